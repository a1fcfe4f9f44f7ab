//! Adaptive meshes: `[mesh.refine]` asks for a mesh on which the error of one quantity is within a tolerance.
//!
//! The scene is run up to the time at which the quantity departs most from its start, its error is estimated together with the shares of the cells
//! ([`ErrorEstimator::localised`]), and the mesher makes the next mesh from a size field: mesh, solve, estimate, mesh again.
//!
//! The share η_K of a cell is assumed to fall as h^α. Minimising the number of cells N = Σ (h_K/h)³ for a given error Σ η_K (h/h_K)^α gives
//! h/h_K ∝ η_K^{−1/(α + 3)}; the factor of proportionality follows from the error aimed at. It is limited by a bound on the growth of the number of cells from
//! mesh to mesh, so that a coarse first estimate does not decide the last mesh. Every mesh follows from the one with the smallest bar so far; after a mesh
//! that did not improve on it, half of the error is aimed at, and no cell becomes larger. A bar that lacks the error of curved facets, or of a singular edge
//! or a small patch within one cell of the place of the quantity, is not a valid measure: the next mesh then follows from that mesh in the same way. If the
//! extent of a region is missing in a bar, it is missing on every mesh, and no further mesh is made.
//!
//! A relative tolerance refers to the largest departure from the start, so that it does not depend on the origin of coordinates.

use super::Body;
use super::mesh_spec::RefineSpec;
use crate::math::stopwatch::{Spent, Stopwatch};
use crate::mesh::TetMesh;
use crate::mesh::element::CELL_EDGES;
use crate::mesh::generate::{MeshStore, SizeField};
use crate::scene::error_estimate::{ErrorEstimator, EstimateError, QuantityError};
use crate::scene::{Progress, RunOptions, Scene, SceneError, SceneSpec};
use crate::solve::Status;
use crate::system::State;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Order α with which the shares of the cells are assumed to fall: that of linear cells, and of quadratic ones at singular edges.
const ORDER: f64 = 2.0;
/// Share of the tolerance that a new mesh aims at.
const AIM: f64 = 0.8;
/// Largest number of cells of a mesh, as a multiple of that of the mesh before.
const MOST_GROWTH: f64 = 6.0;
/// Bounds of the change of the edge length from mesh to mesh, as factors.
const BOUNDS: [f64; 2] = [0.25, 2.0];
/// Bounds of the change of the edge length after a mesh that did not improve on the best one, as factors.
const BOUNDS_AFTER_FAILURE: [f64; 2] = [0.25, 1.0];
/// Steepest growth of the edge length in space [–].
const GRADING: f64 = 0.35;
/// Smallest share of a cell relative to the mean; smaller ones are raised to it.
const LEAST_SHARE: f64 = 1e-6;

/// One mesh of a refinement.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementStep {
    /// File name of the mesh
    pub mesh: String,
    pub cells: usize,
    /// Number of equations of the run
    pub dofs: usize,
    /// Error of the quantity on this mesh
    pub error: QuantityError,
    /// The deciding error bar, of the value or of its departure from the start, and its largest accepted value \[unit of the quantity\]
    pub bar: f64,
    pub tolerance: f64,
    /// CPU and wall time of the run, the estimate and the next mesh
    pub spent: Spent,
}

impl RefinementStep {
    /// Whether the error bar is within the tolerance, and no part of it is missing.
    pub fn is_within(&self) -> bool {
        is_within(&self.error, [self.bar, self.tolerance])
    }
}

/// Whether a bar is within a tolerance, with no part of it missing.
fn is_within(error: &QuantityError, [bar, tolerance]: [f64; 2]) -> bool {
    error.lacks().is_none() && bar <= tolerance
}

/// The mesh with the smallest bar so far.
struct Best {
    body: Arc<Body>,
    /// Magnitudes of the shares of its cells
    shares: Vec<f64>,
    bar: f64,
    /// Whether no part of the bar is missing
    is_whole: bool,
    /// Number of meshes since then, none of which has improved on it; a mesh whose bar lacks a part counts as such
    failures: i32,
}

impl Best {
    /// Whether this mesh remains the best one after a mesh with another bar. A bar that lacks a part is not a valid measure: its mesh gives way to any later
    /// one.
    fn remains(&self, bar: f64, is_whole: bool) -> bool {
        self.is_whole && (!is_whole || self.bar <= bar)
    }

