//! Report of measured motion: a figure of each record, and the methods of a paper.

pub mod methods;
pub mod picture;
