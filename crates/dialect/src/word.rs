//! Table of the Sinumerik words that are not codes: one row per word and place, read from `grammars/`.

use std::sync::LazyLock;

/// Place in which a row applies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum WordPlace {
    /// Actions of a synchronized action.
    Action,
    /// A word of a block.
    Block,
    /// `DEF`.
    Definition,
    /// A function in an expression.
    Expression,
    /// First word of a block that is read to its end.
    Statement,
}

/// Treatment of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// An address; its value is executed.
    Read,
    /// Concerns the axis in its brackets.
    Axis,
    /// Passed on, values evaluated.
    Pass,
    /// An address letter with an index in brackets, passed on.
    Letter,
    /// Replaces the feed in its block.
    BlockFeed,
    /// Reads or writes files of the control: omitted, its result variable is 0 (no error).
    File,
    /// Lets an interrupt start a program.
    Interrupt,
    /// Passed on; the axis positions are unknown afterwards.
    Lost,
    /// Text for the display.
    Message,
    /// Ends a program.
    Return,
    /// Refused; the meaning says why.
    Refuse,
    /// Known, not executed yet.
    Later,
    /// A function that depends only on its arguments.
    Function,
    /// A function that is evaluated with the state of the channel.
    Channel,
    /// A function whose value is a frame.
    Frame,
    /// Moves no axis.
    Still,
    /// Changes no value.
    Modifier,
}

/// Unit of the values of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueUnit {
    /// Neither length nor feed.
    None,
    /// A length; for a call, the first argument is a length.
    Length,
    /// A feed.
    Feed,
}

/// Row of the table.
#[derive(Clone, Debug)]
pub struct WordEntry {
    /// Name, upper case.
    pub name: &'static str,
    /// Place in which the row applies.
    pub place: WordPlace,
    /// Treatment.
    pub treatment: Treatment,
    /// Form of the values: `-`, `=length`, `[axis]=value`, `(...)`; for a function the number of its arguments: `1`, `2..3`.
    pub arguments: &'static str,
    /// Unit of its values.
    pub unit: ValueUnit,
    /// Minimum and maximum number of arguments of a function.
    pub counts: (usize, usize),
    /// Manual and chapter.
    pub source: &'static str,
    /// Short description; for a refused word the reason.
    pub meaning: &'static str,
}

/// All words, sorted by name and place.
pub struct WordTable {
    rows: Vec<WordEntry>,
}

impl WordTable {
    /// Reads `word TAB place TAB treatment TAB arguments TAB source TAB meaning` lines; `#` starts a comment line.
    ///
    /// The table is compiled in, and a test reads it. So a faulty row is omitted, not reported.
    fn from_tsv(text: &'static str) -> WordTable {
        let rows = text.lines().filter(|line| !line.starts_with('#')).filter_map(|line| {
            let fields: Vec<&'static str> = line.split('\t').collect();
            let [name, place, treatment, arguments, source, meaning] = fields[..] else { return None };
            let unit = match arguments {
                _ if arguments.contains("length") => ValueUnit::Length,
                _ if arguments.contains("feed") => ValueUnit::Feed,
                _ => ValueUnit::None,
            };
            let (fewest, most) = arguments.split_once("..").unwrap_or((arguments, arguments));
            let counts = (fewest.parse().unwrap_or(0), most.parse().unwrap_or(usize::MAX));
            let (place, treatment) = (WordPlace::from_word(place)?, Treatment::from_word(treatment)?);
            Some(WordEntry { name, place, treatment, arguments, unit, counts, source, meaning })
        });
        WordTable { rows: rows.collect() }
    }

    /// Returns the row of a word, upper case, in a place.
    #[must_use]
    pub fn find(&self, name: &str, place: WordPlace) -> Option<&WordEntry> {
        let found = self.rows.binary_search_by(|row| row.name.cmp(name).then(row.place.cmp(&place)));
        found.ok().and_then(|index| self.rows.get(index))
    }

    /// Returns all rows.
    #[must_use]
    pub fn rows(&self) -> &[WordEntry] {
        &self.rows
    }
}

/// Returns the words of the Sinumerik.
#[must_use]
pub fn words() -> &'static WordTable {
    static WORDS: LazyLock<WordTable> =
        LazyLock::new(|| WordTable::from_tsv(include_str!(concat!(env!("NCFIX_GRAMMARS"), "/sinumerik-words.tsv"))));
    &WORDS
}

impl WordPlace {
    fn from_word(word: &str) -> Option<WordPlace> {
        Some(match word {
            "action" => WordPlace::Action,
            "block" => WordPlace::Block,
            "definition" => WordPlace::Definition,
            "expression" => WordPlace::Expression,
            "statement" => WordPlace::Statement,
            _ => return None,
        })
    }
}

