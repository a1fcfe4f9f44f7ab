//! `durometer fit CSV… --law LAW`

use super::arguments;
use super::files;
use super::outcome::{CommandResult, Outcome};
use super::results::ReplaceArgs;
use super::softening;
use durometer::calibrate::softening::fit_softening;
use durometer::calibrate::{
    Accuracy, Cycle, Decimal, Dimensions, FitRequest, Loss, Mode, Partner, Sign, SlackChoice, StrainKind, StressKind,
    StretchRange, UnknownMode, Weighting, compare, fit, fittable_laws,
};
use durometer::material::{FitForm, LawEntry};
use durometer::math::threads;
use durometer::math::units::{self, Dimension};
use durometer::report::ReportError;
use durometer::wording::joined;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  durometer fit data/treloar-1944/treloar-1944.csv --law neo_hookean --mode uniaxial --range 1..1.6 --nu 0.49
  durometer fit data/treloar-1944/treloar-1944.csv --law ogden --terms 3 --modes uniaxial,equibiaxial,planar
  durometer fit data/treloar-1944/treloar-1944.csv --law all --mode uniaxial
  durometer fit one.csv two.csv three.csv --law yeoh --terms 2
  durometer fit pull.csv --law yeoh --weight relative --stable 0.6..1.6
  durometer fit pull.csv --law neo_hookean --strain-column strain --stress-column 'stress [MPa]' --stress-unit MPa
  durometer fit machine.csv --law yeoh --mode uniaxial --gauge-length '33 mm' --width '6 mm' --thickness '3 mm' --toe '5 kPa'
  durometer fit pairs.csv --law yeoh --mode uniaxial --test 2
  durometer fit cycles.csv --law ogden --terms 1 --mode uniaxial --cycle last-loading
  durometer fit cycles.csv --law yeoh --mode uniaxial --softening
  durometer fit foam.csv --law hyperfoam --terms 2 --mode uniaxial --positive compression
  durometer fit foam.csv --law hyperfoam --mode uniaxial --positive compression --nu 0 --accuracy poisson=0.02

A scene includes the result with:  [laws.rubber]  include = \"law.toml\"  and the keys that the output names";

/// Returns the end of the help: examples, the laws that can be fitted with their numbers of terms, and exit codes.
fn after_help() -> String {
    let line = |law: &LawEntry, form: &FitForm| {
        let terms =
            if form.term_counts.len() > 1 { format!("--terms {}", joined(form.term_counts)) } else { String::new() };
        let poisson = "of foams: Poisson's ratio is that of a column of lateral strain or --nu";
        let note = if form.compressible { poisson } else { "" };
        format!("  {:20}{terms:22}{note}", law.info.name).trim_end().to_string()
    };
    let laws = fittable_laws().into_iter().filter_map(|law| Some(line(law, law.fit.as_ref()?)));
    let laws = laws.collect::<Vec<_>>().join("\n");
    let codes = "Exit codes: 0 done, 2 bad input, 3 the data do not determine every constant (the output names them).";
    format!("{EXAMPLES}\n\nLaws:\n{laws}\n\n{codes}")
}

