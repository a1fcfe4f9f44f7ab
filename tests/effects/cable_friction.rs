//! Cable with friction: the capstan law in closed form, hysteresis and its energy, no friction as a limit, symmetry, and
//! the derivatives that Newton's method takes.

use crate::common;
use crate::common::{Random, column, newton, run, scene};
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Run, Scene};
use durometer::solve::{Integrator, NonlinearSolver, Status, Step};
use durometer::system::{BlockValues, ConstraintKind, ConstraintValues, LinearFunction, State, Want};

const RAISED: &str =
    r#"{ kind = "length", signal = { kind = "raised_cosine", amplitude = "8 mm", frequency = "1 Hz" } }"#;

/// A beam of 100 × 15 × 15 mm, clamped at x = 0, with one cable of these keys.
fn beam(cables: &[String], dt: &str, order: Order) -> Scene {
    let cables: String = cables.iter().map(|keys| format!("[[constraint]]\nkind = \"cable\"\n{keys}\n")).collect();
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[constraint]]
kind = "fixed"
region = "xmin"
{cables}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "{dt}"
[[probe]]
kind = "energy"
[[probe]]
kind = "position"
region = "xmax"
"#
    );
    scene(block(12, 2, 2, 0.1, 0.015, 0.015, order), &text)
}

/// Guides at height z, the first one off the line of the others so that the cable turns at rest too.
fn bent(friction: &str, drive: &str) -> String {
    format!(
        r#"
guides = [["12 mm", "7.5 mm", "6 mm"], ["35 mm", "7.5 mm", "3 mm"], ["65 mm", "7.5 mm", "3 mm"], ["92 mm", "7.5 mm", "4 mm"]]
pull_point = ["-10 mm", "7.5 mm", "3 mm"]
guide_radius = "5 mm"
drive = {drive}
{friction}"#
    )
}

fn ended(scene: &Scene) -> Run {
    let result = run(scene);
    assert_eq!(result.status, Status::Converged);
    result
}

/// The tension of a raised cosine ends at a rounding of its amplitude, 4e-32 N, which is none.
#[test]
fn a_tension_may_come_back_to_zero() {
    let drive = r#"{ kind = "tension", signal = { kind = "raised_cosine", amplitude = "1 N", frequency = "2 Hz" } }"#;
    for friction in ["friction = 0", "friction = 0.3"] {
        let run = ended(&beam(&[bent(friction, drive)], "0.05 s", Order::Linear));
        for (t, tension) in column(&run, "t_s").iter().zip(column(&run, "cable_tension_N")) {
            let given = 0.5 * (1.0 - (4.0 * std::f64::consts::PI * t).cos());
            assert!((tension - given).abs() < 1e-9, "{friction}: {tension} N for {given} N at {t} s");
        }
    }
}

/// A law without the geometric stiffness of its stress is named under forces that turn with the body.
#[test]
fn a_law_that_does_not_turn_has_a_note() {
    let drive = r#"{ kind = "tension", signal = "1 N" }"#;
    for (law, noted) in [("linear", true), ("corotational", false), ("neo_hookean", false)] {
        let text = beam(&[bent("", drive)], "0.5 s", Order::Linear).text.replace("neo_hookean", law);
        let scene = scene(block(2, 1, 1, 0.1, 0.015, 0.015, Order::Linear), &text);
        let of_law = format!("rubber is {law}, and the force of cable turns with the body");
        assert_eq!(scene.notes.iter().any(|note| note.starts_with(&of_law)), noted, "{law}: {:?}", scene.notes);
    }
}

fn angles(line: &[durometer::math::tensor::Vec3]) -> Vec<f64> {
    let turn = |w: &[durometer::math::tensor::Vec3]| (w[1] - w[0]).angle(&(w[2] - w[1]));
    line.windows(3).map(turn).collect()
}

