//! Every law on the same data, ranked by its prediction of data that were not fitted.
//!
//! Two predictions, each as √(Σr²/ΣP²) over the data points left out: *hold-out*, the last third of ln λ of every fitted mode from the rest of
//! them; *cross-mode*, each fitted mode from the other ones (with one fitted mode: the other modes of the table from it). The score is the worse
//! of the two; where it is equal the better one decides, then the number of constants. Laws with constants that the data do not determine come after the others, and after all of them those of which a prediction cannot be had. The misfit of the fit itself falls with every constant and
//! decides only between laws that are alike in all of this.
//!
//! Each law has the slack of its own fit: the strains of its data points are those without it, also of the data points left out. The stresses, over which the misfits are taken, are the same for all.

use super::constant_format::stretch_text;
use super::fit::{choose, headline, read, slack_estimates, without_slack};
use super::judgement::certificate::{Reach, certificate, lost};
use super::judgement::determined::undetermined;
use super::judgement::mirrored::either_sign;
use super::judgement::misfit::residuals;
use super::solve::{LawSetting, solve};
use super::{
    AuditKind, Experiment, FitError, FitOptions, FitRequest, FittableLaw, Misfit, Mode, Sample, Slack, fittable_laws,
};
use crate::storage;
use serde::Serialize;
use std::fmt;
use std::path::Path;

/// Part of ln λ from rest that is fitted where the rest is held out \[–\]
const KEPT: f64 = 2.0 / 3.0;

/// Relative misfit from which on the sizes are alike \[–\]
const LARGEST: f64 = 10.0;

/// One law. Misfits are relative \[–\]; `None`: there are too few data points for it, or no other mode.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Compared {
    pub law: &'static str,
    pub terms: usize,
    /// Name with the number of terms
    pub label: String,
    pub constants: usize,
    pub misfit: f64,
    pub hold_out: Option<f64>,
    pub cross_mode: Option<f64>,
    /// The worse of the two
    pub score: Option<f64>,
    /// Why some constants are not determined, in words; empty where all are
    pub undetermined: Vec<String>,
    /// Modes in which material stability ends within the principal stretches of the fitted data points, and where: λ, in simple shear γ \[–\]
    pub lost: Vec<(Mode, f64)>,
    /// Strain offsets that were fitted with the law
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub slack: Vec<Slack>,
}

/// Laws, in the order of their predictions.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Comparison {
    /// Of the program that fitted
    pub version: &'static str,
    pub data: String,
    pub modes: Vec<Mode>,
    pub stretch: [f64; 2],
    pub rows: usize,
    pub laws: Vec<Compared>,
    /// Reasons to doubt the data, in words
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
}

/// Reads a table and compares all laws with all their numbers of terms; the law and terms of the options do not count.
pub fn compare(request: &FitRequest) -> Result<Comparison, FitError> {
    compare_experiment(&read(request)?, &request.options)
}

/// Like [`compare`], of a table that was read already.
pub fn compare_experiment(experiment: &Experiment, options: &FitOptions) -> Result<Comparison, FitError> {
    let choice = choose(experiment, options)?;
    let mut laws = Vec::new();
    // Foams need Poisson's ratio, and predict other lateral stretches than those of the other laws
    for law in fittable_laws().into_iter().filter(|e| e.fit.is_some_and(|f| !f.compressible)) {
        for terms in law.fit.iter().flat_map(|f| f.term_counts) {
            let model = FittableLaw::new(law.info.name, Some(*terms)).expect("a number of the list");
            laws.push(one(experiment, options, model)?);
        }
    }
    laws.sort_by_key(Compared::rank);
    let (modes, stretch, rows) = (choice.modes, choice.stretch, choice.fitted.len());
    let version = env!("CARGO_PKG_VERSION");
    let doubts = doubts(experiment, &laws);
    Ok(Comparison { version, data: experiment.file.clone(), modes, stretch, rows, laws, doubts })
}

/// Those of the table, and slack where it is not fitted with every law.
fn doubts(experiment: &Experiment, laws: &[Compared]) -> Vec<String> {
    let slack = (!laws.iter().all(|c| !c.slack.is_empty())).then_some(AuditKind::Slack);
    let kinds = std::iter::once(AuditKind::Doubt).chain(slack);
    kinds.flat_map(|kind| experiment.audit.of(kind)).map(|entry| entry.message.clone()).collect()
}

