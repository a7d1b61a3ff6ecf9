//! Flat programs that are generated without a source: axis positions in machine coordinates, for test plans.
//!
//! Zero offset and tool length must not be active: Sinumerik writes `SUPA` in every block and `D0`, Grundig `G53`. Fanuc knows machine coordinates
//! on rapid moves only, RS274/NGC on straight moves only. There these moves are `G90 G53`, and all others are increments of the last written
//! position. No offset changes increments, and they add up exactly because they are counts. After a stop or a cycle, increments begin with a `G90 G53
//! G0` to the last position of the axes. The first comments list what must be off.
//!
//! The program of a workpiece ([`flat_part`]) is in the coordinates of the workpiece instead, with its tool, as a part program is: a correction then
//! knows the tool, and the operator sets the zero.

use super::comment::in_parentheses;
use super::number::{Decimals, push_pointed, push_value};
use ncfix_base::geometry::{AXES, AXIS_COUNT, Axis, Plane, Vector};
use ncfix_base::units::push_integer;
use ncfix_dialect::Language;
use ncfix_machine::machine::{Machine, ToolChange};
use ncfix_machine::snc::{Dwell, Kind, Move, Word, WordValue};

/// The program number, for languages that number programs.
const NUMBER: u64 = 9001;
/// The largest block number if the machine file has none.
const LAST_BLOCK: u32 = 9_999_999;

/// Writes elements as a program of the machine's control: moves, dwells in seconds, S and M words, comments, and lines that are passed through.
///
/// # Errors
/// Returns a message if the control has no dialect or its increments are not decimals.
pub fn flat(machine: &Machine, title: &str, elements: &[Kind]) -> Result<Vec<u8>, String> {
    written(machine, title, elements, None)
}

/// Zero and tool of a program in the coordinates of a workpiece.
#[derive(Clone, Debug, PartialEq)]
pub struct PartFrame {
    /// The zero offset: `G54`.
    pub zero_offset: String,
    /// Its position as that of the tool tip: axis positions plus tool vector, mm.
    pub origin_mm: Vector,
    /// The tool, by its number at the control.
    pub tool: u32,
    /// From the spindle gauge point to the tip, along Z, mm.
    pub tool_mm: Vector,
}

/// Writes elements as [`flat`] does, but X, Y and Z in the coordinates of a workpiece, with its tool. Motion must be straight, and the zero offset must
/// not shift rotary axes.
///
/// # Errors
/// As [`flat`].
pub fn flat_part(machine: &Machine, title: &str, elements: &[Kind], part: &PartFrame) -> Result<Vec<u8>, String> {
    written(machine, title, elements, Some(part))
}

fn written(machine: &Machine, title: &str, elements: &[Kind], part: Option<&PartFrame>) -> Result<Vec<u8>, String> {
    let language = ncfix_dialect::find(&machine.controller).map(|dialect| dialect.language);
    let language = language.ok_or_else(|| format!("the controller '{}' is not a dialect", machine.controller))?;
    let decimals = |increment: f64| {
        let decimals = Decimals::of_increment(increment)
            .ok_or_else(|| format!("the increment {increment} of the control is not a decimal number"))?;
        Ok::<_, String>(if language == Language::Fanuc { decimals.pointed() } else { decimals })
    };
    // The conversion from radians is off in the last digit.
    let increment_deg = (machine.control.increment_rad.to_degrees() * 1e9).round() / 1e9;
    let mut writer = Flat {
        machine,
        language,
        linear: (machine.control.increment_mm, decimals(machine.control.increment_mm)?),
        rotary: (increment_deg, decimals(increment_deg)?),
        last: [None; AXIS_COUNT],
        plane: None,
        feed: 0.0,
        is_incremental: false,
        is_stale: [false; AXIS_COUNT],
        number: 0,
        part,
        has_length: false,
        out: Vec::new(),
    };
    writer.head(title);
    for element in elements {
        writer.element(element);
    }
    writer.foot();
    Ok(writer.out)
}

struct Flat<'a> {
    machine: &'a Machine,
    language: Language,
    /// Increment and its decimals: mm, degrees.
    linear: (f64, Decimals),
    rotary: (f64, Decimals),
    /// The last counts written.
    last: [Option<i64>; AXIS_COUNT],
    plane: Option<Plane>,
    feed: f64,
    is_incremental: bool,
    /// Axes that something other than this writer may have moved since.
    is_stale: [bool; AXIS_COUNT],
    number: u32,
    /// Zero and tool of a program in the coordinates of a workpiece.
    part: Option<&'a PartFrame>,
    /// `true` after the word of the tool length was written, where the language needs one.
    has_length: bool,
    out: Vec<u8>,
}

