//! Stress fields of materials with a history: they carry the reactions.

use crate::common::{column, run_with_states, scene};
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::output::FieldSpec;
use durometer::system::State;

/// A cube of 10 mm that is sheared along x and held in y and z: one deformation everywhere.
const CUBE: &str = r#"
[mesh]
body = "cube"
[laws.rubber]
law = "neo_hookean_split"
mu = "100 kPa"
nu = 0.49
volumetric = "quadratic"
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "zmin"
components = "x"
[[constraint]]
kind = "fixed"
region = "body"
components = "yz"
[[constraint]]
kind = "prescribed"
region = "zmax"
components = "x"
displacement = { kind = "points", of = [[0, 0], [0.5, 5], [1, 2.5]], unit = "mm" }
[[probe]]
kind = "reaction"
region = "zmax"
"#;

const RELAXING: &str = r#"
[[effect]]
kind = "viscoelastic"
region = "body"
law = "rubber"
moduli = "MODULI"
prony = [{ g = 0.5, tau = "0.1 s" }, { g = 0.2, tau = "10 s" }]
"#;

const SOFTENING: &str = r#"
[[effect]]
kind = "mullins"
region = "body"
law = "rubber"
softening = { r = 2, m = "0 Pa", beta = 0.1 }
"#;

/// The law of small strains: what its field says is C:ε, symmetric and μγ, at a shear of 50 %.
#[test]
fn the_stress_of_small_strains_is_symmetric() {
    let linear = CUBE.replace("neo_hookean_split", "linear").replace("volumetric = \"quadratic\"\n", "");
    let stage = "[[stage]]\nintegrator = \"static\"\nduration = \"0.5 s\"\ndt = \"0.5 s\"\n";
    let scene = scene(block(1, 1, 2, 0.01, 0.01, 0.01, Order::Linear), &format!("{linear}{stage}"));
    let mut fields = Vec::new();
    run_with_states(&scene, &mut |state: &State| fields = scene.fields(state, &[FieldSpec::Stress]));
    let of_cells = fields.iter().find(|field| field.values.len() == 9 * scene.body.mesh.cell_count());
    for sigma in of_cells.expect("a stress of each cell").values.chunks_exact(9) {
        let expected = [0.0, 0.0, 5e4, 0.0, 0.0, 0.0, 5e4, 0.0, 0.0];
        assert!(sigma.iter().zip(expected).all(|(own, right)| (own - right).abs() < 1e-3), "{sigma:?}");
    }
}

/// The mean of J σ_xz over the cells, which have one volume, is the force by the area: virtual work of a displacement along x in proportion to z, where y
/// and z are held everywhere. J is within γ²μ/κ = 5e-3 of 1, at every state of loading, unloading and relaxation.
#[test]
fn shear_stress_by_area_is_the_reaction() {
    let [instantaneous, long_term] = ["instantaneous", "long_term"].map(|moduli| RELAXING.replace("MODULI", moduli));
    // A part of the stress has to remain.
    let both = format!("{}{SOFTENING}", instantaneous.replace("g = 0.5", "g = 0.2"));
    for (name, effects) in [
        ("instantaneous", instantaneous.as_str()),
        ("long-term", long_term.as_str()),
        ("softening", SOFTENING),
        ("both", both.as_str()),
    ] {
        for integrator in ["implicit_euler", "static"] {
            let rates = effects.contains("viscoelastic");
            if integrator == "implicit_euler" || !rates {
                check(&format!("{name}, {integrator}"), effects, integrator);
            }
        }
    }
}

fn check(label: &str, effects: &str, integrator: &str) {
    let stage = format!("[[stage]]\nintegrator = \"{integrator}\"\nduration = \"1 s\"\ndt = \"50 ms\"\n");
    let scene = scene(block(1, 1, 2, 0.01, 0.01, 0.01, Order::Linear), &format!("{CUBE}{effects}{stage}"));
    let mut fields = Vec::new();
    let run = run_with_states(&scene, &mut |state: &State| fields.push(scene.fields(state, &[FieldSpec::Stress])));
    let forces = column(&run, "zmax_reaction_x_N");
    let most = forces.iter().fold(0.0, |most, force| larger(most, force.abs()));
    assert_eq!((forces.len(), fields.len()), (21, 21), "{label}");
    for (force, fields) in forces.iter().zip(&fields) {
        let cells = scene.body.mesh.cell_count();
        let of_cells = fields.iter().find(|field| field.values.len() == 9 * cells).expect("a stress of each cell");
        let mean = of_cells.values.chunks_exact(9).map(|sigma| sigma[2]).sum::<f64>() / cells as f64;
        assert!((mean * 1e-4 - force).abs() < 1e-2 * most, "{label}: {mean} Pa for {force} N");
    }
}
