//! Text form of the stream: one element per line, stable, written and read.
//!
//! ```text
//! ; snc 1 machine=demo units=mm
//! G0 X10 Y0 Z100 ;@12
//! G2 X30 Y10 Z-1 I0 J10 K0 P17 F500 ;@14<3
//! ```
//!
//! Positions are those of the tool tip, mm and degrees, up to 6 decimals. `;@14<3` is line 14 called from line 3.
//! A feed is per minute, unless `G95` (mm per spindle revolution) or `G93` (blocks per minute, the reciprocal of the time) follows it.
//! `I J K` is the center minus the start, `P` the plane, `L` the number of extra full turns. A tilted plane has its normal, `D E H`, instead of `P`. `G1.W` is straight in the workpiece while the rotary axes move in
//! proportion, `G1.V` while the tool follows a great circle; so are `G0`, `G2` and `G3`, with `I J K` along the directions of the workpiece. Threads and positioning axes appear only as moves: G1 without a
//! feed for spindle-driven axes, G0 for positioning axes.

use std::io::{self, Write};

use super::{Dwell, Element, FeedUnit, Kind, Move, Turning, WordValue};
use ncfix_base::geometry::{AXES, AxisSet, AxisVector, Vector};
use ncfix_base::source::is_deceptive;
use ncfix_base::units::push_integer;

/// Smallest feed that is not zero at the last decimal of the text, mm/min.
const LEAST_FEED: f64 = 5e-7;

/// Rotates a tool vector by the rotary axes of the tool side at an axis command.
type TurnTool<'a> = Box<dyn Fn(&AxisVector, &Vector) -> Vector + 'a>;
/// Converts an axis command with a tool to the position fixed to the workpiece.
type OnWorkpiece<'a> = Box<dyn Fn(&AxisVector, &Vector) -> AxisVector + 'a>;

/// Writes elements as text.
pub struct TextWriter<'a, W: Write> {
    out: W,
    axes: AxisSet,
    turned_tool_mm: TurnTool<'a>,
    on_workpiece: OnWorkpiece<'a>,
    position: AxisVector,
    tool_mm: Vector,
    line: Vec<u8>,
    count: u64,
}

/// The head line before the name of the machine, and after it.
const HEAD: &str = "; snc 1 machine=";
const UNITS: &str = " units=mm";

/// Returns the name of the machine in the head line of a text; `None` if it is not a flat stream.
#[must_use]
pub fn stated_machine(text: &[u8]) -> Option<String> {
    let line = text.split(|&byte| byte == b'\n').next()?;
    let line = std::str::from_utf8(line).ok()?.trim_end();
    Some(line.strip_prefix(HEAD)?.strip_suffix(UNITS)?.to_owned())
}

impl<'a, W: Write> TextWriter<'a, W> {
    /// Writes the head line. `turned_tool_mm` returns the tool vector as rotated by the rotary axes of the tool side at an axis command, along the directions
    /// of F, mm.
    ///
    /// # Errors
    /// I/O errors of the writer.
    pub fn new(
        mut out: W,
        machine: &str,
        axes: AxisSet,
        turned_tool_mm: impl Fn(&AxisVector, &Vector) -> Vector + 'a,
    ) -> io::Result<Self> {
        writeln!(out, "{HEAD}{machine}{UNITS}")?;
        Ok(TextWriter {
            out,
            axes,
            turned_tool_mm: Box::new(turned_tool_mm),
            on_workpiece: Box::new(|command, _| *command),
            position: AxisVector::ZERO,
            tool_mm: Vector::zeros(),
            line: Vec::with_capacity(160),
            count: 0,
        })
    }

    /// Sets the conversion of an axis command with a tool to the position fixed to the workpiece, mm and rad, for the centers of arcs in the workpiece.
    #[must_use]
    pub fn with_workpiece(self, on_workpiece: impl Fn(&AxisVector, &Vector) -> AxisVector + 'a) -> Self {
        TextWriter { on_workpiece: Box::new(on_workpiece), ..self }
    }

    /// Returns the number of lines written, without the head.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Sets the axis command at which the stream starts.
    pub fn start_at(&mut self, position: AxisVector) {
        self.position = position;
    }

