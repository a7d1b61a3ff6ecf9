//! Servo behavior of the control and the position loops at feed: `[servo]`.
//!
//! The control plans set-points in cycles and smooths them. The loop of every axis follows them with its velocity gain and its velocity feed-forward.
//! `ncfix_path::servo` simulates this.

use super::AxisData;
use super::file::Section;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, AxisSet, AxisVector};
use ncfix_base::units::{mm_from_um, rad_from_urad};

/// Treatment of set-points by the control, and response of the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Servo {
    /// Interpolation cycle, s.
    pub cycle_s: f64,
    /// Length of the smoothing kernel for set-points, s.
    pub smoothing_s: f64,
    /// Maximum distance by which the set-points of a linear axis may round off a corner, mm.
    pub corner_tolerance_mm: f64,
    /// Maximum angle by which the set-points of a rotary axis may round off a corner, rad.
    pub corner_tolerance_rad: f64,
    /// Maximum distance of a linear axis from its end point at the end of an exact stop, mm.
    pub exact_stop_mm: f64,
    /// Position loops by slot; `None` if the machine lacks the axis.
    pub axes: [Option<AxisServo>; AXIS_COUNT],
}

/// Position loop of one axis: x′ = K (s − x) + f s′, after a dead time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisServo {
    /// Velocity gain K, 1/s.
    pub velocity_gain_per_s: f64,
    /// Share of velocity feed-forward, f: 0 … 1.
    pub feed_forward: f64,
    /// Dead time, s.
    pub delay_s: f64,
    /// Maximum acceleration, mm/s² or rad/s².
    pub max_acceleration: f64,
    /// Maximum speed, mm/s or rad/s.
    pub max_speed: f64,
}

/// 1 m/min per mm as 1/s.
const PER_S_OF_M_MIN_MM: f64 = 1000.0 / 60.0;
/// m/s² as mm/s².
const MM_PER_M: f64 = 1e3;
/// Lever arm that converts the corner tolerance of linear axes to that of rotary axes without their own value, mm.
const ARM_MM: f64 = 100.0;
/// Maximum length of the smoothing kernel in cycles.
const MOST_CYCLES: f64 = 1000.0;
/// Default of the exact-stop limit: that of controls as delivered (Sinumerik MD36010), µm.
const EXACT_STOP_UM: f64 = 10.0;
/// Maximum dead time, ms.
const MOST_DELAY_MS: f64 = 200.0;

impl Servo {
    /// Returns the maximum distance of each axis from its end point at the end of an exact stop, mm and rad.
    #[must_use]
    pub fn exact_stop(&self) -> AxisVector {
        AxisVector(AXES.map(|axis| if axis.is_rotary() { self.exact_stop_mm / ARM_MM } else { self.exact_stop_mm }))
    }
}

impl AxisServo {
    /// Returns the time lag of the axis at constant speed: (1 − f)/K plus the dead time, s.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        (1.0 - self.feed_forward) / self.velocity_gain_per_s + self.delay_s
    }
}

/// Reads `[servo]`. `axes` are those of the machine that could be read.
pub(super) fn read(
    mut section: Section<'_>,
    axes: &[Option<AxisData>; AXIS_COUNT],
    named: AxisSet,
    findings: &mut Vec<Diagnostic>,
) -> Option<Servo> {
    let cycle_ms = section.required("cycle_ms", "3.0", |section, key| {
        section.number_where(key, "a time from 0.01 to 100 ms", |ms| (0.01..=100.0).contains(&ms))
    });
    let most_ms = cycle_ms.map_or(f64::INFINITY, |cycle_ms| cycle_ms * MOST_CYCLES);
    let smoothing_ms =
        section.number_where("smoothing_ms", "0 or a time of at most 1000 cycles", |ms| (0.0..=most_ms).contains(&ms));
    let corner_um = section.required("corner_tolerance_um", "10.0", |section, key| {
        section.number_where(key, "a number above 0", |um| um > 0.0)
    });
    let corner_urad = section.number_where("corner_tolerance_urad", "a number above 0", |urad| urad > 0.0);
    let exact_um = section.number_where("exact_stop_um", "a number above 0", |um| um > 0.0);
    let mut loops = [None; AXIS_COUNT];
    let mut missing: Vec<Axis> = Vec::new();
    for axis in AXES {
        let key = axis.to_string();
        let is_named = named.contains(axis);
        if let Some(own) = section.section(&key) {
            let place = section.place_of(&key);
            loops[axis.slot()] = read_axis(axis, own, axes[axis.slot()].as_ref(), findings);
            if !is_named {
                let message = format!("[servo.{axis}] names an axis that the machine does not have");
                section.report(Code::BAD_VALUE, place, message, "remove the section");
            }
        } else if is_named && !section.has(&key) {
            missing.push(axis);
        }
    }
    report_missing(&mut section, &missing);
    section.finish(findings);
    let corner_tolerance_mm = mm_from_um(corner_um?);
    Some(Servo {
        cycle_s: cycle_ms? * 1e-3,
        smoothing_s: smoothing_ms.unwrap_or(0.0) * 1e-3,
        corner_tolerance_mm,
        corner_tolerance_rad: corner_urad.map_or(corner_tolerance_mm / ARM_MM, rad_from_urad),
        exact_stop_mm: mm_from_um(exact_um.unwrap_or(EXACT_STOP_UM)),
        axes: loops,
    })
}

