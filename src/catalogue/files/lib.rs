//! The files that are bundled with the program, packed: studies, data, bodies with their meshes, and the mesher.

/// The files as a gzipped tar archive.
pub const PACKED: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/files.tar.gz"));
/// One line for each file, in the order of the archive: digest (SHA-256), length in bytes, and path below the root of a project.
pub const LIST: &str = include_str!(concat!(env!("OUT_DIR"), "/files.txt"));
/// SHA-256 of the list.
pub const DIGEST: &str = env!("DUROMETER_FILES_SHA256");
