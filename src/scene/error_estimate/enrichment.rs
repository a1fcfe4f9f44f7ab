//! The scene of a run on an enriched mesh.

use super::EstimateError;
use super::kept_state::Kept;
use crate::effect::pressure_hosts;
use crate::mesh::enrich::Enriched;
use crate::mesh::{Order, TetMesh};
use crate::scene::body::Body;
use crate::scene::build::SceneBuilder;
use crate::scene::spec::{EffectSpec, ElementSpec};
use crate::scene::{Scene, SceneSpec};
use crate::solve::Status;
use crate::system::State;
use std::sync::Arc;

/// The way in which the space of a run is enriched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Enrichment {
    /// Each cell into eight of the same order
    Split,
    /// Linear cells to quadratic ones
    Raise,
}

/// Least order of a quantity in h, where edges are singular: half that of linear cells on a smooth solution.
const LEAST_ORDER: f64 = 1.0;
/// Largest share of the error of linear cells that quadratic ones on the same mesh leave.
const SHARE_LEFT: f64 = 1.0 / 3.0;

impl Enrichment {
    /// The enrichment that estimates errors of cells of this order best.
    pub fn usual(order: Order) -> Self {
        match order {
            Order::Linear => Self::Raise,
            Order::Quadratic => Self::Split,
        }
    }

    /// Bounds of the factor from the change of a quantity to its error.
    pub fn factors(self, order: Order) -> [f64; 2] {
        let formal = match order {
            Order::Linear => 2.0,
            Order::Quadratic => 4.0,
        };
        let split = |q: f64| 1.0 / (1.0 - (-q).exp2());
        match self {
            Self::Split => [split(formal), split(LEAST_ORDER)],
            Self::Raise => [1.0 / (1.0 + SHARE_LEFT), 1.0 / (1.0 - SHARE_LEFT)],
        }
    }
}

/// The scene with quadratic cells, with a pressure field in addition where it `mixed` can have one: displacements alone may still lock.
fn raised(spec: &SceneSpec, mixed: bool) -> SceneSpec {
    let mut spec = spec.clone();
    spec.mesh.element = ElementSpec::Tet10;
    for effect in spec.effects.iter_mut().filter(|_| mixed) {
        if let EffectSpec::Elastic(elastic) = effect {
            elastic.take_pressure_field();
        }
    }
    spec
}

/// The scene on the enriched mesh, and the map of states to it.
pub(super) struct EnrichedScene {
    pub scene: Scene,
    map: Enriched,
}

impl EnrichedScene {
    pub fn new(scene: &Scene, enrichment: Enrichment) -> Result<Self, EstimateError> {
        let map = match enrichment {
            Enrichment::Split => Enriched::by_splitting(&scene.body.mesh),
            Enrichment::Raise => Enriched::by_raising(&scene.body.mesh),
        };
        let Body { paths, source, sha256, .. } = &*scene.body;
        let body =
            Body { mesh: map.mesh.clone(), paths: paths.clone(), source: source.clone(), sha256: sha256.clone() };
        let body = Arc::new(body);
        let build = |spec: SceneSpec| SceneBuilder::new(spec).file(&scene.file).body(body.clone()).build();
        let fine = match enrichment {
            Enrichment::Split => build(scene.spec.clone())?,
            Enrichment::Raise => build(raised(&scene.spec, true)).or_else(|_| build(raised(&scene.spec, false)))?,
        };
        let same = [
            ("effects", fine.system.effects.len() == scene.system.effects.len()),
            ("constraints", fine.system.constraints.len() == scene.system.constraints.len()),
            ("columns", fine.columns() == scene.columns()),
        ];
        match same.iter().find(|(_, same)| !same) {
            Some((what, _)) => Err(EstimateError::Additions { why: format!("its {what} differ") }),
            None => Ok(Self { scene: fine, map }),
        }
    }

    /// The columns at time `t` by the protocol from its start, and the factorisations for them.
    pub fn run_until(&mut self, t: f64) -> Result<(Vec<f64>, usize), EstimateError> {
        let mut spans = self.scene.spans.clone();
        spans.retain(|span| span.start < t);
        spans.iter_mut().for_each(|span| span.end = span.end.min(t));
        let whole = std::mem::replace(&mut self.scene.spans, spans);
        let run = self.scene.run();
        self.scene.spans = whole;
        match (run.status, run.rows.last()) {
            (Status::Converged, Some(row)) => Ok((row.clone(), run.factorisations)),
            (status, _) => Err(EstimateError::NotSolved { t, status: status.name() }),
        }
    }

    /// A state of the run in the enriched space: the same displacements and pressures as functions, with prescribed values as they are
    /// on the enriched mesh.
    pub fn prolong(&self, from: &Scene, kept: &Kept) -> State {
        let Self { scene, map } = self;
        let displacements = 3 * from.points.len();
        let of_mesh = 3 * from.body.mesh.points.len();
        let mut x = map.prolong(3, &kept.x[..of_mesh]);
        x.extend_from_slice(&kept.x[of_mesh..displacements]);
        x.extend(self.pressures(&from.spec, &from.body.mesh, &kept.x[displacements..]));
        let rest = scene.system.rest();
        let (lambda, inputs) = (kept.lambda.clone(), kept.inputs.clone());
        let mut state = State { t: kept.t, x, lambda, inputs, ..rest };
        for p in &scene.system.prescribed {
            state.x[p.dof as usize] = p.signal.at(state.clock());
        }
        state
    }

    /// Pressures of the mixed effects, which are linear between corners; zero where the run has none. The unknown is p ℓ/μ with the mean
    /// cell size ℓ.
    fn pressures(&self, spec: &SceneSpec, mesh: &TetMesh, values: &[f64]) -> Vec<f64> {
        let fine = &self.scene.body.mesh;
        let scale = fine.h() / mesh.h();
        let (mut out, mut first) = (Vec::new(), 0);
        for (before, now) in spec.effects.iter().zip(&self.scene.spec.effects) {
            let (EffectSpec::Elastic(before), EffectSpec::Elastic(now)) = (before, now) else { continue };
            if !now.formulation.is_mixed() {
                continue;
            }
            let hosts = |mesh: &TetMesh| pressure_hosts(mesh, &mesh.regions[&now.region].cells);
            if !before.formulation.is_mixed() {
                out.extend(hosts(fine).iter().map(|_| 0.0));
                continue;
            }
            let own = hosts(mesh);
            let at = |node: &u32| values[first + own.binary_search(node).expect("a corner between corners")];
            let value = |node: &u32| -> f64 { self.map.corner_weights[node].iter().map(|(k, w)| w * at(k)).sum() };
            out.extend(hosts(fine).iter().map(|node| scale * value(node)));
            first += own.len();
        }
        out
    }
}
