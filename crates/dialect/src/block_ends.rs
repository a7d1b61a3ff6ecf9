//! How a language says that blocks end in an exact stop, or that they do not.

/// The words of a language for the ends of blocks; a language without such words has empty ones.
#[derive(Clone, Copy, Debug)]
pub struct BlockEnds {
    /// From here on every block ends in an exact stop.
    pub exact: &'static str,
    /// What a line says that is not to stop while that is in force.
    pub running: &'static str,
    /// An exact stop at the end of its own block.
    pub once: Option<&'static str>,
    /// All codes of the modal group of [`Self::exact`].
    pub group: &'static [&'static str],
}

/// What a word says about the ends of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockEnd {
    /// Exact stops from here on.
    Exact,
    /// No exact stops from here on.
    Running,
    /// An exact stop at the end of its own block.
    Once,
}

impl BlockEnds {
    /// No word says anything about the ends of blocks.
    pub const NONE: BlockEnds = BlockEnds { exact: "", running: "", once: None, group: &[] };

    /// What a word says, upper case; `None` where it is another word.
    #[must_use]
    pub fn of(&self, word: &str) -> Option<BlockEnd> {
        if self.once == Some(word) {
            return Some(BlockEnd::Once);
        }
        let is_exact = word == self.exact;
        self.group.contains(&word).then_some(if is_exact { BlockEnd::Exact } else { BlockEnd::Running })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DIALECTS, find};

    /// A code of the group that was missing here would be ended at the control by what a writer puts around the lines of a block.
    #[test]
    fn the_group_is_that_of_the_code_table() {
        for dialect in DIALECTS.iter().filter(|dialect| !dialect.block_ends.exact.is_empty()) {
            let (rows, ends) = (dialect.codes().rows(), dialect.block_ends);
            let group = rows.iter().find(|row| row.name == ends.exact).unwrap().group;
            let all: Vec<&str> = rows.iter().filter(|row| row.group == group).map(|row| row.name).collect();
            assert!(all.len() >= 3, "{all:?}");
            assert_eq!(all, ends.group, "{dialect:?}");
        }
    }

    /// Programming manuals: Sinumerik "Job Planning" (G groups 10 and 11; G62 is of group 57), Fanuc B-64484 "Feed functions" (G61 exact stop mode, G60 single
    /// direction positioning), LinuxCNC "G-Codes" (G61 exact path, which slows down or stops where it must; G61.1 exact stop), MillPlus (G9 pole, G61 and G62
    /// tangential approach and leaving, G63 and G64 calculation of geometry).
    #[test]
    fn a_word_is_an_exact_stop_where_its_language_says_so() {
        use BlockEnd::{Exact, Once, Running};
        let words = ["G9", "G60", "G61", "G61.1", "G62", "G63", "G64", "G642"];
        for (name, expected) in [
            ("sinumerik", [Some(Once), Some(Exact), None, None, None, None, Some(Running), Some(Running)]),
            ("fanuc", [Some(Once), None, Some(Exact), None, Some(Running), Some(Running), Some(Running), None]),
            ("rs274", [None, None, Some(Running), Some(Exact), None, None, Some(Running), None]),
            ("grundig", [None; 8]),
        ] {
            let ends = find(name).unwrap().block_ends;
            assert_eq!(words.map(|word| ends.of(word)), expected, "{name}");
            assert_eq!((ends.of(""), ends.of("G1")), (None, None));
        }
    }
}
