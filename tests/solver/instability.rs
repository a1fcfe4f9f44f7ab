//! Loss of stability, of bodies and of elements alone: steps past a bifurcation, the count of unstable modes, and remedies that fit the scene.

use crate::common::formulation::{FORMULATIONS, Formulation, label, solid};
use crate::common::{law, newton, nodes};
use durometer::material::Law;
use durometer::math::signal::Signal;
use durometer::math::tensor::{Mat3, Vec3};
use durometer::mesh::structured::block;
use durometer::mesh::{Order, TetMesh};
use durometer::scene::{ErrorEstimator, EstimateError, Run, Scene, lost_volumes, parse_scene};
use durometer::solve::{Driver, Failure, Integrator, Status, StepSettings, TimeSpan, set_second_field};
use durometer::study::store::solver_record::notes;
use durometer::system::{At, Prescribed, Rates, State, System, Want};
use nalgebra::{DMatrix, Vector2};

fn scene(text: &str) -> Scene {
    parse_scene(text).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

fn run(text: &str) -> Run {
    scene(text).run()
}

/// The part of a scene that is the same in all: a body of one law on a grid, and its elasticity.
fn rubber(grid: &str, element: &str, law: &str, formulation: &str) -> String {
    format!(
        r#"
[mesh]
grid = {grid}
element = "{element}"
[laws.rubber]
{law}
[[effect]]
kind = "elastic"
region = "body"
law = "rubber"
formulation = "{formulation}"
"#
    )
}

/// A grid of a box with these sides \[mm\].
fn grid([x, y, z]: [u32; 3], divisions: [usize; 3]) -> String {
    format!("{{ kind = \"box\", size = [\"{x} mm\", \"{y} mm\", \"{z} mm\"], divisions = {divisions:?} }}")
}

fn law_text(name: &str, e: &str, nu: f64) -> String {
    format!("law = \"{name}\"\nE = \"{e}\"\nnu = {nu}")
}

fn fixed(region: &str, components: &str) -> String {
    format!("[[constraint]]\nkind = \"fixed\"\nregion = \"{region}\"\ncomponents = \"{components}\"\n")
}

/// A static stage of 1 s in so many steps, with further keys.
fn stage(steps: usize, more: &str) -> String {
    stage_of("1 s", 1.0 / steps as f64, more)
}

fn stage_of(duration: &str, dt: f64, more: &str) -> String {
    format!("[[stage]]\nintegrator = \"static\"\nduration = \"{duration}\"\ndt = \"{dt} s\"\n{more}\n")
}

/// Rollers on five faces of a block, the last one pressed along x to `stretch`; the face y = 40 mm is free.
fn pressed(
    element: &str,
    formulation: &str,
    nu: f64,
    [divisions, steps]: [usize; 2],
    stretch: f64,
    numerics: &str,
) -> Run {
    let travel = 40.0 * (stretch - 1.0);
    let held =
        [("xmin", "x"), ("ymin", "y"), ("zmin", "z"), ("zmax", "z")].map(|(region, c)| fixed(region, c)).concat();
    let grid = grid([40, 40, 5], [divisions, divisions, 2]);
    let body = rubber(&grid, element, &law_text("neo_hookean_split", "1 MPa", nu), formulation);
    let stage = stage(steps, "");
    run(&format!(
        r#"
{body}
{held}
[[constraint]]
kind = "prescribed"
region = "xmax"
components = "x"
displacement = {{ kind = "ramp", from = "0 mm", to = "{travel} mm", end = "1 s" }}
{stage}
[[probe]]
kind = "reaction"
region = "xmax"
{numerics}
"#
    ))
}

/// Beyond Biot's surface instability a lagged factor leads nowhere: the step is repeated with one of its own in every iteration, and with its tangent as it is,
/// before it is cut. Without that the run makes hundreds of cuts.
#[test]
fn a_lagged_factor_does_not_end_a_compressed_block() {
    let [lagged, fresh] = ["", "[numerics]\nreuse_factor = false"]
        .map(|numerics| pressed("tet10", "displacement", 0.3, [8, 20], 0.5, numerics));
    for run in [&lagged, &fresh] {
        println!("{}; {:?}, {} factorisations", run.status, run.totals, run.factorisations);
        assert_eq!(run.status, Status::Converged);
    }
    assert!(
        lagged.totals.cuts <= fresh.totals.cuts + 2,
        "{} cuts, {} without a lagged one",
        lagged.totals.cuts,
        fresh.totals.cuts
    );
    assert!(
        lagged.tried_iterations >= lagged.totals.iterations && lagged.shifted_factorisations < lagged.factorisations
    );
}

/// A scene that is driven by a displacement is not told to drive by one.
#[test]
fn remedies_fit_the_drive() {
    let why = || Failure::NotConverged { residual: 1.0, node: 0 };
    let [force, motion] = [true, false].map(|by_force| Status::StepTooSmall { t: 0.0, why: why(), by_force }.remedy());
    assert!(force.contains("prescribe a length") && !motion.contains("prescribe a"), "{force}; {motion}");
    let lost = pressed("tet10", "displacement", 0.3, [2, 1], 0.02, "[numerics]\ncuts = 0\nmax_iterations = 2");
    assert!(matches!(lost.status, Status::StepTooSmall { by_force: false, .. }), "{}", lost.status);
}

/// A weight that grows from zero is not told to grow, and one that acts in full from the start is.
#[test]
fn remedies_name_nothing_that_the_scene_does() {
    let hanging = |acceleration: &str| {
        let body =
            rubber(&grid([60, 10, 10], [6, 1, 2]), "tet4", &law_text("neo_hookean", "100 Pa", 0.45), "displacement");
        let (held, stage) = (fixed("xmin", "xyz"), stage(2, ""));
        run(&format!(
            r#"
{body}
[[effect]]
kind = "gravity"
region = "body"
density = "1070 kg/m^3"
direction = [0, 0, -1]
acceleration = {acceleration}
{held}
{stage}
[[probe]]
kind = "reaction"
region = "xmin"
[numerics]
cuts = 0
max_iterations = 2
"#
        ))
        .status
    };
    let full = hanging("\"9.81 m/s^2\"");
    let grown = hanging("{ kind = \"ramp\", from = \"0 m/s^2\", to = \"9.81 m/s^2\", end = \"1 s\" }");
    for status in [&full, &grown] {
        assert!(matches!(status, Status::StepTooSmall { t: 0.0, .. }), "{status}");
    }
    assert!(full.remedy().contains("let them grow") && !grown.remedy().contains("let them grow"), "{full}; {grown}");
    assert!(grown.remedy().contains("prescribe a length, volume or displacement instead of a force"), "{grown}");
}

/// Rivlin's cube: equal dead tractions T on three faces, rollers on the others. The extrapolation is so good that steps need no
/// iteration; they are counted all the same. Along (1, −1, 0) the energy of the cube of stretch λ is 2μ s²/λ² − U′(J) λ s², so it is
/// unstable from U′ = 2μ/λ³ on, which is T = U′ λ² = 2μ/λ.
#[test]
fn rivlins_cube_is_noticed_where_it_loses_its_stability() {
    let (e, nu) = (1e6, 0.49);
    let (mu, kappa) = (e / (2.0 * (1.0 + nu)), e / (3.0 * (1.0 - 2.0 * nu)));
    // U = ½κ (J − 1)²
    let (mut low, mut high) = (1.0_f64, 1.5_f64);
    for _ in 0..60 {
        let l = 0.5 * (low + high);
        if kappa * (l.powi(3) - 1.0) < 2.0 * mu / l.powi(3) { low = l } else { high = l }
    }
    let critical = 2.0 * mu / low;
    let faces = [("x", "[1, 0, 0]"), ("y", "[0, 1, 0]"), ("z", "[0, 0, 1]")].map(|(c, direction)| {
        let held = fixed(&format!("{c}min"), c);
        format!(
            r#"
{held}
[[effect]]
kind = "traction"
name = "pull_{c}"
region = "{c}max"
direction = {direction}
traction = {{ kind = "ramp", from = "0 Pa", to = "{} Pa", end = "1 s" }}
"#,
            1.2 * critical
        )
    });
    let steps = 60;
    let law = law_text("neo_hookean_split", "1 MPa", nu) + "\nvolumetric = \"quadratic\"";
    let body = rubber(&grid([10; 3], [2; 3]), "tet10", &law, "mixed");
    let probe = "[[probe]]\nkind = \"position\"\nregion = \"xmax\"\n";
    let found = run(&[body, faces.concat(), stage(steps, ""), probe.into()].concat());
    let (t, modes) = *found.findings.unstable.first().expect("it loses its stability");
    println!("unstable from T = {:.4} of the closed form on, {modes} modes; {:?}", 1.2 * t, found.totals);
    // Noted at the first step beyond: one step of the ramp, a fiftieth of the load.
    assert!((1.0..=1.0 + 1.5 * 1.2 / steps as f64).contains(&(1.2 * t)), "T = {} T_c", 1.2 * t);
}

/// A balloon under pressure by arc length, with a short first step where it is stiff: beyond the limit of the pressure (radius 14 mm)
/// steps grow with the way behind them. Steps of at most ten first ones would need 1 500 to a radius of 100 mm.
#[test]
fn arc_length_steps_grow_beyond_a_turn() {
    let octant = "{ kind = \"octant\", inner = \"10 mm\", outer = \"10.5 mm\", divisions = [3, 1] }";
    let body = rubber(octant, "tet10", &law_text("neo_hookean_split", "1 MPa", 0.4999), "mixed");
    let held = [("xmin", "x"), ("ymin", "y"), ("zmin", "z")].map(|(region, c)| fixed(region, c)).concat();
    let stage = stage(100, "continuation = \"arc_length\"\nmax_steps = 150");
    let found = run(&format!(
        r#"
{body}
{held}
[[constraint]]
kind = "cavity"
region = "inner"
drive = {{ kind = "pressure", signal = {{ kind = "ramp", from = "0 kPa", to = "25 kPa", end = "1 s" }} }}
{stage}
[[probe]]
kind = "position"
region = "inner"
"#
    ));
    assert!(matches!(found.status, Status::LimitPoint { .. }), "{}", found.status);
    let x = found.column("cavity_volume_m3").expect("recorded");
    let (first, last) = (x[0], x[x.len() - 1]);
    println!(
        "{} rows, volume {:.1} times the first one, turn at {:?}",
        x.len(),
        last / first,
        found.findings.turning_points
    );
    assert!(last > 1000.0 * first, "the radius grows tenfold: {last:e} of {first:e}");
    // Closed form for the thin balloon, as in tests/effects/cavity.rs: 1.20915 × 0.05 μ with μ = E/2(1 + ν); the mesh is 1 % off.
    let limit = 1.20915 * 0.05 * 1e6 / (2.0 * 1.4999) / 25e3;
    let turn = found.findings.turning_points[0].t;
    assert!((turn / limit - 1.0).abs() < 0.02, "{turn} {limit}");
}

/// \[equations²\] K at a state, column by column, by products.
fn dense(system: &System, state: &State) -> DMatrix<f64> {
    let mut sums = system.workspace();
    let State { t, x, v, a, history, .. } = state;
    let at = At { t: *t, dt: f64::INFINITY, x, v, a, old: x, history, inputs: &[], rates: Rates::default() };
    system.assemble(&at, &state.lambda, Want::Tangent, None, &mut sums).expect("regular");
    let n = system.dofs.free.len();
    let mut k = DMatrix::zeros(n, n);
    for j in 0..n {
        let (mut unit, mut column) = (vec![0.0; n], vec![0.0; n]);
        unit[j] = 1.0;
        system.pattern.multiply(&sums.k, &unit, &mut column);
        k.set_column(j, &column.into());
    }
    k
}

/// Negative eigenvalues of the tangent of the displacements alone: with a second field A − B D⁻¹ Bᵀ, D its own block.
fn negative(system: &System, state: &State) -> usize {
    let k = dense(system, state);
    let n = k.nrows();
    let (own, second): (Vec<usize>, Vec<usize>) = (0..n).partition(|e| !system.dofs.is_scalar(*e));
    let part = |rows: &[usize], columns: &[usize]| k.select_rows(rows).select_columns(columns);
    let mut condensed = part(&own, &own);
    if !second.is_empty() {
        let inverse = part(&second, &second).try_inverse().expect("1/κ makes it regular");
        let of_pressures = part(&second, &second).symmetric_eigenvalues();
        assert!(of_pressures.max() < 0.0, "the block of the pressures is negative");
        condensed -= part(&own, &second) * inverse * part(&second, &own);
    }
    condensed.symmetric_eigenvalues().iter().filter(|e| **e < 0.0).count()
}

/// Stretch along y, where the faces are free, for those along x and z, by bisection.
fn across(law: &dyn Law, [x, z]: [f64; 2]) -> f64 {
    let stress = |y: f64| {
        let f = Mat3::from_diagonal(&Vec3::new(x, y, z));
        law.eval(&f, Want::Residual).expect("a regular state").p[(1, 1)]
    };
    let (mut low, mut high) = (1.0, 3.0 / x);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stress(middle) < 0.0 { low = middle } else { high = middle }
    }
    low
}