/// Fit a law to tensile data (CSV) and write law.toml, which a scene can include
///
/// The table is a CSV file with one column of stretch, strain or displacement and one of stress or force. Units are given in the header, in
/// card.toml next to it, or by flags. Nothing is changed silently: the audit log lists conversions and unusual data points.
#[derive(clap::Args)]
#[command(after_help = after_help())]
pub struct Args {
    /// Tensile data (CSV); several files are specimens of the same test
    #[arg(required = true)]
    csv: Vec<PathBuf>,
    /// Name of the law, e.g. neo_hookean; `all` compares every law by what it predicts, and writes compare.json and a page only
    #[arg(long)]
    law: String,
    /// Terms of mooney_rivlin (2, 3, 5), yeoh (1 to 3), ogden (1 to 4), hyperfoam (1 to 3) [default: 2, 3, 3, 1]
    #[arg(long)]
    terms: Option<usize>,
    /// Folder of the results [default: reports/fit-<name of the table>-<law>]; it may hold the fit of the same law to the same table, others with --replace only
    #[arg(long)]
    out: Option<PathBuf>,
    /// Stretches that are fitted, e.g. 1..1.6 [default: every data point]
    #[arg(long)]
    range: Option<StretchRange>,
    /// Mode to fit: uniaxial, equibiaxial, planar, simple_shear, biaxial; several times, or with commas, to fit several together
    #[arg(long, visible_alias = "modes", value_delimiter = ',', value_parser = asked_mode)]
    mode: Vec<AskedMode>,
    /// Error that has the same weight in every data point: one pascal (absolute), one per cent (relative), one standard deviation of its mode (noise)
    #[arg(long, visible_alias = "weighting", default_value = "absolute")]
    weight: Weighting,
    /// Standard deviation of the stress for --weight noise, e.g. "2 kPa" [default: from the point-to-point scatter of each mode]
    #[arg(long)]
    noise: Option<String>,
    /// squares, or huber: outliers have less weight
    #[arg(long, default_value = "squares")]
    loss: Loss,
    /// Stretches over which mooney_rivlin and yeoh are kept stable in every mode [default: fitted modes, fitted range]
    #[arg(long)]
    stable: Option<StretchRange>,
    /// Poisson's ratio for the law file, which tensile data do not determine in an incompressible fit. For hyperfoam: Poisson's ratio in the test, if no
    /// lateral strain was measured
    #[arg(long, conflicts_with = "kappa")]
    nu: Option<f64>,
    /// Bulk modulus for the law file instead of --nu, e.g. "2 GPa"
    #[arg(long)]
    kappa: Option<String>,
    /// Volumetric part for the law file: quadratic, logarithmic, simo_taylor; without it the scene must name one
    #[arg(long)]
    volumetric: Option<String>,
    /// Whether to fit a strain offset of each curve with the constants: yes, no, or auto (if data points without stress show an offset)
    #[arg(long, default_value = "auto")]
    slack: SlackChoice,
    /// Data card [default: card.toml next to the table]
    #[arg(long)]
    card: Option<PathBuf>,
    /// Name of the column of strain or stretch if the header does not identify it, or its number such as "#3"
    #[arg(long)]
    strain_column: Option<String>,
    /// Name of the column of stress or force
    #[arg(long)]
    stress_column: Option<String>,
    /// Second strain column of a biaxial test
    #[arg(long)]
    strain_column_2: Option<String>,
    /// Second stress column of a biaxial test
    #[arg(long)]
    stress_column_2: Option<String>,
    /// Column of the strain transverse to the load, for hyperfoam
    #[arg(long)]
    lateral_column: Option<String>,
    /// Unit of that column: % or 1
    #[arg(long)]
    lateral_unit: Option<String>,
    /// Content of the strain column: stretch, engineering, true (logarithmic) or displacement
    #[arg(long)]
    strain_kind: Option<StrainKind>,
    /// Content of the stress column: nominal, true (Cauchy) or force
    #[arg(long)]
    stress_kind: Option<StressKind>,
    /// Unit of the strain column: %, 1, or a length
    #[arg(long)]
    strain_unit: Option<String>,
    /// Unit of the stress column, e.g. MPa, or N of a force
    #[arg(long)]
    stress_unit: Option<String>,
    /// Decimal mark, if the table does not determine it: point or comma
    #[arg(long)]
    decimal: Option<Decimal>,
    /// Which of several tests that are next to each other in the table, counted from 1
    #[arg(long, value_name = "N")]
    test: Option<usize>,
    /// Load whose strain and stress the table counts as positive: tension or compression [default: tension, unless a column is called compressive]
    #[arg(long, value_name = "LOAD")]
    positive: Option<Sign>,
    /// Load whose stress or force counts as positive, if its sign differs from that of the strain, e.g. a machine whose force is negative in tension
    #[arg(long, value_name = "LOAD")]
    stress_positive: Option<Sign>,
    /// Instrument that measured the strain: crosshead, extensometer, …
    #[arg(long)]
    strain_from: Option<String>,
    /// Undeformed gauge length of a displacement (in simple shear, the sheared thickness), e.g. "33 mm"
    #[arg(long)]
    gauge_length: Option<String>,
    /// Undeformed width, for a force
    #[arg(long)]
    width: Option<String>,
    /// Undeformed thickness, for a force
    #[arg(long)]
    thickness: Option<String>,
    /// Undeformed diameter, for a force
    #[arg(long)]
    diameter: Option<String>,
    /// Undeformed cross-section, for a force, e.g. "18 mm^2"
    #[arg(long)]
    area: Option<String>,
    /// Compliance of machine and grips, whose share of the travel is subtracted from the displacement, e.g. "0.002 mm/N"
    #[arg(long)]
    compliance: Option<String>,
    /// Half-width of the 95 % interval of an error that all data points share: stress_zero, force_zero, stress_scale, area_scale, strain_zero,
    /// strain_scale, compliance, poisson (for hyperfoam); e.g. --accuracy stress_scale=2% --accuracy force_zero=0.05N
    #[arg(long, value_name = "ERROR=VALUE")]
    accuracy: Vec<Accuracy>,
    /// Rows of a table that loads and unloads: first-loading, last-loading, a number from 1 on, all [default: first-loading, with a warning]
    #[arg(long)]
    cycle: Option<Cycle>,
    /// Subtract the mean stress of the first N data points from every stress
    #[arg(long, value_name = "N")]
    zero: Option<usize>,
    /// Shift the strain to where the line through the data above this noise level reaches zero stress, e.g. "2 kPa"
    #[arg(long, value_name = "STRESS")]
    toe: Option<String>,
    /// Fit softening (Mullins effect) to unloading and reloading too, and the law to the first loading of every stretch; writes mullins/mullins.toml
    #[arg(long, conflicts_with_all = ["cycle", "zero", "toe"])]
    softening: bool,
    /// Threads that the fit may use [default: one per core]; the results do not depend on it
    #[arg(long, value_name = "N", value_parser = arguments::threads)]
    threads: Option<usize>,
    #[command(flatten)]
    replace: ReplaceArgs,
    /// Print fit.json instead of text
    #[arg(long)]
    json: bool,
}

