//! Regions of a scene: the regions of the mesh, the whole surface, and the regions that the file defines by selectors.

use crate::mesh::boundary::boundary_facets;
use crate::mesh::{Region, TetMesh};
use crate::scene::error::{SceneError, hint};
use crate::scene::parts::selectors::{Ground, Refusal, SelectorSpec, region_of};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// All regions by name, with notes on those whose position is in doubt. The regions of the file may be made of other regions in any order; all that cannot be
/// found are refused together. `levels`: how often the cells of a volume mesh from a file were split, as in [`Ground`].
pub(in crate::scene) fn regions(
    file: &Path,
    (mesh, levels): (&TetMesh, Option<u32>),
    specs: &BTreeMap<String, SelectorSpec>,
) -> Result<(BTreeMap<String, Region>, Vec<String>), SceneError> {
    let mut doubts = Vec::new();
    let mut known = mesh.regions.clone();
    known.entry("skin".into()).or_insert_with(|| Region { facets: boundary_facets(mesh), ..Region::default() });
    let mut refused: BTreeMap<&str, Refusal> = BTreeMap::new();
    for name in mesh.regions.keys().chain(specs.keys()).filter(|name| !is_printable(name)) {
        refused
            .insert(name, Refusal::new("its name cannot be printed", "use letters, digits, signs and single spaces"));
    }
    for name in specs.keys().filter(|name| known.contains_key(*name)) {
        let fact = match mesh.regions.contains_key(name) {
            true => "the mesh has a region of this name",
            false => "\"skin\" is the name of the whole surface",
        };
        refused.insert(name, Refusal::new(fact, "choose another name"));
    }
    let names: Vec<&String> = known.keys().chain(specs.keys()).collect();
    for (name, spec) in specs {
        if let Some(other) = spec.part().of().iter().find(|other| !names.contains(other)) {
            let others: Vec<&String> = names.iter().copied().filter(|other| *other != name).collect();
            let refusal = Refusal::new(format!("there is no region \"{other}\""), hint(other, &others));
            refused.entry(name).or_insert(refusal);
        }
    }
    for path in cycles(specs) {
        let fact = format!("it is made of itself: {}", path.join(" of "));
        refused.entry(path[0]).or_insert(Refusal::new(fact, "break the circle"));
    }
    let base = file.parent().unwrap_or(Path::new(""));
    let is_known = |known: &BTreeMap<String, Region>, spec: &SelectorSpec| {
        spec.part().of().iter().all(|other| known.contains_key(other))
    };
    // A region that is made of a refused one is not reported: the reason is given once
    let mut open: Vec<(&String, &SelectorSpec)> =
        specs.iter().filter(|(name, _)| !refused.contains_key(name.as_str())).collect();
    while let Some(k) = open.iter().position(|(_, spec)| is_known(&known, spec)) {
        let (name, spec) = open.remove(k);
        match region_of(spec.part(), &Ground { mesh, levels, base, regions: &known }) {
            Ok((region, note)) => {
                known.insert(name.clone(), region);
                doubts.extend(note.map(|note| format!("region {name}: {note}")));
            }
            Err(refusal) => _ = refused.insert(name, refusal),
        }
    }
    match refused.is_empty() {
        true => Ok((known, doubts)),
        false => Err(all(file, &refused)),
    }
}

/// Whether a name can be part of a column, a message and a report: it has no control characters.
fn is_printable(name: &str) -> bool {
    !name.trim().is_empty() && !name.chars().any(char::is_control)
}

/// Notes on regions whose extent changes with the mesh.
pub(in crate::scene) fn notes(
    regions: &BTreeMap<String, Region>,
    specs: &BTreeMap<String, SelectorSpec>,
) -> Vec<String> {
    let depends = |name: &&String| regions.get(*name).is_some_and(|r| r.depends_on_mesh);
    let note = |name| {
        format!(
            "region {name} is picked by a selector whose border runs through cells: its extent changes with the mesh (O(h))"
        )
    };
    specs.keys().filter(depends).map(note).collect()
}

/// One error for all refused regions.
fn all(file: &Path, refused: &BTreeMap<&str, Refusal>) -> SceneError {
    let file = file.into();
    if let (1, Some((name, Refusal { fact, remedy }))) = (refused.len(), refused.first_key_value()) {
        let (place, fact, remedy) = (format!("mesh.regions.{}", name.escape_debug()), fact.clone(), remedy.clone());
        return SceneError::Content { file, place, fact, remedy };
    }
    let lines: Vec<String> = refused
        .iter()
        .map(|(name, Refusal { fact, remedy })| format!("\n  {}: {fact}; {remedy}", name.escape_debug()))
        .collect();
    let (place, fact) = ("mesh.regions".into(), format!("{} regions are refused", refused.len()));
    SceneError::Content { file, place, fact, remedy: format!("correct each of them{}", lines.concat()) }
}

/// Cycles of definitions, each listed once: a, b, a.
fn cycles(specs: &BTreeMap<String, SelectorSpec>) -> Vec<Vec<&str>> {
    let (mut found, mut done) = (Vec::new(), BTreeSet::new());
    for name in specs.keys() {
        follow(specs, &mut vec![name], &mut done, &mut found);
    }
    found
}

fn follow<'a>(
    specs: &'a BTreeMap<String, SelectorSpec>,
    path: &mut Vec<&'a str>,
    done: &mut BTreeSet<&'a str>,
    found: &mut Vec<Vec<&'a str>>,
) {
    let name = path[path.len() - 1];
    let of = specs.get(name).filter(|_| !done.contains(name)).map_or(&[][..], |spec| spec.part().of());
    for other in of {
        if let Some(start) = path.iter().position(|known| known == other) {
            found.push(path[start..].iter().copied().chain([other.as_str()]).collect());
            continue;
        }
        path.push(other);
        follow(specs, path, done, found);
        path.pop();
    }
    done.insert(name);
}
