//! Constants of laws as inputs of reduced models: equal to the full model where nothing is left out, with derivatives and bars.

use crate::bar::{Bar, Weight};
use crate::common::Random;
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::reduction::{
    ConstantInputs, FullState, Input, ReducedModel, ReductionError, StepError, Training, Twin, errors,
};
use durometer::scene::Scene;
use durometer::solve::Status;
use std::sync::OnceLock;

/// Weight across a bar, μ and ν.
const RANGES: [[f64; 2]; 3] = [[-15.0, 15.0], [40e3, 90e3], [0.45, 0.495]];

/// The weight as an input with its range.
const WEIGHT: Weight = Weight::Input([-15, 15]);

/// The bar at these constants, with 3 mm of its cable drawn in.
fn bar(order: Order, formulation: &str, weight: Weight, [mu, nu]: [f64; 2]) -> Scene {
    let law = format!("law = \"neo_hookean\"\nmu = \"{mu} Pa\"\nnu = {nu}");
    let drive = Some("{ kind = \"length\", signal = \"3 mm\" }");
    Bar { law: &law, formulation, weight, drive, ..Bar::default() }
        .of_points(block(8, 2, 2, 0.04, 0.01, 0.01, order), 1)
}

fn names() -> Vec<String> {
    ["xmax_z_m", "xmax_y_m", "cable_tension_N"].map(String::from).to_vec()
}

/// The full state at these inputs.
fn state(order: Order, formulation: &str, u: &[f64]) -> FullState {
    let run = bar(order, formulation, Weight::Given(u[0]), [u[1], u[2]]).run();
    assert_eq!(run.status, Status::Converged);
    let value = |name: &String| *run.column(name).expect("it is recorded").last().expect("a row");
    FullState {
        inputs: u.to_vec(),
        x: run.last.x.clone(),
        lambda: run.last.lambda.clone(),
        values: names().iter().map(value).collect(),
    }
}

fn states(order: Order, formulation: &str, count: usize, seed: u64) -> Vec<FullState> {
    let mut random = Random::seed(seed);
    let mut point = || RANGES.map(|r| r[0] + random.unit() * (r[1] - r[0]));
    (0..count).map(|_| state(order, formulation, &point())).collect()
}

/// Constants of these keys, and what a training makes of them.
fn with_constants<T>(
    (order, formulation, keys): (Order, &str, &[&str]),
    work: impl FnOnce(&Scene, &ConstantInputs) -> T,
) -> T {
    let middle = [65e3, 0.47];
    let build = |values: &[f64]| Ok::<_, ReductionError>(bar(order, formulation, WEIGHT, [values[0], values[1]]));
    let constants = ConstantInputs {
        keys: keys.iter().map(|key| key.parse().expect("a path")).collect(),
        inputs: ["rubber_mu_Pa", "rubber_nu"]
            .iter()
            .zip(&RANGES[1..])
            .map(|(name, range)| Input::new(*name, *range))
            .collect(),
        build: &build,
    };
    work(&bar(order, formulation, WEIGHT, middle), &constants)
}

const KEYS: [&str; 2] = ["laws.rubber.mu", "laws.rubber.nu"];

/// A model of a nearly incompressible bar with three inputs, and states that it was not made of.
fn trained() -> &'static (ReducedModel, Vec<FullState>) {
    static ALL: OnceLock<(ReducedModel, Vec<FullState>)> = OnceLock::new();
    ALL.get_or_init(|| {
        let of = (Order::Quadratic, "mixed");
        let (known, held_back) = (states(of.0, of.1, 70, 1), states(of.0, of.1, 62, 2));
        let model = with_constants((of.0, of.1, &KEYS), |scene, constants| {
            let training = Training::with_constants(scene, Some(constants), &known, &names());
            training.and_then(|t| t.model(8, Some(1e-3), &held_back)).unwrap_or_else(|e| panic!("{e}"))
        });
        (model, states(of.0, of.1, 100, 3))
    })
}

/// With as many modes as states and all points a state of the training is the full one, whatever its constants: laws and compliances are those of
/// the present constants. The solver leaves 1e-8 of the forces, which bending turns into 1e-6 of the motion at most.
#[test]
fn all_modes_and_all_points_give_the_full_model_at_any_constants() {
    for (order, formulation) in
        [(Order::Linear, "displacement"), (Order::Quadratic, "displacement"), (Order::Quadratic, "mixed")]
    {
        let known = states(order, formulation, 10, 5);
        let model = with_constants((order, formulation, &KEYS), |scene, constants| {
            let training = Training::with_constants(scene, Some(constants), &known, &names());
            training.and_then(|t| t.model(10, None, &[])).unwrap_or_else(|e| panic!("{e}"))
        });
        for (state, row) in known.iter().zip(errors(&model, &known).expect("a law of the library")) {
            for ((error, _), (size, name)) in row.iter().zip(model.largest_changes.iter().zip(names())) {
                assert!(error.abs() < 1e-6 * size, "{formulation} {name}: {error:e} of {size:e} at {:?}", state.inputs);
            }
        }
    }
}

