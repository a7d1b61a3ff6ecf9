//! A trace on a common clock: estimated delays, resampled runs, and the machine pose at every sample.

use crate::measure::trace::{Trace, TraceRun};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::numeric::in_parts;
use ncfix_machine::machine::Machine;
use ncfix_model::{ErrorModel, Model};

use super::clock::{Clock, clock, reading};
use super::grid::RunGrid;
use super::parts::{DecompositionError, DecompositionOptions};
use super::poses::RunPoses;
use super::servo::{ServoErrors, servo};

/// Averaging time of accelerations on both sides, s.
const REACH_S: f64 = 0.009;
/// Largest relative difference of the path lengths of runs of one program.
const SAME_PATH: f64 = 0.02;
/// Minimum path length, mm.
const LEAST_MM: f64 = 1.0;
/// Ratio of encoder travel to set-point travel above which, or below the inverse of which, the unit is wrong.
const OTHER_UNIT: f64 = 2.0;

/// The resampled runs, the slowest first, and their indices in the trace.
fn grids(machine: &Machine, trace: &Trace) -> (Vec<Axis>, Vec<usize>, Vec<RunGrid>) {
    let axes: Vec<Axis> = machine.axes.iter().flatten().map(|data| data.axis).collect();
    let mut order: Vec<usize> = (0..trace.runs.len()).collect();
    let feed = |run: &TraceRun| run.feed_mm_min.unwrap_or(0.0);
    order.sort_by(|&a, &b| feed(&trace.runs[a]).total_cmp(&feed(&trace.runs[b])));
    let runs: Vec<&TraceRun> = order.iter().map(|&number| &trace.runs[number]).collect();
    let grids = in_parts(&runs, &|run| RunGrid::new(run, &axes));
    (axes, order, grids)
}

/// Estimates the delay between the recordings, if it is not known.
fn find_servo(axes: &[Axis], grids: &[RunGrid], options: &DecompositionOptions) -> Option<ServoErrors> {
    let pairs: Vec<_> = axes
        .iter()
        .enumerate()
        .map(|(place, &axis)| (axis, grids.iter().map(|grid| grid.axes[place].1.clone()).collect()))
        .collect();
    let mut found = servo(&pairs)?;
    if let Some(known) = options.record_delay_s {
        (found.delay_s, found.uncertainty_s) = (known, 0.0);
    }
    Some(found)
}

/// A trace on a common clock.
#[derive(Clone, Debug)]
pub(super) struct Synchronous {
    /// The axes of the machine.
    pub(super) axes: Vec<Axis>,
    /// The indices of the runs in the trace, the slowest first; all lists are in this order.
    pub(super) order: Vec<usize>,
    /// The resampled runs.
    pub(super) grids: Vec<RunGrid>,
    /// The machine poses at their samples.
    pub(super) poses: Vec<RunPoses>,
    /// χ − χenc by run and sample, mm.
    pub(super) left: Vec<Vec<Option<Vector>>>,
    /// Delay of the encoders, and the loops.
    pub(super) servo: ServoErrors,
    /// Delay of the instrument.
    pub(super) clock: Option<Clock>,
    /// The tool vector, mm.
    pub(super) tool_mm: Vector,
    /// The machine without errors.
    pub(super) nominal: Model,
}

/// Brings a trace to a common clock.
///
/// # Errors
/// [`DecompositionError`].
pub(super) fn synchronous(
    machine: &Machine,
    trace: &Trace,
    options: &DecompositionOptions,
) -> Result<Synchronous, DecompositionError> {
    synchronous_telling(machine, trace, options, &mut |_, _| {})
}

pub(super) fn synchronous_telling(
    machine: &Machine,
    trace: &Trace,
    options: &DecompositionOptions,
    tell: &mut dyn FnMut(&str, f64),
) -> Result<Synchronous, DecompositionError> {
    tell("delays and servo loops", 0.0);
    let (axes, order, grids) = grids(machine, trace);
    check_units(&grids)?;
    let servo = find_servo(&axes, &grids, options).ok_or(DecompositionError::Still)?;
    let nominal = Model::new(machine, &ErrorModel::default());
    let tool_mm = trace.runs.first().map_or_else(Vector::zeros, |run| run.tool_mm);
    let pose = |grid: &RunGrid| {
        let reach = ((REACH_S / grid.step_s).round() as usize).max(1);
        RunPoses::new(&nominal, trace, &tool_mm, grid, servo.delay_s, reach)
    };
    let poses = in_parts(&grids, &pose);
    check_paths(&poses, &order)?;
    tell("clock of the instrument", 0.3);
    let mut clock =
        if trace.has_readings() { Some(clock(&grids, &poses, &axes).ok_or(DecompositionError::Apart)?) } else { None };
    if let (Some(clock), Some(known)) = (&mut clock, options.reading_delay_s) {
        (clock.delay_s, clock.uncertainty_s) = (known, 0.0);
    }
    let left = left(&grids, &poses, clock.as_ref());
    Ok(Synchronous { axes, order, grids, poses, left, servo, clock, tool_mm, nominal })
}

/// Checks that the encoders travel as far as the set-points.
fn check_units(grids: &[RunGrid]) -> Result<(), DecompositionError> {
    let span = |values: &[f64]| {
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        most - values.iter().copied().fold(f64::INFINITY, f64::min)
    };
    for (axis, pair) in grids.iter().flat_map(|grid| &grid.axes) {
        let [set, encoder] = [&pair.set, &pair.encoder].map(|signal| span(&signal.values));
        let least = if axis.is_rotary() { LEAST_MM / 100.0 } else { LEAST_MM };
        if set > least && !(1.0 / OTHER_UNIT..OTHER_UNIT).contains(&(encoder / set)) {
            return Err(DecompositionError::Units(*axis, [set, encoder]));
        }
    }
    Ok(())
}

/// Checks that all runs follow one path.
fn check_paths(poses: &[RunPoses], order: &[usize]) -> Result<(), DecompositionError> {
    let Some(first) = poses.first() else { return Err(DecompositionError::Still) };
    if first.length_mm < LEAST_MM {
        return Err(DecompositionError::Still);
    }
    for (other, &number) in poses.iter().zip(order).skip(1) {
        if (other.length_mm / first.length_mm - 1.0).abs() > SAME_PATH {
            return Err(DecompositionError::OtherPath([order[0], number], [first.length_mm, other.length_mm]));
        }
    }
    Ok(())
}

/// χ − χenc by run and sample.
fn left(grids: &[RunGrid], poses: &[RunPoses], clock: Option<&Clock>) -> Vec<Vec<Option<Vector>>> {
    let one = |(grid, poses): (&RunGrid, &RunPoses)| {
        let at = |number: usize| Some(reading(grid, number, clock?.delay_s)? - poses.nominal[1][number]);
        (0..poses.count()).map(at).collect()
    };
    grids.iter().zip(poses).map(one).collect()
}
