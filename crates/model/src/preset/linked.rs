//! Models of location errors: `mayer-13`, `12` and `10`.
//!
//! Five axes have eight location errors that are not redundant: the squareness of the linear axes (three), two tilts of each rotary axis, and the offset
//! between the rotary axes. The other location errors of ISO 230-1 describe the zero of an axis or the position of the workpiece. The presets add
//!
//! | preset | additions | unknowns of the set-up |
//! | --- | --- | --- |
//! | `mayer-13` | two offsets of the spindle, gains of the linear axes | position of the workpiece, tool length |
//! | `12` | two relative gains, backlash of the rotary axes | position and size of the workpiece, whole tool vector |
//! | `10` | two relative gains | as for `12` |
//!
//! With an unknown tool vector the spindle offsets cannot be distinguished from those of the tool, so `12` and `10` lack them. `mayer-13` requires that the
//! offset of the tool is known, or separated from that of the spindle by indexing the spindle. Without a length standard a gain common to all axes cannot be
//! distinguished from the size of the workpiece. The gain of X, or of the first linear axis in the order of letters, therefore keeps its value in the machine
//! file. `EYY1` is then what is printed as `EYY1 − EXX1`.
//!
//! Tilts are about directions of F. If a rotary axis lies between them, for example at 45°, its tilts are those about the two directions other than that of
//! its letter.

use super::Unsuitable;
use super::roles::{Linear, RotaryPair, spindle_offsets, tilts};
use crate::name::{DIRECTIONS, ErrorName};
use crate::parameter::ParameterName;
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;

/// Returns the parameters of Esmaeili 2021, Table 4-3.
pub(super) fn mayer_13(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let mut parameters = location_errors(machine)?;
    parameters.extend(spindle_offsets(machine).map(ParameterName::location));
    parameters.extend(gains(machine)?);
    Ok(parameters)
}

/// Returns the parameters of Esmaeili 2021, Table 5-1.
pub(super) fn linked_12(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let mut parameters = location_errors(machine)?;
    parameters.extend(backlashes(machine)?);
    parameters.extend(gains(machine)?.into_iter().skip(1));
    Ok(parameters)
}

/// Returns the parameters of Esmaeili 2021, Table 6-1.
pub(super) fn linked_10(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let mut parameters = location_errors(machine)?;
    parameters.extend(gains(machine)?.into_iter().skip(1));
    Ok(parameters)
}

/// Returns the eight location errors, in the order of the published tables.
pub(super) fn location_errors(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    let linear = Linear::of(machine)?;
    let rotary = RotaryPair::of(machine)?;
    let mut names = tilts(rotary.first).to_vec();
    names.push(rotary.offset());
    names.extend(tilts(rotary.second));
    names.extend(linear.squareness(machine));
    Ok(names.into_iter().map(ParameterName::location).collect())
}

/// Returns the three location errors of the linear axes.
pub(super) fn squareness(machine: &Machine) -> Result<Vec<ParameterName>, Unsuitable> {
    Ok(Linear::of(machine)?.squareness(machine).into_iter().map(ParameterName::location).collect())
}

/// Returns degree 1 of the positioning of the linear axes, in the order of their letters.
fn gains(machine: &Machine) -> Result<[ParameterName; 3], Unsuitable> {
    let mut axes = Linear::of(machine)?.0.map(|data| data.axis);
    axes.sort();
    Ok(axes.map(|axis| ParameterName::coefficient(positioning(axis), 1)))
}

/// Returns the backlash of the positioning of both rotary axes.
pub(super) fn backlashes(machine: &Machine) -> Result<[ParameterName; 2], Unsuitable> {
    let rotary = RotaryPair::of(machine)?;
    Ok([rotary.first, rotary.second].map(|data| ParameterName::backlash(positioning(data.axis))))
}

/// Returns the error of an axis along or about itself, by its letter.
pub(super) fn positioning(axis: Axis) -> ErrorName {
    ErrorName::motion(DIRECTIONS[axis.dimension() + if axis.is_rotary() { 3 } else { 0 }], axis)
}
