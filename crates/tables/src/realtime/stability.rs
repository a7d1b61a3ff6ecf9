//! The reason for looking up the correction at the set-point: a position loop with one table, corrected in both ways (Spaan 1995, Figs. 6.4–6.8).
//!
//! The table has one step, at position 0. Under *scale compensation* the correction is looked up at the measured position. With a downward step no
//! position satisfies the loop for set-points just above the grid point: before it the axis must advance, after it return, which is a limit cycle.
//! With an upward step two positions satisfy the loop, depending on the direction of approach: a virtual hysteresis, with a jump between them. Under
//! *set-point compensation* the motion of the axis does not affect the correction. There remain only positions that belong to two set-points, or to
//! none.
//!
//! The loop, once per cycle of 15 ms: e = p + c − m with set-point p, correction c and measured position m (whole increments). Friction holds a
//! stationary axis while |e| is at most an increment; otherwise its velocity follows Kv e with the lag of the drive. The correction takes effect
//! [`DELAY`] cycles after its lookup. The drive of the Maho 700S is not published, so the amplitudes of limit cycles are those of this loop. Their
//! existence depends on increment and step alone.

use serde::Serialize;

/// A cycle of the control, s (Spaan 1995, ch. 6).
pub const CYCLE_S: f64 = 0.015;
/// An increment of the measuring system, µm (Spaan 1995, ch. 6).
pub const INCREMENT_UM: f64 = 1.0;
/// Cycles between the measurement and the resulting correction: one to compute it, one to apply it.
pub const DELAY: usize = 2;
/// Gain of the position loop times the cycle: 27 / s, 1.6 m/min per mm of lag.
const GAIN: f64 = 0.4;
/// Share of a velocity change that a drive executes per cycle.
const RESPONSE: f64 = 0.6;
/// Velocity below which friction can hold the axis, µm per cycle.
const STANDSTILL_UM: f64 = 0.3;

/// Position at which the correction is looked up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compensation {
    /// At the measured position (Fig. 6.4).
    Scale,
    /// At the uncompensated set-point (Fig. 6.6).
    SetPoint,
}

/// State of the axis in one cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moment {
    /// s.
    pub time_s: f64,
    /// The uncompensated set-point, µm from the grid point.
    pub set_point_um: f64,
    /// Measured position, µm.
    pub measured_um: f64,
    /// Actual position, µm.
    pub position_um: f64,
    /// Active correction, µm.
    pub correction_um: f64,
}

/// The correction of a table with a step at 0, µm.
fn table_um(position_um: f64, step_um: f64) -> f64 {
    if position_um >= 0.0 { step_um } else { 0.0 }
}

/// Simulates an axis along set-points, one per cycle, µm from the grid point; it begins at the first one, at rest.
#[must_use]
pub fn run(compensation: Compensation, step_um: f64, set_points_um: &[f64]) -> Vec<Moment> {
    let Some(&first) = set_points_um.first() else { return Vec::new() };
    let (mut position_um, mut velocity_um) = (first + table_um(first, step_um), 0.0_f64);
    let mut on_their_way = [table_um(first, step_um); DELAY];
    let cycle = |(index, &set_point_um): (usize, &f64)| {
        let measured_um = (position_um / INCREMENT_UM).round() * INCREMENT_UM;
        let looked_up_at = match compensation {
            Compensation::Scale => measured_um,
            Compensation::SetPoint => set_point_um,
        };
        let correction_um = on_their_way[0];
        on_their_way.rotate_left(1);
        on_their_way[DELAY - 1] = table_um(looked_up_at, step_um);
        let moment = Moment { time_s: index as f64 * CYCLE_S, set_point_um, measured_um, position_um, correction_um };
        let error_um = set_point_um + correction_um - measured_um;
        if error_um.abs() <= INCREMENT_UM && velocity_um.abs() < STANDSTILL_UM {
            velocity_um = 0.0;
        } else {
            velocity_um += RESPONSE * (GAIN * error_um - velocity_um);
            position_um += velocity_um;
        }
        moment
    };
    set_points_um.iter().enumerate().map(cycle).collect()
}

/// Set-points that approach a position from 20 µm below, 0.5 µm per cycle, and stay there for 300 cycles.
#[must_use]
pub fn approach_um(place_um: f64) -> Vec<f64> {
    let way = (0..40).map(|index| place_um - 20.0 + 0.5 * f64::from(index));
    way.chain(std::iter::repeat_n(place_um, 300)).collect()
}

