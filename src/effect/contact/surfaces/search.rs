//! Search for the terms in a state; the last candidates are stored in the caches of the run.

use super::candidates::{Candidates, candidates};
use super::pair::Surfaces;
use super::terms::{Term, near, nodes_within};
use crate::effect::contact::Counts;
use crate::math::boxes::Span;
use crate::math::tensor::Vec3;
use crate::system::Caches;
use std::sync::Arc;
use std::time::Instant;

/// Distance below which pairs belong to the sparsity pattern of the tangent, relative to the reach \[–\].
const PATTERN_REACH: f64 = 3.0;

/// Search of two surfaces during a run: the last candidates and terms, and the counts.
#[derive(Default)]
pub(super) struct SurfaceSearch {
    /// \[nodes\] displacements at which the candidates were found \[m\]
    pub(super) at: Vec<Vec3>,
    pub(super) candidates: Arc<Candidates>,
    /// Displacements of the last evaluation, and its terms
    last: (Vec<Vec3>, Arc<Vec<Term>>),
    pub(super) counts: Counts,
}

impl Surfaces {
    /// Counts of the run to which these caches belong.
    pub fn counts(&self, caches: &Caches) -> Counts {
        caches.get::<SurfaceSearch>(&self.key).map_or(Counts::default(), |search| search.counts)
    }

    /// Returns the terms nearer than the reach at displacement x, point by point, then edge by edge.
    pub fn terms(&self, x: &[f64], caches: &mut Caches) -> Arc<Vec<Term>> {
        let start = Instant::now();
        let here = self.displacements(x);
        let search: &mut SurfaceSearch = caches.entry(&self.key);
        if search.last.0 != here {
            self.refresh(search, x, &here);
            let mut tested = 0;
            let terms = near(self, x, &search.candidates, self.reach, &mut tested);
            search.counts.points += self.point_count();
            search.counts.tested += tested;
            search.counts.active += terms.len();
            search.counts.search += start.elapsed();
            search.last = (here, Arc::new(terms));
        }
        search.last.1.clone()
    }

    /// Returns the nodes of the pairs that the sparsity pattern of the tangent includes.
    pub fn coupled_nodes(&self, x: &[f64], caches: &mut Caches) -> Vec<Vec<u32>> {
        let here = self.displacements(x);
        let search: &mut SurfaceSearch = caches.entry(&self.key);
        self.refresh(search, x, &here);
        nodes_within(self, x, &search.candidates, PATTERN_REACH * self.reach)
    }

    /// Updates the candidates such that they contain all pairs within the pattern reach as long as no node moves farther than the margin from x.
    pub(super) fn refresh(&self, search: &mut SurfaceSearch, x: &[f64], here: &[Vec3]) {
        if search.at.is_empty() || farthest(&search.at, here) > self.margin {
            search.candidates = Arc::new(self.around(x, PATTERN_REACH * self.reach + 2.0 * self.margin));
            search.at = here.to_vec();
        }
    }

    fn around(&self, x: &[f64], radius: f64) -> Candidates {
        let spot = |at: Vec3| -> Span { (at, at) };
        candidates(&self.passes(), radius, &|p| spot(self.place(x, p)), &|k| spot(self.node(x, k)))
    }
}

/// Largest norm of the differences.
pub(super) fn farthest(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}
