//! The models of cubic motion errors: `84` and `81`.
//!
//! Each of the six motion errors of five axes is a polynomial of degree 3, and the positioning of both rotary axes has a backlash:
//! 122 numbers, of which some move the tip just as others do, or as the unknown set-up does. Location errors are not listed
//! beside them, because constant rotations and slopes stand for them. Following the procedure that Esmaeili 2021, 5.5, describes
//! (coefficients of degree 0 and 1 are removed as long as the rank stays), parameters are taken in the order of [`candidates`], and
//! those that bring nothing new ([`super::separable`]) are left out.
//!
//! | preset | what the set-up may leave unknown | left out on the printed machine |
//! | --- | --- | --- |
//! | `84` (Table 4-2) | place of the workpiece, tool length | 38 |
//! | `81` (appendix 5.13) | place and size of the workpiece, tool vector | 41 |
//!
//! The numbers are those of chains with both rotary axes on the table and at most one linear axis below them. With two linear axes
//! there it is one more, with three, or with a rotary axis in the head, three more.
//!
//! In `81` the gain `EXX1` stays as it is in the machine file, and `EYY1`, `EZZ1` are relative to it.
//!
//! Misprints: in Table 4-2 the first `EYB3` (1.53E-02) is `EXB3`; in the appendix the second `EAY0` … `EAY3` are `ECY0` … `ECY3`, and in
//! Table 5-2 `EEXZ`, `EEx0` … are `EXZ`, `EXZ0` ….

use super::Unsuitable;
use super::linked::{backlashes, positioning};
use super::roles::{Linear, RotaryPair, along};
use super::separable::{ReadingPlan, SetUp};
use crate::name::{DIRECTIONS, Direction, ErrorName};
use crate::parameter::{ParameterName, Term};
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;

/// Esmaeili 2021, Table 4-2.
pub(super) fn cubic_84(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    parameters(machine, SetUp::ToolLength)
}

/// Esmaeili 2021, appendix 5.13.
pub(super) fn cubic_81(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    parameters(machine, SetUp::ToolAndSize)
}

fn parameters(machine: &Machine, set_up: SetUp) -> Result<Vec<ParameterName>, Unsuitable> {
    let plan = ReadingPlan::of(machine);
    let mut candidates = candidates(machine)?;
    // With a constant arm a rotation is a displacement, and is called one.
    candidates.sort_by_cached_key(|parameter| {
        parameter.component.direction.is_rotation() && plan.is_constant(parameter.component)
    });
    let mut parameters = plan.separable(&candidates, set_up);
    // As printed: by axis and component, backlash last.
    parameters.sort_by_key(|parameter| (parameter.component.axis(), parameter.component.direction, parameter.term));
    Ok(parameters)
}

/// The candidates; of those that say the same the earlier one is kept.
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
    // What bends has no equal among the location errors. A displacement comes before the rotation that has the same effect
    // because its arm is constant.
    for degree in [3, 2] {
        for direction in straight.clone().chain(tilting.clone()) {
            five.into_iter().for_each(|axis| add(axis, direction, degree));
        }
    }
    for direction in straight.clone().chain(tilting.clone()) {
        turning.into_iter().for_each(|axis| add(axis, direction, 1));
    }
    // Gains; that of the first letter last, so that it is the one that the others relate to where only their differences show.
    let mut by_letter = [datum, outer, inner];
    by_letter.sort_by(|a, b| b.cmp(a));
    for axis in by_letter {
        add(axis, positioning(axis).direction, 1);
    }
    for direction in tilting.clone() {
        [outer, datum, inner].into_iter().for_each(|axis| add(axis, direction, 1));
    }
    // Constant rotations stand for squareness and tilt: zero of the rotary axes first, then from the tool side on.
    for axis in turning {
        add(axis, positioning(axis).direction, 0);
    }
    for axis in [outer, datum, inner, turning[0], turning[1]] {
        tilting.clone().for_each(|direction| add(axis, direction, 0));
    }
    // Constant displacements stand for offsets: between the rotary axes, then of the spindle.
    let offset = rotary.offset();
    add(turning[0], offset.direction, 0);
    for axis in [inner, outer, datum, turning[0], turning[1]] {
        straight.clone().for_each(|direction| add(axis, direction, 0));
    }
    // Slopes that no rotation stands for: the middle axis along the first one, then all others.
    add(outer, along(&linear[0].direction), 1);
    for axis in [outer, datum, inner] {
        straight.clone().for_each(|direction| add(axis, direction, 1));
    }
    all.extend(backlashes(machine)?);
    // Some are named twice; the first place counts.
    let mut seen = std::collections::BTreeSet::new();
    all.retain(|parameter| seen.insert(*parameter));
    debug_assert_eq!(all.iter().filter(|parameter| matches!(parameter.term, Term::Coefficient(_))).count(), 120);
    Ok(all)
}
