//! Verdict on running a corrected program, with reasons: one line for each.

use std::collections::BTreeSet;

use serde::Serialize;

use super::correction::{MOST_FORM, NO_ZERO, push_row};
use super::json::DiagnosticReport;
use super::number::{counted, grouped, micrometers, probability};
use super::prediction::{NOT_KNOWN, PredictionReport};
use super::review::Review;
use ncfix_base::diagnostic::{Code, Severity};
use ncfix_base::source::shown;

/// Growth of the largest error, µm, up to which a person decides: the default tolerance of a correction, with 5 % for the path between the checked positions,
/// and a quarter of the largest rounding error, as for `E0320`; or an increment where there was no error.
const MOST_GROWTH_UM: f64 = 1.05;

/// Grade of a verdict or reason; a larger one is worse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// No objection.
    #[default]
    Ok,
    /// A person should look at it.
    Warn,
    /// It should not run.
    Bad,
}

/// Reason for a verdict.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Reason {
    /// Grade of the reason.
    pub grade: Grade,
    /// Description.
    pub text: String,
    /// Code of the diagnostic, if the reason is one.
    pub code: Option<&'static str>,
    /// True if it states an assumption, which is neither for nor against running the program.
    #[serde(skip)]
    pub is_neutral: bool,
}

/// Verdict on running a program.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verdict {
    /// Worst grade of the reasons.
    pub grade: Grade,
    /// True if the machine file states the measured ranges and the program stays within them.
    pub is_covered: bool,
    /// True if the uncertainty of the machine file is known and the correction improves the program within it.
    pub is_certain: bool,
    /// Reasons, the worst first.
    pub reasons: Vec<Reason>,
}

impl Grade {
    /// Returns its name, as in pages and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Grade::Ok => "ok",
            Grade::Warn => "warn",
            Grade::Bad => "bad",
        }
    }
}

impl Reason {
    /// Returns the name of its mark on a page: that of its grade, or `note`.
    #[must_use]
    pub fn mark(&self) -> &'static str {
        if self.is_neutral { "note" } else { self.grade.name() }
    }

    /// True if it is a gap in the measured ranges.
    fn is_gap(&self) -> bool {
        self.code.and_then(Code::find).is_some_and(|row| row.code.is_coverage())
    }
}

