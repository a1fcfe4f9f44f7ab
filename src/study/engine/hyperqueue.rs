//! HyperQueue: one job whose tasks are the batches, with resource requests, and a report that depends on them.
//!
//! The job is a HyperQueue job definition file (`jobs.toml`). It is submitted with `hq job submit-file` or, if there is no `hq`, as after `pip install
//! hyperqueue`, through the Python interface. HyperQueue restarts a task whose worker is lost.

use super::{EngineError, EngineFile, Submission, output, shell};
use std::path::Path;
use std::process::Command;
use toml::{Table, Value};

const REMEDY: &str = "install HyperQueue (its release archive holds the program hq; or pip install hyperqueue, whose Python DUROMETER_PYTHON names) \
and start a server, hq server start";
/// Number of times that a task may be started if its workers are lost.
const CRASH_LIMIT: i64 = 20;
/// Requested time of the report \[s\].
const REPORT_S: u64 = 3600;
/// Submits `jobs.toml` through the Python interface. Arguments: the file, then the server folder or nothing.
const SUBMIT: &str = r#"
import sys, tomllib, datetime
from hyperqueue import Client, Job
from hyperqueue.ffi.protocol import ResourceRequest
definition = tomllib.load(open(sys.argv[1], "rb"))
client = Client(sys.argv[2] if len(sys.argv) > 2 else None)
job, made = Job(name=definition["name"], max_fails=None), {}
for task in definition["task"]:
    resources = dict(task["request"][0]["resources"])
    seconds = datetime.timedelta(seconds=int(task["request"][0]["time_request"].removesuffix("s")))
    made[task["id"]] = job.program(
        task["command"], cwd=task["cwd"], stdout=task["stdout"], stderr=task["stderr"],
        deps=[made[k] for k in task.get("deps", [])],
        resources=ResourceRequest(cpus=resources.pop("cpus"), resources=resources, min_time=seconds))
print(client.submit(job).id)
"#;

/// The files of a submission.
pub fn files(s: &Submission) -> Result<Vec<EngineFile>, EngineError> {
    s.check()?;
    let (batches, mut tasks, mut first_phase) = (s.batches(), vec![], vec![]);
    let numbered = s.groups.iter().flat_map(|g| g.batches.iter().map(move |_| g)).enumerate();
    for (k, group) in numbered {
        // A case that does not converge is a result; the remaining cases and the report continue
        let run = format!("{} || [ $? -eq 3 ]", s.run_batch(&batches, &(k + 1).to_string()));
        let deps = if group.phase == 0 { vec![] } else { first_phase.clone() };
        if group.phase == 0 {
            first_phase.push(k);
        }
        tasks.push(task(s, k, &run, (s.seconds(group), s.mebibytes(group.bytes)), &deps));
    }
    let all: Vec<usize> = (0..tasks.len()).collect();
    let needs = (REPORT_S, s.mebibytes(s.requests.report_bytes));
    tasks.push(task(s, all.len(), &shell(&s.report), needs, &all));
    let mut job = Table::new();
    job.insert("name".into(), format!("durometer-{}", s.study).into());
    job.insert("task".into(), Value::Array(tasks));
    let text = toml::to_string(&job).expect("tables with string keys only");
    Ok(vec![batches, EngineFile { name: "jobs.toml".into(), text }])
}

