//! Probes on motions that are known: rotations over several turns, forwards and back, saved in the middle; lines bent to arcs; derivatives.

use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::scene::column::is_angle;
use durometer::scene::{Checkpoint, Energies, Moment, Reading, Run, RunOptions, Scene, parse_scene};
use durometer::solve::Status;
use durometer::system::{Gradient, State};

/// A block that turns as a rigid body about z by 900° and back, 45° a step, with these probes.
fn turning(probes: &str) -> Scene {
    let text = format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"], divisions = [2, 1, 1] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"prescribed\"\nregion = \"xmin\"\n\
         rotation = {{ axis = [0, 0, 1], about = [\"0 mm\", \"0 mm\", \"0 mm\"], \
         angle = {{ kind = \"sum\", of = [{{ kind = \"ramp\", from = \"0 deg\", to = \"900 deg\", end = \"1 s\" }}, \
         {{ kind = \"ramp\", from = \"0 deg\", to = \"-1080 deg\", start = \"1 s\", end = \"2 s\" }}] }} }}\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"2 s\"\ndt = \"0.05 s\"\n{probes}"
    );
    parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
}

/// The rotation at a time of [`turning`] \[deg\].
fn exact(t: f64) -> f64 {
    if t <= 1.0 { 900.0 * t } else { 900.0 - 1080.0 * (t - 1.0) }
}

fn bending(axis: &str) -> String {
    format!("[[probe]]\nkind = \"bending_angle\"\nroot = \"xmin\"\ntip = \"xmax\"\n{axis}")
}

fn largest(run: &Run, column: &str, exact: impl Fn(f64) -> f64) -> f64 {
    let (t, found) = (run.column("t_s").expect("a time"), run.column(column).expect(column));
    t.iter().zip(found).map(|(t, found)| (found - exact(*t)).abs()).fold(0.0, larger)
}

/// A body that turns as a whole bends by the angle of the turn. Newton's method leaves 1e-6 of a displacement at most, some 1e-4 degrees.
#[test]
fn bending_angles_count_turns() {
    for (axis, sign) in [("axis = [0, 0, 2]", 1.0), ("axis = [0, 0, -1]", -1.0), ("", 0.0)] {
        let run = turning(&bending(axis)).run();
        assert_eq!(run.status, Status::Converged);
        // Without an axis a first half turn has no sign.
        let right = |t: f64| if sign == 0.0 { exact(t).abs() } else { sign * exact(t) };
        for column in ["bending_angle_deg", "chord_angle_deg"] {
            let error = largest(&run, column, right);
            println!("{axis:20} {column}: {error:.1e}°");
            assert!(error < 1e-3, "{axis} {column}: {error}");
        }
    }
}

/// A tip without facets has no normal: that its angle is not recorded is a note, of which a tip of facets has none.
#[test]
fn a_bending_angle_that_is_left_out_is_a_note() {
    let corners = "min = [\"19.9 mm\", \"-1 mm\", \"-1 mm\"], max = [\"20.1 mm\", \"11 mm\", \"11 mm\"]";
    for (more, is_left_out) in [("", true), (", pick = \"facets\", rule = \"all\"", false)] {
        let tip = format!("[mesh.regions]\ntip = {{ kind = \"box\", {corners}{more} }}\n");
        let probe = "[[probe]]\nkind = \"bending_angle\"\nroot = \"xmin\"\ntip = \"tip\"\n";
        let scene = turning(&format!("{tip}{probe}"));
        let columns: Vec<String> = scene.recorders().flat_map(|recorder| recorder.columns()).collect();
        assert_eq!(columns.iter().any(|column| column == "bending_angle_deg"), !is_left_out);
        let of_tip = "bending_angle: region \"tip\" holds no facets, so that bending_angle_deg is not recorded";
        assert_eq!(scene.notes.iter().any(|note| note.starts_with(of_tip)), is_left_out, "{:?}", scene.notes);
    }
}

/// Of the columns that reduced models give, the angles are those that count turns: studies cut the way to these by their names, models by their readings.
#[test]
fn angles_of_reduced_models_count_turns() {
    let position = "[[probe]]\nkind = \"position\"\nregion = \"xmax\"\n";
    let scene = turning(&format!("{position}{SPINE}{}", bending("")));
    let mut of_kinds = [0, 0];
    for recorder in scene.recorders() {
        let readings = recorder.features().map(|features| features.readings);
        for (column, reading) in recorder.columns().iter().zip(readings.into_iter().flatten()) {
            let turns = matches!(reading, Reading::Turned(..));
            assert_eq!(turns, is_angle(column), "{column}");
            of_kinds[usize::from(turns)] += 1;
        }
    }
    assert_eq!(of_kinds, [3, 2]);
}

