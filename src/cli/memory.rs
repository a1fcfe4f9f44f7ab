//! Settings of the allocator of the process.

/// Lets the C library keep memory that is freed. By default it returns the blocks of a factorisation to the system, which clears their pages
/// when the next factorisation takes them: up to a third of the time of a case.
pub fn keep_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const MIB: libc::c_int = 1 << 20;
        // Blocks below the second one come from memory that is kept. Larger ones belong to large systems, where clearing is a small part of the time
        // and what is kept a large part of the memory. Versions before 2.35 refuse more than 32 MiB.
        let settings = [
            (libc::M_TRIM_THRESHOLD, 128 * MIB),
            (libc::M_MMAP_THRESHOLD, 32 * MIB),
            (libc::M_MMAP_THRESHOLD, 64 * MIB),
        ];
        for (setting, value) in settings {
            // SAFETY: the call has no preconditions; a value that it refuses changes nothing.
            unsafe { libc::mallopt(setting, value) };
        }
    }
}

/// Lets the threads of this process share one arena. With an arena of its own each thread keeps what it frees for itself, and a case whose
/// factors are freed by one thread and made again by another one takes up to 1.7 times the memory, by chance.
pub fn share_one_arena() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the call has no preconditions; it holds for arenas that do not exist yet.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 1);
    }
}
