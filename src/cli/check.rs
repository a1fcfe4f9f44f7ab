//! `durometer check FILE`

use super::outcome::{CommandResult, Outcome};
use super::{body_figure, files, region_table};
use durometer::math::threads;
use durometer::math::units::{Decimals, Dimension, shown};
use durometer::scene::protocol::extremes;
use durometer::scene::spec::{ConstraintSpec, EffectSpec};
use durometer::scene::{Body, Scene, SceneSpec, limits_of_scene, read_scene};
use durometer::study::case::Case;
use durometer::study::expand::Study;
use durometer::study::run::task::Task;
use durometer::system::ConstraintKind;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Validate a scene or study and say what would be simulated, without running it
///
/// It names mesh, regions with what they hold, effects with region, law and formulation, contacts, what of these is not there, unknowns, steps, signals and recorded columns. Nothing is solved. A mesh that is not stored yet is made, because the number of unknowns depends on it.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer check finger-convergence            every case of the study, the first one in detail
  durometer check studies/finger-dynamics/scene.toml
  durometer check my-scene.toml --figure regions.png
  durometer check my-scene.toml --set mesh.cells=9300 --set 'stage.0.dt=\"10 ms\"'

Exit codes: 0 the file can be run, 2 it cannot (the message says where and why).")]
pub struct Args {
    /// Scene or study file (TOML), or the name of a study
    file: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Draw the body with its regions, what is held, and its cables: a file in .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
}

pub fn main(args: Args) -> CommandResult {
    threads::use_threads(threads::available());
    let file = files::find_any(&args.file)?;
    let changes = super::arguments::changes(&args.set)?;
    if files::is_study(&file) {
        return study(&Study::read(&file, &changes)?, args.figure.as_deref());
    }
    let (spec, text) = read_scene(&file, &changes)?;
    let body = body(&file, &spec, &mut Bodies::new())?;
    let scene = Scene::build(&file, spec, text, body)?;
    durometer::study::overlay::markers::read(&scene)?;
    describe(&scene);
    picture(args.figure.as_deref(), &scene)
}

/// Cases that are built at the same time.
const AT_ONCE: usize = 8;

fn picture(file: Option<&Path>, scene: &Scene) -> CommandResult {
    if let Some(file) = file {
        body_figure::write(file, scene)?;
        say!("\n{} shows the regions", file.display());
    }
    Ok(Outcome::Complete)
}

fn study(study: &Study, figure: Option<&Path>) -> CommandResult {
    say!("study {} ({}): {}", study.name, study.record.kind, study.record.question);
    say!("{} cases; tolerance {} %", study.cases.len(), shown(study.record.tolerance * 100.0));
    say!("\n  {:32} {:11} {:>8} {:>9} {:>6}", "case", "", "cells", "unknowns", "steps");
    let (mut bodies, mut first, mut refused) = (Bodies::new(), None, vec![]);
    for cases in study.cases.chunks(AT_ONCE) {
        let on: Vec<_> = cases.iter().map(|case| body(&case.scene_file, &case.spec, &mut bodies)).collect();
        // Only the first scene is kept, because scenes can be large
        let rows = threads::map(cases.iter().zip(on).enumerate().collect(), |(k, (case, body))| {
            checked(study, case, body?).map(|scene| (row(case, &scene), (k == 0).then_some(scene)))
        });
        for (case, row) in cases.iter().zip(rows) {
            match row {
                Ok((row, scene)) => {
                    say!("{row}");
                    first = first.or(scene.map(|scene| (&case.id, scene)));
                }
                Err(error) => refused.push((&case.id, error)),
            }
        }
    }
    if let Some(error) = refusal(refused) {
        return Err(error);
    }
    for (variant, quantities) in &study.record.quantities {
        let names: Vec<&str> = quantities.iter().map(|q| q.name.as_str()).collect();
        say!("\nvariant {variant} judges {}", names.join(", "));
    }
    if let Some((id, scene)) = first {
        say!("\n{id} in detail:");
        describe(&scene);
        return picture(figure, &scene);
    }
    Ok(Outcome::Complete)
}

/// Why a scene cannot be run.
type Refusal = Box<dyn std::error::Error + Send + Sync>;

/// Meshes by the text of what they are made from, or the reason why there is none.
type Bodies = BTreeMap<String, Result<Arc<Body>, String>>;

