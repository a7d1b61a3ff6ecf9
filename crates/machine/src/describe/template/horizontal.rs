//! Template `horizontal`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// Horizontal machining center: Z carries the table B; the column X carries Y with the spindle.
pub(super) const HORIZONTAL: Template = Template {
    name: "horizontal",
    topology: "wBZFXYSt",
    line: "horizontal machining center: Z carries the table B; the column X carries Y with the spindle",
    travels_mm: [[0.0, 600.0], [0.0, 600.0], [0.0, 600.0]],
    rotary: &[TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 0.0], travel_deg: None }],
    is_router: false,
    lacks: "",
};