/// Reports all axes without a loop in one diagnostic.
fn report_missing(section: &mut Section<'_>, axes: &[Axis]) {
    let Some(&first) = axes.first() else { return };
    let names: Vec<String> = axes.iter().map(Axis::to_string).collect();
    let message = format!("[servo] has no data for {}", names.join(", "));
    let help = format!(
        "add [servo.{first}] and so on, with velocity_gain_per_s, feed_forward and {}",
        acceleration_key(first)
    );
    section.report(Code::MISSING_KEY, section.place(), message, help);
}

fn acceleration_key(axis: Axis) -> &'static str {
    if axis.is_rotary() { "max_acceleration_rad_s2" } else { "max_acceleration_m_s2" }
}

fn read_axis(
    axis: Axis,
    mut section: Section<'_>,
    data: Option<&AxisData>,
    findings: &mut Vec<Diagnostic>,
) -> Option<AxisServo> {
    let gain = read_gain(&mut section);
    let feed_forward = section.required("feed_forward", "0.98", |section, key| {
        section.number_where(key, "a share from 0 to 1", |share| (0.0..=1.0).contains(&share))
    });
    let delay_ms =
        section.number_where("delay_ms", "a time from 0 to 200 ms", |ms| (0.0..=MOST_DELAY_MS).contains(&ms));
    let key = acceleration_key(axis);
    let acceleration = section.required(key, "5.0", |section, key| {
        section.number_where(key, "a number from 0.001 on", |value| value >= 0.001)
    });
    let factor = if axis.is_rotary() { 1.0 } else { MM_PER_M };
    let max_speed = data.and_then(|data| match data.max_feed {
        Some(per_min) if axis.is_rotary() => Some(per_min.to_radians() / 60.0),
        Some(per_min) => Some(per_min / 60.0),
        None => {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            let message = format!("axis {axis} has a servo loop but no max_feed_{unit}_min");
            let help = format!("write max_feed_{unit}_min in [axis.{axis}]: it is the rate of rapid moves");
            section.report(Code::MISSING_KEY, section.place(), message, help);
            None
        }
    });
    section.finish(findings);
    Some(AxisServo {
        velocity_gain_per_s: gain?,
        feed_forward: feed_forward?,
        delay_s: delay_ms.unwrap_or(0.0) * 1e-3,
        max_acceleration: acceleration? * factor,
        max_speed: max_speed?,
    })
}

/// Reads the velocity gain in either unit, 1/s.
fn read_gain(section: &mut Section<'_>) -> Option<f64> {
    const BY_S: &str = "velocity_gain_per_s";
    const BY_MIN: &str = "velocity_gain_m_min_mm";
    let (expected, allowed) = ("a number from 0.01 to 100000", |gain: f64| (0.01..=1e5).contains(&gain));
    if !section.has(BY_MIN) {
        section.accept(BY_MIN);
        return section.required(BY_S, "50.0", |section, key| section.number_where(key, expected, allowed));
    }
    if section.has(BY_S) {
        section.accept(BY_S);
        let place: Place = section.place_of_key(BY_MIN);
        let message = format!("the velocity gain of {} is given twice", section.title());
        section.report(Code::BAD_VALUE, place, message, "remove one; 1 m/min per mm is 16.667 1/s");
    }
    section.number_where(BY_MIN, expected, allowed).map(|gain| gain * PER_S_OF_M_MIN_MM)
}
