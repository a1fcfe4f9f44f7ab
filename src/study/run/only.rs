//! The cases of a study that one run takes: those with a text in their name, one of several parts, or a list.

use crate::storage::sha256;
use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

/// A selection of the cases of a study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Only {
    /// Cases whose id contains this text
    Containing(String),
    Partition(Partition),
    /// Cases with these ids
    Listed(BTreeSet<String>),
}

impl Only {
    /// Whether the case with this id is taken.
    pub fn takes(&self, id: &str) -> bool {
        match self {
            Self::Containing(text) => id.contains(text.as_str()),
            Self::Partition(partition) => partition.holds(id),
            Self::Listed(ids) => ids.contains(id),
        }
    }

    /// Whether other runs take the other cases: this run then leaves their results alone, and may have nothing to do.
    pub fn is_part(&self) -> bool {
        !matches!(self, Self::Containing(_))
    }
}

impl fmt::Display for Only {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Containing(text) => write!(f, "cases with \"{text}\""),
            Self::Partition(partition) => write!(f, "part {partition}"),
            Self::Listed(ids) => write!(f, "list of {} cases", ids.len()),
        }
    }
}

impl From<&str> for Only {
    fn from(text: &str) -> Self {
        Self::Containing(text.into())
    }
}

/// The k-th of n parts of a study, `k/n`.
///
/// A case belongs to the part determined by the hash of its id, independently of the other cases: it stays in its part when cases are added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Partition {
    /// Index of the part, from 1 to `n`
    pub k: u64,
    pub n: u64,
}

/// A text that is not a valid part.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PartitionError {
    #[error("\"{0}\" names no part; write k/n with two whole numbers, for example 1/4")]
    Form(String),
    #[error("there is no part {k} of {n}; the parts of {n} are 1/{n} to {n}/{n}")]
    NoSuchPart { k: u64, n: u64 },
    #[error("nothing can be divided into 0 parts; write k/n with n of 1 or more, for example 1/4")]
    NoParts,
}

impl FromStr for Partition {
    type Err = PartitionError;

    fn from_str(text: &str) -> Result<Self, PartitionError> {
        let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        let (k, n) = numbers.ok_or_else(|| PartitionError::Form(text.into()))?;
        match (k, n) {
            (_, 0) => Err(PartitionError::NoParts),
            (k, n) if (1..=n).contains(&k) => Ok(Self { k, n }),
            (k, n) => Err(PartitionError::NoSuchPart { k, n }),
        }
    }
}

impl fmt::Display for Partition {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.k, self.n)
    }
}

impl Partition {
    /// Whether the case with this id belongs to this part: the first 64 bits of the SHA-256 of the id, modulo n.
    pub fn holds(self, id: &str) -> bool {
        let hash = u64::from_str_radix(&sha256(id)[..16], 16).expect("hexadecimal digits");
        hash % self.n == self.k - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each case is in exactly one part, and the parts have about the same size: with 4000 cases of probability 1/n the standard deviation of the size
    /// of a part is at most √(4000/n); five standard deviations are allowed.
    #[test]
    fn every_case_is_in_exactly_one_part() {
        let ids: Vec<String> = (0..4000).map(|k| format!("grid-press-{k}")).collect();
        for n in [1, 2, 3, 7, 64] {
            let parts: Vec<Partition> = (1..=n).map(|k| Partition { k, n }).collect();
            assert!(ids.iter().all(|id| parts.iter().filter(|p| p.holds(id)).count() == 1));
            for part in parts {
                let (own, mean) = (ids.iter().filter(|id| part.holds(id)).count() as f64, 4000.0 / n as f64);
                assert!((own - mean).abs() <= 5.0 * mean.sqrt(), "{part}: {own}");
            }
        }
    }

    /// The part of an id is fixed here: a change would make every half-finished study run its cases again elsewhere.
    #[test]
    fn the_part_of_a_case_is_for_ever() {
        let part = |id: &str| (1..=8).find(|&k| Partition { k, n: 8 }.holds(id)).expect("in one of the parts");
        assert_eq!(["a", "sizes-length-2000", "grid-press-17"].map(part), [3, 4, 2]);
    }

    #[test]
    fn a_part_that_does_not_exist_is_refused() {
        assert_eq!("4/4".parse(), Ok(Partition { k: 4, n: 4 }));
        assert_eq!("5/4".parse::<Partition>(), Err(PartitionError::NoSuchPart { k: 5, n: 4 }));
        assert_eq!("0/4".parse::<Partition>(), Err(PartitionError::NoSuchPart { k: 0, n: 4 }));
        assert_eq!("0/0".parse::<Partition>(), Err(PartitionError::NoParts));
        for text in ["", "1", "1/", "a/b", "-1/4", "1/4/2", "1.5/4", "99999999999999999999/4"] {
            assert_eq!(text.parse::<Partition>(), Err(PartitionError::Form(text.into())));
        }
    }
}
