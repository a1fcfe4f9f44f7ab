//! The limit of a quantity in the mesh and in the time step, whose errors are kept apart.
//!
//! ```text
//! f* = f_h (1 + s)       f_h: limit over h with the steps of the scene;   s: change by smaller steps on one mesh, whose peak is f_c
//! U(f*)/|f*| = U(f_h)/|f_h| + U(s) + |s/(1 + s)| |1 − f_c/f_h|
//! ```
//!
//! The last term is the difference between carrying the change over to f_h as a share and in the unit of f.
//!
//! f_h ± U(f_h) is the reference of a convergence study, with precautions against values that agree by chance (errors of opposite sign, a
//! curve that crosses its limit): two meshes are no family; U of a family is no less than the largest of |fᵢ − fᵢ₊₁|/(rᵖ − 1) (h₁/hᵢ)ᵖ over its
//! neighbours; and where the interval of a family that is not refused lies apart from the reference, U(f_h) grows as by an independent estimate.

use crate::study::curve::peak;
use crate::study::estimate::family::{Estimate, Level, estimate};
use crate::study::estimate::reference::{self, Reference};
use crate::study::estimate::richardson::{LEAST_ORDER, correction};
use crate::study::locking;
use crate::study::plan::pilots::Pilots;
use crate::study::plan::sizes::Choice;
use crate::study::plan::steps::Steps;
use crate::study::store::record::{Role, StoredCase};
use serde::Serialize;
use std::collections::BTreeMap;

/// Meshes without which an element has no limit: two values agree by chance too easily.
const LEAST_PILOTS: usize = 3;

/// f* with its uncertainty and the parts of it.
#[derive(Serialize, Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// f*; f_h where the error of the steps is not known
    pub value: f64,
    /// U(f*)/|f*| \[–\]
    pub uncertainty: f64,
    /// f_h
    pub at_steps: f64,
    /// U(f_h)/|f_h| \[–\]
    pub of_mesh: f64,
    /// The rest of U(f*)/|f*|, by the time step \[–\]; none where its error is not known
    pub of_steps: Option<f64>,
}

/// Column → limit.
pub type References = BTreeMap<String, Limit>;

/// Column → f_h and U(f_h)/|f_h|.
pub type MeshLimits = BTreeMap<String, (f64, f64)>;

impl Limit {
    /// From the limit over h and what is known about the steps.
    pub fn new((at_steps, of_mesh): (f64, f64), steps: &Steps, quantity: &str) -> Self {
        let (shift, of_steps) = match steps.laws.get(quantity) {
            Some(law) => (law.shift, Some(law.uncertainty + law.transfer(at_steps))),
            None => (0.0, (!steps.matter).then_some(0.0)),
        };
        let uncertainty = of_mesh + of_steps.unwrap_or(0.0);
        Self { value: at_steps * (1.0 + shift), uncertainty, at_steps, of_mesh, of_steps }
    }

    /// The limit against which a run is judged, and whether the run took part in it: as a further mesh, where the size is a choice and its
    /// steps are those of the pilots.
    pub fn for_run(
        self,
        (choices, pilots): (&[Choice], &Pilots),
        (choice, run): (usize, &StoredCase),
        steps: &Steps,
        (quantity, tolerance): (&str, f64),
    ) -> (Self, bool) {
        if steps.factor != 1.0 || choices[choice].sizes.is_empty() || !run.record.converged() {
            return (self, false);
        }
        let mut of = pilots.of.clone();
        of[choice].push(run.clone());
        match of_estimates(&estimates(choices, &of, quantity, tolerance), tolerance) {
            Some(limit) => (Self::new(limit, steps, quantity), true),
            None => (self, false),
        }
    }

    /// |f − f*|/|f*| \[–\].
    pub fn error(&self, value: f64) -> f64 {
        (value / self.value - 1.0).abs()
    }
}

/// f_h of every quantity, from the pilots of each element.
pub fn of_meshes(choices: &[Choice], pilots: &Pilots, quantities: &[String], tolerance: f64) -> MeshLimits {
    let one = |q: &String| Some((q.clone(), of_estimates(&estimates(choices, &pilots.of, q, tolerance), tolerance)?));
    quantities.iter().filter_map(one).collect()
}

