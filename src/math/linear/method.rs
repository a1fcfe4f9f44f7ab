//! Choice of the method for a matrix: by counts, never by the clock or by the machine.

use crate::math::multigrid::Places;
use std::sync::Arc;

/// Iterations of the Krylov method for one right side.
pub(super) const MOST_ITERATIONS: usize = 600;

/// Choice of the user.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Linear {
    /// By the counts of the factor
    #[default]
    Auto,
    Direct,
    Iterative,
}

/// How to choose, and what the iterative path needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    pub linear: Linear,
    /// The largest factor that is made \[GB\]
    pub factor_memory: f64,
    /// Or why the matrix is not one for the iterative path
    pub places: Result<Arc<Places>, &'static str>,
}

impl Default for Method {
    /// Direct, as long as 32 bits count its entries.
    fn default() -> Self {
        Self { linear: Linear::Direct, factor_memory: f64::INFINITY, places: Err("the nodes are not known") }
    }
}

/// Cost of a factorisation.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    /// Entries of L
    pub nnz: usize,
    /// Additions and multiplications
    pub flops: f64,
    /// Entries of one triangle of A
    pub matrix: usize,
}

/// Operations of a factorisation per entry of the matrix from which the iterative path is taken. It is faster from a tenth to a half of it on;
/// the direct one counts negative eigenvalues, which is worth the time as long as it is little.
const OPERATIONS: f64 = 5e4;

/// Memory of the values of L \[GB\].
pub(super) fn gigabytes(nnz: usize) -> f64 {
    8e-9 * nnz as f64
}

impl Method {
    /// The iterative path, whatever the factor is.
    pub(super) fn is_asked_for(&self) -> bool {
        self.linear == Linear::Iterative && self.places.is_ok()
    }

    /// The places for the iterative path if it is taken, and why it is or is not. No `cost` is known where the factor has more entries
    /// than can be counted, or where it does not matter.
    pub(super) fn choose(&self, cost: Option<Cost>) -> (Option<Arc<Places>>, String) {
        if self.is_asked_for() {
            return (self.places.clone().ok(), "asked for".into());
        }
        let places = match &self.places {
            Ok(places) => places,
            Err(why) => return (None, (*why).into()),
        };
        if self.linear == Linear::Direct {
            return (None, "asked for".into());
        }
        let Some(cost) = cost else {
            return (Some(places.clone()), "the factor would have more entries than 32 bits count".into());
        };
        let (size, work) = (gigabytes(cost.nnz), cost.flops / cost.matrix as f64);
        if size > self.factor_memory {
            let allowed = self.factor_memory;
            return (
                Some(places.clone()),
                format!("the factor would take {size:.3} GB, more than factor_memory = {allowed} GB"),
            );
        }
        if work > OPERATIONS {
            let why = format!(
                "a factorisation would take {work:.0} operations an entry of the tangent, more than {OPERATIONS}"
            );
            return (Some(places.clone()), why);
        }
        (
            None,
            format!(
                "a factor of {size:.3} GB, and {work:.0} operations an entry of the tangent, not more than {OPERATIONS}"
            ),
        )
    }
}
