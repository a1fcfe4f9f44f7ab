//! The process of the mesher: calling it, setting up its environment, and finding missing requirements.

use super::error::GenerateError;
use super::interpreter;
use super::running::Running;
use crate::catalogue::{Home, host};
use crate::subprocess::ends_with_parent;
use serde::Deserialize;
use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead, BufReader, Read, Seek, Write};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Number of lines of stderr that an error contains.
const KEPT: usize = 12;

/// Largest number of bytes of an answer that are kept.
const ANSWER: u64 = 256 << 20;

/// Remedies if the mesher takes too long: a conversion has neither a size nor a key for its time limit.
const MESHING_LATE: &str = "ask for fewer cells or a larger size, try the other generator, or raise mesh.time_limit";
const CONVERSION_LATE: &str = "give a smaller mesh, or write it as .msh or legacy .vtk, which need no conversion";

/// Remedies if the mesher ends without an answer: a file on which a library crashes cannot be read.
const MESHING_ENDED: &str = "try another size or seed";
const CONVERSION_ENDED: &str =
    "the file cannot be read: write it in another format, such as MSH 4.1 or VTU, with cells of order 1 or 2";

/// The command that installs Python on this system.
const INSTALL: &str = if cfg!(windows) {
    "winget install Python.Python.3.13"
} else if cfg!(target_os = "macos") {
    "brew install python"
} else {
    "apt-get install -y python3 python3-venv"
};

/// One line of the doctor's report.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Check {
    pub what: String,
    pub ok: bool,
    pub detail: String,
    /// Exact command that resolves the problem
    pub remedy: Option<String>,
    /// Whether meshes by gmsh do not need it (CGAL)
    pub optional: bool,
}

/// Refusal by the mesher: `{"error", "hint", "nearest"}`.
#[derive(Deserialize)]
struct Refusal {
    error: String,
    #[serde(default)]
    hint: String,
    nearest: Option<usize>,
}

/// Output of a finished process.
struct Output {
    status: ExitStatus,
    stdout: String,
    /// The last lines of stderr
    lines: Vec<String>,
    /// Whether it was ended because it took too long
    late: bool,
}

/// Runs a command to its end, or ends it after `limit`; every line of stderr is passed to `progress` as it arrives.
fn run(
    command: &mut Command,
    input: &str,
    limit: Option<Duration>,
    progress: &mut dyn FnMut(&str),
) -> std::io::Result<Output> {
    let start = Instant::now();
    // From a file: a process that dies before it has read all of it must not end this process (SIGPIPE).
    let mut stdin = tempfile::tempfile()?;
    stdin.write_all(input.as_bytes())?;
    stdin.rewind()?;
    command.stdin(stdin).stdout(Stdio::piped()).stderr(Stdio::piped());
    ends_with_parent(command);
    let mut child = command.spawn()?;
    let running = Running::new(child.id());
    let mut stdout = child.stdout.take().expect("piped");
    let stderr = child.stderr.take().expect("piped");
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        // More than any valid answer: the rest is read and dropped, so that the mesher does not block
        stdout.by_ref().take(ANSWER).read_to_end(&mut bytes).ok();
        std::io::copy(&mut stdout, &mut std::io::sink()).ok();
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let (send, receive) = channel();
    std::thread::spawn(move || {
        let mut said = BufReader::new(stderr).split(b'\n').map_while(Result::ok);
        said.all(|line| send.send(String::from_utf8_lossy(&line).trim_end().to_string()).is_ok())
    });
    let (mut lines, mut late) = (VecDeque::new(), false);
    // Without a limit, wait for more than a hundred years.
    let limit = limit.unwrap_or(Duration::from_secs(u32::MAX.into()));
    loop {
        let line = match receive.recv_timeout(limit.saturating_sub(start.elapsed())) {
            Ok(line) => line,
            Err(RecvTimeoutError::Disconnected) => break,
            Err(RecvTimeoutError::Timeout) => {
                late = true;
                child.kill()?;
                break;
            }
        };
        progress(&line);
        if lines.len() == KEPT {
            lines.pop_front();
        }
        lines.push_back(line);
    }
    drop(running);
    let status = child.wait()?;
    // A process started by the ended one may keep its stdout open.
    let stdout = if late { String::new() } else { reader.join().expect("reading does not panic") };
    Ok(Output { status, stdout, lines: lines.into(), late })
}

