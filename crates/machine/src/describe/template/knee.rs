//! Template `knee`.

use super::Template;

/// Knee mill: the knee Z carries the saddle Y, and Y carries the table X; the spindle is fixed.
pub(super) const KNEE: Template = Template {
    name: "knee",
    topology: "wXYZFSt",
    line: "knee mill: the knee Z carries the saddle Y, and Y carries the table X; the spindle is fixed",
    travels_mm: [[0.0, 700.0], [0.0, 300.0], [0.0, 400.0]],
    rotary: &[],
    is_router: false,
    lacks: "",
};
