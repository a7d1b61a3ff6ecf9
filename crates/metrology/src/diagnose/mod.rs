//! Diagnosis: what the model gets wrong, why, and what mending it gains.
//!
//! ```text
//! Scene::new(machine, errors, sets)      what is left of every reading, and what a deviation anywhere would do to it
//! fault::FAULTS                         what is wrong with the data themselves
//! cause::Causes                          candidates: what readings would have in addition, one file per cause
//! search, refine, group, cancel          which of them explain what is left
//! sample, promising                      which of these are worth a look where there are many readings
//! judge, freedom                         which of these stand beside each other and the memory of the noise
//! slow                                   which of these stand beside noise that wanders
//! gates, fold                            which of these also help where they were not found
//! verdict                                sizes, rivals, shares, noise, what is left; before and after, also on data held out
//! contest                                whether another set of terms is surely more probable
//! stated                                 hypotheses that a person states, each tested against the readings
//! mimic, doubt, volume                    which of them other errors explain as well that would do something else where was not measured
//! extend                                 what goes into the machine file
//! ```

mod account;
#[cfg(test)]
pub(crate) mod bench;
mod cancel;
pub mod cause;
mod circles;
mod contest;
mod doubt;
mod empirical;
mod event;
pub mod explain;
pub mod extend;
pub mod fault;
mod fold;
mod freedom;
mod gates;
mod group;
mod held;
mod held_out;
mod jackknife;
mod judge;
mod known;
mod mimic;
mod noise;
mod parts;
mod price;
mod promising;
mod readings;
mod refine;
mod rejected;
pub mod row;
mod sample;
pub mod scene;
mod score;
mod search;
mod seek;
mod sensors;
mod separate;
pub mod shape;
mod share;
mod size;
mod slow;
pub mod stated;
mod sweep;
mod verdict;
mod volume;

pub use account::Account;
pub use cause::Causes;
pub use contest::ExplanationSummary;
pub use doubt::ExtrapolationRisk;
pub use held::{Compared, Sizes};
pub use noise::{Left, NoiseSource};
pub use parts::FileShare;
pub use readings::{FAR as FAR_OUT, freedom_of, levels, residuals};
pub use rejected::{Gate, Rejected, TriedCause};
pub use scene::Scene;
pub use separate::commands;
pub use share::VarianceShare;
pub(crate) use size::EXPANDED;
pub(crate) use size::is_angle;
pub use size::{Amounts, Size};
pub use verdict::{AcceptedCause, DiagnosedCauses, diagnose, diagnose_with, reads_angles};
