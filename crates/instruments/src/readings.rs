//! Imported readings: a table and its description, as the two files of a measurement.

use std::fmt::Write as _;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::Machine;

use crate::text::DecodedText;

/// Largest deviation of a machine tool that is believed, µm or µrad: 20 mm, 20 mrad. A reading above it has another unit.
const LARGEST: f64 = 20_000.0;

/// Smallest peak deviation that is believed, µm or µrad: it is below the noise of every instrument in a workshop, and the preview would show it as 0.0.
const SMALLEST: f64 = 0.1;

/// Peak deviation, µm or µrad, below which `diagnose` may doubt the unit of the readings.
const DOUBTED: f64 = 1.0;

/// Most readings of one file.
pub const MOST_ROWS: usize = 1_000_000;

/// Kind of a measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImportedKind {
    /// One error component at a time.
    Direct,
    /// Displacement of the tool relative to the workpiece.
    Displacement,
    /// Distance of two balls.
    BallBar,
    /// Axis positions at a ball.
    Probe,
}

impl ImportedKind {
    /// Returns the name in the description.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            ImportedKind::Direct => "direct",
            ImportedKind::Displacement => "displacement",
            ImportedKind::BallBar => "ballbar",
            ImportedKind::Probe => "probe",
        }
    }
}

/// Reading: axis positions, then the cells of its kind.
#[derive(Clone, Debug, Default)]
pub struct ImportedRow {
    /// Label of the repetition; empty without a repetition.
    pub run: String,
    /// Positions, mm and degrees, of the axes with a column.
    pub position: Vec<f64>,
    /// Direction of approach of the first axis, if the file states it.
    pub sense: Option<i8>,
    /// Error component, or target.
    pub label: String,
    /// Readings, µm and µrad; `None` for a missing one.
    pub values: Vec<Option<f64>>,
    /// Cells of [`ImportedReadings::extra`]; `None` for an empty one.
    pub extra: Vec<Option<f64>>,
    /// Line of the file.
    pub line: usize,
}

/// Table of readings and its description.
#[derive(Clone, Debug)]
pub struct ImportedReadings {
    /// Kind.
    pub kind: ImportedKind,
    /// Axes with a column, in the order of the positions.
    pub axes: Vec<Axis>,
    /// Columns of the readings.
    pub value_columns: Vec<&'static str>,
    /// Further columns of the file that a measurement has under the same name: `t_s`, `T_head_C`.
    pub extra: Vec<String>,
    /// Rows.
    pub rows: Vec<ImportedRow>,
    /// Positions of the axes without a column, mm and degrees.
    pub fixed: Vec<(Axis, f64)>,
    /// Measuring point, mm.
    pub tool_mm: [f64; 3],
    /// Unknowns of a set-up.
    pub free: Vec<&'static str>,
    /// True if the direction of the reference of a straightness is exact.
    pub is_square: bool,
    /// True if the order of the rows is that of the motion; false for a sorted export.
    pub is_in_order: bool,
    /// True if the heading of the readings states their unit, so that small ones are not doubted.
    pub is_unit_stated: bool,
    /// Standard uncertainty of a reading, µm or µrad.
    pub sigma: Option<f64>,
    /// True if the length of a calibrated bar has no uncertainty.
    pub lacks_certificate: bool,
    /// Feed, mm/min.
    pub feed: Option<f64>,
    /// Further sections of the description.
    pub sections: String,
    /// A sentence that a person can check on the machine.
    pub sign_sentence: String,
    /// Options that were given and have no effect on these readings, with their dashes.
    pub unused: Vec<String>,
    /// Facts that were understood or assumed.
    pub notes: Vec<String>,
    /// Places at which a reading is missing, each a sentence without a full stop.
    pub gaps: Vec<String>,
}

impl ImportedReadings {
    /// An empty table of a kind.
    #[must_use]
    pub fn new(kind: ImportedKind, axes: Vec<Axis>, value_columns: Vec<&'static str>) -> ImportedReadings {
        ImportedReadings {
            kind,
            axes,
            value_columns,
            extra: Vec::new(),
            rows: Vec::new(),
            fixed: Vec::new(),
            tool_mm: [0.0; 3],
            free: vec!["offset"],
            is_square: false,
            is_in_order: true,
            is_unit_stated: false,
            sigma: None,
            lacks_certificate: false,
            feed: None,
            sections: String::new(),
            sign_sentence: String::new(),
            unused: Vec::new(),
            notes: Vec::new(),
            gaps: Vec::new(),
        }
    }

    /// Remedy for positions of a measured axis beyond its travel, mm or rad.
    fn help_of_place(&self, axis: Axis, [low, high]: [f64; 2]) -> String {
        let letter = char::from(axis.letter());
        let place = self.axes.iter().position(|own| *own == axis);
        let own = self.rows.iter().filter_map(|row| row.position.get(place?).copied());
        let own = own.map(|at| if axis.is_rotary() { at.to_radians() } else { at });
        let [first, last] = own.fold([f64::MAX, f64::MIN], |[first, last], at| [first.min(at), last.max(at)]);
        if last - first > high - low {
            return format!(
                "the positions of {letter} span more than the travel: check columns and unit, and travel of {letter} in the machine file"
            );
        }
        format!(
            "positions must be machine coordinates: if the targets of the file begin at another zero, state the position of {letter} at this zero with --at {letter}…; else check columns and unit"
        )
    }

