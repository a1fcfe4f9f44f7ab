//! Membranes against closed forms: any law in plane stress, a reinforced strip, a laminated beam, a balloon.

use crate::common;
use crate::common::{elastic, example, hold, law, move_to, nodes, ramp, reaction, statics};
use durometer::effect::{Cavity, CavityPressure, Membrane, VolumeField};
use durometer::material::{LAWS, Law, LoadCase};
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::curved::octant;
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::{no_limit_at, wrinkle_notes};
use durometer::system::{At, BlockValues, Effect, Prescribed, Rates, System, Want};
use std::sync::Arc;

fn sheet(mesh: &TetMesh, region: &str, law: Box<dyn Law>, thickness: f64) -> Membrane {
    Membrane::new("membrane".into(), mesh, &mesh.regions[region].facets, law, thickness)
}

/// Energy of an effect at displacement x, and Σ over its blocks of the forces.
fn energy(effect: &dyn Effect, x: &[f64]) -> (f64, Vec<f64>) {
    let zero = vec![0.0; x.len()];
    let at = At { t: 0.0, dt: 1.0, x, v: &zero, a: &zero, old: x, history: &[], inputs: &[], rates: Rates::default() };
    let (mut energy, mut force) = (0.0, zero.clone());
    for b in 0..effect.blocks().len() {
        let mut out = BlockValues::new(effect.blocks().size(b));
        effect.eval(&at, b, Want::Residual, &mut out).expect("regular");
        energy += out.energy;
        effect.blocks().dofs(b).zip(&out.r).for_each(|(dof, r)| force[dof as usize] += r);
    }
    (energy, force)
}

fn affine(mesh: &TetMesh, f: &Mat3) -> Vec<f64> {
    mesh.points.iter().flat_map(|p| <[f64; 3]>::from(f * p - p)).collect()
}

/// A flat sheet under λ in all directions of its plane, then turned in space: the force on a side of length l is P t l with the nominal
/// stress P of the equibiaxial test, whose lateral stretch is found by other code; also where the image of the normal is prescribed to be
/// anything else. Every objective law, both orders; both solve to rounding.
#[test]
fn every_law_has_its_equibiaxial_stress_in_the_plane() {
    let turn = *nalgebra::Rotation3::from_euler_angles(0.4, -1.1, 2.0).matrix();
    for entry in LAWS.iter().filter(|entry| entry.info.objective) {
        for order in common::ORDERS {
            let mesh = block(3, 2, 1, 0.03, 0.02, 0.01, order);
            let (stretch, thickness) = (1.15, 2e-4);
            let law = example(entry.info.name);
            let stress = LoadCase::Equibiaxial.state(&*law, stretch).expect("defined").stress;
            let f = turn * Mat3::new(stretch, 0.0, 0.3, 0.0, stretch, -0.2, 0.0, 0.0, 0.7);
            let (_, force) = energy(&sheet(&mesh, "zmax", law, thickness), &affine(&mesh, &f));
            let on_side: Vec3 =
                nodes(&mesh, "xmax").iter().map(|&k| Vec3::from_column_slice(&force[3 * k as usize..][..3])).sum();
            let exact = turn * Vec3::new(stress * thickness * 0.02, 0.0, 0.0);
            let error = (on_side - exact).norm() / exact.norm();
            assert!(error < 1e-9, "{} {order:?}: {error:e}", entry.info.name);
        }
    }
}

