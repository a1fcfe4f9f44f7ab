//! A law that is defined outside of the library: checked, used in a scene, differentiated and fitted like those of the library.

use crate::common;
use durometer::calibrate::{Experiment, FitOptions};
use durometer::calibrate::{FittableLaw, Mode, Sample, fit_experiment};
use durometer::material::check::check_property;
use durometer::material::isochoric::{self, InvariantEnergy, Parametric, Partials};
use durometer::material::principal::{invariants, of_invariants, tau};
use durometer::material::split::{Isochoric, IsochoricPart, Split, fitted_parameters, law_parameters, required};
use durometer::material::volumetric::CHOICES;
use durometer::material::{
    Chosen, FitForm, FitTerms, LaneResponse, LawEntry, LawError, LawInfo, LawProperty, LawSpecError, Parameter,
    Response, ShapedTerm, Values, Volumetric, Want, check_law, derivative, law_from_table, moduli, register,
};
use durometer::math::lanes::Lanes;
use durometer::math::tensor::Mat3;
use durometer::math::units::Dimension;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::solve::Status;

/// Demiray's law of soft tissue, ψ = (μ/2b)(e^{b(Ī₁ − 3)} − 1) + U(J) (Demiray, J. Biomech. 5, 1972).
#[derive(Clone, Copy, Debug)]
struct Demiray {
    mu: f64,
    b: f64,
    /// Factor of the stress that makes the law wrong where it is not 1
    flaw: f64,
}

const KEYS: &[Parameter] = &[
    moduli::NU,
    moduli::KAPPA,
    Parameter::new("mu", "μ", Dimension::PRESSURE, Parameter::POSITIVE, "shear modulus at F = I"),
    Parameter::new("b", "b", Dimension::NONE, Parameter::POSITIVE, "rate of the exponential"),
];

static INFO: LawInfo = LawInfo {
    name: "demiray",
    title: "Demiray",
    formula: "ψ = (μ/2b)(e^{b(Ī₁ − 3)} − 1) + U(J)",
    source: "Demiray 1972",
    limits: "J > 0",
    parameters: law_parameters(KEYS),
    optional: 0,
    choices: CHOICES,
    survives_inversion: false,
    objective: true,
    isochoric: true,
};

const FIT: FitForm = FitForm {
    formula: "P = μ g e^{b(I₁ − 3)}",
    source: "Demiray 1972",
    parameters: fitted_parameters(KEYS),
    term_counts: &[1],
    default_count: 1,
    compressible: false,
    terms: FitTerms::Separable(ShapedTerm {
        tau: |b, s| of_invariants(&Demiray { mu: 1.0, b, flaw: 1.0 }, s).tau,
        tau_by_shape: |b, s| {
            let i = invariants(s).0;
            tau(0.5 * i * (b * i).exp(), 0.0, s)
        },
        shape: |x, _| (x.exp(), x.exp()),
        grid: &[-6.0, -4.0, -2.0, 0.0, 2.0, 4.0],
        factor: |_| (1.0, 0.0),
    }),
};

impl Isochoric for Demiray {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, _: &Chosen) -> Result<Self, LawSpecError> {
        Ok(Self { mu: required(&INFO, values, "mu")?, b: required(&INFO, values, "b")?, flaw: 1.0 })
    }

    fn values(&self) -> Vec<f64> {
        vec![self.mu, self.b]
    }

    fn shear(&self) -> f64 {
        self.mu
    }
}

impl InvariantEnergy for Demiray {
    const SECOND: bool = false;

    fn partials(&self, i: f64, _: f64) -> Result<Partials, LawError> {
        let (y, mu) = (self.b * i, self.mu);
        // The exponential leaves the range of numbers
        if y > 600.0 {
            return Err(LawError::Locked { i, limit: 600.0 / self.b });
        }
        let w1 = 0.5 * mu * y.exp();
        Ok(Partials { w: 0.5 * mu / self.b * y.exp_m1(), w1: self.flaw * w1, w11: self.b * w1, ..Partials::default() })
    }
}

