//! Figures of a convergence study.

pub mod bodies;
pub mod cost;
pub mod curves;
pub mod errors;
pub mod formulations;
mod look;

use crate::report::figure::{Drawn, drawn};
use crate::study::analysis::Analysis;
use crate::study::figures::time;
use crate::study::kinds::convergence::findings::ConvergenceFindings;
use crate::study::store::results::Results;

/// Draws every figure that the stored data allow.
pub fn draw(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Vec<Drawn> {
    let mut out = vec![];
    out.extend(drawn("meshes", || bodies::meshes(store)));
    out.extend(drawn("bent", || bodies::bent(store, analysis)));
    let curves = |v: &String| drawn(&format!("curves-{v}"), || curves::draw(store, analysis, v));
    out.extend(store.study.variants.iter().filter_map(curves));
    out.extend(drawn("formulations", || formulations::draw(store, analysis)));
    out.extend(drawn("error-h", || errors::against_h(store, analysis)));
    out.extend(drawn("error-cost", || errors::against_cost(store, analysis)));
    out.extend(drawn("cost", || cost::draw(store)));
    let headline = analysis.headline().map(|q| q.variant.as_str());
    out.extend(headline.into_iter().flat_map(|v| time::of_variant(store, v, "time")));
    out
}
