//! The answer of a fit.

use super::constant_format::{Printed, list, printed, stress_unit, stretch_text};
use super::judgement::compressibility::Written;
use super::judgement::errors::Errors;
use super::solve::noise::ModeNoise;
use super::{
    Audit, AuditKind, Contribution, Direction, ErrorModel, Estimate, FitCurves, FitError, FitWarning, FittableLaw,
    Loss, Misfit, Mode, Partner, Poisson, Residual, Scatter, SharedError, Slack, SolverCheck, StableRange,
    StretchRange, Test, Treatment, Weighting,
};
use crate::material::Choice;
use crate::storage;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::Path;

/// Describes the assumptions of the intervals.
pub fn interval_assumption(errors: &Errors, weighting: Weighting, loss: Loss, measurement: &[Contribution]) -> String {
    let Errors { model, free, .. } = errors;
    let degrees = if *free == 1 { "1 degree".into() } else { format!("{free} degrees") };
    let size = match weighting {
        _ if model.grows() || matches!(model, ErrorModel::Unequal { .. }) => "whose size changes with the stress",
        _ if errors.sizes.is_some() => "of another size in each curve",
        Weighting::Absolute => "of one size",
        Weighting::Relative => "in proportion to the stress",
        Weighting::Noise => "of one size in each mode",
    };
    let outliers = if loss == Loss::Huber { "; asymptotic, of Huber's loss" } else { "" };
    let listed = |words: &str, of_correction: bool| {
        let own = measurement.iter().map(|c| c.error).filter(|error| error.is_of_a_correction() == of_correction);
        let names: Vec<&str> = own.map(SharedError::name).collect();
        if names.is_empty() { String::new() } else { format!("; with the {words}{}", names.join(", the ")) }
    };
    let stated = listed("stated errors of the ", false) + &listed("", true);
    format!(
        "95 %, Student's t with {degrees} of freedom: {model}; normal stress errors {size}{stated}; it does not cover misfit of the law, the interval for use does{outliers}"
    )
}

/// Kinds of data points that were not fitted.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PredictionKind {
    /// A fitted mode outside the fitted range
    OutsideRange,
    /// Another mode, in the same range of λ
    OtherModeInRange,
    /// Another mode, all data points
    OtherMode,
}

/// Error of the law on data points that were not fitted.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct Prediction {
    pub kind: PredictionKind,
    pub mode: Mode,
    /// Smallest and largest λ of these data points \[–\]
    pub stretch: [f64; 2],
    pub misfit: Misfit,
}

/// A fit over a range that ends earlier or later.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RangeRow {
    /// λ of its end farthest from 1 \[–\]
    pub to: f64,
    pub rows: usize,
    pub parameters: Vec<Estimate>,
    /// Whether each parameter differs from that of the fitted range by more than the errors of both explain; false for a range that is not part of
    /// the fitted range
    pub departs: Vec<bool>,
    pub rms_pa: f64,
    pub rms_relative: f64,
}

/// A fit to data under another treatment.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Otherwise {
    pub treatment: Treatment,
    /// Whether the treatment that the fit uses was not requested
    pub unasked: bool,
    pub rows: usize,
    pub parameters: Vec<Estimate>,
    /// √(Σ(P′ − P)²/ΣP²) of the two laws over the fitted data points \[–\]
    pub change: f64,
}

/// Range in which the law describes the data of each test: from rest on, √(Σr²/ΣP²) stays within the tolerance, or the misfit within 2 % of the rms
/// stress of the fit.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
pub struct Validity {
    pub tolerance: f64,
    /// Ranges of the fitted modes; results of earlier versions do not have them
    #[serde(default)]
    pub tests: Vec<ValidRange>,
}

/// The range of one test.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
pub struct ValidRange {
    pub test: Test,
    /// Beginning of the range; nearer to rest the misfit is larger, but below 2 % of the rms stress of the fit. `None`: the range begins at rest
    pub from: Option<f64>,
    /// End of the range; `None`: the law is valid nowhere
    pub to: Option<f64>,
}

