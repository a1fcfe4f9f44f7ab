//! Writes a constitutive law outside of the library, checks it, and runs a scene with it.
//!
//! The law is compressible Neo-Hookean with the volumetric part ½λ(J − 1)² (Simo & Pister 1984):
//!
//! ψ = ½μ(I₁ − 3) − μ ln J + ½λ(J − 1)²
//!
//! Run with `cargo run --release --example write_a_law`.

use durometer::prelude::*;

static INFO: LawInfo = LawInfo {
    name: "simo_pister",
    title: "Simo–Pister",
    formula: "ψ = ½μ(I₁ − 3) − μ ln J + ½λ(J − 1)²",
    source: "Simo & Pister 1984",
    limits: "J > 0",
    parameters: moduli::PAIR,
    optional: 0,
    choices: &[],
    survives_inversion: false,
    objective: true,
    isochoric: false,
};

/// The law with its constants, stored as all five elastic moduli.
#[derive(Clone, Copy, Debug)]
struct SimoPister(Moduli);

impl Law for SimoPister {
    fn info(&self) -> &'static LawInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.0.e, self.0.nu]
    }

    fn small_strain(&self) -> Moduli {
        self.0
    }

    fn eval(&self, f: &Mat3, want: Want) -> Result<Response, LawError> {
        let Moduli { mu, lambda, .. } = self.0;
        // Invariants computed from F − I stay accurate at small strain: J − 1, and I₁ − 3 − 2 ln J.
        let k = Invariants::of_positive(f)?;
        let (j, x) = (k.j, k.x);
        let mut response = Response::energy(0.5 * mu * k.i_2ln(k.ln_j()) + 0.5 * lambda * x * x);
        if want < Want::Residual {
            return Ok(response);
        }
        // P = μ(F − G) + λ(J − 1)J G with G = F⁻ᵀ
        let g = k.cof / j;
        response.p = mu * (f - g) + lambda * x * j * g;
        if want == Want::Tangent {
            // A_iJkL = μ δ_ik δ_JL + λ(2J − 1)J G_iJ G_kL + (μ − λ(J − 1)J) G_iL G_kJ
            let (direct, crossed) = (lambda * (2.0 * j - 1.0) * j, mu - lambda * x * j);
            for (row, col) in (0..81).map(|n| (n / 9, n % 9)) {
                let (i, jj, kk, l) = (row / 3, row % 3, col / 3, col % 3);
                let identity = if row == col { mu } else { 0.0 };
                response.a[row][col] = identity + direct * g[(i, jj)] * g[(kk, l)] + crossed * g[(i, l)] * g[(kk, jj)];
            }
        }
        Ok(response)
    }

    /// ψ is linear in μ and λ, so its derivative with respect to a parameter is the same function of their rates.
    fn along(&self, rates: &[f64]) -> Box<dyn Law> {
        Box::new(Self(self.0.along(rates)))
    }
}

/// A cube of 10 mm with one face clamped, pulled by 2 mm at the other.
const SCENE: &str = r#"
[mesh]
grid = { kind = "box", size = ["10 mm", "10 mm", "10 mm"], divisions = [3, 3, 3] }

[laws.rubber]
law = "simo_pister"
E = "100 kPa"
nu = 0.4

[[effect]]
kind = "elastic"
region = "body"
law = "rubber"

[[constraint]]
kind = "fixed"
region = "xmin"

[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = { kind = "ramp", from = "0 mm", to = "2 mm", end = "1 s" }

[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"

[[probe]]
kind = "energy"
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // One line makes the law known to scenes, studies and `law_from_table`.
    let entry = register(LawEntry::elastic(&INFO, |values, _| Ok(Box::new(SimoPister(Moduli::from_map(values)?)))))?;

    // Finite differences of ψ and P at random states, objectivity, small strain, refusal of J ≤ 0, and more.
    check_law(entry)?;
    println!("{}: {} has every property of a law", INFO.name, INFO.formula);

    let scene = parse_scene(SCENE)?;
    let run = scene.run();
    assert_eq!(run.status, Status::Converged);
    let energy = run.column("elastic_J").expect("the probe records it");
    let last = energy[energy.len() - 1];
    println!("stored energy at 20 % stretch: {last:.3e} J");
    // A free bar would store ½Eε²V = 2 mJ; clamped ends and finite strain change that by less than a third.
    assert!((1.4e-3..2.7e-3).contains(&last));
    Ok(())
}
