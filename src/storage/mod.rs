//! Files: read up to a size limit, written whole or not at all, and identified by their contents; the time for records.

pub mod columns;
pub mod reading;
pub mod results;
pub mod table;
pub mod writing;

use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use tempfile::NamedTempFile;

/// Largest accepted text written by hand, such as scenes, studies, laws and cards \[bytes\].
pub const TEXT_LIMIT: u64 = 64 << 20;
/// Largest accepted data file, such as meshes, surfaces and tables \[bytes\].
pub const DATA_LIMIT: u64 = 4 << 30;
/// Size to which any gzipped file may unpack \[bytes\], in addition to a multiple of its own size.
const UNPACKED_FREE: u64 = 16 << 20;
/// Largest accepted compression ratio. Files of numbers compress to about a third of their size, regular grids written as text to about a tenth.
const UNPACKED_RATIO: u64 = 24;

/// Reads a regular file of at most `limit` bytes. A pipe or a device, which may have no end, is refused.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let bytes = limited(open(path)?, limit)?;
    reading::note(path, || sha256(&bytes));
    Ok(bytes)
}

/// Opens a regular file for reading. Its kind is checked first, because opening a pipe without a writer would block.
pub fn open(path: &Path) -> Result<File> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(Error::new(ErrorKind::InvalidInput, "it is not a regular file"));
    }
    File::open(path)
}

/// Whether an error means that the file does not exist, or that its folder is itself a file.
pub fn is_absent(e: &Error) -> bool {
    matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory)
}

/// Reads a regular file of at most `limit` bytes as UTF-8 text.
pub fn read_text(path: &Path, limit: u64) -> Result<String> {
    String::from_utf8(read(path, limit)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is not text in UTF-8; save it in this encoding"))
}

/// Reads a stream, such as an archive while it is unpacked, to its end; refuses more than `limit` bytes.
pub fn limited(stream: impl Read, limit: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(Error::new(ErrorKind::InvalidData, format!("it has more than {} MiB", limit >> 20)));
    }
    Ok(bytes)
}

/// Unpacks a gzipped file. A file that unpacks to far more than a file of numbers would is refused, because it may be meant to fill the memory.
pub fn unpacked(packed: &[u8]) -> Result<Vec<u8>> {
    let limit = (UNPACKED_FREE + UNPACKED_RATIO * packed.len() as u64).min(DATA_LIMIT);
    let mut bytes = Vec::new();
    flate2::read::MultiGzDecoder::new(packed).take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let fact = format!("it unpacks to more than {} MiB, {UNPACKED_RATIO} times its size", limit >> 20);
        return Err(Error::new(ErrorKind::InvalidData, format!("{fact}; give it unpacked")));
    }
    Ok(bytes)
}

/// Whether a file begins like a gzipped file.
pub fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Writes a file whole or not at all: into a new file in the same folder, which reaches the disk before it is given the name. Concurrent writers do
/// not interfere, and a symbolic link of the same name is replaced, not followed.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes a file whole or not at all, with the content that `fill` produces.
pub fn write_with(path: &Path, fill: impl FnOnce(&mut File) -> Result<()>) -> Result<()> {
    keep_part(part_with(path, fill)?, path)
}

/// Writes several files in order, each whole: none is given its name before all have reached the disk and `ready` has been called.
///
/// # Errors
///
/// The file that cannot be written. If the error occurs before `ready` is called, nothing has changed.
pub fn write_together<B: AsRef<[u8]>>(
    files: &[(PathBuf, B)],
    ready: impl FnOnce(),
) -> std::result::Result<(), (PathBuf, Error)> {
    let part = |(path, bytes): &(PathBuf, B)| {
        part_with(path, |file| file.write_all(bytes.as_ref())).map_err(|e| (path.clone(), e))
    };
    let parts = files.iter().map(part).collect::<std::result::Result<Vec<_>, _>>()?;
    ready();
    files.iter().zip(parts).try_for_each(|((path, _), part)| keep_part(part, path).map_err(|e| (path.clone(), e)))
}

