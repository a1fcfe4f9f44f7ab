//! Families of fibres: differences, invariances, and closed forms of uniaxial and biaxial tension and of helices about an axis.

use crate::common::{Random, column, run, scene};
use durometer::material::Want;
use durometer::material::fibre_family::FibreFamily;
use durometer::math::statistics::larger;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::curved::tube;
use durometer::mesh::structured::block;
use durometer::scene::Scene;
use durometer::system::{At, BlockValues, Rates};

const FAMILIES: [FibreFamily; 4] = [
    FibreFamily { k1: 2e4, k2: 0.0, kappa: 0.0 },
    FibreFamily { k1: 2e4, k2: 3.0, kappa: 0.0 },
    FibreFamily { k1: 2e4, k2: 3.0, kappa: 0.2 },
    FibreFamily { k1: 2e4, k2: 3.0, kappa: 1.0 / 3.0 },
];

/// D₆ of g at 0 with steps s, s/2, s/4: truncation (s/ρ)⁶/64 with ρ ≈ 0.1, rounding 7 ε/s, together 1e-11 of the size at s = 2e-3.
fn difference(g: impl Fn(f64) -> f64) -> f64 {
    let s = 2e-3;
    let [a, b, c] = [s, s / 2.0, s / 4.0].map(|s| (g(s) - g(-s)) / (2.0 * s));
    (64.0 * c - 20.0 * b + a) / 45.0
}

/// P and A are the derivatives of ψ, A is symmetric, ψ does not see rotations or changes of volume. Stretched by 1.3 on the mean, so
/// that the fibres are taut within the differences.
#[test]
fn stress_and_tangent_are_derivatives() {
    let mut random = Random::seed(8);
    let turn = *nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0).matrix();
    for family in FAMILIES {
        for _ in 0..20 {
            let a = Vec3::from_fn(|_, _| random.around(1.0)).normalize();
            let taut = Mat3::identity() * 0.9 + a * a.transpose() * 0.45;
            let f = taut + Mat3::from_fn(|_, _| random.around(0.05));
            let at = |f: &Mat3| family.eval(&a, f, Want::Tangent).expect("defined");
            let r = at(&f);
            let size = r.a.as_flattened().iter().fold(0.0, |m, x| larger(m, x.abs()));
            assert!(r.psi > 0.0 && size > 0.0);
            for column in 0..9 {
                let moved = |h: f64| {
                    let mut f = f;
                    f[(column / 3, column % 3)] += h;
                    f
                };
                let slope = difference(|h| at(&moved(h)).psi);
                assert!((r.p[(column / 3, column % 3)] - slope).abs() <= 1e-9 * size, "{family:?} P[{column}]");
                for row in 0..9 {
                    let slope = difference(|h| at(&moved(h)).p[(row / 3, row % 3)]);
                    assert!((r.a[row][column] - slope).abs() <= 1e-8 * size, "{family:?} A[{row}][{column}]");
                    assert!((r.a[row][column] - r.a[column][row]).abs() <= 1e-13 * size);
                }
            }
            for same in [turn * f, f * 1.7] {
                assert!((at(&same).psi - r.psi).abs() <= 1e-12 * size, "{family:?}");
            }
        }
        let a = Vec3::x();
        let rest = family.eval(&a, &Mat3::identity(), Want::Tangent).expect("defined");
        assert_eq!((rest.psi, rest.p), (0.0, Mat3::zeros()));
        let shorter = Mat3::from_diagonal(&Vec3::new(0.8, 1.0, 1.0 / 0.8));
        let along = family.eval(&a, &shorter, Want::Tangent).expect("defined");
        assert!(family.kappa > 0.0 || along.psi == 0.0, "aligned fibres are slack in compression");
    }
    assert!(FAMILIES[1].eval(&Vec3::x(), &Mat3::from_diagonal(&Vec3::new(6.0, 0.4, 0.4)), Want::Energy).is_err());
}

