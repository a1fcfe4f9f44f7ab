//! Output of `durometer simulate`: notes before the run, then its results and costs, and why it is incomplete.

use super::args::Args;
use super::drawing::Drawn;
use super::errors::print_errors;
use crate::outcome::Outcome;
use durometer::math::units::Decimals;
use durometer::report::numbers::{five_digits, seconds};
use durometer::scene::column::is_result;
use durometer::scene::{ErrorEstimate, ExtremeKind, Run, Scene, Sensitivities, limits_of_scene};
use durometer::solve::Status;
use durometer::study::limits::limits_of_run;
use durometer::study::overlay::distance::Distance;
use durometer::study::overlay::markers;
use durometer::study::store::record::CaseRecord;
use std::path::PathBuf;

/// Value, relative to the extreme of its column, below which it is printed as zero.
const ROUNDING: f64 = 1e-12;

pub fn print_notes(args: &Args, scene: &Scene) {
    if !args.json {
        scene.notes.iter().for_each(|note| tell!("{}: {note}", scene.kind_of_note(note)));
        limits_of_scene(scene).iter().for_each(|(kind, limit)| tell!("{kind}: {limit}"));
    }
}

/// Prints the record as JSON, or the results as text; the first `known` notes have been printed before.
pub fn tell<'e>(
    args: &Args,
    (record, known, json): (&CaseRecord, usize, &str),
    states: &[PathBuf],
    errors: impl Iterator<Item = &'e ErrorEstimate>,
    drawn: &Drawn,
) {
    if args.json {
        say!("{json}");
        return;
    }
    print(record, known);
    states.iter().for_each(|file| say!("state:   {}", file.display()));
    errors.for_each(|found| print_errors(found, record));
    say!("{}", costs(record));
    say!("results: {}", args.out.join(format!("{}.csv", record.id)).display());
    drawn.print();
}

/// Prints the results of a run; the first `known` notes have been printed before.
fn print(record: &CaseRecord, known: usize) {
    record.notes[known..].iter().for_each(|note| tell!("note: {note}"));
    limits_of_run(record).iter().for_each(|(kind, limit)| tell!("{kind}: {limit}"));
    for (probe, value) in &record.probes {
        let (peak, last) = (five_digits(value.peak), five_digits(without_rounding(value.last, value.peak)));
        match value.peak_is {
            ExtremeKind::Constant => say!("{probe:28} constant {peak:>12}"),
            kind => {
                say!("{probe:28} {:8} {peak:>12} at {:.3} s   final {last:>12}", kind.name(), Decimals(value.peak_t_s))
            }
        }
    }
    for e in &record.events {
        let value = e.value.map_or_else(String::new, |v| format!(" (at {})", five_digits(v)));
        say!("event {} at {:.4} s{value}: {}", e.event, Decimals(e.t_s), e.did.join(", "));
    }
    for d in &record.distances {
        let (l2, largest) = (100.0 * d.l2, 100.0 * d.largest);
        let inside = d.inside_words().map_or(String::new(), |words| format!(", {words}"));
        let compared = format!("{} points, {}", d.share_words(), d.range_words());
        let (Distance { column, over, .. }, file) = (d, d.origin_words());
        say!("{column} over {over} is off {file}, by {l2:.2} % (L2), {largest:.2} % (largest) at {compared}{inside}");
    }
    record.markers.iter().for_each(|d| say!("{}", markers::words(d)));
    // Contacts that are enforced by multipliers have no counts.
    for c in record.contacts.iter().filter(|c| c.seen > 0) {
        say!(
            "contact {}: {} points, examined {} times in all, {} distances computed, {} active; search {}, collision detection {}",
            c.name,
            c.points,
            c.seen,
            c.tested,
            c.active,
            seconds(c.search_s),
            seconds(c.detection_s)
        );
    }
}

