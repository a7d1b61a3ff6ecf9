//! What data or a plan can tell of parameters, before anything is fitted: rank, singular values, null space in words.

use crate::machine::Machine;
use crate::measure::data::DataSet;
use crate::model::ErrorModel;
use crate::numeric::System;

use super::column::Column;
use super::design::Design;
use super::effect::Parameter;
use super::noise::{FIRST_ANGLE_SIGMA, FIRST_SIGMA};
use super::words::{self, Lost};

/// What the data can tell. Of the readings only counts that there are some: zeros do for a plan, while empty cells say nothing.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Parameters of the machine, then unknowns of the measurements.
    pub columns: Vec<Column>,
    /// Equations.
    pub equations: usize,
    /// Of the equations with columns of unit length, the largest first.
    pub singular_values: Vec<f64>,
    /// How many combinations of all columns can be told.
    pub rank: usize,
    /// How many of them are the machine's: what is left of the rank behind the unknowns of the measurements.
    pub machine_rank: usize,
    /// Largest by smallest singular value that is not zero.
    pub condition: f64,
    /// How much the variance of each column grows because others are free; infinite where it cannot be told.
    pub inflation: Vec<f64>,
    /// Standard uncertainty of each column at readings of uncertainty 1 mm, angles 1 mrad; infinite where it cannot be told.
    pub sigmas: Vec<f64>,
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
    let design = Design::new(machine, data, parameters);
    let values = design.start(start);
    let count = parameters.len();
    let mut all = System::new(design.columns.len());
    let mut unknowns = System::new(design.columns.len().saturating_sub(count));
    let mut strongest = vec![0.0_f64; design.columns.len()];
    design.walk(start, &values, true, |_, factors| {
        strongest.iter_mut().zip(factors).for_each(|(most, factor)| *most = most.max(factor.abs()));
    });
    let weak = design.weak(&strongest);
    let mut own = vec![0.0; design.columns.len()];
    design.walk(start, &values, true, |line, factors| {
        own.copy_from_slice(factors);
        weak.iter().for_each(|&column| own[column] = 0.0);
        // Known distances count as readings, and 1 µm as 1 µrad: what can be told does not depend on how well.
        let weight = if line.is_angle { FIRST_SIGMA / FIRST_ANGLE_SIGMA } else { 1.0 };
        all.add(&own, 0.0, weight);
        unknowns.add(own.get(count..).unwrap_or_default(), 0.0, weight);
    });
    let equations = all.rows();
    let (all, unknowns) = (all.solve()?, unknowns.solve()?);
    Some(Identified {
        equations,
        rank: all.rank,
        machine_rank: all.rank - unknowns.rank.min(all.rank),
        condition: all.condition(),
        lost: words::lost(&all.null_space, &design.columns, data),
        sigmas: all
            .cofactors
            .diagonal()
            .iter()
            .zip(&all.inflation)
            .map(|(variance, inflation)| if inflation.is_finite() { variance.sqrt() } else { f64::INFINITY })
            .collect(),
        singular_values: all.singular_values,
        inflation: all.inflation,
        columns: design.columns,
    })
}
