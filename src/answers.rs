//! Search in the texts for people: the questions of `docs/questions.md`, the titles of the how-to pages, the sections of all pages, the G and M codes, and
//! the explanations of the diagnostic codes.

mod pages;
mod plain;
mod query;

use ncfix_base::diagnostic::{CODES, Code};

use plain::plain;
use query::{Hit, Query};

/// The page with questions and answers, as tables of Markdown.
const QUESTIONS: &str = include_str!("../docs/questions.md");

/// The table of contents, with the titles of all pages.
const CONTENTS: &str = include_str!("../docs/SUMMARY.md");

/// The most texts of one kind that a search shows if they have all words: about one screen.
const MOST: usize = 8;

/// The most texts of one kind that a search shows if none has all words.
const MOST_IN_PART: usize = 5;

/// The most sections of pages after answers that have all words, and before answers that have only some of them.
const MOST_SECTIONS: usize = 3;
const MOST_FIRST_SECTIONS: usize = 2;

/// The name of each language with its table of G and M codes (code, group, effect, words and meaning, separated by tabs), and the codes whose holes stay
/// cycles in the output.
const TABLES: [(&str, &str, &str); 4] = [
    ("Sinumerik", include_str!("../grammars/sinumerik-codes.tsv"), ""),
    (
        "Fanuc and Haas",
        include_str!("../grammars/fanuc-codes.tsv"),
        "G73 G74 G76 G81 G82 G83 G84 G84.2 G84.3 G85 G86 G89",
    ),
    ("RS274/NGC", include_str!("../grammars/rs274-codes.tsv"), "G73 G74 G81 G82 G83 G84 G85 G86 G89"),
    ("Grundig", include_str!("../grammars/grundig-codes.tsv"), "G81 G83 G85 G86"),
];

/// A text that a search can find.
struct Entry {
    /// Text as it is printed.
    shown: String,
    /// Its title: words here count more.
    title: String,
    /// All of its words, with the title.
    text: String,
}

/// The texts of codes, or what the texts say about words; without a word, the list of codes. `None` if no text has the words.
pub(crate) fn to(words: &[String]) -> Option<String> {
    if words.is_empty() {
        let mut list: Vec<String> = CODES.iter().map(|row| format!("{}  {}\n", row.code, row.title)).collect();
        list.sort();
        return Some(list.concat());
    }
    let codes = words.iter().flat_map(|word| Code::meant(word));
    let texts: Vec<String> = codes.map(|row| format!("{}: {}\n\n{}\n", row.code, row.title, row.explain)).collect();
    if !texts.is_empty() {
        return Some(texts.join("\n"));
    }
    let is_code = |word: &String| word.starts_with(['E', 'W', 'e', 'w']) && word[1..].parse::<u16>().is_ok();
    if words.iter().any(is_code) { None } else { about(words) }
}

/// The questions with their answers, the how-to pages, the G and M codes and the diagnostic codes that have the words; `None` if no text has them.
fn about(words: &[String]) -> Option<String> {
    let (answers, codes) = (answers(), codes());
    let query = Query::new(words, answers.iter().chain(&codes).map(|entry| entry.text.as_str()));
    let named = nc_codes(words);
    let found = best(&query, &answers);
    let most = if found.has_all { MOST_SECTIONS } else { MOST_FIRST_SECTIONS };
    let sections = query.best_sections(&pages::sections(), most);
    // The page of an answer is not named again.
    let is_new = |shown: &&String| {
        shown.lines().next().is_some_and(|title| !found.shown.iter().any(|own| own.starts_with(title)))
    };
    // Those before the answers: a page about these very words, or all if no answer has all words.
    let first = if found.has_all { usize::from(sections.is_its_heading) } else { most };
    let first = first.min(sections.shown.len());
    let mut out: String = sections.shown[..first].iter().filter(is_new).cloned().collect();
    out += &found.shown.concat();
    out.extend(sections.shown[first..].iter().filter(is_new).cloned());
    out += &named;
    let found_codes = best(&query, &codes);
    // Codes that have only some of the words say less than an answer.
    if found_codes.has_all || out.is_empty() {
        out += &found_codes.shown.concat();
    }
    (!out.is_empty()).then_some(out)
}

