//! Texts and curves of a run for the page that shows its motion.

use crate::report::numbers::seconds;
use crate::report::viewer::film::About;
use crate::report::viewer::model::Curves;
use crate::scene::{Run, Scene};
use crate::study::store::record::CaseRecord;

/// Title, facts, limits and curves of a run.
pub fn about(scene: &Scene, run: &Run, record: &CaseRecord) -> About {
    let law = record.law.as_ref().map(|law| {
        let constants: Vec<String> = law.parameters.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        format!("{} ({}, SI units)", law.name, constants.join(", "))
    });
    let mesh = &record.mesh;
    let facts = [
        ("mesh", Some(format!("{} cells, {} nodes", mesh.cells, mesh.nodes))),
        ("element", Some(record.formulation.clone())),
        ("law", law),
        ("integrator", Some(record.integrator.clone())),
        ("status", Some(record.status.clone())),
        ("work", Some(format!("{} steps in {}", record.steps, seconds(record.wall_s)))),
        ("build", Some(record.provenance.build.words())),
    ];
    let incomplete = record.status_detail.as_ref().map(|why| format!("The run is not complete: {why}"));
    About {
        title: if scene.title.is_empty() { record.id.clone() } else { scene.title.clone() },
        facts: facts.into_iter().filter_map(|(name, value)| Some((name.to_string(), value?))).collect(),
        notes: incomplete.into_iter().collect(),
        curves: Curves { columns: run.columns.clone(), rows: run.rows.clone() },
    }
}
