//! File that grows, or file that holds a value: `tail` reads rows as they are added, `value` reads the whole file each time (a sensor in sysfs).
//!
//! A line counts once its end has been written. A file that is replaced or truncated is read from its beginning. Rows that existed before ncfix started are
//! as old as the file.

use std::collections::BTreeMap;
use std::fs::{File, Metadata};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime};

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::lines::{LONGEST_LINE, LineReader, Splitter};
use super::super::monitor::SourceReport;
use super::super::outlet::ReadingOutlet;
use super::{Items, Kind, OpenedSource, Polled, SourcePlan, Wanted, items, polled};

/// Number of bytes at the end of an existing file that are searched for its last row.
const LAST: u64 = 1 << 16;
/// Maximum number of bytes that are read at once from a growing file.
const MOST_AT_ONCE: usize = 1 << 20;

pub(super) const KIND: Kind = Kind {
    name: "file",
    title: "a growing file (CSV, JSON lines), or a file with one value",
    is_record: false,
    is_standard_input: false,
    read,
};

#[derive(Debug)]
struct Settings {
    path: String,
    is_value: bool,
    has_times: bool,
    items: Items,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let path = section.required("path", "\"cabinet.csv\"", Section::text)?.to_owned();
    let is_value = match section.text("mode") {
        None | Some("tail") => false,
        Some("value") => true,
        Some(other) => {
            let message = format!("there is no mode '{other}'");
            section.report(Code::BAD_VALUE, section.place_of("mode"), message, "one of \"tail\", \"value\"");
            false
        }
    };
    let has_times = section.boolean("use_time").unwrap_or(true);
    Some(Arc::new(Settings { path, is_value, has_times, items: items(wanted) }))
}

impl SourcePlan for Settings {
    fn open(&self, base: &Path, poll: Duration) -> Result<OpenedSource, String> {
        let (path, lines) = (base.join(&self.path), LineReader::new(&self.items, self.has_times));
        Ok(if self.is_value {
            polled(Whole { path, lines }, poll)
        } else {
            polled(Tail { path, lines, splitter: Splitter::default(), open: None, looked: SystemTime::now() }, poll)
        })
    }
}

/// Describes why a file cannot be read.
fn fault(path: &Path, error: &io::Error) -> String {
    let reason =
        if error.kind() == io::ErrorKind::NotFound { "there is no such file".to_owned() } else { error.to_string() };
    format!("{}: {reason}", path.display())
}

/// File that holds a value.
struct Whole {
    path: PathBuf,
    lines: LineReader,
}

impl Polled for Whole {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        let mut bytes = Vec::new();
        let file = File::open(&self.path).map_err(|error| fault(&self.path, &error))?;
        // Files of the kernel are created on reading; the age of any other file follows from its modification time.
        let is_of_kernel = self.path.starts_with("/sys") || self.path.starts_with("/proc");
        let written = file.metadata().and_then(|data| data.modified()).ok().filter(|_| !is_of_kernel);
        file.take(LONGEST_LINE as u64).read_to_end(&mut bytes).map_err(|error| fault(&self.path, &error))?;
        if bytes.trim_ascii().is_empty() {
            return Err(format!("{}: the file is empty", self.path.display()));
        }
        self.lines.forget_header();
        for line in bytes.split(|&byte| byte == b'\n') {
            self.lines.read(line, &mut |channel, told, stamp| outlet.tell(channel, told, stamp.or(written)));
        }
        Ok(())
    }
}

/// File that grows.
struct Tail {
    path: PathBuf,
    lines: LineReader,
    splitter: Splitter,
    /// The open file, its identity, and the number of bytes that were read.
    open: Option<(File, Identity, u64)>,
    /// Time of the last look.
    looked: SystemTime,
}

/// Identity of a file, if the system provides it.
type Identity = (u64, u64);

fn identity(data: &Metadata) -> Identity {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        (data.dev(), data.ino())
    }
    #[cfg(not(unix))]
    {
        let _ = data;
        (0, 0)
    }
}

impl Polled for Tail {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        let path = self.path.clone();
        let no = |error: io::Error| fault(&path, &error);
        // Bytes that were written to a file before it was replaced belong to its rows.
        let grown = self.grow(outlet).map_err(no);
        let data = std::fs::metadata(&self.path).map_err(no)?;
        grown?;
        let is_other = match &self.open {
            Some((_, known, done)) => *known != identity(&data) || data.len() < *done,
            None => true,
        };
        if is_other {
            self.begin(outlet).map_err(no)?;
        }
        Ok(())
    }
}

impl Tail {
    /// Reads added bytes.
    fn grow(&mut self, outlet: &ReadingOutlet) -> io::Result<()> {
        let Some((file, _, done)) = &mut self.open else { return Ok(()) };
        if file.metadata()?.len() < *done {
            // It was truncated and is read again from the beginning.
            return Ok(());
        }
        // New bytes were written since the last look, regardless of the clock of another computer.
        let (before, now) = (std::mem::replace(&mut self.looked, SystemTime::now()), SystemTime::now());
        let written = file.metadata()?.modified().unwrap_or(now).max(before).min(now);
        let mut bytes = vec![0; 1 << 14];
        for _ in 0..MOST_AT_ONCE / bytes.len() {
            let count = file.read(&mut bytes)?;
            *done += count as u64;
            let lines = &mut self.lines;
            let mut tell = |channel, told, stamp: Option<_>| outlet.tell(channel, told, stamp.or(Some(written)));
            self.splitter.take(bytes.get(..count).unwrap_or_default(), &mut |line| lines.read(line, &mut tell));
            if count < bytes.len() {
                break;
            }
        }
        Ok(())
    }

    /// Opens a file; of its existing rows the last one of each channel counts.
    fn begin(&mut self, outlet: &ReadingOutlet) -> io::Result<()> {
        self.open = None;
        self.splitter.clear();
        self.lines.forget_header();
        let mut file = File::open(&self.path)?;
        let data = file.metadata()?;
        if data.is_dir() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        let mut last: BTreeMap<usize, (SourceReport, Option<SystemTime>)> = BTreeMap::new();
        let lines = &mut self.lines;
        let mut tell = |channel: usize, told: SourceReport, stamp: Option<SystemTime>| {
            last.insert(channel, (told, stamp));
        };
        let mut done = 0;
        if data.len() > 2 * LAST {
            // The column names are in the first line, the last row is near the end.
            let mut head = Vec::new();
            (&mut file).take(LAST).read_to_end(&mut head)?;
            let end = head.iter().position(|&byte| byte == b'\n').unwrap_or(0);
            lines.read(head.get(..end).unwrap_or_default(), &mut tell);
            done = data.len() - LAST;
            file.seek(SeekFrom::Start(done))?;
        }
        let mut bytes = Vec::new();
        (&mut file).take(2 * LAST).read_to_end(&mut bytes)?;
        // After a seek the first line is incomplete.
        let cut = bytes.iter().position(|&byte| byte == b'\n').filter(|_| done > 0).map_or(0, |end| end + 1);
        done += bytes.len() as u64;
        self.splitter.take(bytes.get(cut..).unwrap_or_default(), &mut |line| lines.read(line, &mut tell));
        let written = data.modified().ok();
        for (channel, (told, stamp)) in last {
            outlet.tell(channel, told, stamp.or(written));
        }
        self.open = Some((file, identity(&data), done));
        Ok(())
    }
}
