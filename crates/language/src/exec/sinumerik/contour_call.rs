//! CYCLE62: names the contour of the next milling cycle, and contours between two labels.
//!
//! Within a cycle, the name of a contour is that of a subprogram, or `A:B` for the blocks from label A to label B of the user's program. An empty name
//! is the contour of the CYCLE62 before the cycle.

use super::gathered::Call;
use super::level::{Entry, Interpreter};
use super::place::Place;
use super::scope::scope_of;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::source::Span;

/// The cycle that names contours.
pub(super) const CONTOUR: &str = "CYCLE62";

/// Contours for the next milling cycle.
#[derive(Debug, Default)]
pub(super) struct NamedContours {
    names: Vec<String>,
    /// `true` after a cycle has used them: the next CYCLE62 begins anew.
    is_used: bool,
}

/// Maximum number of contours for one cycle: an edge and its islands.
const MOST_CONTOURS: usize = 100;

impl Interpreter<'_> {
    /// `CYCLE62(name, type, label, label)`: type 0 a subprogram, 1 the labels of a named contour, 2 two labels of this program.
    pub(super) fn name_contour(&mut self, call: &Call) -> Result<(), Fault> {
        let Some(level) = self.levels.last() else { return Ok(()) };
        let loaded = &self.programs[level.program];
        let given = call.arguments.map_or(&[][..], |range| loaded.program.arguments_of(range));
        let scope = scope_of(loaded, &self.channel);
        let text = |place: usize| -> Result<String, Fault> {
            let Some(Some(id)) = given.get(place) else { return Ok(String::new()) };
            Ok(String::from_utf8_lossy(&scope.value(*id)?.text()).trim().to_ascii_uppercase())
        };
        let kind = match given.get(1) {
            Some(Some(id)) => scope.number(*id)?,
            _ => 0.0,
        };
        let name = text(0)?;
        let contour = match kind {
            0.0 => name,
            1.0 => format!("E_LAB_A_{name}:E_LAB_E_{name}"),
            2.0 => format!("{}:{}", text(2)?, text(3)?),
            _ => {
                let message = format!("{CONTOUR} of type {kind}: contours in another program");
                let help = "put the contour into this program, or into a subprogram of its own (type 0)";
                return Err(fault(Code::NOT_SUPPORTED, call.span, message, help));
            }
        };
        let contours = &mut self.own.contours;
        if std::mem::take(&mut contours.is_used) {
            contours.names.clear();
        }
        if contours.names.len() < MOST_CONTOURS {
            contours.names.push(contour);
        }
        Ok(())
    }

    fn is_in_cycle(&self) -> bool {
        self.levels.last().is_some_and(|level| level.own.cycle.is_some())
    }

    /// The contour of CYCLE62 for an empty name in a cycle; `None` for other names.
    pub(super) fn named_contour(&mut self, name: &str, span: Span) -> Result<Option<String>, Fault> {
        if !self.is_in_cycle() || !name.trim().is_empty() {
            return Ok(None);
        }
        let contours = &mut self.own.contours;
        contours.is_used = true;
        let [only] = &contours.names[..] else {
            let message =
                format!("{} contours were named by {CONTOUR}, and this cycle needs one", contours.names.len());
            let help = "program one CYCLE62 before the cycle, or give the name of the contour in it";
            return Err(fault(Code::CYCLE_ALARM, span, message, help));
        };
        Ok(Some(only.clone()))
    }

    /// The part of the user's program that a cycle runs as the contour `A:B`; `None` for other names.
    pub(super) fn part_of_contour(&mut self, name: &str, repeats: u32, span: Span) -> Result<Option<Entry>, Fault> {
        let Some((first, last)) = name.split_once(':').filter(|_| self.is_in_cycle()) else { return Ok(None) };
        let user = self.levels.iter().rev().find(|level| level.own.cycle.is_none());
        let (program, section) = user.map_or((0, 0), |level| (level.program, level.part));
        self.programs[program].program.keep_whole();
        let loaded = &self.programs[program];
        let blocks = loaded.program.sections.get(section).map_or(0..0, |section| section.blocks.clone());
        let find = |label: &str, from: usize| {
            let place = Place::of_text(&loaded.program, label.as_bytes())?;
            (from..blocks.end).find(|&at| place.is_at(&loaded.program.blocks[at]))
        };
        let found = find(first, blocks.start).and_then(|start| Some((start, find(last, start)?)));
        let Some(part) = found else {
            let message = format!("there is no contour from label {first} to label {last} in this program");
            return Err(fault(Code::NO_TARGET, span, message, "check the labels and their order"));
        };
        let file = self.levels.last().map_or(0, |level| level.program);
        let file = self.programs[file].program.source.id();
        let arguments = Vec::new();
        Ok(Some(Entry { program, section, arguments, repeats, is_modal: false, part: Some(part), span, file }))
    }
}
