//! Differences between set-points and encoders: the delay of the recorder and the lag of the servo loops.
//!
//! A recorder that samples encoders later than set-points delays all axes equally, at any feed; a position loop with velocity gain K and velocity
//! feed-forward f follows with
//!
//! ```text
//! x' = K (s − x) + f s'        s − x = (1 − f) z,   z' = s' − K z
//! ```
//!
//! At constant velocity this is a delay of (1 − f)/K, but not under acceleration: z needs 1/K to follow. Both are fitted together to the encoder
//! positions, x(t) = s(t − d) − (1 − f) z(t − d), with one d for all axes and runs. For given d and K the share 1 − f is linear, so that only two
//! numbers are searched.
//!
//! Andolfatto, Lavernhe and Mayer 2011, section 3.2, use the best fitting shift as that of their recorder (18 ms at all feeds). It is determined here
//! too, by axis and run ([`AxisServoErrors::shift_s`]): it includes the lag.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::{in_parts, peak};

use super::signal::{SIGMAS_95, Signal, inflation};

/// Largest searched delay, s.
const MOST_S: f64 = 0.25;
/// Time constants 1/K, s: 300 m/min/mm to 0.1 m/min/mm.
const TIMES_S: [f64; 2] = [2e-4, 0.6];
/// Minimum travel of an axis for determining its loop, mm or rad.
const STILL: f64 = 1e-3;
/// Minimum lag relative to the noise.
const LEAST_LAG: f64 = 2.0;
/// Maximum number of samples of a run in the search.
const ENOUGH: usize = 10_000;
/// Maximum number of search steps.
const STEPS: usize = 60;
/// Convergence limit of delays, s.
const CLOSE_S: f64 = 1e-7;
/// Tolerance by which the delay may exceed the smallest shift, s: noise, overcompensating feed-forward.
const OVER_S: f64 = 2e-3;

/// Determinant of two columns of unit length below which they are equal, but for rounding.
const SINGULAR: f64 = 1e-9;

/// The signals of an axis in a run.
#[derive(Clone, Debug)]
pub struct AxisSignals {
    /// Set-points.
    pub set: Signal,
    /// Encoder positions at the same times.
    pub encoder: Signal,
}

/// The servo loop of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisServoErrors {
    /// The axis.
    pub axis: Axis,
    /// Shift of the set-points that fits the encoder best, with its standard uncertainty, s, by run; NaN if the axis does not move.
    pub shift_s: Vec<(f64, f64)>,
    /// K, 1/s; `None` without a visible lag.
    pub velocity_gain: Option<f64>,
    /// f; 1 without a visible lag.
    pub feed_forward: f64,
    /// RMS residual, mm or rad.
    pub rms: f64,
    /// Half widths of the 95 % intervals.
    pub limits: LoopLimits,
}

/// Half widths of the 95 % intervals of a loop; infinite if the data say nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopLimits {
    /// Of K, 1/s.
    pub velocity_gain: f64,
    /// Of f.
    pub feed_forward: f64,
    /// Of the lag at constant velocity, s.
    pub lag_s: f64,
    /// Of the RMS residual, mm or rad.
    pub rms: f64,
}

/// Largest half width of the 95 % interval of K of a determined loop, as a share of K: of two loops with gains a quarter apart, it is known which is stiffer.
const DETERMINED_GAIN: f64 = 0.125;

impl AxisServoErrors {
    /// `true` if the recording determines K well enough to be stated.
    #[must_use]
    pub fn is_determined(&self) -> bool {
        self.velocity_gain.is_some_and(|gain| self.limits.velocity_gain < DETERMINED_GAIN * gain)
    }

    /// The lag at constant velocity, s.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        self.velocity_gain.map_or(0.0, |gain| (1.0 - self.feed_forward) / gain)
    }
}

