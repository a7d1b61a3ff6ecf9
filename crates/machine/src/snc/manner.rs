//! What a move is on the control beside its way: part of the path, a thread, positions of axes that move on their own, or a probing
//! motion.
//!
//! The text form does not show it: it says where the axes go.

/// How the control carries a move out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Manner {
    /// As part of the path, rapid or with feed; it may be cut into pieces.
    #[default]
    Path,
    /// As a thread, in one piece.
    Thread(Thread),
    /// Each axis on its own (`POS[X]=`), in one piece.
    Positioning,
    /// To the reference point of the axes named, which is where it is whatever the errors of the machine.
    Reference,
    /// Until a probe or a signal ends it, by its code (`G38.2`, `G31`), in one piece.
    Probe(&'static str),
}

/// A thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Its code.
    pub code: ThreadCode,
    /// `I`, `J` or `K` and the lead, mm per turn; signed for rigid tapping. None for G63.
    pub lead: Option<(u8, f64)>,
    /// Change of the lead, mm per turn and turn.
    pub change: Option<f64>,
}

/// Codes of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThreadCode {
    /// Constant lead.
    G33,
    /// Increasing lead.
    G34,
    /// Decreasing lead.
    G35,
    /// Rigid tapping.
    G331,
    /// Retraction of rigid tapping.
    G332,
    /// Tapping with a compensating chuck: a move with feed, for its block only.
    G63,
}

impl ThreadCode {
    const ALL: [ThreadCode; 6] =
        [ThreadCode::G33, ThreadCode::G34, ThreadCode::G35, ThreadCode::G331, ThreadCode::G332, ThreadCode::G63];

    /// The code of a word.
    #[must_use]
    pub fn of(word: &str) -> Option<ThreadCode> {
        ThreadCode::ALL.into_iter().find(|code| code.word() == word)
    }

    /// As a program writes it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            ThreadCode::G33 => "G33",
            ThreadCode::G34 => "G34",
            ThreadCode::G35 => "G35",
            ThreadCode::G331 => "G331",
            ThreadCode::G332 => "G332",
            ThreadCode::G63 => "G63",
        }
    }

    /// Whether the turning spindle moves the axes; else it is a feed.
    #[must_use]
    pub fn is_spindle_driven(self) -> bool {
        self != ThreadCode::G63
    }
}
