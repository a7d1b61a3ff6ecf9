//! Measurements on the machine: positions and readings in data tables.
//!
//! [`reading`] finds axis positions, tool vectors and directions of motion in the columns of a table ([`ncfix_base::csv`]). [`data`] reads a
//! measurement with its description. [`kind`] has one file per kind of measurement, with its columns and equations. [`simulate`] does the inverse,
//! with [`noise`]; [`plan`] makes measurements without readings, with the path of the axes to them. [`mode`] removes the corrections from measured
//! positions (measurement mode), [`iso230`] has the figures of the acceptance tests. [`strain`] reads a strain gauge, [`weighing`] determines the
//! load from it, [`copies`] detects tables with identical readings, `display` finds the steps of a display, [`certificate`] has the effects of the uncertainty of lengths and scales on the readings, [`ranges`] states which positions and conditions they cover. [`trace`] has the recordings of a control and an instrument during motion.

pub mod certificate;
pub mod circles;
pub mod copies;
pub mod data;
pub(crate) mod display;
pub mod iso230;
pub mod kind;
pub mod mode;
pub mod nest;
pub mod plan;
pub mod ranges;
pub mod reading;
pub mod simulate;
pub mod squareness;
pub mod strain;
pub mod trace;
pub mod weighing;

pub use ncfix_base::numeric::noise;
