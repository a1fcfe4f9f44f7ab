//! Laws whose cells stretch beyond the data from which their constants come.
//!
//! States of different modes are compared by the first invariant Ī₁ = tr(FFᵀ)/J^⅔ (Rivlin 1948; the measure of Yeoh, Gent and Arruda–Boyce), which is reported
//! as the stretch λ of a uniaxial test with λ² + 2/λ = Ī₁. The state checked is that of a run that is farthest from rest, in the elastic effects.

use crate::effect::CellPoints;
use crate::math::tensor::Mat3;
use crate::math::units::Decimals;
use crate::scene::build::Scene;
use crate::scene::spec::EffectSpec;
use toml::{Table, Value};

/// Share of the volume above which there is a note: smaller shares occur at edges and clamps of any scene \[–\].
const SHARE: f64 = 0.01;

/// A note for each law of an elastic effect of which more than one per cent of the volume lies beyond its data at displacement x \[unknowns\].
pub fn beyond_data_notes(scene: &Scene, x: &[f64]) -> Vec<String> {
    let solids = scene.spec.effects.iter().filter_map(|effect| match effect {
        EffectSpec::Elastic(solid) => Some(&solid.law),
        _ => None,
    });
    let mut of_laws: Vec<(&String, Vec<(f64, f64)>)> = vec![];
    for (law, effect) in solids.zip(&scene.stressed) {
        let found = invariants(effect.points(), x);
        match of_laws.iter_mut().find(|(known, _)| *known == law) {
            Some((_, all)) => all.extend(found),
            None => of_laws.push((law, found)),
        }
    }
    let note = |(name, points): (&String, Vec<(f64, f64)>)| {
        let data = Data::of(scene.spec.laws.get(name)?)?;
        data.note(name, &points)
    };
    of_laws.into_iter().filter_map(note).collect()
}

/// The range of stretches of the data of a law.
struct Data {
    /// Smallest and largest stretch \[–\]
    stretch: [f64; 2],
    /// Largest Ī₁ \[–\]
    invariant: f64,
}

impl Data {
    /// The range that the provenance in a law file states: `fitted_stretch` of a fit, `largest_stretch` of an inverse analysis.
    fn of(law: &Table) -> Option<Self> {
        // Each term of a foam has its own ν, and Ī₁ of its tests is not that at constant volume
        let provenance = law.get("provenance").filter(|_| !law.contains_key("nu1"))?.as_table()?;
        let ends = provenance.get("fitted_stretch").and_then(Value::as_array);
        let stretch = match ends.map(Vec::as_slice) {
            Some([low, high]) => [number(low)?, number(high)?],
            Some(_) => return None,
            None => [1.0, largest(provenance.get("largest_stretch")?)?],
        };
        // An inverse analysis states no mode, and its largest stretch may be transverse to a compression: the mode with the largest Ī₁ is taken
        let modes: Vec<&str> = match provenance.get("mode") {
            Some(Value::Array(modes)) => modes.iter().filter_map(Value::as_str).collect(),
            _ => vec!["equibiaxial"],
        };
        // The file does not say how far each mode went: the mode with the smallest Ī₁ at these stretches is taken
        let reach = |mode: &&str| first_invariant(mode, stretch[0]).max(first_invariant(mode, stretch[1]));
        let invariant = modes.iter().map(reach).reduce(f64::min)?;
        (stretch.iter().all(|s| *s > 0.0) && invariant.is_finite()).then_some(Self { stretch, invariant })
    }

    /// The note on a law, given its name, and Ī₁ and the weights of its points; `None` if nearly all of the volume is within the data.
    fn note(&self, name: &str, points: &[(f64, f64)]) -> Option<String> {
        let volume: f64 = points.iter().map(|(_, weight)| weight).sum();
        let beyond = points.iter().filter(|(invariant, _)| *invariant > self.invariant);
        let share = beyond.map(|(_, weight)| weight).sum::<f64>() / volume;
        let largest = points.iter().map(|(invariant, _)| *invariant).reduce(f64::max)?;
        let [low, high] = self.stretch.map(Decimals);
        let words = || {
            format!(
                "laws.{name} is used beyond its data (stretches from {low:.3} to {high:.3}) in {:.1} % of its volume, up to a state like a uniaxial stretch of {:.2}: \
                 nothing measured tells how stiff the material is there; fit the law to data that reach as far",
                Decimals(100.0 * share),
                Decimals(uniaxial(largest))
            )
        };
        (share > SHARE).then(words)
    }
}

/// The number, or the largest number of a list for several specimens.
fn largest(value: &Value) -> Option<f64> {
    match value {
        Value::Array(all) => all.iter().map(number).collect::<Option<Vec<f64>>>()?.into_iter().reduce(f64::max),
        one => number(one),
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| Some(value.as_integer()? as f64))
}