/// A body pressed to these stretches along x and z, with these components of some nodes held and free faces along y. Its state is uniform, which every
/// formulation holds exactly: an equilibrium, stable or not. The system, the state, and the count of a step that stays there.
fn uniform(
    mesh: &TetMesh,
    held: Vec<(Vec<u32>, u32)>,
    formulation: Formulation,
    nu: f64,
    [x, z]: [f64; 2],
) -> (System, State, usize) {
    let kind = law("neo_hookean_split", 1.0, nu);
    let growth = Vec3::new(x, across(&*kind, [x, z]), z).add_scalar(-1.0);
    let u: Vec<Vec3> = mesh.points.iter().map(|place| growth.component_mul(place)).collect();
    let fixed = |n: u32, c: u32| Prescribed { dof: 3 * n + c, signal: Signal::Constant(u[n as usize][c as usize]) };
    let prescribed = held.iter().flat_map(|(nodes, c)| nodes.iter().map(|n| fixed(*n, *c))).collect();
    let system = solid(mesh, kind, formulation, vec![], prescribed);
    let mut state = system.rest();
    state.x.chunks_exact_mut(3).zip(&u).for_each(|(x, u)| x.copy_from_slice(u.as_slice()));
    set_second_field(&system, &mut state).expect("pressures");
    let mut driver = Driver::new(&system, newton(&system, 1e-9, mesh.diagonal()), StepSettings::default());
    let span = TimeSpan { integrator: Integrator::Static, start: 0.0, end: 1.0, dt: 1.0 };
    assert_eq!(driver.run(span, &mut state, &mut ()), Status::Converged);
    assert!(state.x.chunks_exact(3).zip(&u).all(|(x, u)| (Vec3::from_column_slice(x) - u).norm() < 1e-9));
    let counted = driver.findings.unstable.last().map_or(0, |found| found.1);
    (system, state, counted)
}

