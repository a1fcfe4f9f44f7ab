//! Discretisation error of recorded quantities, estimated from one run.
//!
//! At the time at which a quantity departs most from its start, the equilibrium is solved again in an enriched space that contains the space of the run
//! (hierarchical or two-level estimate: R. E. Bank & R. K. Smith, *SIAM J. Numer. Anal.* 30 (1993) 921–935). The change e = J⁺ − J is the part of the error
//! that the enrichment resolves. If the error of J falls with the q-th power of h, then
//!
//! ```text
//! J_exact − J = c e,   c = 1/(1 − 2^{-q})                  each cell split into eight
//! J_exact − J = c e,   1/(1 + ϱ) ≤ c ≤ 1/(1 − ϱ)           linear cells raised to quadratic ones, ϱ the share of the error that stays
//! ```
//!
//! If the state depends on the path (inertia, viscosity, friction, contact of deformable surfaces), the whole protocol is run in the enriched space. J is then
//! the extreme and e its change; each run has its extreme at its own time.
//!
//! The order q is not known from one run: [`Enrichment::factors`] gives bounds of c. `tests/estimates/error_estimate.rs` compares them with true errors.
//!
//! Both spaces lie on the facets of the mesh. Where these cut off a curved boundary, the enriched equilibrium is solved once more with its new boundary nodes
//! on a smooth surface ([`on_smooth_surface`](crate::mesh::smooth_surface::on_smooth_surface)); with the change g the error gains a geometry term,
//! J_exact − J = c e + γ g. A region of nodes whose border cuts through cells adds δ x, where x is the change when it is widened by one layer of enriched
//! cells.
//!
//! An enriched equilibrium on a branch other than that of the run gives no estimate.
//!
//! Limit: the time step does not change, so that its error is not included.

mod enrichment;
mod extent;
mod geometry;
mod indicators;
mod kept_state;
mod refusal;
mod singular_edge;
mod unresolved;

pub use enrichment::Enrichment;
pub use geometry::GeometryError;
pub use indicators::CellErrors;
pub use refusal::{EstimateError, path_dependence};
pub use singular_edge::has_glued_edge;

use super::body::source_volume::SourceVolume;
use super::notes::volumes::lost_volumes;
use super::notes::wrinkles::no_limit_at;
use super::record::extreme::{ExtremeKind, extreme, extreme_on};
use super::record::recorder::Energies;
use super::{Run, Scene};
use crate::math::stopwatch::{Spent, Stopwatch};
use crate::mesh::row_of_sides::angle_in_row;
use crate::solve::{Integrator, Step};
use crate::system::State;
use crate::wording::all;
use enrichment::{EnrichedScene, check_branch};
use extent::{EXTENT, ExtentSpace};
use geometry::{GEOMETRY, Geometry};
use kept_state::{Kept, Solved, Start};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use unresolved::unresolved_columns;

/// Error of one recorded quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct QuantityError {
    /// Recorded column
    pub column: String,
    /// Time of the extreme of the run, the largest departure from the start, whose error is estimated \[s\]
    pub t: f64,
    /// J of the run at that time
    pub value: f64,
    /// J of the first row of the run
    pub start: f64,
    /// J⁺ of the enriched space: at that time, or, if the whole protocol is run, the extreme on the same side of the start at any time
    pub enriched: f64,
    /// c e with the smallest, the likely and the largest c
    pub discretisation: [f64; 3],
    /// Error due to facets that cut off a curved boundary; `None` if it is not estimated
    pub geometry: Option<GeometryError>,
    /// Change when regions of nodes whose border cuts through cells are widened by one layer of cells; 0 without such a region
    pub extent: f64,
    /// Regions on which the quantity depends and whose border cuts through cells: the bar does not contain the error of their extent
    pub cut_regions: Vec<String>,
    /// Contacts that end within their region: their border is resolved only by points, also in the enriched space, and the bar may be several times too small
    pub contacts: Vec<String>,
    /// Whether the quantity belongs to a place in a cell with a singular edge, or with a force on a patch smaller than the cell, neither of which the cell
    /// resolves: the bar may be several times too small
    pub unresolved: bool,
    /// J + c e + g with the likely c, and half of the change by extent
    pub corrected: f64,
    /// Largest distance of the bounds of the exact value from `corrected`
    pub uncertainty: f64,
    /// Largest |J_exact − J| within the bounds
    pub bar: f64,
    /// Bounds of the largest departure from the start; errors that also change the first value, such as those of the mean of a region of nodes, do not count
    pub departure: ErrorBounds,
}