/// The derivative of an angle at a state that is known by its displacements and what was recorded is that along the run, in each half turn.
#[test]
fn an_angle_that_was_recorded_has_the_derivative_of_its_half_turn() {
    let scene = turning(&bending(""));
    let turned =
        |degrees: f64| moved(&scene, |at| nalgebra::Rotation3::from_scaled_axis(Vec3::z() * degrees.to_radians()) * at);
    let recorder = scene.recorders().next().expect("the angle");
    let mut path: Vec<State> = vec![];
    for degrees in (1..12).map(|k| 60.0 * f64::from(k) + 7.0) {
        path.push(turned(degrees));
        let states: Vec<&State> = path.iter().collect();
        let (values, memories) = recorded(&scene, &states);
        assert!((values[0] - degrees).abs() < 1e-6, "{values:?} at {degrees}°");
        let state = states[states.len() - 1];
        let known: Vec<Option<f64>> = values.iter().take(2).copied().map(Some).collect();
        let memory = recorder.memory_at(&scene.body, state, &known);
        let [found, exact] = [&memory, &memories[0]].map(|memory| recorder.gradients(&scene.body, state, memory));
        for (found, exact) in found.iter().zip(&exact) {
            assert_eq!(found.as_ref().map(|g| &g.x), exact.as_ref().map(|g| &g.x), "{degrees}°");
        }
    }
}

/// An angle is continuous over any number of rotations: an event at 200° is not ruled out, and happens at the first row beyond.
#[test]
fn an_event_beyond_half_a_turn_happens() {
    let event = "[[event]]\nwhen = { kind = \"above\", column = \"bending_angle_deg\", value = \"200 deg\" }\nthen = [{ kind = \"stop\" }]\n";
    let scene = turning(&(bending("axis = [0, 0, 1]") + "\n" + event));
    assert!(scene.notes.iter().all(|note| !note.contains("cannot happen")), "{:?}", scene.notes);
    let run = scene.run();
    assert_eq!(run.events.len(), 1);
    assert!((run.events[0].t_s - 0.25).abs() < 1e-12, "225° after five steps: {}", run.events[0].t_s);
}

/// The threshold of a moment carries a moment, the one of a curvature an inverse length; other units and plain numbers are refused.
#[test]
fn thresholds_on_moments_and_curvatures_carry_their_units() {
    let probes = format!("[[probe]]\nkind = \"moment\"\nregion = \"xmin\"\n{SPINE}");
    let scene = |column: &str, value: &str| {
        beam(&format!(
            "{probes}[[event]]\nwhen = {{ kind = \"above\", column = \"{column}\", value = \"{value}\" }}\nthen = [{{ kind = \"stop\" }}]\n"
        ))
    };
    let (moment, curvature) = ("xmin_moment_z_Nm", "spine_1_curvature_per_m");
    for (column, value) in [(moment, "5 mN m"), (moment, "0.002 N m"), (curvature, "20 1/m"), (curvature, "0.02 1/mm")]
    {
        if let Err(why) = scene(column, value) {
            panic!("{column} above {value}: {why}");
        }
    }
    for (column, value) in [(moment, "0.005"), (moment, "5 mN"), (curvature, "20"), (curvature, "20 mm")] {
        let said = scene(column, value).err().map(|why| why.to_string()).unwrap_or_default();
        assert!(said.contains(&format!("the column is {column}")), "{column} above {value}: {said}");
    }
}

