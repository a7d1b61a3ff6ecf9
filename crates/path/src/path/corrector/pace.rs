//! How long the pieces of moves take that turn rotary axes.
//!
//! Most controls take F for the way of X, Y and Z and let rotary axes keep up; only where nothing else moves, F is theirs. The correction
//! of a block that turns an axis alone moves X, Y, Z by micrometers: F would be the speed on these, and the axis would turn as fast as
//! it can. Such blocks say how long they take instead (G93), and the next one that does not says again that F is a feed (G94). Both stand in the
//! line with which a block begins, so that what acts in that block alone stays with its motion. A short way beside a turn, and what
//! comes up within a block, gets the F that takes the same time.
//!
//! Which way counts: [`crate::path::way`].

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AxisVector, ROTARY_AXES};
use ncfix_machine::snc::{Element, FEED_MODES, FeedUnit, Kind, Manner, Move, Origin, Word, WordValue};

use super::{Active, Corrector};
use crate::path::cut::{MOST_FEED, of_share};
use crate::path::place::{Placer, SHORT_MM};
use crate::path::route::Route;
use crate::path::{Feeds, Output, way};

/// Times that differ by less than this part are the same.
const SAME_SHARE: f64 = 0.05;
/// Ways that differ by less than so many increments are the same: rounding changes them by two.
const SAME_INCREMENTS: f64 = 3.0;
/// The time of a move whose feed the correction may change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pacing {
    /// As the program has it, min, or turns of the spindle.
    minutes: f64,
    /// Nothing but rotary axes moves in the program.
    is_turn: bool,
}

/// M functions that end a program, and that go back to the one that has called.
const ENDS: [f64; 2] = [2.0, 30.0];
const RETURNS: [f64; 2] = [17.0, 99.0];

/// What F counts, in the program and in the output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    is_per_minute: bool,
    /// The program has put rotary axes among those for whose way the feed is (FGROUP): it stays that with a correction.
    pub(super) counts_turns: bool,
    /// Since when the output says how long blocks take, where the program says how fast they are.
    by_time: Option<Origin>,
    /// No piece of the block has been written yet.
    is_fresh: bool,
    /// The last feed of the program itself, 0 for none.
    feed: f64,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { is_per_minute: true, counts_turns: false, by_time: None, is_fresh: false, feed: 0.0 }
    }
}

