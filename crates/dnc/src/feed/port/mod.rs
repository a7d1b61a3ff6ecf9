//! Ports: serial lines, pseudo-terminals and TCP. None of them waits unless asked to.

mod serial;
mod tcp;

use super::{Port, Profile};

/// Prefix of the name of a TCP port.
const TCP: &str = "tcp:";
/// Folder of pseudo-terminals, which have no speed.
const PSEUDO: &str = "/dev/pts/";

/// Open port.
pub struct OpenPort {
    /// The port.
    pub port: Box<dyn Port>,
    /// Notes for a person: settings that it rejected, a permanent name.
    pub notes: Vec<String>,
}

/// Opens a port: `tcp:host:1234`, or the name of a serial port such as `/dev/ttyUSB0` or `COM3`.
///
/// # Errors
/// It cannot be opened. The error is a sentence with the reason.
pub fn open(name: &str, profile: &Profile) -> Result<OpenPort, String> {
    match name.strip_prefix(TCP) {
        Some(address) => tcp::open(address),
        None => serial::open(name, profile),
    }
}

/// Returns the characters per second of a port; infinite if it has no speed of its own.
#[must_use]
pub fn characters_per_s(name: &str, profile: &Profile) -> f64 {
    let is_line = !name.starts_with(TCP) && !name.starts_with(PSEUDO);
    if is_line { profile.serial.characters_per_s() } else { f64::INFINITY }
}
