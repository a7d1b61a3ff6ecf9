//! Equidistant time signals: interpolation, readings at other instants, second differences.

/// Standard deviations on either side of the mean that hold 95 % of a normal distribution.
pub const SIGMAS_95: f64 = 1.96;

/// Equidistant values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signal {
    /// Time of the first one, s.
    pub start_s: f64,
    /// Step, s.
    pub step_s: f64,
    /// Values.
    pub values: Vec<f64>,
}

impl Signal {
    /// The value at a time by the cubic through the four surrounding samples; constant beyond the ends.
    ///
    /// Its slope at a sample is half the difference of the neighbors (Catmull and Rom 1974), so that it has no kinks. Its error is of the fourth
    /// order of the step.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        let [before, low, high, behind, share] = self.around(t_s);
        let (rise, bend) = (high - before, 2.0 * before - 5.0 * low + 4.0 * high - behind);
        let twist = 3.0 * (low - high) + behind - before;
        low + 0.5 * share * (rise + share * (bend + share * twist))
    }

    /// Its slope there, per second.
    #[must_use]
    pub fn slope(&self, t_s: f64) -> f64 {
        let [before, low, high, behind, share] = self.around(t_s);
        let (rise, bend) = (high - before, 2.0 * before - 5.0 * low + 4.0 * high - behind);
        let twist = 3.0 * (low - high) + behind - before;
        0.5 * (rise + share * (2.0 * bend + 3.0 * share * twist)) / self.step_s
    }

    /// Indices of four samples and the fraction of the step between the middle ones.
    fn around(&self, t_s: f64) -> [f64; 5] {
        let last = self.values.len().saturating_sub(1);
        let place = ((t_s - self.start_s) / self.step_s).clamp(0.0, last as f64);
        let low = (place.floor() as usize).min(last.saturating_sub(1));
        let at = |k: usize| self.values.get(k.min(last)).copied().unwrap_or(0.0);
        // Beyond the ends the machine is at rest.
        [at(low.saturating_sub(1)), at(low), at(low + 1), at(low + 2), place - low as f64]
    }

    /// The time of a sample, s.
    #[must_use]
    pub fn time(&self, number: usize) -> f64 {
        self.start_s + self.step_s * number as f64
    }

    /// Duration, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.step_s * self.values.len().saturating_sub(1) as f64
    }
}

/// Resamples samples at any increasing times to equal steps, by quadratics fitted to those within half a `window_s` of each instant, or through the
/// nearest three if they are sparse. A parabola has a fourth-order error, and averages noise.
#[must_use]
pub fn even(t_s: &[f64], values: &[f64], start_s: f64, step_s: f64, count: usize, window_s: f64) -> Signal {
    let mut out = Vec::with_capacity(count);
    let mut first = 0;
    for number in 0..count {
        let at = start_s + step_s * number as f64;
        while t_s.get(first).is_some_and(|&t| t < at - 0.5 * window_s) {
            first += 1;
        }
        let mut last = first;
        while t_s.get(last).is_some_and(|&t| t <= at + 0.5 * window_s) {
            last += 1;
        }
        let (mut low, mut high) = (first, last);
        if high - low < 5 {
            // Sparse samples: equally many before and after, or higher-order terms would be shifted in time.
            let middle = t_s.partition_point(|&t| t < at);
            let away = |k: usize| t_s.get(k).map_or(f64::INFINITY, |&t| (t - at).abs());
            let nearest = if middle > 0 && away(middle - 1) < away(middle) { middle - 1 } else { middle };
            let is_on_one = away(nearest) < 0.25 * step_s;
            let wanted = if is_on_one { 5 } else { 4 };
            let from = if is_on_one { nearest } else { middle };
            low = from.saturating_sub(2).min(t_s.len().saturating_sub(wanted));
            high = (low + wanted).min(t_s.len());
        }
        let (times, own) = (t_s.get(low..high).unwrap_or_default(), values.get(low..high).unwrap_or_default());
        out.push(parabola(times, own, at, window_s.max(step_s)));
    }
    Signal { start_s, step_s, values: out }
}

/// The value of the best-fitting parabola at an instant.
fn parabola(t_s: &[f64], values: &[f64], at: f64, unit: f64) -> f64 {
    let mut sums = [0.0; 5];
    let mut products = [0.0; 3];
    for (&t, &value) in t_s.iter().zip(values) {
        let x = ((t - at) / unit).clamp(-50.0, 50.0);
        let mut power = 1.0;
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += power;
            if let Some(product) = products.get_mut(k) {
                *product += power * value;
            }
            power *= x;
        }
    }
    let [n, s1, s2, s3, s4] = sums;
    let minor = |a: f64, b: f64, c: f64, d: f64| a * d - b * c;
    let determinant = n * minor(s2, s3, s3, s4) - s1 * minor(s1, s3, s2, s4) + s2 * minor(s1, s2, s2, s3);
    if n < 3.0 || determinant.abs() < 1e-12 * n * n * n {
        return if n > 0.0 { products[0] / n } else { 0.0 };
    }
    let [p0, p1, p2] = products;
    (p0 * minor(s2, s3, s3, s4) - s1 * minor(p1, s3, p2, s4) + s2 * minor(p1, s2, p2, s3)) / determinant
}

