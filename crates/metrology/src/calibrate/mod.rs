//! Calibration: from measured data to the parameters of the error model.
//!
//! [`identify()`] determines the identifiability for data or a plan. [`fit()`] determines the parameters and the unknowns of all set-ups by
//! Gauss–Newton iterations on the full kinematics, with robust weights. It refuses data that do not separate the parameters: [`FitError::NotIdentified`] names
//! them in [`words`], and [`reduce()`] leaves them out. Set-up unknowns without effect are held. Results have uncertainties, which [`monte_carlo()`]
//! checks, and [`quality()`] compares a model with data, including held-out data. [`select()`] selects the parameters that the data need. [`sensors`]
//! selects temperature sensors for a drift. [`contradictions()`] names parameters for which files differ.

pub mod automatic;
#[cfg(test)]
pub(crate) mod bench;
mod by_file;
pub mod candidates;
mod cause;
mod certified;
mod column;
mod contradiction;
mod design;
mod drift;
pub mod effect;
mod equivalent;
mod exact;
mod fault;
mod fit;
mod identify;
mod improve;
pub mod mean_line;
mod monte_carlo;
mod noise;
mod null_space;
mod quality;
mod reduce;
mod robust;
mod row_store;
mod select;
pub mod sensors;
mod sorted;
mod unit;
pub mod words;

pub use certified::add_certificates;
pub use column::Column;
pub use contradiction::{Contradiction, FileValue, contradictions};
pub(crate) use design::WEAK;
pub use design::{EquationOrigin, Factored, ReadingEquation, equations};
pub use drift::reversals;
pub use effect::{EffectParameter, Parameter};
pub use equivalent::{equivalents, tip_effects};
pub use fault::{FitError, Unsettled};
pub use fit::{Estimate, Fit, FitOptions, fit};
pub use identify::{Identified, identify};
pub use improve::improve;
pub use mean_line::MeanLine;
pub use monte_carlo::{MonteCarlo, monte_carlo};
pub use ncfix_base::numeric::stepwise::{Change, Choice, Gain, Rule, Term};
pub use quality::{ComparedReading, Quality, quality};
pub use reduce::{Reduced, reduce};
pub use select::{Refusal, Selected, select};
pub use sorted::sorted_axes;
pub use words::{Confused, Lost};
