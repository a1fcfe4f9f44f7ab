//! How this program is started again, and the Python that it is a part of where that is so.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

static PYTHON: OnceLock<PathBuf> = OnceLock::new();

/// Says that this process is the interpreter `file` of Python, which has loaded the program as its package `durometer`. The first call counts.
pub fn set_python(file: impl Into<PathBuf>) {
    PYTHON.get_or_init(|| file.into());
}

/// The interpreter that has loaded this program.
pub fn python() -> Option<&'static Path> {
    PYTHON.get().map(PathBuf::as_path)
}

/// The command that makes new meshes possible, for messages.
pub fn setup() -> &'static str {
    if python().is_some() { "pip install \"durometer[mesh]\"" } else { "durometer doctor --setup" }
}

/// The file of a program and its first arguments, which those of the user follow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    pub file: PathBuf,
    pub arguments: Vec<OsString>,
}

impl Launch {
    /// This program for processes that it starts itself: the one that runs, also where its file has been replaced meanwhile.
    pub fn running() -> std::io::Result<Self> {
        let running = PathBuf::from("/proc/self/exe");
        let is_here = cfg!(target_os = "linux") && running.exists();
        if python().is_none() && is_here { Ok(running.into()) } else { Self::lasting() }
    }

    /// This program for processes that start when it has ended, such as those of a scheduler. Where the system does not say which it is, as Linux
    /// without `/proc`, it is the one that was called by a path.
    pub fn lasting() -> std::io::Result<Self> {
        if let Some(file) = python() {
            return Ok(Self { file: file.into(), arguments: ["-P", "-m", "durometer"].map(Into::into).to_vec() });
        }
        let called = || std::env::args_os().next().map(PathBuf::from).filter(|path| path.is_file());
        let found = std::env::current_exe().or_else(|e| called().map_or(Err(e), std::path::absolute));
        found.map(Into::into)
    }

    /// A command with these first arguments.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.file);
        command.args(&self.arguments);
        command
    }
}

impl From<PathBuf> for Launch {
    fn from(file: PathBuf) -> Self {
        Self { file, arguments: vec![] }
    }
}

impl From<&str> for Launch {
    fn from(file: &str) -> Self {
        PathBuf::from(file).into()
    }
}
