//! From signals and events of a file to [`Controls`].

use super::Controls;
use super::event::{Event, Then, When};
use super::input::{Input, Source, Variable};
use super::signals::SignalBuilder;
use super::spec::{EventSpec, ThenSpec, WhenSpec};
use crate::math::formula::Formula;
use crate::scene::build::builder::Builder;
use crate::scene::error::{SceneError, hint};
use crate::scene::parts::constraints::{Drive, NamedCable, NamedCavity};
use crate::scene::record::column::in_unit_of;
use crate::scene::signal::protocol::extremes;
use crate::scene::text::quantity::Quantity;

/// Place, fact and remedy.
type Refusal = (String, String, String);

/// The columns and signals of a scene by name.
struct Known<'k> {
    pub columns: &'k [String],
    /// Names of the signals
    pub signals: Vec<String>,
    pub cables: Vec<String>,
    /// End time of the last stage \[s\]
    pub end: f64,
    /// Smallest and largest value of a column, if they are known
    pub range: &'k dyn Fn(&str) -> Option<(f64, f64)>,
}

impl SignalBuilder<'_> {
    /// Builds the controls, now that all names are known; returns notes too.
    fn finish(mut self, known: &Known) -> Result<(Controls, Vec<String>), Refusal> {
        let mut inputs = std::mem::take(&mut self.inputs);
        for input in &mut inputs {
            let Source::Formula { formula, variables, .. } = &mut input.source else { continue };
            *variables =
                resolve(formula, known).map_err(|(fact, remedy)| (format!("signal {}", input.signal), fact, remedy))?;
        }
        let (mut events, mut notes) = (Vec::<Event>::new(), Vec::new());
        for (e, spec) in self.specs.iter().enumerate() {
            let (place, name) = (self.place(e), self.name(e));
            let refuse = |fact: String, remedy: String| (place.clone(), fact, remedy);
            if events.iter().any(|other| other.name == name) {
                return Err(refuse(format!("another event is called \"{name}\" too"), "give each its `name`".into()));
            }
            let when = condition(spec, known).map_err(|(fact, remedy)| refuse(fact, remedy))?;
            notes.extend(never(&name, when, known));
            if spec.then.is_empty() {
                return Err(refuse("nothing happens".into(), "list at least one action in `then`".into()));
            }
            let mut then = Vec::new();
            for spec in &spec.then {
                then.push(match spec {
                    ThenSpec::Stop {} => Then::Stop,
                    ThenSpec::Save {} => Then::Save,
                    ThenSpec::Switch { signal, over, .. } => {
                        if over.is_some_and(|t| t.0 < 0.0) {
                            return Err(refuse("`over` is negative".into(), "give the time of the passage".into()));
                        }
                        let of_signal = |i: &Input| i.signal == *signal && matches!(i.source, Source::Switched { .. });
                        let Some(input) = inputs.iter().position(of_signal) else {
                            let fact = format!("there is no signal \"{signal}\"");
                            return Err(refuse(fact, hint(signal, &known.signals)));
                        };
                        let Source::Switched { others, .. } = &inputs[input].source else {
                            unreachable!("found as such")
                        };
                        let mine = others.iter().enumerate().filter(|(_, o)| o.event == e).map(|(k, _)| k);
                        let [other] = mine.collect::<Vec<_>>()[..] else {
                            let fact = format!("it switches {signal} twice");
                            return Err(refuse(fact, "keep one of the two".into()));
                        };
                        Then::Switch { input, other, signal: signal.clone() }
                    }
                });
            }
            events.push(Event { name, when, then, repeat: spec.repeat });
        }
        Ok((Controls { inputs, events }, notes))
    }
}

