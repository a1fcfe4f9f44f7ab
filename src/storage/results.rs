//! A folder with the results of one command: written elsewhere first, moved into place when all of them are complete, and listed in `results.json`.

use super::{DATA_LIMIT, TEXT_LIMIT, keep, read, sha256, write};
use crate::wording::few;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::time::Duration;

/// Name of the file with the list of results.
pub const FILE: &str = "results.json";
/// Beginning and end of the name of the temporary folder in which results are written.
const PART: [&str; 2] = [".results-", ".part"];
/// Age after which such a folder is taken to be left by a killed command.
const LEFT: Duration = Duration::from_secs(3600);

/// Reason why results could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// The folder holds results of another command or of different input
    #[error("{}: holds {own}, which {by} would replace; name another folder with --out, or pass --replace", dir.display())]
    Others { dir: PathBuf, own: String, by: String },
    /// The folder holds a study, whose report is redrawn repeatedly
    #[error("{}: holds the results of a study; name another folder with --out", dir.display())]
    Study { dir: PathBuf },
    /// The folder holds files of the same names that are not in its list
    #[error(
        "{}: holds {files} not listed in {FILE}, which {by} would replace; name another folder with --out, or pass --replace",
        dir.display()
    )]
    Unlisted { dir: PathBuf, files: String, by: String },
    /// An input file cannot be read
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: Error },
    /// A folder or a file cannot be written
    #[error("{}: cannot be written: {source}; choose another folder with --out, or make room", path.display())]
    Write { path: PathBuf, source: Error },
}

/// An input file with its digest.
#[derive(Serialize, Deserialize, Clone, Debug)]
struct Input {
    name: String,
    sha256: String,
}

/// The subject of results: the command, the choice among its possible results, and the contents of its input files.
#[derive(Serialize, Deserialize, Clone, Debug)]
pub struct Subject {
    command: String,
    /// Which of several possible results of the command for these files; empty if there is only one
    #[serde(default, skip_serializing_if = "String::is_empty")]
    choice: String,
    inputs: Vec<Input>,
}

impl Subject {
    /// Reads the files from which a command produces results.
    pub fn read(command: &str, choice: impl Into<String>, files: &[PathBuf]) -> Result<Self, ResultsError> {
        let input = |path: &PathBuf| {
            let bytes = read(path, DATA_LIMIT).map_err(|source| ResultsError::Read { path: path.clone(), source })?;
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            Ok(Input { name, sha256: sha256(bytes) })
        };
        let inputs = files.iter().map(input).collect::<Result<_, _>>()?;
        Ok(Self { command: command.into(), choice: choice.into(), inputs })
    }

    /// Whether both have the same command, choice and file contents; the names of the files may differ.
    fn is_same(&self, other: &Self) -> bool {
        let digests = |of: &Self| of.inputs.iter().map(|i| i.sha256.clone()).collect::<Vec<_>>();
        self.command == other.command && self.choice == other.choice && digests(self) == digests(other)
    }

    /// A description such as `results of fit (Yeoh with 2 terms) of pull.csv`.
    fn words(&self) -> String {
        let choice = if self.choice.is_empty() { String::new() } else { format!(" ({})", self.choice) };
        let names: Vec<&str> = self.inputs.iter().map(|i| i.name.as_str()).collect();
        format!("results of {}{choice} of {}", self.command, few(&names))
    }
}

/// The list of the results in a folder.
#[derive(Serialize, Deserialize, Clone, Debug)]
struct List {
    #[serde(flatten)]
    subject: Subject,
    /// Paths below the folder
    files: BTreeSet<String>,
}

impl List {
    fn read(dir: &Path) -> Option<Self> {
        serde_json::from_slice(&read(&dir.join(FILE), TEXT_LIMIT).ok()?).ok()
    }

    fn write(&self, dir: &Path) -> Result<(), ResultsError> {
        let path = dir.join(FILE);
        let text = serde_json::to_string_pretty(self).expect("strings only") + "\n";
        write(&path, text.as_bytes()).map_err(|source| ResultsError::Write { path, source })
    }
}

/// A description of the results that a folder holds; `None` if it has no list of them.
pub fn held(dir: &Path) -> Option<String> {
    List::read(dir).map(|list| list.subject.words())
}

/// Adds files to the list of a folder, if it has one, after its report was redrawn.
pub fn add(dir: &Path, files: impl IntoIterator<Item = PathBuf>) -> Result<(), ResultsError> {
    let Some(mut list) = List::read(dir) else { return Ok(()) };
    list.files.extend(files.into_iter().filter_map(|file| file.strip_prefix(dir).ok().map(name)));
    list.write(dir)
}

