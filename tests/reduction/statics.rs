//! Reduced models: equal to the full model where nothing is left out, near to it where little is, with bars that hold.

use crate::bar::{self, Bar, SOFT};
use crate::common::{Random, scene};
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::reduction::running::inverse::{Target, reach};
use durometer::reduction::training::adjoint_space::adjoint_solutions;
use durometer::reduction::training::body_points::BodyPoints;
use durometer::reduction::{FullState, ReducedModel, StepError, Training, Twin, errors};
use durometer::scene::Scene;
use std::path::Path;
use std::sync::OnceLock;

fn bar(order: Order, formulation: &str, points: usize, law: &str) -> Scene {
    Bar { law, formulation, ..Bar::default() }.of_points(block(8, 2, 2, 0.04, 0.01, 0.01, order), points)
}

const NEARLY_INCOMPRESSIBLE: &str = "law = \"neo_hookean\"\nmu = \"60 kPa\"\nnu = 0.499";
/// Inputs are the acceleration, then the shortening: the order of the scene.
const RANGES: [[f64; 2]; 2] = [[-20.0, 20.0], [0.0, 4e-3]];

/// The states of the full model at these points.
fn states(build: impl Fn(usize) -> Scene, points: Vec<Vec<f64>>, names: &[String]) -> Vec<FullState> {
    bar::states(&build(points.len()), &points, names)
}

/// Random points in the ranges, along a way of short steps.
fn points(count: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = Random::seed(seed);
    let mut at = |range: [f64; 2]| range[0] + random.unit() * (range[1] - range[0]);
    let mut all: Vec<Vec<f64>> = (0..count).map(|_| RANGES.map(&mut at).to_vec()).collect();
    all.sort_by(|a, b| a[1].total_cmp(&b[1]));
    all
}

fn names() -> Vec<String> {
    ["xmax_z_m", "bending_angle_deg", "cable_tension_N", "cable_length_m"].map(String::from).to_vec()
}

/// States of the nearly incompressible bar for training and held back, and a model of them.
fn trained() -> &'static (Scene, Vec<FullState>, Vec<FullState>, ReducedModel) {
    static ALL: OnceLock<(Scene, Vec<FullState>, Vec<FullState>, ReducedModel)> = OnceLock::new();
    ALL.get_or_init(|| {
        let build = |n: usize| bar(Order::Quadratic, "mixed", n, NEARLY_INCOMPRESSIBLE);
        let (known, others) = (states(build, points(60, 1), &names()), states(build, points(62, 2), &names()));
        let scene = build(1);
        let model = Training::new(&scene, &known, &names())
            .and_then(|t| t.model(8, Some(1e-3), &others))
            .unwrap_or_else(|e| panic!("{e}"));
        (scene, known, others, model)
    })
}

/// A cavity that no pressure ever acts in tells its volume, like one with a pressure: both are exact with all modes and all points, as in
/// [`all_modes_and_all_points_give_the_full_model`].
#[test]
fn the_volume_of_a_cavity_without_pressure_follows_the_body() {
    let held: String = ["y", "z"]
        .iter()
        .flat_map(|axis| ["min", "max"].map(|side| (axis, side)))
        .map(|(a, side)| format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{a}{side}\"\ncomponents = \"{a}\"\n"))
        .collect();
    let build = |pressure: &str, points: usize| {
        let text = format!(
            "[mesh]\nbody = \"block\"\n[laws.rubber]\nlaw = \"neo_hookean\"\nmu = \"100 kPa\"\nnu = 0.3\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[effect]]\nkind = \"traction\"\nregion = \"xmax\"\ndirection = [1, 0, 0]\n\
             traction = {{ kind = \"controlled\", initial = \"0 Pa\", range = [\"-20 kPa\", \"20 kPa\"] }}\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n{held}\
             [[constraint]]\nkind = \"cavity\"\nname = \"gas\"\nregion = \"xmax\"\n\
             drive = {{ kind = \"pressure\", signal = \"{pressure}\" }}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"{points} s\"\ndt = \"1 s\"\n\
             [[probe]]\nkind = \"position\"\nregion = \"xmax\"\n"
        );
        scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Quadratic), &text)
    };
    let names = ["gas_volume_m3", "xmax_x_m"].map(String::from);
    for pressure in ["0 Pa", "1 Pa"] {
        let tractions = [-20e3, -12e3, -5e3, 4e3, 11e3, 20e3].map(|traction| vec![traction]).to_vec();
        let known = states(|n| build(pressure, n), tractions, &names);
        let scene = build(pressure, 1);
        let training = Training::new(&scene, &known, &names).unwrap_or_else(|e| panic!("{e}"));
        let model = training.model(6, None, &[]).unwrap_or_else(|e| panic!("{e}"));
        for (state, row) in known.iter().zip(errors(&model, &known).expect("a law of the library")) {
            for ((error, _), size) in row.iter().zip(&model.largest_changes) {
                assert!(error.abs() < 1e-6 * size, "{pressure}: {row:?} at {:?}", state.inputs);
            }
        }
    }
}

