//! `durometer plan SCENE`

use super::outcome::{CommandResult, Outcome};
use super::results::ReplaceArgs;
use super::{files, progress::Bars};
use durometer::math::units::{self, Dimension};
use durometer::scene::Progress;
use durometer::solve::Status;
use durometer::study::plan::{PlanError, PlanWatch, Request, plan};
use durometer::study::run::runner::Watch;
use durometer::study::store::folder;
use durometer::study::store::record::CaseRecord;
use std::path::PathBuf;

/// Find the mesh, element and time step that meet a tolerance within a time budget
///
/// Coarse pilot runs with every element take a quarter of the budget, or up to a half; models of error and time are fitted to them. The answer names the
/// setting, its expected error and time, and what cannot be guaranteed. For a volume mesh or grid, whose size is given, only formulations and
/// steps are compared. Writes plan.json.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  durometer plan studies/finger-convergence/scene.toml --tolerance \"2 %\" --budget \"5 min\"
  durometer plan finger-dynamics --tolerance \"5 %\" --budget \"10 min\" --quantity bending_angle_deg
  durometer plan my-scene.toml --tolerance \"1 %\" --budget \"30 min\" --run

Exit codes: 0 a setting is expected to meet the tolerance within the budget, 2 bad input, 3 none is, the run did not complete, or a signal ended it.
Ctrl-C ends it with what the complete pilots tell.")]
pub struct Args {
    /// Scene file (TOML), or the name of a folder in studies/
    scene: PathBuf,
    /// Largest error of a peak
    #[arg(long, value_name = "SHARE")]
    tolerance: String,
    /// Wall-clock time for meshes, pilots and the recommended run together
    #[arg(long, value_name = "TIME")]
    budget: String,
    /// Recorded column that is judged; may be repeated [default: every recorded angle and cable tension]
    #[arg(long, value_name = "COLUMN")]
    quantity: Vec<String>,
    /// Make the recommended run, and report how good the prediction was
    #[arg(long)]
    run: bool,
    /// Folder of plan.json [default: reports/plan-<scene>]
    #[arg(long)]
    out: Option<PathBuf>,
    #[command(flatten)]
    replace: ReplaceArgs,
    /// Change a key, e.g. --set laws.rubber.nu=0.49
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print plan.json instead of progress and text
    #[arg(long)]
    json: bool,
}

/// Shows progress bars and the output of the mesher.
struct Shown(Bars);

impl PlanWatch for Shown {
    fn line(&self, line: &str) {
        self.0.meshing("plan", line);
    }
    fn started(&self, name: &str) {
        self.0.started(name);
    }
    fn progress(&self, name: &str, progress: Progress) {
        self.0.progress(name, progress);
    }
    fn finished(&self, record: &CaseRecord) {
        self.0.finished(record, false);
    }
}

pub fn main(args: Args) -> CommandResult {
    let within =
        |what: &str, text: &str, dimension| units::parse(text, dimension).map_err(|e| format!("--{what}: {e}"));
    let tolerance = within("tolerance", &args.tolerance, Dimension::NONE)?;
    if !(tolerance > 0.0 && tolerance < 1.0) {
        return Err(
            format!("--tolerance: it is {tolerance}; it lies between 0 and 1, write for example \"2 %\"").into()
        );
    }
    let budget_s = within("budget", &args.budget, Dimension::TIME)?;
    if budget_s <= 0.0 {
        return Err(format!("--budget: it is {budget_s} s; give a positive time, for example \"10 min\"").into());
    }
    let file = files::find(&args.scene, "scene.toml")?;
    let stop = super::interrupt::stop_flag();
    let (changes, quantities) = (super::arguments::changes(&args.set)?, args.quantity);
    let request = Request { file, changes, tolerance, budget_s, quantities, stop };
    let shown = Shown(Bars::new(args.json));
    let name = request.file.parent().and_then(|p| p.file_name()).map_or("scene".into(), |n| n.to_string_lossy());
    let out = args.out.unwrap_or_else(|| PathBuf::from("reports").join(format!("plan-{name}")));
    // Checked before the pilots, which take a long time
    let results = args.replace.check(&out, "plan", args.set.join(", "), std::slice::from_ref(&request.file))?;
    let made = plan(&request, &shown).and_then(|mut planned| {
        if args.run {
            planned.carry_out(&request, &shown)?;
        }
        Ok(planned.plan)
    });
    let plan = match made {
        Err(PlanError::Stopped) => {
            tell!("stopped: nothing was written");
            return Ok(Outcome::Interrupted);
        }
        Err(none @ PlanError::FewPilots { .. }) => {
            tell!("{none}");
            return Ok(Outcome::NotWithinBudget);
        }
        plan => plan?,
    };
    let json = serde_json::to_string_pretty(&plan)?;
    results.write(|part| Ok::<_, Box<dyn std::error::Error>>(folder::write(&part.join("plan.json"), &json)?))?;
    match args.json {
        true => say!("{json}"),
        false => say!("\n{}\n\nwritten: {}", plan.lines().join("\n"), out.join("plan.json").display()),
    }
    if plan.stopped {
        return Ok(Outcome::Interrupted);
    }
    let complete = plan.outcome.as_ref().is_none_or(|o| o.status == Status::Converged.name());
    Ok(if plan.meets && complete { Outcome::Complete } else { Outcome::NotWithinBudget })
}
