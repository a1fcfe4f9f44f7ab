//! Settings of the allocator of the process.

/// Lets the C library keep freed memory. By default it returns the blocks of a factorisation to the system, which clears their pages
/// when the next factorisation allocates them; this takes up to a third of the time of a case.
pub fn keep_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        const MIB: libc::c_int = 1 << 20;
        // Blocks smaller than the second value come from memory that is kept. Larger blocks belong to large systems, for which clearing takes a small
        // part of the time but kept blocks would be a large part of the memory. Versions before 2.35 refuse more than 32 MiB.
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

/// Lets the threads of this process share one arena. With arenas of their own, each thread keeps the memory that it frees, and a case whose
/// factors are freed by one thread and rebuilt by another can take up to 1.7 times the memory, depending on chance.
pub fn share_one_arena() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the call has no preconditions; it holds for arenas that do not exist yet.
    unsafe {
        libc::mallopt(libc::M_ARENA_MAX, 1);
    }
}
