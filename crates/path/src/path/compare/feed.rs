//! Comparison of the feed of a piece with that of its move.
//!
//! F values can be compared if both refer to the same path. If a rotary axis turns, if one of the programs states the duration of blocks (G93), or if
//! only one has a transformation, the durations in the control are compared instead.

use super::super::way::counted;
use super::step::ComparedMove;
use super::{Course, MoveGroup, ON_THE_SPOT_MM};
use ncfix_base::geometry::{Axis, ROTARY_AXES};
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::FeedUnit;

/// Relative difference below which durations are equal: corrections change path lengths.
const SAME_TIME: f64 = 0.05;
/// Relative difference within which a correction keeps the duration of a piece that turns, with rounding: its F value may then differ.
const KEPT_TIME: f64 = 0.015;

impl ComparedMove<'_> {
    /// Minutes (turns under G95) that a control takes for a part of it; `None` without feed, or for a curve that turns an axis.
    fn minutes(&self, [from, to]: [f64; 2], kinematics: &Kinematics) -> Option<f64> {
        if self.rapid || self.feed <= 0.0 {
            return None;
        }
        let least = self.least_minutes([from, to], kinematics);
        if self.unit == FeedUnit::InverseTime {
            return Some(((to - from) / self.feed).max(least));
        }
        let way = match self.route.arc() {
            // Under a transformation the feed is that of the tip.
            Some(_) if self.route.is_of_tip() => self.route.length_mm() * (to - from),
            Some(_) if self.turns() => return None,
            Some(_) => self.route.size_mm() * (to - from),
            None => {
                let is_transformed = self.setup.transform.is_some();
                // A control divides the time of the whole move evenly, also on a great circle, on which the axes turn unevenly.
                let [start, end] = [0.0, 1.0].map(|place| {
                    let command = self.route.at(place);
                    // Under a transformation the feed is that of the tip, in any coordinates.
                    if is_transformed {
                        kinematics.on_workpiece(&command, &self.tool_mm)
                    } else {
                        self.programmed(&command, kinematics)
                    }
                });
                counted(self.feeds, is_transformed, [&start, &end]) * (to - from)
            }
        };
        let taken = way / self.feed;
        // Turns of the spindle are not a time.
        Some(if self.unit == FeedUnit::PerMinute { taken.max(least) } else { taken })
    }

    /// Minutes that the rotary axes need for a part of it. A control lowers a feed that they cannot follow.
    fn least_minutes(&self, part: [f64; 2], kinematics: &Kinematics) -> f64 {
        let [start, end] = part.map(|place| self.route.at(place));
        let turn = |axis: Axis| (end[axis] - start[axis]).abs();
        kinematics.rotary_axes().map(|axis| turn(axis) / kinematics.most_rad_min(axis)).fold(0.0, f64::max)
    }

    /// `true` if one feed is per minute and the other per turn of the spindle.
    pub(super) fn is_of_another_unit(&self, other: &ComparedMove<'_>) -> bool {
        let has_feeds = self.feed > 0.0 && other.feed > 0.0;
        has_feeds && self.unit != other.unit && ![self.unit, other.unit].contains(&FeedUnit::InverseTime)
    }

    /// `true` if it turns a rotary axis.
    fn turns(&self) -> bool {
        ROTARY_AXES.into_iter().any(|axis| self.route.start[axis] != self.route.end[axis])
    }
}

impl MoveGroup<'_> {
    /// Ratio of the feed of a piece to that of its move. A step on the spot covers nothing of the move, so only its F value can be compared. Both
    /// ends of a piece are rounded by up to `rounding_mm`.
    pub(super) fn feed_share(&self, course: &Course<'_>, stands: bool, rounding_mm: f64) -> Option<f64> {
        let (step, piece) = (self.step, course.piece);
        let is_comparable = ![step.unit, piece.unit].contains(&FeedUnit::InverseTime)
            && step.feeds == piece.feeds
            && step.setup.transform.is_some() == piece.setup.transform.is_some();
        let of_numbers = (is_comparable && step.feed > 0.0).then(|| piece.feed / step.feed);
        if of_numbers.is_some() && !step.turns() {
            return of_numbers;
        }
        let part = [course.from, course.to];
        let way_mm = step.route.size_mm() * (part[1] - part[0]);
        if stands || way_mm < ON_THE_SPOT_MM {
            return None;
        }
        let times = step.minutes(part, self.kinematics).zip(piece.minutes([0.0, 1.0], self.kinematics));
        // The duration of a curve that also turns an axis is not computed.
        let Some((wanted, taken)) = times else { return of_numbers };
        let share = wanted / taken;
        // The place on the move is known within the tip error. The tip path may be much shorter than that of the axes.
        let is_timed = step.unit == FeedUnit::InverseTime;
        let counted_mm = if is_timed { way_mm } else { way_mm.min(wanted * step.feed) };
        let place = 2.0 * (ON_THE_SPOT_MM + rounding_mm) / counted_mm.max(ON_THE_SPOT_MM);
        let is_within = |ratio: f64, same: f64| ratio > 1.0 / (1.0 + same) && ratio < 1.0 + same;
        let is_near = |ratio: f64| is_within(ratio, SAME_TIME + place);
        match of_numbers {
            _ if is_within(share, KEPT_TIME) => Some(1.0),
            // Both values refer to the same path.
            Some(of_numbers) if is_near(share / of_numbers) => Some(of_numbers),
            _ if is_near(share) => Some(1.0),
            _ => share.is_finite().then_some(share),
        }
    }
}
