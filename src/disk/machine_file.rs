//! Finds and reads the machine: `--machine`, `NCFIX_MACHINE`, the nearest `ncfix.toml`, or the embedded demo machine.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diagnostics::Diagnostics;
use crate::disk::files::{self, FileRole, is_standard_stream};
use crate::disk::hash::short_hash;
use crate::disk::{archive, table_files};
use crate::error::Error;
use crate::machine::Machine;
use crate::registry::Registry;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::{FileId, Source};
use ncfix_dialect::{CodeEffect, Dialect};
use ncfix_language::exec::apply_archive;
use ncfix_machine::machine::controller::{ControllerMeaning, controller};
use ncfix_machine::machine::file::{DEMO, MachineFile, apply_setup};
use ncfix_machine::machine::{Clamp, Condition};
use ncfix_machine::saved::{SavedFormat, apply_saved, recognized};
use ncfix_model::file::load_with;

/// Name of the machine file that is searched in the folder of the program and above it.
const NEAREST: &str = "ncfix.toml";

/// The environment variable that names a machine file.
const VARIABLE: &str = "NCFIX_MACHINE";

/// The way in which the machine file was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FoundFile {
    /// It is the argument of the command.
    Named,
    /// `--machine`.
    Option,
    /// `NCFIX_MACHINE`.
    Environment,
    /// The nearest `ncfix.toml` in the folder of the program or above it.
    AboveProgram,
    /// The nearest `ncfix.toml` in the working folder or above it.
    AboveWorkingFolder,
    /// The demo machine, as no file was found.
    Demo,
}

impl FoundFile {
    /// The way as text.
    pub(crate) fn words(self) -> &'static str {
        match self {
            FoundFile::Named => "named on the command line",
            FoundFile::Option => "--machine",
            FoundFile::Environment => "NCFIX_MACHINE",
            FoundFile::AboveProgram => "the nearest ncfix.toml from the folder of the program upwards",
            FoundFile::AboveWorkingFolder => "the nearest ncfix.toml from the working folder upwards",
            FoundFile::Demo => "embedded, as no machine file was found",
        }
    }
}

/// Chooses and reads the machine for `program`; `None` if there are errors.
///
/// # Errors
/// If a named file cannot be read.
pub(crate) fn choose(
    named: Option<&Path>,
    setups: &[PathBuf],
    program: &Path,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let (path, found) = locate(named, program);
    let source = source_of(path.as_deref(), found, findings)?;
    let Some(mut chosen) = read(&source, setups, findings)? else { return Ok(None) };
    chosen.is_demo = path.is_none();
    lie_beside(&mut chosen, path.as_deref());
    chosen.files.extend(path);
    Ok(Some(chosen))
}

/// Reads the machine of a file; `None` if there are errors.
///
/// # Errors
/// If the file or a set-up file cannot be read.
pub(crate) fn read_file(
    path: &Path,
    setups: &[PathBuf],
    registry: &Registry,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let source = files::read_written(path, FileId(0), "machine file")?;
    let Some(mut machine) = read_with(&source, setups, registry, findings)? else { return Ok(None) };
    lie_beside(&mut machine, Some(path));
    machine.files.push(path.to_path_buf());
    Ok(Some(machine))
}

/// The machine of a text alone; `None` if there are errors.
///
/// # Errors
/// If it names tables in files.
pub(crate) fn of_text(
    source: &Source,
    registry: &Registry,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    if load_with(source, &registry.model).0.is_some_and(|(machine, _)| !machine.active_tables.files.is_empty()) {
        let name = source.name();
        return Err(Error::usage(format!("{name} names files of tables as active: read the machine from its file")));
    }
    read_with(source, &[], registry, findings)
}

/// Folders in the machine file are relative to its folder if they exist there, otherwise to that of the program.
fn lie_beside(machine: &mut Machine, path: Option<&Path>) {
    let base = path.and_then(Path::parent).unwrap_or(Path::new("."));
    for entry in &mut machine.machine.control.search_path {
        let folder = base.join(&*entry);
        if let Some(full) = folder.canonicalize().ok().and_then(|full| full.to_str().map(str::to_owned)) {
            *entry = full;
        }
    }
}

