//! Fits the Yeoh law to Treloar's rubber data of 1944 and prints its constants with their intervals.
//!
//! The fit uses only uniaxial tension, up to a stretch of 6; how well the law predicts the two other tests, which were not
//! used in the fit, is part of the result. Run with `cargo run --release --example fit_a_law`.

use durometer::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut request = FitRequest::new("data/treloar-1944/treloar-1944.csv", "yeoh");
    request.options.modes = vec![Mode::Uniaxial];
    request.options.range = Some(StretchRange { from: 1.0, to: 6.0 });
    let result = fit(&request)?;
    // The same text as `durometer fit` prints: constants, intervals, range of validity, predictions, warnings.
    println!("{result}");

    // Constants are in SI units and in the order of the law.
    let c10 = &result.parameters[0];
    assert_eq!(c10.name, "C10");
    assert!(c10.interval[0] < c10.value && c10.value < c10.interval[1]);
    // Half of the shear modulus of this rubber, which is 0.3 MPa to 0.4 MPa.
    assert!((0.12e6..0.22e6).contains(&c10.value), "C10 = {} Pa", c10.value);
    assert!(result.misfit.rms_relative < 0.1, "the law describes its own rows: {}", result.misfit.rms_relative);
    assert!(!result.predictions.is_empty(), "the other two tests are predicted");

    // A scene takes the law from a file of this form: `[laws.rubber] include = "yeoh.toml"`.
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("yeoh.toml");
    result.write_law(&file)?;
    println!("\n{}", std::fs::read_to_string(&file)?);
    Ok(())
}
