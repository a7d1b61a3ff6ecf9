//! JSON form of diagnostics and of the results of `check` and `verify`. Keys are stable; numbers carry their unit in the key.

use serde::Serialize;

use super::excerpt::Excerpt;
use super::number::{micrometers, significant};
use ncfix_base::diagnostic::{Diagnostic, Severity};
use ncfix_base::geometry::Axis;
use ncfix_base::source::{Source, is_deceptive};

/// A diagnostic.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosticReport {
    /// Stable code, `E0203`.
    pub code: &'static str,
    /// Severity.
    pub severity: Severity,
    /// File name; `null` if the diagnostic has no place.
    pub file: Option<String>,
    /// Line from 1.
    pub line: Option<usize>,
    /// Column from 1, in characters; in a line that is not UTF-8, in bytes.
    pub column: Option<usize>,
    /// Message.
    pub message: String,
    /// Advice.
    pub help: String,
}

impl DiagnosticReport {
    /// Creates the JSON form of a diagnostic. `source` is the file of its place.
    #[must_use]
    pub fn new(diagnostic: &Diagnostic, source: Option<&Source>) -> DiagnosticReport {
        let excerpt = diagnostic.place.zip(source).map(|(place, source)| Excerpt::new(source, place));
        DiagnosticReport {
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

/// Output of `ncfix check`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProgramCheck {
    /// True if the text was parsed without an error.
    pub parsed: bool,
    /// True if it was executed, corrected and written to its end without an error. The text is discarded.
    pub executed: bool,
    /// Name of the machine for which it was executed; absent if the machine has no effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<String>,
    /// Kind of a file that is not a program: `machine data`, `definitions` …
    #[serde(skip_serializing_if = "Option::is_none")]
    pub support_file: Option<&'static str>,
    /// Elements of the flat stream (moves, dwells, tool and auxiliary words).
    pub elements: u64,
    /// Diagnostics in order of occurrence.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// A zero offset of a program and the error of the machine that it contains if it was touched.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ZeroReport {
    /// Name of the zero offset.
    pub name: String,
    /// Method by which it was set: `touched`, `probed` or `absolute`.
    pub set: &'static str,
    /// True if the method is stated; otherwise the zero counts as touched.
    pub is_stated: bool,
    /// Error of the tip that a touched zero contains, in the directions of the workpiece, µm.
    pub contains_um: [f64; 3],
    /// Its size, µm.
    pub distance_um: f64,
    /// Rotary axes of the workpiece that have a zero of their own, with the error of the angle there, µrad. Their zeros count as true angles.
    #[serde(skip)]
    pub turned_urad: Vec<(Axis, f64)>,
}

/// Errors of angles below this are not named, µrad.
const LEAST_TURN_URAD: f64 = 0.5;

impl ZeroReport {
    /// Returns the error that the zero offset contains if it was touched, in words.
    #[must_use]
    pub fn contents(&self) -> String {
        let parts = components_um(self.contains_um);
        let turned = self.turned();
        match (parts.is_empty(), self.set == "absolute") {
            (true, false) if !turned.is_empty() => {
                format!("a zero touched off here has no error of X, Y and Z{turned}")
            }
            (true, _) => "a zero touched off here has no geometric error".to_owned(),
            (false, false) if !turned.is_empty() => {
                format!("a touched-off zero contains the machine error {}{turned}", parts.join(", "))
            }
            (false, false) => format!("a touched-off zero contains the machine error {}", parts.join(", ")),
            (false, true) => {
                format!("if it had been touched off, it would contain the machine error {}", parts.join(", "))
            }
        }
    }

    /// The rotary axes whose zeros count as true angles, in words; empty without any.
    fn turned(&self) -> String {
        let felt = self.turned_urad.iter().filter(|(_, urad)| urad.abs() >= LEAST_TURN_URAD);
        let parts: Vec<String> = felt.map(|(axis, urad)| format!("{axis} {} µrad", significant(*urad))).collect();
        if parts.is_empty() {
            return String::new();
        }
        format!(
            "; its rotary zero counts as a true angle, and would contain {} if it was set on this machine",
            parts.join(", ")
        )
    }

    /// Returns these words for the line of a zero offset, after its method: in parentheses if they state only a possibility.
    #[must_use]
    pub fn contents_in_line(&self) -> String {
        let is_possibility = self.set == "absolute" && !components_um(self.contains_um).is_empty();
        if is_possibility { format!(" ({})", self.contents()) } else { format!("; {}", self.contents()) }
    }
}

/// Returns the components of a displacement in words, `X -33.0 µm`, without those that round to 0.
#[must_use]
pub fn components_um(displacement_um: [f64; 3]) -> Vec<String> {
    let parts = ["X", "Y", "Z"].iter().zip(displacement_um).filter(|(_, um)| um.abs() >= 0.05);
    parts.map(|(axis, um)| format!("{axis} {}{}", if um < 0.0 { "-" } else { "" }, micrometers(um.abs()))).collect()
}

/// Mean, root mean square and maximum of a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpreadReport {
    /// Mean, µm.
    pub mean_um: f64,
    /// Root mean square, µm.
    pub rms_um: f64,
    /// Maximum, µm.
    pub max_um: f64,
}

/// Residual of one error source after a correction: the largest over poses of the program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RemainingReport {
    /// Error source.
    pub source: &'static str,
    /// Displacement of the tip, as its correction is less than an increment, µm.
    pub position_um: f64,
    /// Tilt of the tool axis, µrad.
    pub tilt_urad: f64,
    /// Rotation about the tool axis, µrad.
    pub roll_urad: f64,
}

