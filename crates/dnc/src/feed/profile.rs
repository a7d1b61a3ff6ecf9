//! Links as data: transmission, framing of programs, window size.
//!
//! A profile is a TOML file. Those in `links/` are shipped ([`PROFILES`]); a caller adds others to [`Links`] or passes their path. A missing key has the
//! value of a plain link without that feature.

use std::borrow::Cow;
use std::time::Duration;

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::register::{Register, Registered};
use ncfix_base::source::Source;
use ncfix_machine::machine::Firmware;
use ncfix_machine::machine::file::{MachineFile, Section, nearest};

use super::dialogue::{Protocol, Protocols};
use super::watch::Patience;

/// Names and texts of the shipped profiles.
pub const PROFILES: &[(&str, &str)] = &[
    ("fanuc-rs232", include_str!("../../links/fanuc-rs232.toml")),
    ("grbl", include_str!("../../links/grbl.toml")),
    ("grblhal", include_str!("../../links/grblhal.toml")),
    ("grundig-v24", include_str!("../../links/grundig-v24.toml")),
    ("haas", include_str!("../../links/haas.toml")),
    ("heidenhain-fe1", include_str!("../../links/heidenhain-fe1.toml")),
    ("linuxcnc", include_str!("../../links/linuxcnc.toml")),
    ("lsv2", include_str!("../../links/lsv2.toml")),
    ("lsv2-serial", include_str!("../../links/lsv2-serial.toml")),
    ("marlin", include_str!("../../links/marlin.toml")),
    ("siemens-v24", include_str!("../../links/siemens-v24.toml")),
];

/// Text of a profile with the name of its link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinkFile {
    /// Name as given to `--link`.
    pub name: Cow<'static, str>,
    /// Profile, TOML.
    pub text: Cow<'static, str>,
}

/// Links that have a name. [`Register::default`](ncfix_base::register::Register::default) contains the shipped ones.
pub type Links = Register<LinkFile>;

impl Registered for LinkFile {
    const KIND: &'static str = "link";

    fn name(&self) -> &str {
        &self.name
    }

    fn built_in() -> Vec<Box<Self>> {
        PROFILES.iter().map(|&(name, text)| Box::new(LinkFile { name: name.into(), text: text.into() })).collect()
    }

    fn conflict(&self, other: &Self) -> Option<String> {
        self.name.eq_ignore_ascii_case(&other.name).then(|| "names that differ only in case are the same".into())
    }
}

/// Parity of a character.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parity {
    /// No parity bit.
    #[default]
    None,
    /// The parity bit makes the number of ones even.
    Even,
    /// The parity bit makes the number of ones odd.
    Odd,
}

/// Settings of a serial line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Serial {
    /// Bits per second.
    pub baud: u32,
    /// Data bits, 7 or 8.
    pub data_bits: u8,
    /// Parity.
    pub parity: Parity,
    /// Stop bits, 1 or 2.
    pub stop_bits: u8,
    /// True if RTS and CTS hold the flow.
    pub rts_cts: bool,
    /// True if the parity bit is computed here and sent as the eighth data bit, for adapters that support only eight data bits.
    pub software_parity: bool,
}

impl Serial {
    /// Returns the bits on the wire per character: start, data, parity, stop.
    #[must_use]
    pub fn bits_per_character(&self) -> u32 {
        1 + u32::from(self.data_bits) + u32::from(self.parity != Parity::None) + u32::from(self.stop_bits)
    }

    /// Returns the characters per second.
    #[must_use]
    pub fn characters_per_s(&self) -> f64 {
        f64::from(self.baud) / f64::from(self.bits_per_character())
    }
}

/// Limits on the data under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Maximum number of lines that are sent and not acknowledged.
    pub lines: usize,
    /// Maximum number of their bytes.
    pub bytes: usize,
    /// Maximum number of bytes in the queue of the operating system, which cannot be held back any more.
    pub system_bytes: usize,
    /// Number of further lines that a control of this kind usually holds; used by the forecast only. The true number is stated by the control.
    pub planned: usize,
}

