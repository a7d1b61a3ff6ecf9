//! SAVE: the modal state of the caller comes back when a program returns, and the output says so.

use super::channel::Channel;
use super::modal::Modal;
use super::setup;
use crate::exec::core::fault::fault;
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::{AxisSet, AxisVector, Plane};
use ncfix_dialect::{CodeTable, Effect};
use ncfix_machine::snc::{FrameKind, FrameStatement, FrameWords, Kind};

/// Codes that are active when the control starts, by group (Sinumerik MD20150), where the output passes them on.
const INITIAL: &[&str] = &[
    "STARTFIFO",
    "G17",
    "G40",
    "G60",
    "G601",
    "G94",
    "CFC",
    "NORM",
    "G450",
    "BNAT",
    "ENAT",
    "BRISK",
    "CUT2D",
    "CDOF",
    "FFWOF",
    "ORIWKS",
    "RMI",
    "ORIC",
    "WALIMON",
    "DIAMOF",
    "COMPOF",
    "FTOCOF",
    "OSOF",
    "SPOF",
    "PDELAYOF",
    "FNORM",
    "SPIF1",
    "CPRECOF",
    "CUTCONOF",
    "LFOF",
    "TCOABS",
    "G140",
    "G340",
    "SPATH",
    "G290",
    "G460",
    "CP",
    "FENDNORM",
    "DYNNORM",
    "RTLION",
    "ORIVECT",
    "PAROTOF",
    "TOROTOF",
];

/// Groups whose codes hold for one block only, and those that the output always writes as G90 and in mm.
const NOT_MODAL: &[u8] = &[0, 2, 3, 9, 11, 13, 14];

/// `TRANS` alone: no programmable frame.
const NO_FRAME: FrameStatement = FrameStatement {
    kind: FrameKind::Translate,
    additive: false,
    values: AxisVector::ZERO,
    named: AxisSet::EMPTY,
    in_plane_rad: None,
};

/// A programmable frame of more statements cannot be brought back.
const MAX_STATEMENTS: usize = 1000;

/// What the output has said of the modal state.
#[derive(Clone, Debug)]
pub(super) struct Stated {
    /// Codes in force by group.
    codes: Vec<(u8, &'static str)>,
    /// `G500`, `G54` …
    offset: String,
    /// The assignment to the programmable frame that its statements build on, where there was one.
    assigned: Option<Vec<u8>>,
    /// The statements that make up the programmable frame, each with its working plane.
    frame: Vec<(FrameStatement, Plane)>,
}

impl Stated {
    pub(super) fn new(offset: &str) -> Stated {
        Stated { codes: Vec::new(), offset: offset.to_owned(), assigned: None, frame: Vec::new() }
    }

    /// The settable frame in force: `G54`, or the assignment to it.
    pub(super) fn offset(&self) -> &str {
        &self.offset
    }

    /// Notes an assignment to the settable frame in force.
    pub(super) fn assign_settable(&mut self, text: &str) {
        text.clone_into(&mut self.offset);
    }

    /// Notes an assignment to the programmable frame.
    pub(super) fn assign_programmable(&mut self, text: &str) {
        self.frame.clear();
        self.assigned = Some(text.as_bytes().to_vec());
    }

    /// The code of a group that was programmed last.
    pub(super) fn code(&self, group: u8) -> Option<&'static str> {
        self.codes.iter().find(|(known, _)| *known == group).map(|&(_, word)| word)
    }

    fn set_code(&mut self, group: u8, word: &'static str) {
        match self.codes.iter_mut().find(|(known, _)| *known == group) {
            Some(entry) => entry.1 = word,
            None => self.codes.push((group, word)),
        }
    }

    fn add_frame(&mut self, words: &FrameWords, plane: Plane) {
        let new = match words {
            FrameWords::Settable(name) => return self.offset.clone_from(name),
            FrameWords::Statement(statement) => *statement,
        };
        let is_part = matches!(new.kind, FrameKind::Coarse | FrameKind::Fine);
        if !new.additive && !is_part {
            self.frame.clear();
            self.assigned = None;
        }
        let has_room = self.frame.len() < MAX_STATEMENTS;
        match self.frame.last_mut() {
            // Shifts in a row are one: a loop of ATRANS shall not grow without end.
            Some((last, _)) if new.additive && [last.kind, new.kind] == [FrameKind::Translate; 2] => {
                last.values = last.values + new.values;
                last.named = last.named.iter().chain(new.named.iter()).collect();
            }
            None if !is_part && self.assigned.is_none() => {
                self.frame.push((FrameStatement { additive: false, ..new }, plane))
            }
            _ if has_room => self.frame.push((new, plane)),
            _ => {}
        }
    }
}

