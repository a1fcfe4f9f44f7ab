//! Commands of `durometer`. Their exit codes are in `outcome`.

#[macro_use]
mod stderr;
#[macro_use]
mod stdout;

pub mod arguments;
mod body_figure;
mod bundle;
mod cases;
mod check;
mod compare;
mod doctor;
mod engine;
mod file_size;
pub mod files;
mod fit;
mod import;
pub mod interrupt;
mod laws;
mod live;
mod memory;
mod mesh;
mod motion;
mod motion_tables;
mod new;
mod outcome;
mod plan;
mod progress;
mod prony;
mod region_table;
mod report;
mod results;
mod robustness;
mod run;
mod schema;
mod shown_regions;
mod simulate;
mod softening;
mod store;
mod studies;
mod style;
mod twin;
mod view;
mod volume;
mod worker;

use clap::{Parser, Subcommand};
use std::ffi::OsString;

/// Mesh-convergence studies, hyperelastic calibration and paper figures for soft-robot simulation.
///
/// To start, `durometer run finger-convergence` simulates a finger on several meshes and writes a report that says
/// which mesh can be trusted, with what error bar and at what cost. `durometer check FILE` describes what a file would simulate.
#[derive(Parser)]
#[command(
    name = "durometer",
    version,
    max_term_width = 110,
    after_help = "\
Start with:
  durometer new finger                    a project of your own, in the folder finger
  durometer studies                       the studies that the program brings
  durometer check finger-convergence      what would be simulated
  durometer run finger-convergence        simulate it; the report is reports/finger-convergence/index.html
  durometer simulate studies/finger-dynamics/scene.toml --vtu

Files are TOML; quantities carry their unit (\"18 kPa\", \"7.5 mm\"). `durometer COMMAND --help` has examples.
Exit codes: 0 done, 2 bad input, 3 some case did not complete."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Args),
    Studies(studies::Args),
    New(new::Args),
    Cases(cases::Args),
    Simulate(simulate::Args),
    Import(import::Args),
    Mesh(mesh::Args),
    Plan(plan::Args),
    Robustness(robustness::Args),
    Fit(Box<fit::Args>),
    Prony(prony::Args),
    Volume(volume::Args),
    Motion(Box<motion::Args>),
    Laws(laws::Args),
    Check(check::Args),
    Report(report::Args),
    View(view::Args),
    Twin(twin::Args),
    Compare(compare::Args),
    Bundle(bundle::Args),
    Store(store::Args),
    Schema(schema::Args),
    Doctor(doctor::Args),
    #[command(hide = true)]
    Worker(worker::Args),
}

/// Passes the studies, bodies and meshes that are packed into this program to the library.
pub fn bring_files() {
    durometer::catalogue::bring(durometer::catalogue::Archive {
        packed: durometer_files::PACKED,
        list: durometer_files::LIST,
        digest: durometer_files::DIGEST,
    });
}

/// Runs the command line, whose first argument is the name of the program, and returns the exit code. If `owns_process`, the process runs nothing else,
/// and a closed pipe may end it.
pub fn main(arguments: impl IntoIterator<Item = OsString>, owns_process: bool) -> u8 {
    memory::keep_freed();
    file_size::let_writes_fail();
    let code = match Cli::try_parse_from(arguments) {
        Ok(cli) => dispatch(cli.command, owns_process),
        Err(told) => {
            let printed = told.print();
            if !told.use_stderr() {
                stdout::kept(printed).ok();
            }
            u8::try_from(told.exit_code()).unwrap_or(2)
        }
    };
    match stdout::end() {
        Ok(()) => code,
        Err(why) => {
            tell!("error: {why}");
            outcome::UNWRITTEN
        }
    }
}

fn dispatch(command: Command, owns_process: bool) -> u8 {
    // Commands that keep finished results when they are stopped listen for signals, before any other thread starts
    if matches!(command, Command::Run(_) | Command::Robustness(_) | Command::Simulate(_) | Command::Plan(_)) {
        interrupt::stop_flag();
        interrupt::set_up(false);
    }
    // A reader that closes the pipe (`| head`) ends the program quietly; the end of a controller or of a case's process must not.
    let talks = match &command {
        Command::Simulate(args) => args.control.controller.is_some(),
        Command::Run(_) | Command::Robustness(_) | Command::Worker(_) => true,
        _ => false,
    };
    if owns_process && !talks {
        sigpipe::reset();
    }
    let result = match command {
        Command::Run(args) => run::main(args),
        Command::Studies(args) => studies::main(args),
        Command::New(args) => new::main(args),
        Command::Cases(args) => cases::main(args),
        Command::Simulate(args) => simulate::main(args),
        Command::Import(args) => import::main(args),
        Command::Mesh(args) => mesh::main(args),
        Command::Plan(args) => plan::main(args),
        Command::Robustness(args) => robustness::main(args),
        Command::Fit(args) => fit::main(*args),
        Command::Prony(args) => prony::main(args),
        Command::Volume(args) => volume::main(args),
        Command::Motion(args) => motion::main(*args),
        Command::Laws(args) => laws::main(args),
        Command::Check(args) => check::main(args),
        Command::Report(args) => report::main(args),
        Command::View(args) => view::main(args),
        Command::Twin(args) => twin::main(&args),
        Command::Compare(args) => compare::main(args),
        Command::Bundle(args) => bundle::main(args),
        Command::Store(args) => store::main(args),
        Command::Schema(args) => schema::main(&args),
        Command::Doctor(args) => doctor::main(args),
        Command::Worker(args) => worker::main(args),
    };
    // The failure of a mesher that the signal has ended is not an error in the input
    let result = match result {
        Err(error) if interrupt::was_stopped() => {
            tell!("stopped: {error}");
            Ok(outcome::Outcome::Interrupted)
        }
        result => result,
    };
    if let Err(error) = &result {
        tell!("error: {error}");
    }
    outcome::exit_code(&result)
}
