//! The files to which a mesh file refers: its mesh depends on the content of all of them.

use super::error::GenerateError;
use crate::mesh::file::format::content;
use crate::storage::{self, DATA_LIMIT};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest depth of nested includes; the mesher has the same limit.
const MOST_LEVELS: usize = 16;
/// Largest number of included files, counted with repetition; the mesher has the same limit.
const MOST_FILES: usize = 1000;

/// Returns the SHA-256 of `begin` followed by the content of a mesh file and of the files to which it refers.
pub fn digest(begin: &str, path: &Path, format: &str) -> Result<String, GenerateError> {
    let read = |file: &Path| storage::read(file, DATA_LIMIT).map_err(|e| GenerateError::io(file, &e));
    let mut hash = Sha256::new();
    hash.update(begin);
    hash.update(read(path)?);
    for other in files(path, format)? {
        hash.update(Sha256::digest(read(&other)?));
    }
    Ok(storage::hexadecimal(&hash.finalize()))
}

/// Returns the files to which a mesh file refers.
fn files(path: &Path, format: &str) -> Result<Vec<PathBuf>, GenerateError> {
    let folder = folder(path, format)?;
    Ok(names(path, format)?.iter().map(|name| folder.join(name)).collect())
}

/// Returns the folder to which names in a mesh file are relative. XML readers search next to the target of a symbolic link.
pub fn folder(path: &Path, format: &str) -> Result<PathBuf, GenerateError> {
    let path = match format {
        "xdmf" | "dolfin-xml" => path.canonicalize().map_err(|e| GenerateError::io(path, &e))?,
        _ => path.to_path_buf(),
    };
    Ok(path.parent().unwrap_or(Path::new("")).to_path_buf())
}

/// Returns the files to which a mesh file refers, and those over which its format distributes the mesh by their names, each once, named relative to
/// its folder.
///
/// # Errors
/// A file that is missing or not a regular file, files that include each other in a cycle, or more files than a mesh can need.
pub fn names(path: &Path, format: &str) -> Result<Vec<PathBuf>, GenerateError> {
    let folder = folder(path, format)?;
    let found = match format {
        "abaqus" => {
            let mut all =
                Includes { main: path, folder: &folder, known: BTreeMap::new(), open: vec![], files: 0, bytes: 0 };
            all.follow(Path::new(path.file_name().unwrap_or_default()))?;
            all.known.into_keys().filter(|name| folder.join(name) != path).collect()
        }
        "xdmf" => data_items(path)?,
        "dolfin-xml" => mesh_functions(path, &folder),
        "tetgen" => ["node", "ele"]
            .iter()
            .map(|end| path.with_extension(end))
            .filter(|other| other != path && other.is_file())
            .filter_map(|other| other.file_name().map(PathBuf::from))
            .collect(),
        _ => vec![],
    };
    found.iter().try_for_each(|name| size(path, &folder, name).map(|_| ()))?;
    Ok(found)
}

fn refused(path: &Path, fact: String, remedy: &str) -> GenerateError {
    GenerateError::Refers { file: path.into(), fact, remedy: remedy.into() }
}

/// Returns the size in bytes of a file to which `path` refers; a file that is not regular is refused before it is opened.
fn size(path: &Path, folder: &Path, name: &Path) -> Result<u64, GenerateError> {
    let fact = |what: &str| format!("it refers to {}, which {what}", name.display());
    match std::fs::metadata(folder.join(name)) {
        Ok(about) if about.is_file() => Ok(about.len()),
        Ok(_) => Err(refused(path, fact("is not a regular file"), "give a file, not a pipe, a device or a folder")),
        Err(e) => Err(refused(path, fact(&format!("cannot be read ({e})")), "give this file too, or correct its name")),
    }
}

/// Traversal of an Abaqus input file and the files that it includes, in the order in which the mesher reads them.
struct Includes<'a> {
    main: &'a Path,
    folder: &'a Path,
    /// Files included by each file
    known: BTreeMap<PathBuf, Vec<PathBuf>>,
    /// The file being read, preceded by those that include it
    open: Vec<PathBuf>,
    files: usize,
    bytes: u64,
}

