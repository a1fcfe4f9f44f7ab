//! Child processes that end with this one.

use std::process::Command;

/// The command ends when the thread that starts it ends, also where this process is killed. Linux only: elsewhere a killed process leaves
/// it behind.
pub fn ends_with_parent(command: &mut Command) {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::{prctl::set_pdeathsig, signal::Signal};
        use std::os::unix::process::CommandExt;
        // SAFETY: between fork and exec the closure makes one system call and allocates nothing.
        unsafe {
            command.pre_exec(|| set_pdeathsig(Signal::SIGKILL).map_err(Into::into));
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = command;
}

/// Ends a child process at once. It must not have been waited for, because its number may belong to another one then.
pub fn kill(pid: u32) {
    #[cfg(unix)]
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(pid as i32), nix::sys::signal::Signal::SIGKILL).ok();
    #[cfg(not(unix))]
    {
        let pid = sysinfo::Pid::from_u32(pid);
        let mut system = sysinfo::System::new();
        system.refresh_processes(sysinfo::ProcessesToUpdate::Some(&[pid]), false);
        system.process(pid).map(sysinfo::Process::kill);
    }
}