/// Builds inputs and events, once all names are known.
pub(in crate::scene) fn build_controls(
    builder: &mut Builder,
    columns: &[String],
    cables: &[NamedCable],
    cavities: &[NamedCavity],
) -> Result<Controls, SceneError> {
    let end = builder.spans.last().map_or(0.0, |s| s.end);
    let imposed = |drive: &Drive, floor: f64| match drive {
        Drive::Prescribed(signal) if !signal.has_inputs() => {
            let ((_, low), (_, high)) = extremes(signal, &builder.spans);
            Some((low.max(floor), high.max(floor)))
        }
        _ => None,
    };
    let range = |column: &str| {
        let cable = cables.iter().find(|c| column == format!("{}_tension_N", c.name));
        let cavity = cavities.iter().find(|c| column == format!("{}_pressure_Pa", c.name));
        match (cable, cavity) {
            (Some(cable), _) => imposed(&cable.drive, 0.0),
            (_, Some(cavity)) => imposed(&cavity.drive, f64::NEG_INFINITY),
            _ if column == "t_s" => Some((0.0, end)),
            _ => None,
        }
    };
    let known = Known {
        columns,
        signals: builder.signals.iter().map(|s| s.name.clone()).collect(),
        cables: cables.iter().map(|c| c.name.clone()).collect(),
        end,
        range: &range,
    };
    let signal_builder = std::mem::replace(&mut builder.signal_builder, SignalBuilder::new(&[]));
    let (controls, notes) =
        signal_builder.finish(&known).map_err(|(place, fact, remedy)| builder.content(&place, fact, remedy))?;
    builder.notes.extend(notes);
    Ok(controls)
}

fn column(name: &str, known: &Known) -> Result<usize, (String, String)> {
    let missing = || (format!("the scene records no \"{name}\""), hint(name, known.columns));
    known.columns.iter().position(|c| c == name).ok_or_else(missing)
}

fn resolve(formula: &Formula, known: &Known) -> Result<Vec<Variable>, (String, String)> {
    let variable = |name: &String| match name.as_str() {
        "t" => Ok(Variable::Time),
        name => column(name, known).map(Variable::Column),
    };
    formula.variables().iter().map(variable).collect()
}

fn condition(spec: &EventSpec, known: &Known) -> Result<When, (String, String)> {
    let tension = |cable: &String| {
        if !known.cables.contains(cable) {
            return Err((format!("there is no cable \"{cable}\""), hint(cable, &known.cables)));
        }
        column(&format!("{cable}_tension_N"), known)
    };
    let threshold = |name: &str, value: &Quantity| {
        let index = column(name, known)?;
        let value = in_unit_of(name, value).map_err(|e| (e.to_string(), format!("the column is {name}")))?;
        Ok::<_, (String, String)>((index, value))
    };
    Ok(match &spec.when {
        WhenSpec::At { t, every } => {
            let (t, every) = (t.0, every.map(|t| t.0));
            if !(0.0..=known.end * (1.0 + 1e-9)).contains(&t) {
                let remedy = format!("take a time from 0 to {} s, the end of the last stage", known.end);
                return Err((format!("it waits for t = {t} s"), remedy));
            }
            if every.is_some_and(|every| every <= 0.0) {
                return Err(("`every` is not positive".into(), "give the time from one to the next".into()));
            }
            if spec.repeat {
                return Err(("a time comes once".into(), "write `every` instead of `repeat`".into()));
            }
            When::At { t, every }
        }
        WhenSpec::Above { column, value } => {
            let (column, value) = threshold(column, value)?;
            When::Above { column, value }
        }
        WhenSpec::Below { column, value } => {
            let (column, value) = threshold(column, value)?;
            When::Below { column, value }
        }
        WhenSpec::Slack { cable } => When::Below { column: tension(cable)?, value: 0.0 },
        WhenSpec::Taut { cable } => When::Above { column: tension(cable)?, value: f64::MIN_POSITIVE },
    })
}

/// The reason why a condition cannot become true, if one is known.
fn never(name: &str, when: When, known: &Known) -> Option<String> {
    let column = match when {
        When::At { .. } => return None,
        When::Above { column, .. } | When::Below { column, .. } => column,
    };
    let column = &known.columns[column];
    let (low, high) = (known.range)(column)?;
    // A condition that is true from the start cannot become true later.
    let reached = match when {
        When::At { .. } => true,
        When::Above { value, .. } => low < value && value <= high,
        When::Below { value, .. } => low <= value && value < high,
    };
    (!reached).then(|| format!("the event \"{name}\" cannot happen: {column} stays between {low} and {high}"))
}
