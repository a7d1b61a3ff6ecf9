//! Linearized data: the residual of each reading, the drivers of its row, and its sensitivity to a deviation anywhere in the machine.
//!
//! All effects are linear in small deviations. A displacement of the tool relative to the workpiece acts on a reading through the derivatives of the kind of
//! measurement ([`crate::measure::kind::Equation`]). An error of an axis acts through the sensitivity of the error model. There is no second formula.

use std::collections::HashMap;

use crate::calibrate::{Column, FitError, FitOptions, Parameter, WEAK, fit};
use crate::measure::data::DataSet;
use crate::measure::kind::{ByComponent, Equation, Seen, by_component};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Condition, Machine};
use ncfix_model::{ErrorModel, ErrorName, Model};

use super::path::ReadingPaths;
use super::row::{SceneRow, rows};

/// Default uncertainty of a reading, mm or rad.
const FIRST_SIGMA: f64 = 1e-3;

/// Row number of a known distance, which belongs to no row.
pub const NO_ROW: usize = usize::MAX;
/// Its default standard uncertainty, mm.
const TIE_SIGMA: f64 = 1e-4;

/// Point of the chain at which a deviation acts. Signs are those of the machine file: deviations of the body that an axis moves, also on the workpiece side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Through {
    /// Component of the error of an axis, mm or rad.
    Component(ErrorName),
    /// Displacement of the tool relative to the workpiece along a direction of F (0, 1, 2), mm.
    Tip(usize),
    /// The instrument itself: all its readings of lengths (`false`) or of angles (`true`) increase, mm or rad.
    Reading(bool),
    /// One of several values of a reading, such as the second of `dx dy dz`, mm.
    Value(usize),
}

/// A single measured number.
#[derive(Clone, Debug)]
pub struct SceneReading {
    /// Its row among [`Scene::rows`].
    pub row: usize,
    /// Its position among the values of the row.
    pub value: usize,
    /// Residual: reading minus prediction, mm or rad.
    pub left: f64,
    /// Standard uncertainty used as its weight, mm or rad.
    pub sigma: f64,
    /// True if it is an angle.
    pub is_angle: bool,
    by_tip: Vector,
    by_turn: Vector,
    by_location: ByComponent,
    /// Derivatives with respect to set-up unknowns, with their numbers among all unknowns.
    pub by_unknown: Vec<(usize, f64)>,
}

/// Measurements with the predictions of a model.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Its error model.
    pub errors: ErrorModel,
    /// The measurements.
    pub sets: &'a [DataSet],
    /// Rows of all measurements.
    pub rows: Vec<SceneRow>,
    /// Readings in the order of rows.
    pub items: Vec<SceneReading>,
    /// Unknowns of the set-ups.
    pub unknowns: usize,
    pub(super) paths: ReadingPaths,
}