impl Includes<'_> {
    fn follow(&mut self, name: &Path) -> Result<(), GenerateError> {
        let refuse = |fact: String, remedy: &str| Err(refused(self.main, fact, remedy));
        if self.open.iter().any(|other| other == name) {
            let names: Vec<_> =
                self.open.iter().map(PathBuf::as_path).chain([name]).map(|n| n.to_string_lossy()).collect();
            return refuse(format!("files include each other: {}", names.join(" → ")), "remove one *INCLUDE of them");
        }
        if self.open.len() == MOST_LEVELS || self.files == MOST_FILES {
            let fact = format!("more than {MOST_LEVELS} levels of *INCLUDE, or more than {MOST_FILES} included files");
            return refuse(fact, "write the mesh into fewer files");
        }
        self.files += 1;
        self.bytes += size(self.main, self.folder, name)?;
        if self.bytes > DATA_LIMIT {
            let fact = format!("the file and those that it includes have more than {} MiB", DATA_LIMIT >> 20);
            return refuse(fact, "give a smaller mesh");
        }
        let included = match self.known.get(name) {
            Some(known) => known.clone(),
            None => {
                let bytes = content(&self.folder.join(name))?;
                let found = included(&String::from_utf8_lossy(&bytes));
                self.known.entry(name.into()).or_insert(found).clone()
            }
        };
        self.open.push(name.into());
        included.iter().try_for_each(|other| self.follow(other))?;
        self.open.pop();
        Ok(())
    }
}

/// Whether the mesher strips this character at the ends of words.
fn is_blank(letter: char) -> bool {
    letter.is_whitespace() || ('\x1c'..='\x1f').contains(&letter)
}

/// Keywords that may name a file: one with whole lines of input, or with their data lines.
const WITH_INPUT: [&str; 6] = ["include", "node", "element", "nset", "elset", "surface"];

/// Returns the names in keywords `*INCLUDE, INPUT=name`, `*NODE, INPUT=name` and similar. A keyword line that ends with a comma continues on the next
/// line.
fn included(text: &str) -> Vec<PathBuf> {
    let (mut keyword, mut names) = (String::new(), vec![]);
    for line in text.split(['\n', '\r']).map(|line| line.trim_matches(is_blank)) {
        let is_part = !keyword.is_empty() || line.starts_with('*');
        if line.is_empty() || line.starts_with("**") || !is_part {
            continue;
        }
        keyword += line;
        if !keyword.ends_with(',') {
            names.extend(input(&keyword));
            keyword.clear();
        }
    }
    names
}

/// Returns the file that a keyword names, possibly as a Windows path; the mesher interprets it in the same way. Keyword and option may be abbreviated
/// and contain blanks; the mesher refuses ambiguous abbreviations.
fn input(keyword: &str) -> Option<PathBuf> {
    let mut words = keyword[1..].split(',').map(|word| word.trim_matches(is_blank));
    let means = |word: &str, short: &str| {
        let short = short.replace(is_blank, "").to_ascii_lowercase();
        !short.is_empty() && word.starts_with(&short)
    };
    let takes_input = words.next().is_some_and(|name| WITH_INPUT.iter().any(|word| means(word, name)));
    let options = words.filter_map(|option| option.split_once('='));
    let mut inputs = options.filter(|(key, _)| means("input", key));
    let (_, name) = inputs.next_back().filter(|_| takes_input)?;
    Some(name.trim_matches(is_blank).trim_matches('"').replace('\\', "/").into())
}