/// A strip with a sheet on both sides, stretched and held in width: the body has ν = 0 and P = E (λ − 1), the sheets are in planar tension.
/// The strain is uniform, so the reaction is the sum of both exactly.
#[test]
fn a_strip_between_two_sheets_adds_their_forces() {
    for order in common::ORDERS {
        let (e, [l, w, h], thickness, stretch) = (1e5, [0.04, 0.02, 0.01], 1e-4, 1.3);
        let mesh = block(4, 2, 2, l, w, h, order);
        let rubber = || law("neo_hookean", 3e6, 0.45);
        let mut held = hold(&nodes(&mesh, "xmin"), &[0]);
        held.extend(hold(&nodes(&mesh, "ymin"), &[1]));
        held.extend(hold(&nodes(&mesh, "ymax"), &[1]));
        held.extend(hold(&[0], &[2]));
        let pulled = move_to(&mesh, &nodes(&mesh, "xmax"), |_| Vec3::new((stretch - 1.0) * l, 0.0, 0.0));
        held.extend(pulled.into_iter().filter(|p| p.dof % 3 == 0));
        let middle: Vec<u32> =
            (0..mesh.points.len() as u32).filter(|&k| mesh.points[k as usize].z == 0.5 * h).collect();
        held.extend(hold(&middle, &[2]).into_iter().filter(|p| p.dof != 2));
        let effects: Vec<Box<dyn Effect>> = vec![
            elastic(&mesh, law("linear", e, 0.0)),
            Box::new(sheet(&mesh, "zmin", rubber(), thickness)),
            Box::new(sheet(&mesh, "zmax", rubber(), thickness)),
        ];
        let system = System::new(mesh.points.len(), effects, vec![], dedup(held)).expect("consistent");
        let (_, sums) = statics(&mesh, &system, 1e-12, 3);
        let force = reaction(&sums, &nodes(&mesh, "xmax")).x;
        let planar = LoadCase::Planar.state(&*rubber(), stretch).expect("defined").stress;
        let exact = e * w * h * (stretch - 1.0) + 2.0 * planar * thickness * w;
        assert!((force / exact - 1.0).abs() < 1e-9, "{order:?}: {force} N, exactly {exact} N");
    }
}

fn dedup(mut held: Vec<Prescribed>) -> Vec<Prescribed> {
    held.sort_by_key(|p| p.dof);
    held.dedup_by_key(|p| p.dof);
    held
}

/// A beam of modulus E with a stiff sheet of modulus 50 E below, bent by a small curvature κ: with ν = 0 the exact displacement
/// (−κ x (z − n), 0, ½ κ x²) is quadratic, so tet10 has it to rounding. About the neutral axis n = ½ E h²/(E h + E′t) the axial force is
/// zero, and the moment is κ [E w h³/12 + E w h (n − ½h)² + E′ t w n²].
#[test]
fn a_laminated_beam_bends_about_its_neutral_axis() {
    let (e, ratio, [l, w, h], thickness, kappa) = (1e5, 50.0, [0.06, 0.01, 0.008], 2e-4, 1e-4);
    let mesh = block(6, 1, 2, l, w, h, Order::Quadratic);
    let neutral = 0.5 * e * h * h / (e * h + ratio * e * thickness);
    let bent =
        |p: Vec3| Vec3::new(-kappa * (p.x - 0.5 * l) * (p.z - neutral), 0.0, 0.5 * kappa * (p.x - 0.5 * l).powi(2));
    let mut held = move_to(&mesh, &nodes(&mesh, "xmin"), bent);
    held.extend(move_to(&mesh, &nodes(&mesh, "xmax"), bent));
    held.extend(hold(&nodes(&mesh, "ymin"), &[1]));
    let effects: Vec<Box<dyn Effect>> = vec![
        elastic(&mesh, law("linear", e, 0.0)),
        Box::new(sheet(&mesh, "zmin", law("linear", ratio * e, 0.0), thickness)),
    ];
    let system = System::new(mesh.points.len(), effects, vec![], dedup(held)).expect("consistent");
    let (state, sums) = statics(&mesh, &system, 1e-12, 1);
    let size = kappa * l * l;
    for (k, p) in mesh.points.iter().enumerate() {
        let error = (Vec3::from_column_slice(&state.x[3 * k..][..3]) - bent(*p)).norm();
        assert!(error < 1e-9 * size, "{p}: {error:e} m");
    }
    let (mut axial, mut moment, mut sum) = (0.0, 0.0, 0.0);
    for k in nodes(&mesh, "xmax") {
        let (force, z) = (sums.r[3 * k as usize], mesh.points[k as usize].z);
        axial += force;
        sum += force.abs();
        moment -= force * (z - neutral);
    }
    let exact =
        kappa * w * e * (h.powi(3) / 12.0 + h * (neutral - 0.5 * h).powi(2) + ratio * thickness * neutral * neutral);
    assert!(axial.abs() < 1e-9 * sum, "axial force {axial} N of {sum} N");
    assert!((moment / exact - 1.0).abs() < 1e-8, "{moment} N m, exactly {exact} N m");
}

