//! What is given exactly and jumps in a dynamic stage: an impact without a limit as Δt → 0, which is noted.

use durometer::math::statistics::larger;
use durometer::scene::{Run, Scene, parse_scene};

/// A clamped bar with mass under this constraint.
fn bar(constraint: &str, dt_ms: f64) -> Scene {
    let text = format!(
        "[mesh]\ngrid = {{ kind = \"box\", size = [\"60 mm\", \"10 mm\", \"10 mm\"], divisions = [6, 1, 1] }}\n\
         [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
         [[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"consistent\"\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[constraint]]\n{constraint}\n\
         [[stage]]\nintegrator = \"bdf2\"\nduration = \"8 ms\"\ndt = \"{dt_ms} ms\"\n[[probe]]\nkind = \"energy\"\n"
    );
    parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
}

fn cable(keys: &str, kind: &str, signal: &str) -> String {
    format!(
        "kind = \"cable\"\nguide_radius = \"point\"\npull_point = [\"-10 mm\", \"5 mm\", \"8 mm\"]\n\
         guides = [[\"20 mm\", \"5 mm\", \"8 mm\"], [\"50 mm\", \"5 mm\", \"8 mm\"]]\n{keys}\ndrive = {{ kind = \"{kind}\", signal = {signal} }}"
    )
}

fn ramp(to: &str, start: f64, end: f64) -> String {
    let unit = to.rsplit(' ').next().expect("a unit");
    format!("{{ kind = \"ramp\", from = \"0 {unit}\", to = \"{to}\", start = \"{start} ms\", end = \"{end} ms\" }}")
}

fn is_noted(scene: &Scene) -> bool {
    scene.notes.iter().any(|note| note.contains("within one step") && note.contains("an impact that grows"))
}

/// Every exact drive is looked at, and nothing else: tensions, elastic cables and drives that yield have a limit.
#[test]
fn jumps_of_exact_drives_are_noted() {
    let pressed =
        |signal: &str| format!("kind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"x\"\ndisplacement = {signal}");
    let turned = "kind = \"prescribed\"\nregion = \"xmax\"\nrotation = { axis = [1, 0, 0], about = [\"0 mm\", \"5 mm\", \"5 mm\"], angle = \
                  { kind = \"ramp\", from = \"0 deg\", to = \"30 deg\", start = \"2 ms\", end = \"2.2 ms\" } }";
    let noted = [
        cable("", "length", "\"2 mm\""),
        cable("", "length", &ramp("2 mm", 2.0, 2.2)),
        cable("friction = 0.1", "length", "\"2 mm\""),
        pressed(&ramp("2 mm", 2.0, 2.2)),
        turned.to_string(),
    ];
    for constraint in noted {
        assert!(is_noted(&bar(&constraint, 1.0)), "{constraint}");
    }
    let silent = [
        cable("", "length", &ramp("2 mm", 0.0, 4.0)),
        cable("", "length", "\"-2 mm\""),
        cable("EA = \"50 N\"", "length", "\"2 mm\""),
        cable("max_tension = \"1 N\"", "length", "\"2 mm\""),
        cable("", "tension", "\"0.1 N\""),
        pressed(&ramp("2 mm", 0.0, 4.0)),
        // A body is placed where its nodes begin.
        pressed("\"2 mm\""),
    ];
    for constraint in silent {
        assert!(!is_noted(&bar(&constraint, 1.0)), "{constraint}");
    }
}

/// The volume of a cavity is exact too.
#[test]
fn a_jump_of_a_volume_is_noted() {
    let shell = |signal: &str| {
        let planes = ["x", "y", "z"]
            .map(|c| format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{c}min\"\ncomponents = \"{c}\"\n"))
            .concat();
        let text = format!(
            "[mesh]\ngrid = {{ kind = \"octant\", inner = \"10 mm\", outer = \"12 mm\", divisions = [2, 1] }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.4\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[effect]]\nkind = \"inertia\"\nregion = \"body\"\ndensity = \"1000 kg/m^3\"\nmass = \"consistent\"\n{planes}\
             [[constraint]]\nkind = \"cavity\"\nregion = \"inner\"\ndrive = {{ kind = \"volume\", signal = {signal} }}\n\
             [[stage]]\nintegrator = \"bdf2\"\nduration = \"8 ms\"\ndt = \"1 ms\"\n"
        );
        parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
    };
    assert!(is_noted(&shell("\"0.1 ml\"")));
    assert!(!is_noted(&shell(&ramp("0.1 ml", 0.0, 4.0))));
}

/// The note is true: the tension after a jump grows with 1/Δt, that of a ramp over many steps does not.
#[test]
fn the_impact_of_a_jump_has_no_limit() {
    let peak = |signal: &str, dt: f64| {
        let run: Run = bar(&cable("", "length", signal), dt).run();
        let tension = run.column("cable_tension_N").expect("recorded");
        tension.into_iter().fold(0.0, larger)
    };
    let [jump, smooth] =
        ["\"2 mm\"".to_string(), ramp("2 mm", 0.0, 8.0)].map(|signal| peak(&signal, 0.25) / peak(&signal, 1.0));
    println!(
        "peak of the tension at a quarter of the step: {jump:.2} times after a jump, {smooth:.2} times over a ramp"
    );
    assert!(jump > 2.0 && smooth < 1.5, "{jump} {smooth}");
}
