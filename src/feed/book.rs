//! The file of a journal: append-only, written to the disk by a separate thread, so that a slow disk delays no line.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Read as _, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread;

use crate::diagnostics::Diagnostics;
use crate::error::Error;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_dnc::feed::{HeadKey, JournalContents, JournalEnd, Store, read_journal};

/// A file that another thread writes.
pub(super) struct Book {
    file: File,
    ask: SyncSender<()>,
    fault: Arc<Mutex<Option<io::Error>>>,
}

/// Checks whether a journal may be written at the path: a journal of a job that ended without an error, or of which no line was sent, is replaced;
/// any other file is not.
///
/// # Errors
/// If the file cannot be read.
pub(crate) fn check(path: &Path, findings: &mut Diagnostics) -> Result<(), Error> {
    let shown = path.display();
    if std::fs::metadata(path).is_ok_and(|data| !data.is_file()) {
        let message = format!("{shown} is not a file");
        findings.add(Diagnostic::nowhere(Code::UNFINISHED_JOB, message, "give a file with --journal"), &[]);
        return Ok(());
    }
    if is_held(path) {
        let message = format!("{shown} is the journal of a job that is running");
        let help = "wait until it ends, or give another file with --journal";
        findings.add(Diagnostic::nowhere(Code::UNFINISHED_JOB, message, help), &[]);
        return Ok(());
    }
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(Error::file("read", path, &error)),
    };
    let (message, help) = match read_journal(&text) {
        Ok(told) if gives_way(&told) => return Ok(()),
        Ok(told) => (
            format!(
                "{shown} is the journal of an aborted job: {} lines sent, {} acknowledged",
                told.frozen, told.acknowledged
            ),
            format!(
                "{}; or delete this journal, or give another file with --journal",
                next_step(path, told.head.iter().any(|(key, word)| *key == HeadKey::Argument && word == "--zero-now"))
            ),
        ),
        Err(_) => (format!("{shown} exists and is not a journal"), "give another file with --journal".to_owned()),
    };
    findings.add(Diagnostic::nowhere(Code::UNFINISHED_JOB, message, help), &[]);
    Ok(())
}

/// Advice to a user after an aborted job.
pub(crate) fn next_step(journal: &Path, is_zeroed_at_start: bool) -> String {
    let shown = journal.display();
    if is_zeroed_at_start {
        // Its temperatures count from its start, which is over.
        return format!(
            "a job with --zero-now cannot be resumed: touch off the workpiece zero again, remove {shown}, and feed the program from its beginning"
        );
    }
    format!("`ncfix resume {shown} --clearance HEIGHT` shows how to resume the job")
}

/// True if a job has a journal open.
pub(crate) fn is_held(path: &Path) -> bool {
    let file = File::open(path);
    file.is_ok_and(|file| matches!(file.try_lock_shared(), Err(TryLockError::WouldBlock)))
}

/// Notes in an old journal that its job was resumed in another one, so that it cannot be resumed from the old one.
fn supersede(mut file: &File, bytes: &[u8], path: &Path) -> io::Result<()> {
    let is_done = String::from_utf8_lossy(bytes).lines().last().is_some_and(|line| line.ends_with(" E done"));
    if is_done {
        return Ok(());
    }
    // The end of the last complete record; a record may be cut off after it.
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    file.set_len(whole as u64)?;
    writeln!(file, "0 E {}", JournalEnd::TakenUp(path.display().to_string()))?;
    file.sync_data()
}

/// True if an open file is still the one at its path: another job may have put its own journal there meanwhile.
#[cfg(unix)]
fn is_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let of = |data: std::fs::Metadata| (data.dev(), data.ino());
    file.metadata().ok().map(of) == std::fs::metadata(path).ok().map(of)
}

/// The check on systems where an open file keeps its name.
#[cfg(not(unix))]
fn is_there(_file: &File, path: &Path) -> bool {
    path.exists()
}

