//! Laws, effects and recorders from Rust, which no file holds: a part of a scene and of its identity.

use super::builder::LawSource;
use crate::material::Want;
use crate::scene::record::recorder::Recorder;
use crate::storage::sha256;
use crate::system::{At, BlockValues, Effect, HistoryVariables, State};
use std::collections::BTreeMap;

/// Additions that a file cannot hold: laws, effects and recorders from Rust.
#[derive(Default)]
pub(in crate::scene) struct Additions {
    pub(in crate::scene) laws: BTreeMap<String, LawSource>,
    pub(in crate::scene) effects: Vec<Box<dyn Effect>>,
    pub(in crate::scene) recorders: Vec<Box<dyn Recorder>>,
    /// Whether the scene is a variant of one that has said where its laws are stable, which takes many evaluations
    pub(super) is_variant: bool,
}

/// Number of intervals of the protocol at whose ends the intensity of an effect is sampled.
const TIMES: usize = 16;

impl Additions {
    /// All additions as text, for the identity of a scene; empty without additions. The protocol ends at `end` \[s\]; `size` is that of the mesh \[m\].
    pub(in crate::scene) fn identity(&self, size: f64, end: f64) -> String {
        let law = |(name, make): (&String, &LawSource)| {
            let law = make();
            format!("\nlaw {name} {:?}", (law.info().name, law.values(), law.choices()))
        };
        let laws = self.laws.iter().map(law);
        let effects = self.effects.iter().map(|effect| format!("\neffect {}", of_effect(&**effect, size, end)));
        let recorders = self.recorders.iter().map(|r| format!("\nrecorder {:?}", (r.columns(), r.memory())));
        laws.chain(effects).chain(recorders).collect()
    }
}

/// An effect as text: its name, role in the energy balance and blocks, and a digest of its values at a state away from rest, which depend on its constants.
fn of_effect(effect: &dyn Effect, size: f64, end: f64) -> String {
    let (blocks, can) = (effect.blocks(), effect.capabilities());
    let dofs = (0..blocks.len()).flat_map(|b| blocks.dofs(b)).max().map_or(0, |dof| dof as usize + 1);
    // Displacements of up to half a thousandth of the size, different for neighbours
    let x: Vec<f64> = (0..dofs).map(|k| 1e-3 * size * ((37 * k % 101) as f64 / 101.0 - 0.5)).collect();
    let zero = vec![0.0; dofs];
    let history = vec![0.0; can.history_size() * blocks.len()];
    let state = State { t: 0.5 * end, v: x.clone(), a: x.clone(), x, history, ..State::rest(0, 0) };
    let at = At { dt: 1.0, old: &zero, ..state.at() };
    let mut numbers: Vec<f64> = (0..=TIMES).map(|k| effect.intensity((end * k as f64 / TIMES as f64).into())).collect();
    for b in 0..blocks.len() {
        let mut out = BlockValues::new(blocks.size(b));
        // An effect that is not defined there has no values
        if effect.eval(&at, b, Want::Residual, &mut out).is_ok() {
            numbers.extend([out.energy, out.dissipated].iter().chain(&out.r));
        }
        let mut new = vec![0.0; can.history_size()];
        if can.history.is_some_and(|history: &dyn HistoryVariables| history.advance(&at, b, &mut new).is_ok()) {
            numbers.extend(new);
        }
    }
    let numbers: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    let means = can.means.map(|means| means.lists());
    format!("{:?} {}", (effect.name(), effect.role(), blocks, means), sha256(numbers))
}
