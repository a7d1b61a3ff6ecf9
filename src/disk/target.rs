//! The target of a text: the file of a name on the command line, through links and folders.

use std::fmt;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::files::{self, is_standard_stream};
use super::fingerprint::Fingerprint;
use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// Symbolic links followed to find a target, as many as Linux follows.
const MAX_LINKS: usize = 40;

/// Destination of a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Standard output.
    Standard,
    /// A file that may exist already; links are followed, so this is the file itself.
    File(OneFile),
    /// A device or a pipe.
    Special(PathBuf),
}

/// A file that a run will write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OneFile {
    /// Its path.
    pub(crate) path: PathBuf,
    /// The file at the path when the run began. A different file is newer and is not replaced.
    pub(crate) before: Option<Fingerprint>,
}

impl Target {
    /// The target of a path on the command line.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(crate) fn new(path: &Path) -> Result<Target, Error> {
        if is_standard_stream(path) {
            return Ok(Target::Standard);
        }
        let path = follow(path)?;
        match fs::metadata(&path) {
            Ok(found) if found.is_dir() => Err(Error::file("write", &path, &io::ErrorKind::IsADirectory.into())),
            Ok(found) if !found.is_file() => Ok(Target::Special(path)),
            Ok(found) if found.permissions().readonly() => {
                Err(Error::usage(format!("cannot write {}: it is write-protected", path.display())))
            }
            Ok(found) => Ok(Target::File(OneFile { before: Some(Fingerprint::of(&found)), path })),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                if folder_of(&path).is_dir() {
                    Ok(Target::File(OneFile { path, before: None }))
                } else {
                    Err(Error::file("write", &path, &error))
                }
            }
            Err(error) => Err(Error::file("write", &path, &error)),
        }
    }

    /// Refuses to write a machine file over readings or their description. An input of this run has its own refusal.
    ///
    /// # Errors
    /// If such a file is there.
    pub(crate) fn must_be_machine_file(&self) -> Result<(), Error> {
        let Target::File(file) = self else { return Ok(()) };
        let is_toml = file.path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
        let is_other = |bytes: Vec<u8>| {
            let begins = |line: &[u8], text: &[u8]| line.trim_ascii_start().starts_with(text);
            let has = |text: &[u8]| bytes.split(|byte| *byte == b'\n').any(|line| begins(line, text));
            has(b"[measurement]") || !is_toml && !bytes.trim_ascii().is_empty() && !has(b"[machine]")
        };
        let is_input = || files::first_read(|path| self.is(path)).is_some();
        if fs::read(&file.path).is_ok_and(is_other) && !is_input() {
            let shown = file.path.display();
            return Err(Error::usage(format!(
                "{shown} exists and is not a machine file: give -o another name, or remove it"
            )));
        }
        Ok(())
    }

    /// True if the target is the file `other`, with any name or link, also if neither exists yet.
    pub(crate) fn is(&self, other: &Path) -> bool {
        self.path().is_some_and(|path| is_same(path, other))
    }

    /// Its path, if it has one.
    fn path(&self) -> Option<&Path> {
        match self {
            Target::Standard => None,
            Target::File(OneFile { path, .. }) | Target::Special(path) => Some(path),
        }
    }

    /// True if it is a file; it is written only when its content is complete.
    pub(crate) fn is_file(&self) -> bool {
        matches!(self, Target::File(_))
    }

    /// True if both are one file.
    pub(crate) fn is_also(&self, other: &Target) -> bool {
        matches!(other, Target::File(file) if self.is_file() && self.is(&file.path))
    }
}

impl fmt::Display for Target {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.path() {
            None => out.write_str("standard output"),
            Some(path) => path.display().fmt(out),
        }
    }
}

/// Follows symbolic links, including one to a file that does not exist yet.
fn follow(path: &Path) -> Result<PathBuf, Error> {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        // The path of a pipe or device need not be resolved: `/dev/stdout`.
        if fs::metadata(&path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            return Ok(path);
        }
        match fs::read_link(&path) {
            Ok(link) => path = folder_of(&path).join(link),
            Err(_) => return Ok(path),
        }
    }
    Err(Error::usage(format!("cannot write {}: too many links", path.display())))
}

/// The folder of a file, `.` for a bare name.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// True if two paths are one file, with any name or link, also if neither exists yet.
pub(crate) fn is_same(one: &Path, other: &Path) -> bool {
    is_same_file(one, other) || is_same_name(one, other)
}

/// True if two paths lead to one file: the same path, or two names (hard links) of it.
pub(crate) fn is_same_file(one: &Path, other: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        if let (Ok(one), Ok(other)) = (fs::metadata(one), fs::metadata(other)) {
            return (one.dev(), one.ino()) == (other.dev(), other.ino());
        }
    }
    matches!((fs::canonicalize(one), fs::canonicalize(other)), (Ok(one), Ok(other)) if one == other)
}

/// True if two paths would be one file: the same name in one folder. Some file systems ignore case.
fn is_same_name(one: &Path, other: &Path) -> bool {
    let name = |path: &Path| path.file_name().map(|name| name.to_string_lossy().to_lowercase());
    let is_missing = !one.exists() && !other.exists();
    is_missing && name(one) == name(other) && is_same_file(folder_of(one), folder_of(other))
}

/// Reports an output that would overwrite one of the input files.
pub(crate) fn protect<'f>(target: &Target, files: impl IntoIterator<Item = &'f PathBuf>, findings: &mut Diagnostics) {
    protect_with(target, files, "choose another output", findings);
}

/// The protection of the input program, for a command that can overwrite it.
pub(crate) fn protect_program<'f>(
    target: &Target,
    files: impl IntoIterator<Item = &'f PathBuf>,
    findings: &mut Diagnostics,
) {
    let help = "choose another output; to overwrite the program itself and keep it as a .bak file, give --in-place instead of -o";
    protect_with(target, files, help, findings);
}

fn protect_with<'f>(
    target: &Target,
    files: impl IntoIterator<Item = &'f PathBuf>,
    help: &str,
    findings: &mut Diagnostics,
) {
    if let Some(file) = files.into_iter().find(|file| target.is(file)) {
        findings.add(
            Diagnostic::nowhere(
                Code::WRONG_FILE,
                format!("the output would overwrite {}, which is an input of this run", file.display()),
                help,
            ),
            &[],
        );
    }
}