    /// Checks that positions are within the travel of the machine and that readings have a plausible size.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check(&self, machine: &Machine, text: &DecodedText) -> Result<(), Box<Diagnostic>> {
        if self.rows.is_empty() {
            return Err(Box::new(Diagnostic::nowhere(
                Code::DATA_NO_TABLE,
                "the file has no readings",
                "export the raw readings, not only the results",
            )));
        }
        if self.rows.len() > MOST_ROWS {
            let message = format!("the file has {} readings, at most {MOST_ROWS} are read", self.rows.len());
            return Err(Box::new(Diagnostic::nowhere(
                Code::IMPORT_CONTRADICTION,
                message,
                "export fewer readings, such as every tenth one",
            )));
        }
        for row in &self.rows {
            let fixed = self.fixed.iter().copied();
            for (axis, value) in self.axes.iter().copied().zip(row.position.iter().copied()).chain(fixed) {
                let Some([low, high]) = machine.axis(axis).and_then(|data| data.travel) else { continue };
                let value = if axis.is_rotary() { value.to_radians() } else { value };
                // Overtravel of ISO 230-2 and rounding of a file.
                if value < low - 1e-6 || value > high + 1e-6 {
                    let letter = char::from(axis.letter());
                    let shown_of = |value: f64| if axis.is_rotary() { shown(value.to_degrees()) } else { shown(value) };
                    let message = format!(
                        "{letter} {} is outside of the travel from {} to {}",
                        shown_of(value),
                        shown_of(low),
                        shown_of(high)
                    );
                    let help = if self.axes.contains(&axis) {
                        self.help_of_place(axis, [low, high])
                    } else {
                        format!("state {letter} of --at in machine coordinates, within the travel")
                    };
                    return Err(Box::new(Diagnostic::at(
                        Code::IMPORT_CONTRADICTION,
                        text.place(row.line),
                        message,
                        help,
                    )));
                }
            }
        }
        if self.kind == ImportedKind::Probe {
            return Ok(());
        }
        let values =
            || self.rows.iter().flat_map(|row| row.values.iter().flatten().map(move |value| (*value, row.line)));
        let peak = self.peak();
        if let Some((value, line)) = values().find(|(value, _)| value.abs() > LARGEST) {
            let message = format!("a deviation of {} µm or µrad is too large for a machine tool", shown(value));
            return Err(Box::new(Diagnostic::at(
                Code::DATA_SIZE,
                text.place(line),
                message,
                "check --unit, and that the columns are not swapped",
            )));
        }
        if peak > 0.0 && peak < SMALLEST && !self.is_unit_stated {
            let message = format!(
                "the largest deviation is {} µm or µrad, below the noise of any instrument in a workshop",
                shown(peak)
            );
            return Err(Box::new(Diagnostic::nowhere(
                Code::DATA_SIZE,
                message,
                "check the unit in the file, and --unit: small numbers are usually mm",
            )));
        }
        Ok(())
    }

    /// Returns the warning about places without a reading.
    #[must_use]
    pub fn warning(&self) -> Option<Diagnostic> {
        let (first, rest) = self.gaps.split_first()?;
        let more = if rest.is_empty() { String::new() } else { format!("; {}", rest.join("; ")) };
        let help = "export the whole file again if it was cut; if these places were not measured, the result is less certain there";
        Some(Diagnostic::nowhere(Code::IMPORT_GAP, format!("{first}{more}"), help))
    }

    /// Returns the warning about a calibrated length without its uncertainty.
    #[must_use]
    pub fn length_warning(&self) -> Option<Diagnostic> {
        let message = "the length of the bar is calibrated, and its uncertainty is not stated: the interval of a scale will lack it";
        let help = "give --length-sigma with the standard uncertainty of the certificate in µm (half of U for k = 2)";
        self.lacks_certificate.then(|| Diagnostic::nowhere(Code::NO_CERTIFICATE, message, help))
    }

    /// Largest reading without its sign, µm or µrad.
    fn peak(&self) -> f64 {
        self.rows.iter().flat_map(|row| row.values.iter().flatten()).map(|value| value.abs()).fold(0.0, f64::max)
    }

    fn has(&self, given: impl Fn(&ImportedRow) -> bool) -> bool {
        self.rows.iter().any(given)
    }

    /// Returns the table as the text of `NAME.csv`.
    #[must_use]
    pub fn table(&self) -> String {
        let (has_run, has_sense) = (self.has(|row| !row.run.is_empty()), self.has(|row| row.sense.is_some()));
        let label = match self.kind {
            ImportedKind::Direct => Some("component"),
            ImportedKind::Probe => Some("target"),
            ImportedKind::Displacement | ImportedKind::BallBar => None,
        };
        let mut heads: Vec<String> = has_run.then(|| "run".to_owned()).into_iter().collect();
        heads.push("setup".to_owned());
        heads.extend(label.map(str::to_owned));
        heads.extend(self.axes.iter().map(|axis| char::from(axis.letter()).to_string()));
        if let (true, Some(first)) = (has_sense, self.axes.first()) {
            heads.push(format!("{}_dir", char::from(first.letter())));
        }
        heads.extend(["tool_x_mm", "tool_y_mm", "tool_z_mm"].map(str::to_owned));
        heads.extend(self.feed.map(|_| "feed_mm_min".to_owned()));
        heads.extend(self.extra.iter().cloned());
        heads.extend(self.value_columns.iter().map(|&name| name.to_owned()));
        let mut out = heads.join(",") + "\n";
        for row in &self.rows {
            let mut cells: Vec<String> = has_run.then(|| safe(&row.run)).into_iter().collect();
            cells.push("A".to_owned());
            cells.extend(label.map(|_| safe(&row.label)));
            cells.extend(row.position.iter().map(|value| shown(*value)));
            if has_sense && !self.axes.is_empty() {
                cells.push(row.sense.unwrap_or(0).to_string());
            }
            cells.extend(self.tool_mm.iter().map(|value| shown(*value)));
            cells.extend(self.feed.map(shown));
            let or_empty = |value: &Option<f64>| value.map_or_else(String::new, shown);
            cells.extend(row.extra.iter().map(or_empty));
            cells.extend(row.values.iter().map(or_empty));
            out.push_str(&cells.join(","));
            out.push('\n');
        }
        out
    }

    /// True if a row reads a displacement across its axis, which increases along the axis by the angle of the reference.
    fn has_straightness(&self) -> bool {
        let is_across = |row: &ImportedRow| match *row.label.as_bytes() {
            [b'E', direction @ b'X'..=b'Z', letter] => Axis::from_letter(letter)
                .is_some_and(|axis| !axis.is_rotary() && axis.dimension() != usize::from(direction - b'X')),
            _ => false,
        };
        self.kind == ImportedKind::Direct && self.rows.iter().any(is_across)
    }

    /// Returns the description as the text of `NAME.toml`; `file` is the name of the imported file.
    #[must_use]
    pub fn description(&self, file: &str) -> String {
        let mut out = format!("# Imported from {}.\n", comment(file));
        for note in self.notes.iter().chain(&self.gaps) {
            let _ = writeln!(out, "# - {}", comment(note));
        }
        let _ = writeln!(out, "# - {}", comment(&self.sign_sentence));
        let _ = writeln!(
            out,
            "# - Compensation of the control: as it was during the measurement. Corrected programs need the same setting."
        );
        let slope = (self.has_straightness() && !self.is_square).then_some("slope");
        if slope.is_some() {
            let _ = writeln!(
                out,
                "# - Alignment of the straightness reference: unknown (slope), because a straightedge was aligned by hand. A square has --reference square."
            );
        }
        let free: Vec<String> = self.free.iter().copied().chain(slope).map(|name| format!("\"{name}\"")).collect();
        let _ = writeln!(out, "\n[measurement]\nkind = \"{}\"", self.kind.name());
        if !free.is_empty() {
            let _ = writeln!(out, "free = [{}]", free.join(", "));
        }
        if self.has_straightness() && self.is_square {
            out.push_str(
                "reference = \"square\"           # its direction is exact: the slope is an error of the machine\n",
            );
        }
        if !self.is_in_order {
            out.push_str("order = \"unknown\"              # sorted: no direction and no time follow from the order of the rows\n");
        }
        if self.is_unit_stated && self.peak() < DOUBTED {
            out.push_str("unit = \"stated\"                # the heading of the file states it, so small readings are not doubted\n");
        }
        if let Some(sigma) = self.sigma {
            let unit = if self.value_columns == ["value_urad"] { "urad" } else { "um" };
            let _ = writeln!(out, "sigma_{unit} = {sigma:?}");
        }
        if !self.fixed.is_empty() {
            out.push_str("\n[position]\n");
            for (axis, value) in &self.fixed {
                let unit = if axis.is_rotary() { "deg" } else { "mm" };
                let _ = writeln!(out, "{}_{unit} = {}", char::from(axis.letter()), shown(*value));
            }
        }
        if !self.sections.is_empty() {
            out.push('\n');
            out.push_str(&self.sections);
        }
        out
    }
}

/// Shows a number with at most six decimals.
#[must_use]
pub fn shown(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if matches!(text, "-0" | "") { "0".to_owned() } else { text.to_owned() }
}

/// A label as a cell: letters, digits and a few marks.
fn safe(text: &str) -> String {
    text.chars().filter(|c| c.is_alphanumeric() || matches!(c, '+' | '-' | '_' | '.')).take(40).collect()
}

/// A text on one line of a comment.
fn comment(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || ncfix_base::source::is_deceptive(c) { ' ' } else { c }).collect()
}
