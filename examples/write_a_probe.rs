//! Writes a probe outside of the library: the volume of the deformed body, as two columns of the results.
//!
//! A block is stretched by 20 % in x while its sides are held in y and z: its volume must grow by 20 %.
//! Run with `cargo run --release --example write_a_probe`.

use durometer::prelude::*;

/// Volume of a deformed body of linear cells.
struct Volume {
    /// Volume at rest \[m³\]
    rest: f64,
}

/// Sum over the cells of ⅙ det of three edges, with the nodes at X + u.
fn volume(mesh: &TetMesh, u: &[f64]) -> f64 {
    let position = |node: u32| mesh.points[node as usize] + Vec3::from_column_slice(&u[3 * node as usize..][..3]);
    let one = |cell: usize| {
        let nodes = mesh.cell(cell);
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| position(nodes[k]));
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    };
    (0..mesh.cell_count()).map(one).sum()
}

/// The columns are written at every step. The `[[probe]]`s of a scene file implement the same trait.
impl Recorder for Volume {
    /// Returns the column names, which end with their unit.
    fn columns(&self) -> Vec<String> {
        vec!["volume_m3".into(), "volume_ratio".into()]
    }

    fn record(&self, now: &Moment) -> Vec<f64> {
        let volume = volume(&now.body.mesh, &now.state.x);
        vec![volume, volume / self.rest]
    }
}

const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "10 mm", "10 mm"], divisions = [4, 2, 2] }

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.45

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[constraint]]
kind = "fixed"
region = "xmin"
components = "x"

[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"

[[constraint]]
kind = "fixed"
region = "ymax"
components = "y"

[[constraint]]
kind = "fixed"
region = "zmin"
components = "z"

[[constraint]]
kind = "fixed"
region = "zmax"
components = "z"

[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "4 mm", end = "1 s" }

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut builder = SceneBuilder::parse(SCENE)?;
    let mesh = &builder.load()?.mesh;
    let rest = volume(mesh, &vec![0.0; 3 * mesh.points.len()]);
    assert!((rest / 2e-6 - 1.0).abs() < 1e-12, "the block of 20 × 10 × 10 mm has {rest} m³");

    let run = builder.recorder(Box::new(Volume { rest })).build()?.run();
    assert_eq!(run.status, Status::Converged);
    // The columns are part of the results, like those of the probes of the scene.
    let time = run.column("t_s").expect("always recorded");
    let ratio = run.column("volume_ratio").expect("recorded by the probe of this file");
    for (t, ratio) in time.iter().zip(&ratio) {
        println!("t = {t:.1} s   V/V₀ = {ratio:.6}");
        assert!((ratio - (1.0 + 0.2 * t)).abs() < 1e-9, "V/V₀ = {ratio} at {t} s");
    }
    Ok(())
}
