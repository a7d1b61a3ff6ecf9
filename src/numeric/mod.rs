//! Least squares, the choice of columns, and statistics: plain arithmetic that knows no machine tools.

pub mod fisher;
pub mod least_squares;
pub mod normal;
mod series;
pub mod stepwise;
pub mod student;
pub mod sums;

pub use least_squares::{RANK_LIMIT, Solution, System};
pub use normal::{Normal, Step};
pub use series::{Gain, Series};
