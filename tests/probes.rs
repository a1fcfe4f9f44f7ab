//! Probes on motions that are known: rotations over several turns, forwards and back, saved in the middle.

use durometer::scene::{Checkpoint, Run, RunOptions, Scene, parse_scene};
use durometer::solve::Status;

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
    t.iter().zip(found).map(|(t, found)| (found - exact(*t)).abs()).fold(0.0, f64::max)
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

/// Position, quaternion and rotation vector of a face and of the whole body follow the rotation throughout; relative to its other end a rigid body
/// rests. The quaternion is the one of the angle, with its sign.
#[test]
fn poses_follow_rigid_motions() {
    let pose = |keys: &str| format!("[[probe]]\nkind = \"pose\"\n{keys}\n");
    let probes = pose("region = \"xmax\"")
        + &pose("region = \"body\"\nname = \"all\"")
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
    let mut saved = |checkpoint: &Checkpoint, _: &str| checkpoint.write(&file, &scene).expect("writable");
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
