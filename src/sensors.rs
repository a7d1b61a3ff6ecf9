//! Sensors of temperature that are read while a program is sent: those of a file of sensors, and kinds of one's own.
//!
//! A kind of one's own implements [`SensorSource`] and [`Plan`]; [`polled`] makes a thread of what is asked from time to time.

pub use ncfix_dnc::sense::source::{Items, Opened, Plan, Polled, Wanted, items, polled};
pub use ncfix_dnc::sense::{Fault, Outlet, Panel, Reading, SensorSource, SensorSources, Told};
pub use ncfix_machine::machine::file::Section;

use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::error::Error;
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::Config;

/// Opens the sensors of a file (TOML), which may have kinds of sources of one's own; paths in it count from its folder.
///
/// ```
/// use ncfix::sensors::{SensorSources, from_file};
///
/// let path = std::env::temp_dir().join(format!("ncfix_sensors_{}.toml", std::process::id()));
/// std::fs::write(&path, "[source.own]\nkind = \"crystal ball\"\n")?;
/// let opened = from_file(&path, &SensorSources::default());
/// std::fs::remove_file(&path)?;
/// assert!(opened.err().unwrap().diagnostics().has_errors());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Where the file cannot be read, or diagnostics forbid to use it.
pub fn from_file(path: impl AsRef<Path>, kinds: &SensorSources) -> Result<Panel, Error> {
    let path = path.as_ref();
    let source = files::read_written(path, FileId(0), "sensors")?;
    open(&source, kinds, path.parent().unwrap_or(Path::new(".")))
}

/// The same of the text of such a file; paths in it count from the working folder.
///
/// ```
/// use ncfix::sensors::{SensorSources, from_text};
///
/// let error = from_text("sensors.toml", "[source.probe]\nkind = \"crystal ball\"\n", &SensorSources::default()).err();
/// assert!(error.unwrap().diagnostics().has_errors());
/// ```
///
/// # Errors
/// Where diagnostics forbid to use it.
pub fn from_text(name: &str, text: &str, kinds: &SensorSources) -> Result<Panel, Error> {
    let too_large = |_| Error::usage(format!("{name} is too large"));
    let source = Source::new(FileId(0), name, text.as_bytes().to_vec()).map_err(too_large)?;
    open(&source, kinds, Path::new("."))
}

fn open(source: &Source, kinds: &SensorSources, base: &Path) -> Result<Panel, Error> {
    let opened = Config::read_with(source, kinds).and_then(|config| Panel::open(&config, base));
    opened.map_err(|found| {
        let mut all = Diagnostics::default();
        all.extend(found, std::slice::from_ref(source));
        Error::found(all)
    })
}
