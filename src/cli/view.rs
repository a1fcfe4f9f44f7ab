//! `durometer view FILE…`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::math::units::{self, Dimension};
use durometer::mesh::format::has_name;
use durometer::mesh::grid_file::read_collection;
use durometer::report;
use durometer::report::viewer::footage::{About, Footage};
use durometer::report::viewer::pack::Packed;
use durometer::report::viewer::shape::{Limits, Shape};
use durometer::report::viewer::{film, of_grid, page};
use durometer::scene::{Body, Import, Scene, read_scene};
use durometer::study::store::results;
use durometer::study::view;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Write a page that shows results, scenes or meshes in three dimensions
///
/// Takes pages of `simulate` (next to each other, with one camera), folders of results, VTU and PVD files, scenes before anything is run (regions, cables, what is held), and meshes. The page opens in a browser from disk and asks for nothing else.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer view my-scene.toml                                 regions, cables and held nodes, at rest
  durometer view coarse/scene.html fine/scene.html             two runs next to each other
  durometer view reports/finger-convergence                    the cases of a study at their peak
  durometer view out/scene.pvd --out scene.html
  durometer view gripper.inp --unit mm

Exit codes: 0 the page is written, 2 a file cannot be shown (the message says why).")]
pub struct Args {
    /// Pages, folders of results, VTU or PVD files, scenes, meshes; several are shown next to each other
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// The page [default: reports/view/<name>.html]
    #[arg(long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Unit of length of meshes (instead of a guess), and of VTU and PVD files (instead of metres)
    #[arg(long)]
    unit: Option<String>,
    /// Change a key of a scene, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

pub fn main(args: Args) -> CommandResult {
    if let Some(out) = args.out.as_ref().filter(|out| out.extension().is_none_or(|end| end != "html")) {
        return Err(format!("{}: a page is written; end its name in .html", out.display()).into());
    }
    let mut cases = vec![];
    for file in &args.files {
        cases.extend(shown(file, &args)?.into_iter().map(|case| (file.as_path(), case)));
    }
    let cases = told_apart(cases);
    let out = args.out.clone().unwrap_or_else(|| default_page(&args.files[0]));
    let title = match &args.files[..] {
        [one] => cases.first().filter(|_| cases.len() == 1).map_or_else(|| name(one), |c| c.title().into()),
        all => all.iter().map(|f| name(f)).collect::<Vec<_>>().join(", "),
    };
    if let Some(folder) = out.parent().filter(|p| !p.as_os_str().is_empty()) {
        files::make_folder(folder)?;
    }
    report::files::write(&out, page::page(&title, &cases).as_bytes())?;
    cases.iter().flat_map(Packed::notes).for_each(|note| tell!("note: {note}"));
    say!("view: {} (open it in a browser)", out.display());
    Ok(Outcome::Complete)
}

/// Appends to equal titles of cases from different files the parts in which the paths of the files differ.
fn told_apart(cases: Vec<(&Path, Packed)>) -> Vec<Packed> {
    let known: Vec<(&Path, String)> = cases.iter().map(|(file, case)| (*file, case.title().to_string())).collect();
    let one = |(file, mut case): (&Path, Packed)| {
        let title = case.title().to_string();
        let alike: Vec<&Path> = known.iter().filter(|(_, other)| *other == title).map(|(file, _)| *file).collect();
        if alike.iter().any(|other| *other != file) {
            case.rename(format!("{title}: {}", own_part(file, &alike)));
        }
        case
    };
    cases.into_iter().map(one).collect()
}

/// Returns a path without the leading and trailing parts that all of these paths share.
fn own_part(path: &Path, all: &[&Path]) -> String {
    let parts =
        |path: &Path| path.components().map(|c| c.as_os_str().to_string_lossy().into_owned()).collect::<Vec<_>>();
    let (own, all): (Vec<String>, Vec<Vec<String>>) = (parts(path), all.iter().map(|path| parts(path)).collect());
    let front = |k: &usize| all.iter().all(|other| other.get(*k) == own.get(*k));
    let from = (0..own.len()).take_while(front).count();
    let back = |k: &usize| all.iter().all(|other| other.iter().rev().nth(*k) == own.iter().rev().nth(*k));
    let end = (0..own.len() - from).take_while(back).count();
    match &own[from..own.len() - end] {
        [] => path.display().to_string(),
        part => part.join("/"),
    }
}

/// Returns the name of a file or folder without its extension; for a `scene` file, the name of its folder.
fn name(file: &Path) -> String {
    let stem = file.file_stem().map_or_else(|| "view".into(), |n| n.to_string_lossy().into_owned());
    let folder = file.parent().and_then(Path::file_name).map(|n| n.to_string_lossy().into_owned());
    if stem == "scene" { folder.unwrap_or(stem) } else { stem }
}

fn default_page(file: &Path) -> PathBuf {
    PathBuf::from("reports/view").join(format!("{}.html", name(file)))
}

/// Returns the cases in a file.
fn shown(file: &Path, args: &Args) -> Result<Vec<Packed>, Box<dyn std::error::Error>> {
    let ending = file.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    if file.is_dir() && file.join("study.json").is_file() {
        return Ok(view::cases(&results::read(file)?));
    }
    match ending.as_str() {
        "html" => Ok(page::read(file)?),
        "vtu" | "pvd" => Ok(vec![grid(file, &ending, args.unit.as_deref())?]),
        "json" | "csv" if file.is_file() => sibling(file),
        _ if file.is_file() && has_name(file) => Ok(vec![mesh(file, args.unit.as_deref())?]),
        _ => Ok(vec![scene(file, &args.set)?]),
    }
}

/// Reads the page that `simulate` has written next to a record or a time series.
fn sibling(file: &Path) -> Result<Vec<Packed>, Box<dyn std::error::Error>> {
    let page = file.with_extension("html");
    if !page.is_file() {
        let remedy = "simulate the scene again, without --no-view";
        return Err(format!(
            "{}: a record has no motion, and {} does not exist; {remedy}",
            file.display(),
            page.display()
        )
        .into());
    }
    Ok(page::read(&page)?)
}

fn grid(file: &Path, ending: &str, unit: Option<&str>) -> Result<Packed, Box<dyn std::error::Error>> {
    let unit_m = match unit {
        None => 1.0,
        Some(unit) => units::parse(&format!("1 {unit}"), Dimension::LENGTH).map_err(|e| format!("--unit: {e}"))?,
    };
    let states = if ending == "pvd" { read_collection(file)? } else { vec![(0.0, file.to_path_buf())] };
    let (footage, notes) = of_grid::footage(&states, unit_m, &Limits::USUAL)?;
    let shape = &footage.shape;
    let facts = vec![
        ("file".to_string(), file.display().to_string()),
        ("faces".into(), (shape.facets.len() / shape.facet_nodes.max(1)).to_string()),
    ];
    Ok(footage.packed(About { title: name(file), facts, notes, ..About::default() }))
}

fn mesh(file: &Path, unit: Option<&str>) -> Result<Packed, Box<dyn std::error::Error>> {
    let mut import = Import::of(file, unit, &mut |line| tell!("{line}"))?;
    let imported = import.load(&mut |line| tell!("{line}"))?;
    let mesh = &imported.body.mesh;
    let facts = vec![
        ("file".to_string(), file.display().to_string()),
        ("format".into(), import.format.name.to_string()),
        ("unit of length".into(), format!("{} ({})", import.unit, import.unit_reason)),
        ("mesh".into(), format!("{} cells, {} nodes", mesh.cell_count(), mesh.points.len())),
    ];
    let mut shape = Shape::of_mesh(mesh, &Limits::USUAL);
    for (name, region) in mesh.regions.iter().filter(|(name, _)| *name != "body") {
        shape.mark(name, "region", |f| region.facets.binary_search(&f).is_ok(), &region.nodes);
    }
    let about = About { title: name(file), facts, notes: imported.body.warnings.clone(), ..About::default() };
    Ok(Footage { shape, times: vec![0.0], ..Footage::default() }.packed(about))
}

fn scene(file: &Path, set: &[String]) -> Result<Packed, Box<dyn std::error::Error>> {
    let path = files::find(file, "scene.toml")?;
    let (spec, text) = read_scene(&path, &super::arguments::changes(set)?)?;
    let body = Arc::new(Body::load(&path, &spec.mesh, &mut |line| tell!("{line}"))?);
    let scene = Scene::build(&path, spec, text, body)?;
    let mesh = &scene.body.mesh;
    let facts = vec![
        ("scene".to_string(), path.display().to_string()),
        ("mesh".into(), format!("{} ({} cells, {} nodes)", scene.body.source, mesh.cell_count(), mesh.points.len())),
        ("unknowns".into(), scene.system.dofs.free.len().to_string()),
    ];
    let title = if scene.title.is_empty() { name(&path) } else { scene.title.clone() };
    let about = About { title, facts, notes: scene.notes.clone(), ..About::default() };
    Ok(film::at_rest(&scene, &Limits::USUAL, about))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_of_one_title_have_the_folders_that_differ() {
        let files = ["reports/soft/simulate/scene.html", "reports/stiff/simulate/scene.html", "reports/other.html"];
        let files = files.map(Path::new);
        let case = |title: &str| Packed { head: serde_json::json!({ "title": title }), data: vec![] };
        let cases = files.into_iter().zip(["arm", "arm", "leg"].map(case)).collect();
        let titles: Vec<String> = told_apart(cases).iter().map(|case| case.title().to_string()).collect();
        assert_eq!(titles, ["arm: soft", "arm: stiff", "leg"]);
        let longer = [Path::new("a/scene.html"), Path::new("a/scene.html/scene.html")];
        assert_eq!(own_part(longer[0], &longer), "a/scene.html");
    }
}
