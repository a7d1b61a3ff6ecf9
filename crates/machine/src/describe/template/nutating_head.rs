//! Template `nutating-head`.

use super::{Template, TemplateRotary};
use ncfix_base::geometry::Axis;

/// 45 degree head: Z carries C, C carries B, whose axis lies between Y and Z, and B carries the spindle.
pub(super) const NUTATING_HEAD: Template = Template {
    name: "nutating-head",
    topology: "wFXYZCBSt",
    line: "45 degree head: Z carries C, C carries B, whose axis lies between Y and Z, and B carries the spindle",
    travels_mm: [[0.0, 2000.0], [0.0, 1000.0], [-800.0, 0.0]],
    rotary: &[
        TemplateRotary { axis: Axis::C, line: [0.0, 0.0, 1.0], travel_deg: Some([-360.0, 360.0]) },
        TemplateRotary { axis: Axis::B, line: [0.0, 1.0, 1.0], travel_deg: Some([-180.0, 180.0]) },
    ],
    is_router: false,
    lacks: "",
};
