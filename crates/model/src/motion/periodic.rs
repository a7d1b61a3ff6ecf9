//! Sine of the axis command, fixed in position: e(q) = a sin(2π q/p + φ).
//!
//! Pitch errors of ball screws and gears, interpolation errors of scales and eccentric rotary encoders repeat with the pitch
//! (ISO 230-2, ISO 230-3).

use std::f64::consts::TAU;

use super::{Entry, EntryFunction};
use ncfix_base::diagnostic::Code;

/// Shortest period, mm or rad: a tenth of the shortest pitch of a scale. The blocks of a program could not follow a shorter one.
const SHORTEST: f64 = 1e-3;

/// Sine function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Periodic {
    /// p, mm or rad.
    pub period: f64,
    /// a, mm or rad.
    pub amplitude: f64,
    /// φ, rad.
    pub phase_rad: f64,
}

impl Periodic {
    /// Returns the value at a command, mm or rad.
    #[must_use]
    pub fn value(&self, command: f64) -> f64 {
        self.amplitude * (TAU * (command / self.period) + self.phase_rad).sin()
    }
}

/// Example entry.
pub(super) const EXAMPLE: &str = "component = \"EXX\"\nkind = \"periodic\"\n\
    period_mm = 10.0\namplitude_um = 1.5\nphase_deg = 30.0\n";

/// Reads `period_mm` or `period_deg`, `amplitude_um` or `amplitude_urad`, and the optional `phase_deg`.
pub(super) fn read(entry: &mut Entry<'_>) -> Option<EntryFunction> {
    let period = entry.length("period");
    if period.is_some_and(|period| period < SHORTEST) {
        let key = entry.position_key("period");
        let place = entry.section.place_of(&key);
        let help = "leave it out, or give the period of the screw, the gear or the scale";
        entry.section.report(Code::BAD_VALUE, place, format!("{key} is too short for a correction to follow it"), help);
        return None;
    }
    let amplitude = entry.deviation("amplitude");
    let phase_rad = entry.section.number("phase_deg").map_or(0.0, f64::to_radians);
    Some(EntryFunction::Periodic(Periodic { period: period?, amplitude: amplitude?, phase_rad }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_repeats_with_its_period() {
        let periodic = Periodic { period: 10.0, amplitude: 1.5e-3, phase_rad: 0.0 };
        assert_eq!(periodic.value(0.0), 0.0);
        assert!((periodic.value(2.5) - 1.5e-3).abs() < 1e-18);
        assert!((periodic.value(127.5) + 1.5e-3).abs() < 1e-15);
        let shifted = Periodic { phase_rad: TAU / 12.0, ..periodic };
        assert!((shifted.value(10.0) - 0.75e-3).abs() < 1e-15, "sin 30° is one half");
    }
}