/// With as many modes as the states have, at a state of the training, and with all points, a reduced equilibrium is the full one: the
/// solver leaves 1e-8 of the forces, which bending turns into 1e-6 of the motion at most.
#[test]
fn all_modes_and_all_points_give_the_full_model() {
    for (order, formulation, law) in [
        (Order::Linear, "displacement", SOFT),
        (Order::Quadratic, "displacement", SOFT),
        (Order::Quadratic, "mixed", NEARLY_INCOMPRESSIBLE),
    ] {
        let build = |n: usize| bar(order, formulation, n, law);
        let known = states(build, points(12, 3), &names());
        let scene = build(1);
        let training = Training::new(&scene, &known, &names()).unwrap_or_else(|e| panic!("{e}"));
        let model = training.model(12, None, &[]).unwrap_or_else(|e| panic!("{e}"));
        let sizes = &model.largest_changes;
        for (state, row) in known.iter().zip(errors(&model, &known).expect("a law of the library")) {
            for ((error, _), (size, name)) in row.iter().zip(sizes.iter().zip(names())) {
                assert!(error.abs() < 1e-6 * size, "{formulation} {name}: {error:e} of {size:e} at {:?}", state.inputs);
            }
        }
    }
}

/// A traction and a cavity of one name act on the end of a block between walls.
#[test]
fn the_pressure_of_a_cavity_is_not_that_of_a_load_of_its_name() {
    let walls = ["y", "z"].map(|axis| {
        let wall = |end: &str| {
            format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{axis}{end}\"\ncomponents = \"{axis}\"\n")
        };
        wall("min") + &wall("max")
    });
    let walls = walls.concat();
    let build = |points: usize| {
        let text = format!(
            r#"
[mesh]
body = "block"
[laws.rubber]
{SOFT}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "traction"
name = "air"
region = "xmax"
direction = [0, 0, -1]
traction = "50 Pa"
[[constraint]]
kind = "fixed"
region = "xmin"
{walls}
[[constraint]]
kind = "cavity"
name = "air"
region = "xmax"
drive = {{ kind = "pressure", signal = {{ kind = "controlled", initial = "0 Pa", range = ["0 Pa", "4 kPa"] }} }}
[[stage]]
integrator = "static"
duration = "{points} s"
dt = "1 s"
"#
        );
        scene(block(2, 2, 2, 0.01, 0.01, 0.01, Order::Quadratic), &text)
    };
    let names = ["air_pressure_Pa".to_string()];
    let known = states(build, (1..=8).map(|k| vec![500.0 * f64::from(k)]).collect(), &names);
    let scene = build(1);
    let model =
        Training::new(&scene, &known, &names).and_then(|t| t.model(2, None, &[])).unwrap_or_else(|e| panic!("{e}"));
    for row in errors(&model, &known).expect("a law of the library") {
        assert!(row[0].0.abs() < 1e-9, "{row:?} Pa");
    }
}