/// Maximum number of blocks that a control has taken and not executed, if it does not state the number itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bound {
    /// Maximum number of blocks, never exceeded.
    pub at_most: u64,
    /// Source of the figure.
    pub source: String,
}

/// Bytes that frame lines and programs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Framing {
    /// Bytes before everything else.
    pub leader: Vec<u8>,
    /// Bytes before the first line.
    pub start: Vec<u8>,
    /// Bytes after each line.
    pub end_of_block: Vec<u8>,
    /// Bytes after the last line.
    pub trailer: Vec<u8>,
}

/// Flow control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Flow {
    /// Byte that resumes the flow; `None` if no bytes hold it.
    pub xon: Option<u8>,
    /// Byte that stops the flow.
    pub xoff: Option<u8>,
    /// True if nothing is sent before the first [`Flow::xon`].
    pub wait_for_xon: bool,
}

/// File on the control, for a link that sends the program as one file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileOptions {
    /// Its path.
    pub path: Option<String>,
    /// True if its bytes are stored as they are; false if the control keeps it as lines of text.
    pub is_binary: bool,
    /// True if an existing file may be replaced.
    pub replaces: bool,
    /// True if the control is asked for its state, before the transfer and until the program has run.
    pub watches: bool,
}

impl Default for FileOptions {
    fn default() -> FileOptions {
        FileOptions { path: None, is_binary: false, replaces: false, watches: true }
    }
}

/// Longest path of a file on a control, bytes.
const LONGEST_PATH: usize = 250;

impl FileOptions {
    /// Checks a path of a file on a control.
    ///
    /// # Errors
    /// It is not a valid path. The error is a sentence.
    pub fn check_path(path: &str) -> Result<(), String> {
        let is_plain = |byte: u8| (b' '..=b'~').contains(&byte) && !b"\"*?<>|".contains(&byte);
        let name = path.rsplit(['\\', '/', ':']).next().unwrap_or_default();
        if path.len() > LONGEST_PATH || !path.bytes().all(is_plain) {
            return Err(format!(
                "a path has at most {LONGEST_PATH} printable ASCII characters, without quotation marks, * ? < > |"
            ));
        }
        if !path.to_ascii_uppercase().starts_with("TNC:") || name.trim().is_empty() {
            return Err(
                "a path begins with the drive of the programs and ends with a file name, such as TNC:\\PART.PM".into(),
            );
        }
        Ok(())
    }
}

/// Link and its settings.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Name.
    pub name: String,
    /// Description for people.
    pub title: String,
    /// Sentence about controls that cannot use this link although their programs look the same; `None` without such controls.
    pub caution: Option<String>,
    /// Dialogue.
    pub protocol: &'static Protocol,
    /// Serial line; TCP and pseudo-terminals ignore it.
    pub serial: Serial,
    /// Flow control.
    pub flow: Flow,
    /// Framing of lines and programs.
    pub frame: Framing,
    /// File on the control.
    pub file: FileOptions,
    /// Limits on the data under way.
    pub window: Window,
    /// Maximum number of blocks in its planner; `None` if it is not known.
    pub depth: Option<Bound>,
    /// Maximum length of a line, bytes without line end.
    pub longest_line: usize,
    /// Dialects that the control executes; empty if the link serves any.
    pub dialects: Vec<String>,
    /// Firmware whose words are known; a line with another word is not sent.
    pub firmware: Option<Firmware>,
    /// True if letters are sent as capitals.
    pub is_upper_case: bool,
    /// Bytes that no line may contain: they have another meaning on this link.
    pub refused: Vec<u8>,
    /// Time until an answer, s.
    pub answer_s: f64,
    /// Time without an answer, beyond the duration of a block, after which the control is asked or the line is sent again.
    pub answer_within: Duration,
    /// Maximum times without progress before the job ends.
    pub patience: Patience,
    /// Maximum number of times that a line is sent again.
    pub most_repeats: u32,
    /// True if check characters are made printable.
    pub avoids_controls: bool,
}

