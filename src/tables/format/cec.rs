//! Sag and angularity compensation of the SINUMERIK 840D: `$AN_CEC` as an initialisation program.
//!
//! A table has a basic axis (input) and a compensation axis (output), equal steps between MIN and MAX, linear between, the end values
//! outside. Tables of one output are added; `$AN_CEC_MULT_BY_TABLE[t] = n` multiplies table t by the table of number n, which is its index
//! plus 1. The result is added to the set-point. (SINUMERIK 840D sl, Extended Functions K3 4.4.4; Esmaeili 2021, 2.4.5.3 and Fig. 7.3.)
//! Units are those of the basic system, mm here, and degrees.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::ini::{Assignment, Place};
use super::limits::{Holds, Limits};
use super::plain::{even_points, round_steps};
use super::scan::{Line, MOST_POINTS, Report, lines, shown};
use super::{Format, Written, rounded};
use crate::diagnostic::Diagnostic;
use crate::geometry::Axis;
use crate::source::{Source, Span};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};

/// Decimals of values that are added: a nanometre.
const DECIMALS: usize = 6;
/// Decimals of factors, whose products are smaller than they are.
const FACTOR_DECIMALS: usize = 8;
/// Decimals of positions.
const POSITION_DECIMALS: usize = 6;
/// Numbers of tables that are read: two for each of 31 axes, and some.
const MOST_TABLES: usize = 128;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "cec",
    title: "SINUMERIK $AN_CEC",
    sign: "values are added to the set-point of the output axis; the manual does not spell out the sign: try one large value on the machine",
    holds: &[Holds::Own, Holds::Cross, Holds::Products, Holds::Senses],
    // Two tables for each of 31 axes; MD18342 takes 2000 points; MD32720 takes 10 mm and is 1 mm as delivered.
    limits: Limits { tables: 62, points: 2000, value_mm: 10.0, resolution_mm: 1e-6 },
    round,
    faults,
    write,
    read,
    numbers,
    is_mine,
};

fn round(tables: &mut Tables) {
    let named: Vec<usize> = tables.lookups.iter().filter_map(|one| one.factor).collect();
    for (index, one) in tables.lookups.iter_mut().enumerate() {
        let decimals = if one.factor.is_some() || named.contains(&index) { FACTOR_DECIMALS } else { DECIMALS };
        one.values.iter_mut().for_each(|value| *value = rounded(*value, decimals));
        even_points(one, POSITION_DECIMALS);
        round_steps(one, POSITION_DECIMALS);
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        match one.nodes {
            Nodes::At(_) => faults.push(format!("table {index} has uneven steps, and $AN_CEC has equal ones")),
            Nodes::Even { start, step, end } if step <= 0.0 || end <= start => {
                faults.push(format!("table {index} has one point, and $AN_CEC has two at least"));
            }
            Nodes::Even { .. } => {}
        }
        let factor = one.factor.and_then(|factor| tables.lookups.get(factor));
        if factor.is_some_and(|factor| factor.output != one.output) {
            faults.push(format!("table {index} is multiplied by one that corrects another axis"));
        }
    }
    faults
}

/// What a table is, for a comment.
fn role(tables: &Tables, index: usize) -> String {
    let Some(one) = tables.lookups.get(index) else { return String::new() };
    let product = one.factor.map_or(String::new(), |factor| format!(", times table {}", factor + 1));
    format!("; table {}: {} over {}{product}", index + 1, one.output, one.input)
}

