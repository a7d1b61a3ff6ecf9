//! Template `trunnion-ac`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// Swivel table: Y carries the trunnion A, and A carries the table C; X carries Z.
pub(super) const TRUNNION_AC: Template = Template {
    name: "trunnion-ac",
    topology: "wCAYFXZSt",
    line: "swivel table: Y carries the trunnion A, and A carries the table C; X carries Z",
    travels_mm: [[0.0, 600.0], [-450.0, 50.0], [-550.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::A, line: [1.0, 0.0, 0.0], travel_deg: Some([-120.0, 30.0]) },
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: None },
    ],
    is_router: false,
    lacks: "",
};
