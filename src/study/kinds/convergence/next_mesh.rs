//! The mesh that would support a verdict where the evidence does not, and its cost.
//!
//! The family whose bars are nearest to the tolerance is refined, among those that do not lock, have no region whose border runs through cells, and do not
//! oscillate by more than the tolerance whatever the next value is: its next size follows from its finest and
//! second finest scene, whose `[mesh]` tables differ in the keys that set the size. The ratio is the one that brings the largest bar to the tolerance by the
//! observed order (2 where there is none), from 1.3 to 2; more than that is another step. A grid keeps the proportions of its
//! family. The cost is that of the power law through the family.

use crate::math::units;
use crate::report::numbers::{percent, seconds, thousands};
use crate::study::analysis::ByQuantity;
use crate::study::estimate::family::{Estimate, oscillation};
use crate::study::estimate::growth::{Predicted, growth};
use crate::study::estimate::richardson::{CAUTIOUS_FACTOR, Convergence, LEAST_ORDER, LEAST_RATIO};
use crate::study::extension::Extension;
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::errors::StepCause;
use crate::study::kinds::convergence::findings::MeshErrors;
use crate::study::locking;
use crate::study::store::record::{CaseRecord, FamilyRecord, NOT_RUN, Role, StoredCase};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Largest ratio of sizes from one mesh to the next.
const MOST_RATIO: f64 = 2.0;
/// Share of the tolerance that the next mesh is to reach.
const AIM: f64 = 0.8;

/// The mesh that would help.
#[derive(Clone, Debug, PartialEq)]
pub enum NextMesh {
    /// It is not a mesh of the study yet
    New(Extension),
    /// No mesh helps, or the family has it already without a usable result; in words
    OfNoUse(String),
}

impl NextMesh {
    /// In words: which mesh, and why.
    pub fn sentence(&self) -> &str {
        match self {
            Self::New(extension) => &extension.sentence,
            Self::OfNoUse(sentence) => sentence,
        }
    }

    /// The mesh to add.
    pub fn extension(self) -> Option<Extension> {
        match self {
            Self::New(extension) => Some(extension),
            Self::OfNoUse(_) => None,
        }
    }
}

/// The mesh that would help where there is no verdict; none where no family can be refined by its keys, where a quantity near zero needs an absolute
/// tolerance first, or where a reason remains that no mesh removes.
pub fn next_mesh(cases: &Cases, quantities: &[ByQuantity<MeshErrors>]) -> Option<NextMesh> {
    let deciding = || quantities.iter().filter(|q| q.deciding);
    let is_supported = deciding().all(|q| q.supported);
    let open: Vec<&ByQuantity<MeshErrors>> = deciding().filter(|q| is_supported || !q.supported).collect();
    let is_near_zero = |q: &&ByQuantity<MeshErrors>| {
        let leading = q.reference.as_ref().and_then(|r| q.estimate(&r.family));
        q.quantity.absolute_tolerance.is_none() && leading.is_some_and(Estimate::is_near_zero)
    };
    if open.is_empty() || open.iter().any(is_near_zero) {
        return None;
    }
    if let Some(sentence) = open.iter().find_map(|q| limited_by_steps(q, cases.study.tolerance)) {
        return Some(NextMesh::OfNoUse(sentence));
    }
    let families =
        cases.study.families.iter().filter(|f| !matches!(f.role, Role::Seeds | Role::Adaptive | Role::TimeStep));
    let candidates = families.filter_map(|f| Candidate::new(cases, f, &open));
    let best = candidates.min_by(|a, b| a.bar.total_cmp(&b.bar))?;
    if let Some(sentence) = best.tried(cases) {
        return Some(NextMesh::OfNoUse(sentence));
    }
    let (family, meshes) = (best.family, best.meshes.len());
    let cells = best.next.cells;
    let cost_s = best.cost(cases);
    let cost = cost_s.map_or(String::new(), |p| {
        // Three meshes may leave an interval over decades
        let known = p.interval.filter(|[low, high]| *high < 100.0 * low);
        let interval = known.map_or(String::new(), |[a, b]| format!(" (95 %: {} to {})", seconds(a), seconds(b)));
        format!(", {} per case by the law of growth{interval}", seconds(p.value))
    });
    let more = if best.wanted > MOST_RATIO { ", and probably another one after it" } else { "" };
    let changes: Vec<String> = best.next.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let sentence = format!(
        "A finer mesh of family {} would help: about {} cells ({}){cost}{more}. It has {meshes} meshes with a bar of {}; `durometer run \
         STUDY --extend` adds it and runs it.",
        family.name,
        thousands(cells),
        changes.join(", "),
        percent(best.bar)
    );
    let (family, member) = (family.name.clone(), label(cells));
    Some(NextMesh::New(Extension { family, member, set: best.next.set, cells, cost_s, sentence }))
}

