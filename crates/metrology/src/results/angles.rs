//! Angular errors of linear axes (EAX, EBX, ECX) that no reading of a calibration can show.
//!
//! A laser reads along one line, and a straightness optic too. An angle displaces the tool by its distance from this line, and on the line it looks like a scale or a
//! straightness. The error model then has no angle, and nothing distinguishes it from a measured one of zero. The test shape of an angle is the simplest one that is
//! not a squareness: it grows linearly along its axis.

use super::rotary_places::spread;
use crate::calibrate::{Parameter, identify};
use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, Axis, AxisVector, Vector};
use ncfix_base::numeric::System;
use ncfix_machine::machine::{Machine, MeasuredRanges};
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::{ErrorModel, Model, ParameterName};

/// Number of poses in the measured ranges at which effects are compared.
const POSES: usize = 80;
/// Highest power of a straightness or positioning error that may look like an angle: an angle that grows linearly, at an arm that grows along the same axis.
const POWER: u8 = 2;
/// Difference of tool lengths below which they are one, mm.
pub(super) const ONE_LENGTH_MM: f64 = 1.0;
/// Arm below which an angle has no effect, RMS over the measured ranges, mm: 10 µrad displace the tool by 0.01 µm.
const LEAST_ARM_MM: f64 = 1.0;
/// Growth of the scatter of readings, by which they do not show an error: that of its effect over the measured ranges, as a multiple of that of the readings.
const MOST_GROWTH: f64 = 10.0;

/// An angular error that displaces the tool in the measured ranges as no straightness and no squareness does.
pub(super) struct EffectiveAngle {
    pub(super) name: ErrorName,
    /// Displacement of the tool by 1 rad per mm of its axis, without the part of other errors: RMS over the measured ranges, mm² per rad.
    effect: f64,
}

/// The angular errors with an effect of their own in the measured ranges, for their tools. If several have the same effect, it belongs to the first.
pub(super) fn with_effect(machine: &Machine, ranges: &MeasuredRanges) -> Vec<EffectiveAngle> {
    let model = Model::new(machine, &ErrorModel::default());
    let linear: Vec<(Axis, [f64; 2])> =
        ranges.axes.iter().map(|(&axis, &range)| (axis, range)).filter(|(axis, _)| !axis.is_rotary()).collect();
    let poses = poses(machine, ranges);
    let lengths_mm = ranges.tool_length_mm.unwrap_or_default();
    let is_one_length = lengths_mm[1] - lengths_mm[0] <= ONE_LENGTH_MM;
    let tools = lengths_mm.map(|length_mm| machine.spindle.axis * -length_mm);
    let tools = if is_one_length { &tools[1..] } else { &tools[..] };
    let places: Vec<(&AxisVector, &Vector)> =
        poses.iter().flat_map(|pose| tools.iter().map(move |tool| (pose, tool))).collect();
    // Displacement at every place by an error that is a power of the position, from −1 to 1 in its range.
    let column = |name: ErrorName, power: u8, [low, high]: [f64; 2]| -> Vec<f64> {
        let at = |(pose, tool): &(&AxisVector, &Vector)| {
            let share = name.axis().map_or(0.0, |axis| (2.0 * pose[axis] - low - high) / (high - low));
            model.sensitivity(name, pose, tool).translation * share.powi(i32::from(power))
        };
        places.iter().map(at).flat_map(|moved| [moved.x, moved.y, moved.z]).collect()
    };
    let mut others: Vec<Vec<f64>> = Vec::new();
    for &(axis, range) in &linear {
        for direction in &DIRECTIONS[..3] {
            others.extend((0..=POWER).map(|power| column(ErrorName::motion(*direction, axis), power, range)));
        }
        // A constant angle is a squareness.
        others.extend(DIRECTIONS[3..].iter().map(|direction| column(ErrorName::motion(*direction, axis), 0, range)));
    }
    let mut found = Vec::new();
    for &(axis, range) in &linear {
        for direction in &DIRECTIONS[3..] {
            let name = ErrorName::motion(*direction, axis);
            let own = column(name, 1, range);
            let arm_mm = own_part(&own, &others) / (places.len() as f64).sqrt();
            if arm_mm > LEAST_ARM_MM {
                others.push(own);
                found.push(EffectiveAngle { name, effect: arm_mm * 0.5 * (range[1] - range[0]) });
            }
        }
    }
    found
}

/// Length of the part of a column that is no combination of others.
fn own_part(column: &[f64], others: &[Vec<f64>]) -> f64 {
    let length = column.iter().map(|value| value * value).sum::<f64>().sqrt();
    let mut system = System::new(1 + others.len());
    let mut row = vec![0.0; 1 + others.len()];
    for (place, value) in column.iter().enumerate() {
        row[0] = *value;
        row[1..].iter_mut().zip(others).for_each(|(factor, other)| *factor = other[place]);
        system.add(&row, 0.0, 1.0);
    }
    let inflation = system.solve().and_then(|solution| solution.inflation.first().copied());
    inflation.filter(|inflation| *inflation > 0.0).map_or(0.0, |inflation| length / inflation.sqrt())
}

/// Poses in the measured ranges. An axis that was not measured is in its zero position, or at the end of its travel next to it.
fn poses(machine: &Machine, ranges: &MeasuredRanges) -> Vec<AxisVector> {
    spread(machine, POSES, |axis| {
        let travel = machine.axis(axis).and_then(|data| data.travel);
        let zero = travel.map_or(0.0, |[low, high]| 0.0_f64.clamp(low, high));
        ranges.axes.get(&axis).copied().unwrap_or([zero; 2])
    })
}

/// The angles of these that readings show: they separate each from the others, from slopes and bows of all linear axes, from these further errors, and from the
/// unknowns of the set-ups.
pub(super) fn shown(
    machine: &Machine,
    angles: &[EffectiveAngle],
    others: &[ParameterName],
    data: &[DataSet],
) -> Vec<ErrorName> {
    if angles.is_empty() {
        return Vec::new();
    }
    let linear = AXES.into_iter().filter(|&axis| !axis.is_rotary() && machine.axis(axis).is_some());
    let lines = linear.flat_map(|axis| DIRECTIONS[..3].iter().map(move |&of| ErrorName::motion(of, axis)));
    let of_lines = lines.flat_map(|line| (1..=POWER).map(move |degree| ParameterName::coefficient(line, degree)));
    // A reading at one position of the axis shows its angle there, and no change of it.
    let own = [1, 0]
        .into_iter()
        .flat_map(|degree| angles.iter().map(move |angle| ParameterName::coefficient(angle.name, degree)));
    let mut all: Vec<ParameterName> = own.chain(of_lines).collect();
    let further: Vec<ParameterName> = others.iter().filter(|name| !all.contains(name)).copied().collect();
    all.extend(further);
    let parameters: Vec<Parameter> = all.into_iter().map(Parameter::from).collect();
    let Some(found) = identify(machine, &ErrorModel::default(), &parameters, data) else { return Vec::new() };
    let is_shown = |(angle, (sigma, inflation)): &(&EffectiveAngle, (&f64, &f64))| {
        inflation.is_finite() && *sigma * angle.effect < MOST_GROWTH
    };
    let columns = found.sigmas.iter().zip(&found.inflation);
    angles.iter().zip(columns).filter(is_shown).map(|(angle, _)| angle.name).collect()
}