/// A balloon: a sheet on the inner side of a thick sphere that is softer by 1e4, under pressure. p = 2 t P(λ)/(R λ²) with the nominal
/// stress P of the equibiaxial test. Bounds: the soft sphere, and the curved facets of an octant of 3 × 3, each 1e-3 of p.
#[test]
fn a_balloon_has_the_pressure_of_a_spherical_sheet() {
    let (radius, thickness) = (0.02, 2e-4);
    for order in common::ORDERS {
        let n = if order == Order::Linear { 8 } else { 4 };
        let mesh = octant(radius, 1.2 * radius, n, 1, order);
        let rubber = || law("neo_hookean", 1e6, 0.49);
        let pressure = 4000.0;
        let field = VolumeField::cones(Vec3::zeros());
        let cavity = Arc::new(Cavity::new("cavity".into(), &mesh, &mesh.regions["inner"].facets, field));
        let effects: Vec<Box<dyn Effect>> = vec![
            elastic(&mesh, law("neo_hookean", 10.0, 0.3)),
            Box::new(sheet(&mesh, "inner", rubber(), thickness)),
            Box::new(CavityPressure { cavity, pressure: ramp(pressure) }),
        ];
        let held = ["xmin", "ymin", "zmin"].iter().enumerate();
        let held = held.flat_map(|(axis, name)| hold(&nodes(&mesh, name), &[axis as u32])).collect();
        let system = System::new(mesh.points.len(), effects, vec![], dedup(held)).expect("consistent");
        let (state, _) = statics(&mesh, &system, 1e-10, 5);
        let inner = nodes(&mesh, "inner");
        let stretch = inner
            .iter()
            .map(|&k| {
                (mesh.points[k as usize] + Vec3::from_column_slice(&state.x[3 * k as usize..][..3])).norm() / radius
            })
            .sum::<f64>()
            / inner.len() as f64;
        let stress = LoadCase::Equibiaxial.state(&*rubber(), stretch).expect("defined").stress;
        let exact = 2.0 * thickness * stress / (radius * stretch * stretch);
        println!("{order:?}: λ = {stretch:.6}, p = {pressure} Pa, closed form {exact:.2} Pa");
        let bound = if order == Order::Linear { 2e-2 } else { 2e-3 };
        assert!((pressure / exact - 1.0).abs() < bound, "{order:?}: λ = {stretch}, {exact} Pa");
    }
}

/// Derivatives of positions and reactions by the constants of the sheet, which differ from those of the body, against differences of runs.
#[test]
fn derivatives_by_the_constants_of_the_sheet() {
    let sheet: toml::Table = "law = \"neo_hookean\"\nE = \"3000.0 kPa\"\nnu = 0.4".parse().expect("a table");
    let text = r#"
[mesh]
body = "block"
[laws.base]
law = "neo_hookean"
E = "100 kPa"
nu = 0.4
[[effect]]
kind = "elastic"
region = "body"
law = "base"
[[effect]]
kind = "membrane"
region = "zmin"
law = "rubber"
thickness = "0.2 mm"
[[effect]]
kind = "traction"
region = "xmax"
direction = [1, 0, -1]
traction = { kind = "ramp", from = "0 Pa", to = "3000 Pa", end = "1 s" }
[[constraint]]
kind = "fixed"
region = "xmin"
[[stage]]
integrator = "static"
duration = "1 s"
dt = "0.5 s"
[[probe]]
kind = "position"
region = "xmax"
[[probe]]
kind = "reaction"
region = "xmin"
[numerics]
tolerance = 1e-12
reuse_factor = false
[laws.rubber]
"#;
    for order in common::ORDERS {
        let build = |table: &toml::Table| {
            let text = format!("{text}{}", toml::to_string(table).expect("a table"));
            common::scene(block(5, 2, 2, 0.05, 0.01, 0.01, order), &text)
        };
        let worst = common::sensitivities::check("membrane", &sheet, &build);
        println!("{order:?}: {worst:.1e}");
    }
}

