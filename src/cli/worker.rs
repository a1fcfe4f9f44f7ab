//! `durometer worker`

use super::memory;
use super::outcome::{CommandResult, Outcome};
use durometer::math::threads;
use durometer::study::run::worker::{Said, obey};
use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// Least time between two messages about the progress of a case.
const OFTEN: Duration = Duration::from_millis(50);

/// Compute one case of a study (internal: `run` starts it)
///
/// The case is read from standard input; progress and outcome are reported on standard output. The process ends with the process that
/// started it.
#[derive(clap::Args)]
pub struct Args {}

pub fn main(_: Args) -> CommandResult {
    static SHARED: AtomicBool = AtomicBool::new(false);
    // If memory runs out, the system ends this process before the one that started it
    std::fs::write("/proc/self/oom_score_adj", "500").ok();
    // Keeps the memory of a case at the expected amount
    memory::share_one_arena();
    threads::use_threads(1);
    let mut order = String::new();
    std::io::stdin().read_line(&mut order)?;
    let (sender, admitted) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lines().map_while(Result::ok) {
            match (line.as_str(), line.strip_prefix("threads ").and_then(|count| count.parse().ok())) {
                ("shared", _) => SHARED.store(true, Ordering::Relaxed),
                (_, Some(count)) => threads::use_threads(count),
                // The admission of the case, which it waits for once
                _ => sender.send(()).unwrap_or_default(),
            }
        }
        end_all();
    });
    let mut shown = None::<Instant>;
    obey(&order, &SHARED, &mut || admitted.recv().is_ok(), &mut |said: &Said| {
        if matches!(said, Said::Progress { .. }) {
            if shown.is_some_and(|shown| shown.elapsed() < OFTEN) {
                return;
            }
            shown = Some(Instant::now());
        }
        let line = serde_json::to_string(said).expect("numbers and strings only");
        // Errors are ignored: if nobody listens any more, the input ends as well
        writeln!(std::io::stdout(), "{line}").ok();
    });
    Ok(Outcome::Complete)
}

/// Ends this process, and if it leads its process group, all processes of the group.
fn end_all() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{Signal, killpg};
        let (own, group) = (nix::unistd::getpid(), nix::unistd::getpgrp());
        if own == group {
            killpg(group, Signal::SIGKILL).ok();
        }
    }
    std::process::exit(1);
}
