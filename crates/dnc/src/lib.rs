//! Connection to the control: links, live sensors, and drip feed (DNC), which sends a program line by line. Corrections come from other crates.

pub mod drip;
pub mod feed;
pub mod sense;
