//! The equations of all readings: the derivative of each with respect to each unknown, and the residuals.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::measure::data::DataSet;
use crate::measure::kind::{Equation, Seen};
use ncfix_base::geometry::{AxisVector, Matrix, Vector};
use ncfix_base::numeric::in_parts;
use ncfix_machine::machine::{Condition, Machine};
use ncfix_model::parameter::ParameterName;
use ncfix_model::{ErrorModel, ErrorName, Model};

use super::column::Column;
use super::effect::{EffectParameter, Parameter};
use super::row_store::RowStore;
use super::unit::{Units, number_of};

/// Default standard uncertainty of known distances, mm.
pub(super) const TIE_SIGMA: f64 = 1e-4;

/// Largest derivative of a set-up unknown below which it is not identifiable, such as the position of a ball across a circle: 0.1 mm would change
/// readings by less than 1 µm, less than its own square.
pub(crate) const WEAK: f64 = 0.01;

/// Standard uncertainty of a known distance of a measurement, mm.
pub(super) fn tie_sigma(data: &[DataSet], set: usize, tie: usize) -> f64 {
    data.get(set).and_then(|set| set.lengths.get(tie)).and_then(|length| length.sigma_mm).unwrap_or(TIE_SIGMA)
}

/// Number of readings that one core processes together, and number of such blocks that are held until they are passed on.
const STRETCH: usize = 512;
const STRETCHES: usize = 8;

/// Typical lever arm of rotations, mm.
const LEVER_MM: f64 = 1000.0;

/// Parameters and data, arranged in columns.
#[derive(Clone, Debug)]
pub(super) struct Design<'a> {
    pub(super) machine: &'a Machine,
    pub(super) data: &'a [DataSet],
    pub(super) parameters: Vec<Parameter>,
    /// The components of the geometric parameters, each once.
    pub(super) components: Vec<ErrorName>,
    /// The geometric parameters, with their columns and components.
    pub(super) geometry: Vec<(usize, ParameterName, usize)>,
    /// The parameters of effects, with their columns.
    pub(super) effects: Vec<(usize, EffectParameter)>,
    /// Index of the first unknown of each measurement among the columns, and the end index.
    first: Vec<usize>,
    pub(super) columns: Vec<Column>,
}

/// One equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingEquation {
    /// Reading minus prediction, mm or rad.
    pub residual: f64,
    /// Index of the measurement.
    pub set: usize,
    /// Its origin.
    pub origin: EquationOrigin,
    /// `true` for an angle, rad.
    pub is_angle: bool,
}

/// Origin of an equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquationOrigin {
    /// The reading with this index.
    Row(usize),
    /// The known distance with this index.
    Tie(usize),
}

impl ReadingEquation {
    /// The index of the reading; `None` for a known distance.
    #[must_use]
    pub fn row(&self) -> Option<usize> {
        match self.origin {
            EquationOrigin::Row(row) => Some(row),
            EquationOrigin::Tie(_) => None,
        }
    }
}