/// The text of a located machine file; without a path that of the demo machine, with a warning.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn source_of(path: Option<&Path>, found: FoundFile, findings: &mut Diagnostics) -> Result<Source, Error> {
    match path {
        Some(path) => {
            let role = format!("machine file, {}", found.words());
            let is_option = matches!(found, FoundFile::Option | FoundFile::Environment);
            let role = if is_option { files::option(&role) } else { FileRole::Plain(&role) };
            files::read_written(path, FileId(0), role)
        }
        None => {
            log::info!("machine: the demo machine, {}", found.words());
            findings.add(
                Diagnostic::nowhere(
                    Code::NO_MACHINE,
                    format!("the embedded demo machine is used: no --machine was given and no {NEAREST} was found"),
                    format!(
                        "give --machine M.toml, name the machine file in {VARIABLE}, or save it as {NEAREST} in the folder of the input file"
                    ),
                ),
                &[],
            );
            demo()
        }
    }
}

/// Reads a machine from its file and its set-up files; `None` if there are errors.
///
/// # Errors
/// If a set-up file cannot be read.
pub(crate) fn read(source: &Source, setups: &[PathBuf], findings: &mut Diagnostics) -> Result<Option<Machine>, Error> {
    read_with(source, setups, &Registry::default(), findings)
}

/// Reads a machine as [`read`] does, with one head: the named one, or the only one.
///
/// # Errors
/// If a set-up file cannot be read, or the head is not clear.
pub(crate) fn read_head(
    source: &Source,
    setups: &[PathBuf],
    head: Option<&str>,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    read(source, setups, findings)?.map(|machine| machine.with_one_head(head)).transpose()
}

/// Reads a machine as [`read`] does, with the additional keys of a registry.
fn read_with(
    source: &Source,
    setups: &[PathBuf],
    registry: &Registry,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let (loaded, found) = load_with(source, &registry.model);
    let mut is_usable = !found.iter().any(Diagnostic::is_error);
    findings.extend(found, std::slice::from_ref(source));
    let Some((mut machine, errors)) = loaded else { return Ok(None) };
    if ncfix_dialect::find(&machine.controller).is_none() {
        is_usable = false;
        let place = MachineFile::parse(source).ok().and_then(|file| {
            let section = file.root().section("machine")?;
            Some(section.place_of("controller"))
        });
        let message = format!("controller '{}' in {} is not a dialect", machine.controller, source.name());
        let help = match controller(&machine.controller).map(|row| row.meaning) {
            Some(ControllerMeaning::Differs(advice) | ControllerMeaning::Unread(advice)) => advice.to_owned(),
            _ => format!("write one of {}, haas", dialect_names()),
        };
        let found = Diagnostic::nowhere(Code::BAD_VALUE, message, help);
        findings.add(Diagnostic { place, ..found }, std::slice::from_ref(source));
    }
    let found = of_other_meaning(&machine, source);
    is_usable &= found.is_empty();
    findings.extend(found, std::slice::from_ref(source));
    for word in &machine.control.initial_codes {
        let table = ncfix_dialect::find(&machine.controller).map(Dialect::codes);
        let row = table.and_then(|table| table.word(&word.to_ascii_uppercase()));
        if row.is_none_or(|row| row.effect != CodeEffect::Keep || row.group == 0) {
            is_usable = false;
            findings.add(
                Diagnostic::nowhere(
                    Code::BAD_VALUE,
                    format!(
                        "'{word}' in control.initial_codes of {} is not a modal code, or it changes positions",
                        source.name()
                    ),
                    "write codes such as \"G64\", \"CFTCP\", \"SOFT\"; the zero offset is control.initial_zero_offset",
                ),
                &[],
            );
        }
    }
    let mut files = Vec::new();
    let mut parts = vec![source.bytes()];
    let mut sources = Vec::new();
    for path in setups {
        let (setup, members) = members(path)?;
        for Member { source: member, is_saved_data, format } in members {
            let mut found = match format {
                Some(format) => {
                    log::info!("set-up {}: {}", member.name(), format.name);
                    apply_saved(format, &member, &mut machine)
                }
                None if is_saved_data => apply_archive(&member, &mut machine),
                None => apply_setup(&member, &mut machine),
            };
            if !is_saved_data && found.iter().any(|found| found.code == Code::BAD_TOML) && is_program(&member) {
                let message = format!("{} is a part program, not a set-up", member.name());
                let help = "give it as the program; a set-up is a .toml file, or the saved data of the control";
                found = vec![Diagnostic::nowhere(Code::BAD_TOML, message, help)];
            }
            is_usable &= !found.iter().any(Diagnostic::is_error);
            findings.extend(found, std::slice::from_ref(&member));
        }
        files.push(path.clone());
        sources.push(setup);
    }
    let folder = Path::new(source.name()).parent().unwrap_or(Path::new("."));
    let named: Vec<PathBuf> = machine.active_tables.files.iter().map(|file| folder.join(file)).collect();
    let active = if named.is_empty() { None } else { table_files::active(&named, &machine, findings)? };
    match &active {
        Some((control, read)) => {
            machine.active_tables.set(control.clone());
            parts.extend(read.iter().map(Source::bytes));
        }
        None => is_usable &= named.is_empty(),
    }
    if machine.active_tables.is_offline && errors.effects().next().is_some() {
        let message = "the machine file states errors, and offline_tables may correct the same ones";
        let help = "remove the errors, or the key; tables that the control uses belong in active_tables";
        findings.add(Diagnostic::nowhere(Code::TABLES_DO_NOT_FIT, message, help), &[]);
        is_usable = false;
    }
    files.extend(named);
    parts.extend(sources.iter().map(Source::bytes));
    let hash = short_hash(parts);
    Ok(is_usable.then_some(Machine {
        machine,
        errors,
        registry: Arc::new(registry.clone()),
        condition: Condition::default(),
        state: None,
        is_demo: false,
        stated_zeros: Vec::new(),
        written_zeros: Vec::new(),
        first_tools_mm: BTreeMap::new(),
        hash,
        files,
    }))
}

