//! The fingerprint of a file when a run first saw it, so that a run never replaces a newer file.

use std::fs::{self, Metadata};
use std::io;
use std::path::Path;
use std::time::SystemTime;

/// Identity, length and modification time of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Fingerprint {
    length: u64,
    modified: Option<SystemTime>,
    /// Device and inode of the file; a text editor that writes a new file and renames it changes them.
    identity: Option<(u64, u64)>,
}

impl Fingerprint {
    /// The fingerprint of an open file.
    pub(crate) fn of(found: &Metadata) -> Fingerprint {
        #[cfg(unix)]
        let identity = {
            use std::os::unix::fs::MetadataExt as _;
            Some((found.dev(), found.ino()))
        };
        #[cfg(not(unix))]
        let identity = None;
        Fingerprint { length: found.len(), modified: found.modified().ok(), identity }
    }

    /// The fingerprint of the file at a path; `None` if there is no file.
    ///
    /// # Errors
    /// If it cannot be determined.
    pub(crate) fn at(path: &Path) -> io::Result<Option<Fingerprint>> {
        match fs::metadata(path) {
            Ok(found) => Ok(Some(Fingerprint::of(&found))),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(error),
        }
    }
}

/// The file that a run expects at the path of its output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Expected<'a> {
    /// The file at the path when the run began; `None` if there was no file.
    pub(crate) before: Option<Fingerprint>,
    /// Its content, if the run has read it: the clock may be too coarse to show that the file was written again.
    pub(crate) content: Option<&'a [u8]>,
}

impl Expected<'_> {
    /// True if the file is the expected one, with the same content.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn is(&self, path: &Path) -> io::Result<bool> {
        if Fingerprint::at(path)? != self.before {
            return Ok(false);
        }
        match self.content.filter(|_| self.before.is_some()) {
            None => Ok(true),
            Some(content) => Ok(fs::read(path)? == content),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sets the modification time of a file.
    fn touch(path: &Path, time: SystemTime) {
        fs::File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
    }

    #[test]
    fn length_time_and_file_tell_that_something_is_newer() {
        let folder = tempfile::tempdir().unwrap();
        let (path, other) = (folder.path().join("part.mpf"), folder.path().join("other"));
        assert_eq!(Fingerprint::at(&path).unwrap(), None);
        fs::write(&path, "N10 X1\n").unwrap();
        let before = Fingerprint::at(&path).unwrap();
        let time = fs::metadata(&path).unwrap().modified().unwrap();
        let expected = Expected { before, content: None };
        assert!(expected.is(&path).unwrap());

        fs::write(&path, "N10 X1\nN20\n").unwrap();
        touch(&path, time);
        assert!(!expected.is(&path).unwrap(), "longer");
        fs::write(&path, "N10 X2\n").unwrap();
        touch(&path, time + std::time::Duration::from_millis(1));
        assert!(!expected.is(&path).unwrap(), "later");
        fs::write(&other, "N10 X1\n").unwrap();
        touch(&other, time);
        fs::rename(&other, &path).unwrap();
        assert_eq!(expected.is(&path).unwrap(), cfg!(not(unix)), "another file of the same time and length");
        fs::remove_file(&path).unwrap();
        assert!(!expected.is(&path).unwrap(), "gone");
        assert!(Expected { before: None, content: Some(b"N10 X1\n") }.is(&path).unwrap());
    }

    #[test]
    fn content_tells_what_no_clock_tells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.mpf");
        fs::write(&path, "N10 X1\n").unwrap();
        let before = Fingerprint::at(&path).unwrap();
        let time = fs::metadata(&path).unwrap().modified().unwrap();
        fs::write(&path, "N10 X9\n").unwrap();
        touch(&path, time);
        assert!(Expected { before, content: None }.is(&path).unwrap());
        assert!(!Expected { before, content: Some(b"N10 X1\n") }.is(&path).unwrap());
        assert!(Expected { before, content: Some(b"N10 X9\n") }.is(&path).unwrap());
    }
}