/// St Venant and Kirchhoff's law softens under equal biaxial tension until a sheet of it has no thickness: a note says from what stretch on.
#[test]
fn a_sheet_that_loses_its_stiffness_is_noted() {
    let notes = |law: &str| {
        let text = format!(
            "[mesh]\ngrid = {{ kind = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"], divisions = [2, 1, 1] }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
             [laws.cloth]\nlaw = \"{law}\"\nE = \"1 MPa\"\nnu = 0.45\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[effect]]\nkind = \"membrane\"\nregion = \"zmin\"\nlaw = \"cloth\"\nthickness = \"1 mm\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n"
        );
        durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}")).notes
    };
    let of_sheet = |law: &str| notes(law).into_iter().find(|n| n.starts_with("laws.cloth"));
    let note = of_sheet("st_venant_kirchhoff").expect("a note");
    assert!(note.contains("is not stable") && note.contains("equibiaxial at 1."), "{note}");
    assert_eq!(of_sheet("neo_hookean"), None);
}

/// A stiff sheet on a soft block, compressed in its plane by ε and held in width: |N| = Et ε/(1 − ν²). The tangent loses its definiteness where facets are as
/// large as h* = π|N|/(2μ), which is stated for a half-space of incompressible material and one wave: within a factor of 1.5 here (measured: 0.96). Before,
/// nothing is refused; on cells of half the size it comes at half the strain. Stretched, the sheet is silent.
#[test]
fn a_compressed_sheet_wrinkles_at_the_size_of_its_facets() {
    let scene = |cells: usize, strain: f64, dt: &str| {
        let text = format!(
            "[mesh]\nelement = \"tet10\"\ngrid = {{ kind = \"box\", size = [\"20 mm\", \"10 mm\", \"10 mm\"], divisions = [{}, {cells}, {cells}] }}\n\
             [laws.rubber]\nlaw = \"neo_hookean\"\nE = \"100 kPa\"\nnu = 0.45\n\
             [laws.foil]\nlaw = \"neo_hookean\"\nE = \"100 MPa\"\nnu = 0.3\n\
             [[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"rubber\"\n\
             [[effect]]\nkind = \"membrane\"\nregion = \"zmax\"\nlaw = \"foil\"\nthickness = \"0.1 mm\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"xmin\"\ncomponents = \"x\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"ymin\"\ncomponents = \"y\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"ymax\"\ncomponents = \"y\"\n\
             [[constraint]]\nkind = \"fixed\"\nregion = \"zmin\"\ncomponents = \"z\"\n\
             [[constraint]]\nkind = \"prescribed\"\nregion = \"xmax\"\ncomponents = \"x\"\n\
             displacement = {{ kind = \"ramp\", from = \"0 mm\", to = \"{} mm\", start = \"0 s\", end = \"1 s\" }}\n\
             [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"{dt}\"\n",
            2 * cells,
            20.0 * strain
        );
        durometer::scene::parse_scene(&text).unwrap_or_else(|e| panic!("{e}"))
    };
    let mu = 1e5 / 2.9;
    for cells in [2, 4] {
        // Strain at which h* is the size of the facets, the shorter sides of right triangles
        let h = 0.01 / cells as f64;
        let critical = 2.0 * mu * h / std::f64::consts::PI * (1.0 - 0.3 * 0.3) / (1e8 * 1e-4);
        let compressed = scene(cells, -2.0 * critical, "50 ms");
        let run = compressed.run();
        let (t, _) = *run.findings.unstable.first().expect("it wrinkles");
        assert!((1.0 / 1.5..1.5).contains(&(2.0 * t)), "{cells}: at {} of the strain", 2.0 * t);
        let why = no_limit_at(&compressed, &run.peak.x).expect("it wrinkles");
        assert_eq!(why, "the sheet membrane wrinkles at the size of its facets");
        let [note] = &wrinkle_notes(&compressed, &run.peak.x)[..] else { panic!("one sheet") };
        assert!(note.contains("wrinkles from facet to facet"), "{note}");
        let below = scene(cells, -0.6 * critical, "50 ms");
        let run = below.run();
        assert!(run.findings.unstable.is_empty(), "{cells}: {:?}", run.findings.unstable);
        assert_eq!(no_limit_at(&below, &run.peak.x), None);
        let [note] = &wrinkle_notes(&below, &run.peak.x)[..] else { panic!("it is close") };
        assert!(note.contains("where facets are smaller than"), "{note}");
        let stretched = scene(cells, 2.0 * critical, "0.5 s");
        assert_eq!(wrinkle_notes(&stretched, &stretched.run().peak.x), Vec::<String>::new());
    }
}
