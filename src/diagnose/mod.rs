//! Diagnosis: what the model gets wrong, why, and what mending it gains.
//!
//! ```text
//! Scene::new(machine, errors, sets)      what is left of every reading, and what a deviation anywhere would do to it
//! cause::CAUSES                          candidates: what readings would have in addition, one file per cause
//! search                                 which of them explain what is left, and which stand
//! ```

pub mod cause;
mod empirical;
pub mod row;
pub mod scene;
mod score;
mod search;
mod seek;
mod sweep;
mod verdict;

pub use scene::Scene;
pub use verdict::{Diagnosis, Finding, diagnose};
