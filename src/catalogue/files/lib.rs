//! The files that the program brings, packed: studies, data, bodies with their meshes, and the mesher.

/// The files, as tar and gzip.
pub const PACKED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/files.tar.gz"));
/// One line for each file, in their order: digest (SHA-256), length in bytes, and path below the root of a project.
pub const LIST: &str = include_str!(concat!(env!("OUT_DIR"), "/files.txt"));
/// SHA-256 of the list.
pub const DIGEST: &str = env!("DUROMETER_FILES_SHA256");