/// 100 further states: bars that are made to contain 95 % with 95 % confidence contain fewer than 89 of 100 once in 200 times (binomial, 95 % − 2.6 σ).
#[test]
fn bars_hold_over_the_ranges_of_the_constants() {
    let (model, fresh) = trained();
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    let mut inside = vec![0; names().len()];
    let mut largest = vec![0.0_f64; names().len()];
    for state in fresh {
        twin.step(&state.inputs).expect("an equilibrium in the ranges");
        for k in 0..names().len() {
            let error = (state.values[k] - twin.values()[k]).abs();
            inside[k] += usize::from(error <= twin.bars()[k]);
            largest[k] = larger(largest[k], error / model.largest_changes[k]);
        }
    }
    println!("inside {inside:?} of {}, largest errors {largest:?}", fresh.len());
    assert!(inside.iter().all(|n| *n >= 89), "{inside:?}");
    assert!(largest.iter().all(|e| *e < 0.02), "{largest:?}");
}

/// Central differences of 1e-4 of the ranges, whose truncation is 1e-8; and of the full model, from which the derivative is as far as the model is: 2 %
/// of the range of a quantity over that of the input.
#[test]
fn derivatives_by_constants_are_those_of_differences() {
    let (model, _) = trained();
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    let at = [6.0, 60e3, 0.47];
    twin.step(&at).expect("an equilibrium");
    let mut exact = vec![0.0; names().len() * 3];
    twin.sensitivities(&mut exact);
    for k in 0..3 {
        let width = RANGES[k][1] - RANGES[k][0];
        let ends = |h: f64| {
            [1.0, -1.0].map(|sign| {
                let mut u = at;
                u[k] += sign * h * width;
                u
            })
        };
        let [plus, minus] = ends(1e-4).map(|u| {
            twin.step(&u).expect("an equilibrium");
            twin.values().to_vec()
        });
        let full = ends(0.05).map(|u| state(Order::Quadratic, "mixed", &u).values);
        for (q, name) in names().iter().enumerate() {
            let unit = model.largest_changes[q] / width;
            let difference = (plus[q] - minus[q]) / (2e-4 * width);
            assert!(
                (exact[3 * q + k] - difference).abs() < 1e-5 * unit,
                "∂{name}/∂u{k}: {} {difference}",
                exact[3 * q + k]
            );
            let difference = (full[0][q] - full[1][q]) / (0.1 * width);
            assert!(
                (exact[3 * q + k] - difference).abs() < 0.02 * unit,
                "full ∂{name}/∂u{k}: {} {difference}",
                exact[3 * q + k]
            );
        }
    }
}

/// The same constants after others give the same bits; a constant that its law does not allow is refused, and the model stays where it was.
#[test]
fn constants_come_back_and_are_checked() {
    let (model, _) = trained();
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    let bits = |twin: &Twin| twin.values().iter().chain(twin.bars()).map(|v| v.to_bits()).collect::<Vec<_>>();
    let mut at = |u: [f64; 3]| {
        twin.reset();
        twin.step(&u).expect("an equilibrium");
        bits(&twin)
    };
    let first = at([3.0, 50e3, 0.46]);
    assert_ne!(at([3.0, 80e3, 0.49]), first);
    assert_eq!(at([3.0, 50e3, 0.46]), first);
    let file = ReducedModel::from_bytes(std::path::Path::new("x"), &model.to_bytes()).expect("sound");
    let mut other = Twin::new(file).expect("a law of the library");
    other.step(&[3.0, 50e3, 0.46]).expect("an equilibrium");
    assert_eq!(bits(&other), first);
    assert_eq!(other.step(&[3.0, 50e3, 0.5]), Err(StepError::Constant(1)));
    assert_eq!(bits(&other), first);
    other.step(&[3.0, 95e3, 0.46]).expect("an equilibrium");
    assert!(!other.in_range() && other.bars().iter().all(|bar| bar.is_infinite()));
}

/// What cannot be an input is refused with the reason.
#[test]
fn constants_that_cannot_be_inputs_are_refused() {
    let why = |order: Order, formulation: &str, keys: [&str; 2]| {
        let known = states(order, formulation, 3, 9);
        with_constants((order, formulation, &keys), |scene, constants| {
            Training::with_constants(scene, Some(constants), &known, &names())
                .map(drop)
                .expect_err("refused")
                .to_string()
        })
    };
    assert!(why(Order::Linear, "mixed", KEYS).contains("stabilisation"));
    assert!(why(Order::Linear, "displacement", ["laws.rubber.E", KEYS[1]]).contains("other constants"));
    assert!(why(Order::Linear, "displacement", ["effect.gravity.density", KEYS[1]]).contains("no constant of a law"));
    assert!(why(Order::Linear, "displacement", ["laws.gel.mu", KEYS[1]]).contains("no such law"));
}
