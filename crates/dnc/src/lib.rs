//! Connection to the control: links, live sensors, DNC (line-by-line feeding). This crate does not compute corrections.

pub mod drip;
pub mod feed;
pub mod sense;
