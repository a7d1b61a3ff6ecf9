//! The shape of findings and of `check` and `verify` results in `--json`. Keys are stable; numbers carry their unit in the key.

use serde::Serialize;

use super::excerpt::Excerpt;
use ncfix_base::diagnostic::{Diagnostic, Severity};
use ncfix_base::source::{Source, is_deceptive};

/// A finding.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// Stable code, `E0203`.
    pub code: &'static str,
    /// How much it weighs.
    pub severity: Severity,
    /// Name of the file, `null` where a finding has no place.
    pub file: Option<String>,
    /// Line from 1.
    pub line: Option<usize>,
    /// Column from 1, in characters; in a line that is no UTF-8, in bytes.
    pub column: Option<usize>,
    /// What was found.
    pub message: String,
    /// What to do.
    pub help: String,
}

impl Finding {
    /// A finding with the file of its place.
    #[must_use]
    pub fn new(diagnostic: &Diagnostic, source: Option<&Source>) -> Finding {
        let excerpt = diagnostic.place.zip(source).map(|(place, source)| Excerpt::new(source, place));
        Finding {
            code: diagnostic.code.as_str(),
            severity: diagnostic.severity(),
            file: diagnostic.place.and(source).map(|source| source.name().to_owned()),
            line: excerpt.as_ref().map(|excerpt| excerpt.line),
            column: excerpt.as_ref().map(|excerpt| excerpt.column),
            message: diagnostic.message.clone(),
            help: diagnostic.help.clone(),
        }
    }
}

/// What `ncfix check` found.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Check {
    /// Whether the text was understood without an error.
    pub parsed: bool,
    /// Whether it was executed to its end without an error.
    pub executed: bool,
    /// What the file is where it is no program: `machine data`, `definitions` …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support_file: Option<&'static str>,
    /// Elements of the flat stream (moves, dwells, tool and auxiliary words).
    pub elements: u64,
    /// Findings in the order in which they were met.
    pub diagnostics: Vec<Finding>,
}

/// Mean, root mean square and maximum of a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Spread {
    /// Mean, µm.
    pub mean_um: f64,
    /// Root of the mean square, µm.
    pub rms_um: f64,
    /// Maximum, µm.
    pub max_um: f64,
}

/// What a correction leaves of one source of error: the largest over poses of the program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Remaining {
    /// The source.
    pub source: &'static str,
    /// Of the tip, because its correction is less than an increment, µm.
    pub position_um: f64,
    /// Of the direction of the tool axis, µrad.
    pub tilt_urad: f64,
    /// About the tool axis, µrad.
    pub roll_urad: f64,
}

/// How far the axes leave the tool off its path at feed, as `[servo]` and `[[dynamic]]` predict it: by cycles of the control, of moves with feed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Contouring {
    /// Root of the mean square, µm.
    pub rms_um: f64,
    /// Maximum, µm.
    pub max_um: f64,
}

/// What `ncfix fix --feed-limit` did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeedLimit {
    /// The limit, µm.
    pub limit_um: f64,
    /// With the feeds of the program.
    pub contouring_before: Contouring,
    /// With the feeds that were written.
    pub contouring_after: Contouring,
    /// Time on the machine with the feeds of the program, without tool changes, s.
    pub time_before_s: f64,
    /// The same with the feeds that were written.
    pub time_after_s: f64,
    /// Pieces with a lower feed.
    pub slowed: u64,
    /// Pieces that exceed the limit all the same.
    pub exceeding: u64,
}

/// What the axes make of a program at feed, as `[servo]` and `[[dynamic]]` predict it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AtFeed {
    /// How far the tool is off the path of the program.
    #[serde(flatten)]
    pub contouring: Contouring,
    /// File of the largest distance.
    pub file: Option<String>,
    /// Line of the largest distance.
    pub line: Option<u32>,
    /// Time on the machine, without tool changes, s.
    pub time_s: f64,
}

/// What `ncfix verify` measured on the error model: distance of the tool tip from the nominal path of the original.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Verification {
    /// Whether the corrected program should run; nothing where they were not compared.
    pub verdict: Option<super::verdict::Verdict>,
    /// Of the original program.
    pub before: Option<Spread>,
    /// Of the corrected program.
    pub after: Option<Spread>,
    /// Points at which both were evaluated.
    pub samples: u64,
    /// What the axes make of the original at feed, with `--at-feed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub original_at_feed: Option<AtFeed>,
    /// The same of the corrected program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected_at_feed: Option<AtFeed>,
    /// Findings.
    pub diagnostics: Vec<Finding>,
}

/// A value as one line of JSON, with its line feed.
///
/// # Errors
/// None for the types of this room, whose keys are all texts; the reason in words if that should ever change.
pub fn line(value: &impl Serialize) -> Result<String, String> {
    let text = serde_json::to_string(value).map_err(|error| error.to_string())?;
    // JSON needs no escape for these, but a terminal would obey them. They stand in texts only.
    let mut line = String::with_capacity(text.len() + 1);
    for character in text.chars() {
        if is_deceptive(character) {
            line.push_str(&format!("\\u{:04x}", u32::from(character)));
        } else {
            line.push(character);
        }
    }
    line.push('\n');
    Ok(line)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::diagnostic::{Code, Place};
    use ncfix_base::source::{FileId, Span};

    #[test]
    fn a_finding_has_the_documented_keys() {
        let source = Source::new(FileId(0), "a.mpf", b"N1 G0\nN2 Q\n".to_vec()).unwrap();
        let place = Place { file: FileId(0), span: Span::new(9, 10) };
        let found = Diagnostic::at(Code::NOT_SUPPORTED, place, "Q is not supported yet", "remove it");
        let check = Check {
            parsed: true,
            executed: false,
            support_file: None,
            elements: 1,
            diagnostics: vec![Finding::new(&found, Some(&source))],
        };
        assert_eq!(
            line(&check).unwrap(),
            concat!(
                r#"{"parsed":true,"executed":false,"elements":1,"diagnostics":[{"code":"E0201","severity":"error","#,
                r#""file":"a.mpf","line":2,"column":4,"message":"Q is not supported yet","help":"remove it"}]}"#,
                "\n"
            )
        );
    }

    #[test]
    fn a_finding_without_place_has_nulls() {
        let found = Finding::new(&Diagnostic::nowhere(Code::NO_MACHINE, "m", "h"), None);
        assert_eq!((found.severity, found.file, found.line, found.column), (Severity::Warning, None, None, None));
    }
}