impl<'a> Design<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        data: &'a [DataSet],
        parameters: &[impl Clone + Into<Parameter>],
    ) -> Design<'a> {
        let parameters: Vec<Parameter> = parameters.iter().cloned().map(Into::into).collect();
        let mut components = Vec::new();
        let (mut geometry, mut effects) = (Vec::new(), Vec::new());
        for (column, parameter) in parameters.iter().enumerate() {
            match parameter {
                Parameter::Geometry(name) => {
                    geometry.push((column, *name, number_of(&mut components, name.component)));
                }
                Parameter::Effect(parameter) => effects.push((column, parameter.clone())),
            }
        }
        let mut columns: Vec<Column> = parameters.iter().cloned().map(Column::from).collect();
        let mut first = Vec::new();
        for (number, set) in data.iter().enumerate() {
            first.push(columns.len());
            columns.extend((set.kind.unknowns)(set).into_iter().map(|unknown| Column::Unknown(number, unknown)));
        }
        first.push(columns.len());
        Design { machine, data, parameters, components, geometry, effects, first, columns }
    }

    /// `true` if there are nonlinear parameters, whose derivatives change between iterations.
    pub(super) fn is_curved(&self) -> bool {
        !self.parameters.iter().all(Parameter::is_linear)
    }

    /// Start values of the columns for the fit.
    pub(super) fn start(&self, errors: &ErrorModel) -> Vec<f64> {
        let model = Model::at(self.machine, errors, &Condition::default());
        let mut values: Vec<f64> = self.parameters.iter().map(|name| name.get(errors)).collect();
        for (set, &until) in self.data.iter().zip(self.first.iter().skip(1)) {
            values.extend((set.kind.start)(set, &model));
            values.resize(until, 0.0);
        }
        values
    }

    /// Set-up unknowns that are not identifiable by themselves, given the largest derivative of each column.
    pub(super) fn weak(&self, strongest: &[f64]) -> Vec<usize> {
        let unknowns = strongest.iter().enumerate().skip(self.parameters.len());
        unknowns.filter(|(_, factor)| **factor < WEAK).map(|(column, _)| column).collect()
    }

    /// Approximate motion per unit of each column, mm; values far below are rounding noise.
    pub(super) fn reach(&self, errors: &ErrorModel) -> Vec<f64> {
        let lever = |is_angle: bool| if is_angle { LEVER_MM } else { 1.0 };
        let of_unknown = |column: &Column| if column.is_of_machine() { 0.0 } else { lever(column.is_angle(self.data)) };
        let mut reach: Vec<f64> = self.columns.iter().map(of_unknown).collect();
        let mut raise = |column: usize, component: ErrorName, value: f64| {
            if let Some(most) = reach.get_mut(column) {
                *most = most.max(value.abs() * lever(component.direction.is_rotation()));
            }
        };
        let mut units = Units::new(self, errors);
        for set in self.data {
            let mut now = None;
            for observation in &set.observations {
                if now.replace(observation.condition) != Some(observation.condition) {
                    units.enter(set.condition(observation));
                }
                let state = &observation.reading.state;
                let command = self.within_turn(&observation.reading.position);
                for (column, name, _) in &self.geometry {
                    raise(*column, name.component, name.weight(&command, state));
                }
                for (column, _, part) in &units.parts {
                    raise(*column, part.component, part.value(&command, state));
                }
            }
        }
        reach
    }

    /// Calls `out` with every equation and, if requested, its derivatives with respect to all columns.
    pub(super) fn walk(
        &self,
        errors: &ErrorModel,
        values: &[f64],
        factors: bool,
        out: impl FnMut(ReadingEquation, &[f64]),
    ) {
        self.walk_with([errors, errors], values, factors, out);
    }

    /// As [`Self::walk`], on an error-free machine; effects have the values at which some of their parameters act.
    pub(super) fn walk_exact(&self, effects: &ErrorModel, values: &[f64], out: impl FnMut(ReadingEquation, &[f64])) {
        self.walk_with([&ErrorModel::default(), effects], values, true, out);
    }

    /// The equations on a machine with the first errors, with the derivatives of effects for the second ones.
    fn walk_with(
        &self,
        models: [&ErrorModel; 2],
        values: &[f64],
        factors: bool,
        mut out: impl FnMut(ReadingEquation, &[f64]),
    ) {
        for (number, (set, bounds)) in self.data.iter().zip(self.first.windows(2)).enumerate() {
            let own =
                Own { number, set, from: bounds[0], values: values.get(bounds[0]..bounds[1]).unwrap_or_default() };
            let stretches: Vec<Range<usize>> =
                (0..set.observations.len()).step_by(STRETCH).map(|from| from..from + STRETCH).collect();
            for some in stretches.chunks(STRETCHES) {
                for (lines, all) in in_parts(some, &|rows: &Range<usize>| self.of_rows(models, &own, rows, factors)) {
                    if factors {
                        all.each(|row, factors| lines.get(row).iter().for_each(|line| out(**line, factors)));
                    } else {
                        lines.into_iter().for_each(|line| out(line, &[]));
                    }
                }
            }
            let mut equations: Vec<Equation> = Vec::new();
            (set.kind.ties)(set, own.values, &mut equations);
            let mut row_factors = vec![0.0; self.columns.len()];
            for (tie, equation) in equations.iter().enumerate() {
                row_factors.fill(0.0);
                own.factors(equation).for_each(|(column, factor)| row_factors[column] = factor);
                out(own.line(equation, EquationOrigin::Tie(tie)), &row_factors);
            }
        }
    }

    /// The equations of some readings of a measurement and, if requested, their derivatives, concatenated.
    fn of_rows(
        &self,
        [errors, effects]: [&ErrorModel; 2],
        own: &Own<'_>,
        rows: &Range<usize>,
        factors: bool,
    ) -> (Vec<ReadingEquation>, RowStore) {
        let mut model = Model::at(self.machine, errors, &Condition::default());
        let mut units = Units::new(self, effects);
        let mut equations: Vec<Equation> = Vec::new();
        let mut shared = vec![0.0; self.parameters.len()];
        let (mut lines, mut all) = (Vec::new(), RowStore::new(self.columns.len(), self.parameters.len()));
        let set = own.set;
        let mut now = None;
        for (row, observation) in set.observations.iter().enumerate().take(rows.end).skip(rows.start) {
            if now.replace(observation.condition) != Some(observation.condition) {
                let condition = set.condition(observation);
                model = Model::at(self.machine, errors, condition);
                if factors {
                    units.enter(condition);
                }
            }
            let reading = &observation.reading;
            let seen = Seen::new(self.machine, &model, reading, &reading.tool_mm);
            equations.clear();
            (set.kind.equations)(set, observation, &seen, own.values, &mut equations);
            if factors {
                units.stand(&model, reading, &seen.nominal.rotation);
            }
            for equation in &equations {
                if factors {
                    if equation.by_path.is_empty() {
                        units.factors(equation, &mut shared);
                    } else {
                        units.factors_along(&model, equation, &mut shared);
                        units.stand(&model, reading, &seen.nominal.rotation);
                    }
                    all.push_parts(&shared, own.factors(equation));
                }
                lines.push(own.line(equation, EquationOrigin::Row(row)));
            }
        }
        (lines, all)
    }

    /// Tip motion of each parameter, root mean square over the readings, mm per unit.
    pub(super) fn effects(&self, errors: &ErrorModel) -> Vec<f64> {
        let model = Model::new(self.machine, &ErrorModel::default());
        let mut units = Units::new(self, errors);
        let mut sums = vec![0.0; self.parameters.len()];
        let mut moved = vec![Vector::zeros(); self.parameters.len()];
        let mut count = 0.0_f64;
        for set in self.data {
            let mut now = None;
            for observation in &set.observations {
                if now.replace(observation.condition) != Some(observation.condition) {
                    units.enter(set.condition(observation));
                }
                units.stand(&model, &observation.reading, &Matrix::identity());
                units.moved(&mut moved);
                for (sum, moved) in sums.iter_mut().zip(&moved) {
                    *sum += moved.norm_squared();
                }
                count += 1.0;
            }
        }
        sums.iter().map(|sum| (sum / count.max(1.0)).sqrt()).collect()
    }

    /// The command in the range of errors that repeat with every turn.
    pub(super) fn within_turn(&self, command: &AxisVector) -> AxisVector {
        let mut out = *command;
        for data in self.machine.axes.iter().flatten().filter(|data| data.modulo) {
            out[data.axis] = out[data.axis].rem_euclid(TAU);
        }
        out
    }
}

