//! Draws plain data of the other rooms for people and for programs: findings, numbers of a correction, machines.
//!
//! Everything here returns text or serializable values; nothing opens a file or asks what a terminal can do.

mod excerpt;
pub mod correction;
pub mod json;
pub mod number;
pub mod terminal;
