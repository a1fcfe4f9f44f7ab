//! Bodies of nanometres and kilometres, moduli of 1e-30 and 1e30 Pa: the dimensionless results are equal.

use crate::common::column;
use durometer::math::statistics::larger;
use durometer::scene::{Run, parse_scene};
use durometer::solve::Status;

/// Lengths of the body [m] and moduli [Pa].
const LENGTHS: [f64; 6] = [1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6];
const MODULI: [f64; 7] = [1e-30, 1e-15, 1.0, 1e5, 1e12, 1e20, 1e30];

/// A block of this length and modulus, loaded in this way. Times are in units of a second: the density is E s²/L².
fn text(length: f64, modulus: f64, load: &str, integrator: &str) -> String {
    let density = 1e-3 * modulus / (length * length);
    let inertia = match integrator {
        "static" => String::new(),
        _ => format!(
            "[[effect]]\nkind = \"inertia\"\nregion = \"body\"\nmass = \"consistent\"\ndensity = \"{density:e} kg/m^3\"\n"
        ),
    };
    let l = |x: f64| format!("\"{:e} m\"", x * length);
    let load = match load {
        "motion" => format!(
            "[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"xz\"\n\
             displacement = {{ kind = \"ramp\", from = \"0 m\", to = {}, end = \"1 s\" }}\n",
            l(0.2)
        ),
        "traction" => format!(
            "[[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [0, 0, 1]\n\
             traction = {{ kind = \"ramp\", from = \"0 Pa\", to = \"{:e} Pa\", end = \"1 s\" }}\n",
            3e-3 * modulus
        ),
        "patch" => format!(
            "[[effect]]\nkind = \"point_force\"\npoint = [{}, {}, {}]\nradius = {}\ndirection = [0, 0, 1]\n\
             force = {{ kind = \"ramp\", from = \"0 N\", to = \"{:e} N\", end = \"1 s\" }}\n",
            l(0.9),
            l(0.1),
            l(0.1),
            l(0.08),
            1e-4 * modulus * length * length
        ),
        _ => format!(
            "[[constraint]]\nkind = \"cable\"\npull_point = [{}, {}, {}]\nguides = [[{}, {}, {}], [{}, {}, {}]]\nguide_radius = {}\n\
             drive = {{ kind = \"tension\", signal = {{ kind = \"ramp\", from = \"0 N\", to = \"{:e} N\", end = \"1 s\" }} }}\n",
            l(-0.2),
            l(0.1),
            l(0.05),
            l(0.3),
            l(0.1),
            l(0.05),
            l(0.8),
            l(0.1),
            l(0.05),
            l(0.06),
            2e-4 * modulus * length * length
        ),
    };
    format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [{}, {}, {}], divisions = [4, 1, 1] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"{modulus:e} Pa\"\nnu = 0.4\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n{inertia}\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n{load}\
         [[stage]]\nintegrator = \"{integrator}\"\nduration = \"1 s\"\ndt = \"0.25 s\"\n\
         [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n[[probe]]\nkind = \"reaction\"\nregion = \"xmin\"\n",
        l(1.0),
        l(0.2),
        l(0.2)
    )
}

/// Displacement by L and reaction by E L² at the end.
fn numbers(run: &Run, length: f64, modulus: f64) -> Vec<f64> {
    let last = |name: &str| *column(run, name).last().expect("a row");
    let names: Vec<String> = run.columns.clone();
    let scaled = |name: &String| match name {
        _ if name.ends_with("_m") => Some(last(name) / length),
        _ if name.ends_with("_N") => Some(last(name) / (modulus * length * length)),
        _ => None,
    };
    names.iter().filter_map(scaled).collect()
}

/// Newton stops at a relative residual of 1e-8: the results of one problem in other units differ by about that of the largest.
#[test]
fn results_do_not_depend_on_units() {
    let (mut solved, mut refused) = (0, vec![]);
    for integrator in ["static", "implicit_euler"] {
        for load in ["motion", "traction", "patch", "cable"] {
            let solve = |length: f64, modulus: f64| -> Result<Vec<f64>, String> {
                let scene = parse_scene(&text(length, modulus, load, integrator)).map_err(|e| e.to_string())?;
                let run = scene.run();
                if run.status == Status::Converged {
                    Ok(numbers(&run, length, modulus))
                } else {
                    Err(run.status.to_string())
                }
            };
            let base = solve(0.1, 1e5).unwrap_or_else(|e| panic!("{integrator} {load}: {e}"));
            let largest = base.iter().map(|x| x.abs()).fold(0.0, larger);
            assert!(largest.is_finite() && largest > 0.0 && base.len() >= 6, "{base:?}");
            for length in LENGTHS {
                for modulus in MODULI {
                    match solve(length, modulus) {
                        Ok(found) => {
                            let far = found.iter().zip(&base).map(|(a, b)| (a - b).abs()).fold(0.0, larger);
                            assert!(
                                far < 1e-5 * largest,
                                "{integrator} {load} {length:e} m {modulus:e} Pa: {found:?} {base:?}"
                            );
                            solved += 1;
                        }
                        Err(why) => refused.push(format!("{integrator} {load} {length:e} m {modulus:e} Pa: {why}")),
                    }
                }
            }
        }
    }
    println!("{solved} equal");
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}
