//! Mistakes in a study file that are no matter of syntax: place, fact and remedy of the first one.

use crate::scene::hint;
use crate::study::record::Role;
use crate::study::spec::{FamilySpec, Kind, StudySpec, VariantSpec};

/// Roles and reference that the kind knows: place, fact and remedy of the first mistake.
pub(super) fn check_roles(spec: &StudySpec) -> Result<(), (String, String, String)> {
    let kind = spec.kind.name();
    let known = spec.kind.roles();
    if let Some(family) = spec.families.iter().find(|f| !known.contains(&f.role)) {
        let fact = format!("a study of kind \"{kind}\" has no role \"{}\"", family.role.words());
        let words = known.iter().map(|r| r.words().replace(' ', "_")).collect::<Vec<_>>().join(", ");
        return Err((format!("family {}", family.name), fact, format!("the roles are {words}")));
    }
    check_repeats(spec)?;
    let calibrates = spec.kind == Kind::Calibration;
    match (&spec.calibration, spec.variants.iter().find(|v| v.measured.is_some() != calibrates)) {
        (None, _) if calibrates => {
            let remedy = "add [calibration] with `unknown` and `weighting`";
            return Err(("calibration".into(), "it is missing".into(), remedy.into()));
        }
        (Some(c), _) if calibrates && c.unknown.is_empty() => {
            let remedy = "name constants of the scene, such as \"laws.rubber.mu\"";
            return Err(("calibration.unknown".into(), "nothing is to be found".into(), remedy.into()));
        }
        (None, _) if !calibrates && spec.usage.is_some() => {
            let fact = format!("a study of kind \"{kind}\" finds no constants");
            return Err(("use".into(), fact, "remove it, or take kind = \"calibration\"".into()));
        }
        (Some(_), _) if !calibrates => {
            let fact = format!("a study of kind \"{kind}\" finds no constants");
            return Err(("calibration".into(), fact, "remove it, or take kind = \"calibration\"".into()));
        }
        (_, Some(v)) if calibrates => {
            let remedy = "add measured = { file = …, x = { column, unit, is }, y = { column, unit, is } }";
            return Err((format!("variant {}", v.name), "it has no measured curve".into(), remedy.into()));
        }
        (_, Some(v)) => {
            let fact = format!("a study of kind \"{kind}\" has no use for `measured`");
            return Err((format!("variant {}", v.name), fact, "remove it".into()));
        }
        _ => {}
    }
    match (&spec.reference, spec.kind) {
        (None, Kind::Convergence | Kind::Calibration | Kind::Sweep | Kind::Robustness | Kind::Cost) => Ok(()),
        (None, Kind::Prices) => {
            let on = |f: &FamilySpec, v: &VariantSpec| f.variants.as_ref().is_none_or(|own| own.contains(&v.name));
            let twice = spec.variants.iter().find(|v| spec.families.iter().filter(|f| on(f, v)).count() > 1);
            twice.map_or(Ok(()), |v| {
                let remedy = "a variant has one ladder: give each family its `variants`";
                Err((format!("variant {}", v.name), "two families are run in it".into(), remedy.into()))
            })
        }
        (Some(_), Kind::Convergence | Kind::Calibration | Kind::Cost) => {
            let fact = format!("a study of kind \"{kind}\" finds its reference itself");
            Err(("reference".into(), fact, "remove the key".into()))
        }
        (Some(_), Kind::Sweep | Kind::Prices | Kind::Robustness) => {
            Err(("reference".into(), format!("a study of kind \"{kind}\" has none"), "remove the key".into()))
        }
        (reference, Kind::Materials) => {
            let laws: Vec<&FamilySpec> = spec.families.iter().filter(|f| f.role == Role::Laws).collect();
            let [laws] = laws[..] else {
                let fact = format!("{} families have the role \"laws\"", laws.len());
                return Err(("family".into(), fact, "give it to one; a finer mesh has the role \"finer\"".into()));
            };
            let members: Vec<String> = laws.members.keys().cloned().collect();
            match reference {
                Some(r) if members.contains(r) => Ok(()),
                Some(r) => Err(("reference".into(), format!("no law is called \"{r}\""), hint(r, &members))),
                None => {
                    let remedy = format!("name the law that the others are compared with: {}", members.join(", "));
                    Err(("reference".into(), "it is missing".into(), remedy))
                }
            }
        }
    }
}

/// Only prices scatter, and one overkill case does not tell its own error.
fn check_repeats(spec: &StudySpec) -> Result<(), (String, String, String)> {
    let kind = spec.kind.name();
    match spec.repeats {
        Some(0) => return Err(("repeats".into(), "no run at all".into(), "give 1 or more, for example 3".into())),
        Some(_) if spec.kind != Kind::Cost => {
            let fact = format!("a study of kind \"{kind}\" runs every case once");
            return Err(("repeats".into(), fact, "remove it, or take kind = \"cost\"".into()));
        }
        _ => {}
    }
    match spec.families.iter().find(|f| f.role == Role::Overkill && f.members.len() < 2) {
        Some(f) => {
            let remedy = "add a coarser member: their difference is what the error of the reference is estimated from";
            Err((format!("family {}", f.name), "an overkill family of one member".into(), remedy.into()))
        }
        None => Ok(()),
    }
}

/// Axes belong to a sweep, suites and maps to a study of stability, and families to every other kind.
pub(super) fn check_axes(spec: &StudySpec) -> Result<(), (String, String, String)> {
    let kind = spec.kind.name();
    let names: Vec<String> = spec.axes.iter().map(|a| a.name.clone()).collect();
    check_names(&names).map_err(|(k, fact, remedy)| (format!("axis {}", k + 1), fact, remedy.to_string()))?;
    let hard = !spec.suites.is_empty() || !spec.maps.is_empty();
    match spec.kind {
        Kind::Robustness if !spec.families.is_empty() => {
            let remedy = "write [[suite]] and [[map]] instead";
            return Err(("family".into(), "a study of stability has suites and maps".into(), remedy.into()));
        }
        Kind::Robustness => {}
        _ if hard => {
            let fact = format!("a study of kind \"{kind}\" has none");
            return Err(("suite or map".into(), fact, "take kind = \"stability\"".into()));
        }
        _ => {}
    }
    match (spec.kind, spec.axes.is_empty(), spec.families.is_empty()) {
        (Kind::Sweep, true, _) => {
            let remedy = "add an [[axis]] with name, keys, label, symbol, unit and values";
            Err(("study".into(), "the sweep has no axis".into(), remedy.into()))
        }
        (Kind::Sweep, _, false) => {
            Err(("family".into(), "a sweep makes its cases from its axes".into(), "remove the [[family]]".into()))
        }
        (Kind::Sweep, ..) | (_, true, _) => Ok(()),
        _ => Err(("axis".into(), format!("a study of kind \"{kind}\" has none"), "take kind = \"sweep\"".into())),
    }
}

/// Names become parts of file names and are told apart: index, fact and remedy of the first that cannot be used.
pub(super) fn check_names(names: &[String]) -> Result<(), (usize, String, &'static str)> {
    for (k, name) in names.iter().enumerate() {
        if names[..k].contains(name) {
            return Err((k, format!("another one is called \"{name}\" too"), "give it a name of its own"));
        }
        let fits = |c: char| c.is_alphanumeric() || "._-".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(fits) {
            let fact = format!("\"{name}\" cannot be part of a file name");
            return Err((k, fact, "use letters, digits, \"-\", \"_\" and \".\""));
        }
    }
    Ok(())
}