/// Bounds of the exact value \[unit of the quantity\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorBounds {
    /// Likely J_exact − J
    pub correction: f64,
    /// Largest distance of the bounds of J_exact − J from `correction`
    pub uncertainty: f64,
    /// Largest |J_exact − J| within the bounds
    pub bar: f64,
}

impl ErrorBounds {
    /// Combines the smallest, the likely and the largest discretisation error with the changes by geometry and by extent.
    fn new(discretisation: [f64; 3], geometry: f64, extent: f64) -> Self {
        let ends = |of: [f64; 3]| (of[0].min(of[2]), of[0].max(of[2]));
        let ((mut low, mut high), mut correction) = (ends(discretisation), discretisation[1]);
        for all in [GEOMETRY.map(|share| geometry * share), EXTENT.map(|share| extent * share)] {
            let (lower, higher) = ends(all);
            (low, high, correction) = (low + lower, high + higher, correction + all[1]);
        }
        let uncertainty = (high - correction).max(correction - low);
        Self { correction, uncertainty, bar: low.abs().max(high.abs()) }
    }
}

impl QuantityError {
    /// The parts of the error that the bar lacks, in words; `None` if it is complete.
    pub fn lacks(&self) -> Option<String> {
        let facets = self.geometry.is_none().then(|| "curved facets".to_string());
        let parts: Vec<String> = facets.into_iter().chain(self.parts_on_facets()).collect();
        (!parts.is_empty()).then(|| all(&parts))
    }

    /// The parts of the error that the bar lacks, in words, for the body that the facets of the mesh enclose, so that its facets are not an error; `None` if
    /// it is complete.
    pub fn lacks_on_facets(&self) -> Option<String> {
        let parts: Vec<String> = self.parts_on_facets().collect();
        (!parts.is_empty()).then(|| all(&parts))
    }

    fn parts_on_facets(&self) -> impl Iterator<Item = String> {
        let extent = (!self.cut_regions.is_empty()).then(|| format!("the extent of {}", all(&self.cut_regions)));
        let edge = self.unresolved.then(|| "the singular edge or small patch in the cell of its place".to_string());
        let contacts = (!self.contacts.is_empty()).then(|| format!("the border of contact {}", all(&self.contacts)));
        extent.into_iter().chain(contacts).chain(edge)
    }
}

/// Errors of quantities of a run, and the cost of finding them.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorEstimate {
    pub enrichment: Enrichment,
    /// Whether the whole protocol was run in the enriched space because the state depends on the path
    pub whole_run: bool,
    pub quantities: Vec<QuantityError>,
    /// Volumes of the mesh that are far from those of its CAD: no bar contains the error of this surface
    pub missed_volumes: Vec<SourceVolume>,
    /// Angle between consecutive flat sides of equal width about one axis \[rad\]: a prism has no other surface, but for a round body no bar contains the
    /// error of its surface
    pub angle_in_row: Option<f64>,
    /// Shares of the cells, one entry for each quantity, if they were requested
    pub cells: Vec<CellErrors>,
    /// Number of equations of the enriched space
    pub dofs: usize,
    /// Number of times at which the enriched space was solved
    pub solves: usize,
    pub factorisations: usize,
    pub spent: Spent,
}

/// Estimates errors of a run: it collects the states of the run, and solves in the enriched space afterwards.
pub struct ErrorEstimator<'a> {
    scene: &'a Scene,
    enrichment: Enrichment,
    /// Whether the states depend on the path.
    whole_run: bool,
    /// Whether a held face ends at a re-entrant edge.
    glued: bool,
    /// The errors for which the shares of the cells are found as well
    localised: Localised<'a>,
    states: Vec<Kept>,
    /// Flag that stops the solutions in the enriched space
    stop: Option<Arc<AtomicBool>>,
}

/// Whether the shares of the cells in an error are to be found.
type Localised<'a> = Box<dyn Fn(&QuantityError) -> bool + 'a>;

impl<'a> ErrorEstimator<'a> {
    /// An estimator for a run of this scene, with the usual enrichment for its cells.
    ///
    /// # Errors
    ///
    /// Where the scene has no estimate, with the part that prevents it.
    pub fn new(scene: &'a Scene) -> Result<Self, EstimateError> {
        Self::with(scene, Enrichment::usual(scene.body.mesh.order))
    }