/// The mesher: its folder, and the Python that runs it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mesher<'a> {
    pub home: &'a Home,
    pub python: &'a Path,
}

impl Mesher<'_> {
    /// Returns the command `python -m meshgen` with the folder of the bodies in its path.
    fn meshgen(&self) -> Command {
        let mut command = Command::new(self.python);
        command.args(["-m", "meshgen"]).current_dir(&self.home.path);
        command
            .env("PYTHONPATH", self.home.path.join("meshes"))
            .env("PYTHONUNBUFFERED", "1")
            .env("PYTHONDONTWRITEBYTECODE", "1");
        command
    }

    /// Creates the environment of the mesher, or uses that of the Python of which this program is a package, and installs its pinned packages.
    /// `progress` receives pip's output line by line.
    pub fn setup_environment(&self, progress: &mut dyn FnMut(&str)) -> Result<(), GenerateError> {
        let folder = &self.home.environment;
        let own = host::python().map_or_else(|| interpreter::in_environment(folder), Path::to_path_buf);
        let mut steps = Vec::new();
        if !own.exists() {
            let mut venv = Command::new(self.python);
            venv.args(["-m", "venv"]).arg(folder.strip_prefix(&self.home.path).unwrap_or(folder));
            let remedy = if cfg!(target_os = "linux") { "apt-get install -y python3-venv" } else { INSTALL };
            steps.push((venv, format!("install Python 3.11 or newer with venv: {remedy}")));
        }
        let mut pip = Command::new(&own);
        pip.args(["-m", "pip", "install", "--disable-pip-version-check", "-r", "meshes/meshgen/requirements.txt"]);
        steps.push((pip, "check the network, then run it again".to_string()));
        for (mut command, remedy) in steps {
            let text = describe(&command);
            progress(&text);
            let failed = |lines| GenerateError::Setup { command: text.clone(), remedy: remedy.clone(), lines };
            let output = run(command.current_dir(&self.home.path), "", None, progress)
                .map_err(|e| failed(vec![e.to_string()]))?;
            let said = output.stdout.lines().map(str::to_string);
            said.clone().for_each(|line| progress(&line));
            if !output.status.success() {
                let lines: Vec<String> = said.chain(output.lines).collect();
                return Err(failed(lines[lines.len().saturating_sub(KEPT)..].to_vec()));
            }
        }
        Ok(())
    }

    /// Returns the requirements of the mesher and whether they are met, with the command that installs a missing one.
    pub fn diagnose(&self) -> Vec<Check> {
        // If DUROMETER_PYTHON is set, setting up a separate environment would have no effect
        let given = std::env::var_os("DUROMETER_PYTHON").is_some_and(|given| Path::new(&given) == self.python);
        let requirements = self.home.path.join("meshes/meshgen/requirements.txt");
        let setup = || {
            let pip = format!("{} -m pip install -r {}", self.python.display(), requirements.display());
            Some(if given { pip } else { host::setup().to_string() })
        };
        let check = |what: &str, ok: bool, detail: String, remedy: Option<String>| Check {
            what: what.into(),
            ok,
            detail,
            remedy: remedy.filter(|_| !ok),
            optional: false,
        };
        let home = self.home.path.join("meshes").join("meshgen");
        let mut checks = vec![check("meshes/meshgen", home.is_dir(), home.display().to_string(), None)];
        let version =
            Command::new(self.python).args(["-c", "import sys; print('%d.%d.%d' % sys.version_info[:3])"]).output();
        let other = || "unset DUROMETER_PYTHON, or let it name a Python 3.11 or newer".to_string();
        let install = || Some(if given { other() } else { INSTALL.to_string() });
        let version = match version {
            Ok(out) if out.status.success() => String::from_utf8_lossy(&out.stdout).trim().to_string(),
            Ok(out) => {
                checks.push(check(
                    "python",
                    false,
                    format!("{} ends with {}", self.python.display(), out.status),
                    install(),
                ));
                return checks;
            }
            Err(e) => {
                checks.push(check("python", false, format!("{}: {e}", self.python.display()), install()));
                return checks;
            }
        };
        let numbers: Vec<u32> = version.split('.').filter_map(|n| n.parse().ok()).collect();
        let new = numbers.as_slice() >= [3, 11].as_slice();
        let detail = format!("{version} ({})", self.python.display());
        checks.push(check(
            "python",
            new,
            detail,
            Some(if given { other() } else { "install Python 3.11 or newer".into() }),
        ));
        let venv =
            host::python().map_or_else(|| interpreter::in_environment(&self.home.environment), Path::to_path_buf);
        let packages = match run(self.meshgen().arg("--doctor"), "", None, &mut |_| {}) {
            Ok(output) => match serde_json::from_str::<Examination>(&output.stdout) {
                Ok(found) => found.checks(setup),
                Err(e) => vec![check("mesher", false, format!("{}: {e}", output.status), setup())],
            },
            Err(e) => vec![check("mesher", false, e.to_string(), setup())],
        };
        let own = venv.exists() || given;
        // A Python that has all packages needs no environment
        let has_all = packages.iter().all(|c| c.ok || c.optional);
        let detail = match (given, own || !has_all) {
            (true, _) => format!("not needed: DUROMETER_PYTHON names {}", self.python.display()),
            (_, true) => venv.display().to_string(),
            (_, false) => format!("not needed: {} has the packages", self.python.display()),
        };
        checks.push(check("environment", own || has_all, detail, setup()));
        checks.extend(packages);
        checks
    }

    /// Sends one request to the mesher, which is ended after `limit_s`; returns the manifest as JSON.
    pub(super) fn call(
        &self,
        request: &serde_json::Value,
        name: &str,
        limit_s: f64,
        progress: &mut dyn FnMut(&str),
    ) -> Result<String, GenerateError> {
        let missing = |reason: String| GenerateError::NotInstalled { name: name.into(), reason };
        let limit = Duration::try_from_secs_f64(limit_s).ok();
        let output = run(&mut self.meshgen(), &request.to_string(), limit, progress)
            .map_err(|e| missing(format!("{}: {e}", self.python.display())))?;
        let [late, ended] = match request.get("convert") {
            Some(_) => [CONVERSION_LATE, CONVERSION_ENDED],
            None => [MESHING_LATE, MESHING_ENDED],
        };
        if output.late {
            return Err(GenerateError::TimeLimit { seconds: limit_s, remedy: late, lines: output.lines });
        }
        if output.status.success() {
            return Ok(output.stdout);
        }
        let said = serde_json::from_str::<Refusal>(&output.stdout);
        let lines = output.lines;
        match (output.status.code(), said) {
            (_, Ok(Refusal { error, .. })) if error.starts_with("the mesher is not installed") => {
                Err(missing(error.trim_start_matches("the mesher is not installed: ").to_string()))
            }
            (Some(2), Ok(Refusal { error, hint, .. })) => Err(GenerateError::Refused { fact: error, remedy: hint }),
            (_, Ok(Refusal { error, hint, nearest })) => {
                Err(GenerateError::Failed { fact: error, remedy: hint, nearest, lines })
            }
            // Python itself fails before the mesher runs: too old, or no such module.
            (Some(1), Err(_)) if lines.iter().any(|l| l.contains("No module named")) => {
                Err(missing(lines.last().cloned().unwrap_or_default()))
            }
            (_, Err(_)) => Err(GenerateError::Died { status: output.status.to_string(), remedy: ended, lines }),
        }
    }
}

