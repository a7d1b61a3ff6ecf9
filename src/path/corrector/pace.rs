//! How long the pieces of moves take that turn rotary axes.
//!
//! Most controls take F for the way of X, Y and Z and let rotary axes keep up; only where nothing else moves, F is theirs. The correction
//! of a block that turns an axis alone moves X, Y, Z by micrometers: F would be the speed on these, and the axis would turn as fast as
//! it can. Such pieces say how long they take instead (G93), and what follows says again that F is a feed (G94).
//!
//! Sources: LinuxCNC, G code overview, "Feed rate"; Sinumerik, programming manual, FGROUP; Fanuc, operator's manual, G01 with linear and
//! rotary axes: `G91 G1 X20. C40. F300.` takes √(20² + 40²) / 300 min.

use crate::diagnostic::Diagnostic;
use crate::geometry::{Axis, AxisVector, ROTARY_AXES};
use crate::snc::{BlockNumber, Element, Kind, Manner, Move, Origin};

use super::{Active, Corrector};
use crate::path::cut::of_share;
use crate::path::place::{Placer, SHORT_MM};
use crate::path::route::Route;
use crate::path::{Feeds, Output};

/// Times that differ by less than this part are the same.
const SAME_SHARE: f64 = 0.05;
/// Ways that differ by less than so many increments are the same: rounding changes them by two.
const SAME_INCREMENTS: f64 = 3.0;
/// Codes that say what F counts. Those of the constant cutting speed among them: what they mean besides is left alone.
const FEED_MODES: [&str; 13] =
    ["G93", "G94", "G95", "G96", "G97", "G961", "G962", "G971", "G972", "G973", "G942", "G952", "G931"];

/// What F counts, in the program and in the output.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    is_per_minute: bool,
    /// The program has put rotary axes among those for whose way the feed is (FGROUP): it stays that with a correction.
    counts_turns: bool,
    /// Since when the output says how long blocks take, where the program says how fast they are.
    by_time: Option<Origin>,
}

impl Default for Pace {
    fn default() -> Self {
        Pace { is_per_minute: true, counts_turns: false, by_time: None }
    }
}

impl Placer<'_> {
    /// The way between two commands for which a control takes a feed: mm or degrees.
    fn counted(&self, feeds: Feeds, start: &AxisVector, end: &AxisVector) -> f64 {
        let (start, end) = (self.programmed(start), self.programmed(end));
        let linear_mm = (end.xyz() - start.xyz()).norm();
        let turned = ROTARY_AXES.map(|axis| (end[axis] - start[axis]).to_degrees());
        let turned_deg = turned.iter().map(|turn| turn * turn).sum::<f64>().sqrt();
        match feeds {
            Feeds::OfAll if !self.is_transformed() => linear_mm.hypot(turned_deg),
            _ if linear_mm > SHORT_MM => linear_mm,
            _ => turned_deg,
        }
    }

    /// The time of a whole move at a feed, min, where the correction may change for which way its feed is.
    pub(super) fn minutes(&self, feeds: Feeds, route: &Route, motion: &Move, feed: f64) -> Option<f64> {
        let has_feed = !motion.rapid && feed > 0.0 && !motion.inverse_time && motion.manner == Manner::Path;
        if !self.has_rotary || !has_feed || route.arc().is_some() {
            return None;
        }
        let turns = ROTARY_AXES.into_iter().any(|axis| route.start[axis] != route.end[axis]);
        let minutes = self.counted(feeds, &route.start, &route.end) / feed;
        (turns && minutes > 0.0).then_some(minutes)
    }
}

impl<I> Corrector<'_, I>
where
    I: Iterator<Item = Result<Element, Diagnostic>>,
{
    /// The feed of a piece between two commands that takes this share of the time of its move, and whether it is the reciprocal of a time. What
    /// changes between the two waits in the queue then.
    pub(super) fn feed_of(&mut self, active: &mut Active, [start, end]: [&AxisVector; 2], share: f64) -> (f64, bool) {
        let motion = &active.motion;
        if motion.inverse_time {
            return (of_share(motion.feed, share), true);
        }
        let minutes = active.minutes.filter(|_| !self.pace.counts_turns);
        let is_by_time = minutes.is_some_and(|minutes| {
            let way = self.placer.counted(self.options.feeds, start, end);
            let (wanted, least) = (share * minutes * motion.feed, SAME_INCREMENTS * self.placer.increments.linear_mm);
            let is_off = (way - wanted).abs() > least.max(SAME_SHARE * wanted);
            // A block that has begun so goes on so.
            let is_begun = self.pace.by_time.is_some_and(|since| since == active.origin);
            is_off || is_begun && way > 0.0
        });
        if is_by_time && (!self.pace.is_per_minute || self.options.feeds == Feeds::OfLinearOnly) {
            self.findings.feed_of_another_way(&active.origin);
            return (motion.feed, false);
        }
        let is_free = motion.rapid || motion.feed <= 0.0;
        if is_by_time != self.pace.by_time.is_some() && !is_free {
            let number = active.number.take().filter(|_| std::mem::take(&mut active.starts_block));
            self.change_pace(active.origin, number, is_by_time);
        }
        match minutes.filter(|_| is_by_time) {
            Some(minutes) => (of_share(minutes.recip(), share), true),
            None => (active.motion.feed, false),
        }
    }

    fn change_pace(&mut self, origin: Origin, number: Option<BlockNumber>, is_by_time: bool) {
        self.pace.by_time = is_by_time.then_some(origin);
        let kind = Kind::Keep(if is_by_time { "G93" } else { "G94" });
        self.pending.push_back(Ok(Output::Element(Element { origin, starts_block: true, number, kind })));
    }

    /// Before a block without a move F is what the program says it is.
    pub(super) fn keep_pace(&mut self, element: &Element) {
        if self.pace.by_time.is_some() && element.starts_block && !matches!(element.kind, Kind::Move(_)) {
            self.change_pace(element.origin, None, false);
        }
        match &element.kind {
            Kind::Keep(word) if FEED_MODES.contains(word) => self.pace.is_per_minute = *word == "G94",
            Kind::Verbatim(text) => {
                if let Some(counts_turns) = self.counts_turns(text) {
                    self.pace.counts_turns = counts_turns;
                }
            }
            _ => {}
        }
    }

    /// Whether words put axes that turn, or that nobody knows, among those for whose way the feed is; `None` where they do not say.
    fn counts_turns(&self, words: &[u8]) -> Option<bool> {
        let words = String::from_utf8_lossy(words).to_ascii_uppercase();
        let (axes, _) = words.split_once("FGROUP(")?.1.split_once(')')?;
        let by_letter = |name: &str| name.bytes().next().filter(|_| name.len() == 1).and_then(Axis::from_letter);
        let turns =
            |name: &str| self.machine.axis_named(name).or_else(|| by_letter(name)).is_none_or(|axis| axis.is_rotary());
        Some(axes.split(',').map(str::trim).filter(|name| !name.is_empty()).any(turns))
    }

    /// The same behind the last element; whether there was anything to say.
    pub(super) fn end_pace(&mut self) -> bool {
        let since = self.pace.by_time;
        if let Some(origin) = since {
            self.change_pace(origin, None, false);
        }
        since.is_some()
    }
}
