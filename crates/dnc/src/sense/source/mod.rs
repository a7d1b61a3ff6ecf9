//! Where readings come from: one file for each kind of source, and the register of them ([`SensorSources`]), which a caller extends.
//!
//! To add one from another crate, implement [`SensorSource`], give it to [`SensorSources::with`](ncfix_base::register::Register::with) and read the file of the sensors
//! with [`Config::read_with`](super::Config::read_with).

/// Stands for a kind that is not built in: its name is known, and it says so.
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
absent!(modbus, "registers of a control or a coupler, Modbus TCP", "read the sensor in another way");
#[cfg(not(feature = "mqtt"))]
absent!(mqtt, "messages of an MQTT broker", "read the sensor in another way");
#[cfg(not(feature = "mtconnect"))]
absent!(mtconnect, "an MTConnect agent", "read the sensor in another way");
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

use super::monitor::{Fault, Told};
use super::outlet::Outlet;

/// A kind of source of readings.
pub trait SensorSource: Send + Sync {
    /// What the file of the sensors calls it: `kind = "file"`.
    fn name(&self) -> &str;

    /// What it is.
    fn title(&self) -> &str;

    /// Whether its values were judged when they were recorded.
    fn is_record(&self) -> bool {
        false
    }

    /// Whether it reads standard input, which there is one of.
    fn is_standard_input(&self) -> bool {
        false
    }

    /// Reads the keys of `[source.NAME]`, and those that its channels have for it; what is wrong is reported in the sections. `kind`, `poll_s`, and what is
    /// believed of a channel, are read already. `None` where it is not sound.
    fn read(&self, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn Plan>>;
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

/// The kinds of sources that a file of sensors may have: [`Register::default`](ncfix_base::register::Register::default) are those that are built in.
pub type SensorSources = Register<dyn SensorSource>;

impl Registered for dyn SensorSource {
    const KIND: &'static str = "kind of source of readings";

    fn name(&self) -> &str {
        SensorSource::name(self)
    }

    fn built_in() -> Vec<Box<Self>> {
        BUILT_IN.iter().map(|&kind| Box::new(kind) as Box<dyn SensorSource>).collect()
    }
}

/// Reads the section of a source and what its channels have for it; findings go into the sections.
type Read = fn(&mut Section<'_>, &mut [Wanted<'_>]) -> Option<Arc<dyn Plan>>;

/// A kind of source that is built in.
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

    fn read(&self, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn Plan>> {
        (self.read)(section, wanted)
    }
}

/// Those that are built in.
const BUILT_IN: &[Kind] =
    &[command::KIND, file::KIND, modbus::KIND, mqtt::KIND, mtconnect::KIND, opcua::KIND, replay::KIND, stdin::KIND];

/// A channel that wants its values from a source.
#[derive(Debug)]
pub struct Wanted<'a> {
    /// Which one it is.
    pub index: usize,
    /// Its name.
    pub name: String,
    /// What the file says of it.
    pub section: Section<'a>,
}

/// A source as its file has it.
pub trait Plan: fmt::Debug + Send + Sync {
    /// Makes it ready to run; paths count from `base`.
    ///
    /// # Errors
    /// A sentence where it never can.
    fn open(&self, base: &Path, poll: Duration) -> Result<Opened, String>;
}

/// A source that is ready.
pub enum Opened {
    /// Runs in a thread of its own until its outlet is over.
    Thread(Box<dyn FnOnce(Outlet) + Send>),
    /// Has all its readings already and is driven by the clock of the job.
    Clocked(Box<dyn Clocked>),
}

/// A source that has all its readings already.
pub trait Clocked: Send {
    /// Tells what is read until now: the channel, what is told, and when it was read.
    fn until(&mut self, now: Duration, hear: &mut dyn FnMut(usize, &Told, Duration));
}

/// A source that is asked from time to time.
pub trait Polled: Send + 'static {
    /// Asks once.
    ///
    /// # Errors
    /// A sentence where it cannot be reached.
    fn poll(&mut self, outlet: &Outlet) -> Result<(), String>;
}

/// Runs a source that is asked from time to time.
#[must_use]
pub fn polled(mut source: impl Polled, every: Duration) -> Opened {
    Opened::Thread(Box::new(move |outlet| {
        loop {
            if let Err(why) = source.poll(&outlet) {
                outlet.fail(Fault::Disconnected, &why);
            }
            if !outlet.wait(every) {
                return;
            }
        }
    }))
}

/// Names under which a source knows its channels.
pub type Items = Vec<(String, usize)>;

/// The key `item` of each channel: what the source calls it; its own name where it is left out.
pub fn items(wanted: &mut [Wanted<'_>]) -> Items {
    wanted
        .iter_mut()
        .map(|wanted| (wanted.section.text("item").unwrap_or(&wanted.name).to_owned(), wanted.index))
        .collect()
}

/// The key `address` of a server, with its port or the usual one.
#[allow(dead_code, reason = "sources over a network are features")]
fn host_and_port(section: &mut Section<'_>, usual: u16) -> Option<String> {
    let address = section.required("address", &format!("\"192.168.0.5:{usual}\""), Section::text)?;
    let port = address.rsplit_once(':').map(|(_, port)| port);
    // An address of version 6 has colons of its own, and then brackets.
    let has_port = port.is_some_and(|port| !port.contains(']'));
    if address.is_empty() || address.contains('/') || (has_port && port.is_none_or(|port| port.parse::<u16>().is_err()))
    {
        let help = format!("write a name or a number and a port, for example \"192.168.0.5:{usual}\"");
        section.report(Code::BAD_VALUE, section.place_of("address"), format!("'{address}' is no address"), help);
        return None;
    }
    Some(if has_port { address.to_owned() } else { format!("{address}:{usual}") })
}

/// Reports that a kind is not built in, and what to do.
#[allow(dead_code, reason = "with all features there is none")]
fn not_built_in(name: &str, help: &str, section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) {
    let message = format!("this ncfix was built without {name}");
    section.report(Code::BAD_VALUE, section.place_of("kind"), message, help);
    super::config::accept_all(section);
    wanted.iter_mut().for_each(|wanted| super::config::accept_all(&mut wanted.section));
}
