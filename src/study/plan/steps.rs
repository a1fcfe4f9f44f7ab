//! The time step of a plan: three steps on the coarsest mesh, their error by a power law, and the largest step that will do.
//!
//! ```text
//! e(dt) = |f(dt) − f*|/|f*| (φ)ᵖ for φ dt,   p observed, else that of the integrator,   φ = 2, 1, ½, ¼, …
//! ```
//!
//! The largest φ whose error is within a quarter of the tolerance in every quantity is taken: what is left belongs to the mesh. In
//! statics without history the state does not depend on the step, and the scene keeps its own.

use crate::scene::Scene;
use crate::study::curve::peak;
use crate::study::estimate::family::{Level, estimate_of_order};
use crate::study::estimate::richardson::LEAST_ORDER;
use crate::study::plan::budget::Budget;
use crate::study::plan::error::PlanError;
use crate::study::plan::pilots::{Trial, build, run};
use crate::study::plan::request::{PlanWatch, Request};
use crate::study::plan::sizes::Choice;
use crate::study::store::record::{Role, StoredCase};
use crate::system::ConstraintKind;
use serde::Serialize;
use std::collections::BTreeMap;
use toml::Value;

/// Share of the tolerance that the time step may take.
const SHARE: f64 = 0.25;
/// No step is planned below the scene's by more halvings.
const HALVINGS: i32 = 6;

#[derive(Serialize, Clone, Debug, PartialEq)]
pub struct Steps {
    /// φ, over the steps of the scene
    pub factor: f64,
    /// Changes of the scene that make them
    #[serde(skip)]
    pub changes: Vec<(String, Value)>,
    /// Column → expected error \[–\]
    pub errors: BTreeMap<String, f64>,
    /// CPU time of a step over that of a step of the scene \[–\]
    pub per_step: f64,
    pub cpu_s: f64,
    pub words: String,
}

impl Steps {
    pub fn error(&self, quantity: &str) -> f64 {
        self.errors.get(quantity).copied().unwrap_or(0.0)
    }
}

pub fn steps(
    request: &Request,
    scene: &Scene,
    (choice, cells, coarsest): (&Choice, u64, &StoredCase),
    quantities: &[String],
    budget: &Budget,
    watch: &dyn PlanWatch,
) -> Result<Steps, PlanError> {
    let own = |words: &str| Steps {
        factor: 1.0,
        changes: vec![],
        errors: BTreeMap::new(),
        per_step: 1.0,
        cpu_s: 0.0,
        words: words.into(),
    };
    let remembers = scene.system.effects.iter().any(|e| e.capabilities().history.is_some());
    let linked = scene.system.constraints.iter().any(|c| c.kind() == ConstraintKind::Linked);
    if scene.spans.iter().all(|s| s.integrator.is_static()) && !remembers && !linked {
        return Ok(own("statics without history: the state does not depend on the step, and the scene keeps its own"));
    }
    // Half the steps and twice as many
    if 2.5 * coarsest.record.wall_s > budget.learning_s() {
        return Ok(own(
            "not examined, since the budget has no time for it: the scene keeps its own, whose error is not in the expected one",
        ));
    }
    let mut runs = vec![(1.0, coarsest.clone())];
    let mut cpu_s = 0.0;
    for factor in [2.0, 0.5] {
        let changes = [scaled(scene, factor), choice.changes(cells)].concat();
        let scene = build(request, &changes, budget.learning_s(), watch)?;
        let name = format!("{}, step × {factor}", choice.words(cells));
        let trial = Trial { name, scene: &scene, limit_s: budget.learning_s(), estimated: &[] };
        let Some(case) = run(request, trial, watch)? else { continue };
        cpu_s += case.record.cpu_s;
        if case.record.converged() {
            runs.push((factor, case));
        }
    }
    let formal = if coarsest.record.integrator.starts_with("implicit_euler") { 1.0 } else { 2.0 };
    let mut laws = BTreeMap::new();
    for q in quantities {
        let level = |(factor, c): &(f64, StoredCase)| {
            Some(Level { id: c.record.id.clone(), h: *factor, f: peak(c, q)?, ..Level::default() })
        };
        let levels = runs.iter().filter_map(level).collect();
        let Some(e) = estimate_of_order((q, Role::TimeStep, ""), formal, levels, None, request.tolerance) else {
            continue;
        };
        let at_own = peak(coarsest, q).map_or(0.0, |f| (f - e.extrapolated).abs() / e.extrapolated.abs());
        laws.insert(q.clone(), (at_own, e.observed_order.unwrap_or(formal).clamp(LEAST_ORDER, formal)));
    }
    let error = |law: &(f64, f64), factor: f64| law.0 * factor.powf(law.1);
    let most = if runs.iter().any(|r| r.0 == 2.0) { 1 } else { 0 };
    let factors = (-HALVINGS..=most).rev().map(|k| 2f64.powi(k));
    let enough = |f: &f64| laws.values().all(|law| error(law, *f) <= SHARE * request.tolerance);
    let factor = factors.clone().find(enough).unwrap_or(2f64.powi(-HALVINGS));
    let per_step = |c: &StoredCase| c.record.cpu_s / c.record.steps.max(1) as f64;
    let like = runs.iter().min_by(|a, b| (a.0 / factor).ln().abs().total_cmp(&(b.0 / factor).ln().abs()));
    Ok(Steps {
        factor,
        changes: if factor == 1.0 { vec![] } else { scaled(scene, factor) },
        errors: laws.iter().map(|(q, law)| (q.clone(), error(law, factor))).collect(),
        per_step: like.map_or(1.0, |r| per_step(&r.1) / per_step(coarsest)),
        cpu_s,
        words: format!("{factor} times the steps of the scene, from three steps on {}", choice.words(cells)),
    })
}

/// All stages with their step times a factor.
fn scaled(scene: &Scene, factor: f64) -> Vec<(String, Value)> {
    let one = |(k, s): (usize, &crate::scene::spec::StageSpec)| {
        (format!("stage.{k}.dt"), Value::String(format!("{} s", s.dt.0 * factor)))
    };
    scene.spec.stages.iter().enumerate().map(one).collect()
}
