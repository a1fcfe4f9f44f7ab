//! `durometer mesh FILE`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::mesh::generate::MeshStore;
use durometer::mesh::quality::Quality;
use durometer::scene::{Body, Scene, keep, limits_of_mesh, limits_of_scene, read_scene};
use durometer::study::case::Case;
use durometer::study::expand::Study;
use std::path::PathBuf;
use std::sync::Arc;

/// Make (or find) the meshes of a scene or study and report their quality
///
/// A mesh is found by the hash of its body, size and options; the mesher is only called if it is not stored.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer mesh finger-convergence                     every mesh of the study
  durometer mesh studies/finger-dynamics/scene.toml --set mesh.cells=9300
  durometer mesh my-scene.toml --set 'mesh.parameters.length=\"80 mm\"' --keep")]
pub struct Args {
    /// Scene or study file (TOML), or the name of a study
    file: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Keep the meshes in the folder of their body (meshes/<body>/), to be committed, instead of in meshes/cache
    #[arg(long)]
    keep: bool,
}

pub fn main(args: Args) -> CommandResult {
    let file = files::find_any(&args.file)?;
    let changes = super::arguments::changes(&args.set)?;
    let scenes = if files::is_study(&file) {
        let study = Study::read(&file, &changes)?;
        let scenes = study.cases.iter().map(Case::scenes).collect::<Result<Vec<_>, _>>()?.into_iter().flatten();
        scenes.map(|(file, spec, text)| (file.to_path_buf(), spec.into_owned(), text.to_string())).collect()
    } else {
        let (spec, text) = read_scene(&file, &changes)?;
        vec![(file.clone(), spec, text)]
    };
    let mut seen = Vec::new();
    for (file, scene, text) in scenes {
        let spec = &scene.mesh;
        let key = format!("{spec:?}");
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        if args.keep {
            keep(&file, spec, &MeshStore::find()?, &mut |line| tell!("{line}"))?;
        }
        let body = Arc::new(Body::load(&file, spec, &mut |line| tell!("{line}"))?);
        let (mesh, quality) = (&body.mesh, Quality::of(&body.mesh));
        say!(
            "{:28} {:>7} cells {:>6} nodes  h {:.3} mm  radius ratio min {:.3} mean {:.3}  dihedral {:.1}–{:.1}°",
            body.source,
            mesh.cell_count(),
            mesh.points.len(),
            mesh.h() * 1e3,
            quality.radius_ratio_min,
            quality.radius_ratio_mean,
            quality.dihedral_min_deg,
            quality.dihedral_max_deg
        );
        let when = if body.undeformed.is_some() { ", before [mesh.deform]" } else { "" };
        body.volumes.iter().for_each(|volume| say!("volume       {volume}{when}"));
        body.warnings.iter().for_each(|warning| say!("warning      {warning}"));
        // A valid scene says which nodes are held
        let built = Scene::build(&file, scene.clone(), text, body.clone());
        let limits = built.map_or_else(|_| limits_of_mesh(mesh, spec), |scene| limits_of_scene(&scene));
        limits.iter().for_each(|(kind, limit)| say!("{kind:12} {limit}"));
    }
    Ok(Outcome::Complete)
}
