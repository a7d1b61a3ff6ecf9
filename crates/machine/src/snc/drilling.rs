//! The drilling cycle of a control around the moves of one hole.

use ncfix_base::geometry::Plane;

/// A call of a drilling cycle at one hole.
#[derive(Clone, Debug, PartialEq)]
pub struct DrillingCycle {
    /// Word of the cycle: `G83`, `CYCLE83`.
    pub name: String,
    /// True if only the control knows the moves: the call must stay, and its moves are the axis of the hole.
    pub is_own: bool,
    /// Working plane; its third axis is the drilling axis.
    pub plane: Plane,
    /// True if the tool ends at a height that the call gives (G99, the retraction plane of a Sinumerik), false if at the initial level (G98).
    pub ends_at_reference: bool,
    /// False if the program leaves that end to the state of the control (RS274/NGC without G98 and G99): the call must not state it.
    pub is_end_stated: bool,
    /// Pecks of one depth, if the number of pecks follows from the heights of the call.
    pub peck: Option<Peck>,
    /// Further words or arguments in their order.
    pub arguments: Vec<CycleArgument>,
    /// The motion or call that makes a hole.
    pub trigger: HoleTrigger,
}

/// The motion or call that makes a hole of a drilling cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoleTrigger {
    /// The motion to the position of the hole (MCALL).
    Motion,
    /// A call with the position of the hole (G81, G79).
    Position,
    /// A call without position: the hole is where the tool is (CYCLE81 without MCALL).
    Call,
}

/// Pecks of one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peck {
    /// Depth of one peck, mm.
    pub depth_mm: f64,
    /// Largest remainder of the depth that is not a peck, mm.
    pub slack_mm: f64,
}

/// Word or argument of a cycle.
#[derive(Clone, Debug, PartialEq)]
pub enum CycleArgument {
    /// Height along the drilling axis in the coordinates of the program, mm.
    Height(f64),
    /// Written unchanged; empty for an omitted argument.
    Text(String),
}

impl CycleArgument {
    /// Returns an M function, which is in the block before the call: `M29 S500`.
    #[must_use]
    pub fn function(&self) -> Option<&str> {
        match self {
            CycleArgument::Text(text) if text.starts_with('M') => Some(text),
            _ => None,
        }
    }
}
