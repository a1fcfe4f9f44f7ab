//! Unknowns of an inverse analysis: constants of laws and other numbers of a scene, with their start and the values that they may take.

use super::InverseError;
use crate::material::Parameter;
use crate::material::registry::quantity;
use crate::math::threads::locked;
use crate::math::units::{self, Dimension};
use crate::scene::{KeyValue, ParameterKey, SceneError, SceneSpec};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::{Mutex, OnceLock};
use toml::{Table, Value};

/// A number of the scene that is to be found.
#[derive(Clone, Debug)]
pub struct Unknown {
    pub key: ParameterKey,
    /// For a constant, its declaration by the law; for another number, its key, its dimension and the values for which it has a meaning
    pub parameter: Parameter,
    /// Value in the scene file \[SI\]
    pub start: f64,
    /// Values that it may take, including both ends \[SI\]
    pub bounds: [f64; 2],
    /// A typical size of the value, used if the value is zero \[SI\]
    pub usual: f64,
    /// The number in the scene with its unit; `None` for a constant of a law in pascal or without a unit
    value: Option<KeyValue>,
}

/// Bounds as written in a file, by the name of the unknown.
pub type Bounds = BTreeMap<String, [Value; 2]>;

/// Distance from the end of an open interval, relative to its width or the size of the value \[–\]
const INSIDE: f64 = 1e-6;

impl Unknown {
    /// The unknowns of a scene with the values of its file, within `bounds` where these are given, otherwise where they have a meaning. The error
    /// names all wrong unknowns.
    pub fn all(
        (file, spec, text): (&Path, &SceneSpec, &str),
        keys: &[ParameterKey],
        bounds: &Bounds,
    ) -> Result<Vec<Self>, InverseError> {
        let mut wrong: Vec<String> = vec![];
        let known: Vec<String> = keys.iter().map(ToString::to_string).collect();
        wrong.extend(bounds.keys().filter(|k| !known.contains(k)).map(|k| {
            format!("{k}: it has bounds and is not looked for; name it in `unknown`, or take its bounds out")
        }));
        let twice = keys.iter().enumerate().filter(|(k, key)| keys[..*k].contains(key));
        wrong.extend(twice.map(|(_, key)| format!("{key}: it is named twice in `unknown`")));
        let mut found = vec![];
        for key in keys {
            let one = match key.law_constant() {
                Some(_) => Self::of_law(spec, key, bounds),
                None => Self::of_scene(file, text, key, bounds),
            };
            match one {
                Ok(unknown) => found.push(unknown),
                Err(why) => wrong.push(why),
            }
        }
        if wrong.is_empty() { Ok(found) } else { Err(InverseError::Unknowns { wrong }) }
    }

    fn of_law(spec: &SceneSpec, key: &ParameterKey, bounds: &Bounds) -> Result<Self, String> {
        let refuse = |fact: String| format!("{key}: {fact}");
        let of = key.law_constant().ok_or_else(|| refuse("it is no constant of a law".into()))?;
        let table = spec.laws.get(of.law).ok_or_else(|| refuse("the scene has no such law".into()))?;
        let (entry, values, _) = spec.known_laws.given(table).map_err(|e| refuse(e.to_string()))?;
        let parameter = entry.keys.iter().find(|p| p.name == of.key).copied();
        let (Some(parameter), Some(&start)) = (parameter, values.get(of.key)) else {
            let known = values.keys().cloned().collect::<Vec<_>>().join(", ");
            return Err(refuse(format!("law {} does not give it; it gives {known}", of.law)));
        };
        let bounds = limits(&parameter, start, bounds.get(key.path())).map_err(refuse)?;
        let is_usual = [Dimension::PRESSURE, Dimension::NONE].contains(&parameter.dimension);
        let value = table.get(of.key).filter(|_| !is_usual).map(KeyValue::of).transpose().map_err(refuse)?;
        Ok(Self { key: key.clone(), parameter, start, bounds, usual: 1.0, value })
    }

    fn of_scene(file: &Path, text: &str, key: &ParameterKey, bounds: &Bounds) -> Result<Self, String> {
        let refuse = |fact: String| format!("{key}: {fact}");
        let table = scene_table(file, text).map_err(|e| refuse(e.to_string()))?;
        let value = key.value(&table).map_err(|e| e.to_string())?;
        let (start, dimension) = (value.si(), value.dimension);
        let symbol = interned(key.path());
        let parameter =
            Parameter::new(symbol, symbol, dimension, domain(key, dimension, start), "a number of the scene");
        let bounds = limits(&parameter, start, bounds.get(key.path())).map_err(refuse)?;
        Ok(Self { key: key.clone(), parameter, start, bounds, usual: value.factor.abs(), value: Some(value) })
    }

