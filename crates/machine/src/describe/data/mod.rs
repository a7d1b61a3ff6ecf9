//! Data of a control from which a machine is described: one reader for each format, found by the content of the file.

mod grbl;
mod linuxcnc;
mod note;
mod reset_words;
mod sinumerik;

use std::collections::BTreeMap;

use crate::describe::known::{Known, KnownOrigin};
use crate::describe::stated::TravelRange;
use crate::machine::{Branch, Topology};
use ncfix_base::diagnostic::character::wide_encoding;
use ncfix_base::geometry::Axis;

pub use note::{DataNote, DataNoteKind};

/// Data of one axis, as far as a file states them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisFacts {
    /// Travel, mm or degrees.
    pub travel: Option<Known<TravelRange>>,
    /// Maximum feed, mm/min or degrees/min.
    pub max_feed: Option<Known<f64>>,
    /// Axis of rotation in F, with its sense.
    pub direction: Option<Known<[f64; 3]>>,
    /// Point on the axis of rotation in F at the zero pose, mm.
    pub point_mm: Option<Known<[f64; 3]>>,
}

/// Data of a control.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlFacts {
    /// Name of the control.
    pub control: Option<Known<String>>,
    /// Rotary axes with their sides of F, in the order in which they carry one another, and the origin of this order.
    pub rotary: Vec<(Axis, Branch)>,
    /// Origin of [`Self::rotary`].
    pub rotary_origin: String,
    axes: BTreeMap<usize, AxisFacts>,
    /// Shift of the workpiece zero by TRAORI, mm; `None` if the chain is closed.
    pub zero_shift_mm: Option<Known<[f64; 3]>>,
    /// Axes by their numbers at the control, from 1.
    pub axis_numbers: Option<Known<BTreeMap<usize, Axis>>>,
    /// Unit of the files in which the control saves offsets and tools: `mm` or `inch`.
    pub saved_unit: Option<Known<&'static str>>,
    /// Increments into which the control divides a millimeter.
    pub increments_per_mm: Option<Known<u32>>,
    /// True if a tool change moves axes.
    pub tool_change_moves: Option<Known<bool>>,
    /// Words in force before the first block.
    pub startup_code: Option<Known<String>>,
    /// Lines of `[control]`: words that are in force before the first block.
    pub control_lines: Vec<Known<String>>,
    /// Data that the machine file does not carry, and data that the file lacks.
    pub notes: Vec<DataNote>,
}

/// Format of data of a control.
#[derive(Clone, Copy, Debug)]
pub struct ControlDataFormat {
    /// Name in messages.
    pub name: &'static str,
    /// True if the text has the marks of the format.
    pub is: fn(&str) -> bool,
    /// Reads a text with the name of its file.
    pub read: fn(&str, &str, &mut ControlFacts) -> Result<(), String>,
}

/// Formats, in the order in which their marks are searched.
pub const FORMATS: &[ControlDataFormat] = &[sinumerik::FORMAT, linuxcnc::FORMAT, grbl::FORMAT];

impl ControlFacts {
    /// Adds a note for people.
    fn note(&mut self, text: String) {
        self.note_as(DataNoteKind::Other, text);
    }

    fn note_as(&mut self, kind: DataNoteKind, text: String) {
        self.notes.push(DataNote { kind, text });
    }

    /// Returns the data of an axis; `None` if no file states any.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<&AxisFacts> {
        self.axes.get(&axis.slot())
    }

    /// Reads a file. Returns the name of its format.
    ///
    /// # Errors
    /// Returns a sentence if the format is unknown or its data contradict each other.
    pub fn read(&mut self, name: &str, bytes: &[u8]) -> Result<&'static str, String> {
        if let Some(encoding) = wide_encoding(bytes) {
            return Err(format!("{name} is in {encoding}, which ncfix does not read here: save it as UTF-8"));
        }
        let text = String::from_utf8_lossy(bytes);
        let Some(format) = FORMATS.iter().find(|format| (format.is)(&text)) else {
            let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
            return Err(format!("{name} has no data of a machine that ncfix can use; it reads {}", names.join(", ")));
        };
        (format.read)(name, &text, self)?;
        Ok(format.name)
    }

    /// Returns a sentence if the rotary axes of a chain are not those of the data.
    #[must_use]
    pub fn contradiction(&self, topology: &Topology) -> Option<String> {
        if self.rotary.is_empty() {
            return None;
        }
        let rotary = |axes: &[Axis], branch| -> Vec<(Axis, Branch)> {
            axes.iter().filter(|axis| axis.is_rotary()).map(|axis| (*axis, branch)).collect()
        };
        for (axes, branch) in [(&topology.workpiece, Branch::Workpiece), (&topology.tool, Branch::Tool)] {
            let stated: Vec<_> = self.rotary.iter().copied().filter(|one| one.1 == branch).collect();
            if stated != rotary(axes, branch) {
                let listed: Vec<String> = self
                    .rotary
                    .iter()
                    .map(|(axis, branch)| {
                        let carried = if *branch == Branch::Tool { "the spindle" } else { "the workpiece" };
                        format!("{axis} on the side of {carried}")
                    })
                    .collect();
                return Some(format!(
                    "the data state {}, from F outwards ({}), and the chain {topology} differs: choose another template with --like",
                    listed.join(", "),
                    self.rotary_origin
                ));
            }
        }
        None
    }

    fn axis_mut(&mut self, axis: Axis) -> &mut AxisFacts {
        self.axes.entry(axis.slot()).or_default()
    }
}

/// Value of a line of a file, with a remark on the data.
fn known<T>(value: T, (name, line): (&str, usize), remark: &str) -> Known<T> {
    Known { value, origin: KnownOrigin::File(format!("{name}:{line} {remark}").trim_end().to_owned()) }
}

/// A finite number.
fn number(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|value| value.is_finite())
}

/// Removes the noise of a conversion from a number.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
