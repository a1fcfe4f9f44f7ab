//! Adjoint solutions against differences of whole solutions: by loads, and by the gaps of constraints.

use durometer::scene::{Run, Scene, parse_scene};
use durometer::solve::{Integrator, Step, adjoints};
use durometer::system::{Gradient, State, Want};

/// A block that is held at one end, pulled sideways at the other and by a cable, with a prescribed side.
fn scene(traction: f64, pull_mm: f64, formulation: &str) -> Scene {
    let text = format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [\"30 mm\", \"10 mm\", \"10 mm\"], divisions = [3, 1, 1] }}\nelement = \"tet10\"\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\nformulation = \"{formulation}\"\n\
         [[effect]]\nkind = \"traction\"\nregion = \"ymax\"\ndirection = [0, 0, 1]\n\
         traction = {{ kind = \"ramp\", from = \"0 Pa\", to = \"{traction} Pa\", start = \"0 s\", end = \"1 s\" }}\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
         [[constraint]]\nkind = \"cable\"\nname = \"tendon\"\nguides = [[\"28 mm\", \"5 mm\", \"8 mm\"], [\"15 mm\", \"5 mm\", \"8 mm\"]]\n\
         guide_radius = \"2 mm\"\npull_point = [\"-5 mm\", \"5 mm\", \"8 mm\"]\n\
         drive = {{ kind = \"length\", signal = {{ kind = \"ramp\", from = \"0 mm\", to = \"{pull_mm} mm\", start = \"0 s\", end = \"1 s\" }} }}\n\
         [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n[[probe]]\nkind = \"reaction\"\nregion = \"xmin\"\n\
         [[probe]]\nkind = \"bending_angle\"\nroot = \"xmin\"\ntip = \"xmax\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.25 s\"\n\
         [numerics]\ntolerance = 1e-12\n"
    );
    parse_scene(&text).expect("a scene")
}

/// A run and its last state.
fn solved(scene: &Scene) -> (Run, State) {
    let mut last = None;
    let mut keep = |state: &State| last = Some(state.clone());
    let options = durometer::scene::RunOptions { on_state: Some(&mut keep), ..Default::default() };
    let run = scene.run_with(options);
    (run, last.expect("a state"))
}

/// dJ/dp by the adjoint is −z·∂r/∂p + μ·∂g/∂p. The load p enters r linearly and the shortening g, so that both are differences without
/// an error. Central differences of J with a step of 1 % of the load leave 1e-4 of the derivative, and the
/// tolerance 1e-12 of the solver less than that.
#[test]
fn derivatives_by_loads_and_gaps() {
    for formulation in ["displacement", "mixed"] {
        let (traction, pull) = (300.0, 3.0);
        let here = scene(traction, pull, formulation);
        let (run, state) = solved(&here);
        let recorders = here.with_memories(run.memories.last().expect("rows"));
        let gradients: Vec<Gradient> = recorders
            .flat_map(|(r, memory)| r.gradients(&here.body, &state, memory))
            .map(|gradient| gradient.expect("differentiable"))
            .collect();
        let step = Step { system: &here.system, integrator: Integrator::Static, past: &state, dt: 1.0 };
        let dual = adjoints(here.method(), &step, &state, &gradients).expect("regular");

        let residual = |traction: f64| {
            let scene = scene(traction, pull, formulation);
            let mut sums = scene.system.workspace();
            let step = Step { system: &scene.system, integrator: Integrator::Static, past: &state, dt: 1.0 };
            let found = scene.system.assemble(&step.at(&state), &state.lambda, Want::Residual, None, &mut sums);
            found.expect("regular");
            sums.r
        };
        let by_traction: Vec<f64> =
            residual(traction + 1.0).iter().zip(residual(traction)).map(|(a, b)| a - b).collect();

        let gap = |pull: f64| scene(traction, pull, formulation).system.gaps(&state).expect("regular")[0];
        let by_pull = gap(pull + 1.0) - gap(pull);

        let difference = |k: usize, change: [f64; 2]| {
            let value = |sign: f64| {
                let (run, _) = solved(&scene(traction + sign * change[0], pull + sign * change[1], formulation));
                run.rows.last().expect("rows")[1 + k]
            };
            (value(1.0) - value(-1.0)) / 2.0
        };
        let columns = here.columns();
        for (k, (adjoint, gradient)) in dual.iter().zip(&gradients).enumerate() {
            let name = &columns[1 + k];
            let close = |found: f64, exact: f64, what: &str| {
                println!("{formulation} {name} by {what}: {found:.8e}, difference {exact:.8e}");
                assert!(
                    (found - exact).abs() <= 1e-4 * exact.abs() + 1e-12,
                    "{formulation} {name} by {what}: {found} and {exact}"
                );
            };
            let along: f64 = adjoint.z.iter().zip(&by_traction).map(|(z, r)| z * r).sum();
            // A traction on a prescribed part of the surface is a reaction too.
            let direct: f64 = gradient.reaction.iter().map(|(dof, weight)| weight * by_traction[*dof as usize]).sum();
            close(direct - along, difference(k, [3.0, 0.0]) / 3.0, "traction");
            close(adjoint.mu[0] * by_pull, difference(k, [0.0, 0.03]) / 0.03, "shortening");
        }
    }
}