    /// The size field of the next mesh, and the number of cells that it asks for.
    fn next(&self, tolerance: f64) -> (SizeField, u64) {
        let mesh = &self.body.mesh;
        let aim = AIM * (tolerance / self.bar).min(1.0) * 0.5_f64.powi(self.failures);
        let bounds = if self.failures == 0 { BOUNDS } else { BOUNDS_AFTER_FAILURE };
        let lengths = lengths(mesh, &self.shares, aim, bounds);
        let mean = (lengths.iter().map(|h| h.ln()).sum::<f64>() / lengths.len() as f64).exp();
        let field = SizeField::new(mesh, &lengths, mean, GRADING);
        let count = cells(mesh, &field, mean);
        (field, count)
    }
}

/// Callbacks that follow a refinement.
pub struct RefinementWatch<'a> {
    /// Receives every step when it is complete
    pub step: &'a mut dyn FnMut(&RefinementStep),
    /// Receives the output lines of the mesher
    pub mesher: &'a mut dyn FnMut(&str),
    /// Receives the progress of the runs; returns `false` to stop
    pub progress: &'a mut dyn FnMut(Progress) -> bool,
    /// Flag that stops error estimates too and prevents further meshes
    pub stop: Option<Arc<AtomicBool>>,
}

impl RefinementWatch<'_> {
    fn is_stopped(&self) -> bool {
        self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

/// The mesh of a refinement with the smallest bar, and all steps.
#[derive(Debug)]
pub struct Refinement {
    pub body: Arc<Body>,
    pub steps: Vec<RefinementStep>,
}

impl Refinement {
    /// The fact that the error is not within the tolerance on any mesh, and the remedy after a semicolon; `None` if it is within the tolerance.
    pub fn missed(&self) -> Option<String> {
        let last = self.steps.last().filter(|step| !step.is_within())?;
        let lacks = self.steps.iter().find_map(|step| step.error.lacks());
        let lacks = lacks.map_or_else(|| ",".into(), |parts| format!(", or without {parts},"));
        let remedy = match last.error.cut_regions.is_empty() {
            true => "allow more `meshes`, or more tolerance",
            false => "let the border of these regions run along edges of the cells, or take regions of the mesh",
        };
        Some(format!(
            "the error bar is above the tolerance on every mesh{lacks} and smallest on that of {} cells, which is taken; {remedy}",
            self.body.mesh.cell_count()
        ))
    }
}

/// Reason why a scene cannot be refined.
#[derive(Debug, thiserror::Error)]
pub enum RefineError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error("mesh.refine: {0}")]
    Estimate(#[from] EstimateError),
    #[error(
        "mesh.refine: {name} changes by {change:.3e} at most, within its error bar; give an absolute_tolerance in its unit"
    )]
    NearZero { name: String, change: f64 },
    #[error(
        "mesh.refine: the scene on mesh {number} with {cells} cells does not complete ({status}); start from smaller cells, or \
         run it without `refine` to see why"
    )]
    NotSolved { number: usize, cells: usize, status: &'static str },
    #[error("interrupted in the refinement, on mesh {number} with {cells} cells")]
    Interrupted { number: usize, cells: usize },
}