    /// Writes one element; `call_lines` are the lines that called its program, innermost first.
    ///
    /// # Errors
    /// I/O errors of the writer.
    pub fn write(&mut self, element: &Element, call_lines: &[u32]) -> io::Result<()> {
        self.line.clear();
        match &element.kind {
            Kind::Setup(setup) => self.tool_mm = setup.tool_mm,
            Kind::Move(motion) => self.motion(motion),
            Kind::Dwell(Dwell::Seconds(seconds)) => {
                self.line.extend_from_slice(b"G4");
                push_value(&mut self.line, b" S", *seconds);
            }
            Kind::Dwell(Dwell::Turns(turns)) => {
                self.line.extend_from_slice(b"G4");
                push_value(&mut self.line, b" R", *turns);
            }
            Kind::Tool(value) => push_word(&mut self.line, b'T', None, value),
            Kind::Before(words) | Kind::After(words) => {
                for word in words {
                    push_word(&mut self.line, word.letter, word.extension, &word.value);
                }
            }
            _ => {}
        }
        if !element.kind.is_in_text() || self.line.is_empty() {
            return Ok(());
        }
        self.line.extend_from_slice(b" ;@");
        push_integer(&mut self.line, u64::from(element.origin.line));
        for &line in call_lines {
            self.line.push(b'<');
            push_integer(&mut self.line, u64::from(line));
        }
        self.line.push(b'\n');
        self.count += 1;
        self.out.write_all(&self.line)
    }

    /// Flushes and returns the writer.
    ///
    /// # Errors
    /// I/O errors of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn motion(&mut self, motion: &Move) {
        let code: &[u8] = match (motion.rapid, &motion.arc) {
            (true, _) => b"G0",
            (false, None) => b"G1",
            (false, Some(arc)) if arc.clockwise => b"G2",
            (false, Some(_)) => b"G3",
        };
        self.line.extend_from_slice(code);
        match motion.tip {
            None => {}
            Some(Turning::Axes) => self.line.extend_from_slice(b".W"),
            Some(Turning::Vector) => self.line.extend_from_slice(b".V"),
        }
        let mut tip = motion.target;
        tip.set_xyz(tip.xyz() + (self.turned_tool_mm)(&motion.target, &self.tool_mm));
        for axis in AXES {
            if self.axes.contains(axis) {
                let value = if axis.is_rotary() { tip[axis].to_degrees() } else { tip[axis] };
                push_value(&mut self.line, &[b' ', axis.letter()], value);
            }
        }
        if let Some(arc) = &motion.arc {
            let start = match motion.tip {
                None => self.position,
                Some(_) => (self.on_workpiece)(&self.position, &self.tool_mm),
            };
            let (ijk, normal) = match &motion.arc_basis {
                None => (arc.center_from_start_mm(&start), None),
                Some(basis) => {
                    let mut flat = start;
                    flat.set_xyz(basis.tr_mul(&start.xyz()));
                    let across = arc.plane.axes()[2].slot();
                    let normal = basis.column(across).into_owned();
                    (basis * arc.center_from_start_mm(&flat), Some(normal))
                }
            };
            for (letter, value) in [b" I", b" J", b" K"].into_iter().zip(ijk.iter()) {
                push_value(&mut self.line, letter, *value);
            }
            match normal {
                None => {
                    self.line.extend_from_slice(b" P");
                    push_integer(&mut self.line, u64::from(arc.plane.number()));
                }
                Some(normal) => {
                    for (letter, value) in [b" D", b" E", b" H"].into_iter().zip(normal.iter()) {
                        push_value(&mut self.line, letter, *value);
                    }
                }
            }
            if arc.extra_turns > 0 {
                self.line.extend_from_slice(b" L");
                push_integer(&mut self.line, u64::from(arc.extra_turns));
            }
        }
        if !motion.rapid && motion.feed >= LEAST_FEED {
            push_value(&mut self.line, b" F", motion.feed);
            if motion.unit != FeedUnit::PerMinute {
                self.line.push(b' ');
                self.line.extend_from_slice(motion.unit.word().as_bytes());
            }
        }
        self.position = motion.target;
    }
}

fn push_word(line: &mut Vec<u8>, letter: u8, extension: Option<u32>, value: &WordValue) {
    if !line.is_empty() {
        line.push(b' ');
    }
    line.push(letter);
    if let Some(extension) = extension {
        push_integer(line, u64::from(extension));
        line.push(b'=');
    }
    match value {
        WordValue::Number(number) => push_value(line, b"", *number),
        WordValue::Name(name) => {
            if extension.is_none() {
                line.push(b'=');
            }
            line.push(b'"');
            push_name(line, name);
            line.push(b'"');
        }
    }
}

