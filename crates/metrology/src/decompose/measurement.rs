//! A trace as a measurement for calibration and diagnosis: on a common clock, at the encoder positions.

use crate::measure::data::{DataColumn, DataSet, Free, Observation, Setup};
use crate::measure::kind;
use crate::measure::reading::Reading;
use crate::measure::trace::Trace;
use ncfix_base::diagnostic::Place;
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::ErrorModel;

use super::parts::{DecompositionError, decompose};
use super::signal::triangle;
use super::together::{Synchronous, synchronous};

/// The column of the feed.
const FEED: &str = "feed_mm_min";

/// Content of the readings of a trace.
#[derive(Clone, Copy, Debug)]
pub enum Of<'a> {
    /// The displacement of the tool from the encoder position, which a calibration explains.
    Everything,
    /// As [`Of::Everything`], minus fitted links, motion errors, drift and set-up in addition to a model: one path does not separate these, and the
    /// speed-dependent part remains.
    Speed(&'a ErrorModel),
}

/// Creates it: readings are averaged as the accelerations are, with one reading per averaging time.
///
/// # Errors
/// [`DecompositionError`].
pub fn measurement(machine: &Machine, trace: &Trace, of: Of<'_>, place: Place) -> Result<DataSet, DecompositionError> {
    let options = super::DecompositionOptions::default();
    let Synchronous { axes, order, grids, poses, mut left, .. } = synchronous(machine, trace, &options)?;
    if let Of::Speed(errors) = of {
        let found = decompose(machine, errors, trace, &options, &mut |_, _| {})?;
        for (left, run) in left.iter_mut().zip(&found.runs) {
            for ((left, parts), known) in left.iter_mut().zip(&run.parts).zip(&run.known) {
                *left = parts.map(|[.., dynamic]| dynamic + known);
            }
        }
    }
    let mut setups = Vec::new();
    let mut observations = Vec::new();
    for (run, ((&number, grid), poses)) in order.iter().zip(&grids).zip(&poses).enumerate() {
        let one = &trace.runs[number];
        setups.push(Setup { label: one.label.clone(), ..Setup::default() });
        let smooth: Vec<Vec<f64>> = (0..3)
            .map(|k| {
                let values: Vec<f64> = left[run].iter().map(|left| left.map_or(0.0, |left| left[k])).collect();
                triangle(&values, poses.reach)
            })
            .collect();
        let mut state = State::default();
        let mut before = poses.encoder.first().copied().unwrap_or_default();
        for k in (poses.reach..poses.count().saturating_sub(poses.reach)).step_by(poses.reach) {
            let position = poses.encoder[k];
            note_motion(&mut state, &axes, &before, &position);
            before = position;
            if [k - poses.reach, k, k + poses.reach].iter().any(|&k| left[run][k].is_none()) {
                continue;
            }
            let state = State { acceleration: poses.acceleration[k], jerk: poses.jerk[k], ..state };
            observations.push(Observation {
                reading: Reading { position, tool_mm: one.tool_mm, state },
                setup: run,
                run,
                t_s: Some(grid.time(k)),
                condition: 0,
                temperature_c: None,
                feed: one.feed_mm_min,
                cycle: None,
                values: [0, 1, 2].map(|axis| Some(smooth[axis][k])),
                target: None,
                component: None,
                spindle_rad: 0.0,
                place: one.readings.place_at(grid.time(k)).or(one.place).unwrap_or(place),
            });
        }
    }
    let feeds: Vec<f64> = observations.iter().map(|row| row.feed.unwrap_or(f64::NAN)).collect();
    let has_feeds = feeds.iter().any(|feed| !feed.is_nan());
    Ok(DataSet {
        name: trace.name.clone(),
        kind: &kind::TRACE,
        date: None,
        head: None,
        sigma: None,
        sigma_rad: None,
        scale_sigma: 0.0,
        free: vec![Free::Offset],
        artefact: Setup::default(),
        runs: setups.iter().map(|setup| setup.label.clone()).collect(),
        setups,
        rods: Vec::new(),
        cycles: Vec::new(),
        targets: Vec::new(),
        lengths: Vec::new(),
        balls: Vec::new(),
        is_plan: false,
        fixed: Vec::new(),
        ranges: Vec::new(),
        conditions: Vec::new(),
        is_in_order: true,
        is_order_stated: true,
        is_unit_stated: false,
        is_square_stated: false,
        sensors: None,
        has_senses: true,
        observations,
        drivers: if has_feeds { vec![DataColumn { name: FEED.to_owned(), values: feeds }] } else { Vec::new() },
    })
}

/// Records directions of motion; encoder noise does not count as motion.
fn note_motion(state: &mut State, axes: &[Axis], before: &AxisVector, now: &AxisVector) {
    for &axis in axes {
        let step = now[axis] - before[axis];
        // 1 µm or 2 µrad.
        if step.abs() > if axis.is_rotary() { 2e-6 } else { 1e-3 } {
            state.direction[axis.slot()] = if step > 0.0 { 1 } else { -1 };
        }
    }
}
