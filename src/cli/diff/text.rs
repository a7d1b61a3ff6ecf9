//! `ncfix diff --text`: the words of two programs as they are written.

use std::collections::BTreeMap;

use super::listing::Text;
use super::pager::Page;
use crate::cli::arguments::DiffArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::stop::Stop;
use crate::cli::{print, program};
use crate::report::json;
use crate::report::review::{TextLine, TextReview, TextWord, WordFigures};
use crate::review::text::{Change, Pairing, compare};

/// Rows in the object for programs where nothing else is said.
const ROWS_OF_JSON: usize = 20;

/// Compares two programs.
pub(super) fn run(arguments: &DiffArguments) -> Result<ExitCode, Stop> {
    let sources = [program::read(&arguments.original)?, program::read(&arguments.corrected)?];
    let both = sources.each_ref().map(|source| (source.bytes(), source.line_end()));
    let found = compare(both, arguments.tolerance.unwrap_or(0.0));
    let texts = sources.each_ref().map(Text::new);
    let mut review = TextReview { schema: 1, compared: "text", ..TextReview::default() };
    review.files = [&arguments.original, &arguments.corrected].map(|path| path.display().to_string());
    let wanted = |change: &&Change| {
        let is_axis = |address: &str| arguments.axis.iter().any(|axis| address == axis.to_string());
        arguments.axis.is_empty() || is_axis(&change.address)
    };
    let mut rows: Vec<TextLine> = Vec::new();
    for pairing in &found {
        match pairing {
            Pairing::Same(_) => review.same_lines += 1,
            Pairing::Gone(line) => {
                review.gone += 1;
                rows.push(TextLine {
                    lines: [Some(*line), None],
                    text: short(&texts[0].line(*line)),
                    ..TextLine::default()
                });
            }
            Pairing::New(line) => {
                review.new += 1;
                rows.push(TextLine {
                    lines: [None, Some(*line)],
                    text: short(&texts[1].line(*line)),
                    ..TextLine::default()
                });
            }
            Pairing::Changed([one, other], changes) => {
                let words: Vec<TextWord> = changes.iter().filter(wanted).map(word).collect();
                if words.is_empty() {
                    review.same_lines += 1;
                    continue;
                }
                review.changed += 1;
                note(&mut review.words, &words, *one);
                rows.push(TextLine { lines: [Some(*one), Some(*other)], words, ..TextLine::default() });
            }
        }
    }
    let largest = |row: &TextLine| row.words.iter().map(|word| word.added.abs()).fold(0.0, f64::max);
    review.same = rows.is_empty();
    let all = rows.len();
    let is_passed =
        arguments.fail_above.is_some_and(|limit| rows.iter().any(|row| largest(row) > limit || row.words.is_empty()));
    if let Some(least) = arguments.only {
        rows.retain(|row| row.words.is_empty() || largest(row) >= least);
    }
    if arguments.top.is_some() {
        // Lines that came or went are the largest change of all.
        let size = |row: &TextLine| if row.words.is_empty() { f64::INFINITY } else { largest(row) };
        rows.sort_by(|a, b| size(b).total_cmp(&size(a)));
    }
    rows.truncate(arguments.top.unwrap_or(if arguments.json { ROWS_OF_JSON } else { usize::MAX }));
    review.more_rows = (all - rows.len()) as u64;
    if arguments.json {
        review.rows = rows;
        print(&json::line(&review).map_err(Stop::Usage)?)?;
    } else {
        let mut page = Page::open(arguments.no_pager);
        page.write(&review.summary())?;
        if !arguments.summary && !rows.is_empty() {
            page.write("\n")?;
            let look = page.look();
            for row in &rows {
                page.write(&row.line(&look))?;
            }
        }
        page.close();
    }
    Ok(match (review.same, arguments.fail_above) {
        (false, None) => ExitCode::Different,
        (false, Some(_)) if is_passed => ExitCode::Refused,
        _ => ExitCode::Done,
    })
}

fn word(change: &Change) -> TextWord {
    let [before, after] = change.texts.clone();
    TextWord { address: change.address.clone(), before, after, added: change.added }
}

/// Takes words into the figures of their addresses.
fn note(figures: &mut BTreeMap<String, WordFigures>, words: &[TextWord], line: u32) {
    for word in words {
        let own = figures.entry(word.address.clone()).or_default();
        own.count += 1;
        if word.added.abs() > own.max.abs() {
            (own.max, own.max_line) = (word.added, line);
        }
    }
}

/// A line, no longer than a row.
fn short(line: &str) -> String {
    const LONGEST: usize = 60;
    let text = line.trim();
    if text.chars().count() > LONGEST { text.chars().take(LONGEST).chain(['…']).collect() } else { text.to_owned() }
}
