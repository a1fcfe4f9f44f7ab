//! Runs the cases of a study.
//!
//! | Step | File |
//! |---|---|
//! | Which cases run | [`only`], [`waiting`] |
//! | Results of another study that a run would replace | [`other_study`] |
//! | Mistakes of scenes, before the first case runs | `mistakes` |
//! | The whole run: the cases, and those that follow from their results | [`growing`] |
//! | Cases side by side, and reuse of stored results | [`runner`] |
//! | Memory and threads of cases that run side by side | [`memory`], [`cores`] |
//! | One case: its task, its computation, its process | [`task`], [`compute`], [`worker`] |
//! | The search for its constants, and derivatives with respect to constants | `search`, `derivatives` |
//! | Adaptive meshes, errors from one run, derivatives with respect to constants | [`refinement`], [`one_run`], [`uncertain_constants`] |
//! | The amount of work of a case | [`work`] |

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
