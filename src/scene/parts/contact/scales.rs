//! Lengths, pressure and velocity that scale a contact, as given or by default.

use crate::effect::contact::friction::Coulomb;
use crate::math::units::shown;
use crate::mesh::boundary::facet_cells;
use crate::scene::build::builder::Builder;
use crate::scene::error::SceneError;
use crate::scene::parts::contact::spec::{ContactSpec, ResponseSpec};

/// The scales of one contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactScales {
    /// Length over which a barrier or a penalty acts \[m\]
    pub distance: f64,
    /// Pressure of the response \[Pa\]
    pub modulus: f64,
    pub friction: Coulomb,
}

impl ContactScales {
    /// The scales of a contact at cells of size `cell` \[m\] with this modulus \[Pa\], which is 0 without a law.
    pub(in crate::scene) fn new(
        builder: &Builder,
        place: &str,
        spec: &ContactSpec,
        (cell, stiffness): (f64, f64),
    ) -> Result<Self, SceneError> {
        let or = |key: &str, given: Option<f64>, otherwise: f64| match given {
            None => Ok(otherwise),
            Some(value) if value > 0.0 && value.is_finite() => Ok(value),
            Some(value) => Err(builder.content(place, format!("{key} = {value} (SI)"), "it must be positive")),
        };
        let distance = or("distance", spec.distance.map(|l| l.0), 0.01 * cell)?;
        if stiffness == 0.0 && spec.modulus.is_none() {
            let fact = "no law of the scene gives the pressure that the response is scaled with";
            return Err(builder.content(place, fact, "give modulus, of the size of Young's modulus of the body"));
        }
        let modulus = or("modulus", spec.modulus.map(|m| m.0), stiffness)?;
        let size = builder.body.mesh.diagonal();
        let stick_velocity = or("stick_velocity", spec.stick_velocity.map(|s| s.0), 1e-3 * size)?;
        let slip = or("slip", spec.slip.map(|l| l.0), 1e-3 * cell)?;
        // A default does not know the time scale of the motion
        let most = if spec.stick_velocity.is_some() { f64::INFINITY } else { slip };
        let friction = Coulomb { coefficient: spec.friction, stick_velocity, slip, most };
        Ok(Self { distance, modulus, friction })
    }

    /// The scales that matter for this response, in words: `distance 0.05 mm, modulus 1000000 Pa`.
    pub fn words(&self, response: ResponseSpec) -> String {
        let Self { distance, modulus, friction } = self;
        let mut words = format!("modulus {} Pa", shown(*modulus));
        if response != ResponseSpec::Multiplier {
            words = format!("distance {} mm, {words}", shown(distance * 1e3));
        }
        if friction.coefficient > 0.0 {
            let (velocity, slip) = (shown(friction.stick_velocity * 1e3), shown(friction.slip * 1e3));
            words += &format!(", stick_velocity {velocity} mm/s, slip {slip} mm");
        }
        words
    }
}

/// Young's modulus of the stiffest law \[Pa\]; 0 without a law.
pub(super) fn stiffest(builder: &Builder) -> f64 {
    builder.gathered.laws.iter().map(|l| l.law.small_strain().e).fold(0.0, f64::max)
}

/// The largest Young's modulus E \[Pa\] such that cells of modulus E or more are behind at least half of the area of the facets with a law; `None` if there is
/// no law.
pub(super) fn modulus_at(builder: &Builder, facets: &[u32]) -> Option<f64> {
    let mesh = &builder.body.mesh;
    let mut of_cell = vec![0.0_f64; mesh.cell_count()];
    for law in &builder.gathered.laws {
        let e = law.law.small_strain().e;
        for &cell in builder.regions.get(&law.region).iter().flat_map(|region| &region.cells) {
            of_cell[cell as usize] = of_cell[cell as usize].max(e);
        }
    }
    let behind = facet_cells(mesh);
    let own = |&f: &u32| (of_cell[behind[f as usize].0 as usize], mesh.facet_area(f as usize));
    let mut facets: Vec<(f64, f64)> = facets.iter().map(own).filter(|(e, _)| *e > 0.0).collect();
    facets.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Two halves are equal except for rounding.
    let half = (0.5 - 1e-9) * facets.iter().map(|(_, area)| area).sum::<f64>();
    let mut so_far = 0.0;
    let reaches_half = |(_, area): &(f64, f64)| {
        so_far += area;
        so_far >= half
    };
    facets.into_iter().find(reaches_half).map(|(e, _)| e)
}
