//! How this program starts itself again, and the Python interpreter that has loaded it, if any.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

static PYTHON: OnceLock<PathBuf> = OnceLock::new();

/// Declares that this process is the Python interpreter `file`, which has loaded the program as its package `durometer`. Only the first call has an
/// effect.
pub fn set_python(file: impl Into<PathBuf>) {
    PYTHON.get_or_init(|| file.into());
}

/// The Python interpreter that has loaded this program, if any.
pub fn python() -> Option<&'static Path> {
    PYTHON.get().map(PathBuf::as_path)
}

/// The command that installs what new meshes need, for messages.
pub fn setup() -> &'static str {
    if python().is_some() { "pip install \"durometer[mesh]\"" } else { "durometer doctor --setup" }
}

/// The file of a program with its leading arguments, which precede those of the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Launch {
    pub file: PathBuf,
    pub arguments: Vec<OsString>,
}

impl Launch {
    /// This program, for processes that it starts itself: the running executable, even if its file has been replaced meanwhile.
    pub fn running() -> std::io::Result<Self> {
        let running = PathBuf::from("/proc/self/exe");
        let is_here = cfg!(target_os = "linux") && running.exists();
        if python().is_none() && is_here { Ok(running.into()) } else { Self::lasting() }
    }

    /// This program, for processes that start after it has ended, such as those of a scheduler. Where the system does not report the executable, as
    /// on Linux without `/proc`, it is found by the path that it was called with.
    pub fn lasting() -> std::io::Result<Self> {
        if let Some(file) = python() {
            return Ok(Self { file: file.into(), arguments: ["-P", "-m", "durometer"].map(Into::into).to_vec() });
        }
        let called = || std::env::args_os().next().map(PathBuf::from).filter(|path| path.is_file());
        let found = std::env::current_exe().or_else(|e| called().map_or(Err(e), std::path::absolute));
        found.map(Into::into)
    }

    /// A command with these leading arguments.
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