/// Euler & Eytelwein: over rings on an arc of 2 rad, from the first turn to the last, T ratio e^{2μ} while it is pulled and
/// e^{−2μ} while it is let out. The solver keeps each ratio to 1e-8 (of T and of Σ‖r_e‖/1000), and there are eight.
#[test]
fn over_rings_the_tension_grows_by_the_capstan_law() {
    let (turns, angle, mu) = (8, 2.0, 0.3);
    // Rings at the corners of a polygon with `turns` equal turns, straight on before the first and after the last.
    let mut at = [0.13, 0.0075, 0.0075_f64];
    let mut heading = 0.0_f64;
    let mut rings = vec![at];
    for k in 0..=turns {
        if k > 0 {
            heading += angle / turns as f64;
        }
        at = [at[0] + 0.01 * heading.cos(), at[1] + 0.01 * heading.sin(), at[2]];
        rings.push(at);
    }
    let pull = rings.pop().expect("the last point");
    let text = |p: &[f64; 3]| format!("[\"{} m\", \"{} m\", \"{} m\"]", p[0], p[1], p[2]);
    // The first ring lies on the axis of the beam: what turns there depends on the body, and is left out of the ratio.
    let rings: Vec<String> = rings.iter().rev().map(|r| format!("{{ at = {}, after = 0 }}", text(r))).collect();
    let keys = |friction: f64| {
        format!(
            "guides = [[\"85 mm\", \"7.5 mm\", \"7.5 mm\"]]\npull_point = {}\nrings = [{}]\nguide_radius = \"5 mm\"\n\
             drive = {RAISED}\nfriction = {friction}",
            text(&pull),
            rings.join(", ")
        )
    };
    for friction in [mu, 0.0] {
        let result = ended(&beam(&[keys(friction)], "0.05 s", Order::Linear));
        let (first, last) =
            (column(&result, "cable_tension_1_N"), column(&result, &format!("cable_tension_{}_N", turns + 1)));
        let (time, exact) = (column(&result, "t_s"), (friction * angle).exp());
        let strongest = first.iter().copied().fold(0.0, larger);
        let (mut seen, mut worst) = ([0, 0], 0.0_f64);
        for (k, t) in time.iter().enumerate().skip(1) {
            if last[k] < 1e-6 * strongest {
                continue;
            }
            let pulled = *t <= 0.5;
            let expected = if pulled { exact } else { 1.0 / exact };
            seen[usize::from(pulled)] += 1;
            let error = (first[k] / last[k] / expected - 1.0).abs();
            worst = larger(worst, error);
            assert!(error <= 1e-6, "μ = {friction}, t = {t}: {}", first[k] / last[k]);
        }
        println!(
            "capstan μ = {friction}: {seen:?} states let out, pulled, wrong by {worst:.1e}; T up to {strongest:.4} N"
        );
        assert!(seen[0] >= 8 && seen[1] == 10);
    }
}

/// A scene with the coefficient 0 is solved like one without the key, to the last bit, and records the columns of a cable with friction besides.
#[test]
fn the_coefficient_zero_is_a_cable_without_friction() {
    for drive in
        [RAISED, r#"{ kind = "tension", signal = { kind = "ramp", from = "0 N", to = "0.1 N", end = "1 s" } }"#]
    {
        let plain = ended(&beam(&[bent("EA = \"20 N\"", drive)], "0.1 s", Order::Linear));
        let zero = ended(&beam(&[bent("EA = \"20 N\"\nfriction = 0", drive)], "0.1 s", Order::Linear));
        for name in plain.columns.iter().filter(|name| !name.contains("cpu") && !name.contains("wall")) {
            assert_eq!(column(&plain, name), column(&zero, name), "{drive}: {name}");
        }
        let (first, drawn) = (column(&zero, "cable_tension_N"), column(&zero, "cable_drawn_m"));
        for name in ["cable_end_tension_N", "cable_tension_1_N", "cable_tension_4_N"] {
            assert_eq!(column(&zero, name), first, "{drive}: {name}");
        }
        let slip = column(&zero, "cable_slip_1_m");
        assert!(slip.iter().zip(&drawn).any(|(slip, drawn)| *slip != 0.0 && slip != drawn), "{drive}: {slip:?}");
    }
}

/// The rows of the cable with a friction that vanishes, μ = 1e-12, against its one row without: the same problem by two ways, each solved to 1e-8.
#[test]
fn without_friction_it_is_the_plain_cable() {
    for extra in ["", "EA = \"20 N\"", "max_tension = \"0.08 N\""] {
        let plain = ended(&beam(&[bent(extra, RAISED)], "0.1 s", Order::Linear));
        let rows = ended(&beam(&[bent(&format!("{extra}\nfriction = 1e-12"), RAISED)], "0.1 s", Order::Linear));
        for name in ["cable_tension_N", "cable_length_m", "xmax_z_m", "elastic_J", "work_J"] {
            let (a, b) = (column(&plain, name), column(&rows, name));
            let size = a.iter().fold(0.0, |m, v| larger(m, v.abs()));
            let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, larger) / size;
            assert!(worst <= 1e-6, "{extra}: {name} differs by {worst:e}");
        }
        let (first, end) = (column(&rows, "cable_tension_N"), column(&rows, "cable_end_tension_N"));
        assert!(first.iter().zip(&end).all(|(a, b)| (a - b).abs() <= 1e-8 * a), "{extra}: one tension everywhere");
        let lost = column(&rows, "dissipated_J").iter().fold(0.0, |m, v| larger(m, v.abs()));
        let peak = column(&rows, "elastic_J").iter().copied().fold(0.0, larger);
        assert!(lost <= 1e-7 * peak, "{extra}: {lost:e} J lost without friction");
    }
}

