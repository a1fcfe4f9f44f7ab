//! Choice of the method for a matrix: by operation counts, never by the clock or the machine.

use crate::math::multigrid::Places;
use std::sync::Arc;

/// Largest number of iterations of the Krylov method for one right-hand side.
pub(super) const MOST_ITERATIONS: usize = 600;

/// The user's choice of the method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Linear {
    /// By the operation counts of the factor
    #[default]
    Auto,
    Direct,
    Iterative,
}

/// Criteria for the choice of the method, and the data that the iterative path needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Method {
    pub linear: Linear,
    /// Largest factor that is computed \[GB\]
    pub factor_memory: f64,
    /// The displacements of the nodes, or the reason why the matrix is not suited for the iterative path
    pub places: Result<Arc<Places>, &'static str>,
}

impl Default for Method {
    /// The direct method, as long as 32 bits can count the entries of the factor.
    fn default() -> Self {
        Self { linear: Linear::Direct, factor_memory: f64::INFINITY, places: Err("the nodes are not known") }
    }
}

/// Cost of a factorisation.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    /// Number of entries of L
    pub nnz: usize,
    /// Number of additions and multiplications
    pub flops: f64,
    /// Number of entries of one triangle of A
    pub matrix: usize,
}

/// Number of operations of a factorisation per entry of the matrix above which the iterative path is used. The iterative path is already faster from
/// between a tenth and a half of this number; but the direct one counts negative eigenvalues, which is worth the time while it is short.
const OPERATIONS: f64 = 5e4;

/// Memory of the values of L \[GB\].
pub(super) fn gigabytes(nnz: usize) -> f64 {
    8e-9 * nnz as f64
}

impl Method {
    /// Whether the user asks for the iterative path, whatever the size of the factor.
    pub(super) fn is_asked_for(&self) -> bool {
        self.linear == Linear::Iterative && self.places.is_ok()
    }

    /// Returns the places of the unknowns if the iterative path is used, and the reason for the choice. `cost` is `None` if the factor has more
    /// entries than can be counted, or if the cost does not matter.
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
