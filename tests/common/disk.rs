//! A disk that is full, loses its power or has no links, and a stop at any call: a layer between the program and the system (`layer.c`) that counts
//! what is written.

use std::collections::HashMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The layer, and the folder that lies on its disk.
pub struct Disk {
    keep: tempfile::TempDir,
    folder: PathBuf,
}

/// How the disk fails in one call of the program.
#[derive(Clone, Copy, Debug)]
pub enum Fault {
    None,
    /// The power is cut at this call
    Cut(i64),
    /// There is room for so many bytes
    Space(i64),
    /// The user stops the program at this call
    Stop(i64),
    /// The file system has no hard links
    NoLinks,
}

/// Counts of one call of the program.
#[derive(Clone, Copy, Debug)]
pub struct Counts {
    pub calls: i64,
    pub bytes: i64,
}

impl Disk {
    /// Compiles the layer. `folder` is the one that lies on the disk.
    pub fn new(folder: &Path) -> Self {
        let keep = tempfile::tempdir().expect("a temporary folder");
        let folder = folder.canonicalize().expect("it is there");
        let disk = Self { keep, folder };
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/common/layer.c");
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"]).arg(disk.place("layer.so")).arg(source);
        let output = compiler.arg("-ldl").output().expect("the linker of Rust is a compiler of C");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        disk
    }

    fn place(&self, name: &str) -> PathBuf {
        self.keep.path().join(name)
    }

    /// Calls the program on the disk.
    pub fn call(&self, mut command: Command, fault: Fault) -> (Output, Counts) {
        let (mut cut_at, mut space, mut stop_at, mut no_link) = (0, i64::MAX, 0, 0);
        match fault {
            Fault::None => {}
            Fault::Cut(at) => cut_at = at,
            Fault::Space(bytes) => space = bytes,
            Fault::Stop(at) => stop_at = at,
            Fault::NoLinks => no_link = 1,
        }
        // As `struct state` of the layer
        let fields = [0, 0, 0, cut_at, 0, space, stop_at, no_link];
        std::fs::write(self.place("state"), fields.map(i64::to_ne_bytes).concat()).expect("room");
        std::fs::write(self.place("log"), "").expect("room");
        command.env("LD_PRELOAD", self.place("layer.so")).env("LAYER_ROOT", &self.folder);
        command.env("LAYER_STATE", self.place("state")).env("LAYER_LOG", self.place("log"));
        let output = command.output().expect("the program starts");
        let state = std::fs::read(self.place("state")).expect("there");
        let field = |k: usize| i64::from_ne_bytes(state[8 * k..8 * k + 8].try_into().expect("eight bytes"));
        (output, Counts { calls: field(2), bytes: field(4) })
    }

    /// Takes from the disk what the last call has not made safe: the content of files and, where `names`, also files that have got
    /// their names since their folder was made safe.
    pub fn lose(&self, names: bool) {
        let log = std::fs::read_to_string(self.place("log")).expect("there");
        // Device and inode → whether its content is safe, and since when its entries are
        let mut known: HashMap<(u64, u64), (bool, i128)> = HashMap::new();
        for line in log.lines() {
            let mut words = line.split(' ');
            let kind = words.next();
            let mut number = || words.next().expect("five words").parse::<u64>().expect("a number");
            let (device, inode, seconds, nanoseconds) = (number(), number(), number(), number());
            let entry = known.entry((device, inode)).or_insert((true, 0));
            match kind {
                Some("W") => entry.0 = false,
                _ => *entry = (true, i128::from(seconds) * 1_000_000_000 + i128::from(nanoseconds)),
            }
        }
        self.lose_in(&self.folder, &known, names);
    }

    fn lose_in(&self, folder: &Path, known: &HashMap<(u64, u64), (bool, i128)>, names: bool) {
        let of = |path: &Path| {
            let m = std::fs::symlink_metadata(path).expect("there");
            let changed = i128::from(m.ctime()) * 1_000_000_000 + i128::from(m.ctime_nsec());
            (known.get(&(m.dev(), m.ino())), changed)
        };
        let (Some((_, safe_since)), _) = of(folder) else { return self.lose_below(folder, known, names) };
        for entry in std::fs::read_dir(folder).expect("a folder").flatten().filter(|e| e.path().is_file()) {
            if let (Some((is_safe, _)), changed) = of(&entry.path()) {
                if names && changed > *safe_since {
                    std::fs::remove_file(entry.path()).expect("own file");
                } else if !is_safe {
                    std::fs::write(entry.path(), "").expect("own file");
                }
            }
        }
        self.lose_below(folder, known, names);
    }

    fn lose_below(&self, folder: &Path, known: &HashMap<(u64, u64), (bool, i128)>, names: bool) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten().filter(|e| e.path().is_dir()) {
            self.lose_in(&entry.path(), known, names);
        }
    }
}
