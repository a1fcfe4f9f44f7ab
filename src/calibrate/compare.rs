//! Every law on the same data, ranked by its prediction of data that were not fitted.
//!
//! Each law makes two predictions, with misfits √(Σr²/ΣP²) over the data points left out. *Hold-out*: the last third of |ln λ| of every fitted test,
//! measured from its nearest fitted data point, from a fit to the rest. *Cross-mode*: each fitted mode from the others (with one fitted mode: the
//! other modes of the table from it). The score is the worse of the two; ties are decided by the better one, then by the number of constants. Laws
//! with constants that the data do not determine come after the others, and laws without one of the predictions come last. The misfit of the fit
//! itself falls with every constant and decides only between laws that are equal in all of this.
//!
//! Each law has the slack of its own fit, which is subtracted from the strains of its data points, including those left out. The stresses, over which
//! the misfits are taken, are the same for all. With Huber's loss the misfits leave out the data points that most laws name as outliers; otherwise a
//! single outlier could decide the order.

use super::constant_format::stretch_text;
use super::fit::{ChosenData, choose, headline, read, slack_estimates, without_slack};
use super::judgement::certificate::{Reach, certificate, lost};
use super::judgement::determined::undetermined;
use super::judgement::mirrored::either_sign;
use super::judgement::misfit::residuals;
use super::judgement::outliers::Outliers;
use super::sample::{Test, by_test, tests};
use super::solve::{LawFit, LawSetting, solve};
use super::{
    AuditKind, Experiment, FitError, FitOptions, FitRequest, FittableLaw, Misfit, Mode, Sample, Slack, fittable_laws,
};
use crate::math::statistics::extent;
use crate::storage;
use serde::Serialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

/// Part of the range of |ln λ|, from the nearest data point on, that is fitted when the rest is held out \[–\]
const KEPT: f64 = 2.0 / 3.0;

/// Relative misfit above which misfits are no longer distinguished \[–\]
const LARGEST: f64 = 10.0;

/// A law in the comparison. Misfits are relative \[–\]. `None`: there are too few data points for it, or no other mode. Infinite, which JSON cannot
/// hold: the law is not defined there.
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
    /// The worse of the two predictions
    pub score: Option<f64>,
    /// Predictions that are infinite, `hold_out` or `cross_mode`
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub failed: Vec<&'static str>,
    /// Reasons why some constants are not determined; empty if all are
    pub undetermined: Vec<String>,
    /// Modes in which material stability ends within the principal stretches of the fitted data points, and where: λ, in simple shear γ \[–\]
    pub lost: Vec<(Mode, f64)>,
    /// Strain offsets that were fitted with the law
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub slack: Vec<Slack>,
}

/// The compared laws, in the order of their predictions.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Comparison {
    /// Version of the program that fitted
    pub version: &'static str,
    pub data: String,
    pub modes: Vec<Mode>,
    pub stretch: [f64; 2],
    pub rows: usize,
    pub laws: Vec<Compared>,
    /// Reasons to doubt the data
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubts: Vec<String>,
}

/// Reads a table and compares all laws with all their numbers of terms; the law and the terms of the options are ignored.
pub fn compare(request: &FitRequest) -> Result<Comparison, FitError> {
    compare_experiment(&read(request)?, &request.options)
}

