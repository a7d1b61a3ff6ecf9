//! Ports: serial lines, pseudo-terminals and TCP, none of which ever waits unless it is told to.

mod serial;
mod tcp;

use super::{Port, Profile};

/// What a port over TCP begins with.
const TCP: &str = "tcp:";
/// Where pseudo-terminals are: they have no speed.
const PSEUDO: &str = "/dev/pts/";

/// A port that is open.
pub struct OpenPort {
    /// It.
    pub port: Box<dyn Port>,
    /// What a person should know of it: settings that it did not take, a name that stays the same.
    pub notes: Vec<String>,
}

/// Opens a port: `tcp:host:1234`, or the name of a serial port such as `/dev/ttyUSB0` or `COM3`.
///
/// # Errors
/// A sentence that says why it cannot be opened.
pub fn open(name: &str, profile: &Profile) -> Result<OpenPort, String> {
    match name.strip_prefix(TCP) {
        Some(address) => tcp::open(address),
        None => serial::open(name, profile),
    }
}

/// Characters that go over a port in a second; infinite where it has no speed of its own.
#[must_use]
pub fn characters_per_s(name: &str, profile: &Profile) -> f64 {
    let is_line = !name.starts_with(TCP) && !name.starts_with(PSEUDO);
    if is_line { profile.serial.characters_per_s() } else { f64::INFINITY }
}
