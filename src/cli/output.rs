//! Writes a file completely or not at all.
//!
//! The text is first spooled to a file without a name, so that an error, an interrupt or a crash leaves nothing behind. Only a
//! complete text, flushed to the disk, gets a name beside the target and is renamed over it; where a system cannot give a name to such a
//! file, it gets a copy. A target that is no plain file (standard output, a device, a pipe) gets the complete text as it is.

use std::fs::{self, File};
use std::io::{self, BufWriter, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use super::input;
use super::progress;
use super::stop::Stop;
use super::target::folder_of;
pub(super) use super::target::{Target, is_same_file};

/// Bytes gathered before they go to the disk.
const BUFFER: usize = 1 << 16;

/// Permissions of a new file before the umask takes its bits away.
#[cfg(unix)]
const NEW_FILE: u32 = 0o666;

/// A text on its way to a target.
pub(super) struct Spool {
    file: BufWriter<File>,
    target: Target,
}

impl Spool {
    /// An empty spool, in the folder of the target because that disk must have room for it anyway.
    ///
    /// # Errors
    /// A sentence where the folder cannot be written.
    pub(super) fn new(target: Target) -> Result<Spool, Stop> {
        let file = match &target {
            Target::Standard | Target::Special(_) => tempfile::tempfile(),
            Target::File(path) => without_name(folder_of(path)),
        };
        let file = file.map_err(|error| target_fault(&target, &error))?;
        Ok(Spool { file: BufWriter::with_capacity(BUFFER, file), target })
    }

    /// Where the text is written to.
    pub(super) fn writer(&mut self) -> &mut (dyn io::Write + Send) {
        &mut self.file
    }

    /// Where the text will go.
    pub(super) fn target(&self) -> &Target {
        &self.target
    }

    /// The reason of a failed write, in words.
    pub(super) fn fault(&self, error: &io::Error) -> Stop {
        target_fault(&self.target, error)
    }

    /// Reads the text so far.
    ///
    /// # Errors
    /// A sentence where that fails.
    pub(super) fn text(&mut self) -> Result<Vec<u8>, Stop> {
        let mut text = Vec::new();
        let read = self.file.rewind().and_then(|()| self.file.get_mut().read_to_end(&mut text));
        read.map_err(|error| self.fault(&error))?;
        Ok(text)
    }

    /// Refuses to write over what this run has read.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub(super) fn spare_inputs(&self) -> Result<(), Stop> {
        match input::first_read(|path| self.target.is(path)) {
            None => Ok(()),
            Some(path) => {
                let path = path.display();
                Err(Stop::Usage(format!(
                    "the output would overwrite {path}, which is an input of this run; choose another output"
                )))
            }
        }
    }

    /// Brings the text to the disk: what is published then has room there.
    ///
    /// # Errors
    /// A sentence where there is none.
    pub(super) fn settle(&mut self) -> Result<(), Stop> {
        let settled = self.file.flush().and_then(|()| self.file.get_ref().sync_all());
        settled.map_err(|error| self.fault(&error))
    }

    /// Puts the complete text in its place. With `keep_backup` an existing target stays as a `.bak` file, whose path is returned.
    ///
    /// # Errors
    /// A sentence where that fails; the target is then as it was before.
    pub(super) fn publish(self, keep_backup: bool) -> Result<Option<PathBuf>, Stop> {
        if !keep_backup {
            self.spare_inputs()?;
        }
        let Spool { file, target } = self;
        let fault = |error: io::Error| target_fault(&target, &error);
        let mut text = file.into_inner().map_err(|error| fault(error.into_error()))?;
        text.rewind().map_err(fault)?;
        match &target {
            Target::Standard => {
                progress::end();
                let mut out = io::stdout().lock();
                io::copy(&mut text, &mut out).and_then(|_| out.flush()).map_err(fault)?;
                Ok(None)
            }
            Target::Special(path) => {
                let mut out = File::options().write(true).open(path).map_err(fault)?;
                io::copy(&mut text, &mut out).map_err(fault)?;
                Ok(None)
            }
            Target::File(path) => replace(&mut text, path, keep_backup).map_err(fault),
        }
    }
}

/// The reason why a target cannot be written.
fn target_fault(target: &Target, error: &io::Error) -> Stop {
    match target {
        Target::Standard => Stop::output(error),
        Target::File(path) | Target::Special(path) => Stop::file("write", path, error),
    }
}

