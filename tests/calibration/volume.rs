//! Poisson's ratio from lateral strain and the bulk modulus from pressure over volume: closed forms, coverage of intervals, refusals.

use crate::common;
use crate::common::Random;
use crate::common::coverage::{Coverage, Found};
use durometer::calibrate::volume::{VolumeError, VolumeFit, VolumeRequest, VolumeTest, fit_volume};
use durometer::calibrate::{Role, Sign};
use durometer::material::{Volumetric, VolumetricKind};
use rayon::prelude::*;
use std::path::PathBuf;

fn table(name: &str, header: &str, rows: impl Iterator<Item = [f64; 2]>) -> PathBuf {
    let path = common::folder("volume").join(format!("{name}.csv"));
    let lines: String = rows.map(|r| format!("{},{}\n", r[0], r[1])).collect();
    std::fs::write(&path, format!("{header}\n{lines}")).expect("written");
    path
}

fn request(path: PathBuf, test: VolumeTest) -> VolumeRequest {
    VolumeRequest::new(path, test)
}

fn lateral(name: &str, nu: f64, noise: f64, seed: u64) -> Result<VolumeFit, VolumeError> {
    let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9));
    let row = |k: u32| {
        let e = 0.01 * f64::from(k);
        [100.0 * e, 100.0 * ((1.0 + e).powf(-nu) - 1.0 + noise * random.normal())]
    };
    let path = table(name, "strain [%],transverse strain [%]", (0..60).map(row));
    fit_volume(&request(path, VolumeTest::Lateral))
}

/// How often the intervals hold this value.
fn coverage(truth: f64, all: &[VolumeFit]) -> Coverage {
    let found: Vec<Found> = all.iter().map(|fit| (fit.value.value, fit.value.interval)).collect();
    Coverage::of(truth, &found)
}

/// λ_t = λ^−ν is a line through the origin; the digits of the table are those of the numbers.
#[test]
fn a_constant_ratio_comes_back() {
    let fit = lateral("exact", 0.43, 0.0, 1).expect("a fit");
    assert!((fit.value.value - 0.43).abs() < 1e-12 && fit.offsets[0].value.abs() < 1e-12, "{fit}");
    assert!(fit.is_determined() && fit.summary.messages.is_empty(), "{fit}");
    // The same as stretches, in compression
    let rows = (0..20).map(|k| 1.0 - 0.02 * f64::from(k)).map(|l| [l, l.powf(-0.43)]);
    let path = table("stretches", "stretch,lateral stretch", rows);
    let mut stretches = request(path, VolumeTest::Lateral);
    stretches.units = [(Role::Lateral, "1".into())].into();
    assert!((fit_volume(&stretches).expect("a fit").value.value - 0.43).abs() < 1e-12);
}

/// Brackets may say that there is no unit, and λ has a second name.
#[test]
fn columns_without_a_unit_are_numbers() {
    let rows = || (0..20).map(|k| 0.02 * f64::from(k)).map(|e| [e, (1.0 + e).powf(-0.43) - 1.0]);
    for (name, header) in [("dash", "strain [-],lateral strain [-]"), ("one", "strain [1],transverse strain (1)")] {
        let fit = fit_volume(&request(table(name, header, rows()), VolumeTest::Lateral)).expect(header);
        assert!((fit.value.value - 0.43).abs() < 1e-12, "{header}: {fit}");
    }
    let ratios = || rows().map(|[e, t]| [1.0 + e, t]);
    let path = table("ratio", "extension ratio,lateral strain [-]", ratios());
    assert!((fit_volume(&request(path, VolumeTest::Lateral)).expect("λ").value.value - 0.43).abs() < 1e-12);
    let bare = fit_volume(&request(table("bare", "strain,lateral strain [-]", rows()), VolumeTest::Lateral));
    assert!(bare.expect_err("no unit").to_string().contains("column \"strain\" has no unit"));
}

