//! Calibration: from measured data to the parameters of the error model.
//!
//! [`identify()`] says what data or a plan can tell. [`fit()`] finds the parameters and the unknowns of all set-ups in one step of Gauss–Newton after
//! another on the full kinematics, with rows that do not fit weighted down, and refuses where the data cannot tell the parameters apart:
//! [`Fault::NotTold`] says in [`words`] which, and [`reduce()`] leaves them out. Unknowns of set-ups that move nothing stay where they are. What comes
//! out has uncertainties, which [`monte_carlo()`] checks, and [`quality()`] holds it against the data, also against data that it has not seen.
//! [`select()`] finds which of many parameters the data needs. [`sensors`] selects the sensors of temperature that tell a drift.

#[cfg(test)]
pub(crate) mod bench;
pub mod candidates;
mod cause;
mod column;
mod design;
mod drift;
pub mod effect;
mod exact;
mod fault;
mod fit;
mod identify;
mod improve;
mod monte_carlo;
mod noise;
mod null_space;
mod quality;
mod reduce;
mod robust;
mod select;
pub mod sensors;
mod unit;
pub mod words;

pub use column::Column;
pub(crate) use design::WEAK;
pub use design::{EquationOrigin, Factored, ReadingEquation, equations};
pub use drift::reversals;
pub use effect::{EffectParameter, Parameter};
pub use fault::{Fault, Unsettled};
pub use fit::{Estimate, Fit, Options, fit};
pub use identify::{Identified, identify};
pub use improve::improve;
pub use monte_carlo::{MonteCarlo, monte_carlo};
pub use ncfix_base::numeric::stepwise::{Change, Choice, Gain, Rule, Term};
pub use quality::{Compared, Quality, quality};
pub use reduce::{Reduced, reduce};
pub use select::{Refusal, Selected, select};
pub use words::{Confused, Lost};
