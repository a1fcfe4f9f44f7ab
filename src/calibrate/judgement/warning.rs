//! Warnings about the answer of a fit.

use super::compressibility::{Change, UNNOTICED};
use super::estimate::Direction;
use crate::calibrate::constant_format::{number_text, probability_text, stress_text};
use crate::calibrate::sample::Test;
use crate::calibrate::{Mode, Partner, Treatment};
use crate::wording;
use serde::Serialize;
use std::fmt;

/// A warning about the answer of a fit.
#[derive(Clone, PartialEq, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum FitWarning {
    /// Residuals have a pattern. p-values \[–\] of the two tests, of which one is below 2.5 %. `wider`: the smooth residual widens the intervals for
    /// use
    Systematic { runs: Option<usize>, runs_p: Option<f64>, departure_p: Option<f64>, rms_relative: f64, wider: bool },
    /// Rms misfit in the fitted range above the tolerance; of one `test` if there are several
    Misfit { test: Option<Test>, rms_relative: f64, tolerance: f64 },
    /// Another mode is predicted with an error above the tolerance
    CrossMode { mode: Mode, bias_relative: f64, rms_relative: f64 },
    /// Stiffness outside 1 kPa to 10 MPa; `instead`: the stress unit with which it would be that of a rubber
    Stiffness { mu_pa: f64, unit: String, instead: Option<&'static str> },
    /// An entry of the audit log
    Data { message: String },
    /// The compressible law of the file is softer (or stiffer) than the fitted curve; `enough`: a ν for which it is not
    Compressible { given: Partner, change: Change, enough: Option<f64> },
    /// The law file lacks a constant; `volumetric`: and also the form of the volumetric part
    NoPartner { volumetric: bool },
    /// Directions about which the data say nothing, or hardly anything
    Unidentifiable { directions: Vec<Direction> },
    /// As many constants as data points, and the direction that the data determine least
    NoFreedom { constants: usize, rows: usize, least: String },
    /// Shape constants at an end of the searched interval
    Limit { found: Vec<(&'static str, f64)> },
    /// Data points that were not fitted and at which the law is not defined; the one nearest to rest
    Undefined { rows: usize, nearest: f64 },
    /// Modes and amounts at which stability ends, within the largest principal stretch of the fitted data
    Unstable { lost: Vec<(Mode, f64)>, reach: f64, linear: bool },
    /// Least squares alone would give a law that is unstable at these stretches of a mode
    Held { mode: Mode, range: [f64; 2] },
    /// A law with several constants, fitted to tests of only one mode
    OneMode { mode: Mode },
    /// Rows of a file that are far from their neighbours
    Outliers { file: String, lines: Vec<u64> },
    /// Rows of a file that are far from their neighbours, with a loss that limits their weight
    LimitedOutliers { file: String, lines: Vec<u64> },
    /// A specimen whose stresses, relative to those of the fit to all specimens, are an outlier
    Specimen { file: String, level: f64 },
    /// Tests of only one specimen, and tests of several
    NoRepeat { single: Vec<Test>, repeated: Vec<Test> },
    /// The errors are larger at large stresses, although every pascal has the same weight
    Unequal,
    /// The errors of the curves have different sizes, although every pascal has the same weight; ratio of the largest to the smallest standard
    /// deviation
    UnequalCurves { ratio: f64 },
    /// A strain offset that was not fitted and would change the constants: slack, or misfit of the law
    Slack { mode: Mode, strain: f64, answer: String },
    /// Intervals of these constants include zero: a law without them describes the data equally well
    MayBeZero { symbols: Vec<&'static str> },
    /// A choice of data that was not requested, and its answer
    Cycles { treatment: Treatment, change: f64, answer: String },
    /// Other constants that describe the data within their errors: those with the smallest misfit
    OtherMinimum { answer: String, minima: usize, decides: Option<(Mode, f64)> },
    /// Constants that may have either sign; the mode in which the stresses of both answers differ most, and their relative difference \[–\]
    OpenSigns { symbols: Vec<&'static str>, decides: Option<(Mode, f64)> },
    /// The reported minimum was found from a single start
    Starts { starts: usize },
}

impl fmt::Display for FitWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Systematic { runs, runs_p, departure_p, rms_relative, wider } => {
                write_systematic(f, (*runs, *runs_p), *departure_p, *rms_relative)?;
                if *wider { write!(f, "; for its use over all of it take the wider interval") } else { Ok(()) }
            }
            Self::Misfit { test, rms_relative, tolerance } => write!(
                f,
                "misfit {:.1} % rms{} in the fitted range is above {:.1} %: narrow --range to the stretches of the use, \
                 or take a richer law",
                100.0 * rms_relative,
                test.map(|test| format!(" of {test}")).unwrap_or_default(),
                100.0 * tolerance
            ),
            Self::CrossMode { mode, bias_relative, rms_relative } => {
                let side = if *bias_relative < 0.0 { "low" } else { "high" };
                write!(
                    f,
                    "{mode} data points in the same range are predicted {:.1} % too {side} (rms {:.1} %)",
                    100.0 * bias_relative.abs(),
                    100.0 * rms_relative
                )
            }
            Self::Stiffness { mu_pa, unit, instead } => write_stiffness(f, *mu_pa, unit, *instead),
            Self::Data { message } => f.write_str(message),
            Self::Compressible { given, change, enough } => write_compressible(f, *given, change, *enough),
            Self::NoPartner { volumetric } => {
                f.write_str(
                    "tests of an incompressible material do not give nu or kappa: the law file has neither, pass --nu or \
                     add one in the scene",
                )?;
                f.write_str(if *volumetric { "; the scene also names `volumetric`" } else { "" })
            }
            Self::Unidentifiable { directions } => write_unidentifiable(f, directions),
            Self::Unstable { lost, reach, linear } => write_unstable(f, lost, *reach, *linear),
            Self::NoFreedom { .. } | Self::Limit { .. } | Self::Undefined { .. } => self.write_limits(f),
            Self::Held { mode, range: [low, high] } => write!(
                f,
                "least squares alone give a law that is unstable in {mode} (stretch {low:.4} to {high:.4}); the condition of material \
                 stability limits the answer, and the intervals do not account for it"
            ),
            Self::OneMode { mode } => write!(
                f,
                "only {mode} tests: nothing checks this law of several constants in other modes; bending involves tension \
                 and compression, a membrane is under equibiaxial tension"
            ),
            Self::Outliers { .. } | Self::LimitedOutliers { .. } => self.write_outliers(f),
            Self::Specimen { .. } | Self::NoRepeat { .. } | Self::Unequal | Self::UnequalCurves { .. } => {
                self.write_scatter(f)
            }
            Self::Slack { mode, strain, answer } => write_slack(f, *mode, *strain, answer),
            Self::MayBeZero { symbols } => write!(
                f,
                "the intervals of {} contain zero: these data do not show whether the law needs them; take a law with fewer constants, widen the \
                 range or add modes",
                symbols.join(", ")
            ),
            Self::Cycles { treatment, change, answer } => write!(
                f,
                "the table loads and unloads, and the first loading was fitted: {} the answer would be {answer}, stresses {:.1} % rms away; \
                 choose with --cycle first-loading, last-loading, a number, or all",
                treatment.words(),
                100.0 * change
            ),
            Self::OtherMinimum { .. } | Self::OpenSigns { .. } => self.write_others(f),
            Self::Starts { starts } => write!(
                f,
                "only one of {starts} starts of the search ended in the reported minimum; a better one may exist"
            ),
        }
    }
}

/// Writes the change of the stress due to the given ν or κ.
fn write_compressible(f: &mut fmt::Formatter<'_>, given: Partner, change: &Change, enough: Option<f64>) -> fmt::Result {
    match given {
        Partner::Nu(nu) => write!(f, "with nu = {}", number_text(nu)),
        Partner::Kappa(kappa) => write!(f, "with kappa = {}", stress_text(kappa)),
    }?;
    let side = if change.relative < 0.0 { "softer" } else { "stiffer" };
    write!(
        f,
        " the law is up to {:.1} % {side} than the fitted curve ({}, stretch {:.2}), since the data were taken as incompressible",
        100.0 * change.relative.abs(),
        change.mode,
        change.stretch
    )?;
    let within = 100.0 * UNNOTICED;
    match enough {
        Some(nu) => write!(f, "; nu = {nu} keeps its stresses within {within} % of the fit over these data"),
        None => {
            write!(f, "; even nu = 0.49999 does not keep its stresses within {within} % of the fit over these data")
        }
    }
}

impl FitWarning {
    /// Whether it is only a note, which limits nothing.
    pub fn is_note(&self) -> bool {
        matches!(self, Self::LimitedOutliers { .. })
    }

    /// Whether it casts doubt on the constants, or on the law over the stretches of the data.
    pub fn is_grave(&self) -> bool {
        match self {
            Self::Systematic { .. }
            | Self::Misfit { .. }
            | Self::Stiffness { .. }
            | Self::Data { .. }
            | Self::Unidentifiable { .. }
            | Self::NoFreedom { .. }
            | Self::Limit { .. }
            | Self::Undefined { .. }
            | Self::Unstable { .. }
            | Self::Held { .. }
            | Self::Outliers { .. }
            | Self::Specimen { .. }
            | Self::Cycles { .. }
            | Self::OpenSigns { .. } => true,
            Self::CrossMode { .. }
            | Self::Compressible { .. }
            | Self::NoPartner { .. }
            | Self::OneMode { .. }
            | Self::LimitedOutliers { .. }
            | Self::NoRepeat { .. }
            | Self::Unequal
            | Self::UnequalCurves { .. }
            | Self::Slack { .. }
            | Self::MayBeZero { .. }
            | Self::OtherMinimum { .. }
            | Self::Starts { .. } => false,
        }
    }

    /// Writes warnings about data points far from their neighbours.
    fn write_outliers(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let write = |f: &mut fmt::Formatter<'_>, what: &str, file: &str, lines: &[u64]| {
            let (n, lines) = (lines.len(), wording::lines(lines));
            write!(f, "data points far from their neighbours {what} ({n} of {file}: {lines})")
        };
        match self {
            Self::Outliers { file, lines } => {
                write(f, "influence the fit", file, lines)?;
                f.write_str("; pass --loss huber, or leave them out")
            }
            Self::LimitedOutliers { file, lines } => {
                write(f, "have a limited weight by --loss huber", file, lines)?;
                f.write_str("; the misfit is that of the others")
            }
            _ => Ok(()),
        }
    }

    /// Writes warnings about other constants that describe the data.
    fn write_others(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let test = |decides: &Option<(Mode, f64)>| {
            let words = |(mode, part): &(Mode, f64)| {
                format!(
                    ": a test in {mode} mode tells them apart, where their stresses differ by up to {:.0} %",
                    100.0 * part
                )
            };
            decides.as_ref().map(words).unwrap_or_default()
        };
        match self {
            Self::OtherMinimum { answer, minima, decides } => {
                let more = if *minima > 1 { format!(" (and {} more)", minima - 1) } else { String::new() };
                write!(
                    f,
                    "other constants describe these data as well, within their errors: {answer}{more}; the intervals hold them too. Add modes{}; or widen the range, \
                     or take fewer terms",
                    test(decides)
                )
            }
            Self::OpenSigns { symbols, decides } => write!(
                f,
                "the sign of {} is not determined: in the fitted modes every term has the same stresses with the other sign. Add modes{}",
                symbols.join(", "),
                test(decides)
            ),
            _ => Ok(()),
        }
    }

    /// Writes warnings about the scatter of data points and specimens.
    fn write_scatter(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Specimen { file, level } => write!(
                f,
                "specimen {file} is an outlier: its stresses are {level:.2} times those of the fit to all at the stretches that all have, more than the scatter of the others \
                 explains (Grubbs' test, 5 %); look for the cause before leaving it out"
            ),
            Self::NoRepeat { single, repeated } => write_no_repeat(f, single, repeated),
            Self::Unequal => f.write_str(
                "the errors of the data points grow with the stress, and the intervals account for it; --weight relative counts every per cent equally, which \
                 determines the constants better",
            ),
            Self::UnequalCurves { ratio } => write!(
                f,
                "the errors of one mode are {ratio:.1} times as large as those of another, and the intervals account for it; --weight noise divides each mode \
                 by its noise, which determines the constants better"
            ),
            _ => Ok(()),
        }
    }

    /// Writes warnings about the limits of what can be searched, fitted or predicted.
    fn write_limits(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFreedom { constants, rows, least } => write!(
                f,
                "{constants} constants and {rows} data points: the law can pass through every one of them, and no interval is finite; the data determine \
                 least of all {least}. Take a law with fewer constants, or more data points"
            ),
            Self::Limit { found } => {
                let all: Vec<_> =
                    found.iter().map(|(symbol, value)| format!("{symbol} = {}", number_text(*value))).collect();
                write!(
                    f,
                    "{} is at an end of the interval that is searched: the data would take it further, and the interval does not account for the limit; \
                     take another law or fewer terms",
                    all.join(", ")
                )
            }
            Self::Undefined { rows, nearest } => write!(
                f,
                "the law is not defined at {rows} data points outside the fitted range, the first at stretch {nearest:.4}: its chains are fully stretched \
                 there; fit them too, or stay below"
            ),
            _ => Ok(()),
        }
    }
}