/// Refines the mesh of a scene until the error bar of the quantity is within its tolerance, or the largest number of meshes is reached. `body` is the first
/// mesh; `store` as in [`Body::load_from`].
///
/// # Errors
///
/// Where a scene is refused, a run does not complete or is stopped, or the quantity has no estimate or is within its error bar of zero.
pub fn refine(
    (file, spec, text): (&Path, &SceneSpec, &str),
    wanted: &RefineSpec,
    body: Arc<Body>,
    store: Option<&MeshStore>,
    watch: &mut RefinementWatch,
) -> Result<Refinement, RefineError> {
    let (mut body, mut steps, mut until) = (body, Vec::new(), f64::INFINITY);
    let mut best: Option<Best> = None;
    loop {
        let stopwatch = Stopwatch::start();
        let mut scene = Scene::build(file, spec.clone(), text.to_string(), body.clone())?;
        scene.spans.retain(|span| span.start < until);
        scene.spans.iter_mut().for_each(|span| span.end = span.end.min(until));
        let (error, shares) = estimate(&scene, wanted, steps.len() + 1, watch)?;
        until = error.t;
        let [bar, tolerance] = wanted.judged(&error)?;
        let is_last = shares.is_none();
        let is_whole = error.lacks().is_none();
        let best = match &mut best {
            Some(best) if best.remains(bar, is_whole) => {
                best.failures += 1;
                best
            }
            best => {
                let (shares, failures) = (shares.unwrap_or_default(), i32::from(!is_whole));
                best.insert(Best { body: body.clone(), shares, bar, is_whole, failures })
            }
        };
        if !is_last && !watch.is_stopped() {
            body = Arc::new(Body::sized(file, &spec.mesh, best.next(tolerance), store, watch.mesher)?);
        }
        let spent = stopwatch.spent();
        let (cells, dofs) = (scene.body.mesh.cell_count(), scene.system.dofs.free.len());
        let mesh = scene.body.source.clone();
        let step = RefinementStep { mesh, cells, dofs, error, bar, tolerance, spent };
        (watch.step)(&step);
        steps.push(step);
        if is_last {
            return Ok(Refinement { body: best.body.clone(), steps });
        }
        if watch.is_stopped() {
            return Err(RefineError::Interrupted { number: steps.len(), cells });
        }
    }
}

/// The error of the quantity on mesh `number`, and the magnitudes of the shares of its cells; without shares this mesh is the last.
fn estimate(
    scene: &Scene,
    wanted: &RefineSpec,
    number: usize,
    watch: &mut RefinementWatch,
) -> Result<(QuantityError, Option<Vec<f64>>), RefineError> {
    // The border of a region cuts through cells on every mesh of the mesher
    let goes_on = |error: &QuantityError| {
        let is_above = || wanted.judged(error).is_ok_and(|judged| !is_within(error, judged));
        number < wanted.meshes && error.cut_regions.is_empty() && is_above()
    };
    let mut estimator = ErrorEstimator::new(scene)?.localised_where(goes_on)?;
    if let Some(stop) = &watch.stop {
        estimator = estimator.stopped_by(stop.clone());
    }
    let cells = scene.body.mesh.cell_count();
    let columns = [wanted.quantity.clone()];
    estimator.check_columns(&columns)?;
    let mut add = |state: &State| estimator.add(state);
    let mut go_on = |progress| (watch.progress)(progress);
    let run =
        scene.run_with(RunOptions { on_state: Some(&mut add), on_progress: Some(&mut go_on), ..RunOptions::default() });
    match run.status {
        Status::Converged => (),
        Status::Interrupted { .. } => return Err(RefineError::Interrupted { number, cells }),
        status => return Err(RefineError::NotSolved { number, cells, status: status.name() }),
    }
    let mut found = match estimator.estimate(&run, &columns) {
        Err(EstimateError::Stopped) => return Err(RefineError::Interrupted { number, cells }),
        found => found?,
    };
    Ok((found.quantities.swap_remove(0), found.cells.pop().map(|shares| shares.size)))
}

impl RefineSpec {
    /// The deciding error bar and its tolerance, in the unit of the quantity.
    fn judged(&self, error: &QuantityError) -> Result<[f64; 2], RefineError> {
        if let Some(tolerance) = self.absolute_tolerance {
            return Ok([error.bar, tolerance]);
        }
        let (change, bar) = (error.value - error.start, error.departure.bar);
        // A change of at most a tenth of its bar is indistinguishable from zero, and a share of it is not a meaningful tolerance.
        if 10.0 * change.abs() <= bar {
            return Err(RefineError::NearZero { name: error.column.clone(), change });
        }
        Ok([bar, self.tolerance.unwrap_or(0.0) * change.abs()])
    }
}

