//! The mesh that `durometer simulate` runs on, refined if the scene asks for it.

use super::args::Args;
use super::errors::{WITHOUT_FACETS, without_extent};
use crate::interrupt;
use crate::progress::Bars;
use durometer::report::numbers::{five_digits, seconds};
use durometer::scene::{Body, RefinementStep, RefinementWatch, SceneSpec, refine};
use durometer::study::run::runner::Watch;
use durometer::study::store::csv_text;
use durometer::study::store::folder;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Loads the mesh of the scene, refined if the scene asks for it, and returns whether the error is then within the tolerance.
pub fn mesh(
    args: &Args,
    scene: (&Path, &SceneSpec, &str),
    name: &str,
    bars: &Bars,
) -> Result<(Arc<Body>, bool), Box<dyn std::error::Error>> {
    let (file, spec, _) = scene;
    let body = Arc::new(Body::load(file, &spec.mesh, &mut |line| bars.meshing(name, line))?);
    let Some(wanted) = &spec.mesh.refine else { return Ok((body, true)) };
    let (table, mut steps) = (args.out.join(format!("{name}.refinement.csv")), vec![]);
    let mut follow = |step: &RefinementStep| {
        if !args.json {
            print_refinement(step);
        }
        steps.push(step.clone());
        // A failure is ignored here: the table is written again at the end, where a failure is an error
        _ = folder::write(&table, &csv_text::refinement(&steps));
    };
    let stop = interrupt::stop_flag();
    bars.started(name);
    let mut watch = RefinementWatch {
        step: &mut follow,
        mesher: &mut |line| bars.meshing(name, line),
        progress: &mut |progress| {
            bars.progress(name, progress);
            !stop.load(Ordering::Relaxed)
        },
        stop: Some(stop.clone()),
    };
    let found = refine(scene, wanted, body, None, &mut watch)?;
    folder::write(&table, &csv_text::refinement(&found.steps))?;
    let missed = found.missed();
    missed.iter().for_each(|why| tell!("not complete: {why}"));
    Ok((found.body, missed.is_none()))
}

fn print_refinement(step: &RefinementStep) {
    let RefinementStep { cells, error, bar, tolerance, .. } = step;
    let facets = if error.geometry.is_none() { WITHOUT_FACETS } else { "" };
    let extent = if error.cut_regions.is_empty() { String::new() } else { without_extent(&error.cut_regions) };
    say!(
        "mesh of {cells} cells: {} = {}, error bar {}{facets}{extent} (tolerance {}), {}",
        error.column,
        five_digits(error.value),
        five_digits(*bar),
        five_digits(*tolerance),
        seconds(step.spent.cpu_s)
    );
}
