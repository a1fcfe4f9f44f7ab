//! Mathematics without physics: small tensors, quantities with units, signals, sparse matrices, linear solvers.

pub mod cpu_clock;
pub mod difference;
pub mod disjoint_sets;
pub mod dual;
pub mod formula;
pub mod gmres;
pub mod lanes;
pub mod linear;
pub mod low_rank;
pub mod multigrid;
pub mod nonnegative;
pub mod ordering;
mod parts;
pub mod pcg;
pub mod random;
pub mod ranked_set;
pub mod rotation;
pub mod signal;
mod signal_rate;
pub mod sparse;
pub mod statistics;
pub mod svd;
pub mod tensor;
pub mod threads;
pub mod units;
pub mod vector;
