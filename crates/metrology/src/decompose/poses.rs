//! State of the machine at the samples of a run: positions of tool and ball by set-points and by encoders, effect of small axis errors, accelerations
//! of the axes.

use crate::measure::trace::Trace;
use ncfix_base::geometry::{Axis, AxisVector, Matrix, Vector};
use ncfix_machine::machine::State;
use ncfix_model::{ErrorName, Model};

use super::grid::RunGrid;
use super::signal::second_difference;

/// Arm for angles in the length of a path, mm.
const ARM_MM: f64 = 100.0;

/// The samples of a run.
#[derive(Clone, Debug)]
pub struct RunPoses {
    /// Set-points, at the instants of the encoders.
    pub set: Vec<AxisVector>,
    /// Encoder positions.
    pub encoder: Vec<AxisVector>,
    /// Accelerations from encoders, mm/s² or rad/s², as weighted means over [`RunPoses::reach`] samples on both sides.
    pub acceleration: Vec<AxisVector>,
    /// Jerks from encoders, averaged equally, mm/s³ or rad/s³.
    pub jerk: Vec<AxisVector>,
    /// Number of samples on each side in the averages.
    pub reach: usize,
    /// Displacement of the tool from the ball by set-points and by encoders, on an error-free machine, along F's directions, mm.
    pub nominal: [Vec<Vector>; 2],
    /// Relative path position by set-points, 0 to 1.
    pub share: Vec<f64>,
    /// Length of the path, mm; angles count with an arm of 100 mm.
    pub length_mm: f64,
    /// From the workpiece frame to F's directions, by encoders.
    pub to_f: Vec<Matrix>,
}

impl RunPoses {
    /// Computes the poses of a run, with the delay of the encoders relative to the set-points removed.
    #[must_use]
    pub fn new(model: &Model, trace: &Trace, tool_mm: &Vector, grid: &RunGrid, delay_s: f64, reach: usize) -> RunPoses {
        let set: Vec<AxisVector> = (0..grid.count).map(|k| grid.set_at(grid.time(k) - delay_s)).collect();
        let encoder: Vec<AxisVector> = (0..grid.count).map(|k| grid.encoder(k)).collect();
        let mut acceleration = vec![AxisVector::ZERO; grid.count];
        let mut jerk = acceleration.clone();
        for (axis, pair) in &grid.axes {
            let own = second_difference(&pair.encoder.values, reach, grid.step_s);
            for (k, value) in own.iter().enumerate() {
                acceleration[k][*axis] = *value;
                let around = [k.saturating_sub(1), (k + 1).min(own.len() - 1)].map(|k| own[k]);
                jerk[k][*axis] = (around[1] - around[0]) / (2.0 * grid.step_s);
            }
        }
        let to_f = |command: &AxisVector| {
            model.tool_orientation(command) * model.nominal(command, tool_mm).rotation.transpose()
        };
        let turns: Vec<Matrix> = encoder.iter().map(to_f).collect();
        // With a ball: displacement of the tool from it. Without: from the target position.
        let off = |command: &AxisVector, set: &AxisVector, to_f: &Matrix| {
            let tip = model.nominal(command, tool_mm).translation;
            to_f * (tip - trace.ball_mm.unwrap_or_else(|| model.nominal(set, tool_mm).translation))
        };
        let by_set = set.iter().map(|set| off(set, set, &to_f(set))).collect();
        let by_encoder = encoder.iter().zip(&set).zip(&turns).map(|((one, set), turn)| off(one, set, turn)).collect();
        let mut share = vec![0.0; grid.count];
        for k in 1..grid.count {
            share[k] = share[k - 1] + way(&set[k - 1], &set[k], grid);
        }
        let length_mm = share.last().copied().unwrap_or(0.0);
        if length_mm > 0.0 {
            share.iter_mut().for_each(|share| *share /= length_mm);
        }
        RunPoses {
            set,
            encoder,
            acceleration,
            jerk,
            reach,
            nominal: [by_set, by_encoder],
            share,
            length_mm,
            to_f: turns,
        }
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> usize {
        self.set.len()
    }

    /// Effect of an error of 1 mm or 1 rad of a component on the tool at a sample, along F's directions, mm.
    #[must_use]
    pub fn effect(&self, model: &Model, name: ErrorName, tool_mm: &Vector, number: usize) -> Vector {
        let command = &self.encoder[number];
        model.tool_orientation(command) * model.sensitivity(name, command, tool_mm).translation
    }

    /// Prediction of an error model at a sample, with its direction of motion and rates, mm.
    #[must_use]
    pub fn predicted(&self, model: &Model, tool_mm: &Vector, number: usize, with_rates: bool) -> Vector {
        let mut state = State::default();
        let now = &self.encoder[number];
        if let Some(before) = number.checked_sub(1).and_then(|k| self.encoder.get(k)) {
            state.note_motion(before, now);
        }
        if with_rates {
            (state.acceleration, state.jerk) = (self.acceleration[number], self.jerk[number]);
        }
        model.deviation(now, tool_mm, &state).translation
    }

    /// `true` if an axis accelerates.
    #[must_use]
    pub fn accelerate(&self, axis: Axis) -> bool {
        let most = self.acceleration.iter().map(|all| all[axis].abs()).fold(0.0, f64::max);
        // 10 mm/s² and 0.1 rad/s²: the noise of encoders.
        most > if axis.is_rotary() { 0.1 } else { 10.0 }
    }
}

fn way(from: &AxisVector, to: &AxisVector, grid: &RunGrid) -> f64 {
    let squares = grid.axes.iter().map(|(axis, _)| {
        let step = to[*axis] - from[*axis];
        if axis.is_rotary() { (ARM_MM * step).powi(2) } else { step * step }
    });
    squares.sum::<f64>().sqrt()
}
