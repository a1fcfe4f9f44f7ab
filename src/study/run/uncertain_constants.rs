//! Constants of laws that are known within intervals, and the derivatives of recorded quantities with respect to them.
//!
//! A law file from `durometer fit` has, next to the constant `mu`, the key `mu_interval` in `[provenance]`: the ends of its 95 % interval. With several
//! constants it also has the table `correlation`. Constants without a correlation count as independent of each other. Poisson's ratio, which all terms
//! of a foam share, is one constant. If the interval of a constant is open at one end, or the file says why there is none, nothing bounds its share of
//! the error. A constant that a scene sets to a value outside the interval does not count as that of the file.

use crate::calibrate::{correlation_of, interval_at, is_poisson_of_term};
use crate::math::statistics::larger;
use crate::scene::{KeyValue, ParameterKey, Run, SceneSpec, Sensitivities, extreme};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use toml::Table;

/// A constant with its interval, and the derivatives of the extremes with respect to it.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct UncertainConstantRecord {
    /// `laws.rubber.mu`, or several keys with one value, as in `laws.foam.nu1 = laws.foam.nu2`
    pub constant: String,
    /// The larger distance of its value from an end of its 95 % interval \[SI\]
    pub half_width: f64,
    /// Column → derivative of its largest departure from the start \[unit of the column per SI unit of the constant\]
    pub derivatives: BTreeMap<String, f64>,
    /// Other constant → correlation with it \[–\]; absent ones count as independent
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub correlation: BTreeMap<String, f64>,
}

/// A constant that is known within an interval.
pub struct Uncertain {
    /// Its keys, several if they share one value
    pub keys: Vec<ParameterKey>,
    /// Value \[SI\]
    pub value: f64,
    /// The larger distance of its value from an end of its interval \[SI\]
    pub half_width: f64,
    /// Other constant → correlation with it \[–\]
    pub correlation: BTreeMap<String, f64>,
}

impl Uncertain {
    /// The name of the constant, made of its keys: `laws.foam.nu1 = laws.foam.nu2`.
    fn name(&self) -> String {
        self.keys.iter().map(ToString::to_string).collect::<Vec<_>>().join(" = ")
    }
}

/// The constants in the laws of a scene whose files give an interval with two finite ends.
pub fn uncertain_constants(spec: &SceneSpec) -> Vec<Uncertain> {
    let of = |(law, table): (&String, &Table)| {
        let mut own: Vec<(Uncertain, [f64; 2])> = vec![];
        let known = |(_, _, [low, high]): &(_, f64, [f64; 2])| (high - low).is_finite() && high > low;
        for (name, value, [low, high]) in intervals(table).filter(known) {
            let (ends, is_poisson) = ([low, high], is_poisson_of_term(name));
            let is_shared = |(other, of): &&mut (Uncertain, [f64; 2])| {
                is_poisson && *of == ends && other.keys[0].law_constant().is_some_and(|c| is_poisson_of_term(c.key))
            };
            let key = ParameterKey::of_law(law, name);
            match own.iter_mut().find(is_shared) {
                Some((one, _)) => one.keys.push(key),
                None => own.push((
                    Uncertain {
                        value,
                        correlation: correlations(law, table, name),
                        keys: vec![key],
                        half_width: larger(value - low, high - value),
                    },
                    ends,
                )),
            }
        }
        own.into_iter().map(|(one, _)| one).collect::<Vec<_>>()
    };
    spec.laws.iter().flat_map(of).collect()
}

/// The constants of the laws used by a scene whose interval is open at an end, or whose file says why there is none.
pub fn undetermined_constants(spec: &SceneSpec) -> Vec<String> {
    let used = spec.laws_in_use();
    let of = |(law, table): (&String, &Table)| {
        let open = intervals(table).filter(|(_, _, ends)| ends.iter().any(|end| end.is_infinite()));
        open.map(|(key, ..)| ParameterKey::of_law(law, key).to_string()).collect::<Vec<_>>()
    };
    spec.laws.iter().filter(|(law, _)| used.contains(law.as_str())).flat_map(of).collect()
}

/// The constants of the laws used by a scene whose interval has two finite ends.
pub fn bounded_constants(spec: &SceneSpec) -> Vec<String> {
    let used = spec.laws_in_use();
    let is_used = |one: &Uncertain| one.keys[0].law_constant().is_some_and(|c| used.contains(c.law));
    uncertain_constants(spec).iter().filter(|one| is_used(one)).map(Uncertain::name).collect()
}

/// Correlations of a constant with the other constants of its law.
fn correlations(law: &str, table: &Table, name: &str) -> BTreeMap<String, f64> {
    let provenance = table.get("provenance").and_then(toml::Value::as_table);
    let with = |(other, ..): (&String, f64, [f64; 2])| {
        let r = if other == name { 0.0 } else { correlation_of(provenance?, name, other) };
        (r != 0.0).then(|| (ParameterKey::of_law(law, other).to_string(), r))
    };
    intervals(table).filter_map(with).collect()
}

/// The constants of a law with their values \[SI\] and the intervals in its file.
fn intervals(law: &Table) -> impl Iterator<Item = (&String, f64, [f64; 2])> {
    let provenance = law.get("provenance").and_then(toml::Value::as_table);
    law.iter().filter_map(move |(key, value)| {
        let value = KeyValue::of(value).ok()?.si();
        Some((key, value, interval_at(provenance?, key, value)?))
    })
}

