//! The folder of a new project: it gets its name once it is complete.

use super::error::StarterError;
use crate::storage;
use crate::study::schema::{Described, SCHEMAS};
use std::path::Path;

/// Makes a folder from what `fill` writes. `fill` gets a temporary folder and the name that the project will have.
pub(super) fn make(
    folder: &Path,
    fill: impl FnOnce(&Path, &str) -> Result<(), StarterError>,
) -> Result<(), StarterError> {
    let io = |e: std::io::Error| StarterError::io(folder, &e);
    let whole = std::path::absolute(folder).map_err(io)?;
    let (Some(parent), Some(name)) = (whole.parent(), whole.file_name()) else {
        return Err(StarterError::NoName { folder: folder.into() });
    };
    let is_empty = |folder: &Path| std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if whole.symlink_metadata().is_ok() && !is_empty(&whole) {
        return Err(StarterError::NotEmpty { folder: folder.into() });
    }
    std::fs::create_dir_all(parent).map_err(io)?;
    let part = tempfile::Builder::new().prefix(".new-").suffix(".part").tempdir_in(parent).map_err(io)?;
    let new = part.path().join("project");
    std::fs::create_dir(&new).map_err(io)?;
    fill(&new, &name.to_string_lossy())?;
    // Only some systems let a folder replace an empty one
    std::fs::remove_dir(&whole).ok();
    std::fs::rename(&new, &whole).map_err(io)
}

/// Writes texts into a folder. For a TOML file of a kind with a schema, the schema is written next to it, and its first line refers editors to it.
pub(super) fn write(folder: &Path, files: [(&str, &str); 3]) -> Result<(), StarterError> {
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        storage::write(&path, text.as_bytes()).map_err(|e| StarterError::io(&path, &e))
    };
    files.iter().try_for_each(|(name, text)| {
        let kind = name.strip_suffix(".toml");
        let Some(Described { name: kind, schema }) = SCHEMAS.iter().find(|s| Some(s.name) == kind) else {
            return write(name, text);
        };
        write(&format!("{kind}.schema.json"), &format!("{:#}\n", schema().as_value()))?;
        write(name, &format!("#:schema ./{kind}.schema.json\n{text}"))
    })
}