fn write(tables: &Tables, wiring: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::from("%_N_NC_CEC_INI\n");
    for note in notes {
        let _ = writeln!(text, "; {note}");
    }
    text.push_str("METRIC\nCHANDATA(1)\n");
    for (t, one) in tables.lookups.iter().enumerate() {
        let _ = writeln!(text, "{}", role(tables, t));
        for (n, value) in one.values.iter().enumerate() {
            let _ = writeln!(text, "$AN_CEC[{t},{n}]={value}");
        }
        let [start, end] = one.nodes.range();
        let step = if let Nodes::Even { step, .. } = one.nodes { step } else { 0.0 };
        let direction = match one.sense {
            Sense::Both => 0,
            Sense::Positive => 1,
            Sense::Negative => -1,
        };
        let rows = [
            ("INPUT_AXIS", wiring.name(one.input)),
            ("OUTPUT_AXIS", wiring.name(one.output)),
            ("STEP", step.to_string()),
            ("MIN", start.to_string()),
            ("MAX", end.to_string()),
            ("DIRECTION", direction.to_string()),
            ("MULT_BY_TABLE", one.factor.map_or(0, |factor| factor + 1).to_string()),
            ("IS_MODULO", u8::from(one.modulo).to_string()),
        ];
        for (name, value) in rows {
            let is_axis = name.ends_with("AXIS");
            let value = if is_axis { format!("({value})") } else { value };
            let _ = writeln!(text, "$AN_CEC_{name}[{t}]={value}");
        }
        if one.weight != 1.0 {
            let _ = writeln!(text, "$SN_CEC_TABLE_WEIGHT[{t}]={}", one.weight);
        }
        if !one.is_enabled {
            let _ = writeln!(text, "$SN_CEC_TABLE_ENABLE[{t}]=0");
        }
    }
    text.push_str("M17\n");
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    let has = |word: &[u8]| bytes.windows(word.len()).any(|part| part.eq_ignore_ascii_case(word));
    has(b"$AN_CEC") || has(b"_CEC_INI")
}

/// The numbers of the tables that a file has points of.
fn numbers(source: &Source) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut place = Place::new("CEC", "CEC");
    let mut report = Report::new(source);
    for line in lines(source) {
        place.line(&line, &mut report, |_, one| {
            found.extend(one.index(0, MOST_TABLES).filter(|_| one.name == "$AN_CEC"));
        });
    }
    found
}

/// A table as far as it was read.
#[derive(Clone, Debug, Default)]
struct Raw {
    /// Millimetres of its unit of length.
    unit_mm: f64,
    values: BTreeMap<usize, f64>,
    input: String,
    output: String,
    step: f64,
    min: f64,
    max: f64,
    sense: Sense,
    multiplied_by: usize,
    modulo: bool,
    weight: Option<f64>,
    is_disabled: bool,
    /// Where it begins.
    span: Option<Span>,
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut reader = Reader { report: Report::new(source), wiring, raw: BTreeMap::new() };
    let mut place = Place::new("CEC", "CEC");
    for line in lines(source) {
        let mut found = Vec::new();
        place.line(&line, &mut reader.report, |unit_mm, one| found.push((unit_mm, one)));
        for (unit_mm, one) in found {
            reader.assignment(&line, unit_mm, &one);
        }
        if reader.report.is_hopeless() {
            break;
        }
    }
    reader.finish(tables)
}

struct Reader<'a> {
    report: Report<'a>,
    wiring: &'a Wiring,
    raw: BTreeMap<usize, Raw>,
}