/// Few modes and points are near to states that the model has not seen, and nearer with more of them.
#[test]
fn errors_fall_with_modes_and_points() {
    let (scene, known, others, _) = trained();
    let training = Training::new(scene, known, &names()).unwrap_or_else(|e| panic!("{e}"));
    let largest = |modes: usize, sampling: f64| {
        let model = training.model(modes, Some(sampling), &[]).unwrap_or_else(|e| panic!("{e}"));
        let points: usize = model.points.iter().map(|p| p.weights.len()).sum();
        let all = errors(&model, others).expect("a law of the library");
        let of = |k: usize| all.iter().map(|row| row[k].0.abs() / model.largest_changes[k]).fold(0.0, larger);
        ((0..names().len()).map(of).fold(0.0, larger), points)
    };
    let [(coarse, few), (fine, more)] = [largest(3, 1e-2), largest(8, 1e-3)];
    println!("3 modes, {few} points: {coarse:.1e}; 8 modes, {more} points: {fine:.1e}");
    assert!(fine < 0.01 && fine < 0.2 * coarse && few < more, "{coarse:e} {fine:e} {few} {more}");
    assert!(more < known[0].x.len() / 10, "{more} points of {}", known[0].x.len());
}

/// A body of ν = 0.499 bends in the reduced space as it does in the full one: it does not lock, and its pressures are determined.
#[test]
fn pressures_neither_lock_nor_are_lost() {
    let (_, _, others, model) = trained();
    assert!(model.sizes.pressures > 0 && model.sizes.displacements >= 2 * model.sizes.pressures);
    let all = errors(model, others).expect("a law of the library");
    let angle = all.iter().map(|row| row[1].0.abs()).fold(0.0, larger);
    assert!(angle < 0.01 * model.largest_changes[1], "{angle} of {}", model.largest_changes[1]);
}

/// 200 states that neither the modes nor the bars have seen: the bars are made to contain 95 % with 95 % confidence, so that fewer than 91 %
/// of 200 happen once in 200 (binomial, 95 % − 2.6 σ). The estimates follow the errors, and the bars are no wider than five errors in the median.
#[test]
fn bars_contain_the_error_and_are_not_wide() {
    let (_, _, _, model) = trained();
    let build = |n: usize| bar(Order::Quadratic, "mixed", n, NEARLY_INCOMPRESSIBLE);
    let fresh = states(build, points(200, 7), &names());
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    let mut inside = vec![0; names().len()];
    let mut ratios = vec![vec![]; names().len()];
    for state in &fresh {
        twin.step(&state.inputs).expect("an equilibrium in the ranges");
        for k in 0..names().len() {
            let (error, bar) = ((state.values[k] - twin.values()[k]).abs(), twin.bars()[k]);
            inside[k] += usize::from(error <= bar);
            ratios[k].push(bar / error);
        }
    }
    for (k, name) in names().iter().enumerate() {
        ratios[k].sort_by(f64::total_cmp);
        let median = ratios[k][fresh.len() / 2];
        println!("{name}: {} of {} inside, bar/error {median:.1} in the median", inside[k], fresh.len());
        assert!(inside[k] >= 182, "{name}: {} of {}", inside[k], fresh.len());
        // The length of a taut cable is exact: its error is what the solver leaves
        assert!(median < 5.0 || name == "cable_length_m", "{name}: {median}");
    }
}

/// Central differences of 1e-4 of the ranges: their truncation is 1e-8, and the equilibria are known to 1e-10.
#[test]
fn sensitivities_are_those_of_differences() {
    let (_, _, _, model) = trained();
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    let at = [7.0, 2.5e-3];
    let mut exact = vec![0.0; names().len() * 2];
    // The body at rest is not in equilibrium under its inputs before a step
    twin.sensitivities(&mut exact);
    assert!(exact.iter().all(|d| d.is_nan()), "{exact:?}");
    let rest = twin.save();
    twin.step(&at).expect("an equilibrium");
    let there = twin.save();
    twin.restore(&rest);
    twin.sensitivities(&mut exact);
    assert!(exact.iter().all(|d| d.is_nan()), "{exact:?}");
    twin.restore(&there);
    twin.sensitivities(&mut exact);
    for k in 0..2 {
        let h = 1e-4 * (RANGES[k][1] - RANGES[k][0]);
        let mut value = |sign: f64| {
            let mut u = at;
            u[k] += sign * h;
            twin.step(&u).expect("an equilibrium");
            twin.values().to_vec()
        };
        let (plus, minus) = (value(1.0), value(-1.0));
        for (q, name) in names().iter().enumerate() {
            let difference = (plus[q] - minus[q]) / (2.0 * h);
            let size = model.largest_changes[q] / (RANGES[k][1] - RANGES[k][0]);
            let error = (exact[2 * q + k] - difference).abs();
            assert!(error < 1e-5 * size, "∂{name}/∂u{k}: {} and {difference}", exact[2 * q + k]);
        }
    }
}

