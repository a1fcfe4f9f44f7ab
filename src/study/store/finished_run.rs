//! Results of a finished run that are kept: its record, and the boundary at the state farthest from rest.

use crate::effect::pressure_scatter::pressure_scatter;
use crate::math::statistics::extent;
use crate::math::stopwatch::Spent;
use crate::math::tensor::Vec3;
use crate::math::units::Dimension;
use crate::mesh::boundary::boundary_facets;
use crate::mesh::element::FACET_EDGES;
use crate::mesh::quality::Quality;
use crate::mesh::{Order, TetMesh};
use crate::scene::protocol::between;
use crate::scene::{
    CutRegions, Extreme, NamedSkin, Run, Scene, column, extreme, extreme_on, has_glued_edge, no_limit_at,
    path_dependence, wall,
};
use crate::solve::{Integrator, TimeSpan};
use crate::study::case::Case;
use crate::study::overlay::distance::MarkerDistance;
use crate::study::overlay::markers;
use crate::study::overlay::{notes, overlays};
use crate::study::run::work::WorkRecord;
use crate::study::store::contact_record::contacts;
use crate::study::store::identity::Build;
use crate::study::store::record::{
    CaseRecord, EffectRecord, LawRecord, LockingRecord, MeshRecord, MotionRecord, OppositeRecord, PhaseRecord,
    ProbeRecord, Provenance, SCHEMA,
};
use crate::study::store::skin::{Rigid, Skin};
use crate::study::store::solver_record::{self, SolverRecord};
use nalgebra::Rotation3;
use std::collections::{BTreeMap, BTreeSet};

/// Motion of a probe, relative to the largest motion of the scene, below which it counts as zero \[–\]. The largest motion counts as at most the size
/// of the bodies
const VISIBLE: f64 = 1e-3;
/// Least motion, relative to the size of the bodies, that can count as the largest one of the scene: if nothing moves more, all motions are rounding
/// \[–\]
const STILL: f64 = 1e-5;
/// Largest range with which a rotation counts: a point on a circle moves by at most two radii \[deg\]
const WHOLE: f64 = 360.0 / std::f64::consts::PI;

/// Mean length of the time steps in stages that are not static \[s\].
fn mean_step(scene: &Scene, run: &Run) -> Option<f64> {
    let in_time = scene.spans.iter().filter(|s| !s.integrator.is_static());
    // A run may end before its last stage
    let duration: f64 = in_time.map(|s| (s.end.min(run.last.t) - s.start).max(0.0)).sum();
    (run.totals.in_time > 0).then(|| duration / run.totals.in_time as f64)
}

/// Whether masses move in a stage.
fn has_motion(scene: &Scene, span: &TimeSpan) -> bool {
    let has_mass = scene.spec.effects.iter().any(|e| e.kind() == "inertia") || !scene.spec.rigids.is_empty();
    has_mass && !span.integrator.is_static()
}

/// Largest excess of a prescribed signal over its values at the time-grid points of these stages, relative to its range.
fn unseen_share(scene: &Scene, is_of: impl Fn(&TimeSpan) -> bool) -> Option<f64> {
    let spans: Vec<TimeSpan> = scene.spans.iter().filter(|s| is_of(s)).copied().collect();
    let prescribed = scene.signals.iter().flat_map(|s| s.signal.prescribed());
    prescribed.filter_map(|signal| between(signal, &spans)).map(|b| b.share).max_by(f64::total_cmp)
}

/// Largest excess of a prescribed signal over its values at the time-grid points of all stages, relative to its range; 0 if there is none, `None` if no
/// masses move.
fn unseen_force_share(scene: &Scene) -> Option<f64> {
    let moves = scene.spans.iter().any(|span| has_motion(scene, span));
    moves.then(|| unseen_share(scene, |_| true).unwrap_or(0.0))
}

/// The integrator that determines the order of convergence in the time step: among the stages that have one, the last with the lowest order.
fn integrator(spans: &[TimeSpan]) -> Integrator {
    let all = || spans.iter().rev().map(|s| s.integrator);
    let in_time = all().filter_map(|integrator| Some((integrator.order()?, integrator)));
    let of_least_order = in_time.min_by_key(|(order, _)| *order).map(|(_, integrator)| integrator);
    of_least_order.or_else(|| all().next()).unwrap_or(Integrator::Static)
}