impl Profile {
    /// Checks that a line can be sent over the link.
    ///
    /// # Errors
    /// The line cannot be sent. The error is a sentence with the reason.
    pub fn check(&self, text: &[u8]) -> Result<(), String> {
        if let Some(firmware) = self.firmware {
            let lacking = firmware.lacks(text);
            if !lacking.is_empty() {
                let words: Vec<String> = lacking.iter().map(|word| word.text()).collect();
                return Err(format!("{} does not have {}", firmware.name(), words.join(", ")));
            }
        }
        (self.protocol.check)(self, text)
    }

    /// Checks that the control executes programs of a dialect: elsewhere a word may have another meaning, and the machine would move by it.
    ///
    /// # Errors
    /// It does not. The error is a sentence with the reason.
    pub fn check_dialect(&self, dialect: &str) -> Result<(), String> {
        if self.dialects.is_empty() || self.dialects.iter().any(|one| one == dialect) {
            return Ok(());
        }
        Err(format!(
            "the link {} serves controls that execute {}, and this program is {dialect}",
            self.name,
            self.dialects.join(" or ")
        ))
    }

    /// True if the control is asked before the first line whether it is idle.
    #[must_use]
    pub fn asks_idle(&self) -> bool {
        self.protocol.asks_idle && (!self.protocol.sends_file || self.file.watches)
    }

    /// Returns the maximum number of blocks that the control has answered and not executed, as stated by the profile. It includes the planner, the blocks
    /// that still move, and those that wait before the planner.
    #[must_use]
    pub fn holds_at_most(&self) -> Option<u64> {
        let depth = self.depth.as_ref().filter(|_| self.protocol.has_planner)?;
        Some(depth.at_most.saturating_add(self.protocol.beyond))
    }

    /// Reads a profile.
    ///
    /// # Errors
    /// All faults of the file: `E0401`–`E0404`.
    pub fn read(source: &Source) -> Result<Profile, Vec<Diagnostic>> {
        Profile::read_with(source, &Protocols::default())
    }

