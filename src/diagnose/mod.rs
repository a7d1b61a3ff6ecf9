//! Diagnosis: what the model gets wrong, why, and what mending it gains.
//!
//! ```text
//! Scene::new(machine, errors, sets)      what is left of every reading, and what a deviation anywhere would do to it
//! fault::FAULTS                         what is wrong with the data themselves
//! cause::CAUSES                          candidates: what readings would have in addition, one file per cause
//! search                                 which of them explain what is left, and which stand
//! ```

pub mod cause;
pub mod fault;
pub mod row;
pub mod scene;
mod search;
mod sweep;
mod verdict;

pub use scene::Scene;
pub use verdict::{Diagnosis, Finding, diagnose};
