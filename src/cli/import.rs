//! `durometer import FILE`

use super::outcome::{CommandResult, Outcome};
use durometer::math::tensor::Vec3;
use durometer::math::units::{Decimals, shown};
use durometer::mesh::TetMesh;
use durometer::mesh::format::{has_name, recognise};
use durometer::mesh::quality::Quality;
use durometer::scene::{Fixture, Import, Imported, Scene, SceneSpec, Slab, limits_of_mesh, starter};
use durometer::solve::Status;
use durometer::storage;
use durometer::wording::{self, few};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Describe the content of a mesh, surface or CAD file, and write a starter scene for it
///
/// The format is recognised by the content. A volume mesh is read as a scene would read it; a surface or CAD file is meshed with about 2000 cells, or as few as its shape allows. The starter scene holds the body by a region of the file whose name says so, else at the larger flat end of each component, or its wider end where it has none, and loads it with its weight; its physics is an example that you replace. For a folder every file is imported and its starter scene is run.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer import finger.vtk
  durometer import gripper.inp --unit mm --scene gripper.toml
  durometer import meshes-of-others/                    a table, one row a file

Exit codes: 0 everything can be used, 2 the file cannot (the message says why), 3 some file of the folder cannot, or its run did not complete.")]
pub struct Args {
    /// Mesh, surface or CAD file, or a folder of them
    file: PathBuf,
    /// Unit of length of the file, instead of a guess from the size
    #[arg(long)]
    unit: Option<String>,
    /// Write a starter scene to this file
    #[arg(long, value_name = "OUT.toml")]
    scene: Option<PathBuf>,
}

pub fn main(args: Args) -> CommandResult {
    if args.file.is_dir() {
        if args.scene.is_some() {
            return Err("--scene needs one file, not a folder; name the file".into());
        }
        return folder(&args.file, args.unit.as_deref());
    }
    let mut import = Import::of(&args.file, args.unit.as_deref(), &mut |line| tell!("{line}"))?;
    content(&import);
    let imported = import.load(&mut |line| tell!("{line}"))?;
    mesh(&import, &imported);
    if let Some(out) = &args.scene {
        let text = starter(&import, &imported, out.parent().unwrap_or(Path::new("")));
        storage::write(out, text.as_bytes())
            .map_err(|e| format!("{}: cannot be written: {e}; check the folder and its permissions", out.display()))?;
        say!("scene        {}: replace the values marked EXAMPLE, then: durometer simulate {0}", out.display());
    }
    Ok(Outcome::Complete)
}

/// Coordinate, relative to the size of the body, below which it is printed as zero.
const ROUNDING: f64 = 1e-12;

/// Prints the content of the file, before anything is done to it.
fn content(import: &Import) {
    say!("format       {}", import.format.name);
    let list = |kinds: &std::collections::BTreeMap<&'static str, usize>| {
        kinds.iter().map(|(kind, n)| format!("{n} {kind}")).collect::<Vec<_>>().join(", ")
    };
    if let Some(found) = &import.census {
        say!("nodes        {}", found.nodes);
        say!("cells        {}", if found.cells.is_empty() { "none".into() } else { list(&found.cells) });
        if !found.others.is_empty() {
            say!("elements     {}", list(&found.others));
        }
        let (a, b) = found.bounds;
        // Coordinates at the rounding level of the body are zero
        let least = ROUNDING * (b - a).norm();
        let corner = |p: Vec3| wording::joined(&[p.x, p.y, p.z].map(|x| if x.abs() < least { 0.0 } else { shown(x) }));
        say!("bounds       ({}) to ({}) in units of the file", corner(a), corner(b));
        for (count, what) in [
            (found.unused_nodes, "nodes belong to no cell; they are dropped"),
            (found.doubled_nodes, "nodes are at the place of another one; merge joins them"),
            (found.inverted_cells, "cells are inverted"),
        ] {
            if count > 0 {
                say!("defect       {count} {what}");
            }
        }
    }
    say!("unit         {} ({})", import.unit, import.unit_reason);
    let spec = &import.spec;
    for (needed, key) in [
        (spec.cells.is_some(), format!("cells = {}", spec.cells.unwrap_or(0))),
        (spec.split, "split = true".into()),
        (spec.merge.is_some(), format!("merge = \"{:e} mm\"", spec.merge.map_or(0.0, |m| shown(m.0 * 1e3)))),
    ] {
        if needed {
            say!("needs        {key}");
        }
    }
}

