//! Samples of every law with known constants.

use durometer::calibrate::{
    ColumnChoice, Experiment, FitOptions, FitResult, FittableLaw, Mode, Sample, fit_experiment, fittable_laws,
};
use durometer::material::{LoadCase, registry};

/// Constants of a rubber for every law and number of terms.
pub fn truth(law: &str, terms: usize) -> Vec<f64> {
    match law {
        "neo_hookean" => vec![0.3e6],
        "mooney_rivlin" => [0.15e6, 0.03e6, 2e3, 3e3, 1e2][..terms].to_vec(),
        "yeoh" => [0.17e6, -1.8e3, 40.0][..terms].to_vec(),
        // The three terms of Ogden 1972, the larger μα first, and one more
        "ogden" => [0.63e6, 1.3, -1e4, -2.0, 1.2e3, 5.0, 1e2, 3.0][..2 * terms].to_vec(),
        "gent" => vec![0.3e6, 80.0],
        "arruda_boyce" => vec![0.27e6, 5.0],
        "veronda_westmann" => vec![0.6e6, 0.3],
        // The example of the registry, without the bulk modulus of a split law
        other => {
            let entry = registry::find(other).expect("registered");
            let skipped = usize::from(entry.info.parameters[0].name == "kappa");
            entry.sample[skipped..][..terms].to_vec()
        }
    }
}

/// Every law that is fitted as incompressible, with all its numbers of terms.
pub fn models() -> Vec<FittableLaw> {
    let rubbers = fittable_laws().into_iter().filter(|e| e.fit.is_some_and(|f| !f.compressible));
    let all = rubbers.flat_map(|e| {
        let counts = e.fit.iter().flat_map(|f| f.term_counts);
        counts.map(|n| FittableLaw::new(e.info.name, Some(*n)).expect("registered"))
    });
    all.collect()
}

pub fn case(mode: Mode) -> LoadCase {
    match mode {
        Mode::Uniaxial => LoadCase::Uniaxial,
        Mode::Equibiaxial => LoadCase::Equibiaxial,
        Mode::Planar => LoadCase::Planar,
        Mode::SimpleShear => LoadCase::SimpleShear,
        Mode::Biaxial => panic!("a biaxial test is no load case of one amount"),
    }
}

/// A table that holds these samples.
pub fn table(samples: Vec<Sample>) -> Experiment {
    let text = b"stretch,nominal stress (Pa)\n1.1,1\n1.2,1\n";
    let mut e =
        Experiment::parse("made.csv", text, None, &ColumnChoice::default(), Some(Mode::Uniaxial)).expect("valid");
    e.samples = samples;
    e
}

/// Samples of a law at evenly spread ln λ, with an error per sample.
pub fn samples(
    model: FittableLaw,
    values: &[f64],
    modes: &[Mode],
    [low, high]: [f64; 2],
    n: u32,
    mut error: impl FnMut(f64) -> f64,
) -> Vec<Sample> {
    let at = |k: u32| low * (high / low).powf(f64::from(k) / f64::from(n - 1));
    let of = |mode: &Mode| (0..n).map(|k| (*mode, at(k))).collect::<Vec<_>>();
    let points = modes.iter().flat_map(of).enumerate();
    let sample = |(k, (mode, stretch)): (usize, (Mode, f64))| {
        let stress = error(model.stress(values, mode, stretch));
        Sample { mode, stretch, stress, line: k as u64 + 2, specimen: 0, second: 1.0 }
    };
    points.map(sample).collect()
}

/// Without repetitions over other ranges, which tests of ranges ask for.
pub fn options(model: FittableLaw, modes: &[Mode]) -> FitOptions {
    FitOptions { terms: Some(model.terms), modes: modes.to_vec(), ranges: 0, ..FitOptions::new(model.name()) }
}

pub fn fitted(model: FittableLaw, modes: &[Mode], samples: Vec<Sample>) -> FitResult {
    fit_experiment(&table(samples), &options(model, modes)).unwrap_or_else(|e| panic!("{}: {e}", model.label()))
}