/// 200 draws with errors of 0.1 % strain: 95 ± 4.6 % of the intervals hold the truth.
#[test]
fn intervals_of_the_ratio_cover_it() {
    let holds = |seed: &u64| {
        let fit = lateral(&format!("noisy-{seed}"), 0.45, 1e-3, *seed).expect("a fit");
        fit.value.interval[0] <= 0.45 && 0.45 <= fit.value.interval[1]
    };
    let covered = (1..=200_u64).into_par_iter().filter(holds).count() as f64 / 200.0;
    println!("coverage of nu in 200 draws: {covered:.3}");
    assert!((covered - 0.95).abs() <= 0.046, "{covered}");
}

/// Noise of 0.2 % in the axial strain, up to 10 %, makes the column of the strain rougher than the lateral strain: ν is low by the part σ²/(σ² + s²) of the strain that is noise, and the
/// interval holds that value in 95 − 4.6 % of 200 draws. Its half-width is the one of independent errors, ±0.005; as correlated it was ±0.19, and no bulk modulus followed.
#[test]
fn noise_in_the_strain_is_no_correlation() {
    let drawn = |seed: &u64| {
        let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 5);
        let row = |k: u32| {
            let e = 0.1 * f64::from(k) / 199.0;
            let lateral = (1.0 + e).powf(-0.45) - 1.0 + 5e-4 * random.normal();
            [100.0 * (e + 2e-3 * random.normal()), 100.0 * lateral]
        };
        let path = table(&format!("rough-{seed}"), "strain [%],transverse strain [%]", (0..200).map(row));
        fit_volume(&request(path, VolumeTest::Lateral)).expect("a fit")
    };
    let all: Vec<VolumeFit> = (1..=200_u64).into_par_iter().map(|seed| drawn(&seed)).collect();
    let (strain, noise) = (0.1_f64.powi(2) / 12.0, 2e-3_f64.powi(2));
    let low = 0.45 * strain / (strain + noise);
    let holds = |f: &&VolumeFit| f.value.interval[0] <= low && low <= f.value.interval[1];
    let covered = all.iter().filter(holds).count() as f64 / 200.0;
    let wide = all.iter().filter(|f| f.value.interval[1] - f.value.interval[0] > 0.02).count();
    println!("coverage of the ratio with noise in the strain, 200 draws: {covered:.3}, wide {wide}");
    assert!(covered >= 0.95 - 0.046 && wide <= 10 && all.iter().all(VolumeFit::is_determined), "{covered} {wide}");
    let holds_truth = |f: &&VolumeFit| f.value.interval[0] <= 0.45 && 0.45 <= f.value.interval[1];
    let covered = all.iter().filter(holds_truth).count() as f64 / 200.0;
    assert!(covered >= 0.95 - 0.046, "{covered}");
}

/// κ from volumes that shrink by 2 %, with errors of 0.1 % of their own in 200 rows: the slope of least squares is 2.9 % low with an interval of ±2.4 %, which held the truth in 6 of
/// 20 draws. It is the slope over what is measured; the end of the interval holds what the noise may have taken, in 95 − 6.1 % of 200 draws at least, also where that is 11 %.
#[test]
fn noise_in_the_volume_is_in_the_interval_of_the_bulk_modulus() {
    let drawn = |seed: u64, noise: f64| {
        let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 3);
        let row = |k: u32| {
            let change = -0.02 * f64::from(k) / 199.0;
            [-1500.0 * change, 100.0 * (change + noise * random.normal())]
        };
        let path = table(&format!("volume-{noise}-{seed}"), "Pressure [MPa],volume change [%]", (0..200).map(row));
        let asked = VolumeRequest { volumetric: Some("quadratic".into()), ..request(path, VolumeTest::Bulk) };
        fit_volume(&asked).expect("a fit")
    };
    // 3.4 and 7.7 of the scatter, which 200 draws know to 5 %, and three of these
    for (noise, widest) in [(1e-3, 4.0), (2e-3, 9.0)] {
        let all: Vec<VolumeFit> = (1..=200_u64).into_par_iter().map(|seed| drawn(seed, noise)).collect();
        let found = coverage(1.5e9, &all);
        println!("coverage of kappa with noise of {noise} in the volume: {found:.3?}");
        assert!(found.holds_within([1.66, widest]), "{noise}: {found:?}");
        let named = |f: &VolumeFit| f.summary.messages.iter().any(|m| m.contains("noise in the volume may make kappa"));
        // Where errors pass as correlated by chance the standard error may be the larger one
        let without = all.iter().filter(|f| !named(f)).count();
        assert!(without <= 10, "{without} of 200");
    }
}