/// Edge lengths \[cells\] \[m\] of the next mesh with which the error falls to the share `aim` with the fewest cells.
fn lengths(mesh: &TetMesh, shares: &[f64], aim: f64, bounds: [f64; 2]) -> Vec<f64> {
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let exponents: Vec<f64> =
        shares.iter().map(|share| (share / mean).max(LEAST_SHARE).powf(-1.0 / (ORDER + 3.0))).collect();
    let change = |factor: f64, own: &f64| (factor * own).clamp(bounds[0], bounds[1]);
    let error = |factor: f64| -> f64 {
        exponents.iter().zip(shares).map(|(own, share)| share / mean * change(factor, own).powf(ORDER)).sum::<f64>()
            / shares.len() as f64
    };
    let cells = |factor: f64| exponents.iter().map(|own| change(factor, own).powi(-3)).sum::<f64>();
    let most = MOST_GROWTH * shares.len() as f64;
    // The largest factor that reaches the error aimed at, unless it asks for too many cells: both are monotonic in it.
    let (mut low, mut high) = (1e-3_f64, 1e3_f64);
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        if error(middle) > aim && cells(middle) < most { high = middle } else { low = middle }
    }
    let factor = (low * high).sqrt();
    (0..mesh.cell_count()).map(|c| edge(mesh, c) * change(factor, &exponents[c])).collect()
}

/// Number of cells that a size field in units of `length` \[m\] asks for: a cell becomes (its edge length / the edge length of the field)³ cells.
fn cells(mesh: &TetMesh, field: &SizeField, length: f64) -> u64 {
    let there = |cell: &[u32; 4]| cell.iter().map(|k| field.sizes[*k as usize]).sum::<f64>() / 4.0 * length;
    let parts = |(c, cell): (usize, &[u32; 4])| (edge(mesh, c) / there(cell)).powi(3);
    field.cells.iter().enumerate().map(parts).sum::<f64>().round() as u64
}

