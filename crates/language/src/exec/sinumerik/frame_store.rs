//! The frames of the control that a program reads and writes: settable, base, programmable, and what they add up to.

use std::collections::BTreeMap;

use super::expression::Scope;
use super::value::Value;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{ArgumentRange, ExprId};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{Frame, FrameParts, RotationOrder};
use ncfix_base::source::Span;
use ncfix_machine::machine::Machine;

/// Settable frames: G500, G54 to G57, G505 to G599.
const SETTABLE: i64 = 100;
/// Base frames of the channel and of the control, 16 each.
pub(super) const BASES: i64 = 16;

/// Frames that the run has written.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameStore {
    /// By number: 0 for G500, 1 for G54, 5 for G505.
    settable: BTreeMap<i64, FrameParts>,
    /// Base frames in the data of the control; they act when a settable frame is selected next.
    stored_base: BTreeMap<i64, FrameParts>,
    /// Base frames in force: those of the control, then those of the channel from number 16 on.
    active_base: BTreeMap<i64, FrameParts>,
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
    /// A system frame such as `$P_SETFRAME`, of which only the one that changes nothing is known.
    System,
}

/// A name, how many numbers select one of its frames, and the frame of a number.
type Row = (&'static str, i64, fn(i64) -> FrameName);

const NAMES: &[Row] = &[
    ("$P_UIFR", SETTABLE, FrameName::Settable),
    ("$P_NCBFR", BASES, FrameName::StoredBase),
    ("$P_CHBFR", BASES, |number| FrameName::StoredBase(number + BASES)),
    ("$P_UBFR", 0, |_| FrameName::StoredBase(BASES)),
    ("$P_NCBFRAME", BASES, FrameName::Base),
    ("$P_CHBFRAME", BASES, |number| FrameName::Base(number + BASES)),
    ("$P_BFRAME", 0, |_| FrameName::Base(BASES)),
    ("$P_IFRAME", 0, |_| FrameName::ActiveSettable),
    ("$P_PFRAME", 0, |_| FrameName::Programmable),
    ("$P_ACTBFRAME", 0, |_| FrameName::AllBases),
    ("$P_ACTFRAME", 0, |_| FrameName::All),
    ("$P_PARTFRAME", 0, |_| FrameName::System),
    ("$P_SETFRAME", 0, |_| FrameName::System),
    ("$P_EXTFRAME", 0, |_| FrameName::System),
    ("$P_TOOLFRAME", 0, |_| FrameName::System),
    ("$P_WPFRAME", 0, |_| FrameName::System),
    ("$P_TRAFRAME", 0, |_| FrameName::System),
    ("$P_CYCFRAME", 0, |_| FrameName::System),
];

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
    /// A settable frame; `None` where it has no value.
    pub(super) fn settable(&self, machine: &Machine, number: i64) -> Option<FrameParts> {
        let written = self.settable.get(&number).copied();
        let known = written.or_else(|| machine.zero_offsets.get(&settable_code(number)).copied());
        known.or_else(|| (number == 0).then(FrameParts::default))
    }

    /// With the base frames that the control has when a program starts.
    pub(super) fn new(machine: &Machine) -> FrameStore {
        let bases = &machine.base_frames;
        FrameStore { settable: BTreeMap::new(), stored_base: bases.clone(), active_base: bases.clone() }
    }

    /// Settable frames that were written, by number.
    pub(super) fn written_settable(&self) -> impl Iterator<Item = (i64, FrameParts)> + '_ {
        self.settable.iter().map(|(&number, &parts)| (number, parts))
    }

    /// Base frames in the data of the control.
    pub(super) fn written_bases(&self) -> impl Iterator<Item = (i64, FrameParts)> + '_ {
        self.stored_base.iter().map(|(&number, &parts)| (number, parts))
    }

    /// Sets a settable frame; it acts when it is selected next.
    pub(super) fn set_settable(&mut self, number: i64, parts: FrameParts) {
        self.settable.insert(number, parts);
    }

    /// Sets a base frame in the data of the control.
    pub(super) fn set_stored_base(&mut self, number: i64, parts: FrameParts) {
        self.stored_base.insert(number, parts);
    }

    /// Sets a base frame in force.
    pub(super) fn set_base(&mut self, number: i64, parts: FrameParts) {
        self.stored_base.insert(number, parts);
        self.active_base.insert(number, parts);
    }

    /// Puts the base frames of the data in force, as a settable frame does that is selected.
    pub(super) fn activate_bases(&mut self) {
        self.active_base.clone_from(&self.stored_base);
    }

    /// All base frames in force; `None` where one cannot be undone.
    pub(super) fn base(&self, order: RotationOrder) -> Option<Frame> {
        self.active_base.values().try_fold(Frame::identity(), |all, parts| Some(all.compose(&parts.frame(order)?)))
    }
}

impl Scope<'_> {
    /// The frame of the control that a name and its indices mean; `None` where it is none.
    pub(super) fn frame_name(
        &self,
        name: &str,
        range: Option<ArgumentRange>,
        span: Span,
    ) -> Result<Option<FrameName>, Fault> {
        let Some(&(_, count, make)) = NAMES.iter().find(|(known, ..)| *known == name) else { return Ok(None) };
        if count == 0 {
            return Ok(Some(make(0)));
        }
        let first = range.and_then(|range| self.program.arguments_of(range).first().copied().flatten());
        let missing = || {
            let message = format!("{name} needs the number of the frame");
            fault(Code::BAD_INDEX, span, message, format!("write {name}[n] with n from 0 to {}", count - 1))
        };
        let number = self.whole(first.ok_or_else(missing)?)?;
        if !(0..count).contains(&number) {
            let message = format!("there is no {name}[{number}]");
            return Err(fault(Code::BAD_INDEX, span, message, format!("its numbers run from 0 to {}", count - 1)));
        }
        Ok(Some(make(number)))
    }

    /// A frame of the control.
    pub(super) fn frame(&self, name: FrameName, span: Span) -> Result<FrameParts, Fault> {
        let frames = &self.system.frames;
        let of = |frame: &Frame| {
            FrameParts::of(frame, self.order()).ok_or_else(|| {
                let message = "this frame has no components: it turns inside different factors";
                fault(Code::NOT_COMPUTABLE, span, message, "scale all axes alike, or turn before scaling")
            })
        };
        match name {
            FrameName::Settable(number) => match frames.settable(self.machine, number) {
                Some(parts) => Ok(parts),
                None if self.system.strict => Err(super::frames::no_offset(&settable_code(number), span)),
                None => Ok(FrameParts::default()),
            },
            FrameName::StoredBase(number) => Ok(frames.stored_base.get(&number).copied().unwrap_or_default()),
            FrameName::Base(number) => Ok(frames.active_base.get(&number).copied().unwrap_or_default()),
            FrameName::System => Ok(FrameParts::default()),
            FrameName::ActiveSettable => of(&self.modal.settable),
            FrameName::Programmable => of(&self.modal.programmable),
            FrameName::AllBases => of(&self.modal.base),
            FrameName::All => of(&self.modal.frame()),
        }
    }

    /// Reads a frame of the control or a component of it.
    pub(super) fn read_frame(&self, name: FrameName, range: Option<ArgumentRange>, id: ExprId) -> Result<Value, Fault> {
        let span = self.program.expr(id).span;
        let parts = self.frame(name, span)?;
        match range.map(|range| self.component(range)).transpose()?.flatten() {
            Some((axis, component, _)) => self.get_component(&parts, axis, component, span),
            None => Ok(Value::Frame(Box::new(parts))),
        }
    }
}
