//! Template `trunnion-bc`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// Swivel table: X carries the trunnion B, and B carries the table C; Y carries Z.
pub(super) const TRUNNION_BC: Template = Template {
    name: "trunnion-bc",
    topology: "wCBXFYZSt",
    line: "swivel table: X carries the trunnion B, and B carries the table C; Y carries Z",
    travels_mm: [[0.0, 600.0], [0.0, 500.0], [-550.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 0.0], travel_deg: Some([-110.0, 110.0]) },
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: None },
    ],
    is_router: false,
    lacks: "",
};
