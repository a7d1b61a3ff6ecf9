//! The frames of the control that a program reads and writes: settable, base, programmable, and their product.

use ncfix_base::geometry::Axis;
use ncfix_base::geometry::Plane;
use ncfix_base::geometry::Vector;
use ncfix_base::geometry::about;
use ncfix_base::geometry::by_solid_angles;
use ncfix_machine::machine::Control;
use ncfix_machine::snc::FrameKind;
use ncfix_machine::snc::{FrameStatement, Origin, WrittenZeros};
use std::collections::BTreeMap;

use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::growing_offsets;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Frame, FrameParts, RotationOrder};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;

/// Base frames of the channel and of the control, 16 each.
pub(super) const BASES: i64 = 16;

/// Frames written by the run.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameStore {
    /// By number: 0 for G500, 1 for G54, 5 for G505.
    pub(super) settable: BTreeMap<i64, FrameParts>,
    /// Values of written settable frames that were used.
    pub(super) zeros: WrittenZeros,
    /// Base frames in the data of the control; they take effect at the next selection of a settable frame.
    pub(super) stored_base: BTreeMap<i64, FrameParts>,
    /// Active base frames: those of the control, then those of the channel from number 16 on.
    pub(super) active_base: BTreeMap<i64, FrameParts>,
    /// Settable frames to which the program has added something before it has set them, with the first place.
    growing: BTreeMap<i64, Origin>,
}

/// A frame of the control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameName {
    /// `$P_UIFR[n]`
    Settable(i64),
    /// `$P_NCBFR[n]`, `$P_CHBFR[n]`
    StoredBase(i64),
    /// `$P_NCBFRAME[n]`, `$P_CHBFRAME[n]`
    Base(i64),
    /// `$P_IFRAME`
    ActiveSettable,
    /// `$P_PFRAME`
    Programmable,
    /// `$P_ACTBFRAME`: all base frames.
    AllBases,
    /// `$P_ACTFRAME`: all frames.
    All,
    /// A system frame such as `$P_SETFRAME`; only the identity is supported.
    System,
}

/// The number of a settable frame by its code, `G54`.
pub(super) fn settable_number(code: &str) -> Option<i64> {
    match code.strip_prefix('G')?.parse::<i64>().ok()? {
        500 => Some(0),
        number @ 54..=57 => Some(number - 53),
        number @ 505..=599 => Some(number - 500),
        _ => None,
    }
}

/// The code of a settable frame by its number.
pub(super) fn settable_code(number: i64) -> String {
    format!("G{}", if (1..5).contains(&number) { number + 53 } else { number + 500 })
}

impl FrameStore {
    /// A settable frame; `None` if it has no value.
    pub(super) fn settable(&self, machine: &Machine, number: i64) -> Option<FrameParts> {
        let written = self.settable.get(&number).copied();
        let known = written.or_else(|| machine.zero_offsets.get(&settable_code(number)).copied());
        known.or_else(|| (number == 0).then(FrameParts::default))
    }

    /// The base frames of the control at the start of a program.
    pub(super) fn new(machine: &Machine) -> FrameStore {
        let bases = &machine.base_frames;
        FrameStore { stored_base: bases.clone(), active_base: bases.clone(), ..FrameStore::default() }
    }