/// Prints the mesh that a scene would get.
fn mesh(import: &Import, imported: &Imported) {
    let mesh = &imported.body.mesh;
    let quality = Quality::of(mesh);
    say!(
        "mesh         {} tetrahedra, {} nodes, {} {}",
        mesh.cell_count(),
        mesh.points.len(),
        imported.components,
        if imported.components == 1 { "component" } else { "components" }
    );
    say!(
        "quality      dihedral angles {:.2} to {:.2} degrees, smallest radius ratio {:.3}",
        quality.dihedral_min_deg,
        quality.dihedral_max_deg,
        quality.radius_ratio_min
    );
    for (name, region) in &mesh.regions {
        say!("region       {name}: {}", extent(mesh, region));
    }
    match &imported.fixture {
        Fixture::Region(name) => say!("fixture      region {name}, by its name"),
        Fixture::Slabs(slabs) => {
            let ends: Vec<String> = slabs.iter().map(Slab::end).collect();
            let of = if slabs.len() > 1 { ", one of each component" } else { "" };
            say!("fixture      {}{of}", few(&ends));
        }
    }
    imported.body.volumes.iter().for_each(|volume| say!("volume       {volume}"));
    imported.body.warnings.iter().for_each(|warning| say!("warning      {warning}"));
    imported.body.notes.iter().for_each(|note| say!("note         {note}"));
    limits_of_mesh(mesh, &import.spec).iter().for_each(|(kind, limit)| say!("{kind:12} {limit}"));
}

/// Describes a region by its counts and sizes.
fn extent(mesh: &TetMesh, region: &durometer::mesh::Region) -> String {
    let mut words = Vec::new();
    if !region.cells.is_empty() {
        words.push(format!(
            "{} cells, {:.4} mm^3",
            region.cells.len(),
            Decimals(mesh.region_volume(&region.cells) * 1e9)
        ));
    }
    if !region.facets.is_empty() {
        words.push(format!(
            "{} facets, {:.4} mm^2",
            region.facets.len(),
            Decimals(mesh.region_area(&region.facets) * 1e6)
        ));
    }
    if !region.nodes.is_empty() {
        words.push(format!("{} nodes", region.nodes.len()));
    }
    words.join("; ")
}

/// Prints a table of all files of a folder.
fn folder(folder: &Path, unit: Option<&str>) -> CommandResult {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(|p| p.is_file()).collect();
    files.sort();
    // Companion files of another mesh file are skipped: nodes of TetGen, data of XDMF
    let with = |p: &Path, end: &str| files.contains(&p.with_extension(end));
    let is_part = |p: &PathBuf| {
        p.extension()
            .is_some_and(|e| (e == "node" && with(p, "ele")) || (e == "h5" && (with(p, "xdmf") || with(p, "xmf"))))
    };
    let (rows, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        files.iter().partition(|p| !is_part(p) && (has_name(p) || recognise(p).is_ok()));
    say!("{:32} {:20} {:>8} {:>5} {:>8} {:22} {:>8}", "file", "format", "cells", "parts", "regions", "run", "time");
    let (mut bad, mut reasons, mut guessed) = (0, Vec::new(), BTreeMap::<String, Vec<String>>::new());
    for file in &rows {
        let start = Instant::now();
        let name = file.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
        let format = recognise(file).map_or("unknown", |f| f.name);
        let tried = Import::of(file, unit, &mut |_| {}).map_err(Into::into).and_then(|import| {
            // CAD files state their unit and have no census
            if unit.is_none() && import.census.is_some() {
                guessed.entry(import.unit.clone()).or_default().push(name.clone());
            }
            tried(file, import)
        });
        match tried {
            Ok((imported, status)) => {
                bad += usize::from(!matches!(status, Status::Converged));
                let mesh = &imported.mesh;
                say!(
                    "{name:32} {format:20} {:>8} {:>5} {:>8} {:22} {:>6.2} s",
                    mesh.cell_count(),
                    imported.components,
                    mesh.regions.len(),
                    status.name(),
                    start.elapsed().as_secs_f64()
                );
            }
            Err(why) => {
                bad += 1;
                say!("{name:32} {format:20} {:>8} {:>5} {:>8} {:22}", "–", "–", "–", "refused");
                reasons.push(why.to_string());
            }
        }
    }
    reasons.iter().for_each(|why| say!("refused: {why}"));
    if guessed.len() > 1 {
        let units: Vec<String> = guessed.iter().map(|(unit, files)| format!("{unit} ({})", few(files))).collect();
        let units = wording::all(&units);
        tell!(
            "note: the guessed units of length differ: {units}; where these files belong together, give their unit with --unit"
        );
    }
    if !others.is_empty() {
        let names: Vec<_> = others.iter().filter_map(|p| p.file_name()).map(|n| n.to_string_lossy()).collect();
        say!("passed over: {}", names.join(", "));
    }
    say!("{} of {} files can be used", rows.len() - bad, rows.len());
    Ok(if bad == 0 { Outcome::Complete } else { Outcome::RunIncomplete })
}

/// The values of a table row for a file that can be used.
struct Row {
    mesh: TetMesh,
    components: usize,
}

/// Imports a file and runs its starter scene.
fn tried(file: &Path, mut import: Import) -> Result<(Row, Status), Box<dyn std::error::Error>> {
    let imported = import.load(&mut |_| {})?;
    let at = file.with_extension("toml");
    let text = starter(&import, &imported, at.parent().unwrap_or(Path::new("")));
    let spec = SceneSpec::from_text(&at, &text, "of the starter scene")?;
    let row = Row { mesh: imported.body.mesh.clone(), components: imported.components };
    let run = Scene::build(&at, spec, text, Arc::new(imported.body))?.run();
    Ok((row, run.status))
}
