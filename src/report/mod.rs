//! Toolkit for reports: canvas, plots, surfaces, tables, pages, their export and the 3-D viewer; also the reports of fits.
//!
//! This module knows nothing about studies; the kinds of study draw their reports with it.

pub mod axis;
pub mod body;
pub mod canvas;
pub mod color_bar;
pub mod error;
pub mod export;
pub mod figure;
pub mod files;
pub mod fit;
pub mod latex;
pub mod measure;
pub mod motion;
pub mod names;
pub mod numbers;
pub mod page;
pub mod panels;
pub mod paper;
pub mod plot;
pub mod service_fit;
pub mod style;
pub mod surface;
pub mod table;
mod table_files;
pub mod unit;
pub mod viewer;

pub use error::ReportError;
