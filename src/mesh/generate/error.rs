//! Reasons why there is no mesh.

use crate::catalogue::{CatalogueError, host};
use crate::mesh::MeshError;
use std::path::{Path, PathBuf};

/// Reason why there is no mesh.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum GenerateError {
    #[error(transparent)]
    Catalogue(#[from] CatalogueError),
    /// The folder of bodies belongs to the program itself.
    #[error(
        "{}: a mesh is not kept with the files of the program; set DUROMETER_HOME to the folder of a project, or leave --keep out",
        folder.display()
    )]
    NotKept { folder: PathBuf },
    #[error("unknown {what} {name}; {hint}")]
    Unknown { what: String, name: String, hint: String },
    #[error("{body}: parameter {name}: {fact}")]
    Parameter { body: String, name: String, fact: String },
    #[error("{}: {fact}; correct the declaration", file.display())]
    Declaration { file: PathBuf, fact: String },
    #[error("mesh request: {fact}; {remedy}")]
    Request { fact: String, remedy: String },
    #[error("{}: {reason}; check the path, its permissions and the free space", file.display())]
    Io { file: PathBuf, reason: String },
    /// A mesh file refers to files that cannot be used.
    #[error("{}: {fact}; {remedy}", file.display())]
    Refers { file: PathBuf, fact: String, remedy: String },
    #[error("no mesh {name} is stored and the mesher is not installed ({reason}); run: {}", host::setup())]
    NotInstalled { name: String, reason: String },
    #[error("the mesher refused the request: {fact}{}", hint(remedy))]
    Refused { fact: String, remedy: String },
    #[error("the mesher failed: {fact}{}{}", hint(remedy), tail(lines))]
    Failed {
        fact: String,
        remedy: String,
        /// Number of cells of the mesh that came closest, if only the number of cells was missed
        nearest: Option<usize>,
        lines: Vec<String>,
    },
    #[error("the mesher stopped ({status}) before it wrote a mesh; {remedy}{}", tail(lines))]
    Died { status: String, remedy: &'static str, lines: Vec<String> },
    #[error("the mesher was ended after its time limit of {seconds} s; {remedy}{}", tail(lines))]
    TimeLimit { seconds: f64, remedy: &'static str, lines: Vec<String> },
    #[error("{}: {fact}; delete the mesh and its manifest: they are made again", file.display())]
    Manifest { file: PathBuf, fact: String },
    #[error("setting up the mesher failed at: {command}{}; {remedy}", tail(lines))]
    Setup { command: String, remedy: String, lines: Vec<String> },
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl GenerateError {
    pub(super) fn io(file: &Path, error: &std::io::Error) -> Self {
        Self::Io { file: file.to_path_buf(), reason: error.to_string() }
    }
}

fn hint(remedy: &str) -> String {
    if remedy.is_empty() { String::new() } else { format!("; {remedy}") }
}

fn tail(lines: &[String]) -> String {
    let lines: Vec<&str> = lines.iter().map(|line| line.as_str()).filter(|line| !line.trim().is_empty()).collect();
    if lines.is_empty() { String::new() } else { format!("; it last said:\n  {}", lines.join("\n  ")) }
}
