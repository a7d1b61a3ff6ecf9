//! The words of a question, and the rating of a text by them.

/// Words that are in every question and find nothing.
const TOO_COMMON: &str = "a about after am an and any are as at be before but by can could did do does doing for from get go had has have how i if in into is \
                          it its me my need of off on one or our out should so than that the their them then there these they this those to up use \
                          using want was we were what when where which who why will with would you your";

/// Words that shop people use for one thing. The first three letters or more of a word are enough, as in all texts.
const SYNONYMS: &[&str] = &[
    "axis axes",
    "backlash slop play reversal",
    "ballbar qc20",
    "break broke broken snapped",
    "caliper vernier",
    "collision crash",
    "continue resume restart midprogram",
    "control controller cnc",
    "diagonal corner square squareness",
    "dnc drip feeding",
    "drift warm hot thermal temperature heat",
    "excel xlsx spreadsheet",
    "feed feedrate speed",
    "gauge gage indicator dti",
    "heidenhain tnc",
    "inch imperial",
    "interrupt abort stop halt",
    "lathe turning",
    "power outage blackout electricity",
    "program gcode job",
    "reground resharpened shorter",
    "residual unexplained",
    "router gantry",
    "sensor thermometer thermocouple",
    "sinumerik siemens 840d 828d",
    "straight straightness bow bent",
    "tool cutter endmill",
    "zero datum origin offset preset",
];

/// The weight of a word that no text has: that of a word in this number of texts.
const AS_UNKNOWN: f64 = 40.0;

/// A word in at most this number of texts is rare: it alone may find a text.
const RARE: usize = 3;

/// A word of a question.
struct Term {
    /// Its stem.
    stem: String,
    /// Stems of other words for it.
    others: Vec<String>,
    /// Importance, larger for a rare word.
    weight: f64,
    is_rare: bool,
}

/// The words of a question, without those that find nothing.
pub(super) struct Query(Vec<Term>);

/// The rating of a text.
pub(super) struct Hit {
    pub(super) score: f64,
    /// True if it has all words, or other words for them.
    pub(super) has_all: bool,
}

impl Query {
    /// The words of a question; their weights come from the number of texts that have them.
    pub(super) fn new<'t>(words: &[String], texts: impl Iterator<Item = &'t str>) -> Query {
        let meant = words.iter().flat_map(|word| word.split_whitespace()).map(letters);
        let is_common = |word: &String| word.is_empty() || TOO_COMMON.split(' ').any(|common| common == word);
        let mut terms: Vec<Term> = meant
            .filter(|word| !is_common(word))
            .map(|word| Term { others: others(&word), stem: stem(&word), weight: 0.0, is_rare: false })
            .collect();
        let texts: Vec<Vec<String>> = texts.map(words_of).collect();
        for term in &mut terms {
            let count = texts.iter().filter(|text| has(text, &term.stem)).count();
            let all = texts.iter().filter(|text| has_any(text, term)).count();
            let of = if all == 0 { AS_UNKNOWN } else { all as f64 };
            term.weight = (1.0 + texts.len() as f64 / (1.0 + of)).ln();
            term.is_rare = (1..=RARE).contains(&count);
        }
        Query(terms)
    }

    /// The rating of a text with its title; `None` if it has too few of the words.
    pub(super) fn hit(&self, title: &str, text: &str) -> Option<Hit> {
        let (title, text) = (words_of(title), words_of(text));
        let (mut score, mut weight, mut count, mut has_rare) = (0.0, 0.0, 0_usize, false);
        for term in &self.0 {
            // A word itself counts more than another word for it, and a title more than a text.
            let value = if has(&title, &term.stem) {
                3.0
            } else if has(&text, &term.stem) {
                2.0
            } else if has_any(&title, term) {
                1.5
            } else if has_any(&text, term) {
                1.0
            } else {
                continue;
            };
            score += value * term.weight;
            weight += term.weight;
            count += 1;
            has_rare |= term.is_rare && value >= 2.0;
        }
        let total: f64 = self.0.iter().map(|term| term.weight).sum();
        let is_enough = 2 * count >= self.0.len() && 2.0 * weight >= total;
        (count > 0 && (is_enough || has_rare)).then_some(Hit { score, has_all: count == self.0.len() })
    }
}

/// The letters and digits of a word in lower case: `ball-bar` is `ballbar`.
fn letters(word: &str) -> String {
    word.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The stem of a word in lower case: without the ending of a plural, a past or an -ing, without the second of two equal letters before it, and without a
/// last -e: `overwrite` is found in `overwritten`.
fn stem(word: &str) -> String {
    let cut = without_ending(word);
    cut.strip_suffix('e').filter(|short| short.chars().count() >= 4).map_or(cut.clone(), ToOwned::to_owned)
}

/// A word in lower case without its ending.
fn without_ending(word: &str) -> String {
    let cut = ["ing", "ed", "es", "s"].iter().find_map(|ending| Some((*ending, word.strip_suffix(ending)?)));
    let Some((ending, cut)) = cut.filter(|(_, cut)| cut.chars().count() >= 3) else { return word.to_owned() };
    let mut last = cut.chars().rev();
    let is_double =
        ending != "s" && matches!((last.next(), last.next()), (Some(a), Some(b)) if a == b && !"ls".contains(a));
    // The letter is as long in bytes as its equal neighbor.
    let length = cut.len() - if is_double { cut.chars().next_back().map_or(0, char::len_utf8) } else { 0 };
    cut[..length].to_owned()
}

/// Stems of other words for a word in lower case.
fn others(word: &str) -> Vec<String> {
    let own = stem(word);
    let groups = SYNONYMS.iter().map(|group| group.split(' ').map(stem).collect::<Vec<String>>());
    let mut found: Vec<String> = groups.filter(|group| group.contains(&own)).flatten().collect();
    found.retain(|other| *other != own);
    found
}

/// The words of a text in lower case, each also joined with the next one: `hold-out` and `hold out` are `holdout` too.
fn words_of(text: &str) -> Vec<String> {
    let mut words: Vec<String> = text
        .split(|letter: char| !letter.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let joined: Vec<String> = words.windows(2).map(|pair| pair.concat()).collect();
    words.extend(joined);
    words
}

/// True if a word of a text has the stem. A short stem, and that of a code such as `g154`, must be the whole word.
fn has(words: &[String], own: &str) -> bool {
    let is_code = own.chars().skip(1).all(|letter| letter.is_ascii_digit());
    if is_code || own.chars().count() <= 3 {
        words.iter().any(|word| word == own || !is_code && stem(word) == own)
    } else {
        words.iter().any(|word| word.starts_with(own))
    }
}

/// True if a text has a word or another word for it.
fn has_any(words: &[String], term: &Term) -> bool {
    has(words, &term.stem) || term.others.iter().any(|other| has(words, other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stems_of_other_forms_are_equal() {
        for (word, other) in [
            ("stopped", "stop"),
            ("touching", "touched"),
            ("planning", "plan"),
            ("overwrite", "overwrit"),
            ("drilling", "drilled"),
            ("corners", "corner"),
        ] {
            assert_eq!(stem(word), stem(other), "{word} {other}");
        }
    }

    #[test]
    fn a_short_word_is_not_the_beginning_of_another() {
        let words = words_of("the output of a Haas, G154 and G15");
        assert!(!has(&words, "out") && has(&words, &stem("haas")) && has(&words, "g154") && !has(&words, "g1"));
    }
}
