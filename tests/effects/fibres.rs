//! Embedded elastic fibres against sums by hand and closed forms: affine motions, slack fibres, a reinforced bar, a wound tube.

use crate::common;
use crate::common::{DeadLoad, distorted_cube, elastic, hold, law, move_to, nodes, ramp, reaction, statics};
use durometer::effect::{FibrePoint, Fibres};
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::attach::attach;
use durometer::mesh::curved::tube;
use durometer::mesh::polyline::{Helix, cut};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::system::{At, BlockValues, Effect, Rates, System, Want};
use std::f64::consts::{PI, TAU};

fn points(mesh: &TetMesh, line: &[Vec3], reach: f64) -> Vec<FibrePoint> {
    let attached = attach(mesh, line, reach).expect("near enough").into_iter().map(|a| a.weights);
    line.iter().copied().zip(attached).collect()
}

/// Energy and Σ ‖r‖ of an effect at displacement x.
fn sums(effect: &dyn Effect, x: &[f64]) -> (f64, f64) {
    let zero = vec![0.0; x.len()];
    let at = At { t: 0.0, dt: 1.0, x, v: &zero, a: &zero, old: x, history: &[], inputs: &[], rates: Rates::default() };
    let blocks = 0..effect.blocks().len();
    blocks.fold((0.0, 0.0), |(energy, force), b| {
        let mut out = BlockValues::new(effect.blocks().size(b));
        effect.eval(&at, b, Want::Residual, &mut out).expect("regular");
        (energy + out.energy, force + durometer::math::vector::norm(&out.r))
    })
}

fn affine(mesh: &TetMesh, f: &Mat3) -> Vec<f64> {
    mesh.points.iter().flat_map(|p| <[f64; 3]>::from(f * p - p)).collect()
}

/// Under x = F X every segment has λ = ‖F T‖ with its direction T, also where it is outside of the body: Π = Σ ½ EA (λ − 1)² L to
/// rounding of the weights. Rotated, the energy is the same.
#[test]
fn affine_motions_stretch_every_segment_by_its_direction() {
    let f = Mat3::new(1.2, 0.3, 0.0, -0.1, 0.9, 0.2, 0.0, 0.1, 1.1);
    let turn = *nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0).matrix();
    for order in common::ORDERS {
        let mesh = distorted_cube(3, order, 0.1, 5);
        let line = [[-0.02, 0.5, 0.5], [0.4, 0.2, 0.6], [0.9, 0.7, 0.3]].map(Vec3::from);
        let line = cut(&line, 0.1);
        let by_hand: f64 = line
            .windows(2)
            .map(|p| {
                let d = p[1] - p[0];
                0.5 * 70.0 * ((f * d).norm() / d.norm() - 1.0).powi(2) * d.norm()
            })
            .sum();
        let fibres = Fibres::new("fibre".into(), &[points(&mesh, &line, 0.1)], 70.0, true);
        for f in [f, turn * f] {
            let (energy, _) = sums(&fibres, &affine(&mesh, &f));
            assert!((energy / by_hand - 1.0).abs() < 1e-12, "{order:?}: {energy} J, by hand {by_hand} J");
        }
        assert!(sums(&fibres, &affine(&mesh, &turn)).1 <= 1e-12 * 70.0, "a rotation makes no force");
    }
}

/// Shortened by 10 %, a fibre that does not resist compression has neither energy nor force; one that does has both. Longer, they are
/// the same.
#[test]
fn a_slack_fibre_has_no_force() {
    let mesh = block(2, 2, 2, 1.0, 1.0, 1.0, Order::Quadratic);
    let line = points(&mesh, &cut(&[Vec3::new(0.1, 0.4, 0.4), Vec3::new(0.9, 0.6, 0.4)], 0.2), 0.0);
    let [slack, stiff] = [false, true].map(|both| Fibres::new("fibre".into(), std::slice::from_ref(&line), 5.0, both));
    let shorter = affine(&mesh, &(Mat3::identity() * 0.9));
    assert_eq!(sums(&slack, &shorter), (0.0, 0.0));
    let (energy, force) = sums(&stiff, &shorter);
    assert!(energy > 0.0 && force > 0.0);
    let longer = affine(&mesh, &(Mat3::identity() * 1.1));
    assert_eq!(sums(&slack, &longer), sums(&stiff, &longer));
    assert_eq!((slack.tension(0.9), stiff.tension(0.9)), (0.0, -0.5 + 5.0 * (0.9 - 1.0 + 0.1)));
}

