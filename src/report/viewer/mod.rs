//! The 3-D viewer: a self-contained page that shows the motion of cases.
//!
//! ```text
//! run ──► film ──► footage ──► pack ──► page        a run: its states are collected and become principal modes
//! run ──► film ──► frame ──► live                 during the run: state by state
//! file ──► of_grid ──► footage ──► pack ──► page    VTU, PVD, meshes
//! ```
//!
//! The program of the page is in the folder `viewer` of the repository; its built form is in `bundle`.

mod coarsen;
pub mod film;
pub mod footage;
pub mod frame;
pub mod limits;
pub mod model;
pub mod modes;
pub mod of_grid;
pub mod of_scene;
pub mod pack;
pub mod page;
pub mod shape;
pub mod unpack;
