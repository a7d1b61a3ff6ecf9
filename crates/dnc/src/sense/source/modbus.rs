//! Registers of a control or a coupler over Modbus TCP: functions 3 (holding registers) and 4 (input registers); nothing is ever written.
//!
//! According to *MODBUS Application Protocol Specification* V1.1b3 and *MODBUS Messaging on TCP/IP Implementation Guide* V1.0b. A header of seven bytes
//! (transaction, protocol 0, length, unit) precedes each request and answer; registers have their high byte first. The order of the two registers of a 32-bit
//! number is not part of the standard.

use std::io::{self, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use ncfix_base::diagnostic::Code;
use ncfix_machine::machine::file::Section;

use super::super::config::seconds;
use super::super::monitor::{ChannelFault, SourceReport};
use super::super::outlet::ReadingOutlet;
use super::{Kind, OpenedSource, Polled, SourcePlan, Wanted, host_and_port, polled};

/// Standard port.
const PORT: u16 = 502;
/// Length of unit, function and registers of a request, bytes.
const REQUEST: u16 = 6;
/// Maximum length of an answer, bytes after the length field.
const LONGEST: usize = 254;

pub(super) const KIND: Kind = Kind {
    name: "modbus",
    title: "registers of a control or a coupler, Modbus TCP",
    is_record: false,
    is_standard_input: false,
    read,
};

/// Type of a number in registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Type {
    I16,
    U16,
    I32,
    U32,
    F32,
}

const TYPES: [(&str, Type); 5] =
    [("i16", Type::I16), ("u16", Type::U16), ("i32", Type::I32), ("u32", Type::U32), ("f32", Type::F32)];

#[derive(Clone, Copy, Debug)]
struct Register {
    channel: usize,
    function: u8,
    address: u16,
    kind: Type,
    is_low_first: bool,
    /// True if the highest and the lowest number mean that there is no value.
    has_sentinels: bool,
}

#[derive(Clone, Debug)]
struct Settings {
    host: String,
    unit: u8,
    timeout: Duration,
    registers: Vec<Register>,
}

fn read(section: &mut Section<'_>, wanted: &mut [Wanted<'_>]) -> Option<Arc<dyn SourcePlan>> {
    let host = host_and_port(section, PORT);
    let is_byte = |value: f64| value.fract() == 0.0 && (0.0..=255.0).contains(&value);
    let unit = section.number_where("unit", "a whole number from 0 to 255", is_byte).unwrap_or(1.0) as u8;
    let timeout = seconds(section, "timeout_s", 0.05).unwrap_or(Duration::from_secs(3));
    let registers = wanted.iter_mut().filter_map(|wanted| read_register(wanted.index, &mut wanted.section)).collect();
    Some(Arc::new(Settings { host: host?, unit, timeout, registers }))
}

fn read_register(channel: usize, section: &mut Section<'_>) -> Option<Register> {
    let one_of = |section: &mut Section<'_>, key: &str, names: &[&str]| {
        let written = section.text(key)?;
        let found = names.iter().position(|name| *name == written);
        if found.is_none() {
            let help = format!("one of {}", names.join(", "));
            section.report(Code::BAD_VALUE, section.place_of(key), format!("there is no {key} '{written}'"), help);
        }
        found
    };
    let is_address = |value: f64| value.fract() == 0.0 && (0.0..=65_535.0).contains(&value);
    let address = section.required("address", "100", |section, key| {
        section.number_where(key, "the address on the wire, a whole number from 0 to 65535", is_address)
    });
    let function = if one_of(section, "table", &["input", "holding"]) == Some(1) { 3 } else { 4 };
    let names = TYPES.map(|(name, _)| name);
    let index = section.required("type", "\"i16\"", |section, key| one_of(section, key, &names));
    let is_low_first = one_of(section, "words", &["high_first", "low_first"]) == Some(1);
    let (_, kind) = *TYPES.get(index?)?;
    let has_sentinels = !section.has("invalid");
    Some(Register { channel, function, address: address? as u16, kind, is_low_first, has_sentinels })
}

impl SourcePlan for Settings {
    fn open(&self, _: &Path, poll: Duration) -> Result<OpenedSource, String> {
        Ok(polled(Client { settings: self.clone(), stream: None, transaction: 0 }, poll))
    }
}

struct Client {
    settings: Settings,
    stream: Option<TcpStream>,
    transaction: u16,
}

impl Polled for Client {
    fn poll(&mut self, outlet: &ReadingOutlet) -> Result<(), String> {
        let mut stream = match self.stream.take() {
            Some(stream) => stream,
            None => connect(&self.settings.host, self.settings.timeout)?,
        };
        for index in 0..self.settings.registers.len() {
            let Some(register) = self.settings.registers.get(index).copied() else { continue };
            if outlet.is_over() {
                return Ok(());
            }
            let told = self.ask(&mut stream, &register).map_err(|error| format!("{}: {error}", self.settings.host))?;
            outlet.tell(register.channel, told, None);
        }
        // Only a connection on which everything was answered is used again.
        self.stream = Some(stream);
        Ok(())
    }
}

