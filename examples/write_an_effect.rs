//! Writes an effect outside of the library and adds it to a scene: a bed of springs that stiffen.
//!
//! The bed supports the lower face of a block; where the face is displaced by w in z, the bed has the energy per area
//! ½kw² + ¼cw⁴ and therefore the pressure kw + cw³ (a nonlinear Winkler foundation). A uniform pressure on the upper face
//! must then press the block into the bed by the w at which both pressures are equal.
//! Run with `cargo run --release --example write_an_effect`.

use durometer::prelude::*;

/// A bed of springs below a region of the surface.
struct Bed {
    /// One block per node: the unknowns that one evaluation reads and writes
    blocks: Blocks,
    /// \[blocks\] ∫ N_a dA, tributary area of the node \[m²\]
    area: Vec<f64>,
    /// k \[N/m³\]
    stiffness: f64,
    /// c \[N/m⁵\]
    stiffening: f64,
}

impl Bed {
    /// Creates a bed below the linear facets of a region.
    fn new(mesh: &TetMesh, region: &str, stiffness: f64, stiffening: f64) -> Result<Self, MeshError> {
        let region = mesh.region(region)?;
        let mut area = vec![0.0; mesh.points.len()];
        for &f in &region.facets {
            let nodes = mesh.facet(f as usize);
            let [a, b, c] = [0, 1, 2].map(|k| mesh.points[nodes[k] as usize]);
            for &node in nodes {
                area[node as usize] += (b - a).cross(&(c - a)).norm() / 6.0;
            }
        }
        let nodes = mesh.nodes_of(region);
        let area = nodes.iter().map(|&node| area[node as usize]).collect();
        Ok(Self { blocks: Blocks::new(nodes.chunks(1)), area, stiffness, stiffening })
    }

    /// Returns the pressure at the displacement w.
    fn pressure(&self, w: f64) -> f64 {
        self.stiffness * w + self.stiffening * w.powi(3)
    }
}

impl Effect for Bed {
    fn name(&self) -> &str {
        "bed"
    }

    /// The energy is stored, and the residual is its derivative.
    fn role(&self) -> EnergyRole {
        EnergyRole::Stored
    }

    fn blocks(&self) -> &Blocks {
        &self.blocks
    }

    /// Evaluates energy, residual r = ∂Π/∂u and tangent K = ∂r/∂u of one block, for the unknowns u_x, u_y, u_z of its node. The
    /// buffers are zero before the call.
    fn eval(&self, at: &At, b: usize, want: Want, out: &mut BlockValues) -> Result<(), EvalError> {
        let (area, node) = (self.area[b], self.blocks.nodes(b)[0] as usize);
        let w = at.x[3 * node + 2];
        out.energy = area * (0.5 * self.stiffness * w * w + 0.25 * self.stiffening * w.powi(4));
        out.r[2] = area * self.pressure(w);
        if want == Want::Tangent {
            // Row 2, column 2 of the 3 × 3 matrix
            out.k[8] = area * (self.stiffness + 3.0 * self.stiffening * w * w);
        }
        Ok(())
    }

    // This effect reads displacements only. One that reads velocities, carries history variables or finds contact says
    // so in `capabilities`.
}

/// Compares r with differences of the energy, and K with differences of r, in block 0.
fn check_derivatives(effect: &impl Effect, nodes: usize) -> Result<(), EvalError> {
    let values = |w: f64| {
        let mut state = State::rest(nodes, 0);
        state.x[3 * effect.blocks().nodes(0)[0] as usize + 2] = w;
        let mut out = BlockValues::new(3);
        effect.eval(&state.at(), 0, Want::Tangent, &mut out).map(|()| out)
    };
    let (w, h) = (-0.7e-3, 1e-6);
    let (before, here, after) = (values(w - h)?, values(w)?, values(w + h)?);
    let force = (after.energy - before.energy) / (2.0 * h);
    let stiffness = (after.r[2] - before.r[2]) / (2.0 * h);
    assert!((here.r[2] / force - 1.0).abs() < 1e-5, "r = {} N, differences give {force} N", here.r[2]);
    assert!((here.k[8] / stiffness - 1.0).abs() < 1e-5, "K = {} N/m, differences give {stiffness} N/m", here.k[8]);
    Ok(())
}

/// A block that can slide on its bed; a pressure of 4 kPa presses on its upper face.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["20 mm", "20 mm", "10 mm"], divisions = [4, 4, 2] }

[laws.silicone]
law = "neo_hookean"
E = "100 kPa"
nu = 0.3

[[effect]]
kind = "elastic"
region = "body"
law = "silicone"

[[effect]]
kind = "traction"
region = "zmax"
direction = [0, 0, -1]
traction = { kind = "ramp", from = "0 kPa", to = "4 kPa", end = "1 s" }

[[constraint]]
kind = "fixed"
region = "xmin"
components = "x"

[[constraint]]
kind = "fixed"
region = "ymin"
components = "y"

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.25 s"

[[probe]]
kind = "position"
region = "zmin"
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut builder = SceneBuilder::parse(SCENE)?;
    // The effect is built on the mesh of the scene: k w + c w³ = 2 kPa + 2 kPa at w = 1 mm.
    let body = builder.load()?;
    let bed = Bed::new(&body.mesh, "zmin", 2e6, 2e12)?;
    assert!((bed.pressure(1e-3) - 4e3).abs() < 1e-9);
    check_derivatives(&bed, body.mesh.points.len())?;

    let run = builder.effect(Box::new(bed)).build()?.run();
    assert_eq!(run.status, Status::Converged);
    let w = run.column("zmin_z_m").expect("the probe records it");
    println!("displacement of the lower face at each step [mm]: {:.4?}", w.iter().map(|w| 1e3 * w).collect::<Vec<_>>());
    let last = w[w.len() - 1];
    assert!((last + 1e-3).abs() < 1e-9, "the block is displaced by {last} m instead of -1 mm");
    Ok(())
}