impl Verdict {
    /// Returns the verdict on a comparison that is otherwise complete.
    #[must_use]
    pub fn of(review: &Review) -> Verdict {
        let mut reasons = Vec::new();
        let mut neutral: Vec<String> = Vec::new();
        let mut say = |grade, text: String| reasons.push(Reason { grade, text, code: None, is_neutral: false });
        if review.same {
            say(Grade::Warn, "nothing was changed".into());
        }
        for limit in &review.limits {
            let grade = if limit.is_kept { Grade::Ok } else { Grade::Bad };
            let [value, most] = [limit.value_um, limit.limit_um].map(micrometers);
            let than = if limit.is_kept { "within" } else { "more than" };
            say(grade, format!("{} is {value}, {than} the {most} allowed", limit.name));
        }
        for (axis, beyond) in &review.beyond_travel {
            let count = grouped(beyond.pieces);
            let text = format!(
                "{count} pieces end beyond the travel of {axis}, the first in line {} of the corrected program",
                beyond.line
            );
            say(Grade::Bad, text);
        }
        if let (Some(before), Some(after)) = (review.before, review.after) {
            let [from, to] = [before.max_um, after.max_um].map(micrometers);
            let grows = after.max_um > before.max_um && after.rms_um > before.rms_um;
            // A program in inches has larger increments than most tolerances.
            let most_um = (MOST_GROWTH_UM + 0.25 * review.rounding_um).max(review.rounding_um);
            let (grade, verb) = match (after.max_um - before.max_um > most_um, grows) {
                (true, true) => (Grade::Bad, "increases"),
                // The mean improves, but a place becomes worse; or the growth is that of rounding or of the tolerance.
                (true, false) | (false, true) => (Grade::Warn, "increases"),
                (false, false) => (Grade::Ok, "changes"),
            };
            say(grade, format!("the largest error on the error model {verb} from {from} to {to}"));
        }
        if let (Some(before), Some(form)) = (review.before, review.before_form)
            && form.mean_um < MOST_FORM * before.mean_um
        {
            let [whole, own] = [before.mean_um, form.mean_um].map(micrometers);
            neutral.push(format!(
                "of the mean error of {whole}, {own} is form error; the rest is a constant offset, which a touched-off zero removes"
            ));
        }
        if review.zeros.is_empty() && review.before.is_some_and(|before| before.max_um > 0.0) {
            neutral.push(format!("zero: {NO_ZERO}"));
        }
        for zero in review.zeros.iter().filter(|zero| zero.is_stated) {
            neutral.push(format!("{} counts as {}{}", zero.name, zero.set, zero.contents_in_line()));
        }
        for (why, is_harmless) in LEFT {
            if let Some(count) = review.left.get(why).filter(|_| !is_harmless) {
                say(Grade::Warn, format!("unchanged: {} {}", counted(*count, "move"), left_in_words(why)));
            }
        }
        if review.other_feeds > 0 {
            let by = review.feed_share.map(|[least, most]| {
                let percent = |share: f64| format!("{:+.1} %", 100.0 * (share - 1.0));
                format!(", by {} to {}", percent(least), percent(most))
            });
            say(
                Grade::Warn,
                format!("{} with a different feed{}", counted(review.other_feeds, "piece"), by.unwrap_or_default()),
            );
        }
        let coverage = review.coverage.as_ref();
        let is_covered = coverage.is_some_and(|coverage| coverage.is_complete);
        if coverage.is_some_and(|coverage| !coverage.is_stated) {
            let text = "the machine file does not state the measured ranges: the errors are assumed to hold at all positions of the program";
            neutral.push(text.into());
        } else if is_covered {
            say(Grade::Ok, "all positions are within the measured ranges".into());
        }
        let prediction = review.prediction.as_ref();
        let is_certain = prediction.is_some_and(PredictionReport::is_certain);
        match prediction.map(|prediction| (prediction.largest().is_some(), of_prediction(prediction))) {
            Some((true, (grade, text))) => say(grade, text),
            Some((false, (_, text))) => neutral.push(text),
            None => {}
        }
        reasons.extend(neutral.into_iter().map(|text| Reason { text, is_neutral: true, ..Reason::default() }));
        let of_finding = |finding: &DiagnosticReport| {
            let text = format!("{} {}", finding.code, finding.message);
            Reason { grade: grade_of(finding), text, code: Some(finding.code), is_neutral: false }
        };
        reasons.extend(review.diagnostics.iter().map(of_finding));
        // Among equals, gaps of the coverage come first: they limit every number that follows.
        reasons.sort_by_key(|reason| (std::cmp::Reverse(reason.grade), !reason.is_gap()));
        Verdict {
            grade: reasons.iter().map(|reason| reason.grade).max().unwrap_or_default(),
            is_covered,
            is_certain,
            reasons,
        }
    }

    /// Returns the objections to running it: gaps of the coverage, and those that are not diagnostics, which are shown separately.
    pub fn doubts(&self) -> impl Iterator<Item = &str> {
        let is_shown = |reason: &Reason| reason.code.is_none() || reason.is_gap();
        let against = self.reasons.iter().filter(move |reason| reason.grade > Grade::Ok && is_shown(reason));
        against.map(|reason| reason.text.as_str())
    }

    /// Returns the doubts, and the errors that the comparison of a review has found: a correction does not print them with their places.
    pub fn doubts_and_errors(&self) -> impl Iterator<Item = &str> {
        let is_shown = |reason: &Reason| reason.code.is_none() || reason.is_gap() || reason.grade == Grade::Bad;
        let against = self.reasons.iter().filter(move |reason| reason.grade > Grade::Ok && is_shown(reason));
        against.map(|reason| reason.text.as_str())
    }