/// Inputs for an angle and a height; an angle that the ranges do not contain ends at their edge.
#[test]
fn inputs_are_found_for_targets() {
    let (_, _, _, model) = trained();
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    twin.step(&[-6.0, 3e-3]).expect("an equilibrium");
    let wanted = [twin.values()[1], twin.values()[0]];
    twin.reset();
    let target =
        |quantity: usize, value: f64| Target { quantity, value, tolerance: 1e-6 * model.largest_changes[quantity] };
    let found = reach(&mut twin, &[target(1, wanted[0]), target(0, wanted[1])]).expect("an equilibrium");
    assert!(found.met, "{found:?}");
    // An input that is held begins at the value of the scene, and the search leaves it there
    let mut held = model.clone();
    (held.inputs[0].held, held.inputs[0].start) = (true, Some(5.0));
    let mut other = Twin::new(held).expect("a law of the library");
    assert_eq!(other.inputs(), [5.0, 0.0]);
    let found = reach(&mut other, &[target(1, wanted[0])]).expect("an equilibrium");
    assert_eq!(found.inputs[0], 5.0, "{found:?}");
    // Where every input is held a search moves all of them
    let mut all = model.clone();
    all.inputs.iter_mut().for_each(|input| input.held = true);
    assert_eq!(all.driving(), [true, true]);
    let beyond = reach(&mut twin, &[target(1, 10.0 * model.largest_changes[1])]).expect("an equilibrium");
    assert!(!beyond.met && twin.in_range(), "{beyond:?}");
}

/// 4 000 random inputs, half of them up to twice the ranges away: each step ends, with finite numbers or with a reason, and
/// says whether it is in range; the first 800 of them, replayed, give the same bits.
#[test]
fn any_input_ends_and_is_replayed() {
    let (_, _, _, model) = trained();
    let mut random = Random::seed(11);
    let mut draw = |k: usize| {
        let (centre, half) = (0.5 * (RANGES[k][0] + RANGES[k][1]), 0.5 * (RANGES[k][1] - RANGES[k][0]));
        centre + random.around(2.0 * half)
    };
    let inputs: Vec<[f64; 2]> = (0..4_000).map(|_| [draw(0), draw(1)]).collect();
    let run = |inputs: &[[f64; 2]]| {
        let mut twin = Twin::new(model.clone()).expect("a law of the library");
        let step = |u: &[f64; 2]| {
            let done = twin.step(u);
            assert!(twin.values().iter().all(|v| v.is_finite()));
            if done.is_ok() {
                let inside = (0..2).all(|k| (RANGES[k][0]..=RANGES[k][1]).contains(&u[k]));
                assert_eq!(twin.in_range(), inside);
                assert!(inside || twin.bars().iter().all(|bar| bar.is_infinite()));
                assert!(!inside || twin.bars().iter().all(|bar| !bar.is_nan()));
            }
            (done, twin.values().iter().map(|v| v.to_bits()).collect::<Vec<_>>())
        };
        inputs.iter().map(step).collect::<Vec<_>>()
    };
    let first = run(&inputs);
    assert!(first.iter().filter(|(done, _)| done.is_ok()).count() > 3_800);
    assert_eq!(first[..800], run(&inputs[..800]));
    let mut twin = Twin::new(model.clone()).expect("a law of the library");
    assert_eq!(twin.step(&[f64::NAN, 0.0]), Err(StepError::NotFinite(0)));
    assert_eq!(twin.step(&[0.0]), Err(StepError::Count { given: 1, wanted: 2 }));
}

