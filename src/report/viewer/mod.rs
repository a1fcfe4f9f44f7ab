//! The 3-D viewer: one page that shows the motion of cases, with everything that it needs in it.
//!
//! ```text
//! run ──► film ──► modes ──► pack ──► page          a run: states are gathered and become principal modes
//! scene, mesh ──► shape ──► pack ──► page           at rest
//! ```
//!
//! The program of the page is in the folder `viewer` of the repository; its built form is in `bundle`.

mod coarsen;
pub mod film;
pub mod model;
pub mod modes;
pub mod of_scene;
pub mod pack;
pub mod page;
pub mod shape;