/// The complete result of one fit. Stresses and stiffnesses in Pa, stretches \[–\].
#[derive(Clone, Debug, Serialize)]
pub struct FitResult {
    pub law: &'static str,
    /// Name with the number of terms
    pub label: String,
    pub terms: usize,
    pub formula: &'static str,
    pub law_source: &'static str,
    /// File name of the table
    pub data: String,
    pub data_sha256: String,
    /// Authors, journal and year from the card
    pub data_source: Option<String>,
    pub version: &'static str,
    pub modes: Vec<Mode>,
    /// Range as requested; `None`: all data points
    pub asked_range: Option<StretchRange>,
    /// Smallest and largest fitted λ
    pub stretch: [f64; 2],
    /// Number of data points that are used; those at λ = 1 with zero stress carry no information and are not counted
    pub rows: usize,
    pub weighting: Weighting,
    /// Noise of each mode, if the weights need it
    pub noise: Vec<ModeNoise>,
    pub loss: Loss,
    pub parameters: Vec<Estimate>,
    /// Covariance of the constants due to the scatter of the data, without the stated errors of the measurement \[SI²\]
    pub covariance: Vec<Vec<f64>>,
    /// Correlation of the constants due to all contributions to their intervals \[–\]; empty if one of them has no finite variance, no degree of
    /// freedom is left, or intervals are far from those of a linear fit
    pub correlation: Vec<Vec<f64>>,
    pub interval_assumption: String,
    /// 95 % interval of each constant for use of the law over the fitted range: it includes the misfit
    pub in_use: Vec<[f64; 2]>,
    /// Error model, chosen by the data
    pub errors: ErrorModel,
    /// Degrees of freedom of Student's t
    pub degrees: usize,
    /// Errors of the measurement that data points share, stated or due to a correction, and their contributions to the intervals
    pub measurement: Vec<Contribution>,
    /// Fitted strain offsets
    pub slack: Vec<Slack>,
    /// Scatter between specimens, if there are several
    pub scatter: Option<Scatter>,
    /// The answer under other treatments of the data
    pub otherwise: Vec<Otherwise>,
    /// Directions that the data do not determine, or hardly determine
    pub unidentified: Vec<Direction>,
    /// Reasons why some constants are not determined; empty if all are
    pub undetermined: Vec<String>,
    /// Symbols of constants that may have either sign: the fitted modes have the same stresses with both
    pub open_signs: Vec<&'static str>,
    /// Range of material stability, by mode
    pub stability: Vec<StableRange>,
    pub partner: Option<Partner>,
    /// Poisson's ratio of a law that is fitted as compressible
    pub poisson: Option<Poisson>,
    /// Volumetric part of the law file, as given
    pub volumetric: Option<String>,
    pub misfit: Misfit,
    pub validity: Validity,
    pub predictions: Vec<Prediction>,
    pub range_dependence: Vec<RangeRow>,
    /// Smallest and largest value of each parameter over the fitted range and the ranges that end within it, where their errors do not explain the
    /// difference: the effect of the choice of the range on the answer
    pub range_spread: Vec<[f64; 2]>,
    pub solver_check: Option<SolverCheck>,
    pub warnings: Vec<FitWarning>,
    pub residuals: Vec<Residual>,
    pub curves: FitCurves,
    pub audit: Audit,
}

impl FitResult {
    /// Writes `fit.json`: all fields of this value, and in addition `messages` (the warnings as text), `notes` (those of them that limit nothing) and
    /// `doubtful` (whether a warning is grave).
    pub fn write_json(&self, path: &Path) -> Result<(), FitError> {
        let mut value = serde_json::to_value(self).expect("the result has string keys and serialisable values");
        value["messages"] = self.warnings.iter().map(ToString::to_string).collect();
        value["notes"] = self.warnings.iter().filter(|w| w.is_note()).map(ToString::to_string).collect();
        value["doubtful"] = self.warnings.iter().any(FitWarning::is_grave).into();
        let text = serde_json::to_string_pretty(&value).expect("a JSON value can be written");
        storage::write(path, (text + "\n").as_bytes()).map_err(|source| FitError::Write { path: path.into(), source })
    }

