//! Cases for the page that shows them in three dimensions: a run with its motion, and the stored cases of a study at their peak.

use crate::report::numbers::seconds;
use crate::report::viewer::footage::{About, Footage, Quantity};
use crate::report::viewer::model::Curves;
use crate::report::viewer::pack::Packed;
use crate::report::viewer::shape::{PartKind, Shape};
use crate::scene::{Run, Scene};
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::skin::Skin;

/// Most bytes of the packed cases of a study.
const BYTES: usize = 3_500_000;

/// Title, facts, limits and curves of a run.
pub fn about(scene: &Scene, run: &Run, record: &CaseRecord) -> About {
    About {
        title: if scene.title.is_empty() { record.id.clone() } else { scene.title.clone() },
        curves: Curves { columns: run.columns.clone(), rows: run.rows.clone() },
        ..facts(record)
    }
}

/// Title, facts and limits of a run before its first step.
pub fn about_before(scene: &Scene, name: &str) -> About {
    let mesh = &scene.body.mesh;
    let facts = [
        ("mesh", format!("{} ({} cells, {} nodes)", scene.body.source, mesh.cell_count(), mesh.points.len())),
        ("unknowns", scene.system.dofs.free.len().to_string()),
        ("integrator", scene.spans.first().map_or_else(String::new, |span| span.integrator.name().into())),
    ];
    About {
        title: if scene.title.is_empty() { name.into() } else { scene.title.clone() },
        facts: facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect(),
        notes: scene.notes.clone(),
        curves: Curves { columns: scene.columns(), rows: vec![] },
        absent: vec![],
    }
}

fn facts(record: &CaseRecord) -> About {
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
        title: record.id.clone(),
        facts: facts.into_iter().filter_map(|(name, value)| Some((name.to_string(), value?))).collect(),
        notes: incomplete.into_iter().collect(),
        ..About::default()
    }
}

/// The cases of a study at the peaks of their protocols, as far as they fit into one page.
pub fn cases(results: &Results) -> Vec<Packed> {
    let mut out: Vec<Packed> = vec![];
    let mut left = BYTES;
    for case in &results.cases {
        let Some(skin) = results.skins.get(&case.record.id) else { continue };
        let packed = at_peak(case, skin);
        if packed.data.len() <= left {
            left -= packed.data.len();
            out.push(packed);
        }
    }
    out
}

/// A stored case at the state farthest from rest.
fn at_peak(case: &StoredCase, skin: &Skin) -> Packed {
    let count = skin.points.len() as u32;
    let numbers: Vec<u32> = (0..skin.triangles.len() as u32).collect();
    let mut shape = Shape {
        points: skin.points.clone(),
        nodes: (0..count).collect(),
        facet_nodes: 3,
        facets: skin.triangles.iter().flatten().copied().collect(),
        facet_cells: numbers.clone(),
        cell_numbers: numbers.clone(),
        facet_numbers: numbers,
        ..Shape::default()
    };
    // Cables and bodies are known at this state alone, so that they do not move from it
    let mut motion: Vec<f32> = skin.displacement.iter().flatten().map(|v| *v as f32).collect();
    for (k, cable) in skin.cables.iter().enumerate() {
        shape.add_part(&format!("cable {}", k + 1), PartKind::Cable, cable, vec![]);
    }
    for (k, rigid) in skin.rigids.iter().enumerate() {
        shape.add_part(&format!("rigid body {}", k + 1), PartKind::Rigid, &rigid.points, rigid.triangles.clone());
    }
    motion.resize(3 * shape.points.len(), 0.0);
    let stretch = skin.stretch.iter().map(|v| *v as f32).collect();
    let stretch =
        Quantity { name: "stretch".into(), unit: String::new(), components: 1, at_nodes: true, states: vec![stretch] };
    let series = &case.series;
    let row = |k: usize| std::iter::once(series.t_s[k]).chain(series.columns.values().map(|c| c[k])).collect();
    let columns = std::iter::once("t_s".to_string()).chain(series.columns.keys().cloned()).collect();
    let mut about = facts(&case.record);
    about.curves = Curves { columns, rows: (0..series.t_s.len()).map(row).collect() };
    about.notes.push("This is the state farthest from rest; `durometer simulate` shows the whole motion.".into());
    Footage { shape, times: vec![skin.t_s], motion: vec![motion], quantities: vec![stretch], arrows: vec![] }
        .packed(about)
}
