//! Sag and angularity compensation of the SINUMERIK 840D: `$AN_CEC` as an initialisation program.
//!
//! A table has a basic axis (input) and a compensation axis (output), equal steps between MIN and MAX, linear between, the end values
//! outside. Tables of one output are added; `$AN_CEC_MULT_BY_TABLE[t] = n` multiplies table t by the table of number n, which is its index
//! plus 1. The result is added to the set-point. (SINUMERIK 840D sl, Extended Functions K3 4.4.4; Esmaeili 2021, 2.4.5.3 and Fig. 7.3.)
//! Units are those of the basic system, mm here, and degrees.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::limits::{Holds, Limits};
use super::scan::{Line, Report, lines};
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
/// Points of a table that are read: more than `MM_CEC_MAX_POINTS` allows.
const MOST_POINTS: usize = 5000;
/// Numbers of tables that are read: two for each of 31 axes, and some.
const MOST_TABLES: usize = 128;
/// Millimetres of an inch.
const INCH_MM: f64 = 25.4;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "cec",
    title: "SINUMERIK $AN_CEC",
    holds: &[Holds::Own, Holds::Cross, Holds::Products, Holds::Senses],
    // Two tables for each of 31 axes; MD18342 takes 2000 points; MD32720 takes 10 mm and is 1 mm as delivered.
    limits: Limits { tables: 62, points: 2000, value_mm: 10.0, resolution_mm: 1e-6 },
    round,
    faults,
    write,
    read,
    is_mine,
};

