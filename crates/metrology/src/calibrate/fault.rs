//! Reasons for which a fit has no result.

use super::words::Lost;

/// Reason why there is no result.
#[derive(Clone, Debug, PartialEq)]
pub enum FitError {
    /// Fewer equations than unknowns.
    TooFew {
        /// Number of equations.
        equations: usize,
        /// Number of unknowns.
        unknowns: usize,
        /// The unidentifiable part.
        lost: Box<Lost>,
    },
    /// The data do not separate the parameters.
    NotIdentified(Box<Lost>),
    /// It did not converge; with the measurement that is the most likely reason.
    NotSettled(Option<Unsettled>),
}

/// A measurement whose residuals exceed its description.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsettled {
    /// Its index.
    pub set: usize,
    /// Ratio of the residual spread to the described uncertainty.
    pub times: f64,
    /// Number of rejected readings, and of all readings.
    pub rejected: [usize; 2],
}
