//! Errors of the measurement that all data points share: their part in the intervals, and the compliance of the machine.

use crate::common::made::{models, table, truth};
use durometer::calibrate::{
    Accuracy, ColumnChoice, ErrorModel, Experiment, FitError, FitOptions, FitResult, FittableLaw, Mode, Sample,
    SlackChoice, fit_experiment,
};

const LENGTH: f64 = 0.033;
const AREA: f64 = 18e-6;

/// Data points with a small pattern, so that the fit is no rounding.
fn pull(model: FittableLaw, values: &[f64], mode: Mode) -> Vec<Sample> {
    let one = |k: u64| {
        let stretch = 1.05 + 0.9 * k as f64 / 39.0;
        let stress = model.stress(values, mode, stretch) * (1.0 + 1e-5 * (5.0 * k as f64).sin());
        Sample { mode, stretch, stress, line: k + 2, specimen: 0, second: 1.0 }
    };
    (0..40).map(one).collect()
}

fn options(model: FittableLaw, mode: Mode, accuracy: &[&str]) -> FitOptions {
    let mut o = FitOptions::new(model.name());
    (o.terms, o.modes, o.slack, o.ranges) = (Some(model.terms), vec![mode], SlackChoice::No, 0);
    o.accuracy =
        accuracy.iter().fold(Accuracy::default(), |all, text| text.parse::<Accuracy>().expect("valid").or(&all));
    o
}

fn fitted(samples: Vec<Sample>, options: &FitOptions) -> FitResult {
    let mut e = table(samples);
    let own = &mut e.pieces[0].dimensions;
    (own.gauge_length, own.area) = (Some(LENGTH), Some(AREA));
    fit_experiment(&e, options).expect("fitted")
}

/// What a stated error does to the constants equals the change of the answer when the data have it: ± h, central differences.
#[test]
fn a_contribution_is_the_change_of_the_answer() {
    type Change = fn(&Sample, f64) -> Sample;
    let changes: [(&str, &str, Change); 6] = [
        ("stress_zero", "Pa", |s, by| Sample { stress: s.stress + by, ..*s }),
        ("force_zero", "N", |s, by| Sample { stress: s.stress + by / AREA, ..*s }),
        ("stress_scale", "", |s, by| Sample { stress: s.stress * (1.0 + by), ..*s }),
        ("strain_zero", "", |s, by| Sample { stretch: s.stretch + by, ..*s }),
        ("strain_scale", "", |s, by| Sample { stretch: 1.0 + (s.stretch - 1.0) * (1.0 + by), ..*s }),
        ("compliance", " m/N", |s, by| Sample { stretch: s.stretch - by * s.stress * AREA / LENGTH, ..*s }),
    ];
    let sizes = [1.0, 2e-5, 1e-5, 1e-6, 1e-5, 1e-8];
    // Two terms of Ogden are hardly determined by these data
    let most = |m: &FittableLaw| if m.name() == "ogden" { 1 } else { 2 };
    for model in models()
        .into_iter()
        .filter(|m| ["neo_hookean", "yeoh", "gent", "ogden"].contains(&m.name()) && m.terms <= most(m))
    {
        let samples = pull(model, &truth(model.name(), model.terms), Mode::Uniaxial);
        for ((key, unit, change), size) in changes.iter().zip(sizes) {
            let stated = format!("{key}={size}{unit}");
            let r = fitted(samples.clone(), &options(model, Mode::Uniaxial, &[&stated]));
            let plain = options(model, Mode::Uniaxial, &[]);
            let ends = [size, -size].map(|h| fitted(samples.iter().map(|s| change(s, h)).collect(), &plain));
            for (k, by) in r.measurement[0].moves.iter().enumerate() {
                let real = 0.5 * (ends[0].parameters[k].value - ends[1].parameters[k].value).abs();
                // The second derivative of the sum of squares, which is left out, is of the size of the misfit, 1e-5, times the conditioning
                assert!(
                    (by - real).abs() < 5e-3 * real + 1e-9 * r.parameters[k].value.abs(),
                    "{} {key} {k}: {by} {real}",
                    model.label()
                );
            }
        }
    }
}

