//! Reads the tables of a request; flags that have no effect on any of them are refused.

use super::accuracy::SharedError;
use super::experiment::Experiment;
use super::names::{StrainKind, StressKind};
use crate::calibrate::{FitError, FitRequest, fittable_laws};
use crate::material::FitTerms;
use crate::wording::distinct;

/// Reads the tables of a request.
pub fn read(request: &FitRequest) -> Result<Vec<Experiment>, FitError> {
    let modes = distinct(request.options.modes.iter().copied());
    let stated = if let [one] = modes[..] { Some(one) } else { None };
    let without_column = |e: FitError| match e {
        FitError::NoMode { file } if modes.len() > 1 => FitError::NoModeColumn { file, modes: modes.clone() },
        other => other,
    };
    let files = std::iter::once(&request.data).chain(&request.more);
    let one = |path: &std::path::PathBuf| {
        Experiment::read(path, request.card.as_deref(), &request.columns, stated).map_err(without_column)
    };
    let tables = files.map(one).collect::<Result<Vec<_>, _>>()?;
    check_flags(request, &tables)?;
    Ok(tables)
}

/// Refuses the first flag that has no effect on any table.
fn check_flags(request: &FitRequest, tables: &[Experiment]) -> Result<(), FitError> {
    let (columns, options, sizes) = (&request.columns, &request.options, request.columns.dimensions);
    let any = |is: &dyn Fn(&Experiment) -> bool| tables.iter().any(is);
    let has = |key: &'static str| any(&|e| e.pieces.iter().any(|p| p.dimensions.has(key)));
    let errs = |error| {
        let by_card = any(&|e| e.pieces.iter().any(|p| p.accuracy.0.contains_key(&error)));
        by_card || options.accuracy.0.contains_key(&error)
    };
    let is_machine = has("compliance") || errs(SharedError::Compliance);
    let is_travel = is_machine || any(&|e| e.kinds.iter().any(|k| k.0 == StrainKind::Displacement));
    let is_force =
        is_machine || errs(SharedError::ForceZero) || any(&|e| e.kinds.iter().any(|k| k.1 == StressKind::Force));
    let is_biaxial = any(&|e| e.kinds.len() > 1);
    let is_true = any(&|e| e.kinds.iter().any(|k| k.1 == StressKind::True));
    let takes_lateral = columns.compressible && (columns.ratio.is_none() || is_true);
    let law = fittable_laws().into_iter().find(|law| law.info.name == options.law).and_then(|law| law.fit.as_ref());
    let is_linear = law.is_none_or(|form| matches!(form.terms, FitTerms::Linear(_)));
    let lateral = "only hyperfoam takes the strain across the load, for Poisson's ratio where --nu does not give it, or for a true stress";
    let force = "no column is a force, and no compliance is corrected";
    let flags = [
        ("strain-column-2", columns.strain_2.is_some(), is_biaxial, "the test is not biaxial"),
        ("stress-column-2", columns.stress_2.is_some(), is_biaxial, "the test is not biaxial"),
        ("lateral-column", columns.lateral.is_some(), takes_lateral, lateral),
        ("lateral-unit", columns.lateral_unit.is_some(), takes_lateral, lateral),
        (
            "gauge-length",
            sizes.has("gauge_length"),
            is_travel,
            "no column is a displacement, and no compliance is corrected",
        ),
        ("width", sizes.has("width"), is_force, force),
        ("thickness", sizes.has("thickness"), is_force, force),
        ("diameter", sizes.has("diameter"), is_force, force),
        ("area", sizes.has("area"), is_force, force),
        (
            "width",
            sizes.has("width"),
            has("thickness"),
            "the cross-section is given, and without a thickness the width is no part of it",
        ),
        (
            "thickness",
            sizes.has("thickness"),
            has("width"),
            "the cross-section is given, and without a width the thickness is no part of it",
        ),
        (
            "stable",
            options.stable.is_some(),
            is_linear,
            "only laws that are linear in their constants are kept stable, as mooney_rivlin and yeoh are",
        ),
    ];
    match flags.into_iter().find(|(_, is_given, is_used, _)| *is_given && !is_used) {
        Some((flag, _, _, why)) => Err(FitError::Idle { flag, why }),
        None => Ok(()),
    }
}