/// Second differences over `reach` samples on both sides, divided by time squared; 0 at the ends. It is the mean of the second derivative with the
/// weights of [`triangle`].
#[must_use]
pub fn second_difference(values: &[f64], reach: usize, step_s: f64) -> Vec<f64> {
    let unit = (reach as f64 * step_s).powi(2);
    let at = |k: usize| values.get(k).copied();
    (0..values.len())
        .map(|k| {
            let around = k.checked_sub(reach).and_then(|before| Some([at(before)?, at(k)?, at(k + reach)?]));
            around.map_or(0.0, |[before, now, behind]| (before - 2.0 * now + behind) / unit)
        })
        .collect()
}

/// Means with weights that decrease linearly to zero at `reach` samples, as far as samples exist.
#[must_use]
pub fn triangle(values: &[f64], reach: usize) -> Vec<f64> {
    let at = |k: Option<usize>| k.and_then(|k| values.get(k)).copied();
    (0..values.len())
        .map(|k| {
            let (mut sum, mut weights) = (reach as f64 * values[k], reach as f64);
            for away in 1..reach {
                let weight = (reach - away) as f64;
                for value in [at(k.checked_sub(away)), at(k.checked_add(away))].into_iter().flatten() {
                    sum += weight * value;
                    weights += weight;
                }
            }
            sum / weights
        })
        .collect()
}

/// Variance inflation by autocorrelation: 1 + 2 Σ ρ, up to the last correlated neighbor; at least 1.
#[must_use]
pub fn inflation(values: &[f64]) -> f64 {
    /// Maximum number of neighbors.
    const MOST: usize = 2000;
    /// Maximum number of values for estimating the autocorrelation.
    const ENOUGH: usize = 20_000;
    let values = values.get(..ENOUGH).unwrap_or(values);
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let along = |lag: usize| -> f64 {
        values.iter().zip(values.iter().skip(lag)).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>()
    };
    let whole = along(0);
    if whole <= 0.0 {
        return 1.0;
    }
    let mut sum = 1.0;
    for lag in 1..values.len().min(MOST) {
        let share = along(lag) / whole;
        // Beyond this, correlations are due to chance.
        if share < 0.05 {
            break;
        }
        sum += 2.0 * share;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_met_between_its_samples() {
        let values: Vec<f64> = (0..20).map(|k| 1.0 + 0.5 * f64::from(k) + 0.25 * f64::from(k * k)).collect();
        let signal = Signal { start_s: 10.0, step_s: 0.5, values };
        // k = 7.3: 1 + 3.65 + 13.3225, slope (0.5 + 0.5 · 7.3) / 0.5.
        assert!((signal.at(13.65) - 17.9725).abs() < 1e-12);
        assert!((signal.slope(13.65) - 8.3).abs() < 1e-12);
        assert_eq!([signal.at(0.0), signal.at(99.0)], [1.0, 1.0 + 9.5 + 90.25]);
    }

    #[test]
    fn sparse_samples_of_a_cubic_are_not_shifted_in_time() {
        // About its middle a cubic is odd relative to a parabola, and does not affect a symmetric fit.
        let times: Vec<f64> = (0..60).map(f64::from).collect();
        let cubic = |t: f64| 2.0 - t + 0.5 * t * t + 0.01 * (t - 20.0).powi(3);
        let values: Vec<f64> = times.iter().map(|&t| cubic(t)).collect();
        for start in [5.0, 5.5] {
            let signal = even(&times, &values, start, 1.0, 40, 1.0);
            for (number, value) in signal.values.iter().enumerate() {
                let t = start + number as f64;
                assert!((value - cubic(t)).abs() < 1e-6, "{t}: {value} instead of {}", cubic(t));
            }
        }
    }

    #[test]
    fn uneven_samples_of_a_parabola_come_out_even() {
        let times: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k) + 0.002 * f64::from(k % 3)).collect();
        let values: Vec<f64> = times.iter().map(|t| 3.0 - t + 2.0 * t * t).collect();
        for window in [0.001, 0.2] {
            let signal = even(&times, &values, 0.5, 0.125, 20, window);
            for (number, value) in signal.values.iter().enumerate() {
                let t = 0.5 + 0.125 * number as f64;
                assert!((value - (3.0 - t + 2.0 * t * t)).abs() < 1e-9, "{window} {t} {value}");
            }
        }
    }

    #[test]
    fn second_differences_are_means_over_a_triangle() {
        // The discrete second differences of any series, weighted: an identity.
        let values: Vec<f64> = (0..60).map(|k| (f64::from(k) * 0.37).sin() + 0.01 * f64::from(k * k % 17)).collect();
        let fine = second_difference(&values, 1, 0.1);
        let coarse = second_difference(&values, 4, 0.1);
        let smooth = triangle(&fine, 4);
        for k in 8..52 {
            assert!((coarse[k] - smooth[k]).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn neighbours_that_are_alike_count_as_one() {
        let blocks: Vec<f64> = (0..4000).map(|k| if (k / 20 * 7919) % 13 < 6 { 1.0 } else { -1.0 }).collect();
        // Blocks of 20: about 20 readings for each independent one.
        let found = inflation(&blocks);
        assert!((12.0..40.0).contains(&found), "{found}");
    }
}
