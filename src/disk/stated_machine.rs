//! The machine file that a corrected program or a flat stream was made with, if no `--machine` names one.

use std::path::{Path, PathBuf};

use super::machine_file;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use crate::machine::Machine;
use crate::registry::Registry;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_machine::snc;
use ncfix_path::emit;

/// Maximum number of machine files that are examined in a folder, and the largest of them, bytes.
const MOST_FILES: usize = 200;
const MOST_BYTES: u64 = 4_000_000;

/// The byte order mark of UTF-8.
pub(crate) const MARK: &str = "\u{feff}";

/// The beginning of the head line of a flat stream.
pub(crate) const FLAT_HEAD: &str = "; snc 1";

/// True if a text is a flat stream, also one whose head line lacks the machine.
pub(crate) fn is_flat(bytes: &[u8]) -> bool {
    let rest = from_head(bytes).strip_prefix(FLAT_HEAD.as_bytes());
    rest.is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace))
}

/// A flat stream from its head line: blank lines and a byte order mark may precede it.
pub(crate) fn from_head(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(MARK.as_bytes()).unwrap_or(bytes).trim_ascii_start()
}

/// A program for which a machine is chosen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MachineSearch<'a> {
    /// The file from whose folder the nearest `ncfix.toml` is searched.
    pub(crate) near: &'a Path,
    /// A file that states its machine, with its bytes.
    pub(crate) made: Option<(&'a Path, &'a [u8])>,
    /// True if the program itself may change the head.
    pub(crate) changes_heads: bool,
}

impl<'a> MachineSearch<'a> {
    /// The search for the machine of a program in a file, which may change the head.
    pub(crate) fn of_program(near: &'a Path) -> MachineSearch<'a> {
        MachineSearch { near, made: None, changes_heads: true }
    }

    /// The same search for one head.
    pub(crate) fn with_one_head(self) -> MachineSearch<'a> {
        MachineSearch { changes_heads: false, ..self }
    }
}

impl<'a> From<&'a Path> for MachineSearch<'a> {
    fn from(near: &'a Path) -> MachineSearch<'a> {
        MachineSearch { near, made: None, changes_heads: false }
    }
}

impl<'a> From<&'a PathBuf> for MachineSearch<'a> {
    fn from(near: &'a PathBuf) -> MachineSearch<'a> {
        MachineSearch { near, made: None, changes_heads: false }
    }
}

/// Statement about a machine: the fingerprint in the stamp of a corrected program, or the name in the head of a flat stream.
#[derive(Clone, Debug, PartialEq)]
enum StatedMachine {
    Model(String),
    Name(String),
}

impl StatedMachine {
    fn of(bytes: &[u8]) -> Option<StatedMachine> {
        let name = || snc::stated_machine(from_head(bytes)).map(StatedMachine::Name);
        emit::stamped_model(bytes).map(StatedMachine::Model).or_else(name)
    }

    fn is(&self, machine: &Machine) -> bool {
        match self {
            StatedMachine::Model(model) => machine.hash == *model,
            StatedMachine::Name(name) => machine.machine.name == *name,
        }
    }

    fn words(&self) -> String {
        match self {
            StatedMachine::Model(model) => format!("the machine file with the checksum {model}"),
            StatedMachine::Name(name) => format!("the machine {name}"),
        }
    }
}

/// Chooses a machine as [`found`] does, with a head: the one that is active at the start of a program that may change it, otherwise the only one in use.
///
/// # Errors
/// If a named file cannot be read, or the head is not clear.
pub(crate) fn choose(
    (named, head): (Option<&Path>, Option<&str>),
    setups: &[PathBuf],
    search: MachineSearch<'_>,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let Some(machine) = found(named, setups, search, findings)? else { return Ok(None) };
    Ok(Some(match head {
        Some(name) if search.changes_heads => machine.starting_with(name)?,
        None if search.changes_heads => machine,
        head => machine.with_one_head(head)?,
    }))
}

/// Finds a machine as [`machine_file::choose`] does. If neither an option nor the environment names a file, and the program states its machine, only
/// that one is used: the nearest `ncfix.toml`, or another file in the folder of the program.
///
/// # Errors
/// If a named file cannot be read.
fn found(
    named: Option<&Path>,
    setups: &[PathBuf],
    search: MachineSearch<'_>,
    findings: &mut Diagnostics,
) -> Result<Option<Machine>, Error> {
    let usual = |findings: &mut Diagnostics| machine_file::choose(named, setups, search.near, findings);
    let stated = search.made.and_then(|(path, bytes)| Some((path, StatedMachine::of(bytes)?)));
    let Some((path, stated)) = stated.filter(|_| !machine_file::is_named(named)) else { return usual(findings) };
    let (near, _) = machine_file::locate(None, search.near);
    let is_it = |file: &PathBuf| {
        let read = machine_file::read_file(file, setups, &Registry::default(), &mut Diagnostics::default());
        read.is_ok_and(|machine| machine.is_some_and(|machine| stated.is(&machine)))
    };
    match &near {
        Some(file) if is_it(file) => return usual(findings),
        None if is_demo(&stated, setups)? => return usual(findings),
        _ => {}
    }
    let folders = [path, search.near].map(|path| path.parent().unwrap_or(Path::new("")).to_path_buf());
    let mut files: Vec<PathBuf> = folders.iter().flat_map(|folder| machine_files(folder)).collect();
    files.sort();
    files.dedup();
    if let Some(file) = files.iter().find(|file| is_it(file)) {
        log::info!("machine: {}, stated by {}", file.display(), path.display());
        return machine_file::choose(Some(file), setups, search.near, findings);
    }
    let message = format!("{} was made for {}, and no such file was found", path.display(), stated.words());
    let beside = near.map_or(String::new(), |near| format!("; {} is another one, or has changed", near.display()));
    let help = "name the machine file with --machine; if it has changed, correct the original program again";
    findings.add(Diagnostic::nowhere(Code::STATED_MACHINE_MISSING, message + &beside, help), &[]);
    Ok(None)
}

/// True if the statement is about the embedded machine.
fn is_demo(stated: &StatedMachine, setups: &[PathBuf]) -> Result<bool, Error> {
    let read = machine_file::read(&machine_file::demo()?, setups, &mut Diagnostics::default())?;
    Ok(read.is_some_and(|machine| stated.is(&machine)))
}

/// Machine files in a folder, some hundred at most.
fn machine_files(folder: &Path) -> Vec<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_toml = |path: &PathBuf| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    let is_small = |path: &PathBuf| path.metadata().is_ok_and(|data| data.is_file() && data.len() <= MOST_BYTES);
    files.filter(|path| is_toml(path) && is_small(path)).take(MOST_FILES).collect()
}
