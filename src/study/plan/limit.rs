//! The limit of a quantity in the mesh and in the time step, whose errors are treated separately.
//!
//! ```text
//! f* = f_h (1 + s)       f_h: limit over h with the steps of the scene;   s: change by smaller steps on one mesh, whose peak is f_c
//! U(f*)/|f*| = U(f_h)/|f_h| + U(s) + |s/(1 + s)| |1 − f_c/f_h|
//! ```
//!
//! The last term is the difference between applying the change to f_h as a ratio and in the unit of f.
//!
//! The module `mesh_limits` determines f_h ± U(f_h).

use crate::study::plan::mesh_limits::{estimates, of_estimates};
use crate::study::plan::pilots::Pilots;
use crate::study::plan::sizes::ElementMeshes;
use crate::study::plan::steps::Steps;
use crate::study::store::record::StoredCase;
use serde::Serialize;
use std::collections::BTreeMap;

/// The limit f* with its uncertainty and the contributions to it.
#[derive(Serialize, Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// f*, or f_h if the error of the steps is unknown
    pub value: f64,
    /// U(f*)/|f*| \[–\]
    pub uncertainty: f64,
    /// f_h
    pub at_steps: f64,
    /// U(f_h)/|f_h| \[–\]
    pub of_mesh: f64,
    /// The rest of U(f*)/|f*|, from the time step \[–\]; `None` if its error is unknown
    pub of_steps: Option<f64>,
}

/// Column → limit.
pub type References = BTreeMap<String, Limit>;

impl Limit {
    /// Builds the limit from that over h and the knowledge about the steps.
    pub fn new((at_steps, of_mesh): (f64, f64), steps: &Steps, quantity: &str) -> Self {
        let (shift, of_steps) = match steps.laws.get(quantity) {
            Some(law) => (law.shift, Some(law.uncertainty + law.transfer(at_steps))),
            None => (0.0, (!steps.matter).then_some(0.0)),
        };
        let uncertainty = of_mesh + of_steps.unwrap_or(0.0);
        Self { value: at_steps * (1.0 + shift), uncertainty, at_steps, of_mesh, of_steps }
    }

