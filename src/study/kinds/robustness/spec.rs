//! `[[suite]]` and `[[map]]` of a study of kind `robustness`, as families of cases.

use crate::scene::{changes, hint};
use crate::schema::AnyTable;
use crate::study::axis::{self, AxisSpec, Combine};
use crate::study::kind::{Expansion, RunRules};
use crate::study::kinds::robustness::check::{Check, CheckSpec};
use crate::study::kinds::robustness::record::{MapRecord, RobustnessRecord, SuiteRecord};
use crate::study::spec::{FamilySpec, Mistake, VariantSpec, check_unit};
use crate::study::store::record::{REFUSED, Role, StudyQuantity};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Scenes that are hard for simulators: rows of the matrix, whose columns are variants.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SuiteSpec {
    /// Part of the case ids
    pub name: String,
    /// The set-up in one line
    pub setup: String,
    /// Scene file, relative to the study; the scene of the study if absent
    pub scene: Option<PathBuf>,
    /// Columns of the matrix in which the suite is run, all if absent
    pub variants: Option<Vec<String>>,
    /// Changes for all members
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// Label of a member → its changes
    #[serde(deserialize_with = "changes::of_members")]
    #[schemars(with = "AnyTable")]
    pub members: toml::Table,
    /// Statuses at the end of the run that are right, including `Refused`. A stop is demanded if `Converged` is not among them. If absent,
    /// `Converged` if a check needs a converged run, otherwise any stated end except running out of time
    pub ends: Option<Vec<String>>,
    /// Checks of the results
    #[serde(rename = "check", default)]
    pub checks: Vec<CheckSpec>,
    /// Whether it belongs to the quick half
    #[serde(default)]
    pub quick: bool,
}

/// Map of the region over two axes in which a scene can be solved.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapSpec {
    /// Part of the case ids
    pub name: String,
    /// The set-up in one line
    pub setup: String,
    /// Scene file, relative to the study; the scene of the study if absent
    pub scene: Option<PathBuf>,
    /// Variants that are compared side by side
    pub variants: Option<Vec<String>>,
    /// Changes for all points, by path
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "AnyTable")]
    pub set: toml::Table,
    /// The column whose peak is compared with that of the reference
    pub quantity: StudyQuantity,
    /// The two axes: first along x, then along y
    #[serde(rename = "axis")]
    pub axes: Vec<AxisSpec>,
    /// Changes that make the case that a row is compared with; if absent, the first value along x in the first variant
    #[serde(default, deserialize_with = "changes::by_path")]
    #[schemars(with = "Option<AnyTable>")]
    pub reference: Option<toml::Table>,
}

/// Statuses that a case may be expected to end with.
const ENDS: [&str; 11] = [
    "Converged",
    "LimitPoint",
    "NoEquilibrium",
    "Inverted",
    "Singular",
    "ContactJammed",
    "FactorTooLarge",
    "StepTooSmall",
    "NotFinite",
    "TimeBudget",
    REFUSED,
];

/// Returns the families of cases and the checks made in them, or the first mistake as place, fact and remedy.
pub fn expand(
    variants: Vec<VariantSpec>,
    suites: &[SuiteSpec],
    maps: &[MapSpec],
) -> Result<Expansion<RobustnessRecord>, Mistake> {
    let rules = RunRules { keep_refusals: true, share_cases: false, ..RunRules::default() };
    let mut out = Expansion { rules, ..Expansion::new(variants, vec![], RobustnessRecord::default()) };
    for suite in suites {
        expand_suite(suite, &mut out)?;
    }
    for map in maps {
        expand_map(map, &mut out)?;
    }
    Ok(out)
}

