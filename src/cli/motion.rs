//! `durometer motion FILE...`

use super::files;
use super::motion_tables as tables;
use super::outcome::{CommandResult, Outcome};
use super::results::ReplaceArgs;
use super::style::StyleArgs;
use durometer::math::tensor::Vec3;
use durometer::math::units::{self, Dimension, UnitError};
use durometer::motion::plateau::PlateauRule;
use durometer::motion::release::ReleaseRule;
use durometer::motion::repeats::check_distinct;
use durometer::motion::ring_down::Creep;
use durometer::motion::{BodyRequest, Evaluation, MotionRequest, ReadOptions, Tracks, evaluate_tracks};
use durometer::report::motion::{methods, picture};
use durometer::report::{export, files as output, style};
use durometer::wording::numbered;
use std::path::{Path, PathBuf};

/// Evaluate measured motion: marker tracks (C3D, TRC, CSV) with their states, the release, the motion of a body, frequency and decay
///
/// Every decision is in the audit that is printed: format, unit, rate, gaps, registration, windows, release. Several files are repeats of one
/// experiment and are pooled.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer motion gravity_a.csv gravity_b.csv --body tip1,tip2,tip3 --at '100 mm,0,0'
  durometer motion gravity_a.csv --body tip1,tip2,tip3 --ring-down displacement_z_m --window '0.3 s,1.6 s' --threshold '0.1 mm'
  durometer motion capture.c3d --reference markers.csv --unit mm
  durometer motion positions.csv --record m1_u005

A table has one row per time (t_s, tip_x_mm, tip_y_mm, tip_z_mm, ...) or one row per marker (marker, x_mm, y_mm, z_mm, with t_s where there are several
times). The reference of a registration is such a table of positions in the frame of the body.

Exit codes: 0 done, 2 bad input.")]
pub struct Args {
    /// Files of the same experiment
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Unit of the coordinates, e.g. mm [default: as stated in the file]
    #[arg(long)]
    unit: Option<String>,
    /// Unit of the times of a table, e.g. ms [default: as stated in the file, otherwise s]
    #[arg(long, value_name = "UNIT")]
    time_unit: Option<String>,
    /// Frames per second, if the file has no times or wrong ones
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Name of the record to read from a table with several
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// Three or more markers that move as a rigid body
    #[arg(long, value_name = "MARKERS", value_delimiter = ',')]
    body: Vec<String>,
    /// Tracked point of the body, in the held state: '100 mm,0,0' [default: the centroid of its markers]
    #[arg(long, value_name = "X,Y,Z", value_delimiter = ',', requires = "body", allow_hyphen_values = true)]
    at: Vec<String>,
    /// Table of marker positions in the frame of the body, onto which the held state is registered
    #[arg(long, value_name = "FILE")]
    reference: Option<PathBuf>,
    /// Window of the held state: '-0.2 s,0 s' [default: the first plateau]
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', allow_hyphen_values = true)]
    held: Vec<String>,
    /// Window of the final state [default: the plateau that extends to the end]
    #[arg(long = "final", value_name = "FROM,TO", value_delimiter = ',', allow_hyphen_values = true)]
    last: Vec<String>,
    /// Deviation from the held state that counts as release, e.g. '0.1 mm' [default: five standard deviations]
    #[arg(long, value_name = "LENGTH")]
    threshold: Option<String>,
    /// Curve whose frequency and decay are evaluated: displacement_z_m, tip_z_m
    #[arg(long, value_name = "CURVE", requires = "window")]
    ring_down: Option<String>,
    /// Window of the ring-down, after the release
    #[arg(long, value_name = "FROM,TO", value_delimiter = ',', requires = "ring_down", allow_hyphen_values = true)]
    window: Vec<String>,
    /// Slow motion superimposed on the vibration: none, linear, logarithmic
    #[arg(long, default_value = "logarithmic")]
    creep: Creep,
    #[command(flatten)]
    style: StyleArgs,
    /// Folder of the results [default: reports/motion-<name of the first file>, with "-and-<n>-more" for several files]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
}

pub fn main(args: Args) -> CommandResult {
    style::within(args.style.style()?, || draw(args))
}

fn draw(args: Args) -> CommandResult {
    let (request, files) = (request(&args)?, files::all_brought(&args.files)?);
    let one = |file: &PathBuf| -> Result<Evaluation, Box<dyn std::error::Error>> {
        let tracks = Tracks::read(file, &request.read)?;
        evaluate_tracks(tracks, &request).map_err(|e| format!("{}: {e}", file.display()).into())
    };
    let mut found: Vec<Evaluation> = files.iter().map(one).collect::<Result<_, _>>()?;
    let named: Vec<_> = files.iter().map(|f| f.display().to_string()).zip(found.iter().map(|e| &e.tracks)).collect();
    check_distinct(&named)?;
    // Repeats in different folders may have the same file name
    let names = numbered(&args.files.iter().map(|f| stem(f)).collect::<Vec<_>>(), "-");
    found.iter_mut().zip(names).for_each(|(evaluation, name)| evaluation.source = name);
    let out = args.out.clone().unwrap_or_else(|| usual_folder(&args.files));
    let results = args.replace.check(&out, "motion", args.record.as_deref().unwrap_or_default(), &files)?;
    let said = results.write(|folder| write(folder, &args.files, &found))?;
    say!("{said}");
    say!(
        "\nresults: {}, figures: {}, paper: {}",
        out.display(),
        out.join("figures").display(),
        out.join("paper").display()
    );
    Ok(Outcome::Complete)
}