/// A file gives the model back bit for bit; one that is cut, changed in any byte, or of another format is refused with a reason.
#[test]
fn a_file_is_the_model_or_is_refused() {
    let (_, _, _, model) = trained();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("bar.durom");
    let size = model.write(&file).expect("room");
    assert_eq!(ReducedModel::read(&file).expect("sound"), *model);
    let bytes = model.to_bytes();
    assert_eq!(bytes.len(), size);
    let refused = |bytes: &[u8]| ReducedModel::from_bytes(Path::new("x"), bytes).expect_err("refused").to_string();
    let end = bytes.iter().position(|b| *b == b'\n').expect("a first line");
    for cut in [0, 10, end, end + 1, bytes.len() / 2, bytes.len() - 1] {
        let why = refused(&bytes[..cut]);
        assert!(why.contains("no reduced model") || why.contains("damaged"), "{cut}: {why}");
    }
    let mut random = Random::seed(5);
    for _ in 0..200 {
        let mut other = bytes.clone();
        let place = end + 1 + (random.unit() * (bytes.len() - end - 1) as f64) as usize;
        other[place] ^= 1 << (random.unit() * 8.0) as u32;
        assert!(refused(&other).contains("damaged"));
    }
    let newer = [b"durometer reduced model 99 ", &bytes[end - 64..]].concat();
    assert!(refused(&newer).contains("format 99"));
    assert!(ReducedModel::read(&folder.path().join("none.durom")).is_err());
    // Nothing is written that could not be read
    let file = folder.path().join("unusable.durom");
    let is_refused = |unusable: ReducedModel, fact: &str| {
        let why = unusable.write(&file).expect_err("refused").to_string();
        assert!(why.contains(fact) && !file.exists(), "{why}");
    };
    let mut unusable = model.clone();
    unusable.estimate.as_mut().expect("an estimate").bars[0].factor = f64::INFINITY;
    is_refused(unusable, "an error bar is not a finite number");
    let mut unusable = model.clone();
    unusable.inputs[0].start = Some(f64::NAN);
    is_refused(unusable, "its start not finite");
}

/// Parts of a scene without a reduced form are named, with a remedy.
#[test]
fn what_is_not_reduced_is_refused() {
    let (_, known, _, _) = trained();
    let dynamic = bar(Order::Quadratic, "mixed", 1, NEARLY_INCOMPRESSIBLE);
    let mean = bar(Order::Quadratic, "mean_dilatation", 1, NEARLY_INCOMPRESSIBLE);
    let why = |scene: &Scene, names: &[String]| match Training::new(scene, known, names).map(|t| t.model(2, None, &[]))
    {
        Ok(Ok(_)) => String::new(),
        Ok(Err(why)) | Err(why) => why.to_string(),
    };
    let words = why(&mean, &names());
    assert!(words.contains("mixed") || words.contains("unknowns"), "{words}");
    // A hundred times beyond the ranges there is no equilibrium, and a bar without a bound is none
    let (scene, _, others, _) = trained();
    let beyond = |s: &FullState| FullState { inputs: s.inputs.iter().map(|u| 100.0 * u).collect(), ..s.clone() };
    let others: Vec<FullState> = others.iter().map(beyond).collect();
    let made = Training::new(scene, known, &names()).and_then(|t| t.model(2, Some(1e-3), &others));
    let words = made.expect_err("no equilibrium").to_string();
    assert!(words.contains("no equilibrium") && words.contains("held back"), "{words}");
    let words = why(&dynamic, &["none_m".into()]);
    assert!(words.contains("none_m") && words.contains("bending_angle_deg"), "{words}");
}

/// A slender bar that a cable winds up by 300°.
fn winding(points: usize) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
mu = "100 kPa"
nu = 0.3
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["2 mm", "3 mm", "5 mm"], ["18 mm", "3 mm", "5 mm"], ["34 mm", "3 mm", "5 mm"], ["50 mm", "3 mm", "5 mm"], ["66 mm", "3 mm", "5 mm"], ["82 mm", "3 mm", "5 mm"], ["98 mm", "3 mm", "5 mm"]]
pull_point = ["-10 mm", "3 mm", "5 mm"]
guide_radius = "2.5 mm"
drive = {{ kind = "length", signal = {{ kind = "controlled", initial = "0 mm", range = ["0 mm", "26 mm"] }} }}
[[stage]]
integrator = "static"
duration = "{points} s"
dt = "1 s"
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
"#
    );
    scene(block(20, 2, 2, 0.1, 0.006, 0.006, Order::Linear), &text)
}

