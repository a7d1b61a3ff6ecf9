//! Archives of a control: one file with programs, machine data and tools, read as a folder.
//!
//! Every entry is a record of 512 bytes and its content, filled up to whole records, much like a tape archive: at byte 0 the name on
//! the control (`_N_PART_MPF`), at 50 the name of the file (`PART.MPF`), at 124 its length in decimal digits, at 148 the sum of the
//! record's bytes in decimal digits with this field taken as zeros, at 384 its folder (`\MPF.DIR\`). The first record names the format.
//!
//! An archive as text has a line `%_N_PART_MPF` before every file, and below it its folder: `;$PATH=/_N_MPF_DIR`.

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::files;
use super::folder_library::DEFINITION_FILES;
use crate::error::Error;
use ncfix_base::source::{FileId, MAX_BYTES, Source};
use ncfix_language::exec::Library;

/// Beginning of the first record.
const MAGIC: &[u8] = b"@@MMCIBN";
/// Beginning of an archive as text.
const TEXT_MAGIC: &[u8] = b"%_N_";
/// Beginning of the line with the folder of a file in it.
const TEXT_FOLDER: &str = ";$PATH=";
/// Length of a record.
const RECORD: usize = 512;
/// Folders in which programs are searched after their own folder.
const FOLDERS: [&str; 4] = ["SPF.DIR", "CUS.DIR", "CMA.DIR", "CST.DIR"];
/// Number of names shown if one must be selected.
const SHOWN: usize = 8;

/// A file in an archive.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    /// `PART.MPF`
    name: String,
    /// `WKS.DIR/PART.WPD`
    folder: String,
    content: Range<usize>,
}

/// An archive in memory.
pub(crate) struct Archive {
    path: PathBuf,
    bytes: Vec<u8>,
    entries: Vec<Entry>,
    main: usize,
}

/// Opens the archive at a path or around it (`SAVE.arc/PART.MPF`); `None` if there is no archive.
///
/// # Errors
/// If the archive is damaged, or the path does not determine one of its programs.
pub(crate) fn open(path: &Path) -> Result<Option<Archive>, Error> {
    let Some(file) = path.ancestors().find(|ancestor| ancestor.is_file()) else { return Ok(None) };
    // A text that is named itself is a program, with its subprograms below it.
    let is_text = file != path && begins_with(file, TEXT_MAGIC);
    if !is_text && !is_archive(file) {
        return Ok(None);
    }
    let bytes = files::bytes_of(file, MAX_BYTES).map_err(|error| Error::file("read", file, &error))?;
    let shown = file.display();
    let entries = if is_text { Ok(text_entries(&bytes)) } else { entries(&bytes) }.map_err(|at| {
        Error::usage(format!(
            "{shown} is damaged: at byte {at} there is no entry with a correct checksum; copy it from the control again"
        ))
    })?;
    let member =
        path.strip_prefix(file).ok().map(|rest| rest.display().to_string().replace('\\', "/")).unwrap_or_default();
    let is_meant = |entry: &&Entry| {
        if member.is_empty() {
            return entry.name.to_ascii_uppercase().ends_with(".MPF");
        }
        let full = format!("{}/{}", entry.folder, entry.name);
        entry.name.eq_ignore_ascii_case(&member) || full.eq_ignore_ascii_case(&member)
    };
    let found: Vec<&Entry> = entries.iter().filter(is_meant).collect();
    let main = match found.as_slice() {
        [only] => entries.iter().position(|entry| entry == *only).unwrap_or(0),
        [] if member.is_empty() => return Err(Error::usage(format!("{shown} has no main program"))),
        [] => return Err(Error::usage(format!("{shown} has no file {member}"))),
        several => {
            let mut names: Vec<String> =
                several.iter().map(|entry| format!("{}/{}", entry.folder, entry.name)).collect();
            names.sort();
            let more = if names.len() > SHOWN { " …" } else { "" };
            let list = names.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
            return Err(Error::usage(format!(
                "{shown} has {} such programs; name one after the archive, for example {shown}/{}: {list}{more}",
                names.len(),
                names.first().map_or("", String::as_str)
            )));
        }
    };
    Ok(Some(Archive { path: file.to_path_buf(), bytes, entries, main }))
}

/// True if a file begins like an archive of records.
pub(crate) fn is_archive(file: &Path) -> bool {
    begins_with(file, MAGIC)
}

/// True if a program is in an archive of the control.
pub(crate) fn holds(path: &Path) -> bool {
    let file = path.ancestors().find(|ancestor| ancestor.is_file());
    file.is_some_and(|file| is_archive(file) || (file != path && begins_with(file, TEXT_MAGIC)))
}

fn begins_with(file: &Path, magic: &[u8]) -> bool {
    use std::io::Read as _;
    let mut head = vec![0; magic.len()];
    fs::File::open(file).and_then(|mut file| file.read_exact(&mut head)).is_ok() && head == magic
}

/// The files of an archive as text: each from the line after its name to the next name.
fn text_entries(bytes: &[u8]) -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut at = 0;
    for line in bytes.split_inclusive(|&byte| byte == b'\n') {
        let text = String::from_utf8_lossy(line);
        if line.starts_with(TEXT_MAGIC) {
            let name = file_name(text.split_whitespace().next().unwrap_or_default().trim_start_matches('%'));
            entries.push(Entry { name, folder: String::new(), content: at + line.len()..at + line.len() });
        } else if let Some(last) = entries.last_mut() {
            last.content.end = at + line.len();
            if let Some(folder) = text.trim().strip_prefix(TEXT_FOLDER).filter(|_| last.folder.is_empty()) {
                last.folder =
                    folder.split('/').filter(|part| !part.is_empty()).map(file_name).collect::<Vec<_>>().join("/");
            }
        }
        at += line.len();
    }
    entries
}

