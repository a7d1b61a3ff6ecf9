//! Identifiability of parameters from data or a plan, before any fit: rank, singular values, null space in words.
//!
//! The computation uses an error-free machine ([`super::exact`]). Only the existence of readings matters: zeros suffice for a plan, but empty cells give no
//! information.

use crate::measure::data::DataSet;
use ncfix_base::numeric::BorderedSystem;
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

use super::column::Column;
use super::design::Design;
use super::effect::Parameter;
use super::exact::exact;
use super::fault::FitError;
use super::noise::{FIRST_ANGLE_SIGMA, FIRST_SIGMA};
use super::words::{self, Lost};

/// Derivative below which a column is zero, as a share of its possible motion.
const NOTHING: f64 = 1e-12;

/// Identifiability of parameters.
#[derive(Clone, Debug)]
pub struct Identified {
    /// Parameters of the machine, then unknowns of the measurements.
    pub columns: Vec<Column>,
    /// Number of equations.
    pub equations: usize,
    /// Singular values of the equations with columns of unit length, in descending order.
    pub singular_values: Vec<f64>,
    /// Number of identifiable combinations of all columns, without set-up unknowns that hardly affect a reading, which are held.
    pub rank: usize,
    /// Number of identifiable combinations of machine parameters: the rank minus that of the unknowns of the measurements.
    pub machine_rank: usize,
    /// Condition number: largest to smallest nonzero singular value.
    pub condition: f64,
    /// Variance inflation factor of each column; infinite if not identifiable.
    pub inflation: Vec<f64>,
    /// Standard uncertainty of each column for readings with an uncertainty of 1 mm or 1 mrad; infinite if not identifiable.
    pub sigmas: Vec<f64>,
    /// Tip motion per unit of each parameter, root mean square over the readings, mm.
    pub effects: Vec<f64>,
    /// The unidentifiable part, in words.
    pub lost: Lost,
}

/// Determines the identifiability of parameters. `None` if positions are so large that numbers are not finite.
#[must_use]
pub fn identify(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
) -> Option<Identified> {
    identify_exact(machine, start, parameters, &exact(machine, data))
}

/// As [`identify`], with exact data.
pub(super) fn identify_exact(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
) -> Option<Identified> {
    let design = Design::new(machine, data, parameters);
    let values = design.start(&ErrorModel::default());
    let mut all = BorderedSystem::new(design.columns.len(), parameters.len());
    let mut strongest = vec![0.0_f64; design.columns.len()];
    // Derivatives of a dependent parameter, such as the arm of a load, are those at the start values.
    design.walk_exact(start, &values, |line, factors| {
        strongest.iter_mut().zip(factors).for_each(|(most, factor)| *most = most.max(factor.abs()));
        // Known distances count as readings, and 1 µm as 1 µrad: identifiability does not depend on the accuracy.
        all.add(factors, 0.0, if line.is_angle { FIRST_SIGMA / FIRST_ANGLE_SIGMA } else { 1.0 });
    });
    // Rounding noise counts as zero. A small effect on readings, as of the height of a ball over a slightly uneven circle, counts here: without it,
    // dependent unknowns would seem identifiable.
    let reach = design.reach(start);
    (0..strongest.len()).filter(|&k| strongest[k] < NOTHING * reach[k]).for_each(|column| all.clear(column));
    let equations = all.rows();
    let of_unknowns = all.rank_besides(parameters.len())?;
    let all = all.solve()?;
    let mut lost = words::lost(&all.null_space, &design.columns, data);
    words::name_other_axis(&mut lost, machine);
    let weak: Vec<usize> = design.weak(&strongest).into_iter().filter(|column| !lost.held.contains(column)).collect();
    lost.held.extend(&weak);
    lost.loose.extend(&weak);
    Some(Identified {
        equations,
        rank: all.rank - weak.len().min(all.rank),
        machine_rank: all.rank - of_unknowns.min(all.rank),
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

/// Checks that data identify the parameters.
pub(super) fn judge(
    machine: &Machine,
    start: &ErrorModel,
    parameters: &[Parameter],
    data: &[DataSet],
) -> Result<Identified, FitError> {
    let judged = identify(machine, start, parameters, data).ok_or(FitError::NotSettled(None))?;
    if judged.equations < judged.columns.len() {
        let Identified { equations, columns, lost, .. } = judged;
        return Err(FitError::TooFew { equations, unknowns: columns.len(), lost: Box::new(lost) });
    }
    if judged.lost.leave_out.is_empty() { Ok(judged) } else { Err(FitError::NotIdentified(Box::new(judged.lost))) }
}
