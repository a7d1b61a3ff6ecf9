//! Selection of the parameters that the data need: stepwise selection among candidates, then a fit of the selected ones.
//!
//! Selection uses the equations at a fitted point, the fit the full kinematics, in turn, until the selection is stable. Weights and uncertainties of
//! the readings come from the residuals of all candidates together: in a model without it, a true effect looks like outliers. Readings of one set-up,
//! run, component and direction are a series, in the order of `t_s` or otherwise of the rows.

use std::collections::{HashMap, HashSet};

use nalgebra::DMatrix;

use crate::measure::data::DataSet;
use ncfix_base::geometry::{AXES, AXIS_COUNT};
use ncfix_base::numeric::Normal;
use ncfix_base::numeric::stepwise::{Choice, REPEATED, Rows, Rule, choose};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::candidates::handicap;
use super::column::Column;
use super::design::{Design, EquationOrigin, ReadingEquation, tie_sigma};
use super::effect::Parameter;
use super::fault::FitError;
use super::fit::{Fit, FitOptions, fit};
use super::noise::{FIRST_ANGLE_SIGMA, FIRST_SIGMA, group_of};
use super::robust::{spread, weight};

/// Maximum number of selections.
const MOST_PASSES: usize = 3;
/// Maximum number of derivatives: 256 MB, of which the selection makes a few copies.
const MOST_FACTORS: usize = 1 << 25;
/// Number of iterations with preliminary weights, and with rejecting weights; one of each for large problems.
const WEIGHT_ROUNDS: usize = 3;
const MUCH: f64 = 5e8;
/// Weight below which a row is left out.
const REJECTED: f64 = 0.01;
/// Positions closer than this are one place, mm or rad.
const SAME_PLACE: f64 = 1e-5;
/// Ridge for an unidentifiable coefficient, relative to the length of its column.
const RIDGE: f64 = 1e-4;
/// Minimum spread relative to the initial uncertainty, for data without noise.
const LEAST_SPREAD: f64 = 1e-6;
/// Smallest number of readings whose residuals have a spread.
const FEWEST_FOR_SPREAD: usize = 3;

/// The selection, and its fit.
#[derive(Clone, Debug)]
pub struct Selected {
    /// The fit of the fixed and the selected parameters.
    pub fit: Fit,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// The candidates to which the indices of [`Self::choice`] refer.
    pub candidates: Vec<Parameter>,
    /// The last selection.
    pub choice: Choice,
    /// Number of selections.
    pub passes: usize,
    /// `true` if the last selection equals the previous one.
    pub is_settled: bool,
}

/// Reason why there is no selection.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The fixed parameters, or the selected ones, cannot be fitted.
    Fault(FitError),
    /// The product of equations and columns is too large.
    TooLarge {
        /// Number of equations.
        equations: usize,
        /// Number of parameters, unknowns and candidates.
        columns: usize,
    },
}

impl From<FitError> for Refusal {
    fn from(fault: FitError) -> Refusal {
        Refusal::Fault(fault)
    }
}

/// Selects among candidates in addition to fixed parameters, which are not candidates.
///
/// # Errors
/// [`Refusal`].
pub fn select(
    machine: &Machine,
    start: &ErrorModel,
    base: &[Parameter],
    candidates: &[Parameter],
    data: &[DataSet],
    options: FitOptions,
    rule: Rule,
) -> Result<Selected, Refusal> {
    let mut own: Vec<Parameter> = Vec::new();
    for name in candidates {
        if !base.contains(name) && !own.contains(name) {
            own.push(name.clone());
        }
    }
    let job = Job { machine, start, base, candidates: &own, data, options };
    // Before the effects are included, residuals do not reveal outliers.
    let mut fitted = fit(machine, start, base, data, FitOptions { robust: false })?;
    let mut chosen: Vec<usize> = Vec::new();
    let mut choice = Choice::default();
    let (mut passes, mut is_settled) = (0, false);
    while passes < MOST_PASSES && !is_settled {
        choice = choose(&job.rows(&fitted)?, rule).ok_or(FitError::NotSettled(None))?;
        passes += 1;
        let now: Vec<usize> = choice.terms.iter().map(|term| term.candidate).collect();
        is_settled = now == chosen;
        if !is_settled || passes == 1 {
            chosen = now;
            fitted = fit(machine, start, &job.parameters(&chosen), data, options)?;
        }
    }
    let parameters = job.parameters(&chosen);
    Ok(Selected { fit: fitted, parameters, candidates: own, choice, passes, is_settled })
}

struct Job<'a> {
    machine: &'a Machine,
    start: &'a ErrorModel,
    base: &'a [Parameter],
    candidates: &'a [Parameter],
    data: &'a [DataSet],
    options: FitOptions,
}