    /// The limit against which a run is judged, and whether the run took part in it: as a further mesh, if the size is a choice and its steps are those
    /// of the pilots.
    pub fn for_run(
        self,
        (choices, pilots): (&[ElementMeshes], &Pilots),
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

    /// Relative error |f − f*|/|f*| \[–\].
    pub fn error(&self, value: f64) -> f64 {
        (value / self.value - 1.0).abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ElementSpec;
    use crate::study::plan::mesh_limits::{MeshLimits, contradiction, of_given, of_meshes};
    use crate::study::plan::step_law::StepLaw;
    use crate::study::run::one_run::{OneRunError, OneRunRecord};
    use crate::study::store::record::{CaseRecord, Series};

    const Q: &str = "tip_z_m";
    const TOLERANCE: f64 = 0.01;

    /// Returns a run on a mesh with this h and peak.
    fn case(id: &str, h: f64, f: f64) -> StoredCase {
        let mut record = CaseRecord {
            id: id.into(),
            formulation: "tet10".into(),
            status: "Converged".into(),
            ..CaseRecord::default()
        };
        record.mesh.h_m = h;
        let series = Series { t_s: vec![0.0, 1.0], columns: [(Q.to_string(), vec![0.0, f])].into() };
        StoredCase::new(record, series)
    }

    fn choice(name: &str) -> ElementMeshes {
        ElementMeshes {
            name: name.into(),
            sizes: vec![600, 1320, 2904, 6389],
            element: ElementSpec::Tet10,
            ..ElementMeshes::default()
        }
    }

    /// Returns elements with the peaks on their meshes, coarsest first; h decreases by a factor of 1.3.
    fn pilots(of: &[(&str, &[f64])]) -> (Vec<ElementMeshes>, Pilots) {
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

    /// Limit over h of a block that swings under its weight, with steps of 10 ms \[mm\]. A mesh of 2904 cells with steps of 1 ms gives 5.034, and its
    /// limit is about 5.06.
    const LIMIT_OVER_H: f64 = -4.6855;
    /// Relative uncertainty of that limit \[–\].
    const UNCERTAINTY_OVER_H: f64 = 0.0019;
    /// The same block with 600 cells of `tet10`: steps of 20 ms to 1.25 ms as multiples of 10 ms, each with its peak \[mm\].
    const OVER_DT: [(f64, f64); 5] =
        [(2.0, -4.0544), (1.0, -4.6029), (0.5, -4.8629), (0.25, -4.9454), (0.125, -4.9671)];

    #[test]
    fn a_limit_includes_the_steps_and_what_is_not_known_about_them() {
        let limit = Limit::new((LIMIT_OVER_H, UNCERTAINTY_OVER_H), &steps(0.125, &OVER_DT), Q);
        assert_eq!((limit.at_steps, limit.of_mesh), (LIMIT_OVER_H, UNCERTAINTY_OVER_H));
        assert!((limit.value / -5.06 - 1.0).abs() < limit.uncertainty, "{limit:?}");
        assert!(limit.uncertainty > 0.0019 && limit.uncertainty < 0.01, "{limit:?}");
        assert!((limit.uncertainty - 0.0019 - limit.of_steps.expect("known")).abs() < 1e-12);
        // A run with fine steps is about 1 % off, not the 7 % between it and the limit for coarse steps
        assert!((limit.error(-5.0118) - 0.01).abs() < 0.003, "{}", limit.error(-5.0118));
        let coarse = Limit::new((LIMIT_OVER_H, UNCERTAINTY_OVER_H), &steps(0.5, &OVER_DT[..3]), Q);
        assert!(coarse.uncertainty > 0.1, "three coarse steps do not tell the limit: {coarse:?}");
    }

    #[test]
    fn without_a_law_the_limit_is_that_of_the_steps_of_the_scene() {
        let unknown = Limit::new((LIMIT_OVER_H, UNCERTAINTY_OVER_H), &Steps::of_scene(true, ""), Q);
        assert_eq!((unknown.value, unknown.uncertainty, unknown.of_steps), (LIMIT_OVER_H, UNCERTAINTY_OVER_H, None));
        let none = Limit::new((LIMIT_OVER_H, UNCERTAINTY_OVER_H), &Steps::of_scene(false, ""), Q);
        assert_eq!((none.value, none.uncertainty, none.of_steps), (LIMIT_OVER_H, UNCERTAINTY_OVER_H, Some(0.0)));
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
        // On a given mesh there is no sequence in which it could take part
        let given = [ElementMeshes { sizes: vec![], ..choice("tet10") }];
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

    /// Values of 7.50 and 7.52 on meshes whose h differs by 1.3 may be 2.7 % off at first order in h, but not 9.6 %.
    #[test]
    fn two_meshes_that_agree_contradict_a_limit_that_is_not_known() {
        let element = |peaks: &[f64], known: f64| {
            let (choices, pilots) = pilots(&[("tet4_up", &[5.9, 6.7, 7.0]), ("tet10_up", peaks)]);
            let limits = MeshLimits::from([(Q.to_string(), (8.24, known))]);
            contradiction(&choices, &pilots, &limits, TOLERANCE).map(|found| found.formulation)
        };
        assert_eq!(element(&[7.50, 7.52], 0.18).as_deref(), Some("tet10_up"));
        assert_eq!(element(&[7.50, 7.52], 0.005), None, "a limit that is known");
        assert_eq!(element(&[5.0, 6.5], 0.18), None, "two that are far apart");
        assert_eq!(element(&[8.20, 8.22], 0.18), None, "two that are near the limit");
        assert_eq!(element(&[7.48, 7.50, 7.52], 0.18), None, "three have a limit of their own");
    }

    /// A limit of 0.95 with a small uncertainty of its own and one of 1.0 ± 2 %: one of the two is wrong.
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
    fn formulations_on_a_given_mesh_check_each_other() {
        let run = |id: &str, f: f64, correction: f64, uncertainty: f64| {
            let mut case = case(id, 0.01, f);
            let error = OneRunError { correction, uncertainty, bar: uncertainty, ..OneRunError::default() };
            case.record.one_run =
                Some(OneRunRecord { quantities: [(Q.to_string(), error)].into(), ..OneRunRecord::default() });
            vec![case]
        };
        // The corrections of the first cancel: it claims an uncertainty of 1e-5
        let pilots = Pilots { of: vec![run("a", 1.0, 0.0, 1e-5), run("b", 0.98, 0.06, 0.02)], ..Pilots::default() };
        let (value, uncertainty) = of_given(&pilots, &[Q.into()])[Q];
        assert_eq!(value, 1.0);
        assert!(uncertainty > 0.039, "{uncertainty}");
        let alike = Pilots { of: vec![run("a", 1.0, 0.0, 0.01), run("b", 0.98, 0.03, 0.02)], ..Pilots::default() };
        assert_eq!(of_given(&alike, &[Q.into()])[Q], (1.0, 0.01));
    }
}
