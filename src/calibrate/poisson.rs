//! Poisson's ratio of a law that is fitted as compressible: as given, or from the lateral strain of the tables.
//!
//! The law has one ν in all terms, so that ln λ_t = −ν ln λ in uniaxial stress for any other constants: the closed form of the lateral stretch at
//! zero lateral stress. ν is therefore the slope of that line, with the errors of direct fits ([`crate::calibrate::volume`]), and the stress is
//! fitted with this ν. Its interval enters as a stated error that all data points share ([`super::judgement::measurement`]).
//!
//! Limits: the tables are read as written, with all rows. If the fitted stretches differ from them (by slack, toe, compliance, or a strain of a kind
//! that differs from its name), or if some rows are not uniaxial, this line gives no ν, and ν has to be stated.

use super::intake::accuracy::SharedError;
use super::intake::card::Card;
use super::intake::columns::Lateral;
use super::volume::{VolumeError, VolumeFit, VolumeRequest, VolumeTest, fit_volume};
use super::{
    Bounded, ColumnError, Experiment, FitError, FitOptions, FitRequest, FitResult, FittableLaw, Mode, Partner, Poisson,
    Role, Sample,
};
use crate::wording::all;

/// Poisson's ratio for a request: the given one, otherwise that of the lateral strain. `None` for laws that are fitted as incompressible.
///
/// # Errors
///
/// Returns an error if there is neither a given ratio nor a lateral strain, or if the lateral strain does not belong to the data points of the
/// `experiment` or is that of a material that keeps its volume.
pub fn of_request(
    request: &FitRequest,
    model: FittableLaw,
    experiment: &Experiment,
) -> Result<Option<Poisson>, FitError> {
    if !model.form.compressible || request.options.partner.is_some() {
        return Ok(of_options(&request.options, model)?.1);
    }
    let card = Card::find(request.card.as_deref(), &request.data)?;
    let choice = Card::complete(card.as_ref(), &request.columns)?;
    // Columns as the fit reads them: with the card, of the chosen test, and with the sign that both columns imply
    let Lateral { strain, across, positive } = experiment.lateral.clone();
    let roles = |strain: Option<String>, lateral: Option<String>| {
        [(Role::Strain, strain), (Role::Lateral, lateral)]
            .into_iter()
            .filter_map(|(role, v)| Some((role, v?)))
            .collect()
    };
    let volume = VolumeRequest {
        more: request.more.clone(),
        columns: roles(strain.or(choice.strain), across.or(choice.lateral)),
        units: roles(choice.strain_unit, choice.lateral_unit),
        range: request.options.range,
        positive: positive.or(choice.positive),
        ..VolumeRequest::new(&request.data, VolumeTest::Lateral)
    };
    let law = model.name();
    let fit = fit_volume(&volume).map_err(|e| FitError::NoPoisson { law, reason: reason(&e) })?;
    if let Some(reason) = other_points(&fit, request, experiment) {
        return Err(FitError::NoPoisson { law, reason });
    }
    if fit.bound_only {
        return Err(FitError::NoFoam { law, low: fit.value.interval[0] });
    }
    Ok(Some(Poisson { ratio: fit.value, measured: true, doubts: fit.summary.messages }))
}

/// Difference of ln λ below which two data points are equal \[–\]
const SAME: f64 = 1e-9;

/// The reason why the lateral strain does not belong to the fitted data points.
fn other_points(fit: &VolumeFit, request: &FitRequest, experiment: &Experiment) -> Option<String> {
    let is_in_range = |s: &&Sample| request.options.range.is_none_or(|range| range.contains(s.stretch));
    let samples = || experiment.single.iter().filter(is_in_range);
    if let Some(other) = samples().find(|s| s.mode != Mode::Uniaxial) {
        let rows = "the lateral strain of all rows is compared with their strain as in a uniaxial test, and some are";
        return Some(format!(
            "{rows} {} (line {}); fit the uniaxial rows in a table of their own",
            other.mode.words(),
            other.line
        ));
    }
    let mut known = fit.abscissas.clone();
    known.sort_by(f64::total_cmp);
    let is_known = |s: &Sample| {
        let ln = s.stretch.ln();
        known.get(known.partition_point(|x| *x < ln - SAME)).is_some_and(|x| *x <= ln + SAME)
    };
    let other = samples().find(|s| s.is_informative() && !is_known(s))?;
    Some(format!(
        "the lateral strain is compared with the strain as the table has it, and the fit takes another one (line {}: stretch {:.6}), by a treatment or a stated kind of strain",
        other.line, other.stretch
    ))
}

