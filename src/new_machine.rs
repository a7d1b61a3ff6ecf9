//! A new machine: from a template, statements and data of its control to the text of a machine file.

use std::path::PathBuf;

use crate::diagnostics::Diagnostics;
use crate::disk::{files, machine_file};
use crate::error::Error;
use crate::machine::Machine;
use crate::registry::Registry;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::describe::{
    Ask, Description, DescriptionRequest, KnownOrigin, TEMPLATES, TravelRange, has_same_setup, setup_text, template,
    text, worn_edges,
};
use ncfix_report::chain::{ChainPicture, sketch};
use ncfix_report::plot::Picture as _;

/// The templates with their chains, a row for each.
pub(crate) fn templates() -> String {
    let row = |one: &ncfix_machine::describe::Template| {
        let chain = if one.topology.is_empty() { "not yet" } else { one.topology };
        format!("{:<18} {chain:<11} {}\n", one.name, one.line)
    };
    TEMPLATES.iter().map(row).collect()
}

/// A described machine.
pub(crate) struct NewMachine {
    /// Text of the machine file.
    pub(crate) text: String,
    /// Sketch of the chain, assumed values, and data that are not in the file, for a terminal.
    pub(crate) sketch: String,
    /// Picture of the chain.
    pub(crate) picture: String,
}

/// Describes a machine by the template `like` and the files of its control, adds the zero offsets and tools of `setups`, and reads the result as a machine file.
///
/// # Errors
/// If a file cannot be read, a dangerous value is missing, or a statement does not fit the chain.
pub(crate) fn describe(
    request: &DescriptionRequest,
    like: &str,
    (from, setups): (&[PathBuf], &[PathBuf]),
    ask: Ask<'_>,
    findings: &mut Diagnostics,
) -> Result<Option<NewMachine>, Error> {
    let template = template(like).map_err(Error::usage)?;
    let mut request = request.clone();
    let mut read = Vec::new();
    for path in from {
        let source = files::read_written(path, FileId(0), files::option("data of the control, --from"))?;
        let format = request.facts.read(source.name(), source.bytes()).map_err(Error::usage)?;
        read.push(format!("  {}: {format}\n", source.name()));
    }
    let description = request.describe(template, ask).map_err(Error::usage)?;
    let mut text = text(&description);
    let source = in_memory(&request.name, &text)?;
    let Some(mut machine) = machine_file::of_text(&source, &Registry::default(), findings)? else { return Ok(None) };
    if !setups.is_empty() {
        let Some(full) = machine_file::read(&source, setups, findings)? else { return Ok(None) };
        let names = setups.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
        let cannot = |what: &str| {
            Error::usage(format!(
                "{names} has {what}, which a machine file cannot hold: leave --setup out here, and give it with each command"
            ))
        };
        let worn: Vec<String> =
            worn_edges(&machine.machine, &full.machine).into_iter().map(|(number, _)| format!("T{number}")).collect();
        let added = setup_text(&machine.machine, &full.machine).map_err(|what| cannot(&what))?;
        text.push_str(&format!(
            "\n# From {}: if they change at the control, give --setup FILE, which overrides them.\n{added}",
            names.replace(char::is_control, " ")
        ));
        let source = in_memory(&request.name, &text)?;
        let Some(again) = machine_file::of_text(&source, &Registry::default(), findings)? else { return Ok(None) };
        if !has_same_setup(&again.machine, &full.machine) {
            return Err(cannot("data"));
        }
        if !worn.is_empty() {
            let worn = worn.join(", ");
            text.push_str(&format!(
                "\n# Not in this file because its radius has a wear: {worn}. Give --setup FILE with each command.\n"
            ));
            read.push(format!(
                "  {worn}: the radius has a wear, which a machine file cannot hold; give --setup {names} with each command\n"
            ));
        }
        machine = again;
        let (offsets, tools) = (machine.machine.zero_offsets.len(), machine.machine.tools.len());
        read.push(format!("  {names}: zero offsets: {offsets}, edges of tools: {tools}\n"));
    }
    let mut shown = sketch(&machine.machine);
    if !read.is_empty() {
        shown.push_str("\nread:\n");
        shown.extend(read);
    }
    shown.push_str(&remarks(&description));
    Ok(Some(NewMachine { text, sketch: shown, picture: picture(&machine) }))
}

/// The text of a machine file that is not on the disk.
fn in_memory(name: &str, text: &str) -> Result<Source, Error> {
    Source::new(FileId(0), name, text.as_bytes().to_vec())
        .map_err(|_| Error::usage("the machine file is too large".into()))
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