fn round(tables: &mut Tables) {
    let named: Vec<usize> = tables.lookups.iter().filter_map(|one| one.factor).collect();
    for (index, one) in tables.lookups.iter_mut().enumerate() {
        let decimals = if one.factor.is_some() || named.contains(&index) { FACTOR_DECIMALS } else { DECIMALS };
        one.values.iter_mut().for_each(|value| *value = rounded(*value, decimals));
        if let Nodes::Even { start, step, end } = &mut one.nodes {
            for value in [start, step, end] {
                *value = rounded(*value, POSITION_DECIMALS);
            }
        }
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        if matches!(one.nodes, Nodes::At(_)) {
            faults.push(format!("table {index} has uneven steps, and $AN_CEC has equal ones"));
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
    let one = &tables.lookups[index];
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

/// A table as far as it was read.
#[derive(Clone, Debug, Default)]
struct Raw {
    values: BTreeMap<usize, f64>,
    input: Option<Axis>,
    output: Option<Axis>,
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
    let mut reader = Reader { report: Report::new(source), wiring, raw: BTreeMap::new(), unit: 1.0 };
    for line in lines(source) {
        reader.line(&line);
    }
    reader.finish(source, tables)
}

struct Reader<'a> {
    report: Report<'a>,
    wiring: &'a Wiring,
    raw: BTreeMap<usize, Raw>,
    /// Millimetres of a unit of length.
    unit: f64,
}

impl Reader<'_> {
    fn line(&mut self, line: &Line<'_>) {
        let mut rest = line.before(';').trim();
        if rest.starts_with('%') {
            return;
        }
        if let Some(number) =
            rest.strip_prefix(['N', 'n']).filter(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
        {
            rest = number.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        }
        while !rest.is_empty() {
            let (statement, behind) = match rest[1..].find('$') {
                Some(at) => rest.split_at(at + 1),
                None => (rest, ""),
            };
            self.statement(line, statement.trim());
            rest = behind;
        }
    }

    fn statement(&mut self, line: &Line<'_>, text: &str) {
        let upper = text.to_ascii_uppercase();
        match upper.as_str() {
            "" | "METRIC" | "M17" | "M30" | "M2" | "M02" | "RET" | "NEWCONF" | "STOPRE" => return,
            "INCH" => {
                self.unit = INCH_MM;
                return;
            }
            _ if upper.starts_with("CHANDATA") => return,
            _ => {}
        }
        let Some((left, value)) = text.split_once('=') else {
            let help = "a table is a list of assignments such as $AN_CEC[0,0]=0.005";
            self.report.fault(line, text, format!("'{text}' is no assignment"), help);
            return;
        };
        let value = value.trim();
        let (name, indices) = left.split_once('[').unwrap_or((left, ""));
        let indices: Vec<&str> = indices.trim().trim_end_matches(']').split(',').map(str::trim).collect();
        let name = name.trim().to_ascii_uppercase();
        let Some(field) = name.strip_prefix("$AN_CEC").or_else(|| name.strip_prefix("$SN_CEC_TABLE")) else {
            if !name.starts_with("$MA_CEC") && !name.starts_with("$MN_MM_CEC") {
                let message = format!("{name} is not part of the sag compensation and is left out");
                self.report.unused(line, text, message, "read leadscrew tables with --format enc");
            }
            return;
        };
        let t = indices.first().and_then(|index| index.parse::<usize>().ok()).filter(|&t| t < MOST_TABLES);
        let Some(t) = t else {
            let help = "write the index of the table, 0, 1, 2 …";
            self.report.fault(line, left, format!("'{}' has no index of a table", left.trim()), help);
            return;
        };
        self.raw.entry(t).or_default().span.get_or_insert(line.span(text));
        let is_shared = name.starts_with("$SN");
        self.assign(line, t, if is_shared { field } else { field.trim_start_matches('_') }, &indices, value);
    }

    /// One value of a table.
    fn assign(&mut self, line: &Line<'_>, t: usize, field: &str, indices: &[&str], value: &str) {
        match field {
            "INPUT_AXIS" | "OUTPUT_AXIS" => {
                let axis = self.wiring.axis(value);
                if axis.is_none() {
                    let help = "give the machine, or name the axis with --axis-name X=AX1";
                    self.report.fault(line, value, format!("no axis is known as {value}"), help);
                }
                if let Some(raw) = self.raw.get_mut(&t) {
                    let place = if field == "INPUT_AXIS" { &mut raw.input } else { &mut raw.output };
                    *place = axis;
                }
                return;
            }
            "INPUT_NCU" | "OUTPUT_NCU" => return,
            _ => {}
        }
        let Some(number) = self.report.number(line, value) else { return };
        let Some(raw) = self.raw.get_mut(&t) else { return };
        match field {
            "" => {
                let n = indices.get(1).and_then(|index| index.parse::<usize>().ok()).filter(|&n| n < MOST_POINTS);
                match n {
                    Some(n) => drop(raw.values.insert(n, number)),
                    None => {
                        let help = "write $AN_CEC[table,point]=value";
                        self.report.fault(line, indices.last().copied().unwrap_or(value), "no number of a point", help);
                    }
                }
            }
            "STEP" => raw.step = number,
            "MIN" => raw.min = number,
            "MAX" => raw.max = number,
            "DIRECTION" => {
                raw.sense = if number > 0.0 {
                    Sense::Positive
                } else if number < 0.0 {
                    Sense::Negative
                } else {
                    Sense::Both
                }
            }
            "MULT_BY_TABLE" => raw.multiplied_by = number.clamp(0.0, MOST_TABLES as f64) as usize,
            "IS_MODULO" => raw.modulo = number != 0.0,
            "_WEIGHT" => raw.weight = Some(number),
            "_ENABLE" => raw.is_disabled = number == 0.0,
            "TYPE" if number == 0.0 => {}
            "TYPE" => {
                let help = "ncfix knows tables that depend on one axis ($AN_CEC_TYPE 0)";
                self.report.fault(line, value, format!("table {t} is of another type, {number}"), help);
            }
            _ => {
                let message = format!("$AN_CEC_{field} is not known and is left out");
                self.report.unused(line, value, message, "look up what it does before the table is used");
            }
        }
    }

    /// The tables, where each is complete.
    fn finish(mut self, source: &Source, tables: &mut Tables) -> Vec<Diagnostic> {
        if self.raw.is_empty() {
            let help = "an $AN_CEC file has lines such as $AN_CEC[0,0]=0.005";
            self.report.fault_at(
                Span::new(0, source.bytes().len().min(1)),
                "no compensation table is in the file",
                help,
            );
        }
        let first = tables.lookups.len();
        let mut places = BTreeMap::new();
        let raw = std::mem::take(&mut self.raw);
        for (&t, one) in &raw {
            let span = one.span.unwrap_or_default();
            if one.step <= 0.0 || one.max <= one.min {
                let message = format!("table {t} is not in use: STEP {}, MIN {}, MAX {}", one.step, one.min, one.max);
                self.report.unused_at(span, message, "give it a step above 0 and MAX above MIN if it shall be used");
                continue;
            }
            if let Some(lookup) = self.lookup(t, one, span) {
                places.insert(t, tables.lookups.len());
                tables.lookups.push(lookup);
            }
        }
        for (t, at) in &places {
            let one = &raw[t];
            let Some(other) = one.multiplied_by.checked_sub(1) else { continue };
            match places.get(&other) {
                Some(&factor) => tables.lookups[*at].factor = Some(factor),
                None => {
                    let message = format!("table {t} is multiplied by number {}, which is not there", other + 1);
                    let help = "the number of a table is its index plus 1";
                    self.report.fault_at(one.span.unwrap_or_default(), message, help);
                }
            }
        }
        debug_assert!(tables.lookups.len() >= first);
        self.report.findings
    }

    fn lookup(&mut self, t: usize, raw: &Raw, span: Span) -> Option<Lookup> {
        let (Some(input), Some(output)) = (raw.input, raw.output) else {
            let help = "write $AN_CEC_INPUT_AXIS and $AN_CEC_OUTPUT_AXIS";
            self.report.fault_at(span, format!("table {t} has no input or no output axis"), help);
            return None;
        };
        let unit = |axis: Axis| if axis.is_rotary() { 1.0 } else { self.unit };
        let scale = |value: f64, factor: f64| if factor == 1.0 { value } else { value * factor };
        let nodes = Nodes::Even {
            start: scale(raw.min, unit(input)),
            step: scale(raw.step, unit(input)),
            end: scale(raw.max, unit(input)),
        };
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
        if missing > 0 && missing < count {
            let message = format!("{missing} of the {count} points of table {t} have no value and count as 0");
            self.report.unused_at(span, message, "the control keeps what it had there; write every point");
        }
        let value = |n: usize| scale(raw.values.get(&n).copied().unwrap_or(0.0), unit(output));
        let mut lookup = Lookup::added(input, output, nodes, (0..count).map(value).collect());
        lookup.sense = raw.sense;
        lookup.modulo = raw.modulo;
        lookup.weight = raw.weight.unwrap_or(1.0);
        lookup.is_enabled = !raw.is_disabled;
        Some(lookup)
    }
}