/// Four fibres along a bar with ν = 0, pulled to λ = 1.2: the strain is uniform, so the force is A P(λ) + 4 EA (λ − 1) exactly, and half of
/// it is that of the fibres. The linear law has P = E (λ − 1). To the tolerance of the solver.
#[test]
fn fibres_along_a_bar_carry_their_share() {
    for order in common::ORDERS {
        let (e, a, l) = (1e5, 0.02, 0.06);
        let mesh = block(6, 2, 2, l, a, a, order);
        let ea = e * a * a / 4.0;
        let at = |y: f64, z: f64| points(&mesh, &cut(&[Vec3::new(0.0, y, z), Vec3::new(l, y, z)], 0.007), 0.0);
        let lines = [(0.006, 0.006), (0.014, 0.006), (0.006, 0.014), (0.014, 0.014)].map(|(y, z)| at(y, z));
        let fibres = Fibres::new("fibre".into(), &lines, ea, false);
        let mut held = hold(&nodes(&mesh, "xmin"), &[0]);
        held.extend(hold(&nodes(&mesh, "ymin"), &[1]));
        held.extend(hold(&nodes(&mesh, "zmin"), &[2]));
        let pulled = move_to(&mesh, &nodes(&mesh, "xmax"), |_| Vec3::new(0.2 * l, 0.0, 0.0));
        held.extend(pulled.into_iter().filter(|p| p.dof % 3 == 0));
        let effects: Vec<Box<dyn Effect>> = vec![elastic(&mesh, law("linear", e, 0.0)), Box::new(fibres)];
        let system = System::new(mesh.points.len(), effects, vec![], held).expect("consistent");
        let (_, sums) = statics(&mesh, &system, 1e-12, 2);
        let force = reaction(&sums, &nodes(&mesh, "xmax")).x;
        let exact = 2.0 * e * a * a * 0.2;
        assert!((force / exact - 1.0).abs() < 1e-9, "{order:?}: {force} N, exactly {exact} N");
    }
}

#[test]
fn parts_are_cut_to_the_spacing() {
    let line = [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.3, 0.0]].map(Vec3::from);
    let points = cut(&line, 0.25);
    assert_eq!(points.len(), 7);
    assert_eq!(points[4], line[1]);
    assert!((points[6] - line[2]).norm() < 1e-15);
    assert_eq!(cut(&line, 10.0), line);
}

/// Every vertex is at the radius, climbs evenly and turns by the right hand; the chord of 1/24 turn is shorter than its arc by
/// (π/24)²/6 = 0.29 % at most.
#[test]
fn a_helix_is_at_its_radius_and_turns_by_its_hand() {
    let (start, end) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.1, 0.2, 0.8));
    for turns in [2.5, -2.5] {
        let helix = Helix { start, end, radius: 0.1, turns, phase: 0.3 };
        let points = helix.points(0.1);
        assert_eq!(points.len(), 61);
        for pair in points.windows(2) {
            let [a, b] = [pair[0] - start, pair[1] - start];
            assert!((a.xy().norm() - 0.1).abs() < 1e-15);
            assert!((b.z - a.z - 0.5 / 60.0).abs() < 1e-15);
            assert_eq!((a.x * b.y - a.y * b.x).signum(), turns.signum());
        }
        assert!((points[0] - start - Vec3::new(0.3f64.cos(), 0.3f64.sin(), 0.0) * 0.1).norm() < 1e-15);
        let length: f64 = points.windows(2).map(|p| (p[1] - p[0]).norm()).sum();
        let exact = 0.5f64.hypot(TAU * 0.25);
        assert!(length < exact && length > 0.9971 * exact);
        let fine = Helix { start, end, radius: 0.1, turns, phase: 0.3 }.points(1e-3);
        assert!(fine.windows(2).all(|p| (p[1] - p[0]).norm() <= 1e-3));
    }
}

/// Volume and areas of a tube; straight edges miss them by the square of an angle of π/12, curved ones by its fourth power.
#[test]
fn a_tube_closes_around_its_axis() {
    for order in common::ORDERS {
        let tolerance = if order == Order::Linear { 2e-2 } else { 2e-4 };
        let mesh = tube([1.0, 1.5], 3.0, [2, 24, 3], order);
        let wall = PI * (1.5f64.powi(2) - 1.0);
        assert_eq!(mesh.facet_count(), 2 * (24 * 3 * 2 + 24 * 2 * 2));
        assert!((mesh.volume() / (3.0 * wall) - 1.0).abs() < tolerance);
        for (name, area) in [("inner", TAU * 3.0), ("outer", TAU * 4.5), ("zmin", wall), ("zmax", wall)] {
            let found = mesh.region_area(&mesh.regions[name].facets);
            assert!((found / area - 1.0).abs() < tolerance, "{name}: {found} {area}");
        }
    }
}

