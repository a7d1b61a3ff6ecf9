//! Penalty of a column: the gain that it must exceed.

use ncfix_base::numeric::Gain;

/// Penalties of the Bayesian information criterion (Schwarz), with a penalty for the choice among all tested candidates: the best of many gains something by
/// chance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Price {
    /// Number of readings.
    count: f64,
    /// Penalty of a column.
    each: f64,
    /// Penalty of a choice among all tested candidates.
    choice: f64,
}

impl Price {
    /// Penalties for numbers of readings and candidates.
    pub(super) fn new(count: f64, tried: usize) -> Price {
        let choice = 2.0 * (tried as f64).ln();
        Price { count, each: count.ln() + choice, choice }
    }

    /// Returns the penalty of a number of columns.
    pub(super) fn of(self, rank: usize) -> f64 {
        self.each * rank as f64
    }

    /// Returns the net gain of a shape whose columns are not chosen separately: the choice counts once.
    pub(super) fn worth_whole(self, squares: f64, gain: &Gain) -> f64 {
        self.worth(squares, gain) + self.choice * gain.rank.saturating_sub(1) as f64
    }

    /// Returns the decrease of −2 ln of the likelihood due to a gain, minus the penalty. `squares` is the sum of squares without it.
    pub(super) fn worth(self, squares: f64, gain: &Gain) -> f64 {
        let rest = (squares - gain.squares).max(squares * 1e-12);
        self.count * (squares / rest).ln() - self.of(gain.rank)
    }
}
