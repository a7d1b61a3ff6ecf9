//! Machine data of a Sinumerik as text: `N36100 $MA_POS_LIMIT_MINUS[AX1]=-10`, of an archive or an INI file.
//!
//! The geometry of TRAORI follows from MD24500 to MD24572, or from the swivel data record `$TC_CARR1` to `$TC_CARR23`. The formulas are those of the page
//! *Describe a five-axis Sinumerik*: BT, JO and JP are the base tool, the joint offset, and the joint offset on the part.

use std::collections::{BTreeMap, BTreeSet};

use super::reset_words::{ResetWord, reset_word};
use super::{ControlDataFormat, ControlFacts, DataNoteKind, known, number, rounded};
use crate::describe::known::Known;
use crate::describe::stated::TravelRange;
use crate::machine::Branch;
use ncfix_base::geometry::Axis;

/// Machine data of a Sinumerik.
pub(super) const FORMAT: ControlDataFormat = ControlDataFormat { name: "Sinumerik machine data", is, read };

/// Degrees of one turn: MD32000 of a rotary axis is in turns a minute.
const TURN_DEG: f64 = 360.0;
/// Machine axes of an 840D sl.
const MACHINE_AXES: u32 = 31;
/// Offsets below this are zero, mm or degrees.
const ZERO: f64 = 1e-9;

/// Vectors of a transformation that place its axes.
const OFFSETS: [&str; 4] = [
    "$MC_TRAFO5_BASE_TOOL_1",
    "$MC_TRAFO5_JOINT_OFFSET_1",
    "$MC_TRAFO5_JOINT_OFFSET_PART_1",
    "$MC_TRAFO5_PART_OFFSET_1",
];

/// Values by name and indices, with their lines.
type Values<'a> = BTreeMap<(String, String), (&'a str, usize)>;

fn is(text: &str) -> bool {
    text.lines().filter_map(assignment).any(|(name, ..)| {
        ["$MA_", "$MC_TRAFO", "$MN_AXCONF", "$TC_CARR", "$MC_GCODE_RESET"].iter().any(|start| name.starts_with(start))
    })
}

/// Name, indices and value of an assignment.
fn assignment(line: &str) -> Option<(String, String, &str)> {
    let line = line.split(';').next()?;
    let (left, value) = line.get(line.find('$')?..)?.split_once('=')?;
    let (name, index) = left.split_once('[').unwrap_or((left, ""));
    let index = index.replace([' ', ']'], "").to_ascii_uppercase();
    Some((name.trim().to_ascii_uppercase(), index, value.trim().trim_matches(['\'', '"'])))
}

fn read(name: &str, text: &str, facts: &mut ControlFacts) -> Result<(), String> {
    let mut values = Values::new();
    for (at, line) in text.lines().enumerate() {
        if let Some((key, index, value)) = assignment(line) {
            values.insert((key, index), (value, at + 1));
        }
    }
    check_values(name, &values)?;
    facts.control = Some(known("sinumerik".to_owned(), (name, 1), "machine data of a Sinumerik"));
    let letters = letters(&values);
    facts.axis_numbers = axis_numbers(name, &values, &letters);
    let mut unnamed = BTreeSet::new();
    for ((key, index), (value, line)) in &values {
        let Some(axis_index) = key.starts_with("$MA_").then(|| index.rsplit(',').next()).flatten() else { continue };
        let Some(axis) = letters.get(axis_index).copied() else {
            unnamed.insert(axis_index);
            continue;
        };
        axis_data(facts, (axis, axis_index), (key, value, (name, *line)), &values);
    }
    let arrays = ["$MN_AXCONF_MACHAX_NAME_TAB", "$MC_AXCONF_CHANAX_NAME_TAB", "$MC_AXCONF_MACHAX_USED"];
    let lacks = |array: &&str| !values.keys().any(|(key, _)| key == array);
    let missing = arrays.into_iter().filter(lacks).collect::<Vec<_>>().join(", ");
    let missing = if missing.is_empty() { String::new() } else { format!("; {name} lacks {missing}") };
    if !unnamed.is_empty() {
        let axes = unnamed.into_iter().collect::<Vec<_>>().join(", ");
        facts.note_as(DataNoteKind::Unused, format!(
            "{name} has data of {axes}, but the names of these axes are not known, so the data were not used{missing}"
        ));
    }
    let per_mm = values.get(&("$MN_INT_INCR_PER_MM".to_owned(), String::new()));
    if let Some((value, line)) = per_mm
        && let Ok(count) = value.parse::<u32>()
        && count > 0
    {
        facts.increments_per_mm = Some(known(count, (name, *line), "MD10200"));
    }
    reset_words(name, &values, facts);
    Geometry { name, values: &values }.read(&letters, facts)?;
    facts.note(format!("{name} does not state which slide carries the table: it follows from the template"));
    Ok(())
}