/// Axial strain of a long thin closed tube under a small pressure, wound at an angle α to the axis: at mid-length of a half with a plane of
/// symmetry at its end.
fn axial_strain(alpha: f64) -> (f64, f64) {
    let (e, nu, radius, wall, p) = (1e6, 0.3, 0.02, 0.001, 100.0);
    let (a, b, length, count) = (radius - 0.5 * wall, radius + 0.5 * wall, 0.06, 16);
    let mesh = tube([a, b], length, [1, 32, 16], Order::Quadratic);
    let ends = [Vec3::zeros(), Vec3::new(0.0, 0.0, length)];
    let turns = length * alpha.tan() / (TAU * radius);
    let helix = |hand: f64, k: usize| {
        let phase = TAU * (k as f64 + 0.5) / count as f64;
        Helix { start: ends[0], end: ends[1], radius, turns: hand * turns, phase }.points(0.002)
    };
    let lines: Vec<Vec<FibrePoint>> = [1.0, -1.0]
        .into_iter()
        .flat_map(|hand| (0..count).map(move |k| (hand, k)))
        .map(|(hand, k)| points(&mesh, &helix(hand, k), 1e-5))
        .collect();
    let ea = 200.0;
    let inside = DeadLoad::surface(&mesh, &mesh.regions["inner"].facets, ramp(1.0), |_, normal| -normal * p);
    let cap = p * PI * a * a / (PI * (b * b - a * a));
    let end = DeadLoad::surface(&mesh, &mesh.regions["zmax"].facets, ramp(1.0), |_, normal| normal * cap);
    let effects: Vec<Box<dyn Effect>> = vec![
        elastic(&mesh, law("neo_hookean", e, nu)),
        Box::new(Fibres::new("winding".into(), &lines, ea, true)),
        Box::new(inside),
        Box::new(end),
    ];
    let mut held = hold(&nodes(&mesh, "zmin"), &[2]);
    let on = |x: f64, y: f64| {
        let at = Vec3::new(x, y, 0.0);
        let near = |k: &usize| (mesh.points[*k] - at).norm() < 1e-9;
        (0..mesh.points.len()).find(near).expect("a node of the grid") as u32
    };
    held.extend(hold(&[on(a, 0.0), on(-a, 0.0)], &[1]));
    held.extend(hold(&[on(0.0, a)], &[0]));
    let system = System::new(mesh.points.len(), effects, vec![], held).expect("consistent");
    let (state, _) = statics(&mesh, &system, 1e-9, 1);
    let middle: Vec<f64> = (0..mesh.points.len())
        .filter(|&k| (mesh.points[k].z - 0.5 * length).abs() < 1e-9)
        .map(|k| state.x[3 * k + 2])
        .collect();
    let measured = middle.iter().sum::<f64>() / middle.len() as f64 / (0.5 * length);
    (measured, laminate(alpha, [e, nu, radius, wall, p], 2.0 * count as f64 * ea / (TAU * radius * alpha.cos())))
}

/// The same of a thin shell with fibres spread over it, K \[N/m\]: N_z = pR/2 and N_θ = pR are those of the wall in plane stress and of the
/// fibres, n = K (ε_z cos²α + ε_θ sin²α) along them.
fn laminate(alpha: f64, [e, nu, radius, wall, p]: [f64; 5], k: f64) -> f64 {
    let sheet = e * wall / (1.0 - nu * nu);
    let (c, s) = (alpha.cos().powi(2), alpha.sin().powi(2));
    let [[zz, zt], [_, tt]] = [[sheet + k * c * c, nu * sheet + k * c * s], [0.0, sheet + k * s * s]];
    (0.5 * p * radius * tt - p * radius * zt) / (zz * tt - zt * zt)
}

/// A tube wound at less than arctan √2 = 54.74° shortens under pressure, at more it lengthens: fibres that do not stretch, on a wall without
/// stiffness, do neither at that angle. Here the fibres are 80 times as stiff as the wall, which moves the angle of the thin laminate by 0.16°.
/// The wall is R/20 thick: strains are within that share of the thin laminate, and the angle within ½°.
#[test]
fn a_tube_wound_at_the_neutral_angle_keeps_its_length() {
    let neutral = 2f64.sqrt().atan();
    let angles = [45f64.to_radians(), neutral, 65f64.to_radians()];
    let strains = angles.map(axial_strain);
    for ((measured, thin), angle) in strains.iter().zip(angles) {
        println!("{:.1}°: ε = {measured:.4e}, thin laminate {thin:.4e}", angle.to_degrees());
        assert!((measured - thin).abs() < strains[0].1.abs() / 20.0, "{measured} {thin}");
    }
    let [steep, none, flat] = strains.map(|s| s.0);
    assert!(steep < 0.0 && flat > 0.0, "{steep} {flat}");
    let slope = (flat - steep) / (angles[2] - angles[0]);
    let off = (none / slope).to_degrees();
    println!("the length stays at {:.2}°", neutral.to_degrees() - off);
    assert!(off.abs() < 0.5, "{off}°");
}

