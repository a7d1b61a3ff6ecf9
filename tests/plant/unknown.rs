//! Effects that no catalogue has: a diagnosis can only say on what they depend and show their shape.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::catalogue;
use super::effect::{Effect, Law, Place, Stage};
use super::random::Random;

/// Kinds of effects outside the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unknown {
    /// Depends on Y only beyond 400 mm in X.
    Beyond,
    /// A bump over two coordinates.
    Bump,
    /// Grows with time and position.
    PositionAndTime,
    /// Nothing near the middle, further out a reversal value.
    DeadZone,
    /// Only above a speed of the spindle.
    Speed,
    /// The product of two temperatures.
    TwoTemperatures,
    /// A wave of the position at high feeds only.
    FastWave,
    /// A wave of C where A is tilted far.
    TiltedWave,
    /// Weight and time.
    LoadAndTime,
}

/// All kinds.
pub(crate) const UNKNOWNS: [Unknown; 9] = [
    Unknown::Beyond,
    Unknown::Bump,
    Unknown::PositionAndTime,
    Unknown::DeadZone,
    Unknown::Speed,
    Unknown::TwoTemperatures,
    Unknown::FastWave,
    Unknown::TiltedWave,
    Unknown::LoadAndTime,
];

/// The effect, not scaled yet; `None` where the bench does not show it.
pub(crate) fn effect(kind: Unknown, stage: &Stage<'_>, random: &mut Random) -> Option<Effect> {
    let bench = stage.bench;
    let new = |drivers: &[&str], unit| Effect::new(0, "unknown", "", drivers, Law::Linear(1e3), unit);
    let tip = random.below(3);
    Some(match kind {
        Unknown::Beyond if bench == Bench::Plate => new(&["X", "Y"], "um at 200 mm beyond")
            .acts(Place::Tip(2), |row| if row.q[0] > 400.0 { (row.q[1] - 250.0) / 200.0 } else { 0.0 }),
        Unknown::Bump if matches!(bench, Bench::Plate | Bench::Ballbar) => {
            let (x, y) = (random.between(270.0, 430.0), random.between(180.0, 320.0));
            let wide = random.between(40.0, 70.0);
            let tip = if bench == Bench::Plate { tip } else { random.below(2) };
            new(&["X", "Y"], "um").acts(Place::Tip(tip), move |row| {
                let [u, v, _] = row.point();
                (-((u - x).powi(2) + (v - y).powi(2)) / (2.0 * wide * wide)).exp()
            })
        }
        Unknown::PositionAndTime if matches!(bench, Bench::Plate | Bench::Laser) => {
            let last = stage.sheets[0].rows.last()?.t;
            new(&["X", "t_s"], "um at the end of day and axis")
                .acts(Place::Tip(0), move |row| (row.q[0] - 350.0) / 350.0 * row.t / last)
        }
        Unknown::DeadZone if matches!(bench, Bench::Plate | Bench::Laser) => {
            let zone = random.between(50.0, 90.0);
            new(&["Y", "Y_dir"], "um per 100 mm")
                .acts(Place::Tip(1), move |row| row.dir[1] * ((row.q[1] - 250.0).abs() - zone).max(0.0) / 100.0)
        }
        Unknown::Speed if bench == Bench::Drift => {
            let from = random.between(2500.0, 4000.0);
            new(&["spindle_rpm"], "um").acts(Place::Tip(tip), move |row| if row.rpm > from { 1.0 } else { 0.0 })
        }
        Unknown::TwoTemperatures if bench == Bench::Drift => {
            let one = catalogue::follower(stage, "T_spindle", 0.0)?;
            let other = catalogue::follower(stage, "T_bed", 0.0)?;
            new(&["T_spindle_C", "T_bed_C"], "um/K2").acts(Place::Tip(tip), move |row| one(row) * other(row))
        }
        Unknown::TwoTemperatures if bench == Bench::HotCold => {
            let front = catalogue::follower(stage, "T_front", 0.0)?;
            let back = catalogue::follower(stage, "T_back", 0.0)?;
            new(&["T_front_C", "T_back_C", "X", "Y"], "um/K at the corner").acts(Place::Tip(2), move |row| {
                let [x, y, _] = row.point();
                (front(row) - back(row)) * (x - 350.0) * (y - 250.0) / (150.0 * 150.0)
            })
        }
        Unknown::FastWave if matches!(bench, Bench::Ballbar | Bench::OnTheFly) => {
            let (axis, long, phase) = (random.below(2), random.between(90.0, 160.0), random.between(0.0, TAU));
            new(&[["X", "Y"][axis], "feed_mm_min"], "um").acts(Place::Tip(axis), move |row| {
                if row.feed > 2000.0 { (TAU * row.q[axis] / long + phase).sin() } else { 0.0 }
            })
        }
        Unknown::TiltedWave if bench == Bench::FiveAxis => {
            let phase = random.between(0.0, TAU);
            new(&["A", "C"], "um")
                .acts(Place::Tip(tip), move |row| if row.q[3] > 0.4 { (2.0 * row.q[4] + phase).sin() } else { 0.0 })
        }
        Unknown::LoadAndTime if bench == Bench::Load => {
            let last = stage.sheets[0].rows.last()?.t;
            let drivers = ["load_N", "t_s", "X"];
            Effect::new(0, "unknown", "", &drivers, Law::Linear(1e6), "urad").acts(Place::Motion(4, 0), move |row| {
                row.load / 4800.0 * row.t / last * ((row.q[0] - 350.0) / 350.0).powi(2)
            })
        }
        _ => return None,
    })
}
