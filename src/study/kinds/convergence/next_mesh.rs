//! The mesh that would support a verdict if the present evidence does not, and its cost.
//!
//! The family whose bars are nearest to the tolerance is refined. Families are excluded if they lock, have an objection that no mesh removes (a
//! region whose border runs through cells, a value that may have no limit), or oscillate, or scatter between seeds, by more than the tolerance
//! whatever the next value is. The next size follows from the finest and the second finest scene, whose `[mesh]` tables differ in the keys that set
//! the size. The ratio of sizes is the one that brings the largest bar to the tolerance by the observed order (2 if there is none), limited to 1.3 to
//! 2; a larger ratio takes another step. A grid keeps the proportions of its family, and the number of its cells follows from its kind. The cost
//! comes from the power law through the means over the variants of the family.

use crate::math::units;
use crate::report::numbers::{percent, seconds, thousands};
use crate::scene::spec::GridSpec;
use crate::scene::{MeshSpec, from_text};
use crate::scene::{cells_of_grid, common_divisor, divisions_of_grid, divisions_value, grid_with_divisions};
use crate::study::analysis::ByQuantity;
use crate::study::estimate::family::{Estimate, oscillation};
use crate::study::estimate::method::Method;
use crate::study::estimate::power_law::{Predicted, power_law};
use crate::study::estimate::richardson::{CAUTIOUS_FACTOR, Convergence, LEAST_ORDER, LEAST_RATIO};
use crate::study::extension::{ADD, Extension};
use crate::study::kinds::convergence::cases::Cases;
use crate::study::kinds::convergence::errors::StepCause;
use crate::study::kinds::convergence::findings::MeshErrors;
use crate::study::locking;
use crate::study::store::record::{CaseRecord, FamilyRecord, NOT_RUN, Role, StoredCase};
use std::collections::BTreeMap;
use std::path::Path;
use toml::{Table, Value};

/// Largest ratio of sizes between successive meshes.
const MOST_RATIO: f64 = 2.0;
/// Fraction of the tolerance that the next mesh aims at.
const AIM: f64 = 0.8;

/// The mesh that would help.
#[derive(Clone, Debug, PartialEq)]
pub enum NextMesh {
    /// A mesh that the study does not have yet
    New(Extension),
    /// The reason, in words, why no mesh helps or why the family already has the mesh without a usable result
    OfNoUse(String),
}

impl NextMesh {
    /// Returns the advice in words: which mesh, and why.
    pub fn sentence(&self) -> &str {
        match self {
            Self::New(extension) => &extension.sentence,
            Self::OfNoUse(sentence) => sentence,
        }
    }

    /// Returns the mesh to add.
    pub fn extension(self) -> Option<Extension> {
        match self {
            Self::New(extension) => Some(extension),
            Self::OfNoUse(_) => None,
        }
    }
}

/// Returns the mesh that would help if there is no verdict; `None` if no family can be refined through its keys, if a quantity near zero first needs
/// an absolute tolerance, or if a reason remains that no mesh removes.
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
    let cost_s = best.cost();
    let cost = cost_s.map_or(String::new(), |p| {
        // With three meshes the interval may extend over decades
        let known = p.interval.filter(|[low, high]| *high < 100.0 * low);
        let interval = known.map_or(String::new(), |[a, b]| format!(" (95 %: {} to {})", seconds(a), seconds(b)));
        let over = if best.meshes[0].len() > 1 { " on average over the variants" } else { "" };
        format!(", {} per case{over} by the law of growth{interval}", seconds(p.value))
    });
    let more = if best.wanted > MOST_RATIO { ", and probably another one after it" } else { "" };
    let changes: Vec<String> = best.next.set.iter().map(|(key, value)| format!("{key} = {value}")).collect();
    let bar = percent(best.bar);
    let has = match best.bar <= cases.study.tolerance {
        true => format!("{meshes} meshes, whose bar of {bar} is no claim for the reasons above"),
        false => format!("{meshes} meshes with a bar of {bar}"),
    };
    let sentence = format!(
        "A finer mesh of family {} would help: about {} cells ({}){cost}{more}. It has {has}; `{ADD}` adds it and runs it.",
        family.name,
        thousands(cells),
        changes.join(", "),
    );
    let (family, member) = (family.name.clone(), label(cells));
    Some(NextMesh::New(Extension { family, member, set: best.next.set, cells, cost_s, sentence }))
}