/// The questions with their answers, and the how-to pages.
fn answers() -> Vec<Entry> {
    let rows = QUESTIONS.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | "));
    let questions = rows.filter(|(question, _)| *question != "question").map(|(question, answer)| Entry {
        shown: format!("{}\n  {}\n\n", plain(question), plain(answer)),
        title: question.to_owned(),
        text: format!("{question} {answer}"),
    });
    let pages = CONTENTS.lines().filter_map(|line| line.trim_start().strip_prefix("- [")?.split_once("](how-to/"));
    let pages = pages.map(|(title, page)| Entry {
        shown: format!("{title}\n  See the page (docs/how-to/{}).\n\n", page.trim_end_matches(')')),
        title: title.to_owned(),
        // The name of a page often has another word for its subject.
        text: format!("{title} {page}"),
    });
    questions.chain(pages).collect()
}

/// The diagnostic codes.
fn codes() -> Vec<Entry> {
    let entry = |row: &ncfix_base::diagnostic::CodeRow| Entry {
        shown: format!("{}  {}\n", row.code, row.title),
        title: row.title.to_owned(),
        text: format!("{} {}", row.title, row.explain),
    };
    CODES.iter().map(entry).collect()
}

/// Texts that a search shows.
struct Found {
    shown: Vec<String>,
    /// True if they have all words.
    has_all: bool,
}

/// The texts that have all words, best first; if none has all, the best of those that have enough of them.
fn best(query: &Query, entries: &[Entry]) -> Found {
    let mut rated: Vec<(Hit, &Entry)> =
        entries.iter().filter_map(|entry| Some((query.hit(&entry.title, &entry.text)?, entry))).collect();
    let has_all = rated.iter().any(|(hit, _)| hit.has_all);
    let highest = rated.iter().map(|(hit, _)| hit.score).fold(0.0, f64::max);
    // Of partial hits, only those that come near the best one.
    rated.retain(|(hit, _)| if has_all { hit.has_all } else { hit.score * 1.5 >= highest });
    rated.sort_by(|(a, _), (b, _)| b.score.total_cmp(&a.score));
    let most = if has_all { MOST } else { MOST_IN_PART };
    Found { shown: rated.into_iter().take(most).map(|(_, entry)| entry.shown.clone()).collect(), has_all }
}

/// A line for each G or M code, or word in capital letters, that a table has: its meaning, by language.
fn nc_codes(words: &[String]) -> String {
    let mut out = String::new();
    let asked = words.iter().flat_map(|word| word.split_whitespace());
    for word in asked.filter(|word| word.bytes().any(|byte| byte.is_ascii_digit()) || **word == word.to_uppercase()) {
        for (language, table, kept) in TABLES {
            let rows = table.lines().filter(|line| !line.starts_with('#'));
            let row = rows.map(|line| line.split('\t').collect::<Vec<&str>>()).find(|row| is_named(word, row[0]));
            if let Some([name, _, effect, _, meaning]) = row.as_deref() {
                // The meaning states what another control of the same language does.
                let other = if meaning.contains("executed with") { "otherwise " } else { "" };
                let is_kept = kept.split(' ').any(|cycle| cycle == *name);
                let effect = if is_kept { "executed, each hole stays a cycle" } else { effect_of(effect) };
                out += &format!("{name}  {language}: {meaning}; {other}{effect} (docs/reference/codes.md)\n");
            }
        }
    }
    if out.is_empty() { out } else { out + "\n" }
}

