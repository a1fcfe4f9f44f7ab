//! The choice among settings: the cheapest whose expected error is within the tolerance, once its own mesh confirms its time.

use crate::study::plan::budget::Budget;
use crate::study::plan::error::PlanError;
use crate::study::plan::limit::References;
use crate::study::plan::pilots::{Pilots, build, count};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::settings::Setting;
use crate::study::plan::sizes::ElementMeshes;
use crate::study::plan::steps::Steps;
use crate::study::plan::weigh::Expectation;

/// Largest number of meshes that are made to confirm a setting.
const MESHES: usize = 3;
/// Share of the remaining time, less that of the run itself, that the mesh of a setting may take.
const FOR_MESH: f64 = 0.5;

/// Basis of a choice.
pub struct Known<'a> {
    pub choices: &'a [ElementMeshes],
    pub references: &'a References,
    pub steps: &'a Steps,
    pub budget: &'a Budget,
}

/// Returns the cheapest setting within the tolerance that fits into the remaining budget, or else the most accurate one that fits, and whether it is
/// within the tolerance. Meshes are made only for settings that come first; they are then counted by symbolic factorisation and weighed again. After a
/// signal to stop no mesh is made.
pub fn choose(
    request: &Request,
    known: &Known,
    weighed: &mut Vec<Setting>,
    pilots: &mut Pilots,
    watch: &dyn PlanWatch,
) -> Result<(Option<Setting>, bool), PlanError> {
    let mut made = 0;
    loop {
        let left = known.budget.left_s();
        let fits = |s: &&Setting| s.wall_s <= left && (s.on_its_mesh || made < MESHES);
        let enough = weighed.iter().filter(fits).find(|s| s.error <= request.tolerance);
        let best = weighed.iter().filter(fits).min_by(|a, b| a.error.total_cmp(&b.error));
        let Some(setting) = enough.or(best).cloned() else { return Ok((None, false)) };
        let meets = enough.is_some();
        if setting.on_its_mesh || request.is_stopped() {
            return Ok((Some(setting), meets));
        }
        made += 1;
        let place = weighed.iter().position(|s| s.set == setting.set).expect("it is one of them");
        let choice = &known.choices[setting.choice];
        let changes = [known.steps.changes.clone(), choice.changes(setting.cells)].concat();
        let limit = FOR_MESH * (left - setting.wall_s);
        match build(request, &changes, limit, watch) {
            Ok(scene) => {
                let expectation =
                    Expectation::new(&pilots.of[setting.choice], known.references).expect("weighed by it");
                let counted = count(&scene);
                let (error, limited_by, cpu_s) = expectation.of(&counted, known.steps);
                let wall_s = cpu_s * pilots.slowness();
                weighed[place] = Setting { counted, on_its_mesh: true, error, limited_by, cpu_s, wall_s, ..setting };
                weighed.sort_by(|a, b| a.cpu_s.total_cmp(&b.cpu_s));
            }
            Err(PlanError::Stopped) => return Ok((Some(setting), meets)),
            Err(e @ (PlanError::Scene(_) | PlanError::MeshLate { .. })) => {
                pilots.lost.push((setting.words(), e.to_string()));
                weighed.remove(place);
            }
            Err(e) => return Err(e),
        }
    }
}