impl Treatment {
    fn from_word(word: &str) -> Option<Treatment> {
        Some(match word {
            "read" => Treatment::Read,
            "axis" => Treatment::Axis,
            "pass" => Treatment::Pass,
            "letter" => Treatment::Letter,
            "blockfeed" => Treatment::BlockFeed,
            "file" => Treatment::File,
            "interrupt" => Treatment::Interrupt,
            "lost" => Treatment::Lost,
            "message" => Treatment::Message,
            "return" => Treatment::Return,
            "refuse" => Treatment::Refuse,
            "later" => Treatment::Later,
            "function" => Treatment::Function,
            "channel" => Treatment::Channel,
            "frame" => Treatment::Frame,
            "still" => Treatment::Still,
            "modifier" => Treatment::Modifier,
            _ => return None,
        })
    }

    /// True if words of a place may have this treatment.
    #[cfg(test)]
    fn fits(self, place: WordPlace) -> bool {
        match place {
            WordPlace::Action => matches!(self, Treatment::Axis | Treatment::Still),
            WordPlace::Definition => self == Treatment::Modifier,
            WordPlace::Expression => matches!(self, Treatment::Function | Treatment::Channel | Treatment::Frame),
            WordPlace::Statement => self == Treatment::Later,
            WordPlace::Block => !matches!(
                self,
                Treatment::Function | Treatment::Channel | Treatment::Frame | Treatment::Still | Treatment::Modifier
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the rows of the file as written.
    fn written() -> Vec<Vec<String>> {
        let path = format!("{}/../../grammars/sinumerik-words.tsv", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).unwrap();
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        lines.map(|line| line.split('\t').map(str::to_owned).collect()).collect()
    }

    #[test]
    fn every_row_is_read_and_complete() {
        let written = written();
        assert_eq!(words().rows().len(), written.len(), "a row has an unknown place or treatment, or not six fields");
        for row in &written {
            assert!(row.iter().all(|field| !field.trim().is_empty()), "an empty field: {row:?}");
            let manual = row[4].split([' ', ',']).next().unwrap();
            assert!(["PG", "PGA", "TM", "unverified"].contains(&manual), "an unknown source: {row:?}");
        }
        for row in words().rows() {
            assert!(row.treatment.fits(row.place), "{}: a treatment for another place", row.name);
        }
    }

    #[test]
    fn rows_are_sorted_and_stand_once() {
        for pair in words().rows().windows(2) {
            let [first, second] = pair else { continue };
            assert!((first.name, first.place) < (second.name, second.place), "{} before {}", first.name, second.name);
        }
        for row in words().rows() {
            assert_eq!(words().find(row.name, row.place).map(|found| found.meaning), Some(row.meaning), "{}", row.name);
        }
        assert!(words().find("ABS", WordPlace::Block).is_none());
    }

    #[test]
    fn words_of_blocks_are_no_codes() {
        let codes = crate::sinumerik().codes();
        let doubled =
            words().rows().iter().filter(|row| row.place == WordPlace::Block && codes.word(row.name).is_some());
        assert_eq!(doubled.map(|row| row.name).collect::<Vec<_>>(), Vec::<&str>::new());
    }

    #[test]
    fn arguments_have_one_of_the_known_forms() {
        let forms = [
            "-",
            "=value",
            "=length",
            "=feed",
            "[axis]",
            "[axis]=value",
            "[axis]=length",
            "[axis]=feed",
            "[axis]=(...)",
            "[spindle]=value",
            "(...)",
            "(length...)",
        ];
        for row in words().rows() {
            let is_known = match row.place {
                WordPlace::Expression if row.treatment == Treatment::Function => {
                    row.counts.0 >= 1 && row.counts.1 <= 32
                }
                WordPlace::Expression => row.arguments == "..." || row.counts.1 <= 32,
                WordPlace::Definition => ["-", "value"].contains(&row.arguments),
                _ => forms.contains(&row.arguments),
            };
            assert!(is_known, "{}: {}", row.name, row.arguments);
        }
        let unit = |name| words().find(name, WordPlace::Block).map(|row| row.unit);
        assert_eq!(unit("ADIS"), Some(ValueUnit::Length));
        assert_eq!(unit("CYCLE832"), Some(ValueUnit::Length));
        assert_eq!(unit("FA"), Some(ValueUnit::Feed));
        assert_eq!(unit("LIMS"), Some(ValueUnit::None));
        assert_eq!(words().find("SUBSTR", WordPlace::Expression).map(|row| row.counts), Some((2, 3)));
    }
}
