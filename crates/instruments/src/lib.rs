//! Files of measuring instruments: from the bytes of an export to a table of readings with its description.
//!
//! [`import`] decodes the text, finds its layout in the [`InstrumentFormats`], and reads it. No public layout states all that a calibration needs: the sign of
//! a reading, the position of the other axes, the place of the instrument. The result is therefore either [`ImportedReadings`] or
//! [`ImportQuestion`]s, each with the option that answers it. Nothing is guessed, and no file is read or written here.

pub mod answers;
mod differences;
pub mod format;
pub mod grid;
pub mod inquiry;
mod kept;
mod numerals;
pub mod preview;
pub mod readings;
mod row_fact;
mod rows;
pub mod signs;
mod stated;
pub mod text;
pub mod unit;
mod unread;
pub mod words;
mod workbook;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::machine::Machine;

use answers::ImportAnswers;
use format::InstrumentFormats;
use inquiry::{ImportQuestion, ImportStop, Inquiry};
use readings::{ImportedKind, ImportedReadings};
use text::DecodedText;

/// Result of an import.
#[derive(Clone, Debug)]
pub enum ImportOutcome {
    /// The readings, complete.
    Readings(Box<ImportedReadings>),
    /// Questions that the file leaves open.
    Questions(Vec<ImportQuestion>),
}

/// Reads the text of an instrument for a machine. `format` is the name of a layout; without it, the content decides.
///
/// # Errors
/// A diagnostic if the text has no known layout, or is not what it seems to be.
pub fn import(
    text: &DecodedText,
    format: Option<&str>,
    answers: &ImportAnswers,
    machine: &Machine,
    formats: &InstrumentFormats,
) -> Result<ImportOutcome, Box<Diagnostic>> {
    read(text, format, answers, machine, formats).map_err(|mut found| {
        // The line of a workbook is that of its sheet; a person looks for the cell.
        if let Some(cell) = found.place.and_then(|place| text.cell(place)) {
            found.message = format!("{cell}: {}", found.message);
        }
        found
    })
}

fn read(
    text: &DecodedText,
    format: Option<&str>,
    answers: &ImportAnswers,
    machine: &Machine,
    formats: &InstrumentFormats,
) -> Result<ImportOutcome, Box<Diagnostic>> {
    let chosen = match format {
        Some(name) => formats.find(name).copied().ok_or_else(|| {
            let names: Vec<&str> = formats.names().collect();
            let help = format!("write one of {}", names.join(", "));
            Box::new(Diagnostic::nowhere(Code::IMPORT_FORMAT, format!("'{name}' is not a format"), help))
        })?,
        None => format::recognize(text, formats)?,
    };
    let mut inquiry = Inquiry::new(text, answers, machine);
    match (chosen.read)(&mut inquiry) {
        Ok(mut readings) if inquiry.questions().is_empty() => {
            readings.is_unit_stated = inquiry.is_unit_stated();
            if readings.kind != ImportedKind::BallBar {
                readings.is_in_order = inquiry.answer("order", |own| own.is_in_order).unwrap_or(readings.is_in_order);
            }
            if !readings.is_in_order {
                let note = "the order of the rows counts as sorted, so it gives no directions of approach (--order motion if the machine moved in it)";
                inquiry.note(note, 0);
            }
            readings.check(machine, text)?;
            kept::keep(&mut inquiry, &mut readings);
            inquiry.note_signs();
            rows::check_copies(&readings, text)?;
            Ok(ImportOutcome::Readings(Box::new(inquiry.finish(readings, chosen.name))))
        }
        Err(ImportStop::Asks) if inquiry.questions().is_empty() => {
            let message = format!("{} has no readings in the layout '{}'", text.source().name(), chosen.name);
            let help = "`ncfix import --list` lists the formats; without --as, the content decides";
            Err(Box::new(Diagnostic::nowhere(Code::IMPORT_FORMAT, message, help)))
        }
        Ok(_) | Err(ImportStop::Asks) => Ok(ImportOutcome::Questions(inquiry.questions().to_vec())),
        // A contradiction may only be the consequence of an open question.
        Err(ImportStop::Refused(_)) if !inquiry.questions().is_empty() => {
            Ok(ImportOutcome::Questions(inquiry.questions().to_vec()))
        }
        Err(ImportStop::Refused(diagnostic)) => Err(diagnostic),
    }
}
