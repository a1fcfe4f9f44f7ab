//! `durometer twin FILE`

use super::files;
use super::outcome::{CommandResult, Outcome};
use super::stdout::Output;
use durometer::math::units;
use durometer::reduction::running::inverse::{Target, reach_by};
use durometer::reduction::training::train::confidence;
use durometer::reduction::{Fallback, FullModel, Input, ReducedModel, StepReport, Twin};
use durometer::scene::control::strict_json::Strict;
use durometer::storage::unix_time;
use serde_json::{Map, Value, json};
use std::fmt::Display;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::time::Instant;

/// Step a reduced model: inputs as lines of JSON on standard input, quantities with their error bars on standard output
///
/// The file is made by a study of kind "reduction". The first output line lists the inputs with their ranges and present values, and the quantities.
/// Each input line gives the inputs that change, in SI, or target values of quantities, for which the driving inputs are searched within their
/// ranges; the answer is one line. A model that moves takes one step in time for each line.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer twin reports/finger-real-time/models/finger-real-time-4.durom
  echo '{\"inputs\": {\"cable_shortening_m\": 0.005}}' | durometer twin finger.durom
  echo '{\"target\": {\"bending_angle_deg\": 20}}' | durometer twin finger.durom
  durometer twin finger.durom --tolerance 1% --stop < protocol.jsonl
  durometer twin finger.durom --tolerance 1% --full studies/finger-real-time/scene.toml
  durometer twin finger.durom --listen 7000

Lines that are read: {\"inputs\": {NAME: VALUE, …}}, {\"target\": {NAME: VALUE, …}, \"moving\": [NAME, …]}, {\"reset\": true}.
Exit codes: 0 done, 2 bad input, 3 stopped where an error bar was above the tolerance (--stop).")]
pub struct Args {
    /// A reduced model, .durom
    file: PathBuf,
    /// Largest accepted error bar, relative to the largest change in the training runs, e.g. 1%; answers say whether it is met
    #[arg(long, value_name = "SHARE", value_parser = share)]
    tolerance: Option<f64>,
    /// End if an error bar exceeds the tolerance, an input is out of range, or the model has no answer
    #[arg(long, requires = "tolerance")]
    stop: bool,
    /// Scene of the study that made the model: if an error bar exceeds the tolerance or an input is out of range, the answer comes from the full
    /// model ("by": "full")
    #[arg(long, value_name = "SCENE", requires = "tolerance", conflicts_with = "stop")]
    full: Option<PathBuf>,
    /// Read lines from connections to this port of the loopback interface, one at a time, instead of standard input; 0 takes a free port
    #[arg(long, value_name = "PORT")]
    listen: Option<u16>,
}

fn share(text: &str) -> Result<f64, String> {
    let value = units::parse(text, units::Dimension::NONE).map_err(|e| e.to_string())?;
    if value > 0.0 && value.is_finite() { Ok(value) } else { Err("give a positive share, for example 1%".into()) }
}

/// Relative tolerance of a target, by the size of its quantity.
const MET: f64 = 1e-4;

/// Length limit of a line \[bytes\].
const LONGEST_LINE: u64 = 1 << 20;

pub fn main(args: &Args) -> CommandResult {
    let model = ReducedModel::read(&args.file)?;
    let full = args.full.as_ref().map(|scene| files::find(scene, "scene.toml")).transpose()?;
    let full = full.map(|scene| FullModel::open(&model, &scene)).transpose()?;
    full.iter().flat_map(FullModel::uncompared).for_each(|name| {
        tell!("note: {name} could not be compared with the file of the study: the model is of an earlier version; make it again");
    });
    let fallback = full.zip(args.tolerance).map(|(full, tolerance)| Fallback { full, tolerance });
    let twin = Twin::new(model)?;
    let mut models = Models { inputs: twin.inputs().to_vec(), twin, fallback };
    match args.listen {
        Some(port) => listen(&mut models, port, args),
        None => converse(&mut models, std::io::stdin().lock(), Output, args),
    }
}

/// A reduced model, and the full model that corrects it, if there is one.
struct Models {
    twin: Twin,
    fallback: Option<Fallback>,
    /// Inputs of the last answer
    inputs: Vec<f64>,
}

impl Models {
    /// Returns the reduced model to rest.
    fn reset(&mut self) {
        self.twin.reset();
        self.inputs.copy_from_slice(self.twin.inputs());
    }
}

/// Serves one connection after another, each starting with the model at rest; with `--stop` it ends at an answer that is not trusted.
fn listen(models: &mut Models, port: u16, args: &Args) -> CommandResult {
    let refused =
        |e: std::io::Error| format!("port {port} cannot be opened: {e}; give another one, or 0 for a free one");
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
    say!("{}", json!({ "listening": listener.local_addr()?.to_string() }));
    for connection in listener.incoming() {
        models.reset();
        models.fallback.iter_mut().for_each(|fallback| fallback.full.reset());
        // A client that disconnects, or sends something other than text, gets no more answers; the next client is served
        let served = connection.map_err(Into::into).and_then(|stream| {
            stream.set_nodelay(true)?;
            converse(models, BufReader::new(&stream), &stream, args)
        });
        if let Ok(Outcome::RunIncomplete) = served {
            return served;
        }
    }
    Ok(Outcome::Complete)
}

/// Answers lines until the input ends, or the other side accepts no more answers.
fn converse(models: &mut Models, mut lines: impl BufRead, mut out: impl Write, args: &Args) -> CommandResult {
    let mut tell = |answer: &Value| writeln!(out, "{answer}").and_then(|()| out.flush()).is_ok();
    if !tell(&opening(&models.twin)) {
        return Ok(Outcome::Complete);
    }
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = lines.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes)?;
        if length == 0 {
            return Ok(Outcome::Complete);
        }
        let text = if length as u64 == LONGEST_LINE && bytes.last() != Some(&b'\n') {
            lines.skip_until(b'\n')?;
            Err(format!("the line is longer than {LONGEST_LINE} bytes; give shorter ones"))
        } else {
            std::str::from_utf8(&bytes).map_err(|_| "the line is not UTF-8".to_string())
        };
        if text.as_ref().is_ok_and(|line| line.trim().is_empty()) {
            continue;
        }
        let answered = text.map_err(Refused::Line).and_then(|line| answer(models, line, args.tolerance));
        let (answer, trusted) = match answered {
            Ok(answer) => answer,
            Err(Refused::Line(why)) => (json!({ "error": why }), true),
            Err(Refused::Model(why)) => (json!({ "error": why }), false),
        };
        if !tell(&answer) {
            return Ok(Outcome::Complete);
        }
        if args.stop && !trusted {
            return Ok(Outcome::RunIncomplete);
        }
    }
}

