//! The equations of all readings: what each unknown does to each, and what is left.

use crate::geometry::Vector;
use crate::machine::{Condition, Machine};
use crate::measure::data::DataSet;
use crate::measure::kind::{Equation, Seen};
use crate::model::parameter::ParameterName;
use crate::model::{ErrorModel, ErrorName, Model};

use super::column::Column;

/// Distances that are known count as much as readings of this uncertainty, where the description gives none, mm.
const TIE_SIGMA: f64 = 1e-4;

/// Parameters and data, laid out in columns.
#[derive(Clone, Debug)]
pub(super) struct Design<'a> {
    machine: &'a Machine,
    data: &'a [DataSet],
    parameters: Vec<ParameterName>,
    /// The components of the parameters, each once, and which of them each parameter belongs to.
    components: Vec<ErrorName>,
    component_of: Vec<usize>,
    /// Place of the first unknown of each measurement among the columns.
    first: Vec<usize>,
    pub(super) columns: Vec<Column>,
}

/// One equation with the place of its reading.
#[derive(Clone, Debug)]
pub(super) struct Line {
    /// What was read less what is predicted, mm or rad.
    pub(super) residual: f64,
    /// The measurement.
    pub(super) set: usize,
    /// Its row; `None` for a known distance.
    pub(super) row: Option<usize>,
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
        Design { machine, data, parameters: parameters.to_vec(), components, component_of, first, columns }
    }

    /// Standard uncertainty of a line as the descriptions give it.
    pub(super) fn sigma(&self, line: &Line) -> Option<f64> {
        let sigma = self.data.get(line.set).and_then(|set| set.sigma);
        if line.row.is_some() { sigma } else { Some(sigma.unwrap_or(TIE_SIGMA)) }
    }

    /// Calls `out` with every equation: its line, and its factors by all columns where they are wanted.
    pub(super) fn walk(&self, errors: &ErrorModel, values: &[f64], factors: bool, mut out: impl FnMut(Line, &[f64])) {
        let model = Model::at(self.machine, errors, &Condition::default());
        let mut equations: Vec<Equation> = Vec::new();
        let mut row_factors = vec![0.0; self.columns.len()];
        let mut moved = vec![[Vector::zeros(); 2]; self.components.len()];
        for (number, set) in self.data.iter().enumerate() {
            let from = self.first.get(number).copied().unwrap_or(0);
            let until = self.first.get(number + 1).copied().unwrap_or(self.columns.len());
            let own = values.get(from..until).unwrap_or_default();
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
                }
                for equation in &equations {
                    if factors {
                        row_factors.fill(0.0);
                        for (k, name) in self.parameters.iter().enumerate() {
                            let [tip, turn] = moved[self.component_of[k]];
                            let unit = equation.by_tip.dot(&tip) + equation.by_turn.dot(&turn);
                            row_factors[k] = unit * name.weight(&reading.position, &reading.state);
                        }
                        for &(place, factor) in &equation.by_unknown {
                            row_factors[from + place] = factor;
                        }
                    }
                    out(Line { residual: equation.residual, set: number, row: Some(row) }, &row_factors);
                }
            }
            equations.clear();
            (set.kind.ties)(set, own, &mut equations);
            for equation in &equations {
                row_factors.fill(0.0);
                for &(place, factor) in &equation.by_unknown {
                    row_factors[from + place] = factor;
                }
                out(Line { residual: equation.residual, set: number, row: None }, &row_factors);
            }
        }
    }

    /// By how much each parameter moves the tip, root of the mean square over the readings, mm per unit.
    pub(super) fn effects(&self, errors: &ErrorModel) -> Vec<f64> {
        let model = Model::at(self.machine, errors, &Condition::default());
        let mut sums = vec![0.0; self.parameters.len()];
        let mut count = 0.0_f64;
        for observation in self.data.iter().flat_map(|set| &set.observations) {
            let reading = &observation.reading;
            let units: Vec<f64> = self
                .components
                .iter()
                .map(|name| model.sensitivity(*name, &reading.position, &reading.tool_mm).translation.norm())
                .collect();
            for (k, name) in self.parameters.iter().enumerate() {
                sums[k] += (units[self.component_of[k]] * name.weight(&reading.position, &reading.state)).powi(2);
            }
            count += 1.0;
        }
        sums.iter().map(|sum| (sum / count.max(1.0)).sqrt()).collect()
    }
}
