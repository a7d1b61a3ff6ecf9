//! The signals of a run at equidistant steps of its control.

use crate::measure::trace::TraceRun;
use ncfix_base::geometry::{Axis, AxisVector};

use super::servo::AxisSignals;
use super::signal::{Signal, even};

/// Minimum step, s, faster than any control: a smaller one is that of an instrument whose table was filled between the cycles.
const FASTEST_S: f64 = 5e-4;
/// Relative second difference that counts as zero.
const STRAIGHT: f64 = 1e-3;
/// Longest step relative to the usual one; larger gaps are filled by a curve.
const GAP: f64 = 1.5;

/// A run at equidistant steps.
#[derive(Clone, Debug)]
pub struct RunGrid {
    /// The cycle of the control, s.
    pub step_s: f64,
    /// Time of the first sample, by the clock of the control, s.
    pub start_s: f64,
    /// Number of samples.
    pub count: usize,
    /// Set-points and encoder positions by axis of the machine.
    pub axes: Vec<(Axis, AxisSignals)>,
    /// Readings along F's directions by the clock of the instrument, mm; empty without readings.
    pub readings: Vec<Signal>,
    /// RMS of single readings about these, mm: the noise of the instrument and motion too fast for the control.
    pub fast_mm: [f64; 3],
}

impl RunGrid {
    /// Resamples a run at equidistant steps.
    #[must_use]
    pub fn new(run: &TraceRun, axes: &[Axis]) -> RunGrid {
        let control = &run.control;
        let kept = cycles(&control.t_s, &control.set, axes);
        let times: Vec<f64> = kept.iter().map(|&k| control.t_s[k]).collect();
        let start_s = times.first().copied().unwrap_or(0.0);
        let end_s = times.last().copied().unwrap_or(0.0);
        let step_s = median_step(&times).max(FASTEST_S);
        let count = ((end_s - start_s) / step_s + 0.5).floor() as usize + 1;
        let is_even = is_even(&times, start_s, step_s);
        let signal = |of: &[AxisVector], axis: Axis| {
            let values: Vec<f64> = kept.iter().map(|&k| of[k][axis]).collect();
            if is_even {
                Signal { start_s, step_s, values }
            } else {
                even(&times, &values, start_s, step_s, count, GAP * step_s)
            }
        };
        let pair = |&axis: &Axis| {
            let [set, encoder] = [&control.set, &control.encoder].map(|of| signal(of, axis));
            (axis, AxisSignals { set, encoder })
        };
        let axes: Vec<(Axis, AxisSignals)> = axes.iter().map(pair).collect();
        let (readings, fast_mm) = readings(run, step_s);
        let count = if is_even { times.len() } else { count };
        RunGrid { step_s, start_s, count, axes, readings, fast_mm }
    }

    /// Set-points at a time of the control, mm and rad.
    #[must_use]
    pub fn set_at(&self, t_s: f64) -> AxisVector {
        let mut out = AxisVector::ZERO;
        self.axes.iter().for_each(|(axis, pair)| out[*axis] = pair.set.at(t_s));
        out
    }

    /// Encoder positions of a sample, mm and rad.
    #[must_use]
    pub fn encoder(&self, number: usize) -> AxisVector {
        let mut out = AxisVector::ZERO;
        self.axes.iter().for_each(|(axis, pair)| out[*axis] = pair.encoder.values.get(number).copied().unwrap_or(0.0));
        out
    }

    /// Time of a sample by the clock of the control, s.
    #[must_use]
    pub fn time(&self, number: usize) -> f64 {
        self.start_s + self.step_s * number as f64
    }
}

/// The true samples of a control in a table filled by linear interpolation: those at which set-points bend.
fn cycles(times: &[f64], set: &[AxisVector], axes: &[Axis]) -> Vec<usize> {
    let count = times.len();
    let bends: Vec<f64> = (1..count.saturating_sub(1))
        .map(|k| {
            let bend = |&axis: &Axis| (set[k + 1][axis] - 2.0 * set[k][axis] + set[k - 1][axis]).abs();
            axes.iter().map(bend).fold(0.0, f64::max)
        })
        .collect();
    let most = bends.iter().copied().fold(0.0, f64::max);
    let knots: Vec<usize> =
        bends.iter().enumerate().filter(|(_, bend)| **bend > STRAIGHT * most).map(|(k, _)| k + 1).collect();
    let common = knots.windows(2).map(|pair| pair[1] - pair[0]).fold(0, greatest_common_divisor);
    match (knots.first(), common) {
        (Some(first), 2..) if median_step(times) < 2e-3 => (first % common..count).step_by(common).collect(),
        _ => (0..count).collect(),
    }
}

/// `true` if samples are equidistant.
fn is_even(times: &[f64], start_s: f64, step_s: f64) -> bool {
    times.iter().enumerate().all(|(k, t)| (t - start_s - step_s * k as f64).abs() < 0.02 * step_s)
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

fn median_step(times: &[f64]) -> f64 {
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(FASTEST_S)
}

/// Readings at three times the rate of the control, and the residuals of single ones.
fn readings(run: &TraceRun, step_s: f64) -> (Vec<Signal>, [f64; 3]) {
    let times = &run.readings.t_s;
    let (Some(&start), Some(&end)) = (times.first(), times.last()) else { return (Vec::new(), [0.0; 3]) };
    let fine = (step_s / 3.0).max(median_step(times));
    let count = ((end - start) / fine).floor() as usize + 1;
    let signals: Vec<Signal> = (0..3)
        .map(|k| {
            let values: Vec<f64> = run.readings.along.iter().map(|along| along[k]).collect();
            if is_even(times, start, fine) {
                // A curve through them would distort changes between successive ones.
                return Signal { start_s: start, step_s: fine, values };
            }
            even(times, &values, start, fine, count, step_s)
        })
        .collect();
    let mut fast = [0.0; 3];
    for ((k, out), signal) in fast.iter_mut().enumerate().zip(&signals) {
        let squares = times.iter().zip(&run.readings.along).map(|(&t, along)| (along[k] - signal.at(t)).powi(2));
        *out = (squares.sum::<f64>() / times.len() as f64).sqrt();
    }
    (signals, fast)
}
