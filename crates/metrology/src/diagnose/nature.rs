//! Natures of causes: the quantity on which an effect depends. Causes of different natures need different corrections, even if they predict the same readings.

use super::cause::{Candidate, EffectKind};

/// The quantity on which an effect depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Nature {
    /// The positions of the axes.
    Place,
    /// The direction of the last motion.
    Sense,
    /// Velocity and acceleration.
    Speed,
    /// Time and temperature.
    Time,
    /// The weight on the table.
    Load,
    /// The instrument and its set-up: nothing of the machine.
    Instrument,
    /// The quantity of a cause from a caller.
    Own(&'static str),
}

impl Nature {
    /// The nature of a cause; `None` for faults of data, and states of earlier files.
    pub(super) fn of(one: &Candidate) -> Option<Nature> {
        if one.cause.effect == EffectKind::Unknown {
            return Some(of_drivers(&one.drivers));
        }
        Nature::of_effect(one.cause.effect)
    }

    /// The nature of an effect with a name.
    pub(super) fn of_effect(effect: EffectKind) -> Option<Nature> {
        match effect {
            EffectKind::Location | EffectKind::Motion | EffectKind::Periodic | EffectKind::Cross => Some(Nature::Place),
            EffectKind::Backlash | EffectKind::LateralPlay | EffectKind::ReversalSpike => Some(Nature::Sense),
            EffectKind::ServoMismatch | EffectKind::Following | EffectKind::Delay | EffectKind::Dynamic => {
                Some(Nature::Speed)
            }
            EffectKind::ThermalDrift
            | EffectKind::ThermalExpansion
            | EffectKind::ThermalSquareness
            | EffectKind::Drift
            | EffectKind::SpindleSpeed => Some(Nature::Time),
            EffectKind::Load => Some(Nature::Load),
            EffectKind::Setup | EffectKind::Probe => Some(Nature::Instrument),
            EffectKind::Own(name) => Some(Nature::Own(name)),
            EffectKind::Unknown
            | EffectKind::Earlier
            | EffectKind::Sensor
            | EffectKind::Outlier
            | EffectKind::Program => None,
        }
    }
}

/// The nature of an effect without a name: that of the driver which varies least from one machine to the next.
fn of_drivers(drivers: &[String]) -> Nature {
    let has = |is: fn(&str) -> bool| drivers.iter().any(|driver| is(driver));
    if has(|driver| OF_TIME.contains(&driver) || driver.starts_with("T_") || driver.ends_with("_rpm")) {
        Nature::Time
    } else if has(|driver| driver.starts_with("feed_") || driver.ends_with("_acc")) {
        Nature::Speed
    } else if has(|driver| driver.ends_with("_dir")) {
        Nature::Sense
    } else {
        Nature::Place
    }
}

/// Driver of a displacement that depends on the order of the rows, if they have no time.
pub(in crate::diagnose) const ORDER: &str = "row";
/// Drivers of time.
const OF_TIME: [&str; 2] = ["t_s", ORDER];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::bench;
    use crate::diagnose::scene::Through;

    #[test]
    fn an_effect_without_a_name_has_the_nature_of_its_drivers() {
        let of = |drivers: &[&str]| {
            let mut one = bench::candidate(EffectKind::Unknown, Through::Tip(0), |_| 1.0);
            one.drivers = drivers.iter().map(|&name| name.to_owned()).collect();
            Nature::of(&one)
        };
        assert_eq!(of(&["X", "T_head_C"]), Some(Nature::Time));
        assert_eq!(of(&["X", "feed_mm_min"]), Some(Nature::Speed));
        assert_eq!(of(&["X", "X_dir"]), Some(Nature::Sense));
        assert_eq!(of(&["X", "Y"]), Some(Nature::Place));
    }
}
