//! Discretisation errors of one run: `--error`.

use super::args::Args;
use crate::progress::Bars;
use durometer::report::numbers::{five_digits, seconds};
use durometer::scene::{Enrichment, ErrorEstimate, ErrorEstimator, EstimateError, Run, Scene};
use durometer::solve::Status;
use durometer::study::run::runner::Watch;
use durometer::study::store::csv_text;
use durometer::study::store::folder;
use durometer::study::store::record::CaseRecord;
use durometer::wording::{all, distinct};

/// Returns the columns whose errors are requested; empty for all columns.
fn estimated_columns(args: &Args) -> &[String] {
    if args.error.iter().any(|column| column == "all") { &[] } else { &args.error }
}

/// Builds the estimator if errors are requested.
pub fn estimator<'a>(args: &Args, scene: &'a Scene) -> Result<Option<ErrorEstimator<'a>>, EstimateError> {
    if args.error.is_empty() {
        return Ok(None);
    }
    let estimator = ErrorEstimator::new(scene)?;
    estimator.check_columns(estimated_columns(args))?;
    if args.error_cells { estimator.localised().map(Some) } else { Ok(Some(estimator)) }
}

/// Estimates and writes the requested errors; `None` if the run or the enriched solution is not complete.
pub fn estimate(
    estimator: ErrorEstimator,
    args: &Args,
    name: &str,
    run: &Run,
    bars: &Bars,
) -> Result<Option<ErrorEstimate>, Box<dyn std::error::Error>> {
    if run.status != Status::Converged {
        return Ok(None);
    }
    bars.note(name, "the errors are estimated; Ctrl-C ends that, and the results of the run stay");
    let found = match estimator.estimate(run, estimated_columns(args)) {
        Err(
            why @ (EstimateError::NotSolved { .. }
            | EstimateError::TooLong { .. }
            | EstimateError::Unstable { .. }
            | EstimateError::Stopped),
        ) => {
            tell!("not complete: no error estimate: {why}");
            return Ok(None);
        }
        found => found?,
    };
    folder::write(&args.out.join(format!("{name}.errors.csv")), &csv_text::errors(&found))?;
    Ok(Some(found))
}

/// Addition to an error bar that does not include the geometry error.
pub const WITHOUT_FACETS: &str = " (without curved facets, which are not estimated here)";

/// Returns the addition to an error bar that does not include the extent of these regions.
pub fn without_extent(regions: &[String]) -> String {
    format!(" (without the extent of {})", regions.join(", "))
}

pub fn print_errors(found: &ErrorEstimate, record: &CaseRecord) {
    for volume in &found.missed_volumes {
        tell!(
            "warning: the error bars do not contain the error of the surface, since the mesh is too far from its surface, CAD or round grid ({volume}): the error may be \
             several times the bar; use more cells, or a smaller size"
        );
    }
    if let Some(angle) = found.angle_in_row {
        tell!(
            "note: flat sides meet at {:.0}° in a row about one axis, and the error bars take them for those of a prism: if the body is round there, the error may be \
             several times the bar; use more cells around, or cells that are quadratic on the round surface",
            angle.to_degrees()
        );
    }
    if found.enrichment == Enrichment::Split && record.locking.as_ref().is_some_and(|l| l.alarm) {
        tell!(
            "warning: the smaller cells by which the errors are estimated lock too: the error may be several times the bar"
        );
    }
    let unresolved: Vec<&str> = found.quantities.iter().filter(|q| q.unresolved).map(|q| q.column.as_str()).collect();
    if !unresolved.is_empty() {
        tell!(
            "warning: a cell with a singular edge, such as the border of a held region, or with a patch of a force or a guide that is smaller does not resolve a place in it: \
             the error of {} may be several times the bar; use cells that are smaller than the distance from the edge, or than the patch",
            unresolved.join(", ")
        );
    }
    let contacts = distinct(found.quantities.iter().flat_map(|q| q.contacts.clone()));
    if !contacts.is_empty() {
        tell!(
            "warning: the border of contact {} is found by points of the mesh, and the error bars do not contain its error, which may be several times the bar: take a family of \
             meshes",
            all(&contacts)
        );
    }
    for q in &found.quantities {
        let (value, corrected, uncertainty) =
            (five_digits(q.value), five_digits(q.corrected), five_digits(q.uncertainty));
        let geometry = match q.geometry {
            Some(g) if g.change == 0.0 => String::new(),
            Some(g) => format!(" (of it {} by curved facets)", five_digits(g.change)),
            None => WITHOUT_FACETS.into(),
        };
        let extent = match (&q.cut_regions[..], q.extent) {
            ([], 0.0) => String::new(),
            ([], change) => format!(" (of it up to {} by the extent of regions)", five_digits(change.abs())),
            (regions, _) => without_extent(regions),
        };
        say!(
            "{:28} error bar {:>12} of {value:>12}; corrected {corrected} ± {uncertainty}{geometry}{extent}",
            q.column,
            five_digits(q.bar)
        );
    }
    let (cpu, dofs) = (seconds(found.spent.cpu_s), found.dofs);
    let what = match found.solves {
        _ if found.whole_run => "a whole run".into(),
        1 => "1 solution".into(),
        solves => format!("{solves} solutions"),
    };
    say!("errors:  {what} with {dofs} equations in {cpu}");
}