/// Deviation of the tool from its path at feed, predicted from `[servo]` and `[[dynamic]]`: over the control cycles of feed moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Contouring {
    /// Root mean square, µm.
    pub rms_um: f64,
    /// Maximum, µm.
    pub max_um: f64,
}

/// Result of `ncfix fix --feed-limit`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeedLimit {
    /// Limit, µm.
    pub limit_um: f64,
    /// Deviation with the feeds of the program.
    pub contouring_before: Contouring,
    /// Deviation with the feeds that were written.
    pub contouring_after: Contouring,
    /// Time on the machine with the feeds of the program, without tool changes, s.
    pub time_before_s: f64,
    /// Time on the machine with the feeds that were written, without tool changes, s.
    pub time_after_s: f64,
    /// Pieces with a lower feed.
    pub slowed: u64,
    /// Pieces that still exceed the limit.
    pub exceeding: u64,
}

/// Behavior of a program at feed, predicted from `[servo]` and `[[dynamic]]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct AtFeed {
    /// Deviation of the tool from the path of the program.
    #[serde(flatten)]
    pub contouring: Contouring,
    /// File of the largest deviation.
    pub file: Option<String>,
    /// Line of the largest deviation.
    pub line: Option<u32>,
    /// Time on the machine, without tool changes, s.
    pub time_s: f64,
}

/// Output of `ncfix verify`: distance of the tool tip from the nominal path of the original, on the error model.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VerificationReport {
    /// Verdict on running the corrected program; `null` if the programs were not compared.
    pub verdict: Option<super::verdict::Verdict>,
    /// Coverage by the measured ranges of the machine; `null` if the programs were not compared.
    pub coverage: Option<super::coverage::CoverageReport>,
    /// Intervals of the true errors; `null` if the programs were not compared or the machine file has no errors.
    pub prediction: Option<super::prediction::PredictionReport>,
    /// Errors of the original program.
    pub before: Option<SpreadReport>,
    /// Errors of the original program, beyond the constant displacement that a touched zero offset takes up.
    pub before_form: Option<SpreadReport>,
    /// Zero offsets in which axes move.
    pub zeros: Vec<ZeroReport>,
    /// Errors of the corrected program.
    pub after: Option<SpreadReport>,
    /// Number of points at which both were evaluated.
    pub samples: u64,
    /// Behavior of the original at feed, with `--at-feed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub original_at_feed: Option<AtFeed>,
    /// Behavior of the corrected program at feed, with `--at-feed`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corrected_at_feed: Option<AtFeed>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

/// Returns a value as one line of JSON, with its line feed.
///
/// # Errors
/// None for the types of this crate, whose keys are all texts; a sentence if that should ever change.
pub fn line(value: &impl Serialize) -> Result<String, String> {
    let text = serde_json::to_string(value).map_err(|error| error.to_string())?;
    // JSON does not require escapes for these, but a terminal would obey them. They occur only in texts.
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
        let check = ProgramCheck {
            parsed: true,
            executed: false,
            machine: None,
            support_file: None,
            elements: 1,
            diagnostics: vec![DiagnosticReport::new(&found, Some(&source))],
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
        let found = DiagnosticReport::new(&Diagnostic::nowhere(Code::NO_MACHINE, "m", "h"), None);
        assert_eq!((found.severity, found.file, found.line, found.column), (Severity::Warning, None, None, None));
    }
}
