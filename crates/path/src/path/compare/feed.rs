//! The feed of a piece beside that of its move.
//!
//! Numbers behind F can be compared where both count the same way. Where a rotary axis turns, where one of the programs says how long a block takes (G93), or
//! where only one has a transformation, they cannot: the times can that a control takes for them.

use super::super::way::counted;
use super::step::ComparedMove;
use super::{Course, MoveGroup, ON_THE_SPOT_MM};
use ncfix_base::geometry::ROTARY_AXES;
use ncfix_machine::machine::Kinematics;
use ncfix_machine::snc::FeedUnit;

/// Times that differ by less than this share are the same: corrections change ways.
const SAME_TIME: f64 = 0.05;

impl ComparedMove {
    /// Minutes (turns under G95) that a control takes for a part of it; `None` where there is no feed, or it is a curve that turns an axis.
    fn minutes(&self, [from, to]: [f64; 2], kinematics: &Kinematics) -> Option<f64> {
        if self.rapid || self.feed <= 0.0 {
            return None;
        }
        if self.unit == FeedUnit::InverseTime {
            return Some((to - from) / self.feed);
        }
        let way = match self.route.arc() {
            Some(_) if self.turns() => return None,
            Some(_) => self.route.size_mm() * (to - from),
            None => {
                let is_transformed = self.setup.transform.is_some();
                let [start, end] = [from, to].map(|place| {
                    let command = self.route.at(place);
                    // Under a transformation the feed is that of the tip, in whatever coordinates the place is written.
                    if is_transformed {
                        kinematics.on_workpiece(&command, &self.tool_mm)
                    } else {
                        self.programmed(&command, kinematics)
                    }
                });
                counted(self.feeds, is_transformed, [&start, &end])
            }
        };
        Some(way / self.feed)
    }

    /// Whether the one feed is per minute and the other per turn of the spindle.
    pub(super) fn is_of_another_unit(&self, other: &ComparedMove) -> bool {
        let has_feeds = self.feed > 0.0 && other.feed > 0.0;
        has_feeds && self.unit != other.unit && ![self.unit, other.unit].contains(&FeedUnit::InverseTime)
    }

    /// Whether it turns a rotary axis.
    fn turns(&self) -> bool {
        ROTARY_AXES.into_iter().any(|axis| self.route.start[axis] != self.route.end[axis])
    }
}

impl MoveGroup<'_> {
    /// The feed of a piece as a share of that of its move. A step on the spot covers nothing of the move, so that only its number can be compared. Both
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
        // A curve that turns an axis beside it has no time here.
        let Some((wanted, taken)) = times else { return of_numbers };
        let share = wanted / taken;
        // The place on the move is known to what the tip is off. The way of the tip may be far less than that of the axes.
        let is_timed = step.unit == FeedUnit::InverseTime;
        let counted_mm = if is_timed { way_mm } else { way_mm.min(wanted * step.feed) };
        let same = SAME_TIME + 2.0 * (ON_THE_SPOT_MM + rounding_mm) / counted_mm.max(ON_THE_SPOT_MM);
        let is_near = |ratio: f64| ratio > 1.0 / (1.0 + same) && ratio < 1.0 + same;
        match of_numbers {
            // Both numbers are for the same way.
            Some(of_numbers) if is_near(share / of_numbers) => Some(of_numbers),
            _ if is_near(share) => Some(1.0),
            _ => share.is_finite().then_some(share),
        }
    }
}