/// f_h of every quantity on a given mesh, by the errors estimated from single runs: that of the most certain one. The other formulations
/// check it, unless they lock.
pub fn of_given(pilots: &Pilots, quantities: &[String]) -> MeshLimits {
    let one = |q: &String| {
        let value = |c: &StoredCase| {
            let e = c.record.one_run.as_ref()?.quantities.get(q)?;
            Some((c.record.id.clone(), locking::alarm(&c.record).is_some(), peak(c, q)? + e.correction, e.uncertainty))
        };
        let mut found: Vec<_> = pilots.of.iter().filter_map(|own| value(own.first()?)).collect();
        found.sort_by(|a, b| (a.1, a.3).partial_cmp(&(b.1, b.3)).unwrap_or(std::cmp::Ordering::Equal));
        let (family, _, value, uncertainty) = found.first()?.clone();
        let mut best = Reference {
            value,
            uncertainty,
            scale: value.abs(),
            family,
            method: "from one run".into(),
            envelope: vec![],
            others: vec![],
            disagreement: 0.0,
            independent: None,
        };
        found.iter().skip(1).filter(|f| !f.1).for_each(|(id, _, value, u)| best.check(id, *value, *u));
        (value != 0.0).then(|| (q.clone(), (value, best.uncertainty / value.abs())))
    };
    quantities.iter().filter_map(one).collect()
}

/// Estimate of the limit by each element with three meshes or more.
fn estimates(choices: &[Choice], of: &[Vec<StoredCase>], quantity: &str, tolerance: f64) -> Vec<Estimate> {
    let level = |c: &StoredCase| Some(Level { edge: None, ..Level::of(&c.record, peak(c, quantity)?) });
    let one = |(choice, own): (&Choice, &Vec<StoredCase>)| {
        let levels: Vec<Level> = own.iter().filter_map(level).collect();
        let mut e = estimate((&choice.name, Role::Element, &choice.name), levels, None, tolerance)?;
        e.uncertainty = e.uncertainty.max(largest_of_sequence(&e));
        e.defensible &= e.uncertainty <= tolerance * e.extrapolated.abs();
        (e.values.len() >= LEAST_PILOTS).then_some(e)
    };
    choices.iter().zip(of).filter_map(one).collect()
}

/// The reference among the families as f_h and U(f_h)/|f_h|; none where it is zero.
fn of_estimates(estimates: &[Estimate], tolerance: f64) -> Option<(f64, f64)> {
    let mut best = reference::choose(estimates, tolerance)?;
    let apart = |e: &&Estimate| !e.refused && e.family != best.family && !best.envelope.contains(&e.family);
    let others: Vec<&Estimate> = estimates.iter().filter(apart).collect();
    others.iter().for_each(|e| best.check(&e.family, e.extrapolated, e.uncertainty));
    (best.value != 0.0).then(|| (best.value, best.uncertainty / best.value.abs()))
}

