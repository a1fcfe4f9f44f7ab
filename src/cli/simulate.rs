//! `durometer simulate SCENE`

use super::{INCOMPLETE, Outcome, bars::Bars};
use durometer::mesh::vtu::{Data, write_pvd, write_vtu};
use durometer::scene::{Body, Scene, read_scene};
use durometer::solve::Status;
use durometer::study::runner::{self, Watch};
use durometer::study::store;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Runs one scene; writes <name>.csv (time series) and <name>.json (record), and fields for ParaView on request.
#[derive(clap::Args)]
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
    /// Print the record instead of progress
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let file = super::find(&args.scene, "scene.toml");
    let (spec, text) = read_scene(&file, &super::changes(&args.set)?)?;
    let name = file.file_stem().map_or_else(|| "scene".into(), |n| n.to_string_lossy().into_owned());
    let bars = Bars::new(args.json);
    let body = Body::load(&file, &spec.mesh, &mut |line| bars.meshing(&name, line))?;
    let scene = Scene::build(&file, spec, text, body.into())?;
    std::fs::create_dir_all(&args.out).map_err(|e| format!("{}: cannot be made: {e}", args.out.display()))?;
    if !args.json {
        scene.remarks.iter().for_each(|remark| eprintln!("note: {remark}"));
    }
    bars.started(&name);
    let stop = super::stop_flag();
    let (mut frames, mut failure) = (Vec::new(), None);
    let (wall, cpu) = (Instant::now(), cpu_time::ThreadTime::now());
    let run = scene.run(
        &mut |progress| {
            bars.progress(&name, progress);
            !stop.load(Ordering::Relaxed)
        },
        &mut |state| {
            if args.vtu && failure.is_none() {
                let frame = format!("{name}-{:04}.vtu", frames.len());
                let stretch = scene.nodal_stretch(&state.x);
                let data = [
                    Data {
                        name: "displacement_m",
                        components: 3,
                        values: &state.x[..3 * scene.body.mesh.points.len()],
                    },
                    Data { name: "stretch", components: 1, values: &stretch },
                ];
                failure = write_vtu(&args.out.join(&frame), &scene.body.mesh, &data, &[]).err();
                frames.push((state.t, frame));
            }
        },
    );
    let times = (wall.elapsed().as_secs_f64(), cpu.elapsed().as_secs_f64());
    if let Some(error) = failure {
        return Err(error.into());
    }
    if args.vtu {
        write_pvd(&args.out.join(format!("{name}.pvd")), &frames)?;
    }
    let mut record = runner::record(&scene, &run, times);
    record.id.clone_from(&name);
    store::write(&args.out.join(format!("{name}.csv")), &store::csv(&run))?;
    let json = serde_json::to_string_pretty(&record)?;
    store::write(&args.out.join(format!("{name}.json")), &json)?;
    bars.finished(&record, false);
    if args.json {
        println!("{json}");
    } else {
        for (probe, value) in &record.probes {
            println!("{probe:28} peak {:>14.6} at {:.3} s   final {:>14.6}", value.peak, value.peak_t_s, value.last);
        }
        println!("results: {}", args.out.join(format!("{name}.csv")).display());
    }
    Ok(if run.status == Status::Converged { ExitCode::SUCCESS } else { ExitCode::from(INCOMPLETE) })
}
