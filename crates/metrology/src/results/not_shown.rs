//! Squareness, positioning, straightness and angular errors, tilts of the spindle, and places of rotary axes, that no reading of a calibration can show.
//!
//! A laser along X and another along Y say nothing about the angle between the two axes, and neither does a straightness whose reference was aligned by hand.
//! The error model then has no squareness, and nothing distinguishes it from a measured one of zero. So the machine file names it.

use super::angles::{ONE_LENGTH_MM, shown, with_effect};
use super::rotary_places::{places, shows_place};
use crate::calibrate::automatic::usual_errors;
use crate::calibrate::{Parameter, identify};
use crate::measure::data::DataSet;
use crate::measure::ranges::measured_ranges;
use ncfix_base::geometry::{AXES, Axis, Plane};
use ncfix_machine::machine::squareness::{pair, squareness};
use ncfix_machine::machine::{Machine, MeasuredRanges};
use ncfix_model::coverage::{states_place, states_slope, states_squareness};
use ncfix_model::motion::EntryFunction;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::ComponentTerm;
use ncfix_model::{ErrorModel, MotionError, ParameterName};

/// Length of a travel below which an axis counts as standing, mm or rad.
const STANDS: f64 = 1e-6;

/// Component of the spindle axis above which a turn about this direction is no tilt.
const ALONG: f64 = 0.99;

/// The names for [`MeasuredRanges::not_shown`]: pairs of measured axes whose squareness neither the errors at the start nor any of these measurements show,
/// and likewise errors of one measured axis, its angles if they have an effect of their own in the measured ranges, and places of rotary axes.
/// `ranges` are those after the measurements. The readings show an error only if they separate it from the location errors and scales of the machine.
/// A squareness that they show and the model lacks, or that was left out of it (`omitted`), remains unknown: other parameters have absorbed it. What the fit
/// has found (`fitted`) is known, and so is what an earlier calibration has shown. `None` if there is nothing to state.
#[must_use]
pub fn not_shown(
    machine: &Machine,
    start: &ErrorModel,
    ranges: &MeasuredRanges,
    sets: &[&DataSet],
    (omitted, fitted): (&[String], &[ParameterName]),
) -> Option<Vec<String>> {
    let data: Vec<DataSet> = sets.iter().map(|set| (*set).clone()).collect();
    let others = separate_from(machine, start, &data);
    let shows = |name: ParameterName| shows_beside(machine, name, &others, &data);
    // A backlash says nothing about the mean of both directions.
    let is_fitted =
        |name: &ErrorName| fitted.iter().any(|own| own.component == *name && own.term != ComponentTerm::Backlash);
    let states = |name: &ErrorName| {
        let of = |error: &&MotionError| error.name == *name && !matches!(error.function, EntryFunction::Backlash(_));
        start.motion.iter().any(|error| of(&error))
    };
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
        let is_omitted = omitted.contains(&term.name) && !names.iter().any(is_fitted);
        let is_missing = is_open(&term.name, [first, second])
            && !states_squareness(start, error, [first, second])
            && (is_omitted || !names.iter().any(|name| is_fitted(name) || shows(ParameterName::location(*name))));
        is_missing.then_some(term.name)
    };
    let mut names: Vec<String> = [Plane::XY, Plane::ZX, Plane::YZ].into_iter().filter_map(of_plane).collect();
    // Positioning and straightness: what the file states, or an earlier calibration has shown, is known.
    let is_unknown = |axis: Axis, name: &ErrorName| {
        let is_listed = earlier.is_some_and(|one| one.not_shown.iter().flatten().any(|one| *one == name.to_string()));
        let was_measured = earlier.is_some_and(|one| one.axes.contains_key(&axis));
        let is_stated = states(name);
        // A scale, or the bow of a straightness.
        let degree = if name.direction.index() == axis.dimension() { 1 } else { 2 };
        let is_open = (is_listed || !was_measured) && !is_stated && !is_fitted(name);
        is_open && !shows(ParameterName::coefficient(*name, degree))
    };
    for axis in AXES.into_iter().filter(|axis| !axis.is_rotary() && ranges.axes.contains_key(axis)) {
        let own = DIRECTIONS[..3].iter().map(|&direction| ErrorName::motion(direction, axis));
        names.extend(own.filter(|name| is_unknown(axis, name)).map(|name| name.to_string()));
    }
    // Where one scale is left open, the others are relative to it, unless the readings show them alone.
    let scale = |axis: Axis| DIRECTIONS.get(axis.dimension()).map(|&direction| ErrorName::motion(direction, axis));
    let linear = || AXES.into_iter().filter(|axis| !axis.is_rotary() && ranges.axes.contains_key(axis));
    if linear().filter_map(scale).any(|name| names.contains(&name.to_string())) {
        let is_relative = |axis: Axis, name: &ErrorName| {
            let is_listed =
                earlier.is_some_and(|one| one.not_shown.iter().flatten().any(|one| *one == name.to_string()));
            let was_measured = earlier.is_some_and(|one| one.axes.contains_key(&axis));
            let is_known = was_measured && !is_listed || states(name);
            !is_known && is_fitted(name) && !shows(ParameterName::coefficient(*name, 1))
        };
        let relative: Vec<String> = linear()
            .filter_map(|axis| scale(axis).filter(|name| is_relative(axis, name)))
            .map(|name| name.to_string())
            .filter(|name| !names.contains(name))
            .collect();
        names.extend(relative);
    }
    // The place of a rotary axis that was measured.
    for place in places(machine) {
        let of = |measured: &MeasuredRanges| place.axes.iter().any(|axis| measured.axes.contains_key(axis));
        let name = place.name.to_string();
        let is_listed = earlier.is_some_and(|one| one.not_shown.iter().flatten().any(|listed| *listed == name));
        let is_known = !is_listed && earlier.is_some_and(of) || states_place(start, place.name);
        if of(ranges) && !is_known && !sets.iter().any(|set| shows_place(machine, &place, set)) {
            names.push(name);
        }
    }
    // Several tool lengths show how far the spindle is tilted only if they meet at one place. Heads were looked at above.
    let has_lengths = ranges.tool_length_mm.is_some_and(|[low, high]| high - low > ONE_LENGTH_MM);
    let turns = machine.topology.tool.iter().any(|axis| axis.is_rotary());
    if has_lengths && !turns {
        let is_open = |name: &ErrorName| {
            let is_known = states_place(start, *name) || is_fitted(name);
            !is_known && !shows(ParameterName::location(*name))
        };
        let tilts = DIRECTIONS[3..].iter().filter(|of| machine.spindle.axis[of.index() % 3].abs() < ALONG);
        let tilts = tilts.map(|&of| ErrorName::spindle(of)).filter(is_open).map(|name| name.to_string());
        let new: Vec<String> = tilts.filter(|name| !names.contains(name)).collect();
        names.extend(new);
    }
    // Angles: an earlier calibration has judged those that had an effect in its ranges.
    let judged = earlier.map_or_else(Vec::new, |earlier| with_effect(machine, earlier));
    let is_open = |name: &ErrorName| {
        let is_listed = earlier.is_some_and(|one| one.not_shown.iter().flatten().any(|one| *one == name.to_string()));
        let is_known = !is_listed && judged.iter().any(|angle| angle.name == *name);
        !is_known && !is_fitted(name) && !states(name)
    };
    let angles = with_effect(machine, ranges);
    if angles.iter().any(|angle| is_open(&angle.name)) {
        let shown = shown(machine, &angles, &others, &data);
        let open = angles.iter().map(|angle| angle.name).filter(|name| is_open(name) && !shown.contains(name));
        names.extend(open.map(|name| name.to_string()));
    }
    let was_stated = earlier.is_some_and(|earlier| earlier.not_shown.is_some());
    (was_stated || !names.is_empty()).then_some(names)
}