impl Placer<'_> {
    /// The way between two commands for which a control takes a feed: mm or degrees.
    fn counted(&self, feeds: Feeds, start: &AxisVector, end: &AxisVector) -> f64 {
        way::counted(feeds, self.is_transformed(), [&self.programmed(start), &self.programmed(end)])
    }

    /// Whether a feed is for the way of X, Y, Z between two commands, whatever turns beside it.
    fn takes_feed(&self, feeds: Feeds, start: &AxisVector, end: &AxisVector) -> bool {
        let [start, end] = [start, end].map(|command| self.programmed(command).xyz());
        (feeds != Feeds::OfAll || self.is_transformed()) && (end - start).norm() > SHORT_MM
    }

    /// The time of a whole move at a feed, where the correction may change for which way its feed is.
    pub(super) fn pacing(&self, feeds: Feeds, route: &Route, motion: &Move, feed: f64) -> Option<Pacing> {
        let has_feed = !motion.rapid && feed > 0.0 && !motion.is_inverse_time() && motion.manner == Manner::Path;
        if !self.has_rotary || !has_feed || route.arc().is_some() {
            return None;
        }
        let turns = ROTARY_AXES.into_iter().any(|axis| route.start[axis] != route.end[axis]);
        let minutes = self.counted(feeds, &route.start, &route.end) / feed;
        let is_turn = !self.takes_feed(Feeds::OfLinear, &route.start, &route.end);
        (turns && minutes > 0.0).then_some(Pacing { minutes, is_turn })
    }
}

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The feed of a piece between two commands that takes this share of the time of its move, and what it counts. What
    /// changes between the two waits in the queue then. A step on the spot has no share of the way, and keeps the feed where that is one.
    pub(super) fn feed_of(
        &mut self,
        active: &mut Active,
        [start, end]: [&AxisVector; 2],
        share: f64,
        is_on_the_spot: bool,
    ) -> (f64, FeedUnit) {
        let is_fresh = std::mem::take(&mut self.pace.is_fresh);
        let motion = &active.motion;
        if motion.rapid || motion.feed <= 0.0 {
            return (motion.feed, motion.unit);
        }
        if motion.is_inverse_time() {
            return (of_share(motion.feed, share), FeedUnit::InverseTime);
        }
        let (feed, unit, origin) = (motion.feed, motion.unit, active.origin);
        self.pace.feed = feed;
        let is_begun = self.pace.by_time == Some(origin) && !is_fresh;
        let pacing = active.pacing.filter(|_| !self.pace.counts_turns);
        if let Some(Pacing { minutes, is_turn }) = pacing {
            let way = self.placer.counted(self.options.feeds, start, end);
            let (wanted, least) = (share * minutes * feed, SAME_INCREMENTS * self.placer.increments.linear_mm);
            let is_off = (way - wanted).abs() > least.max(SAME_SHARE * wanted);
            let has_times = self.pace.is_per_minute && self.options.feeds != Feeds::OfLinearOnly;
            if is_off && is_turn && !has_times {
                self.findings.feed_of_another_way(&origin);
                return (feed, unit);
            }
            // What comes behind a first piece that is not off, as a step on the spot, will be.
            let is_taken = is_off || self.placer.takes_feed(self.options.feeds, start, end);
            if is_begun || is_taken && is_turn && is_fresh && has_times {
                if !is_begun && self.pace.by_time.is_none() {
                    self.change_pace(active, true);
                }
                self.pace.by_time = Some(origin);
                return (of_share(minutes.recip(), share), FeedUnit::InverseTime);
            }
            if is_off && !is_on_the_spot && way > 0.0 && wanted > 0.0 && self.leave_pace(active, is_fresh) {
                // To parts of a millionth, but never to none.
                return (((feed * way / wanted * 1e6).ceil() / 1e6).min(MOST_FEED), unit);
            }
        }
        self.leave_pace(active, is_fresh);
        (feed, unit)
    }

    /// From this piece on F is a feed. Only a line with which a block begins can say that; false where it is none.
    fn leave_pace(&mut self, active: &mut Active, is_fresh: bool) -> bool {
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

    /// Says in the line with which the block of a move begins what F is.
    fn change_pace(&mut self, active: &mut Active, is_by_time: bool) {
        let (number, starts_block) = (active.number.take(), std::mem::take(&mut active.starts_block));
        self.say_pace(Element { origin: active.origin, starts_block, number, kind: Kind::Empty }, is_by_time);
    }

    fn say_pace(&mut self, element: Element, is_by_time: bool) {
        self.pace.by_time = is_by_time.then_some(element.origin);
        let kind = Kind::Keep(if is_by_time { "G93" } else { "G94" });
        self.pending.push_back(Ok(Output::Element(Element { kind, ..element })));
    }

    /// Before a block whose words need it F is what the program says it is.
    pub(super) fn keep_pace(&mut self, element: &Element) {
        self.pace.is_fresh |= element.starts_block;
        let has_m = |words: &[Word], codes: &[f64]| {
            words
                .iter()
                .any(|word| word.letter == b'M' && codes.iter().any(|&code| word.value == WordValue::Number(code)))
        };
        let needs_feed = match &element.kind {
            Kind::Feed(_) | Kind::Verbatim(_) => true,
            Kind::Before(words) | Kind::After(words) => has_m(words, &RETURNS),
            _ => false,
        };
        if needs_feed && element.starts_block && self.pace.by_time.is_some() {
            self.say_pace(Element { number: None, kind: Kind::Empty, ..element.clone() }, false);
            // The word that follows, or the program that calls, finds the feed of the program.
            if !matches!(element.kind, Kind::Feed(_)) && self.pace.feed > 0.0 {
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
            // The end of the program is the end of its modes.
            Kind::Before(words) | Kind::After(words) if has_m(words, &ENDS) => self.pace.by_time = None,
            Kind::Verbatim(text) => {
                if let Some(counts_turns) = way::counts_turns(text, self.machine) {
                    self.pace.counts_turns = counts_turns;
                }
            }
            _ => {}
        }
    }

    /// The same behind the last element; whether there was anything to say.
    pub(super) fn end_pace(&mut self) -> bool {
        let since = self.pace.by_time;
        if let Some(origin) = since {
            self.say_pace(Element { origin, starts_block: true, number: None, kind: Kind::Empty }, false);
        }
        since.is_some()
    }
}
