//! Packs cases into batches, each of which is one task of a scheduler. This keeps the number of tasks and files small and makes resource requests
//! reliable.
//!
//! Cases with similar memory are packed together, the longest first, until a batch is expected to take the wanted time. Cases that wait for results of
//! others go into batches of a later phase. Packing is deterministic and takes O(n log n) for n cases.

use crate::study::listing::Listed;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Smallest size class of memory \[bytes\].
const SMALLEST: u64 = 256 << 20;

/// How cases are packed.
#[derive(Clone, Copy, Debug)]
pub struct Packing {
    /// Expected time of a batch \[s\]
    pub batch_s: f64,
    /// Largest number of batches
    pub most: usize,
    /// Assumed time of a case without an estimate \[s\]
    pub unknown_s: f64,
    /// Assumed memory of a case without an estimate \[bytes\]
    pub unknown_bytes: u64,
}

/// Cases that one task runs, one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Batch {
    pub cases: Vec<String>,
    /// Expected time \[s\]
    pub seconds: f64,
}

/// Batches with the same resource request.
#[derive(Clone, Debug, PartialEq)]
pub struct Group {
    /// 0, or 1 for cases that wait for results of others
    pub phase: usize,
    /// Expected memory of the largest case \[bytes\]
    pub bytes: u64,
    pub batches: Vec<Batch>,
}

impl Group {
    /// Expected time of the longest batch \[s\].
    pub fn longest_s(&self) -> f64 {
        self.batches.iter().map(|b| b.seconds).fold(0.0, f64::max)
    }
}

/// Packs cases into groups, sorted by phase and memory.
pub fn pack<'a>(cases: impl Iterator<Item = &'a Listed>, packing: Packing) -> Vec<Group> {
    let need = |c: &'a Listed| {
        let (seconds, bytes) = (c.expected.cost_s, c.expected.memory_bytes);
        let (seconds, bytes) = (seconds.unwrap_or(packing.unknown_s), bytes.unwrap_or(packing.unknown_bytes));
        let class = bytes.max(SMALLEST).next_power_of_two();
        (usize::from(c.waits_for.is_some()), class, seconds, bytes, c.id.as_str())
    };
    let mut needs: Vec<_> = cases.map(need).collect();
    needs.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(b.2.total_cmp(&a.2)).then(a.4.cmp(b.4)));
    let total: f64 = needs.iter().map(|n| n.2).sum();
    let mut batch_s = packing.batch_s.max(total / packing.most.max(1) as f64);
    loop {
        let groups = packed(&needs, batch_s);
        let count: usize = groups.iter().map(|g| g.batches.len()).sum();
        // Every group has at least one batch, whatever the limit
        if count <= packing.most.max(groups.len()) {
            return groups;
        }
        batch_s *= 1.1;
    }
}

fn packed(needs: &[(usize, u64, f64, u64, &str)], batch_s: f64) -> Vec<Group> {
    let mut groups: Vec<Group> = vec![];
    let mut class = None;
    for &(phase, of, seconds, bytes, id) in needs {
        if class.replace((phase, of)) != Some((phase, of)) {
            groups.push(Group { phase, bytes, batches: vec![] });
        }
        let group = groups.last_mut().expect("one was added");
        group.bytes = group.bytes.max(bytes);
        match group.batches.last_mut().filter(|b| b.seconds + seconds <= batch_s) {
            Some(batch) => {
                batch.cases.push(id.into());
                batch.seconds += seconds;
            }
            None => group.batches.push(Batch { cases: vec![id.into()], seconds }),
        }
    }
    groups
}

/// The text of a batch file: one batch per line, ids separated by spaces.
pub fn text(groups: &[Group]) -> String {
    groups.iter().flat_map(|g| &g.batches).map(|b| b.cases.join(" ") + "\n").collect()
}