    /// An estimator for a run of this scene with the given enrichment.
    ///
    /// # Errors
    ///
    /// Fails as [`ErrorEstimator::new`] does.
    pub fn with(scene: &'a Scene, enrichment: Enrichment) -> Result<Self, EstimateError> {
        refusal::check(scene)?;
        let whole_run = refusal::path_dependence(scene).is_some();
        let (glued, localised) = (has_glued_edge(scene), Box::new(|_: &QuantityError| false));
        Ok(Self { scene, enrichment, whole_run, glued, localised, states: Vec::new(), stop: None })
    }

    /// Finds the shares of the cells as well, by an adjoint solution for every quantity.
    ///
    /// # Errors
    ///
    /// Where the scene has no adjoint solution.
    pub fn localised(self) -> Result<Self, EstimateError> {
        self.localised_where(|_| true)
    }

    /// Finds the shares of the cells as well, but only for errors that `wanted` accepts: an adjoint solution costs as much as the estimate.
    ///
    /// # Errors
    ///
    /// Where the scene has no adjoint solution.
    pub fn localised_where(self, wanted: impl Fn(&QuantityError) -> bool + 'a) -> Result<Self, EstimateError> {
        refusal::check_adjoint(self.scene)?;
        Ok(Self { localised: Box::new(wanted), ..self })
    }

    /// Ends the solutions in the enriched space when `stop` is set; there is then no estimate.
    pub fn stopped_by(self, stop: Arc<AtomicBool>) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Takes a state on the time grid; to be passed as the [`on_state`](super::RunOptions::on_state) of the run.
    pub fn add(&mut self, state: &State) {
        if !self.whole_run {
            self.states.push(Kept::new(state));
        }
    }

