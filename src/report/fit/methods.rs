//! How a law was fitted, in sentences for a paper: data, law with its constants, fit, limits.

use super::page::answer;
use super::stored::StoredFit;
use crate::calibrate::{Loss, Weighting, stretch_text};
use crate::report::numbers::capital;
use crate::report::paper::law::{LawGroup, describe};
use crate::report::paper::{Paragraph, software};

/// Returns the paragraphs of a fit; `law` is the content of its law file, if that could be read.
pub fn paragraphs(fit: &StoredFit, law: Option<&str>) -> Vec<Paragraph> {
    let table = law.and_then(|text| text.parse::<toml::Table>().ok());
    let constants = match &table {
        Some(table) => describe(Paragraph::new("Law"), &LawGroup { name: None, tables: vec![table] }),
        None => Paragraph::new("Law").text(format!("{}, ", fit.label)).formula(fit.formula.as_str()).text(". "),
    };
    let all = [
        Some(data(fit)),
        Some(constants.text(lateral(fit))),
        Some(search(fit)),
        Some(Paragraph::new("Result").text(answer(fit))),
        Some(stability(fit)),
        limits(fit),
        Some(software(std::slice::from_ref(&fit.version))),
    ];
    all.into_iter().flatten().collect()
}

/// States the lateral stretches of the test pieces in the fit.
fn lateral(fit: &StoredFit) -> String {
    match &fit.poisson {
        None => "The material was taken as incompressible (J = 1).".into(),
        Some(of) => {
            let source = if of.measured { "by the lateral strain" } else { "as given" };
            format!("The lateral stretches follow Poisson's ratio {:.3}, {source}.", of.ratio.value)
        }
    }
}

/// The warnings of the fit; `None` if it has only notes.
fn limits(fit: &StoredFit) -> Option<Paragraph> {
    let warnings: Vec<String> = fit.warnings().map(|message| format!("{}.", capital(message))).collect();
    (!warnings.is_empty()).then(|| Paragraph::new("Limits").text(warnings.join(" ")))
}

fn data(fit: &StoredFit) -> Paragraph {
    let [a, b] = fit.stretch.map(stretch_text);
    let source = fit.data_source.as_deref().map_or_else(|| fit.data.clone(), |s| s.trim_end_matches('.').to_string());
    let mut all = Paragraph::new("Data").text(format!(
        "{} data points ({}) with stretches from {a} to {b}, from {source}.",
        fit.rows,
        fit.modes.join(" and ")
    ));
    let treated = fit.audit.iter().filter(|e| e.kind.is_treatment());
    for entry in treated {
        let rows = if entry.lines.is_empty() { String::new() } else { format!(" ({} rows)", entry.lines.len()) };
        all = all.text(format!(" {}{rows}.", capital(&entry.message)));
    }
    all
}

fn search(fit: &StoredFit) -> Paragraph {
    let weighted = match fit.weighting {
        Weighting::Relative => "errors in proportion to the stress",
        Weighting::Noise => "errors of one size in each mode",
        Weighting::Absolute => "errors of one size",
    };
    let loss = match fit.loss {
        Loss::Squares => "",
        Loss::Huber => ", with Huber's loss",
    };
    Paragraph::new("Fit")
        .marked(&format!(
            "The constants have the least squares of the nominal stresses, {weighted}{loss}. Intervals [@bates1988]: "
        ))
        .text(format!("{}.", fit.interval_assumption))
}

fn stability(fit: &StoredFit) -> Paragraph {
    let lost = fit.stability.iter().filter(|r| r.below.is_some() || r.above.is_some());
    let words = lost.map(|r| {
        let ends = [("below", r.below), ("above", r.above)];
        let ends = ends.into_iter().filter_map(|(side, at)| Some(format!("{side} {:.3}", at?)));
        format!("{} {}", r.mode.words(), ends.collect::<Vec<_>>().join(" and "))
    });
    let words: Vec<String> = words.collect();
    let text = match words.is_empty() {
        true => "The law is stable (Drucker) at all stretches that were looked at.".to_string(),
        false => format!("The law is not stable (Drucker) in {}.", words.join(", ")),
    };
    Paragraph::new("Stability").text(text)
}
