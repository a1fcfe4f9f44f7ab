//! Memory of cases that run side by side: what they are going to need, and what is available.

use crate::math::threads::locked;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// Share of the available memory that all cases together may take \[–\]; the rest is for reading meshes, for reports and for other programs.
pub const SHARE: f64 = 0.9;

/// Memory that a process of this user may still take \[bytes\]: the minimum of what the system has available, what its control groups leave, and the
/// limit of the address space. `None` if the system reports none of them.
pub fn available() -> Option<u64> {
    of_system().into_iter().chain(of_control_groups()).chain(of_address_space()).min()
}

#[cfg(target_os = "linux")]
fn of_system() -> Option<u64> {
    let info = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(1024 * line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?)
}

#[cfg(not(target_os = "linux"))]
fn of_system() -> Option<u64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    Some(system.available_memory()).filter(|bytes| *bytes > 0)
}

/// Memory that the control groups of this process leave, versions 1 and 2, up to the outermost group.
fn of_control_groups() -> Option<u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let root = Path::new("/sys/fs/cgroup");
    let of_line = |line: &str| {
        let (controllers, path) = line.split_once(':')?.1.split_once(':')?;
        let (top, names) = match controllers {
            "" => (root.to_path_buf(), ["memory.max", "memory.current"]),
            "memory" => (root.join("memory"), ["memory.limit_in_bytes", "memory.usage_in_bytes"]),
            _ => return None,
        };
        let group = top.join(path.trim_start_matches('/'));
        let groups = group.ancestors().take_while(|folder| folder.starts_with(&top)).map(Path::to_path_buf);
        let number =
            |folder: &PathBuf, name: &str| std::fs::read_to_string(folder.join(name)).ok()?.trim().parse::<u64>().ok();
        groups.filter_map(|folder| Some(number(&folder, names[0])?.saturating_sub(number(&folder, names[1])?))).min()
    };
    groups.lines().filter_map(of_line).min()
}

#[cfg(unix)]
fn of_address_space() -> Option<u64> {
    use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
    getrlimit(Resource::RLIMIT_AS).ok().map(|(soft, _)| soft).filter(|soft| *soft != RLIM_INFINITY)
}

#[cfg(not(unix))]
fn of_address_space() -> Option<u64> {
    None
}

/// Whether a case may continue with its factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Admission {
    Now,
    /// Other cases have to end first
    Later,
    /// It needs more than all cases together may take
    Never,
}

/// Memory promised to running cases.
pub struct Allowance {
    /// Memory that all cases together may take \[bytes\]
    pub limit: u64,
    promised: Mutex<u64>,
}

impl Allowance {
    pub fn new(limit: u64) -> Self {
        Self { limit, promised: Mutex::new(0) }
    }

    /// Promises memory to a case if it is available; [`Allowance::release`] returns it.
    pub fn admit(&self, bytes: u64) -> Admission {
        let mut promised = locked(&self.promised);
        if bytes > self.limit {
            return Admission::Never;
        }
        if *promised + bytes > self.limit {
            return Admission::Later;
        }
        *promised += bytes;
        Admission::Now
    }

    pub fn release(&self, bytes: u64) {
        *locked(&self.promised) -= bytes;
    }
}
