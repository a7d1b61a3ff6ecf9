//! Common data of all cycles: words, position, heights of a hole.

use crate::exec::core::step::{Flat, Step};

/// The words of a cycle definition: lengths in mm, dwells in s, angles in degrees.
#[derive(Clone, Debug, Default)]
pub(in crate::exec::grundig) struct CycleWords(Vec<(u8, u16, f64)>);

impl CycleWords {
    /// Sets a word; index 0 is a bare letter. A later one replaces an earlier one.
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

    /// The value of a bare letter, or 0.
    pub(super) fn value(&self, letter: u8) -> f64 {
        self.get(letter, 0).unwrap_or(0.0)
    }
}

/// Position and settings of a cycle execution.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::exec::grundig) struct At {
    /// Position in the plane, mm.
    pub(in crate::exec::grundig) point: Flat,
    /// Height of the surface, mm.
    pub(in crate::exec::grundig) surface: f64,
    /// Current height of the tool, mm.
    pub(in crate::exec::grundig) height: f64,
    /// Rotation of pockets and slots about the position (B1=), rad.
    pub(in crate::exec::grundig) rotation_rad: f64,
    /// Radius of the tool, mm; 0 if it has none.
    pub(in crate::exec::grundig) tool_radius_mm: f64,
    /// Height above the previous depth at which a peck begins, mm (machine constant).
    pub(in crate::exec::grundig) peck_clearance_mm: f64,
    /// Cutting width of pockets without I, per cent of the tool diameter (machine constant).
    pub(in crate::exec::grundig) engagement_percent: f64,
    /// `true` if the position of a slot is the center of its end arc, `false` if it is the end itself.
    pub(in crate::exec::grundig) slot_from_arc_center: bool,
}

/// Reason why a cycle cannot be executed, with help.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::exec::grundig) struct CycleFault {
    pub(in crate::exec::grundig) message: String,
    pub(in crate::exec::grundig) help: &'static str,
}

pub(super) fn fault(message: impl Into<String>, help: &'static str) -> CycleFault {
    CycleFault { message: message.into(), help }
}

/// The heights of a drilling cycle: first clearance above the surface (Y), depth (Z, negative below the surface), and retraction above the first
/// clearance (B).
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

    /// Moves to the hole at the current height, but not below the first clearance, then down to it.
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
