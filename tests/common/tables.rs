//! Tables of uniaxial, equibiaxial and planar tests of a Neo-Hookean rubber, as text.

use durometer::calibrate::{
    AuditKind, ColumnChoice, Experiment, FitError, FitOptions, FitResult, Mode, fit_experiment,
};

pub const MU: f64 = 0.371e6;

pub fn stress(mode: Mode, l: f64) -> f64 {
    MU * match mode {
        Mode::Uniaxial => l - 1.0 / (l * l),
        Mode::Equibiaxial => l - l.powi(-5),
        Mode::Planar => l - l.powi(-3),
        Mode::SimpleShear => l - 1.0 / l,
        Mode::Biaxial => panic!("two stretches"),
    }
}

pub fn parse(text: &str) -> Result<Experiment, FitError> {
    Experiment::parse("test.csv", text.as_bytes(), None, &ColumnChoice::default(), Some(Mode::Uniaxial))
}

pub fn parsed(text: &str) -> Experiment {
    parse(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

pub fn fitted(text: &str) -> FitResult {
    fit_experiment(&parsed(text), &FitOptions::new("neo_hookean")).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

pub fn refusal(text: &str) -> String {
    let answer = parse(text).and_then(|e| fit_experiment(&e, &FitOptions::new("neo_hookean")));
    answer.err().unwrap_or_else(|| panic!("must be refused:\n{text}")).to_string()
}

/// A clean table with stretch and stress / `unit`.
pub fn table(mode: Mode, header: &str, unit: f64) -> String {
    let row = |k: usize| {
        let l = 0.8 + 0.05 * k as f64;
        format!("{l},{}\n", stress(mode, l) / unit)
    };
    header.to_string() + "\n" + &(0..30).map(row).collect::<String>()
}

pub fn log_of(e: &Experiment, kind: AuditKind) -> String {
    e.audit.of(kind).map(|entry| format!("{entry}\n")).collect()
}
