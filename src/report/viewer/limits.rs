//! Limits on the content of a page, so that it opens quickly and can be sent by e-mail.

/// Largest number of states of a case.
pub const STATES: usize = 240;
/// Largest number of values kept while states are collected: 160 MB.
pub const VALUES: usize = 40 << 20;
/// Largest number of rows of a curve; a screen has fewer points.
pub const ROWS: usize = 4000;
/// Largest size of the packed cases of a page in bytes; with base64 and the program of the page it is below 5 MB.
pub const BYTES: usize = 3_500_000;
