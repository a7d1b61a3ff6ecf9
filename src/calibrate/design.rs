//! The equations of all readings: what each unknown does to each, and what is left.

use std::f64::consts::TAU;

use crate::geometry::{AxisVector, Vector};
use crate::machine::{Condition, Machine};
use crate::measure::data::DataSet;
use crate::measure::kind::{Equation, Seen};
use crate::model::parameter::ParameterName;
use crate::model::{ErrorModel, ErrorName, Model};

use super::column::Column;

/// Known distances have this standard uncertainty where the description gives none, mm.
const TIE_SIGMA: f64 = 1e-4;

/// An unknown of a set-up that moves no reading by a larger share of itself is not told, as the place of a ball across a circle: 0.1 mm would
/// be less than 1 µm, and its own square more.
const WEAK: f64 = 0.01;

/// Parameters and data, laid out in columns.
#[derive(Clone, Debug)]
pub(super) struct Design<'a> {
    machine: &'a Machine,
    pub(super) data: &'a [DataSet],
    parameters: Vec<ParameterName>,
    /// The components of the parameters, each once, and which of them each parameter belongs to.
    components: Vec<ErrorName>,
    component_of: Vec<usize>,
    /// Place of the first unknown of each measurement among the columns, and behind the last one.
    first: Vec<usize>,
    pub(super) columns: Vec<Column>,
}

/// One equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// What was read less what is predicted, mm or rad.
    pub residual: f64,
    /// The measurement.
    pub set: usize,
    /// Where it comes from.
    pub origin: Origin,
    /// Whether it is an angle, rad.
    pub is_angle: bool,
}

/// Where an equation comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The reading of this number.
    Row(usize),
    /// The known distance of this number.
    Tie(usize),
}

impl Line {
    /// The number of the reading; `None` for a known distance.
    #[must_use]
    pub fn row(&self) -> Option<usize> {
        match self.origin {
            Origin::Row(row) => Some(row),
            Origin::Tie(_) => None,
        }
    }
}

impl<'a> Design<'a> {
    pub(super) fn new(machine: &'a Machine, data: &'a [DataSet], parameters: &[ParameterName]) -> Design<'a> {
        let mut components = Vec::new();
        let component_of = parameters
            .iter()
            .map(|name| {
                components.iter().position(|known| *known == name.component).unwrap_or_else(|| {
                    components.push(name.component);
                    components.len() - 1
                })
            })
            .collect();
        let mut columns: Vec<Column> = parameters.iter().copied().map(Column::Parameter).collect();
        let mut first = Vec::new();
        for (number, set) in data.iter().enumerate() {
            first.push(columns.len());
            columns.extend((set.kind.unknowns)(set).into_iter().map(|unknown| Column::Unknown(number, unknown)));
        }
        first.push(columns.len());
        Design { machine, data, parameters: parameters.to_vec(), components, component_of, first, columns }
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

    /// Standard uncertainty of a known distance, mm.
    pub(super) fn tie_sigma(&self, set: usize, tie: usize) -> f64 {
        self.data.get(set).and_then(|set| set.lengths.get(tie)).and_then(|length| length.sigma_mm).unwrap_or(TIE_SIGMA)
    }

    /// Unknowns of set-ups that are not told by themselves, by the largest factor of each column.
    pub(super) fn weak(&self, strongest: &[f64]) -> Vec<usize> {
        let unknowns = strongest.iter().enumerate().skip(self.parameters.len());
        unknowns.filter(|(_, factor)| **factor < WEAK).map(|(column, _)| column).collect()
    }