/// The record of a run that took this time.
pub fn record(scene: &Scene, run: &Run, spent: Spent) -> CaseRecord {
    let (markers, of_tracks) = marker_distances(scene, run);
    let overlays = overlays(scene, run);
    let of_scene = scene.notes.iter().cloned();
    let integrator = integrator(&scene.spans);
    let CutRegions { of_all: cut_regions, of_columns: cut_columns } = CutRegions::new(scene);
    CaseRecord {
        id: String::new(),
        family: String::new(),
        variant: String::new(),
        member: String::new(),
        mesh: mesh_record(scene),
        formulation: scene.spec.formulation(),
        law: scene.law.as_deref().map(LawRecord::new),
        integrator: integrator.name().into(),
        order_in_time: integrator.order(),
        dt_s: scene.spans.iter().map(|s| s.dt).fold(0.0, f64::max),
        stage_dt_s: scene.spans.iter().map(|s| s.dt).collect(),
        time_error_m: scene.spec.numerics.time_error.map(|error| error.0),
        mean_dt_s: mean_step(scene, run),
        steps_matter: Some(path_dependence(scene).is_some()),
        unseen_share: unseen_share(scene, |span| !has_motion(scene, span)),
        unseen_force_share: unseen_force_share(scene),
        status: run.status.name().into(),
        status_detail: solver_record::detail(scene, run),
        solver: SolverRecord::new(scene, run),
        wall_s: spent.wall_s,
        cpu_s: spent.cpu_s,
        shared: false,
        steps: run.totals.steps,
        newton_iterations: run.totals.iterations,
        cuts: run.totals.cuts,
        dofs: run.dofs,
        factor_nnz: run.factor_nnz,
        effects: run
            .costs
            .iter()
            .map(|cost| EffectRecord {
                name: cost.name.clone(),
                role: cost.role.map(|role| role.name().into()),
                wall_s: cost.time.as_secs_f64(),
            })
            .collect(),
        phases: PhaseRecord {
            assembly_s: run.assembly.as_secs_f64(),
            factorisation_s: run.factorisation.as_secs_f64(),
            solve_s: run.solve.as_secs_f64(),
            contact_forces_s: run.contact_forces.as_secs_f64(),
            output_s: 0.0,
            build_s: 0.0,
        },
        work: WorkRecord {
            factorisations: run.factorisations,
            solves: run.solves,
            factor_flops: run.factor_flops,
            matrix_nnz: scene.system.pattern.nnz(),
            memory_bytes: None,
            expected_bytes: None,
        },
        repeats: Vec::new(),
        locking: locking(scene, run),
        probes: probes(scene, run),
        cable_events: run.cable_events.iter().map(Into::into).collect(),
        contacts: contacts(scene, run),
        notes: of_scene.chain(solver_record::notes(scene, run)).chain(of_tracks).chain(notes(&overlays)).collect(),
        distances: overlays.into_iter().filter_map(|o| o.distance).collect(),
        measured: scene.measured.curves.clone(),
        markers,
        one_run: None,
        inputs: vec![],
        events: run.events.clone(),
        controllers: run.controllers.clone(),
        cut_regions,
        cut_columns,
        glued_edge: has_glued_edge(scene),
        no_limit: no_limit_at(scene, &run.peak.x),
        refinement: Vec::new(),
        provenance: Provenance { scene: scene.text.clone(), build: Build::this(), ..Provenance::default() },
    }
}

/// The record of the mesh of a scene.
fn mesh_record(scene: &Scene) -> MeshRecord {
    let mesh = &scene.body.mesh;
    let (quality, wall) = (Quality::of(mesh), wall(scene));
    MeshRecord {
        cells: mesh.cell_count(),
        nodes: mesh.points.len(),
        h_m: mesh.h(),
        edge_m: Some(mesh.mean_edge()),
        extents_m: Some(mesh.mean_extents(free_axes(scene))),
        wall_cells: wall.map(|w| w.cells),
        wall_m: wall.map(|w| w.thickness),
        min_quality: quality.radius_ratio_min,
        mean_quality: quality.radius_ratio_mean,
        volume_m3: mesh.volume(),
        source: scene.body.source.clone(),
    }
}

/// Distances from measured markers, and notes on their tracks: where they start, or why they can no longer be read.
fn marker_distances(scene: &Scene, run: &Run) -> (Vec<MarkerDistance>, Vec<String>) {
    match markers::overlays(scene, run) {
        Ok(all) => {
            let notes = all.iter().filter_map(|o| o.note.clone()).collect();
            (all.into_iter().flat_map(|o| o.pairs).filter_map(|p| p.distance).collect(), notes)
        }
        Err(why) => (vec![], vec![why.to_string()]),
    }
}

/// Axes along which some corner of a cell is free.
fn free_axes(scene: &Scene) -> [bool; 3] {
    let held: BTreeSet<u32> = scene.system.prescribed.iter().map(|p| p.dof).collect();
    let mesh = &scene.body.mesh;
    let corners = (0..mesh.cell_count()).flat_map(|c| &mesh.cell(c)[..4]);
    [0, 1, 2].map(|axis| corners.clone().any(|node| !held.contains(&(3 * node + axis))))
}

