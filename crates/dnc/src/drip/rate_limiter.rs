//! Maps the permissions of a move to steps of the rate limit.

use crate::feed::{Dose, DosingLimits, LineDosing};
use ncfix_base::geometry::{AXES, AXIS_COUNT, AxisVector};
use ncfix_path::path::{Allows, Asked, Doses};

use super::slots;

/// Limits the rate of change of the correction to the limits of a job.
pub(super) struct RateLimiter {
    dosing: LineDosing,
    /// True while sensors are unreliable: the applied correction follows the path and approaches no target.
    pub(super) is_frozen: bool,
}

impl RateLimiter {
    pub(super) fn new(limits: DosingLimits) -> RateLimiter {
        RateLimiter { dosing: LineDosing::new(limits), is_frozen: false }
    }
}

impl Doses for RateLimiter {
    fn dose(&mut self, asked: &Asked) -> AxisVector {
        let dose = match asked.allows {
            Allows::Nothing => Dose::Hold,
            Allows::Release => Dose::Release,
            Allows::Change | Allows::Rapid if self.is_frozen => Dose::Follow,
            Allows::Change => Dose::Step { way_mm: asked.way_mm, time_s: asked.time_s },
            Allows::Rapid => Dose::Whole,
        };
        let applied: [f64; AXIS_COUNT] = self.dosing.step(&slots(&asked.before), &slots(&asked.now), dose);
        let mut out = AxisVector::ZERO;
        AXES.into_iter().zip(applied).for_each(|(axis, value)| out[axis] = value);
        out
    }
}