    /// Returns its rows for a terminal. Diagnostics are shown separately.
    #[must_use]
    pub fn rows(&self) -> String {
        let mut out = String::new();
        push_row(&mut out, "verdict", self.sentence());
        for text in self.doubts() {
            push_row(&mut out, "", text);
        }
        // A diagnostic is printed with its place; here its code is enough.
        let is_against = |reason: &&Reason| reason.grade > Grade::Ok && !reason.is_gap();
        let codes: BTreeSet<&str> = self.reasons.iter().filter(is_against).filter_map(|reason| reason.code).collect();
        if !codes.is_empty() {
            push_row(&mut out, "", &format!("see {}", Vec::from_iter(codes).join(", ")));
        }
        out
    }

    /// True if nothing is against running the program, and measurements with a known uncertainty support that.
    #[must_use]
    pub fn is_supported(&self) -> bool {
        self.grade == Grade::Ok && self.is_covered && self.is_certain
    }

    /// Returns it as one sentence.
    #[must_use]
    pub fn sentence(&self) -> &'static str {
        match self.grade {
            Grade::Ok => match (self.is_covered, self.is_certain) {
                (true, true) => "nothing found against running it",
                (true, false) => "nothing found against running it; uncertainty not known",
                (false, true) => "nothing found against running it; measured ranges not stated",
                (false, false) => "nothing found against running it; measured ranges and uncertainty not stated",
            },
            Grade::Warn => "check it before it runs",
            Grade::Bad => "should not run",
        }
    }
}

/// Returns the reason that the interval of a correction gives. Without a known uncertainty it is a statement, like that about ranges that are not stated.
fn of_prediction(prediction: &PredictionReport) -> (Grade, String) {
    let Some(largest) = prediction.largest() else {
        return (
            Grade::Ok,
            format!("{NOT_KNOWN}: the errors are those of the model, and those of the machine may differ"),
        );
    };
    if prediction.is_harmful() {
        return (Grade::Bad, format!("the correction makes the error larger, with 95 % confidence: {largest}"));
    }
    if let Some(share) = prediction.improves.filter(|share| *share < 1.0) {
        let text = format!(
            "by the uncertainty of the machine file, the correction may make the largest or the RMS error larger ({}); the largest error is {largest} (95 %)",
            probability(1.0 - share)
        );
        return (Grade::Warn, text);
    }
    match prediction.names() {
        Some(names) => (
            Grade::Ok,
            format!("the uncertainty of {names} is not known; without it the largest error is {largest} (95 %)"),
        ),
        None => (Grade::Ok, format!("the largest error of the machine is {largest} (95 %)")),
    }
}

/// Prepares the text of a report for a terminal: control characters of programs are replaced, and the verdict is colored as diagnostics are, errors red and
/// warnings yellow.
#[must_use]
pub fn colored(text: &str) -> String {
    let good = [(true, true), (true, false), (false, true), (false, false)];
    let good = good.map(|(is_covered, is_certain)| Verdict { is_covered, is_certain, ..Verdict::default() });
    let others = [Grade::Warn, Grade::Bad].map(|grade| Verdict { grade, ..Verdict::default() });
    good.iter().chain(&others).fold(shown(text), |text, verdict| {
        let (grade, sentence) = (verdict.grade, verdict.sentence());
        let color = match grade {
            Grade::Ok => "\x1b[1;32m",
            Grade::Warn => "\x1b[1;33m",
            Grade::Bad => "\x1b[1;91m",
        };
        let [mut plain, mut bright] = [String::new(), String::new()];
        push_row(&mut plain, "verdict", sentence);
        push_row(&mut bright, "verdict", &format!("{color}{sentence}\x1b[0m"));
        text.replacen(&plain, &bright, 1)
    })
}