/// The name of a file by its name on the control: `PART.MPF` of `_N_PART_MPF`.
fn file_name(on_control: &str) -> String {
    let name = on_control.strip_prefix("_N_").unwrap_or(on_control);
    name.rsplit_once('_').map_or_else(|| name.to_owned(), |(stem, ending)| format!("{stem}.{ending}"))
}

/// All entries after the first record, or the byte offset of an error.
fn entries(bytes: &[u8]) -> Result<Vec<Entry>, usize> {
    let mut entries = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let record = bytes.get(at..at + RECORD).ok_or(at)?;
        let sum: u32 =
            record.iter().enumerate().map(|(k, &byte)| if (148..156).contains(&k) { 0 } else { u32::from(byte) }).sum();
        if number(record, 148..156) != Some(sum as usize) {
            return Err(at);
        }
        let length = number(record, 124..136).ok_or(at)?;
        let start = at + RECORD;
        let content = start..start.checked_add(length).filter(|&end| end <= bytes.len()).ok_or(at)?;
        at = start + length.div_ceil(RECORD) * RECORD;
        let name = text(record, 50..100);
        if !name.is_empty() {
            let folder = text(record, 384..RECORD).trim_matches('\\').replace('\\', "/");
            entries.push(Entry { name, folder, content });
        }
    }
    Ok(entries)
}

/// Data files of an archive in memory: tools, zero offsets, parameters, variables. `None` if the bytes are not an
/// archive.
pub(crate) fn saved_data(path: &Path, bytes: &[u8]) -> Result<Option<Vec<Source>>, Error> {
    const ENDINGS: [&str; 6] = [".TOA", ".UFR", ".RPA", ".GUD", ".INI", ".TMA"];
    let is_data = |file: &Source| {
        let name = file.name().to_ascii_uppercase();
        ENDINGS.iter().any(|ending| name.ends_with(ending))
    };
    Ok(members(path, bytes)?.map(|files| files.into_iter().filter(is_data).collect()))
}

/// All files of an archive in memory. `None` if the bytes are not an archive.
pub(crate) fn members(path: &Path, bytes: &[u8]) -> Result<Option<Vec<Source>>, Error> {
    if !bytes.starts_with(MAGIC) {
        return Ok(None);
    }
    let shown = path.display();
    let entries = entries(bytes).map_err(|at| Error::usage(format!("{shown} is damaged at byte {at}")))?;
    let content = |entry: Entry| {
        let bytes = bytes.get(entry.content.clone()).unwrap_or_default().to_vec();
        Source::new(FileId(0), &format!("{shown}/{}/{}", entry.folder, entry.name), bytes).ok()
    };
    Ok(Some(entries.into_iter().filter_map(content).collect()))
}

/// The bytes of a field before its first zero.
fn field(record: &[u8], range: Range<usize>) -> &[u8] {
    record.get(range).and_then(|field| field.split(|&byte| byte == 0).next()).unwrap_or_default()
}

fn text(record: &[u8], range: Range<usize>) -> String {
    String::from_utf8_lossy(field(record, range)).trim().to_owned()
}

fn number(record: &[u8], range: Range<usize>) -> Option<usize> {
    text(record, range).parse().ok()
}

impl Archive {
    /// The main program.
    ///
    /// # Errors
    /// If it is too large.
    pub(crate) fn main(&self) -> Result<Source, Error> {
        let (name, bytes) = self.entries.get(self.main).map(|entry| self.content(entry)).unwrap_or_default();
        let too_large = format!("cannot read {name}: it has more than {MAX_BYTES} bytes");
        Source::new(FileId(0), &name, bytes).map_err(|_| Error::usage(too_large))
    }

    /// The archive itself.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    fn content(&self, entry: &Entry) -> (String, Vec<u8>) {
        let shown = format!("{}/{}/{}", self.path.display(), entry.folder, entry.name);
        (shown, self.bytes.get(entry.content.clone()).unwrap_or_default().to_vec())
    }
}

impl Library for Archive {
    fn definitions(&mut self) -> Vec<(String, Vec<u8>)> {
        let is_of = |entry: &&Entry| entry.folder.eq_ignore_ascii_case("DEF.DIR");
        let place = |entry: &Entry| {
            let name = entry.name.to_ascii_uppercase();
            DEFINITION_FILES.iter().position(|known| name.strip_suffix(".DEF") == Some(known))
        };
        let mut found: Vec<(usize, &Entry)> =
            self.entries.iter().filter(is_of).filter_map(|entry| Some((place(entry)?, entry))).collect();
        found.sort_by_key(|&(place, _)| place);
        found.into_iter().map(|(_, entry)| self.content(entry)).collect()
    }

    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)> {
        let own = self.entries.get(self.main).map_or("", |entry| entry.folder.as_str());
        let folders = std::iter::once(own).chain(FOLDERS);
        let found = folders.flat_map(|folder| [(folder, "SPF"), (folder, "MPF")]).find_map(|(folder, ending)| {
            let file = format!("{name}.{ending}");
            self.entries
                .iter()
                .find(|entry| entry.folder.eq_ignore_ascii_case(folder) && entry.name.eq_ignore_ascii_case(&file))
        })?;
        Some(self.content(found))
    }
}