fn opening(twin: &Twin) -> Value {
    let model = twin.model();
    let driving = model.driving();
    let input = |(k, i): (usize, &Input)| {
        let mut input = json!({ "name": i.name, "range": i.range, "value": twin.inputs()[k], "held": !driving[k] });
        if let Some(dynamics) = &model.dynamics {
            input["largest_change"] = dynamics.changes[k].into();
        }
        input
    };
    let inputs: Vec<Value> = model.inputs.iter().enumerate().map(input).collect();
    let quantities: Vec<&str> = model.quantities.iter().map(|q| q.name.as_str()).collect();
    let mut opening = json!({
        "durometer": env!("CARGO_PKG_VERSION"),
        "model": model.title,
        "inputs": inputs,
        "quantities": quantities,
        "modes": model.sizes.displacements - model.origin.supremisers,
        "supremisers": model.origin.supremisers,
        "pressure_modes": model.sizes.pressures,
        "cells": model.origin.cells,
        "held_back": model.origin.held_back,
    });
    if model.bars().is_some() && model.origin.held_back > 0 {
        opening["confidence"] = confidence(model.origin.held_back).into();
    }
    if let Some(dt) = twin.dt() {
        opening["dt_s"] = dt.into();
    }
    opening
}

/// Why a line has no answer, as text; the state of the model does not change.
enum Refused {
    /// The line is not a valid request
    Line(String),
    /// The model cannot reach the requested state
    Model(String),
}

impl From<String> for Refused {
    fn from(why: String) -> Self {
        Self::Line(why)
    }
}

impl Refused {
    fn model(why: impl Display) -> Self {
        Self::Model(why.to_string())
    }
}

/// A parsed request line.
struct Asked {
    resets: bool,
    /// Given inputs as (index, value); `None` if the key is missing
    inputs: Option<Vec<(usize, f64)>>,
    targets: Vec<Target>,
    moving: Vec<bool>,
}

/// Returns the answer to a line, and whether it can be trusted.
fn answer(models: &mut Models, line: &str, tolerance: Option<f64>) -> Result<(Value, bool), Refused> {
    let asked = understood(&models.twin, line)?;
    let start = Instant::now();
    let before = (models.twin.save(), models.inputs.clone());
    if asked.resets {
        models.reset();
    }
    let answered = match &asked.inputs {
        None if models.twin.dt().is_some() => answer_in_time(&mut models.twin, &asked, (start, tolerance)),
        _ => answer_at(models, &asked, (start, tolerance)),
    };
    if answered.is_err() {
        models.twin.restore(&before.0);
        models.inputs = before.1;
    }
    answered
}