/// The mesher's report on its packages.
#[derive(Deserialize)]
struct Examination {
    versions: BTreeMap<String, Option<String>>,
    #[serde(default)]
    errors: BTreeMap<String, PackageError>,
}

#[derive(Deserialize)]
struct PackageError {
    error: String,
    #[serde(default)]
    missing_library: Option<String>,
    #[serde(default)]
    debian_package: Option<String>,
}

impl Examination {
    /// Returns the lines of the report; `setup` returns the command that installs a package.
    fn checks(self, setup: impl Fn() -> Option<String>) -> Vec<Check> {
        let one = |(what, version): (String, Option<String>)| {
            let optional = what == "cgal";
            let Some(error) = self.errors.get(&what) else {
                let detail = version.unwrap_or_else(|| "installed".into());
                return Check { what, ok: true, detail, remedy: None, optional };
            };
            let package =
                error.debian_package.as_ref().map(|p| format!("apt-get install -y --no-install-recommends {p}"));
            let search = error.missing_library.as_ref().map(|l| format!("install the package that holds {l}"));
            let remedy = package.or(search).or_else(&setup);
            Check { what, ok: false, detail: error.error.clone(), remedy, optional }
        };
        self.versions.clone().into_iter().map(one).collect()
    }
}

fn describe(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|w| w.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
