//! Mistakes in scenes, which are reported for all cases before the first one runs.

use super::task::Task;
use crate::scene::{Body, Scene, mistakes_before_meshing};
use crate::study::case::Case;
use crate::study::expand::Study;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Largest mesh on which a case is checked before the first one runs \[cells\].
const CHECKED_CELLS: usize = 20_000;
/// Largest number of scenes that are checked on a mesh before the first case runs; each takes up to a few tenths of a second.
const CHECKED_SCENES: usize = 64;

/// The mistakes in cases that can be found without a mesh; empty if a refusal is a result.
pub(super) fn before_meshing(study: &Study, cases: &[&Case]) -> Vec<String> {
    if study.rules.keep_refusals {
        return vec![];
    }
    let mistakes = |c: &&Case| -> Vec<String> {
        mistakes_before_meshing(&c.scene_file, &c.spec).into_iter().map(|why| of_case(c, &why)).collect()
    };
    let ready = cases.iter().filter(|c| c.after.is_none() && c.plan.is_none());
    ready.flat_map(mistakes).collect()
}

/// The smallest mesh of each scene among the cases to run. Scenes that differ only in their meshes usually have the same mistakes.
#[derive(Default)]
pub(super) struct SmallestMeshes {
    /// Scene without its mesh → (number of nodes, index of the case)
    of: BTreeMap<String, (usize, usize)>,
}

impl SmallestMeshes {
    /// Adds a case with its index and mesh.
    pub fn add(&mut self, index: usize, task: &Task, body: &Body) {
        if task.keep_refusals || task.case.plan.is_some() || body.mesh.cell_count() > CHECKED_CELLS {
            return;
        }
        let own = (body.mesh.points.len(), index);
        let smallest = self.of.entry(scene_but_for_mesh(&task.case.text)).or_insert(own);
        *smallest = own.min(*smallest);
    }

    /// The mistakes in cases on these meshes, in the order of the cases.
    pub fn mistakes<'a>(self, task: impl Fn(usize) -> &'a Task) -> Vec<String> {
        let mut cases: Vec<usize> = self.of.into_values().map(|(_, index)| index).collect();
        cases.sort_unstable();
        cases.into_iter().take(CHECKED_SCENES).filter_map(|k| mistake_on_mesh(task(k))).collect()
    }
}

/// The text of a scene without its mesh, but with its named regions.
fn scene_but_for_mesh(text: &str) -> String {
    let mut scene: toml::Table = toml::from_str(text).unwrap_or_default();
    let regions = scene.remove("mesh").and_then(|mut mesh| mesh.as_table_mut()?.remove("regions"));
    scene.extend(regions.map(|regions| ("regions".into(), regions)));
    toml::to_string(&scene).unwrap_or_default()
}

/// The reason why a case would be refused on its mesh, which exists. A panic is left to the run of the case, where it becomes the status.
fn mistake_on_mesh(task: &Task) -> Option<String> {
    let case = &task.case;
    let body = Body::load(&case.scene_file, &case.spec.mesh, &mut |_| ()).ok()?;
    let checked = || match Scene::build(&case.scene_file, case.spec.clone(), case.text.clone(), body.into()) {
        Ok(scene) => task.check(&scene).map_err(|why| of_case(case, &why)),
        Err(why) => Err(of_case(case, &why)),
    };
    catch_unwind(AssertUnwindSafe(checked)).ok()?.err()
}

fn of_case(c: &Case, why: &dyn Display) -> String {
    format!("case {} (family {}, variant {}, member {}): {why}", c.id, c.family, c.variant, c.member)
}