/// A load–unload cycle. At every state each guide is inside its cone with the angle of the line as it is, and slips only at the end of it
/// that resists; on the return the guides turn round one after the other; what is lost grows, and is the loop of tension over
/// what was drawn in. Both are trapezoidal sums: they differ by O(dt²), 1e-2 of the loop at 80 steps and a fourth at twice that.
#[test]
fn a_cycle_loses_the_area_of_its_loop() {
    let mu = 0.2;
    let defect = |dt: &str| {
        let scene = beam(&[bent(&format!("friction = {mu}"), RAISED)], dt, Order::Linear);
        let mut lines = Vec::new();
        let result = common::run_with_states(&scene, &mut |state| lines.push(scene.cables[0].cable.polyline(&state.x)));
        assert_eq!(result.status, Status::Converged);
        let n = 4;
        let tension: Vec<_> = (1..=n).map(|s| column(&result, &format!("cable_tension_{s}_N"))).collect();
        let slip: Vec<_> = (1..n).map(|k| column(&result, &format!("cable_slip_{k}_m"))).collect();
        let most = tension[0].iter().copied().fold(0.0, larger);
        let mut turned = vec![None; n - 1];
        for (step, line) in lines.iter().enumerate().skip(1) {
            for (k, beta) in angles(line).into_iter().enumerate() {
                let (a, b, cone) = (tension[k][step], tension[k + 1][step], (mu * beta).exp());
                let moved = slip[k][step] - slip[k][step - 1];
                assert!(
                    a <= cone * b + 1e-6 * most && b <= cone * a + 1e-6 * most,
                    "step {step}, guide {k}: {a} N, {b} N"
                );
                // 1e-8 of the length is what the solver leaves of a guide that sticks.
                if moved > 1e-8 {
                    assert!((a - cone * b).abs() <= 1e-6 * most, "step {step}, guide {k} slips in");
                } else if moved < -1e-8 {
                    assert!((b - cone * a).abs() <= 1e-6 * most, "step {step}, guide {k} slips out");
                    turned[k].get_or_insert(step);
                }
            }
        }
        let turned: Vec<usize> = turned.into_iter().map(|t| t.expect("every guide turns round")).collect();
        let lost = column(&result, "dissipated_J");
        assert!(
            lost.windows(2).all(|w| w[1] >= w[0] - 1e-6 * lost[lost.len() - 1]),
            "what is lost stays lost: {lost:?}"
        );
        let drawn = column(&result, "cable_drawn_m");
        let area: f64 =
            (1..drawn.len()).map(|k| 0.5 * (tension[0][k] + tension[0][k - 1]) * (drawn[k] - drawn[k - 1])).sum();
        let (work, elastic) = (column(&result, "work_J"), column(&result, "elastic_J"));
        let (last, peak) = (lost.len() - 1, elastic.iter().copied().fold(0.0, larger));
        println!(
            "cycle dt = {dt}: loop {area:.4e} J, lost {:.4e} J, peak {peak:.3e} J, guides turn at {turned:?}",
            lost[last]
        );
        assert!(elastic[last].abs() <= 1e-6 * peak && lost[last] > 0.02 * peak);
        assert!((work[last] - area).abs() <= 1e-6 * peak, "work_J is the loop: {} and {area}", work[last]);
        (turned, (area / lost[last] - 1.0).abs())
    };
    let (turned, coarse) = defect("0.0125 s");
    assert!(turned.windows(2).all(|w| w[0] <= w[1]) && turned[0] < turned[2], "from the pull point on: {turned:?}");
    let (_, fine) = defect("0.00625 s");
    println!("loop against loss: {coarse:.1e}, {fine:.1e}");
    assert!(coarse <= 1e-2 && fine <= 0.5 * coarse);
}