/// All loops.
#[derive(Clone, Debug, PartialEq)]
pub struct ServoErrors {
    /// Delay of the encoder recording relative to the set-points, s.
    pub delay_s: f64,
    /// Its standard uncertainty, s.
    pub uncertainty_s: f64,
    /// The moving axes.
    pub axes: Vec<AxisServoErrors>,
}

/// Fit of an axis at one delay.
#[derive(Clone, Copy, Debug)]
struct Follows {
    squares: f64,
    /// 1/K, s, and 1 − f.
    time_s: f64,
    share: f64,
}

/// Estimates delay and loops; `runs` are the pairs of each axis. `None` if no axis moves.
#[must_use]
pub fn servo(axes: &[(Axis, Vec<AxisSignals>)]) -> Option<ServoErrors> {
    let moving: Vec<&(Axis, Vec<AxisSignals>)> =
        axes.iter().filter(|(_, runs)| runs.iter().any(|pair| travel(&pair.set) > STILL)).collect();
    let shifts: Vec<Vec<(f64, f64)>> = in_parts(&moving, &|(_, runs)| runs.iter().map(shift).collect());
    // A loop is never ahead of its set-points: the delay is at most the smallest shift.
    let smallest =
        shifts.iter().flatten().map(|(shift, _)| *shift).filter(|shift| shift.is_finite()).reduce(f64::min)?;
    let at = |delay: f64| -> Vec<Follows> { in_parts(&moving, &|(_, runs)| follows(runs, delay)) };
    let counts: Vec<f64> =
        moving.iter().map(|(_, runs)| runs.iter().map(|pair| pair.set.values.len() as f64).sum()).collect();
    let likely = |delay: f64| -> f64 {
        // Twice the log-likelihood, with the actual noise of each axis.
        -at(delay)
            .iter()
            .zip(&counts)
            .map(|(axis, count)| count * axis.squares.max(f64::MIN_POSITIVE).ln())
            .sum::<f64>()
    };
    let (low, high) = (smallest - MOST_S.min(0.1), smallest + OVER_S);
    // Coarse search first: a long delay and a slow loop are similar at a distance.
    let coarse = (0..=20).map(|k| low + (high - low) * f64::from(k) / 20.0);
    let (best, _) = coarse.map(|delay| (delay, likely(delay))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    let step = (high - low) / 20.0;
    let (delay_s, _) = peak(best - step, (best + step).min(high), CLOSE_S, STEPS, &likely);
    let found = at(delay_s);
    let uncertainty_s = uncertainty(&moving, delay_s, &likely);
    let servo_axes: Vec<AxisServoErrors> = moving
        .iter()
        .zip(&found)
        .zip(shifts)
        .zip(&counts)
        .map(|((((axis, runs), follows), shift_s), count)| {
            let rms = (follows.squares / count).sqrt();
            let most = runs.iter().map(|pair| largest(&lag(&pair.set, follows.time_s))).fold(0.0, f64::max);
            let is_seen = (follows.share * most).abs() > LEAST_LAG * rms;
            AxisServoErrors {
                axis: *axis,
                shift_s,
                velocity_gain: is_seen.then(|| 1.0 / follows.time_s),
                feed_forward: if is_seen { 1.0 - follows.share } else { 1.0 },
                rms,
                limits: limits(runs, delay_s, uncertainty_s, follows, is_seen),
            }
        })
        .collect();
    Some(ServoErrors { delay_s, uncertainty_s, axes: servo_axes })
}

fn travel(signal: &Signal) -> f64 {
    let [low, high] =
        signal.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &v| [low.min(v), high.max(v)]);
    high - low
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// The shift of a run with its standard uncertainty, s.
fn shift(pair: &AxisSignals) -> (f64, f64) {
    if travel(&pair.set) <= STILL {
        return (f64::NAN, f64::NAN);
    }
    let step = pair.set.step_s;
    let most = (MOST_S / step).floor() as i32;
    let squares = |shift: f64| -> f64 { left(pair, shift).iter().map(|value| value * value).sum() };
    let lags = (-most..=most).map(|lag| f64::from(lag) * step);
    let Some((mut best, _)) = lags.map(|shift| (shift, squares(shift))).min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return (f64::NAN, f64::NAN);
    };
    let mut error = f64::INFINITY;
    for _ in 0..20 {
        let left = left(pair, best);
        let slopes: Vec<f64> = (0..left.len()).map(|k| pair.set.slope(pair.encoder.time(k) - best)).collect();
        let whole: f64 = slopes.iter().map(|slope| slope * slope).sum();
        let change = -left.iter().zip(&slopes).map(|(value, slope)| value * slope).sum::<f64>() / whole;
        let variance = left.iter().map(|value| value * value).sum::<f64>() / left.len() as f64;
        error = (variance * inflation(&left) / whole).sqrt();
        best += change.clamp(-step, step);
        if change.abs() < CLOSE_S {
            break;
        }
    }
    (best, error)
}