/// Position, quaternion and rotation vector of a face and of the whole body follow the rotation throughout; relative to its other end a rigid body
/// rests. The quaternion is the one of the angle, with its sign.
#[test]
fn poses_follow_rigid_motions() {
    let pose = |keys: &str| format!("[[probe]]\nkind = \"pose\"\n{keys}\n");
    let probes = pose("region = \"xmax\"")
        + &pose(
            "region = \"body\"\nname = \"all\"\npoints = [[\"1 mm\", \"2 mm\", \"3 mm\"], [\"30 mm\", \"0 mm\", \"-4 mm\"]]",
        )
        + &pose("region = \"xmax\"\nrelative_to = \"xmin\"\nname = \"end\"");
    let run = turning(&probes).run();
    assert_eq!(run.status, Status::Converged);
    let half = |t: f64| 0.5 * exact(t).to_radians();
    for name in ["xmax", "all"] {
        assert!(largest(&run, &format!("{name}_rotation_z_deg"), exact) < 1e-3);
        assert!(largest(&run, &format!("{name}_rotation_x_deg"), |_| 0.0) < 1e-3);
        assert!(largest(&run, &format!("{name}_quaternion_w"), |t| half(t).cos()) < 1e-5);
        assert!(largest(&run, &format!("{name}_quaternion_z"), |t| half(t).sin()) < 1e-5);
    }
    // The middle of xmax is at (20, 5, 5) mm, and turns about the z axis.
    let angle = |t: f64| 2.0 * half(t);
    assert!(largest(&run, "xmax_pose_x_m", |t| 0.02 * angle(t).cos() - 0.005 * angle(t).sin()) < 1e-6);
    assert!(largest(&run, "xmax_pose_y_m", |t| 0.02 * angle(t).sin() + 0.005 * angle(t).cos()) < 1e-6);
    // A point on a stalk outside the body turns with it
    assert!(largest(&run, "all_point_2_x_m", |t| 0.03 * angle(t).cos()) < 1e-6);
    assert!(largest(&run, "all_point_2_y_m", |t| 0.03 * angle(t).sin()) < 1e-6);
    assert!(largest(&run, "all_point_2_z_m", |_| -0.004) < 1e-6);
    for (column, value) in
        [("end_pose_x_m", 0.02), ("end_pose_y_m", 0.0), ("end_quaternion_w", 1.0), ("end_rotation_z_deg", 0.0)]
    {
        assert!(largest(&run, column, |_| value) < 1e-3, "{column}");
    }
}

/// A run that goes on from a saved state between two turns has the bits of the whole one.
#[test]
fn turns_survive_a_restart() {
    let scene = turning(&bending(""));
    let whole = scene.run();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("state");
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file).expect("writable");
    scene.run_with(RunOptions { save_at: vec![0.7], on_save: Some(&mut saved), ..RunOptions::default() });
    let restart = Some(Checkpoint::read(&file, &scene).unwrap_or_else(|e| panic!("{e}")));
    let rest = scene.run_with(RunOptions { restart, ..RunOptions::default() });
    assert!(whole.rows == rest.rows && whole.memories == rest.memories);
}

/// An axis without a length, and one along the body.
#[test]
fn an_axis_lies_across_the_body() {
    for (axis, says) in [("[0, 0, 0]", "the axis has no length"), ("[1, 0, 0]", "along the line from root to tip")] {
        let text = turning("").text + &bending(&format!("axis = {axis}"));
        let error = parse_scene(&text).err().expect(axis).to_string();
        assert!(error.contains(says) && error.contains("probe 1"), "{error}");
    }
}

/// A beam of 60 × 10 × 10 mm along x, whose axis is a row of nodes 5 mm apart, with a skin and these probes.
fn beam(probes: &str) -> Result<Scene, String> {
    let text = format!(
        "[mesh]\nelement = \"tet10\"\n\
         grid = {{ kind = \"box\", size = [\"60 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 2, 2] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n{probes}"
    );
    parse_scene(&text).map_err(|e| e.to_string())
}

/// The state in which the node at X is at `place`(X).
fn moved(scene: &Scene, place: impl Fn(Vec3) -> Vec3) -> State {
    let mut state = State::rest(scene.body.mesh.points.len(), 0);
    for (k, point) in scene.body.mesh.points.iter().enumerate() {
        state.x[3 * k..3 * k + 3].copy_from_slice((place(*point) - point).as_slice());
    }
    state
}

/// The columns at a state that follows these, and what the recorders keep.
fn recorded(scene: &Scene, states: &[&State]) -> (Vec<f64>, Vec<Vec<f64>>) {
    let mut memories: Vec<Vec<f64>> = scene.recorders().map(|r| r.memory()).collect();
    for state in states {
        for (recorder, own) in scene.recorders().zip(&mut memories) {
            recorder.remember(&scene.body, state, own);
        }
    }
    let state = *states.last().expect("a state");
    let (body, residual) = (&*scene.body, vec![0.0; state.x.len()]);
    let record = |(recorder, memory): (&dyn durometer::scene::Recorder, &Vec<f64>)| {
        recorder.record(&Moment { body, state, step: None, residual: &residual, energies: Energies::default(), memory })
    };
    (scene.recorders().zip(&memories).flat_map(record).collect(), memories)
}