/// Specimens whose ratio scatters by 0.02, with an offset each: the interval between three and six of them holds the mean in 95 ± 4.6 % of 200 draws, and the
/// rows of all together, which know nothing of the scatter, are no substitute.
#[test]
fn specimens_are_repeats_of_the_ratio() {
    let drawn = |seed: u64, count: u32| {
        let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 11);
        let one = |specimen: u32| {
            let (nu, offset) = (0.35 + 0.02 * random.normal(), 0.002 * random.normal());
            let row = |k: u32| {
                let e = 0.01 * f64::from(k);
                [100.0 * e, 100.0 * ((offset - nu * e.ln_1p()).exp() - 1.0 + 5e-4 * random.normal())]
            };
            let rows: Vec<[f64; 2]> = (0..40).map(row).collect();
            table(&format!("specimen-{seed}-{count}-{specimen}"), "strain [%],transverse strain [%]", rows.into_iter())
        };
        let mut files: Vec<PathBuf> = (0..count).map(one).collect();
        let mut request = request(files.remove(0), VolumeTest::Lateral);
        request.more = files;
        fit_volume(&request).expect("a fit")
    };
    for count in [3, 6] {
        let holds = |seed: &u64| {
            let [low, high] = drawn(*seed, count).value.interval;
            low <= 0.35 && 0.35 <= high
        };
        let covered = (1..=200_u64).into_par_iter().filter(holds).count() as f64 / 200.0;
        println!("coverage of nu over {count} specimens in 200 draws: {covered:.3}");
        assert!((covered - 0.95).abs() <= 0.046, "{count}: {covered}");
    }
    let fit = drawn(1, 4);
    assert!(fit.offsets.len() == 4 && fit.rows == 160, "{fit}");
    assert!(fit.to_string().contains("scatter between 4 specimens"), "{fit}");
    let mut twice = request(
        table("twice", "strain [%],lateral strain [%]", (0..9).map(|k| [f64::from(k), -0.4 * f64::from(k)])),
        VolumeTest::Lateral,
    );
    twice.more = vec![twice.data.clone()];
    let message = fit_volume(&twice).expect_err("the same file").to_string();
    assert!(message.contains("would count as two specimens"), "{message}");
}

/// A table of a press counts compression as positive, and a range leaves out what is beyond.
#[test]
fn compression_and_ranges_are_understood() {
    let rows = || (0..40).map(|k| 0.01 * f64::from(k)).map(|e| [100.0 * e, 100.0 * ((1.0 - e).powf(-0.2) - 1.0)]);
    let fit =
        fit_volume(&request(table("press", "compressive strain [%],lateral strain [%]", rows()), VolumeTest::Lateral));
    assert!((fit.expect("a fit").value.value - 0.2).abs() < 1e-12);
    let mut stated = request(table("turned", "strain [%],lateral strain [%]", rows()), VolumeTest::Lateral);
    assert!(fit_volume(&stated).is_err(), "it grows with the strain");
    stated.positive = Some(durometer::calibrate::Sign::Compression);
    stated.range = Some("0.8..1".parse().expect("a range"));
    let fit = fit_volume(&stated).expect("a fit");
    assert!((fit.value.value - 0.2).abs() < 1e-12 && fit.rows == 21, "{fit}");
}