/// Returns the default folder of the results of these files; several files have a folder different from that of the first file alone.
fn usual_folder(files: &[PathBuf]) -> PathBuf {
    let first = stem(&files[0]);
    let name = match files.len() - 1 {
        0 => format!("motion-{first}"),
        more => format!("motion-{first}-and-{more}-more"),
    };
    PathBuf::from("reports").join(name)
}

fn stem(file: &Path) -> String {
    file.file_stem().map_or_else(|| "record".into(), |n| n.to_string_lossy().into_owned())
}

/// Writes curves, figures, tables and the paper of these files, each under the name in its evaluation, and returns the audit with the tables as text.
fn write(folder: &Path, files: &[PathBuf], found: &[Evaluation]) -> Result<String, Box<dyn std::error::Error>> {
    output::folder(&folder.join("figures"))?;
    let (mut audit, mut figures) = (String::new(), vec![]);
    for (file, evaluation) in files.iter().zip(found) {
        let name = &evaluation.source;
        let renamed = if *name == stem(file) { String::new() } else { format!(", called {name} here") };
        audit += &format!("{}{renamed}\n", file.display());
        audit.extend(evaluation.log.iter().map(|line| format!("  {line}\n")));
        audit.extend(evaluation.doubts.iter().map(|line| format!("  doubt: {line}\n")));
        output::write(&folder.join(format!("{name}-curves.csv")), tables::curves(evaluation).as_bytes())?;
        if let Some(figure) = picture::draw(name, evaluation) {
            export::save(&folder.join("figures"), &figure)?;
            figures.push(figure.name);
        }
    }
    output::write(&folder.join("audit.txt"), audit.as_bytes())?;
    let mut said = audit.trim_end().to_string();
    let tables = [tables::states(found), tables::ring_downs(found), tables::repeats(found)?];
    for table in tables.iter().filter(|t| !t.rows.is_empty()) {
        table.save(folder)?;
        said += &format!("\n\n{}", tables::text(table).trim_end());
    }
    let written: Vec<&str> = tables.iter().filter(|t| !t.rows.is_empty()).map(|t| t.name).collect();
    methods::write(folder, found, &written, &figures)?;
    Ok(said)
}

fn request(args: &Args) -> Result<MotionRequest, Box<dyn std::error::Error>> {
    let times = |texts: &[String], flag: &str| match texts {
        [] => Ok(None),
        [from, to] => {
            let [from, to] = [units::parse(from, Dimension::TIME)?, units::parse(to, Dimension::TIME)?];
            let ordered: Result<_, Box<dyn std::error::Error>> = Ok(Some([from, to]));
            if from < to {
                ordered
            } else {
                Err(format!("{flag}: {from} s is not before {to} s; exchange them").into())
            }
        }
        _ => Err(format!("{flag}: two times are wanted, such as '0.3 s,1.6 s'").into()),
    };
    let threshold = args.threshold.as_ref().map(|text| units::parse(text, Dimension::LENGTH)).transpose()?;
    let release = match threshold {
        Some(threshold) if threshold > 0.0 => ReleaseRule { factor: 0.0, threshold, ..ReleaseRule::default() },
        Some(_) => return Err("--threshold: a departure is above zero".into()),
        None => ReleaseRule::default(),
    };
    let body = (!args.body.is_empty())
        .then(|| point(&args.at).map(|at| BodyRequest { markers: args.body.clone(), at }))
        .transpose()?;
    let window = times(&args.window, "--window")?;
    Ok(MotionRequest {
        file: PathBuf::new(),
        read: ReadOptions {
            unit: args.unit.clone(),
            time_unit: args.time_unit.clone(),
            rate_hz: args.rate,
            record: args.record.clone(),
        },
        body,
        guides: vec![],
        reference: args.reference.clone(),
        held_s: times(&args.held, "--held")?,
        final_s: times(&args.last, "--final")?,
        ring_down: args.ring_down.clone().zip(window),
        creep: args.creep,
        plateau: PlateauRule::default(),
        release,
    })
}

/// Parses three lengths; a zero needs no unit.
fn point(texts: &[String]) -> Result<Option<Vec3>, Box<dyn std::error::Error>> {
    let length = |text: &String| match text.trim().parse::<f64>() {
        Ok(0.0) => Ok(0.0),
        _ => units::parse(text, Dimension::LENGTH),
    };
    match texts {
        [] => Ok(None),
        [_, _, _] => {
            let all: Vec<f64> = texts.iter().map(length).collect::<Result<_, UnitError>>()?;
            Ok(Some(Vec3::new(all[0], all[1], all[2])))
        }
        _ => Err("--at: three lengths are wanted, such as '100 mm,0,0'".into()),
    }
}