/// The code of a group that is active when the control starts.
pub(super) fn initial(table: &'static CodeTable, group: u8) -> Option<&'static str> {
    INITIAL.iter().copied().find(|word| table.word(word).is_some_and(|row| row.group == group))
}

/// Notes the codes that the machine file says are active at the start.
pub(super) fn note_initial_codes(channel: &mut Channel<'_>) {
    let machine = channel.machine;
    let rows = machine.control.initial_codes.iter().filter_map(|word| channel.codes.word(&word.to_ascii_uppercase()));
    for row in rows.filter(|row| row.effect == Effect::Keep && !NOT_MODAL.contains(&row.group)) {
        channel.modal.stated.set_code(row.group, row.name);
    }
}

/// Passes a code on and notes that it is in force.
pub(super) fn keep(channel: &mut Channel<'_>, word: &'static str) {
    if let Some(row) = channel.codes.word(word).filter(|row| !NOT_MODAL.contains(&row.group)) {
        channel.modal.stated.set_code(row.group, word);
    }
    channel.push(Kind::Keep(word));
}

/// Passes a zero offset or frame on and notes that it is in force.
pub(super) fn push_frame(channel: &mut Channel<'_>, words: FrameWords) {
    channel.modal.stated.add_frame(&words, channel.modal.plane);
    channel.push(Kind::Frame(words));
}

/// Brings the modal state of a caller back: codes, plane, units, frames. Positions, tool and feed stay as they are.
pub(super) fn restore(channel: &mut Channel<'_>, saved: Modal) {
    let left = std::mem::replace(&mut channel.modal, saved);
    channel.modal.keep_position_of(&left);
    let codes = left.stated.codes.iter().filter_map(|&(group, word)| {
        let before = channel.modal.stated.code(group).or_else(|| initial(channel.codes, group))?;
        (before != word).then_some(before)
    });
    let codes: Vec<&'static str> = codes.collect();
    if !codes.is_empty() {
        channel.outlet.begin_line();
        codes.into_iter().for_each(|word| channel.push(Kind::Keep(word)));
    }
    if left.stated.offset != channel.modal.stated.offset {
        channel.outlet.begin_line();
        channel.push(Kind::Frame(FrameWords::Settable(channel.modal.stated.offset.clone())));
    }
    let (before, after) = (&left.stated.frame, channel.modal.stated.frame.clone());
    let assigned = channel.modal.stated.assigned.clone();
    let is_other = *before != after || left.stated.assigned != assigned;
    let is_same_settable = left.settable == channel.modal.settable;
    let is_said = (is_other || left.programmable == channel.modal.programmable)
        && (is_same_settable || left.stated.offset != channel.modal.stated.offset);
    let is_whole = after.len() < MAX_STATEMENTS && before.len() < MAX_STATEMENTS;
    let in_plane = |(statement, plane): &(FrameStatement, Plane)| {
        let needs_plane = statement.in_plane_rad.is_some() || statement.kind == FrameKind::SolidAngles;
        !needs_plane || *plane == channel.modal.plane
    };
    if !is_said || !is_whole || !after.iter().all(in_plane) || left.base != channel.modal.base {
        let message = "SAVE of the program that ends here brings back a frame that cannot be written as statements";
        let help = "program the frame anew behind the call, with TRANS, ROT, SCALE, MIRROR in the plane in force";
        channel.outlet.warnings.push(fault(Code::NOT_SUPPORTED, channel.outlet.origin.span, message, help));
    } else if is_other {
        if let Some(text) = assigned {
            channel.outlet.begin_line();
            channel.push(Kind::Verbatim(text));
        } else if after.is_empty() {
            channel.outlet.begin_line();
            channel.push(Kind::Frame(FrameWords::Statement(NO_FRAME)));
        }
        for (statement, _) in after {
            channel.outlet.begin_line();
            channel.push(Kind::Frame(FrameWords::Statement(statement)));
        }
    }
    setup::refresh_setup(channel);
}