/// The count by pivots is that of a dense eigenvalue solver in every formulation, of up to seven negative eigenvalues: a column of 4 × 1 in plane strain between two
/// rollers is straight beyond Euler's load. No eigenvalue is closer to zero than 1e-7 of the largest, far from rounding.
#[test]
fn counts_agree_with_dense_eigenvalues() {
    for (nu, (order, formulation)) in [0.45, 0.499].into_iter().flat_map(|nu| FORMULATIONS.map(|which| (nu, which))) {
        let mesh = block(4, 1, 1, 4.0, 1.0, 1.0, order);
        let all: Vec<u32> = (0..mesh.points.len() as u32).collect();
        // Across, the edge that a roller and the lower side share
        let edge = all.iter().copied().filter(|n| mesh.points[*n as usize].xy() == Vector2::zeros()).collect();
        let held = vec![(nodes(&mesh, "xmin"), 0), (nodes(&mesh, "xmax"), 0), (edge, 1), (all, 2)];
        let mut counts = Vec::new();
        for stretch in [0.9, 0.8, 0.7, 0.6, 0.5, 0.4] {
            let (system, state, counted) = uniform(&mesh, held.clone(), formulation, nu, [stretch, 1.0]);
            let exact = negative(&system, &state);
            assert_eq!(counted, exact, "{} with ν = {nu} at {stretch}", label(order, formulation));
            counts.push(counted);
        }
        // Linear cells that lock have one
        let least = if (order, formulation) == FORMULATIONS[0] { 1 } else { 2 };
        assert!(counts.iter().any(|n| *n >= least), "{} with ν = {nu}: {counts:?}", label(order, formulation));
    }
}

