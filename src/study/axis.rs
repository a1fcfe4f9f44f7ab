//! Axes of a sweep: which keys of the scene take which values, and the resulting points.
//!
//! A grid has a point for every combination of values; the first axis varies slowest. A list advances along all axes together: its k-th point takes the
//! k-th value of each. Values of a grid must rise or fall. Those of a list may be in any order and may repeat, as in a Latin hypercube, a random or
//! Sobol' sequence, or changes of one key at a time.

use crate::math::units;
use crate::scene::{overrides, read_table};
use crate::study::spec::{FamilySpec, MOST_CASES, Mistake};
use crate::study::store::record::Role;
use crate::wording::count;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::path::Path;

/// `[[axis]]` of a study.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxisSpec {
    /// Part of the case ids
    pub name: String,
    /// Paths into the scene that all take the value
    pub keys: Vec<String>,
    /// In words: `Young's modulus`
    pub label: String,
    /// Letter in tables and on axes
    pub symbol: String,
    /// Unit of the numbers in tables and figures; absent if they have none
    #[serde(default)]
    pub unit: String,
    /// Values in their order, with their unit, or tables of changes
    #[schemars(with = "Vec<serde_json::Value>")]
    pub values: Vec<toml::Value>,
    /// Names of the values if these are tables of changes
    #[serde(skip)]
    pub names: Option<Vec<String>>,
}

/// Axis of a sweep: keys of the scene that take the same values.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct AxisRecord {
    pub name: String,
    pub keys: Vec<String>,
    /// In words: `Young's modulus`
    pub label: String,
    /// Letter in tables and on axes: `E`
    pub symbol: String,
    /// Unit of the numbers
    pub unit: String,
    /// The values in their order, as written in the study
    pub values: Vec<String>,
    /// The values as numbers in `unit`; empty if they are words
    pub numbers: Vec<f64>,
}

impl AxisRecord {
    /// Whether the values are numbers that only rise or only fall; words and the scattered values of a list have no order.
    pub fn is_ordered(&self) -> bool {
        let all = |holds: fn(&[f64]) -> bool| self.numbers.windows(2).all(holds);
        !self.numbers.is_empty() && (all(|w| w[0] < w[1]) || all(|w| w[0] > w[1]))
    }
}

/// How several axes are combined.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, PartialEq, Eq, Default)]
#[serde(rename_all = "snake_case")]
pub enum Combine {
    /// Every combination of the values
    #[default]
    Grid,
    /// The first values of all axes together, then the second ones, and so on
    List,
}

/// A sweep as a family of cases.
pub struct Expanded {
    pub family: FamilySpec,
    pub axes: Vec<AxisRecord>,
    /// Member → index of its value on every axis
    pub points: BTreeMap<String, Vec<usize>>,
}

/// Expands the axes into points, as members of one family.
pub fn expand(specs: &[AxisSpec], combine: Combine) -> Result<Expanded, Mistake> {
    let axes: Vec<AxisRecord> = specs.iter().map(|spec| spec.record(combine)).collect::<Result<_, _>>()?;
    let (mut members, mut points) = (toml::Table::new(), BTreeMap::new());
    for at in combinations(specs, combine)? {
        let (mut set, mut name) = (toml::Table::new(), Vec::new());
        for ((spec, axis), &k) in specs.iter().zip(&axes).zip(&at) {
            spec.keys.iter().for_each(|key| drop(set.insert(key.clone(), spec.values[k].clone())));
            spec.names.iter().for_each(|_| set.extend(spec.values[k].as_table().cloned().unwrap_or_default()));
            name.push(format!("{}{}", axis.name, axis.file_name(k)));
        }
        let name = name.join("_");
        if members.insert(name.clone(), set.into()).is_some() {
            let fact = format!("two points are called {name} in file names");
            return Err((
                "axis".into(),
                fact,
                "remove one, write their values in another unit, or rename the files".into(),
            ));
        }
        points.insert(name, at);
    }
    let set = toml::Table::new();
    let (name, role, own) = ("sweep".into(), Role::Grid, BTreeMap::new());
    let family = FamilySpec { name, role, variants: None, set, members, labels: BTreeMap::new(), own, scene: None };
    Ok(Expanded { family, axes, points })
}

/// Refuses axes that overwrite each other or one of the `sets` (changes made before those of the axes, each with its owner): the points would not have
/// the values that name them.
pub fn check_apart(specs: &[AxisSpec], sets: &[(String, &toml::Table)], scene: &Path) -> Result<(), Mistake> {
    // A scene that cannot be read and a change to an unknown key are refused elsewhere, with their own reason
    let Ok((_, mut table)) = read_table(scene) else { return Ok(()) };
    let mut before: Vec<(&str, String)> = vec![];
    for (owner, set) in sets {
        for (key, value) in set.iter() {
            overrides::apply(&mut table, key, value.clone()).ok();
            before.push((key, owner.clone()));
        }
    }
    for spec in specs {
        for key in &spec.keys {
            if let Some((other, owner)) = before.iter().find(|(other, _)| overrides::undoes(&table, key, other)) {
                let fact = format!("its key {key} takes the place of {other}, which {owner} sets");
                let remedy = "leave one of them out: the last change alone would count";
                return Err((format!("axis {}", spec.name), fact, remedy.into()));
            }
        }
        before.extend(spec.keys.iter().map(|key| (key.as_str(), format!("axis {}", spec.name))));
    }
    Ok(())
}

