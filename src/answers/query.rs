//! The words of a question, and the rating of a text by them.

use super::pages::PageSection;

/// Words that are in every question and find nothing.
const TOO_COMMON: &str = "a about after am an and any are as at be before but by can could did do does doing for from get go had has have how i if in into is \
                          it its me my need of off on one or our out should so than that the their them then there these they this those to up use \
                          using want was we were what when where which who why will with would you your";

/// Words that shop people use for one thing. The first three letters or more of a word are enough, as in all texts.
const SYNONYMS: &[&str] = &[
    "axis axes",
    "backlash slop play reversal",
    "ballbar qc20",
    "bed mesh heightmap",
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
    "sensor thermometer thermocouple thermistor",
    "sinumerik siemens 840d 828d",
    "straight straightness bow bent",
    "tool cutter endmill",
    "zero datum origin offset preset",
];

/// The weight of a word that no text has: that of a word in this number of texts.
const AS_UNKNOWN: f64 = 40.0;

/// A word in at most this number of texts is rare: it alone may find a text.
const RARE: usize = 3;

/// Constants of the rating of long texts, BM25 with the values that its authors recommend (Robertson and Zaragoza 2009, *The Probabilistic Relevance
/// Framework*): saturation of repeats, and influence of the length.
const SATURATION: f64 = 1.2;
const LENGTH_SHARE: f64 = 0.75;

/// The value of a word in the heading of a section, in words of its text.
const TITLE: f64 = 3.0;

/// The value of another word for a word.
const OTHER: f64 = 0.5;

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

impl Query {
    /// The sections that have all words, as they are printed, the best first. If none has, and the question has three words or more, one may be missing.
    pub(super) fn best_sections(&self, sections: &[PageSection], most: usize) -> BestSections {
        if self.0.is_empty() {
            return BestSections::default();
        }
        let parts = |section: &PageSection| [&section.heading, &section.page, &section.text].map(|text| words_of(text));
        let words: Vec<[Vec<String>; 3]> = sections.iter().map(parts).collect();
        let mean = words.iter().map(|[_, _, text]| text.len() as f64).sum::<f64>() / words.len().max(1) as f64;
        let counts: Vec<Vec<f64>> =
            words.iter().map(|own| self.0.iter().map(|term| count(own, term)).collect()).collect();
        let rarity = |at: usize| {
            let having = counts.iter().filter(|own| own[at] > 0.0).count() as f64;
            (1.0 + (counts.len() as f64 - having + 0.5) / (having + 0.5)).ln()
        };
        let rarities: Vec<f64> = (0..self.0.len()).map(rarity).collect();
        let missing: Vec<usize> = counts.iter().map(|own| own.iter().filter(|count| **count == 0.0).count()).collect();
        let least = missing.iter().copied().min().unwrap_or_default();
        if least > usize::from(self.0.len() > 2) {
            return BestSections::default();
        }
        let mut rated: Vec<(f64, &PageSection)> = Vec::new();
        for (at, section) in sections.iter().enumerate().filter(|(at, _)| missing[*at] == least) {
            let [_, _, text] = &words[at];
            let length = 1.0 - LENGTH_SHARE + LENGTH_SHARE * text.len() as f64 / mean;
            let of =
                |(count, rarity): (&f64, &f64)| rarity * count * (1.0 + SATURATION) / (count + SATURATION * length);
            rated.push((counts[at].iter().zip(&rarities).map(of).sum(), section));
        }
        rated.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let is_heading = |section: &PageSection| {
            let heading = words_of(&section.heading);
            self.0.iter().all(|term| has(&heading, &term.stem))
        };
        let is_its_heading = rated.first().is_some_and(|(_, section)| is_heading(section));
        BestSections {
            shown: rated.into_iter().take(most).map(|(_, section)| section.shown.clone()).collect(),
            is_its_heading,
        }
    }
}

/// Sections that have the words of a question.
#[derive(Default)]
pub(super) struct BestSections {
    /// As they are printed, the best first.
    pub(super) shown: Vec<String>,
    /// True if the heading of the first one has all words.
    pub(super) is_its_heading: bool,
}

/// The number of times that a heading, the title of its page and its text have a word. Another word for it counts less, a heading more.
fn count([heading, page, text]: &[Vec<String>; 3], term: &Term) -> f64 {
    let own = |words: &[String], stem: &str| words.iter().filter(|word| is(word, stem)).count() as f64;
    let of = |stem: &str| own(text, stem) + own(page, stem) + TITLE * own(heading, stem);
    of(&term.stem) + OTHER * term.others.iter().map(|other| of(other)).sum::<f64>()
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
    words.iter().any(|word| is(word, own))
}

/// True if a word in lower case has the stem.
fn is(word: &str, own: &str) -> bool {
    let is_code = own.chars().skip(1).all(|letter| letter.is_ascii_digit());
    if is_code || own.chars().count() <= 3 {
        word == own || !is_code && stem(word) == own
    } else {
        word.starts_with(own)
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
