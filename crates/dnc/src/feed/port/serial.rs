//! Serial port or pseudo-terminal.
//!
//! The dialogue, not the operating system, reads the bytes that hold the flow: bytes in the queue of an adapter would still be sent after a stop. For
//! adapters that support only eight data bits, the parity bit can be computed here and sent as the eighth data bit.

use std::collections::VecDeque;
use std::io::{self, ErrorKind};
use std::path::Path;
use std::time::Duration;

use serialport::{DataBits, FlowControl, SerialPort, StopBits};

use super::{OpenPort, PSEUDO};
use crate::feed::{Parity, Port, Profile, Serial};

/// Bytes read ahead while it waits.
const CHUNK: usize = 256;
/// Folder of permanent port names on Linux; they do not depend on the order in which ports are connected.
const BY_ID: &str = "/dev/serial/by-id";
/// The eighth bit.
const EIGHTH: u8 = 0x80;

struct Line {
    port: Box<dyn SerialPort>,
    /// Computed here and sent as the eighth bit.
    parity: Parity,
    heard: VecDeque<u8>,
    /// Buffer for bytes with parity; bytes that the port did not accept are coded again.
    coded: Vec<u8>,
}

/// Opens a port with the settings of a profile.
pub(super) fn open(name: &str, profile: &Profile) -> Result<OpenPort, String> {
    let serial = &profile.serial;
    let (data_bits, parity) =
        if serial.software_parity { (8, Parity::None) } else { (serial.data_bits, serial.parity) };
    let data_bits = if data_bits == 7 { DataBits::Seven } else { DataBits::Eight };
    let wanted = match parity {
        Parity::None => serialport::Parity::None,
        Parity::Even => serialport::Parity::Even,
        Parity::Odd => serialport::Parity::Odd,
    };
    let builder = serialport::new(name, serial.baud)
        .data_bits(data_bits)
        .parity(wanted)
        .stop_bits(if serial.stop_bits == 2 { StopBits::Two } else { StopBits::One })
        .flow_control(if serial.rts_cts { FlowControl::Hardware } else { FlowControl::None })
        .timeout(Duration::ZERO);
    let port = builder.open().map_err(|error| {
        let help = match error.kind() {
            serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => "; you may have to be in the group dialout",
            serialport::ErrorKind::NoDevice => "; is it plugged in, and does another program have it open?",
            _ => "",
        };
        format!("cannot open {name}: {error}{help}")
    })?;
    let mut notes = Vec::new();
    let is_kept = port.data_bits().ok() == Some(data_bits) && port.parity().ok() == Some(wanted);
    if !is_kept {
        let asked = describe(serial);
        notes.push(format!(
            "{name} does not accept {asked}: the port sends eight bits without parity; set software_parity = true in the profile to compute the parity here"
        ));
    }
    if !name.starts_with(PSEUDO)
        && let Some(same) = lasting_name(name)
    {
        notes.push(format!("{name} may be another port after a restart; this one is also {same}"));
    }
    let parity = if serial.software_parity { serial.parity } else { Parity::None };
    Ok(OpenPort { port: Box::new(Line { port, parity, heard: VecDeque::new(), coded: Vec::new() }), notes })
}

/// Formats the settings, for example `7E2`.
fn describe(serial: &Serial) -> String {
    let parity = match serial.parity {
        Parity::None => 'N',
        Parity::Even => 'E',
        Parity::Odd => 'O',
    };
    format!("{}{parity}{}", serial.data_bits, serial.stop_bits)
}

/// Returns the permanent name of a port.
fn lasting_name(name: &str) -> Option<String> {
    let device = Path::new(name).canonicalize().ok()?;
    if Path::new(name).starts_with(BY_ID) {
        return None;
    }
    let links = std::fs::read_dir(BY_ID).ok()?.flatten().map(|entry| entry.path());
    links
        .filter(|link| link.canonicalize().is_ok_and(|target| target == device))
        .find_map(|link| Some(link.to_str()?.to_owned()))
}

/// Returns a byte with the bit that makes the number of its ones even or odd.
fn with_parity(byte: u8, parity: Parity) -> u8 {
    let byte = byte & !EIGHTH;
    let is_odd = byte.count_ones() % 2 == 1;
    match parity {
        Parity::Even if is_odd => byte | EIGHTH,
        Parity::Odd if !is_odd => byte | EIGHTH,
        _ => byte,
    }
}

impl Line {
    fn read_now(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let count = nothing_now(self.port.read(into))?;
        if self.parity != Parity::None {
            into.iter_mut().take(count).for_each(|byte| *byte &= !EIGHTH);
        }
        Ok(count)
    }
}

impl Port for Line {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if !self.heard.is_empty() {
            let count = into.len().min(self.heard.len());
            into.iter_mut().zip(self.heard.drain(..count)).for_each(|(to, byte)| *to = byte);
            return Ok(count);
        }
        self.read_now(into)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.parity == Parity::None {
            return nothing_now(self.port.write(bytes));
        }
        self.coded.clear();
        self.coded.extend(bytes.iter().map(|byte| with_parity(*byte, self.parity)));
        nothing_now(self.port.write(&self.coded))
    }

    fn queued(&mut self) -> Option<usize> {
        self.port.bytes_to_write().ok().map(|count| count as usize)
    }

    fn wait(&mut self, most: Duration) {
        // An error here occurs again at the next read.
        if self.heard.is_empty() && self.port.set_timeout(most).is_ok() {
            let mut chunk = [0; CHUNK];
            if let Ok(count) = self.read_now(&mut chunk) {
                self.heard.extend(chunk.iter().take(count));
            }
            let _ = self.port.set_timeout(Duration::ZERO);
        }
    }
}

fn nothing_now(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
            Ok(0)
        }
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_eighth_bit_makes_ones_even_or_odd() {
        // ISO 840 (RS-358-B) is ASCII with even parity: "1" is B1, "0" is 30, LF is 0A, "%" is A5.
        let iso = |byte| with_parity(byte, Parity::Even);
        assert_eq!([b'1', b'0', b'\n', b'%'].map(iso), [0xB1, 0x30, 0x0A, 0xA5]);
        assert_eq!(with_parity(b'0', Parity::Odd), 0xB0);
    }
}