impl Reader<'_> {
    fn assignment(&mut self, line: &Line<'_>, unit_mm: f64, one: &Assignment<'_>) {
        let name = one.name.as_str();
        let Some(field) = name.strip_prefix("$AN_CEC").or_else(|| name.strip_prefix("$SN_CEC_TABLE")) else {
            if !name.starts_with("$MA_CEC") && !name.starts_with("$MN_MM_CEC") {
                let message = format!("{} is not part of the sag compensation and is left out", shown(name));
                self.report.unused(line, one.text, message, "read leadscrew tables with --format enc");
            }
            return;
        };
        let Some(t) = one.index(0, MOST_TABLES) else {
            let help = "write the index of the table, 0, 1, 2 …";
            self.report.fault(line, one.text, format!("'{}' has no index of a table", shown(one.text)), help);
            return;
        };
        let raw = self.raw.entry(t).or_insert_with(|| Raw { unit_mm, ..Raw::default() });
        raw.span.get_or_insert(line.span(one.text));
        if raw.unit_mm != unit_mm {
            let help = "write METRIC or INCH once, before the first table";
            self.report.fault(line, one.text, format!("the units of table {t} change in the middle of it"), help);
        }
        match field.strip_prefix('_') {
            None if field.is_empty() => self.point(line, t, one),
            Some("INPUT_AXIS") => raw.input = one.value.to_owned(),
            Some("OUTPUT_AXIS") => raw.output = one.value.to_owned(),
            Some("INPUT_NCU" | "OUTPUT_NCU") => {}
            Some(field) => self.parameter(line, t, field, one.value),
            None => self.unknown(line, one),
        }
    }

    fn unknown(&mut self, line: &Line<'_>, one: &Assignment<'_>) {
        let message = format!("{} is not known and is left out", shown(&one.name));
        self.report.unused(line, one.text, message, "look up what it does before the table is used");
    }

    /// The value of a point.
    fn point(&mut self, line: &Line<'_>, t: usize, one: &Assignment<'_>) {
        let Some(number) = self.report.number(line, one.value) else { return };
        let Some(n) = one.index(1, MOST_POINTS) else {
            let help = format!("write $AN_CEC[table,point]=value, with a point below {MOST_POINTS}");
            self.report.fault(line, one.text, format!("'{}' has no number of a point", shown(one.text)), &help);
            return;
        };
        let Some(raw) = self.raw.get_mut(&t) else { return };
        if raw.values.insert(n, number).is_some_and(|before| before != number) {
            let message = format!("point {n} of table {t} is there twice, with different values");
            self.report.fault(line, one.text, message, super::TWICE);
        }
    }

    /// One of the numbers that say what a table is.
    fn parameter(&mut self, line: &Line<'_>, t: usize, field: &str, value: &str) {
        let Some(number) = self.report.number(line, value) else { return };
        let Some(raw) = self.raw.get_mut(&t) else { return };
        match field {
            "STEP" => raw.step = number,
            "MIN" => raw.min = number,
            "MAX" => raw.max = number,
            "DIRECTION" if number == 0.0 => raw.sense = Sense::Both,
            "DIRECTION" if number == 1.0 => raw.sense = Sense::Positive,
            "DIRECTION" if number == -1.0 => raw.sense = Sense::Negative,
            "DIRECTION" => {
                let message = format!("table {t} has the direction {number}");
                self.report.fault(
                    line,
                    value,
                    message,
                    "write 0 for both senses, 1 for the positive or -1 for the negative one",
                );
            }
            "MULT_BY_TABLE" if number.fract() == 0.0 && (0.0..=MOST_TABLES as f64).contains(&number) => {
                raw.multiplied_by = number as usize;
            }
            "MULT_BY_TABLE" => {
                let message = format!("table {t} is multiplied by number {number}, which no table has");
                self.report.fault(line, value, message, "the number of a table is its index plus 1; 0 is none");
            }
            "IS_MODULO" => raw.modulo = number != 0.0,
            "WEIGHT" => raw.weight = Some(number),
            "ENABLE" => raw.is_disabled = number == 0.0,
            "TYPE" if number == 0.0 => {}
            "TYPE" => {
                let help = "only tables that depend on one axis are known ($AN_CEC_TYPE 0)";
                self.report.fault(line, value, format!("table {t} is of another type, {number}"), help);
            }
            _ => {
                let message = format!("$AN_CEC_{} is not known and is left out", shown(field));
                self.report.unused(line, value, message, "look up what it does before the table is used");
            }
        }
    }

    /// The tables, where each is complete.
    fn finish(mut self, tables: &mut Tables) -> Vec<Diagnostic> {
        let raw = std::mem::take(&mut self.raw);
        if raw.is_empty() {
            self.report.empty("no compensation table is in the file", "a table has lines such as $AN_CEC[0,0]=0.005");
        }
        let mut places = BTreeMap::new();
        for (&t, one) in &raw {
            let span = one.span.unwrap_or_default();
            if one.step != 0.0 && (one.step < 0.0 || one.max <= one.min) {
                let message = format!("table {t} has STEP {}, MIN {}, MAX {}", one.step, one.min, one.max);
                let help = "give it a step above 0 and MAX above MIN, or STEP 0 if it shall not be used";
                self.report.fault_at(span, message, help);
                continue;
            }
            if one.step == 0.0 {
                let message = format!("table {t} is not in use: STEP {}, MIN {}, MAX {}", one.step, one.min, one.max);
                self.report.unused_at(span, message, "give it a step above 0 and MAX above MIN if it shall be used");
                continue;
            }
            if let Some(lookup) = self.lookup(t, one, span) {
                places.insert(t, tables.lookups.len());
                tables.lookups.push(lookup);
            }
        }
        self.products(&raw, &places, tables);
        self.report.findings
    }

    /// Which table is multiplied by which.
    fn products(&mut self, raw: &BTreeMap<usize, Raw>, places: &BTreeMap<usize, usize>, tables: &mut Tables) {
        for (t, one) in raw {
            let (Some(&at), Some(other)) = (places.get(t), one.multiplied_by.checked_sub(1)) else { continue };
            let span = one.span.unwrap_or_default();
            if one.unit_mm != 1.0 {
                let message = format!("table {t} is multiplied by another one, in inches");
                let help =
                    "save the tables with the basic system METRIC: in which unit the control multiplies is not known";
                self.report.fault_at(span, message, help);
            }
            match (places.get(&other), tables.lookups.get_mut(at)) {
                (Some(&factor), Some(lookup)) => lookup.factor = Some(factor),
                _ => {
                    let message = format!("table {t} is multiplied by number {}, which is not there", other + 1);
                    self.report.fault_at(span, message, "the number of a table is its index plus 1");
                }
            }
        }
    }

    /// The axis of a name in a table.
    fn axis(&mut self, t: usize, what: &str, name: &str, span: Span) -> Option<Axis> {
        let axis = self.wiring.axis(name);
        if axis.is_none() && name.is_empty() {
            let help = "write $AN_CEC_INPUT_AXIS and $AN_CEC_OUTPUT_AXIS";
            self.report.fault_at(span, format!("table {t} has no {what} axis"), help);
        } else if axis.is_none() {
            let help = "give the machine, or name the axis with --axis-name X=AX1";
            self.report.fault_at(span, format!("table {t}: no axis is known as {}", shown(name)), help);
        }
        axis
    }

    fn lookup(&mut self, t: usize, raw: &Raw, span: Span) -> Option<Lookup> {
        let input = self.axis(t, "input", &raw.input, span);
        let output = self.axis(t, "output", &raw.output, span);
        let (input, output) = (input?, output?);
        let scale = |value: f64, axis: Axis| if axis.is_rotary() { value } else { value * raw.unit_mm };
        let nodes =
            Nodes::Even { start: scale(raw.min, input), step: scale(raw.step, input), end: scale(raw.max, input) };
        let count = nodes.count();
        if count > MOST_POINTS {
            self.report.fault_at(span, format!("table {t} has {count} points"), "choose a larger $AN_CEC_STEP");
            return None;
        }
        let surplus = raw.values.range(count..).filter(|(_, value)| **value != 0.0).count();
        if surplus > 0 {
            let message = format!("{surplus} values of table {t} lie behind MAX and are not used");
            self.report.unused_at(span, message, "the control does not use them either");
        }
        let missing = (0..count).filter(|n| !raw.values.contains_key(n)).count();
        if missing > 0 {
            let message = format!("{missing} of the {count} points of table {t} have no value");
            self.report.fault_at(span, message, super::KEEPS);
            return None;
        }
        if raw.is_disabled {
            let message = format!("table {t} is switched off: $SN_CEC_TABLE_ENABLE[{t}]=0");
            self.report.unused_at(span, message, "write 1 if something else switches it on");
        }
        let value = |n: usize| scale(raw.values.get(&n).copied().unwrap_or(0.0), output);
        Some(Lookup {
            sense: raw.sense,
            modulo: raw.modulo,
            weight: raw.weight.unwrap_or(1.0),
            is_enabled: !raw.is_disabled,
            ..Lookup::added(input, output, nodes, (0..count).map(value).collect())
        })
    }
}
