//! Names the build for the provenance of results, a digest of the sources and the compiler, and packs the files that the program brings:
//! studies, data, bodies with their meshes, and the mesher.

use flate2::{Compression, write::GzEncoder};
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders that the program brings.
const BROUGHT: [&str; 3] = ["data", "meshes", "studies"];
/// Kinds of files there; others, such as measured tables of others that a user has put there, stay where they are.
const ENDINGS: [&str; 12] = ["csv", "gz", "inp", "json", "md", "py", "step", "stl", "toml", "txt", "vtk", "vtu"];

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    name_build(&root);
    pack(&root);
    // A hundred test programs with the lines of the library would take 20 GB.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-link-arg-tests=-Wl,--strip-debug");
    }
}

fn name_build(root: &Path) {
    let mut files = vec![root.join("Cargo.toml"), root.join("Cargo.lock")];
    collect(&root.join("src"), &mut files);
    files.sort();
    let mut hash = Sha256::new();
    // A package of the library has no Cargo.lock of its own
    for file in files.iter().filter(|file| file.is_file()) {
        println!("cargo::rerun-if-changed={}", file.display());
        let bytes = std::fs::read(file).expect("a source file can be read");
        hash.update(name(root, file));
        hash.update(bytes.len().to_le_bytes());
        hash.update(bytes);
    }
    println!("cargo::rerun-if-changed=src");
    println!("cargo::rustc-env=DUROMETER_SOURCE_SHA256={}", hex(hash));
    let of = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(of("RUSTC")).arg("--version").output().ok();
    let version = version.map_or_else(String::new, |o| String::from_utf8_lossy(&o.stdout).trim().to_string());
    println!("cargo::rustc-env=DUROMETER_COMPILER={version}, {}, opt-level {}", of("TARGET"), of("OPT_LEVEL"));
}

/// Writes `files.tar.gz`, and `files.txt` with the digest, the length and the name of each file. The digest of this list names the contents.
fn pack(root: &Path) {
    let mut files = vec![];
    BROUGHT.iter().for_each(|folder| collect(&root.join(folder), &mut files));
    let mut files: Vec<(String, PathBuf)> = files.into_iter().map(|file| (name(root, &file), file)).collect();
    files.retain(|(name, _)| is_brought(name));
    files.sort();
    let out = PathBuf::from(std::env::var("OUT_DIR").expect("set by cargo"));
    let archive = std::fs::File::create(out.join("files.tar.gz")).expect("the folder of the build is writable");
    let mut archive = tar::Builder::new(GzEncoder::new(archive, Compression::best()));
    let mut list = String::new();
    for (name, file) in &files {
        let bytes = std::fs::read(file).expect("a file of the project can be read");
        let mut header = tar::Header::new_gnu();
        header.set_size(bytes.len() as u64);
        header.set_mode(0o644);
        header.set_cksum();
        archive.append_data(&mut header, name, bytes.as_slice()).expect("the folder of the build has room");
        let mut hash = Sha256::new();
        hash.update(&bytes);
        writeln!(list, "{} {} {name}", hex(hash), bytes.len()).expect("a text takes every line");
        // Not the folders of bodies: Python writes there when the tests of the mesher run
        println!("cargo::rerun-if-changed={}", file.display());
    }
    println!("cargo::rerun-if-changed=data");
    println!("cargo::rerun-if-changed=studies");
    let packed = archive.into_inner().expect("the folder of the build has room");
    packed.finish().expect("the folder of the build has room");
    std::fs::write(out.join("files.txt"), &list).expect("the folder of the build has room");
    let mut hash = Sha256::new();
    hash.update(list);
    println!("cargo::rustc-env=DUROMETER_FILES_SHA256={}", hex(hash));
}

/// Whether the program brings a file of these folders: neither meshes of the cache, nor tests, nor measured tables that may not be passed on.
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
