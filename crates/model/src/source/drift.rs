//! Zero-point drift: displacement of the tool relative to the workpiece as a weighted sum of temperatures (Spaan 1995, ch. 5 and 6).
//!
//! d = Σ cᵢ ΔTᵢ along an axis of F, or a rotation of the tool holder about it, at the gauge point of the spindle (Fig. 5.1: three displacements and two
//! rotations are measured.) ΔTᵢ is the rise of a sensor above the reference state, or of a body that follows the sensor with a time constant: a
//! sensor close to a heat source is ahead of the casting that expands. Coefficients are valid at one position of an axis; with several positions the drift is
//! linear between them and constant outside. `[[drift]]` has one entry for each direction and position.
//!
//! A drift ends when the zero point of the workpiece is set: it counts from the condition at that time.

use crate::ErrorModel;
use crate::accumulator::Accumulator;
use crate::motion::EntryFunction;
use crate::motion::table::ErrorTable;
use crate::name::{DIRECTIONS, Direction, ErrorName};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::{Axis, AxisSet, Vector, about};
use ncfix_base::units::{mm_from_um, rad_from_urad, um_from_mm, urad_from_rad};
use ncfix_machine::machine::file::Section;
use ncfix_machine::machine::{Condition, Lever, Machine};

use super::{Effect, MachineFileReading, Parameter, SourceInfo, WrittenAt};

