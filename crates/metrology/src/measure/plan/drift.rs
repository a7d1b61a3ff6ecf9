//! Thermal drift: the spindle runs through a speed spectrum while the tool holder is measured every minute.
//!
//! `din`: levels in steps of 25 % of the highest speed, 15 min each, with 30 min at 25 % from 135 min on, as Spaan 1995 (ch. 5) quotes DIN 8602; the
//! order of the other levels is our choice. `pseudo-din`: his variant for test workpieces, with 15 min there too, so that the twelfth level is the
//! highest speed. `random`: speeds between 800 1/min and the highest, or standstill, for 5 to 45 min each, over a day (Spaan 1995, ch. 5), determined
//! by a seed. `steady`: a constant speed for a day, then standstill for as long (Spaan 1995, Fig. 5.5).

use super::builder::{Builder, Extra};
use super::random::Random;
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, empty, kind};
use crate::measure::data::{Free, Setup};
use ncfix_machine::machine::Machine;

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "drift",
    title: "spindle speeds and readings every minute: variants din (DIN 8602), pseudo-din, random, steady (Spaan 1995)",
    wishes: &["variant", "hours", "speed", "seed", "center", "feed"],
    spacing: RowSpacing::Angle,
    has_setups: false,
    build,
};

/// Time between readings, s.
const EVERY_S: u32 = 60;
/// Percent of the highest speed, 15 min each.
const DIN: [u8; 16] = [25, 50, 75, 100, 75, 50, 25, 0, 100, 25, 25, 50, 100, 75, 50, 0];
/// As [`DIN`] with 25 % for only 15 min from 135 min on, so that the twelfth level is the highest speed.
const PSEUDO_DIN: [u8; 15] = [25, 50, 75, 100, 75, 50, 25, 0, 100, 25, 50, 100, 75, 50, 0];
/// Duration of a level, s.
const LEVEL_S: u32 = 900;
/// Highest speed of the spectra, and the speed of the constant one, 1/min (Spaan 1995, ch. 5).
const MOST_SPEED: f64 = 6300.0;
const STEADY_SPEED: f64 = 6000.0;
/// Duration of the random spectrum, and of the running part of the constant one, h.
const DAY_H: f64 = 24.0;
/// Lowest speed of the random spectrum, 1/min.
const LEAST_SPEED: f64 = 800.0;
/// Range of durations of the random spectrum, min.
const TIMES_MIN: [f64; 2] = [5.0, 45.0];
/// Probability of a spindle stop.
const STOPS: f64 = 0.2;

/// Levels of a spectrum, percent of the highest speed: once, or again and again for as long as is asked for.
fn levels(percents: &[u8], wishes: &Wishes, most: f64) -> Vec<(f64, u32)> {
    let mut left_s = wishes.hours.map_or(u32::MAX, end_s);
    let mut out = Vec::new();
    let once = wishes.hours.is_none();
    let count = if once { percents.len() } else { usize::MAX };
    for percent in percents.iter().cycle().take(count) {
        if left_s == 0 {
            break;
        }
        let time_s = LEVEL_S.min(left_s);
        left_s -= time_s;
        out.push((most * f64::from(*percent) / 100.0, time_s));
    }
    out
}

fn end_s(hours: f64) -> u32 {
    (hours.clamp(0.1, 1000.0) * 3600.0).round() as u32
}

/// Speeds and durations, in whole readings.
fn spectrum(wishes: &Wishes) -> Result<Vec<(f64, u32)>, PlanRefused> {
    let most = wishes.speed.unwrap_or(MOST_SPEED);
    match wishes.variant.as_deref() {
        None | Some("din") => Ok(levels(&DIN, wishes, most)),
        Some("pseudo-din") => Ok(levels(&PSEUDO_DIN, wishes, most)),
        Some("random") => {
            if most < LEAST_SPEED {
                return Err(PlanRefused(format!(
                    "the random spectrum begins at {LEAST_SPEED} 1/min; give a higher --speed"
                )));
            }
            let mut random = Random(wishes.seed);
            let mut left_s = end_s(wishes.hours.unwrap_or(DAY_H));
            let mut out = Vec::new();
            while left_s > 0 {
                let stands = random.share() < STOPS;
                let speed = random.between(LEAST_SPEED, most).round();
                let minutes = random.between(TIMES_MIN[0], TIMES_MIN[1]).round() as u32;
                let time_s = (minutes * 60).min(left_s);
                left_s -= time_s;
                out.push((if stands { 0.0 } else { speed }, time_s));
            }
            Ok(out)
        }
        Some("steady") => {
            let time_s = end_s(wishes.hours.unwrap_or(DAY_H));
            Ok(vec![(wishes.speed.unwrap_or(STEADY_SPEED), time_s), (0.0, time_s)])
        }
        Some(other) => {
            Err(PlanRefused(format!("unknown spectrum '{other}'; the variants are din, pseudo-din, random, steady")))
        }
    }
}

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let tool_mm = wishes.tool_mm();
    let mut data = empty(kind("displacement")?, &[Free::Offset]);
    data.setups.push(Setup { label: "A".into(), ..Setup::default() });
    let mut plan = Builder::new(machine, wishes, data);
    plan.is_geometric = false;
    let centre_mm = wishes.centre_or_middle(machine, &tool_mm);
    let pose = plan.at_tip(&centre_mm, &tool_mm);
    plan.stop("clear the path: the axes move to the sensors");
    plan.approach(&pose, wishes.feed.unwrap_or(1000.0))?;
    let pose = plan.last().unwrap_or(pose);
    plan.stop("zero the sensors");
    let mut time_s = 0;
    let row = |plan: &mut Builder, time_s: u32, speed: f64| {
        let extra = Extra { time_s: Some(f64::from(time_s)), speed: Some(speed), ..Extra::default() };
        plan.row(&pose, tool_mm, 0, extra)
    };
    row(&mut plan, 0, 0.0)?;
    let mut running = 0.0;
    for (speed, stage_s) in spectrum(wishes)? {
        if (speed - running).abs() > 0.0 {
            plan.words(&if speed > 0.0 { vec![(b'S', speed), (b'M', 3.0)] } else { vec![(b'M', 5.0)] });
            running = speed;
        }
        let mut left_s = stage_s;
        while left_s > 0 {
            let step_s = EVERY_S.min(left_s);
            plan.dwell(f64::from(step_s));
            left_s -= step_s;
            time_s += step_s;
            row(&mut plan, time_s, speed)?;
        }
    }
    if running > 0.0 {
        plan.words(&[(b'M', 5.0)]);
    }
    Ok(plan)
}
