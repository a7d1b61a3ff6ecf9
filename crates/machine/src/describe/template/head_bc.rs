//! Template `head-bc`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// Gantry mill with a fork head: Z carries C, C carries B, and B carries the spindle.
pub(super) const HEAD_BC: Template = Template {
    name: "head-bc",
    topology: "wFXYZCBSt",
    line: "gantry mill with a fork head: Z carries C, C carries B, and B carries the spindle",
    travels_mm: [[0.0, 3000.0], [0.0, 2000.0], [-1000.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: Some([-360.0, 360.0]) },
        TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 0.0], travel_deg: Some([-110.0, 110.0]) },
    ],
    is_router: false,
    lacks: "",
};