/// A task that runs a shell command line, with the time \[s\] and memory \[MiB\] that it requests.
fn task(s: &Submission, id: usize, line: &str, (seconds, memory): (u64, Option<u64>), deps: &[usize]) -> Value {
    let before: String = s.requests.before.iter().map(|line| format!("{line}\n")).collect();
    let line = format!("{before}{line}");
    let log = |end: &str| s.place().join("logs").join(format!("{id}.{end}")).to_string_lossy().into_owned();
    let mut resources = Table::new();
    resources.insert("cpus".into(), 1.into());
    resources.extend(memory.map(|m| ("mem".to_string(), Value::Integer(m as i64))));
    let mut request = Table::new();
    request.insert("resources".into(), resources.into());
    request.insert("time_request".into(), format!("{seconds}s").into());
    let mut task = Table::new();
    let entries: [(&str, Value); 7] = [
        ("id", Value::Integer(id as i64)),
        ("command", vec!["bash", "-c", line.as_str()].into()),
        ("cwd", s.folder.to_string_lossy().into_owned().into()),
        ("stdout", log("out").into()),
        ("stderr", log("err").into()),
        ("crash_limit", CRASH_LIMIT.into()),
        ("deps", deps.iter().map(|k| *k as i64).collect::<Vec<_>>().into()),
    ];
    task.extend(entries.into_iter().map(|(key, value)| (key.to_string(), value)));
    task.insert("request".into(), Value::Array(vec![request.into()]));
    task.into()
}

/// Writes the files and submits the job with `hq`, or else through the interface of this Python. Returns the output of the engine.
pub fn submit(s: &Submission, python: &Path) -> Result<String, EngineError> {
    s.write(&files(s)?)?;
    let jobs = s.place().join("jobs.toml");
    let mut command = Command::new("hq");
    command.args(&s.requests.options).args(["job", "submit-file"]).arg(&jobs);
    match output("hyperqueue", REMEDY, &mut command) {
        Err(EngineError::Missing { .. }) => {}
        said => return said,
    }
    let has_module = Command::new(python).args(["-c", "import hyperqueue"]).output().is_ok_and(|o| o.status.success());
    if !has_module {
        return Err(EngineError::Missing { engine: "hyperqueue", program: "hq".into(), remedy: REMEDY });
    }
    let server = s.requests.options.iter().find_map(|o| o.strip_prefix("--server-dir="));
    let said = output("hyperqueue", REMEDY, Command::new(python).args(["-c", SUBMIT]).arg(&jobs).args(server))?;
    Ok(format!("job {said}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::engine::Requests;
    use crate::study::engine::batches::{Batch, Group};

    #[test]
    fn the_job_has_a_task_for_every_batch_and_the_report_last() {
        let batch = |case: &str| Batch { cases: vec![case.into()], seconds: 100.0 };
        let requests = Requests {
            time_factor: 2.0,
            memory_factor: 1.0,
            report_bytes: 1 << 30,
            options: vec![],
            before: vec!["module load gcc".into()],
        };
        let s = Submission {
            study: "press".into(),
            dir: "/r".into(),
            folder: "/".into(),
            run: ["durometer", "run", "s"].map(String::from).to_vec(),
            report: ["durometer", "report", "/r"].map(String::from).to_vec(),
            groups: vec![
                Group { phase: 0, bytes: 1 << 30, batches: vec![batch("a"), batch("b")] },
                Group { phase: 1, bytes: 1 << 30, batches: vec![batch("c")] },
            ],
            list_bytes: 0,
            requests,
        };
        let files = files(&s).expect("no line breaks");
        let job: Table = files[1].text.parse().expect("TOML");
        let tasks = job["task"].as_array().expect("a list");
        let deps = |k: usize| tasks[k]["deps"].as_array().expect("a list").len();
        assert_eq!((0..4).map(deps).collect::<Vec<_>>(), [0, 0, 2, 3]);
        assert_eq!(tasks[1]["request"][0]["time_request"].as_str(), Some("500s"));
        assert_eq!(tasks[1]["request"][0]["resources"]["mem"].as_integer(), Some(1280));
        let line = tasks[2]["command"][2].as_str().expect("a line");
        let end = format!("durometer run s --batch /r/engine/{}:3 || [ $? -eq 3 ]", files[0].name);
        assert!(line.ends_with(&end), "{line}");
        let fewer = Submission { groups: s.groups[..1].to_vec(), ..s };
        assert_ne!(fewer.batches().name, files[0].name, "tasks of the first submission may still wait");
        assert!(line.starts_with("module load gcc\n"), "{line}");
    }
}
