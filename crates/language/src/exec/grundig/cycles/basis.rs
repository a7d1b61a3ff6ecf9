//! What every cycle works with: its words, its place, the heights of a hole.

use crate::exec::core::step::{Flat, Step};

/// The words with which a cycle was defined: lengths in mm, dwells in s, angles in degrees as programmed.
#[derive(Clone, Debug, Default)]
pub(in crate::exec::grundig) struct CycleWords(Vec<(u8, u16, f64)>);

impl CycleWords {
    /// Takes a word; index 0 for a letter alone. A later one replaces an earlier one.
    pub(in crate::exec::grundig) fn set(&mut self, letter: u8, index: u16, value: f64) {
        match self.0.iter_mut().find(|word| (word.0, word.1) == (letter, index)) {
            Some(word) => word.2 = value,
            None => self.0.push((letter, index, value)),
        }
    }

    /// The value of a word.
    pub(in crate::exec::grundig) fn get(&self, letter: u8, index: u16) -> Option<f64> {
        self.0.iter().find(|word| (word.0, word.1) == (letter, index)).map(|word| word.2)
    }

    /// The value of a letter alone, or 0.
    pub(super) fn value(&self, letter: u8) -> f64 {
        self.get(letter, 0).unwrap_or(0.0)
    }
}

/// Where and with what a cycle is carried out.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::exec::grundig) struct At {
    /// Position in the plane, mm.
    pub(in crate::exec::grundig) point: Flat,
    /// Height of the surface, mm.
    pub(in crate::exec::grundig) surface: f64,
    /// Height at which the tool is, mm.
    pub(in crate::exec::grundig) height: f64,
    /// Turn of pockets and slots about the position (B1=), rad.
    pub(in crate::exec::grundig) rotation_rad: f64,
    /// Radius of the tool, mm; 0 where it has none.
    pub(in crate::exec::grundig) tool_radius_mm: f64,
    /// By how much above the old depth a peck begins again, mm (machine constant).
    pub(in crate::exec::grundig) peck_clearance_mm: f64,
    /// Cutting width of pockets without I, per cent of the tool diameter (machine constant).
    pub(in crate::exec::grundig) engagement_percent: f64,
    /// Whether the position of a slot is the center of the arc at its end, or its end itself.
    pub(in crate::exec::grundig) slot_from_arc_center: bool,
}

/// Why a cycle cannot be carried out: what was found, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::exec::grundig) struct CycleFault {
    pub(in crate::exec::grundig) message: String,
    pub(in crate::exec::grundig) help: &'static str,
}

pub(super) fn fault(message: impl Into<String>, help: &'static str) -> CycleFault {
    CycleFault { message: message.into(), help }
}

/// The heights of a drilling cycle: first clearance above the surface (Y), depth (Z, below it negative), and how far above the first
/// clearance the tool retracts (B).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct HoleHeights {
    pub(super) clearance: f64,
    pub(super) bottom: f64,
    pub(super) retract: f64,
}

impl HoleHeights {
    pub(super) fn of(words: &CycleWords, at: &At) -> Result<HoleHeights, CycleFault> {
        let clearance = at.surface + words.value(b'Y');
        let bottom = at.surface + words.value(b'Z');
        let retract = clearance + words.value(b'B');
        if bottom >= clearance || retract < clearance {
            return Err(fault(
                "the depth (Z) is not below the first clearance (Y), or the retraction (B) is negative",
                "Z is negative into the workpiece, Y and B are distances above it",
            ));
        }
        Ok(HoleHeights { clearance, bottom, retract })
    }

    /// To the hole at the height at which the tool is – not below the first clearance –, then down to that.
    pub(super) fn approach(&self, at: &At, steps: &mut Vec<Step>) {
        if at.height < self.clearance {
            steps.push(Step::rapid_height(self.clearance));
        }
        steps.push(Step::rapid_plane(at.point));
        steps.push(Step::rapid_height(self.clearance));
    }
}

/// A dwell at the bottom.
pub(super) fn dwell(words: &CycleWords, steps: &mut Vec<Step>) {
    let seconds = words.value(b'X');
    if seconds > 0.0 {
        steps.push(Step::Dwell(seconds));
    }
}