    /// The law of this fit in the form that scenes use.
    pub fn written(&self, model: FittableLaw) -> Written<'_> {
        let values = self.parameters.iter().map(|e| e.value).collect();
        Written { model, values, fitted: &self.residuals, volumetric: self.volumetric.as_deref() }
    }

    /// Lines that a scene adds to the law file that it includes, each with its alternatives: the data determine none of these constants.
    pub fn scene_lines(&self) -> Vec<String> {
        let Ok(model) = FittableLaw::new(self.law, Some(self.terms)) else { return vec![] };
        let partner = (!model.form.compressible && self.partner.is_none()).then(|| {
            let nu = self.written(model).enough().map_or("…".to_string(), |nu| nu.to_string());
            format!("nu = {nu} (or kappa)")
        });
        let volumetric = model.volumetric().filter(|_| self.volumetric.is_none());
        let words = |c: &Choice| format!("{} = \"{}\" (or {})", c.name, c.options[0], c.options[1..].join(", "));
        partner.into_iter().chain(volumetric.map(words)).collect()
    }

    /// Whether the data determine every constant
    pub fn is_determined(&self) -> bool {
        self.undetermined.is_empty()
    }

    /// The constants with their intervals, `μ = … Pa [… , …]` for each parameter.
    pub fn answer(&self) -> String {
        let one = |((e, p), wide): ((&Estimate, Printed), &[f64; 2])| {
            let head = format!("{} = {}", e.symbol, p.text(e.value));
            match (e.std_error.is_finite(), e.is_bounded()) {
                (true, true) if self.open_signs.contains(&e.symbol) => {
                    format!("{head} (its sign is not determined by the data: 95 % interval {})", p.span(e.interval))
                }
                (true, true) if *wide == e.interval => format!("{head} (95 % interval {})", p.span(e.interval)),
                (true, true) => {
                    format!("{head} (95 % interval {}; if used over this range {})", p.span(e.interval), p.span(*wide))
                }
                (true, false) => format!("{head} (not determined by the data: 95 % interval {})", p.span(e.interval)),
                (false, _) => format!("{head} (not determined by the data)"),
            }
        };
        self.parameters.iter().zip(printed(&self.parameters)).zip(&self.in_use).map(one).collect::<Vec<_>>().join("\n")
    }
}

impl fmt::Display for FitResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let modes: Vec<_> = self.modes.iter().map(|m| m.name()).collect();
        let percent = |stretch: f64| stretch_text(100.0 * (stretch - 1.0));
        writeln!(
            f,
            "{} on {} ({}), stretch {} to {} (strain {} to {} %), {} data points",
            self.label,
            self.data,
            modes.join(" + "),
            stretch_text(self.stretch[0]),
            stretch_text(self.stretch[1]),
            percent(self.stretch[0]),
            percent(self.stretch[1]),
            self.rows
        )?;
        writeln!(f, "{}", self.answer())?;
        let (factor, unit) = stress_unit(self.misfit.rms_pa);
        writeln!(f, "misfit {:.2} % rms, {:.3} {unit}", 100.0 * self.misfit.rms_relative, factor * self.misfit.rms_pa)?;
        self.write_noise(f)?;
        self.write_intervals(f)?;
        self.write_validity(f)?;
        for warning in &self.warnings {
            writeln!(f, "{}: {warning}", if warning.is_note() { "note" } else { "warning" })?;
        }
        Ok(())
    }
}

impl FitResult {
    /// Writes the noise levels, and the answer under other treatments.
    fn write_noise(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for n in &self.noise {
            let (factor, unit) = stress_unit(n.std_pa);
            let how = if n.given { "as given" } else { "from point to point" };
            writeln!(f, "noise of {}: {:.3} {unit}, {how}", n.mode, factor * n.std_pa)?;
        }
        for o in &self.otherwise {
            let all = list(&self.parameters, o.parameters.iter().map(|e| e.value));
            let (words, percent) = (o.treatment.words(), 100.0 * o.change);
            writeln!(f, "{words} ({} data points): {all}; the stresses differ by {percent:.1} % rms", o.rows)?;
        }
        for entry in self.audit.of(AuditKind::Ruptured) {
            writeln!(f, "note: {entry}")?;
        }
        Ok(())
    }