/// A sentence, where the error of the time steps alone is above the tolerance.
fn limited_by_steps(q: &ByQuantity<MeshErrors>, tolerance: f64) -> Option<String> {
    if q.unresolved.is_some() {
        return Some("No finer mesh would help before the time steps are shorter.".into());
    }
    let (step, reference) = (q.step.as_ref()?, q.reference.as_ref()?);
    (step.error > q.quantity.tolerance(tolerance).allowed(reference.value)).then(|| {
        format!(
            "No finer mesh would help: the {} of the {} alone is {}; {}.",
            step.cause.words(),
            q.peak_title(),
            percent(step.error / reference.scale),
            match step.cause {
                StepCause::TimeStep => "shorten the steps",
                StepCause::Algebraic => "give numerics.accuracy a smaller value",
            }
        )
    })
}

/// Label of a member that is added with about so many cells.
fn label(cells: usize) -> String {
    format!("added-{cells}")
}

/// A family that can be refined.
struct Candidate<'a> {
    family: &'a FamilyRecord,
    /// Finest first, one record each
    meshes: Vec<&'a CaseRecord>,
    /// Largest bar of its finest mesh in the quantities without a verdict \[–\]
    bar: f64,
    /// Ratio of sizes by which the bar would meet the tolerance
    wanted: f64,
    next: Finer,
}

impl<'a> Candidate<'a> {
    fn new(cases: &Cases<'a>, family: &'a FamilyRecord, open: &[&ByQuantity<MeshErrors>]) -> Option<Self> {
        let mut meshes: Vec<&CaseRecord> = vec![];
        for c in cases.study.variants.iter().flat_map(|variant| cases.of(family, variant)) {
            if !meshes.iter().any(|m| m.has_mesh_of(&c.record)) {
                meshes.push(&c.record);
            }
        }
        meshes.sort_by(|a, b| a.mesh.h_m.total_cmp(&b.mesh.h_m));
        let [finest, second, ..] = meshes[..] else { return None };
        if locking::alarm(finest).is_some() {
            return None;
        }
        let (mut bar, mut wanted, mut all) = (0.0_f64, LEAST_RATIO, false);
        for q in open {
            let e = q.estimate(&family.name).filter(|e| !e.cuts_cells)?;
            let finest = e.cases.first()?;
            let own = q.errors.iter().find(|c| c.id == *finest).map_or(f64::INFINITY, |c| c.bar);
            bar = bar.max(own);
            wanted = wanted.max((own / (AIM * cases.study.tolerance)).powf(1.0 / order(e)));
            if let Some(cells) = e.wall_cells.first().filter(|_| !e.defensible) {
                wanted = wanted.max(2.0 / cells);
                all = true;
            }
            all |= e.keeps_length;
        }
        let ratio = wanted.clamp(LEAST_RATIO, MOST_RATIO);
        let next = Finer::new(second, finest, ratio, all)?;
        let is_hopeless = |q: &&ByQuantity<MeshErrors>| {
            let allowed = |e: &Estimate| q.quantity.tolerance(cases.study.tolerance).allowed(e.extrapolated);
            q.estimate(&family.name).is_some_and(|e| left_by(e, ratio) > allowed(e))
        };
        if open.iter().any(is_hopeless) {
            return None;
        }
        bar.is_finite().then_some(Self { family, meshes, bar, wanted, next })
    }

    /// A sentence, where the family has the next mesh already: it has no usable result, or it would be the finest one.
    fn tried(&self, cases: &Cases) -> Option<String> {
        let label = label(self.next.cells);
        let is_next = |c: &&StoredCase| {
            let of_family = c.is_of_family(&self.family.name) && !c.record.converged();
            let keys = of_family.then(|| mesh_keys(&c.record)).flatten();
            let sets = |keys: &BTreeMap<String, Value>| {
                let mut all = self.next.set.iter();
                all.all(|(key, value)| key.strip_prefix("mesh.").and_then(|key| keys.get(key)) == Some(value))
            };
            keys.is_some_and(|keys| sets(&keys))
        };
        let end = format!("-{label}");
        let (case, why) = match cases.stored.iter().find(is_next) {
            Some(c) => {
                let detail = c.record.status_detail.as_ref().map_or(String::new(), |why| format!(": {why}"));
                (&c.record.id, format!("{}{detail}", c.record.status))
            }
            None => (self.family.cases.iter().find(|id| id.ends_with(&end))?, NOT_RUN.to_string()),
        };
        let cells = thousands(self.next.cells);
        Some(format!(
            "The mesh of family {} that would help, about {cells} cells, is case {case}: {why}.",
            self.family.name
        ))
    }