/// `columns()` of a scene begin with the time.
fn value(scene: &Scene, values: &[f64], column: &str) -> f64 {
    let columns = scene.columns();
    values[columns.iter().position(|c| c == column).unwrap_or_else(|| panic!("no {column}: {columns:?}")) - 1]
}

const SPINE: &str = "[[probe]]\nkind = \"centre_line\"\nname = \"spine\"\nfrom = \"xmin\"\nto = \"xmax\"\nstations = 13\ntowards = [0, 0, 1]\n";

/// A point of a segment of constant curvature that starts along x: `turn` over its length, towards the direction `plane` from z; and its frame.
fn segment(length: f64, turn: f64, plane: f64) -> (Vec3, Mat3) {
    let frame = nalgebra::Rotation3::from_scaled_axis(Vec3::new(0.0, plane.cos(), plane.sin()) * -turn);
    let aside = 2.0 * length * (0.5 * turn).sin().powi(2) / turn;
    (Vec3::new(length * turn.sin() / turn, -aside * plane.sin(), aside * plane.cos()), *frame.matrix())
}

/// Two segments of constant curvature, one after the other, each with the stretch 1.1: Webster and Jones' chain of arcs. All
/// parameters come back to rounding (1e-14 of 60 mm, amplified by a curvature of 1e2/m).
#[test]
fn segments_of_constant_curvature_are_found() {
    for (turns, planes) in [([90.0, 60.0], [0.0, 0.0]), ([40.0, 130.0], [30.0, 150.0]), ([200.0, 100.0], [-70.0, 45.0])]
    {
        let scene = beam(&format!("{SPINE}segments = 2\n")).expect("a scene");
        let (turns, planes) = (turns.map(f64::to_radians), planes.map(f64::to_radians));
        let place = |at: Vec3| {
            let across = Vec3::new(0.0, at.y - 0.005, at.z - 0.005);
            let half = |x: f64, k: usize| segment(1.1 * x, turns[k] * x / 0.03, planes[k]);
            let first = if at.x > 0.0 { half(at.x.min(0.03), 0) } else { (Vec3::zeros(), Mat3::identity()) };
            let second = if at.x > 0.0301 { half(at.x - 0.03, 1) } else { (Vec3::zeros(), Mat3::identity()) };
            first.0 + first.1 * (second.0 + second.1 * across)
        };
        let (values, _) = recorded(&scene, &[&moved(&scene, place)]);
        let off = |column: &str, exact: f64| {
            let found = value(&scene, &values, column);
            println!("{column}: {found} {:e}", found - exact);
            found - exact
        };
        assert!(off("spine_length_m", 0.066).abs() < 1e-13);
        for k in 0..2 {
            assert!(off(&format!("spine_{}_length_m", k + 1), 0.033).abs() < 1e-13);
            assert!(off(&format!("spine_{}_curvature_per_m", k + 1), turns[k] / 0.033).abs() < 1e-9);
            assert!(off(&format!("spine_{}_plane_deg", k + 1), planes[k].to_degrees()).abs() < 1e-8);
            assert!(off(&format!("spine_{}_residual_m", k + 1), 0.0).abs() < 1e-14);
        }
    }
}

/// A straight line has no curvature and keeps its plane angle; a plane that goes round is followed over any number of rotations. A line that is no arc has a
/// residual: of y = a x (L² − x²) with small a, whose least arc is its chord by symmetry, a x (L² − x²) itself.
#[test]
fn straight_lines_and_other_curves() {
    let scene = beam(SPINE).expect("a scene");
    let bent = |plane: f64| {
        moved(&scene, move |at| {
            let (p, frame) =
                if at.x > 0.0 { segment(at.x, 20.0 * at.x, plane) } else { (Vec3::zeros(), Mat3::identity()) };
            p + frame * Vec3::new(0.0, at.y - 0.005, at.z - 0.005)
        })
    };
    let straight = moved(&scene, |at| at * 1.2);
    let round: Vec<State> = (0..=20).map(|k| bent(f64::from(k) * 0.7)).collect();
    let mut path: Vec<&State> = round.iter().collect();
    let (values, _) = recorded(&scene, &path);
    assert!((value(&scene, &values, "spine_1_plane_deg") - f64::to_degrees(14.0)).abs() < 1e-8);
    path.push(&straight);
    let (values, _) = recorded(&scene, &path);
    assert!((value(&scene, &values, "spine_1_plane_deg") - f64::to_degrees(14.0)).abs() < 1e-8);
    assert!(value(&scene, &values, "spine_1_curvature_per_m").abs() < 1e-10);
    assert!((value(&scene, &values, "spine_1_length_m") - 0.072).abs() < 1e-15);
    let cubic = |x: f64| 1e-4 * x * (1.0 - x * x);
    let curve = moved(&scene, |at| at + Vec3::z() * cubic((at.x - 0.03) / 0.03));
    let (values, _) = recorded(&scene, &[&curve]);
    let squares: f64 = (-5..=5).map(|k| cubic(f64::from(k) / 6.0).powi(2)).sum();
    let found = value(&scene, &values, "spine_1_residual_m");
    assert!((found - (squares / 11.0).sqrt()).abs() < 1e-4 * found, "{found}");
}

