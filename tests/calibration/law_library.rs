//! The list of a library of law files: stability by mode, laws of other conventions, foams, and the files that are not listed.

use durometer::calibrate::{Library, ListedLaw, Mode, library, library_text};
use std::path::Path;

const YEOH: &str = "law = \"yeoh\"\nC10 = \"20 kPa\"\nC20 = \"-2.7 kPa\"\nC30 = \"35 Pa\"\n";
const VOLUME: &str = "volumetric = \"quadratic\"\nkappa = \"40 MPa\"\n";

/// The library of these files, and the folder they are in.
fn of(files: &[(&str, &str)]) -> (tempfile::TempDir, Library) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).expect("writable"));
    let found = library(folder.path()).unwrap_or_else(|e| panic!("{e}"));
    (folder, found)
}

/// This law of Yeoh is stable farther in uniaxial than in equibiaxial tension, which ends the list. Independently: of W(I₁) the Hessian in the logarithmic strains e₁, e₂ (λ₃ = 1/λ₁λ₂) at λ₁ = λ₂ = λ
/// has the least eigenvalue W′h₋ or W′h₊ + W″g², whose zero is found by bisection.
#[test]
fn stability_is_that_of_every_mode() {
    let (folder, found) = of(&[("yeoh.toml", YEOH)]);
    let law = &found.laws[0];
    let least = |l: f64| {
        let (a, b) = (l.powi(2), l.powi(-4));
        let i = 2.0 * a + b - 3.0;
        let (w1, w2) = (20e3 - 5.4e3 * i + 105.0 * i * i, -5.4e3 + 210.0 * i);
        // ∂²I₁/∂e² along (1, 1) and (1, −1), of unit length, and (∂I₁/∂e)² along the first
        let (plus, minus, slope) = (4.0 * a + 8.0 * b, 4.0 * a, 2.0_f64.sqrt() * (2.0 * a - 2.0 * b));
        (w1 * plus + w2 * slope * slope).min(w1 * minus)
    };
    let (mut low, mut high) = (1.0, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if least(middle) > 0.0 { low = middle } else { high = middle }
    }
    // The near incompressibility of the certificate moves the loss by about 1e-5
    assert!((law.stable[1] / low - 1.0).abs() < 1e-3, "{} not {low}", law.stable[1]);
    assert_eq!(law.stable_modes[1], Some("equibiaxial"));
    for r in law.stability.iter().filter(|r| r.mode != Mode::SimpleShear) {
        assert!(r.covers([law.stable[0] + 1e-9, law.stable[1] - 1e-9]), "{r:?} {:?}", law.stable);
    }
    let text = library_text(&found, folder.path());
    assert!(text.contains("(equibiaxial)") && text.contains("stable λ (all modes)"), "{text}");
}

fn same(a: &ListedLaw, b: &ListedLaw) {
    let near = |x: f64, y: f64| (x - y).abs() <= 1e-12 * y.abs();
    assert!(near(a.shear_modulus, b.shear_modulus) && near(a.stress_at_2, b.stress_at_2), "{a:?} {b:?}");
    assert_eq!(a.constants.len(), b.constants.len());
    assert!(a.constants.iter().zip(&b.constants).all(|(x, y)| x.symbol == y.symbol && near(x.value, y.value)));
}

/// One law in three conventions is listed three times alike, with the interval of μ only where it is one of the μ listed.
#[test]
fn other_conventions_are_converted() {
    let ogden = |convention: &str, mu: [f64; 2]| {
        format!(
            "law = \"ogden\"\nconvention = \"{convention}\"\nmu1 = \"{} Pa\"\nalpha1 = 1.5\nmu2 = \"{} Pa\"\nalpha2 = -2.5\n{VOLUME}[provenance]\nmu1_interval = [1.0, 2.0]\n",
            mu[0], mu[1]
        )
    };
    let c = [8e5, 1e5];
    let texts = [
        ("abaqus", ogden("abaqus", [c[0] / 2.0, c[1] / 2.0])),
        ("febio", ogden("febio", c)),
        ("ogden", ogden("ogden", [c[0] / 1.5, -c[1] / 2.5])),
    ];
    for (name, text) in &texts {
        // Alone in its folder
        let (_folder, alone) = of(&[("law.toml", text)]);
        assert!(alone.laws.len() == 1 && alone.skipped.is_empty(), "{name}: {alone:?}");
        let (_folder, own) = of(&[("law.toml", &texts[2].1)]);
        same(&alone.laws[0], &own.laws[0]);
        assert_eq!(alone.laws[0].constants[0].interval.is_some(), *name == "ogden");
    }
}

