//! `ncfix diff --text`: the words of two programs as they are written.

use std::collections::BTreeMap;

use super::listing::Text;
use super::pager::Page;
use crate::cli::arguments::DiffArguments;
use crate::cli::exit_code::ExitCode;
use crate::cli::stop::Stop;
use crate::cli::{print, program};
use ncfix_path::review::text::{Change, Pairing, compare};
use ncfix_report::json;
use ncfix_report::review::{TextLine, TextReview, TextWord, WordFigures};

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
    let is_wanted = |word: &TextWord| {
        arguments.axis.is_empty() || arguments.axis.iter().any(|axis| word.address == axis.to_string())
    };
    let row = |place: usize| -> Option<TextLine> {
        let alone = |lines: [Option<u32>; 2], text: String| TextLine { lines, text: short(&text), words: Vec::new() };
        Some(match found.at(place)? {
            Pairing::Same(_) => return None,
            Pairing::Gone(line) => alone([Some(line), None], texts[0].line(line)),
            Pairing::New(line) => alone([None, Some(line)], texts[1].line(line)),
            Pairing::Changed([one, other], changes) => {
                let words: Vec<TextWord> = changes.into_iter().map(word).filter(is_wanted).collect();
                if words.is_empty() {
                    return None;
                }
                TextLine { lines: [Some(one), Some(other)], words, text: String::new() }
            }
        })
    };
    // Lines that came or went are the largest change of all. Rows are made again when they are shown: there may be millions.
    let mut sizes: Vec<(f64, usize)> = Vec::new();
    for place in 0..found.count() {
        let Some(row) = row(place) else {
            review.same_lines += 1;
            continue;
        };
        match row.lines {
            [Some(line), Some(_)] => {
                review.changed += 1;
                note(&mut review.words, &row.words, line);
            }
            [Some(_), None] => review.gone += 1,
            _ => review.new += 1,
        }
        let largest = row.words.iter().map(|word| word.added.abs()).fold(0.0, f64::max);
        sizes.push((if row.words.is_empty() { f64::INFINITY } else { largest }, place));
    }
    review.same = sizes.is_empty();
    let all = sizes.len();
    let is_passed = arguments.fail_above.is_some_and(|limit| sizes.iter().any(|(size, _)| *size > limit));
    if let Some(least) = arguments.only {
        sizes.retain(|(size, _)| *size >= least);
    }
    if arguments.top.is_some() {
        sizes.sort_by(|a, b| b.0.total_cmp(&a.0));
    }
    sizes.truncate(arguments.top.unwrap_or(if arguments.json { ROWS_OF_JSON } else { usize::MAX }));
    review.more_rows = (all - sizes.len()) as u64;
    let rows = sizes.into_iter().filter_map(|(_, place)| row(place));
    if arguments.json {
        review.rows = rows.collect();
        print(&json::line(&review).map_err(Stop::Usage)?)?;
    } else {
        let mut page = Page::open(arguments.no_pager);
        page.write(&review.summary())?;
        if !arguments.summary && !review.same {
            page.write("\n")?;
            let look = page.look();
            for row in rows {
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

fn word(change: Change) -> TextWord {
    let [before, after] = change.texts;
    TextWord { address: change.address, before, after, added: change.added }
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
