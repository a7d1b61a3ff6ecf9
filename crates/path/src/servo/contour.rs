//! The distance of the tool from its path in the workpiece, at right angles to the path.
//!
//! A lag along the path does no harm. The nearest point is searched on the part of the path that the set-points passed recently. Its duration is the
//! lag of the axes plus the settling time of their errors, as a path may return to a place later.

use std::collections::VecDeque;

use super::chord::Chord;
use super::plan::SpeedProfile;
use ncfix_base::geometry::Vector;

/// Maximum number of stored chords; older chords are dropped.
const MOST: usize = 4096;

/// The nearest point of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnPath {
    /// The block that it belongs to.
    pub block: u64,
    /// `true` if the block is rapid.
    pub is_rapid: bool,
    /// Vector from the path to the tool, in the workpiece, mm.
    pub off_mm: Vector,
    /// Speed of the set-points at this point, mm/min or degrees/min as the feed.
    pub feed_mm_min: f64,
}

/// A chord that the set-points have passed.
#[derive(Clone, Copy, Debug)]
struct Passed {
    start: Vector,
    along: Vector,
    square: f64,
    /// Time at which its end was passed, s.
    until_s: f64,
    block: u64,
    is_rapid: bool,
    size: f64,
    feed_share: f64,
    profile: SpeedProfile,
}

/// The recent path.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    passed: VecDeque<Passed>,
    /// Search range back in time, s.
    back_s: f64,
}

impl Contour {
    pub(super) fn new(back_s: f64) -> Contour {
        Contour { passed: VecDeque::with_capacity(MOST), back_s }
    }

    pub(super) fn clear(&mut self) {
        self.passed.clear();
    }

    pub(super) fn pass(&mut self, chord: &Chord, profile: &SpeedProfile, until_s: f64) {
        if self.passed.len() >= MOST {
            self.passed.pop_front();
        }
        let along = chord.tips[1] - chord.tips[0];
        self.passed.push_back(Passed {
            start: chord.tips[0],
            along,
            square: along.norm_squared(),
            until_s,
            block: chord.block,
            is_rapid: chord.is_rapid,
            size: chord.size,
            feed_share: chord.feed_share,
            profile: *profile,
        });
    }

    /// The nearest path point to the current tip; `None` without a path.
    pub(super) fn nearest(&mut self, tip: &Vector, now_s: f64) -> Option<OnPath> {
        while self.passed.len() > 1 && self.passed.front().is_some_and(|first| first.until_s < now_s - self.back_s) {
            self.passed.pop_front();
        }
        let mut best: Option<(f64, f64, Vector, &Passed)> = None;
        for passed in &self.passed {
            let from = tip - passed.start;
            let share =
                if passed.square > 0.0 { (from.dot(&passed.along) / passed.square).clamp(0.0, 1.0) } else { 0.0 };
            let off = from - passed.along * share;
            let square = off.norm_squared();
            // If a path retraces itself, the tool is on its way back: the later point is used.
            if best.is_none_or(|(least, ..)| square <= least) {
                best = Some((square, share, off, passed));
            }
        }
        best.map(|(_, share, off_mm, passed)| OnPath {
            block: passed.block,
            is_rapid: passed.is_rapid,
            off_mm,
            feed_mm_min: passed.profile.speed_at(share * passed.size) * passed.feed_share * 60.0,
        })
    }
}