/// Half-widths are added in quadrature, and stated in every output.
#[test]
fn stated_errors_widen_the_interval() {
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
    let samples = pull(model, &[0.1e6], Mode::Uniaxial);
    let plain = fitted(samples.clone(), &options(model, Mode::Uniaxial, &[]));
    let wide = fitted(samples, &options(model, Mode::Uniaxial, &["stress_scale=2%", "strain_scale=1%"]));
    let half = |r: &FitResult| 0.5 * (r.parameters[0].interval[1] - r.parameters[0].interval[0]);
    assert_eq!(wide.measurement.len(), 2);
    // A scale of the stress is one of the modulus
    let value = wide.parameters[0].value;
    assert!((wide.measurement[0].moves[0] - 0.02 * value).abs() < 1e-9 * value);
    let sum = wide.measurement.iter().map(|c| c.moves[0].powi(2)).sum::<f64>() + half(&plain).powi(2);
    assert!((half(&wide) - sum.sqrt()).abs() < 1e-9 * half(&wide));
    assert_eq!(wide.parameters[0].value, plain.parameters[0].value);
    let said = wide.to_string();
    assert!(said.contains("of which the scale of the stress: μ ± 2.0 kPa"), "{said}");
    assert!(
        wide.interval_assumption.contains("with the stated errors of the scale of the stress, the scale of the strain")
    );
    assert!(wide.law_text().contains("scale of the stress ± 2e-2 –"));
}

/// The zeros of several specimens are in their scatter; the common scale is not.
#[test]
fn zeros_of_specimens_count_once() {
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
    let mut samples = vec![];
    for specimen in 0..3 {
        let values = [0.1e6 * (1.0 + 0.02 * (specimen as f64 - 1.0))];
        samples.extend(pull(model, &values, Mode::Uniaxial).into_iter().map(|s| Sample { specimen, ..s }));
    }
    let mut e = table(samples);
    e.specimens = (0..3).map(|k| format!("{k}.csv")).collect();
    let stated = ["stress_zero=1kPa", "strain_zero=1%", "stress_scale=1%"];
    let r = fit_experiment(&e, &options(model, Mode::Uniaxial, &stated)).expect("fitted");
    assert_eq!(r.measurement.iter().map(|c| c.error.name()).collect::<Vec<_>>(), ["scale of the stress"]);
}

/// Three uniaxial specimens and one in equibiaxial tension: the zero of that one is in no scatter, and its own alone is added.
#[test]
fn the_zero_of_a_single_specimen_of_a_mode_counts() {
    let model = FittableLaw::new("mooney_rivlin", None).expect("registered");
    let of = |specimen: usize, mode: Mode, factor: f64| {
        let values = [0.04e6 * factor, 0.02e6 * factor];
        pull(model, &values, mode).into_iter().map(move |s| Sample { specimen, ..s })
    };
    let pulls = (0..3).flat_map(|k| of(k, Mode::Uniaxial, 1.0 + 0.02 * (k as f64 - 1.0)));
    let samples: Vec<Sample> = pulls.chain(of(3, Mode::Equibiaxial, 1.0)).collect();
    let fit = |accuracy: &[&str], samples: &[Sample]| {
        let mut e = table(samples.to_vec());
        e.specimens = (0..4).map(|k| format!("{k}.csv")).collect();
        let mut o = options(model, Mode::Uniaxial, accuracy);
        o.modes = vec![Mode::Uniaxial, Mode::Equibiaxial];
        fit_experiment(&e, &o).expect("fitted")
    };
    let stated = fit(&["stress_zero=1 Pa"], &samples);
    assert!(matches!(stated.errors, ErrorModel::Levels { .. }), "{:?}", stated.errors);
    let ends = [1.0, -1.0].map(|h| {
        let of_one = |s: &Sample| Sample { stress: s.stress + if s.specimen == 3 { h } else { 0.0 }, ..*s };
        fit(&[], &samples.iter().map(of_one).collect::<Vec<_>>())
    });
    for (k, by) in stated.measurement[0].moves.iter().enumerate() {
        let real = 0.5 * (ends[0].parameters[k].value - ends[1].parameters[k].value).abs();
        // The second derivative that is left out has the size of the misfit, 2 %
        assert!((by - real).abs() < 0.05 * real, "{k}: {by} {real}");
    }
}

/// Travel of a crosshead with a compliant machine gives the constants of the piece, of a force and of a true stress, also where the machine takes more than
/// half of the travel.
#[test]
fn the_compliance_of_the_machine_is_taken_out() {
    let model = FittableLaw::new("yeoh", Some(2)).expect("registered");
    let values = [0.3e6, -2e3];
    for compliance in [2e-4, 2e-3] {
        compliance_is_taken_out(model, &values, compliance);
    }
}