/// The largest error of the finest value by any two neighbours of the sequence, scaled by the order:
/// max |fᵢ − fᵢ₊₁|/(rᵖ − 1) (h₁/hᵢ)ᵖ.
pub fn largest_of_sequence(e: &Estimate) -> f64 {
    let p = e.observed_order.unwrap_or(e.formal_order).clamp(LEAST_ORDER, e.formal_order);
    let of =
        |k: usize| correction((e.values[k] - e.values[k + 1]).abs(), e.ratios[k], p) * (e.h_m[0] / e.h_m[k]).powf(p);
    (0..e.ratios.len()).map(of).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ElementSpec;
    use crate::study::plan::step_law::StepLaw;
    use crate::study::run::one_run::{OneRunError, OneRunRecord};
    use crate::study::store::record::{CaseRecord, Series};

    const Q: &str = "tip_z_m";
    const TOLERANCE: f64 = 0.01;

    /// A run of a mesh with this h and peak.
    fn case(id: &str, h: f64, f: f64) -> StoredCase {
        let mut record = CaseRecord {
            id: id.into(),
            formulation: "tet10".into(),
            status: "Converged".into(),
            ..CaseRecord::default()
        };
        record.mesh.h_m = h;
        let series = Series { t_s: vec![0.0, 1.0], columns: [(Q.to_string(), vec![0.0, f])].into() };
        StoredCase { record, series }
    }

    fn choice(name: &str) -> Choice {
        Choice { name: name.into(), set: vec![], sizes: vec![600, 1320, 2904, 6389], element: ElementSpec::Tet10 }
    }

    /// Elements with the peaks of their meshes, coarse ones first; h falls by 1.3.
    fn pilots(of: &[(&str, &[f64])]) -> (Vec<Choice>, Pilots) {
        let runs = |(name, values): &(&str, &[f64])| {
            let one = |(k, f): (usize, &f64)| case(&format!("{name}-{k}"), 0.012 / 1.3f64.powi(k as i32), *f);
            values.iter().enumerate().map(one).collect()
        };
        let pilots = Pilots { of: of.iter().map(runs).collect(), ..Pilots::default() };
        (of.iter().map(|(name, _)| choice(name)).collect(), pilots)
    }

    fn limit_over_h(of: &[(&str, &[f64])]) -> (f64, f64) {
        let (choices, pilots) = pilots(of);
        of_meshes(&choices, &pilots, &[Q.into()], TOLERANCE)[Q]
    }

    fn steps(factor: f64, values: &[(f64, f64)]) -> Steps {
        let law = StepLaw::new(values, 2.0, TOLERANCE).expect("a limit");
        Steps { factor, laws: [(Q.to_string(), law)].into(), ..Steps::of_scene(true, "") }
    }

    /// The block that swings under its weight, \[mm\]: limit over h with steps of 10 ms, and `tet10` with 600 cells and steps of 20 ms to 1.25 ms.
    /// 2904 cells with steps of 1 ms give 5.034, and their limit lies near 5.06.
    const OVER_H: (f64, f64) = (-4.6855, 0.0019);
    const OVER_DT: [(f64, f64); 5] =
        [(2.0, -4.0544), (1.0, -4.6029), (0.5, -4.8629), (0.25, -4.9454), (0.125, -4.9671)];

    #[test]
    fn a_limit_includes_the_steps_and_what_is_not_known_about_them() {
        let limit = Limit::new(OVER_H, &steps(0.125, &OVER_DT), Q);
        assert_eq!((limit.at_steps, limit.of_mesh), OVER_H);
        assert!((limit.value / -5.06 - 1.0).abs() < limit.uncertainty, "{limit:?}");
        assert!(limit.uncertainty > 0.0019 && limit.uncertainty < 0.01, "{limit:?}");
        assert!((limit.uncertainty - 0.0019 - limit.of_steps.expect("known")).abs() < 1e-12);
        // A run with fine steps is about 1 % off, and not the 7 % that lie between it and the limit for coarse steps
        assert!((limit.error(-5.0118) - 0.01).abs() < 0.003, "{}", limit.error(-5.0118));
        let coarse = Limit::new(OVER_H, &steps(0.5, &OVER_DT[..3]), Q);
        assert!(coarse.uncertainty > 0.1, "three coarse steps do not tell the limit: {coarse:?}");
    }

    #[test]
    fn without_a_law_the_limit_is_that_of_the_steps_of_the_scene() {
        let unknown = Limit::new(OVER_H, &Steps::of_scene(true, ""), Q);
        assert_eq!((unknown.value, unknown.uncertainty, unknown.of_steps), (OVER_H.0, OVER_H.1, None));
        let none = Limit::new(OVER_H, &Steps::of_scene(false, ""), Q);
        assert_eq!((none.value, none.uncertainty, none.of_steps), (OVER_H.0, OVER_H.1, Some(0.0)));
    }

    #[test]
    fn a_run_with_other_steps_is_no_further_mesh() {
        let (choices, pilots) = pilots(&[("tet10", &[-4.6029, -4.6447, -4.6646])]);
        let mesh = of_meshes(&choices, &pilots, &[Q.into()], TOLERANCE)[Q];
        let run = case("run", 0.012 / 1.3f64.powi(3), -4.98);
        let judged =
            |steps: &Steps| Limit::new(mesh, steps, Q).for_run((&choices, &pilots), (0, &run), steps, (Q, TOLERANCE));
        let other = steps(0.125, &OVER_DT);
        let (limit, further) = judged(&other);
        assert!(!further && limit == Limit::new(mesh, &other, Q), "{limit:?}");
        let (limit, further) = judged(&steps(1.0, &OVER_DT));
        assert!(further && limit.at_steps != mesh.0, "{limit:?}");
        // On a given mesh there is no sequence that it could take part in
        let given = [Choice { sizes: vec![], ..choice("tet10") }];
        let same = Limit::new(mesh, &Steps::of_scene(false, ""), Q);
        let kept = same.for_run((&given, &pilots), (0, &run), &Steps::of_scene(false, ""), (Q, TOLERANCE));
        assert_eq!(kept, (same, false));
    }

    #[test]
    fn two_meshes_that_agree_by_chance_do_not_know_the_limit() {
        let sound: &[f64] = &[0.94, 0.9645, 0.979];
        let alone = limit_over_h(&[("tet10", sound)]);
        let both = limit_over_h(&[("tet10", sound), ("tet10_up", &[0.95, 0.950001])]);
        assert_eq!(both, alone);
        assert!(both.1 > 0.01, "{both:?}");
    }

    /// 0.95 with a small uncertainty of its own, and 1.0 ± 2 %: one of the two is wrong.
    #[test]
    fn an_element_that_finds_another_limit_widens_the_interval() {
        let certain: &[f64] = &[0.9472, 0.94834, 0.94902];
        let other: &[f64] = &[0.94, 0.9645, 0.979];
        let (alone, both) =
            (limit_over_h(&[("tet10_up", certain)]), limit_over_h(&[("tet10_up", certain), ("tet10", other)]));
        assert!(alone.1 < 0.005, "{alone:?}");
        assert_eq!(both.0, alone.0);
        assert!(both.0 * (1.0 + both.1) > 0.999, "{both:?}");
    }

    #[test]
    fn the_sequence_bounds_the_uncertainty_from_below() {
        let (h, f) = ([1.0, 2.0, 4.0, 8.0], [1.0, 1.01, 1.05, 1.8]);
        let levels = h.iter().zip(f).map(|(h, f)| Level { h: *h, f, ..Level::default() }).collect();
        let e = estimate(("tet10", Role::Element, "tet10"), levels, None, TOLERANCE).expect("four meshes");
        let p = e.observed_order.expect("monotone");
        assert!((p - 2.0).abs() < 1e-12, "{p}");
        // The pair 4, 8 of the sequence: 0.75/(2² − 1) (1/4)²
        assert!((largest_of_sequence(&e) - 0.25 / 16.0).abs() < 1e-12, "{}", largest_of_sequence(&e));
    }

    #[test]
    fn formulations_on_a_given_mesh_check_each_other() {
        let run = |id: &str, f: f64, correction: f64, uncertainty: f64| {
            let mut case = case(id, 0.01, f);
            let error = OneRunError { correction, geometry: None, uncertainty, bar: uncertainty };
            case.record.one_run =
                Some(OneRunRecord { quantities: [(Q.to_string(), error)].into(), ..OneRunRecord::default() });
            vec![case]
        };
        // The corrections of the first cancel: it claims 1e-5
        let pilots = Pilots { of: vec![run("a", 1.0, 0.0, 1e-5), run("b", 0.98, 0.06, 0.02)], ..Pilots::default() };
        let (value, uncertainty) = of_given(&pilots, &[Q.into()])[Q];
        assert_eq!(value, 1.0);
        assert!(uncertainty > 0.039, "{uncertainty}");
        let alike = Pilots { of: vec![run("a", 1.0, 0.0, 0.01), run("b", 0.98, 0.03, 0.02)], ..Pilots::default() };
        assert_eq!(of_given(&alike, &[Q.into()])[Q], (1.0, 0.01));
    }
}
