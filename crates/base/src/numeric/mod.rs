//! Least squares, selection of columns, and statistics: plain arithmetic, independent of machine tools.

mod bordered;
pub mod fisher;
pub mod least_squares;
mod leave_out;
pub mod noise;
pub mod normal;
mod parallel;
mod peak;
mod series;
pub mod stepwise;
pub mod student;
pub mod sums;
mod upright;

pub use bordered::BorderedSystem;
pub use least_squares::{RANK_LIMIT, Solution, System};
pub use leave_out::{Beside, LeaveOut};
pub use normal::{Normal, NormalStep};
pub use parallel::{both, in_parts, repeated};
pub use peak::peak;
pub use series::{BasisColumn, Gain, Series};
pub use upright::Upright;