/// Machine data and parts of swivel data records with lengths, as their names begin: a value that is not a number must not count as missing.
const NUMBERS: [&str; 9] = [
    "$MA_POS_LIMIT_",
    "$MA_MAX_AX_VELO",
    "$MA_BACKLASH",
    "$MA_AX_MOTION_DIR",
    "$MC_TRAFO_TYPE_1",
    "$MC_TRAFO5_PART_OFFSET",
    "$MC_TRAFO5_BASE_TOOL",
    "$MC_TRAFO5_JOINT_OFFSET",
    "$MC_TRAFO5_AXIS",
];

/// Checks that lengths are in mm and that every number is one.
///
/// # Errors
/// A sentence on the first line that ncfix cannot use.
fn check_values(name: &str, values: &Values<'_>) -> Result<(), String> {
    if let Some((text, line)) = values.get(&("$MN_SCALING_SYSTEM_IS_METRIC".to_owned(), String::new()))
        && matches!(text.to_ascii_uppercase().as_str(), "0" | "FALSE")
    {
        return Err(format!(
            "{name}:{line} MD10240 is {text}: the lengths of these machine data are in inches, and ncfix reads mm; save them with MD10240 = 1"
        ));
    }
    for ((key, index), (text, line)) in values {
        if NUMBERS.iter().any(|begin| key.starts_with(begin)) && number(text).is_none() {
            return Err(format!(
                "{name}:{line} {key}[{index}] is {text}, which is not a number: write a point as its decimal sign"
            ));
        }
    }
    Ok(())
}

/// Words in force before the first block: MD20150.
fn reset_words(name: &str, values: &Values<'_>, facts: &mut ControlFacts) {
    for ((key, index), (text, line)) in values {
        if key != "$MC_GCODE_RESET_VALUES" {
            continue;
        }
        let word = index.parse().ok().zip(text.parse().ok()).and_then(|(element, place)| reset_word(element, place));
        match word {
            None | Some(ResetWord::Usual) => {}
            Some(ResetWord::Key(key)) => {
                facts.control_lines.push(known(key, (name, *line), &format!("MD20150[{index}]")));
            }
            Some(ResetWord::Unknown(word, assumed)) => facts.note_as(DataNoteKind::UnknownStart, format!(
                "{name}:{line} MD20150[{index}] is {text}: programs begin with {word}, and ncfix assumes {assumed}; write the word at the beginning of every program"
            )),
        }
    }
}

/// Axes by their numbers at the control; `None` if the text does not name the machine axes.
fn axis_numbers(
    name: &str,
    values: &Values<'_>,
    letters: &BTreeMap<String, Axis>,
) -> Option<Known<BTreeMap<usize, Axis>>> {
    let named = values.iter().find(|((key, _), _)| key == "$MN_AXCONF_MACHAX_NAME_TAB");
    let (_, (_, line)) = named?;
    let number = |index: &String| index.strip_prefix("AX").and_then(|digits| digits.parse().ok());
    let numbers = letters
        .iter()
        .filter_map(|(index, axis)| Some((number(index).filter(|n| *n <= MACHINE_AXES as usize)?, *axis)));
    let numbers = numbers.collect();
    Some(known(numbers, (name, *line), "MD10000"))
}

