//! What a column must explain to be worth taking.

use ncfix_base::numeric::Gain;

/// By the information criterion of Schwarz for the number of those that were tried as well: what a chance pick would gain is no gain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Price {
    /// Readings.
    count: f64,
    /// For each column.
    each: f64,
    /// For a choice among those that were tried.
    choice: f64,
}

impl Price {
    /// For so many readings and candidates.
    pub(super) fn new(count: f64, tried: usize) -> Price {
        let choice = 2.0 * (tried as f64).ln();
        Price { count, each: count.ln() + choice, choice }
    }

    /// Of so many columns.
    pub(super) fn of(self, rank: usize) -> f64 {
        self.each * rank as f64
    }

    /// Worth of a shape without any choice among its columns: it is chosen once.
    pub(super) fn worth_whole(self, squares: f64, gain: &Gain) -> f64 {
        self.worth(squares, gain) + self.choice * gain.rank.saturating_sub(1) as f64
    }

    /// −2 ln of the likelihood that is gained of so many squares, less the price.
    pub(super) fn worth(self, squares: f64, gain: &Gain) -> f64 {
        let rest = (squares - gain.squares).max(squares * 1e-12);
        self.count * (squares / rest).ln() - self.of(gain.rank)
    }
}