/// A column that does not vary gives no value, whatever the other one does.
#[test]
fn a_column_that_does_not_vary_is_refused() {
    let strain = |k: u32| 0.02 * f64::from(k);
    for (name, header, test, what, row) in [
        ("zero", "strain [%],lateral strain [%]", VolumeTest::Lateral, "lateral strain", [1.0, 0.0, 0.0]),
        ("shifted", "strain [%],lateral strain [%]", VolumeTest::Lateral, "lateral strain", [1.0, 0.0, -1.5]),
        ("pressed", "volume change [%],Pressure [MPa]", VolumeTest::Bulk, "pressure", [-1.0, 0.0, 2.0]),
    ] {
        let [along, across, offset] = row;
        let path = table(name, header, (0..30).map(|k| [along * strain(k), across * strain(k) + offset]));
        let error = fit_volume(&request(path, test)).expect_err(what).to_string();
        assert!(error.contains(&format!("the {what} does not vary")), "{error}");
    }
}

/// A lateral strain that comes back while the load goes on has no ratio, however narrow the interval of the line is.
#[test]
fn a_line_that_does_not_describe_the_data_determines_nothing() {
    let row = |k: u32| {
        let e = 0.01 * f64::from(k);
        [100.0 * e, -100.0 * (0.02 * e + 0.5 * (0.3 - e).powi(2))]
    };
    let path = table("back", "strain [%],transverse strain [%]", (0..60).map(row));
    let fit = fit_volume(&request(path, VolumeTest::Lateral)).expect("a fit");
    assert!(fit.misfit > 0.5 && !fit.is_determined(), "{fit}");
    assert!(fit.to_string().contains("the data do not show a constant ratio"), "{fit}");
}

/// A nearly incompressible rubber: the interval reaches ½, and the answer is a bound.
#[test]
fn an_incompressible_rubber_gives_a_bound() {
    let fit = lateral("bound", 0.4999, 2e-3, 3).expect("a fit");
    assert!(fit.bound_only && !fit.is_determined(), "{fit}");
    assert!(fit.to_string().contains("gives no bulk modulus, only nu ≥ 0.49"), "{fit}");
}

/// Data of each volumetric part give its κ, and the part itself where none is asked for; errors of 0.1 % of the pressure leave κ to 0.1 %.
#[test]
fn every_volumetric_part_comes_back() {
    for kind in VolumetricKind::ALL {
        let law = Volumetric { kind, kappa: 1.3e9 };
        let rows = || (0..40).map(|k| 1.0 - 0.01 * f64::from(k)).map(|j| [-law.du(j) / 1e6 + 0.2, 100.0 * (j - 1.0)]);
        let path = table(kind.name(), "Pressure [MPa],volume change [%]", rows());
        let fit = fit_volume(&request(path.clone(), VolumeTest::Bulk)).expect("a fit");
        assert_eq!(fit.volumetric, Some(kind.name()), "{fit}");
        assert!(
            (fit.value.value / 1.3e9 - 1.0).abs() < 1e-9 && (fit.offsets[0].value / 0.2e6 - 1.0).abs() < 1e-6,
            "{fit}"
        );
        let asked = VolumeRequest { volumetric: Some("quadratic".into()), ..request(path, VolumeTest::Bulk) };
        let fit = fit_volume(&asked).expect("a fit");
        assert_eq!(fit.volumetric, Some("quadratic"));
        assert_eq!(fit.summary.messages.is_empty(), kind == VolumetricKind::Quadratic, "a wrong part bends: {fit}");
    }
}