impl Parametric for Demiray {
    fn partials_along(&self, rates: &[f64], i: f64, k: f64) -> Result<Partials, LawError> {
        let (p, y) = (self.partials(i, k)?, self.b * i);
        let (by_mu, db) = (rates[0] / self.mu, rates[1]);
        Ok(Partials {
            w: by_mu * p.w + db * 0.5 * self.mu / (self.b * self.b) * (y * y.exp() - y.exp_m1()),
            w1: by_mu * p.w1 + db * i * p.w1,
            w11: by_mu * p.w11 + db * (1.0 + y) * p.w1,
            ..Partials::default()
        })
    }
}

const ENTRY: LawEntry = Split::<Demiray>::entry(KEYS, &[200e3, 30e3, 0.8]).with_fit(FIT);

/// Demiray's law with a stress that is 0.01 % off.
#[derive(Clone, Copy, Debug)]
struct Flawed(Demiray);

impl IsochoricPart for Flawed {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError> {
        <Demiray as Isochoric>::read(values, chosen).map(|d| Self(Demiray { flaw: 1.0 + 1e-4, ..d }))
    }

    fn values(&self) -> Vec<f64> {
        Isochoric::values(&self.0)
    }

    fn shear(&self) -> f64 {
        self.0.mu
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.0.response(u, f, want)
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.0.response_along(rates, u, f, want)
    }
}

#[test]
fn it_is_checked() {
    check_law(&ENTRY).unwrap_or_else(|e| panic!("{e}"));
    let flawed: LawEntry = Split::<Flawed>::entry(KEYS, &[200e3, 30e3, 0.8]);
    let violation = check_law(&flawed).expect_err("the stress is wrong");
    assert_eq!((violation.law, violation.property), ("demiray", LawProperty::Stress));
    assert!(violation.to_string().contains("differences of the energy give"), "{violation}");
}

/// Demiray's law with one of five mistakes.
#[derive(Clone, Copy, Debug)]
struct Mistaken<const MISTAKE: usize>(Demiray);

/// The energy is the rest of a large sum
const CANCELS: usize = 0;
/// F that is inverted has an energy of zero
const ACCEPTS: usize = 1;
/// F that is inverted is refused for another reason
const REFUSES: usize = 2;
/// The tangent is 0.1 % too stiff
const STIFF: usize = 3;
/// An entry of the tangents of several gradients is not a number
const BLANK: usize = 4;

impl<const MISTAKE: usize> IsochoricPart for Mistaken<MISTAKE> {
    const INFO: &'static LawInfo = &INFO;

    fn read(values: &Values, chosen: &Chosen) -> Result<Self, LawSpecError> {
        <Demiray as Isochoric>::read(values, chosen).map(Self)
    }

    fn values(&self) -> Vec<f64> {
        Isochoric::values(&self.0)
    }

    fn shear(&self) -> f64 {
        self.0.mu
    }

    fn response(&self, u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let is_inverted = f.determinant() <= 0.0;
        match MISTAKE {
            ACCEPTS if is_inverted => return Ok(Response { psi: 0.0, p: Mat3::zeros(), a: [[0.0; 9]; 9] }),
            REFUSES if is_inverted => return Err(LawError::Undefined),
            _ => {}
        }
        let mut found = self.0.response(u, f, want)?;
        match MISTAKE {
            CANCELS => found.psi = (found.psi + 1e6 * self.0.mu) - 1e6 * self.0.mu,
            STIFF => found.a.as_flattened_mut().iter_mut().for_each(|a| *a *= 1.001),
            _ => {}
        }
        Ok(found)
    }

    fn lanes(
        &self,
        u: &Volumetric,
        f: &[Lanes; 9],
        want: Want,
        out: &mut LaneResponse,
    ) -> Result<(), (usize, LawError)> {
        isochoric::lanes(&self.0, u, f, want, out)?;
        if MISTAKE == BLANK {
            out.a[4][2].0[1] = f64::NAN;
        }
        Ok(())
    }

    fn response_along(&self, rates: &[f64], u: &Volumetric, f: &Mat3, want: Want) -> Result<Response, LawError> {
        self.0.response_along(rates, u, f, want)
    }
}