/// A mode as it was requested.
#[derive(Clone, Copy)]
struct AskedMode {
    mode: Mode,
    compression: bool,
}

fn asked_mode(word: &str) -> Result<AskedMode, UnknownMode> {
    Ok(AskedMode { mode: word.parse()?, compression: word.to_lowercase().contains("compression") })
}

impl Args {
    /// Refuses flags that apply to a single law if all laws are compared.
    fn check(&self) -> Result<(), String> {
        let of_one_law = [
            ("--softening", self.softening),
            ("--terms", self.terms.is_some()),
            ("--nu", self.nu.is_some()),
            ("--kappa", self.kappa.is_some()),
            ("--volumetric", self.volumetric.is_some()),
        ];
        match of_one_law.into_iter().find(|(_, is_given)| *is_given && self.law == "all") {
            Some((flag, _)) => Err(format!(
                "{flag} does not go with --law all, which compares every law with every number of its terms and writes none: name a law, or leave it out"
            )),
            None => Ok(()),
        }
    }
}

/// Combines the errors of all flags; an error that is given twice is refused.
fn accuracy(given: Vec<Accuracy>) -> Result<Accuracy, String> {
    given.into_iter().try_fold(Accuracy::default(), |all, one| match one.0.keys().find(|e| all.0.contains_key(e)) {
        Some(error) => Err(format!("--accuracy: the {error} is given twice; keep one of the two")),
        None => Ok(one.or(&all)),
    })
}