/// Errors of 4 kPa under pressures of up to 0.6 MPa do not tell the volumetric parts apart, whose moduli differ by more than the interval of one: that of the part with the least misfit alone
/// held κ in 60 % of the draws. The one that is given holds those of all parts within its errors, in 95 − 6.1 % of 200 draws at least, and names them. The choice of the part is in the
/// scatter of κ between the draws, so that half-widths are 0.7 to 1.8 of it.
#[test]
fn parts_that_the_data_do_not_tell_apart_are_in_the_interval_of_the_bulk_modulus() {
    let drawn = |seed: u64, kind: VolumetricKind| {
        let mut random = Random::seed(seed.wrapping_mul(0x9e37_79b9) + 17);
        let law = Volumetric { kind, kappa: 20e6 };
        let row = |k: u32| {
            let j = 1.0 - 0.03 * f64::from(k) / 39.0;
            [-law.du(j) + 4e3 * random.normal(), 100.0 * (j - 1.0)]
        };
        let path = table(&format!("{}-{seed}", kind.name()), "Pressure [Pa],volume change [%]", (0..40).map(row));
        fit_volume(&request(path, VolumeTest::Bulk)).expect("a fit")
    };
    for kind in VolumetricKind::ALL {
        let all: Vec<VolumeFit> = (1..=200_u64).into_par_iter().map(|seed| drawn(seed, kind)).collect();
        let found = coverage(20e6, &all);
        println!("coverage of kappa where the part is chosen, {}: {found:.3?}", kind.name());
        assert!(found.holds_within([0.5, 2.2]), "{}: {found:?}", kind.name());
        let is_named = |f: &&VolumeFit| f.summary.method[0].contains("too, which the data do not tell from");
        assert!(all.iter().filter(is_named).count() > 50, "{}", all[0]);
    }
}

/// κ = 500 MPa from V/V0 as a number and in percent, and from its change: the name decides, and numbers that contradict it are refused, as is advice with another factor.
#[test]
fn the_name_tells_a_ratio_from_a_change() {
    let law = Volumetric { kind: VolumetricKind::Quadratic, kappa: 500e6 };
    let fit = |name: &str, header: &str, of: &dyn Fn(f64) -> f64, unit: Option<&str>| {
        let rows = (0..20).map(|k| 1.0 - 0.0025 * f64::from(k)).map(|j| [-law.du(j) / 1e6, of(j)]);
        let path = table(name, &format!("Pressure [MPa],{header}"), rows);
        let units = unit.map(|u| (Role::Volume, u.to_string())).into_iter().collect();
        let volumetric = Some("quadratic".to_string());
        fit_volume(&VolumeRequest { units, volumetric, ..request(path, VolumeTest::Bulk) })
    };
    let ratio = |j: f64| j;
    let percent = |j: f64| 100.0 * j;
    let change = |j: f64| 100.0 * (j - 1.0);
    for (name, header, of, unit) in [
        ("j", "J", &ratio as &dyn Fn(f64) -> f64, Some("1")),
        ("relative", "Relative volume [%]", &percent, None),
        ("v-v0", "V/V0 [-]", &ratio, None),
        ("relative-change", "Relative volume change [%]", &change, None),
        ("volumetric-strain", "Volumetric strain [%]", &change, None),
        ("delta-v", "ΔV/V0 volume [%]", &change, None),
    ] {
        let fit = fit(name, header, of, unit).unwrap_or_else(|e| panic!("{header}: {e}"));
        assert!((fit.value.value / 500e6 - 1.0).abs() < 1e-9, "{header}: {fit}");
    }
    for (name, header, of, says) in [
        ("bare-j", "J", &ratio as &dyn Fn(f64) -> f64, "such as --unit volume=1"),
        ("not-change", "Volume change [%]", &percent, "the nearest V/V0 is 1.95"),
        ("unsaid", "Volume [%]", &percent, "call it \"volume ratio\""),
        ("not-ratio", "Volume ratio [%]", &(|j: f64| 100.0 * (1.001 - j)), "call it \"volume change\""),
    ] {
        let message = fit(name, header, of, None).expect_err(says).to_string();
        assert!(message.contains(says), "gave: {message}\nnot: {says}");
    }
}

