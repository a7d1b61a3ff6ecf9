//! What every part of ncfix stands on: bytes with their places, findings as plain data, the edge of units, tables of text, frames, least squares. It knows no
//! machines.

pub mod csv;
pub mod diagnostic;
pub mod geometry;
pub mod numeric;
pub mod source;
pub mod units;