/// Mean length of the edges of a cell \[m\].
fn edge(mesh: &TetMesh, c: usize) -> f64 {
    let corner = |k: usize| mesh.points[mesh.cell(c)[k] as usize];
    CELL_EDGES.iter().map(|[i, j]| (corner(*i) - corner(*j)).norm()).sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Order;
    use crate::mesh::structured::block;
    use crate::scene::error_estimate::{ErrorBounds, GeometryError};

    fn cells_of(mesh: &TetMesh, lengths: &[f64]) -> f64 {
        lengths.iter().enumerate().map(|(c, h)| (edge(mesh, c) / h).powi(3)).sum()
    }

    /// Equal shares are refined equally, by the error aimed at and the order.
    #[test]
    fn equal_shares_are_refined_equally() {
        let mesh = block(2, 2, 2, 1.0, 1.0, 1.0, Order::Linear);
        let lengths = lengths(&mesh, &vec![3.0; mesh.cell_count()], 0.5, BOUNDS);
        for (c, h) in lengths.iter().enumerate() {
            assert!((h / edge(&mesh, c) - 0.5_f64.powf(1.0 / ORDER)).abs() < 1e-9);
        }
    }

    /// No uniform mesh with the same predicted error has as few cells, and the growth is bounded.
    #[test]
    fn graded_meshes_have_fewer_cells_and_growth_is_bounded() {
        let mesh = block(3, 3, 3, 1.0, 1.0, 1.0, Order::Linear);
        let shares: Vec<f64> = (0..mesh.cell_count()).map(|c| (-(c as f64) / 20.0).exp()).collect();
        let graded = lengths(&mesh, &shares, 0.5, BOUNDS);
        let predicted = |lengths: &[f64]| -> f64 {
            let part = |(c, h): (usize, &f64)| shares[c] * (h / edge(&mesh, c)).powf(ORDER);
            lengths.iter().enumerate().map(part).sum::<f64>() / shares.iter().sum::<f64>()
        };
        assert!((predicted(&graded) - 0.5).abs() < 1e-6);
        let uniform = mesh.cell_count() as f64 * 0.5_f64.powf(-3.0 / ORDER);
        assert!(cells_of(&mesh, &graded) < 0.8 * uniform, "{} and {uniform}", cells_of(&mesh, &graded));
        let hasty = lengths(&mesh, &shares, 1e-3, BOUNDS);
        assert!(cells_of(&mesh, &hasty) <= MOST_GROWTH * mesh.cell_count() as f64 * (1.0 + 1e-6));
    }

    /// An error of a value with a bar of 0.08 mm.
    fn error(start: f64, value: f64) -> QuantityError {
        QuantityError {
            column: "tip_z_m".into(),
            t: 1.0,
            value,
            start,
            enriched: value,
            discretisation: [0.0, 4e-5, 8e-5],
            geometry: None,
            extent: 0.0,
            cut_regions: vec![],
            contacts: vec![],
            unresolved: false,
            corrected: value + 4e-5,
            uncertainty: 4e-5,
            bar: 8e-5,
            departure: ErrorBounds { correction: 4e-5, uncertainty: 4e-5, bar: 8e-5 },
        }
    }

    /// A tip that rises by 4 mm, with a bar of 0.08 mm, wherever the origin is; a quantity that does not move needs an absolute tolerance.
    #[test]
    fn a_share_is_one_of_the_change() {
        let wanted =
            RefineSpec { quantity: "tip_z_m".into(), tolerance: Some(0.01), absolute_tolerance: None, meshes: 4 };
        for start in [0.0, 0.5, -3.0] {
            let [bar, tolerance] = wanted.judged(&error(start, start + 4e-3)).expect("it moves");
            assert!((bar - 8e-5).abs() < 1e-12 && (tolerance - 4e-5).abs() < 1e-12, "{start}: {bar} {tolerance}");
        }
        assert!(matches!(wanted.judged(&error(0.5, 0.5)), Err(RefineError::NearZero { .. })));
        let absolute = RefineSpec { tolerance: None, absolute_tolerance: Some(1e-6), ..wanted };
        assert_eq!(absolute.judged(&error(0.5, 0.5)).expect("given"), [8e-5, 1e-6]);
    }

    /// A bar that lacks the extent of a region, or the error next to a singular edge, is within no tolerance; a known change by extent is a part of the bar.
    #[test]
    fn a_bar_with_a_part_missing_is_within_no_tolerance() {
        let whole = QuantityError { geometry: Some(GeometryError::default()), ..error(0.0, 4e-3) };
        let cut = QuantityError { cut_regions: vec!["clamp".into(), "tip".into()], ..whole.clone() };
        assert!(is_within(&whole, [1.0, 1.0]) && !is_within(&whole, [1.0, 0.9]) && !is_within(&cut, [1.0, 1.0]));
        assert_eq!(whole.lacks(), None);
        assert_eq!(cut.lacks().as_deref(), Some("the extent of clamp and tip"));
        let neither = QuantityError { geometry: None, ..cut };
        assert_eq!(neither.lacks().as_deref(), Some("curved facets and the extent of clamp and tip"));
        assert_eq!(neither.lacks_on_facets().as_deref(), Some("the extent of clamp and tip"));
        // A marker next to the tip of a crack
        let near = QuantityError { unresolved: true, ..whole };
        assert!(!is_within(&near, [1.0, 1.0]));
        assert_eq!(near.lacks().as_deref(), Some("the singular edge or small patch in the cell of its place"));
    }

    /// A bar that lacks the error of curved facets is within no tolerance, whatever its value, and no reason to keep a mesh.
    #[test]
    fn a_bar_with_a_part_missing_is_no_measure() {
        let body = Arc::new(Body::of_mesh(block(1, 1, 1, 1.0, 1.0, 1.0, Order::Linear)));
        let best = |is_whole| Best { body: body.clone(), shares: vec![], bar: 1.0, is_whole, failures: 0 };
        assert!(best(true).remains(0.1, false) && best(true).remains(2.0, true) && !best(true).remains(0.1, true));
        assert!(!best(false).remains(2.0, false) && !best(false).remains(2.0, true));
    }

    /// After a mesh that did not improve on the best one, the next mesh follows from the best one, has more cells than it would have had, and no larger ones.
    #[test]
    fn a_failure_is_followed_by_a_finer_mesh() {
        let mesh = block(3, 3, 3, 1.0, 1.0, 1.0, Order::Linear);
        let shares: Vec<f64> = (0..mesh.cell_count()).map(|c| (-(c as f64) / 20.0).exp()).collect();
        let body = Arc::new(Body::of_mesh(mesh));
        let after = |failures| {
            Best { body: body.clone(), shares: shares.clone(), bar: 1.0, is_whole: true, failures }.next(0.9).1
        };
        let [first, second, third] = [0, 1, 2].map(after);
        assert!(first < second && second < third, "{first} {second} {third}");
        let lengths = lengths(&body.mesh, &shares, 0.9, BOUNDS_AFTER_FAILURE);
        assert!(lengths.iter().enumerate().all(|(c, h)| *h <= edge(&body.mesh, c) * (1.0 + 1e-12)));
    }
}
