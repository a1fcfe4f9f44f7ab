//! Arguments that several commands share.

use durometer::scene::{MemorySpec, overrides};

/// `--set key=value`, several times. A step into a list is its index from 0, or the `name` or `kind` of an entry.
pub fn changes(set: &[String]) -> Result<Vec<(String, toml::Value)>, overrides::OverrideError> {
    set.iter().map(|text| overrides::parse(text)).collect()
}

/// A number of cases that run at a time.
pub fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "at least one case runs at a time; give 1 or more".into())
}

/// A size of memory with its unit \[bytes\].
pub fn memory(text: &str) -> Result<u64, String> {
    let text: toml::Value = text.into();
    text.try_into::<MemorySpec>().map(|gigabytes| (1e9 * gigabytes.0) as u64).map_err(|e| e.message().to_string())
}