impl Flat<'_> {
    fn head(&mut self, title: &str) {
        self.title(title);
        self.plane = Some(Plane::XY);
        if let Some(part) = self.part {
            return self.part_head(part);
        }
        match self.language {
            Language::Sinumerik => {
                self.notes(&[
                    "positions of the axes in machine coordinates: SUPA and D0, zero offset and tool length are not active",
                    "feed in mm/min",
                ]);
                self.line(b"G17 G710 G90 G94 G40 G60");
                self.line(b"D0");
                self.select_head();
                if self.has_rotary() {
                    self.line(b"TRAFOOF");
                }
            }
            Language::Grundig => {
                self.notes(&[
                    "positions of the axes in machine coordinates: G53 suppresses zero offsets",
                    "the length of the tool in the spindle is active: load one of length 0 before the start",
                ]);
                self.line(b"G17 G71 G90 G94 G40");
                self.line(b"G53");
                self.select_head();
            }
            Language::Fanuc => {
                self.notes(&[
                    "positions of the axes in machine coordinates: G53, and increments from there",
                    "no rotation, scaling or mirror image may be active; G49 cancels the tool length",
                    "rapid of G53 at the first position and from stop to stop: use the override",
                ]);
                self.line(b"G21 G17 G90 G94 G40 G49 G80");
                self.select_head();
            }
            Language::Rs274 => {
                self.notes(&[
                    "positions of the axes in machine coordinates: G53, arcs as increments from there",
                    "no rotation of coordinates may be active; G49 cancels the tool length",
                ]);
                self.line(b"G21 G17 G90 G94 G40 G49 G80 G61");
                self.select_head();
            }
        }
    }

    /// The lines before all others.
    fn title(&mut self, title: &str) {
        match self.language {
            Language::Sinumerik | Language::Rs274 => self.comment(title.as_bytes()),
            Language::Grundig => {
                self.out.extend_from_slice(b"%PM");
                push_integer(&mut self.out, NUMBER);
                self.out.extend_from_slice(b"\nN");
                push_integer(&mut self.out, NUMBER);
                self.out.push(b' ');
                self.out.extend_from_slice(&in_parentheses(title.to_ascii_uppercase().as_bytes()));
                self.out.push(b'\n');
            }
            Language::Fanuc => {
                self.out.extend_from_slice(b"%\nO");
                push_integer(&mut self.out, NUMBER);
                self.out.push(b' ');
                self.out.extend_from_slice(&in_parentheses(title.to_ascii_uppercase().as_bytes()));
                self.out.push(b'\n');
            }
        }
    }

    /// The beginning of a program in the coordinates of a workpiece.
    fn part_head(&mut self, part: &PartFrame) {
        self.notes(&[
            "positions of the tool tip in the coordinates of the workpiece, with its zero offset and tool length",
        ]);
        self.line(match self.language {
            Language::Sinumerik => b"G17 G710 G90 G94 G40 G60",
            Language::Grundig => b"G17 G71 G90 G94 G40",
            Language::Fanuc => b"G21 G17 G90 G94 G40 G49 G80",
            Language::Rs274 => b"G21 G17 G90 G94 G40 G49 G80 G61",
        });
        // The head before its tool: a change is not possible while a tool length is active.
        self.select_head();
        let change = if self.machine.control.tool_change == ToolChange::M6 { " M6" } else { "" };
        // Sinumerik changes the tool in a block of its own, after which its edge is selected.
        if self.language == Language::Sinumerik && !change.is_empty() {
            self.line(format!("T{}", part.tool).as_bytes());
            self.line(b"M6");
        } else {
            self.line(format!("T{}{change}", part.tool).as_bytes());
        }
        if self.language == Language::Sinumerik {
            self.line(b"D1");
        }
        self.line(part.zero_offset.as_bytes());
        if self.language == Language::Sinumerik && self.has_rotary() {
            self.line(b"TRAFOOF");
        }
    }

    /// The word of the head in use, for a machine with several: which one is active at the start is unknown.
    fn select_head(&mut self) {
        let Some(head) = self.machine.heads.first().filter(|_| self.machine.heads.len() > 1) else { return };
        if let Some(word) = head.select.first() {
            self.comment(format!("M{word} selects the head {}: start where the head can turn", head.name).as_bytes());
            self.line(format!("M{word}").as_bytes());
        }
    }

    /// Writes the notes that a user must read before the start.
    fn notes(&mut self, notes: &[&str]) {
        notes.iter().for_each(|note| self.comment(note.as_bytes()));
    }

    fn has_rotary(&self) -> bool {
        AXES.into_iter().any(|axis| axis.is_rotary() && self.machine.axis(axis).is_some())
    }

    fn foot(&mut self) {
        if self.is_incremental {
            self.line(b"G90");
        }
        self.line(b"M30");
        if self.language == Language::Fanuc {
            self.out.extend_from_slice(b"%\n");
        }
    }

    fn element(&mut self, element: &Kind) {
        match element {
            Kind::Move(motion) => self.motion(motion),
            Kind::Dwell(Dwell::Seconds(seconds)) => {
                let mut line = match self.language {
                    Language::Sinumerik => b"G4 F".to_vec(),
                    Language::Grundig | Language::Fanuc => b"G4 X".to_vec(),
                    Language::Rs274 => b"G4 P".to_vec(),
                };
                self.value(&mut line, *seconds);
                self.line(&line);
            }
            Kind::Before(words) | Kind::After(words) => {
                let mut line = Vec::new();
                for Word { letter, value, .. } in words {
                    if let WordValue::Number(number) = value {
                        if !line.is_empty() {
                            line.push(b' ');
                        }
                        line.push(*letter);
                        push_value(&mut line, *number);
                    }
                }
                self.line(&line);
                if line == b"M0" {
                    self.is_stale = [true; AXIS_COUNT];
                }
            }
            Kind::Comment(text) => self.comment(text),
            Kind::Verbatim(text) => {
                // Cycles expect absolute positions.
                if std::mem::take(&mut self.is_incremental) {
                    self.line(b"G90");
                }
                self.line(text);
                self.is_stale = [true; AXIS_COUNT];
            }
            _ => {}
        }
    }

    fn motion(&mut self, motion: &Move) {
        let relative = self.part.is_none() && matches!(self.language, Language::Fanuc | Language::Rs274);
        // There is no position yet to which an increment could relate.
        let is_first = AXES.into_iter().any(|axis| self.machine.axis(axis).is_some() && self.last_of(axis).is_none());
        let is_straight = self.language == Language::Rs274 && motion.arc.is_none();
        let is_absolute = !relative || motion.rapid || is_first || is_straight;
        let is_rapid = motion.rapid || relative && is_first && !is_straight;
        let is_stale = |axis: Axis| self.machine.axis(axis).is_some() && self.is_stale[axis.slot()];
        if !is_absolute && AXES.into_iter().any(is_stale) {
            self.come_back();
        }
        let mut line = Vec::new();
        if let Some(arc) = motion.arc.filter(|arc| self.plane != Some(arc.plane)) {
            self.plane = Some(arc.plane);
            self.line(format!("G{}", arc.plane.number()).as_bytes());
        }
        match self.language {
            _ if self.part.is_some() => self.length_word(&mut line),
            Language::Sinumerik => line.extend_from_slice(b"SUPA "),
            Language::Grundig => {}
            Language::Fanuc | Language::Rs274 if is_absolute => {
                line.extend_from_slice(b"G90 G53 ");
                self.is_incremental = false;
            }
            Language::Fanuc | Language::Rs274 => {
                if !self.is_incremental {
                    self.line(b"G91");
                }
                self.is_incremental = true;
            }
        }
        line.extend_from_slice(match (&motion.arc, is_rapid) {
            (Some(arc), _) if arc.clockwise => b"G2",
            (Some(_), _) => b"G3",
            (None, true) => b"G0",
            (None, false) => b"G1",
        });
        let start = self.last;
        let bare = line.len();
        for axis in AXES.into_iter().filter(|&axis| self.machine.axis(axis).is_some()) {
            let count = self.count(axis, motion.target[axis] - self.zero_mm(axis));
            let before = self.last_of(axis);
            let is_known = before.is_some() && !self.is_stale[axis.slot()];
            if !is_known && !motion.named.contains(axis) {
                continue;
            }
            let is_in_plane = motion.arc.is_some_and(|arc| {
                let [abscissa, ordinate, _] = arc.plane.axes();
                axis == abscissa || axis == ordinate
            });
            if before == Some(count) && is_known && !is_in_plane {
                continue;
            }
            self.name(&mut line, axis);
            let shown = if is_absolute { count } else { count - before.unwrap_or(0) };
            self.decimals(axis).1.push(&mut line, shown);
            self.last[axis.slot()] = Some(count);
            self.is_stale[axis.slot()] = false;
        }
        if line.len() == bare {
            return;
        }
        if let Some(arc) = motion.arc {
            let [abscissa, ordinate, _] = arc.plane.axes();
            for (axis, center) in [abscissa, ordinate].into_iter().zip(arc.center_mm) {
                let center = self.count(axis, center);
                let from = if self.language == Language::Grundig { 0 } else { start[axis.slot()].unwrap_or(0) };
                line.extend_from_slice(&[b' ', b"IJK"[axis.dimension().min(2)]]);
                self.linear.1.push(&mut line, center - from);
            }
        }
        if !is_rapid && motion.feed > 0.0 && (motion.feed - self.feed).abs() > 0.0 {
            self.feed = motion.feed;
            line.extend_from_slice(b" F");
            self.value(&mut line, motion.feed);
        }
        self.line(&line);
    }

    /// The word that makes the tool length active, before the first position of a workpiece.
    fn length_word(&mut self, line: &mut Vec<u8>) {
        let needs = matches!(self.language, Language::Fanuc | Language::Rs274);
        if let Some(part) = self.part.filter(|_| needs && !self.has_length) {
            self.has_length = true;
            line.extend_from_slice(format!("G43 H{} ", part.tool).as_bytes());
        }
    }

    /// The axis position at zero of the program, mm; 0 for a rotary axis and in machine coordinates.
    fn zero_mm(&self, axis: Axis) -> f64 {
        let at = |part: &PartFrame| (part.origin_mm - part.tool_mm)[axis.dimension()];
        self.part.filter(|_| !axis.is_rotary()).map_or(0.0, at)
    }

    /// Returns to the last position of the axes, so that increments count from there. No axis moves if none was moved.
    fn come_back(&mut self) {
        let mut line = b"G90 G53 G0".to_vec();
        for axis in AXES {
            if let Some(count) = self.last_of(axis) {
                self.name(&mut line, axis);
                self.decimals(axis).1.push(&mut line, count);
            }
        }
        self.is_incremental = false;
        self.is_stale = [false; AXIS_COUNT];
        self.line(&line);
    }

    fn last_of(&self, axis: Axis) -> Option<i64> {
        self.last[axis.slot()]
    }

    fn decimals(&self, axis: Axis) -> (f64, Decimals) {
        if axis.is_rotary() { self.rotary } else { self.linear }
    }

    fn count(&self, axis: Axis, value: f64) -> i64 {
        let shown = if axis.is_rotary() { value.to_degrees() } else { value };
        // Axis travel is far below the range of a count.
        (shown / self.decimals(axis).0).round() as i64
    }

    fn name(&self, line: &mut Vec<u8>, axis: Axis) {
        line.push(b' ');
        match self.machine.axis(axis).and_then(|data| data.name.as_deref()) {
            Some(name) => {
                line.extend_from_slice(name.as_bytes());
                line.push(b'=');
            }
            None => line.push(axis.letter()),
        }
    }

    fn value(&self, line: &mut Vec<u8>, value: f64) {
        if self.language == Language::Fanuc {
            push_pointed(line, value);
        } else {
            push_value(line, value);
        }
    }

    fn comment(&mut self, text: &[u8]) {
        let text = if self.language == Language::Sinumerik {
            let mut line = b"; ".to_vec();
            line.extend(text.iter().map(|&byte| if (b' '..=b'~').contains(&byte) { byte } else { b'_' }));
            line
        } else {
            in_parentheses(&text.to_ascii_uppercase())
        };
        self.line(&text);
    }

    fn line(&mut self, text: &[u8]) {
        if self.language == Language::Grundig {
            let last = self.machine.control.last_block_number.unwrap_or(LAST_BLOCK).max(1);
            self.number = if self.number >= last { 1 } else { self.number + 1 };
            self.out.push(b'N');
            push_integer(&mut self.out, u64::from(self.number));
            self.out.push(b' ');
        }
        self.out.extend_from_slice(text);
        self.out.push(b'\n');
    }
}