/// Prints which columns have no derivative, and which have none in some rows; the table contains NaN there.
pub fn note_missing(run: &Run, sensitivities: &Sensitivities) {
    let is_left_out = |column: &&String| !sensitivities.columns.contains(column) && is_result(column);
    let left_out: Vec<&str> = run.columns.iter().filter(is_left_out).map(String::as_str).collect();
    if !left_out.is_empty() {
        tell!("note: no derivatives are computed of {}", left_out.join(", "));
    }
    for (k, column) in sensitivities.columns.iter().enumerate() {
        let missing = |row: &&Vec<Vec<f64>>| row[k].iter().any(|d| d.is_nan());
        let count = sensitivities.rows.iter().filter(missing).count();
        if let Some(first) = sensitivities.rows.iter().position(|row| missing(&row)) {
            let t = run.rows[first][0];
            tell!("note: {column} has no derivative in {count} of {} rows, the first at t = {t} s", run.rows.len());
        }
    }
}

/// Warns of keys that change nothing, and of derivatives that are less accurate than they should be.
pub fn note_quality(sensitivities: &Sensitivities) {
    for key in sensitivities.idle() {
        tell!("warning: all derivatives by {key} are zero: it changes none of the columns that have derivatives");
    }
    for (column, key, error) in sensitivities.doubtful() {
        tell!(
            "warning: the derivative of {column} by {key} has an estimated error of {:.1e} of its largest value: the scene is not smooth in \
             this key, as where a guide moves into another cell or a signal has a kink",
            error
        );
    }
}

/// Returns the outcome of a run with the requested error estimates. For an incomplete run it prints the reason, and, if no state was `kept`, how the run
/// could be continued.
pub fn completion(run: &Run, has_errors: bool, kept: bool) -> Outcome {
    if let Some(why) = &run.failure {
        tell!("not complete: {why}");
    }
    // A run with derivatives has no states to continue from
    if matches!(run.status, Status::Interrupted { .. }) && run.failure.is_none() && run.sensitivities.is_none() && !kept
    {
        tell!("note: no state was kept; pass --save-state end to be able to go on with --restart");
    }
    let stopped = run.sensitivities.as_ref().and_then(|s| s.stopped.as_ref());
    if let Some((t, why)) = stopped {
        tell!("not complete: no derivative at t = {t} s: {why}");
    }
    let complete = run.status == Status::Converged && stopped.is_none() && has_errors;
    if complete { Outcome::Complete } else { Outcome::RunIncomplete }
}

/// Replaces a value by zero if it is at the rounding level of its column's extreme.
fn without_rounding(value: f64, extreme: f64) -> f64 {
    if value.abs() < ROUNDING * extreme.abs() { 0.0 } else { value }
}

/// Describes where the time went: every effect and constraint that is assembled, then the linear algebra.
fn costs(record: &CaseRecord) -> String {
    let share = |(name, s): (&str, f64)| format!("{name} {} ({:.0} %)", seconds(s), 100.0 * s / record.wall_s);
    let effects = record.effects.iter().map(|e| (e.name.as_str(), e.wall_s));
    let p = &record.phases;
    let sweeps = (p.contact_forces_s > 0.0).then_some(("contact forces", p.contact_forces_s));
    let all = effects.chain([("factorisation", p.factorisation_s), ("solve", p.solve_s)]).chain(sweeps);
    let (s, w) = (&record.solver, &record.work);
    let lost =
        if s.lost_iterations > 0 { format!(" and {} in refused attempts", s.lost_iterations) } else { String::new() };
    let shifted = if s.shifted_factorisations > 0 {
        format!(", {} of them of tangents shifted towards definiteness", s.shifted_factorisations)
    } else {
        String::new()
    };
    format!(
        "work: {} iterations{lost}, {} factorisations{shifted}\ntime: {} in all, of it {}",
        record.newton_iterations,
        w.factorisations,
        seconds(record.wall_s),
        all.map(share).collect::<Vec<_>>().join(", ")
    )
}
