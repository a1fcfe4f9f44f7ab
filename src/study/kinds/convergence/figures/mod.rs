//! Figures of a convergence study.

pub mod bodies;
pub mod cost;
pub mod curves;
pub mod errors;
pub mod formulations;

use crate::report::figure::Figure;
use crate::study::analysis::Analysis;
use crate::study::figures::time;
use crate::study::kinds::convergence::findings::ConvergenceFindings;
use crate::study::results::Results;

/// Every figure that the stored data allow.
pub fn draw(store: &Results, analysis: &Analysis<ConvergenceFindings>) -> Vec<Figure> {
    let mut out = vec![];
    out.extend(bodies::meshes(store));
    out.extend(bodies::bent(store, analysis));
    out.extend(store.study.variants.iter().filter_map(|v| curves::draw(store, analysis, v)));
    out.extend(formulations::draw(store, analysis));
    out.extend(errors::against_h(store, analysis));
    out.extend(errors::against_cost(store, analysis));
    out.extend(cost::draw(store, analysis));
    out.extend(analysis.headline().and_then(|q| time::of_variant(store, &q.variant, "time".into())));
    out
}