/// Stretches of a block in plane strain between rollers, of n² boxes with one free face, with the first negative eigenvalue of each formulation, to 0.001, as
/// `docs/explanation/solver.md` lists them. Biot's surface instability of the body (Biot 1965) is at 0.544.
const FIRST: [(usize, [Option<f64>; 4]); 3] = [
    (4, [Some(0.446), None, Some(0.576), Some(0.570)]),
    (8, [Some(0.529), Some(0.489), Some(0.612), Some(0.570)]),
    (12, [Some(0.538), Some(0.518), Some(0.617), Some(0.570)]),
];
/// Where no eigenvalue is negative yet, if the table has no number.
const PRESSED: f64 = 0.4;

#[test]
fn blocks_lose_their_stability_where_the_table_says() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/explanation/solver.md"));
    let page = page.expect("a page");
    for (n, row) in FIRST {
        let cells = row.map(|first| first.map_or(format!("below {PRESSED}"), |first| format!("{first:.3}")));
        let line = format!("| {n} | {} |", cells.join(" | "));
        assert!(page.contains(&line), "docs/explanation/solver.md has no row {line}");
        let [_, tet4_up, tet10, tet10_up, tet10_p0] = FORMULATIONS;
        for ((order, formulation), first) in [tet10, tet4_up, tet10_up, tet10_p0].into_iter().zip(row) {
            let mesh = block(n, n, 1, 1.0, 1.0, 1.0 / n as f64, order);
            let all = (0..mesh.points.len() as u32).collect();
            let rollers = [("xmin", 0), ("xmax", 0), ("ymin", 1)].map(|(side, c)| (nodes(&mesh, side), c));
            let held = [&rollers[..], &[(all, 2)]].concat();
            let counted = |stretch: f64| uniform(&mesh, held.clone(), formulation, 0.499, [stretch, 1.0]).2;
            let before = counted(first.map_or(PRESSED, |first| first + 0.001));
            let after = first.map(|first| counted(first - 0.001));
            let name = label(order, formulation);
            assert!(before == 0 && after != Some(0), "{name} {n}: {before}, then {after:?} at {first:?}");
        }
    }
}

