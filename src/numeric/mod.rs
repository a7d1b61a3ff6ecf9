//! Least squares and statistics: plain arithmetic that knows no machine tools.

pub mod least_squares;

pub use least_squares::{Solution, System};
