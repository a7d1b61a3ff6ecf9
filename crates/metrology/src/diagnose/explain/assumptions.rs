//! Assumptions before any measurement: usual sizes of errors of machine tools, and how often a machine has one.
//!
//! A size is the standard deviation of a normal prior; odds compare one term with its absence. Neither is a limit: data override both. Sizes
//! determine the amounts of two errors with equal effects; odds determine which of two equally good explanations is simpler.

/// A family of terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Family {
    /// Squareness of two linear axes.
    Squareness,
    /// Offset of a rotary axis or of the spindle.
    Offset,
    /// Tilt of a rotary axis or of the spindle.
    Tilt,
    /// Positioning error that grows with the position.
    Scale,
    /// Positioning error of a higher order.
    Positioning,
    /// Straightness.
    Straightness,
    /// Roll, pitch and yaw.
    Angle,
    /// Backlash along the axis.
    Backlash,
    /// Lag of an axis relative to the others.
    Lag,
    /// Lateral play of an axis.
    LateralPlay,
    /// Play that rotates the carriage.
    AngularPlay,
    /// Displacement of one axis that depends on another one too.
    Cross,
    /// Rotation of one axis that depends on another one too.
    CrossAngle,
    /// Displacement of one axis that depends on another one, but only beyond a position.
    Threshold,
    /// Motion error of a rotary axis with one or two periods per revolution.
    Rotary,
    /// Periodic error along an axis.
    Wave,
    /// Peak after a reversal.
    Spike,
    /// Displacement with a temperature.
    Drift,
    /// Thermal expansion of a scale.
    Expansion,
    /// Squareness that changes with a temperature.
    ThermalSquareness,
    /// Displacement with time without a known temperature.
    Creep,
    /// Deflection by acceleration.
    Deflection,
    /// Vibration, stick-slip, steps between octants.
    Dynamic,
    /// Weight of the workpiece.
    Load,
    /// The set-up of the instrument.
    Setup,
    /// Readings of a file with the wrong sign.
    Sign,
    /// An error that differs in earlier files.
    Earlier,
    /// The probe, including its length.
    Probe,
    /// A cause added by a caller.
    Own,
    /// An unnamed term.
    Unnamed,
}

/// The assumption for a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assumption {
    /// The family.
    pub family: Family,
    /// Standard deviation of the amount of a term: mm or rad; for an error that depends on the position, at the ends of the travel.
    pub size: Size,
    /// Odds of each term of the family against its absence.
    pub odds: f64,
    /// Its origin.
    pub source: &'static str,
}

/// The unit of a size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Size {
    /// µm.
    Um(f64),
    /// µrad.
    Urad(f64),
    /// µm per meter of travel.
    UmPerM(f64),
    /// Milliseconds of lag.
    Ms(f64),
    /// µm per m/s².
    UmPerMs2(f64),
}

