//! Cases for the page that shows them in three dimensions: a single run with its motion, and the stored cases of a study.

use crate::report::numbers::seconds;
use crate::report::viewer::footage::{About, FieldHistory, Footage, hollow};
use crate::report::viewer::limits::BYTES;
use crate::report::viewer::model::Curves;
use crate::report::viewer::pack::{Packed, pack};
use crate::report::viewer::shape::{PartKind, Shape};
use crate::report::viewer::unpack::unpack;
use crate::scene::{Run, Scene};
use crate::study::store::record::{CaseRecord, StoredCase};
use crate::study::store::results::Results;
use crate::study::store::skin::Skin;

/// Title, facts, limits and curves of a run.
pub fn about(scene: &Scene, run: &Run, record: &CaseRecord) -> About {
    let about = about_case(run, record);
    About { title: if scene.title.is_empty() { about.title } else { scene.title.clone() }, ..about }
}

/// Title, facts, limits and curves of a run, with the id of the case as title, since all cases of a study may have the same title.
pub fn about_case(run: &Run, record: &CaseRecord) -> About {
    About { curves: Curves { columns: run.columns.clone(), rows: run.rows.clone() }, ..facts(record) }
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
        ..About::default()
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

/// A case on the page of a study: its motion, or the state farthest from rest.
struct Shown<'a> {
    case: &'a StoredCase,
    skin: Option<&'a Skin>,
    packed: Packed,
    moves: bool,
    has_inside: bool,
}

impl<'a> Shown<'a> {
    fn of(results: &'a Results, case: &'a StoredCase) -> Option<Self> {
        let id = &case.record.id;
        let skin = results.skins.get(id);
        let (packed, moves) = match (results.motions.get(id), skin) {
            (Some(motion), _) => (motion.clone(), true),
            (None, Some(skin)) => (at_peak(case, skin, STILL), false),
            (None, None) => return None,
        };
        let has_inside = moves && packed.has_inside();
        Some(Self { case, skin, packed, moves, has_inside })
    }
}

/// The cases of a study, as far as they fit into one page, with their motion if it is recorded, or at the peaks of their protocols. If they are too
/// large, the largest ones lose first their interior and then their motion; a note says so.
pub fn cases(results: &Results) -> Vec<Packed> {
    let mut all: Vec<Shown> = results.cases.iter().filter_map(|case| Shown::of(results, case)).collect();
    let size = |all: &[Shown]| all.iter().map(|s| s.packed.data.len()).sum::<usize>();
    let largest = |all: &[Shown], can: &dyn Fn(&Shown) -> bool| {
        (0..all.len()).filter(|&k| can(&all[k])).max_by_key(|&k| (all[k].packed.data.len(), all.len() - k))
    };
    while size(&all) > BYTES {
        if let Some(k) = largest(&all, &|s| s.has_inside) {
            all[k].has_inside = false;
            all[k].packed = unpack(&all[k].packed).map_or_else(|| all[k].packed.clone(), |m| pack(&hollow(&m)));
        } else if let Some(k) = largest(&all, &|s| s.moves && s.skin.is_some()) {
            all[k].moves = false;
            let still = all[k].skin.map(|skin| at_peak(all[k].case, skin, TOO_LARGE));
            all[k].packed = still.unwrap_or_else(|| all[k].packed.clone());
        } else {
            break;
        }
    }
    let mut left = BYTES;
    let fits = |s: &Shown| {
        let size = s.packed.data.len();
        let fits = size <= left;
        left -= if fits { size } else { 0 };
        fits
    };
    let (kept, out): (Vec<Shown>, Vec<Shown>) = all.into_iter().partition(fits);
    let mut kept: Vec<Packed> = kept.into_iter().map(|s| s.packed).collect();
    if let (Some(first), false) = (kept.first_mut(), out.is_empty()) {
        let ids: Vec<&str> = out.iter().map(|s| s.case.record.id.as_str()).collect();
        first.add_note(format!("Left out to keep the page small: {}.", ids.join(", ")));
    }
    kept
}

/// Note on why a case does not move.
const STILL: &str = "The results hold only the state farthest from rest. With `[output] fields = { what = [\"displacement\"] }` in the scene, a run of the study \
     records the motion.";
const TOO_LARGE: &str = "The motion is left out to keep the page small; `cases/<id>.view.html` shows it.";

/// A stored case in the state farthest from rest.
fn at_peak(case: &StoredCase, skin: &Skin, why: &str) -> Packed {
    let count = skin.points.len() as u32;
    let numbers: Vec<u32> = (0..skin.triangles.len() as u32).collect();
    let mut shape = Shape {
        points: skin.points.clone(),
        nodes: (0..count).collect(),
        has_own_numbers: true,
        facet_nodes: 3,
        facets: skin.triangles.iter().flatten().copied().collect(),
        facet_cells: numbers.clone(),
        cell_numbers: numbers.clone(),
        facet_numbers: numbers,
        ..Shape::default()
    };
    // Cables and bodies are known in this state only, so that they do not move from it
    let mut motion: Vec<f32> = skin.displacement.iter().flatten().map(|v| *v as f32).collect();
    for (k, cable) in skin.cables.iter().enumerate() {
        shape.add_part(&format!("cable {}", k + 1), PartKind::Cable, cable, vec![]);
    }
    for (k, rigid) in skin.rigids.iter().enumerate() {
        shape.add_part(&format!("rigid body {}", k + 1), PartKind::Rigid, &rigid.points, rigid.triangles.clone());
    }
    motion.resize(3 * shape.points.len(), 0.0);
    let stretch = skin.stretch.iter().map(|v| *v as f32).collect();
    let stretch = FieldHistory {
        name: "stretch".into(),
        unit: String::new(),
        components: 1,
        at_nodes: true,
        states: vec![stretch],
    };
    let series = &case.series;
    let row = |k: usize| std::iter::once(series.t_s[k]).chain(series.columns.values().map(|c| c[k])).collect();
    let columns = std::iter::once("t_s".to_string()).chain(series.columns.keys().cloned()).collect();
    let mut about = facts(&case.record);
    about.curves = Curves { columns, rows: (0..series.t_s.len()).map(row).collect() };
    about.still = why.replace("<id>", &case.record.id);
    Footage { shape, times: vec![skin.t_s], motion: vec![motion], quantities: vec![stretch], arrows: vec![] }
        .packed(about)
}
