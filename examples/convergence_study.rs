//! Runs a small convergence study into a temporary folder and reads its verdict.
//!
//! A block is stretched on four grids; the study estimates the order of convergence and the error of each grid, and
//! says which of them meets the tolerance. Run with `cargo run --release --example convergence_study`.

use durometer::prelude::*;
use std::sync::atomic::AtomicBool;

const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[constraint]]
kind = "fixed"
region = "xmin"

[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }

[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"

[[probe]]
kind = "energy"
"#;

const STUDY: &str = r#"
kind = "convergence"
question = "Which grid gives the energy of a stretched block within 5 %?"
expectation = "The error falls with the size of the cells; the coarsest grid is too stiff."
scene = "scene.toml"
tolerance = "5 %"

[[variant]]
name = "stretched"
label = "stretched"
quantity = [{ name = "elastic_J", label = "elastic energy", symbol = "W", unit = "J" }]

[[family]]
name = "grids"
role = "sizes"
[family.members]
coarse = {}
medium = { "mesh.grid.divisions" = [8, 4, 4] }
fine = { "mesh.grid.divisions" = [12, 6, 6] }
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    std::fs::write(folder.path().join("scene.toml"), SCENE)?;
    let file = folder.path().join("study.toml");
    std::fs::write(&file, STUDY)?;

    let study = Study::read(&file, &[])?;
    let results = folder.path().join("results");
    let stop = AtomicBool::new(false);
    let options = StudyOptions { jobs: 2, ..StudyOptions::new(&stop) };
    let records = run_study(&study, &results, &options, &())?;
    assert!(records.len() == 3 && records.iter().all(|record| record.converged()));

    // Writes the page, the figures and the tables, and returns the content of summary.json.
    let summary = write_report(&results)?;
    println!("{}", summary.verdict);
    for case in &summary.cases {
        println!("{:20} {:6} cells", case.id, case.mesh.cells);
    }
    let settings = summary.analysis["settings"].as_array().expect("a list of settings");
    assert!(!settings.is_empty());
    assert!(!summary.verdict.is_empty());
    assert!(results.join("summary.json").is_file() && results.join("index.html").is_file());
    Ok(())
}