    /// Estimates the errors of these columns of the run, or of all columns that have an estimate if none are given.
    ///
    /// # Errors
    ///
    /// Where the states are not those of this run, a column has no estimate, or the enriched problem has no solution.
    pub fn estimate(&self, run: &Run, columns: &[String]) -> Result<ErrorEstimate, EstimateError> {
        let found = self.estimate_whole(run, columns);
        // A solution that was stopped can look like one that does not exist
        let stopped = self.stop.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed));
        if stopped { Err(EstimateError::Stopped) } else { found }
    }

    fn estimate_whole(&self, run: &Run, columns: &[String]) -> Result<ErrorEstimate, EstimateError> {
        let stopwatch = Stopwatch::start();
        if let Some(why) = no_limit_at(self.scene, &run.peak.x) {
            return Err(EstimateError::NoLimit { why });
        }
        if let Some(lost) = lost_volumes(self.scene, &run.peak.x).next() {
            return Err(EstimateError::VolumesLost { why: lost.to_string() });
        }
        let columns = self.columns(&run.columns, columns)?;
        if !self.whole_run && self.states.len() != run.rows.len() {
            return Err(EstimateError::OtherRun { states: self.states.len(), rows: run.rows.len() });
        }
        let mut enriched = EnrichedScene::new(self.scene, self.enrichment)?;
        enriched.stop.clone_from(&self.stop);
        let mut peaks: Vec<(usize, Vec<usize>)> = Vec::new();
        for column in columns {
            let row = extreme(run.rows.iter().map(|row| row[column])).map_or(0, |e| e.at);
            match peaks.iter_mut().find(|(known, _)| *known == row) {
                Some((_, own)) => own.push(column),
                None => peaks.push((row, vec![column])),
            }
        }
        let (mut quantities, mut cells, mut factorisations) = (Vec::new(), Vec::new(), 0);
        let near = unresolved_columns(self.scene, &enriched, &run.memories[0]);
        let first = (!self.whole_run).then(|| {
            let state = enriched.interpolate(self.scene, &self.states[0]);
            Start { row: enriched.row_at(&state, &run.memories[0]), state, memory: &run.memories[0] }
        });
        let mut extent = ExtentSpace::new(first.as_ref().map(|first| (&enriched, first)), self.scene);
        let mut geometry = match &first {
            None => Geometry::of_whole_run(&enriched, self.scene),
            Some(first) => Geometry::new(&enriched, self.scene, first),
        };
        if self.whole_run {
            let known = (&near[..], geometry.of_flat(), &extent);
            let (found, count) = self.of_whole_run(&enriched, run, known, std::mem::take(&mut peaks))?;
            quantities.extend(found);
            factorisations += count;
        }
        for (row, columns) in &peaks {
            let solved = self.solve(&mut enriched, run, *row)?;
            factorisations += solved.factorisations;
            let surface = geometry.errors(&solved);
            let wider = extent.changes(&enriched, &solved);
            let of = |&column: &usize| {
                let surface = surface.as_ref().map(|all| all[column]);
                let both = [first.as_ref().map_or(f64::NAN, |first| first.row[column]), solved.values[column]];
                let error = self.error((run, *row), column, both, surface, (wider[column], &extent));
                QuantityError { unresolved: near[column], ..error }
            };
            let errors: Vec<(usize, QuantityError)> = columns.iter().map(|column| (*column, of(column))).collect();
            let wanted = errors.iter().filter(|(_, error)| (self.localised)(error));
            let own: Vec<(usize, &str, f64)> =
                wanted.map(|&(k, _)| (k, run.columns[k].as_str(), run.rows[*row][k])).collect();
            quantities.extend(errors);
            if !own.is_empty() {
                factorisations += 1;
                let shares = indicators::localise(&enriched, &solved, &own)?;
                cells.extend(own.iter().map(|(column, ..)| *column).zip(shares));
            }
        }
        let missed_volumes = geometry.missed_volumes();
        let is_assumed = missed_volumes.is_empty() && (!self.whole_run || geometry.of_flat().is_some());
        let angle_in_row = is_assumed.then(|| angle_in_row(&self.scene.body.mesh)).flatten();
        factorisations += geometry.factorisations + extent.factorisations;
        quantities.sort_by_key(|(column, _)| *column);
        cells.sort_by_key(|(column, _)| *column);
        Ok(ErrorEstimate {
            enrichment: self.enrichment,
            whole_run: self.whole_run,
            quantities: quantities.into_iter().map(|(_, error)| error).collect(),
            missed_volumes,
            angle_in_row,
            cells: cells.into_iter().map(|(_, shares)| shares).collect(),
            dofs: enriched.scene.system.dofs.free.len(),
            solves: peaks.len().max(1),
            factorisations,
            spent: stopwatch.spent(),
        })
    }

    /// The errors of columns, given the rows of their extremes, if the whole protocol is run in the enriched space; with the number of factorisations.
    fn of_whole_run(
        &self,
        enriched: &EnrichedScene,
        run: &Run,
        (near, geometry, extent): (&[bool], Option<GeometryError>, &ExtentSpace),
        peaks: Vec<(usize, Vec<usize>)>,
    ) -> Result<(Vec<(usize, QuantityError)>, usize), EstimateError> {
        let fine = enriched.run(run)?;
        let (mut found, mut last) = (Vec::new(), 0.0_f64);
        for (row, column) in peaks.into_iter().flat_map(|(row, own)| own.into_iter().map(move |column| (row, column))) {
            let (t, value) = extreme_of(&fine.rows, &run.rows, column);
            last = last.max(t).max(run.rows[row][0]);
            let both = [fine.rows[0][column], value];
            let error = self.error((run, row), column, both, geometry, ([0.0; 2], extent));
            found.push((column, QuantityError { unresolved: near[column], ..error }));
        }
        check_branch(&fine, run, last)?;
        Ok((found, fine.factorisations))
    }

    /// Refuses columns that have no estimate; for use before the run.
    ///
    /// # Errors
    ///
    /// Where a column is not recorded or has no estimate; the error names the first such column.
    pub fn check_columns(&self, names: &[String]) -> Result<(), EstimateError> {
        self.columns(&self.scene.columns(), names).map(|_| ())
    }

    /// The columns that have an estimate: those with a derivative with respect to the state.
    pub fn estimated_columns(&self) -> Vec<String> {
        self.scene.recorders().filter(|r| r.is_differentiable()).flat_map(|r| r.columns()).collect()
    }

    /// Indices of the named columns among `all`; without names, of all columns that have an estimate.
    fn columns(&self, all: &[String], names: &[String]) -> Result<Vec<usize>, EstimateError> {
        let estimated = self.estimated_columns();
        let names = if names.is_empty() { &estimated } else { names };
        let index = |name: &String| {
            let known = estimated.contains(name).then(|| all.iter().position(|c| c == name)).flatten();
            known.ok_or_else(|| EstimateError::Column { name: name.clone(), known: estimated.clone() })
        };
        names.iter().map(index).collect()
    }

    /// The columns in the enriched space at the time of a state of the run: by Newton's method from that state, or, if it does not converge from there or
    /// finds an indefinite tangent and may leave the branch of the run, by running the protocol up to that time.
    fn solve(&self, enriched: &mut EnrichedScene, run: &Run, row: usize) -> Result<Solved, EstimateError> {
        let past = enriched.prolong(self.scene, &self.states[row]);
        let scene = &enriched.scene;
        let step = Step { system: &scene.system, integrator: Integrator::Static, past: &past, dt: 1.0 };
        let mut next = past.clone();
        let mut solver = enriched.solver();
        if !solver.solve(&step, &mut next).is_ok_and(|solution| !solution.regularised) {
            return enriched.run_until(run, past);
        }
        let mut memory = run.memories[row].clone();
        scene.remember(&next, &mut memory);
        let residual = &solver.equations.sums.r;
        let values = scene.record(&next, Some(&step.at(&next)), residual, Energies::default(), 0, &memory);
        Ok(Solved { start: past, end: next, values, memory, factorisations: solver.linear.factor.count })
    }

    /// The error of a column at a row, from its values there and at the start in the enriched space, and from the changes by extent there and at the start.
    fn error(
        &self,
        (run, row): (&Run, usize),
        column: usize,
        [first, enriched]: [f64; 2],
        geometry: Option<GeometryError>,
        ([wider_first, wider], extent): ([f64; 2], &ExtentSpace),
    ) -> QuantityError {
        let (value, start) = (run.rows[row][column], run.rows[0][column]);
        let x = self.states.get(row).map_or(&run.peak.x, |kept| &kept.x);
        let ends_within = self.scene.contacts.iter().filter(|contact| contact.ends_within_region(x));
        let factors = self.enrichment.factors(self.scene.body.mesh.order, self.glued);
        let [discretisation, of_departure] =
            [0.0, first - start].map(|at_start| factors.map(|c| c * (enriched - value - at_start)));
        let GeometryError { change, start: change_at_start } = geometry.unwrap_or_default();
        let bounds = ErrorBounds::new(discretisation, change, wider);
        let departure = ErrorBounds::new(of_departure, change - change_at_start, wider - wider_first);
        QuantityError {
            column: run.columns[column].clone(),
            t: run.rows[row][0],
            value,
            start,
            enriched,
            discretisation,
            geometry,
            extent: wider,
            cut_regions: extent.unknown(&run.columns[column]),
            contacts: ends_within.map(|contact| contact.name.clone()).collect(),
            unresolved: false,
            corrected: value + bounds.correction,
            uncertainty: bounds.uncertainty,
            bar: bounds.bar,
            departure,
        }
    }
}