/// Reasons why moves stay unchanged, as text, for keys that differ from their text.
#[must_use]
pub fn left_in_words(key: &str) -> &str {
    LEFT_IN_WORDS.iter().find(|(own, _)| *own == key).map_or(key, |(_, words)| words)
}

/// Keys with another text for people.
const LEFT_IN_WORDS: [(&str, &str); 2] = [
    ("without an error of an increment", "with an error smaller than one increment"),
    ("before the axes were stated", "before the program states the axis positions"),
];

/// Reasons why moves stay unchanged, as keys; true if that is intended.
pub const LEFT: [(&str, bool); 4] =
    [(LEFT_IN_WORDS[0].0, true), (LEFT_IN_WORDS[1].0, false), ("rapid", true), ("that are not corrected", false)];

fn grade_of(finding: &DiagnosticReport) -> Grade {
    if finding.severity == Severity::Error { Grade::Bad } else { Grade::Warn }
}

#[cfg(test)]
mod tests {
    use super::super::json::SpreadReport;
    use super::super::review::Limit;
    use super::*;

    #[test]
    fn a_verdict_is_colored_by_its_grade() {
        let rows = |grade| Verdict { grade, ..Verdict::default() }.rows();
        let all = [Grade::Ok, Grade::Warn, Grade::Bad].map(|grade| colored(&rows(grade)));
        let codes = ["\x1b[1;32m", "\x1b[1;33m", "\x1b[1;91m"];
        assert!(all.iter().zip(codes).all(|(row, code)| row.contains(code) && row.ends_with("\x1b[0m\n")), "{all:?}");
        assert_eq!(colored("verdict\n"), "verdict\n");
    }

    #[test]
    fn the_worst_reason_decides_and_comes_first() {
        let spread = |max_um: f64| SpreadReport { mean_um: max_um / 2.0, rms_um: max_um / 2.0, max_um };
        let mut review = Review { before: Some(spread(40.0)), after: Some(spread(1.0)), ..Review::default() };
        let verdict = Verdict::of(&review);
        // The reduction, and that no zero offset is in force.
        assert_eq!((verdict.grade, verdict.reasons.len()), (Grade::Ok, 2));
        review.left.insert("before the axes were stated", 3);
        review.left.insert("rapid", 3);
        assert_eq!(Verdict::of(&review).grade, Grade::Warn);
        let limit = |value_um: f64| Limit { name: "it".into(), value_um, limit_um: 10.0, is_kept: value_um <= 10.0 };
        review.limits = vec![limit(9.0), limit(11.0)];
        let verdict = Verdict::of(&review);
        let grades: Vec<Grade> = verdict.reasons.iter().map(|reason| reason.grade).collect();
        assert_eq!(grades, [Grade::Bad, Grade::Warn, Grade::Ok, Grade::Ok, Grade::Ok]);
        assert!(verdict.reasons[0].text.contains("more than the 10.0 µm"), "{verdict:?}");
        // Growth by no more than the tolerance of a correction is for a person to judge.
        review.after = Some(spread(41.0));
        assert_eq!(Verdict::of(&review).reasons.iter().filter(|one| one.grade == Grade::Bad).count(), 1);
        review.after = Some(spread(41.1));
        assert_eq!(Verdict::of(&review).reasons.iter().filter(|one| one.grade == Grade::Bad).count(), 2);
        // 0.0001 inch rounds by up to half of 2.54 µm in each direction.
        review.rounding_um = 0.5 * 3.0_f64.sqrt() * 2.54;
        assert_eq!(Verdict::of(&review).reasons.iter().filter(|one| one.grade == Grade::Bad).count(), 1);
        review.after = Some(spread(42.3));
        assert_eq!(Verdict::of(&review).reasons.iter().filter(|one| one.grade == Grade::Bad).count(), 2);
    }
}
