//! The cases of a validation and its plan, read from the study file with every mistake in it.
//!
//! The design of a record over its m unknowns has the centre of their ranges, the middle of each face and, with several unknowns, the corners (Box &
//! Wilson, *J. R. Stat. Soc. B* 13, 1951, face-centred). All its cases have derivatives by unknowns and inputs.

use crate::math::random::SplitMix;
use crate::math::units::{self, Dimension};
use crate::scene::{KeyValue, ParameterKey, SceneError, find, from_text, hint, in_unit_of, read_scene};
use crate::study::kind::Expansion;
use crate::study::kinds::validation::field::{Errors, Field};
use crate::study::kinds::validation::measured::table;
use crate::study::kinds::validation::plan::{
    ErrorPlan, FamilyPlan, InputPlan, QuantityPlan, RecordPlan, UnknownPlan, ValidationPlan,
};
use crate::study::kinds::validation::spec::{
    Evaluation, InputSpec, Purpose, QuantitySpec, RecordSpec, UnknownSpec, ValidationStudy,
};
use crate::study::spec::{FamilySpec, VariantSpec, check_roles, refuse};
use crate::study::store::record::{Quantity, Role};
use std::collections::BTreeMap;
use std::path::Path;

/// Roles that a study file may give.
const ROLES: [Role; 4] = [Role::Sizes, Role::Nested, Role::Remeshed, Role::TimeStep];
/// Most unknowns: their corners are 16 runs.
const MOST_UNKNOWNS: usize = 4;
/// Seed of the places of checks, to which the name of the record is added.
const SEED: u64 = 0x7661_6c69_6461_7465;
/// Share of the ranges within which checks lie.
const INNER: f64 = 0.8;

/// Variants, families and the plan of a validation in a study file.
pub fn expand(study: &ValidationStudy, file: &Path, scene: &Path) -> Result<Expansion<ValidationPlan>, SceneError> {
    let mut builder =
        Builder { study, file, wrong: vec![], probes: BTreeMap::new(), scenes: scenes(study, file, scene)? };
    let plan = builder.plan();
    if let Err((place, fact, _)) = check_roles("validation", &study.families, &ROLES) {
        builder.wrong.push(format!("{place}: {fact}; give sizes, nested, remeshed or time_step"));
    }
    if !builder.wrong.is_empty() {
        let fact = format!("{} mistake(s): {}", builder.wrong.len(), builder.wrong.join("; "));
        return Err(refuse(file, ("validation".into(), fact, "correct them".into())));
    }
    let (plan, families) = builder.cases(plan);
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
    let variants = study.records.iter().map(|r| {
        let of = |q: &&QuantityPlan| q.records.contains_key(&r.name);
        let mut columns: Vec<&QuantityPlan> = plan.quantities.iter().filter(of).collect();
        columns.dedup_by_key(|q| q.column.clone());
        let quantity = |q: &&QuantityPlan| Quantity {
            name: q.column.clone(),
            label: q.label.clone(),
            symbol: q.symbol.clone(),
            unit: q.column.rsplit('_').next().unwrap_or_default().into(),
            ..Quantity::default()
        };
        VariantSpec {
            name: r.name.clone(),
            label: r.label.clone(),
            set: builder.probes.get(&r.name).into_iter().flatten().fold(r.set.clone(), with_probe),
            quantities: columns.iter().map(quantity).collect(),
            scene: r.scene.clone(),
        }
    });
    let variants = variants.collect();
    Ok(Expansion { derivatives, ..Expansion::new(variants, families, plan) })
}

/// The scenes of all records with their changes.
fn scenes(study: &ValidationStudy, file: &Path, scene: &Path) -> Result<Vec<toml::Table>, SceneError> {
    let one = |r: &RecordSpec| {
        let own = r.scene.as_ref().map(|own| file.parent().unwrap_or(Path::new("")).join(own));
        let scene = own.as_deref().unwrap_or(scene);
        let set: Vec<_> = r.set.clone().into_iter().collect();
        let (_, text) = read_scene(scene, &set).map_err(|e| SceneError::Part {
            file: file.into(),
            place: format!("record {}", r.name),
            source: e.into(),
        })?;
        from_text(scene, &text, "")
    };
    study.records.iter().map(one).collect()
}

