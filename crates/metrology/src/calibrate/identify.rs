//! What data or a plan can tell of parameters, before anything is fitted: rank, singular values, null space in words.
//!
//! Judged on the machine without errors ([`super::exact`]). Of the readings only counts that there are some: zeros do for a plan, while empty
//! cells say nothing.

use crate::measure::data::DataSet;
use ncfix_base::numeric::System;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::column::Column;
use super::design::Design;
use super::effect::Parameter;
use super::exact::exact;
use super::fault::Fault;
use super::noise::{FIRST_ANGLE_SIGMA, FIRST_SIGMA};
use super::words::{self, Lost};

/// Columns without a larger factor are zero, as a share of what they can move.
const NOTHING: f64 = 1e-12;

/// What the data can tell.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Parameters of the machine, then unknowns of the measurements.
    pub columns: Vec<Column>,
    /// Equations.
    pub equations: usize,
    /// Of the equations with columns of unit length, the largest first.
    pub singular_values: Vec<f64>,
    /// How many combinations of all columns can be told; without unknowns of set-ups that hardly move a reading, and stay.
    pub rank: usize,
    /// How many of them are the machine's: what is left of the rank behind the unknowns of the measurements.
    pub machine_rank: usize,
    /// Largest by smallest singular value that is not zero.
    pub condition: f64,
    /// How much the variance of each column grows because others are free; infinite where it cannot be told.
    pub inflation: Vec<f64>,
    /// Standard uncertainty of each column at readings of uncertainty 1 mm, angles 1 mrad; infinite where it cannot be told.
    pub sigmas: Vec<f64>,
    /// By how much a unit of each parameter moves the tip, root of the mean square over the readings, mm.
    pub effects: Vec<f64>,
    /// What cannot be told, in words.
    pub lost: Lost,
}

/// Looks at what data can tell of parameters. `None` where positions are so large that numbers are not finite.
#[must_use]
pub fn identify(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
) -> Option<Identified> {
    identify_exact(machine, start, parameters, &exact(machine, data))
}

/// The same with data that are exact already.
pub(super) fn identify_exact(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
) -> Option<Identified> {
    let design = Design::new(machine, data, parameters);
    let values = design.start(&ErrorModel::default());
    let mut all = System::new(design.columns.len());
    let mut strongest = vec![0.0_f64; design.columns.len()];
    // What acts beside others, as the arm of a load, has its factors where these are at the start.
    design.walk_exact(start, &values, |line, factors| {
        strongest.iter_mut().zip(factors).for_each(|(most, factor)| *most = most.max(factor.abs()));
        // Known distances count as readings, and 1 µm as 1 µrad: what can be told does not depend on how well.
        all.add(factors, 0.0, if line.is_angle { FIRST_SIGMA / FIRST_ANGLE_SIGMA } else { 1.0 });
    });
    // What is left by the arithmetic is nothing. What moves readings a little, as the height of a ball over a circle that is not quite flat, counts
    // here: without it, what depends on it would look as if it could be told.
    let reach = design.reach(start);
    (0..strongest.len()).filter(|&k| strongest[k] < NOTHING * reach[k]).for_each(|column| all.clear(column));
    let equations = all.rows();
    let unknowns = all.behind(parameters.len()).solve()?;
    let all = all.solve()?;
    let mut lost = words::lost(&all.null_space, &design.columns, data);
    let weak: Vec<usize> = design.weak(&strongest).into_iter().filter(|column| !lost.held.contains(column)).collect();
    lost.held.extend(&weak);
    lost.loose.extend(&weak);
    Some(Identified {
        equations,
        rank: all.rank - weak.len().min(all.rank),
        machine_rank: all.rank - unknowns.rank.min(all.rank),
        condition: all.condition(),
        lost,
        sigmas: all
            .cofactors
            .diagonal()
            .iter()
            .zip(&all.inflation)
            .map(|(variance, inflation)| if inflation.is_finite() { variance.sqrt() } else { f64::INFINITY })
            .collect(),
        effects: design.effects(start),
        singular_values: all.singular_values,
        inflation: all.inflation,
        columns: design.columns,
    })
}

/// Whether data can tell parameters at all.
pub(super) fn judge(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[Parameter],
    data: &[DataSet],
) -> Result<Identified, Fault> {
    let judged = identify(machine, start, parameters, data).ok_or(Fault::NotSettled(None))?;
    if judged.equations < judged.columns.len() {
        let Identified { equations, columns, lost, .. } = judged;
        return Err(Fault::TooFew { equations, unknowns: columns.len(), lost: Box::new(lost) });
    }
    if judged.lost.leave_out.is_empty() { Ok(judged) } else { Err(Fault::NotTold(Box::new(judged.lost))) }
}