/// Index of the value on every axis, for each point; too many points are refused before any is made.
fn combinations(specs: &[AxisSpec], combine: Combine) -> Result<Vec<Vec<usize>>, Mistake> {
    let count = |s: &AxisSpec| s.values.len();
    if combine == Combine::List {
        let first = specs.first().map_or(0, count);
        if let Some(other) = specs.iter().find(|s| count(s) != first) {
            let fact = format!("it has {} values and the first axis {first}", count(other));
            let remedy = "in a list every axis has one value a point; or take combine = \"grid\"";
            return Err((format!("axis {}", other.name), fact, remedy.into()));
        }
        check_points(first as f64)?;
        return Ok((0..first).map(|k| vec![k; specs.len()]).collect());
    }
    check_points(specs.iter().map(|s| count(s) as f64).product())?;
    let along = |done: Vec<Vec<usize>>, spec: &AxisSpec| {
        let next = |at: &Vec<usize>| (0..count(spec)).map(|k| [&at[..], &[k]].concat()).collect::<Vec<_>>();
        done.iter().flat_map(next).collect()
    };
    Ok(specs.iter().fold(vec![vec![]], along))
}

fn check_points(points: f64) -> Result<(), Mistake> {
    if points <= MOST_CASES as f64 {
        return Ok(());
    }
    let number = if points < 1e9 { points.to_string() } else { format!("{points:.1e}") };
    let remedy = format!("take fewer values, or divide the study: at most {MOST_CASES} points are run");
    Err(("axis".into(), format!("the axes make {number} points"), remedy))
}

impl AxisSpec {
    fn record(&self, combine: Combine) -> Result<AxisRecord, Mistake> {
        let refuse = |fact: String, remedy: &str| Err((format!("axis {}", self.name), fact, remedy.into()));
        if self.keys.is_empty() && self.names.is_none() {
            return refuse("it changes no key".into(), "write keys = [\"laws.rubber.E\"]");
        }
        if self.symbol.trim().is_empty() {
            return refuse("its symbol is empty".into(), "give it a letter for tables and axes, symbol = \"E\"");
        }
        if self.values.len() < 2 {
            let remedy = "give at least two, values = [\"50 kPa\", \"100 kPa\"]; one alone belongs in the scene";
            return refuse(format!("it has {}", count(self.values.len(), "value")), remedy);
        }
        let values = self.names.clone().unwrap_or_else(|| self.values.iter().map(as_text).collect::<Vec<String>>());
        let mut seen = HashSet::new();
        let is_grid = combine == Combine::Grid;
        if let Some(k) = (0..values.len()).find(|&k| is_grid && !seen.insert(&values[k])) {
            return refuse(format!("the value {} is given twice", values[k]), "remove one");
        }
        // One physical quantity is enough: the other values may have a mistake in their unit
        let numeric = !self.unit.is_empty() || values.iter().any(|v| units::quantity(v).is_ok());
        let mut numbers = vec![];
        if numeric {
            for value in &values {
                match units::in_unit(value, &self.unit) {
                    Ok(number) => numbers.push(number),
                    Err(e) => {
                        let remedy =
                            "set `unit` to one that all values can be written in, or leave it out where they are words";
                        return refuse(e.to_string(), remedy);
                    }
                }
            }
        }
        let Self { name, keys, label, symbol, unit, .. } = self.clone();
        let axis = AxisRecord { name, keys, label, symbol, unit, values, numbers };
        if is_grid && numeric && !axis.is_ordered() {
            return refuse("the values neither rise nor fall".into(), "sort them");
        }
        Ok(axis)
    }
}

/// A value as it is written in the file, without quotes.
fn as_text(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_string)
}

impl AxisRecord {
    /// The part of a value that is used in file names: `1.07 g/cm^3` → `1.07g-cm3`. The dot of a word such as `load.csv` is not a decimal point and
    /// would start a file extension, so that it becomes a hyphen: `load-csv`.
    pub fn file_name(&self, k: usize) -> String {
        let kept = |c: char| match c {
            ' ' | '^' | '"' => None,
            '.' if self.numbers.is_empty() => Some('-'),
            c if c.is_alphanumeric() || "._-".contains(c) => Some(c),
            _ => Some('-'),
        };
        self.values[k].chars().filter_map(kept).collect()
    }
}
