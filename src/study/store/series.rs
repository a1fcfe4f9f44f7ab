//! A stored case with its time series.

use crate::study::store::record::CaseRecord;
use std::collections::BTreeMap;

/// A case that was read from the folder of results: its record, its time series, and its places in the study.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredCase {
    pub record: CaseRecord,
    pub series: Series,
    /// Empty where the study does not say them
    places: Vec<Place>,
}

/// A place that a case has in a study. A scene that several families, variants or members ask for is run once and has several places.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    pub family: String,
    pub variant: String,
    pub member: String,
}

impl StoredCase {
    /// A case whose only place is the one that its record names.
    pub fn new(record: CaseRecord, series: Series) -> Self {
        Self { record, series, places: vec![] }
    }

    /// The same case with the places that the study gives it; its record names the first one.
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

    /// The variants that run it, each once.
    pub fn variants(&self) -> Vec<&str> {
        let mut all = vec![];
        for [_, variant, _] in self.names() {
            if !all.contains(&variant) {
                all.push(variant);
            }
        }
        all
    }

    /// Whether the variant runs it, in whichever family.
    pub fn is_of(&self, variant: &str) -> bool {
        self.names().any(|[_, own, _]| own == variant)
    }

    /// Whether it is a case of the family in the variant.
    pub fn is_in(&self, family: &str, variant: &str) -> bool {
        self.names().any(|[in_family, own, _]| in_family == family && own == variant)
    }

    /// Whether it is a case of the family, in whichever variant.
    pub fn is_of_family(&self, family: &str) -> bool {
        self.names().any(|[own, ..]| own == family)
    }

    /// The members of the family that it is in the variant.
    pub fn members(&self, family: &str, variant: &str) -> impl Iterator<Item = &str> {
        self.names()
            .filter(move |[in_family, own, _]| *in_family == family && *own == variant)
            .map(|[.., member]| member)
    }
}

/// Time series of a case, as `cases/<id>.csv` holds it: the columns over `t_s`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Series {
    /// \[samples\] time \[s\]
    pub t_s: Vec<f64>,
    /// Column name → \[samples\], unit in the name
    pub columns: BTreeMap<String, Vec<f64>>,
}
