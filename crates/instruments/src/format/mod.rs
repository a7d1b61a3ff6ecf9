//! Formats of instruments: one file each, and their registry ([`InstrumentFormats`]), which a caller may extend.
//!
//! A format recognizes a text by its content, never by the name of the file, and turns it into readings. To add one from another crate, write a static
//! [`InstrumentFormat`] and pass it to `ncfix::Registry::with_instrument_format`.

mod ballbar;
mod centres;
mod displacements;
mod height_map;
mod nominal_actual;
mod reprap_map;
mod sections;
mod spheres;
mod targets;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::Axis;
use ncfix_base::register::{Register, Registered};

use crate::grid::GridTable;
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::ImportedReadings;
use crate::text::DecodedText;
use crate::words;

/// Columns whose headings name an axis.
fn axis_columns(table: &GridTable) -> Vec<(usize, Axis)> {
    let headings = table.headings.iter().enumerate();
    headings.filter_map(|(index, heading)| Some((index, words::axis(&heading.words)?))).collect()
}

/// Format of a file.
#[derive(Clone, Copy, Debug)]
pub struct InstrumentFormat {
    /// Name for `--as`. Unique in a registry.
    pub name: &'static str,
    /// Instruments and layout, in a few words.
    pub title: &'static str,
    /// Options that a file of this format usually needs, separated by blanks.
    pub needs: &'static str,
    /// Returns how certain it is that a text has this format: 0 no, 3 a mark that no other format has.
    pub recognize: fn(&DecodedText) -> u8,
    /// Reads a text.
    pub read: fn(&mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop>,
}

/// Formats by name: [`Register::default`] contains the built-in ones.
pub type InstrumentFormats = Register<&'static InstrumentFormat>;

impl Registered for &'static InstrumentFormat {
    const KIND: &'static str = "format of an instrument";

    fn name(&self) -> &str {
        self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        FORMATS.iter().map(|&format| Box::new(format)).collect()
    }
}

/// The built-in formats.
pub const FORMATS: &[&InstrumentFormat] = &[
    &targets::FORMAT,
    &nominal_actual::FORMAT,
    &ballbar::FORMAT,
    &displacements::FORMAT,
    &spheres::FORMAT,
    &centres::FORMAT,
    &sections::FORMAT,
    &height_map::POINTS,
    &height_map::KLIPPER,
    &height_map::MARLIN,
    &reprap_map::FORMAT,
];

/// Finds the format of a text by its content.
///
/// # Errors
/// A diagnostic if no format matches, or two match equally well.
pub fn recognize(
    text: &DecodedText,
    formats: &InstrumentFormats,
) -> Result<&'static InstrumentFormat, Box<Diagnostic>> {
    let scores: Vec<(u8, &'static InstrumentFormat)> =
        formats.iter().map(|format| ((format.recognize)(text), *format)).collect();
    let best = scores.iter().map(|(score, _)| *score).max().unwrap_or(0);
    let mut matching = scores.iter().filter(|(score, _)| *score == best && best > 0).map(|(_, format)| *format);
    match (matching.next(), matching.next()) {
        (Some(only), None) => Ok(only),
        (Some(one), Some(other)) => {
            let message =
                format!("the file may be '{}' ({}) or '{}' ({})", one.name, one.title, other.name, other.title);
            Err(Box::new(Diagnostic::nowhere(
                Code::IMPORT_QUESTION,
                message,
                format!("give --as {} or --as {}", one.name, other.name),
            )))
        }
        (None, _) => {
            // The text may be a table with a fault: its own message is more helpful.
            if let Err(found) = crate::grid::table(text)
                && found.place.is_some()
            {
                return Err(found);
            }
            let message = format!("ncfix import does not recognize the layout of {}", text.source().name());
            let is_markup = text
                .lines()
                .map(|(_, line, _)| line.trim())
                .find(|line| !line.is_empty())
                .is_some_and(|line| line.starts_with('<'));
            let help = if is_markup {
                "export the readings as CSV; `ncfix decompose` reads traces of a Sinumerik as they are"
            } else {
                "`ncfix import --list` lists the formats; name one with --as, and the columns with --columns; in a file with commas \
                 between the cells, numbers need a decimal point"
            };
            Err(Box::new(Diagnostic::nowhere(Code::IMPORT_FORMAT, message, help)))
        }
    }
}
