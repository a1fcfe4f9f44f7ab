//! Fields of a state, for ParaView.
//!
//! Stress fields are those of the elastic effects, of families of fibres, and of effects that relax or soften at the state, σ = P Fᵀ/J: the stress that
//! balances the reactions, except for viscous forces, which it does not contain. A cell has the mean over its quadrature points, weighted by the reference
//! volume; a node has the value [recovered](super::stress_recovery) from the points of the cells around it. Von Mises' stress and the pressure −tr σ/3 are
//! those of that tensor.

use super::output::{Field, FieldSpec};
use super::stress_recovery::StressField;
use crate::effect::{HistoryStress, PointStress, StressAtState};
use crate::math::tensor::Mat3;
use crate::scene::build::Scene;
use crate::scene::parts::effects::EffectSpec;
use crate::system::State;

/// The fields of a state.
pub(in crate::scene) fn fields(scene: &Scene, state: &State, what: &[FieldSpec]) -> Vec<Field> {
    let stress = what.iter().any(|f| matches!(f, FieldSpec::Stress | FieldSpec::VonMises | FieldSpec::Pressure));
    let tensors = || {
        let elastic = scene.stressed.iter().map(|effect| &**effect as &dyn PointStress);
        let remembering = remembering(scene, state);
        let others =
            scene.reinforcing.iter().map(|effect| &**effect as _).chain(remembering.iter().map(|effect| effect as _));
        let all: Vec<&dyn PointStress> = elastic.chain(others).collect();
        let field = StressField::new(&scene.body.mesh, &all, &state.x);
        [(field.nodal(), true), (field.means(), false)]
    };
    let stress = stress.then(tensors);
    let displacements = 3 * scene.body.mesh.points.len();
    let mut out = Vec::new();
    for field in what {
        let node = |name, components, values| Field { name, components, values, at_nodes: true };
        let (name, components, of): (_, _, fn(&Mat3) -> Vec<f64>) = match field {
            FieldSpec::Displacement => {
                out.push(node("displacement_m", 3, state.x[..displacements].to_vec()));
                continue;
            }
            FieldSpec::Velocity => {
                out.push(node("velocity_m_s", 3, state.v[..displacements].to_vec()));
                continue;
            }
            FieldSpec::ContactForce => {
                let mut forces = vec![0.0; displacements];
                scene.contacts.iter().for_each(|c| c.nodal(&state.x, None, &mut forces));
                out.push(node("contact_force_N", 3, forces));
                continue;
            }
            FieldSpec::Stretch => {
                out.push(node("stretch", 1, scene.nodal_stretch(&state.x)));
                continue;
            }
            FieldSpec::Stress => ("stress_Pa", 9, |s| s.transpose().as_slice().to_vec()),
            FieldSpec::VonMises => ("von_mises_Pa", 1, |s| vec![von_mises(s)]),
            FieldSpec::Pressure => ("pressure_Pa", 1, |s| vec![-s.trace() / 3.0]),
        };
        for (tensors, at_nodes) in stress.iter().flatten() {
            let values = tensors.iter().flat_map(of).collect();
            out.push(Field { name, components, values, at_nodes: *at_nodes });
        }
    }
    out
}

/// The effects that relax or soften, each with its memory at a state.
fn remembering<'a>(scene: &'a Scene, state: &'a State) -> Vec<StressAtState<'a>> {
    let (mut relaxing, mut softening) = (scene.relaxing.iter(), scene.softening.iter());
    let of = |(k, spec): (usize, &EffectSpec)| {
        let effect: &dyn HistoryStress = match spec {
            EffectSpec::Viscoelastic(_) => &**relaxing.next().expect("one for each viscoelastic effect"),
            EffectSpec::Mullins(_) => &**softening.next().expect("one for each softening effect"),
            _ => return None,
        };
        Some(StressAtState { effect, history: &state.history[scene.system.history_of(k)] })
    };
    // The effects of the file come first in the system, in their order
    scene.spec.effects.iter().enumerate().filter_map(of).collect()
}