/// Axes by the indices of their machine data: `AX1`, and the name of the machine axis.
fn letters(values: &Values<'_>) -> BTreeMap<String, Axis> {
    let mut out = BTreeMap::new();
    let letter = |text: &str| match text.trim_end_matches(|last: char| last.is_ascii_digit()).as_bytes() {
        [letter] => Axis::from_letter(letter.to_ascii_uppercase()),
        _ => None,
    };
    for ((key, index), (value, _)) in values {
        if key == "$MN_AXCONF_MACHAX_NAME_TAB"
            && let (Ok(place), Some(axis)) = (index.parse::<u32>(), letter(value))
            && place < MACHINE_AXES
        {
            out.insert(format!("AX{}", place + 1), axis);
            out.insert(value.to_ascii_uppercase(), axis);
        }
    }
    // The name in the channel is the one that programs use.
    for ((key, index), (value, _)) in values {
        let used = values.get(&("$MC_AXCONF_MACHAX_USED".to_owned(), index.clone()));
        if key == "$MC_AXCONF_CHANAX_NAME_TAB"
            && let (Some(axis), Some((used, _))) = (letter(value), used)
        {
            out.insert(format!("AX{used}"), axis);
        }
    }
    for ((_, index), _) in values.iter().filter(|((key, _), _)| key.starts_with("$MA_")) {
        let last = index.rsplit(',').next().unwrap_or_default();
        if !last.starts_with("AX")
            && let Some(axis) = letter(last)
        {
            out.entry(last.to_owned()).or_insert(axis);
        }
    }
    out
}

fn axis_data(
    facts: &mut ControlFacts,
    (axis, index): (Axis, &str),
    (key, value, place): (&str, &str, (&str, usize)),
    values: &Values<'_>,
) {
    let Some(value) = number(value) else { return };
    let of = |key: &str| values.get(&(key.to_owned(), index.to_owned())).and_then(|(text, _)| number(text));
    match key {
        "$MA_POS_LIMIT_MINUS" => {
            let Some(high) = of("$MA_POS_LIMIT_PLUS").filter(|high| value < *high) else { return };
            if of("$MA_ROT_IS_MODULO") != Some(1.0) {
                let travel = TravelRange::Ends([value, high]);
                facts.axis_mut(axis).travel = Some(known(travel, place, "MD36100, MD36110"));
            }
        }
        "$MA_ROT_IS_MODULO" if value == 1.0 && axis.is_rotary() => {
            facts.axis_mut(axis).travel = Some(known(TravelRange::Modulo, place, "MD30310"));
        }
        "$MA_MAX_AX_VELO" if value > 0.0 => {
            let feed = if axis.is_rotary() { rounded(value * TURN_DEG) } else { value };
            facts.axis_mut(axis).max_feed = Some(known(feed, place, "MD32000"));
        }
        "$MA_AX_MOTION_DIR" if value < 0.0 => facts.note(format!(
            "{}:{} MD32100 of {axis} is -1: a reversed motor; the sense of the axis does not follow from it",
            place.0, place.1
        )),
        "$MA_BACKLASH" if value != 0.0 => facts.note(format!(
            "{}:{} MD32450: the control compensates {value} backlash of {axis}; ncfix needs only the rest",
            place.0, place.1
        )),
        _ => {}
    }
}

/// Data of the transformation in one file.
struct Geometry<'a> {
    name: &'a str,
    values: &'a Values<'a>,
}

/// Vectors of a transformation, mm; axes of rotation have any length.
struct Vectors {
    base_tool: [f64; 3],
    joint: [f64; 3],
    joint_part: [f64; 3],
    part: [f64; 3],
    first: Option<[f64; 3]>,
    second: Option<[f64; 3]>,
}

