//! Drift that is linear in time within every back-and-forth cycle (Spaan 1995, ch. 3), and the test for the absence of a reversal error.
//!
//! At one target both ways differ by dᵢ = ḋ tᵢ + B. The drift part is proportional to the time between them, which is short near the turn and long at
//! the start of the cycle; the reversal error is the same everywhere. Both are fitted to all pairs, with a rate ḋ for each cycle and one B, and B is
//! tested against its standard error with Student's t-test. Only without a reversal error is the difference due to drift alone. An axis with backlash
//! is rejected, because half of it would distort its cycles at each turn.

use super::positioning::{ApproachReading, FiguresError, SAME, range};

/// Reversal error as a share of the range of the readings below which it is negligible, however certain.
const HARMLESS: f64 = 0.01;
/// Two-sided 0.1 % quantile of the normal distribution.
const NORMAL: f64 = 3.290_53;
/// Two-sided 0.1 % quantiles of Student's distribution with 1 to 4 degrees of freedom, for which the expansion below is not accurate enough.
const STUDENT: [f64; 4] = [636.62, 31.599, 12.924, 8.610];

/// The readings without a drift that is linear in time within every cycle; cycles are shifted to their common mean.
///
/// # Errors
/// [`FiguresError::Backlash`] if the two ways differ by a reversal error, [`FiguresError::TooFew`] if they cannot be compared.
pub fn without_drift(readings: &[ApproachReading]) -> Result<Vec<ApproachReading>, FiguresError> {
    let pairs = pairs(readings)?;
    if let Some((reversal, sigma)) = reversal_of(&pairs, readings)? {
        return Err(FiguresError::Backlash(reversal, sigma));
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let level = mean(&readings.iter().map(|reading| reading.deviation).collect::<Vec<_>>());
    let mut out = readings.to_vec();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); pairs.len()];
    for (number, reading) in readings.iter().enumerate() {
        members.get_mut(reading.cycle).into_iter().for_each(|own| own.push(number));
    }
    for (own, numbers) in pairs.iter().zip(&members) {
        let slope = sum(own, |[time, difference]| time * difference) / sum(own, |[time, _]| time * time);
        let of = |value: fn(&ApproachReading) -> f64| {
            mean(&numbers.iter().filter_map(|&number| readings.get(number)).map(value).collect::<Vec<_>>())
        };
        let (time, deviation) = (of(|reading| reading.time), of(|reading| reading.deviation));
        for &number in numbers {
            if let Some(reading) = out.get_mut(number) {
                reading.deviation += level - deviation - slope * (reading.time - time);
            }
        }
    }
    Ok(out)
}

/// The reversal error and its standard error, if significant in Student's t-test at a p-value of 0.1 %.
///
/// # Errors
/// [`FiguresError::TooFew`] if the two ways cannot be compared.
pub fn significant_reversal(readings: &[ApproachReading]) -> Result<Option<(f64, f64)>, FiguresError> {
    reversal_of(&pairs(readings)?, readings)
}

fn reversal_of(pairs: &[Vec<[f64; 2]>], readings: &[ApproachReading]) -> Result<Option<(f64, f64)>, FiguresError> {
    let (reversal, sigma, freedom) = reversal(pairs).ok_or(FiguresError::TooFew)?;
    let spread = range(readings.iter().map(|reading| reading.deviation));
    let is_there = reversal.abs() > student(freedom) * sigma && reversal.abs() > HARMLESS * spread;
    Ok(is_there.then_some((reversal, sigma)))
}

/// The quantile of Student's distribution (Fisher and Cornish 1960).
fn student(freedom: f64) -> f64 {
    if let Some(&exact) = STUDENT.get((freedom.max(1.0) - 1.0).floor() as usize) {
        return exact;
    }
    let z = NORMAL;
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

/// For every cycle, the time between both ways and the difference of the readings, at every target.
fn pairs(readings: &[ApproachReading]) -> Result<Vec<Vec<[f64; 2]>>, FiguresError> {
    let cycles = readings.iter().map(|reading| reading.cycle).max().ok_or(FiguresError::Nothing)?.saturating_add(1);
    if cycles > readings.len() {
        return Err(FiguresError::TooFew);
    }
    let mut sorted: Vec<&ApproachReading> = readings.iter().collect();
    sorted.sort_by(|one, other| one.cycle.cmp(&other.cycle).then(one.target.total_cmp(&other.target)));
    let mut pairs: Vec<Vec<[f64; 2]>> = vec![Vec::new(); cycles];
    for own in sorted.chunk_by(|one, other| one.cycle == other.cycle && (one.target - other.target).abs() < SAME) {
        // The first of each way: repeated readings at rest on a target would give more pairs than readings.
        let of = |is_up: bool| own.iter().find(|reading| reading.is_up == is_up);
        if let (Some(up), Some(down)) = (of(true), of(false)) {
            let pair = [up.time - down.time, up.deviation - down.deviation];
            pairs.get_mut(up.cycle).into_iter().for_each(|own| own.push(pair));
        }
    }
    if pairs.iter().any(|own| own.len() < 3) { Err(FiguresError::TooFew) } else { Ok(pairs) }
}

/// The reversal error common to all cycles, fitted with a separate drift of each, its standard error, and its degrees of freedom.
fn reversal(pairs: &[Vec<[f64; 2]>]) -> Option<(f64, f64, f64)> {
    let (mut factor, mut value, mut squares, mut count) = (0.0, 0.0, 0.0, 0.0);
    for own in pairs {
        let (tt, t, td) = (sum(own, |[t, _]| t * t), sum(own, |[t, _]| t), sum(own, |[t, d]| t * d));
        let n = own.len() as f64;
        // The drift of the cycle is eliminated.
        factor += n - t * t / tt;
        value += sum(own, |[_, d]| d) - t * td / tt;
        squares += sum(own, |[_, d]| d * d) - td * td / tt;
        count += n - 1.0;
    }
    if !(factor > 1e-9 && count > 1.0) {
        return None;
    }
    let reversal = value / factor;
    let left = (squares - reversal * value).max(0.0);
    Some((reversal, (left / (count - 1.0) / factor).sqrt(), count - 1.0))
}

fn sum(pairs: &[[f64; 2]], term: impl Fn([f64; 2]) -> f64) -> f64 {
    pairs.iter().map(|&pair| term(pair)).sum()
}

#[cfg(test)]
mod tests {
    use super::student;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Two-sided 0.1 %.
        for (freedom, expected) in
            [(1.0, 636.6), (4.0, 8.610), (6.0, 5.959), (10.0, 4.587), (30.0, 3.646), (120.0, 3.373)]
        {
            let found = student(freedom);
            assert!((found / expected - 1.0).abs() < 0.02, "{freedom}: {found}");
        }
    }
}