    /// Reads a profile that may name the dialogues of `protocols`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn read_with(source: &Source, protocols: &Protocols) -> Result<Profile, Vec<Diagnostic>> {
        let document = MachineFile::parse(source)?;
        let mut root = document.root();
        let mut findings = Vec::new();
        let name = root.required("name", "\"my-link\"", Section::text).unwrap_or_default().to_owned();
        let title = root.text("title").unwrap_or(&name).to_owned();
        let caution = root.text("caution").map(str::to_owned);
        let named = root.required("protocol", "\"grbl\"", Section::text);
        let protocol = named.and_then(|name| protocols.find(name)).copied();
        if let (Some(named), None) = (named, protocol) {
            let help = nearest(named, protocols.names()).map_or_else(
                || format!("one of {}", protocols.names().collect::<Vec<_>>().join(", ")),
                |name| format!("did you mean \"{name}\"?"),
            );
            root.report(Code::BAD_VALUE, root.place_of("protocol"), format!("there is no protocol '{named}'"), help);
        }
        let mut own = |key: &str, read: &mut dyn FnMut(&mut Section<'_>)| {
            if let Some(mut section) = root.section(key) {
                read(&mut section);
                section.finish(&mut findings);
            }
        };
        let mut serial = Serial {
            baud: 9600,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
            rts_cts: false,
            software_parity: false,
        };
        own("serial", &mut |section| read_serial(section, &mut serial));
        let mut flow = Flow { xon: None, xoff: None, wait_for_xon: false };
        own("flow", &mut |section| {
            flow.xon = byte(section, "xon");
            flow.xoff = byte(section, "xoff");
            flow.wait_for_xon = section.boolean("wait_for_xon").unwrap_or(false);
        });
        let mut frame = Framing { end_of_block: b"\n".to_vec(), ..Framing::default() };
        own("frame", &mut |section| {
            frame.leader = bytes(section, "leader").unwrap_or_default();
            frame.start = bytes(section, "start").unwrap_or_default();
            frame.end_of_block = bytes(section, "end_of_block").unwrap_or(b"\n".to_vec());
            frame.trailer = bytes(section, "trailer").unwrap_or_default();
        });
        // Five lines: the buffer of the control in Spaan (1995), ch. 7.
        let mut window = Window { lines: 5, bytes: 512, system_bytes: 64, planned: 0 };
        own("window", &mut |section| {
            let mut read = |key: &str, of: &mut usize| *of = section.integer(key).map_or(*of, |value| value as usize);
            read("lines", &mut window.lines);
            read("bytes", &mut window.bytes);
            read("planned", &mut window.planned);
            read("system_bytes", &mut window.system_bytes);
        });
        let sends_file = protocol.is_some_and(|protocol| protocol.sends_file);
        let mut file = FileOptions::default();
        own("file", &mut |section| file = read_file(section, sends_file));
        let has_planner = protocol.is_some_and(|protocol| protocol.has_planner);
        let mut depth = None;
        own("depth", &mut |section| depth = bound(section, has_planner));
        let (mut longest_line, mut is_upper_case, mut refused, mut dialects) = (256, false, Vec::new(), Vec::new());
        let mut firmware = None;
        own("text", &mut |section| {
            longest_line = section.integer("longest_line").map_or(longest_line, |value| value as usize);
            is_upper_case = section.boolean("upper_case").unwrap_or(false);
            refused = bytes(section, "refused").unwrap_or_default();
            dialects = section.texts("dialects").unwrap_or_default();
            firmware = read_firmware(section);
        });
        let mut answer_s = 0.0;
        let (mut answer_within, mut most_repeats, mut avoids_controls) = (Duration::from_secs(10), 3, false);
        let mut patience = Patience::default();
        own("answer", &mut |section| {
            let positive = |value: f64| value > 0.0 && value <= 3600.0;
            if let Some(seconds) = section.number_where("within_s", "a time above 0 and up to 3600", positive) {
                answer_within = Duration::from_secs_f64(seconds);
            }
            let is_long = |value: f64| (1.0..=86_400.0).contains(&value);
            let mut limit = |key: &str, of: &mut Duration| {
                if let Some(seconds) = section.number_where(key, "a time from 1 to 86400", is_long) {
                    *of = Duration::from_secs_f64(seconds);
                }
            };
            limit("stall_s", &mut patience.stall);
            limit("hold_s", &mut patience.hold);
            let is_time = |value: f64| (0.0..=60.0).contains(&value);
            answer_s = section.number_where("typical_s", "a time from 0 to 60", is_time).unwrap_or(answer_s);
            most_repeats = section.integer("repeats").unwrap_or(most_repeats);
            avoids_controls = section.boolean("avoid_control_characters").unwrap_or(false);
        });
        root.finish(&mut findings);
        let Some(protocol) = protocol.filter(|_| !findings.iter().any(Diagnostic::is_error)) else {
            return Err(findings);
        };
        Ok(Profile {
            name,
            title,
            caution,
            protocol,
            serial,
            flow,
            frame,
            file,
            window,
            depth,
            longest_line,
            dialects,
            firmware,
            is_upper_case,
            refused,
            answer_s,
            answer_within,
            patience,
            most_repeats,
            avoids_controls,
        })
    }
}

/// Reads the name of a firmware whose words are known.
fn read_firmware(section: &mut Section<'_>) -> Option<Firmware> {
    let name = section.text("firmware")?.to_owned();
    let found = Firmware::of(&name);
    if found.is_none() {
        let message = format!("'{name}' is not a firmware whose words ncfix knows");
        section.report(
            Code::BAD_VALUE,
            section.place_of("firmware"),
            message,
            "one of grbl, grblhal, fluidnc; for others, omit the key",
        );
    }
    found
}

