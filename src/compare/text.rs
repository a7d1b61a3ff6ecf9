//! `ncfix diff --text`: comparison of two programs by their text.

use std::collections::BTreeMap;

use super::CompareOptions;
use super::listing::Text;
use ncfix_base::source::Source;
use ncfix_path::review::text::{Aligned, ChangedNumber, Pairing, compare};
use ncfix_report::review::{TextLine, TextReview, TextWord, WordFigures};

/// Two programs that are compared by their text.
pub(crate) struct TextComparison<'a> {
    /// The result without its rows.
    pub(crate) review: TextReview,
    /// True if a change is larger than permitted.
    pub(crate) is_beyond: bool,
    found: Aligned<'a>,
    texts: [Text<'a>; 2],
    wanted: &'a CompareOptions,
    /// Indices of the shown rows, in their order.
    shown: Vec<usize>,
}

impl<'a> TextComparison<'a> {
    /// Compares two texts; at most `most` rows are shown.
    pub(crate) fn new(
        sources: [&'a Source; 2],
        names: [String; 2],
        wanted: &'a CompareOptions,
        most: usize,
    ) -> TextComparison<'a> {
        let found = compare(sources.map(|source| (source.bytes(), source.line_end())), wanted.tolerance_mm);
        let review = TextReview { schema: 1, compared: "text", files: names, ..TextReview::default() };
        let texts = sources.map(Text::new);
        let mut own = TextComparison { review, is_beyond: false, found, texts, wanted, shown: Vec::new() };
        // Added and removed lines count as the largest change. Rows are made again for the output, because there may
        // be millions.
        let mut sizes: Vec<(f64, usize)> = Vec::new();
        for place in 0..own.found.count() {
            let Some(row) = own.row(place) else {
                own.review.same_lines += 1;
                continue;
            };
            match row.lines {
                [Some(line), Some(_)] => {
                    own.review.changed += 1;
                    note(&mut own.review.words, &row.words, line);
                }
                [Some(_), None] => own.review.gone += 1,
                _ => own.review.new += 1,
            }
            let largest = row.words.iter().map(|word| word.added.abs()).fold(0.0, f64::max);
            sizes.push((if row.words.is_empty() { f64::INFINITY } else { largest }, place));
        }
        own.review.same = sizes.is_empty();
        let all = sizes.len();
        own.is_beyond = wanted.limit_mm.is_some_and(|limit| sizes.iter().any(|(size, _)| *size > limit));
        if let Some(least) = wanted.least_mm {
            sizes.retain(|(size, _)| *size >= least);
        }
        if wanted.rows.is_some() {
            sizes.sort_by(|a, b| b.0.total_cmp(&a.0));
        }
        sizes.truncate(wanted.rows.unwrap_or(most));
        own.review.more_rows = (all - sizes.len()) as u64;
        own.shown = sizes.into_iter().map(|(_, place)| place).collect();
        own
    }

    /// The shown rows, made one by one.
    pub(crate) fn rows(&self) -> impl Iterator<Item = TextLine> {
        self.shown.iter().filter_map(|&place| self.row(place))
    }

    fn row(&self, place: usize) -> Option<TextLine> {
        let is_wanted = |word: &TextWord| {
            self.wanted.axes.is_empty() || self.wanted.axes.iter().any(|axis| word.address == axis.to_string())
        };
        let alone = |lines: [Option<u32>; 2], text: String| TextLine { lines, text: short(&text), words: Vec::new() };
        Some(match self.found.at(place)? {
            Pairing::Same(_) => return None,
            Pairing::Gone(line) => alone([Some(line), None], self.texts[0].line(line)),
            Pairing::New(line) => alone([None, Some(line)], self.texts[1].line(line)),
            Pairing::Changed([one, other], changes) => {
                let words: Vec<TextWord> = changes.into_iter().map(word).filter(is_wanted).collect();
                if words.is_empty() {
                    return None;
                }
                TextLine { lines: [Some(one), Some(other)], words, text: String::new() }
            }
        })
    }
}

fn word(change: ChangedNumber) -> TextWord {
    let [before, after] = change.texts;
    TextWord { address: change.address, before, after, added: change.added }
}

/// Adds words to the figures of their addresses.
fn note(figures: &mut BTreeMap<String, WordFigures>, words: &[TextWord], line: u32) {
    for word in words {
        let own = figures.entry(word.address.clone()).or_default();
        own.count += 1;
        if word.added.abs() > own.max.abs() {
            (own.max, own.max_line) = (word.added, line);
        }
    }
}

/// A line, limited to the length of a row.
fn short(line: &str) -> String {
    const LONGEST: usize = 60;
    let text = line.trim();
    if text.chars().count() > LONGEST { text.chars().take(LONGEST).chain(['…']).collect() } else { text.to_owned() }
}
