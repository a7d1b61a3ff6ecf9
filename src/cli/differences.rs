//! Differences between an original and a corrected program, in words.

use crate::diagnostic::{Code, Diagnostic, Place};
use crate::path::{Difference, What};
use crate::snc::{FeedUnit, Origin};
use crate::source::{Source, Span};
use crate::units::{um_from_mm, urad_from_rad};

/// Differences that are kept.
pub(super) const MOST: usize = 1000;

/// A sentence for a difference, with the place in the corrected program.
pub(super) fn diagnostic(difference: &Difference, [originals, correcteds]: [&[Source]; 2]) -> Diagnostic {
    let (original, corrected) = (at(&difference.original, originals), at(&difference.corrected, correcteds));
    let again = "correct the original again; a change that is meant belongs into the original";
    let (code, message, help) = match &difference.what {
        What::Act { subject, before, after } => {
            let message = match (before, after) {
                (Some(before), Some(after)) if before == after => {
                    format!("{subject}: {before} ({original}) stands elsewhere, at {corrected}")
                }
                (Some(before), Some(after)) => format!("{subject}: {before} ({original}) became {after} ({corrected})"),
                (Some(before), None) => format!("{subject}: {before} ({original}) is missing, near {corrected}"),
                (None, after) => {
                    let after = after.as_deref().unwrap_or_default();
                    format!("{subject}: {after} ({corrected}) is new, near {original}")
                }
            };
            (Code::OTHER_ACT, message, again)
        }
        What::Off { off_mm, limit_mm } => {
            let [off, limit] = [off_mm, limit_mm].map(|mm| um_from_mm(*mm));
            let message = format!(
                "the tool is {off:.2} µm off its place at {corrected}, in the move of {original}; the correction promised {limit:.2} µm"
            );
            (Code::OFF_PROMISE, message, "correct the original again, with the same machine file and state")
        }
        What::Tilted { tilt_rad, limit_rad } => {
            let [tilt, limit] = [tilt_rad, limit_rad].map(|rad| urad_from_rad(*rad));
            let message = format!(
                "the tool is tilted by {tilt:.0} µrad at {corrected}, in the move of {original}; uncorrected it would be within {limit:.0} µrad"
            );
            (Code::OFF_PROMISE, message, "correct the original again, with the same machine file and state")
        }
        What::Feed { before, after, share } => {
            let [was, is] = [before, after].map(|(feed, unit)| shown(*feed, *unit));
            let by = if share.is_nan() { String::new() } else { format!(", {:+.1} %", 100.0 * (share - 1.0)) };
            (Code::OTHER_FEED, format!("feed: {was} ({original}) became {is} ({corrected}){by}"), again)
        }
    };
    let origin = &difference.corrected;
    let place = Place { file: origin.file, span: origin.span };
    Diagnostic::at(code, place, message, help)
}

/// `line 12 of part.mpf`.
fn at(origin: &Origin, sources: &[Source]) -> String {
    let name = sources.iter().find(|source| source.id() == origin.file).map_or("", Source::name);
    format!("line {} of {name}", origin.line)
}

fn shown(feed: f64, unit: FeedUnit) -> String {
    let unit = if unit == FeedUnit::PerMinute { String::new() } else { format!(" {}", unit.word()) };
    if feed > 0.0 { format!("F{}{unit}", (feed * 1e6).round() / 1e6) } else { format!("no F{unit}") }
}

/// A finding for every line of a corrected program that a switch of the control leaves out: ncfix writes none.
pub(super) fn skipped(corrected: &Source) -> Vec<Diagnostic> {
    let mut at = 0;
    let mut out = Vec::new();
    for (number, line) in corrected.bytes().split(|&byte| byte == corrected.line_end()).enumerate() {
        let text = line.trim_ascii_start();
        if text.starts_with(b"/") && out.len() < MOST {
            let place = Place { file: corrected.id(), span: Span::new(at, at + line.len()) };
            let name = corrected.name();
            let message = format!(
                "block skip: / (line {} of {name}) is new: a switch of the control leaves that block out",
                number + 1
            );
            let help = "take the / out; ncfix fix has decided with --skip which blocks stay";
            out.push(Diagnostic::at(Code::OTHER_ACT, place, message, help));
        }
        at += line.len() + 1;
    }
    out
}
