//! The words of the project: text that a person reads holds none of the words of `tests/plain_english/replacements.tsv` beyond those that stand there already, and
//! documents get no more long sentences.
//!
//! `tests/plain_english/present.tsv` counts what stands there by room, `tests/plain_english/long_sentences.tsv` by document. Both only shrink: `NCFIX_WRITE_DOCS=1` writes
//! smaller numbers, never larger ones.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use regex::bytes::{Captures, Regex, RegexBuilder};

use crate::support::repository;

/// Words of a sentence that reads well: plain-language guides set their limit there (GOV.UK content design, "Sentence length").
const MOST_WORDS: usize = 25;

/// Comments, strings and raw strings of Rust, in the order in which they stand.
static PIECES: LazyLock<Regex> = LazyLock::new(|| {
    ascii(r##"(?s)//[^\n]*|r#"(?:.*?)"#|b?"(?:[^"\\]|\\.)*"|'(?:[\x80-\xff]{2,4}|[^'\\\n]|\\[^\n]{1,8}?)'"##)
});

/// Code, links and marks of a document.
static MARKS: LazyLock<Regex> = LazyLock::new(|| ascii(r"(?s)```.*?```|`[^`\n]*`|\]\([^)]*\)|<[^>\n]*>|[*_\[\]|#]"));

static SENTENCE_END: LazyLock<Regex> = LazyLock::new(|| ascii(r"[.!?](?:\s+|$)|\n\s*\n|\x01"));

/// A pattern of bytes, whatever the case: the words are ASCII.
fn ascii(pattern: &str) -> Regex {
    RegexBuilder::new(pattern).unicode(false).case_insensitive(true).build().unwrap()
}

/// One row of the list.
struct Replacement {
    pattern: String,
    regex: Regex,
    is_opening: bool,
    instead: String,
}

fn replacements() -> Vec<Replacement> {
    let text = fs::read_to_string(repository("tests/plain_english/replacements.tsv")).unwrap();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('\t').collect();
        let [pattern, place, instead] = cells[..] else { panic!("three cells: {line}") };
        let is_opening = match place {
            "opening" => true,
            "all" => false,
            _ => panic!("{place}: all or opening"),
        };
        let whole = if is_opening { format!("^(?:{pattern})") } else { format!(r"\b(?:{pattern})") };
        let regex = RegexBuilder::new(&whole).unicode(false).case_insensitive(!is_opening).build().unwrap();
        Replacement { pattern: pattern.to_owned(), regex, is_opening, instead: instead.to_owned() }
    };
    text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()).map(row).collect()
}

/// All files below a folder with one of these endings, in a steady order.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for entry in entries {
        if entry.is_dir() {
            files(&entry, ending, found);
        } else if entry.extension().is_some_and(|own| own == ending) {
            found.push(entry);
        }
    }
}

/// Name of a file from the top of the repository, with `/`.
fn name_of(file: &Path) -> String {
    let name = file.strip_prefix(repository("")).unwrap_or(file);
    name.to_string_lossy().replace('\\', "/")
}

/// A piece of text that a person reads, and its line.
struct Passage {
    line: usize,
    text: String,
    /// Whether a sentence may open here.
    is_start: bool,
}

/// Comments and strings of a Rust file. Lines of one comment are one passage, so that a word at their border counts.
fn passages_of_rust(text: &str) -> Vec<Passage> {
    let mut found: Vec<Passage> = Vec::new();
    let mut last_comment = 0;
    for piece in PIECES.find_iter(text.as_bytes()) {
        let line = 1 + text[..piece.start()].matches('\n').count();
        let own = &text[piece.range()];
        if let Some(comment) = own.strip_prefix("//") {
            let is_document = comment.starts_with(['/', '!']);
            let comment = comment.trim_start_matches(['/', '!']).trim();
            if last_comment > 0 && line == last_comment + 1 && !comment.is_empty() {
                if let Some(last) = found.last_mut() {
                    last.text.push(' ');
                    last.text.push_str(comment);
                }
            } else {
                found.push(Passage { line, text: comment.to_owned(), is_start: is_document });
            }
            last_comment = line;
        } else if !own.starts_with('\'') {
            found.push(Passage { line, text: own.trim_matches(['b', 'r', '#', '"']).to_owned(), is_start: false });
            last_comment = 0;
        }
    }
    found
}

