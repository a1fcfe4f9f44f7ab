//! Differences between the cases of a study that are overridden by changes of all cases: their results then compare nothing, whatever the names of the
//! cases say.

use crate::scene::value_in;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use toml::Value;

/// The values that the study itself gives to the keys of changes, case by case.
#[derive(Default)]
pub struct Differences {
    /// Scene file and key → value in the first of its cases
    first: HashMap<(PathBuf, String), Option<Value>>,
    overridden: Vec<String>,
}

impl Differences {
    /// Adds a case with its `own` changes; `given` are the changes that override the study in every case.
    pub fn add(&mut self, scene: &Path, own: &[(String, Value)], given: &[(String, Value)]) {
        for (key, _) in given.iter().filter(|(key, _)| !key.ends_with(".+")) {
            let value = value_in(scene, own, key);
            let first = self.first.entry((scene.into(), key.clone())).or_insert_with(|| value.clone());
            if *first != value && !self.overridden.contains(key) {
                self.overridden.push(key.clone());
            }
        }
    }

    /// Keys in which cases of one scene would differ without the overriding changes.
    pub fn overridden(self) -> Vec<String> {
        self.overridden
    }
}