/// A law that fails is told by which property, with its constants and the state where they count, and one remedy: that of the property, not one for a run.
#[test]
fn a_failure_names_constants_state_and_one_remedy() {
    const SAMPLE: &[f64] = &[200e3, 30e3, 0.8];
    let told = |entry: LawEntry, property: LawProperty| {
        let said = check_property(&entry, property).expect_err("a mistake").to_string();
        assert!(said.matches("; ").count() == 1, "{said}");
        said
    };
    let said = told(Split::<Mistaken<CANCELS>>::entry(KEYS, SAMPLE), LawProperty::SmallStrain);
    assert!(said.starts_with("law `demiray` fails the check SmallStrain: with kappa = "), "{said}");
    assert!([" Pa, mu = ", " Pa, b = ", " at F − I = [["].iter().all(|words| said.contains(words)), "{said}");
    assert!(said.ends_with("; compute the energy without cancellation near F = I, as by Invariants"), "{said}");

    let said = told(Split::<Mistaken<STIFF>>::entry(KEYS, SAMPLE), LawProperty::RepeatedStretches);
    assert!(said.starts_with("law `demiray` fails the check RepeatedStretches: with kappa = "), "{said}");
    assert!(said.contains(" at the stretches [0.9, 0.9, 1.2]: A["), "{said}");
    assert!(said.ends_with("; let the tangent be ∂P/∂F where principal stretches coincide, too"), "{said}");

    let said = told(Split::<Mistaken<BLANK>>::entry(KEYS, SAMPLE), LawProperty::Lanes);
    assert!(said.contains("lane 1 differs from the evaluation of one gradient; "), "{said}");

    let inverted = |entry: LawEntry, fact: &str| {
        let said = told(entry, LawProperty::Inversion);
        let remedy = "let the law declare whether it survives inversion, J ≤ 0";
        assert_eq!(said, format!("law `demiray` fails the check Inversion: {fact}; {remedy}"));
    };
    let zero = "F = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]";
    let accepts = format!("it accepts {zero} but does not declare it");
    inverted(Split::<Mistaken<ACCEPTS>>::entry(KEYS, SAMPLE), &accepts);
    let refuses = "at J ≤ 0: the law is not defined at this deformation, take a smaller step or load";
    inverted(Split::<Mistaken<REFUSES>>::entry(KEYS, SAMPLE), refuses);
}

/// One test, because a name is registered once per process.
#[test]
fn it_is_registered_run_differentiated_and_fitted() {
    let table = ENTRY.example_table();
    let unknown = law_from_table(&table).expect_err("not registered yet").to_string();
    assert!(unknown.contains("no law `demiray`"), "{unknown}");
    register(ENTRY).unwrap_or_else(|e| panic!("{e}"));
    let taken = register(ENTRY).expect_err("the name is taken").to_string();
    assert!(taken.contains("already a law `demiray`"), "{taken}");
    assert!(law_from_table(&table).is_ok() && derivative(&table, "b").is_ok());

    let text = r#"
[mesh]
body = "block"
[laws.tissue]
law = "demiray"
mu = "30 kPa"
b = 0.8
nu = 0.4
volumetric = "quadratic"
[[effect]]
kind = "elastic"
region = "body"
law = "tissue"
[[effect]]
kind = "gravity"
region = "body"
density = "1000 kg/m^3"
direction = [0, 0, -1]
acceleration = { kind = "ramp", from = "0 m/s^2", to = "30 m/s^2", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
"#;
    let run = common::run(&common::scene(block(6, 2, 2, 0.06, 0.02, 0.02, Order::Linear), text));
    assert_eq!(run.status, Status::Converged);

    // A fit of exact data gives the constants
    let model = FittableLaw::new("demiray", None).expect("it can be fitted");
    let truth = [30e3, 0.8];
    let samples = (1..=20).map(|k| {
        let stretch = 1.0 + 0.05 * f64::from(k);
        let stress = model.stress(&truth, Mode::Uniaxial, stretch);
        Sample { mode: Mode::Uniaxial, second: 1.0, stretch, stress, line: k as u64 + 1, specimen: 0 }
    });
    let experiment = Experiment::of_samples("own.csv", "", samples.collect());
    let result = fit_experiment(&experiment, &FitOptions::new("demiray")).unwrap_or_else(|e| panic!("{e}"));
    for (estimate, truth) in result.parameters.iter().zip(truth) {
        assert!((estimate.value / truth - 1.0).abs() < 1e-6, "{}: {} is not {truth}", estimate.name, estimate.value);
    }
}