/// Reads an upper bound of the planner depth. Without its source it would be a guess, and a wrong one skips blocks that were not executed.
fn bound(section: &mut Section<'_>, has_planner: bool) -> Option<Bound> {
    let at_most = section.required("at_most", "64", Section::integer);
    let source =
        section.required("source", "\"Configuration_adv.h of this firmware: BLOCK_BUFFER_SIZE 64\"", Section::text);
    let source = source.map(str::to_owned);
    if !has_planner {
        let message = "an answer over this link does not mean that the line is in a planner, or there are no answers";
        section.report(Code::BAD_VALUE, section.place_of("at_most"), message, "omit [depth]");
    } else if source.as_ref().is_some_and(|source| source.trim().is_empty()) {
        let help = "state the source of the figure: a setting of the control, its configuration, its manual";
        section.report(Code::BAD_VALUE, section.place_of("source"), "a bound without a source", help);
    }
    let (at_most, source) = at_most.zip(source)?;
    Some(Bound { at_most: at_most.into(), source })
}

/// Reads the file on the control.
fn read_file(section: &mut Section<'_>, sends_file: bool) -> FileOptions {
    let path = section.text("path").map(str::to_owned);
    let fault = match &path {
        _ if !sends_file => Some(("this link sends lines, not a file".to_owned(), "omit [file]")),
        Some(path) => FileOptions::check_path(path).err().map(|why| (why, "correct the path")),
        None => None,
    };
    if let Some((message, help)) = fault {
        section.report(Code::BAD_VALUE, section.place_of("path"), message, help);
    }
    FileOptions {
        path,
        is_binary: section.boolean("binary").unwrap_or(false),
        replaces: section.boolean("replace").unwrap_or(false),
        watches: section.boolean("watch").unwrap_or(true),
    }
}

fn read_serial(section: &mut Section<'_>, serial: &mut Serial) {
    if let Some(baud) = section.integer("baud") {
        serial.baud = baud;
    }
    let one_of = |section: &mut Section<'_>, key: &str, allowed: [u8; 2]| {
        let expected = format!("{} or {}", allowed[0], allowed[1]);
        let found = section.number_where(key, &expected, |value| allowed.iter().any(|&one| f64::from(one) == value));
        found.map(|value| value as u8)
    };
    serial.data_bits = one_of(section, "data_bits", [7, 8]).unwrap_or(serial.data_bits);
    serial.stop_bits = one_of(section, "stop_bits", [1, 2]).unwrap_or(serial.stop_bits);
    serial.parity = match section.text("parity") {
        None | Some("none") => Parity::None,
        Some("even") => Parity::Even,
        Some("odd") => Parity::Odd,
        Some(other) => {
            let message = format!("there is no parity '{other}'");
            section.report(Code::BAD_VALUE, section.place_of("parity"), message, "one of \"none\", \"even\", \"odd\"");
            Parity::None
        }
    };
    serial.rts_cts = section.boolean("rts_cts").unwrap_or(false);
    serial.software_parity = section.boolean("software_parity").unwrap_or(false);
    if serial.software_parity && (serial.data_bits, serial.parity == Parity::None) != (7, false) {
        let place = section.place_of("software_parity");
        let help = "write data_bits = 7 and parity = \"even\" or \"odd\" with it";
        section.report(Code::BAD_VALUE, place, "parity computed here is the eighth bit after seven data bits", help);
    }
}

/// Reads a byte: a number from 0 to 255.
fn byte(section: &mut Section<'_>, key: &str) -> Option<u8> {
    let is_byte = |value: f64| value.fract() == 0.0 && (0.0..=255.0).contains(&value);
    section.number_where(key, "a byte: a whole number from 0 to 255", is_byte).map(|value| value as u8)
}

/// Reads bytes: a text whose characters are their codes.
fn bytes(section: &mut Section<'_>, key: &str) -> Option<Vec<u8>> {
    let text = section.text_of_bytes(key)?;
    let bytes: Option<Vec<u8>> = text.chars().map(|character| u8::try_from(u32::from(character)).ok()).collect();
    if bytes.is_none() {
        let help = "write them as \\u0000 to \\u00FF";
        section.report(
            Code::BAD_VALUE,
            section.place_of(key),
            format!("{key} has characters that are not bytes"),
            help,
        );
    }
    bytes
}

#[cfg(test)]
mod tests;