fn expand_suite(suite: &SuiteSpec, out: &mut Expansion<RobustnessRecord>) -> Result<(), Mistake> {
    let place = || format!("suite {}", suite.name);
    let variants = suite.variants.clone().unwrap_or_else(|| out.variants.iter().map(|v| v.name.clone()).collect());
    if let Some(unknown) = suite.ends.iter().flatten().find(|end| !ENDS.contains(&end.as_str())) {
        return Err((place(), format!("no run ends with \"{unknown}\""), hint(unknown, &ENDS)));
    }
    let members: Vec<String> = suite.members.keys().cloned().collect();
    let checks = suite.checks.iter().map(|c| Check::new(c, &members, &variants));
    let checks: Vec<Check> = checks.collect::<Result<_, _>>().map_err(|(fact, remedy)| (place(), fact, remedy))?;
    out.families.push(FamilySpec {
        name: suite.name.clone(),
        role: Role::Suite,
        variants: suite.variants.clone(),
        set: suite.set.clone(),
        members: suite.members.clone(),
        labels: BTreeMap::new(),
        own: BTreeMap::new(),
        scene: suite.scene.clone(),
    });
    out.columns.insert(suite.name.clone(), checks.iter().flat_map(Check::columns).collect());
    out.details.suites.push(SuiteRecord {
        family: suite.name.clone(),
        setup: suite.setup.clone(),
        ends: suite.ends.clone(),
        checks,
    });
    Ok(())
}

/// Refuses a map in which an axis undoes a change made by the other axis, by itself or by one of the variants. `scene` is the scene of the study in
/// `file`.
pub fn check_map(map: &MapSpec, variants: &[VariantSpec], (file, scene): (&Path, &Path)) -> Result<(), Mistake> {
    let own = map.scene.as_ref().map(|own| file.parent().unwrap_or(Path::new("")).join(own));
    let wanted = |v: &&VariantSpec| map.variants.as_ref().is_none_or(|names| names.contains(&v.name));
    for v in variants.iter().filter(wanted) {
        let sets = [(format!("variant {}", v.name), &v.set), ("the map".into(), &map.set)];
        axis::check_apart(&map.axes, &sets, own.as_deref().unwrap_or(scene))
            .map_err(|(axis, fact, remedy)| (format!("map {}, {axis}", map.name), fact, remedy))?;
    }
    Ok(())
}

fn expand_map(map: &MapSpec, out: &mut Expansion<RobustnessRecord>) -> Result<(), Mistake> {
    let place = format!("map {}", map.name);
    if map.axes.len() != 2 {
        let remedy = "give two [[map.axis]]: along x, then along y";
        return Err((place, format!("a map has two axes, and this one {}", map.axes.len()), remedy.into()));
    }
    let of_map = |(axis, fact, remedy): Mistake| (format!("{place}, {axis}"), fact, remedy);
    let expanded = axis::expand(&map.axes, Combine::Grid).map_err(of_map)?;
    let family = |name: &str, variants: Option<Vec<String>>, members| FamilySpec {
        name: name.into(),
        role: Role::Map,
        variants,
        set: map.set.clone(),
        members,
        labels: BTreeMap::new(),
        own: BTreeMap::new(),
        scene: map.scene.clone(),
    };
    let (reference, rows) = match &map.reference {
        None => (None, vec![]),
        Some(changes) => {
            let first = map.variants.as_ref().and_then(|v| v.first().cloned());
            let first = first.or_else(|| out.variants.first().map(|v| v.name.clone()));
            let along = &map.axes[1];
            let (mut members, mut rows) = (toml::Table::new(), vec![]);
            for (k, value) in along.values.iter().enumerate() {
                let mut set: toml::Table = along.keys.iter().map(|key| (key.clone(), value.clone())).collect();
                set.extend(changes.clone());
                let label = format!("{}{}", along.name, expanded.axes[1].file_name(k));
                rows.push(label.clone());
                members.insert(label, set.into());
            }
            let name = format!("{}-reference", map.name);
            out.families.push(family(&name, Some(first.into_iter().collect()), members));
            out.columns.insert(name.clone(), vec![map.quantity.name.clone()]);
            (Some(name), rows)
        }
    };
    out.families.push(family(&map.name, map.variants.clone(), expanded.family.members));
    check_unit(&map.quantity).map_err(|(fact, remedy)| (format!("map {}", map.name), fact, remedy))?;
    out.columns.insert(map.name.clone(), vec![map.quantity.name.clone()]);
    out.details.maps.push(MapRecord {
        family: map.name.clone(),
        setup: map.setup.clone(),
        quantity: map.quantity.clone(),
        axes: expanded.axes,
        points: expanded.points,
        reference,
        rows,
    });
    Ok(())
}
