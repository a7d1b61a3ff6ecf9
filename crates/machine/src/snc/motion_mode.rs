//! Motion mode of a move on the control: part of the path, a thread, axes that are positioned separately, or a probing motion.
//!
//! The text form does not contain it: it only gives the target positions.

/// Motion mode of a move.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum MotionMode {
    /// Part of the path, rapid or at feed; it may be split into pieces.
    #[default]
    Path,
    /// A thread, in one piece.
    Thread(Thread),
    /// Each axis separately (`POS[X]=`), in one piece.
    Positioning,
    /// To the reference point of the named axes, whose position does not depend on the errors of the machine.
    Reference,
    /// Until a probe or a signal ends it, with its code (`G38.2`, `G31`), in one piece.
    Probe(&'static str),
}

/// Thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thread {
    /// Code.
    pub code: ThreadCode,
    /// `I`, `J` or `K` and the lead, mm per revolution; signed for rigid tapping. `None` for G63.
    pub lead: Option<(u8, f64)>,
    /// Change of the lead, mm per revolution and revolution.
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
    /// Tapping with a compensating chuck: a move at feed, in its block only.
    G63,
}

impl ThreadCode {
    const ALL: [ThreadCode; 6] =
        [ThreadCode::G33, ThreadCode::G34, ThreadCode::G35, ThreadCode::G331, ThreadCode::G332, ThreadCode::G63];

    /// Returns the code of a word.
    #[must_use]
    pub fn of(word: &str) -> Option<ThreadCode> {
        ThreadCode::ALL.into_iter().find(|code| code.word() == word)
    }

    /// Returns the code as written in a program.
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

    /// True if the rotating spindle drives the axes; otherwise the feed does.
    #[must_use]
    pub fn is_spindle_driven(self) -> bool {
        self != ThreadCode::G63
    }
}