/// One measurement with the values of its unknowns.
struct Own<'a> {
    number: usize,
    set: &'a DataSet,
    /// Index of its first column.
    from: usize,
    values: &'a [f64],
}

impl Own<'_> {
    /// The derivatives with respect to its unknowns, with their columns.
    fn factors(&self, equation: &Equation) -> impl Iterator<Item = (usize, f64)> {
        equation.by_unknown.iter().map(|&(place, factor)| (self.from + place, factor))
    }

    fn line(&self, equation: &Equation, origin: EquationOrigin) -> ReadingEquation {
        ReadingEquation { residual: equation.residual, set: self.number, origin, is_angle: equation.is_angle }
    }
}

/// An equation and its derivatives with respect to every column, the input of a fit.
pub type Factored = (ReadingEquation, Vec<f64>);

/// The columns of a fit, and the equations for values of the unknowns in addition to those of the error model. If `unknowns` is `None`, these are
/// zero, and the mean probed positions for balls.
#[must_use]
pub fn equations(
    machine: &Machine,
    errors: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
    unknowns: Option<&[f64]>,
) -> (Vec<Column>, Vec<Factored>) {
    let design = Design::new(machine, data, parameters);
    let mut values = design.start(errors);
    if let Some(unknowns) = unknowns {
        values.truncate(parameters.len());
        values.extend(unknowns);
        values.resize(design.columns.len(), 0.0);
    }
    let mut out = Vec::new();
    design.walk(errors, &values, true, |line, factors| out.push((line, factors.to_vec())));
    (design.columns, out)
}
