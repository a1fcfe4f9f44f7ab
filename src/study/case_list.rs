//! The cases of a study: one for each member of a family in each variant, and those that use the constants of a calibration.

use crate::scene::{SceneError, hint, read_scene};
use crate::study::calibration_plan::{CalibrationPlan, Member, UseSpec};
use crate::study::case::{After, Case};
use crate::study::extension::{AddedLines, at_line};
use crate::study::kind::StoredExpansion;
use crate::study::overridden::Differences;
use crate::study::spec::{FamilySpec, VariantSpec, check_names, refuse};
use crate::study::store::case_files::{MOST_BYTES, is_ambiguous};
use crate::study::store::record::{FamilyRecord, Role, VariantMember};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Keys of a scene and their values, in the order in which they are set.
type Pairs = [(String, toml::Value)];

/// Changes from the command line, made before or after those of the study, and members added to the study.
pub struct Changes<'a> {
    pub given: &'a Pairs,
    pub first: bool,
    pub added: Added,
}

/// Members that another file adds to the study.
#[derive(Default)]
pub struct Added {
    pub file: PathBuf,
    pub lines: AddedLines,
}

/// The list of cases while it is being built, family by family.
pub struct CaseList<'a> {
    file: &'a Path,
    scene: &'a Path,
    expansion: &'a StoredExpansion,
    changes: &'a Changes<'a>,
    all: Vec<Case>,
    ids: HashSet<String>,
    /// Variant with its task, if that matters, folder of the files that a scene names, and the scene → id of the case that runs it
    scenes: HashMap<(String, PathBuf, String), String>,
    differences: Differences,
}

impl<'a> CaseList<'a> {
    /// An empty list.
    pub fn new(file: &'a Path, scene: &'a Path, expansion: &'a StoredExpansion, changes: &'a Changes<'a>) -> Self {
        let (all, ids, scenes) = (vec![], HashSet::new(), HashMap::new());
        Self { file, scene, expansion, changes, all, ids, scenes, differences: Differences::default() }
    }

    /// Returns the cases, and the keys whose differences between cases are overridden.
    pub fn end(self) -> (Vec<Case>, Vec<String>) {
        (self.all, self.differences.overridden())
    }

    /// The file that defines a member of a family, and the location of the member in it.
    fn origin(&self, family: &FamilySpec, label: &str, place: &str) -> (&Path, String) {
        let Added { file, lines } = &self.changes.added;
        match lines.get(&(family.name.clone(), label.into())) {
            Some(line) => (file, at_line(Some(line), place)),
            None => (self.file, place.into()),
        }
    }

    /// An error about a member of a family, located in the file that defines the member.
    fn refuse(&self, (family, label): (&FamilySpec, &str), place: &str, (fact, remedy): (String, &str)) -> SceneError {
        let (file, place) = self.origin(family, label, place);
        refuse(file, (place, fact, remedy.into()))
    }

    /// Adds the cases of a family.
    pub fn family(&mut self, family: &FamilySpec) -> Result<FamilyRecord, SceneError> {
        let base = self.file.parent().unwrap_or(Path::new(""));
        let expansion = self.expansion;
        let known: Vec<String> = expansion.variants.iter().map(|v| v.name.clone()).collect();
        let wanted = family.variants.as_ref().unwrap_or(&known);
        if let Some(unknown) = wanted.iter().find(|w| !known.contains(w)) {
            let fact = format!("there is no variant \"{unknown}\"");
            return Err(refuse(self.file, (format!("family {}", family.name), fact, hint(unknown, &known))));
        }
        self.check_family(family, wanted)?;
        let (mut ids, mut places) = (Vec::new(), Vec::new());
        let mut formulation = String::new();
        for variant in expansion.variants.iter().filter(|v| wanted.contains(&v.name)) {
            let own = variant.scene.as_ref().or(family.scene.as_ref());
            let scene_file = own.map_or_else(|| self.scene.to_path_buf(), |own| base.join(own));
            // Changes of the preceding members, if they accumulate
            let mut before: Vec<(String, toml::Value)> = Vec::new();
            let members: Vec<(&String, &toml::Value)> =
                family.members.iter().chain(family.own.get(&variant.name).into_iter().flatten()).collect();
            let labels: Vec<String> = members.iter().map(|(label, _)| (*label).clone()).collect();
            let place = format!("family {}: members", family.name);
            check_names(&labels)
                .map_err(|(k, fact, remedy)| self.refuse((family, &labels[k]), &place, (fact, remedy)))?;
            for (label, member) in members {
                let place = format!("family {}, member {label}, variant {}", family.name, variant.name);
                let Some(member) = member.as_table() else {
                    return Err(self.refuse((family, label), &place, ("it is not a table".into(), AS_TABLE)));
                };
                let pairs = |set: &toml::Table| set.clone().into_iter().collect::<Vec<_>>();
                let others = [pairs(&variant.set), pairs(&family.set), before.clone()].concat();
                if family.role == Role::Cumulative {
                    before.extend(pairs(member));
                }
                let (id, found) =
                    self.case((family, variant, label), &scene_file, (&others, &pairs(member)), &place)?;
                ids.push(id);
                places.push(VariantMember { variant: variant.name.clone(), member: label.clone() });
                formulation = found;
            }
        }
        Ok(FamilyRecord { name: family.name.clone(), role: family.role, formulation, cases: ids, members: places })
    }

