//! Search in the texts for people: the questions of `docs/questions.md` and the explanations of the codes.

use ncfix_base::diagnostic::{CODES, Code, CodeRow};

/// The page with questions and answers, as tables of Markdown.
const QUESTIONS: &str = include_str!("../docs/questions.md");

/// The most questions, and the most codes, that one search shows: about one screen.
const MOST: usize = 8;

/// Words that are in every question and find nothing.
const TOO_COMMON: [&str; 24] = [
    "a", "an", "and", "at", "by", "can", "do", "does", "for", "from", "how", "i", "in", "is", "it", "my", "of", "on",
    "or", "the", "to", "what", "when", "with",
];

/// The stem of a word: lower case, without the ending of a plural, a past or an -ing.
fn stem(word: &str) -> String {
    let lower: String = word.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect();
    let endings = ["ing", "ed", "es", "s"];
    let cut = endings.iter().find_map(|ending| lower.strip_suffix(ending)).filter(|cut| cut.chars().count() >= 3);
    cut.map_or(lower.clone(), ToOwned::to_owned)
}

/// The number of stems that begin a word of the text.
fn hits(stems: &[String], text: &str) -> usize {
    let words: Vec<String> = text.split(|letter: char| !letter.is_alphanumeric()).map(str::to_lowercase).collect();
    stems.iter().filter(|stem| words.iter().any(|word| word.starts_with(stem.as_str()))).count()
}

/// The rows that have all stems, best first; if no row has all, those with the most, but at least half of them.
fn best<T: Copy>(stems: &[String], rows: impl Iterator<Item = (T, usize, usize)>) -> Vec<T> {
    let mut rated: Vec<(T, usize, usize)> =
        rows.filter(|(_, all, _)| *all * 2 >= stems.len().max(1) && *all > 0).collect();
    let most = rated.iter().map(|(_, all, _)| *all).max().unwrap_or(0);
    rated.retain(|(_, all, _)| *all == most);
    rated.sort_by_key(|(_, _, title)| std::cmp::Reverse(*title));
    rated.into_iter().take(MOST).map(|(row, ..)| row).collect()
}

/// The text of Markdown as plain text: without the signs of code and bold letters, and a link as its words and its page in brackets.
fn plain(markdown: &str) -> String {
    let mut out = String::new();
    let mut rest = markdown;
    while let Some(at) = rest.find("](") {
        let Some(open) = rest[..at].rfind('[') else { break };
        let Some(length) = rest[at..].find(')') else { break };
        let target = &rest[at + 2..at + length];
        out += &rest[..open];
        out += &rest[open + 1..at];
        if !target.starts_with('#') {
            out += &format!(": docs/{target}");
        }
        rest = &rest[at + length + 1..];
    }
    out += rest;
    out.replace(['`', '*'], "").replace("\\|", "|")
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

/// The questions and answers, and the codes, that have the words; `None` if no text has them.
fn about(words: &[String]) -> Option<String> {
    let meant = words.iter().flat_map(|word| word.split_whitespace());
    let stems: Vec<String> = meant
        .filter(|word| !TOO_COMMON.contains(&word.to_lowercase().as_str()))
        .map(stem)
        .filter(|stem| !stem.is_empty())
        .collect();
    let questions = QUESTIONS.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | "));
    let questions = questions.filter(|(question, _)| question.ends_with('?')).map(|row| {
        let title = hits(&stems, row.0);
        (row, hits(&stems, &format!("{} {}", row.0, row.1)), title)
    });
    let answers = best(&stems, questions);
    let codes =
        CODES.iter().map(|row| (row, hits(&stems, &format!("{} {}", row.title, row.explain)), hits(&stems, row.title)));
    let codes: Vec<&CodeRow> = best(&stems, codes);
    let mut out = String::new();
    for (question, answer) in &answers {
        out += &format!("{}\n  {}\n\n", plain(question), plain(answer));
    }
    for row in &codes {
        out += &format!("{}  {}\n", row.code, row.title);
    }
    (!out.is_empty()).then_some(out)
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
    }

    #[test]
    fn answers_have_no_signs_of_markdown() {
        assert_eq!(
            plain("No, `E0225` ([output](reference/output.md#x), [here](#y))."),
            "No, E0225 (output: docs/reference/output.md#x, here)."
        );
    }
}