/// The equations, concatenated.
struct Equations {
    lines: Vec<ReadingEquation>,
    /// Index of the equation among those of its reading.
    places: Vec<usize>,
    factors: Vec<f64>,
    values: Vec<f64>,
    width: usize,
}

impl Equations {
    fn row(&self, k: usize) -> &[f64] {
        self.factors.get(k * self.width..(k + 1) * self.width).unwrap_or_default()
    }
}

impl Job<'_> {
    fn parameters(&self, chosen: &[usize]) -> Vec<Parameter> {
        let chosen = chosen.iter().filter_map(|&number| self.candidates.get(number));
        self.base.iter().chain(chosen).cloned().collect()
    }

    /// The equations at a fitted point: the residuals there, and the derivatives of the candidates relative to the start.
    fn equations(&self, fitted: &Fit) -> Result<Equations, Refusal> {
        let all: Vec<Parameter> = self.base.iter().chain(self.candidates).cloned().collect();
        let design = Design::new(self.machine, self.data, &all);
        let width = design.columns.len();
        let rows: usize = self.data.iter().map(|set| 3 * set.observations.len() + set.lengths.len()).sum();
        if rows.saturating_mul(width) > MOST_FACTORS {
            return Err(Refusal::TooLarge { equations: rows, columns: width });
        }
        let mut values = design.start(&fitted.errors);
        let unknowns = fitted.estimates.iter().filter(|one| matches!(one.column, Column::Unknown(..)));
        for (to, unknown) in values.iter_mut().skip(all.len()).zip(unknowns) {
            *to = unknown.value;
        }
        let moved: Vec<f64> =
            self.candidates.iter().map(|name| name.get(&fitted.errors) - name.get(self.start)).collect();
        // Fixed parameters, unknowns, candidates.
        let from = self.base.len();
        let until = all.len();
        let mut found = Equations { lines: vec![], places: vec![], factors: vec![], values: vec![], width };
        let mut strongest = vec![0.0_f64; width];
        design.walk(&fitted.errors, &values, true, |line, factors| {
            strongest.iter_mut().zip(factors).for_each(|(most, factor)| *most = most.max(factor.abs()));
            let (base, rest) = factors.split_at(from.min(factors.len()));
            let (candidates, unknowns) = rest.split_at((until - from).min(rest.len()));
            found.factors.extend(base.iter().chain(unknowns).chain(candidates));
            let known: f64 = candidates.iter().zip(&moved).map(|(factor, moved)| factor * moved).sum();
            found.values.push(line.residual + known);
            let is_next = found.lines.last().is_some_and(|last| (last.set, last.origin) == (line.set, line.origin));
            let place = found.places.last().map_or(0, |place| place + 1);
            found.places.push(if is_next { place } else { 0 });
            found.lines.push(line);
        });
        // Unknowns without sufficient effect are held.
        let weak = design.weak(&strongest);
        for column in weak.into_iter().map(|column| column - (until - from)) {
            found.factors.iter_mut().skip(column).step_by(width).for_each(|factor| *factor = 0.0);
        }
        Ok(found)
    }

    /// The rows for the selection at a fitted point.
    fn rows(&self, fitted: &Fit) -> Result<Rows, Refusal> {
        let equations = self.equations(fitted)?;
        let always = equations.width - self.candidates.len();
        let (weights, sigmas) = self.weigh(&equations, always);
        let mut keys: Vec<(Key, f64, usize)> = Vec::new();
        for (k, line) in equations.lines.iter().enumerate().filter(|(k, _)| weights[*k] >= REJECTED) {
            let (key, t_s) = self.key(line, equations.places[k], k);
            keys.push((key, t_s, k));
        }
        // Rows without a time keep their order.
        keys.sort_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)).then(one.2.cmp(&other.2)));
        let mut rows = Rows {
            always,
            factors: DMatrix::zeros(keys.len(), equations.width),
            values: Vec::new(),
            series: Vec::new(),
            noise: Vec::new(),
            cluster: Vec::new(),
            run: Vec::new(),
            place: Vec::new(),
            side: Vec::new(),
            handicaps: self.candidates.iter().map(handicap).collect(),
        };
        let mut clusters = HashMap::new();
        let mut places = HashMap::new();
        let mut sides = HashMap::new();
        let one_sided = self.one_sided(&equations, &keys);
        let mut series = 0;
        for (place, (key, _, k)) in keys.iter().enumerate() {
            let line = &equations.lines[*k];
            series += usize::from(place > 0 && keys[place - 1].0 != *key);
            let (sigma, noise, cluster) = if line.row().is_some() {
                let next = clusters.len();
                let cluster = *clusters.entry((key.set, key.setup, key.component)).or_insert(next);
                (sigmas[group_of(line)], group_of(line), Some(cluster))
            } else {
                (self.tie_sigma(line), 2 * self.data.len(), None)
            };
            let scale = weights[*k].sqrt() / sigma;
            for (column, factor) in equations.row(*k).iter().enumerate() {
                rows.factors[(place, column)] = factor * scale;
            }
            rows.values.push(equations.values[*k] * scale);
            rows.series.push(series);
            rows.noise.push(noise);
            rows.cluster.push(cluster);
            rows.run.push(key.run);
            let next = places.len();
            let own = self.place(line);
            let direction = own.as_ref().map(|place| place.direction);
            let next_side = sides.len();
            rows.side.push(*sides.entry(direction).or_insert(next_side));
            let place = own.map(|own| if one_sided.contains(&group_of(line)) { own.of_any_side() } else { own });
            let label = (key.set, key.setup, key.component, key.place);
            rows.place.push(place.map(|own| *places.entry((label, own)).or_insert(next)));
        }
        Ok(rows)
    }

    /// A known distance has the weight of its uncertainty.
    fn tie_sigma(&self, line: &ReadingEquation) -> f64 {
        match line.origin {
            EquationOrigin::Tie(tie) => tie_sigma(self.data, line.set, tie),
            EquationOrigin::Row(_) => FIRST_SIGMA,
        }
    }

    /// The series of a line, and the time of its reading.
    fn key(&self, line: &ReadingEquation, place: usize, number: usize) -> (Key, f64) {
        let observation = self.data.get(line.set).zip(line.row()).and_then(|(set, row)| set.observations.get(row));
        let Some(observation) = observation else {
            // A known distance is a series by itself.
            return (Key { set: usize::MAX, setup: number, component: 0, run: 0, place }, 0.0);
        };
        let component = if observation.component.is_some() { observation.target.unwrap_or(0) } else { 0 };
        let key = Key { set: line.set, setup: observation.setup, component, run: observation.run, place };
        (key, observation.t_s.unwrap_or(0.0))
    }

    /// Groups of readings of which too few are repeated from one direction: there, the readings from the other direction show the noise.
    fn one_sided(&self, equations: &Equations, keys: &[(Key, f64, usize)]) -> HashSet<usize> {
        let mut counts = HashMap::new();
        let mut groups: HashMap<usize, [usize; 2]> = HashMap::new();
        let places: Vec<_> = keys
            .iter()
            .filter_map(|(key, _, k)| {
                let line = equations.lines.get(*k)?;
                Some((group_of(line), (key.set, key.setup, key.component, key.place, self.place(line)?)))
            })
            .collect();
        places.iter().for_each(|(_, place)| *counts.entry(place).or_insert(0_usize) += 1);
        for (group, place) in &places {
            let [repeated, all] = groups.entry(*group).or_default();
            *all += 1;
            *repeated += usize::from(counts.get(place).is_some_and(|&count| count > 1));
        }
        let is_one_sided = |&(_, [repeated, all]): &(usize, [usize; 2])| (repeated as f64) < REPEATED * all as f64;
        groups.into_iter().filter(is_one_sided).map(|(group, _)| group).collect()
    }

    /// Position and senses of a reading: repeated readings have the same; `None` for a known distance.
    fn place(&self, line: &ReadingEquation) -> Option<ReadingPlace> {
        let reading = &self.data.get(line.set)?.observations.get(line.row()?)?.reading;
        let place = AXES.map(|axis| (reading.position[axis] / SAME_PLACE).round() as i64);
        let tool = [0, 1, 2].map(|k| (reading.tool_mm[k] / SAME_PLACE).round() as i64);
        Some(ReadingPlace { position: place.into_iter().chain(tool).collect(), direction: reading.state.direction })
    }

    /// Weights of the equations, and the uncertainty of each group of readings, from all candidates together. With too few rows, from the fixed
    /// parameters, with equal weights.
    fn weigh(&self, equations: &Equations, always: usize) -> (Vec<f64>, Vec<f64>) {
        let count = equations.lines.len();
        let is_rich = count > 2 * equations.width;
        let width = if is_rich { equations.width } else { always };
        let sigma_of = |group: usize| if group.is_multiple_of(2) { FIRST_SIGMA } else { FIRST_ANGLE_SIGMA };
        let mut sigmas: Vec<f64> = (0..2 * self.data.len()).map(sigma_of).collect();
        let mut weights = vec![1.0; count];
        let is_much = count as f64 * (width as f64).powi(2) > MUCH;
        let each = if is_much { 1 } else { WEIGHT_ROUNDS };
        let rounds = if is_rich && self.options.robust { 2 * each + 1 } else { 1 };
        for round in 0..rounds {
            let residuals = residuals(equations, width, &weights, &sigmas);
            let freedom = 1.0 - (width as f64 / count.max(1) as f64).min(0.5);
            for (group, sigma) in sigmas.iter_mut().enumerate() {
                let own = equations.lines.iter().zip(&residuals).filter(|(line, _)| group_of(line) == group);
                let own: Vec<f64> =
                    own.filter(|(line, _)| line.row().is_some()).map(|(_, residual)| *residual).collect();
                let set = self.data.get(group / 2);
                let stated = set.and_then(|set| if group.is_multiple_of(2) { set.sigma } else { set.sigma_rad });
                // The fit passes through one or two readings, such as that of a square: their residuals are no spread.
                *sigma = if own.len() < FEWEST_FOR_SPREAD {
                    stated.unwrap_or(sigma_of(group))
                } else {
                    (spread(own.into_iter()) / freedom.sqrt()).max(LEAST_SPREAD * sigma_of(group))
                };
            }
            for ((to, line), residual) in weights.iter_mut().zip(&equations.lines).zip(&residuals) {
                if rounds > 1 && line.row().is_some() {
                    *to = weight(residual / sigmas[group_of(line)], round < each);
                }
            }
        }
        (weights, sigmas)
    }
}

