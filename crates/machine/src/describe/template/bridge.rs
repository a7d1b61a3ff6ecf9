//! Template `bridge`.

use super::Template;

/// Bridge mill: the table moves in X; the crossbeam carries Y, and Y carries Z.
pub(super) const BRIDGE: Template = Template {
    name: "bridge",
    topology: "wXFYZSt",
    line: "bridge mill: the table moves in X; the crossbeam carries Y, and Y carries Z",
    travels_mm: [[0.0, 1000.0], [0.0, 800.0], [-500.0, 0.0]],
    rotary: &[],
    is_router: false,
    lacks: "",
};
