//! Figures of a cost study.

pub mod growth;
pub mod work;
