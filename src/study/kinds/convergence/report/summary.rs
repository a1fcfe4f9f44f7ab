//! `analysis` of the `summary.json` of a convergence study.

use crate::study::analysis::{Analysis, ByQuantity, by_name};
use crate::study::kinds::convergence::findings::{ConvergenceFindings, MeshErrors};
use serde_json::{Map, Value, json};

/// Returns observed order, Richardson value, GCI and ratio of the headline's family, which is `sizes` if it shows an order; then the other
/// quantities.
pub fn headline(analysis: &Analysis<ConvergenceFindings>) -> Map<String, Value> {
    let mut out = Map::new();
    let q = analysis.headline();
    let sizes = q.and_then(|q| q.sizes());
    // If the sizes show no order, the family of the reference is used; `family` names it
    let e = sizes.filter(|e| e.observed_order.is_some()).or_else(|| {
        let q = q?;
        q.reference.as_ref().and_then(|r| q.estimate(&r.family)).or(q.estimates.first())
    });
    let r = analysis.recommended.as_ref();
    let reference = q.and_then(|q| q.reference.as_ref());
    let mut put = |key: &str, value: Value| out.insert(key.to_string(), value);
    put("quantity", json!(q.map(|q| &q.quantity.name)));
    put("unit", json!(q.map(|q| &q.quantity.unit)));
    put("variant", json!(q.map(|q| &q.variant)));
    put("family", json!(e.map(|e| &e.family)));
    put("observed_order", json!(e.and_then(|e| e.observed_order)));
    put("richardson_peak", json!(e.and_then(|e| e.richardson)));
    put("gci_percent", json!(e.and_then(|e| e.gci_percent)));
    put("convergence_ratio", json!(e.and_then(|e| e.convergence_ratio)));
    put("convergence", json!(e.map(|e| e.class)));
    put("sizes_convergence", json!(sizes.map(|e| e.class)));
    put("sizes_convergence_ratio", json!(sizes.and_then(|e| e.convergence_ratio)));
    put("reference_peak", json!(reference.map(|r| r.value)));
    put("reference_uncertainty", json!(reference.map(|r| r.uncertainty)));
    put("recommended_case", json!(r.map(|r| &r.case)));
    put("recommended", json!(r));
    put("cost", json!("cpu_s"));
    put("settings", json!(analysis.settings));
    put("incomplete", json!(analysis.incomplete));
    out.extend(by_name(&analysis.quantities, quantity));
    out
}

fn quantity(q: &ByQuantity<MeshErrors>) -> Value {
    let sizes = q.sizes();
    let curves: Map<String, Value> = q.curves.iter().map(|(f, c)| (f.clone(), json!(c))).collect();
    let families: Map<String, Value> = q.estimates.iter().map(|e| (e.family.clone(), json!(e))).collect();
    let mut out = json!({
        "label": q.quantity.label,
        "symbol": q.quantity.symbol,
        "unit": q.quantity.unit,
        "deciding": q.deciding,
        "supported": q.supported,
        "observed_order": sizes.and_then(|e| e.observed_order),
        "richardson_peak": sizes.and_then(|e| e.richardson),
        "gci_percent": sizes.and_then(|e| e.gci_percent),
        "convergence_ratio": sizes.and_then(|e| e.convergence_ratio),
        "reference": q.reference,
        "noise": q.noise,
        "step": q.step,
        "unresolved": q.unresolved,
        "one_run": q.one_run,
        "inputs": q.inputs,
        "families": families,
        "curves": curves,
        "errors": q.errors,
        "reasons": q.reasons,
        "sentence": q.sentence,
    });
    if !q.undetermined.is_empty() {
        out["undetermined"] = json!(q.undetermined);
    }
    if !q.without_share.is_empty() {
        out["without_share"] = json!(q.without_share);
    }
    out
}
