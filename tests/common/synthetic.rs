//! A made-up convergence study with a known answer, in memory and on disk.

use durometer::math::statistics::larger;
use durometer::scene::ExtremeKind;
use durometer::study::store::record::*;
use durometer::study::store::skin::Skin;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::path::Path;

/// Volume of the synthetic body [m³] and the h of N cells.
pub const VOLUME: f64 = 3.4e-5;
pub fn size(cells: usize) -> f64 {
    (VOLUME / cells as f64).cbrt()
}
/// The paper's four sizes, finest first.
pub const SIZES: [usize; 4] = [36_600, 16_200, 9_300, 4_500];

struct Member {
    family: &'static str,
    name: String,
    formulation: &'static str,
    cells: usize,
    dt: f64,
    /// Relative disturbance of the mesh
    noise: f64,
}

fn members() -> Vec<Member> {
    let m =
        |family, name: String, formulation, cells, dt, noise| Member { family, name, formulation, cells, dt, noise };
    let mut out: Vec<Member> = SIZES.iter().map(|n| m("sizes", n.to_string(), "tet4", *n, 0.05, 0.0)).collect();
    out.extend([600, 4_800, 38_400].map(|n| m("nested", n.to_string(), "tet4", n, 0.05, 0.0)));
    out.extend([2_000, 6_750, 22_800].map(|n| m("remeshed", n.to_string(), "tet4", n, 0.05, 2e-4)));
    out.extend(
        [(1, 4e-4), (2, -3e-4), (3, 1e-4)].map(|(k, e)| m("seeds", format!("9300-{k}"), "tet4", 9_300, 0.05, e)),
    );
    out.extend([1_100, 2_200, 4_500].map(|n| m("element", n.to_string(), "tet10", n, 0.05, 0.0)));
    out.extend([0.025, 0.1].map(|dt| m("time_step", format!("dt{dt}"), "tet4", 4_500, dt, 0.0)));
    out
}

fn mesh_of(m: &Member) -> MeshRecord {
    MeshRecord {
        cells: m.cells,
        nodes: m.cells / 4,
        edge_m: None,
        extents_m: None,
        wall_cells: None,
        wall_m: None,
        h_m: size(m.cells),
        min_quality: 0.31,
        mean_quality: 0.75,
        volume_m3: VOLUME,
        source: format!("block-{}-{}-{}", m.cells, m.formulation, m.noise),
    }
}

/// The record of a column that rises from zero to its largest value at t = 1 s.
fn probe(f: &[f64]) -> ProbeRecord {
    ProbeRecord {
        peak: f.iter().copied().fold(0.0, larger),
        peak_is: ExtremeKind::Maximum,
        peak_t_s: 1.0,
        last: f[f.len() - 1],
        opposite: None,
        motion: None,
    }
}

fn case(m: &Member, variant: &str) -> StoredCase {
    let h = size(m.cells) / size(4_500);
    let quadratic = m.formulation == "tet10";
    let error = if quadratic { 0.013 * h.powf(2.6) } else { 0.19 * h.powf(1.8) };
    let (angle, tension) = match variant {
        "length" => (74.0 * (1.0 + 0.05 * error + 0.1 * m.noise), 6.4 * (1.0 + error + m.noise)),
        _ => (71.0 * (1.0 - 0.8 * error - m.noise), 6.4),
    };
    let steps = (4.0 / m.dt) as usize;
    let t_s: Vec<f64> = (0..=steps).map(|k| k as f64 * m.dt).collect();
    let wave: Vec<f64> = t_s.iter().map(|t| 0.5 * (1.0 - (PI * t).cos())).collect();
    let scaled = |a: f64, k: f64| wave.iter().map(|w| a * w.powf(k)).collect::<Vec<f64>>();
    let columns = BTreeMap::from([
        ("bending_angle_deg".to_string(), scaled(angle, 1.1)),
        ("cable_tension_N".to_string(), scaled(tension, 1.3)),
    ]);
    let probes = columns.iter().map(|(k, f)| (k.clone(), probe(f))).collect();
    let wall = 0.4e-3 * (m.cells as f64).powf(1.15) * if quadratic { 9.0 } else { 1.0 } * 0.05 / m.dt;
    let record = CaseRecord {
        id: format!("{}-{variant}-{}", m.family, m.name),
        family: m.family.into(),
        variant: variant.into(),
        member: m.name.clone(),
        mesh: mesh_of(m),
        formulation: m.formulation.into(),
        law: Some(LawRecord {
            name: "neo_hookean".into(),
            parameters: BTreeMap::from([("mu".into(), 6.2e4)]),
            choices: BTreeMap::new(),
        }),
        integrator: "quasi_static".into(),
        dt_s: m.dt,
        stage_dt_s: vec![m.dt],
        steps_matter: Some(true),
        status: "Converged".into(),
        wall_s: wall,
        cpu_s: 0.98 * wall,
        shared: false,
        steps,
        newton_iterations: 4 * steps,
        cuts: 0,
        dofs: m.cells * 3 / 4,
        factor_nnz: m.cells * 90,
        effects: vec![
            EffectRecord { name: "elastic".into(), role: None, wall_s: 0.22 * wall },
            EffectRecord { name: "cable".into(), role: None, wall_s: 0.01 * wall },
        ],
        phases: PhaseRecord {
            assembly_s: 0.25 * wall,
            factorisation_s: 0.58 * wall,
            solve_s: 0.12 * wall,
            contact_forces_s: 0.0,
            output_s: 0.02 * wall,
            build_s: 0.0,
        },
        probes,
        provenance: Provenance {
            scene: "[body]\nmesh = \"block\"\n[[cable]]\nguide_radius = \"4 mm\"\n".into(),
            ..Provenance::default()
        },
        ..CaseRecord::default()
    };
    StoredCase::new(record, Series { t_s, columns })
}