/// A bar of 40 × 10 × 10 mm, or two of them with a gap of 2 mm, that slides on its side y = 10 mm, with an effect: the notes on the latter.
fn noted(mesh: &str, effect: &str) -> Vec<String> {
    let grid = "grid = { kind = \"box\", size = [\"40 mm\", \"10 mm\", \"10 mm\"], divisions = [8, 2, 2] }";
    let text = format!(
        "[mesh]\n{grid}\n{mesh}\n[laws.rubber]\nlaw = \"neo_hookean\"\nE = \"200 kPa\"\nnu = 0.45\n\
         [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n[[effect]]\n{effect}\n\
         [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n[[constraint]]\nkind = \"fixed\"\nregion = \"ymax\"\ncomponents = \"y\"\n\
         [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
    );
    let scene = durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}"));
    let says = ["lie in the plane", "outside of the body", "no cells join"];
    scene.notes.into_iter().filter(|note| says.iter().any(|words| note.contains(words))).collect()
}

/// Places of fibres and sheets that are doubtful: in a plane of symmetry, outside of the body within their reach, across a gap between parts.
#[test]
fn doubtful_places_are_noted() {
    let fibre = |from: [f64; 3], to: [f64; 3], reach: &str| {
        let [from, to] = [from, to].map(|p| format!("[\"{} mm\", \"{} mm\", \"{} mm\"]", p[0], p[1], p[2]));
        format!(
            "kind = \"fibre\"\nalong = {{ kind = \"polylines\", lines = [[{from}, {to}]] }}\nEA = \"5 N\"\ncompression = true\nreach = \"{reach}\""
        )
    };
    assert_eq!(noted("", &fibre([0.0, 5.0, 5.0], [40.0, 5.0, 5.0], "0 mm")), Vec::<String>::new());
    let [note] = &noted("", &fibre([0.0, 10.0, 5.0], [40.0, 10.0, 5.0], "0 mm"))[..] else { panic!("one note") };
    assert!(
        note.starts_with("fibre: 1 of 1 fibres lie in the plane y = 10.0000 mm, in which one component is held"),
        "{note}"
    );
    assert!(note.contains("has half of their EA"), "{note}");
    // The other end, x = 0, is held in all components.
    assert_eq!(noted("", &fibre([0.0, 2.0, 5.0], [0.0, 8.0, 5.0], "0 mm")), Vec::<String>::new());
    let [note] = &noted("", &fibre([0.0, 5.0, 25.0], [40.0, 5.0, 25.0], "15.1 mm"))[..] else { panic!("one note") };
    assert!(note.contains(" points are outside of the body, by up to 15.0000 mm"), "{note}");
    let sheet =
        |region: &str| format!("kind = \"membrane\"\nregion = \"{region}\"\nlaw = \"rubber\"\nthickness = \"1 mm\"");
    assert_eq!(noted("", &sheet("zmax")), Vec::<String>::new());
    // Of 8 × 2 squares on a side, two facets each; the skin has four such sides, and two ends of 2 × 2 squares.
    for (region, all) in [("ymax", 32), ("skin", 144)] {
        let [note] = &noted("", &sheet(region))[..] else { panic!("one note") };
        assert!(note.starts_with(&format!("membrane: 32 of {all} facets lie in the plane y = 10.0000 mm")), "{note}");
    }
    let two = "[[mesh.part]]\nname = \"a\"\n[[mesh.part]]\nname = \"b\"\nshift = [\"42 mm\", \"0 mm\", \"0 mm\"]";
    let found = noted(two, &fibre([1.0, 5.0, 5.0], [81.0, 5.0, 5.0], "1.2 mm"));
    let across: Vec<&String> = found.iter().filter(|note| note.contains("which no cells join")).collect();
    assert_eq!(across.len(), 1, "{found:?}");
    assert!(noted(two, &fibre([1.0, 5.0, 5.0], [39.0, 5.0, 5.0], "1.2 mm")).is_empty());
}