struct Builder<'a> {
    study: &'a ValidationStudy,
    file: &'a Path,
    wrong: Vec<String>,
    /// Record → probes of its fields
    probes: BTreeMap<String, Vec<toml::Value>>,
    /// \[records\] their scenes with all changes
    scenes: Vec<toml::Table>,
}

impl Builder<'_> {
    fn plan(&mut self) -> ValidationPlan {
        if !self.study.records.iter().any(|r| r.purpose == Purpose::Prediction) {
            self.wrong.push("no record has the purpose \"prediction\"; there is nothing to predict".into());
        }
        let unknowns: Vec<UnknownPlan> = self.study.unknowns.iter().filter_map(|u| self.unknown(u)).collect();
        let inputs = self.study.inputs.iter().map(|i| InputPlan {
            name: i.name.clone(),
            group: i.group.clone().unwrap_or_else(|| i.name.clone()),
            deviation: i.deviation.clone(),
            source: i.source.clone(),
        });
        let inputs = inputs.collect();
        let records: Vec<RecordPlan> = (0..self.study.records.len()).map(|k| self.record(k, &unknowns)).collect();
        self.check_unknowns(&records);
        let mut quantities: Vec<QuantityPlan> = self.study.quantities.iter().map(|q| self.quantity(q)).collect();
        quantities.extend(self.fields());
        self.check_sets(&quantities);
        self.check_sources();
        let families = self.study.families.iter().map(|f| self.family(f)).collect();
        let (points, checks) = (BTreeMap::new(), BTreeMap::new());
        ValidationPlan { unknowns, inputs, records, quantities, families, points, checks }
    }

    fn unknown(&mut self, u: &UnknownSpec) -> Option<UnknownPlan> {
        let read = |v: &toml::Value| match v {
            toml::Value::String(text) => units::quantity(text).map_err(|e| e.to_string()),
            other => number(other).map(|n| (n, Dimension::NONE)).ok_or_else(|| format!("{other} is not a number")),
        };
        let found = match (read(&u.range[0]), read(&u.range[1])) {
            (Ok((low, a)), Ok((high, b))) if a == b && low < high => Ok([low, high]),
            (Ok((_, a)), Ok((_, b))) if a != b => Err("its ends have different dimensions".to_string()),
            (Ok(_), Ok(_)) => Err("its lower end is not below the upper one".into()),
            (Err(why), _) | (_, Err(why)) => Err(why),
        };
        match found {
            Err(why) => {
                self.wrong.push(format!("unknown {}: range: {why}", u.name));
                None
            }
            Ok([low, high]) => {
                let unit = unit_of(&u.range[0]);
                let factor = units::quantity(&format!("1 {unit}")).map_or(1.0, |(f, _)| f);
                let (name, key, label, symbol) = (u.name.clone(), u.key.clone(), u.label.clone(), u.symbol.clone());
                Some(UnknownPlan { name, key, label, symbol, unit, range: [low / factor, high / factor], factor })
            }
        }
    }

    fn record(&mut self, k: usize, unknowns: &[UnknownPlan]) -> RecordPlan {
        let r = &self.study.records[k];
        let scene = self.scenes[k].clone();
        let own = (0..unknowns.len()).filter(|u| find(&scene, &unknowns[*u].key).is_ok()).collect();
        let mut inputs = vec![];
        for (j, input) in self.study.inputs.iter().enumerate() {
            let named = input.records.as_ref().map(|of| of.contains(&r.name));
            if named == Some(false) {
                continue;
            }
            let there = input.keys.iter().all(|key| find(&scene, key).is_ok());
            match (there, named) {
                (true, _) => match deviations(input, &scene) {
                    Ok(found) => inputs.push((j, found)),
                    Err(why) => self.wrong.push(format!("input {}, record {}: {why}", input.name, r.name)),
                },
                (false, Some(_)) => {
                    self.wrong
                        .push(format!("input {}: the scene of record {} has not all of its keys", input.name, r.name));
                }
                (false, None) => {}
            }
        }
        RecordPlan {
            name: r.name.clone(),
            label: r.label.clone().unwrap_or_else(|| r.name.clone()),
            experiment: r.experiment.clone().unwrap_or_else(|| r.name.clone()),
            purpose: r.purpose,
            unknowns: own,
            inputs,
        }
    }

    /// Every unknown is in some calibration record, every input somewhere.
    fn check_unknowns(&mut self, records: &[RecordPlan]) {
        let calibrated =
            |k: &usize| records.iter().any(|r| r.purpose == Purpose::Calibration && r.unknowns.contains(k));
        for (_, u) in self.study.unknowns.iter().enumerate().filter(|(k, _)| !calibrated(k)) {
            self.wrong.push(format!("unknown {}: no calibration record has the key {}", u.name, u.key));
        }
        let used = |j: usize| records.iter().any(|r| r.inputs.iter().any(|(i, _)| *i == j));
        for (_, i) in self.study.inputs.iter().enumerate().filter(|(j, _)| !used(*j)) {
            self.wrong.push(format!("input {}: no scene has all of its keys {}", i.name, i.keys.join(", ")));
        }
        if self.study.unknowns.len() > MOST_UNKNOWNS {
            self.wrong
                .push(format!("{} unknowns; at most {MOST_UNKNOWNS} are found at once", self.study.unknowns.len()));
        }
    }

    fn quantity(&mut self, q: &QuantitySpec) -> QuantityPlan {
        let known: Vec<String> = self.study.records.iter().map(|r| r.name.clone()).collect();
        let wanted = q.records.clone().unwrap_or_else(|| known.clone());
        for name in wanted.iter().chain(q.measured.keys()).filter(|n| !known.contains(n)) {
            self.wrong.push(format!("quantity {}: there is no record \"{name}\"; {}", q.name, hint(name, &known)));
        }
        let base = self.file.parent().unwrap_or(Path::new(""));
        let from_table = q.table.as_ref().map(|spec| table(base, spec, &q.unit));
        let mut records = BTreeMap::new();
        for r in self.study.records.iter().filter(|r| wanted.contains(&r.name)) {
            let mut values = q.measured.get(&r.name).map_or(vec![], |v| v.values());
            let experiment = r.experiment.as_ref().unwrap_or(&r.name);
            if let Some(Ok(table)) = &from_table {
                match table.values(experiment) {
                    Ok(found) => values.extend(found),
                    Err(why) => self.wrong.push(format!("quantity {}, record {}: {why}", q.name, r.name)),
                }
            }
            if values.is_empty() && r.purpose == Purpose::Calibration && !matches!(from_table, Some(Err(_))) {
                self.wrong.push(format!(
                    "quantity {}: the calibration record {} has no measured value of it",
                    q.name, r.name
                ));
            }
            records.insert(r.name.clone(), values);
        }
        if let Some(Err(why)) = from_table {
            self.wrong.push(format!("quantity {}: {why}", q.name));
        }
        let mut errors = vec![];
        for e in &q.errors {
            match units::in_unit(&e.deviation, &q.unit) {
                Ok(deviation) if deviation > 0.0 => {
                    let (group, source) = (e.group.clone(), e.source.clone());
                    let shared = e.shared.then(|| format!("{} {group}", q.name));
                    errors.push(ErrorPlan { group, deviation, source, shared });
                }
                Ok(_) => {
                    self.wrong.push(format!("quantity {}, error {}: the deviation is not above zero", q.name, e.group))
                }
                Err(why) => self.wrong.push(format!("quantity {}, error {}: {why}", q.name, e.group)),
            }
        }
        if errors.iter().all(|e| e.shared.is_some()) {
            let fact = "it has no error of its own in every record; add an [[quantity.error]] that is not shared";
            self.wrong.push(format!("quantity {}: {fact}", q.name));
        }
        let (factor, window) = self.numbers(q);
        QuantityPlan {
            name: q.name.clone(),
            label: q.label.clone(),
            symbol: q.symbol.clone(),
            unit: q.unit.clone(),
            column: q.column.clone(),
            value: q.value,
            factor,
            window,
            records,
            errors,
        }
    }

    /// The quantities of all fields; their probes are added to the scenes of the records.
    fn fields(&mut self) -> Vec<QuantityPlan> {
        let base = self.file.parent().unwrap_or(Path::new(""));
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

    /// Factor from column to quantity, and the window of a ring-down \[s\].
    fn numbers(&mut self, q: &QuantitySpec) -> (f64, Option<[f64; 2]>) {
        let rings = matches!(q.value, Evaluation::Frequency | Evaluation::Decay);
        let unit = if rings {
            units::in_unit("1 Hz", &q.unit)
        } else {
            in_unit_of(&q.column, &format!("1 {}", q.unit).as_str().into()).map(|own| 1.0 / own)
        };
        let factor = unit.unwrap_or_else(|why| {
            self.wrong.push(format!("quantity {}: unit: {why}", q.name));
            1.0
        });
        let time = |text: &String| units::parse(text, Dimension::TIME);
        let window = match (&q.window, rings) {
            (Some([a, b]), true) => match (time(a), time(b)) {
                (Ok(a), Ok(b)) if a < b => Some([a, b]),
                (Ok(_), Ok(_)) => {
                    self.wrong.push(format!("quantity {}: the window ends before it begins", q.name));
                    None
                }
                (Err(why), _) | (_, Err(why)) => {
                    self.wrong.push(format!("quantity {}: window: {why}", q.name));
                    None
                }
            },
            (None, true) => {
                self.wrong.push(format!("quantity {}: a ring-down needs a window, [\"0.3 s\", \"1.6 s\"]", q.name));
                None
            }
            (Some(_), false) => {
                self.wrong.push(format!("quantity {}: only ring-downs have a window; remove it", q.name));
                None
            }
            (None, false) => None,
        };
        (q.times * factor, window)
    }

    /// Refuses values that are both calibrated with and predicted.
    fn check_sets(&mut self, quantities: &[QuantityPlan]) {
        for q in quantities {
            let of = |purpose: Purpose| {
                let own =
                    self.study.records.iter().filter(move |r| r.purpose == purpose && q.records.contains_key(&r.name));
                own.map(|r| r.experiment.clone().unwrap_or_else(|| r.name.clone()))
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

    /// Every term of the budget says where it is from.
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

    /// Families of the design and of the checks before those of the study, and the places of their cases.
    fn cases(&self, mut plan: ValidationPlan) -> (ValidationPlan, Vec<FamilySpec>) {
        let (mut designs, mut checks) = (BTreeMap::new(), BTreeMap::new());
        for (r, scene) in plan.records.iter().zip(&self.scenes) {
            let own: Vec<&UnknownPlan> = r.unknowns.iter().map(|k| &plan.unknowns[*k]).collect();
            let setting = |xi: &[f64]| -> toml::Table {
                own.iter().zip(xi).map(|(u, xi)| (u.key.clone(), value_at(u, *xi))).collect()
            };
            let names: Vec<&str> = own.iter().map(|u| u.name.as_str()).collect();
            let mut members = toml::Table::new();
            for (label, xi) in design(&names) {
                members.insert(label.clone(), setting(&xi).into());
                plan.points.insert(format!("design-{}-{label}", r.name), xi);
            }
            designs.insert(r.name.clone(), members);
            let seed = r.name.bytes().fold(SEED, |seed, byte| seed.rotate_left(8) ^ u64::from(byte));
            let mut random = SplitMix(seed);
            let mut members = toml::Table::new();
            for k in 1..=self.study.checks {
                let xi: Vec<f64> = own.iter().map(|_| INNER * (2.0 * random.unit() - 1.0)).collect();
                let s: Vec<f64> = r.inputs.iter().map(|_| 2.0 * random.unit() - 1.0).collect();
                let mut set = setting(&xi);
                for (s, (_, keys)) in s.iter().zip(&r.inputs) {
                    for (key, deviation) in keys {
                        let before = set.get(key).cloned().or_else(|| find(scene, key).ok().cloned());
                        let after = before.and_then(|v| shifted(&v, s * deviation));
                        after.map(|value| set.insert(key.clone(), value));
                    }
                }
                members.insert(k.to_string(), set.into());
                plan.checks.insert(format!("check-{}-{k}", r.name), (xi, s));
            }
            checks.insert(r.name.clone(), members);
        }
        let family = |name: &str, role, own| FamilySpec {
            name: name.into(),
            role,
            variants: None,
            set: toml::Table::new(),
            members: toml::Table::new(),
            own,
            scene: None,
        };
        let mut families = vec![family("design", Role::Design, designs)];
        if self.study.checks > 0 {
            families.push(family("check", Role::Check, checks));
        }
        families.extend(self.study.families.iter().map(|f| self.at_centre(f, &plan)));
        (plan, families)
    }

    /// A family of the study with the constants at the centre of the design.
    fn at_centre(&self, f: &FamilySpec, plan: &ValidationPlan) -> FamilySpec {
        let runs = |r: &&RecordPlan| f.variants.as_ref().is_none_or(|own| own.contains(&r.name));
        let with_centre = |r: &RecordPlan, member: &toml::Value| match member {
            toml::Value::Table(changes) => {
                let centre = r.unknowns.iter().map(|k| &plan.unknowns[*k]).map(|u| (u.key.clone(), value_at(u, 0.0)));
                toml::Value::Table(centre.chain(changes.clone()).collect())
            }
            other => other.clone(),
        };
        let members = |r: &RecordPlan| f.members.iter().map(|(l, m)| (l.clone(), with_centre(r, m))).collect();
        let own = plan.records.iter().filter(runs).map(|r| (r.name.clone(), members(r))).collect();
        FamilySpec { members: toml::Table::new(), own, ..f.clone() }
    }
}

/// Labels and places of a face-centred central composite design.
fn design(names: &[&str]) -> Vec<(String, Vec<f64>)> {
    let m = names.len();
    let word = |x: f64| if x < 0.0 { "low" } else { "high" };
    let mut all = vec![("centre".to_string(), vec![0.0; m])];
    for (k, name) in names.iter().enumerate() {
        for x in [-1.0, 1.0] {
            let mut at = vec![0.0; m];
            at[k] = x;
            all.push((format!("{name}-{}", word(x)), at));
        }
    }
    if m > 1 {
        for corner in 0..1_usize << m {
            let at: Vec<f64> = (0..m).map(|k| if corner >> k & 1 == 1 { 1.0 } else { -1.0 }).collect();
            let label: Vec<String> = names.iter().zip(&at).map(|(n, x)| format!("{n}-{}", word(*x))).collect();
            all.push((label.join("-"), at));
        }
    }
    all
}

/// Changes with one more probe.
fn with_probe(mut set: toml::Table, probe: &toml::Value) -> toml::Table {
    let more = set.entry("probe.+").or_insert_with(|| toml::Value::Array(vec![]));
    more.as_array_mut().into_iter().for_each(|all| all.push(probe.clone()));
    set
}

fn number(v: &toml::Value) -> Option<f64> {
    v.as_float().or_else(|| v.as_integer().map(|n| n as f64))
}

/// Unit of a quantity as it is written.
fn unit_of(v: &toml::Value) -> String {
    v.as_str()
        .and_then(|text| text.trim().split_once(char::is_whitespace))
        .map_or(String::new(), |(_, unit)| unit.trim().into())
}

fn value_at(u: &UnknownPlan, xi: f64) -> toml::Value {
    let value = u.at(xi);
    if u.unit.is_empty() { value.into() } else { format!("{value} {}", u.unit).into() }
}

/// A value of a scene, larger by an amount in SI.
fn shifted(v: &toml::Value, by: f64) -> Option<toml::Value> {
    let value = KeyValue::of(v).ok()?;
    Some(value.written_si(value.si() + by))
}

/// The keys of an input with one standard deviation each \[SI\].
fn deviations(input: &InputSpec, scene: &toml::Table) -> Result<Vec<(String, f64)>, String> {
    let (amount, dimension) = units::quantity(&input.deviation).map_err(|e| e.to_string())?;
    if amount <= 0.0 {
        return Err("its deviation is not above zero".into());
    }
    let share = input.deviation.trim().ends_with('%');
    let one = |key: &String| {
        let found = key.parse::<ParameterKey>().and_then(|key| key.value(scene)).map_err(|e| e.to_string())?;
        let value = found.si();
        match share {
            true if value == 0.0 => {
                Err(format!("{key} is zero, of which no share is taken; give the deviation as a quantity"))
            }
            true => Ok((key.clone(), amount * value.abs())),
            false if found.dimension == dimension => Ok((key.clone(), amount)),
            false => Err(format!("{key} has another dimension than the deviation \"{}\"", input.deviation)),
        }
    };
    input.keys.iter().map(one).collect()
}
