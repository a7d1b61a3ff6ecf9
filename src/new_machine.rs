//! A new machine: from a template, statements and data of its control to the text of a machine file.

use std::path::PathBuf;

use crate::diagnostics::Diagnostics;
use crate::disk::{files, machine_file};
use crate::error::Error;
use crate::machine::Machine;
use crate::registry::Registry;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::describe::{Ask, Description, DescriptionRequest, KnownOrigin, TravelRange, template, text};
use ncfix_report::chain::{ChainPicture, sketch};
use ncfix_report::plot::Picture as _;

/// A described machine.
pub(crate) struct NewMachine {
    /// Text of the machine file.
    pub(crate) text: String,
    /// Sketch of the chain, assumed values, and data that are not in the file, for a terminal.
    pub(crate) sketch: String,
    /// Picture of the chain.
    pub(crate) picture: String,
}

/// Describes a machine by the template `like` and the files of its control, and reads the result as a machine file.
///
/// # Errors
/// If a file cannot be read, a dangerous value is missing, or a statement does not fit the chain.
pub(crate) fn describe(
    request: &DescriptionRequest,
    like: &str,
    from: &[PathBuf],
    ask: Ask<'_>,
    findings: &mut Diagnostics,
) -> Result<Option<NewMachine>, Error> {
    let template = template(like).map_err(Error::usage)?;
    let mut request = request.clone();
    let mut read = Vec::new();
    for path in from {
        let source = files::read_written(path, FileId(0), "data of the control, --from")?;
        let format = request.facts.read(source.name(), source.bytes()).map_err(Error::usage)?;
        read.push(format!("  {}: {format}\n", source.name()));
    }
    let description = request.describe(template, ask).map_err(Error::usage)?;
    let text = text(&description);
    let source = Source::new(FileId(0), &request.name, text.clone().into_bytes())
        .map_err(|_| Error::usage("the machine file is too large".into()))?;
    let Some(machine) = machine_file::of_text(&source, &Registry::default(), findings)? else { return Ok(None) };
    let mut shown = sketch(&machine.machine);
    if !read.is_empty() {
        shown.push_str("\nread:\n");
        shown.extend(read);
    }
    shown.push_str(&remarks(&description));
    Ok(Some(NewMachine { text, sketch: shown, picture: picture(&machine) }))
}

/// The picture of the chain of a machine.
fn picture(machine: &Machine) -> String {
    ChainPicture::of(&machine.machine).svg()
}

/// Values that nobody stated, and notes on the data.
fn remarks(description: &Description) -> String {
    let mut out = String::new();
    let assumed: Vec<String> = description
        .axes
        .iter()
        .filter(|one| one.travel.origin == KnownOrigin::Assumed)
        .map(|one| match one.travel.value {
            TravelRange::Ends(_) => format!("  travel of {}: {}\n", one.axis, one.travel.value),
            TravelRange::Modulo => format!("  {} turns without limits (modulo)\n", one.axis),
        })
        .collect();
    let control = (description.control.origin == KnownOrigin::Assumed)
        .then(|| format!("  control: {}\n", description.control.value));
    if !assumed.is_empty() || control.is_some() {
        out.push_str("\nassumed, check at the machine:\n");
        out.extend(control);
        out.extend(assumed);
    }
    if !description.notes.is_empty() {
        out.push_str("\nnot in the machine file:\n");
        out.extend(description.notes.iter().map(|note| format!("  {note}\n")));
    }
    out
}