/// Encoder minus shifted set-points.
fn left(pair: &AxisSignals, shift: f64) -> Vec<f64> {
    let each = pair.encoder.values.iter().enumerate();
    each.map(|(k, value)| value - pair.set.at(pair.encoder.time(k) - shift)).collect()
}

/// z of [the module](self): the lag of a loop without feed-forward, exact for set-points that are linear between samples.
fn lag(set: &Signal, time_s: f64) -> Vec<f64> {
    let fade = (-set.step_s / time_s).exp();
    let mut z = 0.0;
    let mut out = vec![0.0; set.values.len()];
    for (pair, out) in set.values.windows(2).zip(out.iter_mut().skip(1)) {
        z = z * fade + time_s * (1.0 - fade) * (pair[1] - pair[0]) / set.step_s;
        *out = z;
    }
    out
}

/// The loop that fits best for a delay.
fn follows(runs: &[AxisSignals], delay: f64) -> Follows {
    let left: Vec<Vec<f64>> = runs.iter().map(|pair| left(pair, delay)).collect();
    let with = |log_time: f64| -> Follows {
        let time_s = log_time.exp();
        let (mut zz, mut zl, mut ll) = (0.0, 0.0, 0.0);
        for (pair, left) in runs.iter().zip(&left) {
            let z = Signal { values: lag(&pair.set, time_s), ..pair.set };
            let every = left.len().div_ceil(ENOUGH).max(1);
            for (k, value) in left.iter().enumerate().step_by(every) {
                // Each sample represents the skipped ones.
                let weight = every as f64;
                let z = z.at(pair.encoder.time(k) - delay);
                zz += weight * z * z;
                zl -= weight * z * value;
                ll += weight * value * value;
            }
        }
        // From far overcompensated to no feed-forward.
        let share = if zz > 0.0 { (zl / zz).clamp(-0.5, 1.0) } else { 0.0 };
        Follows { squares: (ll - 2.0 * share * zl + share * share * zz).max(0.0), time_s, share }
    };
    let ends = TIMES_S.map(f64::ln);
    let step = (ends[1] - ends[0]) / 16.0;
    let logs = (0..=16).map(|k| ends[0] + step * f64::from(k));
    let best =
        logs.map(|log| (log, with(log).squares)).min_by(|a, b| a.1.total_cmp(&b.1)).map_or(ends[0], |best| best.0);
    let (log, _) = peak((best - step).max(ends[0]), (best + step).min(ends[1]), 1e-5, STEPS, &|log| -with(log).squares);
    with(log)
}