/// An error in locating or reading a batch.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    #[error(
        "\"{0}\" names no batch; write FILE:K, the K-th line of a file from 1, with the ids of cases and spaces between them"
    )]
    Form(String),
    #[error("{}: it cannot be read: {reason}", file.display())]
    Unreadable { file: PathBuf, reason: String },
    #[error("{}: it has {lines} lines, and no batch {k}", file.display())]
    NoSuchBatch { file: PathBuf, k: usize, lines: usize },
    #[error("{}, line {k}: the study has no case {}; the file belongs to another study, or to another version of this one", file.display(), ids.join(", "))]
    NoSuchCase { file: PathBuf, k: usize, ids: Vec<String> },
}

/// Returns the ids of the batch `FILE:K`; all of them must be in `known`.
pub fn read(text: &str, known: &BTreeSet<&str>) -> Result<BTreeSet<String>, BatchError> {
    let parts = text.rsplit_once(':').and_then(|(file, k)| Some((file, k.parse::<usize>().ok()?)));
    let (file, k) = parts.filter(|(file, _)| !file.is_empty()).ok_or_else(|| BatchError::Form(text.into()))?;
    let file = Path::new(file);
    let read = crate::storage::read_text(file, crate::storage::DATA_LIMIT);
    let read = read.map_err(|e| BatchError::Unreadable { file: file.into(), reason: e.to_string() })?;
    let line = k.checked_sub(1).and_then(|k| read.lines().nth(k));
    let line = line.ok_or_else(|| BatchError::NoSuchBatch { file: file.into(), k, lines: read.lines().count() })?;
    let (ids, others): (Vec<&str>, Vec<&str>) = line.split_whitespace().partition(|id| known.contains(id));
    if !others.is_empty() {
        let ids = others.iter().map(ToString::to_string).collect();
        return Err(BatchError::NoSuchCase { file: file.into(), k, ids });
    }
    Ok(ids.into_iter().map(String::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::SplitMix;
    use crate::study::forecast::Expected;
    use crate::study::listing::State;
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;

    const PACKING: Packing = Packing { batch_s: 3600.0, most: 1000, unknown_s: 600.0, unknown_bytes: 2 << 30 };

    fn case(k: usize, cost_s: Option<f64>, memory_bytes: Option<u64>) -> Listed {
        Listed {
            id: format!("c{k:06}"),
            family: String::new(),
            variant: String::new(),
            member: String::new(),
            state: State::Missing,
            identity: None,
            waits_for: (k % 1000 == 999).then(String::new),
            nodes: None,
            expected: Expected { cost_s, memory_bytes },
        }
    }

    /// Returns cases with times spread log-uniformly over three decades and memory over two, as in a study over mesh sizes.
    fn cases(n: usize) -> Vec<Listed> {
        let mut random = SplitMix(5);
        let mut spread = |low: f64, decades: f64| low * 10f64.powf(decades * random.unit());
        (0..n)
            .map(|k| match k % 10 {
                0 => case(k, None, None),
                _ => case(k, Some(spread(1.0, 3.0)), Some(spread(1e8, 2.0) as u64)),
            })
            .collect()
    }

    #[test]
    fn every_case_is_in_one_batch_that_asks_for_enough() {
        let cases = cases(3000);
        let groups = pack(cases.iter(), PACKING);
        let mut seen: Vec<&String> = groups.iter().flat_map(|g| &g.batches).flat_map(|b| &b.cases).collect();
        seen.sort();
        assert_eq!(seen, cases.iter().map(|c| &c.id).collect::<Vec<_>>());
        for group in &groups {
            for batch in &group.batches {
                let own: Vec<&Listed> =
                    batch.cases.iter().map(|id| &cases[id[1..].parse::<usize>().unwrap()]).collect();
                let seconds: f64 = own.iter().map(|c| c.expected.cost_s.unwrap_or(600.0)).sum();
                assert!((seconds - batch.seconds).abs() < 1e-9 * seconds && (own.len() == 1 || seconds <= 3600.0));
                assert!(own.iter().all(|c| c.expected.memory_bytes.unwrap_or(2 << 30) <= group.bytes));
                assert!(own.iter().all(|c| usize::from(c.waits_for.is_some()) == group.phase));
            }
        }
        let few = pack(cases.iter(), Packing { most: 20, ..PACKING });
        assert!(few.iter().map(|g| g.batches.len()).sum::<usize>() <= 20, "{few:?}");
    }

    #[test]
    fn a_batch_is_read_back() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("batches.txt");
        let cases: Vec<Listed> = (0..3).map(|k| case(k, Some(2000.0), None)).collect();
        std::fs::write(&file, text(&pack(cases.iter(), PACKING))).expect("room");
        let known = BTreeSet::from(["c000000", "c000001", "c000002"]);
        let of = |k: usize| read(&format!("{}:{k}", file.display()), &known);
        assert_eq!(of(2).expect("a line"), BTreeSet::from(["c000001".to_string()]));
        assert!(matches!(of(0), Err(BatchError::NoSuchBatch { lines: 3, .. })));
        assert!(matches!(of(4), Err(BatchError::NoSuchBatch { lines: 3, .. })));
        assert!(matches!(read("batches.txt", &known), Err(BatchError::Form(_))));
        assert!(matches!(read("none:1", &known), Err(BatchError::Unreadable { .. })));
        let other = read(&format!("{}:1", file.display()), &BTreeSet::new());
        assert!(other.expect_err("another study").to_string().contains("no case c000000"));
    }

    /// Runs 100 000 cases in batches on 1000 workers. On average a task is lost once in ten hours of work; it restarts without the cases that it had
    /// finished. Every case is finished exactly once, no batch exceeds its request of twice its expected time, and the whole takes little longer than
    /// the work divided by the workers.
    #[test]
    fn many_cases_on_many_workers_that_fail() {
        let cases = cases(100_000);
        let begin = std::time::Instant::now();
        let groups = pack(cases.iter(), Packing { most: 20_000, ..PACKING });
        let packed_s = begin.elapsed().as_secs_f64();
        let mut random = SplitMix(7);
        // The actual time of a case differs from the expected one by up to half
        let takes: Vec<f64> =
            (cases.iter()).map(|c| c.expected.cost_s.unwrap_or(600.0) * (0.5 + random.unit())).collect();
        let index = |id: &str| id[1..].parse::<usize>().expect("a number");
        let mut done = vec![0usize; cases.len()];
        let (mut end, mut lost, mut work) = (0.0f64, 0, 0.0);
        for phase in 0..2 {
            let mut free: BinaryHeap<Reverse<(u64, usize)>> =
                (0..1000).map(|w| Reverse(((end * 1e3) as u64, w))).collect();
            for batch in groups.iter().filter(|g| g.phase == phase).flat_map(|g| &g.batches) {
                let mut left = &batch.cases[..];
                while let Some(id) = left.first() {
                    let Reverse((at, worker)) = free.pop().expect("a worker");
                    let (mut t, mut id) = (at as f64 / 1e3, Some(id));
                    let fails = -36_000.0 * (1.0 - random.unit()).ln();
                    let started = t;
                    while let Some(case) = id {
                        if t + takes[index(case)] - started > fails {
                            (t, lost) = (started + fails, lost + 1);
                            break;
                        }
                        t += takes[index(case)];
                        done[index(case)] += 1;
                        left = &left[1..];
                        id = left.first();
                    }
                    assert!(t - started <= 2.0 * batch.seconds.max(1.0));
                    work += t - started;
                    end = end.max(t);
                    free.push(Reverse(((t * 1e3) as u64, worker)));
                }
            }
        }
        let tasks: usize = groups.iter().map(|g| g.batches.len()).sum();
        let ideal = work / 1000.0;
        println!(
            "{tasks} tasks in {} groups, packed in {packed_s:.3} s, {} bytes of batches",
            groups.len(),
            text(&groups).len()
        );
        println!("{lost} tasks lost; {end:.0} s on 1000 workers, {ideal:.0} s of work each");
        assert!(done.iter().all(|n| *n == 1) && lost > 100);
        assert!(end < 1.5 * ideal && tasks < 20_000);
    }
}