/// Foams with one ν or several, laws without a form for fits, and laws by other constants have the stiffness of their file.
#[test]
fn foams_and_other_laws_are_listed() {
    let foam =
        "law = \"hyperfoam\"\nmu1 = \"30 kPa\"\nalpha1 = 6\nnu1 = 0.1\nmu2 = \"10 kPa\"\nalpha2 = -2\nnu2 = 0.25\n";
    let blatz = "law = \"hyperfoam\"\nmu1 = \"30 kPa\"\nalpha1 = -2\nnu1 = 0.25\n";
    let elastic = "law = \"neo_hookean\"\nE = \"90 kPa\"\nnu = 0.5\n".replace("0.5", "0.49999");
    let linear = "law = \"linear\"\nE = \"90 kPa\"\nnu = 0.25\n";
    let (_folder, found) = of(&[("a.toml", foam), ("b.toml", blatz), ("c.toml", &elastic), ("d.toml", linear)]);
    assert!(found.skipped.is_empty() && found.laws.len() == 4, "{found:?}");
    let near = |x: f64, y: f64, by: f64| assert!((x / y - 1.0).abs() < by, "{x} not {y}");
    near(found.laws[0].shear_modulus, 40e3, 1e-12);
    assert_eq!(found.laws[0].constants.len(), 6);
    // Uniaxial: λ₂ = λ^−ν, P = (2μ/α)(λ^α − λ₂^α)/λ
    near(found.laws[1].stress_at_2, -30e3 * (2.0_f64.powi(-2) - 2.0_f64.powf(0.5)) / 2.0, 1e-9);
    // E/(2(1 + ν)) and μ(λ − λ⁻²), to 1 − 2ν
    near(found.laws[2].shear_modulus, 30e3, 1e-4);
    near(found.laws[2].stress_at_2, 52.5e3, 1e-3);
    near(found.laws[3].shear_modulus, 36e3, 1e-12);
}

/// Open ends of intervals are listed, and so is a constant that its file says is not determined.
#[test]
fn open_intervals_are_listed() {
    let law = "law = \"mooney_rivlin\"\nC10 = \"25 kPa\"\nC01 = \"5 kPa\"\n[provenance]\n";
    let both = law.to_string() + "C10_interval = [\"-inf Pa\", \"inf Pa\"]\nC01_interval = [\"4 kPa\", \"inf Pa\"]\n";
    let without = law.to_string() + "C10_without_interval = \"the curves do not determine it\"\n";
    let (folder, found) = of(&[("a.toml", &both), ("b.toml", &without)]);
    let ends = |law: usize, k: usize| found.laws[law].constants[k].interval;
    assert_eq!([ends(0, 0), ends(1, 0)], [Some([f64::NEG_INFINITY, f64::INFINITY]); 2]);
    assert_eq!([ends(0, 1), ends(1, 1)], [Some([4e3, f64::INFINITY]), None]);
    let text = library_text(&found, folder.path());
    assert!(text.matches("kPa (open at both ends)").count() == 2 && text.contains(" to open)"), "{text}");
}

/// Every file that is not listed is named: those with a law or an error with the reason.
#[test]
fn files_that_are_not_listed_are_named() {
    let bad = [
        ("unknown.toml", "law = \"rubber\"\n"),
        ("broken.toml", "law = \n"),
        ("half.toml", "law = \"ogden\"\nmu1 = \"30 kPa\"\n"),
    ];
    let files = [&bad[..], &[("card.toml", "name = \"t\"\n"), ("yeoh.toml", YEOH)]].concat();
    let (folder, found) = of(&files);
    assert!(found.laws.len() == 1 && found.skipped.len() == 3 && found.others.len() == 1, "{found:?}");
    let text = library_text(&found, folder.path());
    for words in [
        "not listed: unknown.toml: ",
        "not listed: broken.toml: ",
        "not listed: half.toml: ",
        "without a key `law`: card.toml",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let empty = tempfile::tempdir().expect("a temporary folder");
    bad.iter().for_each(|(name, text)| std::fs::write(empty.path().join(name), text).expect("writable"));
    let message = library(empty.path()).expect_err("no law that can be listed").to_string();
    assert!(message.contains("holds no law file") && message.contains("unknown.toml: "), "{message}");
    assert!(library(Path::new("/nowhere/at/all")).is_err());
}
