//! `durometer simulate SCENE`

use super::{INCOMPLETE, Outcome, bars::Bars, files};
use durometer::scene::{Body, Constant, Scene, read_scene};
use durometer::solve::Status;
use durometer::study::fields::Fields;
use durometer::study::locking::REMEDY;
use durometer::study::record::CaseRecord;
use durometer::study::runner::{self, Watch};
use durometer::study::store;
use durometer::study::words::seconds;
use durometer::system::State;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Run one scene and write its time series
///
/// Writes <name>.csv (what the probes record), <name>.signals.csv (what is prescribed), <name>.json (the
/// record, with the time each effect took), and fields for ParaView on request.
///
/// A run that does not complete keeps everything up to its last good state.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer simulate studies/finger-dynamics/scene.toml
  durometer simulate my-scene.toml --set mesh.cells=9300 --out out
  durometer simulate my-scene.toml --set 'constraint.cable.drive={ tension = \"2 N\" }' --vtu
  durometer simulate finger-convergence --slope laws.rubber.mu --slope laws.rubber.nu

In --set a step into a list is its index from 0, or the name or kind of an entry.
Exit codes: 0 converged, 2 bad input, 3 the run did not complete.")]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,
    /// Folder of the results
    #[arg(long, default_value = "reports/simulate")]
    out: PathBuf,
    /// Change a key, e.g. --set mesh.cells=9300
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Write displacement and stretch at every step of the time grid as VTU, with a PVD collection
    #[arg(long)]
    vtu: bool,
    /// Write <name>.slopes.csv: exact derivatives of positions, angles, reactions and cables by a constant of a law, e.g.
    /// --slope laws.rubber.mu, several times; not in implicit_euler_linearised
    #[arg(long, value_name = "CONSTANT")]
    slope: Vec<String>,
    /// Print the record instead of progress
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let file = files::find(&args.scene, "scene.toml")?;
    let (spec, text) = read_scene(&file, &super::changes(&args.set)?)?;
    let name = file.file_stem().map_or_else(|| "scene".into(), |n| n.to_string_lossy().into_owned());
    let bars = Bars::new(args.json);
    let body = Body::load(&file, &spec.mesh, &mut |line| bars.meshing(&name, line))?;
    let scene = Scene::build(&file, spec, text, body.into())?;
    let constants: Vec<Constant> = args.slope.iter().map(|text| text.parse()).collect::<Result<_, _>>()?;
    files::make_folder(&args.out)?;
    if !args.json {
        scene.remarks.iter().for_each(|remark| eprintln!("note: {remark}"));
    }
    bars.started(&name);
    let stop = super::stop_flag();
    let mut fields = args.vtu.then(|| Fields::new(&args.out, &name));
    let (wall, cpu) = (Instant::now(), cpu_time::ThreadTime::now());
    let mut watch = |progress| {
        bars.progress(&name, progress);
        !stop.load(Ordering::Relaxed)
    };
    let mut states = |state: &State| {
        if let Some(fields) = &mut fields {
            fields.add(&scene, state);
        }
    };
    let (run, slopes) = match constants.is_empty() {
        true => (scene.run(&mut watch, &mut states), None),
        false => scene.run_with_slopes(&constants, &mut watch, &mut states).map(|(run, slopes)| (run, Some(slopes)))?,
    };
    // Derivatives are no part of the price of the run.
    let aside = slopes.as_ref().map_or((0.0, 0.0), |s| (s.wall, s.cpu));
    let mut times = (wall.elapsed().as_secs_f64() - aside.0, cpu.elapsed().as_secs_f64() - aside.1);
    if let Some(fields) = fields {
        let (wall, cpu) = fields.finish()?;
        times = (times.0 - wall, times.1 - cpu);
    }
    let mut record = runner::record(&scene, &run, times);
    record.id.clone_from(&name);
    store::write(&args.out.join(format!("{name}.csv")), &store::csv(&run))?;
    store::write(&args.out.join(format!("{name}.signals.csv")), &store::signals_csv(&scene, &run))?;
    if let Some(slopes) = &slopes {
        store::write(&args.out.join(format!("{name}.slopes.csv")), &store::slopes_csv(&run, slopes))?;
    }
    let json = serde_json::to_string_pretty(&record)?;
    store::write(&args.out.join(format!("{name}.json")), &json)?;
    bars.finished(&record, false);
    if !args.json {
        record.remarks[scene.remarks.len()..].iter().for_each(|remark| eprintln!("note: {remark}"));
    }
    if let Some(l) = record.locking.filter(|l| l.alarm && !args.json) {
        let scatter = l.pressure_scatter;
        eprintln!("locking alarm: the pressures scatter by {scatter:.2} of the deviatoric stress; {REMEDY}");
    }
    if args.json {
        println!("{json}");
    } else {
        for (probe, value) in &record.probes {
            let (peak, last) = (plain(value.peak), plain(value.last));
            println!("{probe:28} peak {peak:>12} at {:.3} s   final {last:>12}", value.peak_t_s);
        }
        println!("{}", price(&record));
        println!("results: {}", args.out.join(format!("{name}.csv")).display());
        if args.vtu {
            println!("fields:  {} (open it in ParaView)", args.out.join(format!("{name}.pvd")).display());
        }
    }
    let stopped = slopes.and_then(|s| s.stopped);
    if let Some((t, why)) = &stopped {
        eprintln!("not complete: no derivative at t = {t} s: {why}");
    }
    let complete = run.status == Status::Converged && stopped.is_none();
    Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(INCOMPLETE) })
}

/// Where the time went: every effect and constraint that is assembled, then the linear algebra.
fn price(record: &CaseRecord) -> String {
    let share = |(name, s): (&str, f64)| format!("{name} {} ({:.0} %)", seconds(s), 100.0 * s / record.wall_s);
    let effects = record.effects.iter().map(|e| (e.name.as_str(), e.wall_s));
    let p = &record.phases;
    let all = effects.chain([("factorisation", p.factorisation_s), ("solve", p.solve_s)]);
    format!("time: {} in all, of it {}", seconds(record.wall_s), all.map(share).collect::<Vec<_>>().join(", "))
}

/// Five digits, whatever the size.
fn plain(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e6).contains(&size) { format!("{value:.5}") } else { format!("{value:.4e}") }
}
