//! The drilling cycle of a control around the moves of one hole.

use ncfix_base::geometry::Plane;

/// A call of a drilling cycle at one hole.
#[derive(Clone, Debug, PartialEq)]
pub struct DrillingCycle {
    /// Word of the cycle: `G83`, `CYCLE83`.
    pub name: String,
    /// Working plane; its third axis is the drilling axis.
    pub plane: Plane,
    /// True if the tool ends at a height that the call gives (G99, the retraction plane of a Sinumerik), false if at the initial level (G98).
    pub ends_at_reference: bool,
    /// Pecks of one depth, if the number of pecks follows from the heights of the call.
    pub peck: Option<Peck>,
    /// Further words or arguments in their order.
    pub arguments: Vec<CycleArgument>,
    /// True if the motion to a hole triggers the cycle (MCALL), false if the call contains the position or is made at the position.
    pub is_modal: bool,
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