fn one(experiment: &Experiment, options: &FitOptions, model: FittableLaw) -> Result<Compared, FitError> {
    let (experiment, slack) = without_slack(experiment, options, model)?;
    let choice = choose(&experiment, options)?;
    // The strains without slack are given to the predictions
    let given = choice.setting(options, model)?;
    let setting = LawSetting { slack: slack.offsets, ..given.clone() };
    let whole = solve(&setting, &choice.fitted, None)?;
    let reach = Reach::of(&choice.fitted, model.nu);
    let stability = certificate(model, &whole.values, whole.modulus, reach.largest());
    let misfit = misfit(&setting, &whole.values, &choice.fitted);
    let ends = Mode::ALL.map(|m| {
        let own = choice.fitted.iter().filter(|s| s.mode == m).map(|s| s.reach().ln());
        own.fold([0.0_f64, 0.0], |[a, b], e| [a.min(e), b.max(e)])
    });
    let held = |s: &Sample| {
        let [low, high] = ends[s.mode as usize];
        let amount = s.reach().ln();
        amount > KEPT * high || amount < KEPT * low
    };
    let hold_out = predict(&given, &choice.fitted, &choice.fitted, &held);
    let cross_mode = if choice.modes.len() > 1 {
        let one = |m: &Mode| predict(&given, &choice.fitted, &choice.fitted, &|s| s.mode == *m);
        choice.modes.iter().map(one).collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max))
    } else {
        let inside = |s: &&Sample| options.range.is_none_or(|r| r.contains(s.reach())) && s.is_informative();
        let all: Vec<Sample> = experiment.samples.iter().filter(inside).copied().collect();
        predict(&given, &choice.fitted, &all, &|s| !choice.modes.contains(&s.mode))
    };
    let (constants, _) = headline(&setting, &choice.fitted, &whole, &experiment, options)?;
    let score = [hold_out, cross_mode].into_iter().flatten().reduce(f64::max);
    Ok(Compared {
        law: model.name(),
        terms: model.terms,
        label: model.label(),
        constants: model.parameters().len(),
        misfit,
        hold_out,
        cross_mode,
        score,
        lost: lost(&stability, reach),
        undetermined: undetermined(&constants, &either_sign(&whole, model), &whole, model),
        slack: slack_estimates(&setting, &choice.fitted, &whole, &experiment, options),
    })
}

fn misfit(setting: &LawSetting, values: &[f64], samples: &[Sample]) -> f64 {
    Misfit::of(&residuals(samples, |s| setting.model.at(values, s))).map_or(f64::NAN, |m| m.rms_relative)
}

/// Misfit on the picked data points of `from` after a fit to those of `fitted` that are not picked.
fn predict(setting: &LawSetting, fitted: &[Sample], from: &[Sample], picked: &dyn Fn(&Sample) -> bool) -> Option<f64> {
    let rest: Vec<Sample> = fitted.iter().filter(|s| !picked(s)).copied().collect();
    let asked: Vec<Sample> = from.iter().filter(|s| picked(s)).copied().collect();
    if asked.is_empty() || rest.len() <= setting.model.parameters().len() {
        return None;
    }
    let values = solve(setting, &rest, None).ok()?.values;
    // A law that is not defined there has failed
    Some(misfit(setting, &values, &asked)).map(|m| if m.is_finite() { m } else { f64::INFINITY })
}

impl Compared {
    /// The place in the order: laws that are not stable where they were fitted after the stable ones, those without one of the predictions after those that have it, those with
    /// constants that are not determined after the determined ones. Misfits count as they are printed, so that a law with no larger number in any column is not behind another one.
    fn rank(&self) -> impl Ord + use<> {
        let shown = |misfit: Option<f64>| misfit.map_or(u32::MAX, |m| (1e3 * m.min(LARGEST)).round() as u32);
        let other = [self.hold_out, self.cross_mode].into_iter().flatten().reduce(f64::min);
        let missing = [self.hold_out, self.cross_mode].into_iter().filter(Option::is_none).count();
        let is_open = !self.undetermined.is_empty();
        (
            !self.lost.is_empty(),
            missing,
            is_open,
            shown(self.score),
            shown(other),
            self.constants,
            shown(Some(self.misfit)),
        )
    }

    /// `yes`, or the modes and amounts at which stability ends
    pub fn stable(&self) -> String {
        let one = |(mode, at): &(Mode, f64)| format!("{} to {at:.3}", mode.words());
        match &self.lost[..] {
            [] => "yes".into(),
            lost => lost.iter().map(one).collect::<Vec<_>>().join(", "),
        }
    }
}

impl Comparison {
    /// `compare.json`
    pub fn write_json(&self, path: &Path) -> Result<(), FitError> {
        let text = serde_json::to_string_pretty(self).expect("the result has string keys and serialisable values");
        storage::write(path, (text + "\n").as_bytes()).map_err(|source| FitError::Write { path: path.into(), source })
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let modes: Vec<_> = self.modes.iter().map(|m| m.name()).collect();
        let [low, high] = self.stretch.map(stretch_text);
        writeln!(f, "{} ({}), stretch {low} to {high}, {} data points", self.data, modes.join(" + "), self.rows)?;
        writeln!(
            f,
            "relative misfit [%] of the data that were fitted, and of data that were not; in the order of the"
        )?;
        writeln!(
            f,
            "worse prediction, then of the other one, then of the number of constants; laws whose constants are"
        )?;
        writeln!(f, "not all determined after those, then laws without one of the predictions, unstable laws last\n")?;
        writeln!(
            f,
            "{:30} {:>9} {:>8} {:>9} {:>11}  stable where fitted; slack; constants that are open",
            "law", "constants", "fitted", "hold-out", "cross-mode"
        )?;
        let percent = |v: Option<f64>| match v {
            None => "–".into(),
            Some(v) if v > LARGEST => "> 1000".into(),
            Some(v) => format!("{:.1}", 100.0 * v),
        };
        for c in &self.laws {
            let slack = c.slack.iter().map(|s| format!("; slack {:.4} ({})", s.strain, s.mode)).collect::<String>();
            let open = c.undetermined.iter().map(|why| format!("; {why}")).collect::<String>();
            let mark = format!("  {}{slack}{open}", c.stable());
            writeln!(
                f,
                "{:30} {:>9} {:>8} {:>9} {:>11}{mark}",
                c.label,
                c.constants,
                percent(Some(c.misfit)),
                percent(c.hold_out),
                percent(c.cross_mode)
            )?;
        }
        self.doubts.iter().try_for_each(|doubt| writeln!(f, "warning: {doubt}"))
    }
}
