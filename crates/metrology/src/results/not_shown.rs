//! Squareness, positioning and straightness errors that no reading of a calibration can show.
//!
//! A laser along X and another along Y say nothing about the angle between the two axes, and neither does a straightness whose reference was aligned by hand.
//! The error model then has no squareness, and nothing distinguishes it from a measured one of zero. So the machine file names it.

use crate::calibrate::{Parameter, identify};
use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, Axis, Plane};
use ncfix_machine::machine::squareness::{pair, squareness};
use ncfix_machine::machine::{Machine, MeasuredRanges};
use ncfix_model::coverage::{states_slope, states_squareness};
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::{ErrorModel, ParameterName};

/// The names for [`MeasuredRanges::not_shown`]: pairs of measured axes whose squareness neither the errors at the start nor any of these measurements show.
/// `ranges` are those after the measurements. A squareness that the readings show and the model lacks (`omitted`) remains unknown: other parameters have
/// absorbed it. What an earlier calibration has shown remains known. `None` if there is
/// nothing to state.
#[must_use]
pub fn not_shown(
    machine: &Machine,
    start: &ErrorModel,
    ranges: &MeasuredRanges,
    (sets, omitted): (&[&DataSet], &[String]),
) -> Option<Vec<String>> {
    let direction = |axis: Axis| machine.axis(axis).map(|data| data.direction);
    let earlier = machine.measured.as_ref();
    let is_open = |name: &str, axes: [Axis; 2]| {
        let is_listed = earlier.is_some_and(|earlier| earlier.not_shown.iter().flatten().any(|one| one == name));
        let was_measured = earlier.is_some_and(|earlier| axes.iter().all(|axis| earlier.axes.contains_key(axis)));
        // The slope of a listed one is an assumption of an earlier calibration.
        let is_known = !is_listed && (was_measured || states_slope(start, axes));
        axes.iter().all(|axis| ranges.axes.contains_key(axis)) && !is_known
    };
    let of_plane = |plane: Plane| {
        let term = squareness(&machine.topology, plane, direction)?;
        let error: ErrorName = term.name.parse().ok()?;
        // The slope of one axis against a reference that stands for the other has the second name.
        let names = [error, term.other.parse().ok()?];
        let [first, second, _] = pair(plane);
        let is_omitted = omitted.contains(&term.name);
        let is_missing = is_open(&term.name, [first, second])
            && !states_squareness(start, error, [first, second])
            && (is_omitted || !names.into_iter().any(|name| sets.iter().any(|set| shows(machine, name, set))));
        is_missing.then_some(term.name)
    };
    let mut names: Vec<String> = [Plane::XY, Plane::ZX, Plane::YZ].into_iter().filter_map(of_plane).collect();
    // Positioning and straightness: what the file states, or an earlier calibration has shown, is known.
    let is_unknown = |axis: Axis, name: &ErrorName| {
        let is_listed = earlier.is_some_and(|one| one.not_shown.iter().flatten().any(|one| *one == name.to_string()));
        let was_measured = earlier.is_some_and(|one| one.axes.contains_key(&axis));
        let is_stated = start.motion.iter().any(|error| error.name == *name);
        (is_listed || !was_measured) && !is_stated && !sets.iter().any(|set| shows_shape(machine, *name, axis, set))
    };
    for axis in AXES.into_iter().filter(|axis| !axis.is_rotary() && ranges.axes.contains_key(axis)) {
        let own = DIRECTIONS[..3].iter().map(|&direction| ErrorName::motion(direction, axis));
        names.extend(own.filter(|name| is_unknown(axis, name)).map(|name| name.to_string()));
    }
    let was_stated = earlier.is_some_and(|earlier| earlier.not_shown.is_some());
    (was_stated || !names.is_empty()).then_some(names)
}

/// The squareness errors of a machine about which neither a model nor the errors at the start say anything.
pub(super) fn lacking(machine: &Machine, start: &ErrorModel, parameters: &[Parameter]) -> Vec<ParameterName> {
    let direction = |axis: Axis| machine.axis(axis).map(|data| data.direction);
    let of_plane = |plane: Plane| {
        let term = squareness(&machine.topology, plane, direction)?;
        let names: [ErrorName; 2] = [term.name.parse().ok()?, term.other.parse().ok()?];
        let [first, second, _] = pair(plane);
        let is_fitted = |name: &ErrorName| parameters.contains(&Parameter::from(ParameterName::location(*name)));
        let is_known = names.iter().any(is_fitted) || states_squareness(start, names[0], [first, second]);
        (!is_known).then(|| ParameterName::location(names[0]))
    };
    [Plane::XY, Plane::ZX, Plane::YZ].into_iter().filter_map(of_plane).collect()
}

/// True if the readings of a measurement can show the positioning of an axis, or the bow of a straightness, beside the unknowns of its set-ups.
fn shows_shape(machine: &Machine, name: ErrorName, axis: Axis, set: &DataSet) -> bool {
    let degree = if name.direction.index() == axis.dimension() { 1 } else { 2 };
    let parameter = Parameter::from(ParameterName::coefficient(name, degree));
    let found = identify(machine, &ErrorModel::default(), &[parameter], std::slice::from_ref(set));
    found.is_some_and(|found| found.inflation.first().is_some_and(|inflation| inflation.is_finite()))
}

/// True if the readings of a measurement can show a squareness beside the unknowns of its set-ups.
fn shows(machine: &Machine, error: ErrorName, set: &DataSet) -> bool {
    let parameter = Parameter::from(ParameterName::location(error));
    let found = identify(machine, &ErrorModel::default(), &[parameter], std::slice::from_ref(set));
    found.is_some_and(|found| found.inflation.first().is_some_and(|inflation| inflation.is_finite()))
}