/// Returns the mesh of a scene, which is loaded or refused only once.
fn body(file: &Path, spec: &SceneSpec, bodies: &mut Bodies) -> Result<Arc<Body>, String> {
    let make = || Body::load(file, &spec.mesh, &mut |line| tell!("{line}")).map(Arc::new).map_err(|e| e.to_string());
    // The path of a mesh file is relative to the folder of the scene
    bodies.entry(format!("{:?} {:?}", file.parent(), spec.mesh)).or_insert_with(make).clone()
}

/// Builds the scene of a case and checks that it can be run.
fn checked(study: &Study, case: &Case, body: Arc<Body>) -> Result<Scene, Refusal> {
    let scene = Scene::build(&case.scene_file, case.spec.clone(), case.text.clone(), body)?;
    Task::new(study, case.clone(), vec![], false).check(&scene)?;
    Ok(scene)
}

/// The line of a case in the table of a study.
fn row(case: &Case, scene: &Scene) -> String {
    format!(
        "  {:32} {:11} {:>8} {:>9} {:>6}",
        case.id,
        case.spec.formulation(),
        scene.body.mesh.cell_count(),
        scene.system.dofs.free.len(),
        steps(scene)
    )
}

/// Combines the errors of all refused cases into one, in which a fact that several cases share is stated once.
fn refusal(refused: Vec<(&String, Refusal)>) -> Option<Box<dyn std::error::Error>> {
    let mut facts: Vec<(String, Vec<&str>)> = vec![];
    for (id, error) in &refused {
        let fact = error.to_string();
        match facts.iter_mut().find(|(known, _)| *known == fact) {
            Some((_, cases)) => cases.push(id),
            None => facts.push((fact, vec![id])),
        }
    }
    if facts.len() < 2 {
        return refused.into_iter().next().map(|(_, error)| -> Box<dyn std::error::Error> { error });
    }
    let lines = facts.iter().map(|(fact, cases)| match cases[..] {
        [case] => format!("\n  {case}: {fact}"),
        [first, ..] => format!("\n  {first} and {} more: {fact}", cases.len() - 1),
        [] => String::new(),
    });
    Some(format!("{} cases cannot be run:{}", refused.len(), lines.collect::<String>()).into())
}

fn steps(scene: &Scene) -> usize {
    scene.spans.iter().map(durometer::solve::TimeSpan::steps).sum()
}

/// The kinds that the scene does not declare.
fn absent(kinds: &[&str], declared: &[&str]) -> String {
    let rest: Vec<&str> = kinds.iter().filter(|kind| !declared.contains(kind)).copied().collect();
    if rest.is_empty() { "none".into() } else { rest.join(", ") }
}

/// Returns the table of the scene that an effect not declared by an `[[effect]]` comes from, and a description of its keys.
fn origin(scene: &Scene, name: &str) -> (&'static str, String) {
    let spec = &scene.spec;
    let contact = spec.contacts.iter().find(|c| name == c.name || name.strip_suffix("_friction") == Some(&c.name));
    if let Some(c) = contact {
        let response = c.response.name();
        let words = format!("{}, region {}, {response}, friction {}", c.obstacle.words(), c.region, c.friction);
        let scales =
            scene.contacts.iter().find(|contact| contact.name == name).map(|contact| contact.scales.words(c.response));
        return ("contact", scales.map_or(words.clone(), |scales| format!("{words}, {scales}")));
    }
    let of_body = |body: &str| name.strip_prefix(body).is_some_and(|part| part.starts_with('_'));
    match spec.rigids.iter().find(|r| of_body(&r.name)) {
        Some(r) => ("rigid body", format!("{}, density {} kg/m^3", r.shape.words(), shown(r.density.0))),
        None => ("effect", "load of a constraint".into()),
    }
}

/// Regions of the file that no other key of the scene names.
fn unused_regions(scene: &Scene) -> Vec<&String> {
    let mut named = BTreeSet::new();
    if let Ok(table) = scene.text.parse() {
        texts(&toml::Value::Table(table), &mut named);
    }
    scene.spec.mesh.regions.keys().filter(|name| !named.contains(*name)).collect()
}

/// All texts that are values in a table.
fn texts(value: &toml::Value, found: &mut BTreeSet<String>) {
    match value {
        toml::Value::String(text) => _ = found.insert(text.clone()),
        toml::Value::Array(list) => list.iter().for_each(|value| texts(value, found)),
        toml::Value::Table(table) => table.iter().for_each(|(_, value)| texts(value, found)),
        _ => {}
    }
}