/// A sentence if the error of the time steps alone exceeds the tolerance.
fn limited_by_steps(q: &ByQuantity<MeshErrors>, tolerance: f64) -> Option<String> {
    if q.unresolved.is_some() || q.is_missed {
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

/// The label of an added member with about `cells` cells.
fn label(cells: usize) -> String {
    format!("added-{cells}")
}

/// A family that can be refined.
struct Candidate<'a> {
    family: &'a FamilyRecord,
    /// Runs of each mesh in all variants, finest mesh first
    meshes: Vec<Vec<&'a CaseRecord>>,
    /// Largest bar of its finest mesh among the quantities without a verdict \[–\]
    bar: f64,
    /// Ratio of sizes at which the bar would meet the tolerance
    wanted: f64,
    next: Finer,
}

impl<'a> Candidate<'a> {
    fn new(cases: &Cases<'a>, family: &'a FamilyRecord, open: &[&ByQuantity<MeshErrors>]) -> Option<Self> {
        let mut meshes: Vec<Vec<&CaseRecord>> = vec![];
        for c in cases.study.variants.iter().flat_map(|variant| cases.of(family, variant)) {
            match meshes.iter_mut().find(|runs| runs[0].has_mesh_of(&c.record)) {
                Some(runs) => runs.push(&c.record),
                None => meshes.push(vec![&c.record]),
            }
        }
        meshes.sort_by(|a, b| a[0].mesh.h_m.total_cmp(&b[0].mesh.h_m));
        let [finest, second, ..] = &meshes[..] else { return None };
        if finest.iter().any(|c| locking::alarm(c).is_some()) {
            return None;
        }
        let (mut bar, mut wanted, mut all) = (0.0_f64, LEAST_RATIO, false);
        for q in open {
            let e = q.estimate(&family.name).filter(|e| !e.lasting)?;
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
        let next = Finer::new(second[0], finest[0], ratio, all)?;
        let is_hopeless = |q: &&ByQuantity<MeshErrors>| {
            let allowed = |e: &Estimate| q.quantity.tolerance(cases.study.tolerance).allowed(e.extrapolated);
            let noise = |e: &Estimate| q.noise.iter().find(|n| n.formulation == e.formulation).map(|n| n.half_width);
            q.estimate(&family.name).is_some_and(|e| left_by(e, noise(e), ratio) > allowed(e))
        };
        if open.iter().any(is_hopeless) {
            return None;
        }
        bar.is_finite().then_some(Self { family, meshes, bar, wanted, next })
    }

    /// A sentence if the family already has the next mesh, because that has no usable result or would be the finest one.
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

    /// Mean CPU time of a case over the variants \[s\].
    fn cost(&self) -> Option<Predicted> {
        let mean = |runs: &[&CaseRecord]| runs.iter().map(|c| c.cpu_s).sum::<f64>() / runs.len() as f64;
        let points: Vec<(f64, f64)> = self.meshes.iter().map(|m| (m[0].mesh.cells as f64, mean(m))).collect();
        power_law(&points).map(|law| law.predict(self.next.cells as f64))
    }
}

/// The smallest U(f*) that a family with one more mesh can have: if it oscillates, its present differences remain, as does noise between seeds that
/// exceeds the difference of its two finest meshes.
fn left_by(e: &Estimate, noise: Option<f64>, ratio: f64) -> f64 {
    let scatters = e.role != Role::Nested && e.class != Convergence::Exact;
    let remains = |s: &f64| scatters && *s > (e.values[0] - e.values[1]).abs();
    let of_noise = CAUTIOUS_FACTOR * noise.filter(remains).unwrap_or(0.0);
    if e.class != Convergence::Oscillatory {
        return of_noise;
    }
    let with = |first: f64, rest: &[f64]| [&[first], rest].concat();
    let (h, f) = (with(e.h_m[0] / ratio, &e.h_m), with(e.values[0], &e.values));
    of_noise.max(CAUTIOUS_FACTOR * oscillation(&h, &f))
}

/// The order by which the bar is expected to fall; for two meshes, the order that their estimate assumes.
fn order(e: &Estimate) -> f64 {
    let usual = match e.method {
        Method::TwoMeshes { p } => p,
        _ => e.formal_order.min(2.0),
    };
    e.observed_order.map_or(usual, |p| p.clamp(LEAST_ORDER, usual))
}

/// The changes that make a mesh finer than the finest of a family.
struct Finer {
    set: Table,
    cells: usize,
}

impl Finer {
    /// Derives the changes from the keys of `[mesh]` in which the two finest scenes differ. `all` also refines directions that the family leaves
    /// unchanged.
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
                ("divisions", _) => {
                    let (now, before) = (grid_of(finest)?, grid_of(second)?);
                    let new = divided(&now, &before, all, ratio);
                    factor *= cells_of_grid(&new) / cells_of_grid(&now);
                    divisions_value(&new)
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

/// The grid with its divisions multiplied by the ratio, in `all` directions or only in those in which they differ from the grid `before`. If the two
/// grids have the same proportions, the next one keeps them as far as the grid allows, with at least this ratio; otherwise the ratio is met
/// approximately.
fn divided(now: &GridSpec, before: &GridSpec, all: bool, ratio: f64) -> GridSpec {
    let [own, before] = [now, before].map(divisions_of_grid);
    let is_left = |k: usize| !all && before[k] == own[k];
    let refined: Vec<usize> = (0..own.len()).filter(|k| !is_left(*k)).collect();
    let proportional = |w: &[usize]| own[w[0]] * before[w[1]] == before[w[0]] * own[w[1]];
    let scale = if refined.windows(2).all(proportional) {
        let common = common_divisor(refined.iter().map(|k| own[*k])) as f64;
        // A product that is a whole number up to rounding is not rounded up
        (common * ratio - 1e-9).ceil() / common
    } else {
        ratio
    };
    let finer = |n: f64| (n * scale).max(n + 1.0);
    let number = |k: usize| if is_left(k) { own[k] as f64 } else { finer(own[k] as f64) };
    grid_with_divisions(now, &(0..own.len()).map(number).collect::<Vec<_>>())
}

/// Rounds to three significant digits.
fn round(x: f64) -> f64 {
    let unit = 10f64.powf(x.abs().log10().floor() - 2.0);
    let rounded = (x / unit).round() * unit;
    // Powers of ten below one are not exact
    if unit < 1.0 { (rounded / unit).round() / (1.0 / unit).round() } else { rounded }
}

/// The table `[mesh]` of a case.
fn mesh_table(case: &CaseRecord) -> Option<Table> {
    let scene: Table = case.provenance.scene.parse().ok()?;
    scene.get("mesh")?.as_table().cloned()
}

fn grid_of(case: &CaseRecord) -> Option<GridSpec> {
    let text = toml::to_string(&mesh_table(case)?).ok()?;
    from_text::<MeshSpec>(Path::new(&case.id), &text, "").ok()?.grid
}

/// The keys of `[mesh]` of a case, dotted.
fn mesh_keys(case: &CaseRecord) -> Option<BTreeMap<String, Value>> {
    let mut keys = BTreeMap::new();
    flatten("", &mesh_table(case)?, &mut keys);
    // A level of zero may be omitted
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
    use crate::study::estimate::family::{Level, estimate};

    /// Seeds of one size say nothing about another: three times their noise remains on the next mesh if it exceeds the difference of the two finest,
    /// unless the meshes are nested.
    #[test]
    fn noise_of_the_seeds_remains_on_a_finer_mesh() {
        let levels = [(1.0, 1.0), (1.5, 1.01), (2.25, 1.05)].map(|(h, f)| Level { h, f, ..Level::default() });
        let left = |role: Role, noise: f64| {
            let e = estimate(("family", role, "tet4"), levels.to_vec(), Some(noise), 0.05).expect("three meshes");
            left_by(&e, Some(noise), 1.5)
        };
        let found = [left(Role::Sizes, 0.005), left(Role::Sizes, 0.02), left(Role::Nested, 0.02)];
        assert_eq!(found, [0.0, CAUTIOUS_FACTOR * 0.02, 0.0]);
    }

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

    fn of_box(divisions: &str) -> String {
        format!("grid = {{ kind = \"box\", size = [\"3 mm\", \"2 mm\", \"1 mm\"], divisions = {divisions} }}")
    }

    #[test]
    fn a_finer_grid_has_the_proportions_of_its_family() {
        for (second, finest, ratio, expected) in [
            ("[18, 3, 3]", "[24, 4, 4]", 1.3, "[36, 6, 6]"),
            ("[18, 3, 3]", "[24, 4, 4]", 1.25, "[30, 5, 5]"),
            ("[20, 10, 5]", "[40, 20, 10]", 1.3, "[52, 26, 13]"),
            ("[4, 1, 1]", "[8, 2, 2]", 2.0, "[16, 4, 4]"),
            ("[8, 4, 2]", "[16, 8, 2]", 1.3, "[22, 11, 2]"),
            // Members of other proportions: the nearest numbers, and every direction is refined
            ("[3, 5, 2]", "[5, 7, 3]", 1.4, "[7, 10, 4]"),
            ("[8, 2, 1]", "[16, 3, 2]", 1.3, "[21, 4, 3]"),
        ] {
            let (set, _) = next(&of_box(second), &of_box(finest), ratio, false).expect("a finer mesh");
            assert_eq!(set, format!("\"mesh.grid.divisions\" = {expected}"), "{second} {finest} {ratio}");
        }
    }

    /// The first division of an octant or a bracket counts in two directions, layers that grow count together, and a hole takes even numbers around
    /// it.
    #[test]
    fn cells_of_a_finer_grid_are_counted_by_its_kind() {
        let octant = "kind = \"octant\", inner = \"1 mm\", outer = \"2 mm\"";
        let bracket = "kind = \"bracket\", edge = \"2 mm\", thickness = \"1 mm\"";
        let ball = "kind = \"half_sphere\", radius = \"9 mm\", fine = \"1 mm\"";
        let hole = "kind = \"hole\", radius = \"1 mm\", half_edge = \"5 mm\", thickness = \"1 mm\"";
        for (kind, second, finest, ratio, all, expected) in [
            (bracket, "[3, 3]", "[4, 4]", 1.5, false, ("[6, 6]", 3380)),
            (octant, "[4, 2]", "[6, 3]", 2.0, false, ("[12, 6]", 8000)),
            (octant, "[4, 2]", "[6, 2]", 2.0, false, ("[12, 2]", 4000)),
            (ball, "[2, 3]", "[2, 4]", 2.0, false, ("[2, 8]", 4630)),
            (hole, "[4, 3, 1]", "[8, 6, 2]", 1.5, false, ("[12, 10, 3]", 3750)),
        ] {
            let grid = |n: &str| format!("grid = {{ {kind}, divisions = {n} }}");
            let (set, cells) = next(&grid(second), &grid(finest), ratio, all).expect("a finer mesh");
            assert_eq!((set, cells), (format!("\"mesh.grid.divisions\" = {}", expected.0), expected.1), "{kind}");
        }
    }

    #[test]
    fn the_keys_that_set_the_size_are_continued() {
        let of = |a: &str, b: &str| next(a, b, 1.5, false).expect("a finer mesh");
        assert_eq!(of("cells = 500", "cells = 1000"), ("\"mesh.cells\" = 3380".into(), 3380));
        assert_eq!(of("cells = 9", "cells = 9\nlevels = 1"), ("\"mesh.levels\" = 2".into(), 8000));
        assert_eq!(of("size = \"2 mm\"", "size = \"1.5 mm\""), ("\"mesh.size\" = \"1 mm\"".into(), 3380));
        assert_eq!(of("size = \"4e-3 m\"", "size = \"3e-3m\"").0, "\"mesh.size\" = \"0.002 m\"");
        let (set, cells) = of(&of_box("[4, 6, 1]"), &of_box("[6, 9, 1]"));
        assert_eq!((set.as_str(), cells), ("\"mesh.grid.divisions\" = [10, 15, 1]", 2780));
        let thick = next(&of_box("[4, 6, 1]"), &of_box("[6, 9, 1]"), 2.0, true).expect("a finer mesh");
        assert_eq!(thick, ("\"mesh.grid.divisions\" = [12, 18, 2]".into(), 8000));
        assert!(next("file = \"a.msh\"", "file = \"b.msh\"", 1.5, false).is_none(), "files cannot be continued");
        assert!(next("seed = 1", "seed = 2", 1.5, false).is_none(), "another seed is no finer mesh");
    }
}
