//! The catalogue: studies, data, bodies with their meshes, and the mesher, in the folder of a project or as bundled with the program.
//!
//! Some of these files are Python programs. They are taken from a folder that the user has named or in which the program was built, otherwise from
//! the program itself, and never from the current folder, which may belong to anyone.

mod brought;
pub mod cache;
mod embedded;
mod error;
mod home;
pub mod host;

pub use brought::{brought, brought_command, is_of_catalogue};
pub use embedded::{Archive, Entry, archive, bring};
pub use error::CatalogueError;
pub use home::{Home, Origin};
pub use host::Launch;
