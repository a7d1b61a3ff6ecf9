//! The modal state that the output has stated.

use std::sync::LazyLock;

use crate::exec::core::modal::CodesInForce;
use ncfix_base::geometry::AxisSet;
use ncfix_base::geometry::AxisVector;
use ncfix_base::geometry::Plane;
use ncfix_machine::snc::FrameKind;
use ncfix_machine::snc::FrameStatement;
use ncfix_machine::snc::FrameWords;

/// Codes that are active when the control starts (Sinumerik MD20150) and that the output passes through, each with its group.
static INITIAL: LazyLock<Vec<(u8, &'static str)>> = LazyLock::new(|| {
    let table = ncfix_dialect::sinumerik().codes();
    STARTING.iter().filter_map(|&word| Some((table.word(word)?.group, word))).collect()
});
const STARTING: &[&str] = &[
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

/// Groups of non-modal codes, and groups that the output always writes as G90 and in mm.
pub(super) const NOT_MODAL: &[u8] = &[0, 2, 3, 9, 11, 13, 14];

/// A bare `TRANS`: no programmable frame.
pub(super) const NO_FRAME: FrameStatement = FrameStatement {
    kind: FrameKind::Translate,
    additive: false,
    values: AxisVector::ZERO,
    named: AxisSet::EMPTY,
    in_plane_rad: None,
};

/// Maximum number of statements of a programmable frame that can be restored.
pub(super) const MAX_STATEMENTS: usize = 1000;

/// The modal state that the output has stated.
#[derive(Clone, Debug)]
pub(super) struct Stated {
    /// Codes by group of the code table.
    pub(super) codes: CodesInForce<u8, &'static str>,
    /// `G500`, `G54` …
    pub(super) offset: String,
    /// The assignment to the programmable frame on which its statements build, if any.
    pub(super) assigned: Option<Vec<u8>>,
    /// The statements of the programmable frame, each with its working plane.
    pub(super) frame: Vec<(FrameStatement, Plane)>,
}

impl Stated {
    pub(super) fn new(offset: &str) -> Stated {
        Stated { codes: CodesInForce::new(&INITIAL), offset: offset.to_owned(), assigned: None, frame: Vec::new() }
    }

    /// The active settable frame: `G54`, or the assignment to it.
    pub(super) fn offset(&self) -> &str {
        &self.offset
    }

    /// Records an assignment to the active settable frame.
    pub(super) fn assign_settable(&mut self, text: &str) {
        text.clone_into(&mut self.offset);
    }

    /// Records an assignment to the programmable frame.
    pub(super) fn assign_programmable(&mut self, text: &str) {
        self.frame.clear();
        self.assigned = Some(text.as_bytes().to_vec());
    }

    pub(super) fn add_frame(&mut self, words: &FrameWords, plane: Plane) {
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
            // Consecutive shifts are merged: a loop of ATRANS must not grow without limit.
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
