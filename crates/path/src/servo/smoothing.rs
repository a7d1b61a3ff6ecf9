//! Smooths set-points: two box filters in series form a triangular kernel.

use ncfix_base::geometry::{AXIS_COUNT, AxisVector};

/// A kernel of two boxes of whole cycles.
#[derive(Clone, Debug)]
pub(super) struct Smoothing {
    boxes: [Mean; 2],
}

impl Smoothing {
    /// Cycles of each box for a kernel length; 1 means no smoothing.
    pub(super) fn cycles(kernel_s: f64, cycle_s: f64) -> usize {
        (0.5 * kernel_s / cycle_s).round().max(1.0) as usize
    }

    pub(super) fn new(cycles: usize) -> Smoothing {
        Smoothing { boxes: [Mean::new(cycles), Mean::new(cycles)] }
    }

    /// Resets the filter as if the position had been constant.
    pub(super) fn reset(&mut self, position: &AxisVector) {
        self.boxes.iter_mut().for_each(|mean| mean.reset(position));
    }

    /// The smoothed position after the next input; its delay is the cycles of a box minus one.
    pub(super) fn next(&mut self, position: &AxisVector) -> AxisVector {
        let [first, second] = &mut self.boxes;
        second.next(&first.next(position))
    }
}

/// Moving average of the last positions.
#[derive(Clone, Debug)]
struct Mean {
    last: Vec<AxisVector>,
    at: usize,
    sum: AxisVector,
}

impl Mean {
    fn new(cycles: usize) -> Mean {
        Mean { last: vec![AxisVector::ZERO; cycles.max(1)], at: 0, sum: AxisVector::ZERO }
    }

    fn reset(&mut self, position: &AxisVector) {
        self.last.fill(*position);
        self.sum = self.total();
    }

    fn next(&mut self, position: &AxisVector) -> AxisVector {
        let Some(oldest) = self.last.get_mut(self.at) else { return *position };
        self.sum = self.sum + (*position - *oldest);
        *oldest = *position;
        self.at += 1;
        if self.at >= self.last.len() {
            self.at = 0;
            // The sum is recomputed, so that rounding errors do not accumulate over days.
            self.sum = self.total();
        }
        let count = self.last.len() as f64;
        AxisVector(self.sum.0.map(|sum| sum / count))
    }

    fn total(&self) -> AxisVector {
        let mut sum = [0.0; AXIS_COUNT];
        for position in &self.last {
            sum.iter_mut().zip(position.0).for_each(|(sum, value)| *sum += value);
        }
        AxisVector(sum)
    }
}