/// Sentences of a document, without code, tables and headings' marks.
fn passages_of_document(text: &str) -> Vec<Passage> {
    let blank = |found: &Captures<'_>| {
        let lines = found[0].iter().filter(|byte| **byte == b'\n').count();
        if lines > 0 {
            vec![b'\n'; lines]
        } else if found[0].starts_with(b"`") {
            b"code".to_vec()
        } else {
            Vec::new()
        }
    };
    // A table is no sentence, and an item of a list begins one.
    let row = |line: &str| match line.trim_start().as_bytes() {
        [b'|', ..] => "\n".to_owned(),
        [b'-' | b'*', b' ', ..] | [b'0'..=b'9', b'.', ..] => format!("\x01{line}\n"),
        _ => format!("{line}\n"),
    };
    let rows: String = text.lines().map(row).collect();
    let plain = MARKS.replace_all(rows.as_bytes(), blank);
    let plain = String::from_utf8_lossy(&plain);
    let mut found = Vec::new();
    let mut start = 0;
    let ends = SENTENCE_END.find_iter(plain.as_bytes()).map(|end| end.end()).chain([plain.len()]);
    for end in ends {
        let sentence = &plain[start..end];
        let text = sentence.replace('\x01', " ").split_whitespace().collect::<Vec<_>>().join(" ");
        if !text.is_empty() {
            let blank = sentence.len() - sentence.trim_start().len();
            let line = 1 + plain[..start + blank].matches('\n').count();
            found.push(Passage { line, text: text.trim_start_matches(['-', ' ']).to_owned(), is_start: true });
        }
        start = end;
    }
    found
}

/// All that a person reads, by file.
fn everything() -> Vec<(String, Vec<Passage>)> {
    let mut found = Vec::new();
    for (folder, ending) in [("src", "rs"), ("crates", "rs"), ("tests", "rs"), ("examples", "rs"), ("benches", "rs")] {
        let mut all = Vec::new();
        files(&repository(folder), ending, &mut all);
        found.extend(all.iter().map(|file| (name_of(file), passages_of_rust(&fs::read_to_string(file).unwrap()))));
    }
    found.extend(documents().into_iter().map(|(name, text)| (name, passages_of_document(&text))));
    found
}

/// The documents: those of the top, and all of `docs`, without what is written from the code.
fn documents() -> Vec<(String, String)> {
    let mut all = Vec::new();
    files(&repository("docs"), "md", &mut all);
    let top = fs::read_dir(repository("")).unwrap().map(|entry| entry.unwrap().path());
    all.extend(top.filter(|path| path.extension().is_some_and(|own| own == "md")));
    let mut named: Vec<(String, String)> =
        all.iter().map(|file| (name_of(file), fs::read_to_string(file).unwrap())).collect();
    named.retain(|(name, _)| !name.starts_with("docs/commands/"));
    named.sort();
    named
}

/// The room of a file: a crate, or the first folder.
fn room(name: &str) -> String {
    let mut parts = name.split('/');
    match (parts.next(), parts.next()) {
        (Some("crates"), Some(member)) => format!("crates/{member}"),
        (Some(top), Some(_)) => top.to_owned(),
        _ => "documents of the top".to_owned(),
    }
}

/// Compares counts with a table that only shrinks, and writes it where that is asked for.
fn only_shrinks(file: &str, head: &str, counts: &BTreeMap<String, usize>, say: impl Fn(&str) -> String) {
    let path = repository(file);
    let text = fs::read_to_string(&path).unwrap_or_default();
    let mut allowed: BTreeMap<String, usize> = BTreeMap::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, count) = line.rsplit_once('\t').unwrap();
        allowed.insert(name.to_owned(), count.parse().unwrap());
    }
    let more: Vec<String> = counts
        .iter()
        .filter(|(name, count)| **count > allowed.get(*name).copied().unwrap_or(0))
        .map(|(name, count)| {
            format!("{name}: {count}, at most {}\n{}", allowed.get(name).copied().unwrap_or(0), say(name))
        })
        .collect();
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() && (more.is_empty() || text.is_empty()) {
        let mut rows = format!("# {head}\n");
        for (name, count) in counts.iter().filter(|(_, count)| **count > 0) {
            writeln!(rows, "{name}\t{count}").unwrap();
        }
        fs::write(&path, rows).unwrap();
        return;
    }
    assert!(more.is_empty(), "{}", more.join("\n"));
    // A number that is larger than the count would let new ones in.
    let less: Vec<&String> = allowed
        .iter()
        .filter(|(name, most)| counts.get(*name).copied().unwrap_or(0) < **most)
        .map(|(name, _)| name)
        .collect();
    assert!(
        less.is_empty(),
        "fewer stand there now than {file} says: run this test with NCFIX_WRITE_DOCS=1\n{less:#?}"
    );
}