const GLOVE: &str =
    "v 0.059 0.002 0.002\nv 0.059 0.008 0.002\nv 0.055 0.008 0.009\nv 0.05 0.001 0.008\nf 1 2 3\nf 1 3 4\n";

/// Gradients of poses in space, in a frame that moves, of a skin, and of two segments of a line, by every displacement of a body that is
/// bent, twisted and stretched, against central differences with steps of 1e-7 m: the residual of 0.1 mm varies most, and leaves (1e-7 m/0.1 mm)² of its derivative, others the rounding of 1e-16/1e-7.
#[test]
fn poses_and_lines_have_exact_derivatives() {
    let folder = tempfile::tempdir().expect("a folder");
    let glove = folder.path().join("glove.obj");
    std::fs::write(&glove, GLOVE).expect("writable");
    let pose = |keys: &str| format!("[[probe]]\nkind = \"pose\"\n{keys}\n");
    let probes = format!("{SPINE}segments = 2\n")
        + &pose("region = \"xmax\"")
        + &pose(
            "region = \"body\"\nrelative_to = \"xmax\"\nname = \"all\"\npoints = [[\"2 mm\", \"30 mm\", \"-4 mm\"]]",
        )
        + &pose("skin = \"glove\"")
        + &format!(
            "[[skin]]\nname = \"glove\"\nfile = {:?}\nunit = \"m\"\nreach = \"0 mm\"\n",
            glove.to_string_lossy()
        );
    let scene = beam(&probes).unwrap_or_else(|e| panic!("{e}"));
    let place = |turn: f64| {
        move |at: Vec3| {
            let (p, frame) = segment(1.1 * at.x + 1e-4, turn * (at.x + 1e-4) / 0.06, 1.0);
            let twist = nalgebra::Rotation3::from_scaled_axis(Vec3::x() * 15.0 * at.x);
            let wave = 3e-4 * Vec3::new((200.0 * at.y).sin(), (90.0 * at.x).cos(), (130.0 * at.z + 50.0 * at.x).sin());
            p + frame * (twist * Vec3::new(0.0, 1.2 * (at.y - 0.005), at.z - 0.005)) + wave
        }
    };
    for turn in [0.8, 3.7] {
        let path: Vec<State> = (1..=8).map(|k| moved(&scene, place(turn * f64::from(k) / 8.0))).collect();
        let path: Vec<&State> = path.iter().collect();
        let (_, memories) = recorded(&scene, &path);
        let here = path[7];
        let gradients: Vec<Gradient> = scene
            .recorders()
            .zip(&memories)
            .flat_map(|(r, memory)| r.gradients(&scene.body, here, memory))
            .map(|g| g.expect("it has one"))
            .collect();
        assert_eq!(gradients.len(), 9 + 3 * 10 + 3);
        let columns = scene.columns();
        let none = vec![0.0; here.x.len()];
        // Directions that move every node, each in its own way.
        for seed in 0..6 {
            let mut change = here.clone();
            let wave = |k: usize| (1.7 * k as f64 + f64::from(seed) * (1.0 + 0.37 * k as f64)).sin();
            change.x = (0..here.x.len()).map(wave).collect();
            let at = |h: f64| {
                let mut state = here.clone();
                state.x.iter_mut().zip(&change.x).for_each(|(x, d)| *x += h * d);
                recorded(&scene, &[&path[..], &[&state]].concat()).0
            };
            let (above, below) = (at(1e-7), at(-1e-7));
            for (c, gradient) in gradients.iter().enumerate() {
                let (exact, difference) = (gradient.along(&change, &none), (above[c] - below[c]) / 2e-7);
                let size: f64 = gradient.x.iter().map(|(_, w)| w.abs()).fold(0.0, larger);
                let name = &columns[c + 1];
                assert!(
                    (exact - difference).abs() < 1e-5 * (size + exact.abs()),
                    "{name} {turn} {seed}: {exact} {difference} {size}"
                );
            }
        }
    }
}

