//! A difference of a corrected program from its original that is not a correction.

use ncfix_base::geometry::Axis;
use ncfix_machine::snc::{FeedUnit, Origin};

/// A difference with its places in both programs; if one program has no counterpart, the place is its next or last move.
#[derive(Clone, Debug, PartialEq)]
pub struct ProgramDifference {
    /// In the original.
    pub original: Origin,
    /// In the corrected program.
    pub corrected: Origin,
    /// The difference.
    pub what: What,
}

/// What an act is about, apart from motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ActSubject {
    /// S.
    SpindleSpeed,
    /// A dwell in seconds.
    Dwell,
    /// A dwell in turns of the spindle.
    DwellInTurns,
    /// A word that stays in force.
    Mode,
    /// A statement that is passed on as it is.
    Statement,
    /// Data that the control computes from its position, such as the zero offset of `G10 L20`.
    ComputedData,
    /// What a control finds a program by.
    ProgramNumber,
    /// A message to the operator.
    Message,
    /// A settable frame.
    WorkOffset,
    /// A programmable frame.
    Frame,
    /// How the ends of blocks are passed.
    Passing,
    /// T.
    Tool,
    /// D.
    ToolOffset,
    /// H.
    ToolLength,
    /// Another function of the machine.
    Auxiliary,
    /// Direction and stop of the spindle.
    Spindle,
    /// M7, M8, M9.
    Coolant,
    /// M0, M1, M60.
    Stop,
    /// M2, M17, M30, M99.
    End,
    /// M6.
    ToolChange,
    /// Another M function.
    Function,
    /// Cutting a thread.
    Thread,
    /// The plane and the transformation of the axes.
    Plane,
}

impl std::fmt::Display for ActSubject {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            ActSubject::SpindleSpeed => "spindle speed",
            ActSubject::Dwell => "dwell",
            ActSubject::DwellInTurns => "dwell in turns",
            ActSubject::Mode => "mode",
            ActSubject::Statement => "statement",
            ActSubject::ComputedData => "data computed from the position",
            ActSubject::ProgramNumber => "program number",
            ActSubject::Message => "message",
            ActSubject::WorkOffset => "work offset",
            ActSubject::Frame => "frame",
            ActSubject::Passing => "exact stop or path mode",
            ActSubject::Tool => "tool",
            ActSubject::ToolOffset => "tool offset",
            ActSubject::ToolLength => "tool length or H function",
            ActSubject::Auxiliary => "auxiliary function",
            ActSubject::Spindle => "spindle",
            ActSubject::Coolant => "coolant",
            ActSubject::Stop => "stop",
            ActSubject::End => "end of program",
            ActSubject::ToolChange => "tool change",
            ActSubject::Function => "M function",
            ActSubject::Thread => "thread",
            ActSubject::Plane => "plane and transformation",
        })
    }
}

/// Kinds of differences.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// An act other than motion, with its text in both programs; `None` if it is missing. Equal texts mean that it is at another place in the
    /// sequence.
    Act {
        /// What it is about.
        subject: ActSubject,
        /// In the original.
        before: Option<String>,
        /// In the corrected program.
        after: Option<String>,
    },
    /// The tool deviates from its place by more than was promised, mm.
    Off {
        /// Actual distance.
        off_mm: f64,
        /// Permitted distance.
        limit_mm: f64,
    },
    /// The tool direction differs by more than its uncorrected direction explains, rad.
    Tilted {
        /// Actual tilt.
        tilt_rad: f64,
        /// Permitted tilt.
        limit_rad: f64,
    },
    /// A piece of a move that is evaluated at its end only, such as a rapid move, is off the straight path of the move, mm.
    Detour {
        /// Actual distance.
        off_mm: f64,
        /// Permitted distance.
        limit_mm: f64,
    },
    /// A piece of such a move turns an axis beyond both of its ends.
    Turned {
        /// The axis.
        axis: Axis,
        /// Excess, rad.
        beyond_rad: f64,
    },
    /// A move has another feed: value and unit in both programs, and the ratio if defined.
    Feed {
        /// In the original.
        before: (f64, FeedUnit),
        /// In the corrected program.
        after: (f64, FeedUnit),
        /// Ratio of the new feed to the original feed.
        share: f64,
    },
}
