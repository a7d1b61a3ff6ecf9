//! What every part of ncfix stands on: bytes with their places, findings as plain data, the edge of units, tables of text, frames, least squares, registers that a
//! caller extends. It knows no machines.

pub mod csv;
pub mod diagnostic;
pub mod geometry;
pub mod number;
pub mod numeric;
pub mod register;
pub mod source;
pub mod units;
