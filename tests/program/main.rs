//! The program as its users meet it, in a checkout, installed, on an empty machine, and as a library.

#[path = "../common/mod.rs"]
mod common;

mod cli;
mod empty_machine;
mod installed;
mod outside;
mod processors;
mod tutorial;
