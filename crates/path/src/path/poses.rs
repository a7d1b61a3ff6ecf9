//! Sampled poses, spread over the whole program, for evaluations that are too slow to be made everywhere.

use ncfix_base::geometry::{AxisSet, AxisVector, Vector};
use ncfix_machine::machine::State;

/// Maximum number of kept poses.
const MOST: usize = 256;

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
}

/// Every n-th pose of a stream, with the smallest n that memory allows.
#[derive(Clone, Debug, Default)]
pub(super) struct PoseSampler {
    kept: Vec<PoseSample>,
    /// The first power of two that thins the stream enough, minus one.
    mask: u64,
    seen: u64,
}

impl PoseSampler {
    /// Offers a pose.
    pub(super) fn offer(&mut self, sample: impl FnOnce() -> PoseSample) {
        if self.seen & self.mask == 0 {
            if self.kept.len() == MOST {
                // Every other pose is dropped, the first stays.
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

    /// The poses in order.
    pub(super) fn kept(&self) -> &[PoseSample] {
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
            });
        }
        let kept = poses.kept();
        assert!(kept.len() > MOST / 2 - 1 && kept.len() <= MOST, "{}", kept.len());
        let steps: Vec<f64> = kept.windows(2).map(|pair| pair[1].nominal.0[0] - pair[0].nominal.0[0]).collect();
        assert!(steps.iter().all(|&step| step == steps[0]), "{steps:?}");
        assert_eq!(kept[0].nominal.0[0], 0.0);
    }
}