fn compliance_is_taken_out(model: FittableLaw, values: &[f64; 2], compliance: f64) {
    let mut texts = ["displacement [mm];force [N]\n".to_string(), "displacement [mm];true stress [Pa]\n".to_string()];
    for k in 1..40 {
        let stretch = 1.0 + 0.02 * f64::from(k);
        let stress = model.stress(values, Mode::Uniaxial, stretch);
        let force = stress * AREA;
        let travel = 1e3 * ((stretch - 1.0) * LENGTH + compliance * force);
        texts[0] += &format!("{travel:.17};{force:.17}\n");
        texts[1] += &format!("{travel:.17};{:.17}\n", stress * stretch);
    }
    let stated = format!("{} mm/N", 1e3 * compliance);
    let mut choice = ColumnChoice::default();
    for (key, text) in [("gauge_length", "33 mm"), ("area", "18 mm^2"), ("compliance", &stated)] {
        choice.dimensions.set(key, text).expect("valid");
    }
    // Where CσA/L is a quarter of the square of the measured stretch, it has one solution, which no passes reach
    let limit = 0.25 * (1.0_f64 + 1.0 / 33.0).powi(2) * LENGTH / (compliance * AREA);
    texts[1] += &format!("1;{limit:.17}\n");
    for text in texts {
        let read =
            |choice: &ColumnChoice| Experiment::parse("a.csv", text.as_bytes(), None, choice, Some(Mode::Uniaxial));
        let e = read(&choice).expect("valid");
        assert!(
            e.audit
                .0
                .iter()
                .any(|a| a.message.contains(&format!("compliance of the machine, {:.6} mm/N", 1e3 * compliance))),
            "{:?}",
            e.audit
        );
        let unsettled =
            e.audit.0.iter().filter(|a| a.message.contains("compliance of the machine is not found")).count();
        assert_eq!(unsettled, usize::from(text.contains("true")), "{:?}", e.audit);
        let r = fit_experiment(&e, &options(model, Mode::Uniaxial, &[])).expect("fitted");
        for (p, v) in r.parameters.iter().zip(values) {
            assert!((p.value / v - 1.0).abs() < 1e-8, "{}: {} {v}", p.name, p.value);
        }
        let on_the_piece = ColumnChoice { strain_measurement: Some("extensometer".into()), ..choice.clone() };
        assert!(matches!(read(&on_the_piece), Err(FitError::Compliance { .. })));
        let mut blunt = choice.clone();
        (blunt.dimensions.area, blunt.dimensions.width) = (None, None);
        if text.contains("true") {
            assert!(read(&blunt).expect_err("no section").to_string().contains("--area"));
        }
    }
}

#[test]
fn a_stated_error_that_makes_no_sense_is_refused() {
    for (text, fact) in [
        ("stress_zero", "write KEY=VALUE"),
        ("tare=1kPa", "there is no such error; known: stress_zero, force_zero"),
        ("stress_zero=1 mm", "--accuracy stress_zero"),
        ("stress_scale=-1%", "above zero"),
        ("stress_scale=0", "above zero"),
        ("stress_scale=nan", "--accuracy stress_scale"),
    ] {
        let message = text.parse::<Accuracy>().expect_err(text).to_string();
        assert!(message.contains(fact), "{text}: {message}");
    }
    let model = FittableLaw::new("neo_hookean", None).expect("registered");
    let e = table(pull(model, &[0.1e6], Mode::Uniaxial));
    for (text, fact) in [("force_zero=1N", "--area"), ("compliance=1 mm/N", "--area")] {
        let message = fit_experiment(&e, &options(model, Mode::Uniaxial, &[text])).expect_err(text).to_string();
        assert!(message.contains(fact), "{text}: {message}");
    }
}