/// Derivatives of the extremes of all columns; columns whose derivatives end before the extreme are left out.
pub fn inputs(constants: &[Uncertain], run: &Run, sensitivities: &Sensitivities) -> Vec<UncertainConstantRecord> {
    let column = |name: &String| {
        let k = run.columns.iter().position(|c| c == name)?;
        sensitivities.rows.get(extreme(run.rows.iter().map(|row| row[k]))?.at)
    };
    let place = |key: &ParameterKey| sensitivities.keys.iter().position(|own| own == key);
    let record = |constant: &Uncertain| {
        let own: Vec<usize> = constant.keys.iter().filter_map(place).collect();
        let derivative = |(j, name): (usize, &String)| {
            let row = column(name).filter(|_| own.len() == constant.keys.len())?;
            let d = own.iter().map(|n| row[j][*n] - sensitivities.rows[0][j][*n]).sum::<f64>();
            d.is_finite().then(|| (name.clone(), d))
        };
        UncertainConstantRecord {
            constant: constant.name(),
            half_width: constant.half_width,
            correlation: constant.correlation.clone(),
            derivatives: sensitivities.columns.iter().enumerate().filter_map(derivative).collect(),
        }
    };
    constants.iter().map(record).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An open end leaves a constant undetermined, and so does a reason why there is no interval. The terms of a foam share ν.
    #[test]
    fn open_intervals_are_told_from_known_ones() {
        let effect = |law: &str| format!("[[effect]]\nkind = \"elastic\"\nregion = \"body\"\nlaw = \"{law}\"\n");
        let text = "[laws.a]\nlaw = \"gent\"\nmu = \"1 kPa\"\nJ_m = 80.0\n\
            [laws.a.provenance]\nmu_interval = [\"0.9 kPa\", \"1.1 kPa\"]\nJ_m_interval = [70.0, \"inf\"]\n\
            [laws.b]\nlaw = \"mooney_rivlin\"\nC10 = \"1 kPa\"\nC01 = \"1 kPa\"\n\
            [laws.b.provenance]\nC10_interval = [\"-inf Pa\", \"inf Pa\"]\nC01_without_interval = \"the curves do not determine it\"\n\
            [laws.c]\nlaw = \"hyperfoam\"\nmu1 = \"1 kPa\"\nalpha1 = 2.0\nnu1 = 0.3\nmu2 = \"1 kPa\"\nalpha2 = 6.0\nnu2 = 0.3\n\
            [laws.c.provenance]\npoisson_interval = [0.25, 0.35]\nalpha1_interval = [1.0, 3.0]\n\
            [laws.unused]\nlaw = \"neo_hookean\"\nmu = \"1 kPa\"\nprovenance = { mu_interval = [\"-inf Pa\", \"inf Pa\"] }\n";
        let rest = "[mesh]\ngrid = { kind = \"box\", size = [\"1 m\", \"1 m\", \"1 m\"], divisions = [1, 1, 1] }\n\
            [[stage]]\nintegrator = \"static\"\nduration = \"1 s\"\ndt = \"1 s\"\n";
        let text = text.to_string() + &["a", "b", "c"].map(effect).concat() + rest;
        let without_c = text.replace(&effect("c"), "");
        let spec = SceneSpec::from_text(std::path::Path::new("scene.toml"), &text, "").expect("a scene");
        assert_eq!(undetermined_constants(&spec), ["laws.a.J_m", "laws.b.C10", "laws.b.C01"]);
        let known: Vec<(String, f64)> = uncertain_constants(&spec)
            .into_iter()
            .map(|one| (one.keys.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "), one.half_width))
            .collect();
        let names: Vec<&str> = known.iter().map(|one| one.0.as_str()).collect();
        assert_eq!(names, ["laws.a.mu", "laws.c.alpha1", "laws.c.nu1 laws.c.nu2"]);
        assert_eq!(bounded_constants(&spec), ["laws.a.mu", "laws.c.alpha1", "laws.c.nu1 = laws.c.nu2"]);
        let fewer = SceneSpec::from_text(std::path::Path::new("scene.toml"), &without_c, "").expect("a scene");
        assert_eq!(bounded_constants(&fewer), ["laws.a.mu"]);
        assert!((known[0].1 - 100.0).abs() < 1e-9 && (known[2].1 - 0.05).abs() < 1e-12, "{known:?}");
        let mu = |ends: &str| {
            let changed = text.replace("mu_interval = [\"0.9 kPa\", \"1.1 kPa\"]", &format!("mu_interval = [{ends}]"));
            let spec = SceneSpec::from_text(std::path::Path::new("scene.toml"), &changed, "").expect("a scene");
            let of = |one: &Uncertain| one.keys[0].to_string() == "laws.a.mu";
            uncertain_constants(&spec).into_iter().find(of).map(|one| one.half_width)
        };
        let skewed = mu("\"0.95 kPa\", \"1.3 kPa\"").expect("known");
        assert!((skewed - 300.0).abs() < 1e-9, "the larger side: {skewed}");
        assert_eq!(mu("\"1.9 kPa\", \"2.1 kPa\""), None, "the scene has another value than the file");
    }
}