    /// Calls `out` with every equation: its line, and its factors by all columns where they are wanted.
    pub(super) fn walk(&self, errors: &ErrorModel, values: &[f64], factors: bool, mut out: impl FnMut(Line, &[f64])) {
        let model = Model::at(self.machine, errors, &Condition::default());
        let mut equations: Vec<Equation> = Vec::new();
        let mut row_factors = vec![0.0; self.columns.len()];
        let mut moved = vec![[Vector::zeros(); 2]; self.components.len()];
        let mut weights = vec![0.0; self.parameters.len()];
        for (set_number, (set, bounds)) in self.data.iter().zip(self.first.windows(2)).enumerate() {
            let [from, until] = [bounds[0], bounds[1]];
            let own = values.get(from..until).unwrap_or_default();
            let mut emit = |equation: &Equation, origin: Origin, row_factors: &mut [f64]| {
                if factors {
                    for &(place, factor) in &equation.by_unknown {
                        row_factors[from + place] = factor;
                    }
                }
                let Equation { residual, is_angle, .. } = *equation;
                out(Line { residual, set: set_number, origin, is_angle }, row_factors);
            };
            for (row, observation) in set.observations.iter().enumerate() {
                let reading = &observation.reading;
                let seen = Seen::new(self.machine, &model, reading, &reading.tool_mm);
                equations.clear();
                (set.kind.equations)(set, observation, &seen, own, &mut equations);
                if factors {
                    for (name, moved) in self.components.iter().zip(&mut moved) {
                        let unit = model.sensitivity(*name, &reading.position, &reading.tool_mm);
                        *moved = [seen.nominal.rotation * unit.translation, seen.nominal.rotation * unit.rotation];
                    }
                    let command = self.within_turn(&reading.position);
                    for (weight, name) in weights.iter_mut().zip(&self.parameters) {
                        *weight = name.weight(&command, &reading.state);
                    }
                }
                for equation in &equations {
                    if factors {
                        row_factors.fill(0.0);
                        for ((factor, weight), &component) in
                            row_factors.iter_mut().zip(&weights).zip(&self.component_of)
                        {
                            let [tip, turn] = &moved[component];
                            *factor = (equation.by_tip.dot(tip) + equation.by_turn.dot(turn)) * weight;
                        }
                    }
                    emit(equation, Origin::Row(row), &mut row_factors);
                }
            }
            equations.clear();
            (set.kind.ties)(set, own, &mut equations);
            for (tie, equation) in equations.iter().enumerate() {
                row_factors.fill(0.0);
                emit(equation, Origin::Tie(tie), &mut row_factors);
            }
        }
    }

    /// By how much each parameter moves the tip, root of the mean square over the readings, mm per unit.
    pub(super) fn effects(&self) -> Vec<f64> {
        let model = Model::new(self.machine, &ErrorModel::default());
        let mut sums = vec![0.0; self.parameters.len()];
        let mut count = 0.0_f64;
        for observation in self.data.iter().flat_map(|set| &set.observations) {
            let reading = &observation.reading;
            let units: Vec<f64> = self
                .components
                .iter()
                .map(|name| model.sensitivity(*name, &reading.position, &reading.tool_mm).translation.norm())
                .collect();
            let command = self.within_turn(&reading.position);
            for ((sum, name), &component) in sums.iter_mut().zip(&self.parameters).zip(&self.component_of) {
                *sum += (units[component] * name.weight(&command, &reading.state)).powi(2);
            }
            count += 1.0;
        }
        sums.iter().map(|sum| (sum / count.max(1.0)).sqrt()).collect()
    }

    /// The command as the errors of axes see it that repeat with every turn.
    fn within_turn(&self, command: &AxisVector) -> AxisVector {
        let mut out = *command;
        for data in self.machine.axes.iter().flatten().filter(|data| data.modulo) {
            out[data.axis] = out[data.axis].rem_euclid(TAU);
        }
        out
    }
}

/// An equation and its factors by every column: what a fit is made of.
pub type Factored = (Line, Vec<f64>);

/// The columns of a fit, and the equations with values of the unknowns beside those that the error model holds: zeros, and the
/// middle of where balls were probed, where `unknowns` is `None`.
#[must_use]
pub fn equations(
    machine: &Machine,
    errors: &ErrorModel,
    parameters: &[ParameterName],
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
