//! Temperature sensors that are read while a program is sent: those of a sensor file, and custom kinds.
//!
//! A custom kind implements [`SensorSource`] and [`SourcePlan`]; [`polled`] makes a thread for a sensor that is polled.

pub use ncfix_dnc::sense::source::{Clocked, Items, OpenedSource, Polled, SourcePlan, Wanted, items, polled};
pub use ncfix_dnc::sense::{
    ChannelFault, ChannelReading, Panel, ReadingOutlet, SensorSource, SensorSources, SourceReport,
};
pub use ncfix_machine::machine::file::Section;

use std::path::Path;

use crate::diagnostics::Diagnostics;
use crate::disk::files;
use crate::error::Error;
use ncfix_base::source::{FileId, Source};
use ncfix_dnc::sense::Config;

/// Opens the sensors of a file (TOML), which may use custom kinds of sources; relative paths in it start at the folder of the file.
///
/// ```
/// use ncfix::sensors::{SensorSources, from_file};
///
/// let path = std::env::temp_dir().join(format!("ncfix_sensors_{}.toml", std::process::id()));
/// std::fs::write(&path, "[source.own]\nkind = \"unknown\"\n")?;
/// let opened = from_file(&path, &SensorSources::default());
/// std::fs::remove_file(&path)?;
/// assert!(opened.err().unwrap().diagnostics().has_errors());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the file cannot be read or has errors.
pub fn from_file(path: impl AsRef<Path>, kinds: &SensorSources) -> Result<Panel, Error> {
    let path = path.as_ref();
    let source = files::read_written(path, FileId(0), "sensors")?;
    open(&source, kinds, path.parent().unwrap_or(Path::new(".")))
}

/// Opens the sensors of a text in the format of a sensor file; relative paths in it start at the working folder.
///
/// ```
/// use ncfix::sensors::{SensorSources, from_text};
///
/// let error = from_text("sensors.toml", "[source.probe]\nkind = \"unknown\"\n", &SensorSources::default()).err();
/// assert!(error.unwrap().diagnostics().has_errors());
/// ```
///
/// # Errors
/// If the text has errors.
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
