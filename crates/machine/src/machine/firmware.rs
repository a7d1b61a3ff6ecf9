//! Firmware of the Grbl family: the words that it executes.
//!
//! Sources: README of Grbl 1.1 and of grblHAL (*Supported G-Codes*), and the parsers of Grbl 1.1 and FluidNC (`gcode.c`, `GCode.cpp`). Any other word
//! gives an error, and nothing of its line is executed.

use super::controller::controller;

/// A firmware of the Grbl family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Firmware {
    /// Grbl 1.1: no drilling cycles, tool change or length by H.
    Grbl,
    /// grblHAL: Grbl with drilling cycles and many options.
    GrblHal,
    /// FluidNC: Grbl with expressions and tool changes, without drilling cycles.
    FluidNc,
}

/// Names of controllers with a firmware of this family.
const FIRMWARES: [(&str, Firmware); 3] =
    [("grbl", Firmware::Grbl), ("grblhal", Firmware::GrblHal), ("fluidnc", Firmware::FluidNc)];

/// G codes of Grbl 1.1 and FluidNC, in tenths.
const G_OF_GRBL: &[u32] = &[
    0, 10, 20, 30, 40, 100, 170, 180, 190, 200, 210, 280, 281, 300, 301, 382, 383, 384, 385, 400, 431, 490, 530, 540,
    550, 560, 570, 580, 590, 610, 800, 900, 910, 911, 920, 921, 930, 940,
];

/// Further G codes of grblHAL, in tenths; some depend on the build.
const MORE_G_OF_HAL: &[u32] = &[
    50, 51, 70, 80, 330, 430, 432, 500, 510, 591, 592, 593, 650, 730, 760, 810, 820, 830, 850, 860, 890, 922, 923, 950,
    960, 970, 980, 990,
];

/// M codes of Grbl 1.1. M7 and M56 depend on the build.
const M_OF_GRBL: &[u32] = &[0, 1, 2, 3, 4, 5, 7, 8, 9, 30, 56];

impl Firmware {
    /// Returns the firmware of a controller name; `None` for all other controls.
    #[must_use]
    pub fn of(name: &str) -> Option<Firmware> {
        let known = controller(name)?;
        FIRMWARES.iter().find(|(own, _)| *own == known.name).map(|&(_, firmware)| firmware)
    }

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Firmware::Grbl => "Grbl 1.1",
            Firmware::GrblHal => "grblHAL",
            Firmware::FluidNc => "FluidNC",
        }
    }

    /// True if an arc may have several turns, with P.
    #[must_use]
    pub fn has_turns(self) -> bool {
        self == Firmware::GrblHal
    }

    /// True if it executes a G code, in tenths (`43.1` is 431).
    #[must_use]
    pub fn has_g(self, tenths: u32) -> bool {
        G_OF_GRBL.contains(&tenths) || self == Firmware::GrblHal && MORE_G_OF_HAL.contains(&tenths)
    }

    /// True if it executes an M code. Builds of grblHAL and FluidNC have M codes of their own.
    #[must_use]
    pub fn has_m(self, number: u32) -> bool {
        self != Firmware::Grbl || M_OF_GRBL.contains(&number)
    }

    /// True if only builds with an option have this M code: M7 needs the output for mist (`ENABLE_M7` of `config.h` of Grbl; an output of the driver in
    /// grblHAL), M56 of Grbl needs `ENABLE_PARKING_OVERRIDE_CONTROL`.
    #[must_use]
    pub fn has_option(self, number: u32) -> bool {
        match self {
            Firmware::Grbl => matches!(number, 7 | 56),
            Firmware::GrblHal => number == 7,
            Firmware::FluidNc => false,
        }
    }

    /// True if it reads words with this letter. Letters of axes are those of the machine.
    #[must_use]
    pub fn reads(self, letter: u8) -> bool {
        match self {
            Firmware::Grbl => !matches!(letter, b'D' | b'E' | b'H' | b'O' | b'Q' | b'#' | b'$'),
            Firmware::FluidNc => !matches!(letter, b'D' | b'H' | b'$'),
            Firmware::GrblHal => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Firmware;

    #[test]
    fn each_firmware_has_the_words_of_its_documentation() {
        let of = |name| Firmware::of(name).unwrap();
        let (grbl, hal, fluid) = (of("Grbl"), of("grblHAL"), of("FluidNC"));
        assert_eq!(Firmware::of("linuxcnc"), None);
        // G43.1 and G49, but no length by number.
        assert_eq!([grbl, hal, fluid].map(|one| one.has_g(431) && one.has_g(490)), [true; 3]);
        assert_eq!([grbl, hal, fluid].map(|one| one.has_g(430)), [false, true, false]);
        assert_eq!([grbl, hal, fluid].map(|one| one.has_g(810)), [false, true, false]);
        assert_eq!([grbl, hal, fluid].map(|one| one.has_g(640)), [false; 3]);
        assert_eq!([grbl, hal, fluid].map(|one| one.has_m(6)), [false, true, true]);
        assert_eq!([grbl, hal, fluid].map(|one| one.reads(b'H')), [false, true, false]);
        assert_eq!([grbl, hal, fluid].map(|one| one.reads(b'T')), [true; 3]);
    }
}