impl Geometry<'_> {
    fn get(&self, key: &str, index: &str) -> Option<(f64, usize)> {
        let (text, line) = self.values.get(&(key.to_owned(), index.to_owned()))?;
        Some((number(text)?, *line))
    }

    /// A vector of machine data, with elements 0 to 2; missing elements are 0.
    fn vector(&self, key: &str) -> Option<[f64; 3]> {
        let parts = ["0", "1", "2"].map(|index| self.get(key, index).map(|(value, _)| value));
        parts.iter().any(Option::is_some).then(|| parts.map(Option::unwrap_or_default))
    }

    /// A vector of the swivel data record 1.
    fn record(&self, first: u32) -> Option<[f64; 3]> {
        let parts = [0, 1, 2].map(|more| self.get(&format!("$TC_CARR{}", first + more), "1").map(|(value, _)| value));
        parts.iter().any(Option::is_some).then(|| parts.map(Option::unwrap_or_default))
    }

    fn read(&self, letters: &BTreeMap<String, Axis>, facts: &mut ControlFacts) -> Result<(), String> {
        if let Some((kind, line)) = self.get("$MC_TRAFO_TYPE_1", "") {
            return self.transformation((kind, line), facts);
        }
        let Some((kind, line)) = self.values.get(&("$TC_CARR23".to_owned(), "1".to_owned())) else { return Ok(()) };
        let vectors = |part, joint, base_tool, joint_part| Vectors {
            base_tool: self.record(base_tool).unwrap_or_default(),
            joint: self.record(joint).unwrap_or_default(),
            joint_part: self.record(joint_part).unwrap_or_default(),
            part: self.record(part).unwrap_or_default(),
            first: self.record(7),
            second: self.record(10),
        };
        // Records have no vector with the number 90.
        let (branches, vectors) = match kind.to_ascii_uppercase().as_str() {
            "P" => ([Branch::Workpiece; 2], vectors(18, 15, 4, 90)),
            "T" => ([Branch::Tool; 2], vectors(1, 4, 15, 90)),
            "M" => ([Branch::Tool, Branch::Workpiece], vectors(18, 1, 4, 15)),
            other => return Err(format!("{}:{line} $TC_CARR23[1] is {other}, which is neither T, P nor M", self.name)),
        };
        let axis = |key: &str| {
            let (text, _) = self.values.get(&(key.to_owned(), "1".to_owned()))?;
            letters.get(&text.to_ascii_uppercase()).copied().or_else(|| match text.as_bytes() {
                [letter] => Axis::from_letter(letter.to_ascii_uppercase()),
                _ => None,
            })
        };
        let axes = [axis("$TC_CARR21"), axis("$TC_CARR22")];
        self.take(axes, branches, [true; 2], &vectors, (*line, "swivel data record 1"), facts)
    }

    /// Elements of offsets that the file lacks, beside others that it has. A control that saves only changed data (MD11210) omits those that are 0.
    fn omitted(&self) -> Vec<String> {
        let mut omitted = Vec::new();
        for key in OFFSETS {
            let has = |index: &str| self.values.contains_key(&(key.to_owned(), index.to_owned()));
            let lacking = ["0", "1", "2"].into_iter().filter(|index| !has(index));
            let lacking: Vec<String> = lacking.map(|index| format!("{key}[{index}]")).collect();
            omitted.extend(lacking.into_iter().filter(|_| ["0", "1", "2"].into_iter().any(has)));
        }
        omitted
    }

    fn transformation(&self, (kind, line): (f64, usize), facts: &mut ControlFacts) -> Result<(), String> {
        let name = self.name;
        let branches = match kind as i64 {
            24 => [Branch::Tool; 2],
            40 => [Branch::Workpiece; 2],
            56 => [Branch::Tool, Branch::Workpiece],
            other => {
                facts.note(format!("{name}:{line} transformation type {other} is not read: give --pivot and --sense"));
                return Ok(());
            }
        };
        for index in ["0", "1"] {
            if let Some((value, line)) =
                self.get("$MC_TRAFO5_ROT_AX_OFFSET_1", index).filter(|(value, _)| value.abs() > ZERO)
            {
                return Err(format!(
                    "{name}:{line} MD24510 is {value}: a machine file has no key for an offset of a rotary axis"
                ));
            }
        }
        let omitted = self.omitted();
        if !omitted.is_empty() {
            facts.note(format!(
                "{name} has no {}: 0 is used, since a control that saves only changed data (MD11210) omits zeros; compare with the control",
                omitted.join(", ")
            ));
        }
        let vector = |key: &str| self.vector(key).unwrap_or_default();
        let vectors = Vectors {
            base_tool: vector("$MC_TRAFO5_BASE_TOOL_1"),
            joint: vector("$MC_TRAFO5_JOINT_OFFSET_1"),
            joint_part: vector("$MC_TRAFO5_JOINT_OFFSET_PART_1"),
            part: vector("$MC_TRAFO5_PART_OFFSET_1"),
            first: self.vector("$MC_TRAFO5_AXIS1_1"),
            second: self.vector("$MC_TRAFO5_AXIS2_1"),
        };
        let axis = |index: &str| {
            let (channel, _) = self.get("$MC_TRAFO_AXES_IN_1", index)?;
            let place = format!("{}", channel as i64 - 1);
            let (text, _) = self.values.get(&("$MC_AXCONF_CHANAX_NAME_TAB".to_owned(), place))?;
            match text.trim_end_matches(|last: char| last.is_ascii_digit()).as_bytes() {
                [letter] => Axis::from_letter(letter.to_ascii_uppercase()),
                _ => None,
            }
        };
        let signs = ["0", "1"].map(|index| {
            self.values
                .get(&("$MC_TRAFO5_ROT_SIGN_IS_PLUS_1".to_owned(), index.to_owned()))
                .is_none_or(|(text, _)| !matches!(text.to_ascii_uppercase().as_str(), "0" | "FALSE"))
        });
        self.take([axis("3"), axis("4")], branches, signs, &vectors, (line, "MD24100, MD24500 to MD24572"), facts)
    }

    fn take(
        &self,
        axes: [Option<Axis>; 2],
        branches: [Branch; 2],
        signs: [bool; 2],
        vectors: &Vectors,
        (line, remark): (usize, &str),
        facts: &mut ControlFacts,
    ) -> Result<(), String> {
        let name = self.name;
        let [Some(first), Some(second)] = axes else {
            facts.note_as(DataNoteKind::Unused, format!("{name}:{line} the names of the rotary axes are not known ($MC_AXCONF_CHANAX_NAME_TAB), so their positions and senses were not used: add the names, or give --pivot and --sense"));
            return Ok(());
        };
        let sum = |parts: &[[f64; 3]]| [0, 1, 2].map(|at| rounded(parts.iter().map(|part| part[at]).sum()));
        let Vectors { base_tool, joint, joint_part, part, .. } = *vectors;
        let (points, closing) = match branches {
            [Branch::Workpiece, _] => ([base_tool, sum(&[base_tool, joint])], sum(&[base_tool, joint, part])),
            [Branch::Tool, Branch::Tool] => ([sum(&[base_tool, joint]), base_tool], sum(&[base_tool, joint, part])),
            [Branch::Tool, Branch::Workpiece] => {
                ([base_tool, sum(&[base_tool, joint, joint_part])], sum(&[base_tool, joint, joint_part, part]))
            }
        };
        let place = (name, line);
        for (((axis, point), direction), is_plus) in
            [first, second].into_iter().zip(points).zip([vectors.first, vectors.second]).zip(signs)
        {
            let own = facts.axis_mut(axis);
            own.point_mm = Some(known(point, place, remark));
            if let Some(direction) = direction {
                own.direction = Some(known(crate::describe::known::signed(direction, is_plus), place, remark));
            } else {
                facts.note(format!("{name} has no vector of {axis}: give --sense"));
            }
        }
        facts.rotary = vec![(first, branches[0]), (second, branches[1])];
        facts.rotary_origin = format!("{name}:{line}");
        if closing.iter().any(|part| part.abs() > ZERO) {
            let [x, y, z] = closing;
            facts.zero_shift_mm = Some(known(closing, place, remark));
            facts.note(format!(
                "{name}:{line} the chain is not closed: TRAORI shifts the zero of the workpiece by ({x}, {y}, {z}) mm; add this to the zero offsets of this file, and give no zero offsets of the control with --setup"
            ));
        }
        Ok(())
    }
}
