//! Common parts of the milling cycles: infeed levels, rotation about the position, approach and retraction.
//!
//! The control's own clearing path inside a pocket is unknown. Here the tool plunges in the middle and mills loops from inside outwards, so that the
//! last one is the edge. Climb milling (J1, the default) is counter-clockwise inside.

use super::basis::{At, CycleFault, CycleWords, fault};
use crate::exec::core::step::Step;
use crate::exec::core::step::{Feed, Flat};

/// Largest cutting width without remaining material between loops with sharp corners, as a share of the tool diameter: (1 + √½) / 2.
const WIDEST_SHARE: f64 = 0.85;
/// Maximum number of levels or loops; more is an input error.
const MOST: f64 = 10_000.0;

/// Data of a milling cycle.
pub(super) struct Pocket<'a> {
    words: &'a CycleWords,
    at: &'a At,
    /// Heights of the infeeds; the last is the bottom.
    pub(super) levels: Vec<f64>,
    clearance: f64,
    retract: f64,
    /// `true` if loops are clockwise.
    pub(super) clockwise: bool,
}

impl<'a> Pocket<'a> {
    /// Reads the words common to all pockets: Z depth, B clearance, K infeed, J direction, Y3= retraction.
    pub(super) fn new(words: &'a CycleWords, at: &'a At) -> Result<Pocket<'a>, CycleFault> {
        let depth = -words.value(b'Z');
        let clearance = words.value(b'B');
        let retract = words.get(b'Y', 3).unwrap_or(0.0);
        let infeed = words.get(b'K', 0).unwrap_or(depth);
        if depth <= 0.0 || clearance < 0.0 || retract < 0.0 {
            let message = "Z must be below 0, B and Y3= must not be negative";
            return Err(fault(message, "Z is the depth, B the clearance above the surface"));
        }
        if infeed <= 0.0 || depth / infeed > MOST {
            return Err(fault(
                format!("K={infeed} is not a valid infeed for a depth of {depth} mm"),
                "K is the infeed per level",
            ));
        }
        if at.tool_radius_mm <= 0.0 {
            return Err(fault("the tool in the spindle has no radius", "give R in the tool memory"));
        }
        let sense = words.get(b'J', 0).unwrap_or(1.0);
        if sense.abs() != 1.0 {
            return Err(fault(
                format!("J={sense} is not a valid milling direction"),
                "J1 is climb milling, J-1 conventional milling",
            ));
        }
        // A remainder of a billionth is zero.
        let count = (depth / infeed - 1e-9).ceil().max(1.0) as u32;
        let level = |k: u32| at.surface - if k == count { depth } else { infeed * f64::from(k) };
        Ok(Pocket {
            words,
            at,
            levels: (1..=count).map(level).collect(),
            clearance: at.surface + clearance,
            retract: at.surface + clearance + retract,
            clockwise: sense < 0.0,
        })
    }

    /// A point relative to the position, before the rotation by B1=.
    pub(super) fn place(&self, [x, y]: Flat) -> Flat {
        let (sin, cos) = self.at.rotation_rad.sin_cos();
        [self.at.point[0] + x * cos - y * sin, self.at.point[1] + x * sin + y * cos]
    }

    /// The number of steps across a width, each at most the cutting width.
    pub(super) fn loops(&self, across: f64) -> Result<u32, CycleFault> {
        let percent = self.words.get(b'I', 0).unwrap_or(self.at.engagement_percent);
        if !(percent > 0.0 && percent <= 100.0) {
            return Err(fault(
                format!("I={percent} is not a valid cutting width in percent"),
                "write a value up to 100",
            ));
        }
        let width = (percent / 100.0).min(WIDEST_SHARE) * 2.0 * self.at.tool_radius_mm;
        let count = (across / width - 1e-9).ceil().max(1.0);
        if count > MOST || count * self.levels.len() as f64 > MOST {
            return Err(fault("the pocket needs too many loops", "correct I, or use a larger tool"));
        }
        // Within the limit.
        Ok(count as u32)
    }

    /// The whole cycle: `mill` adds the steps of one level, which begin and end at `entry`.
    pub(super) fn steps(&self, entry: Flat, mut mill: impl FnMut(&mut Vec<Step>)) -> Vec<Step> {
        let entry = self.place(entry);
        let mut steps = Vec::new();
        if self.at.height < self.clearance {
            steps.push(Step::rapid_height(self.clearance));
        }
        steps.push(Step::rapid_plane(entry));
        steps.push(Step::rapid_height(self.clearance));
        for &level in &self.levels {
            steps.push(Step::to_height(level, Feed::Plunge));
            mill(&mut steps);
        }
        steps.push(Step::rapid_height(self.retract));
        steps
    }
}