fn write_no_repeat(f: &mut fmt::Formatter<'_>, single: &[Test], repeated: &[Test]) -> fmt::Result {
    let words = |tests: &[Test]| tests.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    match repeated {
        [] => f.write_str(
            "each test was made on one specimen: the intervals hold the errors of the curves, not the scatter between specimens; take several for a test",
        ),
        repeated => write!(
            f,
            "{} was tested on one specimen: its level is taken to scatter as that of the specimens in {}; take several for each test",
            words(single),
            words(repeated)
        ),
    }
}

fn write_slack(f: &mut fmt::Formatter<'_>, mode: Mode, strain: f64, answer: &str) -> fmt::Result {
    write!(
        f,
        "a strain offset of {strain:+.4} describes the {mode} data points better, and the answer would be {answer}: slack or preload of the \
                 specimen, or misfit of the law (no data points without stress decide it); pass --slack yes if it was not straight and free at zero, \
                 --slack no if it was"
    )
}

fn write_systematic(
    f: &mut fmt::Formatter<'_>,
    (runs, runs_p): (Option<usize>, Option<f64>),
    departure_p: Option<f64>,
    rms_relative: f64,
) -> fmt::Result {
    write!(f, "the law does not describe this range: its residuals have a pattern (")?;
    if let (Some(runs), Some(p)) = (runs, runs_p) {
        write!(f, "{runs} runs of sign, {}; ", probability_text(p))?;
    }
    if let Some(p) = departure_p {
        write!(f, "stiffness changes with stretch, {}; ", probability_text(p))?;
    }
    write!(f, "rms {:.2} %): the constants depend on the range", 100.0 * rms_relative)
}

