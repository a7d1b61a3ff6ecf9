//! Template `nutating-table`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// 45 degree table: Y carries B, whose axis lies between Y and Z, and B carries the table C; X carries Z.
pub(super) const NUTATING_TABLE: Template = Template {
    name: "nutating-table",
    topology: "wCBYFXZSt",
    line: "45 degree table: Y carries B, whose axis lies between Y and Z, and B carries the table C; X carries Z",
    travels_mm: [[0.0, 600.0], [-450.0, 50.0], [-550.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 1.0], travel_deg: Some([0.0, 180.0]) },
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: None },
    ],
    is_router: false,
    lacks: "",
};
