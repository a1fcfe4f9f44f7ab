//! The direction in which a table without time lists its rows decides nothing: neighbours are those in stretch, and residuals are judged the same from either end.
//! Rows that go to and fro are those of cycles, which is said.

use durometer::calibrate::{FitRequest, FitResult, FitWarning, Mode, fit};
use std::path::Path;

/// Treloar's uniaxial rows in an order.
fn treloar(law: &str, terms: Option<usize>, order: impl Fn(&mut Vec<String>)) -> FitResult {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/treloar-1944/treloar-1944.csv");
    let text = std::fs::read_to_string(file).expect("it is committed");
    let (header, rows) = text.split_once('\n').expect("a header");
    let mut rows: Vec<String> = rows.lines().filter(|row| row.starts_with("uniaxial")).map(String::from).collect();
    order(&mut rows);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let table = folder.path().join("table.csv");
    std::fs::write(&table, format!("{header}\n{}\n", rows.join("\n"))).expect("room");
    let mut request = FitRequest::new(table, law);
    request.options.terms = terms;
    request.options.modes = vec![Mode::Uniaxial];
    fit(&request).unwrap_or_else(|e| panic!("{law}: {e}"))
}

/// Every second row, then the others from the end.
fn shuffle(rows: &mut Vec<String>) {
    let (even, odd): (Vec<_>, Vec<_>) = rows.drain(..).enumerate().partition(|(k, _)| k % 2 == 0);
    rows.extend(even.into_iter().chain(odd.into_iter().rev()).map(|(_, row)| row));
}

/// The warnings by their names, and of a pattern its runs.
fn verdict(fit: &FitResult) -> Vec<String> {
    let name = |w: &FitWarning| match w {
        FitWarning::Systematic { runs, .. } => format!("systematic {runs:?}"),
        FitWarning::MayBeZero { symbols } => format!("may be zero: {symbols:?}"),
        other => format!("{other:?}").split([' ', '{']).next().unwrap_or_default().to_string(),
    };
    fit.warnings.iter().map(name).collect()
}

#[test]
fn the_direction_of_rows_decides_nothing() {
    for (law, terms) in [("yeoh", None), ("mooney_rivlin", Some(5))] {
        let listed = treloar(law, terms, |_| ());
        assert!(!verdict(&listed).is_empty());
        let reversed = treloar(law, terms, |rows| rows.reverse());
        println!("{law}: {:?}, {:?}", reversed.errors, verdict(&reversed));
        assert_eq!(verdict(&listed), verdict(&reversed), "{law}");
        for (a, b) in listed.parameters.iter().zip(&reversed.parameters) {
            assert!((a.value - b.value).abs() < 1e-9 * a.value.abs(), "{law}: {} and {}", a.value, b.value);
            assert!((a.std_error / b.std_error - 1.0).abs() < 1e-6, "{law}: {a:?} {b:?}");
        }
        let shuffled = treloar(law, terms, shuffle);
        assert!(verdict(&shuffled).contains(&"Cycles".into()), "{law}: {:?}", verdict(&shuffled));
    }
}