/// Compares all laws on a table that has already been read, as [`compare`] does.
pub fn compare_experiment(experiment: &Experiment, options: &FitOptions) -> Result<Comparison, FitError> {
    let choice = choose(experiment, options)?;
    let mut fits = Vec::new();
    // Foams need Poisson's ratio, and predict lateral stretches different from those of the other laws
    for law in fittable_laws().into_iter().filter(|e| e.fit.is_some_and(|f| !f.compressible)) {
        for terms in law.fit.iter().flat_map(|f| f.term_counts) {
            let model = FittableLaw::new(law.info.name, Some(*terms)).expect("a number of the list");
            fits.push(Fitted::of(experiment, options, model)?);
        }
    }
    let outliers = named_by_most(&fits);
    let mut laws: Vec<Compared> = fits.iter().map(|f| f.compared(options, &outliers)).collect::<Result<_, _>>()?;
    laws.sort_by_key(Compared::rank);
    let (modes, stretch, rows) = (choice.modes, choice.stretch, choice.fitted.len());
    let version = env!("CARGO_PKG_VERSION");
    let mut doubts = doubts(experiment, &laws);
    doubts.extend(outliers.warnings(&experiment.specimens, options.loss).map(|w| w.to_string()));
    Ok(Comparison { version, data: experiment.file.clone(), modes, stretch, rows, laws, doubts })
}

/// Doubts about the table, about slack unless it is fitted with every law, and a note if there is no hold-out.
fn doubts(experiment: &Experiment, laws: &[Compared]) -> Vec<String> {
    let slack = (!laws.iter().all(|c| !c.slack.is_empty())).then_some(AuditKind::Slack);
    let kinds = std::iter::once(AuditKind::Doubt).chain(slack);
    let none = laws.iter().all(|c| c.hold_out.is_none());
    let none = none.then(|| "no law has a hold-out: there are too few data points of different stretch".to_string());
    kinds.flat_map(|kind| experiment.audit.of(kind)).map(|entry| entry.message.clone()).chain(none).collect()
}

/// The outliers of more than half of the laws: an outlier of one law may be its misfit.
fn named_by_most(fits: &[Fitted]) -> Outliers {
    let mut counts: BTreeMap<(usize, u64), usize> = BTreeMap::new();
    for f in fits {
        let own = Outliers::of(&f.choice.fitted, |s| f.setting.model.at(&f.whole.values, s));
        own.0.into_iter().for_each(|of| *counts.entry(of).or_default() += 1);
    }
    Outliers(counts.into_iter().filter(|(_, count)| 2 * count > fits.len()).map(|(of, _)| of).collect())
}

/// A law with its fit to all fitted data points.
struct Fitted<'a> {
    experiment: Cow<'a, Experiment>,
    choice: ChosenData,
    /// Setting of the predictions, whose strains are given without slack
    given: LawSetting,
    setting: LawSetting,
    whole: LawFit,
}

impl<'a> Fitted<'a> {
    fn of(experiment: &'a Experiment, options: &FitOptions, model: FittableLaw) -> Result<Self, FitError> {
        let (experiment, slack) = without_slack(experiment, options, model)?;
        let choice = choose(&experiment, options)?;
        let given = choice.setting(options, model)?;
        let setting = LawSetting { slack: slack.offsets, ..given.clone() };
        let whole = solve(&setting, &choice.fitted, None)?;
        Ok(Self { experiment, choice, given, setting, whole })
    }