/// The time and value of the extreme of a column in the enriched run, on the same side of the first value as in the run. If it never departs to that side, the
/// first value is the extreme.
fn extreme_of(fine: &[Vec<f64>], of_run: &[Vec<f64>], column: usize) -> (f64, f64) {
    let values = || fine.iter().map(|row| row[column]);
    let found = match extreme(of_run.iter().map(|row| row[column])).map_or(ExtremeKind::Constant, |own| own.kind) {
        ExtremeKind::Constant => extreme(values()),
        side => extreme_on(side, values()),
    };
    let row = &fine[found.map_or(0, |extreme| extreme.at)];
    (row[0], row[column])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wave that arrives later in the enriched run has its extreme later there, on the same side.
    #[test]
    fn extremes_are_those_of_each_run_on_one_side() {
        let rows =
            |values: [f64; 4]| (0_u32..).zip(values).map(|(k, value)| vec![f64::from(k), value]).collect::<Vec<_>>();
        let of = |fine: [f64; 4], own: [f64; 4]| extreme_of(&rows(fine), &rows(own), 1);
        assert_eq!(of([0.0, 1.0, 3.0, -4.0], [0.0, 2.0, 1.0, -1.5]), (2.0, 3.0));
        assert_eq!(of([0.0, 1.0, 3.0, -4.0], [0.0, 1.0, 1.5, -2.0]), (3.0, -4.0));
        assert_eq!(of([0.5, 1.0, 0.7, 0.6], [0.5, 0.2, 0.3, 0.4]), (0.0, 0.5));
        assert_eq!(of([0.5, 1.0, 0.7, 0.6], [0.5, 0.5, 0.5, 0.5]), (1.0, 1.0));
    }
}
