//! Identifies the build for the provenance of results: a digest of the sources of the library, and the compiler.

use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Parts of `src` that belong to other packages: neither the command line nor the bundled files compute anything.
const OTHERS: [&str; 3] = ["src/main.rs", "src/cli/", "src/catalogue/files/"];

fn main() {
    let package = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("set by cargo"));
    // The package is the library or its unit tests
    let root =
        package.ancestors().find(|folder| folder.join("src/lib.rs").is_file()).expect("the folder of the workspace");
    let source = root.join("src");
    let mut files = vec![root.join("Cargo.toml"), root.join("Cargo.lock")];
    collect(&source, &mut files);
    let mut files: Vec<(String, PathBuf)> = files.into_iter().map(|file| (name(root, &file), file)).collect();
    files.retain(|(name, file)| file.is_file() && !OTHERS.iter().any(|other| name.starts_with(other)));
    files.sort();
    let mut hash = Sha256::new();
    for (name, file) in files {
        println!("cargo::rerun-if-changed={}", file.display());
        let bytes = std::fs::read(file).expect("a source file can be read");
        hash.update(name);
        hash.update(bytes.len().to_le_bytes());
        hash.update(bytes);
    }
    let digest: String = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
    println!("cargo::rustc-env=DUROMETER_SOURCE_SHA256={digest}");
    let of = |name: &str| std::env::var(name).unwrap_or_default();
    let version = Command::new(of("RUSTC")).arg("--version").output().ok();
    let version = version.map_or_else(String::new, |o| String::from_utf8_lossy(&o.stdout).trim().to_string());
    println!("cargo::rustc-env=DUROMETER_COMPILER={version}, {}, opt-level {}", of("TARGET"), of("OPT_LEVEL"));
}

/// The path below the root, with slashes.
fn name(root: &Path, file: &Path) -> String {
    file.strip_prefix(root).expect("below the root").to_string_lossy().replace('\\', "/")
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
