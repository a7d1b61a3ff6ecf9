//! The equations of all readings: what each unknown does to each, and what is left.

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
use super::unit::{Units, number_of};

/// Known distances have this standard uncertainty where the description gives none, mm.
pub(super) const TIE_SIGMA: f64 = 1e-4;

/// An unknown of a set-up that moves no reading by a larger share of itself is not told, as the place of a ball across a circle: 0.1 mm would
/// be less than 1 µm, and its own square more.
pub(crate) const WEAK: f64 = 0.01;

/// Standard uncertainty of a known distance of a measurement, mm.
pub(super) fn tie_sigma(data: &[DataSet], set: usize, tie: usize) -> f64 {
    data.get(set).and_then(|set| set.lengths.get(tie)).and_then(|length| length.sigma_mm).unwrap_or(TIE_SIGMA)
}

/// Readings that one core looks at together, and how many such stretches are kept until they are handed on.
const STRETCH: usize = 512;
const STRETCHES: usize = 8;

/// Rotations move points at about this lever, mm.
const LEVER_MM: f64 = 1000.0;

/// Parameters and data, laid out in columns.
#[derive(Clone, Debug)]
pub(super) struct Design<'a> {
    pub(super) machine: &'a Machine,
    pub(super) data: &'a [DataSet],
    pub(super) parameters: Vec<Parameter>,
    /// The components of the parameters of the geometry, each once.
    pub(super) components: Vec<ErrorName>,
    /// The parameters of the geometry, with their columns and components.
    pub(super) geometry: Vec<(usize, ParameterName, usize)>,
    /// Those of effects, with their columns.
    pub(super) effects: Vec<(usize, EffectParameter)>,
    /// Place of the first unknown of each measurement among the columns, and behind the last one.
    first: Vec<usize>,
    pub(super) columns: Vec<Column>,
}

/// One equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReadingEquation {
    /// What was read less what is predicted, mm or rad.
    pub residual: f64,
    /// The measurement.
    pub set: usize,
    /// Where it comes from.
    pub origin: EquationOrigin,
    /// Whether it is an angle, rad.
    pub is_angle: bool,
}

/// Where an equation comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EquationOrigin {
    /// The reading of this number.
    Row(usize),
    /// The known distance of this number.
    Tie(usize),
}

impl ReadingEquation {
    /// The number of the reading; `None` for a known distance.
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

    /// Whether there are parameters whose factors change from round to round.
    pub(super) fn is_curved(&self) -> bool {
        !self.parameters.iter().all(Parameter::is_linear)
    }

    /// Values of the columns from which the fit starts.
    pub(super) fn start(&self, errors: &ErrorModel) -> Vec<f64> {
        let model = Model::at(self.machine, errors, &Condition::default());
        let mut values: Vec<f64> = self.parameters.iter().map(|name| name.get(errors)).collect();
        for (set, &until) in self.data.iter().zip(self.first.iter().skip(1)) {
            values.extend((set.kind.start)(set, &model));
            values.resize(until, 0.0);
        }
        values
    }

    /// Unknowns of set-ups that are not told by themselves, by the largest factor of each column.
    pub(super) fn weak(&self, strongest: &[f64]) -> Vec<usize> {
        let unknowns = strongest.iter().enumerate().skip(self.parameters.len());
        unknowns.filter(|(_, factor)| **factor < WEAK).map(|(column, _)| column).collect()
    }

    /// About how much a unit of each column can move, mm: what is far below it is left by the arithmetic.
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

    /// Calls `out` with every equation: its line, and its factors by all columns where they are wanted.
    pub(super) fn walk(
        &self,
        errors: &ErrorModel,
        values: &[f64],
        factors: bool,
        out: impl FnMut(ReadingEquation, &[f64]),
    ) {
        self.walk_with([errors, errors], values, factors, out);
    }

    /// The same on a machine without errors; effects have the values by which some of their parameters act.
    pub(super) fn walk_exact(&self, effects: &ErrorModel, values: &[f64], out: impl FnMut(ReadingEquation, &[f64])) {
        self.walk_with([&ErrorModel::default(), effects], values, true, out);
    }

    /// The equations on a machine with the first errors, and the factors of effects as they are in the second ones.
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
                    let mut all = all.chunks(self.columns.len().max(1));
                    lines.into_iter().for_each(|line| out(line, all.next().unwrap_or_default()));
                }
            }
            let mut equations: Vec<Equation> = Vec::new();
            (set.kind.ties)(set, own.values, &mut equations);
            let mut row_factors = vec![0.0; self.columns.len()];
            for (tie, equation) in equations.iter().enumerate() {
                row_factors.fill(0.0);
                own.enter(equation, factors, &mut row_factors);
                out(own.line(equation, EquationOrigin::Tie(tie)), &row_factors);
            }
        }
    }

    /// The equations of some readings of a measurement, and their factors one after the other where they are wanted.
    fn of_rows(
        &self,
        [errors, effects]: [&ErrorModel; 2],
        own: &Own<'_>,
        rows: &Range<usize>,
        factors: bool,
    ) -> (Vec<ReadingEquation>, Vec<f64>) {
        let mut model = Model::at(self.machine, errors, &Condition::default());
        let mut units = Units::new(self, effects);
        let mut equations: Vec<Equation> = Vec::new();
        let mut row_factors = vec![0.0; self.columns.len()];
        let (mut lines, mut all) = (Vec::new(), Vec::new());
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
                    units.factors(&equation.by_tip, &equation.by_turn, &mut row_factors);
                    own.enter(equation, factors, &mut row_factors);
                    all.extend_from_slice(&row_factors);
                }
                lines.push(own.line(equation, EquationOrigin::Row(row)));
            }
        }
        (lines, all)
    }

    /// By how much each parameter moves the tip, root of the mean square over the readings, mm per unit.
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

    /// The command as the errors of axes see it that repeat with every turn.
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
    /// The first of its columns.
    from: usize,
    values: &'a [f64],
}

impl Own<'_> {
    /// The factors of its unknowns, where they are wanted.
    fn enter(&self, equation: &Equation, factors: bool, out: &mut [f64]) {
        if factors {
            for &(place, factor) in &equation.by_unknown {
                out[self.from + place] = factor;
            }
        }
    }

    fn line(&self, equation: &Equation, origin: EquationOrigin) -> ReadingEquation {
        ReadingEquation { residual: equation.residual, set: self.number, origin, is_angle: equation.is_angle }
    }
}

/// An equation and its factors by every column: what a fit is made of.
pub type Factored = (ReadingEquation, Vec<f64>);

/// The columns of a fit, and the equations with values of the unknowns beside those that the error model holds: zeros, and the
/// middle of where balls were probed, where `unknowns` is `None`.
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
