//! `durometer laws …`

use super::files;
use super::outcome::{CommandResult, Outcome};
use durometer::calibrate::relaxation::series_table;
use durometer::calibrate::{library, library_text, read_law_file};
use durometer::material::keywords::{self, Energy, Imported, Program};
use durometer::material::{LawSpecError, law_from_table};
use durometer::storage::{self, TEXT_LIMIT};
use std::path::{Path, PathBuf};

/// List law files, write a law for Abaqus, CalculiX, Ansys, FEBio or SOFA, and read one back
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer laws list data
  durometer laws export data/treloar-1944/neo-hookean.toml --to calculix --unit MPa --nu 0.49
  durometer laws export law.toml --to febio --unit kPa --out rubber.feb
  durometer laws import rubber.inp --from abaqus --unit MPa --out law.toml
  durometer laws import rubber.inp --from abaqus --unit MPa --out law.toml --prony prony.toml

Exit codes: 0 done, 2 bad input.")]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// List and compare the law files of a folder: constants, intervals, range, stiffness, stability
    List {
        /// Folder, searched with its subfolders
        folder: PathBuf,
        /// Print JSON instead of a table
        #[arg(long)]
        json: bool,
    },
    /// Write a law file as keywords of another program; comments state the units and the volumetric part
    Export {
        /// Law file (TOML), as `durometer fit` writes it
        law: PathBuf,
        /// Program: abaqus, calculix, ansys, febio, sofa
        #[arg(long)]
        to: Program,
        /// Unit of stresses in the other program, e.g. Pa or MPa
        #[arg(long)]
        unit: String,
        /// Poisson's ratio, if the law file has no bulk modulus
        #[arg(long)]
        nu: Option<f64>,
        /// Volumetric part of the law, if the law file has none: quadratic, logarithmic, simo_taylor
        #[arg(long)]
        volumetric: Option<String>,
        /// File that is written [default: standard output]
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Read the first law in an input file of another program and write it as a law file
    Import {
        /// Input file of the program
        file: PathBuf,
        /// Program: abaqus, calculix, ansys, febio, sofa
        #[arg(long)]
        from: Program,
        /// Unit of stresses in the file, e.g. Pa or MPa
        #[arg(long)]
        unit: String,
        /// File that is written [default: standard output]
        #[arg(long)]
        out: Option<PathBuf>,
        /// File for the Prony series of a viscoelastic material; the times in the input file must be in seconds
        #[arg(long)]
        prony: Option<PathBuf>,
    },
}

pub fn main(args: Args) -> CommandResult {
    match args.action {
        Action::List { folder, json } => {
            let found = library(&files::brought(&folder)?)?;
            if json {
                say!("{}", serde_json::to_string_pretty(&found.laws)?);
                found.passed_over(&folder).lines().for_each(|line| tell!("{line}"));
            } else {
                say!("{}", library_text(&found, &folder).trim_end());
            }
            Ok(Outcome::Complete)
        }
        Action::Export { law, to, unit, nu, volumetric, out } => {
            let (mut table, provenance) = read_law_file(&files::brought(&law)?)?;
            let added = [("nu", nu.map(toml::Value::from)), ("volumetric", volumetric.map(toml::Value::from))];
            for (key, value) in added.into_iter().filter_map(|(key, value)| Some((key, value?))) {
                if let Some(own) = table.insert(key.into(), value) {
                    let remedy = format!("leave out --{key}, or change the file");
                    return Err(format!("{}: the law has {key} = {own} already; {remedy}", law.display()).into());
                }
            }
            let energy = Energy::of(&*law_from_table(&table).map_err(|e| with_flags(&e))?);
            let origin = |key: &str| provenance.get(key).map(|v| format!("{key}: {v}"));
            let notes: Vec<String> = ["data", "source", "fitted_stretch"].into_iter().filter_map(origin).collect();
            print(out.as_deref(), &keywords::write(&energy, to, &unit, &notes)?)
        }
        Action::Import { file, from, unit, out, prony } => {
            let text = storage::read_text(&file, TEXT_LIMIT).map_err(|e| format!("{}: {e}", file.display()))?;
            let found = keywords::read(&text, from, &unit).map_err(|e| format!("{}: {e}", file.display()))?;
            let mut source = format!("{} of {}", file.display(), from.name());
            if !found.passed_over.is_empty() {
                let keywords = found.passed_over.join(", ");
                tell!("warning: {source}: the material has {keywords}, which the law leaves out");
                source += &format!(", without {keywords}");
            }
            write_series(&found, &source, prony.as_deref())?;
            let mut table = found.energy.table()?;
            let words = if found.series.is_empty() { source } else { format!("{source}, constants of the long term") };
            table.insert("source".into(), words.into());
            print(out.as_deref(), &toml::to_string(&table)?)
        }
    }
}

/// Describes why the constants of a law file were refused, with the flags that supply what the file lacks.
fn with_flags(error: &LawSpecError) -> String {
    match error {
        LawSpecError::NotChosen { choice, .. } if choice.name == "volumetric" => {
            format!("{error}; pass for example --volumetric quadratic --nu 0.49")
        }
        LawSpecError::NoVolumetric { .. } => format!("{error}; pass for example --nu 0.49"),
        LawSpecError::NotTwo { given } if given.len() == 1 && given[0] != "nu" => {
            format!("{error}; pass for example --nu 0.49")
        }
        _ => error.to_string(),
    }
}

/// Writes the Prony series of a viscoelastic material; refuses a file name without a series, and a series without a file name.
fn write_series(found: &Imported, source: &str, path: Option<&Path>) -> Result<(), Box<dyn std::error::Error>> {
    match path {
        None if found.series.is_empty() => Ok(()),
        None => Err(format!(
            "{source}: the material relaxes; pass --prony prony.toml for its Prony series, next to which the law has the constants of the long term"
        )
        .into()),
        Some(_) if found.series.is_empty() => {
            Err(format!("{source}: the material of the first law does not relax; leave out --prony").into())
        }
        Some(path) => {
            let mut root = series_table(found.series.iter().copied());
            let origin = toml::Table::from_iter([("source".to_string(), source.into())]);
            root.insert("provenance".into(), origin.into());
            print(Some(path), &toml::to_string(&root)?).map(drop)
        }
    }
}

fn print(out: Option<&Path>, text: &str) -> CommandResult {
    match out {
        Some(path) => {
            storage::write(path, text.as_bytes()).map_err(|e| format!("{}: cannot be written: {e}", path.display()))?
        }
        None => say!("{}", text.trim_end()),
    }
    Ok(Outcome::Complete)
}
