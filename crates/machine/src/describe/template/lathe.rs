//! Template `lathe`, which the machine file cannot carry.

use super::Template;

/// Lathe with two axes: Z carries X, and X carries the turret.
pub(super) const LATHE: Template = Template {
    name: "lathe",
    topology: "",
    line: "lathe with two axes: Z carries X, and X carries the turret",
    travels_mm: [[0.0, 0.0]; 3],
    rotary: &[],
    is_router: false,
    lacks: "programs in diameters outside of Sinumerik, the position of the cutting edge of a turning tool, and a spindle that turns the workpiece",
};
