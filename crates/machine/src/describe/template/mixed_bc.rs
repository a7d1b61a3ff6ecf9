//! Template `mixed-bc`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// Table C and head B: Y carries the table C; Z carries B, and B carries the spindle.
pub(super) const MIXED_BC: Template = Template {
    name: "mixed-bc",
    topology: "wCYFXZBSt",
    line: "table C and head B: Y carries the table C; Z carries B, and B carries the spindle",
    travels_mm: [[0.0, 600.0], [0.0, 600.0], [-500.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: None },
        TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 0.0], travel_deg: Some([-30.0, 120.0]) },
    ],
    is_router: false,
    lacks: "",
};