/// Von Mises' stress √(3/2 s:s), where s is the deviator.
fn von_mises(sigma: &Mat3) -> f64 {
    (1.5 * (sigma - Mat3::identity() * (sigma.trace() / 3.0)).norm_squared()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parse_scene;

    /// A bar pulled along y: each field has its components for every node or cell. A stress and its invariants are given at the nodes, then in the cells, row
    /// by row.
    #[test]
    fn fields_have_the_shape_that_they_state() {
        let scene = parse_scene(
            "[mesh]\ngrid = { kind = 'box', size = ['10 mm', '20 mm', '10 mm'], divisions = [1, 2, 1] }\n\
             [laws.rubber]\nlaw = 'neo_hookean'\nE = '100 kPa'\nnu = 0\n[[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = 'rubber'\n\
             [[constraint]]\nkind = 'fixed'\nregion = 'ymin'\n[[constraint]]\nkind = 'prescribed'\nregion = 'ymax'\ncomponents = 'y'\n\
             displacement = { kind = 'ramp', from = '0 mm', to = '2 mm', end = '1 s' }\n\
             [[stage]]\nintegrator = 'static'\nduration = '1 s'\ndt = '1 s'",
        )
        .expect("a scene");
        use FieldSpec::{ContactForce, Displacement, Pressure, Stress, Stretch, Velocity, VonMises};
        let what = [Displacement, Velocity, ContactForce, Stretch, Stress, VonMises, Pressure];
        let fields = scene.fields(&scene.run().last, &what);
        let pairs =
            ["stress_Pa", "von_mises_Pa", "pressure_Pa"].into_iter().flat_map(|name| [(name, true), (name, false)]);
        let single = ["displacement_m", "velocity_m_s", "contact_force_N", "stretch"].map(|name| (name, true));
        assert!(fields.iter().map(|f| (f.name, f.at_nodes)).eq(single.into_iter().chain(pairs)));
        for Field { name, components, values, at_nodes } in &fields {
            let places = if *at_nodes { scene.body.mesh.points.len() } else { scene.body.mesh.cell_count() };
            assert_eq!(values.len(), components * places, "{name}");
            if *name == "stress_Pa" {
                let along =
                    |stress: &[f64]| stress[4] > 1e3 && (0..9).all(|k| k == 4 || stress[k].abs() < 1e-3 * stress[4]);
                assert!(values.chunks_exact(9).all(along), "{values:?}");
            }
        }
    }

    /// A stress with memory is that of its own effect, whatever the names of effects before it.
    #[test]
    fn a_name_of_another_effect_changes_no_stress() {
        for remembers in [
            "kind = 'viscoelastic'\nmoduli = 'long_term'\nprony = [{ g = 0.3, tau = '0.1 s' }]",
            "kind = 'mullins'\nsoftening = { r = 1.7, m = '1.5 kPa', beta = 0.1 }",
        ] {
            let stress = |name: &str| {
                let scene = parse_scene(&format!(
                    "[mesh]\ngrid = {{ kind = 'box', size = ['20 mm', '10 mm', '10 mm'], divisions = [2, 1, 1] }}\n\
                     [laws.rubber]\nlaw = 'neo_hookean_split'\nmu = '40 kPa'\nnu = 0.45\nvolumetric = 'quadratic'\n\
                     [[effect]]\nkind = 'point_force'\nname = '{name}'\npoint = ['15 mm', '5 mm', '5 mm']\nradius = '4 mm'\ndirection = [0, 0, -1]\n\
                     force = {{ kind = 'ramp', from = '0 N', to = '0.05 N', end = '0.1 s' }}\n\
                     [[effect]]\nkind = 'elastic'\nregion = 'body'\nlaw = 'rubber'\n[[effect]]\nregion = 'body'\nlaw = 'rubber'\n{remembers}\n\
                     [[constraint]]\nkind = 'fixed'\nregion = 'xmin'\n\
                     [[stage]]\nintegrator = 'implicit_euler'\nduration = '0.1 s'\ndt = '0.05 s'"
                ))
                .unwrap_or_else(|e| panic!("{e}"));
                scene.fields(&scene.run().last, &[FieldSpec::Stress]).swap_remove(0).values
            };
            assert_eq!(stress("viscoelastic"), stress("load"));
            assert_eq!(stress("mullins"), stress("load"));
        }
    }

    #[test]
    fn von_mises_of_tension_and_of_shear() {
        let tension = Mat3::new(3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let shear = Mat3::new(5.0, 2.0, 0.0, 2.0, 5.0, 0.0, 0.0, 0.0, 5.0);
        assert!((von_mises(&tension) - 3.0).abs() < 1e-15);
        assert!((von_mises(&shear) - 2.0 * 3f64.sqrt()).abs() < 1e-15);
    }
}
