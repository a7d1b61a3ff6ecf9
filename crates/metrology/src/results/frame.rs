//! The frame of a fitted model: that of the mean lines of the axes, where no reading fixes it.
//!
//! Ball-bar circles show the angle between two axes and the bow of each, but not the direction of the axes: a machine that is turned as a whole has the same
//! readings. A model without slopes then has the directions of the tangents at the zeros of the axes. A bow turns such a tangent by tens of µrad from the mean
//! line, which is the direction of the axis (ISO 230-1), and the squareness with it. So each bow gets the slope that makes it straight on average, and the
//! other unknowns change so that all readings remain as fitted.

use super::calibrated::MeanLineReport;
use super::measurement::{Measurement, data_of};
use super::slope::{curve_range, is_across, numbers_of, range};
use crate::calibrate::mean_line::{MeanLine, level, level_factor, mean_slope, steepest};
use crate::calibrate::{Column, Estimate, Fit, Parameter, equivalents, tip_effects};
use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, Axis, Plane};
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::squareness::{pair, squareness};
use ncfix_model::ErrorModel;
use ncfix_model::name::{DIRECTIONS, ErrorKind, ErrorName};
use ncfix_model::parameter::{ComponentTerm, ParameterName};

/// Mean slope that counts as none, as a share of the slope at the zero of the axis.
const LEVEL: f64 = 1e-3;

/// Refers a fit to the mean lines of the axes whose direction no reading fixes. `of_noise` is the same fit without the contributions to its uncertainty that
/// repetitions do not have.
pub(super) fn refer(
    (machine, start): (&Machine, &ErrorModel),
    parameters: &[Parameter],
    used: &[Measurement],
    fit: &mut Fit,
    of_noise: Option<&mut Fit>,
) -> Vec<MeanLineReport> {
    let data = data_of(used);
    let frame = FittedFrame { machine, start, parameters, used, data: &data };
    let lines = frame.lines(fit);
    if lines.is_empty() {
        return Vec::new();
    }
    if let Some(of_noise) = of_noise {
        let lines = lines.iter().map(|line| MeanLine { turn: 0.0, ..line.clone() }).collect();
        frame.enter(lines, of_noise);
    }
    let report = |line: &MeanLine| MeanLineReport {
        slope: line.slope.to_string(),
        from_mm: line.range[0],
        to_mm: line.range[1],
        turn_urad: 1e6 * line.turn,
    };
    let shown = lines.iter().map(report).collect();
    frame.enter(lines, fit);
    shown
}

struct FittedFrame<'a> {
    machine: &'a Machine,
    start: &'a ErrorModel,
    parameters: &'a [Parameter],
    used: &'a [Measurement],
    data: &'a [DataSet],
}