/// Name, title and sections of the source.
pub(super) static SOURCE: SourceInfo = SourceInfo {
    name: "drift",
    title: "zero-point drift with temperature",
    sections: &["drift"],
    example: "\
[[drift]]
direction = \"X\"
sensors = [{ name = \"T_bed\", um_per_K = -0.8 }]
[[drift]]
direction = \"Y\"
over = \"Z\"
at_mm = 0
sensors = [{ name = \"T_head\", um_per_K = 3.1, lag_s = 600 }, { name = \"T_column\", um_per_K = 1.2 }]
[[drift]]
direction = \"Y\"
over = \"Z\"
at_mm = 400
sensors = [{ name = \"T_head\", um_per_K = 3.1, lag_s = 600 }, { name = \"T_column\", um_per_K = 2.9 }]
",
};

/// Key of a coefficient of a displacement, and of a rotation.
const UM_PER_K: &str = "um_per_K";
const URAD_PER_K: &str = "urad_per_K";

/// Drift in one direction.
#[derive(Clone, Debug, PartialEq)]
struct Drift {
    /// X, Y or Z of F; A, B or C for a rotation of the tool holder.
    direction: Direction,
    /// Axis along which it changes; `None` if it is constant over all positions.
    over: Option<Axis>,
    /// Nodes by increasing position; a single one if it is constant.
    nodes: Vec<Node>,
}

/// Drift at one position.
#[derive(Clone, Debug, PartialEq)]
struct Node {
    /// Number of its section.
    entry: usize,
    /// Position of the axis, mm or rad.
    at: f64,
    terms: Vec<Term>,
}

/// Contribution of one sensor.
#[derive(Clone, Debug, PartialEq)]
struct Term {
    sensor: String,
    /// mm or rad per K.
    per_k: f64,
    lag_s: f64,
}

/// Entry of the machine file with its place.
struct Entry {
    direction: Direction,
    over: Option<Axis>,
    node: Node,
    place: Place,
}

impl Node {
    /// Returns the drift in a condition, mm or rad. A sensor without a reading adds nothing; it is reported where readings are input.
    fn drift(&self, machine: &Machine, condition: &Condition) -> f64 {
        let part = |term: &Term| Some(term.per_k * machine.rise_k(condition, &term.sensor, term.lag_s)?);
        self.terms.iter().filter_map(part).sum()
    }
}

impl Effect for Drift {
    fn source(&self) -> &'static SourceInfo {
        &SOURCE
    }

    fn label(&self) -> String {
        let direction = self.direction.letter();
        self.over.map_or(direction.to_string(), |axis| format!("{direction} over {axis}"))
    }

    fn contribute(&self, condition: &Condition, sum: &mut Accumulator<'_>) {
        let machine = sum.machine();
        let values: Vec<f64> = self.nodes.iter().map(|node| node.drift(machine, condition)).collect();
        if self.direction.is_rotation() {
            return sum.add_location(ErrorName::spindle(self.direction), values.iter().sum());
        }
        let unit = Vector::ith(self.direction.index(), 1.0);
        let Some(over) = self.over else {
            return sum.add_offset(&(unit * values.iter().sum::<f64>()));
        };
        let table = |values| {
            let positions = self.nodes.iter().map(|node| node.at).collect();
            EntryFunction::Table(ErrorTable { positions, values })
        };
        match machine.axis(over) {
            // The errors of a rotary axis rotate with its body: the displacement along the axis of F at each position, in the frame of the body.
            Some(axis) if over.is_rotary() && axis.lever == Lever::Carried => {
                let turned: Vec<Vector> =
                    self.nodes.iter().map(|node| about(&axis.direction, -node.at) * unit).collect();
                for (index, direction) in DIRECTIONS.into_iter().take(3).enumerate() {
                    let part = turned.iter().zip(&values).map(|(turned, value)| turned[index] * value).collect();
                    sum.add_relative(direction, over, &table(part));
                }
            }
            _ => sum.add_relative(self.direction, over, &table(values)),
        }
    }

    fn visit_parameters(&mut self, visit: &mut dyn FnMut(&Parameter<'_>, &mut f64)) {
        let (direction, over) = (self.direction.letter(), self.over);
        let is_rotation = self.direction.is_rotation();
        for node in &mut self.nodes {
            let place = match over {
                Some(axis) if axis.is_rotary() => format!("{direction}@{axis}{}", node.at.to_degrees()),
                Some(axis) => format!("{direction}@{axis}{}", node.at),
                None => direction.to_string(),
            };
            let entry = node.entry;
            for index in 0..node.terms.len() {
                let (before, rest) = node.terms.split_at_mut(index);
                let Some(term) = rest.first_mut() else { continue };
                // A sensor may occur twice, with and without a lag.
                let again = before.iter().filter(|other| other.sensor == term.sensor).count();
                let number = if again > 0 { format!("~{}", again + 1) } else { String::new() };
                let name = format!("drift.{place}.{}{number}", term.sensor);
                let (unit, factor) =
                    if is_rotation { (URAD_PER_K, urad_from_rad(1.0)) } else { (UM_PER_K, um_from_mm(1.0)) };
                let key = format!("sensors[{index}].{unit}");
                let written = Some(WrittenAt { entry, key: &key, factor });
                visit(&Parameter { name: &name, is_linear: true, written }, &mut term.per_k);
                if term.lag_s > 0.0 {
                    let key = format!("sensors[{index}].lag_s");
                    let written = Some(WrittenAt { entry, key: &key, factor: 1.0 });
                    let name = format!("{name}.lag_s");
                    visit(&Parameter { name: &name, is_linear: false, written }, &mut term.lag_s);
                }
            }
        }
    }

    fn sensors(&self) -> Vec<&str> {
        self.nodes.iter().flat_map(|node| &node.terms).map(|term| term.sensor.as_str()).collect()
    }

    fn drifts(&self) -> bool {
        true
    }
}

pub(super) fn read(reading: &mut MachineFileReading<'_, '_>, errors: &mut ErrorModel) {
    let (axes, machine) = (reading.axes, reading.machine);
    let sections = reading.root.sections("drift");
    let entries: Vec<Entry> = sections
        .into_iter()
        .enumerate()
        .filter_map(|(number, section)| {
            let mut entry = read_entry(section, axes, machine, reading.findings)?;
            entry.node.entry = number;
            Some(entry)
        })
        .collect();
    for direction in DIRECTIONS {
        let own = entries.iter().filter(|entry| entry.direction == direction).collect();
        errors.effects.extend(join(own, reading.findings).map(|drift| Box::new(drift) as Box<dyn Effect>));
    }
}

/// Joins the entries of one direction to one drift.
fn join(mut entries: Vec<&Entry>, findings: &mut Vec<Diagnostic>) -> Option<Drift> {
    let first = *entries.first()?;
    let by = |over: Option<Axis>| over.map_or("the same everywhere".to_owned(), |axis| format!("over {axis}"));
    for other in entries.iter().filter(|entry| entry.over != first.over) {
        let message = format!(
            "the drift of {} is {} here and {} before",
            other.direction.letter(),
            by(other.over),
            by(first.over)
        );
        let help = "give all entries of a direction positions of the same axis, or make it one entry without over";
        findings.push(Diagnostic::at(Code::BAD_VALUE, other.place, message, help));
    }
    entries.retain(|entry| entry.over == first.over);
    // The sort is stable: of two entries for one position the later one is reported.
    entries.sort_by(|one, other| one.node.at.total_cmp(&other.node.at));
    for pair in entries.windows(2).filter(|pair| pair[0].node.at >= pair[1].node.at) {
        let letter = first.direction.letter();
        let message = match first.over {
            Some(_) => format!("the drift of {letter} at this position is given twice"),
            None => format!("the drift of {letter} is given twice"),
        };
        let help = "write one entry with all sensors, or give each entry its position with over and at_mm (at_deg)";
        findings.push(Diagnostic::at(Code::BAD_TABLE, pair[1].place, message, help));
    }
    let nodes = entries.into_iter().map(|entry| entry.node.clone()).collect();
    Some(Drift { direction: first.direction, over: first.over, nodes })
}

fn read_entry(
    mut section: Section<'_>,
    axes: AxisSet,
    machine: Option<&Machine>,
    findings: &mut Vec<Diagnostic>,
) -> Option<Entry> {
    let direction = read_direction(&mut section);
    let over = read_over(&mut section, axes, machine);
    let is_rotation = direction.is_some_and(Direction::is_rotation);
    let terms = read_terms(&mut section, is_rotation);
    if is_rotation && section.has("over") {
        let help = "write one entry for all positions; only displacements may change along an axis";
        let place = section.place_of_key("over");
        section.report(Code::BAD_VALUE, place, "a rotation of the tool holder over an axis", help);
    }
    let place = section.place();
    section.finish(findings);
    let (over, at) = over?;
    Some(Entry { direction: direction?, over, node: Node { entry: 0, at, terms: terms? }, place })
}

fn read_direction(section: &mut Section<'_>) -> Option<Direction> {
    let text = section.required("direction", "\"Y\"", Section::text)?;
    let known = match text {
        "X" => Some(Direction::X),
        "Y" => Some(Direction::Y),
        "Z" => Some(Direction::Z),
        "A" => Some(Direction::A),
        "B" => Some(Direction::B),
        "C" => Some(Direction::C),
        _ => None,
    };
    if known.is_none() {
        let message = format!("direction must be \"X\", \"Y\" or \"Z\", or \"A\", \"B\" or \"C\", found \"{text}\"");
        let help = "write the axis of the machine coordinates along which the tool drifts; A, B and C are rotations about X, Y and Z";
        section.report(Code::BAD_VALUE, section.place_of("direction"), message, help);
    }
    known
}

/// Reads the axis and its position; no axis and 0 if the drift is constant over all positions.
fn read_over(section: &mut Section<'_>, axes: AxisSet, machine: Option<&Machine>) -> Option<(Option<Axis>, f64)> {
    if !section.has("over") {
        section.accept("over");
        for key in ["at_mm", "at_deg"] {
            section.accept(key);
            if section.has(key) {
                let place = section.place_of_key(key);
                let help = "write over = \"Z\" with the axis whose position this is, or leave it out";
                section.report(Code::MISSING_KEY, place, format!("{key} without over"), help);
                return None;
            }
        }
        return Some((None, 0.0));
    }
    let letter = section.text("over");
    let axis = letter.and_then(|letter| match letter.as_bytes() {
        [byte @ b'A'..=b'Z'] => Axis::from_letter(*byte).filter(|&axis| axes.contains(axis)),
        _ => None,
    });
    let Some(axis) = axis else {
        section.accept("at_mm");
        section.accept("at_deg");
        if let Some(letter) = letter {
            let known: Vec<String> = axes.iter().map(|axis| axis.to_string()).collect();
            let message = format!("over must be an axis of the machine, found \"{letter}\"");
            section.report(
                Code::BAD_VALUE,
                section.place_of("over"),
                message,
                format!("write one of {}", known.join(" ")),
            );
        }
        return None;
    };
    if let Some(rotary) = machine.and_then(|machine| turned_by(machine, axis)) {
        let message = format!("{rotary} carries {axis} and turns what drifts with {axis}");
        let help = format!("give the drift over {rotary} or over an axis that no rotary axis carries");
        section.report(Code::BAD_VALUE, section.place_of("over"), message, help);
    }
    let (key, wrong, kind) =
        if axis.is_rotary() { ("at_deg", "at_mm", "rotary") } else { ("at_mm", "at_deg", "linear") };
    if section.has(wrong) {
        section.accept(key);
        section.accept(wrong);
        let place = section.place_of_key(wrong);
        section.report(Code::WRONG_UNIT, place, format!("{wrong}: {axis} is {kind}"), format!("write {key}"));
        return None;
    }
    let at = section.required(key, "100", Section::number)?;
    let is_endless = machine.and_then(|machine| machine.axis(axis)).is_some_and(|data| data.modulo);
    if is_endless && !(0.0..=360.0).contains(&at) {
        let message = format!("{axis} is a modulo axis: its positions are 0 to 360°, found {at}");
        section.report(Code::BAD_VALUE, section.place_of(key), message, "write the position within the turn");
    }
    Some((Some(axis), if axis.is_rotary() { at.to_radians() } else { at }))
}

/// Returns the rotary axis between the foundation and an axis, if any.
fn turned_by(machine: &Machine, axis: Axis) -> Option<Axis> {
    let topology = &machine.topology;
    let branch = if topology.tool.contains(&axis) { &topology.tool } else { &topology.workpiece };
    branch.iter().copied().take_while(|&carrier| carrier != axis).find(|carrier| carrier.is_rotary())
}

fn read_terms(section: &mut Section<'_>, is_rotation: bool) -> Option<Vec<Term>> {
    let example = match is_rotation {
        true => "[{ name = \"T_head\", urad_per_K = 2.4, lag_s = 600 }]",
        false => "[{ name = \"T_head\", um_per_K = 3.1, lag_s = 600 }]",
    };
    let sections = section.required("sensors", example, |section, key| Some(section.sections(key)))?;
    if sections.is_empty() {
        let place = section.place_of("sensors");
        section.report(Code::BAD_VALUE, place, "sensors is empty", format!("write for example `sensors = {example}`"));
        return None;
    }
    let mut findings = Vec::new();
    let terms: Vec<Option<Term>> =
        sections.into_iter().map(|section| read_term(section, is_rotation, &mut findings)).collect();
    section.add(findings);
    terms.into_iter().collect()
}

fn read_term(mut section: Section<'_>, is_rotation: bool, findings: &mut Vec<Diagnostic>) -> Option<Term> {
    let sensor = section.required("name", "\"T_head\"", Section::text);
    let key = if is_rotation { URAD_PER_K } else { UM_PER_K };
    let per_k = section.required(key, "3.1", |section, key| {
        section.number_where(key, "a number from -10000 to 10000", |value| value.abs() <= 1e4)
    });
    let lag_s = section.number_where("lag_s", "a time in s that is not negative", |lag_s| lag_s >= 0.0);
    section.finish(findings);
    Some(Term {
        sensor: sensor?.to_owned(),
        per_k: if is_rotation { rad_from_urad(per_k?) } else { mm_from_um(per_k?) },
        lag_s: lag_s.unwrap_or(0.0),
    })
}