/// A file without a name that is gone when it is closed, in a folder, with the permissions of any new file.
fn without_name(folder: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{Mode, OFlags, open};
        // Not every file system has such files; what else is wrong with the folder shows below.
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        if let Ok(file) = open(folder, flags, Mode::from_raw_mode(NEW_FILE)) {
            return Ok(file.into());
        }
    }
    tempfile::tempfile_in(folder)
}

/// Gives a file without a name one that is free, beside the target.
#[cfg(target_os = "linux")]
fn name_beside(text: &File, names: &tempfile::Builder<'_, '_>, folder: &Path) -> io::Result<tempfile::TempPath> {
    use std::os::fd::AsRawFd as _;
    let open_file = format!("/proc/self/fd/{}", text.as_raw_fd());
    let link = |path: &Path| {
        let (from, to) = (rustix::fs::CWD, rustix::fs::CWD);
        rustix::fs::linkat(from, &open_file, to, path, rustix::fs::AtFlags::SYMLINK_FOLLOW).map_err(io::Error::from)
    };
    names.make_in(folder, link).map(tempfile::NamedTempFile::into_temp_path)
}

/// Elsewhere a file without a name stays without.
#[cfg(not(target_os = "linux"))]
fn name_beside(_: &File, _: &tempfile::Builder<'_, '_>, _: &Path) -> io::Result<tempfile::TempPath> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Names the text beside `path` and renames it over that.
fn replace(text: &mut File, path: &Path, keep_backup: bool) -> io::Result<Option<PathBuf>> {
    let mut names = tempfile::Builder::new();
    names.prefix(".ncfix-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // As for any new file: the umask takes its bits away. Without this a temporary file is private to its owner.
        names.permissions(fs::Permissions::from_mode(NEW_FILE));
    }
    let finish = |file: &File| {
        if let Ok(existing) = fs::metadata(path) {
            file.set_permissions(existing.permissions())?;
        }
        file.sync_all()
    };
    // On the disk first: between its name and the rename there are two calls, in which a kill would leave it behind.
    finish(text)?;
    let beside = match name_beside(text, &names, folder_of(path)) {
        Ok(beside) => beside,
        Err(_) => {
            let mut copy = names.tempfile_in(folder_of(path))?;
            io::copy(text, copy.as_file_mut())?;
            finish(copy.as_file())?;
            copy.into_temp_path()
        }
    };
    let backup = if keep_backup && path.exists() { Some(back_up(path)?) } else { None };
    beside.persist(path).map_err(|error| error.error)?;
    // The new name is safe on the disk only when the folder is. Some systems cannot flush folders; the file is complete anyway.
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
    Ok(backup)
}

/// The names of copies of a file, `NAME.bak`, `NAME.bak1` …
fn backups(path: &Path) -> impl Iterator<Item = PathBuf> {
    (0_u32..).map(move |number| {
        let mut name = path.as_os_str().to_owned();
        name.push(".bak");
        if number > 0 {
            name.push(number.to_string());
        }
        PathBuf::from(name)
    })
}

/// The name that the copy of a target would get now.
pub(super) fn next_backup(target: &Target) -> Option<PathBuf> {
    let Target::File(path) = target else { return None };
    backups(path).find(|backup| fs::symlink_metadata(backup).is_err())
}

/// Gives the file a second name that does not exist yet, so that a rename over the first leaves it.
fn back_up(path: &Path) -> io::Result<PathBuf> {
    for backup in backups(path) {
        let made = fs::hard_link(path, &backup).or_else(|error| {
            // Disks without hard links get a copy.
            if error.kind() == io::ErrorKind::AlreadyExists { Err(error) } else { copy_new(path, &backup) }
        });
        match made {
            Ok(()) => return Ok(backup),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(error),
        }
    }
    Err(io::ErrorKind::AlreadyExists.into())
}

/// Copies to a file that must not exist.
fn copy_new(from: &Path, to: &Path) -> io::Result<()> {
    let mut copy = File::options().write(true).create_new(true).open(to)?;
    io::copy(&mut File::open(from)?, &mut copy)?;
    copy.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(path: &Path, text: &str, keep_backup: bool) -> Option<PathBuf> {
        let mut spool = Spool::new(Target::new(path).unwrap()).unwrap();
        spool.writer().write_all(text.as_bytes()).unwrap();
        spool.publish(keep_backup).unwrap()
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
