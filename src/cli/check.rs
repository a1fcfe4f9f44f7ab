//! `durometer check FILE`

use super::Outcome;
use durometer::scene::{Body, Scene, read_scene};
use durometer::study::spec::Study;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Validates a scene or study and says what would be simulated: mesh, effects, unknowns, steps. Runs nothing.
#[derive(clap::Args)]
pub struct Args {
    /// Scene or study file (TOML), or the name of a study
    file: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

pub fn main(args: Args) -> Outcome {
    let file = super::find(&args.file, "study.toml");
    let changes = super::changes(&args.set)?;
    if file.file_name().is_some_and(|n| n == "study.toml") {
        let study = Study::read(&file, &changes)?;
        println!("study {}: {} cases", study.name, study.cases.len());
        for case in &study.cases {
            let mesh = &case.spec.mesh;
            let size = mesh.cells.map_or_else(|| "by length".into(), |n| format!("{n} cells"));
            println!("  {:36} {:6} {size}", case.id, mesh.element.name());
        }
        let Some(first) = study.cases.first() else { return Ok(ExitCode::SUCCESS) };
        println!("\nthe first case:");
        return describe(&first.scene_file, first.spec.clone(), first.text.clone());
    }
    let (spec, text) = read_scene(&file, &changes)?;
    describe(&file, spec, text)
}

fn describe(file: &Path, spec: durometer::scene::SceneSpec, text: String) -> Outcome {
    let body = Body::load(file, &spec.mesh, &mut |line| eprintln!("{line}"))?;
    let scene = Scene::build(file, spec, text, body.into())?;
    let mesh = &scene.body.mesh;
    println!("mesh         {} ({} cells, {} nodes)", scene.body.source, mesh.cell_count(), mesh.points.len());
    let regions: Vec<&str> = mesh.regions.keys().map(String::as_str).collect();
    println!("regions      {}", regions.join(", "));
    let law = scene.law.info();
    let values = law.parameters.iter().zip(scene.law.values()).map(|(p, v)| format!("{} = {v}", p.name));
    println!("law          {} ({})", law.name, values.collect::<Vec<_>>().join(", "));
    for effect in &scene.system.effects {
        println!("effect       {} ({} blocks)", effect.name(), effect.blocks().len());
    }
    for constraint in &scene.system.constraints {
        println!("constraint   {} (exact row with multiplier)", constraint.name());
    }
    println!("prescribed   {} degrees of freedom", scene.system.prescribed.len());
    println!("unknowns     {}, {} entries in the tangent", scene.system.dofs.free.len(), scene.system.pattern.nnz());
    for span in &scene.spans {
        let steps = ((span.end - span.start) / span.dt).ceil();
        println!("stage        {} from {} s to {} s: {steps} steps", span.integrator.name(), span.start, span.end);
    }
    println!("records      {}", scene.columns().join(", "));
    println!("nothing else is assembled");
    scene.remarks.iter().for_each(|remark| println!("note         {remark}"));
    Ok(ExitCode::SUCCESS)
}
