//! Position-independent errors: deviations of the axes and the spindle from their nominal locations in the machine.
//!
//! `EC0Y` is the squareness of Y (its body rotated about Z), `EX0C` the offset of the axis C, `EX0S` the offset of the spindle (ISO 230-1, ISO 230-7). They
//! are the displacement D(e0) at the place of the axis, always of the moving body, on the workpiece side, too.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::Machine;

use super::ErrorModel;
use super::forward::Model;
use super::name::ErrorName;

/// Shares of the travel at which effects are looked for: no symmetric pose.
const SHARES: [f64; 3] = [0.21, 0.58, 0.93];
/// Travel of an axis without limits, mm or rad.
const ANY_TRAVEL: [f64; 2] = [0.0, 1.0];
/// Length of the tool for which effects are looked for, mm.
const TOOL_MM: f64 = 100.0;
/// Effects below this are rounding: mm of the tip per mm or rad of the error.
const NO_EFFECT: f64 = 1e-9;

/// Position-independent error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocationError {
    /// Name.
    pub name: ErrorName,
    /// Value, mm for displacements, rad for rotations.
    pub value: f64,
}

/// The errors that have no effect on the tip or on the tool axis, each with the location errors of the same direction that have one.
pub(super) fn without_effect(machine: &Machine, errors: &[LocationError]) -> Vec<(ErrorName, Vec<ErrorName>)> {
    let model = Model::new(machine, &ErrorModel::default());
    let tool_mm: Vector = -TOOL_MM * machine.spindle.axis;
    let has_effect = |name: ErrorName| {
        SHARES.iter().any(|share| {
            let mut command = AxisVector::ZERO;
            for data in machine.axes.iter().flatten() {
                let [low, high] = data.travel.unwrap_or(ANY_TRAVEL);
                command[data.axis] = low + share * (high - low);
            }
            let effect = model.sensitivity(name, &command, &tool_mm);
            // A turn about the tool axis moves nothing that cuts.
            effect.translation.norm() > NO_EFFECT || effect.rotation.cross(&machine.spindle.axis).norm() > NO_EFFECT
        })
    };
    let of_spindle = |name: ErrorName| name.axis().is_none();
    let without = errors.iter().map(|error| error.name).filter(|&name| !of_spindle(name) && !has_effect(name));
    let with_others = without.map(|name| {
        let linear = machine.axis_set().iter().filter(|axis| !axis.is_rotary());
        let others = linear.map(|axis| ErrorName::location(name.direction, axis));
        (name, others.filter(|&other| has_effect(other)).collect())
    });
    with_others.collect()
}
