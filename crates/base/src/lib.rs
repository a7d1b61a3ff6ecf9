//! Foundation of ncfix: bytes with their places, diagnostics as plain data, unit conversion, text tables, frames, least squares, and registries that a caller
//! can extend. Only the texts of the diagnostic codes and the axis letters of `geometry` belong to machine tools.

pub mod csv;
pub mod diagnostic;
pub mod geometry;
pub mod number;
pub mod numeric;
pub mod pattern;
pub mod register;
pub mod source;
pub mod units;