fn describe(scene: &Scene) {
    let mesh = &scene.body.mesh;
    let (low, high) = mesh.bounding_box();
    let size = (high - low) * 1e3;
    if !scene.title.is_empty() {
        say!("title        {}", scene.title);
    }
    say!("mesh         {} ({} cells, {} nodes)", scene.body.source, mesh.cell_count(), mesh.points.len());
    say!(
        "size         {:.4} × {:.4} × {:.4} mm, mean cell h = {:.4} mm",
        Decimals(size.x),
        Decimals(size.y),
        Decimals(size.z),
        Decimals(mesh.h() * 1e3)
    );
    say!("regions      {}", region_table::table(scene));
    if let Some(law) = &scene.law {
        let info = law.info();
        let values = info.parameters.iter().zip(law.values()).map(|(p, v)| {
            let unit = if p.dimension == Dimension::PRESSURE { " Pa" } else { "" };
            format!("{} = {}{unit}", p.name, shown(v))
        });
        say!("law          {} ({})", info.name, values.collect::<Vec<_>>().join(", "));
    }
    // Effects in the order of the file, then the effects of constraints, rigid bodies and contacts
    for (k, effect) in scene.system.effects.iter().enumerate() {
        let (what, words) = match scene.spec.effects.get(k) {
            Some(spec) => ("effect", spec.words()),
            None => origin(scene, effect.name()),
        };
        let blocks = match effect.capabilities().transient.is_some() {
            true => "blocks where parts meet".into(),
            false => format!("{} blocks", effect.blocks().len()),
        };
        say!("{what:12} {} ({blocks}): {words}", effect.name());
    }
    for rows in scene.system.constraints.chunk_by(|a, b| a.name() == b.name()) {
        let blocks: usize = rows.iter().map(|row| row.blocks().len()).sum();
        match rows.iter().filter(|row| row.kind() != ConstraintKind::Monitored).count() {
            1 => say!("constraint   {} (exact row with multiplier, {blocks} blocks)", rows[0].name()),
            n => say!("constraint   {} ({n} exact rows with multipliers, {blocks} blocks)", rows[0].name()),
        }
    }
    say!("prescribed   {} degrees of freedom", scene.system.prescribed.len());
    let effects: Vec<&str> = scene.spec.effects.iter().map(EffectSpec::kind).collect();
    let constraints: Vec<&str> = scene.spec.constraints.iter().map(ConstraintSpec::kind).collect();
    say!("not there    effects: {}", absent(EffectSpec::KINDS, &effects));
    say!("             constraints: {}", absent(ConstraintSpec::KINDS, &constraints));
    let tables = [("contact", scene.spec.contacts.is_empty()), ("rigid bodies", scene.spec.rigids.is_empty())];
    tables.iter().filter(|(_, is_absent)| *is_absent).for_each(|(name, _)| say!("             {name}"));
    say!("nothing else is assembled");
    say!("unknowns     {}, {} entries in the tangent", scene.system.dofs.free.len(), scene.system.pattern.nnz());
    for s in &scene.signals {
        if s.signal.has_inputs() {
            say!("signal       {}, decided during the run", s.name);
            continue;
        }
        let ((_, low), (t, high)) = extremes(&s.signal, &scene.spans);
        let (low, high) = (shown(low), shown(high));
        match low == high {
            true => say!("signal       {} constant {low}", s.name),
            false => say!("signal       {} between {low} and {high} (at {:.4} s)", s.name, Decimals(t)),
        }
    }
    for span in &scene.spans {
        let (steps, name) = (span.steps(), span.integrator.name());
        let [start, end, dt] = [span.start, span.end, span.dt].map(shown);
        say!("stage        {name} from {start} s to {end} s: {steps} steps of {dt} s");
    }
    say!("records      {}", scene.columns().join("\n             "));
    scene.notes.iter().for_each(|note| say!("{:12} {note}", scene.kind_of_note(note)));
    limits_of_scene(scene).iter().for_each(|(kind, limit)| say!("{kind:12} {limit}"));
    unused_regions(scene).iter().for_each(|name| say!("note         nothing uses the region {name}"));
    if let Some(why) = &scene.no_limit {
        say!("note         {why}: the answer has no limit as h → 0, a convergence study refuses its verdict");
    }
}
