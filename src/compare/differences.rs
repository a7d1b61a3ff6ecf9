//! Differences between an original and a corrected program, in words.

use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{Source, Span};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::snc::{FeedUnit, Origin};
use ncfix_path::path::{ProgramDifference, What};

/// Maximum number of reported differences.
pub(crate) const MOST: usize = 1000;

/// Message for a difference, with its position in the corrected program.
pub(crate) fn diagnostic(difference: &ProgramDifference, [originals, correcteds]: [&[Source]; 2]) -> Diagnostic {
    let (original, corrected) = (at(&difference.original, originals), at(&difference.corrected, correcteds));
    let again = "correct the original again; make an intended change in the original";
    let (code, message, help) = match &difference.what {
        What::Act { subject, before, after } => {
            let message = match (before, after) {
                (Some(before), Some(after)) if before == after => {
                    format!("{subject}: {before} ({original}) has moved to {corrected}")
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
                "the tool tip is {off:.2} µm off its position at {corrected}, in the move of {original}; tolerance and rounding allow {limit:.2} µm"
            );
            let help = "correct the original again, with the same machine file and state; if fix reported W0305, with a larger --tolerance";
            (Code::OFF_PROMISE, message, help)
        }
        What::Tilted { tilt_rad, limit_rad } => {
            let [tilt, limit] = [tilt_rad, limit_rad].map(|rad| urad_from_rad(*rad));
            let message = format!(
                "the tool is tilted by {tilt:.0} µrad at {corrected}, in the move of {original}; uncorrected it would be within {limit:.0} µrad"
            );
            (Code::OFF_PROMISE, message, "correct the original again, with the same machine file and state")
        }
        What::Detour { off_mm, limit_mm } => {
            let message = format!(
                "{corrected} is {off_mm:.1} mm off the path of the move of {original}; a correction would be at most {limit_mm:.2} mm"
            );
            (Code::OFF_PROMISE, message, "a rapid move may hit the workpiece there; correct the original again")
        }
        What::Turned { axis, beyond_rad } => {
            let message = format!(
                "{corrected} turns {axis} {:.1}° beyond both ends of the move of {original}",
                beyond_rad.to_degrees()
            );
            (Code::OFF_PROMISE, message, "the tool may hit the workpiece there; correct the original again")
        }
        What::Feed { before, after, share } => {
            let [was, is] = [before, after].map(|(feed, unit)| shown(*feed, *unit));
            let by = if share.is_nan() { String::new() } else { format!(", {:+.1} %", 100.0 * (share - 1.0)) };
            let message = if before == after && share.is_finite() && *share > 0.0 {
                // The words agree, but the length of the move or the way in which the feed counts does not.
                let more = 100.0 / share - 100.0;
                let (by, how) = (more.abs(), if more > 0.0 { "longer" } else { "shorter" });
                format!(
                    "feed: both moves have {was}, but that of {corrected} takes {by:.1} % {how} than that of {original}"
                )
            } else {
                format!("feed: {was} ({original}) became {is} ({corrected}){by}")
            };
            (Code::OTHER_FEED, message, again)
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

/// The line with its text: `line 12 of part.mpf, "G1 X20",`.
pub(crate) fn line(origin: &Origin, source: Option<&Source>) -> String {
    let Some(source) = source else { return format!("line {}", origin.line) };
    let text = String::from_utf8_lossy(source.slice(origin.span)).trim().to_owned();
    format!("line {} of {}, \"{text}\",", origin.line, source.name())
}

/// Message for a word that a program must state before its first move, because another one may be in force from the
/// previous program.
pub(crate) fn unstated(word: &str, corrected: &Source) -> Diagnostic {
    let name = corrected.name();
    let message = format!(
        "start of the program: {word} is missing before the first move of {name}; the control keeps the setting of the previous program"
    );
    Diagnostic::nowhere(
        Code::OTHER_ACT,
        message,
        "correct the original again; a corrected program states how to read its numbers",
    )
}

/// Variables that keep no value: a guard ends the program with this alarm of a Fanuc.
const ALARM: [&str; 1] = ["#3000"];

/// Diagnostics for variables that a corrected program writes: ncfix writes none, and the control may keep their
/// values after the end.
pub(crate) fn assigned(corrected: &Source) -> Vec<Diagnostic> {
    let mut at = 0;
    let mut out = Vec::new();
    for (number, line) in corrected.bytes().split(|&byte| byte == corrected.line_end()).enumerate() {
        let is_new = |name: &String| !ALARM.contains(&name.as_str()) && !is_of_control(name) && out.len() < MOST;
        if let Some(name) = assigned_in(line).filter(is_new) {
            let place = Place { file: corrected.id(), span: Span::new(at, at + line.len()) };
            let message = format!(
                "variable: {name} (line {} of {}) is new: it is assigned a value",
                number + 1,
                corrected.name()
            );
            out.push(Diagnostic::at(
                Code::OTHER_ACT,
                place,
                message,
                "remove the line; a corrected program has only numbers",
            ));
        }
        at += line.len() + 1;
    }
    out
}

/// True for data of the control, such as `#5221`. The output assigns them as the program does, and a difference is one of the acts.
fn is_of_control(name: &str) -> bool {
    const FIRST: u32 = 1000;
    name.strip_prefix('#').and_then(|number| number.parse::<u32>().ok()).is_some_and(|number| number >= FIRST)
}

/// The variable to which a line assigns a value: `R1` of `R1=5`, `R[1]=`, `#500=`, `#<_x>=`, `E1=`.
fn assigned_in(line: &[u8]) -> Option<String> {
    let mut at = 0;
    while at < line.len() {
        match line[at] {
            b';' => return None,
            b'(' => at += line[at..].iter().position(|&byte| byte == b')').unwrap_or(line.len()),
            b'"' => at += 1 + line[at + 1..].iter().position(|&byte| byte == b'"').unwrap_or(line.len()),
            b'#' | b'R' | b'r' | b'E' | b'e'
                if at == 0 || !line[at - 1].is_ascii_alphanumeric() && line[at - 1] != b'_' =>
            {
                let rest = &line[at + 1..];
                let length = match rest.first() {
                    Some(b'[') => rest.iter().position(|&byte| byte == b']').map_or(0, |end| end + 1),
                    Some(b'<') if line[at] == b'#' => {
                        rest.iter().position(|&byte| byte == b'>').map_or(0, |end| end + 1)
                    }
                    _ => rest.iter().take_while(|byte| byte.is_ascii_digit()).count(),
                };
                if length > 0 && rest[length..].trim_ascii_start().first() == Some(&b'=') {
                    return Some(String::from_utf8_lossy(&line[at..=at + length]).into_owned());
                }
            }
            _ => {}
        }
        at += 1;
    }
    None
}

fn shown(feed: f64, unit: FeedUnit) -> String {
    let unit = if unit == FeedUnit::PerMinute { String::new() } else { format!(" {}", unit.word()) };
    if feed > 0.0 { format!("F{}{unit}", (feed * 1e6).round() / 1e6) } else { format!("no F{unit}") }
}

/// Diagnostics for lines of a corrected program that a skip switch of the control skips: ncfix never writes such
/// lines.
pub(crate) fn skipped(corrected: &Source) -> Vec<Diagnostic> {
    let mut at = 0;
    let mut out = Vec::new();
    for (number, line) in corrected.bytes().split(|&byte| byte == corrected.line_end()).enumerate() {
        let text = line.trim_ascii_start();
        if text.starts_with(b"/") && out.len() < MOST {
            let place = Place { file: corrected.id(), span: Span::new(at, at + line.len()) };
            let name = corrected.name();
            let message = format!(
                "block skip: / (line {} of {name}) is new: a switch of the control skips that block",
                number + 1
            );
            let help = "remove the /; --skip of ncfix fix has decided which blocks remain";
            out.push(Diagnostic::at(Code::OTHER_ACT, place, message, help));
        }
        at += line.len() + 1;
    }
    out
}