/// Labels of a series, in sort order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Key {
    set: usize,
    setup: usize,
    component: usize,
    run: usize,
    place: usize,
}

/// Place of a reading: axis positions and tool, in steps of [`SAME_PLACE`], and the directions of approach.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct ReadingPlace {
    position: Vec<i64>,
    direction: [i8; AXIS_COUNT],
}

impl ReadingPlace {
    /// The place without its directions.
    fn of_any_side(self) -> ReadingPlace {
        ReadingPlace { direction: [0; AXIS_COUNT], ..self }
    }
}

/// Residuals of the values after a fit of the first columns.
fn residuals(equations: &Equations, width: usize, weights: &[f64], sigmas: &[f64]) -> Vec<f64> {
    let mut normal = Normal::new(width, 1);
    let mut lengths = vec![0.0_f64; width];
    for (k, (line, &weight)) in equations.lines.iter().zip(weights).enumerate() {
        let root = weight.sqrt() / sigmas.get(group_of(line)).copied().unwrap_or(FIRST_SIGMA);
        lengths.iter_mut().zip(equations.row(k)).for_each(|(sum, factor)| *sum += (factor * root).powi(2));
        normal.add(0, equations.row(k).get(..width).unwrap_or_default(), equations.values[k], root);
    }
    let mut held = vec![0.0; width];
    for (column, &square) in lengths.iter().enumerate() {
        held[column] = if square > 0.0 { square.sqrt() } else { 1.0 };
        normal.add(0, &held, 0.0, RIDGE);
        held[column] = 0.0;
    }
    let found = normal.solve().map(|step| step.unknowns);
    let left = |k: usize| {
        let said: f64 = found.iter().flat_map(|found| found.iter().zip(equations.row(k))).map(|(a, b)| a * b).sum();
        equations.values[k] - said
    };
    (0..equations.lines.len()).map(left).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::bench;

    #[test]
    fn few_rows_have_the_uncertainty_that_is_left_beside_what_is_always_in() {
        let machine = bench::machine();
        let data =
            [bench::table(&machine, "X,Y,Z,component,value_um\n0,0,0,EXX,0\n", "[measurement]\nkind = \"direct\"\n")];
        let job = Job {
            machine: &machine,
            start: &ErrorModel::default(),
            base: &[],
            candidates: &[],
            data: &data,
            options: FitOptions { robust: true },
        };
        // Eight rows without information on two unknowns and two candidates.
        let line = |row| ReadingEquation { residual: 0.0, set: 0, origin: EquationOrigin::Row(row), is_angle: false };
        let equations = Equations {
            lines: (0..8).map(line).collect(),
            places: vec![0; 8],
            factors: vec![0.0; 32],
            values: [2e-3, -2e-3].repeat(4),
            width: 4,
        };
        let (weights, sigmas) = job.weigh(&equations, 2);
        assert_eq!(weights, [1.0; 8]);
        // The median is 0.6745 standard deviations, and the two absorb a quarter of the squares.
        assert!((sigmas[0] - 2e-3 / 0.674_489_75 / 0.75_f64.sqrt()).abs() < 1e-9, "{sigmas:?}");
    }
}