    /// Settable frames that were written, by number.
    pub(super) fn written_settable(&self) -> impl Iterator<Item = (i64, FrameParts)> + '_ {
        self.settable.iter().map(|(&number, &parts)| (number, parts))
    }

    /// Base frames in the data of the control.
    pub(super) fn written_bases(&self) -> impl Iterator<Item = (i64, FrameParts)> + '_ {
        self.stored_base.iter().map(|(&number, &parts)| (number, parts))
    }

    /// Sets a settable frame; it takes effect at its next selection.
    pub(super) fn set_settable(&mut self, number: i64, parts: FrameParts) {
        self.settable.insert(number, parts);
    }

    /// Notes that a settable frame is about to be changed by a step.
    pub(super) fn grow(&mut self, number: i64, origin: Origin) {
        if !self.settable.contains_key(&number) {
            self.growing.entry(number).or_insert(origin);
        }
    }

    /// The warnings for settable frames to which the program has added something.
    pub(super) fn growing(&self, machine: &Machine) -> Vec<Fault> {
        let grown = |(number, origin): (&i64, &Origin)| {
            let words = settable_code(*number);
            let before = machine.zero_offsets.get(&words).copied().unwrap_or_default();
            growing_offsets::grown(&words, *origin, [&before, self.settable.get(number)?], (machine.axis_set(), true))
        };
        self.growing.iter().filter_map(grown).collect()
    }

    /// Sets a base frame in the data of the control.
    pub(super) fn set_stored_base(&mut self, number: i64, parts: FrameParts) {
        self.stored_base.insert(number, parts);
    }

    /// Sets an active base frame.
    pub(super) fn set_base(&mut self, number: i64, parts: FrameParts) {
        self.stored_base.insert(number, parts);
        self.active_base.insert(number, parts);
    }

    /// Activates the stored base frames, as the selection of a settable frame does.
    pub(super) fn activate_bases(&mut self) {
        self.active_base.clone_from(&self.stored_base);
    }

    /// The product of all active base frames; `None` if one is not invertible.
    pub(super) fn base(&self, order: RotationOrder) -> Option<Frame> {
        self.active_base.values().try_fold(Frame::identity(), |all, parts| Some(all.compose(&parts.frame(order)?)))
    }
}

/// The frame of a single statement; `None` if it is not invertible.
pub(super) fn frame_of(statement: &FrameStatement, plane: Plane, control: &Control) -> Option<Frame> {
    let values = &statement.values;
    let xyz = [values[Axis::X], values[Axis::Y], values[Axis::Z]];
    let is_sound = values.0.iter().chain(&statement.in_plane_rad).all(|value| value.is_finite() && value.abs() < 1e9);
    if !is_sound {
        return None;
    }
    match statement.kind {
        FrameKind::Translate | FrameKind::Coarse | FrameKind::Fine => Some(Frame::translation(*values)),
        FrameKind::Rotate => Some(Frame::rotation(match statement.in_plane_rad {
            Some(angle_rad) => {
                let applicate = plane.axes()[2];
                about(&Vector::ith(applicate.slot(), 1.0), angle_rad)
            }
            None => control.rotation_order.matrix(xyz),
        })),
        FrameKind::SolidAngles => {
            let named = |axis: Axis| statement.named.contains(axis);
            let pair = match (named(Axis::X), named(Axis::Y), named(Axis::Z)) {
                (true, true, true) => return None,
                (_, true, true) => Axis::Y,
                (true, _, true) => Axis::Z,
                (true, _, _) => Axis::X,
                (_, true, _) => Axis::Y,
                _ => Axis::Z,
            };
            let angle = |steps: usize| xyz[(pair.slot() + steps) % 3];
            by_solid_angles(pair, angle(0), angle(1)).map(Frame::rotation)
        }
        FrameKind::Scale => {
            let factor = |axis: Axis| if statement.named.contains(axis) { values[axis] } else { 1.0 };
            let factors = [Axis::X, Axis::Y, Axis::Z].map(factor);
            let is_positive = factors.iter().all(|factor| (1e-6..1e6).contains(factor));
            if is_positive { Frame::scale(factors.into()) } else { None }
        }
        FrameKind::Mirror => {
            let is_on = |axis: &Axis| control.mirror_toggles || values[*axis] != 0.0;
            Some(Frame::mirror(statement.named.iter().filter(is_on).collect()))
        }
    }
}

/// The error for a settable frame without value.
pub(super) fn no_offset(name: &str, span: Span) -> Fault {
    let help = format!("add [zero_offset.{name}] there or in a file given with --setup");
    fault(Code::NO_OFFSET, span, format!("{name} has no value in the machine file"), help)
}