/// A straight line has a derivative of its length only, and a scene with one says so in its table.
#[test]
fn a_straight_line_has_no_direction() {
    let scene = beam(SPINE).expect("a scene");
    let straight = moved(&scene, |at| at * 1.2);
    let (_, memories) = recorded(&scene, &[&straight]);
    let recorder = scene.recorders().next().expect("the line");
    let has: Vec<bool> = recorder.gradients(&scene.body, &straight, &memories[0]).iter().map(Option::is_some).collect();
    assert_eq!(has, [true, true, false, false, false]);
}

/// (keys, what the message must say)
#[test]
fn lines_that_cannot_be_are_refused() {
    let refused = |keys: &str, says: &[&str]| {
        let text = format!("[[probe]]\nkind = \"centre_line\"\nname = \"spine\"\n{keys}\n");
        let error = beam(&text).err().unwrap_or_else(|| panic!("{keys}"));
        assert!(says.iter().all(|says| error.contains(says)) && error.contains("probe 1"), "{error}");
    };
    let ends = "from = \"xmin\"\nto = \"xmax\"\n";
    refused("towards = [0, 0, 1]", &["a line is given by `points`, or by `from`, `to` and `stations`"]);
    refused(&format!("{ends}towards = [0, 0, 1]"), &["a line is given by"]);
    refused(
        &format!("{ends}stations = 3\ntowards = [0, 0, 1]"),
        &["3 stations are not shared by 1 segments", "at least 4"],
    );
    refused(&format!("{ends}stations = 1\ntowards = [0, 0, 1]"), &["1 stations are not shared"]);
    refused(&format!("{ends}stations = 12\nsegments = 3\ntowards = [0, 0, 1]"), &["12 stations are not shared by 3"]);
    refused(&format!("{ends}stations = 12\nsegments = 0\ntowards = [0, 0, 1]"), &["by 0 segments"]);
    refused(&format!("{ends}stations = 9000000000000000000\ntowards = [0, 0, 1]"), &["stations are more than 10000"]);
    let many = format!("{ends}stations = 13\nsegments = 9000000000000000000\ntowards = [0, 0, 1]");
    refused(&many, &["13 stations are not shared"]);
    refused(&format!("{ends}stations = 13\ntowards = [1, 0, 0.01]"), &["`towards`", "along the line"]);
    refused(&format!("{ends}stations = 13\ntowards = [0, 0, 0]"), &["`towards`"]);
    refused(
        "from = \"xmin\"\nto = \"xmin\"\nstations = 4\ntowards = [0, 0, 1]",
        &["two stations are at the same place"],
    );
    let points = |all: &[[f64; 3]]| {
        let text: Vec<String> =
            all.iter().map(|p| format!("[\"{} mm\", \"{} mm\", \"{} mm\"]", p[0], p[1], p[2])).collect();
        format!("points = [{}]\ntowards = [0, 0, 1]", text.join(", "))
    };
    let out = points(&[[1.0, 5.0, 5.0], [20.0, 5.0, 12.0], [40.0, 5.0, 5.0], [70.0, 5.0, 5.0]]);
    refused(
        &out,
        &["2 of 4 stations are outside of the body: (20, 5, 12) mm by 2.0000 mm, (70, 5, 5) mm by 10.0000 mm"],
    );
    let pose = |keys: &str| beam(&format!("[[probe]]\nkind = \"pose\"\n{keys}\n")).err().expect("refused");
    assert!(pose("").contains("one `region` or of one `skin`"));
}

