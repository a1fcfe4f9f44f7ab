//! The class `Study`: a question, a scene and a list of changes; its run makes a report.

use crate::error::{incomplete, input, refused, with_result};
use crate::raised::Raised;
use crate::solve::{Link, ended};
use crate::threads;
use crate::value::{mapping, plain, toml_of};
use durometer::catalogue::{Launch, host};
use durometer::math::threads::{is_alone, locked};
use durometer::report::ReportError;
use durometer::scene::Progress;
use durometer::study::expand::Study as Expanded;
use durometer::study::report::write_report;
use durometer::study::run::growing::run_study;
use durometer::study::run::only::Only;
use durometer::study::run::other_study;
use durometer::study::run::runner::{Isolation, Options, Watch};
use durometer::study::store::record::CaseRecord;
use durometer_commands::files::find;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A study, given by the path of its `study.toml` or by the name of a study that comes with the program.
///
/// >>> import durometer
/// >>> study = durometer.Study.load("finger-convergence")
/// >>> study.kind
/// 'convergence'
#[pyclass(module = "durometer", frozen)]
pub struct Study {
    study: Expanded,
}

#[pymethods]
impl Study {
    /// Reads a study; `changes` are values for keys of every scene, such as {"laws.rubber.nu": 0.49}.
    #[staticmethod]
    #[pyo3(signature = (name, changes = None))]
    fn load(py: Python<'_>, name: PathBuf, changes: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        // The study is run later, perhaps after the current folder has changed
        let file = std::path::absolute(find(&name, "study.toml").map_err(refused)?)?;
        let changes = changes.map(|changes| mapping("changes", changes)).transpose()?.unwrap_or_default();
        let change = |(key, value): (String, Bound<'_, PyAny>)| Ok((key, toml_of(&value)?));
        let changes = changes.into_iter().map(change).collect::<PyResult<Vec<_>>>()?;
        Ok(Self { study: py.detach(|| Expanded::read(&file, &changes)).map_err(refused)? })
    }

    /// Name of the study, that of its folder.
    #[getter]
    fn name(&self) -> &str {
        &self.study.name
    }

    /// Kind of the study, such as `convergence`.
    #[getter]
    fn kind(&self) -> &str {
        &self.study.record.kind
    }

    /// The question that it answers.
    #[getter]
    fn question(&self) -> &str {
        &self.study.record.question
    }

    /// Ids of the cases.
    #[getter]
    fn cases(&self) -> Vec<&str> {
        self.study.cases.iter().map(|c| c.id.as_str()).collect()
    }

    /// The file of the study.
    #[getter]
    fn file(&self) -> &Path {
        &self.study.file
    }

    /// Runs every case that has no result yet in the folder `out`, by default `reports/<name>`, and writes the report. This includes cases that
    /// `durometer run --extend` has added there, and cases that an earlier run has asked for. Raises InputError if the folder holds results of another
    /// study or command. Ctrl-C keeps what is finished: the next run continues from there, and `result` of the exception has the records so far, by case.
    ///
    /// `only`: run only cases whose id contains this text.
    /// `jobs`: number of cases that run at the same time.
    /// `progress`: True, or a function of the number of cases done, including fractions of running ones, and the total number.
    /// `isolation`: "processes", or "threads", which laws in Python need; cases with such a law are always computed again, because
    /// results do not record the class.
    /// `check`: raise `RunError`, with the report as its `result`, if a case does not complete, the study has no result or a stored file is damaged.
    #[pyo3(signature = (out = None, *, only = None, jobs = None, redo = false, accept_build = false, isolation = "processes", progress = None, check = true))]
    fn run<'py>(
        &self,
        py: Python<'py>,
        out: Option<PathBuf>,
        only: Option<&str>,
        jobs: Option<&Bound<'py, PyAny>>,
        redo: bool,
        accept_build: bool,
        isolation: &str,
        progress: Option<&Bound<'py, PyAny>>,
        check: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let follower = crate::run::follower(py, progress)?;
        let is_usual = out.is_none();
        let dir = out.unwrap_or_else(|| PathBuf::from("reports").join(&self.study.name));
        other_study::check_folder(&dir, &self.study.file, is_usual).map_err(refused)?;
        let isolation = match isolation {
            "processes" if host::python().is_some() => Isolation::Processes(Launch::running()?),
            "processes" | "threads" if is_alone() => {
                let fact =
                    "a study is run in threads by a law or a controller, which the threads of the solver wait for";
                return Err(input(fact, "run it before"));
            }
            "processes" | "threads" => Isolation::Threads,
            other => {
                let fact = format!("there is no isolation {other:?}");
                return Err(input(&fact, "give \"processes\" or \"threads\""));
            }
        };
        let (jobs, only) = (threads::number(jobs)?, only.map(Only::from));
        let choice = (only, redo, accept_build);
        let (done, raised) = ended(py, Link::default(), follower.as_ref(), |link| {
            let turn = Raised::by(link);
            self.work(&dir, jobs, choice, isolation, (link, &turn.raised))
        })?;
        let failed = match (done, raised) {
            (Ok(Done::All(failed)), None) => failed,
            (Ok(Done::Part(records)), Some(why)) => {
                let of_cases = PyDict::new(py);
                records.iter().try_for_each(|record| of_cases.set_item(&record.id, plain(py, record)?))?;
                return Err(with_result(py, why, of_cases.into_any().unbind()));
            }
            (_, Some(why)) => return Err(why),
            (Ok(Done::Part(_)), None) => None,
            (Err(why), None) => return Err(refused(why as Box<dyn std::error::Error>)),
        };
        let report = py.import("durometer.report")?.getattr("Report")?.call1((dir,))?;
        match failed {
            Some((fact, status)) if check => {
                Err(incomplete(&status, &fact, "see the report, in `result` of this exception", report.unbind()))
            }
            _ => Ok(report),
        }
    }

