//! Units of readings, as headings and options write them.

use ncfix_base::units::{rad_from_urad, um_from_mm};

/// Unit of a reading or of a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReadingUnit {
    /// A length; the value of one in mm.
    Length(&'static str, f64),
    /// An angle; the value of one in rad.
    Angle(&'static str, f64),
}

/// One arc second in rad: 1/3600 of a degree.
const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;

/// All units: the spelling in options, other spellings in headings, and the value of one.
const UNITS: &[(ReadingUnit, &[&str])] = &[
    (ReadingUnit::Length("mm", 1.0), &["millimeter", "millimetre"]),
    (ReadingUnit::Length("um", 1e-3), &["µm", "μm", "micron", "microns", "mikron", "micrometer", "micrometre"]),
    (ReadingUnit::Length("nm", 1e-6), &["nanometer", "nanometre"]),
    (ReadingUnit::Length("cm", 10.0), &["centimeter", "centimetre", "zentimeter"]),
    (ReadingUnit::Length("m", 1e3), &["meter", "metre"]),
    // A thousandth of an inch.
    (ReadingUnit::Length("thou", 0.0254), &["mil", "mils"]),
    (ReadingUnit::Length("inch", 25.4), &["in", "inches", "zoll"]),
    (ReadingUnit::Angle("urad", 1e-6), &["µrad", "μrad", "microrad", "um/m", "µm/m", "μm/m"]),
    (ReadingUnit::Angle("mrad", 1e-3), &["mm/m"]),
    (ReadingUnit::Angle("rad", 1.0), &[]),
    (ReadingUnit::Angle("deg", std::f64::consts::PI / 180.0), &["°", "grad", "degree", "degrees"]),
    (ReadingUnit::Angle("arcsec", ARCSEC), &["\"", "''", "″", "arcsecond", "arcseconds", "sec", "arc seconds"]),
];

impl ReadingUnit {
    /// Reads a unit as an option or a heading writes it.
    #[must_use]
    pub fn find(text: &str) -> Option<ReadingUnit> {
        let text = text.trim().to_lowercase();
        UNITS
            .iter()
            .find(|(unit, spellings)| unit.sign() == text || spellings.contains(&text.as_str()))
            .map(|(unit, _)| *unit)
    }

    /// Returns the spelling in options: `um`.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            ReadingUnit::Length(sign, _) | ReadingUnit::Angle(sign, _) => sign,
        }
    }

    /// True for angles.
    #[must_use]
    pub fn is_angle(self) -> bool {
        matches!(self, ReadingUnit::Angle(..))
    }

    /// Converts to mm or rad.
    #[must_use]
    pub fn inner(self, value: f64) -> f64 {
        match self {
            ReadingUnit::Length(_, one) | ReadingUnit::Angle(_, one) => value * one,
        }
    }

    /// Converts to µm or µrad, the units of a data file.
    #[must_use]
    pub fn fine(self, value: f64) -> f64 {
        if self.is_angle() { self.inner(value) / rad_from_urad(1.0) } else { um_from_mm(self.inner(value)) }
    }

    /// Returns the spellings of all units of a kind, for a question.
    #[must_use]
    pub fn choices(is_angle: bool) -> String {
        let own = UNITS.iter().filter(|(unit, _)| unit.is_angle() == is_angle);
        // A level shows a slope.
        let slope = |spellings: &[&str]| ["um/m", "mm/m"].into_iter().find(|own| spellings.contains(own));
        let name = |(unit, spellings): &(ReadingUnit, &[&str])| match slope(spellings) {
            Some(slope) => format!("{} ({slope})", unit.sign()),
            None => unit.sign().to_owned(),
        };
        own.map(name).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spellings_of_headings_are_known() {
        for (text, fine) in [("µm", 1.0), ("UM", 1.0), ("mm", 1000.0), ("Mikron", 1.0), ("inch", 25400.0)] {
            assert!((ReadingUnit::find(text).unwrap().fine(1.0) - fine).abs() < 1e-9 * fine, "{text}");
        }
        // 1 arc second is 4.8481 µrad.
        assert!((ReadingUnit::find("arcsec").unwrap().fine(1.0) - 4.848_137).abs() < 1e-6);
        assert!((ReadingUnit::find("µm/m").unwrap().fine(3.0) - 3.0).abs() < 1e-9);
        assert_eq!(ReadingUnit::find("bananas"), None);
    }
}
