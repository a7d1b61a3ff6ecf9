//! The zero offsets and their names.

/// A settable zero offset: 1 to 9 are G54 to G59.3, from [`System::ADDITIONAL`] on G54.1 P1 and so on; 0 is the offset of all systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct System(pub(super) u16);

/// Names of the zero offsets 0 to 9.
pub(super) const NAMES: [&str; 10] = ["EXT", "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

impl System {
    /// G54
    pub(super) const FIRST: System = System(1);
    /// The offset of all systems of a Fanuc.
    pub(super) const EXTERNAL: System = System(0);
    /// G54.1 P0, which does not exist.
    pub(super) const ADDITIONAL: u16 = 100;

    /// The system of a code in tenths.
    pub(super) fn of_code(tenths: u16) -> Option<System> {
        match tenths {
            540 | 550 | 560 | 570 | 580 | 590 => Some(System((tenths - 530) / 10)),
            591..=593 => Some(System(tenths - 591 + 7)),
            _ => None,
        }
    }

    /// The system of a name.
    pub(super) fn of_name(name: &str) -> Option<System> {
        let own = NAMES.iter().position(|known| *known == name).map(|index| System(index as u16));
        own.or_else(|| {
            name.strip_prefix("G54.1 P")?.parse().ok().map(|number: u16| System(System::ADDITIONAL + number))
        })
    }

    /// Its name in programs and in the machine file.
    pub(super) fn words(self) -> String {
        match NAMES.get(usize::from(self.0)) {
            Some(name) => (*name).to_owned(),
            None => format!("G54.1 P{}", self.0 - System::ADDITIONAL),
        }
    }
}