pub fn study() -> (StudyRecord, Vec<StoredCase>) {
    let q = |name: &str, label: &str, symbol: &str, unit: &str| StudyQuantity {
        name: name.into(),
        label: label.into(),
        symbol: symbol.into(),
        unit: unit.into(),
        ..StudyQuantity::default()
    };
    let deciding = |quantity: StudyQuantity| StudyQuantity { deciding: true, ..quantity };
    let angle = || q("bending_angle_deg", "bending angle", "θ", "°");
    let roles = [
        ("sizes", Role::Sizes, "tet4"),
        ("nested", Role::Nested, "tet4"),
        ("remeshed", Role::Remeshed, "tet4"),
        ("seeds", Role::Seeds, "tet4"),
        ("element", Role::Element, "tet10"),
        ("time_step", Role::TimeStep, "tet4"),
    ];
    let cases: Vec<StoredCase> = members().iter().flat_map(|m| ["length", "tension"].map(|v| case(m, v))).collect();
    let families = roles.map(|(name, role, formulation)| FamilyRecord {
        name: name.into(),
        role,
        formulation: formulation.into(),
        cases: cases.iter().map(|c| &c.record).filter(|r| r.family == name).map(|r| r.id.clone()).collect(),
        members: vec![],
    });
    let study = StudyRecord {
        schema: 0,
        study: "synthetic".into(),
        kind: "convergence".into(),
        question: "Which mesh of the finger can be trusted?".into(),
        expectation: "Linear tetrahedra lock; the tension shows it, the angle under length control does not.".into(),
        tolerance: 0.05,
        quantities: BTreeMap::from([
            ("length".to_string(), vec![deciding(angle()), deciding(q("cable_tension_N", "cable tension", "T", "N"))]),
            ("tension".to_string(), vec![StudyQuantity { headline: true, ..angle() }]),
        ]),
        groups: BTreeMap::new(),
        members: BTreeMap::new(),
        variants: vec!["length".into(), "tension".into()],
        labels: ["length", "tension"].map(|v| (v.to_string(), format!("{v} control"))).into(),
        families: families.into(),
        details: serde_json::Value::Null,
        version: "0.1.0".into(),
        asks: None,
        inputs_sha256: BTreeMap::new(),
        overridden: vec![],
    };
    (study, cases)
}

/// Surface of a bar 100 × 20 × 20 mm, bent to a circle about y, with the stretch of its axial fibres.
fn skin(cells: usize, angle_deg: f64) -> Skin {
    let n = ((cells as f64 / 6.0).cbrt() * 0.6).round().max(2.0) as usize;
    let (nx, dims, kappa) = (5 * n, [0.1, 0.02, 0.02], angle_deg.to_radians() / 0.1);
    let (mut points, mut triangles): (Vec<[f64; 3]>, Vec<[u32; 3]>) = (vec![], vec![]);
    for (axis, side) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let count = |k: usize| if k == 0 { nx } else { n };
        let base = points.len() as u32;
        for i in 0..=count(u) {
            for j in 0..=count(v) {
                let mut x = [0.0; 3];
                x[axis] = dims[axis] * f64::from(side);
                x[u] = dims[u] * i as f64 / count(u) as f64;
                x[v] = dims[v] * j as f64 / count(v) as f64;
                points.push(x);
            }
        }
        let at = |i: usize, j: usize| base + (i * (count(v) + 1) + j) as u32;
        for (i, j) in (0..count(u)).flat_map(|i| (0..count(v)).map(move |j| (i, j))) {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let flip = |t: [u32; 3]| if side == 1 { t } else { [t[0], t[2], t[1]] };
            triangles.extend([flip([quad[0], quad[1], quad[2]]), flip([quad[0], quad[2], quad[3]])]);
        }
    }
    let bend = |x: &[f64; 3]| {
        let (s, r) = (x[0] * kappa, 1.0 / kappa - (x[2] - 0.01));
        [r * s.sin(), x[1], 1.0 / kappa + 0.01 - r * s.cos()]
    };
    let displacement = points.iter().map(|x| std::array::from_fn(|k| bend(x)[k] - x[k])).collect();
    let stretch = points.iter().map(|x| 1.0 + (kappa * (x[2] - 0.01)).abs()).collect();
    let cable = (0..=20).map(|k| bend(&[0.005 * f64::from(k) - 0.005, 0.01, 0.016])).collect();
    Skin { points, triangles, middles: vec![], t_s: 1.0, displacement, stretch, cables: vec![cable], rigids: vec![] }
}

pub fn store(dir: &Path, (study, cases): &(StudyRecord, Vec<StoredCase>)) {
    std::fs::create_dir_all(dir.join("cases")).expect("temporary folder");
    let put = |name: String, text: String| std::fs::write(dir.join(name), text).expect("temporary folder");
    put("study.json".into(), serde_json::to_string_pretty(study).expect("record"));
    for c in cases {
        let id = &c.record.id;
        put(format!("cases/{id}.json"), serde_json::to_string(&c.record).expect("record"));
        let mut csv = format!("t_s,{}\n", c.series.columns.keys().cloned().collect::<Vec<_>>().join(","));
        for (k, t) in c.series.t_s.iter().enumerate() {
            let row: Vec<String> = c.series.columns.values().map(|f| f[k].to_string()).collect();
            csv += &format!("{t},{}\n", row.join(","));
        }
        put(format!("cases/{id}.csv"), csv);
        let s = skin(c.record.mesh.cells, c.record.probes["bending_angle_deg"].peak);
        std::fs::write(dir.join(format!("cases/{id}.skin.json.gz")), s.packed()).expect("skin");
    }
}