/// An angle without an axis is known up to its half turn, which the recorded value tells: at one state the adjoint solutions of an angle beyond 180° and of the angle that is
/// as far below are opposite.
#[test]
fn adjoint_solutions_are_of_the_recorded_half_turn() {
    let names = vec!["bending_angle_deg".to_string()];
    let along = (1..=40).map(|k| vec![26e-3 * f64::from(k) / 40.0]).collect();
    let known = states(winding, along, &names);
    let turned = known.into_iter().find(|state| state.values[0] > 195.0).expect("it winds up by 300°");
    let folded = FullState { values: vec![360.0 - turned.values[0]], ..turned.clone() };
    let scene = winding(1);
    let points = BodyPoints::of(&scene).unwrap_or_else(|e| panic!("{e}"));
    let found = adjoint_solutions((&scene, &points), (None, 1), &[turned, folded], &names);
    let found = found.unwrap_or_else(|e| panic!("{e}")).solutions;
    let [turned, folded] = &found[0][..] else { panic!("two states") };
    let largest = |of: &mut dyn Iterator<Item = f64>| of.map(f64::abs).fold(0.0, larger);
    let size = largest(&mut turned.iter().copied());
    let sum = largest(&mut turned.iter().zip(folded).map(|(a, b)| a + b));
    assert!(size > 0.0 && sum < 1e-9 * size, "{sum} of {size}");
}

/// Turns are counted, and the equilibrium is found, whatever the inputs before: from rest, in small steps, and from the other end of the range.
#[test]
fn the_way_to_the_inputs_does_not_matter() {
    let names = vec!["bending_angle_deg".to_string()];
    let along = |count: usize, from: f64| (0..count).map(|k| vec![26e-3 * (k as f64 + from) / count as f64]).collect();
    let (known, others) = (states(winding, along(40, 1.0), &names), states(winding, along(40, 0.5), &names));
    let model = Training::new(&winding(1), &known, &names)
        .and_then(|t| t.model(6, Some(1e-3), &others))
        .unwrap_or_else(|e| panic!("{e}"));
    let mut twin = Twin::new(model).expect("a law of the library");
    let mut slowly = |u: f64| {
        twin.reset();
        for k in 1..=60 {
            twin.step(&[u * f64::from(k) / 60.0]).expect("an equilibrium");
        }
        twin.values()[0]
    };
    let random = &mut Random::seed(5);
    let inputs: Vec<f64> =
        [26e-3, 0.0, 22e-3, 5e-3, 0.0].into_iter().chain((0..40).map(|_| 26e-3 * random.unit())).collect();
    let expected: Vec<f64> = inputs.iter().map(|u| slowly(*u)).collect();
    assert!(expected[0] > 270.0, "{expected:?}");
    twin.reset();
    for (u, expected) in inputs.iter().zip(&expected) {
        twin.step(&[*u]).expect("an equilibrium");
        assert!((twin.values()[0] - expected).abs() < 1e-3, "{u}: {} in place of {expected}", twin.values()[0]);
    }
    for (u, expected) in inputs.iter().zip(&expected) {
        twin.reset();
        twin.step(&[*u]).expect("an equilibrium");
        assert!(
            (twin.values()[0] - expected).abs() < 1e-3,
            "{u} from rest: {} in place of {expected}",
            twin.values()[0]
        );
    }
    // A load that the scene has at its start comes in parts too: at rest the body is undeformed
    let mut loaded = twin.model().clone();
    loaded.inputs[0].start = Some(26e-3);
    let mut loaded = Twin::new(loaded).expect("a law of the library");
    let done = loaded.step(&[26e-3]).expect("an equilibrium");
    assert!(done.parts >= 16 && (loaded.values()[0] - expected[0]).abs() < 1e-3, "{done:?}: {}", loaded.values()[0]);
    let again = loaded.step(&[26e-3]).expect("an equilibrium");
    assert_eq!(again.parts, 1, "it is there");
}