/// A beam of a linear law whose end is moved down and turned as a plate by little: moment and force at the plate are those of the displacements at the
/// other end by equilibrium, Σ (x − x₀) × r over both ends = 0, and a moment about another point differs by a × F.
#[test]
fn moments_are_in_equilibrium() {
    let ramp = |to: &str, unit: &str| {
        format!("{{ kind = \"ramp\", from = \"0 {unit}\", to = \"{to} {unit}\", end = \"1 s\" }}")
    };
    let text = format!(
        "[[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ntranslation = [{}, {}, {}]\n\
         rotation = {{ axis = [0, 1, 0], about = [\"60 mm\", \"5 mm\", \"5 mm\"], angle = {} }}\n",
        ramp("-2", "mm"),
        ramp("1", "mm"),
        ramp("-8", "mm"),
        ramp("50", "deg")
    );
    let probes: String = ["xmin", "xmax"]
        .map(|region| {
            format!(
                "[[probe]]\nkind = \"moment\"\nregion = \"{region}\"\nabout = [\"0 mm\", \"0 mm\", \"0 mm\"]\n\
                 [[probe]]\nkind = \"reaction\"\nregion = \"{region}\"\n[[probe]]\nkind = \"pose\"\nregion = \"{region}\"\n"
            )
        })
        .concat();
    let run = beam(&(text.clone() + &probes)).expect("a scene").run();
    assert_eq!(run.status, Status::Converged);
    let last = |run: &Run, name: &str| *run.column(name).expect(name).last().expect("rows");
    let vector = |run: &Run, start: &str, end: &str| {
        Vec3::from(["x", "y", "z"].map(|c| last(run, &format!("{start}_{c}_{end}"))))
    };
    let moments = ["xmin", "xmax"].map(|r| vector(&run, &format!("{r}_moment"), "Nm"));
    let size = moments[0].norm();
    assert!(size > 1e-4 && (moments[0] + moments[1]).norm() < 1e-6 * size, "{moments:?}");
    // The plate is where the translation puts it.
    let at = vector(&run, "xmax_pose", "m");
    assert!((at - Vec3::new(0.058, 0.006, -0.003)).norm() < 1e-9, "{at}");
    assert!((last(&run, "xmax_rotation_y_deg") - 50.0).abs() < 1e-9);
    let middle = beam(&(text + "[[probe]]\nkind = \"moment\"\nregion = \"xmax\"\n")).expect("a scene").run();
    let shifted = moments[1] - at.cross(&vector(&run, "xmax_reaction", "N"));
    let found = vector(&middle, "xmax_moment", "Nm");
    assert!((found - shifted).norm() < 1e-9 * size, "{found} {shifted}");
}

/// Stretches are those of the volume, in which a cell counts once however many effects resist its deformation: an effect next to nothing in half of the body changes
/// none of them beyond its own share of the stiffness, 1e-7.
#[test]
fn a_cell_with_several_effects_has_its_stretch_once() {
    let run = |more: &str| {
        let text = format!(
            "[mesh]\ngrid = {{ kind = \"box\", size = [\"40 mm\", \"10 mm\", \"10 mm\"], divisions = [4, 2, 2] }}\n\
             [mesh.regions]\nhalf = {{ kind = \"box\", min = [\"-1 mm\", \"-1 mm\", \"-1 mm\"], max = [\"21 mm\", \"11 mm\", \"11 mm\"], pick = \"cells\", rule = \"all\" }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.3\n\
             [laws.weak]\nlaw = \"neo_hookean\"\nE = \"0.01 Pa\"\nnu = 0.3\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n{more}\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmax\"\ncomponents = \"yz\"\n\
             [[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"x\"\n\
             displacement = {{ kind = \"ramp\", from = \"0 mm\", to = \"8 mm\", end = \"1 s\" }}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"0.5 s\"\n[[probe]]\nkind = \"stretch\"\n"
        );
        let scene = parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
        let run = scene.run();
        assert_eq!(run.status, Status::Converged, "{more}");
        let nodal = scene.nodal_stretch(&run.last.x);
        (run.rows.last().expect("a row")[1..5].to_vec(), nodal)
    };
    let (alone, alone_at_nodes) = run("");
    for more in [
        "[[effect]]\nkind = \"edge_springs\"\nregion = \"half\"\nE = \"0.01 Pa\"\noverlap = \"add\"\n",
        "[[effect]]\nkind = \"elastic\"\nregion = \"half\"\nlaw = \"weak\"\noverlap = \"add\"\n",
    ] {
        let (both, at_nodes) = run(more);
        let pairs = alone.iter().chain(&alone_at_nodes).zip(both.iter().chain(&at_nodes));
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, larger);
        assert!(off < 1e-6, "{off:e}: {alone:?} {both:?} with {more}");
    }
}
