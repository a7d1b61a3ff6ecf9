//! The last direction of motion of every axis, derived from its set-points.

use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_machine::machine::State;

/// Directions, with the farthest set-point in each: a reversal counts once the axis has returned from there by more than a band, so that a
/// fluctuating last digit is not a reversal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Senses {
    state: State,
    farthest: Option<AxisVector>,
    band_mm: f64,
    band_rad: f64,
}

impl Senses {
    pub(super) fn new(band_mm: f64, band_rad: f64) -> Senses {
        Senses { state: State::default(), farthest: None, band_mm, band_rad }
    }

    /// Adds a set-point. Returns the directions in which the axes reach it.
    pub(super) fn note(&mut self, set_point: &AxisVector) -> &State {
        let Some(farthest) = &mut self.farthest else {
            self.farthest = Some(*set_point);
            return &self.state;
        };
        for axis in AXES {
            let band = if axis.is_rotary() { self.band_rad } else { self.band_mm };
            let sense = &mut self.state.direction[axis.slot()];
            let step = set_point[axis] - farthest[axis];
            if step * f64::from(*sense) > 0.0 {
                farthest[axis] = set_point[axis];
            } else if step.abs() > band {
                *sense = if step > 0.0 { 1 } else { -1 };
                farthest[axis] = set_point[axis];
            }
        }
        &self.state
    }

    /// Resets all directions.
    pub(super) fn reset(&mut self) {
        *self = Senses::new(self.band_mm, self.band_rad);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reversal_is_more_than_a_flicker() {
        let mut senses = Senses::new(1e-3, 1e-6);
        let mut sense = |x: f64| senses.note(&AxisVector([x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])).direction[0];
        // Creeping counts as motion in the known direction; motion in the other direction is measured from the farthest point.
        let path = [10.0, 10.0, 10.5, 10.5004, 10.4998, 10.4993, 10.4990, 10.5010];
        assert_eq!(path.map(&mut sense), [0, 0, 1, 1, 1, -1, -1, 1]);
    }
}
