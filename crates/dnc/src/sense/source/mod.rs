//! Sources of readings: one file for each kind, and their registry ([`SensorSources`]), which a caller can extend.
//!
//! To add a kind from another crate, implement [`SensorSource`] and pass it to `ncfix::Registry::with_sensor_source`. Then read the sensor file with
//! `ncfix::sensors::from_file`.

/// Placeholder for a kind that is not built in: its name is known, and its use is reported.
#[allow(unused_macros, reason = "with all features there is none")]
macro_rules! absent {
    ($name:ident, $title:literal, $other:literal) => {
        mod $name {
            pub(super) const KIND: super::Kind = super::Kind {
                name: stringify!($name),
                title: $title,
                is_record: false,
                is_standard_input: false,
                read: |section, wanted| {
                    let help = concat!("build it with `--features ", stringify!($name), "`, or ", $other);
                    super::not_built_in(stringify!($name), help, section, wanted);
                    None
                },
            };
        }
    };
}

mod command;
mod file;
#[cfg(feature = "modbus")]
mod modbus;
#[cfg(feature = "mqtt")]
mod mqtt;
#[cfg(feature = "mtconnect")]
mod mtconnect;
#[cfg(feature = "opcua")]
mod opcua;
mod replay;
mod stdin;

#[cfg(not(feature = "modbus"))]
absent!(modbus, "registers of a control or a coupler, Modbus TCP", "read the sensor by another kind of source");
#[cfg(not(feature = "mqtt"))]
absent!(mqtt, "messages of an MQTT broker", "read the sensor by another kind of source");
#[cfg(not(feature = "mtconnect"))]
absent!(mtconnect, "an MTConnect agent", "read the sensor by another kind of source");
#[cfg(not(feature = "opcua"))]
absent!(
    opcua,
    "variables of an OPC UA server",
    "read the server by a `command`, or through a gateway to MQTT or Modbus"
);

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ncfix_base::diagnostic::Code;
use ncfix_base::register::{Register, Registered};
use ncfix_machine::machine::file::Section;

use super::monitor::{ChannelFault, SourceReport};
use super::outlet::ReadingOutlet;

/// Sensor source: a kind of source of live readings.
pub trait SensorSource: Send + Sync {
    /// Returns its name in the sensor file: `kind = "file"`.
    fn name(&self) -> &str;

    /// Returns its description for people.
    fn title(&self) -> &str;

    /// True if its values were checked when they were recorded.
    fn is_record(&self) -> bool {
        false
    }

    /// True if it reads standard input, which exists only once.
    fn is_standard_input(&self) -> bool {
        false
    }

    /// Reads the keys of `[source.NAME]` and the keys of its channels that belong to the source; faults are reported in the sections. `kind`, `poll_s` and
    /// the plausibility limits of a channel have been read already. `None` if the section is not valid.
    fn read(&self, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>>;
}

impl fmt::Debug for dyn SensorSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl<S: SensorSource + 'static> From<S> for Box<dyn SensorSource> {
    fn from(source: S) -> Self {
        Box::new(source)
    }
}

/// Kinds of sources that a sensor file may have. [`Register::default`](ncfix_base::register::Register::default) contains the built-in ones.
pub type SensorSources = Register<dyn SensorSource>;

impl Registered for dyn SensorSource {
    const KIND: &'static str = "sensor source";

    fn name(&self) -> &str {
        SensorSource::name(self)
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&kind| Box::new(kind) as Box<dyn SensorSource>).collect()
    }
}