    fn __repr__(&self) -> String {
        format!("<Study {} ({} cases)>", self.study.name, self.study.cases.len())
    }
}

type Failed = Box<dyn std::error::Error + Send + Sync>;

/// How the work on the cases ended.
enum Done {
    /// The report is written; a description of what is incomplete, and the status of the first incomplete case
    All(Option<(String, String)>),
    /// The work was stopped, with these results
    Part(Vec<CaseRecord>),
}

impl Study {
    /// Runs the cases, including those that were added to the results or follow from them, and writes the report.
    fn work(
        &self,
        dir: &Path,
        jobs: usize,
        (only, redo, accept_build): (Option<Only>, bool, bool),
        isolation: Isolation,
        (link, raised): (&Arc<Link>, &Arc<Raised>),
    ) -> Result<Done, Failed> {
        let study = self.study.again(dir)?;
        other_study::check(&study, dir)?;
        let stop = link.stop.clone();
        let options = Options { jobs, redo, accept_build, only, isolation, ..Options::new(&stop) };
        let wanted = study.cases.iter().filter(|c| options.wants(&c.id)).count();
        let watch = Following { link, raised, wanted: wanted as f64, shares: Mutex::default() };
        let records = run_study(&study, dir, &options, &watch)?;
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            return Ok(Done::Part(records));
        }
        let (missing, failed) = match write_report(dir) {
            Ok(summary) => {
                let failed = summary.failed(&records).first().map(|first| first.status.clone());
                ([summary.incomplete(&records), summary.damaged].concat(), failed)
            }
            Err(ReportError::NoCases { .. }) if records.iter().any(CaseRecord::broke) => {
                let fact = "no case has a result of the present inputs, and the report is an earlier one".to_string();
                let mut failed = records.iter().filter(|record| !record.converged()).peekable();
                let status = failed.peek().map(|first| first.status.clone());
                (std::iter::once(fact).chain(failed.map(CaseRecord::end)).collect(), status)
            }
            Err(why) => return Err(why.into()),
        };
        let status = failed.unwrap_or_else(|| "NotComplete".into());
        Ok(Done::All((!missing.is_empty()).then(|| (format!("not complete: {}", missing.join("; ")), status))))
    }
}

/// Adds up the progress of the cases.
struct Following<'a> {
    link: &'a Link,
    raised: &'a Arc<Raised>,
    wanted: f64,
    /// Case → the fraction of it that is done
    shares: Mutex<HashMap<String, f64>>,
}

impl Following<'_> {
    fn is_at(&self, case: &str, share: f64) {
        let mut shares = locked(&self.shares);
        // A repeated case starts again from zero, but the reported progress does not decrease
        let most = shares.entry(case.into()).or_insert(0.0);
        *most = share.max(*most);
        self.link.progress(Progress { t: shares.values().sum(), end: self.wanted });
    }
}

impl Watch for Following<'_> {
    fn started(&self, _: &str) {
        self.raised.take_thread();
    }

    fn progress(&self, case: &str, Progress { t, end }: Progress) {
        self.is_at(case, if end > 0.0 { t / end } else { 0.0 });
    }

    fn finished(&self, record: &CaseRecord, _: bool) {
        self.is_at(&record.id, 1.0);
    }
}
