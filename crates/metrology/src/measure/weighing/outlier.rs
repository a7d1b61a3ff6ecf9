//! Readings that contradict the others: single ones and pairs are left out if their omission reduces the sum of squares significantly.
//!
//! Without the readings S the sum of squares decreases by Q = rᵀ (I − H)⁻¹ r over S, with the residuals r and the hat matrix H of the whole fit. For
//! a single reading √Q divided by the standard deviation of the rest is Student's t (deletion residual), for a pair Q/2 divided by its square F(2,
//! ν); with a known standard deviation normal and χ². Probabilities are multiplied by the number of candidates (Bonferroni). A disturbed reading of a
//! pair can mask the other one in the single test, which is why pairs are tried.
//!
//! Of two different readings at one position, either may be disturbed. If other candidates explain the readings almost as well (by their likelihood),
//! none of them is left out: they are alternatives. More readings are then needed, unless the contradiction is within the scatter of the residuals.

use super::fit::{WeighingEquation, WeighingFit};

/// Probability of leaving out any undisturbed reading in one step; also the likelihood relative to the best above which a candidate is an alternative.
const CHANCE: f64 = 0.01;
/// Probability below which a disturbance that cannot be located is certain.
const CERTAIN: f64 = 1e-4;
/// Maximum number of readings that are left out, and at most a quarter of all.
const MOST: usize = 500;
/// Maximum number of readings for which pairs are tried.
const MOST_FOR_PAIRS: usize = 60;
/// Minimum independence: a reading that no other one checks has a leverage of 1.
const LEAST_CHECK: f64 = 1e-6;
/// Degrees of freedom above which Student's distribution is approximated by the normal one.
const NORMAL: usize = 1000;

/// Treatment of contradictory readings.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum OutlierVerdict {
    /// These are left out; possibly none.
    LeftOut(Vec<usize>),
    /// Some of these are disturbed, but they cannot be identified.
    Rivals(Vec<usize>),
}

/// Marks contradictory readings as unused.
pub(super) fn leave_out(lines: &mut [WeighingEquation], count: usize, sigma: Option<f64>) -> OutlierVerdict {
    let most = (lines.len() / 4).min(MOST);
    let mut found = Vec::new();
    while let Some(fit) = WeighingFit::new(lines, count) {
        let next = match Search::new(lines, &fit, sigma).next() {
            OutlierVerdict::LeftOut(next) => next,
            rivals => return rivals,
        };
        if next.is_empty() || found.len() + next.len() > most {
            break;
        }
        next.iter().for_each(|&index| lines[index].is_used = false);
        found.extend(next);
    }
    found.sort_unstable();
    OutlierVerdict::LeftOut(found)
}

/// Readings that may be left out together.
#[derive(Clone, Debug)]
struct Candidate {
    readings: Vec<usize>,
    /// Reduction of the sum of squares by their omission.
    gain: f64,
}

/// One step.
struct Search<'a> {
    fit: &'a WeighingFit,
    used: Vec<usize>,
    sigma: Option<f64>,
}

