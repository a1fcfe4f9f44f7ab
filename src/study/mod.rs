//! Studies: cases, their stored results, and the analysis over them.

pub mod record;