/// A cube pressed along two axes with one free face loses its stability at a stretch of 0.666, mixed quadratic cells theirs at these, between steps of 0.005. Other cells
/// have no negative eigenvalue at 0.6 yet.
#[test]
fn mixed_cubes_lose_their_stability_too_early() {
    for (n, first) in [(3, 0.765), (4, 0.795)] {
        let counted = |(order, formulation): (Order, Formulation), stretch: f64| {
            let mesh = block(n, n, n, 1.0, 1.0, 1.0, order);
            let sides = [("xmin", 0), ("xmax", 0), ("ymin", 1), ("zmin", 2), ("zmax", 2)];
            let held = sides.map(|(side, c)| (nodes(&mesh, side), c)).to_vec();
            uniform(&mesh, held, formulation, 0.499, [stretch; 2]).2
        };
        let [_, tet4_up, tet10, tet10_up, _] = FORMULATIONS;
        assert!(counted(tet10_up, first + 0.005) == 0 && counted(tet10_up, first) > 0, "{n} boxes");
        assert_eq!([tet10, tet4_up].map(|which| counted(which, 0.6)), [0, 0], "{n} boxes");
    }
}

/// Last state of a cantilever with a cable above its middle, which hangs down by its weight where there is gravity.
fn hung(drive: &str, more: &str, gravity: f64, stages: &str) -> (Status, Vec<f64>) {
    let body =
        rubber(&grid([60, 12, 12], [6, 2, 2]), "tet10", &law_text("neo_hookean", "100 kPa", 0.4), "displacement");
    let held = fixed("xmin", "xyz");
    let found = run(&format!(
        r#"
{body}
[[effect]]
kind = "gravity"
region = "body"
density = "1100 kg/m^3"
direction = [0, 0, -1]
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "{gravity} m/s^2", end = "1 s" }}
{held}
[[constraint]]
kind = "cable"
pull_point = ["-5 mm", "6 mm", "9 mm"]
guides = [["5 mm", "6 mm", "9 mm"], ["30 mm", "6 mm", "9 mm"], ["55 mm", "6 mm", "9 mm"]]
guide_radius = "5 mm"
{more}
drive = {{ kind = "length", signal = {{ kind = "ramp", {drive}, end = "1 s" }} }}
{stages}
[[probe]]
kind = "position"
region = "xmax"
"#
    ));
    let last = found.rows.last().expect("rows");
    let names = ["xmax_x_m", "xmax_z_m", "cable_tension_N"];
    let column = |name: &str| last[found.columns.iter().position(|c| c == name).expect("a column")];
    (found.status.clone(), names.map(column).to_vec())
}