/// Reads the section of a source and the keys of its channels; diagnostics go into the sections.
type Read = fn(&mut Section<'_>, &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>>;

/// Built-in kind of source.
#[derive(Clone, Copy)]
struct Kind {
    name: &'static str,
    title: &'static str,
    is_record: bool,
    is_standard_input: bool,
    read: Read,
}

impl SensorSource for Kind {
    fn name(&self) -> &str {
        self.name
    }

    fn title(&self) -> &str {
        self.title
    }

    fn is_record(&self) -> bool {
        self.is_record
    }

    fn is_standard_input(&self) -> bool {
        self.is_standard_input
    }

    fn read(&self, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
        (self.read)(section, wanted)
    }
}

/// Built-in kinds.
const BUILT_IN: &[Kind] =
    &[command::KIND, file::KIND, modbus::KIND, mqtt::KIND, mtconnect::KIND, opcua::KIND, replay::KIND, stdin::KIND];

/// Channel that takes its values from a source.
#[derive(Debug)]
pub struct Wanted<'a> {
    /// Index of the channel.
    pub index: usize,
    /// Name.
    pub name: String,
    /// Section of the channel in the file.
    pub section: Section<'a>,
}

/// Settings of a source as read from the file.
pub trait SourcePlan: fmt::Debug + Send + Sync {
    /// Prepares the source for running; paths are relative to `base`.
    ///
    /// # Errors
    /// It can never run. The error is a sentence.
    fn open(&self, base: &Path, poll: Duration) -> Result<OpenedSource, String>;
}

/// Source that is ready to run.
pub enum OpenedSource {
    /// Runs in a separate thread until its outlet is over.
    Thread(Box<dyn FnOnce(ReadingOutlet) + Send>),
    /// Has all its readings in advance and is driven by the clock of the job.
    Clocked(Box<dyn Clocked>),
}

/// Source that has all its readings in advance.
pub trait Clocked: Send {
    /// Reports everything that was read until `now`: channel, report, time.
    fn until(&mut self, now: Duration, hear: &mut dyn FnMut(usize, &SourceReport, Duration));
}

/// Source that is polled.
pub trait Polled: Send + 'static {
    /// Polls once.
    ///
    /// # Errors
    /// It cannot be reached. The error is a sentence.
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String>;
}

/// Runs a polled source.
#[must_use]
pub fn polled(mut source: impl Polled, every: Duration) -> OpenedSource {
    OpenedSource::Thread(Box::new(move |outlet| {
        loop {
            if let Err(why) = source.poll(&outlet) {
                outlet.fail(ChannelFault::Disconnected, &why);
            }
            if !outlet.wait(every) {
                return;
            }
        }
    }))
}

/// Names under which a source knows its channels, with the channel indices.
pub type Items = Vec<(String, usize)>;

/// Reads the key `item` of each channel: its name in the source; the name of the channel if the key is absent.
pub fn items(wanted: &mut [Wanted<'_>]) -> Items {
    wanted
        .iter_mut()
        .map(|wanted| (wanted.section.text("item").unwrap_or(&wanted.name).to_owned(), wanted.index))
        .collect()
}

/// Reads the key `address` of a server; adds the usual port if it has none.
#[allow(dead_code, reason = "sources over a network are features")]
fn host_and_port(section: &mut Section<'_>, usual: u16) -> Option<String> {
    let address = section.required("address", &format!("\"192.168.0.5:{usual}\""), Section::text)?;
    let port = address.rsplit_once(':').map(|(_, port)| port);
    // An IPv6 address contains colons and is written in brackets.
    let has_port = port.is_some_and(|port| !port.contains(']'));
    if address.is_empty() || address.contains('/') || (has_port && port.is_none_or(|port| port.parse::<u16>().is_err()))
    {
        let help = format!("write a name or a number and a port, for example \"192.168.0.5:{usual}\"");
        section.report(Code::BAD_VALUE, section.place_of("address"), format!("'{address}' is not an address"), help);
        return None;
    }
    Some(if has_port { address.to_owned() } else { format!("{address}:{usual}") })
}

/// Reports that a kind is not built in, with advice.
#[allow(dead_code, reason = "with all features there is none")]
fn not_built_in(name: &str, help: &str, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) {
    let message = format!("this ncfix was built without {name}");
    section.report(Code::BAD_VALUE, section.place_of("kind"), message, help);
    super::config::accept_all(section);
    wanted.iter_mut().for_each(|wanted| super::config::accept_all(&mut wanted.section));
}