/// A new file next to `path` with the content that `fill` produces, which has reached the disk.
fn part_with(path: &Path, fill: impl FnOnce(&mut File) -> Result<()>) -> Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // The permissions follow the user's umask
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.tempfile_in(folder_of(path))?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    Ok(file)
}

fn keep_part(part: NamedTempFile, path: &Path) -> Result<()> {
    part.persist(path).map_err(|e| e.error)?;
    make_names_safe(folder_of(path));
    writing::note(path);
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Flushes a folder to the disk, so that new names in it are safe. Where a folder cannot be opened, the system keeps names safe by itself.
fn make_names_safe(folder: &Path) {
    File::open(folder).and_then(|folder| folder.sync_all()).ok();
}

/// Renames a file that another program has written, within one file system, after its content has reached the disk.
pub fn keep(part: &Path, path: &Path) -> Result<()> {
    File::open(part)?.sync_all()?;
    std::fs::rename(part, path)?;
    make_names_safe(folder_of(path));
    Ok(())
}

/// Creates a folder with its parents, and writes and removes a file in it, so that a run finds out at its start that it cannot write there.
pub fn writable_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder)?;
    let mut trial = tempfile::Builder::new().prefix(".").suffix(".part").tempfile_in(folder)?;
    trial.write_all(b"trial")?;
    trial.as_file().sync_all()
}

/// SHA-256 in hexadecimal digits.
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// SHA-256 in hexadecimal digits of the bytes that `fill` writes, piece by piece.
pub fn sha256_of(fill: impl FnOnce(&mut dyn Write) -> Result<()>) -> Result<String> {
    let mut sum = Sha256::new();
    fill(&mut sum)?;
    Ok(hexadecimal(&sum.finalize()))
}

/// Bytes as hexadecimal digits, two for each byte.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Time since the beginning of 1970; zero if the clock is set earlier.
pub fn unix_time() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_written_whole_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.csv");
        write(&path, b"first").expect("room");
        write(&path, b"second").expect("room");
        assert_eq!(read(&path, 6).expect("six bytes"), b"second");
        assert!(read(&path, 5).expect_err("too long").to_string().contains("more than"));
        assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 1);
        assert!(write(&folder.path().join("none/a.csv"), b"x").is_err());
    }

    #[test]
    fn files_that_are_written_together_replace_others_in_order_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [a, b, none] = ["a.csv", "b.json", "none/c"].map(|name| folder.path().join(name));
        std::fs::write(&a, "earlier").expect("room");
        let refused = write_together(&[(a.clone(), "new"), (none.clone(), "new")], || panic!("one is not there"));
        assert_eq!(refused.expect_err("no folder").0, none);
        let earlier = || assert_eq!(read(&a, 7).expect("there"), b"earlier", "all are ready first");
        write_together(&[(a.clone(), "new"), (b.clone(), "record")], earlier).expect("room");
        assert_eq!((read(&a, 3).expect("there"), read(&b, 6).expect("there")), (b"new".to_vec(), b"record".to_vec()));
        assert_eq!(std::fs::read_dir(folder.path()).expect("readable").count(), 2);
    }

    #[test]
    fn a_gzip_bomb_is_refused() {
        let pack = |bytes: &[u8]| {
            let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
            packed.write_all(bytes).and_then(|()| packed.finish()).expect("memory accepts every write")
        };
        let text = "1 0.25 0.5\n".repeat(1000);
        assert_eq!(unpacked(&pack(text.as_bytes())).expect("small"), text.as_bytes());
        let bomb = pack(&vec![0; 64 << 20]);
        assert!(bomb.len() < 1 << 17);
        assert!(unpacked(&bomb).expect_err("a bomb").to_string().contains("give it unpacked"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_replaced_and_not_followed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (other, link) = (folder.path().join("other"), folder.path().join("link"));
        std::fs::write(&other, "kept").expect("room");
        std::os::unix::fs::symlink(&other, &link).expect("a link");
        write(&link, b"new").expect("room");
        assert_eq!(std::fs::read_to_string(&other).expect("there"), "kept");
        assert_eq!(std::fs::read_to_string(&link).expect("there"), "new");
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_refused() {
        assert!(read(Path::new("/dev/zero"), 10).expect_err("endless").to_string().contains("not a regular file"));
    }
}
