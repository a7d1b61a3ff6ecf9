//! Gains of candidates on all readings, computed only for those that a sample of the readings shows to be promising. The others stay outdated until they are
//! needed.

use std::sync::Arc;

use super::cause::Candidate;
use super::score::{Layout, OwnProducts, Scores, gain};
use super::search::Field;
use ncfix_base::numeric::{Gain, Series};

/// Maximum number of candidates that are evaluated on all readings.
const MOST: usize = 100;
/// Margin for the candidates, in standard deviations of the gain that the sample predicts.
const SURELY: f64 = 2.0;
/// Number of directions that are processed at once.
const AT_ONCE: usize = 8;
/// Gain of a candidate that is not evaluated.
const NOTHING: Gain = Gain { squares: 0.0, rank: 0 };

/// Returns the candidates that may explain most of all readings, from their gains on a sample, in units of the noise. All readings are `times` as many as the
/// sample; a column costs `price`.
pub(super) fn promising(gains: &[Gain], times: f64, price: f64) -> Vec<bool> {
    // A fit of noise in the sample gains little in the other readings, and the gain scatters: mean and standard deviation of a noncentral χ².
    let worth = |gain: &Gain| {
        let rank = gain.rank as f64;
        let own = (gain.squares - rank).max(0.0);
        let spread = times * (4.0 * own + 2.0 * rank).sqrt();
        (times * own + rank - price * rank, SURELY * spread)
    };
    let known = || gains.iter().enumerate().filter(|(_, gain)| gain.rank > 0).map(|(k, gain)| (worth(gain), k));
    let least = known().map(|((worth, spread), _)| worth - spread).fold(0.0, f64::max);
    let mut all: Vec<(f64, usize)> =
        known().filter(|((worth, spread), _)| worth + spread > least).map(|((worth, _), k)| (worth, k)).collect();
    if all.len() > MOST {
        all.select_nth_unstable_by(MOST, |a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        all.truncate(MOST);
    }
    let mut out = vec![false; gains.len()];
    all.into_iter().for_each(|(_, k)| out[k] = true);
    out
}

impl Field<'_, '_> {
    /// Like [`Field::gains_of`] for some candidates; the gains of the others are 0.
    pub(super) fn gains_of_some(&self, series: &Series, scores: &mut [Scores; 2], is_in: &[bool]) -> Vec<Gain> {
        let mut gains = Vec::new();
        for scores in scores {
            let more = scores.gains_of_some(series, is_in.get(gains.len()..).unwrap_or_default());
            gains.extend(more);
        }
        let from = gains.len();
        gains.resize(self.candidates.len(), NOTHING);
        let later: Vec<usize> =
            (from..gains.len()).filter(|&number| is_in.get(number).copied().unwrap_or(false)).collect();
        let of_later: Vec<Candidate> =
            later.iter().filter_map(|&number| self.candidates.get(number)).cloned().collect();
        let layout = Arc::new(Layout::new(self.scene, &of_later, &self.tables));
        let scores = Scores::new(&layout, self.scene, &self.factors, series).gains(series);
        for (&number, gain) in later.iter().zip(scores) {
            gains[number] = gain;
        }
        gains
    }
}

impl Scores {
    fn gains_of_some(&mut self, series: &Series, is_in: &[bool]) -> Vec<Gain> {
        let layout = self.layout.clone();
        let numbers: Vec<usize> =
            (0..layout.columns.len()).filter(|&number| is_in.get(number).copied().unwrap_or(false)).collect();
        let mut out = vec![NOTHING; layout.columns.len()];
        let Some(first) = numbers.iter().map(|&number| self.seen(number)).min() else { return out };
        let end = series.basis().len();
        for start in (first..=end).step_by(AT_ONCE) {
            // The products with the residual follow the last direction.
            let behind = (start + AT_ONCE).min(end + 1);
            let all: Vec<Vec<f64>> = (start..behind).map(|place| self.what_is_at(series, place)).collect();
            let open: Vec<usize> =
                numbers.iter().copied().filter(|&number| behind > end || self.seen(number) < behind).collect();
            let mut own: Vec<usize> =
                open.iter().flat_map(|&number| layout.columns[number].iter().flatten()).copied().collect();
            own.sort_unstable();
            own.dedup();
            let pairs: Vec<(usize, usize)> = own.iter().map(|&pair| layout.pairs[pair]).collect();
            let products = self.products(&all, &pairs);
            for number in open {
                let of = |products: &[f64], column: &Vec<usize>| -> f64 {
                    let value = |pair: &usize| own.binary_search(pair).ok().and_then(|place| products.get(place));
                    column.iter().filter_map(value).sum()
                };
                for (place, products) in (start..behind).zip(&products) {
                    let shares = layout.columns[number].iter().map(|column| of(products, column)).collect();
                    if place == end {
                        out[number] = gain(&self.state.own[number], shares);
                    } else if place >= self.seen(number) {
                        self.state.own[number].leave(&shares);
                        self.state.own[number].seen = Some(place + 1);
                    }
                }
            }
        }
        out
    }

    /// Number of directions that a candidate is up to date with.
    fn seen(&self, number: usize) -> usize {
        self.state.own.get(number).and_then(|own: &OwnProducts| own.seen).unwrap_or(self.state.seen)
    }

    fn what_is_at(&self, series: &Series, place: usize) -> Vec<f64> {
        match series.basis().get(place) {
            Some(direction) => series.unwhitened(&direction.whole(series.left().len())),
            None => series.unwhitened(series.left()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_those_stay_that_explain_most_for_their_columns() {
        let of = |squares: f64, rank: usize| Gain { squares, rank };
        // A χ² of 30 in a quarter of the readings predicts 4 · (30 − 1) + 1 − 20 = 97 in all of them, with a margin of 2 · 4 · √(4 · 29 + 2) = 87; a
        // χ² of 1, or of 4 with four columns, predicts −19 or −76, with margins of 11 or 23.
        let mut gains = vec![of(30.0, 1); MOST];
        gains.extend([of(0.0, 0), of(40.0, 1), of(1.0, 1), of(4.0, 4)]);
        let found = promising(&gains, 4.0, 20.0);
        assert_eq!(found.iter().filter(|is_in| **is_in).count(), MOST);
        assert_eq!(found[MOST..], [false, true, false, false]);
    }

    #[test]
    fn what_says_no_more_than_noise_gives_way_to_what_surely_says_more() {
        let of = |squares: f64, rank: usize| Gain { squares, rank };
        // A χ² of 26 is 25 beyond noise: 10 · 25 + 1 − 3 = 248 in all readings, less the margin of 2 · 10 · √(4 · 25 + 2) = 202: 46. A χ² of 1 is
        // noise: −2, plus the margin of 2 · 10 · √2 = 28.
        assert_eq!(promising(&[of(1.0, 1), of(26.0, 1)], 10.0, 3.0), [false, true]);
        // A χ² of 3 is 2 beyond noise: 10 · 2 + 1 − 3 = 18, plus the margin of 2 · 10 · √10 = 63.
        assert_eq!(promising(&[of(3.0, 1), of(26.0, 1)], 10.0, 3.0), [true, true]);
    }
}