/// Words that select a head, and that have another meaning in the language of the control.
fn of_other_meaning(machine: &ncfix_machine::machine::Machine, source: &Source) -> Vec<Diagnostic> {
    let codes = ncfix_dialect::find(&machine.controller).map(Dialect::codes);
    let clamps = |number: u32| {
        let of_axis = |clamp: &Clamp| clamp.close == number || clamp.open == number;
        machine.axes.iter().flatten().any(|axis| axis.clamps.iter().any(of_axis))
    };
    let meaning = |number: u32| match codes.and_then(|codes| codes.m(number as usize)) {
        _ if machine.control.macros.codes.contains_key(&format!("M{number}")) => {
            Some("the call of a program (macro_codes)")
        }
        _ if clamps(number) => Some("a clamp of an axis (clamp_codes, unclamp_codes)"),
        Some(row) if is_for_heads(&machine.controller, row.name) => None,
        Some(row) => Some(row.meaning),
        None => is_standard(number).then_some("a standard function"),
    };
    let mut found = Vec::new();
    for head in &machine.heads {
        for number in &head.select {
            let Some(meaning) = meaning(*number) else { continue };
            let place = MachineFile::parse(source).ok().and_then(|file| place_of_head(&file, &head.name));
            let message = format!("M{number}, which selects the head {}, already means: {meaning}", head.name);
            let help = "write the M word with which this control selects the head; it must have no other meaning";
            found.push(Diagnostic { place, ..Diagnostic::nowhere(Code::BAD_HEAD, message, help) });
        }
    }
    found
}

/// True for the words of a swivel head, and for those that the user assigns.
fn is_for_heads(controller: &str, row: &str) -> bool {
    matches!((controller, row), ("grundig", "M53" | "M54") | ("rs274", "M100..M199"))
}

/// True for M words that a control without rows for them has: stops, ends, spindle, tool change, coolant, gears.
fn is_standard(number: u32) -> bool {
    matches!(number, 0..=9 | 17 | 19 | 30 | 40..=45 | 70)
}

/// The place of the words of a head.
fn place_of_head(file: &MachineFile, name: &str) -> Option<Place> {
    let mut heads = file.root().sections("head").into_iter();
    heads.find_map(|mut section| (section.text("name") == Some(name)).then(|| section.place_of("select")))
}

/// True if the name or the words of a file are those of a part program.
fn is_program(source: &Source) -> bool {
    let (name, bytes) = (source.name(), source.bytes());
    ncfix_dialect::guess(name, bytes).is_some() || ncfix_dialect::likeness(bytes).is_some()
}

/// A set-up file with its content.
pub(crate) struct Member {
    pub(crate) source: Source,
    /// True if it is in the control's own language rather than TOML.
    pub(crate) is_saved_data: bool,
    /// Format of another control, if the file has one.
    pub(crate) format: Option<&'static SavedFormat>,
}

