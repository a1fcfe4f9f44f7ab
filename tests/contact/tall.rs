//! Tall rigid boxes on a plane with friction: they land, rest, slide and tip.

use crate::common::{column, run, scene, threads};
use crate::setup::CUBE;
use durometer::math::statistics::larger;
use durometer::mesh::Order;
use durometer::mesh::structured::block;
use durometer::scene::{Run, Scene};
use durometer::solve::Status;

const GRAVITY: f64 = 9.81;
/// Height of the boxes \[mm\]
const HEIGHT: f64 = 60.0;
const EULER: &str = r#""implicit_euler""#;
const ALPHA: &str = r#"{ kind = "generalised_alpha", rho = 0.8 }"#;

/// A box on a plane of this slope, as gravity that is inclined.
#[derive(Clone, Copy, Debug)]
struct Tower {
    /// \[mm\]
    width: f64,
    /// tan φ \[–\]
    slope: f64,
    friction: f64,
    /// Above the plane \[mm\]
    gap: f64,
    /// About its middle at the start \[rad/s\]
    spin: [f64; 2],
}

impl Tower {
    fn scene(self, integrator: &str, dt: f64, seconds: f64) -> Scene {
        let (sin, cos) = self.slope.atan().sin_cos();
        let (half, gap) = (0.5 * self.width, self.gap);
        let text = format!(
            r#"{CUBE}
[[constraint]]
kind = "fixed"
region = "body"
[[rigid]]
name = "tower"
shape = {{ kind = "box", min = ["-{half} mm", "-{half} mm", "0 mm"], max = ["{half} mm", "{half} mm", "{HEIGHT} mm"] }}
density = "1000 kg/m^3"
gravity = {{ direction = [{sin}, 0, -{cos}], acceleration = "{GRAVITY} m/s^2" }}
spin = ["{} rad/s", "{} rad/s", "0 rad/s"]
[[contact]]
name = "floor"
region = "tower"
obstacle = {{ kind = "floor", point = ["0 mm", "0 mm", "-{gap} mm"], normal = [0, 0, 1] }}
response = "multiplier"
friction = {}
[[stage]]
integrator = {integrator}
duration = "{seconds} s"
dt = "{dt} s"
"#,
            self.spin[0], self.spin[1], self.friction
        );
        let mut mesh = block(1, 1, 1, 0.01, 0.01, 0.01, Order::Linear);
        mesh.points.iter_mut().for_each(|p| p.x += 0.5);
        scene(mesh, &text)
    }

    fn run(self, integrator: &str, dt: f64, seconds: f64) -> Run {
        let run = run(&self.scene(integrator, dt, seconds));
        assert_eq!(run.status, Status::Converged, "{self:?}, {integrator}, {dt} s");
        run
    }
}

/// Boxes that fall 1 mm while they turn, on a level plane and on slopes on which they come to rest.
fn landing_towers() -> impl Iterator<Item = Tower> {
    let sizes = [20.0, 10.0].into_iter().flat_map(|width| [0.0, 0.035, 0.0875].map(|slope| (width, slope)));
    sizes.flat_map(|(width, slope)| {
        [0.3, 0.8].map(|friction| Tower { width, slope, friction, gap: 1.0, spin: [0.1, 0.5] })
    })
}

/// Corrections solve impacts and rests of boxes on four corners: steps are not given up. Forces of friction that were as exact as the displacements of a
/// sweep, 10⁻¹⁰ of the largest, let the residual stall at twice its tolerance, and up to 3600 iterations of a run were for nothing. The forces stay in their cone.
#[test]
fn tall_boxes_land_in_few_iterations() {
    let (mut all, mut in_vain) = (0, 0);
    for tower in landing_towers() {
        for dt in [5e-4, 1e-3, 2e-3, 5e-3] {
            let run = tower.run(EULER, dt, 0.3);
            let (tried, steps) = (run.tried_iterations, run.totals.steps);
            println!(
                "{tower:?}, {dt} s: {steps} steps, {} of {tried}, {} cuts",
                run.totals.iterations, run.totals.cuts
            );
            let [x, y, z] = ["x", "y", "z"].map(|axis| column(&run, &format!("floor_force_{axis}_N")));
            for ((x, y), z) in x.iter().zip(&y).zip(&z) {
                assert!(x.hypot(*y) <= tower.friction * z * (1.0 + 1e-8), "{tower:?}, {dt} s: {x} {y} {z}");
            }
            (all, in_vain) = (all + tried, in_vain + tried - run.totals.iterations);
        }
    }
    println!("{in_vain} of {all} in vain");
    assert!(in_vain < all / 20, "{in_vain} of {all} iterations for nothing");
}