    /// Refuses a family without a variant, and labels for members that it does not have.
    fn check_family(&self, family: &FamilySpec, wanted: &[String]) -> Result<(), SceneError> {
        let place = format!("family {}", family.name);
        if wanted.is_empty() {
            let fact = "it is run in no variant".into();
            return Err(refuse(self.file, (place, fact, "name its variants, or leave `variants` out for all".into())));
        }
        let own = family.own.values().flat_map(toml::Table::keys);
        let members: Vec<String> = family.members.keys().chain(own).cloned().collect();
        match family.labels.keys().find(|label| !members.contains(label)) {
            None => Ok(()),
            Some(label) => {
                let fact = format!("labels: there is no member \"{label}\"");
                Err(refuse(self.file, (place, fact, hint(label, &members))))
            }
        }
    }

    /// Returns the id and formulation of a case, which is new unless the same scene is already run.
    fn case(
        &mut self,
        (family, variant, label): (&FamilySpec, &VariantSpec, &String),
        scene_file: &Path,
        (others, member): (&Pairs, &Pairs),
        place: &str,
    ) -> Result<(String, String), SceneError> {
        let (given, own) = (self.changes.given, &[others, member].concat()[..]);
        let all = if self.changes.first { [given, own] } else { [own, given] }.concat();
        let (spec, text) = read_scene(scene_file, &all).map_err(|e| {
            // The study is at fault if the scene alone is valid and becomes invalid by the changes of the study; the file that defines the member is at
            // fault if the scene with the other changes is valid.
            let sound = |changes: &[_]| read_scene(scene_file, changes).is_ok();
            match sound(&[]) && !sound(own) {
                true if sound(others) => {
                    let (file, place) = self.origin(family, label, place);
                    e.caused_by(file, &place)
                }
                true => e.caused_by(self.file, place),
                false => e,
            }
        })?;
        if !self.changes.first {
            self.differences.add(scene_file, own, given);
        }
        let formulation = spec.formulation();
        let expansion = self.expansion;
        let plan = self.plan((family, variant, label), scene_file, member, place)?;
        // Calibrations and derivatives belong to one variant
        let of_variant = plan.as_ref().map(|p| p.sha256.as_str());
        let of_variant = of_variant.or_else(|| expansion.derivatives.contains_key(&variant.name).then_some(""));
        let asked = of_variant.map_or_else(String::new, |sha256| format!("{} {sha256}", variant.name));
        let folder = scene_file.parent().unwrap_or(Path::new("")).to_path_buf();
        let scene = (asked, folder, text.clone());
        if let Some(same) = self.scenes.get(&scene).filter(|_| expansion.rules.share_cases) {
            return Ok((same.clone(), formulation));
        }
        let id = format!("{}-{}-{label}", family.name, variant.name);
        let derivatives = match family.role {
            Role::Design => expansion.derivatives.get(&variant.name).cloned().unwrap_or_default(),
            _ => vec![],
        };
        if !self.ids.insert(id.clone()) {
            let fact = format!("another case is called {id} too");
            let remedy = "rename the family, the variant or the member";
            return Err(self.refuse((family, label), place, (fact, remedy)));
        }
        check_id(&id).map_err(|mistake| self.refuse((family, label), place, mistake))?;
        self.scenes.entry(scene).or_insert_with(|| id.clone());
        self.all.push(Case {
            id: id.clone(),
            family: family.name.clone(),
            variant: variant.name.clone(),
            member: label.clone(),
            scene_file: scene_file.to_path_buf(),
            spec,
            text,
            plan,
            after: None,
            derivatives,
        });
        Ok((id, formulation))
    }