/// Parses the requests of a line.
fn understood(twin: &Twin, line: &str) -> Result<Asked, String> {
    let refused = |why: String| format!("the line is no JSON object: {why}; write {{\"inputs\": {{…}}}}");
    let Strict(asked) = serde_json::from_str(line).map_err(|e| refused(e.to_string()))?;
    let Value::Object(asked) = asked else { return Err(refused("it is another value".into())) };
    let known = ["inputs", "target", "moving", "reset"];
    if let Some(key) = asked.keys().find(|key| !known.contains(&key.as_str())) {
        return Err(format!("there is no \"{key}\"; the keys are {}", known.join(", ")));
    }
    let resets = match asked.get("reset") {
        None => false,
        Some(Value::Bool(true)) => true,
        Some(other) => return Err(format!("\"reset\" is {other}; write true, or leave it away")),
    };
    let names: Vec<String> = twin.model().inputs.iter().map(|i| i.name.clone()).collect();
    let given: Vec<(usize, f64)> = numbers(&asked, "inputs")?
        .into_iter()
        .map(|(name, value)| Ok((index(&names, &name)?, value)))
        .collect::<Result<_, String>>()?;
    let targets = targets(twin, numbers(&asked, "target")?)?;
    let moving = moving(twin, &asked, &names)?;
    let (has_inputs, has_target) = (asked.contains_key("inputs"), asked.contains_key("target"));
    if twin.dt().is_some() && has_inputs && has_target {
        return Err("a line is one step in time: give \"inputs\", or a \"target\"".into());
    }
    Ok(Asked { resets, inputs: has_inputs.then_some(given), targets, moving })
}

/// Returns the answer at the inputs of a line, or at the inputs that meet its targets.
fn answer_at(
    models: &mut Models,
    asked: &Asked,
    (start, tolerance): (Instant, Option<f64>),
) -> Result<(Value, bool), Refused> {
    let Models { twin, fallback, inputs: last } = models;
    // A model that moves continues from its last step, also if that step searched for a target
    let mut inputs = if twin.dt().is_some() { twin.inputs().to_vec() } else { last.clone() };
    asked.inputs.iter().flatten().for_each(|&(k, value)| inputs[k] = value);
    let (reached, mut met) = if asked.targets.is_empty() {
        (twin.step(&inputs), None)
    } else {
        // The search begins at the given inputs; those that it may move are clamped to their ranges
        let moved = inputs.iter_mut().zip(&twin.model().inputs).zip(&asked.moving).filter(|(_, moves)| **moves);
        moved.for_each(|((u, input), _)| *u = u.clamp(input.range[0], input.range[1]));
        let begins = twin.step(&inputs);
        // If the full model gave the last answer, a search without given inputs may begin elsewhere, provided that it may move all inputs that differ
        let mut held = inputs.iter().zip(twin.inputs()).zip(&asked.moving).filter(|(_, moves)| !**moves);
        if asked.inputs.is_some() || held.any(|((wanted, present), _)| wanted != present) {
            begins.map_err(Refused::model)?;
        }
        let found = reach_by(twin, &asked.targets, &asked.moving).map_err(Refused::model)?;
        inputs = found.inputs;
        (Ok(StepReport { iterations: found.iterations, parts: 1 }), Some(found.met))
    };
    let full = match fallback {
        Some(fallback) => {
            if asked.resets {
                fallback.full.reset();
            }
            fallback.correct(twin, &inputs, reached).map_err(Refused::model)?
        }
        None => None,
    };
    if let (Some(values), Some(t)) = (&full, tolerance) {
        let is_met =
            |of: &Target| (values[of.quantity] - of.value).abs() <= t * twin.model().largest_changes[of.quantity];
        met = met.map(|met| met && asked.targets.iter().all(is_met));
    }
    // If the full model answers, the reduced model need not have reached these inputs
    let report = match reached {
        Err(_) if full.is_some() => StepReport { iterations: 0, parts: 0 },
        reached => reached.map_err(Refused::model)?,
    };
    last.copy_from_slice(&inputs);
    Ok(described(twin, (&inputs, full.as_deref()), report, met, (start, tolerance)))
}

