//! Slurm: array jobs of packed cases, and a report that depends on them.
//!
//! The tasks of a group are the indices of one array, or of several if there are more than `MaxArraySize`. A task that is requeued, because its node
//! failed or its time is up, continues from the stored results: Slurm sends SIGUSR1 two minutes before the time limit, the script forwards it as
//! SIGTERM, the run keeps what is finished, and the task asks to be requeued.

use super::{EngineError, EngineFile, Submission, output, shell};
use crate::study::engine::batches::Group;
use std::process::Command;

const REMEDY: &str =
    "submit where the cluster's commands are (a login node), or install them: apt install slurm-client";
/// `MaxArraySize` if Slurm is not queried: its default.
pub const MAX_ARRAY_SIZE: usize = 1001;
/// Time before its limit at which a task is warned \[s\].
const WARNING_S: u64 = 120;
/// Number of times that a task may ask to be requeued.
const RESTARTS: usize = 10;
/// Requested time of the report \[min\].
const REPORT_MIN: u64 = 60;

/// Queries the largest number of tasks in an array on this cluster.
pub fn max_array_size() -> Result<usize, EngineError> {
    let config = output("slurm", REMEDY, Command::new("scontrol").args(["show", "config"]))?;
    let value = config.lines().find_map(|l| l.strip_prefix("MaxArraySize")?.trim_start().strip_prefix('='));
    Ok(value.and_then(|v| v.trim().parse().ok()).filter(|n| *n > 1).unwrap_or(MAX_ARRAY_SIZE))
}

/// The files of a submission. The last one is the report.
pub fn files(s: &Submission, max_array_size: usize) -> Result<Vec<EngineFile>, EngineError> {
    s.check()?;
    let batches = s.batches();
    let arrays = arrays(s, &batches, max_array_size).into_iter().map(|(_, file)| file);
    let mut files: Vec<EngineFile> = std::iter::once(batches.clone()).chain(arrays).collect();
    files.push(EngineFile { name: "report.sbatch".into(), text: report(s) });
    Ok(files)
}

/// The arrays with their phases.
fn arrays(s: &Submission, batches: &EngineFile, max_array_size: usize) -> Vec<(usize, EngineFile)> {
    let (mut arrays, mut first) = (vec![], 1);
    for group in &s.groups {
        for tasks in group.batches.chunks(max_array_size.max(1)) {
            let name = format!("cases-{}.sbatch", arrays.len() + 1);
            arrays.push((group.phase, EngineFile { name, text: array(s, batches, group, (first, tasks.len())) }));
            first += tasks.len();
        }
    }
    arrays
}

/// The script of an array of `tasks` tasks, beginning with the batch `first`.
fn array(s: &Submission, batches: &EngineFile, group: &Group, (first, tasks): (usize, usize)) -> String {
    let array = format!("--array=0-{}", tasks - 1);
    let signal = format!("--signal=B:USR1@{WARNING_S}");
    let mut text = head(s, "cases", "%A_%a", group.bytes, s.seconds(group).div_ceil(60) + 2);
    text = text.replacen("#SBATCH", &format!("#SBATCH {array}\n#SBATCH {signal}\n#SBATCH"), 1);
    text += &format!(
        r#"
{} &
run=$!
over=
# The time is nearly over: keep what is finished
trap 'over=yes; kill -TERM $run' USR1
# The task is cancelled, or its node is wanted
trap 'kill -TERM $run' TERM INT
wait $run; code=$?
# A signal ends the first wait
while kill -0 $run 2>/dev/null; do wait $run; code=$?; done
if [ -n "$over" ] && [ "$code" -ne 0 ]; then
    if [ "${{SLURM_RESTART_COUNT:-0}}" -lt {RESTARTS} ]; then
        scontrol requeue "$SLURM_JOB_ID" && exit 0
    fi
    echo "the task was queued {RESTARTS} times and is not done: request more time with --time-factor" >&2
fi
exit $code
"#,
        s.run_batch(batches, &format!("$(({first} + SLURM_ARRAY_TASK_ID))"))
    );
    text
}

fn report(s: &Submission) -> String {
    head(s, "report", "%j", s.requests.report_bytes, REPORT_MIN) + &format!("\nexec {}\n", shell(&s.report))
}

/// The first lines of a script, with its resource requests.
fn head(s: &Submission, name: &str, log: &str, bytes: u64, minutes: u64) -> String {
    let logs = s.place().join("logs").join(format!("{log}.txt"));
    let mut requests = vec![
        format!("--job-name=durometer-{}-{name}", s.study),
        "--ntasks=1".into(),
        "--cpus-per-task=1".into(),
        format!("--time={minutes}"),
        "--requeue".into(),
        "--open-mode=append".into(),
        format!("--output={}", shell(&[logs.to_string_lossy().into_owned()])),
        format!("--chdir={}", shell(&[s.folder.to_string_lossy().into_owned()])),
    ];
    requests.extend(s.mebibytes(bytes).map(|m| format!("--mem={m}M")));
    requests.extend(s.requests.options.iter().cloned());
    let requests: String = requests.iter().map(|r| format!("#SBATCH {r}\n")).collect();
    let before: String = s.requests.before.iter().map(|line| format!("{line}\n")).collect();
    format!("#!/bin/bash\n{requests}\n{before}")
}