pub fn main(args: Args) -> CommandResult {
    threads::use_threads(args.threads.unwrap_or_else(threads::available));
    args.check()?;
    let csv = files::all_brought(&args.csv)?;
    let mut request = FitRequest::new(&csv[0], &args.law);
    request.more = csv[1..].to_vec();
    request.card = args.card.as_deref().map(files::brought).transpose()?;
    (request.columns.strain, request.columns.stress) = (args.strain_column, args.stress_column);
    request.columns.strain_kind = args.strain_kind;
    request.columns.strain_unit = args.strain_unit;
    request.columns.stress_unit = args.stress_unit;
    request.columns.strain_2 = args.strain_column_2;
    request.columns.stress_2 = args.stress_column_2;
    (request.columns.lateral, request.columns.lateral_unit) = (args.lateral_column, args.lateral_unit);
    request.columns.stress_kind = args.stress_kind;
    request.columns.decimal = args.decimal;
    request.columns.test = args.test;
    (request.columns.positive, request.columns.stress_positive) = (args.positive, args.stress_positive);
    request.columns.strain_measurement = args.strain_from;
    let sizes = [args.gauge_length, args.width, args.thickness, args.diameter, args.area, args.compliance];
    for ((key, _), text) in Dimensions::KEYS.into_iter().zip(sizes) {
        if let Some(text) = text {
            request.columns.dimensions.set(key, &text)?;
        }
    }
    (request.preparation.cycle, request.preparation.zero, request.preparation.toe) = (args.cycle, args.zero, args.toe);
    request.options.noise = args.noise.map(|text| units::parse(&text, Dimension::PRESSURE)).transpose()?;
    request.columns.compression = args.mode.iter().any(|asked| asked.compression);
    request.options.modes = args.mode.iter().map(|asked| asked.mode).collect();
    request.options.range = args.range;
    request.options.terms = args.terms;
    request.options.weighting = args.weight;
    request.options.loss = args.loss;
    request.options.stable = args.stable;
    request.options.volumetric = args.volumetric;
    request.options.slack = args.slack;
    request.options.accuracy = accuracy(args.accuracy)?;
    request.options.partner = match (args.nu, args.kappa) {
        (Some(nu), _) => Some(Partner::Nu(nu)),
        (None, Some(text)) => Some(Partner::Kappa(units::parse(&text, Dimension::PRESSURE)?)),
        (None, None) => None,
    };
    let stem = args.csv[0].file_stem().map_or_else(|| "data".into(), |n| n.to_string_lossy().into_owned());
    let out = args.out.unwrap_or_else(|| PathBuf::from("reports").join(format!("fit-{stem}-{}", args.law)));
    if args.law == "all" {
        let table = compare(&request)?;
        args.replace.check(&out, "fit", "all laws", &csv)?.write(|folder| {
            table.write_json(&folder.join("compare.json"))?;
            Ok::<_, Box<dyn std::error::Error>>(durometer::report::fit::comparison::write(folder)?)
        })?;
        say!("{}", if args.json { serde_json::to_string_pretty(&table)? } else { table.to_string() });
        return Ok(Outcome::Complete);
    }
    let (result, softening) = match args.softening {
        true => fit_softening(&request).map(|(law, softening)| (law, Some(softening)))?,
        false => (fit(&request)?, None),
    };
    let undrawn = args.replace.check(&out, "fit", result.label.as_str(), &csv)?.write(|folder| {
        result.write_law(&folder.join("law.toml"))?;
        result.write_json(&folder.join("fit.json"))?;
        let of_law = ReportError::of_figure(durometer::report::fit::write(folder))?;
        let of_softening = softening.as_ref().map(|fit| softening::write(&folder.join("mullins"), fit)).transpose()?;
        Ok::<_, Box<dyn std::error::Error>>(of_law.or(of_softening.flatten()))
    })?;
    if args.json {
        say!("{}", durometer::storage::read_text(&out.join("fit.json"), durometer::storage::DATA_LIMIT)?);
    } else {
        say!("{result}");
        say!("results: {}, report: {}", out.join("law.toml").display(), out.join("index.html").display());
        let lines: Vec<String> = std::iter::once("include = \"law.toml\"".into()).chain(result.scene_lines()).collect();
        say!("in the table of a law of a scene: {}", lines.join(", "));
        if let Some(softening) = &softening {
            say!("\n{softening}\nresults: {}", out.join("mullins").join("mullins.toml").display());
        }
    }
    undrawn.map_or(Ok(()), Err)?;
    let determined = result.is_determined() && softening.is_none_or(|fit| fit.is_determined());
    Ok(if determined { Outcome::Complete } else { Outcome::NotDetermined })
}