/// Half widths of the 95 % intervals of a loop: from the slopes of its residuals with respect to the delay, ln(1/K) and 1 − f.
fn limits(runs: &[AxisSignals], delay: f64, delay_error: f64, found: &Follows, is_seen: bool) -> LoopLimits {
    /// Step of ln(1/K) for its slope.
    const STEP: f64 = 0.01;
    let (time_s, share) = (found.time_s, found.share);
    let mut products = Matrix3::zeros();
    let (mut squares, mut count, mut alike) = (0.0, 0.0, 1.0_f64);
    for pair in runs {
        let with = |time_s: f64| Signal { values: lag(&pair.set, time_s), ..pair.set };
        let [z, shorter, longer] = [time_s, time_s * (-STEP).exp(), time_s * STEP.exp()].map(with);
        let mut rest = Vec::with_capacity(pair.encoder.values.len());
        for (k, value) in left(pair, delay).into_iter().enumerate() {
            let then = pair.encoder.time(k) - delay;
            let by_time = -share * (longer.at(then) - shorter.at(then)) / (2.0 * STEP);
            let slopes = Vector3::new(share * z.slope(then) - pair.set.slope(then), by_time, -z.at(then));
            products += slopes * slopes.transpose();
            rest.push(value + share * z.at(then));
        }
        squares += rest.iter().map(|value| value * value).sum::<f64>();
        count += rest.len() as f64;
        alike = alike.max(inflation(&rest));
    }
    let variance = squares * alike / f64::max(count - 3.0, 1.0);
    let rms = SIGMAS_95 * (squares / count * alike / (2.0 * count)).sqrt();
    let own = products.fixed_view::<2, 2>(1, 1).into_owned();
    // In units of their columns: a loop without lag does not determine its time constant.
    let scale = own.diagonal().map(|square| if square > 0.0 { square.sqrt().recip() } else { 0.0 });
    let scaled = Matrix2::from_fn(|row, column| own[(row, column)] * scale[row] * scale[column]);
    let Some(inverse) = scaled.try_inverse().filter(|_| scaled.determinant() > SINGULAR) else {
        return LoopLimits { velocity_gain: f64::INFINITY, feed_forward: f64::INFINITY, lag_s: f64::INFINITY, rms };
    };
    let inverse = Matrix2::from_fn(|row, column| inverse[(row, column)] * scale[row] * scale[column]);
    // A delay that is off is compensated by the loop.
    let by_delay = inverse * Vector2::new(products[(1, 0)], products[(2, 0)]) * delay_error;
    let covariance = inverse * variance + by_delay * by_delay.transpose();
    let [time, of_share, both] = [covariance[(0, 0)], covariance[(1, 1)], covariance[(0, 1)]];
    // The lag is (1 − f)/K.
    let lag = time_s * share;
    let of_lag = time_s * time_s * of_share + 2.0 * time_s * lag * both + lag * lag * time;
    // A lag that is not seen is given as none, so its amount is a part of the interval.
    let unseen = if is_seen { 0.0 } else { 1.0 };
    LoopLimits {
        velocity_gain: SIGMAS_95 * time.sqrt() / time_s,
        feed_forward: SIGMAS_95 * of_share.sqrt() + unseen * share.abs(),
        lag_s: SIGMAS_95 * of_lag.max(0.0).sqrt() + unseen * lag.abs(),
        rms,
    }
}

/// From the curvature of the likelihood at the best delay, and the autocorrelation of the residuals.
fn uncertainty(moving: &[&(Axis, Vec<AxisSignals>)], delay: f64, likely: &dyn Fn(f64) -> f64) -> f64 {
    let step = 2e-4;
    let bend = 2.0 * likely(delay) - likely(delay - step) - likely(delay + step);
    let alike: Vec<f64> = moving
        .iter()
        .flat_map(|(_, runs)| {
            let found = follows(runs, delay);
            runs.iter().map(move |pair| {
                let z = Signal { values: lag(&pair.set, found.time_s), ..pair.set };
                let left = left(pair, delay);
                let rest: Vec<f64> = left
                    .iter()
                    .enumerate()
                    .map(|(k, value)| value + found.share * z.at(pair.encoder.time(k) - delay))
                    .collect();
                inflation(&rest)
            })
        })
        .collect();
    let alike = alike.iter().sum::<f64>() / alike.len().max(1) as f64;
    if bend > 0.0 { (2.0 * alike / bend).sqrt() * step } else { f64::INFINITY }
}