/// The angular errors of linear axes that these readings show beside location errors, scales, slopes and bows, and that displace the tool within their ranges.
#[must_use]
pub fn shown_angles(machine: &Machine, start: &ErrorModel, data: &[DataSet]) -> Vec<ErrorName> {
    let angles = with_effect(machine, &measured_ranges(machine, data, None));
    shown(machine, &angles, &separate_from(machine, start, data), data)
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

/// The location errors and scales beside which readings must show another error. The places of a rotary axis that stands are those of the set-ups.
fn separate_from(machine: &Machine, start: &ErrorModel, data: &[DataSet]) -> Vec<ParameterName> {
    let turns = |axis: Axis| {
        let mut places = data.iter().flat_map(|set| &set.observations).map(|row| row.reading.position[axis]);
        places.next().is_some_and(|first| places.any(|at| (at - first).abs() > STANDS))
    };
    let is_needed = |name: &ParameterName| {
        let stands = name.component.axis().is_some_and(|axis| axis.is_rotary() && !turns(axis));
        name.term != ComponentTerm::Backlash && !stands
    };
    usual_errors(machine, start, data).into_iter().filter(is_needed).collect()
}

/// True if readings can show an error beside the others and the unknowns of the set-ups. Either name of a squareness is the same angle.
fn shows_beside(machine: &Machine, error: ParameterName, others: &[ParameterName], data: &[DataSet]) -> bool {
    let is_other = |name: &&ParameterName| {
        let is_angle = |name: &ParameterName| {
            name.term == ComponentTerm::Whole && name.component.axis().is_some_and(|axis| !axis.is_rotary())
        };
        let is_same_angle = is_angle(name) && is_angle(&error) && name.component.direction == error.component.direction;
        **name != error && !is_same_angle
    };
    let parameters: Vec<Parameter> =
        std::iter::once(&error).chain(others.iter().filter(is_other)).map(|name| Parameter::from(*name)).collect();
    let found = identify(machine, &ErrorModel::default(), &parameters, data);
    found.is_some_and(|found| found.inflation.first().is_some_and(|inflation| inflation.is_finite()))
}
