//! Measuring time of a plan (Spaan 1995, ch. 3): moves at the programmed feed, rapid moves at the largest feed of the axes, and dwells. Ramps and the
//! time of a person at a stop are not included.

use super::builder::Builder;
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Dwell, Kind, Move, WordValue};

/// Number of chords by which an arc is measured.
const ARC_CHORDS: u32 = 180;

/// The time of a plan.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanTime {
    /// Moves and dwells, s.
    pub seconds: f64,
    /// Number of stops for a person.
    pub stops: usize,
    /// `true` if rapid moves are not included, because the machine file has no largest feed of an axis.
    pub is_without_rapids: bool,
}

/// The time of the program of a plan.
#[must_use]
pub fn duration(plan: &Builder) -> PlanTime {
    let mut time = PlanTime::default();
    let mut here: Option<AxisVector> = None;
    for kind in &plan.path {
        match kind {
            Kind::Move(motion) => {
                if let Some(from) = here {
                    match seconds(&plan.machine, &from, motion) {
                        Some(seconds) => time.seconds += seconds,
                        None => time.is_without_rapids = true,
                    }
                }
                here = Some(motion.target);
            }
            Kind::Dwell(Dwell::Seconds(seconds)) => time.seconds += seconds,
            Kind::Before(words) => {
                let is_stop = words.iter().any(|word| word.letter == b'M' && word.value == WordValue::Number(0.0));
                time.stops += usize::from(is_stop);
            }
            _ => {}
        }
    }
    time
}

/// Time of a move; `None` for a rapid move of an axis without a largest feed.
fn seconds(machine: &Machine, from: &AxisVector, motion: &Move) -> Option<f64> {
    const PER_MINUTE: f64 = 60.0;
    let shown = |axis: ncfix_base::geometry::Axis, distance: f64| {
        if axis.is_rotary() { distance.to_degrees() } else { distance }
    };
    if motion.rapid {
        let mut longest = 0.0_f64;
        for axis in AXES {
            let distance = shown(axis, (motion.target[axis] - from[axis]).abs());
            if distance > 0.0 {
                longest = longest.max(distance / machine.axis(axis)?.max_feed?);
            }
        }
        return Some(longest * PER_MINUTE);
    }
    if motion.feed <= 0.0 {
        return Some(0.0);
    }
    let length_mm = match motion.arc {
        Some(arc) => {
            let at = |part: u32| arc.at(from, &motion.target, f64::from(part) / f64::from(ARC_CHORDS)).xyz();
            (0..ARC_CHORDS).map(|part| (at(part + 1) - at(part)).norm()).sum()
        }
        None => (motion.target.xyz() - from.xyz()).norm(),
    };
    let turned = AXES.into_iter().filter(|axis| axis.is_rotary());
    let turned = turned.map(|axis| shown(axis, (motion.target[axis] - from[axis]).abs())).fold(0.0, f64::max);
    // The feed of a block is that of its linear axes; without any it is in degrees.
    Some(if length_mm > 0.0 { length_mm } else { turned } / motion.feed * PER_MINUTE)
}