impl FittedFrame<'_> {
    /// The mean lines to which a fit is referred.
    fn lines(&self, fit: &Fit) -> Vec<MeanLine> {
        [Plane::XY, Plane::ZX, Plane::YZ].into_iter().flat_map(|plane| self.of_plane(plane, fit)).collect()
    }

    /// Those of a plane: none if the readings fix the direction of an axis in it.
    fn of_plane(&self, plane: Plane, fit: &Fit) -> Vec<MeanLine> {
        let [first, second, _] = pair(plane);
        let across = |axis: Axis| match axis.dimension() {
            own if own == first.dimension() => Some(second.dimension()),
            own if own == second.dimension() => Some(first.dimension()),
            _ => None,
        };
        let moves = |axis: &Axis| range(self.used, *axis).is_some_and(|[low, high]| low < high);
        let slopes: Vec<ParameterName> = AXES
            .into_iter()
            .filter(|axis| !axis.is_rotary() && self.machine.axis(*axis).is_some())
            .filter(moves)
            .filter_map(|axis| Some(ParameterName::coefficient(ErrorName::motion(DIRECTIONS[across(axis)?], axis), 1)))
            .collect();
        let is_fitted = |slope: &ParameterName| self.parameters.contains(&Parameter::from(*slope));
        let curved: Vec<(ParameterName, MeanLine)> = slopes
            .iter()
            .filter(|slope| !is_fitted(slope))
            .filter_map(|slope| Some((*slope, self.curve(*slope, fit)?)))
            .collect();
        if curved.is_empty() {
            return Vec::new();
        }
        let (known, free): (Vec<ParameterName>, Vec<ParameterName>) = slopes.into_iter().partition(is_fitted);
        let wanted: Vec<Parameter> = free.iter().copied().map(Parameter::from).collect();
        let changes = equivalents(self.machine, &fit.errors, &wanted, self.parameters, self.data);
        if changes.iter().any(Option::is_none) || !known.into_iter().all(|slope| self.is_free(plane, slope, fit)) {
            return Vec::new();
        }
        let carriers = |slope: &ParameterName| -> Option<Vec<(usize, f64)>> {
            let changes = free.iter().zip(&changes).find(|(own, _)| *own == slope)?.1.as_ref()?;
            let all = changes.iter().copied().enumerate().filter(|(_, change)| *change != 0.0);
            let all: Vec<(usize, f64)> = all.collect();
            // Without a parameter of the machine, only the alignment of an instrument contains the slope.
            let mut of_machine = all.iter().filter_map(|&(column, _)| self.parameters.get(column)).peekable();
            of_machine.peek()?;
            of_machine.all(turns_linear_axes).then_some(all)
        };
        let with = |(slope, line): (ParameterName, MeanLine)| Some(MeanLine { carriers: carriers(&slope)?, ..line });
        curved.into_iter().filter_map(with).collect()
    }

    /// True if the readings do not fix a fitted slope beside a squareness of the plane.
    fn is_free(&self, plane: Plane, slope: ParameterName, fit: &Fit) -> bool {
        let direction = |axis| self.machine.axis(axis).map(|data| data.direction);
        let Some(term) = squareness(&self.machine.topology, plane, direction) else { return false };
        let angle = |name: &String| name.parse::<ErrorName>().ok().map(ParameterName::location).map(Parameter::from);
        let Some(own) = angle(&term.name) else { return false };
        let mut others: Vec<Parameter> = self.parameters.to_vec();
        others.retain(|one| *one != Parameter::from(slope));
        if !others.iter().any(|one| *one == own || Some(one) == angle(&term.other).as_ref()) {
            others.push(own);
        }
        let found = equivalents(self.machine, &fit.errors, &[slope.into()], &others, self.data);
        found.first().is_some_and(Option::is_some)
    }

    /// The mean line of a fitted curve, without its carriers; `None` for a straightness without one, or with a measured slope.
    fn curve(&self, slope: ParameterName, fit: &Fit) -> Option<MeanLine> {
        let axis = slope.component.axis()?;
        let fitted = numbers_of(slope.component, self.parameters);
        let bends = |name: &ParameterName| match name.term {
            ComponentTerm::Coefficient(degree) => degree > 1,
            ComponentTerm::Knot { degree, .. } => degree > 0,
            _ => false,
        };
        let curve: Vec<ParameterName> = fitted.into_iter().filter(bends).collect();
        if curve.is_empty() || !is_across(slope.component, axis) {
            return None;
        }
        let range = curve_range(self.machine, fit, &curve, self.used, axis)?;
        let mean = |errors: &ErrorModel, range: [f64; 2]| -> f64 {
            curve.iter().map(|name| name.get(errors) * mean_slope(name, axis, range)).sum()
        };
        // A slope of the start file is a measured one, unless it is that of an earlier fit.
        let given = slope.get(self.start);
        if given != 0.0 && (mean(self.start, range) + given).abs() > LEVEL * given.abs() {
            return None;
        }
        let amount = -mean(&fit.errors, range);
        let whole: Vec<(ParameterName, f64)> =
            curve.iter().map(|name| (*name, name.get(&fit.errors))).chain([(slope, amount)]).collect();
        // Beyond the range, the curve is an extrapolation: the axis is not more inclined there than the curve within the range.
        let travel = self.machine.axis(axis)?.travel;
        let beyond = travel.map_or(0.0, |travel| (mean(&fit.errors, travel) + amount).abs());
        let turn = beyond.min(steepest(&whole, axis, range));
        let place = |name: &ParameterName| self.parameters.iter().position(|one| *one == Parameter::from(*name));
        let curve = curve.iter().filter_map(|name| Some((place(name)?, mean_slope(name, axis, range)))).collect();
        Some(MeanLine { slope, range, curve, carriers: Vec::new(), turn })
    }

    /// Refers a fit to mean lines: values, uncertainties, and the covariance of its parameters.
    fn enter(&self, lines: Vec<MeanLine>, fit: &mut Fit) {
        let mut values: Vec<f64> = fit.estimates.iter().map(|one| one.value).collect();
        level(&lines, &fit.errors, &mut values);
        let width = fit.factor.iter().map(Vec::len).max().unwrap_or(0);
        level_factor(&lines, &mut fit.factor);
        let slopes = lines.iter().map(|line| Parameter::from(line.slope));
        // No reading shows the slope: it follows from the curve.
        let added = slopes.map(|slope| Estimate {
            column: Column::from(slope),
            value: 0.0,
            sigma: 0.0,
            inflation: f64::INFINITY,
            effect_mm: 0.0,
        });
        fit.estimates.extend(added);
        let of_machine: Vec<usize> =
            (0..fit.estimates.len()).filter(|&place| fit.estimates[place].column.is_of_machine()).collect();
        let parameters: Vec<Parameter> =
            of_machine.iter().filter_map(|&place| fit.estimates[place].column.parameter()).collect();
        let effects = tip_effects(self.machine, &fit.errors, &parameters, self.data);
        for (estimate, value) in fit.estimates.iter_mut().zip(&values) {
            estimate.value = *value;
        }
        let changed = |column: usize| {
            column >= self.parameters.len() || lines.iter().flat_map(|line| &line.carriers).any(|own| own.0 == column)
        };
        for (number, &place) in of_machine.iter().enumerate().filter(|(number, _)| changed(*number)) {
            let (Some(estimate), Some(row)) = (fit.estimates.get_mut(place), fit.factor.get(number)) else { continue };
            let size = |parts: &mut dyn Iterator<Item = &f64>| parts.map(|part| part * part).sum::<f64>().sqrt();
            // The variance that the readings would leave without the other unknowns is the same.
            if estimate.sigma > 0.0 {
                estimate.inflation *= (size(&mut row.iter().take(width)) / estimate.sigma).powi(2);
            }
            estimate.sigma = size(&mut row.iter());
            estimate.effect_mm = effects.get(number).copied().unwrap_or(0.0) * estimate.value.abs();
        }
        for (parameter, &place) in parameters.iter().zip(&of_machine) {
            parameter.set(&mut fit.errors, values[place]);
        }
        fit.mean_lines = lines;
    }
}

/// True for a parameter that turns linear axes or the spindle: a rotation of the location, or a slope of a straightness.
fn turns_linear_axes(parameter: &Parameter) -> bool {
    let Parameter::Geometry(name) = parameter else { return false };
    let component = name.component;
    match (component.kind, component.axis()) {
        (ErrorKind::Location, axis) => component.direction.is_rotation() && axis.is_none_or(|axis| !axis.is_rotary()),
        (ErrorKind::Motion, Some(axis)) => {
            name.term == ComponentTerm::Coefficient(1) && !axis.is_rotary() && is_across(component, axis)
        }
        _ => false,
    }
}
