//! The model `auto`: the usual errors of a machine, of which the rank analysis ([`super::reduce()`]) keeps those that the data determine, and the candidates
//! among which [`super::select()`] chooses further terms.
//!
//! The usual errors are, in this order: offsets and tilts of the rotary axes, squareness of the linear axes, offsets of the spindle if a rotary axis carries it,
//! tilts of the spindle if the tools have several lengths,
//! scales of the linear axes (degree 1 of their positioning), and backlash. Of errors that are not separable, the later one is left out. Candidates are the
//! curves of components that were measured, without degree 1 of a straightness, which is a squareness or the alignment of the instrument. Angles of linear axes
//! are candidates if the readings show them, for example with tools of two lengths.

use crate::measure::data::{DataSet, Free};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::{AXES, Axis, Plane, ROTARY_AXES};
use ncfix_machine::machine::squareness::squareness;
use ncfix_machine::machine::{Branch, Machine};
use ncfix_model::ErrorModel;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::{ComponentTerm, ParameterName};

use super::candidates::{PiecewisePolynomials, of_component};
use super::sorted::sorted_axes;

/// Tools whose lengths differ by less have one length, mm.
const ONE_LENGTH_MM: f64 = 1.0;
/// Length of a travel below which an axis counts as standing, mm or rad.
const STANDS: f64 = 1e-6;

/// The usual errors of a machine for these data, in the order in which they stay.
#[must_use]
pub fn usual_errors(machine: &Machine, errors: &ErrorModel, data: &[DataSet]) -> Vec<ParameterName> {
    let mut rotary: Vec<Axis> = ROTARY_AXES.into_iter().filter(|&axis| machine.axis(axis).is_some()).collect();
    // Beside an axis that stands, the errors of one that moves are those that the readings show.
    rotary.sort_by_key(|&axis| !data.iter().any(|set| moves(set, axis)));
    let mut all: Vec<ParameterName> = Vec::new();
    for &axis in &rotary {
        // Neither a shift along an axis of rotation nor a turn about it is an error of its place.
        let about = DIRECTIONS.into_iter().enumerate().filter(|(place, _)| place % 3 != axis.dimension());
        all.extend(about.map(|(_, direction)| ParameterName::location(ErrorName::location(direction, axis))));
    }
    let direction = |axis: Axis| machine.axis(axis).map(|data| data.direction);
    let is_stated = |name: &str| name.parse::<ParameterName>().is_ok_and(|name| name.get(errors) != 0.0);
    for plane in [Plane::XY, Plane::ZX, Plane::YZ] {
        let Some(term) = squareness(&machine.topology, plane, direction) else { continue };
        let name = if is_stated(&term.other) { &term.other } else { &term.name };
        all.extend(name.parse::<ParameterName>());
    }
    if rotary.iter().any(|&axis| machine.topology.branch(axis) == Some(Branch::Tool)) {
        let along = machine.spindle.axis.iamax();
        let across = DIRECTIONS.into_iter().take(3).enumerate().filter(|(place, _)| *place != along);
        all.extend(across.map(|(_, direction)| ParameterName::location(ErrorName::spindle(direction))));
    }
    all.extend(spindle_tilts(machine, data).map(ParameterName::location));
    let linear: Vec<Axis> =
        AXES.into_iter().filter(|&axis| !axis.is_rotary() && machine.axis(axis).is_some()).collect();
    all.extend(linear.iter().map(|&axis| ParameterName::coefficient(positioning(axis), 1)));
    let reversing: Vec<&DataSet> = data.iter().filter(|set| shows_reversals(set)).collect();
    if !data.iter().any(|set| set.free.contains(&Free::Drift)) {
        let moved = AXES.into_iter().filter(|&axis| machine.axis(axis).is_some());
        let is_read =
            |axis: &Axis| reversing.iter().any(|set| moves(set, *axis) && !sorted_axes(machine, set).contains(axis));
        let reversed = moved.filter(is_read);
        all.extend(reversed.map(|axis| ParameterName::backlash(positioning(axis))));
    }
    all
}