/// Ī₁ of a test at the principal stretch λ in a mode of a law file; J = 1.
fn first_invariant(mode: &str, stretch: f64) -> f64 {
    let square = stretch * stretch;
    match mode {
        "equibiaxial" => 2.0 * square + 1.0 / (square * square),
        "planar" | "simple_shear" => square + 1.0 + 1.0 / square,
        _ => square + 2.0 / stretch,
    }
}

/// The uniaxial stretch λ ≥ 1 with λ² + 2/λ = Ī₁: Newton's method on a convex function, from the right.
fn uniaxial(invariant: f64) -> f64 {
    let mut stretch = invariant.max(3.0).sqrt();
    for _ in 0..60 {
        let slope = 2.0 * stretch - 2.0 / (stretch * stretch);
        let step = (first_invariant("uniaxial", stretch) - invariant) / slope;
        if slope <= 0.0 || step <= 1e-12 * stretch {
            break;
        }
        stretch -= step;
    }
    stretch
}

/// Ī₁ and weight \[m³\] at each point of an elastic effect.
fn invariants(points: &CellPoints, x: &[f64]) -> Vec<(f64, f64)> {
    let of = |f: &Mat3| f.norm_squared() / f.determinant().cbrt().powi(2);
    let cells = points.deformation(x, 0..points.cells.len());
    cells.flat_map(|(_, states)| states.into_iter().map(move |(weight, f)| (of(&f), weight))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data(provenance: &str) -> Option<Data> {
        Data::of(&format!("law = 'neo_hookean'\n[provenance]\n{provenance}").parse().expect("valid TOML"))
    }

    #[test]
    fn the_uniaxial_stretch_of_an_invariant_is_its_inverse() {
        for stretch in [1.0, 1.0 + 1e-6, 1.1, 2.0, 7.6] {
            let found = uniaxial(first_invariant("uniaxial", stretch));
            // Near rest Ī₁ − 3 is of the order of (λ − 1)², which is lost to rounding below 1e-8
            assert!((found - stretch).abs() < 1e-7, "{stretch}: {found}");
        }
        // Compression to 0.7 has the same λ² + 2/λ as a tension of 1.376
        let found = uniaxial(first_invariant("uniaxial", 0.7));
        assert!((first_invariant("uniaxial", found) - 0.49 - 2.0 / 0.7).abs() < 1e-12, "{found}");
    }

    #[test]
    fn data_end_where_the_mode_that_reaches_least_does() {
        let of = |mode, stretch| first_invariant(mode, stretch);
        let found = data("fitted_stretch = [1.02, 1.5]\nmode = ['equibiaxial', 'planar']").expect("a range");
        assert_eq!(found.invariant, of("planar", 1.5));
        let found = data("fitted_stretch = [0.5, 1.2]\nmode = ['uniaxial']").expect("a range");
        assert_eq!(found.invariant, of("uniaxial", 0.5));
        // A specimen compressed to 0.6 has a lateral stretch of 1.291
        let found = data("largest_stretch = 1.291").expect("a whole specimen");
        assert!((found.invariant / of("uniaxial", 0.6) - 1.0).abs() < 1e-3, "{}", found.invariant);
        assert!(
            Data::of(
                &"law = 'hyperfoam'\nnu1 = 0\nprovenance.fitted_stretch = [0.6, 1.0]".parse().expect("valid TOML")
            )
            .is_none()
        );
        let found = data("largest_stretch = 3").expect("a whole specimen");
        assert_eq!((found.stretch, found.invariant), ([1.0, 3.0], of("equibiaxial", 3.0)));
        assert_eq!(data("largest_stretch = [1.5, 2.5]").expect("two specimens").stretch, [1.0, 2.5]);
        for nothing in
            ["data = 'a.csv'", "fitted_stretch = [1.0]", "fitted_stretch = ['a', 'b']", "fitted_stretch = [0.0, 2.0]"]
        {
            assert!(data(nothing).is_none(), "{nothing}");
        }
        assert!(Data::of(&"law = 'gent'\nprovenance = 'a guess'".parse().expect("valid TOML")).is_none());
    }

    #[test]
    fn a_hundredth_of_the_volume_beyond_the_data_is_told() {
        let found = data("fitted_stretch = [1.0, 1.4]\nmode = ['uniaxial']").expect("a range");
        let points = |share: f64| [(3.0, 1.0 - share), (first_invariant("uniaxial", 2.0), share)];
        assert_eq!(found.note("skin", &points(0.009)), None);
        let told = found.note("skin", &points(0.125)).expect("an eighth is beyond");
        let begin = "laws.skin is used beyond its data (stretches from 1.000 to 1.400) in 12.5 % of its volume, up to a state like a uniaxial stretch of 2.00: ";
        assert!(told.starts_with(begin), "{told}");
        assert_eq!(found.note("skin", &[]), None);
    }
}