/// The effect of a code of a table on the output, for people.
fn effect_of(word: &str) -> &'static str {
    match word {
        "refuse" => "refused",
        "keep" => "stays in the output",
        "display" => "not in the output",
        _ => "executed",
    }
}

/// True if a word is a code of a table, or within a range such as `G600..G699`; leading zeros do not matter.
fn is_named(word: &str, name: &str) -> bool {
    let split = |text: &str| {
        let letters = text.len() - text.trim_start_matches(|letter: char| letter.is_ascii_alphabetic()).len();
        Some((text[..letters].to_ascii_uppercase(), text[letters..].parse::<f64>().ok()?))
    };
    match (split(word), name.split_once("..")) {
        (Some((letters, number)), Some((first, last))) => {
            let ends = split(first).zip(split(last));
            ends.is_some_and(|(first, last)| letters == first.0 && (first.1..=last.1).contains(&number))
        }
        (Some(own), None) => split(name).map_or_else(|| word.eq_ignore_ascii_case(name), |other| own == other),
        (None, _) => word.eq_ignore_ascii_case(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(words: &str) -> String {
        about(&[words.to_owned()]).unwrap_or_default()
    }

    #[test]
    fn a_question_is_found_by_its_words_in_other_forms() {
        let text = asked("touching off the zero");
        assert!(text.contains("How do I state that the zero was touched?"), "{text}");
        assert!(asked("overwrite program").starts_with("Is my program overwritten?"), "{}", asked("overwrite program"));
    }

    #[test]
    fn codes_are_found_by_a_word_of_their_title_before_one_of_their_text() {
        let text = asked("thread");
        let codes: Vec<&str> = text.lines().filter(|line| line.starts_with(['E', 'W'])).collect();
        assert!(!codes.is_empty(), "{text}");
    }

    #[test]
    fn words_that_stand_nowhere_find_nothing() {
        assert!(about(&["zyxwv".to_owned()]).is_none());
        assert!(about(&["the".to_owned()]).is_none());
        // A common word beside an unknown one finds no unrelated answers.
        assert!(about(&["zyxwv program".to_owned()]).is_none(), "{}", asked("zyxwv program"));
    }

    #[test]
    fn hyphens_and_spaces_do_not_matter() {
        let first = asked("ball-bar");
        assert!(first.contains("docs/how-to/ball-bar-to-corrected-part.md"), "{first}");
        for other in ["ballbar", "ball bar"] {
            assert!(asked(other).contains("docs/how-to/ball-bar-to-corrected-part.md"), "{other}: {}", asked(other));
        }
        assert!(asked("hold-out").contains("--hold-out"), "{}", asked("hold-out"));
        assert!(asked("holdout").contains("--hold-out"), "{}", asked("holdout"));
    }

    #[test]
    fn a_code_of_a_control_is_named_with_its_language() {
        let text = asked("G154");
        assert!(text.contains("G154  Fanuc and Haas: additional work coordinate system"), "{text}");
        let text = asked("G83");
        assert!(
            text.contains("G83  Fanuc and Haas: deep-hole drilling; executed, each hole stays a cycle ("),
            "{text}"
        );
        let text = asked("G88");
        assert!(text.contains("G88  Fanuc and Haas: boring, out by hand; executed ("), "{text}");
        // A range, and leading zeros.
        assert!(is_named("g04", "G4") && is_named("G650", "G600..G699") && !is_named("G700", "G600..G699"));
        assert!(is_named("G54.1", "G54.1") && !is_named("G54", "G54.1") && is_named("compcad", "COMPCAD"));
    }

    #[test]
    fn a_partial_hit_needs_half_of_the_words_or_a_rare_one() {
        let text = asked("zyxwv lathe");
        assert!(text.contains("`E0225`"), "{text}");
        assert!(text.matches('?').count() <= MOST_IN_PART, "{text}");
        assert!(about(&["zyxwv yxwvz xwvzy tool".to_owned()]).is_none());
    }
}
