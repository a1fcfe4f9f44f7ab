//! Mathematics without physics: small tensors, quantities with units, sparse matrices, linear solvers.

pub mod tensor;
pub mod units;