/// The table. Sizes are based on the acceptance limits of ISO 10791-1 and ISO 10791-2 (squareness 20 µm in 500 mm, straightness 10 µm in 500 mm,
/// angles up to 40 to 60 µrad) and of ISO 10791-4 (positioning) for machining centers, and on the machines measured by Spaan (1995) and Esmaeili
/// (2021), from new to worn.
pub const ASSUMPTIONS: &[Assumption] = &[
    Assumption {
        family: Family::Squareness,
        size: Size::Urad(50.0),
        odds: 1.0,
        source: "ISO 10791-2: 20 µm in 500 mm; detectable on about half of all machines",
    },
    Assumption {
        family: Family::Scale,
        size: Size::UmPerM(50.0),
        odds: 1.0,
        source: "expansion of a screw by 4 K at 11.5 µm/(m K), a usual change of temperature in a day",
    },
    Assumption {
        family: Family::Backlash,
        size: Size::Um(10.0),
        odds: 0.2,
        source: "ISO 10791-4: reversal value of 6 to 10 µm",
    },
    Assumption {
        family: Family::Offset,
        size: Size::Um(100.0),
        odds: 0.3,
        source: "rotary axes that were aligned by hand with the machine zero",
    },
    Assumption {
        family: Family::Tilt,
        size: Size::Urad(100.0),
        odds: 0.2,
        source: "ISO 10791-1: 20 µm in 300 mm and worn machines",
    },
    Assumption {
        family: Family::Positioning,
        size: Size::Um(8.0),
        odds: 0.1,
        source: "ISO 10791-4: 10 to 22 µm over 1 m, in all orders",
    },
    Assumption {
        family: Family::Straightness, size: Size::Um(8.0), odds: 0.1, source: "ISO 10791-2: 10 µm in 500 mm"
    },
    Assumption {
        family: Family::Angle,
        size: Size::Urad(15.0),
        odds: 0.05,
        source: "ISO 10791-2: 40 to 60 µrad from end to end",
    },
    Assumption {
        family: Family::Rotary,
        size: Size::Um(8.0),
        odds: 0.05,
        source: "ISO 230-7: radial and axial error motions of tables",
    },
    Assumption {
        family: Family::Lag,
        size: Size::Ms(0.5),
        odds: 0.1,
        source: "velocity gains of 1.7 m/min/mm (35 ms) that differ by 1 to 2 %",
    },
    Assumption {
        family: Family::LateralPlay,
        size: Size::Um(8.0),
        odds: 0.03,
        source: "a fraction of the backlash along the axis",
    },
    Assumption {
        family: Family::AngularPlay,
        size: Size::Urad(15.0),
        odds: 0.002,
        source: "size as for angles; a hundred times rarer than backlash along an axis",
    },
    Assumption {
        family: Family::Cross,
        size: Size::Um(8.0),
        odds: 0.004,
        source: "Spaan 1995, ch. 2: finite stiffness; rare",
    },
    Assumption {
        family: Family::CrossAngle,
        size: Size::Urad(15.0),
        odds: 0.004,
        source: "Spaan 1995, ch. 2: finite stiffness; rare",
    },
    Assumption {
        family: Family::Threshold,
        size: Size::Um(8.0),
        odds: 0.002,
        source: "joints of guideways, and covers that drag; rarer than a smooth dependence",
    },
    Assumption { family: Family::Wave, size: Size::Um(5.0), odds: 0.05, source: "scales and screws: 1 to 10 µm" },
    Assumption {
        family: Family::Spike,
        size: Size::Um(8.0),
        odds: 0.1,
        source: "ISO 230-4: ball-bar traces of most drives",
    },
    Assumption {
        family: Family::Drift,
        size: Size::Um(20.0),
        odds: 0.2,
        source: "ISO 10791-10: drift of spindle and head",
    },
    Assumption {
        family: Family::Expansion, size: Size::Um(20.0), odds: 0.1, source: "11.5 µm/(m K) over 1 m and 2 K"
    },
    Assumption {
        family: Family::ThermalSquareness,
        size: Size::Urad(20.0),
        odds: 0.03,
        source: "Esmaeili 2021; rarer than drift",
    },
    Assumption {
        family: Family::Creep,
        size: Size::Um(10.0),
        odds: 0.03,
        source: "set-ups that creep; warming that was not measured",
    },
    Assumption {
        family: Family::Deflection,
        size: Size::UmPerMs2(10.0),
        odds: 0.02,
        source: "compliance of a frame with a first natural frequency of 50 Hz: a/(2π f)²",
    },
    Assumption { family: Family::Dynamic, size: Size::Um(8.0), odds: 0.02, source: "rare at measuring feeds" },
    Assumption { family: Family::Load, size: Size::Um(15.0), odds: 0.1, source: "only if the table has weights" },
    Assumption {
        family: Family::Setup,
        size: Size::Um(20.0),
        odds: 0.01,
        source: "assumed: stated lengths are calibrated; artifacts may have another temperature",
    },
    Assumption {
        family: Family::Sign,
        size: Size::Um(20.0),
        odds: 0.05,
        source: "Spaan 1995, ch. 3: operators easily confuse the signs of direct measurements",
    },
    Assumption {
        family: Family::Earlier,
        size: Size::Urad(50.0),
        odds: 0.003,
        source: "a collision or a repair between two measurements is rare, and mostly known",
    },
    Assumption {
        family: Family::Probe,
        size: Size::Um(20.0),
        odds: 0.1,
        source: "ISO 230-10: pre-travel and lobing of touch probes, and lengths that were set with another instrument",
    },
    Assumption { family: Family::Own, size: Size::Um(20.0), odds: 0.1, source: "a custom cause is added for a reason" },
    Assumption {
        family: Family::Unnamed,
        size: Size::Um(10.0),
        odds: 0.001,
        source: "accepted only if no named cause fits",
    },
];

/// Weight of the stated uncertainty, as a number of readings: estimates from fewer readings do not override it.
pub const READINGS_OF_SIGMA: f64 = 20.0;

impl Family {
    /// Returns its assumption.
    #[must_use]
    pub fn assumption(self) -> &'static Assumption {
        // Every family has an entry, which a test checks.
        ASSUMPTIONS.iter().find(|one| one.family == self).unwrap_or(&ASSUMPTIONS[0])
    }

    /// True for errors that most machines have: all of them together are a start of the search.
    #[must_use]
    pub fn is_simple(self) -> bool {
        matches!(self, Family::Squareness | Family::Scale | Family::Backlash | Family::Offset | Family::Tilt)
    }

    /// Returns the standard deviation of the prior, mm, rad, s or s²; `travel_mm` is the full travel.
    #[must_use]
    pub fn size(self, travel_mm: f64) -> f64 {
        match self.assumption().size {
            Size::Um(um) => um * 1e-3,
            Size::Urad(urad) => urad * 1e-6,
            Size::Ms(ms) => ms * 1e-3,
            // mm per mm/s².
            Size::UmPerMs2(um) => um * 1e-6,
            // At the ends, half of the travel from the middle.
            Size::UmPerM(um) => um * 1e-6 * 0.5 * travel_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_family_has_one_row_and_sizes_have_their_units() {
        let mut families: Vec<Family> = ASSUMPTIONS.iter().map(|one| one.family).collect();
        families.sort_unstable();
        families.dedup();
        assert_eq!((families.len(), ASSUMPTIONS.len(), families.last()), (30, 30, Some(&Family::Unnamed)));
        // 50 µm/m over half of 700 mm; 10 µm; 50 µrad.
        let sizes = [Family::Scale, Family::Backlash, Family::Squareness].map(|family| family.size(700.0));
        assert!(
            sizes.iter().zip([17.5e-3, 10e-3, 50e-6]).all(|(own, expected)| (own - expected).abs() < 1e-12),
            "{sizes:?}"
        );
    }
}