    fn compared(&self, options: &FitOptions, outliers: &Outliers) -> Result<Compared, FitError> {
        let Self { experiment, choice, given, setting, whole } = self;
        let (model, fitted) = (setting.model, &choice.fitted[..]);
        let reach = Reach::of(fitted, model.nu);
        let stability = certificate(model, &whole.values, whole.modulus, reach.largest());
        let counted = |samples: &[Sample]| outliers.counted(samples, options.loss);
        let (held, rest) = hold_out(fitted);
        let hold_out = predict(given, &rest, &counted(&held));
        let cross_mode = if choice.modes.len() > 1 {
            let one = |m: &Mode| {
                let (asked, rest): (Vec<_>, Vec<_>) = fitted.iter().copied().partition(|s| s.mode == *m);
                predict(given, &rest, &counted(&asked))
            };
            choice.modes.iter().map(one).collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max))
        } else {
            let inside = |s: &&Sample| options.range.is_none_or(|r| r.contains(s.reach())) && s.is_informative();
            let other = |s: &&Sample| inside(s) && !choice.modes.contains(&s.mode);
            predict(given, fitted, &experiment.samples.iter().filter(other).copied().collect::<Vec<_>>())
        };
        let (constants, _) = headline(setting, fitted, whole, experiment, options)?;
        let predictions = [("hold_out", hold_out), ("cross_mode", cross_mode)];
        let is_failed = |(_, misfit): &(&str, Option<f64>)| misfit.is_some_and(f64::is_infinite);
        Ok(Compared {
            law: model.name(),
            terms: model.terms,
            label: model.label(),
            constants: model.parameters().len(),
            misfit: misfit(setting, &whole.values, &counted(fitted)),
            hold_out,
            cross_mode,
            score: [hold_out, cross_mode].into_iter().flatten().reduce(f64::max),
            failed: predictions.into_iter().filter(is_failed).map(|(name, _)| name).collect(),
            lost: lost(&stability, reach),
            undetermined: undetermined(&constants, &either_sign(whole, model), whole, model),
            slack: slack_estimates(setting, fitted, whole, experiment, options),
        })
    }
}

/// The last third of the |ln λ| of each test, measured from its nearest data point, and the rest.
fn hold_out(fitted: &[Sample]) -> (Vec<Sample>, Vec<Sample>) {
    let amount = |s: &Sample| s.reach().ln().abs();
    let limit = |(test, own): (Test, Vec<Sample>)| {
        let [near, far] = extent(own.iter().map(amount));
        (test, near + KEPT * (far - near))
    };
    let limits: BTreeMap<Test, f64> = by_test(fitted).into_iter().map(limit).collect();
    let (held, rest): (Vec<_>, Vec<_>) =
        fitted.iter().copied().zip(tests(fitted)).partition(|(s, test)| amount(s) > limits[test]);
    let samples = |all: Vec<(Sample, Test)>| all.into_iter().map(|(s, _)| s).collect();
    (samples(held), samples(rest))
}

fn misfit(setting: &LawSetting, values: &[f64], samples: &[Sample]) -> f64 {
    Misfit::of(&residuals(samples, |s| setting.model.at(values, s))).map_or(f64::NAN, |m| m.rms_relative)
}

/// Misfit of a fit to `rest` on the data points `asked`.
fn predict(setting: &LawSetting, rest: &[Sample], asked: &[Sample]) -> Option<f64> {
    if asked.is_empty() || rest.len() <= setting.model.parameters().len() {
        return None;
    }
    let values = solve(setting, rest, None).ok()?.values;
    // A law that is not defined at these data points has failed
    Some(misfit(setting, &values, asked)).map(|m| if m.is_finite() { m } else { f64::INFINITY })
}

impl Compared {
    /// Sort key: laws that are stable over the fitted range come first, then laws with both predictions, then laws whose constants are all
    /// determined, then by misfit. Misfits count as printed, so that of two laws with equal printed numbers neither precedes the other because of
    /// hidden digits.
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

    /// `yes`, or the modes and the amounts at which stability ends
    pub fn stable(&self) -> String {
        let one = |(mode, at): &(Mode, f64)| format!("{} to {at:.3}", mode.words());
        match &self.lost[..] {
            [] => "yes".into(),
            lost => lost.iter().map(one).collect::<Vec<_>>().join(", "),
        }
    }
}

impl Comparison {
    /// Writes `compare.json`.
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
        writeln!(f, "not all determined after those, then laws without one of the predictions, unstable laws last.")?;
        writeln!(f, "–: cannot be had; failed: the law is not defined at these data\n")?;
        writeln!(
            f,
            "{:30} {:>9} {:>8} {:>9} {:>11}  stable where fitted; slack; constants that are open",
            "law", "constants", "fitted", "hold-out", "cross-mode"
        )?;
        let percent = |v: Option<f64>| match v {
            None => "–".into(),
            Some(v) if v.is_infinite() => "failed".into(),
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