/// The record of a case without a run, because its scene was refused or a bug ended it.
pub fn refused(case: &Case, status: &str, why: String) -> CaseRecord {
    CaseRecord {
        id: case.id.clone(),
        family: case.family.clone(),
        variant: case.variant.clone(),
        member: case.member.clone(),
        formulation: case.spec.formulation(),
        status: status.into(),
        status_detail: Some(why),
        provenance: Provenance {
            schema: SCHEMA,
            scene: case.text.clone(),
            identity: case.identity(&[]),
            build: Build::this(),
            ..Provenance::default()
        },
        ..CaseRecord::default()
    }
}

fn locking(scene: &Scene, run: &Run) -> Option<LockingRecord> {
    let scatters = scene.stressed.iter().filter_map(|e| pressure_scatter(&**e, &run.peak.x));
    let scatters = scatters.filter(|s| s.scatter.is_finite() && s.share.is_finite());
    let worst = scatters.max_by(|a, b| a.alarm.cmp(&b.alarm).then(a.scatter.total_cmp(&b.scatter)))?;
    Some(LockingRecord { pressure_scatter: worst.scatter, volumetric_share: worst.share, alarm: worst.alarm })
}

/// Peaks and last values of the columns.
fn probes(scene: &Scene, run: &Run) -> BTreeMap<String, ProbeRecord> {
    let named = |(k, name): (usize, &String)| Some((name.clone(), probe(scene, run, k)?));
    let mut probes = run.columns.iter().enumerate().skip(1).filter_map(named).collect();
    keep_visible(scene, &mut probes);
    probes
}

/// Removes motions from the probes that are negligible compared with the largest one: columns that symmetry or an equilibrium keeps constant.
fn keep_visible(scene: &Scene, probes: &mut BTreeMap<String, ProbeRecord>) {
    let size = scene.rigids.iter().map(|body| body.frame.length).fold(scene.body.mesh.diagonal(), f64::max);
    let length = |column: &str, motion: &MotionRecord| match column::dimension(column) {
        (Dimension::LENGTH, _) => Some(motion.range),
        (Dimension::ANGLE, si) => Some(motion.range * si * size),
        _ => None,
    };
    let lengths = probes.iter().filter_map(|(column, probe)| length(column, probe.motion.as_ref()?));
    let least = VISIBLE * lengths.fold(STILL * size, f64::max).min(size);
    for (column, probe) in probes {
        probe.motion = probe.motion.filter(|motion| length(column, motion).is_none_or(|length| length > least));
    }
}

/// The record of a column; `None` without a row.
fn probe(scene: &Scene, run: &Run, column: usize) -> Option<ProbeRecord> {
    let values = || run.rows.iter().map(|row| row[column]);
    let Extreme { at, value, kind } = extreme(values())?;
    let opposite = extreme_on(kind.opposite(), values()).filter(|e| e.value.is_finite());
    let last = run.rows.last()?[column];
    Some(ProbeRecord {
        peak: value,
        peak_is: kind,
        peak_t_s: run.rows[at][0],
        last,
        opposite: opposite.map(|e| OppositeRecord { value: e.value, t_s: run.rows[e.at][0] }),
        motion: motion(scene, run, column),
    })
}

/// Changes of a column in the stages in which masses move.
fn motion(scene: &Scene, run: &Run, column: usize) -> Option<MotionRecord> {
    let spans = scene.spans.iter().filter(|span| has_motion(scene, span));
    let changes = spans.filter_map(|span| {
        let inside =
            |row: &&Vec<f64>| row[0] >= span.start * (1.0 - f64::EPSILON) && row[0] <= span.end * (1.0 + f64::EPSILON);
        let rows: Vec<&Vec<f64>> = run.rows.iter().filter(inside).collect();
        let [low, high] = extent(rows.iter().map(|row| row[column]));
        let change = |w: &[&Vec<f64>]| w[1][column] - w[0][column];
        let Some(component) = component_of_rotation(&run.columns[column]) else {
            let step = rows.windows(2).map(|w| change(w).abs()).reduce(f64::max)?;
            return Some(MotionRecord { largest_step: step, range: high - low });
        };
        let turned = |w: &[&Vec<f64>]| {
            let [from, to] = [w[0], w[1]].map(|row| {
                let vector = Vec3::from_column_slice(&row[column - component..][..3]);
                Rotation3::new(vector.map(f64::to_radians))
            });
            (to * from.inverse()).scaled_axis()[component].to_degrees()
        };
        let step = rows.windows(2).map(|w| turned(w).abs()).reduce(f64::max)?;
        Some(MotionRecord { largest_step: step, range: (high - low).min(WHOLE) })
    });
    changes.max_by(|a, b| a.largest_step.total_cmp(&b.largest_step)).filter(|m| m.range > 0.0 && m.range.is_finite())
}