/// Appends a name. Bytes with an effect on terminals, and bytes that are not UTF-8, become `\x1b`, which [`super::TextReader`] reads.
fn push_name(line: &mut Vec<u8>, name: &[u8]) {
    for chunk in name.utf8_chunks() {
        for character in chunk.valid().chars() {
            let mut buffer = [0; 4];
            let bytes = character.encode_utf8(&mut buffer).as_bytes();
            if is_deceptive(character) || character.is_control() {
                bytes.iter().for_each(|byte| push_byte(line, *byte));
            } else {
                line.extend_from_slice(bytes);
            }
        }
        chunk.invalid().iter().for_each(|byte| push_byte(line, *byte));
    }
}

fn push_byte(line: &mut Vec<u8>, byte: u8) {
    line.extend_from_slice(format!("\\x{byte:02x}").as_bytes());
}

/// Above this the value times 10⁶ is not an exact 64-bit integer.
const FIXED_LIMIT: f64 = 9e12;

/// Appends a value with up to 6 decimals, without trailing zeros, never `-0`.
fn push_value(line: &mut Vec<u8>, prefix: &[u8], value: f64) {
    line.extend_from_slice(prefix);
    if value.is_nan() || value.abs() >= FIXED_LIMIT {
        line.extend_from_slice(format!("{value}").as_bytes());
        return;
    }
    let micro = (value * 1e6).round() as i64;
    if micro < 0 {
        line.push(b'-');
    }
    let micro = micro.unsigned_abs();
    push_integer(line, micro / 1_000_000);
    let mut fraction = micro % 1_000_000;
    if fraction > 0 {
        line.push(b'.');
        let mut power = 100_000;
        while fraction > 0 {
            line.push(b'0' + u8::try_from(fraction / power).unwrap_or(0));
            fraction %= power;
            power /= 10;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::TextReader;
    use super::*;

    const TEXT: &str = "; snc 1 machine=demo units=mm
G0 X10 Y0 Z100 ;@12
G1 X20.5 Y0 Z-1 F500 ;@13
G2 X30.5 Y10 Z-1 I0 J10 K0 P17 L2 F500 ;@14
G1 X31 Y10 Z-1 F0.1 G95 ;@14
G1.W X31 Y10 Z-2 F100 ;@14
G0.V X31 Y10 Z-1 ;@14
G3.W X31 Y10 Z-1 I5 J0 K0 P17 F100 ;@14
G1 X32 Y10 Z-1 F12.5 G93 ;@14
G1 X33 Y10 Z-1 F100 ;@14
G4 S1.5 ;@15<9<3
T5 ;@16
T=\"MILL_10\" ;@16
M3 S1200 S2=500 ;@16
";

    #[test]
    fn text_that_is_read_and_printed_is_the_same() {
        let mut out = TextWriter::new(Vec::new(), "demo", AxisSet::XYZ, |_, tool| *tool).unwrap();
        let mut reader = TextReader::new(TEXT);
        while let Some(element) = reader.next() {
            out.write(&element.unwrap(), reader.call_lines()).unwrap();
        }
        assert_eq!(out.count(), 13);
        assert_eq!(String::from_utf8(out.finish().unwrap()).unwrap(), TEXT);
    }

    #[test]
    fn values_have_at_most_six_decimals_and_no_negative_zero() {
        for (value, text) in [
            (0.0, "0"),
            (-4e-7, "0"),
            (-0.000_001, "-0.000001"),
            (1.25, "1.25"),
            (-1234.5 - 1e-7, "-1234.5"),
            (1e6 - 1e-7, "1000000"),
        ] {
            let mut line = Vec::new();
            push_value(&mut line, b"", value);
            assert_eq!(String::from_utf8(line).unwrap(), text, "{value}");
        }
    }

    #[test]
    fn faults_name_their_line() {
        let mut reader = TextReader::new("G0 X1\nG9 X1\nG1 Q4\nG1 Xfoo\nG1 X1 F1 G96\n");
        assert!(reader.next().unwrap().is_ok());
        for line in 2..=5 {
            assert_eq!(reader.next().unwrap().unwrap_err().line, line);
        }
    }
}