/// Letters of another word make no true strain: "Analog 2" is a channel, "log. strain" is ln λ.
#[test]
fn true_strains_have_a_word_of_their_own() {
    let column = |e: f64, is_true: bool| if is_true { e.ln_1p() } else { e };
    for (name, header, is_true) in [
        ("analog", "Lateral strain (Analog 2) [%]", false),
        ("logger", "Lateral strain logger [%]", false),
        ("log", "Lateral log. strain [%]", true),
        ("true", "True lateral strain [%]", true),
    ] {
        let rows = (0..20).map(|k| 0.02 * f64::from(k));
        let rows = rows.map(|e| [100.0 * e, 100.0 * column((1.0 + e).powf(-0.43) - 1.0, is_true)]);
        let path = table(&format!("letters-{name}"), &format!("strain [%],{header}"), rows);
        let fit = fit_volume(&request(path, VolumeTest::Lateral)).unwrap_or_else(|e| panic!("{header}: {e}"));
        assert!((fit.value.value - 0.43).abs() < 1e-9, "{header}: {fit}");
    }
}

/// (table, what the message must say)
#[test]
fn bad_tables_of_volume_are_refused() {
    let refused = |request: &VolumeRequest, says: &str| {
        let message = fit_volume(request).expect_err(says).to_string();
        assert!(message.contains(says), "gave: {message}\nnot: {says}");
    };
    let rows = |nu: f64| (0..20).map(move |k| [f64::from(k), -nu * f64::from(k)]);
    let of = |name: &str, header: &str, rows: Vec<[f64; 2]>| table(name, header, rows.into_iter());
    let sign = of("sign", "strain [%],lateral strain [%]", rows(-0.45).collect());
    refused(&request(sign.clone(), VolumeTest::Lateral), "the lateral strain grows with the axial one");
    refused(&request(sign.clone(), VolumeTest::Lateral), "pass --positive compression where");
    refused(&request(sign.clone(), VolumeTest::Bulk), "no line names columns of pressure, volume");
    let part = VolumeRequest { volumetric: Some("quadratic".into()), ..request(sign.clone(), VolumeTest::Lateral) };
    refused(&part, "a lateral strain gives Poisson's ratio");
    let bulk =
        of("bulk", "pressure [MPa],volume ratio", (0..9).map(|k| [f64::from(k), 1.0 + 0.01 * f64::from(k)]).collect());
    let unit = VolumeRequest { units: [(Role::Volume, "1".into())].into(), ..request(bulk.clone(), VolumeTest::Bulk) };
    refused(&unit, "the volume grows with the pressure");
    let range = VolumeRequest { range: Some("1..1.3".parse().expect("a range")), ..unit.clone() };
    refused(&range, "--range has no effect with --experiment bulk");
    let positive = VolumeRequest { positive: Some(Sign::Compression), ..unit.clone() };
    refused(&positive, "--positive has no effect with --experiment bulk");
    refused(&request(bulk.clone(), VolumeTest::Bulk), "column \"volume ratio\" has no unit");
    let named = VolumeRequest { volumetric: Some("cubic".into()), ..unit };
    refused(&named, "\"cubic\" is no volumetric part");
    let wrong = of("wrong", "pressure [mm],volume ratio [%]", rows(1.0).collect());
    refused(&request(wrong, VolumeTest::Bulk), "\"mm\" is no unit of pressure");
    let few = of("few", "strain [%],lateral strain [%]", rows(0.4).take(3).collect());
    refused(&request(few, VolumeTest::Lateral), "3 data points, and a fit needs at least 4");
    let still = of("still", "strain [%],lateral strain [%]", (0..9).map(|k| [1.0, f64::from(k)]).collect());
    refused(&request(still, VolumeTest::Lateral), "the strain does not vary");
    let gone = of("gone", "strain [%],lateral strain [%]", rows(9.0).collect());
    refused(&request(gone, VolumeTest::Lateral), "the lateral strain is not above −100 % in 8 lines: 14, 15, 16");
}
