//! Packs the files that are bundled with the program: studies, data, bodies with their meshes, and the mesher.

use flate2::{Compression, write::GzEncoder};
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Folders that are bundled with the program.
const BROUGHT: [&str; 3] = ["data", "meshes", "studies"];
/// Extensions of the files that are packed; other files, such as measured tables that a user has added, are left out.
const ENDINGS: [&str; 12] = ["csv", "gz", "inp", "json", "md", "py", "step", "stl", "toml", "txt", "vtk", "vtu"];

/// Writes `files.tar.gz`, and `files.txt` with the digest, the length and the name of each file. The digest of this list names the contents.
fn main() {
    let own = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let root = own.ancestors().nth(3).expect("the folder of the workspace");
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("set by cargo"));
    let archive = std::fs::File::create(out.join("files.tar.gz")).expect("the folder of the build is writable");
    let mut archive = tar::Builder::new(GzEncoder::new(archive, Compression::best()));
    let mut list = String::new();
    for (name, file) in &brought(root) {
        let bytes = std::fs::read(file).expect("a file of the project can be read");
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        archive.append_data(&mut header, name, bytes.as_slice()).expect("the folder of the build has room");
        let mut hash = Sha256::new();
        hash.update(&bytes);
        writeln!(list, "{} {} {name}", hex(hash), bytes.len()).expect("a text takes every line");
        // The folders of bodies are not watched: Python writes there when the tests of the mesher run
        println!("cargo::rerun-if-changed={}", file.display());
    }
    for folder in ["data", "studies"] {
        println!("cargo::rerun-if-changed={}", root.join(folder).display());
    }
    let packed = archive.into_inner().expect("the folder of the build has room");
    packed.finish().expect("the folder of the build has room");
    std::fs::write(out.join("files.txt"), &list).expect("the folder of the build has room");
    let mut hash = Sha256::new();
    hash.update(list);
    println!("cargo::rustc-env=DUROMETER_FILES_SHA256={}", hex(hash));
}

/// Names and paths of the files, sorted.
fn brought(root: &Path) -> Vec<(String, PathBuf)> {
    let mut files = vec![];
    BROUGHT.iter().for_each(|folder| collect(&root.join(folder), &mut files));
    let mut files: Vec<(String, PathBuf)> = files.into_iter().map(|file| (name(root, &file), file)).collect();
    files.retain(|(name, _)| is_brought(name));
    files.sort();
    files
}

/// Whether a file of these folders is bundled: not meshes of the cache, not tests, and not measured tables that may not be redistributed.
fn is_brought(name: &str) -> bool {
    let left = ["meshes/cache/", "meshes/meshgen/tests/"].iter().any(|folder| name.starts_with(folder));
    let fetched = name.starts_with("data/silicones/") && name.ends_with(".csv");
    let known = name.rsplit_once('.').is_some_and(|(_, ending)| ENDINGS.contains(&ending));
    known && !left && !fetched && !name.split('/').any(|part| part == "__pycache__" || part.starts_with('.'))
}

/// The path below the root, with slashes.
fn name(root: &Path, file: &Path) -> String {
    file.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/")
}

fn hex(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the project").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}
