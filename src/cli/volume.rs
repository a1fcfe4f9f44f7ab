//! `durometer volume CSV… --experiment KIND`

use super::arguments::contents;
use super::files;
use super::outcome::{CommandResult, Outcome};
use super::results::ReplaceArgs;
use durometer::calibrate::volume::{VolumeRequest, VolumeTest, fit_volume};
use durometer::calibrate::{Sign, StretchRange};
use durometer::report::ReportError;
use std::path::PathBuf;

/// Fit Poisson's ratio to lateral strain, or the bulk modulus to pressure over volume (CSV), and write volume.toml with the keys for a law
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer volume pull.csv --experiment lateral
  durometer volume one.csv two.csv three.csv --experiment lateral --range 1..1.3
  durometer volume compression.csv --experiment bulk --volumetric logarithmic
  durometer volume dic.csv --experiment lateral --column strain=eyy --column lateral=exx --unit strain=1 --unit lateral=1

Columns: strain and lateral (\"transverse strain\", \"Querdehnung\"), or pressure and volume (a ratio, or its change, negative under pressure).

Exit codes: 0 done, 2 bad input, 3 the data give a bound only, as where the interval of Poisson's ratio reaches 0.5.")]
pub struct Args {
    /// Table of the test (CSV); several files are specimens of the same test
    #[arg(required = true)]
    csv: Vec<PathBuf>,
    /// Kind of test: lateral (strain along and transverse to the load), bulk (pressure over volume)
    #[arg(long, value_name = "KIND")]
    experiment: VolumeTest,
    /// Volumetric part of a bulk test: quadratic, logarithmic, simo_taylor [default: the one with the least misfit]
    #[arg(long)]
    volumetric: Option<String>,
    /// Name of a column, or its number: strain=eyy, lateral='#3'; contents: strain, lateral, pressure, volume
    #[arg(long, value_name = "CONTENT=NAME")]
    column: Vec<String>,
    /// Unit of a column: strain=%, pressure=bar
    #[arg(long, value_name = "CONTENT=UNIT")]
    unit: Vec<String>,
    /// Stretches along the load that are fitted, e.g. 1..1.3 [default: every data point]
    #[arg(long)]
    range: Option<StretchRange>,
    /// Load whose strain the table counts as positive: tension or compression [default: tension, unless the column is called compressive]
    #[arg(long, value_name = "LOAD")]
    positive: Option<Sign>,
    /// Folder of the results [default: reports/volume-<name of the table>]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
    /// Print volume.json instead of text
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> CommandResult {
    let Args { csv, experiment: test, volumetric, column, unit, range, positive, out, replace, json } = args;
    let csv = files::all_brought(&csv)?;
    let (columns, units) = (contents(&column)?, contents(&unit)?);
    let (data, more) = (csv[0].clone(), csv[1..].to_vec());
    let stem = data.file_stem().map_or_else(|| "data".into(), |n| n.to_string_lossy().into_owned());
    let out = out.unwrap_or_else(|| PathBuf::from("reports").join(format!("volume-{stem}")));
    let fit = fit_volume(&VolumeRequest { data, more, test, columns, units, volumetric, range, positive })?;
    let undrawn = replace.check(&out, "volume", test.name(), &csv)?.write(|folder| {
        fit.write_keys(&folder.join("volume.toml"))?;
        fit.write_json(&folder.join("volume.json"))?;
        Ok::<_, Box<dyn std::error::Error>>(ReportError::of_figure(durometer::report::service_fit::write(folder))?)
    })?;
    if json {
        say!("{}", serde_json::to_string_pretty(&fit)?);
    } else {
        say!("{fit}");
        say!("results: {}, report: {}", out.join("volume.toml").display(), out.join("index.html").display());
    }
    undrawn.map_or(Ok(()), Err)?;
    Ok(if fit.is_determined() { Outcome::Complete } else { Outcome::NotDetermined })
}
