//! The variants, families and plan of a validation, read from the study file, with all mistakes in it.
//!
//! All cases of the [design](super::design) have derivatives by unknowns, by inputs, and by constants of [law files](super::law_files).

use crate::scene::column;
use crate::scene::{ParameterKey, SceneError, SceneSpec, from_text, hint, read_scene, unit_of_column};
use crate::study::kind::{Expansion, RunRules};
use crate::study::kinds::validation::constants::{record, unknown, without_use};
use crate::study::kinds::validation::design::cases;
use crate::study::kinds::validation::field::{Errors, Field};
use crate::study::kinds::validation::law_files::with_inputs;
use crate::study::kinds::validation::plan::{FamilyPlan, InputPlan, QuantityPlan, RecordPlan, ValidationPlan};
use crate::study::kinds::validation::quantities::Sources;
use crate::study::kinds::validation::spec::{Purpose, QuantitySpec, RecordSpec, ValidationStudy};
use crate::study::kinds::validation::tracks::RecordTracks;
use crate::study::spec::{FamilySpec, VariantSpec, refuse};
use crate::study::store::record::StudyQuantity;
use crate::wording::count;
use std::collections::BTreeMap;
use std::path::Path;

/// Returns the variants, the families and the plan of a validation in a study file.
pub fn expand(study: &ValidationStudy, file: &Path, scene: &Path) -> Result<Expansion<ValidationPlan>, SceneError> {
    let (specs, scenes): (Vec<SceneSpec>, Vec<toml::Table>) = scenes(study, file, scene)?.into_iter().unzip();
    let mut builder = Builder { study, file, wrong: vec![], probes: BTreeMap::new(), scenes };
    let plan = builder.plan();
    if !builder.wrong.is_empty() {
        let fact = format!("{}: {}", count(builder.wrong.len(), "mistake"), builder.wrong.join("; "));
        return Err(refuse(file, ("validation".into(), fact, "correct them".into())));
    }
    let mut derivatives = BTreeMap::new();
    for r in &plan.records {
        let keys = r.keys(&plan.unknowns).iter().map(|k| k.parse()).collect::<Result<Vec<ParameterKey>, _>>();
        let keys = keys.map_err(|e| SceneError::Part {
            file: file.into(),
            place: format!("record {}", r.name),
            source: e.into(),
        })?;
        derivatives.insert(r.name.clone(), keys);
    }
    let (plan, families) = cases(study, &builder.scenes, with_inputs(plan, &specs));
    let variants = study.records.iter().map(|r| {
        let of = |q: &&QuantityPlan| q.records.contains_key(&r.name);
        let mut columns: Vec<&QuantityPlan> = plan.quantities.iter().filter(of).collect();
        columns.dedup_by_key(|q| q.column.clone());
        // The column as it is recorded; the label describes the column, not the value computed from it
        let quantity = |q: &&QuantityPlan| StudyQuantity {
            name: q.column.clone(),
            label: column::words(&q.column).0,
            symbol: q.symbol.clone(),
            unit: match unit_of_column(&q.column) {
                "1" => String::new(),
                unit => unit.into(),
            },
            ..StudyQuantity::default()
        };
        VariantSpec {
            name: r.name.clone(),
            label: r.label.clone(),
            group: None,
            set: builder.probes.get(&r.name).into_iter().flatten().fold(r.set.clone(), with_probe),
            quantities: columns.iter().map(quantity).collect(),
            scene: r.scene.clone(),
        }
    });
    let variants = variants.collect();
    let rules = RunRules { input_uncertainty: true, along_curves: true, ..RunRules::default() };
    Ok(Expansion { derivatives, rules, ..Expansion::new(variants, families, plan) })
}

/// The scenes of all records with their changes.
fn scenes(study: &ValidationStudy, file: &Path, scene: &Path) -> Result<Vec<(SceneSpec, toml::Table)>, SceneError> {
    let one = |r: &RecordSpec| {
        let own = r.scene.as_ref().map(|own| file.parent().unwrap_or(Path::new("")).join(own));
        let scene = own.as_deref().unwrap_or(scene);
        let set: Vec<_> = r.set.clone().into_iter().collect();
        let (spec, text) = read_scene(scene, &set).map_err(|e| SceneError::Part {
            file: file.into(),
            place: format!("record {}", r.name),
            source: e.into(),
        })?;
        Ok((spec, from_text(scene, &text, "")?))
    };
    study.records.iter().map(one).collect()
}

struct Builder<'a> {
    study: &'a ValidationStudy,
    file: &'a Path,
    wrong: Vec<String>,
    /// Probes of the fields, by record
    probes: BTreeMap<String, Vec<toml::Value>>,
    /// Scenes of the records with all their changes
    scenes: Vec<toml::Table>,
}

