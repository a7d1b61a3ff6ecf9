//! `--model`: the parameters of a preset, or those of a file.

use std::collections::HashSet;
use std::path::Path;

use super::findings::Findings;
use super::input;
use super::stop::Stop;
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::machine::Machine;
use crate::model::parameter::ParameterName;
use crate::model::preset::{PRESETS, find};
use crate::source::{FileId, Source, Span};

/// The parameters of `--model`; `None` where findings forbid to use them. A preset goes before a file of its name.
///
/// # Errors
/// Where there is neither preset nor file, or the preset does not suit the machine.
pub(super) fn choose(
    model: &str,
    machine: &Machine,
    findings: &mut Findings,
) -> Result<Option<Vec<ParameterName>>, Stop> {
    if let Some(preset) = find(model) {
        let parameters = (preset.parameters)(machine).map_err(|reason| {
            Stop::Usage(format!("preset {model} does not suit the machine {}: {reason}", machine.name))
        })?;
        return Ok(Some(parameters));
    }
    let path = Path::new(model);
    if !path.is_file() {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        let known = known.join(", ");
        return Err(Stop::Usage(format!("--model {model} is no file and no preset; the presets are {known}")));
    }
    let source = input::read(path, FileId(0))?;
    let (parameters, found) = read(&source, machine);
    let is_sound = found.is_empty();
    findings.extend(found, std::slice::from_ref(&source));
    Ok(is_sound.then_some(parameters))
}

/// Reads a file of parameters: one in each line, comments behind `#`.
fn read(source: &Source, machine: &Machine) -> (Vec<ParameterName>, Vec<Diagnostic>) {
    let (mut parameters, mut findings) = (Vec::new(), Vec::new());
    let mut seen = HashSet::new();
    let mut start = 0;
    for line in source.bytes().split(|&byte| byte == b'\n' || byte == b'\r') {
        let first = start;
        start += line.len() + 1;
        let content = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        let word = content.trim_ascii();
        if word.is_empty() {
            continue;
        }
        let from = first + (content.len() - content.trim_ascii_start().len());
        let place = Place { file: source.id(), span: Span::new(from, from + word.len()) };
        let mut report = |message: String, help: &str| {
            findings.push(Diagnostic::at(Code::BAD_PARAMETER, place, message, help));
        };
        let text = String::from_utf8_lossy(word);
        let help = "write one in each line: EC0Y, EXX1, EXXb or EXX2@150; comments behind #";
        match text.parse::<ParameterName>() {
            Err(_) => report(format!("'{text}' is no parameter"), help),
            Ok(name) => match name.component.axis().filter(|&axis| machine.axis(axis).is_none()) {
                Some(axis) => report(
                    format!("{name}: the machine {} has no axis {axis}", machine.name),
                    "take it out, or check --machine",
                ),
                None if !seen.insert(name) => report(format!("{name} is there twice"), "take one of them out"),
                None => parameters.push(name),
            },
        }
    }
    if parameters.is_empty() && findings.is_empty() {
        let place = Place { file: source.id(), span: Span::new(0, source.bytes().len().min(1)) };
        findings.push(Diagnostic::at(Code::BAD_PARAMETER, place, "the file names no parameter", "write at least one"));
    }
    (parameters, findings)
}
