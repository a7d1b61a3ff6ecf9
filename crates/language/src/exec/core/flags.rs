//! One bit for each block of a program.

/// A bit for each block: set once it has been handled.
#[derive(Clone, Debug, Default)]
pub(in crate::exec) struct Flags {
    bits: Vec<u64>,
    count: usize,
}

impl Flags {
    /// Cleared flags for `count` blocks.
    pub(in crate::exec) fn new(count: usize) -> Flags {
        Flags { bits: vec![0; count.div_ceil(64)], count }
    }

    /// Sets a flag and returns its previous value. `None` if there is no such block.
    pub(in crate::exec) fn note(&mut self, number: usize) -> Option<bool> {
        let bit = 1 << (number % 64);
        let bits = self.bits.get_mut(number / 64).filter(|_| number < self.count)?;
        let before = *bits & bit != 0;
        *bits |= bit;
        Some(before)
    }

    /// `true` if a flag is set.
    pub(in crate::exec) fn holds(&self, number: usize) -> bool {
        self.bits.get(number / 64).is_some_and(|bits| bits & (1 << (number % 64)) != 0)
    }

    /// Clears a flag.
    pub(in crate::exec) fn clear(&mut self, number: usize) {
        if let Some(bits) = self.bits.get_mut(number / 64) {
            *bits &= !(1 << (number % 64));
        }
    }

    /// Sets all flags.
    pub(in crate::exec) fn note_all(&mut self) {
        self.bits.fill(u64::MAX);
    }
}

#[cfg(test)]
mod tests {
    use super::Flags;

    #[test]
    fn each_block_has_a_flag_of_its_own() {
        let mut flags = Flags::new(130);
        let noted = [63, 64, 129, 63, 129].map(|number| flags.note(number));
        assert_eq!(noted, [Some(false), Some(false), Some(false), Some(true), Some(true)]);
        assert_eq!((flags.note(130), flags.note(65)), (None, Some(false)));
        flags.clear(64);
        flags.clear(999);
        assert_eq!([63, 64, 65, 130, 999].map(|number| flags.holds(number)), [true, false, true, false, false]);
        flags.note_all();
        assert_eq!((flags.note(0), flags.note(128)), (Some(true), Some(true)));
    }
}