impl<'a> Builder<'a> {
    /// Folder of the study file.
    fn base(&self) -> &'a Path {
        self.file.parent().unwrap_or(Path::new(""))
    }

    fn plan(&mut self) -> ValidationPlan {
        let study = self.study;
        if !study.records.iter().any(|r| r.purpose == Purpose::Prediction) {
            self.wrong.push("no record has the purpose \"prediction\"; there is nothing to predict".into());
        }
        let mut unknowns = vec![];
        for found in study.unknowns.iter().map(unknown) {
            match found {
                Ok(u) => unknowns.push(u),
                Err(why) => self.wrong.push(why),
            }
        }
        let inputs = study.inputs.iter().map(|i| InputPlan {
            name: i.name.clone(),
            group: i.group.clone().unwrap_or_else(|| i.name.clone()),
            deviation: i.deviation.clone(),
            source: i.source.clone(),
            of_law_file: false,
        });
        let inputs = inputs.collect();
        let own = study.records.iter().zip(&self.scenes);
        let records: Vec<RecordPlan> =
            own.map(|(r, scene)| record(r, scene, study, &unknowns, &mut self.wrong)).collect();
        self.wrong.extend(without_use(study, &records, &self.scenes));
        let tracks = self.tracks();
        let plans = tracks.iter().flat_map(|(name, t)| t.plans(name)).collect();
        let sources = Sources { base: self.base(), study, tracks: &tracks };
        let mut quantities: Vec<QuantityPlan> =
            study.quantities.iter().map(|q| sources.quantity(q, &mut self.wrong)).collect();
        quantities.extend(self.fields());
        self.check_sets(&quantities);
        self.check_sources();
        let families = study.families.iter().map(|f| self.family(f)).collect();
        let (points, checks) = (BTreeMap::new(), BTreeMap::new());
        let reference = study.reference.clone();
        ValidationPlan { unknowns, inputs, records, quantities, families, reference, tracks: plans, points, checks }
    }

    /// Evaluates the tracks of all records that have them.
    fn tracks(&mut self) -> BTreeMap<String, RecordTracks> {
        let mut all = BTreeMap::new();
        for (r, spec) in self.study.records.iter().filter_map(|r| Some((r, r.tracks.as_ref()?))) {
            let is_used = |q: &&QuantitySpec| q.records.as_ref().is_none_or(|of| of.contains(&r.name));
            let curves: Vec<&String> =
                self.study.quantities.iter().filter(is_used).filter_map(|q| q.curve.as_ref()).collect();
            match RecordTracks::read(self.base(), spec, &curves) {
                Ok(found) => {
                    all.insert(r.name.clone(), found);
                }
                Err(why) => self.wrong.push(format!("record {}: {why}", r.name)),
            }
            if curves.is_empty() {
                let fact = "has tracks, but no quantity of it names a `curve` of them";
                self.wrong.push(format!("record {} {fact}", r.name));
            }
        }
        all
    }

    /// Reads the quantities of all fields; their probes are added to the scenes of the records.
    fn fields(&mut self) -> Vec<QuantityPlan> {
        let base = self.base();
        let known: Vec<String> = self.study.records.iter().map(|r| r.name.clone()).collect();
        let mut all = vec![];
        for spec in &self.study.fields {
            let errors = Errors::read(spec);
            if let Err(why) = &errors {
                self.wrong.push(format!("field {}: {why}", spec.name));
            }
            for name in spec.records.iter().flatten().filter(|n| !known.contains(n)) {
                self.wrong.push(format!("field {}: there is no record \"{name}\"; {}", spec.name, hint(name, &known)));
            }
            let own = |r: &&RecordSpec| spec.records.as_ref().is_none_or(|of| of.contains(&r.name));
            for r in self.study.records.iter().filter(own) {
                match (Field::read(base, spec, r), &errors) {
                    (Ok(field), _) if r.purpose == Purpose::Calibration && !field.is_measured() => {
                        let fact = "a calibration needs the displacement of every point";
                        self.wrong.push(format!("field {}, record {}: {fact}", spec.name, r.name));
                    }
                    (Ok(field), Ok(errors)) => {
                        all.extend(field.quantities(spec, r, errors));
                        self.probes.entry(r.name.clone()).or_default().push(field.probe(&spec.name));
                    }
                    (Ok(_), Err(_)) => {}
                    (Err(why), _) => self.wrong.push(format!("field {}, record {}: {why}", spec.name, r.name)),
                }
            }
        }
        all
    }

    fn family(&self, f: &FamilySpec) -> FamilyPlan {
        let runs = |name: &&String| f.variants.as_ref().is_none_or(|own| own.contains(name));
        let names: Vec<String> = self.study.records.iter().map(|r| r.name.clone()).collect();
        FamilyPlan {
            name: f.name.clone(),
            members: f.members.len(),
            records: names.iter().filter(runs).cloned().collect(),
        }
    }

    /// Refuses values that are both used for calibration and predicted.
    fn check_sets(&mut self, quantities: &[QuantityPlan]) {
        for q in quantities {
            let of = |purpose: Purpose| {
                let own =
                    self.study.records.iter().filter(move |r| r.purpose == purpose && q.records.contains_key(&r.name));
                own.map(|r| r.experiment().to_string())
            };
            let predicted: Vec<String> = of(Purpose::Prediction).collect();
            let both: Vec<String> = of(Purpose::Calibration).filter(|e| predicted.contains(e)).collect();
            for e in both {
                self.wrong.push(format!(
                    "quantity {}: experiment {e} is in the calibration and in the predictions; a value that was used is not predicted",
                    q.name
                ));
            }
        }
    }

    /// Requires every term of the budget to state its source.
    fn check_sources(&mut self) {
        let inputs =
            self.study.inputs.iter().filter(|i| i.source.trim().is_empty()).map(|i| format!("input {}", i.name));
        let fields =
            self.study.fields.iter().filter(|f| f.source.trim().is_empty()).map(|f| format!("field {}", f.name));
        let errors = self.study.quantities.iter().flat_map(|q| {
            let empty = q.errors.iter().filter(|e| e.source.trim().is_empty());
            empty.map(move |e| format!("quantity {}, error {}", q.name, e.group))
        });
        let all: Vec<String> = inputs.chain(fields).chain(errors).collect();
        self.wrong.extend(
            all.into_iter().map(|what| format!("{what}: its source is empty; say where the deviation is from")),
        );
    }
}

/// Adds one more probe to the changes.
fn with_probe(mut set: toml::Table, probe: &toml::Value) -> toml::Table {
    let more = set.entry("probe.+").or_insert_with(|| toml::Value::Array(vec![]));
    more.as_array_mut().into_iter().for_each(|all| all.push(probe.clone()));
    set
}
