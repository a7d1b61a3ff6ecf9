//! Template `vmc`.

use super::Template;

/// C-frame vertical mill with a cross table: the saddle Y carries the table X; Z carries the spindle.
pub(super) const VMC: Template = Template {
    name: "vmc",
    topology: "wXYFZSt",
    line: "C-frame vertical mill with a cross table: the saddle Y carries the table X; Z carries the spindle",
    travels_mm: [[0.0, 500.0], [0.0, 400.0], [-500.0, 0.0]],
    rotary: &[],
    is_router: false,
    lacks: "",
};
