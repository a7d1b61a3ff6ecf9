//! The register of the control's cycles: programs of the language itself that are built in.
//!
//! A program of the same name among the user's files goes before. What a cycle does, and what is found in it, has the place of the block
//! that calls it: nobody has the text of the cycle at hand.

use super::call::Entry;
use super::gather::Gatherer;
use super::gathered::Call;
use super::level::Level;
use super::{Interpreter, scope_of};
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::sinumerik::{Address, ArgumentRange, Block, Body, Word};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Span};
use ncfix_machine::snc::Origin;

macro_rules! cycles {
    ($($name:literal)*) => {
        /// Names, upper case, and texts of the cycles. Those that begin with an underscore are called by the others only.
        const CYCLES: &[(&str, &[u8])] = &[
            $(($name, include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/cycles/sinumerik/", $name, ".spf")))),*
        ];
    };
}

cycles! {
    "CYCLE61" "CYCLE71" "CYCLE72" "CYCLE76" "CYCLE77" "CYCLE81" "CYCLE82" "CYCLE83" "CYCLE84" "CYCLE840" "CYCLE85" "CYCLE86" "CYCLE87" "CYCLE88"
    "CYCLE89" "CYCLE801" "CYCLE802" "HOLES1" "HOLES2" "LONGHOLE" "POCKET1" "POCKET2" "POCKET3" "POCKET4" "SLOT1" "SLOT2"
    "_CYC_ARC" "_CYC_AREA" "_CYC_BOW" "_CYC_DEPTH" "_CYC_DWELL" "_CYC_FACE" "_CYC_LINE" "_CYC_MILL" "_CYC_OLD" "_CYC_PITCH"
    "_CYC_PLUNGE" "_CYC_POCKET" "_CYC_RING" "_CYC_SPIGOT" "_CYC_STROKE" "_CYC_TAP" "_CYC_TOOL" "_CYC_WALL"
}

/// The text of a built-in cycle and its name.
pub(super) fn source(name: &str) -> Option<(&'static str, &'static [u8])> {
    CYCLES.iter().find(|(known, _)| *known == name).copied()
}

/// A word of the cycles only: runs a program as far as its first point.
const FIRST: &str = "_CYC_FIRST";

/// The alarms that cycles raise with SETAL: number, what is wrong, what to do.
const ALARMS: &[(i64, &str, &str)] = &[
    (61000, "no tool radius is in force", "activate a cutting edge with a radius before the cycle"),
    (61001, "the lead of the thread is wrong", "give a size M3 to M48 of the table (MPIT), or the lead (PIT)"),
    (61002, "the kind of machining is not one of the cycle", "check VARI, CDIR and the tens of VARI"),
    (
        61101,
        "reference plane, retraction plane and depth do not fit",
        "the reference plane lies between the two others",
    ),
    (61102, "no direction of the spindle is given", "give 3 or 4 (behind tapping also 5)"),
    (61103, "the number of positions is 0", "give at least 1"),
    (61104, "the slots meet, or one is no slot", "check radius, length, width and angles"),
    (61105, "the radius of the tool is too large", "a smaller tool, or a larger corner radius"),
    (61107, "the first depth lies on the wrong side of the reference plane", "check FDEP and FDPR"),
];

/// The finding of an alarm; number 0 is for what is not executed, which the text names.
fn alarm(number: i64, text: &str, span: Span) -> Fault {
    if number == 0 {
        let help = "write its moves out, or name the cycle in control.opaque of the machine file if the control shall run it by itself";
        return fault(Code::NOT_SUPPORTED, span, format!("not supported yet: {text}"), help);
    }
    let known = ALARMS.iter().find(|(known, ..)| *known == number);
    let (message, help) = known.map_or(("the cycle cannot run like this", "check its arguments"), |&(_, m, h)| (m, h));
    fault(Code::CYCLE_ALARM, span, format!("alarm {number}, {message}"), help)
}

/// The call of a cycle by a program of the user.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycle {
    name: &'static str,
    /// What its elements carry: the block that calls it or, with MCALL, the block that moved to its place.
    pub(super) origin: Origin,
    /// Where the call is written.
    place: Place,
}

impl Interpreter<'_> {
    /// The cycle to which a level belongs that is about to begin; `call` is where its call is written.
    pub(super) fn cycle_of(&self, program: usize, is_modal: bool, call: (FileId, Span)) -> Option<Cycle> {
        let name = self.programs.get(program)?.built_in?;
        let place = Place { file: call.0, span: call.1 };
        match self.levels.last().and_then(|level| level.cycle) {
            // A drilling cycle at the positions of a pattern cycle.
            Some(outer) if is_modal => Some(Cycle { name, place, ..outer }),
            Some(outer) => Some(outer),
            None => Some(Cycle { name, place, origin: self.channel.outlet.origin }),
        }
    }

    /// What is wrong with a cycle that begins while the program has radius compensation on.
    pub(super) fn under_compensation(&self, cycle: Option<Cycle>, span: Span) -> Option<Fault> {
        let name = cycle?.name;
        let is_inside = self.levels.last().is_some_and(|level| level.cycle.is_some());
        if is_inside || !self.channel.modal.contour.compensates() {
            return None;
        }
        let message = format!("{name} while radius compensation is on would drill or mill beside its place");
        Some(fault(Code::BAD_COMPENSATION, span, message, "end it with G40 and a motion in the plane before the cycle"))
    }

    /// The name that a cycle gives `_CYC_FIRST`, which runs a contour as far as its start point.
    pub(super) fn contour_of(&self, call: &Call) -> Result<Option<String>, Fault> {
        let Some(level) = self.levels.last().filter(|level| level.cycle.is_some() && call.name == FIRST) else {
            return Ok(None);
        };
        let loaded = &self.programs[level.program];
        let arguments = call.arguments.map_or(&[][..], |range| loaded.program.arguments_of(range));
        let Some(&Some(id)) = arguments.first() else { return Ok(None) };
        let name = scope_of(loaded, &self.channel).value(id)?.text();
        Ok(Some(String::from_utf8_lossy(&name).trim().to_ascii_uppercase()))
    }

    /// Only the blocks of a program up to the first that names an axis of the plane.
    pub(super) fn to_first_point(&self, mut entry: Entry) -> Result<Entry, Fault> {
        let program = &self.programs[entry.program].program;
        let blocks = program.sections.get(entry.section).map_or(0..0, |section| section.blocks.clone());
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

    /// A finding with the place that means something to the user.
    pub(super) fn as_seen_by_user(&self, mut finding: Diagnostic) -> Diagnostic {
        let is_inside = |place: Place| {
            let mut programs = self.programs.iter();
            programs.any(|loaded| loaded.built_in.is_some() && loaded.program.source.id() == place.file)
        };
        let Some(place) = finding.place else { return finding };
        if let Some(cycle) = self.levels.last().and_then(|level| level.cycle) {
            if is_inside(place) {
                finding.place = Some(cycle.place);
            }
            finding.message = format!("{}: {}", cycle.name, finding.message);
        }
        finding
    }

    /// Ends the cycle that runs, if one does: behind a fault nothing in it can be right.
    pub(super) fn leave_cycle(&mut self) {
        while self.levels.last().is_some_and(|level| level.cycle.is_some()) && self.levels.len() > 1 {
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

impl Level {
    /// Whether it counts as a program level: a cycle of the control is one, however it is made here.
    pub(super) fn counts(&self, programs: &[super::Loaded]) -> bool {
        let name = programs.get(self.program).and_then(|loaded| loaded.built_in);
        !name.is_some_and(|name| name.starts_with('_'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_file_is_in_the_register() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/cycles/sinumerik");
        let files: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .filter_map(|entry| entry.unwrap().file_name().to_str().unwrap().strip_suffix(".spf").map(str::to_owned))
            .collect();
        let names: BTreeSet<String> = CYCLES.iter().map(|(name, _)| (*name).to_owned()).collect();
        assert_eq!(files, names);
        assert_eq!(names.len(), CYCLES.len(), "a name stands twice");
    }

    #[test]
    fn every_cycle_is_understood_and_begins_with_what_it_does() {
        for (name, text) in CYCLES {
            let source = ncfix_base::source::Source::new(FileId(0), name, text.to_vec()).unwrap();
            let (_, findings) = crate::syntax::sinumerik::parse(&source, ncfix_dialect::sinumerik());
            let shown: Vec<_> = findings
                .iter()
                .map(|f| (f.place.map(|place| source.line_column(place.span.start)), &f.message))
                .collect();
            assert!(shown.is_empty(), "{name}: {shown:?}");
            let text = String::from_utf8(text.to_vec()).unwrap();
            assert!(text.starts_with("; "), "{name}");
            assert!(text.contains(&format!("\nPROC {name}(")), "{name}");
        }
    }
}
