//! Derivatives by the constants of a law, against differences of the law built anew, at random constants and states.
//!
//! D(h) is the central difference over θ(1 ± h); Richardson's (64 D(h/4) − 20 D(h/2) + D(h))/45 leaves h⁶/64 of the seventh
//! derivative. With h = 1e-2 and constants whose poles lie at least 0.25 θ away (ν → ½, E → 3μ, J_m → Ī₁ − 3) that is
//! (1e-2/0.25)⁶/64 ≈ 1e-10 of the value, and rounding 7ε/h·k ≈ 2e-13 k: the bound is 1e-8 of the size on the stencil.

use crate::common::{Random, example_table};
use durometer::material::{LAWS, Law, LawSpecError, Moduli, Response, Want, derivative, law_from_table};
use durometer::math::statistics::larger;
use durometer::math::tensor::Mat3;
use durometer::math::units::{self, Dimension};
use toml::{Table, Value};

const BOUND: f64 = 1e-8;

/// F within 0.25 of the unit matrix, so that no example of a law is at its limit.
fn near(random: &mut Random) -> Mat3 {
    Mat3::identity() + Mat3::from_fn(|_, _| random.around(0.25))
}

fn number(table: &Table, key: &str) -> f64 {
    match &table[key] {
        Value::String(text) => units::parse(text, Dimension::PRESSURE).expect("a stress"),
        other => other.as_float().expect("a number"),
    }
}

/// The table with another value [SI]; every digit counts.
fn with(table: &Table, key: &str, value: f64) -> Table {
    let mut table = table.clone();
    let text = matches!(table[key], Value::String(_)).then(|| Value::from(format!("{value:?} Pa")));
    table.insert(key.into(), text.unwrap_or(Value::from(value)));
    table
}

/// ψ, P and A one after the other.
fn numbers(law: &dyn Law, f: &Mat3) -> Vec<f64> {
    let Response { psi, p, a } = law.eval(f, Want::Tangent).expect("within the range of the law");
    [&[psi], p.as_slice(), a.as_flattened()].concat()
}

/// `read` of ∂/∂key against its differences.
fn check(table: &Table, key: &str, read: impl Fn(&dyn Law) -> Vec<f64>) {
    let theta = number(table, key);
    let mut size = 0.0_f64;
    let mut difference = |h: f64| -> Vec<f64> {
        let at = |s: f64| {
            let law = law_from_table(&with(table, key, theta * (1.0 + s))).unwrap_or_else(|e| panic!("{key}: {e}"));
            read(law.as_ref())
        };
        let (plus, minus) = (at(h), at(-h));
        size = plus.iter().fold(size, |m, x| larger(m, x.abs()));
        plus.iter().zip(&minus).map(|(a, b)| (a - b) / (2.0 * h * theta)).collect()
    };
    let (d1, d2, d4) = (difference(1e-2), difference(5e-3), difference(2.5e-3));
    let got = read(derivative(table, key).unwrap_or_else(|e| panic!("{key}: {e}")).as_ref());
    let largest = got.iter().fold(0.0, |m, x| larger(m, x.abs()));
    for (k, got) in got.iter().enumerate() {
        let expected = (64.0 * d4[k] - 20.0 * d2[k] + d1[k]) / 45.0;
        let bound = BOUND * (size / theta.abs() + largest);
        assert!((got - expected).abs() <= bound, "{table:?} by {key}, entry {k}: {got}, differences say {expected}");
    }
}

/// Every law, each of its constants, with κ and with ν, every volumetric part.
#[test]
fn derivatives_by_the_constants() {
    for entry in LAWS {
        let name = entry.info.name;
        let (mut random, mut compared) = (Random::seed(31), 0);
        let knows = |key: &str| entry.keys.iter().any(|known| known.name == key);
        for n in 0..12 {
            let mut table = example_table(name);
            if let Some(choice) = entry.info.choices.iter().find(|c| c.name == "volumetric") {
                table.insert("volumetric".into(), choice.options[n % choice.options.len()].into());
            }
            if let Some(choice) = entry.info.choices.iter().find(|c| c.name == "convention") {
                table.insert("convention".into(), choice.options[n % choice.options.len()].into());
            }
            if n % 2 == 1 {
                table.remove("kappa");
            }
            if !table.contains_key("kappa") && knows("nu") {
                table.insert("nu".into(), 0.3.into());
            }
            let keys: Vec<String> = table.keys().filter(|key| knows(key)).cloned().collect();
            for key in &keys {
                let spread = if key == "nu" { 0.1 } else { 0.3 };
                // Differences are over shares of the value, and a share of zero is zero
                let middle = Some(number(&table, key)).filter(|value| *value != 0.0).unwrap_or(0.1);
                table = with(&table, key, middle * (1.0 + random.around(spread)));
            }
            if law_from_table(&table).is_err() {
                continue;
            }
            compared += 1;
            let f = near(&mut random);
            assert!(!keys.is_empty());
            for key in &keys {
                check(&table, key, |law| numbers(law, &f));
                check(&table, key, |law| {
                    let (rest, u) = law.split().map_or((None, 0.0), |(rest, u)| (Some(rest), u.kappa));
                    let mut all = rest.map_or(vec![], |rest| numbers(rest.as_ref(), &f));
                    all.push(u);
                    all
                });
                check(&table, key, |law| {
                    let Moduli { mu, kappa, .. } = law.small_strain();
                    vec![mu, kappa]
                });
            }
        }
        assert!(compared >= 11, "{name}: 12 draws, of which {compared} are a law");
    }
}

/// Any two of E, ν, μ, λ, κ: the derivative by the one at the other fixed.
#[test]
fn any_pair_of_constants() {
    let mut random = Random::seed(32);
    let all = Moduli::from_e_nu(100e3, 0.1).expect("within bounds");
    let named = [("E", all.e), ("nu", all.nu), ("mu", all.mu), ("lambda", all.lambda), ("kappa", all.kappa)];
    for (k, a) in named.iter().enumerate() {
        for b in &named[..k] {
            let mut table = Table::new();
            table.insert("law".into(), "neo_hookean".into());
            for (key, value) in [a, b] {
                let text = Value::from(format!("{value:?} Pa"));
                table.insert((*key).into(), if *key == "nu" { Value::from(*value) } else { text });
            }
            let f = near(&mut random);
            for (key, _) in [a, b] {
                check(&table, key, |law| numbers(law, &f));
                check(&table, key, |law| {
                    let m = law.small_strain();
                    vec![m.e / 1e5, m.nu]
                });
            }
        }
    }
}

/// A constant that the file does not give has no derivative, and the message says which it gives.
#[test]
fn what_is_not_given_is_refused() {
    let error = derivative(&example_table("yeoh"), "nu").expect_err("kappa is given");
    assert!(matches!(&error, LawSpecError::NotGiven { key, .. } if key == "nu"), "{error}");
    let says = "`nu` is not given, so nothing depends on it; give it a value, or take one of C10, C20, C30, kappa";
    assert_eq!(error.to_string(), says);
}
