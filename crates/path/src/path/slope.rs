//! The local change of the correction on a machine without rotary axes, learned from the stream.
//!
//! A correction is found by iteration from a guess. The last correction is a good guess. With the distance from there and the slope of the
//! correction, the first evaluation of the errors usually only confirms it. The slope is learned by Broyden's rank-one update (Broyden 1965, "good"
//! method) from pairs of solved places. If errors have kinks or steps, it is wrong at one place, which costs one more iteration.

use ncfix_base::geometry::{Axis, AxisVector, Matrix, Vector};

/// Places nearer to each other than this give no slope: their corrections differ by rounding noise, mm.
const APART_MM: f64 = 0.02;
/// Error of a guess below which nothing is learned, mm: one evaluation confirms it.
const NEAR_MM: f64 = 2e-8;
/// Largest slope of errors, mm per mm; a steeper change is a step of the errors between two places.
const STEEPEST: f64 = 0.01;

/// A place, its correction, and the slope there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    axes: [Option<Axis>; 3],
    /// Commands of the program, mm.
    place: Vector,
    /// The correction added to them, mm.
    correction: Vector,
    /// Derivative of the correction with respect to the place, mm/mm.
    by_place: Matrix,
}

impl Slope {
    /// An untrained slope for the axes that correct.
    pub(super) fn new(axes: [Option<Axis>; 3]) -> Slope {
        Slope { axes, place: Vector::zeros(), correction: Vector::zeros(), by_place: Matrix::zeros() }
    }

    #[inline]
    fn of(&self, position: &AxisVector) -> Vector {
        let of = |axis: Option<Axis>| axis.map_or(0.0, |axis| position[axis]);
        Vector::new(of(self.axes[0]), of(self.axes[1]), of(self.axes[2]))
    }

    /// Predicted command for a nominal position.
    #[inline]
    pub(super) fn guess(&self, nominal: &AxisVector) -> AxisVector {
        let correction = self.correction + self.by_place * (self.of(nominal) - self.place);
        let mut command = *nominal;
        for (axis, correction) in self.axes.iter().zip(correction.iter()) {
            if let Some(axis) = axis {
                command[*axis] += correction;
            }
        }
        command
    }

    /// Learns from the solved command and the guess for it.
    #[inline]
    pub(super) fn learn(&mut self, nominal: &AxisVector, command: &AxisVector, guess: &AxisVector) {
        let missed = self.of(command) - self.of(guess);
        if missed.norm_squared() < NEAR_MM * NEAR_MM {
            return;
        }
        let place = self.of(nominal);
        let step = place - self.place;
        let square = step.norm_squared();
        if square < APART_MM * APART_MM {
            return;
        }
        self.by_place += missed * (step / square).transpose();
        if self.by_place.amax() > STEEPEST {
            self.by_place = Matrix::zeros();
        }
        self.place = place;
        self.correction = self.of(command) - place;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A quadratic correction: 1e-5 mm/mm and 1e-7 mm/mm².
    fn command(nominal: &AxisVector) -> AxisVector {
        let [x, y, z] = [Axis::X, Axis::Y, Axis::Z].map(|axis| nominal[axis]);
        let mut command = *nominal;
        command[Axis::X] += 1e-5 * y + 1e-7 * x * x;
        command[Axis::Y] -= 2e-5 * x;
        command[Axis::Z] += 3e-5 * z - 1e-7 * x * y;
        command
    }

    #[test]
    fn on_a_smooth_way_the_guess_is_the_answer() {
        let mut slope = Slope::new([Some(Axis::X), Some(Axis::Y), Some(Axis::Z)]);
        let mut worst = 0.0_f64;
        for k in 0..400 {
            // A spiral of 40 mm, in steps of 0.3 mm.
            let angle = f64::from(k) * 0.0075;
            let nominal =
                AxisVector([40.0 * angle.cos(), 40.0 * angle.sin(), 0.01 * f64::from(k), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let exact = command(&nominal);
            let guess = slope.guess(&nominal);
            if k > 60 {
                worst = worst.max((guess - exact).xyz().norm());
            }
            slope.learn(&nominal, &exact, &guess);
        }
        // The correction changes by up to 6e-6 mm from step to step; the iteration accepts 1e-7 mm.
        assert!(worst < 1e-7, "{worst:e}");
    }

    #[test]
    fn a_step_of_the_errors_leaves_no_trace() {
        let mut slope = Slope::new([Some(Axis::X), None, None]);
        let at = |x: f64| AxisVector([x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        for (nominal, command) in [(1.0, 1.01), (1.1, 1.13)] {
            let guess = slope.guess(&at(nominal));
            slope.learn(&at(nominal), &at(command), &guess);
            assert_eq!(slope.guess(&at(nominal))[Axis::X], command);
        }
        assert_eq!(slope.guess(&at(5.0))[Axis::X], 5.0 + (1.13 - 1.1));
    }
}