impl<'a> Search<'a> {
    fn new(lines: &[WeighingEquation], fit: &'a WeighingFit, sigma: Option<f64>) -> Search<'a> {
        let used = (0..lines.len()).filter(|&index| lines[index].is_used).collect();
        Search { fit, used, sigma }
    }

    fn next(&self) -> OutlierVerdict {
        let none = OutlierVerdict::LeftOut(Vec::new());
        let Some(left) = self.fit.freedom.checked_sub(1).filter(|&left| left > 0) else { return none };
        let singles = self.singles();
        let Some(single) = best(&singles) else { return none };
        let single_chance = self.student(single.gain, single.gain, left) * singles.len() as f64;
        let is_single = single_chance <= CHANCE;
        let single_rivals = if is_single { self.single_rivals(&singles, single, left) } else { Vec::new() };
        if is_single && single_rivals.is_empty() {
            return OutlierVerdict::LeftOut(single.readings.clone());
        }
        let pairs = self.pairs();
        if let (Some(pair), Some(left)) = (best(&pairs), left.checked_sub(1).filter(|&left| left > 0)) {
            // If the single reading is significant, the second one of the pair must be significant too.
            let chance = if is_single {
                self.student(pair.gain - single.gain, pair.gain, left)
            } else {
                self.both(pair.gain, left)
            };
            let chance = chance * pairs.len() as f64;
            if chance <= CHANCE {
                let rivals = self.rivals(&pairs, pair, left);
                if rivals.is_empty() {
                    return OutlierVerdict::LeftOut(pair.readings.clone());
                }
                if chance <= CERTAIN && !is_single {
                    return OutlierVerdict::Rivals(rivals);
                }
            }
        }
        if single_chance <= CERTAIN { OutlierVerdict::Rivals(single_rivals) } else { none }
    }

    fn singles(&self) -> Vec<Candidate> {
        let candidate = |&index: &usize| {
            let check = 1.0 - self.fit.hat(index, index);
            let gain = self.fit.residuals[index].powi(2) / check;
            (check > LEAST_CHECK).then(|| Candidate { readings: vec![index], gain })
        };
        self.used.iter().filter_map(candidate).collect()
    }

    fn pairs(&self) -> Vec<Candidate> {
        let mut pairs = Vec::new();
        if self.used.len() > MOST_FOR_PAIRS {
            return pairs;
        }
        for (at, &one) in self.used.iter().enumerate() {
            for &other in &self.used[at + 1..] {
                if let Some(gain) = self.pair_gain(one, other) {
                    pairs.push(Candidate { readings: vec![one, other], gain });
                }
            }
        }
        pairs
    }

    fn pair_gain(&self, one: usize, other: usize) -> Option<f64> {
        let [a, b] = [one, other].map(|index| 1.0 - self.fit.hat(index, index));
        let c = -self.fit.hat(one, other);
        let determinant = a * b - c * c;
        let [r, s] = [self.fit.residuals[one], self.fit.residuals[other]];
        (determinant > LEAST_CHECK).then(|| (b * r * r - 2.0 * c * r * s + a * s * s) / determinant)
    }

    /// The alternatives to a single reading. A reading that is contradictory even without the best is not an alternative, but the next to be left out.
    fn single_rivals(&self, singles: &[Candidate], best: &Candidate, left: usize) -> Vec<usize> {
        let rivals = self.rivals(singles, best, left);
        let Some(left) = left.checked_sub(1).filter(|&left| left > 0) else { return rivals };
        let is_next = |&index: &usize| {
            best.readings.contains(&index)
                || best
                    .readings
                    .first()
                    .and_then(|&one| self.pair_gain(one, index))
                    .is_some_and(|gain| self.student(gain - best.gain, gain, left) * singles.len() as f64 <= CHANCE)
        };
        if rivals.iter().all(is_next) { Vec::new() } else { rivals }
    }

    /// Sum of squares after a gain. If only rounding remains, nothing is disturbed.
    fn rest(&self, gain: f64) -> f64 {
        const ROUNDING: f64 = 1e-9;
        (self.fit.squares - gain).max(ROUNDING * ROUNDING * self.fit.size).max(f64::MIN_POSITIVE)
    }

    /// p-value of a gain by one reading, given the rest after the gain `whole`.
    fn student(&self, gain: f64, whole: f64, left: usize) -> f64 {
        match self.sigma {
            Some(sigma) => student_tail(gain.max(0.0).sqrt() / sigma, NORMAL),
            None => student_tail((gain.max(0.0) / (self.rest(whole) / left as f64)).sqrt(), left),
        }
    }

    /// p-value of a gain by two readings together: P(F(2, ν) > f) = (1 + 2 f/ν)^(−ν/2).
    fn both(&self, gain: f64, left: usize) -> f64 {
        match self.sigma {
            Some(sigma) => (-0.5 * gain / (sigma * sigma)).exp(),
            None => (1.0 + gain / self.rest(gain)).powf(-0.5 * left as f64),
        }
    }

    /// The readings of the best candidate and of those that are almost as likely; empty if there are no others.
    fn rivals(&self, candidates: &[Candidate], best: &Candidate, left: usize) -> Vec<usize> {
        let likelihood = |candidate: &Candidate| match self.sigma {
            Some(sigma) => (-0.5 * (best.gain - candidate.gain) / (sigma * sigma)).exp(),
            None => (self.rest(candidate.gain) / self.rest(best.gain)).powf(-0.5 * left as f64),
        };
        let is_rival = |candidate: &&Candidate| candidate.readings != best.readings && likelihood(candidate) > CHANCE;
        let mut rivals: Vec<usize> = candidates.iter().filter(is_rival).flat_map(|one| one.readings.clone()).collect();
        if !rivals.is_empty() {
            rivals.extend(&best.readings);
        }
        rivals.sort_unstable();
        rivals.dedup();
        rivals
    }
}

fn best(candidates: &[Candidate]) -> Option<&Candidate> {
    candidates.iter().max_by(|one, other| f64::total_cmp(&one.gain, &other.gain))
}

/// P(|t| > value) of Student's distribution (Abramowitz and Stegun, 26.7.3 and 26.7.4).
fn student_tail(value: f64, freedom: usize) -> f64 {
    let freedom = freedom.min(NORMAL);
    let angle = (value / (freedom as f64).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    let is_odd = freedom % 2 == 1;
    let (mut term, mut sum) = if is_odd { (cosine, 0.0) } else { (1.0, 0.0) };
    let mut power = if is_odd { 1 } else { 0 };
    while power + 2 <= freedom {
        sum += term;
        term *= cosine * cosine * (power + 1) as f64 / (power + 2) as f64;
        power += 2;
    }
    let inside = if is_odd { std::f64::consts::FRAC_2_PI * (angle + sine * sum) } else { sine * sum };
    (1.0 - inside).max(0.0)
}

/// χ²/ν that undisturbed readings exceed with a probability of 1 % (Wilson and Hilferty).
pub(super) fn highest_ratio(freedom: usize) -> f64 {
    let spread = 2.0 / (9.0 * freedom.max(1) as f64);
    (1.0 - spread + 2.326 * spread.sqrt()).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_the_tables() {
        // Two-sided points of Student's distribution: 5 % and 1 %.
        let table = [
            (1, 12.7062, 63.6567),
            (2, 4.3027, 9.9248),
            (3, 3.1824, 5.8409),
            (4, 2.7764, 4.6041),
            (7, 2.3646, 3.4995),
            (10, 2.2281, 3.1693),
            (1000, 1.9623, 2.5808),
        ];
        for (freedom, five, one) in table {
            assert!((student_tail(five, freedom) - 0.05).abs() < 1e-5, "{freedom}");
            assert!((student_tail(one, freedom) - 0.01).abs() < 1e-5, "{freedom}");
        }
        assert_eq!(student_tail(0.0, 5), 1.0);
        // χ²: 15.086 at 5, 23.209 at 10 degrees of freedom.
        assert!((highest_ratio(5) - 15.086 / 5.0).abs() < 0.03);
        assert!((highest_ratio(10) - 23.209 / 10.0).abs() < 0.01);
    }
}