/// Returns the files with the data of an XDMF file: `name.h5:/path`, or a plain name.
fn data_items(path: &Path) -> Result<Vec<PathBuf>, GenerateError> {
    let bytes = content(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(&text, options)
        .map_err(|e| refused(path, format!("its XML is not well formed: {e}"), "write it again"))?;
    let mut names = vec![];
    for item in document.descendants() {
        let words = || item.children().take_while(|c| !c.is_element()).filter_map(|c| c.text()).collect::<String>();
        let name = match item.attribute("Format") {
            Some("HDF") => words().split(':').next().unwrap_or_default().trim().to_string(),
            Some("Binary") => words().trim().to_string(),
            _ => continue,
        };
        if !names.contains(&PathBuf::from(&name)) {
            names.push(name.into());
        }
    }
    Ok(names)
}

/// Returns the files `<name>_<function>.xml` of a DOLFIN mesh, which contain data of its cells.
fn mesh_functions(path: &Path, folder: &Path) -> Vec<PathBuf> {
    let begin = format!("{}_", path.file_stem().unwrap_or_default().to_string_lossy());
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    let mut found: Vec<_> = names.filter(|n| n.starts_with(&begin) && n.contains(".xml")).map(PathBuf::from).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a folder with files of these names and contents.
    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("writable");
            std::fs::write(path, text).expect("writable");
        }
        folder
    }

    /// Asserts that each of the files affects the digest.
    fn all_count(format: &str, files: &[(&str, &str)]) {
        let folder = folder(files);
        let digest = || digest("", &folder.path().join(files[0].0), format).unwrap_or_else(|e| panic!("{e}"));
        let before = digest();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), format!("{text} ")).expect("writable");
            assert_ne!(digest(), before, "{format}: {name}");
            std::fs::write(folder.path().join(name), text).expect("writable");
            assert_eq!(digest(), before);
        }
    }

    fn refusal(files: &[(&str, &str)]) -> String {
        names(&folder(files).path().join(files[0].0), "abaqus").expect_err("must be refused").to_string()
    }

    #[test]
    fn every_file_that_a_mesh_file_refers_to_counts() {
        let main = "*Heading\n*include,\r\n Input = \"sub/a.inp\"\n** *INCLUDE, INPUT=none.inp\n*Node\n1, 0, 0, 0\n";
        all_count("abaqus", &[("m.inp", main), ("sub/a.inp", "*INCLUDE, INPUT=b.inp"), ("b.inp", "*NODE")]);
        let main = "*NODE, NSET=all, INPUT=nodes.txt\n*ELEMENT, TYPE=C3D4, INPUT=e.txt\n*NSET, NSET=x, input=x.txt\n*STEP, INPUT=none\n";
        all_count(
            "abaqus",
            &[("m.inp", main), ("nodes.txt", "1, 0, 0, 0"), ("e.txt", "1, 1, 2, 3, 4"), ("x.txt", "1")],
        );
        all_count("abaqus", &[("m.inp", "*INCLUDE, INPUT=.\\sub\\a.inp"), ("sub/a.inp", "*NODE")]);
        let short = "*INCL, INP=a.inp\n* E lem, TYPE=C3D4, I N=e.txt\n*SUBMODEL, INPUT=none\n";
        all_count("abaqus", &[("m.inp", short), ("a.inp", "*NODE"), ("e.txt", "1, 1, 2, 3, 4")]);
        let item = |format: &str, text: &str| format!("<DataItem Format=\"{format}\">\n {text} </DataItem>");
        let items = [item("HDF", "fields.h5:/x"), item("Binary", "cells.bin"), item("XML", "0 1 2")].concat();
        let xdmf = format!("<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf>{items}</Xdmf>");
        all_count("xdmf", &[("m.xdmf", &xdmf), ("fields.h5", "x"), ("cells.bin", "y")]);
        all_count("dolfin-xml", &[("m.xml", "<dolfin/>"), ("m_domains.xml", "<dolfin/>")]);
        all_count("tetgen", &[("m.ele", "1"), ("m.node", "2")]);
        let moved = |main: &str, other: &str| {
            let folder = folder(&[("m.inp", main), ("a.inp", other)]);
            digest("", &folder.path().join("m.inp"), "abaqus").expect("two files")
        };
        let (first, second) = ("*INCLUDE, INPUT=a.inp\n", "*NODE\n");
        assert_ne!(moved(&format!("{first}{second}"), second), moved(first, &format!("{second}{second}")));
    }

    #[test]
    fn a_file_alone_has_the_digest_of_its_content() {
        let folder = folder(&[("m.inp", "*NODE\n"), ("nodes.inp", "")]);
        assert_eq!(digest("", &folder.path().join("m.inp"), "abaqus"), Ok(storage::sha256("*NODE\n")));
    }

    #[test]
    fn includes_without_an_end_are_refused() {
        let cycle = refusal(&[("m.inp", "*INCLUDE, INPUT=a.inp"), ("a.inp", "*INCLUDE, INPUT=m.inp")]);
        assert!(cycle.contains("files include each other: m.inp → a.inp → m.inp; remove one"), "{cycle}");
        let twice = |next: &str| format!("*INCLUDE, INPUT={next}\n*INCLUDE, INPUT={next}\n");
        let texts: Vec<_> = (0..=12).map(|i| (format!("l{i}.inp"), twice(&format!("l{}.inp", i + 1)))).collect();
        let mut files: Vec<_> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        files.push(("l13.inp", "*NODE"));
        assert!(refusal(&files).contains("more than 1000 included files; write"), "{}", refusal(&files));
        let texts: Vec<_> = (0..20).map(|i| (format!("l{i}.inp"), format!("*INCLUDE, INPUT=l{}.inp", i + 1))).collect();
        let files: Vec<_> = texts.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
        assert!(refusal(&files).contains("more than 16 levels"), "{}", refusal(&files));
    }

    #[test]
    fn a_file_that_is_missing_or_has_no_end_is_refused() {
        let absent = refusal(&[("m.inp", "*INCLUDE, INPUT=absent.inp")]);
        assert!(absent.contains("it refers to absent.inp, which cannot be read") && absent.contains("give this file"));
        let folder = refusal(&[("m.inp", "*INCLUDE, INPUT=sub"), ("sub/a.inp", "")]);
        assert!(folder.contains("sub, which is not a regular file; give a file, not a pipe"), "{folder}");
        #[cfg(unix)]
        assert!(refusal(&[("m.inp", "*INCLUDE, INPUT=/dev/zero")]).contains("/dev/zero, which is not a regular file"));
    }
}
