//! Caches and counters of one run, owned by the caller of an evaluation.

use std::any::Any;
use std::sync::Arc;

/// Identity of an object that keeps an entry in [`Caches`].
#[derive(Clone, Debug, Default)]
pub struct CacheKey(Arc<()>);

/// Caches and counters of one run. They affect how much is computed, never the result: two runs of one system, each with its own caches, give the
/// same results and the same counts.
#[derive(Debug, Default)]
pub struct Caches {
    entries: Vec<(CacheKey, Box<dyn Any + Send>)>,
}

impl Caches {
    /// The entry of `key`, which is created on first use.
    pub fn entry<T: Any + Send + Default>(&mut self, key: &CacheKey) -> &mut T {
        let known = self.entries.iter().position(|(k, entry)| Arc::ptr_eq(&k.0, &key.0) && entry.is::<T>());
        let place = known.unwrap_or_else(|| {
            self.entries.push((key.clone(), Box::new(T::default())));
            self.entries.len() - 1
        });
        self.entries[place].1.downcast_mut().expect("the entry was found by its type")
    }

    /// The entry of `key`, if it has one.
    pub fn get<T: Any>(&self, key: &CacheKey) -> Option<&T> {
        self.entries.iter().filter(|(k, _)| Arc::ptr_eq(&k.0, &key.0)).find_map(|(_, entry)| entry.downcast_ref())
    }
}