impl<'a> Scene<'a> {
    /// Linearizes measurements about a model, with the best fit of the set-up unknowns.
    ///
    /// # Errors
    ///
    /// [`FitError`] if the set-up unknowns are not identifiable.
    pub fn new(machine: &'a Machine, errors: &ErrorModel, sets: &'a [DataSet]) -> Result<Scene<'a>, FitError> {
        // Errors that the model lacks are not noise, so they must not decide which rows are outliers.
        let found = fit::<Parameter>(machine, errors, &[], sets, FitOptions { robust: false })?;
        let values: Vec<f64> = found.estimates.iter().map(|estimate| estimate.value).collect();
        let mut first = vec![0; sets.len() + 1];
        for (place, estimate) in found.estimates.iter().enumerate() {
            if let Column::Unknown(set, _) = estimate.column
                && let Some(behind) = first.get_mut(set + 1)
            {
                *behind = place + 1;
            }
        }
        for k in 1..first.len() {
            first[k] = first[k].max(first[k - 1]);
        }
        let mut scene = Scene {
            machine,
            errors: errors.clone(),
            sets,
            rows: rows(sets),
            items: Vec::new(),
            unknowns: values.len(),
            paths: ReadingPaths::default(),
        };
        let mut equations: Vec<Equation> = Vec::new();
        let mut row = 0;
        for (number, data) in sets.iter().enumerate() {
            let (from, until) = (first[number], first[number + 1]);
            let own = values.get(from..until).unwrap_or_default();
            let mut condition = usize::MAX;
            let mut model = Model::at(machine, errors, &Condition::default());
            for observation in &data.observations {
                if observation.condition != condition {
                    condition = observation.condition;
                    model = Model::at(machine, errors, data.condition(observation));
                }
                let seen = Seen::new(machine, &model, &observation.reading, &observation.reading.tool_mm);
                equations.clear();
                (data.kind.equations)(data, observation, &seen, own, &mut equations);
                // A probed ball gives three equations without values.
                let present: Vec<usize> = (0..3).filter(|&k| observation.values[k].is_some()).collect();
                for (place, equation) in equations.iter().enumerate() {
                    let sigma = if equation.is_angle { data.sigma_rad } else { data.sigma };
                    if let Some(own) = scene.rows.get(row) {
                        scene.paths.add(scene.items.len(), own, &equation.by_path);
                    }
                    scene.items.push(SceneReading {
                        row,
                        value: present.get(place).copied().unwrap_or(place),
                        left: equation.residual,
                        sigma: sigma.unwrap_or(FIRST_SIGMA),
                        is_angle: equation.is_angle,
                        by_tip: equation.by_tip,
                        by_turn: equation.by_turn,
                        by_location: equation.by_location,
                        by_unknown: equation.by_unknown.iter().map(|&(k, factor)| (from + k, factor)).collect(),
                    });
                }
                row += 1;
            }
            equations.clear();
            (data.kind.ties)(data, own, &mut equations);
            for (tie, equation) in equations.iter().enumerate() {
                let sigma = data.lengths.get(tie).and_then(|length| length.sigma_mm).unwrap_or(TIE_SIGMA);
                scene.items.push(SceneReading {
                    row: NO_ROW,
                    value: 0,
                    left: equation.residual,
                    sigma,
                    is_angle: false,
                    by_tip: Vector::zeros(),
                    by_turn: Vector::zeros(),
                    by_location: [None; 3],
                    by_unknown: equation.by_unknown.iter().map(|&(k, factor)| (from + k, factor)).collect(),
                });
            }
        }
        scene.leave_weak();
        Ok(scene)
    }

    /// Removes the factors of unknowns that are nearly not identifiable: a fit would change them by meters.
    fn leave_weak(&mut self) {
        let mut strongest = vec![0.0_f64; self.unknowns];
        for &(unknown, factor) in self.items.iter().flat_map(|item| &item.by_unknown) {
            if let Some(most) = strongest.get_mut(unknown) {
                *most = most.max(factor.abs());
            }
        }
        let is_told = |unknown: usize| strongest.get(unknown).is_some_and(|most| *most >= WEAK);
        self.items.iter_mut().for_each(|item| item.by_unknown.retain(|(unknown, _)| is_told(*unknown)));
    }

    /// Effect of one unit of a deviation on every reading.
    #[must_use]
    pub fn factors(&self, through: Through) -> Vec<f64> {
        let model = Model::new(self.machine, &ErrorModel::default());
        let mut at = usize::MAX;
        let (mut tip, mut turn) = (Vector::zeros(), Vector::zeros());
        let one = |item: &SceneReading| {
            if item.row == NO_ROW {
                return 0.0;
            }
            if item.row != at {
                at = item.row;
                (tip, turn) = self.unit(&model, through, item.row);
            }
            match through {
                Through::Reading(of_angles) => f64::from(u8::from(item.is_angle == of_angles)),
                Through::Value(value) => f64::from(u8::from(item.value == value)),
                Through::Component(name) => {
                    item.by_tip.dot(&tip) + item.by_turn.dot(&turn) + by_component(&item.by_location, name)
                }
                Through::Tip(_) => item.by_tip.dot(&tip) + item.by_turn.dot(&turn),
            }
        };
        let mut factors: Vec<f64> = self.items.iter().map(one).collect();
        self.leave_faint(&mut factors);
        factors
    }

    /// Sets the factors to zero in a set-up that is insensitive to the deviation; otherwise errors of the readings would be magnified a hundredfold.
    fn leave_faint(&self, factors: &mut [f64]) {
        // Lengths and angles are compared separately, because their units differ.
        let setup = |item: &SceneReading| self.rows.get(item.row).map(|row| (row.set, row.setup, item.is_angle));
        let mut strongest: HashMap<(usize, usize, bool), f64> = HashMap::new();
        let mut most = [0.0_f64; 2];
        for (item, factor) in self.items.iter().zip(factors.iter()) {
            if let Some(setup) = setup(item) {
                let own = strongest.entry(setup).or_insert(0.0);
                *own = own.max(factor.abs());
                let most = &mut most[usize::from(item.is_angle)];
                *most = most.max(factor.abs());
            }
        }
        strongest.retain(|(.., is_angle), own| *own < WEAK * most[usize::from(*is_angle)]);
        if strongest.is_empty() {
            return;
        }
        for (item, factor) in self.items.iter().zip(factors.iter_mut()) {
            if setup(item).is_some_and(|setup| strongest.contains_key(&setup)) {
                *factor = 0.0;
            }
        }
    }

    /// Displacement and rotation of the tool in the workpiece frame per unit of a deviation, at a row.
    fn unit(&self, model: &Model, through: Through, row: usize) -> (Vector, Vector) {
        let nothing = (Vector::zeros(), Vector::zeros());
        let Some(row) = self.rows.get(row) else { return nothing };
        let Some(observation) = self.sets.get(row.set).and_then(|set| set.observations.get(row.number)) else {
            return nothing;
        };
        self.unit_at(model, through, (&observation.reading.position, &observation.reading.tool_mm))
    }

    /// Displacement and rotation of the tool in the workpiece frame per unit of a deviation, at a position with a tool.
    pub(super) fn unit_at(
        &self,
        model: &Model,
        through: Through,
        (position, tool_mm): (&AxisVector, &Vector),
    ) -> (Vector, Vector) {
        let nominal = model.nominal(position, tool_mm);
        match through {
            Through::Component(name) => {
                let unit = model.sensitivity(name, position, tool_mm);
                (nominal.rotation * unit.translation, nominal.rotation * unit.rotation)
            }
            Through::Tip(direction) => {
                let to_f = model.tool_orientation(position) * nominal.rotation.transpose();
                (to_f.row(direction.min(2)).transpose(), Vector::zeros())
            }
            Through::Reading(_) | Through::Value(_) => (Vector::zeros(), Vector::zeros()),
        }
    }

    /// Returns the row of a reading.
    #[must_use]
    pub fn row_of(&self, item: &SceneReading) -> Option<&SceneRow> {
        self.rows.get(item.row)
    }
}