/// Writes the files and submits them. Returns the ids of the jobs; the last one is that of the report.
pub fn submit(s: &Submission) -> Result<Vec<String>, EngineError> {
    let size = max_array_size()?;
    s.write(&files(s, size)?)?;
    let mut jobs: Vec<(usize, String)> = vec![];
    let submit = |name: &str, after: &[String]| {
        let mut command = Command::new("sbatch");
        command.arg("--parsable");
        if !after.is_empty() {
            command.arg(format!("--dependency=afterany:{}", after.join(":")));
        }
        let said = output("slurm", REMEDY, command.arg(s.place().join(name)))?;
        Ok(said.split(';').next().unwrap_or_default().trim().to_string())
    };
    for (phase, file) in arrays(s, &s.batches(), size) {
        let after: Vec<String> = jobs.iter().filter(|(of, _)| *of < phase).map(|(_, job)| job.clone()).collect();
        jobs.push((phase, submit(&file.name, &after)?));
    }
    let mut ids: Vec<String> = jobs.into_iter().map(|(_, job)| job).collect();
    ids.push(submit("report.sbatch", &ids)?);
    Ok(ids)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::engine::Requests;
    use crate::study::engine::batches::Batch;

    fn submission() -> Submission {
        let batch = |cases: &[&str], seconds| Batch { cases: cases.iter().map(ToString::to_string).collect(), seconds };
        let requests = Requests {
            time_factor: 2.0,
            memory_factor: 1.5,
            report_bytes: 1 << 30,
            options: vec!["--partition=long".into()],
            before: vec!["module load gcc".into()],
        };
        Submission {
            study: "press".into(),
            dir: "/data/my results".into(),
            folder: "/home/a".into(),
            run: ["durometer", "run", "it's/study.toml"].map(String::from).to_vec(),
            report: ["durometer", "report", "/data/my results"].map(String::from).to_vec(),
            groups: vec![
                Group { phase: 0, bytes: 1 << 30, batches: vec![batch(&["a", "b"], 1500.0), batch(&["c"], 10.0)] },
                Group { phase: 1, bytes: 4 << 30, batches: vec![batch(&["d"], 60.0)] },
            ],
            list_bytes: 0,
            requests,
        }
    }

    #[test]
    fn requests_follow_from_the_prediction() {
        let files = files(&submission(), 1001).expect("no line breaks");
        let names: Vec<&str> = files.iter().map(|f| f.name.as_str()).collect();
        let batches = submission().batches().name;
        assert_eq!(names, [batches.as_str(), "cases-1.sbatch", "cases-2.sbatch", "report.sbatch"]);
        assert_eq!(files[0].text, "a b\nc\nd\n");
        // 2 · 1500 s + 300 s = 55 min, plus two for the warning; 1.5 · 1 GiB + 256 MiB
        let wanted = [
            "#SBATCH --array=0-1\n",
            "#SBATCH --time=57\n",
            "#SBATCH --mem=1792M\n",
            "#SBATCH --partition=long\n",
            "#SBATCH --signal=B:USR1@120\n",
            "#SBATCH --requeue\n",
            "#SBATCH --output='/data/my results/engine/logs/%A_%a.txt'\n",
            "module load gcc\n",
            &format!(
                "durometer run \"it's/study.toml\" --batch '/data/my results/engine/{batches}':$((1 + SLURM_ARRAY_TASK_ID)) &\n"
            ),
        ];
        for line in wanted {
            assert!(files[1].text.contains(line), "{line}\n{}", files[1].text);
        }
        assert!(files[1].text.starts_with("#!/bin/bash\n#SBATCH"));
        assert!(files[2].text.contains("--array=0-0\n") && files[2].text.contains("$((3 + SLURM_ARRAY_TASK_ID))"));
        let free = Submission { requests: Requests { memory_factor: 0.0, ..submission().requests }, ..submission() };
        assert!(super::files(&free, 1001).expect("sound").iter().all(|f| !f.text.contains("--mem")));
    }

    #[test]
    fn an_array_is_no_larger_than_the_cluster_takes() {
        let files = files(&submission(), 1).expect("no line breaks");
        let arrays: Vec<&EngineFile> = files.iter().filter(|f| f.name.starts_with("cases")).collect();
        assert_eq!(arrays.len(), 3);
        assert!(arrays.iter().enumerate().all(|(k, f)| f.text.contains(&format!("$(({} + SLURM", k + 1))));
    }

    #[test]
    fn a_line_break_is_refused() {
        let mut bad = submission();
        bad.requests.options.push("--comment=a\nrm -r /".into());
        assert!(matches!(files(&bad, 10), Err(EngineError::LineBreak { .. })));
    }
}