/// The candidates for further terms; empty if the data show no curves.
#[must_use]
pub fn usual_candidates(machine: &Machine, data: &[DataSet], pieces: PiecewisePolynomials) -> Vec<ParameterName> {
    let mut components: Vec<ErrorName> = Vec::new();
    let mut add = |name: ErrorName| {
        if !components.contains(&name) {
            components.push(name);
        }
    };
    for set in data {
        match set.kind.measurand {
            Measurand::Component => set
                .observations
                .iter()
                .filter_map(|row| row.component.filter(|name| !name.is_location()))
                .for_each(&mut add),
            Measurand::BallDistance | Measurand::Displacement | Measurand::LineLength => {
                let linear = AXES.into_iter().filter(|axis| !axis.is_rotary() && machine.axis(*axis).is_some());
                for axis in linear.filter(|&axis| moves(set, axis)) {
                    DIRECTIONS.into_iter().take(3).for_each(|direction| add(ErrorName::motion(direction, axis)));
                }
            }
            _ => {}
        }
    }
    let is_alignment = |name: &ParameterName| {
        let is_slope = matches!(name.term, ComponentTerm::Coefficient(1));
        is_slope
            && !name.component.direction.is_rotation()
            && name.component.axis().map(positioning) != Some(name.component)
    };
    let terms = components.into_iter().flat_map(|component| of_component(component, data, pieces));
    terms.filter(|name| !is_alignment(name)).collect()
}

/// The tilts of the spindle that readings may show: those that were read, and both across its axis if the tools have several lengths. Such tools show
/// the angle between an axis and the spindle. A spindle that counts as exact would give the axis its own tilt.
fn spindle_tilts(machine: &Machine, data: &[DataSet]) -> impl Iterator<Item = ErrorName> {
    let axis = machine.spindle.axis;
    let lengths = data.iter().flat_map(|set| &set.observations).map(|row| row.reading.tool_mm.dot(&axis));
    let [low, high] =
        lengths.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], length| [low.min(length), high.max(length)]);
    let has_lengths = high - low > ONE_LENGTH_MM;
    let along = axis.iamax();
    let across = DIRECTIONS.into_iter().skip(3).enumerate().filter(move |(place, _)| *place != along);
    across.map(|(_, direction)| ErrorName::spindle(direction)).filter(move |tilt| {
        has_lengths || data.iter().any(|set| set.observations.iter().any(|row| row.component == Some(*tilt)))
    })
}

/// The candidates for angular errors that the readings show: polynomials, which the displacements at a few arms separate from straightness and positioning.
#[must_use]
pub fn angle_candidates(angles: &[ErrorName], pieces: PiecewisePolynomials) -> Vec<ParameterName> {
    let terms = |angle: &ErrorName| {
        let angle = *angle;
        (1..=pieces.degree).map(move |degree| ParameterName::coefficient(angle, degree))
    };
    angles.iter().flat_map(terms).collect()
}

/// The error of an axis along or about itself, by its letter.
fn positioning(axis: Axis) -> ErrorName {
    ErrorName::motion(DIRECTIONS[axis.dimension() + if axis.is_rotary() { 3 } else { 0 }], axis)
}

/// True if an axis has several positions in the readings.
fn moves(set: &DataSet, axis: Axis) -> bool {
    let positions = || set.observations.iter().map(|row| row.reading.position[axis]);
    positions().next().is_some_and(|first| positions().any(|at| (at - first).abs() > STANDS))
}

/// True if directions of approach of the rows are those of the axes: a probe approaches in its own directions, and sorted rows have none.
fn shows_reversals(set: &DataSet) -> bool {
    let measurand = set.kind.measurand;
    set.has_senses || set.is_in_order && !matches!(measurand, Measurand::BallPlace | Measurand::Other)
}
