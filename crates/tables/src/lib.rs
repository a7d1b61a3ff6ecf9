//! Compensation tables of controls, and corrections in the cycle of a control.

pub mod realtime;
pub mod results;
pub mod tables;