/// Refuses a fit with slack whose ratio comes from the lateral strain, because that was compared with a strain that includes the slack.
pub fn check_slack(fit: FitResult) -> Result<FitResult, FitError> {
    let is_measured = fit.poisson.as_ref().is_some_and(|poisson| poisson.measured);
    match fit.slack.first().filter(|_| is_measured) {
        None => Ok(fit),
        Some(slack) => {
            let fact = format!(
                "the strain has a slack of {:.4}, so that the lateral strain does not give the ratio",
                slack.strain
            );
            Err(FitError::NoPoisson {
                law: fit.law,
                reason: format!("{fact}; pass --nu, or --slack no for a fit without slack"),
            })
        }
    }
}

/// The reason why the tables give no ratio, with the flags of `fit`.
fn reason(error: &VolumeError) -> String {
    let (file, missing, found) = match error {
        VolumeError::Column(ColumnError::Columns { file, missing, found }) => (file, missing, found),
        VolumeError::Column(ColumnError::NoColumn { file, role, name, found }) => {
            let found = found.join(", ");
            return format!(
                "{file}: there is no column \"{name}\", which --{role}-column names; the nearest line of names has {found}"
            );
        }
        _ => return with_own_flags(error.to_string()),
    };
    let (words, flags): (Vec<&str>, Vec<&str>) = (missing.iter())
        .map(|role| {
            if *role == Role::Lateral.name() {
                ("lateral strain", "--lateral-column")
            } else {
                (*role, "--strain-column")
            }
        })
        .unzip();
    let (words, flags) = (all(&words), all(&flags));
    format!("{file}: no line names a column of {words}; the nearest one has {}. Name it by {flags}", found.join(", "))
}

/// The message with the flags of `fit` in place of those of `volume`.
fn with_own_flags(message: String) -> String {
    [Role::Strain.name(), Role::Lateral.name()].into_iter().fold(message, |text, role| {
        text.replace(&format!("--unit {role}="), &format!("--{role}-unit "))
            .replace(&format!("--column {role}="), &format!("--{role}-column "))
    })
}

/// The model with its Poisson's ratio, and the ratio, for a table that has already been read: found before, or given by the options.
pub fn of_options(options: &FitOptions, model: FittableLaw) -> Result<(FittableLaw, Option<Poisson>), FitError> {
    let stated = options.accuracy.0.get(&SharedError::Poisson).copied();
    if !model.form.compressible {
        return match stated {
            None => Ok((model, None)),
            Some(half) => Err(FitError::Accuracy {
                key: "poisson".into(),
                text: half.to_string(),
                reason: format!("law {} is fitted as incompressible and has no such error; leave it out", model.name()),
            }),
        };
    }
    let law = model.name();
    let poisson = match (&options.poisson, options.partner.map(Partner::check).transpose()?) {
        (Some(found), _) => found.clone(),
        (None, Some(Partner::Nu(value))) => {
            let half = stated.unwrap_or(0.0);
            let ratio = Bounded { value, interval: [value - half, value + half] };
            Poisson { ratio, measured: false, doubts: vec![] }
        }
        (None, Some(Partner::Kappa(_))) => {
            return Err(FitError::NoPoisson { law, reason: "--kappa does not give it".into() });
        }
        (None, None) => return Err(FitError::NoPoisson { law, reason: "neither is there".into() }),
    };
    Ok((model.with_poisson(poisson.ratio.value), Some(poisson)))
}
