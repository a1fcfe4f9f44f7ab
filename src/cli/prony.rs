//! `durometer prony CSV… --experiment KIND`

use super::arguments::contents;
use super::files;
use super::outcome::{CommandResult, Outcome};
use super::results::ReplaceArgs;
use durometer::calibrate::relaxation::{RelaxationRequest, TermChoice, TestKind, fit_relaxation};
use durometer::math::units::{self, Dimension};
use durometer::report::ReportError;
use std::path::PathBuf;

/// Fit a Prony series to relaxation, creep, loading or dynamic data (CSV) and write prony.toml, which a scene can include
///
/// The number of terms is chosen from the data, and every modulus ratio and time has a 95 % interval. The duration of the loading is taken
/// into account.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer prony relaxation.csv --experiment relaxation --ramp '0.5 s'
  durometer prony one.csv two.csv three.csv --experiment relaxation --ramp '0.5 s'
  durometer prony creep.csv --experiment creep --ramp '0.2 s' --stress '20 kPa'
  durometer prony cycles.csv --experiment history --law law.toml
  durometer prony dma.csv --experiment dynamic --per-decade 1
  durometer prony machine.csv --experiment relaxation --ramp '1 s' --start '12 s' --column 'stress=Load (N)' --unit time=ms

A scene includes the result in its effect of kind \"viscoelastic\":  prony = { include = \"prony.toml\" }
Experiments: relaxation (time; stress, force or modulus), creep (time, strain), history (time, strain, stress: loading and unloading), dynamic
(frequency, storage, and loss or tan_delta).

Exit codes: 0 done, 2 bad input, 3 the data do not determine the long-term modulus (the output says why).")]
pub struct Args {
    /// Table of the test (CSV); several files are specimens of the same test
    #[arg(required = true)]
    csv: Vec<PathBuf>,
    /// Kind of test: relaxation, creep, history, dynamic
    #[arg(long, value_name = "KIND")]
    experiment: TestKind,
    /// Duration of the loading at a constant rate before the hold, e.g. "0.5 s"; "0 s" for an ideal step
    #[arg(long, value_name = "TIME")]
    ramp: Option<String>,
    /// Time in the table at which the loading begins, e.g. "12 s" on a logger's clock [default: 0 s, if the data begin soon after the loading]
    #[arg(long, value_name = "TIME")]
    start: Option<String>,
    /// Held stress of a creep test, for moduli in pascals
    #[arg(long)]
    stress: Option<String>,
    /// Law file of the elastic response, for a uniaxial history at finite strain
    #[arg(long)]
    law: Option<PathBuf>,
    /// Number of terms [default: by the Bayesian information criterion]
    #[arg(long, conflicts_with_all = ["times", "per_decade"])]
    terms: Option<usize>,
    /// Times of the terms, e.g. '0.1 s,1 s,10 s' (for a creep test, retardation times)
    #[arg(long, value_delimiter = ',', conflicts_with = "per_decade")]
    times: Vec<String>,
    /// Number of logarithmically spaced times in each decade of the data
    #[arg(long, value_name = "N")]
    per_decade: Option<usize>,
    /// Name of a column, or its number: time=t, stress='#3'; contents: time, strain, stress, frequency, storage, loss, tan_delta
    #[arg(long, value_name = "CONTENT=NAME")]
    column: Vec<String>,
    /// Unit of a column: time=ms, storage=MPa
    #[arg(long, value_name = "CONTENT=UNIT")]
    unit: Vec<String>,
    /// Folder of the results [default: reports/prony-<name of the table>]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
    /// Print prony.json instead of text
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let csv = files::all_brought(&args.csv)?;
    let mut request = RelaxationRequest::new(&csv[0], args.experiment);
    request.more = csv[1..].to_vec();
    let seconds = |text: &String| units::parse(text, Dimension::TIME);
    request.ramp = args.ramp.as_ref().map(seconds).transpose()?;
    request.start = args.start.as_ref().map(seconds).transpose()?;
    request.stress = args.stress.map(|text| units::parse(&text, Dimension::PRESSURE)).transpose()?;
    request.law = args.law.as_deref().map(files::brought).transpose()?;
    request.terms = match (args.terms, args.per_decade) {
        (Some(n), _) => TermChoice::Number(n),
        (None, Some(n)) => TermChoice::PerDecade(n),
        (None, None) if args.times.is_empty() => TermChoice::Evidence,
        (None, None) => TermChoice::Times(args.times.iter().map(seconds).collect::<Result<_, _>>()?),
    };
    request.columns = contents(&args.column)?;
    request.units = contents(&args.unit)?;
    let stem = args.csv[0].file_stem().map_or_else(|| "data".into(), |n| n.to_string_lossy().into_owned());
    let out = args.out.unwrap_or_else(|| PathBuf::from("reports").join(format!("prony-{stem}")));
    let fit = fit_relaxation(&request)?;
    let undrawn = args.replace.check(&out, "prony", request.kind.name(), &csv)?.write(|folder| {
        fit.write_series(&folder.join("prony.toml"))?;
        fit.write_json(&folder.join("prony.json"))?;
        Ok::<_, Box<dyn std::error::Error>>(ReportError::of_figure(durometer::report::service_fit::write(folder))?)
    })?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(&fit)?);
    } else {
        say!("{fit}");
        say!("results: {}, report: {}", out.join("prony.toml").display(), out.join("index.html").display());
    }
    undrawn.map_or(Ok(()), Err)?;
    Ok(if fit.is_determined() { Outcome::Complete } else { Outcome::NotDetermined })
}
