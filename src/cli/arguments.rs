//! Arguments that several commands share.

use durometer::calibrate::Role;
use durometer::math::threads;
use durometer::scene::{MemorySpec, overrides};
use std::collections::BTreeMap;

/// Parses the values of `--set key=value`. An entry of a list is addressed by its index from 0, or by its `name` or `kind`.
pub fn changes(set: &[String]) -> Result<Vec<(String, toml::Value)>, overrides::OverrideError> {
    set.iter().map(|text| overrides::parse(text)).collect()
}

/// Parses a number of cases that run at the same time.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "at least one case runs at a time; give 1 or more".into())
}

/// Parses a number of threads, or of cases that run at the same time; it is limited by the number of cores.
pub fn threads(text: &str) -> Result<usize, String> {
    let wanted = text.parse().ok().filter(|n| *n > 0).ok_or("give a whole number of 1 or more")?;
    let cores = threads::available();
    let most = most_threads(cores);
    if wanted > most {
        return Err(format!(
            "more than {most} only wait for each other on {cores} cores; give {cores}, or leave it out"
        ));
    }
    Ok(wanted)
}

/// Largest number of threads that is accepted on `cores` cores. At least 64 are always accepted, so that thread counts can be compared on a small
/// machine.
fn most_threads(cores: usize) -> usize {
    (4 * cores).max(64)
}

/// Parses an amount of memory with its unit \[bytes\].
pub fn memory(text: &str) -> Result<u64, String> {
    let text: toml::Value = text.into();
    text.try_into::<MemorySpec>().map(|gigabytes| (1e9 * gigabytes.0) as u64).map_err(|e| e.message().to_string())
}

/// Maps the content of each entry such as `time=t` to its text; a content that is given twice is refused.
pub fn contents(texts: &[String]) -> Result<BTreeMap<Role, String>, String> {
    let mut found = BTreeMap::new();
    for text in texts {
        let (role, name) =
            text.split_once('=').ok_or_else(|| format!("\"{text}\": write CONTENT=NAME such as time=t"))?;
        if found.insert(role.trim().parse()?, name.to_string()).is_some() {
            return Err(format!("\"{text}\": {} is given twice; keep one of the two", role.trim()));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_limited_by_the_cores() {
        assert_eq!(["1", "8", "64"].map(|n| threads(n).ok()), [Some(1), Some(8), Some(64)]);
        assert_eq!((most_threads(2), most_threads(128)), (64, 512));
        let most = most_threads(threads::available());
        let refused = threads(&(most + 1).to_string()).expect_err("too many");
        assert!(refused.contains("leave it out"), "{refused}");
        assert!(threads("0").is_err() && threads("100000").is_err());
    }
}
