//! Figures of a validation.

pub mod budget;
pub mod score;