    /// Writes the basis of the intervals, slack, specimens and shorter ranges.
    fn write_intervals(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "intervals: {}", self.interval_assumption)?;
        let printed = printed(&self.parameters);
        match &self.poisson {
            Some(p) if p.measured => writeln!(f, "Poisson's ratio by the lateral strain: {}", p.ratio.words("–"))?,
            Some(p) if p.ratio.half_width() > 0.0 => {
                writeln!(f, "Poisson's ratio: {} as given", p.ratio.words("–"))?;
            }
            Some(p) => writeln!(f, "Poisson's ratio: {} as given, taken as exact", p.ratio.value)?,
            None => {}
        }
        for c in &self.measurement {
            let one = |((e, p), by): ((&Estimate, &Printed), &f64)| format!("{} ± {}", e.symbol, p.width(*by));
            let all: Vec<String> = self.parameters.iter().zip(&printed).zip(&c.moves).map(one).collect();
            writeln!(f, "of which the {}: {}", c.error, all.join(", "))?;
        }
        for s in &self.slack {
            let why = match (s.asked, s.rows) {
                (true, _) => "as asked".into(),
                // The data point at rest does not show slack
                (false, 0 | 1) => "with that of the other specimens".into(),
                (false, rows) => format!("{rows} data points carry no stress"),
            };
            let of = format!("{} ({})", s.file, s.mode);
            let [low, high] = s.interval.map(|end| if end.is_finite() { format!("{end:.5}") } else { "open".into() });
            writeln!(f, "slack of {of}: {:.5} of strain (95 % interval {low} to {high}), {why}", s.strain)?;
        }
        if let Some(s) = &self.scatter {
            for ((e, p), (mean, sd)) in self.parameters.iter().zip(&printed).zip(s.means.iter().zip(&s.deviations)) {
                let (n, mean, sd) = (s.specimens.len(), p.text(*mean), p.width(*sd));
                writeln!(f, "{n} specimens: mean {} = {mean}, standard deviation {sd}", e.symbol)?;
            }
            for mode in &self.modes {
                if let Some(b) = s.next.iter().rfind(|b| b.mode == *mode) {
                    let percent = 50.0 * (b.interval[1] - b.interval[0]) / b.mean.abs();
                    let at = stretch_text(b.stretch);
                    writeln!(f, "the next specimen: {mode} stress within ±{percent:.1} % at stretch {at} (95 %)")?;
                }
            }
        }
        let depends = |(_, ends): &(_, &[f64; 2])| ends[0] < ends[1];
        for ((e, p), ends) in self.parameters.iter().zip(&printed).zip(&self.range_spread).filter(depends) {
            writeln!(f, "ranges that end earlier give {} from {}", e.symbol, p.span(*ends))?;
        }
        Ok(())
    }

    /// Writes where the law describes the data, its predictions, and where it is stable.
    fn write_validity(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.validity.tolerance;
        for ValidRange { test, from, to } in &self.validity.tests {
            let of = if self.validity.tests.len() > 1 { format!(" of {test}") } else { String::new() };
            let Some(to) = to else {
                writeln!(f, "at no stretch within {percent:.0} % rms of the data{of}")?;
                continue;
            };
            let down = if *to < 1.0 { " down" } else { "" };
            let nearer = from.map_or("", |_| "; nearer to rest, within 2 % of the rms stress of the fit");
            let [from, to] = [from.unwrap_or(1.0), *to].map(stretch_text);
            writeln!(f, "within {percent:.0} % rms of the data{of} from stretch {from}{down} to {to}{nearer}")?;
        }
        for p in &self.predictions {
            let what = match p.kind {
                PredictionKind::OutsideRange => "outside the range",
                PredictionKind::OtherModeInRange => "not fitted, same range",
                PredictionKind::OtherMode => "not fitted, every data point",
            };
            writeln!(
                f,
                "{} {what} ({} data points, stretch {} to {}): {:.1} % rms",
                p.mode,
                p.misfit.rows,
                stretch_text(p.stretch[0]),
                stretch_text(p.stretch[1]),
                100.0 * p.misfit.rms_relative
            )?;
        }
        for r in self.stability.iter().filter(|r| r.below.is_some() || r.above.is_some()) {
            let from = r.below.map_or(format!("{:.3}", r.looked[0]), |b| format!("{b:.3} (lost)"));
            let to = r.above.map_or(format!("{:.3}", r.looked[1]), |a| format!("{a:.3} (lost)"));
            writeln!(f, "stable in {} from {from} to {to}", r.mode)?;
        }
        Ok(())
    }
}