/// The tension that a length needed, imposed as a tension, gives the length: with friction, elastic or not, while it is pulled.
#[test]
fn length_and_tension_are_dual_under_friction() {
    for ea in ["", "EA = \"20 N\""] {
        let ramp = |quantity: &str, to: f64, unit: &str| {
            format!(
                "{{ kind = \"{quantity}\", signal = {{ kind = \"ramp\", from = \"0 {unit}\", to = \"{to} {unit}\", end = \"1 s\" }} }}"
            )
        };
        let keys = |drive: &str| [bent(&format!("friction = 0.2\n{ea}"), drive)];
        let first = ended(&beam(&keys(&ramp("length", 6e-3, "m")), "1 s", Order::Linear));
        let tension = *column(&first, "cable_tension_N").last().expect("rows");
        let second = ended(&beam(&keys(&ramp("tension", tension, "N")), "1 s", Order::Linear));
        for name in ["cable_drawn_m", "cable_length_m", "cable_end_tension_N"] {
            let (a, b) = (column(&first, name)[1], column(&second, name)[1]);
            println!("dual {ea}: {name} {a:.6e} {b:.6e}");
            // Both are solved to 1e-8 of Σ‖r_e‖, some tens of the tension.
            assert!((a / b - 1.0).abs() <= 1e-5, "{ea}: {name} {a} by length, {b} by tension");
        }
    }
}

/// Boxes of Kuhn cells do not change when y and z are exchanged, so two cables that are images of each other do not either.
/// Guides are points, as the quadrature of a ball knows its axes. Solved to 1e-11 of forces some tens of the tension.
#[test]
fn two_mirrored_cables_answer_alike() {
    let cable = |name: &str, y: f64, z: f64| {
        format!(
            "name = \"{name}\"\nguides = [[\"12 mm\", \"{y} mm\", \"{z} mm\"], [\"50 mm\", \"7.5 mm\", \"7.5 mm\"], [\"92 mm\", \"{y} mm\", \"{z} mm\"]]\n\
             pull_point = [\"-10 mm\", \"7.5 mm\", \"7.5 mm\"]\nguide_radius = \"point\"\ndrive = {RAISED}\nfriction = 0.2"
        )
    };
    let mut scene = beam(&[cable("left", 3.0, 6.0), cable("right", 6.0, 3.0)], "0.1 s", Order::Linear);
    scene.spec.numerics.tolerance = 1e-11;
    let result = ended(&scene);
    for (a, b) in [("left_tension_N", "right_tension_N"), ("left_slip_1_m", "right_slip_1_m"), ("xmax_y_m", "xmax_z_m")]
    {
        let (a, b) = (column(&result, a), column(&result, b));
        let size = a.iter().fold(0.0, |m, v| larger(m, v.abs()));
        let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, larger) / size;
        println!("mirror: {worst:.1e} of {size:.3e}");
        assert!(worst <= 1e-8, "{worst:e}");
    }
}

