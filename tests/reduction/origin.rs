//! A reduced model is judged by changes from rest: where the origin of the coordinates lies decides nothing.

use crate::bar::{Bar, Weight, states};
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::reduction::training::greedy::{NextStates, Search};
use durometer::reduction::{ReducedModel, Training, errors};
use durometer::scene::Scene;

const LOADS: [f64; 6] = [2.0, 5.0, 9.0, 12.0, 16.0, 20.0];

/// A bar under its weight, so far along z.
fn bar(shift: f64, points: usize) -> Scene {
    let mut mesh = block(8, 1, 1, 0.04, 0.01, 0.01, Order::Linear);
    mesh.points.iter_mut().for_each(|point| point.z += shift);
    Bar { direction: "[0, 0, -1]", weight: Weight::Input([0, 20]), drive: None, ..Bar::default() }
        .of_points(mesh, points)
}

/// A model of one mode, its errors at its own states, and the states that a search would add.
fn judged(shift: f64) -> (ReducedModel, Vec<Vec<(f64, f64)>>, NextStates) {
    let (scene, names) = (bar(shift, LOADS.len()), vec!["xmax_z_m".to_string()]);
    let states = states(&scene, &LOADS.map(|load| vec![load]), &names);
    let training = Training::new(&scene, &states, &names).unwrap_or_else(|e| panic!("{e}"));
    let model = training.model(1, None, &[]).unwrap_or_else(|e| panic!("{e}"));
    let candidates: Vec<Vec<f64>> = (1..20).map(|k| vec![f64::from(k)]).collect();
    let choice = Search { modes: 1, sampling: None, batch: 2 }.choose(&training, &candidates);
    let errors = errors(&model, &states).expect("a law of the library");
    (model, errors, choice.unwrap_or_else(|e| panic!("{e}")))
}

/// Moved by 1 m along the motion that is asked for, a hundred times as far as that is, the model has the same size, the same errors and the same next states. The
/// solver leaves 1e-6 of the motion, and coordinates of 1 m round at 1e-13 of it.
#[test]
fn a_model_does_not_depend_on_the_origin() {
    let ((here, near, first), (there, far, other)) = (judged(0.0), judged(1.0));
    let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-3;
    let change = here.largest_changes[0];
    assert!((1e-4..0.02).contains(&change) && close(change, there.largest_changes[0]), "{change}");
    assert!((there.rest[0] - here.rest[0] - 1.0).abs() < 1e-12, "{:?} {:?}", here.rest, there.rest);
    assert!(close(here.size_at(0, here.rest[0] + 0.1), 0.1) && close(there.size_at(0, there.rest[0] - 0.1), 0.1));
    let largest = |rows: &[Vec<(f64, f64)>]| rows.iter().map(|row| row[0].0.abs()).fold(0.0, larger);
    assert!(close(largest(&near), largest(&far)), "{:e} {:e}", largest(&near), largest(&far));
    assert!(close(first.largest, other.largest) && first.chosen == other.chosen, "{first:?} {other:?}");
}
