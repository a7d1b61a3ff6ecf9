//! The duration of pieces of moves that turn rotary axes.
//!
//! On most controls F refers to the path of X, Y and Z, and rotary axes keep pace; if nothing else moves, F refers to the rotary axes. The correction
//! of a block that turns only an axis moves X, Y, Z by micrometers. F would then be the speed of these micrometers, and the axis would turn as fast
//! as it can. Such blocks state their duration instead (G93), and the next other block returns to a feed (G94). Both are in the line with which a
//! block begins, so that words for that block alone stay with its motion. A short path during a turn, and changes within a block, get the F value
//! that yields the same duration.
//!
//! The feed path: [`crate::path::way`].

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AxisVector, ROTARY_AXES};
use ncfix_machine::snc::{Element, FEED_MODES, FeedUnit, Kind, MotionMode, Move, Origin, Word, WordValue};

use super::{Active, Corrector};
use crate::path::cut::{MOST_FEED, of_share};
use crate::path::place::{CommandSolver, SHORT_MM};
use crate::path::route::Route;
use crate::path::segment_candidate::SegmentCandidate;
use crate::path::{Feeds, Output, way};

/// Turn below which a rotary axis stands, rad: the rounding of its position, and a thousandth of the finest increment.
const STANDS_RAD: f64 = 1e-10;
/// Relative difference below which durations are equal.
const SAME_SHARE: f64 = 0.01;
/// The duration of a move whose feed path the correction may change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pacing {
    /// Programmed duration, min, or turns of the spindle.
    minutes: f64,
    /// `true` if only rotary axes move in the program.
    is_turn: bool,
    /// `true` if each piece needs its own feed: the output has no transformation, and the ratio of the paths of the axes and of the tip changes.
    is_of_axes: bool,
}

/// M functions that end a program, and that return to the caller.
const ENDS: [f64; 2] = [2.0, 30.0];
const RETURNS: [f64; 2] = [17.0, 99.0];

/// The feed mode of the program and of the output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    is_per_minute: bool,
    /// `true` if the program has added rotary axes to the feed path (FGROUP); the correction does not change that.
    pub(super) counts_turns: bool,
    /// Origin since which the output states durations while the program states feeds.
    by_time: Option<Origin>,
    /// `true` if no piece of the block has been written yet.
    is_fresh: bool,
    /// The last programmed feed; 0 if none.
    feed: f64,
    /// The last feed of a piece whose way the correction changed, as written; 0 if none.
    written: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { is_per_minute: true, counts_turns: false, by_time: None, is_fresh: false, feed: 0.0, written: 0.0 }
    }
}

impl Pace {
    /// `true` if the output states durations while the program states feeds.
    pub(super) fn is_by_time(&self) -> bool {
        self.by_time.is_some()
    }
}

