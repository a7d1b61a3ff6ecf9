//! The pages of the documents, by section.

use super::plain::plain;

/// The text of each page that is named.
macro_rules! pages {
    ($($page:literal,)*) => {
        &[$(($page, include_str!(concat!("../../docs/", $page)))),*]
    };
}

/// Pages of the documents, with their texts. The pages of the commands repeat `--help`, and the questions are answers of their own.
const PAGES: &[(&str, &str)] = pages![
    "tutorial.md",
    "how-to/sinumerik-from-start-to-finish.md",
    "how-to/fanuc-from-start-to-finish.md",
    "how-to/haas-from-start-to-finish.md",
    "how-to/plan-a-squareness.md",
    "how-to/ball-bar-to-corrected-part.md",
    "how-to/laser-to-control-tables.md",
    "how-to/describe-a-new-machine.md",
    "how-to/describe-a-five-axis-machine.md",
    "how-to/calibrate-a-five-axis-machine.md",
    "how-to/set-the-zero.md",
    "how-to/cam-five-axis-program.md",
    "how-to/correct-for-the-weight.md",
    "how-to/lower-feeds.md",
    "how-to/drip-feed-with-a-temperature-sensor.md",
    "how-to/state-a-new-error-term.md",
    "how-to/find-what-the-model-lacks.md",
    "how-to/hobby-router-out-of-square.md",
    "how-to/review-and-release.md",
    "how-to/refused-program.md",
    "how-to/import-an-instruments-file.md",
    "how-to/use-a-cmm-report.md",
    "how-to/test-workpiece.md",
    "how-to/correct-readings.md",
    "how-to/fit-the-control.md",
    "how-to/restart.md",
    "how-to/use-the-library.md",
    "how-to/extending.md",
    "reference/command-line.md",
    "reference/machine-file.md",
    "reference/motion.md",
    "reference/load.md",
    "reference/temperature.md",
    "reference/servo.md",
    "reference/settings.md",
    "reference/languages.md",
    "reference/sinumerik.md",
    "reference/iso.md",
    "reference/grundig.md",
    "reference/codes.md",
    "reference/states.md",
    "reference/output.md",
    "reference/snc.md",
    "reference/review.md",
    "reference/data-files.md",
    "reference/instrument-files.md",
    "reference/plan.md",
    "reference/figures.md",
    "reference/calibrate.md",
    "reference/diagnose.md",
    "reference/terms.md",
    "reference/decompose.md",
    "reference/tables.md",
    "reference/table-formats.md",
    "reference/feed.md",
    "reference/sensors.md",
    "reference/realtime.md",
    "reference/limits.md",
    "reference/words.md",
    "reference/seeds.md",
    "explanation/how-it-works.md",
    "explanation/theory.md",
    "explanation/calibration.md",
    "explanation/diagnosis.md",
    "explanation/not-corrected.md",
    "explanation/comparison.md",
    "explanation/speed.md",
    "explanation/fuzzing.md",
];

/// The longest first sentence that is printed, letters: two lines of a terminal.
const MOST_LETTERS: usize = 160;

/// A section of a page.
pub(super) struct PageSection {
    /// Text as it is printed: its titles, its first sentence, its place.
    pub(super) shown: String,
    /// Its heading: for the beginning of a page, the title of the page.
    pub(super) heading: String,
    /// The title of its page.
    pub(super) page: String,
    /// All of its text, without the titles.
    pub(super) text: String,
}

/// All sections of all pages, in the order of the table of contents.
pub(super) fn sections() -> Vec<PageSection> {
    PAGES.iter().flat_map(|(page, text)| of_page(page, text)).collect()
}

/// The sections of one page. A page without a heading has none.
fn of_page(page: &str, text: &str) -> Vec<PageSection> {
    let mut parts: Vec<(&str, String)> = Vec::new();
    let mut is_code = false;
    for line in text.lines() {
        is_code ^= line.starts_with("```");
        let heading = (line.starts_with('#') && !is_code).then(|| line.trim_start_matches('#').trim());
        match (heading, parts.last_mut()) {
            (Some(heading), _) => parts.push((heading, String::new())),
            (None, Some((_, body))) => {
                body.push_str(line);
                body.push('\n');
            }
            (None, None) => {}
        }
    }
    let of = parts.first().map_or("", |(title, _)| title).to_owned();
    let section = |(heading, body): (&str, String)| {
        let (title, place) = if heading == of {
            (of.clone(), format!("docs/{page}"))
        } else {
            (format!("{of}: {heading}"), format!("docs/{page}#{}", anchor(heading)))
        };
        let shown = format!("{}\n  {}({place})\n\n", plain(&title), first_sentence(&body));
        PageSection { shown, heading: heading.to_owned(), page: of.clone(), text: body }
    };
    parts.into_iter().map(section).collect()
}

/// The first sentence of the first paragraph, with a space after it; nothing if the text begins with a table, a list or code, or if it is long.
fn first_sentence(body: &str) -> String {
    let first = body.lines().find(|line| !line.is_empty()).unwrap_or_default();
    if first.starts_with(['|', '`', '-', '>', '<', '!', '*', '1']) {
        return String::new();
    }
    let text = plain(first.split_inclusive(". ").next().unwrap_or_default().trim_end());
    if text.ends_with(['.', ')']) && text.chars().count() <= MOST_LETTERS { text + " " } else { String::new() }
}

/// The name of a heading in a link: letters, digits and hyphens.
fn anchor(heading: &str) -> String {
    let letters = heading.chars().filter(|letter| letter.is_alphanumeric() || matches!(letter, ' ' | '-' | '_'));
    letters.map(|letter| if letter == ' ' { '-' } else { letter }).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_pages_of_the_table_of_contents_are_searched() {
        let links = crate::answers::CONTENTS.split("](").skip(1).filter_map(|link| link.split_once(')'));
        let is_text = |page: &&str| !page.starts_with("commands/") && !["index.md", "questions.md"].contains(page);
        let listed: Vec<&str> = links.map(|(page, _)| page).filter(is_text).collect();
        assert_eq!(PAGES.iter().map(|(page, _)| *page).collect::<Vec<&str>>(), listed);
    }

    #[test]
    fn a_page_is_cut_at_its_headings_but_not_within_code() {
        let text = "# Page\n\nFirst one. Second one.\n\n```sh\n# a comment\n```\n\n## Part of it: 2 `x`\n\n| a |\n";
        let found: Vec<String> = of_page("a/b.md", text).into_iter().map(|section| section.shown).collect();
        let wanted =
            ["Page\n  First one. (docs/a/b.md)\n\n", "Page: Part of it: 2 `x`\n  (docs/a/b.md#part-of-it-2-x)\n\n"];
        assert_eq!(found, wanted);
    }
}