fn write_stiffness(f: &mut fmt::Formatter<'_>, mu_pa: f64, unit: &str, instead: Option<&str>) -> fmt::Result {
    write!(f, "μ = {} is outside 1 kPa to 10 MPa, the range of rubbers", stress_text(mu_pa))?;
    match instead {
        Some(other) => write!(f, "; are the stresses in {other} rather than {unit}? Pass --stress-unit"),
        None => write!(f, "; check the stress column and its unit ({unit})"),
    }
}

fn write_unidentifiable(f: &mut fmt::Formatter<'_>, directions: &[Direction]) -> fmt::Result {
    for (k, d) in directions.iter().enumerate() {
        f.write_str(if k > 0 { "; " } else { "" })?;
        match d.half_width {
            None => write!(f, "unidentifiable: the data are insensitive to ")?,
            Some(s) if s > 10.0 => write!(f, "hardly identifiable (95 % interval beyond ±1000 %): ")?,
            Some(s) => write!(f, "hardly identifiable (95 % interval ±{:.0} %): ", 100.0 * s)?,
        }
        f.write_str(&d.changes)?;
        if let Some(known) = &d.known {
            write!(f, "; they determine {known}")?;
        }
    }
    f.write_str(". Widen the range, add modes, or take a law with fewer constants")
}

fn write_unstable(f: &mut fmt::Formatter<'_>, lost: &[(Mode, f64)], reach: f64, linear: bool) -> fmt::Result {
    let words: Vec<_> = lost.iter().map(|(mode, at)| format!("{} beyond {at:.4}", mode.words())).collect();
    write!(
        f,
        "the law loses material stability in {}, although principal stretches up to {reach:.4} were fitted: do not use it there, fit \
         these modes up to there, too",
        words.join(", ")
    )?;
    if linear { write!(f, ", or pass --stable {:.3}..{reach:.3}", 1.0 / reach) } else { Ok(()) }
}
