//! Reads program and machine files; `-` is standard input.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use super::fingerprint::Fingerprint;
use crate::error::Error;
use ncfix_base::source::{FileId, MAX_BYTES, Source};

/// The name shown for standard input.
pub(crate) const STANDARD_INPUT: &str = "<stdin>";

/// Largest size of a file written by a person, bytes: machine, set-up, state, link or description.
const MAX_WRITTEN_BYTES: usize = 8 << 20;

/// The largest number of bytes read from a pipe or a device, which have no known length.
const MAX_STREAM_BYTES: usize = 1 << 30;

/// True if a path on the command line means standard input or output.
pub(crate) fn is_standard_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Role of a file, and the way in which it was found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FileRole<'a> {
    /// A role, for a note; empty for a file that is read again, without a note.
    Plain(&'a str),
    /// A role with the option or the environment variable that names the file. A message names it too.
    Option(&'a str),
    /// The description of a measurement. No option names it, so a message explains it.
    Description,
}

/// The role of a file that an option or an environment variable names.
pub(crate) const fn option(role: &str) -> FileRole<'_> {
    FileRole::Option(role)
}

impl<'a> From<&'a str> for FileRole<'a> {
    fn from(role: &'a str) -> FileRole<'a> {
        FileRole::Plain(role)
    }
}

impl<'a> FileRole<'a> {
    fn text(self) -> &'a str {
        match self {
            FileRole::Plain(role) | FileRole::Option(role) => role,
            FileRole::Description => DESCRIPTION,
        }
    }
}

/// Text of [`FileRole::Description`].
const DESCRIPTION: &str = "the description of the readings in the .csv: its instrument and set-up. If the .csv is the export of an instrument, `ncfix import` makes both files from it. Else a text file with two lines, [measurement] and kind = \"displacement\", is enough to begin, see docs/reference/data-files.md";

/// Reads the bytes of a file with its displayed name, and notes its role.
///
/// # Errors
/// If the file cannot be read or is too large.
pub(crate) fn read<'a>(path: &Path, id: FileId, role: impl Into<FileRole<'a>>) -> Result<Source, Error> {
    read_up_to(path, id, role.into(), MAX_BYTES)
}

/// Reads a file that people write, which is never large.
///
/// # Errors
/// If the file cannot be read or is too large.
pub(crate) fn read_written<'a>(path: &Path, id: FileId, role: impl Into<FileRole<'a>>) -> Result<Source, Error> {
    read_up_to(path, id, role.into(), MAX_WRITTEN_BYTES)
}

fn read_up_to(path: &Path, id: FileId, role: FileRole<'_>, most: usize) -> Result<Source, Error> {
    let fault = |error: io::Error| {
        let sentence = Error::file("read", path, &error).message().to_owned();
        Error::usage(match role {
            FileRole::Plain(_) => sentence,
            FileRole::Option(role) => format!("{sentence} ({role})"),
            FileRole::Description => format!("{sentence}\n  = help: this file is {DESCRIPTION}"),
        })
    };
    let (name, bytes) = if is_standard_stream(path) {
        before_stream();
        let bytes = bounded(&mut io::stdin().lock(), most.min(MAX_STREAM_BYTES)).map_err(fault)?;
        (STANDARD_INPUT.to_owned(), bytes)
    } else {
        (path.display().to_string(), bytes_of(path, most).map_err(fault)?)
    };
    if !role.text().is_empty() {
        log::info!("read {name}: {}", role.text());
    }
    Source::new(id, &name, bytes).map_err(|_| fault(too_large(MAX_BYTES)))
}

/// The bytes of a file, at most `most`. A file with a larger stated length is not read.
///
/// # Errors
/// If it cannot be read or is larger.
pub(crate) fn bytes_of(path: &Path, most: usize) -> io::Result<Vec<u8>> {
    // Some systems open a folder and then report an unclear error when it is read.
    if path.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    let mut file = File::open(path)?;
    let found = file.metadata()?;
    if !found.is_file() {
        return bounded(&mut file, most.min(MAX_STREAM_BYTES));
    }
    let before = Fingerprint::of(&found);
    if IS_LISTED.load(Ordering::Relaxed) {
        READ.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_path_buf());
    }
    let length = usize::try_from(found.len()).unwrap_or(usize::MAX);
    if length > most {
        return Err(too_large(most));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length)?;
    let bytes = read_bounded(&mut file, most, bytes)?;
    if Fingerprint::of(&file.metadata()?) != before {
        // One part of the file may be old and the other one new.
        return Err(io::Error::other("the file changed while it was read; run the command again"));
    }
    Ok(bytes)
}

/// Called before standard input is read or standard output is written: the command line removes its progress line, so that it does not hide what the
/// user types.
static BEFORE_STREAM: OnceLock<fn()> = OnceLock::new();

/// True if the input files are listed.
static IS_LISTED: AtomicBool = AtomicBool::new(false);

/// Lists the input files from now on, and sets the function that is called before standard input is read, in a
/// process with one run.
pub(crate) fn begin_run(before_stream: fn()) {
    IS_LISTED.store(true, Ordering::Relaxed);
    // A second run in the same process has the same function.
    let _ = BEFORE_STREAM.set(before_stream);
}

/// Call it before standard input is read or standard output is written.
pub(crate) fn before_stream() {
    BEFORE_STREAM.get().inspect(|act| act());
}

/// Files that this run has read, for any option or program.
static READ: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The first input file of this run, by name, that fulfills a condition.
pub(crate) fn first_read(holds: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    let read = READ.lock().unwrap_or_else(PoisonError::into_inner);
    read.iter().find(|path| holds(path)).cloned()
}

fn bounded(reader: &mut dyn io::Read, most: usize) -> io::Result<Vec<u8>> {
    read_bounded(reader, most, Vec::new())
}

/// Reads to the end, or until the limit is exceeded: a file may grow, and a device has no end.
fn read_bounded(reader: &mut dyn io::Read, most: usize, mut bytes: Vec<u8>) -> io::Result<Vec<u8>> {
    reader.take(most as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() > most { Err(too_large(most)) } else { Ok(bytes) }
}

fn too_large(most: usize) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("it has more than {most} bytes"))
}
