//! Writes a file completely or not at all.
//!
//! The text is first spooled to a file without a name, so that an error, an interrupt or a crash leaves no file. Only
//! a complete text, flushed to the disk, gets a name in the folder of the target and replaces it; if the system
//! cannot give a name to such a file, a copy is made. It only replaces the file that was there when the run began. A
//! target that is not a plain file (standard output, a device, a pipe) gets the complete text directly.

use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek as _, Write as _};
use std::path::PathBuf;

use super::files;
pub(crate) use super::replace::Old;
use super::replace::{Put, backups, replace, without_name};
use super::target::folder_of;
pub(crate) use super::target::{OneFile, Target, is_same, is_same_file, protect, protect_program};
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// Size of the write buffer, bytes.
const BUFFER: usize = 1 << 16;

/// A text on its way to a target.
pub(crate) struct Spool {
    file: BufWriter<File>,
    target: Target,
}

impl Spool {
    /// An empty spool in the folder of the target, because that disk must have room for it anyway.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub(crate) fn new(target: Target) -> Result<Spool, Error> {
        let file = match &target {
            Target::Standard | Target::Special(_) => tempfile::tempfile(),
            Target::File(file) => without_name(folder_of(&file.path)),
        };
        let file = file.map_err(|error| target_fault(&target, &error))?;
        Ok(Spool { file: BufWriter::with_capacity(BUFFER, file), target })
    }

    /// The writer of the text.
    pub(crate) fn writer(&mut self) -> &mut (dyn io::Write + Send) {
        &mut self.file
    }

    /// The target of the text.
    pub(crate) fn target(&self) -> &Target {
        &self.target
    }

    /// The error of a failed write.
    pub(crate) fn fault(&self, error: &io::Error) -> Error {
        target_fault(&self.target, error)
    }

    /// Reads the text so far.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn text(&mut self) -> Result<Vec<u8>, Error> {
        let mut text = Vec::new();
        let read = self.file.rewind().and_then(|()| self.file.get_mut().read_to_end(&mut text));
        read.map_err(|error| self.fault(&error))?;
        Ok(text)
    }

    /// Refuses to overwrite files that this run has read.
    ///
    /// # Errors
    /// If it would; the message names the file.
    pub(crate) fn spare_inputs(&self) -> Result<(), Error> {
        match files::first_read(|path| self.target.is(path)) {
            None => Ok(()),
            Some(path) => {
                let path = path.display();
                Err(Error::usage(format!(
                    "the output would overwrite {path}, which is an input of this run; choose another output"
                )))
            }
        }
    }

    /// Flushes the text to the disk, so that there is room for it when it is published.
    ///
    /// # Errors
    /// If there is no room.
    pub(crate) fn settle(&mut self) -> Result<(), Error> {
        let settled = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        settled.map_err(|error| self.fault(&error))
    }

    /// Refuses to overwrite a file that was written after the run began.
    ///
    /// # Errors
    /// If there is such a file, or the check fails.
    pub(crate) fn is_expected(&self, old: Old<'_>) -> Result<(), Error> {
        let Target::File(file) = &self.target else { return Ok(()) };
        match old.expected(file).is(&file.path) {
            Ok(true) => Ok(()),
            Ok(false) => Err(newer(file, old)),
            Err(error) => Err(self.fault(&error)),
        }
    }

    /// Puts the complete text at its target. Returns the path of the old file if it is kept.
    ///
    /// # Errors
    /// If it cannot be written, or a newer file is there; the target is then unchanged.
    pub(crate) fn publish(self, old: Old<'_>) -> Result<Option<PathBuf>, Error> {
        if old == Old::Replaced {
            self.spare_inputs()?;
        }
        let Spool { file, target } = self;
        let fault = |error: io::Error| target_fault(&target, &error);
        let mut text = file.into_inner().map_err(|error| fault(error.into_error()))?;
        text.rewind().map_err(fault)?;
        match &target {
            Target::Standard => {
                files::before_stream();
                let mut out = io::stdout().lock();
                io::copy(&mut text, &mut out).and_then(|_| out.flush()).map_err(fault)?;
                Ok(None)
            }
            Target::Special(path) => {
                let mut out = File::options().write(true).open(path).map_err(fault)?;
                io::copy(&mut text, &mut out).map_err(fault)?;
                Ok(None)
            }
            Target::File(file) => match replace(&mut text, file, old) {
                Ok(Put::There(backup)) => Ok(backup),
                Ok(Put::Newer) => Err(newer(file, old)),
                Err(error) => Err(fault(error)),
            },
        }
    }
}

/// The diagnostic for a newer file at the target of an output.
fn newer(file: &OneFile, old: Old<'_>) -> Error {
    let path = file.path.display();
    let message = match (old, file.before) {
        (Old::Kept(_), _) => format!("{path} has changed since this run read it"),
        (Old::Replaced, Some(_)) => format!("{path} has changed since this run began"),
        (Old::Replaced, None) => format!("{path} was created after this run began"),
    };
    let help = "the current file is kept; check it, then run the command again";
    Error::one(Diagnostic::nowhere(Code::NEWER_FILE, message, help))
}