/// Connects to a host; tries its addresses one after the other.
fn connect(host: &str, timeout: Duration) -> Result<TcpStream, String> {
    let no = |error: io::Error| format!("{host}: {error}");
    let mut last = io::Error::from(io::ErrorKind::AddrNotAvailable);
    for address in host.to_socket_addrs().map_err(no)? {
        match TcpStream::connect_timeout(&address, timeout) {
            Ok(stream) => {
                stream.set_read_timeout(Some(timeout)).map_err(no)?;
                stream.set_write_timeout(Some(timeout)).map_err(no)?;
                stream.set_nodelay(true).map_err(no)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(no(last))
}

impl Client {
    fn ask(&mut self, stream: &mut TcpStream, register: &Register) -> io::Result<SourceReport> {
        let bad = |what: &'static str| io::Error::new(io::ErrorKind::InvalidData, what);
        self.transaction = self.transaction.wrapping_add(1);
        let words: u16 = if matches!(register.kind, Type::I16 | Type::U16) { 1 } else { 2 };
        let mut request = Vec::with_capacity(12);
        request.extend(self.transaction.to_be_bytes());
        request.extend([0, 0]);
        request.extend(REQUEST.to_be_bytes());
        request.extend([self.settings.unit, register.function]);
        request.extend(register.address.to_be_bytes());
        request.extend(words.to_be_bytes());
        stream.write_all(&request)?;

        let mut header = [0; 6];
        stream.read_exact(&mut header)?;
        let [transaction_high, transaction_low, 0, 0, length_high, length_low] = header else {
            return Err(bad("the answer is not Modbus"));
        };
        if [transaction_high, transaction_low] != self.transaction.to_be_bytes() {
            return Err(bad("the answer belongs to another request"));
        }
        let length = usize::from(u16::from_be_bytes([length_high, length_low]));
        if !(3..=LONGEST).contains(&length) {
            return Err(bad("the answer has an invalid length"));
        }
        let mut answer = vec![0; length];
        stream.read_exact(&mut answer)?;
        match answer.as_slice() {
            [_, function, code] if *function == register.function | 0x80 => {
                let why = format!("the device refuses register {}: {}", register.address, exception(*code));
                Ok(SourceReport::Nothing(ChannelFault::Invalid, why))
            }
            [unit, function, count, data @ ..]
                if *unit == self.settings.unit
                    && *function == register.function
                    && usize::from(*count) == 2 * usize::from(words)
                    && data.len() == usize::from(*count) =>
            {
                value(register, data).ok_or_else(|| bad("the answer does not fit the request"))
            }
            _ => Err(bad("the answer does not fit the request")),
        }
    }
}

/// Returns the number in the bytes of its registers.
fn value(register: &Register, data: &[u8]) -> Option<SourceReport> {
    let (number, sentinels): (f64, &[f64]) = match (register.kind, data) {
        (Type::I16, &[high, low]) => (i16::from_be_bytes([high, low]).into(), &[-32_768.0, 32_767.0]),
        (Type::U16, &[high, low]) => (u16::from_be_bytes([high, low]).into(), &[32_767.0, 32_768.0, 65_535.0]),
        (kind, &[a, b, c, d]) => {
            let bytes = if register.is_low_first { [c, d, a, b] } else { [a, b, c, d] };
            match kind {
                Type::I32 => (i32::from_be_bytes(bytes).into(), &[-2_147_483_648.0, 2_147_483_647.0]),
                Type::U32 => (u32::from_be_bytes(bytes).into(), &[2_147_483_647.0, 2_147_483_648.0, 4_294_967_295.0]),
                // The shortest decimal of a 32-bit number, not the long one of the equal 64-bit number.
                _ => (f32::from_be_bytes(bytes).to_string().parse().ok()?, &[]),
            }
        }
        _ => return None,
    };
    if register.has_sentinels && sentinels.contains(&number) {
        let why = format!("register {} has {number}: the device has no value", register.address);
        return Some(SourceReport::Nothing(ChannelFault::Invalid, why));
    }
    Some(SourceReport::Value(number))
}

/// Exceptions of the specification, section 7.
fn exception(code: u8) -> String {
    let name = match code {
        1 => "illegal function",
        2 => "illegal data address",
        3 => "illegal data value",
        4 => "server device failure",
        5 => "acknowledge",
        6 => "server device busy",
        8 => "memory parity error",
        10 => "gateway path unavailable",
        11 => "gateway target device failed to respond",
        _ => "unknown",
    };
    format!("{name} (exception {code})")
}
