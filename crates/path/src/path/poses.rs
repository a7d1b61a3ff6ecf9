//! Sampled poses and places, spread over the whole program, for evaluations that are too slow to be made everywhere.

use ncfix_base::geometry::{AxisSet, AxisVector, Vector};
use ncfix_machine::machine::State;
use ncfix_machine::snc::Origin;

/// A pose of the tool in an emitted program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseSample {
    /// Command of the program.
    pub nominal: AxisVector,
    /// Emitted command.
    pub command: AxisVector,
    /// Direction of motion of the emitted commands.
    pub state: State,
    /// From the spindle gauge point to the tip, in F at the zero pose, mm.
    pub tool_mm: Vector,
    /// The rotary axes that participated in the correction.
    pub turning: AxisSet,
    /// The active head, by its index.
    pub head: u16,
}

/// A place along a program at which its error is predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorPlace {
    /// Command of the program.
    pub nominal: AxisVector,
    /// Emitted command.
    pub command: AxisVector,
    /// Direction of motion of the program, and of the emitted commands.
    pub states: [State; 2],
    /// Displacement of the tip on the model as programmed and as emitted, in the workpiece frame, mm. A body may be within its dead band, where it has no direction.
    pub errors_mm: [Vector; 2],
    /// From the spindle gauge point to the tip, in F at the zero pose, mm.
    pub tool_mm: Vector,
    /// Block of the program.
    pub origin: Origin,
    /// The zero offset in force, by its index.
    pub zero: Option<u16>,
    /// The active head, by its index.
    pub head: u16,
    /// `true` if it counts in means. A place that was chosen for its large error counts only in maxima.
    pub is_even: bool,
}

/// Poses of a program.
pub(super) type PoseSampler = Thinned<PoseSample, 256>;

/// Every n-th entry of a stream, with the smallest n that keeps no more than `MOST`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Thinned<T, const MOST: usize> {
    kept: Vec<T>,
    /// The first power of two that thins the stream enough, minus one.
    mask: u64,
    seen: u64,
}

impl<T, const MOST: usize> Default for Thinned<T, MOST> {
    fn default() -> Self {
        Thinned { kept: Vec::new(), mask: 0, seen: 0 }
    }
}

impl<T, const MOST: usize> Thinned<T, MOST> {
    /// Offers an entry.
    pub(super) fn offer(&mut self, sample: impl FnOnce() -> T) {
        if self.seen & self.mask == 0 {
            if self.kept.len() == MOST {
                // Every other one is dropped, the first stays.
                let mut stays = false;
                self.kept.retain(|_| {
                    stays = !stays;
                    stays
                });
                self.mask = 2 * self.mask + 1;
            }
            if self.seen & self.mask == 0 {
                self.kept.push(sample());
            }
        }
        self.seen += 1;
    }

    /// The entries in order.
    pub(super) fn kept(&self) -> &[T] {
        &self.kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_kept_poses_are_spread_evenly() {
        let mut poses = PoseSampler::default();
        for k in 0..100_000 {
            poses.offer(|| PoseSample {
                nominal: AxisVector([f64::from(k); 9]),
                command: AxisVector::ZERO,
                state: State::default(),
                tool_mm: Vector::zeros(),
                turning: AxisSet::EMPTY,
                head: 0,
            });
        }
        let kept = poses.kept();
        assert!(kept.len() > 127 && kept.len() <= 256, "{}", kept.len());
        let steps: Vec<f64> = kept.windows(2).map(|pair| pair[1].nominal.0[0] - pair[0].nominal.0[0]).collect();
        assert!(steps.iter().all(|&step| step == steps[0]), "{steps:?}");
        assert_eq!(kept[0].nominal.0[0], 0.0);
    }
}