/// A block of 1 m whose end in x is moved, with these constants of Poisson and of fibres.
fn block_in_tension(nu: f64, family: &str, to: &str, held: &str) -> Scene {
    let text = format!(
        r#"
[mesh]
body = "block"
[laws.rubber]
law = "neo_hookean_split"
E = "60 kPa"
nu = {nu}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "fibre_family"
region = "body"
{family}
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
region = "zmin"
components = "z"
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "ramp", from = "0 m", to = "{to}", end = "1 s" }}
{held}
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.1 s"
[[probe]]
kind = "reaction"
region = "xmax"
[[probe]]
kind = "reaction"
region = "ymax"
"#
    );
    scene(block(2, 1, 1, 1.0, 1.0, 1.0, Order::Quadratic), &text)
}

/// A block in tension, x and y prescribed or free.
fn tension(family: &str, held: &str) -> (f64, f64) {
    let run = run(&block_in_tension(0.49999, family, "0.3 m", held));
    let last = |name: &str| *column(&run, name).last().expect("a row");
    (last("xmax_reaction_x_N"), last("ymax_reaction_y_N"))
}

/// Fibres along x, λ = 1.3, incompressible: P = μ(λ − λ⁻²) + 2λ k₁ E exp(k₂ E²), E = λ² − 1. At ν = 0.49999 J differs from 1 by about P/κ = 1e-4.
#[test]
fn uniaxial_tension_along_the_fibres() {
    let (mu, k1, k2, l) = (20e3, 30e3, 0.5, 1.3_f64);
    let family = "k1 = \"30 kPa\"\nk2 = 0.5\nkappa = 0.0\ndirection = { kind = \"constant\", vectors = [[2, 0, 0]] }";
    let (force, _) = tension(family, "");
    let e = l * l - 1.0;
    let exact = mu * (l - l.powi(-2)) + 2.0 * l * k1 * e * (k2 * e * e).exp();
    assert!((force / exact - 1.0).abs() < 1e-3, "{force} N, closed form {exact} N");
}

/// In a compressible body a growth of volume relieves the fibres: 1/E = 1/9K + 1/(3G + 4k₁) at small strains, here 1e-4. Fibres that are stiff against K are
/// noted.
#[test]
fn fibres_in_a_compressible_body_are_relieved() {
    for (nu, k1, noted) in [(0.4, 200e3, true), (0.4, 10e3, false), (0.4999, 200e3, false)] {
        let family = format!(
            "k1 = \"{k1} Pa\"\nk2 = 0\nkappa = 0\ndirection = {{ kind = \"constant\", vectors = [[1, 0, 0]] }}"
        );
        let scene = block_in_tension(nu, &family, "0.1 mm", "");
        let (shear, bulk) = (60e3 / (2.0 + 2.0 * nu), 60e3 / (3.0 - 6.0 * nu));
        let modulus = 1.0 / (1.0 / (9.0 * bulk) + 1.0 / (3.0 * shear + 4.0 * k1));
        let found = column(&run(&scene), "xmax_reaction_x_N").last().expect("a row") / 1e-4;
        assert!((found / modulus - 1.0).abs() < 1e-3, "{nu} {k1}: {found} Pa, closed form {modulus} Pa");
        assert_eq!(scene.notes.iter().any(|note| note.contains("stiff against the bulk modulus")), noted, "{nu} {k1}");
    }
}

