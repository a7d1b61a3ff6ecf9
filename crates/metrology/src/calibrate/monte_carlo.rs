//! Check of uncertainties: simulated readings of the fitted machine with the estimated noise are fitted repeatedly, and the scatter is compared.
//!
//! Poses, conditions, set-ups, weights and known distances are those of the data. Noise is normal, with the estimated uncertainty of each measurement
//! and that of each known distance. The scatter contains effects missing in the covariance: weights that follow the noise, nonlinear equations, few
//! readings.

use crate::measure::data::DataSet;
use crate::measure::noise::Noise;
use crate::measure::simulate::{ReadValue, Simulation};
use ncfix_base::geometry::Axis;
use ncfix_base::numeric::repeated;
use ncfix_machine::machine::Machine;

use super::column::Column;
use super::design::TIE_SIGMA;
use super::effect::Parameter;
use super::fault::FitError;
use super::fit::{Fit, FitOptions, fit_judged};
use super::identify::{Identified, judge};
use super::mean_line::level;

/// Permitted relative difference between uncertainty and scatter.
const AGREES: f64 = 0.25;
/// Additional tolerance in standard deviations of an estimated standard deviation.
const SAMPLING: f64 = 3.0;
/// Increment between seeds: an odd number without structure.
const NEXT_SEED: u64 = 0xd134_2543_de82_ef95;

/// The scatter of repetitions.
#[derive(Clone, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Standard deviation of every estimate, in the order of [`Fit::estimates`].
    pub spreads: Vec<f64>,
    /// Number of successful repetitions.
    pub runs: usize,
    /// Number of failed repetitions.
    pub failed: usize,
}

impl MonteCarlo {
    /// `true` if a standard uncertainty differs from the scatter by more than 25 % beyond sampling error.
    #[must_use]
    pub fn contradicts(&self, spread: f64, sigma: f64) -> bool {
        let sampling = SAMPLING / (2.0 * self.runs.saturating_sub(1).max(1) as f64).sqrt();
        sigma.is_finite() && sigma > 0.0 && (spread / sigma - 1.0).abs() > AGREES + sampling
    }
}

/// Repeats a fit on simulated readings; `progress` receives the number of completed ones. The same seed gives the same result on any number of cores.
///
/// # Errors
/// [`FitError`] if the data do not identify the parameters.
pub fn monte_carlo(
    machine: &Machine,
    parameters: &[impl Clone + Into<Parameter>],
    data: &[DataSet],
    fit: &Fit,
    options: FitOptions,
    [runs, seed]: [u64; 2],
    progress: &mut dyn FnMut(u64),
) -> Result<MonteCarlo, FitError> {
    let parameters: Vec<Parameter> = parameters.iter().cloned().map(Into::into).collect();
    let judged = judge(machine, &fit.errors, &parameters, data)?;
    let job = Job { machine, parameters: &parameters, data, fit, options, judged: &judged, seed };
    let count = usize::try_from(runs).unwrap_or(usize::MAX);
    let all = repeated(count, &|run| job.repeat(run), progress);
    let failed = all.iter().filter(|values| values.is_none()).count();
    let found: Vec<Vec<f64>> = all.into_iter().flatten().collect();
    let n = found.len() as f64;
    let spreads = (0..fit.estimates.len())
        .map(|column| {
            let values = || found.iter().filter_map(|values| values.get(column).copied());
            let mean = values().sum::<f64>() / n.max(1.0);
            (values().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt()
        })
        .collect();
    Ok(MonteCarlo { spreads, runs: found.len(), failed })
}

/// Common data of all repetitions.
struct Job<'a> {
    machine: &'a Machine,
    parameters: &'a [Parameter],
    data: &'a [DataSet],
    fit: &'a Fit,
    options: FitOptions,
    judged: &'a Identified,
    seed: u64,
}

impl Job<'_> {
    /// The estimates of one repetition.
    fn repeat(&self, run: usize) -> Option<Vec<f64>> {
        let mut noise = Noise::new(self.seed.wrapping_add((run as u64).wrapping_mul(NEXT_SEED)));
        let mut data = self.data.to_vec();
        for (number, set) in data.iter_mut().enumerate() {
            self.read(number, set, &mut noise)?;
        }
        let found =
            fit_judged(self.machine, &self.fit.errors, self.parameters, &data, self.options, self.judged).ok()?;
        let mut values = found.estimates.iter().map(|one| one.value).collect();
        // A repetition begins with the slopes of the fit.
        level(&self.fit.mean_lines, &self.fit.errors, &mut values);
        Some(values)
    }

    /// Simulates new readings of a measurement.
    fn read(&self, number: usize, set: &mut DataSet, noise: &mut Noise) -> Option<()> {
        let values: Vec<f64> = self
            .fit
            .estimates
            .iter()
            .filter(|one| matches!(one.column, Column::Unknown(own, _) if own == number))
            .map(|one| one.value)
            .collect();
        let (sigma, sigma_rad) = (*self.fit.sigmas.get(number)?, *self.fit.angle_sigmas.get(number)?);
        let plan = set.clone();
        let mut simulation = Simulation::with_unknowns(self.machine, &self.fit.errors, &plan, values.clone());
        for observation in &mut set.observations {
            let is_angle = observation.component.is_some_and(|name| name.direction.is_rotation());
            let sigma = if is_angle { sigma_rad } else { sigma };
            match simulation.read(observation).ok()? {
                ReadValue::Values(read) => {
                    observation.values = read.map(|value| value.map(|value| value + sigma * noise.normal()));
                }
                ReadValue::Position(position) => {
                    observation.reading.position = position;
                    for axis in [Axis::X, Axis::Y, Axis::Z] {
                        observation.reading.position[axis] += sigma * noise.normal();
                    }
                }
            }
        }
        for length in &mut set.lengths {
            let [from, to] = length.between.map(|ball| values.get(3 * ball..3 * ball + 3));
            let squares = from?.iter().zip(to?).map(|(one, other)| (one - other).powi(2));
            length.value_mm = squares.sum::<f64>().sqrt() + length.sigma_mm.unwrap_or(TIE_SIGMA) * noise.normal();
        }
        Some(())
    }
}
