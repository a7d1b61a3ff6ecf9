//! Calibration: from measured data to the parameters of the error model.
//!
//! [`identify()`] says what data or a plan can tell. [`fit()`] finds the parameters and the unknowns of all set-ups in one step of Gauss–Newton after
//! another on the full kinematics, with rows that do not fit weighted down, and refuses where the data cannot tell the parameters apart:
//! [`Fault::NotTold`] says in [`words`] which. Unknowns of set-ups that move nothing stay where they are. What comes out has uncertainties, and
//! [`quality()`] holds it against the data, also against data that it has not seen. [`select()`] finds which
//! of many parameters the data needs. [`sensors`] selects the sensors of temperature that tell a drift.

pub mod candidates;
mod column;
mod design;
mod drift;
pub mod effect;
mod fit;
mod identify;
mod noise;
mod quality;
mod robust;
mod select;
pub mod sensors;
mod told;
pub mod words;

pub use crate::numeric::stepwise::{Change, Choice, Gain, Rule, Term};
pub use column::Column;
pub use design::{Factored, Line, Origin, equations};
pub use drift::reversals;
pub use effect::{EffectParameter, Parameter};
pub use fit::{Estimate, Fault, Fit, Options, fit};
pub use identify::{Identified, identify};
pub use quality::{Compared, Quality, quality};
pub use select::{Refusal, Selected, select};
pub use told::{Told, improve, told};