/// A path has a corner where a cable becomes taut, from the start or later, and where it yields at its largest tension. Static steps, which solve for the
/// state of the cable, lead to the same end.
#[test]
fn arc_length_goes_round_the_corners_of_cables() {
    let stage = |duration: &str, more: &str| stage_of(duration, 0.1, more);
    let arc = "continuation = \"arc_length\"";
    for (name, drive, more, gravity) in [
        ("taut later", "from = \"-1 mm\", to = \"4 mm\"", "", 9.81),
        ("elastic, taut later", "from = \"-1 mm\", to = \"4 mm\"", "EA = \"50 N\"", 9.81),
        ("taut from the start", "from = \"0 mm\", to = \"5 mm\"", "", 0.0),
        ("taut from the start, with weight", "from = \"0 mm\", to = \"5 mm\"", "", 9.81),
        ("yielding", "from = \"0 mm\", to = \"5 mm\"", "max_tension = \"0.3 N\"", 9.81),
    ] {
        let (status, expected) = hung(drive, more, gravity, &stage("1 s", ""));
        assert_eq!(status, Status::Converged, "{name}");
        let later = [stage("0.3 s", ""), stage("0.7 s", arc)].concat();
        for stages in [stage("1 s", arc), later] {
            let (status, found) = hung(drive, more, gravity, &stages);
            println!("{name}: {status}, {found:?}, static {expected:?}");
            assert_eq!(status, Status::Converged, "{name}");
            let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6 * b.abs().max(1e-2);
            assert!(found.iter().zip(&expected).all(near), "{name}: {found:?}, static {expected:?}");
        }
    }
}

/// A bar of 80 × 10 × 10 mm under a dead traction (Pa) on its end, with these constraints.
fn column(constraints: &str, traction: f64, steps: usize, continuation: &str) -> Run {
    let body =
        rubber(&grid([80, 10, 10], [12, 2, 2]), "tet10", &law_text("neo_hookean", "100 kPa", 0.3), "displacement");
    let stage = stage(steps, continuation);
    run(&format!(
        r#"
{body}
[[effect]]
kind = "traction"
region = "xmax"
direction = [1, 0, 0]
traction = {{ kind = "ramp", from = "0 Pa", to = "{traction} Pa", end = "1 s" }}
{constraints}
{stage}
[[probe]]
kind = "position"
region = "xmax"
"#
    ))
}

/// Rigid motions that nothing holds and nothing drives have eigenvalues of zero, negative by rounding, and are no instability: a bar on rollers
/// that is pulled, one without any constraint between two equal tractions, and one by arc length.
#[test]
fn free_rigid_motions_are_no_instability() {
    let pull = "[[effect]]\nkind = \"traction\"\nname = \"back\"\nregion = \"xmin\"\ndirection = [-1, 0, 0]\n\
                traction = { kind = \"ramp\", from = \"0 Pa\", to = \"20000 Pa\", end = \"1 s\" }\n";
    let rollers = fixed("xmin", "x");
    for (name, constraints, continuation) in [
        ("rollers", &*rollers, ""),
        ("free", pull, ""),
        ("rollers by arc length", &*rollers, "continuation = \"arc_length\""),
    ] {
        let found = column(constraints, 2e4, 10, continuation);
        println!("{name}: {}, {:?}, {:?}", found.status, found.findings.unstable, found.totals);
        assert_eq!(found.status, Status::Converged, "{name}");
        assert!(found.findings.unstable.is_empty() && found.totals.unstable == 0, "{name}: {:?}", found.findings);
    }
}

/// A bar on rollers buckles as a cantilever at σ = π² E b²/(48 L²), in two directions: these two eigenvalues are counted where they become
/// negative, and the three free motions on the rollers are not. Its strain there is 0.3 %, and shear takes off about as much.
#[test]
fn buckling_is_counted_apart_from_free_rigid_motions() {
    let critical = std::f64::consts::PI.powi(2) * 1e5 * 0.01 * 0.01 / (48.0 * 0.08 * 0.08);
    let steps = 24;
    let found = column(&fixed("xmin", "x"), -1.2 * critical, steps, "");
    let (t, modes) = *found.findings.unstable.first().unwrap_or_else(|| panic!("{}: it buckles", found.status));
    println!("buckles at {:.4} of Euler's load, {modes} modes; {}", 1.2 * t, found.status);
    assert_eq!(modes, 2);
    assert!((0.97..=1.03 + 1.2 / steps as f64).contains(&(1.2 * t)), "{} of Euler's load", 1.2 * t);
}

