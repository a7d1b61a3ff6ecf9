//! Template `moving-bed-router`.

use super::Template;

/// Router with a moving bed: Y carries the workpiece; the fixed portal carries X, and X carries Z.
pub(super) const MOVING_BED_ROUTER: Template = Template {
    name: "moving-bed-router",
    topology: "wYFXZSt",
    line: "router with a moving bed: Y carries the workpiece; the fixed portal carries X, and X carries Z",
    travels_mm: [[0.0, 300.0], [0.0, 180.0], [-45.0, 0.0]],
    rotary: &[],
    is_router: true,
    lacks: "",
};
