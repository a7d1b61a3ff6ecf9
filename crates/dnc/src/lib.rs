//! The way to the control: links, live sensors, and the drip feed. It does not know how corrections are computed.

pub mod drip;
pub mod feed;
pub mod sense;
