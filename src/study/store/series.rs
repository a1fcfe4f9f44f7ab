//! A stored case with its time series.

use crate::study::store::record::CaseRecord;
use std::collections::{BTreeMap, HashMap};

/// A case read from the folder of results: its record, its time series, and its places in the study.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredCase {
    pub record: CaseRecord,
    pub series: Series,
    /// Empty if the study does not list them
    places: Vec<Place>,
}

/// A family, variant and member to which a case belongs in a study. A scene that several of them request is run only once and has several places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub family: String,
    pub variant: String,
    pub member: String,
}

impl StoredCase {
    /// Builds a case whose only place is the one named in its record.
    pub fn new(record: CaseRecord, series: Series) -> Self {
        Self { record, series, places: vec![] }
    }

    /// Assigns to the case the places that the study gives it; its record names the first one.
    #[must_use]
    pub fn at(mut self, places: &[Place]) -> Self {
        if let Some(first) = places.first() {
            let r = &mut self.record;
            (r.family, r.variant, r.member) = (first.family.clone(), first.variant.clone(), first.member.clone());
            self.places = places.to_vec();
        }
        self
    }

    /// Family, variant and member of every place.
    fn names(&self) -> impl Iterator<Item = [&str; 3]> {
        let r = &self.record;
        let own = self.places.is_empty().then_some([r.family.as_str(), r.variant.as_str(), r.member.as_str()]);
        let names = self.places.iter().map(|p| [p.family.as_str(), p.variant.as_str(), p.member.as_str()]);
        names.chain(own)
    }

    /// The variants that run the case, without repetition.
    pub fn variants(&self) -> Vec<&str> {
        let mut all = vec![];
        for [_, variant, _] in self.names() {
            if !all.contains(&variant) {
                all.push(variant);
            }
        }
        all
    }

    /// Whether the variant runs the case, in any family.
    pub fn is_of(&self, variant: &str) -> bool {
        self.names().any(|[_, own, _]| own == variant)
    }

    /// Whether it is a case of the family in the variant.
    pub fn is_in(&self, family: &str, variant: &str) -> bool {
        self.names().any(|[in_family, own, _]| in_family == family && own == variant)
    }

    /// Whether it is a case of the family, in any variant.
    pub fn is_of_family(&self, family: &str) -> bool {
        self.names().any(|[own, ..]| own == family)
    }

    /// The members of the family that the case represents in the variant.
    pub fn members(&self, family: &str, variant: &str) -> impl Iterator<Item = &str> {
        self.names()
            .filter(move |[in_family, own, _]| *in_family == family && *own == variant)
            .map(|[.., member]| member)
    }
}

/// Time series of a case as stored in `cases/<id>.csv`: the columns over `t_s`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Series {
    /// \[samples\] Time \[s\]
    pub t_s: Vec<f64>,
    /// Column name, which includes the unit → \[samples\] values
    pub columns: BTreeMap<String, Vec<f64>>,
}

impl Series {
    /// Returns its rows at these times; values are NaN at times without a row.
    pub fn at(&self, times: &[f64]) -> Self {
        let rows: HashMap<u64, usize> = self.t_s.iter().enumerate().map(|(k, t)| (t.to_bits(), k)).collect();
        let places: Vec<Option<usize>> = times.iter().map(|t| rows.get(&t.to_bits()).copied()).collect();
        let of = |values: &Vec<f64>| places.iter().map(|k| k.map_or(f64::NAN, |k| values[k])).collect();
        let columns = self.columns.iter().map(|(name, values)| (name.clone(), of(values))).collect();
        Self { t_s: times.to_vec(), columns }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Derivatives of every step are assigned to the written rows, whichever these are.
    #[test]
    fn rows_are_told_by_their_times() {
        let slopes = Series {
            t_s: vec![0.0, 0.1, 0.2, 0.30000000000000004],
            columns: [("d f_N/d laws.rubber.mu".to_string(), vec![0.0, 1.0, 2.0, 3.0])].into(),
        };
        let at = |times: &[f64]| slopes.at(times).columns["d f_N/d laws.rubber.mu"].clone();
        assert_eq!(at(&[0.0, 0.2, 0.30000000000000004]), [0.0, 2.0, 3.0]);
        let [first, beyond] = at(&[0.1, 0.4])[..] else { panic!("two rows") };
        assert!(first == 1.0 && beyond.is_nan(), "{beyond}");
    }
}
