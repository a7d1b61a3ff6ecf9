//! Diagnosis: finds the errors that the model lacks, their causes, and how much correcting them improves the prediction.
//!
//! ```text
//! Scene::new(machine, errors, sets)      residual of every reading, and its sensitivity to a deviation anywhere in the machine
//! path                                  readings along a path: the angle between the mean lines of two motions
//! fault::FAULTS                         faults of the data
//! cause::Causes                          candidates: the deviations that a cause adds to the readings, one file per cause
//! search, refine, group, cancel, absurd  search for the candidates that explain the residual
//! sample, promising                      shortlist of candidates if there are many readings
//! judge, freedom                         backward elimination with the autocorrelation of the residual
//! slow                                   test against slowly varying noise
//! gates, fold                            acceptance tests on unseen data
//! verdict                                sizes, other explanations, shares, noise, residual; before and after, also on data held out
//! contest                                comparison with other sets of terms by their probability
//! certified                              the contribution of certificates to the uncertainty of sizes
//! next                                   the measurement that separates the explanations
//! stated                                 test of the hypotheses that a person states
//! mimic, doubt, volume                    errors with the same effect on the readings but another effect elsewhere in the travel
//! twins                                  terms with the same effect on all readings, which share their probability
//! class                                  candidates that explain the readings nearly as well
//! nature, undecided                      causes with the same effect on the readings that depend on another quantity: time, direction, speed
//! reversed                               readings of a file with the opposite sign, which would make causes unnecessary
//! swapped                                set-ups of which either may have the wrong scale
//! lever                                  displacements that act on the readings as an accepted angle does
//! level                                  curves of a straightness whose slope no reading determines
//! elsewhere                              angles that explain the readings of a displacement, because they have one arm
//! extend                                 the extended machine file
//! ```

mod absurd;
mod account;
#[cfg(test)]
pub(crate) mod bench;
mod cancel;
pub mod cause;
mod certified;
mod circles;
mod class;
mod contest;
mod doubt;
mod elsewhere;
mod empirical;
mod entrant;
mod event;
pub mod explain;
pub mod extend;
mod far;
pub mod fault;
mod fold;
mod freedom;
mod gates;
mod group;
mod harm;
mod held;
mod held_out;
mod jackknife;
mod judge;
mod known;
mod level;
mod lever;
mod mimic;
mod nature;
mod next;
mod noise;
mod parts;
mod path;
mod price;
mod promising;
mod readings;
mod refine;
mod rejected;
mod reversed;
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
mod swapped;
mod sweep;
mod twins;
mod undecided;
mod verdict;
mod volume;

pub use account::Account;
pub use cause::{CauseId, Causes};
pub use contest::ExplanationSummary;
pub use doubt::ExtrapolationRisk;
pub use elsewhere::ArmRisk;
pub use far::FAR as FAR_OUT;
pub use held::{Compared, Sizes};
pub use next::NextMeasurement;
pub use noise::{Left, NoiseSource};
pub use parts::FileShare;
pub use readings::{freedom_of, levels, residuals};
pub use rejected::{Gate, Rejected, TriedCause};
pub use reversed::{SignContradiction, SignedError};
pub use scene::Scene;
pub use separate::commands;
pub use share::VarianceShare;
pub(crate) use size::EXPANDED;
pub(crate) use size::is_angle;
pub use size::{Amounts, Size};
pub use undecided::RivalCause;
pub use verdict::{AcceptedCause, DiagnosedCauses, diagnose, diagnose_with, reads_angles};