    /// The constants to find in the case of a member.
    fn plan(
        &self,
        (family, variant, label): (&FamilySpec, &VariantSpec, &String),
        scene_file: &Path,
        own: &Pairs,
        place: &str,
    ) -> Result<Option<Arc<CalibrationPlan>>, SceneError> {
        let Some(plan) = self.expansion.plans.get(&variant.name) else { return Ok(None) };
        let set: Vec<_> = family.set.clone().into_iter().collect();
        let member = Member { scene_file, label, family: &set, own, given: self.changes.given };
        plan.of(&member).map(Some).map_err(|e| {
            let (file, place) = self.origin(family, label, place);
            SceneError::Part { file: file.into(), place, source: e.into() }
        })
    }

    /// Adds the cases of `[use]`, one per variant and member.
    pub fn uses(&mut self, usage: &UseSpec) -> Result<FamilyRecord, SceneError> {
        let (file, given, expansion) = (self.file, self.changes.given, self.expansion);
        let mistake = |fact: String, remedy: &str| refuse(file, ("use".into(), fact, remedy.into()));
        let scene_file = file.parent().unwrap_or(Path::new("")).join(&usage.scene);
        let labels: Vec<String> = usage.members.keys().cloned().collect();
        check_names(&labels).map_err(|(_, fact, remedy)| mistake(fact, remedy))?;
        let (mut ids, mut members, mut formulation) = (vec![], vec![], None);
        for variant in expansion.variants.iter().map(|v| &v.name) {
            for (label, member) in &usage.members {
                let Some(member) = member.as_table() else {
                    return Err(mistake(format!("member {label} is not a table"), AS_TABLE));
                };
                let own = [&usage.set, member].into_iter().flatten().map(|(k, v)| (k.clone(), v.clone()));
                let own: Vec<_> = own.collect();
                let (spec, text) = read_scene(&scene_file, &[&own, given].concat())?;
                self.differences.add(&scene_file, &own, given);
                if !spec.laws.contains_key(&usage.law) {
                    let known: Vec<&String> = spec.laws.keys().collect();
                    return Err(mistake(format!("its scene has no law \"{}\"", usage.law), &hint(&usage.law, &known)));
                }
                let after = Some(After { variant: variant.clone(), law: usage.law.clone() });
                let (id, variant) = (format!("use-{variant}-{label}"), format!("use-{variant}"));
                check_id(&id).map_err(|(fact, remedy)| mistake(fact, remedy))?;
                ids.push(id.clone());
                members.push(VariantMember { variant: variant.clone(), member: label.clone() });
                formulation.get_or_insert_with(|| spec.formulation());
                let (family, member, scene_file) = ("use".into(), label.clone(), scene_file.clone());
                let (plan, derivatives) = (None, vec![]);
                self.all.push(Case { id, family, variant, member, scene_file, spec, text, plan, after, derivatives });
            }
        }
        let Some(formulation) = formulation else {
            return Err(mistake(
                "it has no member".into(),
                "add [use.members] with one mesh at least, two for its share",
            ));
        };
        Ok(FamilyRecord { name: "use".into(), role: Role::Use, formulation, cases: ids, members })
    }
}

/// Remedy for a member that is not a table.
const AS_TABLE: &str = "write { \"mesh.cells\" = 4500 }";

/// Refuses an id whose files would be mistaken for those of another case, or whose file names are not allowed; returns fact and remedy.
fn check_id(id: &str) -> Result<(), (String, &'static str)> {
    if id.len() > MOST_BYTES {
        let (begin, bytes): (String, _) = (id.chars().take(40).collect(), id.len());
        let fact = format!(
            "the id of case {begin}… has {bytes} bytes, and an id, which names files, has {MOST_BYTES} at most"
        );
        return Err((fact, "shorten the names of family, variant or member, which make it up"));
    }
    if !is_ambiguous(id) {
        return Ok(());
    }
    let fact = format!("the files of case {id} would have the names of files of another case");
    Err((fact, "rename it without the end behind the last dot, or write a hyphen for the dot"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_is_refused_before_its_files_cannot_be_named() {
        assert!(check_id(&"é".repeat(MOST_BYTES / 2)).is_ok());
        let (fact, _) = check_id(&"é".repeat(MOST_BYTES / 2 + 1)).expect_err("too long");
        assert!(fact.contains("has 182 bytes"), "{fact}");
        assert!(check_id("b.fit").is_err());
    }
}