/// Peak-to-peak oscillation of the measured position in the last 150 cycles, µm.
#[must_use]
pub fn unrest_um(moments: &[Moment]) -> f64 {
    let last = moments.iter().rev().take(150).map(|moment| moment.measured_um);
    let [low, high] = last.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], um| [low.min(um), high.max(um)]);
    if high >= low { high - low } else { 0.0 }
}

/// Rest positions of the axis at set-points from −`reach_um` to `reach_um`, every quarter of an increment: set-point and position, µm, upwards and
/// then downwards.
#[must_use]
pub fn there_and_back_um(compensation: Compensation, step_um: f64, reach_um: f64) -> [Vec<(f64, f64)>; 2] {
    /// Cycles at each set-point, enough to come to rest.
    const STAY: usize = 60;
    let count = (8.0 * reach_um / INCREMENT_UM).round() as usize;
    let place = |index: usize| 0.25 * INCREMENT_UM * index as f64 - reach_um;
    let upwards = 0..=count;
    let places: Vec<f64> = upwards.clone().chain(upwards.rev()).map(place).collect();
    let set_points: Vec<f64> = places.iter().flat_map(|&place| std::iter::repeat_n(place, STAY)).collect();
    let moments = run(compensation, step_um, &set_points);
    let at_rest: Vec<(f64, f64)> = moments
        .chunks(STAY)
        .filter_map(|stay| stay.last())
        .map(|moment| (moment.set_point_um, moment.position_um))
        .collect();
    let (up, down) = at_rest.split_at(at_rest.len() / 2);
    [up.to_vec(), down.to_vec()]
}

/// Steps of the table in the time plots, µm: the one with a limit cycle, and one of an increment, both as measured by Spaan.
const STEPS_UM: [f64; 2] = [-2.0, -1.0];
/// Target position of the axis, µm from the grid point, where the step of 2 µm has no rest position.
const PLACE_UM: f64 = 0.25;
/// Range around the grid point in the plots, µm.
const REACH_UM: f64 = 6.0;

/// An axis over time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AxisTrace {
    /// Step of the table at the grid point, µm.
    pub step_um: f64,
    /// Peak-to-peak oscillation at the end, µm.
    pub unrest_um: f64,
    /// Time, s, and measured position, µm from the grid point.
    pub points: Vec<(f64, f64)>,
}

/// Rest positions of an axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RestCurve {
    /// Step of the table at the grid point, µm.
    pub step_um: f64,
    /// Set-point and position, µm from the grid point, for rising set-points.
    pub up: Vec<(f64, f64)>,
    /// Set-point and position, µm from the grid point, for falling set-points.
    pub down: Vec<(f64, f64)>,
}

/// Scale compensation against set-point compensation, simulated.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct StabilityResult {
    /// Under scale compensation.
    pub scale: [AxisTrace; 2],
    /// Under set-point compensation.
    pub set_point: [AxisTrace; 2],
    /// Scale compensation, an upward step.
    pub hysteresis: RestCurve,
    /// Set-point compensation, a downward step.
    pub ambiguity: RestCurve,
    /// Set-point compensation, an upward step.
    pub forbidden: RestCurve,
}

impl StabilityResult {
    /// Simulates both.
    #[must_use]
    pub fn simulated() -> StabilityResult {
        let trace = |compensation: Compensation, step_um: f64| {
            let moments = run(compensation, step_um, &approach_um(PLACE_UM));
            let points = moments.iter().map(|moment| (moment.time_s, moment.measured_um)).collect();
            AxisTrace { step_um, unrest_um: unrest_um(&moments), points }
        };
        let rest = |compensation: Compensation, step_um: f64| {
            let [up, down] = there_and_back_um(compensation, step_um, REACH_UM);
            RestCurve { step_um, up, down }
        };
        StabilityResult {
            scale: STEPS_UM.map(|step_um| trace(Compensation::Scale, step_um)),
            set_point: STEPS_UM.map(|step_um| trace(Compensation::SetPoint, step_um)),
            hysteresis: rest(Compensation::Scale, 2.0),
            ambiguity: rest(Compensation::SetPoint, -2.0),
            forbidden: rest(Compensation::SetPoint, 2.0),
        }
    }
}