/// Equal tractions press a free bar: any load turns it over, about y or z, and from σ = π² E b²/(12 L²) = 1285 Pa on it buckles as one on hinges, in two
/// directions. The loads, up to eight times that, pass no limit.
#[test]
fn a_pressed_free_bar_has_no_limit_point() {
    let back = "[[effect]]\nkind = \"traction\"\nname = \"back\"\nregion = \"xmin\"\ndirection = [-1, 0, 0]\n\
                traction = { kind = \"ramp\", from = \"0 Pa\", to = \"-10000 Pa\", end = \"1 s\" }\n";
    let found = column(back, -1e4, 10, "");
    println!("{}, {:?}", found.status, found.findings.unstable);
    assert!(!matches!(found.status, Status::NoEquilibrium { .. }), "{}", found.status);
    let rounded: Vec<(i32, usize)> =
        found.findings.unstable.iter().map(|(t, modes)| ((t * 1e4).round() as i32, *modes)).collect();
    assert_eq!(rounded[..2], [(1000, 2), (2000, 4)], "{rounded:?}");
}

/// A column whose sides are held all over is pulled at its top. With v its motion, of height alone, the second variation is ∫ μ|∇v|² + (μ + Λ − Λ ln J)(F⁻ᵀ:∇v)² dV and a
/// part that vanishes with these sides: the body is stable at every J below e. Elements with pressures are not, and the note says that it may be them.
#[test]
fn elements_with_pressures_may_lose_their_stability_under_tension() {
    let pull = |element: &str, formulation: &str| {
        let body =
            rubber(&grid([10, 10, 40], [2, 2, 8]), element, &law_text("neo_hookean", "100 kPa", 0.49), formulation);
        let load = "[[effect]]\nkind = \"traction\"\nregion = \"zmax\"\ndirection = [0, 0, 1]\n\
                    traction = { kind = \"ramp\", from = \"0 kPa\", to = \"100 kPa\", end = \"1 s\" }\n\
                    [[probe]]\nkind = \"position\"\nregion = \"zmax\"\n";
        let scene = scene(&[body.as_str(), &fixed("body", "xy"), &fixed("zmin", "z"), load, &stage(10, "")].concat());
        let run = scene.run();
        let told = notes(&scene, &run);
        let doubted = told.iter().any(|note| note.starts_with("elements with pressures"));
        let claimed = told.iter().any(|note| note.contains("a real body takes another path"));
        // Tenths of the load, as the steps are
        let unstable: Vec<(i32, usize)> =
            run.findings.unstable.iter().map(|(t, modes)| ((10.0 * t).round() as i32, *modes)).collect();
        println!("{element} {formulation}: {} {unstable:?}", run.status);
        (unstable.first().copied(), doubted, claimed)
    };
    for element in ["tet4", "tet10"] {
        assert_eq!(pull(element, "displacement"), (None, false, false), "{element}");
    }
    for (element, formulation, first) in
        [("tet4", "mixed", (9, 2)), ("tet10", "mixed", (8, 17)), ("tet10", "mean_dilatation", (9, 3))]
    {
        assert_eq!(pull(element, formulation), (Some(first), true, false), "{element} {formulation}");
    }
}

/// A beam under its weight with a stiff film on its lower side, which presses the cells at the clamp together; the heaviest has no equilibrium. After each
/// cut that is searched for again, so one is allowed.
fn beam_with_a_film(formulation: &str, density: f64) -> Scene {
    let law = "law = \"ogden\"\nmu1 = \"23 kPa\"\nalpha1 = 1.6\nmu2 = \"-3 kPa\"\nalpha2 = -2\nnu = 0.3\nvolumetric = \"simo_taylor\"";
    let body = rubber(&grid([80, 27, 20], [8, 4, 4]), "tet10", law, formulation);
    let (held, stage) = (fixed("xmin", "xyz"), stage(10, ""));
    scene(&format!(
        r#"
{body}
[laws.film]
law = "neo_hookean"
E = "1.7 MPa"
nu = 0.4
[[effect]]
kind = "membrane"
region = "zmin"
law = "film"
thickness = "0.1 mm"
[[effect]]
kind = "gravity"
region = "body"
density = "{density} kg/m^3"
direction = [-0.75, 0.71, 0.89]
acceleration = {{ kind = "ramp", from = "0 m/s^2", to = "9.81 m/s^2", end = "1 s" }}
{held}
{stage}
[[probe]]
kind = "bending_angle"
root = "xmin"
tip = "xmax"
[numerics]
cuts = 1
"#
    ))
}

