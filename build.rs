//! Names the build for the provenance of results: a digest of the sources, and the compiler.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() {
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    let mut files = vec![root.join("Cargo.toml"), root.join("Cargo.lock")];
    collect(&root.join("src"), &mut files);
    files.sort();
    let mut hash = Sha256::new();
    // A package of the library has no Cargo.lock of its own
    for file in files.iter().filter(|file| file.is_file()) {
        println!("cargo::rerun-if-changed={}", file.display());
        let name = file.strip_prefix(&root).expect("below the root");
        let bytes = std::fs::read(file).expect("a source file can be read");
        hash.update(name.to_string_lossy().replace('\\', "/"));
        hash.update(bytes.len().to_le_bytes());
        hash.update(bytes);
    }
    println!("cargo::rerun-if-changed=src");
    // A hundred test programs with the lines of the library would take 20 GB.
    if std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux") {
        println!("cargo::rustc-link-arg-tests=-Wl,--strip-debug");
    }
    let digest: String = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
    println!("cargo::rustc-env=DUROMETER_SOURCE_SHA256={digest}");
    let of = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(of("RUSTC")).arg("--version").output().ok();
    let version = version.map_or_else(String::new, |o| String::from_utf8_lossy(&o.stdout).trim().to_string());
    println!("cargo::rustc-env=DUROMETER_COMPILER={version}, {}, opt-level {}", of("TARGET"), of("OPT_LEVEL"));
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of sources").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else {
            files.push(path);
        }
    }
}
