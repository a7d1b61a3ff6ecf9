//! Template `router`.

use super::Template;

/// Router with a fixed bed: the gantry Y carries X, and X carries Z.
pub(super) const ROUTER: Template = Template {
    name: "router",
    topology: "wFYXZSt",
    line: "router with a fixed bed: the gantry Y carries X, and X carries Z",
    travels_mm: [[0.0, 600.0], [0.0, 900.0], [-80.0, 0.0]],
    rotary: &[],
    is_router: true,
    lacks: "",
};
