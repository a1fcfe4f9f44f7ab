//! `durometer fit CSV --law LAW`

use super::{Outcome, files};
use durometer::calibrate::{FitRequest, Mode, Partner, StrainKind, StretchRange, fit};
use durometer::math::units::{self, Dimension};
use std::path::PathBuf;
use std::process::ExitCode;

/// Fit a law to tensile data (CSV) and write law.toml, which a scene can include
///
/// The table is a CSV with a strain or stretch and a nominal stress column, units in the header, in card.toml beside it, or
/// by the flags. Nothing is changed silently: the audit log says which rows were unusual.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer fit data/treloar-1944/treloar-1944.csv --law neo_hookean --mode uniaxial --range 1..1.6 --nu 0.49
  durometer fit pull.csv --law neo_hookean --strain-column strain --stress-column 'stress [MPa]' --stress-unit MPa

A scene includes the result with:  [laws.rubber]  include = \"law.toml\"")]
pub struct Args {
    /// Tensile data (CSV)
    csv: PathBuf,
    /// Name of the law, e.g. neo_hookean
    #[arg(long)]
    law: String,
    /// Folder of the results [default: reports/fit-<name of the table>]
    #[arg(long)]
    out: Option<PathBuf>,
    /// Stretches that are fitted, e.g. 1..1.6 [default: every row]
    #[arg(long)]
    range: Option<StretchRange>,
    /// Mode to fit: uniaxial, equibiaxial, planar; several times to fit several
    #[arg(long)]
    mode: Vec<Mode>,
    /// Poisson's ratio of the law file: tensile data of an incompressible fit do not give it
    #[arg(long, conflicts_with = "kappa")]
    nu: Option<f64>,
    /// Bulk modulus of the law file instead of --nu, e.g. "2 GPa"
    #[arg(long)]
    kappa: Option<String>,
    /// Data card [default: card.toml beside the table]
    #[arg(long)]
    card: Option<PathBuf>,
    /// Name of the column of strain or stretch, if the table's header does not give it away
    #[arg(long)]
    strain_column: Option<String>,
    /// Name of the column of nominal stress
    #[arg(long)]
    stress_column: Option<String>,
    /// What the strain column holds: stretch or engineering
    #[arg(long)]
    strain_kind: Option<StrainKind>,
    /// Unit of the strain column: % or 1
    #[arg(long)]
    strain_unit: Option<String>,
    /// Unit of the stress column, e.g. MPa
    #[arg(long)]
    stress_unit: Option<String>,
    /// Print fit.json instead of words
    #[arg(long)]
    json: bool,
}

pub fn main(args: Args) -> Outcome {
    let mut request = FitRequest::new(&args.csv, &args.law);
    request.card = args.card;
    request.columns.strain = args.strain_column;
    request.columns.stress = args.stress_column;
    request.columns.strain_kind = args.strain_kind;
    request.columns.strain_unit = args.strain_unit;
    request.columns.stress_unit = args.stress_unit;
    request.options.modes = args.mode;
    request.options.range = args.range;
    request.options.partner = match (args.nu, args.kappa) {
        (Some(nu), _) => Some(Partner::Nu(nu)),
        (None, Some(text)) => Some(Partner::Kappa(units::parse(&text, Dimension::PRESSURE)?)),
        (None, None) => None,
    };
    let result = fit(&request)?;
    let stem = args.csv.file_stem().map_or_else(|| "data".into(), |n| n.to_string_lossy().into_owned());
    let out = args.out.unwrap_or_else(|| PathBuf::from("reports").join(format!("fit-{stem}")));
    files::make_folder(&out)?;
    result.write_law(&out.join("law.toml"))?;
    result.write_json(&out.join("fit.json"))?;
    durometer::report::fit::write(&out)?;
    if args.json {
        println!("{}", std::fs::read_to_string(out.join("fit.json"))?);
    } else {
        println!("{result}");
        println!("results: {}, report: {}", out.join("law.toml").display(), out.join("index.html").display());
    }
    Ok(ExitCode::SUCCESS)
}
