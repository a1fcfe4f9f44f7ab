//! Effects and constraints, each against sums by hand, closed forms and differences, and what a scene pays for them.

#[path = "../common/mod.rs"]
mod common;

mod cable;
mod cable_friction;
mod cable_places;
mod cavity;
mod cavity_skin;
mod every_kind;
mod fibre_family;
mod fibres;
mod jumps;
mod loads;
mod membrane;
mod open_cavity;
mod pay_for_use;
mod probes;
mod rayleigh;
mod regions;
mod rigid_insert;
mod rotation;
mod several_bodies;
mod springs;
mod start_of_motion;
