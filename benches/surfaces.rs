//! Time of search and collision detection of two deformable surfaces, by their number of triangles: two sheets of waves that face each other,
//! near enough that a part of their points is felt. Prints the time per triangle and the slope of its logarithm.

use cpu_time::ThreadTime;
use durometer::effect::contact::surfaces::surface::Surface;
use durometer::effect::contact::surfaces::{Surfaces, max_step};
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::Order;
use durometer::mesh::parts::{image, side_by_side};
use durometer::mesh::structured::block;
use durometer::system::Caches;

/// Repetitions, of which the fastest counts.
const TIMES: usize = 5;

fn main() {
    println!("triangles   search [ms]   µs a triangle   detection [ms]   µs a triangle   terms");
    let mut rows = Vec::new();
    for n in [16, 28, 50, 89, 158] {
        let (triangles, [search, detection], terms) = sheets(n);
        let each = |s: f64| 1e6 * s / triangles as f64;
        println!(
            "{triangles:9}   {:11.2}   {:13.2}   {:14.2}   {:13.2}   {terms:5}",
            1e3 * search,
            each(search),
            1e3 * detection,
            each(detection)
        );
        rows.push((triangles as f64, search, detection));
    }
    let slope = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
        let logs: Vec<(f64, f64)> = rows.iter().map(|r| (r.0.ln(), value(r).ln())).collect();
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
    };
    println!("time ~ triangles^{:.2} (search), ^{:.2} (detection)", slope(&|r| r.1), slope(&|r| r.2));
}

/// Triangles, CPU seconds of a search and of a detection, and terms, of two sheets of n × n squares with sides of 1 mm.
fn sheets(n: usize) -> (usize, [f64; 2], usize) {
    let size = 1e-3 * n as f64;
    let sheet = block(n, n, 1, size, size, 1e-3, Order::Linear);
    let above = image(&sheet, &Mat3::identity(), &(Vec3::z() * 1.02e-3));
    let mesh = side_by_side(&[("a".into(), sheet), ("b".into(), above)]).expect("two");
    let surface = |name: &str| Surface::new(&mesh, &mesh.regions[name].facets);
    let (first, second) = (surface("b.zmin"), surface("a.zmax"));
    let triangles = first.triangles.len() + second.triangles.len();
    let surfaces = Surfaces::new("sheets".into(), first, Some(second), mesh.points.clone(), 2e-5);
    let upper = mesh.points.len() / 2;
    // Waves of 10 mm bring the sheets together to 12 µm; each state is further from the last than the margin of the candidates.
    let wave = |shift: f64| -> Vec<f64> {
        let lift = |(k, p): (usize, &Vec3)| {
            let own = if k < upper { 0.0 } else { -8e-6 * (600.0 * p.x).sin() * (600.0 * p.y).cos() };
            [shift, 0.0, own]
        };
        mesh.points.iter().enumerate().flat_map(lift).collect()
    };
    let mut caches = Caches::default();
    let (mut best, mut terms) = ([f64::INFINITY; 2], 0);
    for k in 0..TIMES {
        let x = wave(1e-3 * k as f64);
        let start = ThreadTime::now();
        terms = surfaces.terms(&x, &mut caches).len();
        best[0] = best[0].min(start.elapsed().as_secs_f64());
        let dx: Vec<f64> = (0..x.len()).map(|i| if i >= 3 * upper && i % 3 == 2 { -5e-5 } else { 0.0 }).collect();
        let start = ThreadTime::now();
        max_step(&surfaces, &x, &dx, &mut caches);
        best[1] = best[1].min(start.elapsed().as_secs_f64());
    }
    (triangles, best, terms)
}