/// The component of a rotation vector that a column holds; the components of one vector are in consecutive columns.
fn component_of_rotation(column: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|component| column.ends_with(&format!("_rotation_{component}_deg")))
}

/// Distance of a mid-node from the middle of its edge, relative to the length of the edge, above which the edge is curved.
const CURVED: f64 = 0.01;

/// Whether some of these facets are curved at rest.
fn is_curved(mesh: &TetMesh, facets: &[u32]) -> bool {
    let bends = |facet: &[u32]| {
        let at = |k: usize| mesh.points[facet[k] as usize];
        let sides = FACET_EDGES.iter().enumerate();
        sides
            .map(|(e, &[i, j])| (at(3 + e) - (at(i) + at(j)) / 2.0).norm() / (at(j) - at(i)).norm())
            .any(|off| off > CURVED)
    };
    mesh.order == Order::Quadratic && facets.iter().any(|&f| bends(mesh.facet(f as usize)))
}

/// The boundary at the state farthest from rest, with mid-nodes only if it is curved at rest.
pub fn skin(scene: &Scene, run: &Run) -> Skin {
    let mesh = &scene.body.mesh;
    let stretch = scene.nodal_stretch(&run.peak.x);
    let mut local = BTreeMap::new();
    let mut nodes = Vec::new();
    let boundary = boundary_facets(mesh);
    let mut numbers = |own: &[u32]| -> [u32; 3] {
        std::array::from_fn(|k| {
            *local.entry(own[k]).or_insert_with(|| {
                nodes.push(own[k] as usize);
                nodes.len() as u32 - 1
            })
        })
    };
    let triangles = boundary.iter().map(|&f| numbers(&mesh.facet(f as usize)[..3])).collect();
    let curved = if is_curved(mesh, &boundary) { &boundary[..] } else { &[] };
    let middles = curved.iter().map(|&f| numbers(&mesh.facet(f as usize)[3..])).collect();
    let x = &run.peak.x;
    Skin {
        points: nodes.iter().map(|&k| mesh.points[k].into()).collect(),
        triangles,
        middles,
        t_s: run.peak.t,
        displacement: nodes.iter().map(|&k| [x[3 * k], x[3 * k + 1], x[3 * k + 2]]).collect(),
        stretch: nodes.iter().map(|&k| stretch[k]).collect(),
        cables: scene.cables.iter().map(|c| c.cable.polyline(x).into_iter().map(Into::into).collect()).collect(),
        rigids: rigids(scene, x),
    }
}

/// Rigid bodies and bounded obstacles at the displacement x.
fn rigids(scene: &Scene, x: &[f64]) -> Vec<Rigid> {
    let of_contact =
        |name: &str| scene.rigids.iter().any(|r| r.name == name) || scene.contacts.iter().any(|c| c.name == name);
    let place = |skin: &NamedSkin| {
        let moved = skin.displacement(x);
        let at = |(p, u): (&Vec3, &[f64])| [p.x + u[0], p.y + u[1], p.z + u[2]];
        Rigid {
            points: skin.surface.points.iter().zip(moved.chunks_exact(3)).map(at).collect(),
            triangles: skin.surface.triangles.clone(),
        }
    };
    scene.skins.iter().filter(|s| of_contact(&s.name)).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that is shaken and then held converges with the order of the shaking, wherever in the protocol the shaking is.
    #[test]
    fn a_static_hold_hides_no_integrator() {
        let euler = Integrator::ImplicitEuler { linearised: false };
        let of = |all: &[Integrator]| {
            let spans = all.iter().map(|i| TimeSpan { integrator: *i, start: 0.0, end: 1.0, dt: 0.1 });
            integrator(&spans.collect::<Vec<_>>()).name()
        };
        assert_eq!(of(&[euler, Integrator::Static]), "implicit_euler");
        assert_eq!(of(&[euler, Integrator::Bdf2]), "implicit_euler");
        assert_eq!(of(&[Integrator::Static, Integrator::Bdf2]), "bdf2");
        assert_eq!(of(&[Integrator::GeneralisedAlpha { rho: 0.8 }, Integrator::Bdf2, Integrator::Static]), "bdf2");
        assert_eq!(of(&[Integrator::Static, Integrator::ArcLength { max_steps: 9 }]), "arc_length");
        assert_eq!(of(&[]), "static");
    }
}