/// A set-up file and its content: the file itself, or the data of an archive.
///
/// # Errors
/// If it cannot be read.
pub(crate) fn members(path: &Path) -> Result<(Source, Vec<Member>), Error> {
    // An archive contains all data of the control and may be large.
    let is_large = path.is_file() && archive::is_archive(path);
    let role = files::option("set-up file, --setup");
    let setup = if is_large { files::read(path, FileId(0), role) } else { files::read_written(path, FileId(0), role) }?;
    let inside = archive::saved_data(path, setup.bytes())?.unwrap_or_else(|| vec![setup.clone()]);
    let member = |source: Source| {
        let is_saved_data = source.name() != setup.name() || is_saved_data(path, source.bytes());
        let format = if is_toml(path) { None } else { recognized(&source) };
        Member { source, is_saved_data, format }
    };
    let members = inside.into_iter().map(member).collect();
    Ok((setup, members))
}

/// True if a set-up file is in the control's own language rather than TOML.
fn is_saved_data(path: &Path, bytes: &[u8]) -> bool {
    if is_toml(path) {
        return false;
    }
    let lines = bytes.split(|&byte| byte == b'\n' || byte == b'\r').map(<[u8]>::trim_ascii_start);
    let is_mark = |line: &[u8]| matches!(line, [b'%' | b'$' | b';', ..] | [b'R' | b'N' | b'n', b'0'..=b'9', ..]);
    let first = lines.into_iter().find(|line| !line.is_empty());
    first.is_some_and(|line| is_mark(line) || line.starts_with(b"CHANDATA") || line.starts_with(b"METRIC"))
}

/// True if the name of a set-up file ends with `.toml`.
pub(crate) fn is_toml(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// The demo machine as a file.
pub(crate) fn demo() -> Result<Source, Error> {
    Source::new(FileId(0), "<demo machine>", DEMO.as_bytes().to_vec())
        .map_err(|_| Error::usage("the demo machine is too large".into()))
}

/// The machine file: `named`, otherwise that of the environment, otherwise the nearest one; none if only the demo
/// machine remains.
pub(crate) fn locate(named: Option<&Path>, program: &Path) -> (Option<PathBuf>, FoundFile) {
    if let Some(named) = named {
        return (Some(named.to_path_buf()), FoundFile::Option);
    }
    if let Some(path) = of_environment() {
        return (Some(path), FoundFile::Environment);
    }
    match nearest(program) {
        Some((path, found)) => (Some(path), found),
        None => (None, FoundFile::Demo),
    }
}

/// The machine file that the environment names. A variable with an empty value counts as not set.
fn of_environment() -> Option<PathBuf> {
    std::env::var_os(VARIABLE).filter(|path| !path.is_empty()).map(PathBuf::from)
}

/// True if an option or the environment names the machine file.
pub(crate) fn is_named(named: Option<&Path>) -> bool {
    named.is_some() || of_environment().is_some()
}

/// The nearest machine file, from the folder of the program upwards, then from the working folder upwards.
fn nearest(program: &Path) -> Option<(PathBuf, FoundFile)> {
    let upwards = |folder: PathBuf| {
        let folder = folder.canonicalize().ok()?;
        folder.ancestors().map(|folder| folder.join(NEAREST)).find(|file| file.is_file())
    };
    let beside = (!is_standard_stream(program)).then(|| program.parent().map(|parent| Path::new(".").join(parent)));
    let above_program = beside.flatten().and_then(upwards).map(|file| (file, FoundFile::AboveProgram));
    above_program.or_else(|| Some((upwards(PathBuf::from("."))?, FoundFile::AboveWorkingFolder)))
}

/// `sinumerik, grundig, …`.
pub(crate) fn dialect_names() -> String {
    ncfix_dialect::DIALECTS.iter().map(|dialect| dialect.name).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_file_is_found_upwards() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("a/b");
        std::fs::create_dir_all(&inner).unwrap();
        std::fs::write(folder.path().join(NEAREST), "").unwrap();
        let found = nearest(&inner.join("p.mpf")).unwrap();
        assert_eq!(found, (folder.path().canonicalize().unwrap().join(NEAREST), FoundFile::AboveProgram));
    }
}
