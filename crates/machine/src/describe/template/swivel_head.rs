//! Template `swivel-head`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// C-frame mill with a cross table and a swivel head: Z carries B, and B carries the spindle.
pub(super) const SWIVEL_HEAD: Template = Template {
    name: "swivel-head",
    topology: "wXYFZBSt",
    line: "C-frame mill with a cross table and a swivel head: Z carries B, and B carries the spindle",
    travels_mm: [[0.0, 600.0], [0.0, 500.0], [-500.0, 0.0]],
    rotary: &[TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 0.0], travel_deg: Some([-95.0, 95.0]) }],
    is_router: false,
    lacks: "",
};
