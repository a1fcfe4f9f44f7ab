//! Notes on laws that lose stability at stretches that occur in soft robots.
//!
//! Every homogeneous mode is checked while all principal stretches lie between ½ and 2 (for an incompressible material: uniaxial and planar ½ to 2,
//! equibiaxial 1/√2 to √2, simple shear to λ − 1/λ at λ = 2). The probe `stretch` records the stretches that a run reaches.

use crate::material::{Instability, Law, LoadCase, StabilityLimit, material_stability};
use crate::scene::build::builder::{Builder, ElasticLaw};

/// Largest principal stretch that is checked \[–\]
const STRETCH: f64 = 2.0;

/// Adds a note for each law of an elastic effect that loses stability.
pub(in crate::scene) fn note_stability(builder: &mut Builder) {
    for ElasticLaw { name, law, .. } in &builder.gathered.laws {
        let note = stability_note(name, law.as_ref());
        builder.notes.extend(note.filter(|note| !builder.notes.contains(note)));
    }
}

/// The note on a law of this name, with the unstable modes and their amounts; `None` if all modes are stable.
pub(in crate::scene) fn stability_note(name: &str, law: &dyn Law) -> Option<String> {
    let lost: Vec<String> = LoadCase::ALL.into_iter().flat_map(|case| lost(law, case)).collect();
    let words = || {
        format!(
            "laws.{name} ({}) is not stable at every principal stretch from {} to {STRETCH}: {}; beyond, results are not to be \
             trusted",
            law.info().name,
            1.0 / STRETCH,
            lost.join(", ")
        )
    };
    (!lost.is_empty()).then(words)
}

/// The limits of stability of a mode on both sides of rest, such as `equibiaxial at 1.37`.
fn lost(law: &dyn Law, case: LoadCase) -> Vec<String> {
    let (name, range) = match case {
        LoadCase::Uniaxial => ("uniaxial", [1.0 / STRETCH, STRETCH]),
        LoadCase::Equibiaxial => ("equibiaxial", [STRETCH.sqrt().recip(), STRETCH.sqrt()]),
        LoadCase::Planar => ("planar", [1.0 / STRETCH, STRETCH]),
        LoadCase::SimpleShear => ("simple shear", [1.0 / STRETCH - STRETCH, STRETCH - 1.0 / STRETCH]),
    };
    // The range consists of stretches, so that no other error can occur
    let Ok(found) = material_stability(law, case, range) else { return vec![] };
    let words = |l: StabilityLimit| match l.why {
        Instability::Drucker => format!("{name} at {:.3}", l.amount),
        why => format!("{name} at {:.3} ({why})", l.amount),
    };
    [found.below, found.above].into_iter().flatten().map(words).collect()
}
