//! Steps of the length that an allowed time error asks for (`numerics.time_error`).

use crate::common::{column, run, scene};
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::Run;
use durometer::solve::Status;

/// A beam whose cable is shortened within 20 ms and then held for 3 s; its first mode has some 30 ms and dies within 0.3 s.
fn pull_and_hold(dt: &str, numerics: &str) -> Run {
    pulled(&format!("[[stage]]\nintegrator = \"bdf2\"\nduration = \"3 s\"\ndt = \"{dt}\""), numerics)
}

/// The same beam in other stages.
fn pulled(stages: &str, numerics: &str) -> Run {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
mu = "60 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "inertia"
region = "body"
density = "1 g/cm^3"
mass = "lumped"
[[effect]]
kind = "viscous_damping"
region = "body"
eta = "150 Pa s"
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = {{ kind = "length", signal = {{ kind = "ramp", from = "0 mm", to = "2 mm", end = "20 ms" }} }}
{stages}
[[probe]]
kind = "position"
region = "xmax"
[numerics]
{numerics}
"#
    );
    let run = run(&scene(block(6, 1, 1, 0.04, 0.01, 0.01, Order::Linear), &text));
    assert_eq!(run.status, Status::Converged, "{stages} {numerics}");
    run
}

/// The deflection at multiples of 20 ms [m].
fn curve(run: &Run) -> Vec<f64> {
    let on_grid = |t: f64| (t / 0.02 - (t / 0.02).round()).abs() < 1e-6;
    let times = column(run, "t_s");
    column(run, "xmax_z_m").into_iter().zip(times).filter(|(_, t)| on_grid(*t)).map(|(z, _)| z).collect()
}

/// Root of the mean squared difference [m].
fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// The same error as with one length of step, in less than a third of the steps, repeated ones counted; a smaller allowance
/// gives a smaller error. The reference has an eighth of the finest step that it is compared with: its own error, of second order, is
/// 1/64 of that. From 0.8 s on nothing moves by more than 0.1 µm, and its steps are long.
#[test]
fn a_third_of_the_steps_for_the_same_error() {
    let moving = "[[stage]]\nintegrator = \"bdf2\"\nduration = \"0.8 s\"\ndt = \"0.125 ms\"\n";
    let held = "[[stage]]\nintegrator = \"bdf2\"\nduration = \"2.2 s\"\ndt = \"20 ms\"";
    let fine = curve(&pulled(&[moving, held].concat(), ""));
    let fixed = ["2 ms", "1 ms"].map(|dt| pull_and_hold(dt, ""));
    let adaptive = ["3 um", "1 um", "0.3 um"].map(|e| pull_and_hold("20 ms", &format!("time_error = \"{e}\"")));
    let pair = |run: &Run| (distance(&curve(run), &fine), run.totals.steps + run.totals.repeated);
    let (fixed, adaptive) = (fixed.each_ref().map(pair), adaptive.each_ref().map(pair));
    println!("one length: {fixed:?}, by the error: {adaptive:?}");
    assert!(adaptive.windows(2).all(|pair| pair[1].0 < pair[0].0), "{adaptive:?}");
    for (error, steps) in fixed {
        let cheapest = adaptive.iter().filter(|a| a.0 <= error).map(|a| a.1).min();
        assert!(cheapest.is_some_and(|n| 3 * n <= steps), "{error:e} m by {steps} steps, {adaptive:?}");
    }
}

/// Where nothing is to be gained, nothing is cut; and an allowance that cannot be met is told, not hidden.
#[test]
fn steps_are_cut_only_for_the_error() {
    let plain = pull_and_hold("5 ms", "");
    let loose = pull_and_hold("5 ms", "time_error = \"1 m\"");
    assert_eq!((loose.totals, &loose.rows), (plain.totals, &plain.rows));
    let strict = pull_and_hold("5 ms", "time_error = \"1e-9 mm\"\ncuts = 1");
    assert!(strict.totals.coarse > 0 && strict.totals.steps <= 1200, "{:?}", strict.totals);
}

/// The pull at rest in one step, which is cut, and 40 ms in steps of 2 ms: the former are no steps in time.
#[test]
fn parts_of_a_static_step_are_no_steps_in_time() {
    let stages = "[[stage]]\nintegrator = \"static\"\nduration = \"20 ms\"\ndt = \"20 ms\"\n\
                  [[stage]]\nintegrator = \"bdf2\"\nduration = \"40 ms\"\ndt = \"2 ms\"";
    let totals = pulled(stages, "max_iterations = 3").totals;
    assert!(totals.cuts > 0 && totals.steps > 21, "{totals:?}");
    assert_eq!(totals.in_time, 20);
}