/// Moves an old journal out of the way of a new one, while it is locked. `expected` is the content of the journal from which its job is resumed.
fn take(path: &Path, expected: Option<&[u8]>) -> Result<(), Error> {
    let fault = |error: &io::Error| Error::file("write", path, error);
    let file = match OpenOptions::new().read(true).append(true).open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == io::ErrorKind::NotFound && expected.is_none() => return Ok(()),
        Err(error) => return Err(fault(&error)),
    };
    let running = || Error::usage(format!("{} is the journal of a job that is running", path.display()));
    match file.try_lock() {
        Ok(()) if is_there(&file, path) => {}
        Ok(()) | Err(TryLockError::WouldBlock) => return Err(running()),
        Err(TryLockError::Error(error)) => return Err(fault(&error)),
    }
    let mut bytes = Vec::new();
    (&file).read_to_end(&mut bytes).map_err(|error| fault(&error))?;
    let is_free = match expected {
        Some(expected) => bytes == expected,
        None => read_journal(&String::from_utf8_lossy(&bytes)).is_ok_and(|told| gives_way(&told)),
    };
    if !is_free {
        return Err(Error::usage(format!("{} has changed meanwhile: check it again", path.display())));
    }
    std::fs::rename(path, kept(path)).and_then(|()| supersede(&file, &bytes, path)).map_err(|error| fault(&error))
}

/// True if a journal may be replaced by that of a new job: its job ended without an error, or none of its lines was sent or can have run. A journal of a job that
/// itself resumed another one is kept even if none of its lines was sent.
fn gives_way(told: &JournalContents) -> bool {
    matches!(told.ended, Some(JournalEnd::Done | JournalEnd::NotStarted(_)))
        || told.frozen == 0 && told.head.iter().all(|(key, _)| *key != HeadKey::Resumed)
}

/// A free name for an old journal.
fn kept(path: &Path) -> PathBuf {
    let name = |number: Option<u32>| {
        let mut name = path.as_os_str().to_owned();
        name.push(".old");
        name.push(number.map_or(String::new(), |number| number.to_string()));
        PathBuf::from(name)
    };
    std::iter::once(None).chain((1..).map(Some)).map(name).find(|name| !name.exists()).unwrap_or_else(|| name(None))
}

impl Book {
    /// Begins a journal. It replaces that of a finished job or, with the bytes of its journal, of a resumed one,
    /// which is kept as `….old`, `….old1` …. The lock is held from here on: this happens before all operations that
    /// may wait.
    ///
    /// # Errors
    /// If it cannot be written, is that of a job that is running, or has changed.
    pub(super) fn create(path: &Path, expected: Option<&[u8]>) -> Result<Book, Error> {
        let fault = |error: &io::Error| Error::file("write", path, error);
        take(path, expected)?;
        let file = OpenOptions::new().append(true).create_new(true).open(path).map_err(|error| fault(&error))?;
        // The lock prevents that another job resumes it.
        file.try_lock().map_err(|error| Error::usage(format!("cannot lock {}: {error}", path.display())))?;
        let second = file.try_clone().map_err(|error| fault(&error))?;
        let (ask, asked) = sync_channel::<()>(1);
        let shared = Arc::new(Mutex::new(None));
        let to = Arc::clone(&shared);
        thread::spawn(move || {
            while asked.recv().is_ok() {
                if let Err(error) = second.sync_data()
                    && let Ok(mut fault) = to.lock()
                {
                    *fault = Some(error);
                }
            }
        });
        Ok(Book { file, ask, fault: shared })
    }

    /// Writes everything and waits for it.
    pub(super) fn close(&mut self) -> io::Result<()> {
        self.file.sync_data()
    }
}

impl Write for Book {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Store for Book {
    fn sync(&mut self) -> io::Result<()> {
        if let Some(error) = self.fault.lock().ok().and_then(|mut fault| fault.take()) {
            return Err(error);
        }
        match self.ask.try_send(()) {
            // One waiting request is sufficient.
            Ok(()) | Err(TrySendError::Full(())) => Ok(()),
            Err(TrySendError::Disconnected(())) => {
                Err(io::Error::other("the journal can no longer be written to the disk"))
            }
        }
    }
}
