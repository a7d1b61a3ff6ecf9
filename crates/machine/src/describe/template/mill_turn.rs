//! Template `mill-turn`, which the machine file cannot carry.

use super::Template;

/// Turning and milling center: lathe with driven tools, Y and C.
pub(super) const MILL_TURN: Template = Template {
    name: "mill-turn",
    topology: "",
    line: "turning and milling center: lathe with driven tools, Y and C",
    travels_mm: [[0.0, 0.0]; 3],
    rotary: &[],
    is_router: false,
    lacks: "programs in diameters outside of Sinumerik, the position of the cutting edge of a turning tool, and a spindle that is also the axis C",
};
