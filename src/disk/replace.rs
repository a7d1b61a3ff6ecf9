//! Puts a complete text at the path of a file, replacing only the expected file and never a newer one.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use super::fingerprint::Expected;
use super::target::{OneFile, folder_of};

/// Permissions of a new file before the umask is applied.
#[cfg(unix)]
const NEW_FILE: u32 = 0o666;

/// Handling of an existing file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Old<'a> {
    /// It is replaced.
    Replaced,
    /// It is kept as a backup. The run has read the file, and this is its complete content.
    Kept(&'a [u8]),
}

impl<'a> Old<'a> {
    /// The file that must be at the path for it to be written.
    pub(crate) fn expected(self, file: &OneFile) -> Expected<'a> {
        let content = if let Old::Kept(content) = self { Some(content) } else { None };
        Expected { before: file.before, content }
    }
}

/// The result for a text.
pub(crate) enum Put {
    /// It is in its place; the path of the old file if it is kept.
    There(Option<PathBuf>),
    /// A newer file is there.
    Newer,
}

/// A file without a name in a folder, removed when it is closed, with the permissions of any new file.
pub(crate) fn without_name(folder: &Path) -> io::Result<File> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{Mode, OFlags, open};
        // Not every file system supports such files; other errors of the folder are reported later.
        let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
        if let Ok(file) = open(folder, flags, Mode::from_raw_mode(NEW_FILE)) {
            return Ok(file.into());
        }
    }
    tempfile::tempfile_in(folder)
}

/// Gives a file without a name a free name in the folder of the target.
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

/// Other systems cannot give a name to a file without one.
#[cfg(not(target_os = "linux"))]
fn name_beside(_: &File, _: &tempfile::Builder<'_, '_>, _: &Path) -> io::Result<tempfile::TempPath> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Gives the text a name in the folder of its target and moves it to the path of the target.
pub(crate) fn replace(text: &mut File, target: &OneFile, old: Old<'_>) -> io::Result<Put> {
    let path = &target.path;
    let mut names = tempfile::Builder::new();
    names.prefix(".ncfix-").suffix(".tmp");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // The umask is applied, as for any new file. Otherwise a temporary file is private to its owner.
        names.permissions(fs::Permissions::from_mode(NEW_FILE));
    }
    let finish = |file: &File| {
        if let Ok(existing) = fs::metadata(path) {
            file.set_permissions(existing.permissions())?;
        }
        file.sync_all()
    };
    // Flushed first, so that few calls remain between naming and replacing; a kill between them would leave the file.
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
    let is_kept = matches!(old, Old::Kept(_)) && target.before.is_some();
    let backup = if is_kept && path.exists() { Some(back_up(path)?) } else { None };
    let is_there = take_place(beside, path, old.expected(target));
    if !matches!(is_there, Ok(true)) {
        // Removes the second name of the file, which was not replaced.
        backup.as_ref().map_or(Ok(()), fs::remove_file)?;
        return is_there.map(|_| Put::Newer);
    }
    // The new name is safe only after the folder is flushed. Some systems cannot flush folders; the file is complete
    // anyway.
    if let Ok(folder) = File::open(folder_of(path)) {
        let _ = folder.sync_all();
    }
    Ok(Put::There(backup))
}

/// Renames a file to the path of the expected file; returns true if the expected file was there. Any other file
/// stays.
fn take_place(beside: tempfile::TempPath, path: &Path, expected: Expected<'_>) -> io::Result<bool> {
    if expected.before.is_none() {
        return match beside.persist_noclobber(path) {
            Ok(()) => Ok(true),
            Err(fault) if fault.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(fault) => Err(fault.error),
        };
    }
    if !expected.is(path)? {
        return Ok(false);
    }
    if exchange(&beside, path).is_err() {
        // Not every system supports this. The time between the check and the rename is as short as possible.
        return beside.persist(path).map(|()| true).map_err(|fault| fault.error);
    }
    // Now no other process can change it: the old file has the temporary name.
    if expected.is(&beside)? {
        return Ok(true);
    }
    exchange(&beside, path)?;
    Ok(false)
}

/// Exchanges two files atomically, so that neither is ever without a name.
#[cfg(target_os = "linux")]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE).map_err(io::Error::from)
}

/// Other systems have no such call.
#[cfg(not(target_os = "linux"))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The names of copies of a file, `NAME.bak`, `NAME.bak1` …
pub(crate) fn backups(path: &Path) -> impl Iterator<Item = PathBuf> {
    (0_u32..).map(move |number| {
        let mut name = path.as_os_str().to_owned();
        name.push(".bak");
        if number > 0 {
            name.push(number.to_string());
        }
        PathBuf::from(name)
    })
}

/// Gives the file a second name that does not exist yet, so that a rename over the first name keeps it.
fn back_up(path: &Path) -> io::Result<PathBuf> {
    for backup in backups(path) {
        let made = fs::hard_link(path, &backup).or_else(|error| {
            // On disks without hard links a copy is made.
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

/// Copies to a new file.
fn copy_new(from: &Path, to: &Path) -> io::Result<()> {
    let mut copy = File::options().write(true).create_new(true).open(to)?;
    io::copy(&mut File::open(from)?, &mut copy)?;
    copy.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn files_change_places() {
        let folder = tempfile::tempdir().unwrap();
        let (path, beside) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, "first").unwrap();
        fs::write(&beside, "ours").unwrap();
        exchange(&beside, &path).unwrap();
        assert_eq!(
            (fs::read_to_string(&path).unwrap(), fs::read_to_string(&beside).unwrap()),
            ("ours".into(), "first".into())
        );
    }
}