/// Returns the answer of a model that moves to a line without inputs: a step to a target, rest without a step, or a step with the present inputs.
fn answer_in_time(
    twin: &mut Twin,
    asked: &Asked,
    (start, tolerance): (Instant, Option<f64>),
) -> Result<(Value, bool), Refused> {
    let (report, met) = if !asked.targets.is_empty() {
        let reached = reach_by(twin, &asked.targets, &asked.moving).map_err(Refused::model)?;
        (StepReport { iterations: reached.iterations, parts: 1 }, Some(reached.met))
    } else if asked.resets {
        (StepReport { iterations: 0, parts: 0 }, None)
    } else {
        let inputs = twin.inputs().to_vec();
        (twin.step(&inputs).map_err(Refused::model)?, None)
    };
    Ok(described(twin, (twin.inputs(), None), report, met, (start, tolerance)))
}

/// Returns which inputs a search may move: the named ones, or otherwise the driving ones.
fn moving(twin: &Twin, asked: &Map<String, Value>, names: &[String]) -> Result<Vec<bool>, String> {
    let Some(value) = asked.get("moving") else { return Ok(twin.model().driving()) };
    let refused = || format!("\"moving\" is {value}; write {{\"target\": {{…}}, \"moving\": [NAME, …]}}");
    let named =
        value.as_array().filter(|named| !named.is_empty() && asked.contains_key("target")).ok_or_else(refused)?;
    let mut moving = vec![false; names.len()];
    for name in named {
        moving[index(names, name.as_str().ok_or_else(refused)?)?] = true;
    }
    Ok(moving)
}

fn targets(twin: &Twin, asked: Vec<(String, f64)>) -> Result<Vec<Target>, String> {
    let model = twin.model();
    let names: Vec<String> = model.quantities.iter().map(|q| q.name.clone()).collect();
    let target = |(name, value): (String, f64)| {
        let quantity = index(&names, &name)?;
        Ok(Target { quantity, value, tolerance: MET * model.size_at(quantity, value) })
    };
    asked.into_iter().map(target).collect()
}

/// Returns the named numbers under a key of the line.
fn numbers(asked: &Map<String, Value>, key: &str) -> Result<Vec<(String, f64)>, String> {
    let Some(value) = asked.get(key) else { return Ok(vec![]) };
    let object =
        value.as_object().ok_or_else(|| format!("\"{key}\" is no object; write {{\"{key}\": {{NAME: NUMBER}}}}"))?;
    let number = |(name, value): (&String, &Value)| {
        let number = value.as_f64().ok_or_else(|| format!("{name} is {value}, not a number"))?;
        Ok((name.clone(), number))
    };
    object.iter().map(number).collect()
}

fn index(names: &[String], name: &str) -> Result<usize, String> {
    names.iter().position(|n| n == name).ok_or_else(|| format!("there is no \"{name}\"; there is {}", names.join(", ")))
}

/// Returns the answer at these inputs, with the values of the full model if it gave some, and whether it can be trusted.
fn described(
    twin: &Twin,
    (inputs, full): (&[f64], Option<&[f64]>),
    report: StepReport,
    met: Option<bool>,
    (start, tolerance): (Instant, Option<f64>),
) -> (Value, bool) {
    let model = twin.model();
    let named: Map<String, Value> = model.inputs.iter().zip(inputs).map(|(i, u)| (i.name.clone(), json!(u))).collect();
    let mut quantities = Map::new();
    for (k, quantity) in model.quantities.iter().enumerate() {
        let (value, bar) = full.map_or((twin.values()[k], twin.bars()[k]), |values| (values[k], 0.0));
        // JSON has no infinite numbers: an unknown error bar is null
        quantities.insert(quantity.name.clone(), json!({ "value": value, "bar": bar.is_finite().then_some(bar) }));
    }
    let within_ranges = model.inputs.iter().zip(inputs).all(|(i, u)| i.contains(*u));
    // A model that moves also depends on its earlier inputs
    let in_range = within_ranges && (twin.dt().is_none() || twin.in_range());
    let bars_hold = |t: f64| twin.bars().iter().zip(&model.largest_changes).all(|(bar, size)| *bar <= t * size);
    let within = full.is_some() || tolerance.is_none_or(bars_hold);
    let mut answer = json!({
        "inputs": named,
        "quantities": quantities,
        "by": if full.is_some() { "full" } else { "reduced" },
        "in_range": in_range,
        "iterations": report.iterations,
        "seconds": start.elapsed().as_secs_f64(),
        "unix_s": unix_time().as_secs_f64(),
    });
    if let Some(t) = twin.time() {
        answer["t_s"] = t.into();
    }
    if tolerance.is_some() {
        answer["within_tolerance"] = within.into();
    }
    if let Some(met) = met {
        answer["target_met"] = met.into();
    }
    (answer, within && in_range)
}
