//! Measured curves of `[[compare]]`: the same curve in many spellings, with an uncertainty, and what is refused.

use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Measured, SceneBuilder};
use std::path::Path;

const SCENE: &str = r#"
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
[[constraint]]
kind = "fixed"
region = "xmin"
[[constraint]]
kind = "cable"
guides = [["15 mm", "5 mm", "2 mm"], ["35 mm", "5 mm", "2 mm"]]
pull_point = ["-10 mm", "5 mm", "2 mm"]
guide_radius = "5 mm"
drive = { kind = "length", signal = "1 mm" }
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[compare]]
column = "cable_tension_N"
file = "measured.csv"
"#;

/// The curve of a table as a scene reads it with these keys of `[[compare]]`, or the refusal.
pub fn read(folder: &Path, table: &[u8], keys: &str) -> Result<Measured, String> {
    std::fs::write(folder.join("measured.csv"), table).expect("writable");
    let text = format!("{SCENE}{keys}\n");
    let builder = SceneBuilder::parse(&text).map_err(|e| e.to_string())?.file(folder.join("scene.toml")).text(&text);
    let scene = builder.mesh(block(4, 1, 1, 0.04, 0.01, 0.01, Order::Linear)).build().map_err(|e| e.to_string())?;
    Ok(scene.measured.curves[0].clone())
}

const STATED: &str = "x = { column = \"t\", unit = \"ms\" }\ny = { column = \"F\", unit = \"mN\" }";
pub const OF_THE_TABLE: &str = "x = { column = \"t\" }\ny = { column = \"F\" }";

/// t = 0, 0.5, 1 s and F = 0, 1.25, 2.5 N, however the table is written.
#[test]
fn a_curve_is_read_in_every_spelling() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let utf16: Vec<u8> =
        "\u{feff}t [ms]\tF [mN]\n0\t0\n500\t1250\n1000\t2500\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for (table, keys) in [
        (&b"t,F\n0,0\n500,1250\n1000,2500\n"[..], STATED),
        (b"t;F\n0,0;0,0\n500,0;1250,0\n1000,0;2500,0\n", STATED),
        (b"Machine;7\n\nt;F\nms;mN\n0;0\n500;1250\n1000;2500\n\n", STATED),
        (b"Machine;7\n\nt;F\nms;N\n0;0\n500;1,25\n1000;2,5\n", OF_THE_TABLE),
        (b"t [s],F (N)\n0,0\n0.5,1.25\n1,2.5\n", OF_THE_TABLE),
        (b"t [ms],F [mN]\n0,0\n500,1250\n1000,2500\n", STATED),
        (&utf16, OF_THE_TABLE),
    ] {
        let m = read(folder.path(), table, keys).unwrap_or_else(|e| panic!("{e}\n{}", String::from_utf8_lossy(table)));
        let near = |own: &[f64], wanted: [f64; 3]| {
            own.len() == 3 && own.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12)
        };
        assert!(
            near(&m.x, [0.0, 0.5, 1.0]) && near(&m.y, [0.0, 1.25, 2.5]),
            "{m:?}\n{}",
            String::from_utf8_lossy(table)
        );
        assert!(m.half_widths.is_empty());
    }
}

/// The half-widths are in the unit of the recorded column, and negative ones are refused.
#[test]
fn an_uncertainty_is_read_with_the_curve() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let keys = format!("{OF_THE_TABLE}\nuncertainty = {{ column = \"u(F)\", unit = \"mN\" }}");
    let table = "t [s];F [N];u(F)\n0;0;10\n0,5;1,25;20,5\n1;2,5;30\n";
    let m = read(folder.path(), table.as_bytes(), &keys).unwrap_or_else(|e| panic!("{e}"));
    assert!(m.half_widths.iter().zip([0.01, 0.0205, 0.03]).all(|(a, b)| (a - b).abs() < 1e-15), "{m:?}");
    let error = read(folder.path(), table.replace("20,5", "-20,5").as_bytes(), &keys).expect_err("negative");
    assert!(error.contains("line 3: the uncertainty -20.5") && error.contains("half-width"), "{error}");
}

/// Tables that may be read in two ways, or not at all, are refused with file, line and remedy.
#[test]
fn ambiguous_curves_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (table, keys, facts) in [
        ("t,F\n0,0\n0,5,1,25\n", STATED, ["line 3 has 4 cells under 2 names", "export it with ;"]),
        ("t;F\n1,234;2\n2,345;3\n", STATED, ["\"1,234\" may be a decimal fraction", "without separators"]),
        ("t [s],F [N]\n0,0\n1,2\n", STATED, ["is in s by the table and in ms by the scene", "leave out `unit`"]),
        ("t,F\n0,0\n1,2\n", OF_THE_TABLE, ["column \"t\" has no unit", "unit = "]),
        ("t [s],F [mm]\n0,0\n1,2\n", OF_THE_TABLE, ["the unit \"mm\" of the table cannot be taken", "in the scene"]),
        ("t,G\n0,0\n1,2\n", STATED, ["there is no column \"F\"", "t, G"]),
        ("t,F\n0,0\n1,x\n", STATED, ["line 3: \"x\" in column F is not a finite number", "remove the line"]),
    ] {
        let error = read(folder.path(), table.as_bytes(), keys).expect_err(table);
        assert!(facts.iter().all(|fact| error.contains(fact)), "{table}: {error}");
    }
}