    fn cost(&self, cases: &Cases) -> Option<Predicted> {
        let points: Vec<(f64, f64)> = self.meshes.iter().map(|m| (m.mesh.cells as f64, cases.cost(m))).collect();
        growth(&points).map(|law| law.predict(self.next.cells as f64))
    }
}

/// The least U(f*) of an oscillating family with one more mesh: the differences of those that it has remain.
fn left_by(e: &Estimate, ratio: f64) -> f64 {
    if e.class != Convergence::Oscillatory {
        return 0.0;
    }
    let with = |first: f64, rest: &[f64]| [&[first], rest].concat();
    let (h, f) = (with(e.h_m[0] / ratio, &e.h_m), with(e.values[0], &e.values));
    CAUTIOUS_FACTOR * oscillation(&h, &f)
}

/// Order by which the bar is expected to fall.
fn order(e: &Estimate) -> f64 {
    let usual = e.formal_order.min(2.0);
    e.observed_order.map_or(usual, |p| p.clamp(LEAST_ORDER, usual))
}

/// The changes that make a mesh finer than the finest of a family.
struct Finer {
    set: Table,
    cells: usize,
}

impl Finer {
    /// From the keys of `[mesh]` in which the two finest scenes differ. `all` also refines directions that the family leaves as they are.
    fn new(second: &CaseRecord, finest: &CaseRecord, ratio: f64, all: bool) -> Option<Self> {
        let (coarse, fine) = (mesh_keys(second)?, mesh_keys(finest)?);
        let (mut set, mut factor) = (Table::new(), 1.0);
        for (key, value) in fine.iter().filter(|(key, value)| coarse.get(*key) != Some(value)) {
            let name = key.rsplit('.').next().unwrap_or(key);
            let new = match (name, value) {
                ("seed", same) => same.clone(),
                ("levels", Value::Integer(n)) => {
                    factor *= 8.0;
                    Value::Integer(n + 1)
                }
                ("cells", Value::Integer(n)) => {
                    factor *= ratio.powi(3);
                    Value::Integer(round(*n as f64 * ratio.powi(3)) as i64)
                }
                ("divisions", Value::Array(now)) => {
                    let before = coarse.get(key).and_then(Value::as_array);
                    let (new, more) = divided(now, before, all, ratio)?;
                    factor *= more;
                    new
                }
                ("size", Value::String(length)) => {
                    let (number, unit, ..) = units::parts(length).ok()?;
                    factor *= ratio.powi(3);
                    Value::String(format!("{} {unit}", round(number / ratio)))
                }
                _ => return None,
            };
            set.insert(format!("mesh.{key}"), new);
        }
        (factor > 1.0).then(|| Self { set, cells: round(finest.mesh.cells as f64 * factor) as usize })
    }
}

/// Numbers of boxes times the ratio, in `all` directions or those in which they differ from the numbers `before`, and the factor on their product.
/// Where the two meshes have the same proportions, the next one has them too and the ratio is at least this one; otherwise nearly.
fn divided(now: &[Value], before: Option<&Vec<Value>>, all: bool, ratio: f64) -> Option<(Value, f64)> {
    let numbers = |list: &[Value]| list.iter().map(Value::as_integer).collect::<Option<Vec<i64>>>();
    let now = numbers(now)?;
    let before = before.and_then(|list| numbers(list)).filter(|list| list.len() == now.len());
    let is_left = |k: usize| !all && before.as_ref().is_some_and(|b| b[k] == now[k]);
    let refined: Vec<usize> = (0..now.len()).filter(|k| !is_left(*k)).collect();
    let pair = |k: usize| before.as_ref().map(|b| (now[k], b[k]));
    let proportional = |w: &[usize]| pair(w[0]).zip(pair(w[1])).is_some_and(|((a, b), (c, d))| a * d == b * c);
    let scale = if refined.windows(2).all(proportional) {
        let common = refined.iter().fold(0, |g, k| greatest_common_divisor(g, now[*k])) as f64;
        // A product that is whole but for rounding is not rounded up
        (common * ratio - 1e-9).ceil() / common
    } else {
        ratio
    };
    let finer = |n: i64| ((n as f64 * scale).round() as i64).max(n + 1);
    let new: Vec<i64> = (0..now.len()).map(|k| if is_left(k) { now[k] } else { finer(now[k]) }).collect();
    let factor = new.iter().zip(&now).map(|(m, n)| *m as f64 / *n as f64).product();
    Some((Value::from(new), factor))
}

fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Three significant digits.
fn round(x: f64) -> f64 {
    let unit = 10f64.powf(x.abs().log10().floor() - 2.0);
    let rounded = (x / unit).round() * unit;
    // Powers of ten below one are not exact
    if unit < 1.0 { (rounded / unit).round() / (1.0 / unit).round() } else { rounded }
}

/// The keys of `[mesh]` of a case, dotted.
fn mesh_keys(case: &CaseRecord) -> Option<BTreeMap<String, Value>> {
    let scene: Table = case.provenance.scene.parse().ok()?;
    let mut keys = BTreeMap::new();
    flatten("", scene.get("mesh")?.as_table()?, &mut keys);
    // A level of zero may be left out
    keys.entry("levels".into()).or_insert(Value::Integer(0));
    Some(keys)
}

fn flatten(prefix: &str, table: &Table, keys: &mut BTreeMap<String, Value>) {
    for (key, value) in table {
        match value {
            Value::Table(inner) => flatten(&format!("{prefix}{key}."), inner, keys),
            leaf => drop(keys.insert(format!("{prefix}{key}"), leaf.clone())),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(mesh: &str, cells: usize) -> CaseRecord {
        let mut c = CaseRecord::default();
        c.provenance.scene = format!("[mesh]\n{mesh}\n");
        c.mesh.cells = cells;
        c
    }

    fn next(second: &str, finest: &str, ratio: f64, all: bool) -> Option<(String, usize)> {
        let found = Finer::new(&case(second, 500), &case(finest, 1000), ratio, all)?;
        Some((toml::to_string(&found.set).expect("a table").trim().to_string(), found.cells))
    }

    #[test]
    fn a_finer_grid_has_the_proportions_of_its_family() {
        let grid = |n: &str| format!("grid = {{ kind = \"box\", divisions = {n} }}");
        for (second, finest, ratio, expected) in [
            ("[18, 3, 3]", "[24, 4, 4]", 1.3, "[36, 6, 6]"),
            ("[18, 3, 3]", "[24, 4, 4]", 1.25, "[30, 5, 5]"),
            ("[20, 10, 5]", "[40, 20, 10]", 1.3, "[52, 26, 13]"),
            ("[4, 1, 1]", "[8, 2, 2]", 2.0, "[16, 4, 4]"),
            ("[8, 4, 2]", "[16, 8, 2]", 1.3, "[22, 11, 2]"),
            // Members of other proportions: the nearest numbers, and none that stays
            ("[3, 5, 2]", "[5, 7, 3]", 1.4, "[7, 10, 4]"),
            ("[8, 2, 1]", "[16, 3, 2]", 1.3, "[21, 4, 3]"),
        ] {
            let (set, _) = next(&grid(second), &grid(finest), ratio, false).expect("a finer mesh");
            assert_eq!(set, format!("\"mesh.grid.divisions\" = {expected}"), "{second} {finest} {ratio}");
        }
    }

    #[test]
    fn the_keys_that_set_the_size_are_continued() {
        let of = |a: &str, b: &str| next(a, b, 1.5, false).expect("a finer mesh");
        assert_eq!(of("cells = 500", "cells = 1000"), ("\"mesh.cells\" = 3380".into(), 3380));
        assert_eq!(of("cells = 9", "cells = 9\nlevels = 1"), ("\"mesh.levels\" = 2".into(), 8000));
        assert_eq!(of("size = \"2 mm\"", "size = \"1.5 mm\""), ("\"mesh.size\" = \"1 mm\"".into(), 3380));
        assert_eq!(of("size = \"4e-3 m\"", "size = \"3e-3m\"").0, "\"mesh.size\" = \"0.002 m\"");
        let grid = |n: &str| format!("grid = {{ kind = \"box\", divisions = {n} }}");
        let (set, cells) = of(&grid("[4, 6, 1]"), &grid("[6, 9, 1]"));
        assert_eq!((set.as_str(), cells), ("\"mesh.grid.divisions\" = [10, 15, 1]", 2780));
        let thick = next(&grid("[4, 6, 1]"), &grid("[6, 9, 1]"), 2.0, true).expect("a finer mesh");
        assert_eq!(thick, ("\"mesh.grid.divisions\" = [12, 18, 2]".into(), 8000));
        assert!(next("file = \"a.msh\"", "file = \"b.msh\"", 1.5, false).is_none(), "files cannot be continued");
        assert!(next("seed = 1", "seed = 2", 1.5, false).is_none(), "another seed is no finer mesh");
    }
}
