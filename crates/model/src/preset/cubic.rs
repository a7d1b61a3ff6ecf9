//! Models of cubic motion errors: `84` and `81`.
//!
//! Each of the six motion errors of five axes is a polynomial of degree 3, and the positioning of both rotary axes has a backlash: 122 numbers. Some of them
//! move the tip in the same way as others, or as the unknown set-up. Location errors are not listed in addition, because constant rotations and slopes
//! represent them. The selection follows the procedure of Esmaeili 2021, 5.5 (coefficients of degree 0 and 1 are removed while the rank stays). Parameters
//! are taken in the order of [`candidates`]; those that are combinations of earlier ones ([`super::separable`]) are omitted.
//!
//! | preset | unknowns of the set-up | omitted on the printed machine |
//! | --- | --- | --- |
//! | `84` (Table 4-2) | position of the workpiece, tool length | 38 |
//! | `81` (appendix 5.13) | position and size of the workpiece, tool vector | 41 |
//!
//! These numbers apply to chains with both rotary axes on the table and at most one linear axis below them. With two linear axes there, it is one more; with
//! three, or with a rotary axis in the head, three more.
//!
//! In `81` the gain `EXX1` keeps its value in the machine file, and `EYY1`, `EZZ1` are relative to it.
//!
//! Misprints: in Table 4-2 the first `EYB3` (1.53E-02) is `EXB3`; in the appendix the second `EAY0` … `EAY3` are `ECY0` … `ECY3`, and in
//! Table 5-2 `EEXZ`, `EEx0` … are `EXZ`, `EXZ0` ….

use super::Unsuitable;
use super::linked::{backlashes, positioning};
use super::roles::{Linear, RotaryPair, along};
use super::separable::{ReadingPlan, SetUp};
use crate::name::{DIRECTIONS, Direction, ErrorName};
use crate::parameter::{ComponentTerm, ParameterName};
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;

/// Returns the parameters of Esmaeili 2021, Table 4-2.
pub(super) fn cubic_84(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    parameters(machine, SetUp::ToolLength)
}

/// Returns the parameters of Esmaeili 2021, appendix 5.13.
pub(super) fn cubic_81(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    parameters(machine, SetUp::ToolAndSize)
}

fn parameters(machine: &Machine, set_up: SetUp) -> Result<Vec<ParameterName>, Unsuitable> {
    let plan = ReadingPlan::of(machine);
    let mut candidates = candidates(machine)?;
    // With a constant arm a rotation acts as a displacement, and is listed as one.
    candidates.sort_by_cached_key(|parameter| {
        parameter.component.direction.is_rotation() && plan.is_constant(parameter.component)
    });
    let mut parameters = plan.separable(&candidates, set_up);
    // In the printed order: by axis and component, backlash last.
    parameters.sort_by_key(|parameter| (parameter.component.axis(), parameter.component.direction, parameter.term));
    Ok(parameters)
}

/// Returns the candidates; of equivalent ones the earlier one is kept.
fn candidates(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let Linear(linear) = Linear::of(machine)?;
    let rotary = RotaryPair::of(machine)?;
    let [datum, outer, inner] = linear.map(|data| data.axis);
    let turning = [rotary.first.axis, rotary.second.axis];
    let straight = DIRECTIONS.into_iter().filter(|direction| !direction.is_rotation());
    let tilting = DIRECTIONS.into_iter().filter(|direction| direction.is_rotation());
    let mut all = Vec::new();
    let mut add = |axis: Axis, direction: Direction, degree: u8| {
        all.push(ParameterName::coefficient(ErrorName::motion(direction, axis), degree));
    };
    let five = [turning[0], turning[1], datum, outer, inner];
    // Curved functions have no equivalent among the location errors. A displacement comes before a rotation with the same effect due to a constant arm.
    for degree in [3, 2] {
        for direction in straight.clone().chain(tilting.clone()) {
            five.into_iter().for_each(|axis| add(axis, direction, degree));
        }
    }
    for direction in straight.clone().chain(tilting.clone()) {
        turning.into_iter().for_each(|axis| add(axis, direction, 1));
    }
    // Gains. The one of the first letter comes last: if only differences are determined, the others relate to it.
    let mut by_letter = [datum, outer, inner];
    by_letter.sort_by(|a, b| b.cmp(a));
    for axis in by_letter {
        add(axis, positioning(axis).direction, 1);
    }
    for direction in tilting.clone() {
        [outer, datum, inner].into_iter().for_each(|axis| add(axis, direction, 1));
    }
    // Constant rotations represent squareness and tilt: first the zeros of the rotary axes, then from the tool side on.
    for axis in turning {
        add(axis, positioning(axis).direction, 0);
    }
    for axis in [outer, datum, inner, turning[0], turning[1]] {
        tilting.clone().for_each(|direction| add(axis, direction, 0));
    }
    // Constant displacements represent offsets: between the rotary axes, then of the spindle.
    let offset = rotary.offset();
    add(turning[0], offset.direction, 0);
    for axis in [inner, outer, datum, turning[0], turning[1]] {
        straight.clone().for_each(|direction| add(axis, direction, 0));
    }
    // Slopes that no rotation represents: the middle axis along the first one, then all others.
    add(outer, along(&linear[0].direction), 1);
    for axis in [outer, datum, inner] {
        straight.clone().for_each(|direction| add(axis, direction, 1));
    }
    all.extend(backlashes(machine)?);
    // Some occur twice; the first place counts.
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|parameter| seen.insert(*parameter));
    debug_assert_eq!(
        all.iter().filter(|parameter| matches!(parameter.term, ComponentTerm::Coefficient(_))).count(),
        120
    );
    Ok(all)
}