    /// A value \[SI\] as written in a scene file, with all its digits.
    pub fn written(&self, value: f64) -> Value {
        match &self.value {
            Some(own) => own.written_si(value),
            None if self.parameter.dimension == Dimension::PRESSURE => format!("{value} Pa").into(),
            None => value.into(),
        }
    }
}

/// Parses the text of a scene as a table.
pub(super) fn scene_table(file: &Path, text: &str) -> Result<Table, InverseError> {
    text.parse().map_err(|e: toml::de::Error| {
        InverseError::Scene(SceneError::Unreadable { file: file.into(), reason: e.message().into() })
    })
}

/// The open interval in which a number of the scene has a meaning: moduli of a Prony series lie between 0 and 1, and quantities that cannot be
/// negative begin at zero.
fn domain(key: &ParameterKey, dimension: Dimension, start: f64) -> (f64, f64) {
    let path = key.path();
    if path.contains(".prony.") && path.ends_with(".g") {
        return (0.0, 1.0);
    }
    let never_negative = [
        Dimension::DENSITY,
        Dimension::TIME,
        Dimension::FREQUENCY,
        Dimension::VISCOSITY,
        Dimension::DAMPING,
        Dimension::STIFFNESS,
    ];
    let is_size = path.starts_with("mesh.grid.") || path.ends_with("thickness") || path.ends_with(".EA");
    if start > 0.0 && (is_size || never_negative.contains(&dimension)) { Parameter::POSITIVE } else { Parameter::ANY }
}

/// A name that lives as long as the program; each name is stored once.
fn interned(name: &str) -> &'static str {
    static NAMES: OnceLock<Mutex<BTreeSet<&'static str>>> = OnceLock::new();
    let mut names = locked(NAMES.get_or_init(Mutex::default));
    if let Some(known) = names.get(name) {
        return known;
    }
    let kept: &'static str = String::from(name).leak();
    names.insert(kept);
    kept
}

/// The interval in which the law is defined, with open ends moved slightly inside; nothing is cut off below a positive constant.
fn admissible(p: &Parameter, start: f64) -> [f64; 2] {
    let (lower, upper) = p.bounds;
    let own =
        |end: f64| if lower.is_finite() && upper.is_finite() { upper - lower } else { start.abs().max(end.abs()) };
    let inside = |end: f64, side: f64| {
        if end.is_finite() && !(end == 0.0 && upper.is_infinite()) { end + side * INSIDE * own(end) } else { end }
    };
    [inside(lower, 1.0), inside(upper, -1.0)]
}

/// The bounds in a file, within which the number must have a meaning and the start must lie; without bounds, the admissible interval.
fn limits(p: &Parameter, start: f64, ends: Option<&[Value; 2]>) -> Result<[f64; 2], String> {
    let Some(ends) = ends else { return Ok(admissible(p, start)) };
    let read = |v: &Value| read(p, v).map_err(|e| format!("its bound {v}: {e}"));
    let (low, high) = (read(&ends[0])?, read(&ends[1])?);
    let words = format!("its bounds {} to {}", ends[0], ends[1]);
    if low >= high {
        return Err(format!("{words} leave nothing between them; give the lower one first"));
    }
    let (lower, upper) = p.bounds;
    if low < lower || high > upper {
        return Err(format!("{words} go beyond what the law allows, {lower} to {upper} in SI units; narrow them"));
    }
    if !(low..=high).contains(&start) {
        return Err(format!(
            "the search begins at the value of the scene, {start} in SI units, and {words} exclude it; widen them, or change the scene"
        ));
    }
    let [least, most] = admissible(p, start);
    Ok([low.max(least), high.min(most)])
}

/// A bound in SI units.
fn read(p: &Parameter, value: &Value) -> Result<f64, String> {
    if p.dimension == Dimension::PRESSURE || p.dimension == Dimension::NONE {
        return quantity(p, value).map_err(|e| e.to_string());
    }
    let text = value.as_str().ok_or_else(|| format!("it needs a unit such as {}", p.dimension.example()))?;
    units::parse(text, p.dimension).map_err(|e| e.to_string())
}