/// ∂c/∂x of every row against differences at a random state, and of every law of a row against differences in g and λ.
/// Central differences of h = 1e-6 of the length in play: truncation 1e-12, rounding 1e-16/1e-6 = 1e-10 of the size.
#[test]
fn derivatives_of_rows_and_of_their_laws() {
    let scene = beam(&[bent("friction = 0.2\nmax_tension = \"1 N\"", RAISED)], "0.1 s", Order::Linear);
    let system = &scene.system;
    let mut random = Random::seed(7);
    let x = random.vector(system.rest().x.len(), 5e-4);
    let mut local = BlockValues::new(4000);
    for row in &system.constraints {
        let dofs: Vec<u32> = row.blocks().dofs(0).collect();
        let w = row.means().expect("its guides").of(&x);
        let mut eval = |x: &[f64], want| {
            local.r.fill(0.0);
            row.eval(x, 0, want, &mut local).expect("no two guides coincide");
            (local.energy, local.r[..dofs.len()].to_vec())
        };
        let dx = random.vector(dofs.len(), 1.0);
        let moved = |h: f64| {
            let mut out = w.clone();
            dofs.iter().zip(&dx).for_each(|(&dof, d)| out[dof as usize] += h * d);
            out
        };
        let h = 1e-7;
        let difference = (eval(&moved(h), Want::Energy).0 - eval(&moved(-h), Want::Energy).0) / (2.0 * h);
        let r = eval(&w, Want::Residual).1;
        let along: f64 = r.iter().zip(&dx).map(|(r, d)| r * d).sum();
        let size = r.iter().map(|r| r.abs()).sum::<f64>();
        assert!((along - difference).abs() <= 1e-6 * size, "{along} against {difference}");
    }
    let m = system.constraints.len();
    let state = State { x, lambda: (0..m).map(|_| random.unit()).collect(), ..system.rest() };
    let (g, old) = (system.gaps(&state).expect("defined"), vec![0.0; m]);
    let (dg, dl) = (random.vector(m, 1.0), random.vector(m, 1.0));
    let at = |h: f64| -> Vec<LinearFunction> {
        let g: Vec<f64> = g.iter().zip(&dg).map(|(g, d)| g + h * d).collect();
        let lambda: Vec<f64> = state.lambda.iter().zip(&dl).map(|(l, d)| l + h * d).collect();
        let rows = ConstraintValues { now: 0.3.into(), g: &g, lambda: &lambda, old: &old, force: 1.0 };
        let linked = system.constraints.iter().enumerate().filter(|(_, row)| row.kind() == ConstraintKind::Linked);
        let pieces = linked.flat_map(|(c, row)| row.linked_law(c, &rows));
        pieces.flat_map(|p| std::iter::once(p.equation).chain(p.inequalities.into_iter().map(|w| w.0))).collect()
    };
    let h = 1e-6;
    let (now, plus, minus) = (at(0.0), at(h), at(-h));
    assert_eq!(now.len(), 7 + 3 * 7, "the drive with its limit, and three guides");
    for ((f, plus), minus) in now.iter().zip(&plus).zip(&minus) {
        let along =
            f.g.iter().map(|&(c, d)| d * dg[c]).sum::<f64>() + f.lambda.iter().map(|&(c, d)| d * dl[c]).sum::<f64>();
        let difference = (plus.value - minus.value) / (2.0 * h);
        assert!((along - difference).abs() <= 1e-8, "{along} against {difference}");
    }
}

/// With the change of the wrap angle in its step Newton's method is of second order: full steps of a pull of 1 mm, none with an
/// old factor, need few iterations. Without that term the error falls by μ ∂β/∂x a step only.
#[test]
fn newton_keeps_its_order() {
    let text = bent(
        "friction = 0.4",
        r#"{ kind = "length", signal = { kind = "ramp", from = "0 mm", to = "5 mm", end = "1 s" } }"#,
    );
    let mut scene = beam(&[text], "0.2 s", Order::Linear);
    scene.spec.numerics.reuse_factor = false;
    scene.spec.numerics.extrapolate = false;
    let result = ended(&scene);
    let iterations = column(&result, "newton_iterations");
    println!("iterations {iterations:?}, {} cuts", result.totals.cuts);
    assert_eq!(result.totals.cuts, 0);
    assert!(iterations[2..].iter().all(|n| *n <= 6.0), "{iterations:?}");
}

/// The slip belongs to the state: a step that failed and was dropped leaves nothing behind, bit for bit.
#[test]
fn a_dropped_step_leaves_no_slip() {
    let scene = beam(&[bent("friction = 0.3", RAISED)], "0.1 s", Order::Linear);
    let system = &scene.system;
    let solve = |newton: &mut NonlinearSolver, past: &State, t: f64| {
        let mut next = State { t, ..past.clone() };
        let step = Step { system, integrator: Integrator::Static, past, dt: t - past.t };
        newton.solve(&step, &mut next).map(|_| next)
    };
    let fresh = || newton(system, 1e-8, 0.1);
    let pulled = solve(&mut fresh(), &system.rest(), 0.3).expect("a pull of 5 mm");
    let plain = solve(&mut fresh(), &pulled, 0.35).expect("another step");
    let mut tried = fresh();
    tried.settings.max_iterations = 1;
    assert!(solve(&mut tried, &pulled, 0.8).is_err(), "one iteration is not enough to turn round");
    tried.settings.max_iterations = 30;
    assert_eq!(solve(&mut tried, &pulled, 0.35).expect("the same step"), plain);
}
