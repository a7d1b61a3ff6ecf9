//! Template `vmc-a`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// C-frame vertical mill with a rotary table A on its cross table.
pub(super) const VMC_A: Template = Template {
    name: "vmc-a",
    topology: "wAXYFZSt",
    line: "C-frame vertical mill with a rotary table A on its cross table",
    travels_mm: [[0.0, 500.0], [0.0, 400.0], [-500.0, 0.0]],
    rotary: &[TemplateRotary { axis: Axis::A, line: [1.0, 0.0, 0.0], travel_deg: None }],
    is_router: false,
    lacks: "",
};