#[test]
fn new_text_has_none_of_the_words_that_readers_stumble_over() {
    let list = replacements();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (name, passages) in everything() {
        if name == "tests/plain_english.rs" {
            continue;
        }
        for passage in &passages {
            for one in list.iter().filter(|one| passage.is_start || !one.is_opening) {
                for hit in one.regex.find_iter(passage.text.as_bytes()) {
                    let key = format!("{}\t{}", room(&name), one.pattern);
                    *counts.entry(key.clone()).or_default() += 1;
                    let place =
                        format!("  {name}:{}: \"{}\": write {}", passage.line, &passage.text[hit.range()], one.instead);
                    places.entry(key).or_default().push(place);
                }
            }
        }
    }
    let head = "Words of replacements.tsv that stand in a room, and how often. No number grows.";
    only_shrinks("tests/plain_english/present.tsv", head, &counts, |key| places[key].join("\n"));
}

#[test]
#[expect(clippy::print_stdout, reason = "the report is for whoever asks for it")]
fn documents_get_no_more_long_sentences() {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut report = String::new();
    for (name, text) in documents() {
        let passages = passages_of_document(&text);
        let words =
            |passage: &Passage| passage.text.split(' ').filter(|word| word.contains(char::is_alphanumeric)).count();
        let long: Vec<&Passage> = passages.iter().filter(|passage| words(passage) > MOST_WORDS).collect();
        let all: usize = passages.iter().map(words).sum();
        let mean = all as f64 / passages.len().max(1) as f64;
        writeln!(report, "{name}: {} sentences, {mean:.1} words, {} over {MOST_WORDS}", passages.len(), long.len())
            .unwrap();
        places.insert(
            name.clone(),
            long.iter().map(|one| format!("  {name}:{}: {} words: {}", one.line, words(one), one.text)).collect(),
        );
        counts.insert(name, long.len());
    }
    // `cargo test --test ncfix -- plain_english:: --nocapture` shows it.
    println!("{report}");
    let head = "Sentences of more than 25 words in a document. No number grows, and a new document has none.";
    only_shrinks("tests/plain_english/long_sentences.tsv", head, &counts, |name| places[name].join("\n"));
}

#[test]
fn a_word_is_found_in_a_comment_a_string_and_a_document() {
    let text = "/// The same with more.\n/// Goes on\n/// so\n/// many times.\nfn f() { let a = \"sensor of temperature\"; let b = 'x'; } // what is left\n";
    let found: Vec<(usize, String)> = passages_of_rust(text).into_iter().map(|one| (one.line, one.text)).collect();
    assert_eq!(found[0], (1, "The same with more. Goes on so many times.".to_owned()));
    assert_eq!(found[1], (5, "sensor of temperature".to_owned()));
    assert_eq!(found[2], (5, "what is left".to_owned()));
    let hits = |text: &str, is_start: bool| {
        let list = replacements();
        let found = list.iter().filter(|one| (is_start || !one.is_opening) && one.regex.is_match(text.as_bytes()));
        found.count()
    };
    assert_eq!(hits("The same with more. Goes on so many times.", true), 2);
    assert_eq!(hits("The same with more.", false), 0);
    assert_eq!(hits("a sensor of temperature", false), 1);
    assert_eq!(hits("the temperature sensor of the head", true), 0);
    let document = passages_of_document(
        "# Head\n\nOne `code` here. And\ntwo: three.\n\n| a | b |\n```sh\nnot this\n```\n- item\n",
    );
    let lines: Vec<(usize, &str)> = document.iter().map(|one| (one.line, one.text.as_str())).collect();
    assert_eq!(lines, [(1, "Head"), (3, "One code here."), (3, "And two: three."), (10, "item")]);
}