/// A box that falls 1 mm and turns never comes higher than it started, but for its energy of turning, 5 µm: the velocities of an impact are those of a rigid body.
#[test]
fn tall_boxes_are_not_thrown_up_by_generalised_alpha() {
    for tower in landing_towers().filter(|tower| tower.slope == 0.0) {
        for dt in [5e-4, 1e-3, 2e-3, 5e-3] {
            let run = tower.run(ALPHA, dt, 0.3);
            let z = column(&run, "tower_z_m");
            let highest = z.iter().fold(0.0, |m, z| larger(m, *z));
            println!("{tower:?}, {dt} s: {highest} m, {} iterations", run.tried_iterations);
            assert!(run.energy_from_nothing.is_none() && highest < z[0] + 5e-6, "{tower:?}, {dt} s: {highest} m");
        }
    }
}

/// A box at rest tips about its lower edge where tan φ > b/h: θ̈ = 3g/4r sin(φ − atan(b/h) + θ) with the half diagonal r, integrated by Runge & Kutta. Implicit
/// Euler has an error of first order in Δt. Below it stays.
#[test]
fn a_box_tips_beyond_the_slope_of_its_diagonal() {
    let (b, h) = (0.02f64, 1e-3 * HEIGHT);
    let (r, diagonal) = (0.5 * b.hypot(h), (b / h).atan());
    let tower = |share: f64| Tower { width: 1e3 * b, slope: share * b / h, friction: 0.8, gap: 0.0, spin: [0.0; 2] };
    let x = |share: f64, dt: f64| *column(&tower(share).run(EULER, dt, 0.25), "tower_x_m").last().expect("rows");
    assert!(x(0.95, 2e-3).abs() < 1e-7, "{}", x(0.95, 2e-3));
    let slope = (1.05 * b / h).atan();
    let (mut theta, mut rate, step) = (0.0f64, 0.0f64, 1e-4);
    let turn = |theta: f64| 0.75 * GRAVITY / r * (slope - diagonal + theta).sin();
    for _ in 0..2500 {
        let k1 = (rate, turn(theta));
        let k2 = (rate + 0.5 * step * k1.1, turn(theta + 0.5 * step * k1.0));
        let k3 = (rate + 0.5 * step * k2.1, turn(theta + 0.5 * step * k2.0));
        let k4 = (rate + step * k3.1, turn(theta + step * k3.0));
        theta += step / 6.0 * (k1.0 + 2.0 * k2.0 + 2.0 * k3.0 + k4.0);
        rate += step / 6.0 * (k1.1 + 2.0 * k2.1 + 2.0 * k3.1 + k4.1);
    }
    let exact = 0.5 * b + r * (theta - diagonal).sin();
    let errors = [1e-3, 5e-4].map(|dt| (x(1.05, dt) - exact).abs());
    println!("{theta} rad, {exact} m: {errors:?}");
    assert!((errors[0] / errors[1] - 2.0).abs() < 0.2, "{errors:?} of {exact} m");
    assert!(errors[1] < 0.1 * exact, "{errors:?} of {exact} m");
}

/// A box slides where tan φ > μ, by implicit Euler over g (sin φ − μ cos φ) Δt² n (n + 1)/2, but for its elastic slip, and stays where tan φ < μ, both within a
/// hundredth of μ. It falls by the same rule, and lands in the first step that would end inside.
#[test]
fn a_tall_box_slides_beyond_the_slope_of_its_friction() {
    let (friction, dt) = (0.3, 2e-3);
    for share in [0.99, 1.01] {
        let slope: f64 = share * friction;
        let run = Tower { width: 20.0, slope, friction, gap: 0.0, spin: [0.0; 2] }.run(EULER, dt, 0.25);
        let x = column(&run, "tower_x_m");
        let (sin, cos) = slope.atan().sin_cos();
        let acceleration = f64::max(0.0, GRAVITY * (sin - friction * cos));
        let n = (x.len() - 1) as f64;
        let expected = 0.5 * acceleration * dt * dt * n * (n + 1.0);
        let way = x[x.len() - 1] - x[0];
        println!("{share}: {way} {expected}");
        assert!((way - expected).abs() < 1e-7 + 1e-3 * expected, "{share}: {way} for {expected}");
    }
    let run = Tower { width: 20.0, slope: 0.0, friction, gap: 1.0, spin: [0.0; 2] }.run(EULER, dt, 0.05);
    let forces = column(&run, "floor_force_z_N");
    let landed = forces.iter().position(|f| *f > 0.0).expect("it lands");
    let first = (1..).find(|n| 0.5 * GRAVITY * dt * dt * f64::from(n * (n + 1)) > 1e-3).expect("it falls");
    assert_eq!(landed, first as usize);
}

/// The same bits from one, two and three threads.
#[test]
fn tall_boxes_have_the_same_bits_on_any_number_of_threads() {
    let tower = Tower { width: 20.0, slope: 0.035, friction: 0.8, gap: 1.0, spin: [0.1, 0.5] };
    let bits = |count: usize| {
        let run = threads::on(count, || tower.run(ALPHA, 2e-3, 0.1));
        run.last.x.iter().map(|x| x.to_bits()).collect::<Vec<u64>>()
    };
    let one = bits(1);
    assert_eq!(one, bits(2));
    assert_eq!(one, bits(3));
}
