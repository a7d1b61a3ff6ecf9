//! Words of a language that switch exact stops at block ends on or off.

/// Words of a language for block ends; a language without such words has empty ones.
#[derive(Clone, Copy, Debug)]
pub struct BlockEnds {
    /// Word after which every block ends in an exact stop.
    pub exact: &'static str,
    /// Word for a line that is not to stop while the exact stop is in force.
    pub running: &'static str,
    /// Word for an exact stop at the end of its own block only.
    pub once: Option<&'static str>,
    /// All codes of the modal group of [`Self::exact`].
    pub group: &'static [&'static str],
}

/// Meaning of a word for block ends.
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
    /// A language without words for block ends.
    pub const NONE: BlockEnds = BlockEnds { exact: "", running: "", once: None, group: &[] };

    /// Returns the meaning of a word, upper case; `None` if it does not concern block ends.
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

    /// If a code of the group were missing here, the words that a writer adds around the lines of a block would end it at the control.
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
    /// direction positioning), LinuxCNC "G-Codes" (G61 exact path, which slows down or stops where it must; G61.1 exact stop), Mazak EIA (G61.1 geometry compensation), MillPlus (G9 pole, G61 and G62
    /// tangential approach and leaving, G63 and G64 calculation of geometry).
    #[test]
    fn a_word_is_an_exact_stop_where_its_language_says_so() {
        use BlockEnd::{Exact, Once, Running};
        let words = ["G9", "G60", "G61", "G61.1", "G62", "G63", "G64", "G642"];
        for (name, expected) in [
            ("sinumerik", [Some(Once), Some(Exact), None, None, None, None, Some(Running), Some(Running)]),
            (
                "fanuc",
                [Some(Once), None, Some(Exact), Some(Running), Some(Running), Some(Running), Some(Running), None],
            ),
            ("rs274", [None, None, Some(Running), Some(Exact), None, None, Some(Running), None]),
            ("grundig", [None; 8]),
        ] {
            let ends = find(name).unwrap().block_ends;
            assert_eq!(words.map(|word| ends.of(word)), expected, "{name}");
            assert_eq!((ends.of(""), ends.of("G1")), (None, None));
        }
    }
}