/// The reason why a target cannot be written.
fn target_fault(target: &Target, error: &io::Error) -> Error {
    match target {
        Target::Standard => Error::output(error),
        Target::File(OneFile { path, .. }) | Target::Special(path) => Error::file("write", path, error),
    }
}

/// The name of the next backup of a target.
pub(crate) fn next_backup(target: &Target) -> Option<PathBuf> {
    let Target::File(file) = target else { return None };
    backups(&file.path).find(|backup| std::fs::symlink_metadata(backup).is_err())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    fn spool(path: &Path, text: &str) -> Spool {
        let mut spool = Spool::new(Target::new(path).unwrap()).unwrap();
        spool.writer().write_all(text.as_bytes()).unwrap();
        spool
    }

    fn write(path: &Path, text: &str, keep_backup: bool) -> Option<PathBuf> {
        let before = fs::read(path).unwrap_or_default();
        let old = if keep_backup { Old::Kept(&before) } else { Old::Replaced };
        spool(path, text).publish(old).unwrap()
    }

    #[test]
    fn nothing_newer_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mpf");
        let is_newer = |put: Result<Option<PathBuf>, Error>| {
            let code = put.as_ref().err().and_then(Error::code);
            assert_eq!(code, Some(Code::NEWER_FILE), "{put:?}");
            let left: Vec<String> = names(folder.path()).into_iter().filter(|name| name != "a.mpf").collect();
            assert_eq!(left, [""; 0]);
            fs::read_to_string(&path).unwrap()
        };
        // The file was created meanwhile.
        let ours = spool(&path, "ours");
        fs::write(&path, "theirs").unwrap();
        assert!(ours.is_expected(Old::Replaced).is_err_and(|error| error.code() == Some(Code::NEWER_FILE)));
        assert_eq!(is_newer(ours.publish(Old::Replaced)), "theirs");
        // The file was written, in place and by another file.
        let ours = spool(&path, "ours");
        fs::write(&path, "their second").unwrap();
        assert_eq!(is_newer(ours.publish(Old::Kept(b"theirs"))), "their second");
        let ours = spool(&path, "ours");
        fs::write(folder.path().join("new"), "their third").unwrap();
        fs::rename(folder.path().join("new"), &path).unwrap();
        assert_eq!(is_newer(ours.publish(Old::Replaced)), "their third");
        // The file was written after the run had read it, but before the run checked the target.
        assert_eq!(is_newer(spool(&path, "ours").publish(Old::Kept(b"what we read"))), "their third");
        // Only one of two simultaneous runs may write.
        let (one, two) = (spool(&path, "one"), spool(&path, "two"));
        let backup = one.publish(Old::Kept(b"their third")).unwrap().unwrap();
        let code = two.publish(Old::Kept(b"their third")).err().and_then(|error| error.code());
        assert_eq!(code, Some(Code::NEWER_FILE));
        assert_eq!(fs::read_to_string(&path).unwrap(), "one");
        assert_eq!(fs::read_to_string(backup).unwrap(), "their third");
        assert_eq!(names(folder.path()), ["a.mpf", "a.mpf.bak"]);
    }

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn nothing_is_seen_before_the_text_is_complete() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.mpf");
        let mut spool = Spool::new(Target::new(&path).unwrap()).unwrap();
        spool.writer().write_all(&vec![b'X'; 3 * BUFFER]).unwrap();
        assert_eq!(names(folder.path()), [""; 0]);
        drop(spool);
        assert_eq!(names(folder.path()), [""; 0]);
        write(&path, "N10 M30\n", false);
        assert_eq!(names(folder.path()), ["out.mpf"]);
        assert_eq!(fs::read(&path).unwrap(), b"N10 M30\n");
    }

    #[test]
    fn backups_are_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.mpf");
        for text in ["one", "two", "three"] {
            write(&path, text, true);
        }
        assert_eq!(names(folder.path()), ["a.mpf", "a.mpf.bak", "a.mpf.bak1"]);
        let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap();
        assert_eq!(
            (read("a.mpf"), read("a.mpf.bak"), read("a.mpf.bak1")),
            ("three".into(), "one".into(), "two".into())
        );
    }

    #[test]
    fn folders_are_no_targets() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Target::new(folder.path()).is_err());
        assert!(Target::new(&folder.path().join("missing/out.mpf")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        symlink("file", &link).unwrap();
        write(&link, "new", false);
        assert_eq!(fs::read_to_string(&file).unwrap(), "new");
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        write(&link, "newer", false);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&file).unwrap(), "newer");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    }

    #[cfg(unix)]
    #[test]
    fn two_names_of_a_file_are_the_same_file() {
        let folder = tempfile::tempdir().unwrap();
        let (one, two, three) = (folder.path().join("1"), folder.path().join("2"), folder.path().join("3"));
        fs::write(&one, "x").unwrap();
        fs::write(&three, "x").unwrap();
        fs::hard_link(&one, &two).unwrap();
        assert!(Target::new(&two).unwrap().is(&one));
        assert!(!Target::new(&three).unwrap().is(&one));
        assert!(!Target::new(&folder.path().join("4")).unwrap().is(&one));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_and_not_replaced() {
        assert_eq!(Target::new(Path::new("/dev/null")).unwrap(), Target::Special("/dev/null".into()));
        write(Path::new("/dev/null"), "x", true);
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
