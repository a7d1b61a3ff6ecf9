//! Template `gantry`.

use super::Template;

/// Gantry mill with a fixed table: the gantry X carries Y, and Y carries Z.
pub(super) const GANTRY: Template = Template {
    name: "gantry",
    topology: "wFXYZSt",
    line: "gantry mill with a fixed table: the gantry X carries Y, and Y carries Z",
    travels_mm: [[0.0, 2000.0], [0.0, 1000.0], [-500.0, 0.0]],
    rotary: &[],
    is_router: false,
    lacks: "",
};
