//! Counts the blocks of a page that contains only block numbers and letters with numbers, without parsing them.
//!
//! Most of a large program looks like this, and every parser accepts it. Such a page cannot contain an error, and it is parsed when it is executed. A
//! page with any other content is left to the parser.

use super::paged_store::PagedStore;

/// Letters that are words with a number, and nothing else, in every language.
const LETTERS: &[u8] = b"GMXYZABCUVWIJKFSTDH";
/// Maximum bytes of a block; longer ones may exceed a parser's limit.
const MOST_BYTES: usize = 1024;
/// Maximum digits of a number, far below every limit.
const MOST_DIGITS: usize = 15;
/// Maximum digits of a block number.
const MOST_NUMBER_DIGITS: usize = 8;

const BLANK: u8 = 1;
const LETTER: u8 = 2;
const NUMBER: u8 = 3;

/// Kinds of bytes at the beginning of a word.
const KINDS: [u8; 256] = {
    let mut kinds = [0; 256];
    let mut byte = 0;
    while byte <= b' ' as usize {
        kinds[byte] = BLANK;
        byte += 1;
    }
    kinds[0x7f] = BLANK;
    let mut k = 0;
    while k < LETTERS.len() {
        kinds[LETTERS[k] as usize] = LETTER;
        kinds[LETTERS[k].to_ascii_lowercase() as usize] = LETTER;
        k += 1;
    }
    kinds[b'N' as usize] = NUMBER;
    kinds[b'n' as usize] = NUMBER;
    kinds
};

/// Content of a page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Plain {
    pub(super) blocks: usize,
    pub(super) words: usize,
    pub(super) lines: u32,
    /// Start of the next page.
    pub(super) end: usize,
}

/// Counts whole lines from an offset up to another one; `None` if any of them needs the parser.
pub(super) fn count(bytes: &[u8], from: usize, until: usize, line_end: u8) -> Option<Plain> {
    let until = until.min(bytes.len());
    let mut page = Plain { end: from, ..Plain::default() };
    while page.end < until {
        let start = page.end;
        let mut at = start;
        let (mut words, mut numbered) = (0, false);
        while let Some(&byte) = bytes.get(at) {
            if byte == line_end {
                break;
            }
            at += 1;
            match KINDS[usize::from(byte)] {
                BLANK => {}
                LETTER => {
                    if let Some(b'-' | b'+') = bytes.get(at) {
                        at += 1;
                    }
                    let whole = digits(bytes, at);
                    at += whole;
                    let mut found = whole;
                    if bytes.get(at) == Some(&b'.') {
                        let parts = digits(bytes, at + 1);
                        at += 1 + parts;
                        found += parts;
                    }
                    if found == 0 || found > MOST_DIGITS {
                        return None;
                    }
                    words += 1;
                }
                NUMBER if words == 0 && !numbered => {
                    let found = digits(bytes, at);
                    at += found;
                    if found == 0 || found > MOST_NUMBER_DIGITS {
                        return None;
                    }
                    numbered = true;
                }
                _ => return None,
            }
        }
        if at - start > MOST_BYTES {
            return None;
        }
        page.lines += 1;
        page.words += words;
        page.blocks += usize::from(words > 0 || numbered);
        page.end = (at + 1).min(bytes.len());
    }
    Some(page)
}

/// The number of digits at an offset.
#[inline]
fn digits(bytes: &[u8], at: usize) -> usize {
    bytes.get(at..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_digit()).count()
}

impl Plain {
    /// Adds the page to the counts of blocks and words without storing its nodes.
    pub(super) fn leave_out<B, W>(&self, blocks: &mut PagedStore<B>, words: &mut PagedStore<W>) {
        blocks.leave_out(self.blocks);
        words.leave_out(self.words);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::syntax::{self, Program};
    use ncfix_base::source::{FileId, Source};
    use ncfix_dialect::DIALECTS;

    #[test]
    fn plain_lines_are_counted() {
        let text = b"N10 G1 X-1.5Y.25 Z+3.\n\n  \r\nN20\nm30 \n";
        assert_eq!(count(text, 0, 1000, b'\n'), Some(Plain { blocks: 3, words: 5, lines: 5, end: text.len() }));
        // Whole lines; the last one has no line end.
        assert_eq!(count(b"X1\nX2\nX3", 3, 4, b'\n'), Some(Plain { blocks: 1, words: 1, lines: 1, end: 6 }));
        assert_eq!(count(b"X1\nX2\nX3", 6, 99, b'\n'), Some(Plain { blocks: 1, words: 1, lines: 1, end: 8 }));
        for other in [
            "X", "X.", "X--1", "X=1", "X1=2", "R1", "G1 N5", "NN5", "N1.5", "(X1)", "X1;", "%", "X1 2", "/X1", "L6",
            "X1EX3", "X\u{e9}1",
        ] {
            assert_eq!(count(other.as_bytes(), 0, 99, b'\n'), None, "{other}");
        }
        assert_eq!(count(format!("X{}", "1".repeat(16)).as_bytes(), 0, 99, b'\n'), None);
        assert_eq!(count("X1 ".repeat(400).as_bytes(), 0, 9999, b'\n'), None);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        /// Every parser finds the same counts, and no errors.
        #[test]
        fn every_parser_agrees(line in "( ?[NnGMXYZABCUVWIJKFSTDHgmx][-+]?[0-9]{0,4}\\.?[0-9]{0,3}[ \t]?){0,5}") {
            let text = format!("G1 X0\n{line}\nX1\n");
            let Some(page) = count(text.as_bytes(), 6, text.len() - 3, b'\n') else { return Ok(()) };
            for dialect in DIALECTS.iter().filter(|dialect| dialect.language != ncfix_dialect::Language::Grundig) {
                let source = Source::new(FileId(0), "p", text.clone().into_bytes()).unwrap();
                let (program, findings) = syntax::parse(&source, dialect);
                prop_assert!(findings.is_empty(), "{}: {findings:?}", dialect.name);
                let (blocks, words, names) = match &program {
                    Program::Sinumerik(program) => (program.blocks.len(), program.words.len(), program.names.iter().count()),
                    Program::Words(program) => (program.blocks.len(), program.words.len(), program.names.iter().count()),
                };
                prop_assert_eq!((blocks, words, names), (2 + page.blocks, 3 + page.words, 0), "{}", dialect.name);
            }
        }
    }
}