/// A folder that may receive results.
pub struct Results {
    dir: PathBuf,
    subject: Subject,
    /// Paths of the results that it already holds
    earlier: BTreeSet<String>,
    /// Whether results of other commands may be replaced
    replace: bool,
}

impl Results {
    /// Refuses a folder that holds a study, and one that holds results of another command or of different input unless these may be replaced.
    pub fn check(dir: &Path, subject: Subject, replace: bool) -> Result<Self, ResultsError> {
        let dir = dir.to_path_buf();
        if dir.join("study.json").is_file() {
            return Err(ResultsError::Study { dir });
        }
        let earlier = List::read(&dir);
        if let Some(list) = earlier.as_ref().filter(|list| !replace && !list.subject.is_same(&subject)) {
            let (mut own, by) = (list.subject.words(), subject.words());
            if own == by {
                own += " with other contents";
            }
            return Err(ResultsError::Others { dir, own, by });
        }
        Ok(Self { dir, subject, earlier: earlier.map_or_else(BTreeSet::new, |list| list.files), replace })
    }

    /// Replaces the earlier results by the files that `fill` writes into an empty folder. If it fails, the earlier results are unchanged.
    pub fn write<T, E: From<ResultsError>>(self, fill: impl FnOnce(&Path) -> Result<T, E>) -> Result<T, E> {
        let refuse = |source| ResultsError::Write { path: self.dir.clone(), source };
        std::fs::create_dir_all(&self.dir).map_err(refuse)?;
        sweep(&self.dir);
        let part = tempfile::Builder::new().prefix(PART[0]).suffix(PART[1]).tempdir_in(&self.dir).map_err(refuse)?;
        let done = fill(part.path())?;
        let files = files_of(part.path()).map_err(refuse)?;
        self.check_files(&files)?;
        self.place(part.path(), files)?;
        Ok(done)
    }

    /// Refuses to replace unlisted files, and creates the folders of all files, before the first file is moved.
    fn check_files(&self, files: &BTreeSet<String>) -> Result<(), ResultsError> {
        let is_there = |file: &&String| self.dir.join(file.as_str()).symlink_metadata().is_ok();
        let unlisted: Vec<&String> = files.difference(&self.earlier).filter(is_there).collect();
        if !self.replace && !unlisted.is_empty() {
            let (dir, files, by) = (self.dir.clone(), few(&unlisted), self.subject.words());
            return Err(ResultsError::Unlisted { dir, files, by });
        }
        for path in files.iter().map(|file| self.dir.join(file)) {
            let made = match path.is_dir() {
                true => Err(ErrorKind::IsADirectory.into()),
                false => std::fs::create_dir_all(path.parent().unwrap_or(&self.dir)),
            };
            made.map_err(|source| ResultsError::Write { path, source })?;
        }
        Ok(())
    }

    /// Moves the files into place and removes the earlier ones that are no longer written. At any moment the list names all result files in the
    /// folder.
    fn place(self, part: &Path, files: BTreeSet<String>) -> Result<(), ResultsError> {
        let Self { dir, subject, earlier, .. } = self;
        let gone: Vec<String> = earlier.difference(&files).cloned().collect();
        List { subject: subject.clone(), files: &earlier | &files }.write(&dir)?;
        for file in &files {
            let path = dir.join(file);
            keep(&part.join(file), &path).map_err(|source| ResultsError::Write { path, source })?;
        }
        if gone.is_empty() {
            return Ok(());
        }
        gone.iter().filter(|file| is_inside(file)).for_each(|file| remove(&dir, file));
        List { subject, files }.write(&dir)
    }
}

/// Removes a file, and the folders below `dir` that become empty.
fn remove(dir: &Path, file: &str) {
    let path = dir.join(file);
    if std::fs::remove_file(&path).is_ok() {
        let folders = path.ancestors().skip(1).take_while(|folder| *folder != dir);
        folders.take_while(|folder| std::fs::remove_dir(folder).is_ok()).for_each(drop);
    }
}

/// Removes temporary folders that killed commands have left.
fn sweep(dir: &Path) {
    for entry in std::fs::read_dir(dir).into_iter().flatten().flatten() {
        let (name, changed) = (entry.file_name(), entry.metadata().and_then(|m| m.modified()).ok());
        let name = name.to_string_lossy();
        let is_old = changed.and_then(|t| t.elapsed().ok()).is_some_and(|age| age > LEFT);
        if is_old && name.starts_with(PART[0]) && name.ends_with(PART[1]) {
            std::fs::remove_dir_all(entry.path()).ok();
        }
    }
}

