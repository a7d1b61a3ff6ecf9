//! Why a fit has no result.

use super::words::Lost;

/// Why there is no result.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// Less equations than unknowns.
    TooFew {
        /// Equations.
        equations: usize,
        /// Unknowns.
        unknowns: usize,
        /// What they cannot tell.
        lost: Box<Lost>,
    },
    /// The data cannot tell the parameters apart.
    NotTold(Box<Lost>),
    /// It did not settle; with the measurement that most likely is the reason.
    NotSettled(Option<Unsettled>),
}

/// A measurement of which more is left than it says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsettled {
    /// Its number.
    pub set: usize,
    /// Spread of the residuals by the described uncertainty.
    pub times: f64,
    /// Readings that count for nothing, and all readings.
    pub rejected: [usize; 2],
}