/// Two test pieces of different sections, of which one has a stated scale: an error of the force is one of each section, the scale one of its piece, in whatever order the tables are given.
#[test]
fn each_test_piece_has_its_own_errors() {
    let model = FittableLaw::new("mooney_rivlin", None).expect("registered");
    let (uniaxial, planar) = (AREA, 100e-6);
    let of = |mode: Mode, area: f64, accuracy: &str| {
        let mut e = table(pull(model, &[0.04e6, 0.02e6], mode));
        e.pieces[0].dimensions.area = Some(area);
        e.pieces[0].accuracy = accuracy.parse().expect("valid");
        e
    };
    let pieces = || [of(Mode::Uniaxial, uniaxial, "stress_zero=1 Pa"), of(Mode::Planar, planar, "stress_scale=0.1%")];
    let mut asked = options(model, Mode::Uniaxial, &["force_zero=0.01 N"]);
    asked.modes = vec![Mode::Uniaxial, Mode::Planar];
    let fit = |order: [usize; 2], change: &dyn Fn(&mut Sample)| {
        let all = pieces();
        let mut e = Experiment::pool(order.map(|k| all[k].clone()).to_vec()).expect("two tables");
        e.samples.iter_mut().for_each(change);
        fit_experiment(&e, &asked).expect("fitted")
    };
    let [first, second] = [[0, 1], [1, 0]].map(|order| fit(order, &|_| {}));
    assert_eq!(first.measurement.len(), 3);
    for (a, b) in first.measurement.iter().zip(&second.measurement) {
        assert_eq!(a.error, b.error);
        a.moves.iter().zip(&b.moves).for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}"));
    }
    // The answers when the data have these errors: ± 0.01 of each
    let by = |change: &dyn Fn(&mut Sample, f64)| {
        let ends = [0.01, -0.01].map(|h| fit([0, 1], &|s| change(s, h)).parameters[0].value);
        (ends[0] - ends[1]).abs() / 0.02
    };
    let scale = by(&|s, h| s.stress *= 1.0 + if s.mode == Mode::Planar { 1e-3 * h } else { 0.0 });
    let zero = by(&|s, h| s.stress += if s.mode == Mode::Uniaxial { h } else { 0.0 });
    let force = [(Mode::Uniaxial, uniaxial), (Mode::Planar, planar)]
        .map(|(mode, area)| by(&|s, h| s.stress += if s.mode == mode { 0.01 * h / area } else { 0.0 }));
    let wanted = [zero, force[0].hypot(force[1]), scale];
    for (c, real) in first.measurement.iter().zip(wanted) {
        assert!((c.moves[0] / real - 1.0).abs() < 0.02, "{}: {} {real}", c.error, c.moves[0]);
    }
}

/// The cross-section of a test piece is its own: of two pieces in two modes each error moves the constants by itself, that of the load cell both together.
#[test]
fn a_cross_section_is_of_one_test_piece() {
    let model = FittableLaw::new("mooney_rivlin", None).expect("registered");
    let of = |specimen: usize, mode: Mode| {
        pull(model, &[0.04e6, 0.02e6], mode).into_iter().map(move |s| Sample { specimen, ..s })
    };
    let samples: Vec<Sample> = of(0, Mode::Uniaxial).chain(of(1, Mode::Planar)).collect();
    let fit = |accuracy: &[&str], change: &dyn Fn(&Sample) -> f64| {
        let mut e = table(samples.iter().map(|s| Sample { stress: s.stress * change(s), ..*s }).collect());
        e.specimens = (0..2).map(|k| format!("{k}.csv")).collect();
        let mut o = options(model, Mode::Uniaxial, accuracy);
        o.modes = vec![Mode::Uniaxial, Mode::Planar];
        fit_experiment(&e, &o).expect("fitted")
    };
    let stated = fit(&["stress_scale=0.1%", "area_scale=0.1%"], &|_| 1.0);
    let [common, own] = &stated.measurement[..] else { panic!("{:?}", stated.measurement) };
    assert_eq!([common.error.name(), own.error.name()], ["scale of the stress", "scale of the cross-section"]);
    for k in 0..2 {
        let value = stated.parameters[k].value;
        let by = |one: usize| {
            let ends =
                [1.001, 0.999].map(|by| fit(&[], &|s| if s.specimen == one { by } else { 1.0 }).parameters[k].value);
            0.5 * (ends[0] - ends[1])
        };
        let (uniaxial, planar) = (by(0), by(1));
        assert!(
            (own.moves[k] / uniaxial.hypot(planar) - 1.0).abs() < 0.02,
            "{k}: {} {uniaxial} {planar}",
            own.moves[k]
        );
        assert!(
            (common.moves[k] / (1e-3 * value) - 1.0).abs() < 0.02 && own.moves[k] > 1.2 * common.moves[k],
            "{k}: {common:?} {own:?}"
        );
    }
}
