//! Runs the cases of a study.
//!
//! | Step | File |
//! |---|---|
//! | Which cases run | [`only`], [`waiting`] |
//! | Results of another study, which a run would replace | [`other_study`] |
//! | Mistakes of scenes, before the first case runs | `mistakes` |
//! | The whole run: the cases, and those that follow from their results | [`growing`] |
//! | Side by side, and which stored result is reused | [`runner`] |
//! | Memory and threads of cases that run side by side | [`memory`], [`cores`] |
//! | One case: what is asked, its computation, its process | [`task`], [`compute`], [`worker`] |
//! | The search for its constants, and derivatives by constants | `search`, `derivatives` |
//! | Adaptive meshes, errors from one run and derivatives by constants, kept with a result | [`refinement`], [`one_run`], [`uncertain_constants`] |
//! | How much work a case was | [`work`] |

pub mod compute;
pub mod cores;
mod derivatives;
pub mod error;
pub mod growing;
mod live_case;
pub mod memory;
mod mistakes;
pub mod one_run;
pub mod only;
pub mod other_study;
pub mod refinement;
pub mod runner;
mod search;
pub mod task;
pub mod uncertain_constants;
pub mod waiting;
pub mod work;
pub mod worker;