impl CommandSolver<'_> {
    /// The feed path between two commands: mm or degrees.
    fn counted(&self, feeds: Feeds, start: &AxisVector, end: &AxisVector) -> f64 {
        way::counted(feeds, self.is_transformed(), [&self.programmed(start), &self.programmed(end)])
    }

    /// `true` if a feed refers to the path of X, Y, Z between two commands, even if rotary axes turn.
    fn takes_feed(&self, feeds: Feeds, start: &AxisVector, end: &AxisVector) -> bool {
        let [start, end] = [start, end].map(|command| self.programmed(command).xyz());
        (feeds != Feeds::OfAll || self.is_transformed()) && (end - start).norm() > SHORT_MM
    }

    /// The duration of a whole move at its feed, s; `None` for rapid moves and feeds per revolution of the spindle.
    pub(super) fn duration_s(&self, feeds: Feeds, route: &Route<'_>, motion: &Move, feed: f64) -> Option<f64> {
        if motion.rapid || feed <= 0.0 {
            return None;
        }
        let minutes = match motion.unit {
            FeedUnit::InverseTime => feed.recip(),
            FeedUnit::PerMinute if route.is_of_tip() && self.leaves_transform() => self.tip_way(route) / feed,
            FeedUnit::PerMinute if route.arc().is_some() || route.is_of_tip() => route.length_mm() / feed,
            FeedUnit::PerMinute => self.counted(feeds, &route.start, &route.end) / feed,
            FeedUnit::PerTurn => return None,
        };
        Some(60.0 * minutes)
    }

    /// The duration of a whole move at a feed, if the correction may change its feed path.
    pub(super) fn pacing(&self, feeds: Feeds, route: &Route<'_>, motion: &Move, feed: f64) -> Option<Pacing> {
        let has_feed =
            !motion.rapid && feed > 0.0 && !motion.is_inverse_time() && motion.motion_mode == MotionMode::Path;
        if !self.has_rotary || !has_feed {
            return None;
        }
        if route.is_of_tip() && self.leaves_transform() {
            let minutes = self.tip_way(route) / motion.feed;
            return (minutes > 0.0).then_some(Pacing { minutes, is_turn: false, is_of_axes: true });
        }
        let turns = ROTARY_AXES.into_iter().any(|axis| (route.start[axis] - route.end[axis]).abs() > STANDS_RAD);
        if route.arc().is_some() {
            let minutes = route.length_mm() / feed;
            let is_paced = turns && route.is_of_tip() && minutes > 0.0;
            return is_paced.then_some(Pacing { minutes, is_turn: false, is_of_axes: false });
        }
        let minutes = self.counted(feeds, &route.start, &route.end) / feed;
        let is_turn = !self.takes_feed(Feeds::OfLinear, &route.start, &route.end);
        (turns && minutes > 0.0).then_some(Pacing { minutes, is_turn, is_of_axes: false })
    }
}

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The feed of a piece between two commands for its share of the move duration, and the feed unit. A change of the unit is queued. A step on the
    /// spot has no share of the path and keeps the feed.
    pub(super) fn feed_of(
        &mut self,
        active: &mut Active<'_>,
        [start, end]: [&AxisVector; 2],
        share: f64,
        trial: Option<&SegmentCandidate<'_>>,
    ) -> (f64, FeedUnit) {
        let is_fresh = std::mem::take(&mut self.pace.is_fresh);
        let motion = &active.motion;
        if motion.rapid || motion.feed <= 0.0 {
            return (motion.feed, motion.unit);
        }
        if motion.is_inverse_time() {
            return (of_share(motion.feed, share, self.options.feeds), FeedUnit::InverseTime);
        }
        let (feed, unit, origin) = (motion.feed, motion.unit, active.origin);
        self.pace.feed = feed;
        let is_begun = self.pace.by_time == Some(origin) && !is_fresh;
        let pacing = active.pacing.filter(|_| !self.pace.counts_turns);
        if let Some(Pacing { minutes, is_turn, is_of_axes }) = pacing {
            let way = match trial.filter(|trial| trial.circle.is_some()) {
                Some(arc) => arc.emitted.length_mm(),
                None => self.placer.counted(self.options.feeds, start, end),
            };
            let wanted = share * minutes * feed;
            let is_off = is_of_axes || (way - wanted).abs() > SAME_SHARE * wanted;
            let has_times = self.pace.is_per_minute && self.options.feeds != Feeds::OfLinearOnly;
            if is_off && is_turn && !has_times {
                self.findings.feed_of_another_way(&origin);
                return (feed, unit);
            }
            // A piece after an unaffected first piece, such as a step on the spot, will be affected.
            let is_taken = is_off || self.placer.takes_feed(self.options.feeds, start, end);
            if is_begun || is_taken && is_turn && is_fresh && has_times {
                if !is_begun && self.pace.by_time.is_none() {
                    self.change_pace(active, true);
                }
                self.pace.by_time = Some(origin);
                return (of_share(minutes.recip(), share, self.options.feeds), FeedUnit::InverseTime);
            }
            if is_off && trial.is_some() && way > 0.0 && wanted > 0.0 && self.leave_pace(active, is_fresh) {
                let exact = feed * way / wanted;
                // The feed in force stays where it serves too, so that short blocks do not change it one after the other.
                if (self.pace.written - exact).abs() > SAME_SHARE * exact {
                    // Rounded to a millionth, but never to zero.
                    self.pace.written = ((exact * 1e6).ceil() / 1e6).min(MOST_FEED);
                }
                return (self.pace.written, unit);
            }
        }
        self.leave_pace(active, is_fresh);
        self.pace.written = feed;
        (feed, unit)
    }

    /// Returns to feed mode from this piece on. Only the first line of a block can do that; `false` for another line.
    fn leave_pace(&mut self, active: &mut Active<'_>, is_fresh: bool) -> bool {
        if self.pace.by_time.is_none() {
            return true;
        }
        if is_fresh {
            self.change_pace(active, false);
        } else {
            self.findings.feed_of_another_way(&active.origin);
        }
        is_fresh
    }

    /// Writes the change of the feed mode in the first line of a move's block.
    fn change_pace(&mut self, active: &mut Active<'_>, is_by_time: bool) {
        let (number, starts_block) = (active.number.take(), std::mem::take(&mut active.starts_block));
        self.say_pace(Element { origin: active.origin, starts_block, number, kind: Kind::Empty }, is_by_time);
    }

    fn say_pace(&mut self, element: Element, is_by_time: bool) {
        self.pace.by_time = is_by_time.then_some(element.origin);
        let kind = Kind::Keep(if is_by_time { "G93" } else { "G94" });
        self.pending.push_back(Ok(Output::Element(Element { kind, ..element })));
    }

    /// Restores the programmed feed mode before a block whose words need it.
    pub(super) fn keep_pace(&mut self, element: &Element) {
        self.pace.is_fresh |= element.starts_block;
        let has_m = |words: &[Word], codes: &[f64]| {
            words
                .iter()
                .any(|word| word.letter == b'M' && codes.iter().any(|&code| word.value == WordValue::Number(code)))
        };
        // Not every control leaves G93 at the end: the next program would read its F as an inverse time.
        let ends = matches!(&element.kind, Kind::Before(words) | Kind::After(words) if has_m(words, &ENDS));
        let needs_feed = match &element.kind {
            Kind::Feed(_) | Kind::Verbatim(_) => element.starts_block,
            // In the block of the turn itself, they move to a block after it.
            Kind::Before(words) | Kind::After(words) => ends || has_m(words, &RETURNS),
            _ => false,
        };
        if needs_feed && self.pace.by_time.is_some() {
            self.say_pace(Element { starts_block: true, number: None, kind: Kind::Empty, ..element.clone() }, false);
            // The next word, or the calling program, then finds the programmed feed.
            if !ends && !matches!(element.kind, Kind::Feed(_)) && self.pace.feed > 0.0 {
                let kind = Kind::Feed(self.pace.feed);
                let said = Element { number: None, starts_block: false, kind, ..element.clone() };
                self.pending.push_back(Ok(Output::Element(said)));
            }
        }
        match &element.kind {
            Kind::Keep(word) if FEED_MODES.contains(word) => {
                self.pace.is_per_minute = *word == "G94";
                self.pace.by_time = None;
            }
            // Modes end with the program.
            Kind::Before(words) | Kind::After(words) if has_m(words, &ENDS) => self.pace.by_time = None,
            Kind::Verbatim(text) => {
                if let Some(counts_turns) = way::counts_turns(text, self.machine) {
                    self.pace.counts_turns = counts_turns;
                }
            }
            _ => {}
        }
    }

    /// Restores the feed mode after the last element. Returns `true` if that was needed.
    pub(super) fn end_pace(&mut self) -> bool {
        let since = self.pace.by_time;
        if let Some(origin) = since {
            self.say_pace(Element { origin, starts_block: true, number: None, kind: Kind::Empty }, false);
        }
        since.is_some()
    }
}
