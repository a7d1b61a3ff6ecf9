//! Calls of the control's cycles: assignment of levels to cycles, and diagnostics at the user's block.

use super::cycles::{Cycle, alarm};
use super::gathered::Call;
use super::gatherer::Gatherer;
use super::level::{Entry, Interpreter};
use super::scope::scope_of;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{Address, ArgumentRange, Block, Body, Word};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Span};

/// A word for cycles only: runs a program up to its first point.
const FIRST: &str = "_CYC_FIRST";

impl Interpreter<'_> {
    /// The cycle of a level that is about to begin; `call` is the place of its call.
    pub(super) fn cycle_of(&self, program: usize, is_modal: bool, call: (FileId, Span)) -> Option<Cycle> {
        let name = self.programs.get(program)?.own.built_in?;
        let place = Place { file: call.0, span: call.1 };
        match self.levels.last().and_then(|level| level.own.cycle) {
            // A drilling cycle at the positions of a pattern cycle.
            Some(outer) if is_modal => Some(Cycle { name, place, ..outer }),
            Some(outer) => Some(outer),
            None => Some(Cycle { name, place, origin: self.channel.outlet.origin }),
        }
    }

    /// The error for a cycle that begins under radius compensation.
    pub(super) fn under_compensation(&self, cycle: Option<Cycle>, span: Span) -> Option<Fault> {
        let name = cycle?.name;
        let is_inside = self.levels.last().is_some_and(|level| level.own.cycle.is_some());
        if is_inside || !self.channel.modal.contour.compensates() {
            return None;
        }
        let message = format!("{name} while radius compensation is on would machine at an offset position");
        Some(fault(Code::BAD_COMPENSATION, span, message, "end it with G40 and a motion in the plane before the cycle"))
    }

    /// The name in the `_CYC_FIRST` of a cycle, which runs a contour up to its start point.
    pub(super) fn contour_of(&self, call: &Call) -> Result<Option<String>, Fault> {
        let Some(level) = self.levels.last().filter(|level| level.own.cycle.is_some() && call.name == FIRST) else {
            return Ok(None);
        };
        let loaded = &self.programs[level.program];
        let arguments = call.arguments.map_or(&[][..], |range| loaded.program.arguments_of(range));
        let Some(&Some(id)) = arguments.first() else { return Ok(None) };
        let name = scope_of(loaded, &self.channel).value(id)?.text();
        Ok(Some(String::from_utf8_lossy(&name).trim().to_ascii_uppercase()))
    }

    /// Restricts a program to the blocks up to the first one that names an axis of the plane.
    pub(super) fn to_first_point(&self, mut entry: Entry) -> Result<Entry, Fault> {
        let program = &self.programs[entry.program].program;
        let whole = program.sections.get(entry.section).map_or(0..0, |section| section.blocks.clone());
        let blocks = entry.part.map_or(whole, |(first, last)| first..last + 1);
        let is_axis = |word: &Word| matches!(word.address, Address::Letter(b'X' | b'Y' | b'Z'));
        let start = blocks.start;
        let moves = |block: &Block| matches!(block.body, Body::Words) && program.words_of(block).iter().any(is_axis);
        let Some(last) = blocks.into_iter().find(|&at| program.blocks.get(at).is_some_and(moves)) else {
            let help =
                "begin the contour with a block that moves to its start point, G0 or G1 with both axes of the plane";
            return Err(fault(Code::CYCLE_ALARM, entry.span, "the contour has no start point", help));
        };
        entry.part = Some((start, last));
        Ok(entry)
    }

    /// Moves a diagnostic to the place that is meaningful to the user.
    pub(super) fn as_seen_by_user(&self, mut finding: Diagnostic) -> Diagnostic {
        let is_inside = |place: Place| {
            let mut programs = self.programs.iter();
            programs.any(|loaded| loaded.own.built_in.is_some() && loaded.program.source.id() == place.file)
        };
        let Some(place) = finding.place else { return finding };
        if let Some(cycle) = self.levels.last().and_then(|level| level.own.cycle) {
            if is_inside(place) {
                finding.place = Some(cycle.place);
            }
            finding.message = format!("{}: {}", cycle.name, finding.message);
        }
        finding
    }

    /// Ends the running cycle, if any: after an error its further execution is invalid.
    pub(super) fn leave_cycle(&mut self) {
        while self.levels.last().is_some_and(|level| level.own.cycle.is_some()) && self.levels.len() > 1 {
            self.leave();
        }
    }
}

impl Gatherer<'_> {
    /// `SETAL(number, "text")`.
    pub(super) fn alarm(&self, range: ArgumentRange, span: Span) -> Result<Fault, Fault> {
        let mut arguments = self.scope.program.arguments_of(range).iter().flatten();
        let number = arguments.next().map(|&id| self.scope.whole(id)).transpose()?.unwrap_or_default();
        let text = arguments.next().map(|&id| self.scope.value(id)).transpose()?;
        let text = text.as_ref().map(|value| value.text().to_vec()).unwrap_or_default();
        Ok(alarm(number, &String::from_utf8_lossy(&text), span))
    }
}