/// The names of all files below a folder.
fn files_of(dir: &Path) -> Result<BTreeSet<String>, Error> {
    let (mut files, mut folders) = (BTreeSet::new(), vec![dir.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                files.extend(path.strip_prefix(dir).ok().map(name));
            }
        }
    }
    Ok(files)
}

/// A relative path with slashes.
fn name(file: &Path) -> String {
    file.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Whether a listed path leads to a file below the folder.
fn is_inside(file: &str) -> bool {
    Path::new(file).components().all(|part| matches!(part, Component::Normal(_)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes results with these files, of a command on a table.
    fn put(dir: &Path, command: &str, table: &Path, replace: bool, names: &[&str]) -> Result<(), ResultsError> {
        let subject = Subject::read(command, "", &[table.to_path_buf()])?;
        Results::check(dir, subject, replace)?.write(|part| {
            names.iter().try_for_each(|name| {
                let path = part.join(name);
                std::fs::create_dir_all(path.parent().expect("a folder")).expect("room");
                write(&path, name.as_bytes()).map_err(|source| ResultsError::Write { path, source })
            })
        })
    }

    fn names(dir: &Path) -> Vec<String> {
        files_of(dir).expect("readable").into_iter().filter(|name| name != FILE).collect()
    }

    #[test]
    fn results_of_others_stay_and_own_ones_are_replaced_with_all_their_files() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (dir, table) = (folder.path().join("r"), folder.path().join("t.csv"));
        std::fs::write(&table, "1").expect("room");
        put(&dir, "fit", &table, false, &["law.toml", "mullins/m.toml", "tables/a.csv"]).expect("empty");
        std::fs::write(dir.join("tables/mine.csv"), "mine").expect("room");
        put(&dir, "fit", &table, false, &["law.toml"]).expect("the same again");
        assert_eq!(names(&dir), ["law.toml", "tables/mine.csv"]);
        assert!(!dir.join("mullins").exists(), "an empty folder stays");
        let refused = |command| put(&dir, command, &table, false, &["index.html"]).expect_err("others").to_string();
        let said = refused("prony");
        assert!(
            said.contains("holds results of fit of t.csv, which results of prony of t.csv would replace"),
            "{said}"
        );
        std::fs::write(&table, "2").expect("room");
        assert!(refused("fit").contains("t.csv with other contents"));
        assert_eq!(names(&dir), ["law.toml", "tables/mine.csv"]);
        put(&dir, "prony", &table, true, &["index.html"]).expect("asked for");
        assert_eq!(names(&dir), ["index.html", "tables/mine.csv"]);
        assert_eq!(held(&dir).as_deref(), Some("results of prony of t.csv"));
        add(&dir, [dir.join("tables/b.csv")]).expect("writable");
        std::fs::write(dir.join("tables/b.csv"), "drawn again").expect("room");
        put(&dir, "prony", &table, false, &["index.html"]).expect("the same again");
        assert_eq!(names(&dir), ["index.html", "tables/mine.csv"]);
    }

    #[test]
    fn a_failure_and_files_of_the_user_change_nothing() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (dir, table) = (folder.path().join("r"), folder.path().join("t.csv"));
        std::fs::write(&table, "1").expect("room");
        std::fs::create_dir_all(&dir).expect("room");
        std::fs::write(dir.join("law.toml"), "mine").expect("room");
        let said = put(&dir, "fit", &table, false, &["fit.json", "law.toml"]).expect_err("a law of the user");
        assert!(said.to_string().contains("holds law.toml not listed"), "{said}");
        let failed = Results::check(&dir, Subject::read("fit", "", std::slice::from_ref(&table)).expect("there"), true);
        let failed = failed.expect("replaces").write(|part| {
            std::fs::write(part.join("fit.json"), "half").expect("room");
            Err::<(), _>(ResultsError::Study { dir: part.to_path_buf() })
        });
        assert!(failed.is_err());
        std::fs::create_dir(dir.join("index.html")).expect("room");
        put(&dir, "fit", &table, true, &["fit.json", "index.html"]).expect_err("a folder in the place of a file");
        assert_eq!(std::fs::read_to_string(dir.join("law.toml")).expect("there"), "mine");
        assert_eq!(names(&dir), ["law.toml"]);
        std::fs::write(dir.join("study.json"), "{}").expect("room");
        assert!(put(&dir, "fit", &table, true, &["law.toml"]).is_err(), "into a study");
    }
}