/// Cells of degree 2 with pressures go on to states in which some of their points collapse, with no eigenvalue that tells, where displacements find
/// no equilibrium: such a state is noted and has no bar. Under a moderate load it is not.
#[test]
fn pressures_that_lose_their_hold_on_the_volume_are_told() {
    let heavy = beam_with_a_film("mixed", 7000.0);
    let run = heavy.run();
    assert_eq!((&run.status, run.findings.unstable.len()), (&Status::Converged, 0));
    let lost: Vec<_> = lost_volumes(&heavy, &run.peak.x).collect();
    let [found] = &lost[..] else { panic!("one effect") };
    println!("{}", found.note());
    assert!(
        found.note().contains("elastic: the pressures have lost their hold on the volume: a point of cell "),
        "{found}"
    );
    assert!(notes(&heavy, &run).contains(&found.note()), "the record of a case has it");
    let bar = ErrorEstimator::new(&heavy).expect("an estimator").estimate(&run, &[]);
    assert!(matches!(bar, Err(EstimateError::VolumesLost { .. })), "{bar:?}");

    let held = beam_with_a_film("displacement", 7000.0);
    let run = held.run();
    assert!(matches!(run.status, Status::NoEquilibrium { .. }), "{}", run.status);
    assert_eq!(lost_volumes(&held, &run.peak.x).count(), 0);

    for formulation in ["mixed", "mean_dilatation"] {
        let light = beam_with_a_film(formulation, 3000.0);
        let run = light.run();
        assert_eq!(run.status, Status::Converged);
        assert_eq!(lost_volumes(&light, &run.peak.x).count(), 0, "{formulation}");
    }
}

/// A cube of this formulation without loads.
fn cube(formulation: &str) -> Scene {
    let law = law_text("neo_hookean_split", "1 MPa", 0.45) + "\nvolumetric = \"quadratic\"";
    let body = rubber(&grid([10; 3], [1; 3]), "tet10", &law, formulation);
    let probe = "[[probe]]\nkind = \"position\"\nregion = \"xmax\"\n";
    scene(&[body, fixed("xmin", "xyz"), stage(1, ""), probe.into()].concat())
}

/// The cube shrunk to a length of `shrunk`, then the node in the middle of an edge moved by a share `moved` of the edge towards its first end. With N = 4 λ₁λ₂ of
/// this node J = a³ − 4 a² m (λ₁ − λ₂), where λ₁ − λ₂ is ±1/√5 at the two points of a cell next to the ends and zero at the others: of the volume of each
/// cell only the share 1 − a³ is lost.
fn with_an_edge_moved(scene: &Scene, shrunk: f64, moved: f64) -> Vec<f64> {
    let points = &scene.body.mesh.points;
    let cell = scene.body.mesh.cell(0);
    let [a, b] = [cell[0], cell[1]].map(|node| points[node as usize]);
    let from_middle = |node: &&u32| (points[**node as usize] - 0.5 * (a + b)).norm();
    let middle = cell.iter().min_by(|m, n| from_middle(m).total_cmp(&from_middle(n))).expect("ten nodes");
    let mut u: Vec<Vec3> = points.iter().map(|x| (shrunk - 1.0) * x).collect();
    u[*middle as usize] += moved * (a - b);
    u.iter().flat_map(|u| [u.x, u.y, u.z]).collect()
}

/// The pressure of a cell holds its mean volume: a point far below this mean is told with its own volume, and one that shrinks with its cell is not.
#[test]
fn the_pressure_of_a_cell_holds_its_mean_volume() {
    let scene = cube("mean_dilatation");
    let told = |shrunk: f64, moved: f64| {
        let x = with_an_edge_moved(&scene, shrunk, moved);
        lost_volumes(&scene, &x).map(|lost| lost.to_string()).collect::<Vec<_>>()
    };
    // J = 0.729 − 0.551, and the mean is 0.729
    let lost = told(0.9, 0.38);
    assert!(
        lost.len() == 1 && lost[0].contains("is squeezed to 0.18 of its volume, 0.55 below the volume of"),
        "{lost:?}"
    );
    // A gap of −0.43 only, and J = 0.34 everywhere
    assert_eq!([told(0.9, 0.3).len(), told(0.7, 0.0).len()], [0, 0]);
    let points = cube("displacement");
    assert_eq!(lost_volumes(&points, &with_an_edge_moved(&points, 0.9, 0.38)).count(), 0);
}
