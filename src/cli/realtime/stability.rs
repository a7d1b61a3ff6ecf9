//! The page of the simulation of scale compensation against set-point compensation.

use std::path::Path;

use crate::cli::exit_code::ExitCode;
use crate::cli::output::{Old, Spool, Target};
use crate::cli::stop::Stop;
use ncfix_report::page::stability::{Rest, Stability, Trace, stability};
use ncfix_tables::realtime::stability::{Compensation, approach_um, run, there_and_back_um, unrest_um};

/// Steps of the table in the pictures over time, µm: that of the limit cycle, and the one of an increment, both as measured by Spaan.
const STEPS_UM: [f64; 2] = [-2.0, -1.0];
/// Where the axis is sent, µm from the grid point: where the step of 2 µm leaves no rest.
const PLACE_UM: f64 = 0.25;
/// How far from the grid point the axis is looked at, µm.
const REACH_UM: f64 = 6.0;

/// Simulates and writes the page.
pub(super) fn write(path: &Path) -> Result<ExitCode, Stop> {
    let trace = |compensation: Compensation, step_um: f64| {
        let moments = run(compensation, step_um, &approach_um(PLACE_UM));
        let points = moments.iter().map(|moment| (moment.time_s, moment.measured_um)).collect();
        Trace { step_um, unrest_um: unrest_um(&moments), points }
    };
    let rest = |compensation: Compensation, step_um: f64| {
        let [up, down] = there_and_back_um(compensation, step_um, REACH_UM);
        Rest { step_um, up, down }
    };
    let data = Stability {
        scale: STEPS_UM.map(|step_um| trace(Compensation::Scale, step_um)),
        set_point: STEPS_UM.map(|step_um| trace(Compensation::SetPoint, step_um)),
        hysteresis: rest(Compensation::Scale, 2.0),
        ambiguity: rest(Compensation::SetPoint, -2.0),
        forbidden: rest(Compensation::SetPoint, 2.0),
    };
    let mut spool = Spool::new(Target::new(path)?)?;
    if let Err(error) = spool.writer().write_all(stability(&data).as_bytes()) {
        return Err(spool.fault(&error).into());
    }
    spool.publish(Old::Replaced)?;
    Ok(ExitCode::Done)
}