/// Two families at ±35° to x in the plane, dispersed, stretched by λ₁ = 1.3 and λ₂ = 1.1: P_i = ∂ψ̂/∂λ_i of ψ̂(λ₁, λ₂) with
/// Ē = κ(I₁ − 3) + (1 − 3κ)(λ₁² cos² + λ₂² sin² − 1); shear cancels.
#[test]
fn biaxial_tension_of_two_families() {
    let (mu, k1, k2, kappa, alpha) = (20e3, 30e3, 0.5, 0.1, 35f64.to_radians());
    let (l1, l2) = (1.3_f64, 1.1_f64);
    let family = format!(
        "k1 = \"30 kPa\"\nk2 = 0.5\nkappa = 0.1\ndirection = {{ kind = \"constant\", vectors = [[{c}, {s}, 0], [{c}, -{s}, 0]] }}",
        c = alpha.cos(),
        s = alpha.sin()
    );
    let held = "[[constraint]]\nkind = \"prescribed\"\nregion = \"ymax\"\ncomponents = \"y\"\n\
                displacement = { kind = \"ramp\", from = \"0 m\", to = \"0.1 m\", end = \"1 s\" }";
    let (x, y) = tension(&family, held);
    let l3 = 1.0 / (l1 * l2);
    let [i1, i4] = [l1 * l1 + l2 * l2 + l3 * l3, (l1 * alpha.cos()).powi(2) + (l2 * alpha.sin()).powi(2)];
    let e = kappa * (i1 - 3.0) + (1.0 - 3.0 * kappa) * (i4 - 1.0);
    let slope = 2.0 * k1 * e * (k2 * e * e).exp();
    // ∂I₁/∂λ_i = 2(λ_i − λ₃²/λ_i)
    let stress = |l: f64, share: f64| {
        let by_i1 = 2.0 * (l - l3 * l3 / l);
        0.5 * mu * by_i1 + slope * (kappa * by_i1 + (1.0 - 3.0 * kappa) * 2.0 * l * share)
    };
    let exact = [stress(l1, alpha.cos().powi(2)), stress(l2, alpha.sin().powi(2))];
    assert!((x / exact[0] - 1.0).abs() < 1e-3, "{x} N, closed form {} N", exact[0]);
    assert!((y / exact[1] - 1.0).abs() < 1e-3, "{y} N, closed form {} N", exact[1]);
}

/// Helices at 40° about the axis of a tube, which shrinks to 0.95 in width and grows by 1.4 in length: every fibre has λ² = 1.4² cos² + 0.95² sin², so
/// the energy is that of one fibre times the volume, exactly.
#[test]
fn helices_about_an_axis_stretch_alike_all_round() {
    let text = r#"
[mesh]
body = "tube"
[laws.rubber]
law = "neo_hookean"
E = "60 kPa"
nu = 0.45
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
[[effect]]
kind = "fibre_family"
region = "body"
k1 = "30 kPa"
k2 = 0.5
kappa = 0.0
direction = { kind = "helical", axis = [["0 m", "0 m", "0 m"], ["0 m", "0 m", "1 m"]], angle = "40 deg", hand = "both" }
[[constraint]]
kind = "fixed"
region = "zmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "1 s"
"#;
    let mesh = tube([0.02, 0.03], 0.05, [1, 8, 2], Order::Quadratic);
    let scene = scene(mesh, text);
    let (wide, long, alpha) = (0.95_f64, 1.4_f64, 40f64.to_radians());
    let grown = Vec3::new(wide - 1.0, wide - 1.0, long - 1.0);
    let x: Vec<f64> = scene.points.iter().flat_map(|p| <[f64; 3]>::from(p.component_mul(&grown))).collect();
    let zero = vec![0.0; x.len()];
    let at =
        At { t: 0.0, dt: 1.0, x: &x, v: &zero, a: &zero, old: &x, history: &[], inputs: &[], rates: Rates::default() };
    let effect = &scene.system.effects[1];
    assert_eq!(effect.name(), "fibre_family");
    let energy: f64 = (0..effect.blocks().len())
        .map(|b| {
            let mut out = BlockValues::new(effect.blocks().size(b));
            effect.eval(&at, b, Want::Energy, &mut out).expect("regular");
            out.energy
        })
        .sum();
    let stretched = (long * alpha.cos()).powi(2) + (wide * alpha.sin()).powi(2);
    let e = stretched * (wide * wide * long).powf(-2.0 / 3.0) - 1.0;
    // The four points of a curved cell integrate its volume to 1e-5.
    let exact = 2.0 * scene.body.mesh.volume() * 30e3 / (2.0 * 0.5) * (0.5 * e * e).exp_m1();
    assert!((energy / exact - 1.0).abs() < 1e-3, "{energy} J, by hand {exact} J");
}
