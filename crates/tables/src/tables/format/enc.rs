//! Leadscrew (encoder) error compensation of the SINUMERIK 840D: `$AA_ENC_COMP` as an initialisation program.
//!
//! A table of an axis on itself, in equal steps between MIN and MAX, linear between, the end values outside; one for each of the two measuring
//! systems (SINUMERIK 840D sl, Extended Functions K3 4.4.2). The values correct the encoder position: a positive value moves the axis in the NEGATIVE
//! direction, so the correction added to a command is the negated value (SINUMERIK 808D, Function Manual, leadscrew error compensation). It should be
//! 0 at the reference point. Units are mm and degrees.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::ini::{self, IniAssignment, IniPosition, KEEPS_FIELDS, missing};
use super::limits::{FormatLimits, Holds};
use super::plain::{even_points, round_steps, weigh};
use super::scan::{MOST_POINTS, Report, ScannedLine, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{Lookup, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::source::{Source, Span};

/// Decimals of values and positions: a nanometer.
const DECIMALS: usize = 6;
/// Maximum number of tables that are read: 31 axes with two measuring systems each.
const MOST_TABLES: usize = 62;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "enc",
    title: "SINUMERIK $AA_ENC_COMP",
    sign: "positive values move the axis in the negative direction, because they correct the encoder reading",
    holds: &[Holds::Own, Holds::Repetition],
    // One for each of 31 axes; MD38000 accepts 5000 points; the largest value is not documented.
    limits: FormatLimits { tables: 31, points: 5000, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
    round,
    faults,
    write,
    read,
    numbers: super::without_numbers,
    beside: &["cec"],
    sum_limit: None,
    has_axis_numbers: true,
    is_mine,
};

fn round(tables: &mut Tables) {
    weigh(tables);
    for one in &mut tables.lookups {
        one.values.iter_mut().for_each(|value| *value = rounded(*value, DECIMALS));
        even_points(one, DECIMALS);
        round_steps(one, DECIMALS);
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let mut faults = Vec::new();
    for (index, one) in tables.lookups.iter().enumerate() {
        match one.nodes {
            Nodes::At(_) => faults.push(format!("table {index} has uneven steps, and $AA_ENC_COMP has equal ones")),
            Nodes::Even { start, step, end } if step <= 0.0 || end <= start => {
                faults.push(format!("table {index} has one point, and $AA_ENC_COMP has two at least"));
            }
            Nodes::Even { .. } => {}
        }
        if one.modulo && !one.input.is_rotary() {
            faults.push(format!("the table of {} repeats, which only rotary axes can", one.input));
        }
        if tables.lookups.iter().take(index).any(|other| other.input == one.input) {
            faults.push(format!("{} has a second table, but an encoder has only one", one.input));
        }
    }
    faults
}

/// The number of the written measuring system.
const MEASURING_SYSTEM: usize = 0;

fn write(tables: &Tables, wiring: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::from("%_N_AX_EEC_INI\n");
    for note in notes {
        let _ = writeln!(text, "; {note}");
    }
    text.push_str("METRIC\nCHANDATA(1)\n");
    for one in &tables.lookups {
        let (m, axis) = (MEASURING_SYSTEM, wiring.name(one.input));
        for (n, value) in one.values.iter().enumerate() {
            let _ = writeln!(text, "$AA_ENC_COMP[{m},{n},{axis}]={}", 0.0 - value);
        }
        let [start, end] = one.nodes.range();
        let step = if let Nodes::Even { step, .. } = one.nodes { step } else { 0.0 };
        for (name, value) in [("STEP", step), ("MIN", start), ("MAX", end), ("IS_MODULO", f64::from(one.modulo))] {
            let _ = writeln!(text, "$AA_ENC_COMP_{name}[{m},{axis}]={value}");
        }
    }
    text.push_str("M17\n");
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    ini::has(bytes, ini::TableVariable::Enc)
}

/// Required fields of a table in use.
const FIELDS: [&str; 4] = ["STEP", "MIN", "MAX", "IS_MODULO"];

/// A table as far as read.
#[derive(Clone, Debug, Default)]
struct Raw {
    /// Millimeters of its unit of length.
    unit_mm: f64,
    values: BTreeMap<usize, f64>,
    /// Its fields, without the prefix `$AA_ENC_COMP_`.
    fields: BTreeMap<String, f64>,
    /// Span of its beginning.
    span: Option<Span>,
}

impl Raw {
    /// A field; 0 if not written.
    fn field(&self, name: &str) -> f64 {
        self.fields.get(name).copied().unwrap_or(0.0)
    }
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut reader = Reader { report: Report::new(source), raw: BTreeMap::new() };
    let mut place = IniPosition::new("EEC", "ENC_COMP");
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
    place.end(&mut reader.report);
    reader.finish(wiring, tables)
}

struct Reader<'a> {
    report: Report<'a>,
    /// By the name of the axis and the number of the measuring system.
    raw: BTreeMap<(String, usize), Raw>,
}

impl Reader<'_> {
    fn assignment(&mut self, line: &ScannedLine<'_>, unit_mm: f64, one: &IniAssignment<'_>) {
        let Some(field) = one.name.strip_prefix("$AA_ENC_COMP") else {
            // Sag tables belong to another format, with its own reader.
            let is_known = ["$AN_CEC", "$SN_CEC", "$MN_MM_CEC"].iter().any(|head| one.name.starts_with(head));
            if !one.name.contains("ENC_COMP") && !is_known {
                let message = format!("{} is not part of the leadscrew compensation and is ignored", shown(&one.name));
                self.report.unused(line, one.text, message, "check that no part of the tables is missing");
            }
            return;
        };
        let (Some(m), Some(axis)) = (one.index(0, 2), one.indices.last().filter(|_| one.indices.len() > 1)) else {
            let help = "write $AA_ENC_COMP[measuring system 0 or 1,point,axis]=value";
            self.report.fault(line, one.text, format!("'{}' names no table", shown(one.text)), help);
            return;
        };
        let Some(number) = self.report.number(line, one.value) else { return };
        let n = one.index(1, MOST_POINTS).filter(|_| one.indices.len() == 3);
        let key = (axis.to_ascii_uppercase(), m);
        if self.raw.len() >= MOST_TABLES && !self.raw.contains_key(&key) {
            let help = "a control has no more than 31 axes";
            self.report.fault(line, one.text, format!("more than {MOST_TABLES} tables"), help);
            return;
        }
        let raw = self.raw.entry(key).or_insert_with(|| Raw { unit_mm, ..Raw::default() });
        raw.span.get_or_insert(line.span(one.text));
        match (field, n) {
            ("", Some(n)) => {
                if raw.values.insert(n, number).is_some_and(|before| before != number) {
                    let message = format!("point {n} of {} is given twice, with different values", shown(axis));
                    self.report.fault(line, one.text, message, super::TWICE);
                }
            }
            ("", None) => {
                let help = format!("write $AA_ENC_COMP[0,point,axis]=value, with a point below {MOST_POINTS}");
                self.report.fault(line, one.text, format!("'{}' has no number of a point", shown(one.text)), &help);
            }
            (field, _) if field.strip_prefix('_').is_some_and(|field| FIELDS.contains(&field)) => {
                let name = field.trim_start_matches('_').to_owned();
                let is_switch = name != "IS_MODULO" || [0.0, 1.0].contains(&number);
                let before = raw.fields.insert(name, number);
                if !is_switch {
                    let help = "write 0 or 1: it is not known how the control reads another number";
                    self.report.fault(line, one.value, format!("{} is {number}", one.name), help);
                } else if before.is_some_and(|before| before != number) {
                    let message = format!("{} of {} is given twice, with different values", one.name, shown(axis));
                    self.report.fault(line, one.text, message, super::TWICE);
                }
            }
            _ => {
                let message = format!("{} is not known and is ignored", shown(&one.name));
                self.report.unused(line, one.text, message, "look up its effect before the table is used");
            }
        }
    }

    fn finish(mut self, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
        let raw = std::mem::take(&mut self.raw);
        if raw.is_empty() {
            self.report
                .empty("the file has no leadscrew table", "a table has lines such as $AA_ENC_COMP[0,0,AX1]=0.005");
        }
        // In the order of the file, which is that of the written tables.
        let mut raw: Vec<_> = raw.into_iter().collect();
        raw.sort_by_key(|(_, one)| one.span);
        for ((name, m), one) in &raw {
            let span = one.span.unwrap_or_default();
            let [step, min, max] = ["STEP", "MIN", "MAX"].map(|name| one.field(name));
            if one.fields.get("STEP") == Some(&0.0) {
                let message = format!("the table of {} is not in use: STEP 0", shown(name));
                self.report.unused_at(span, message, "if it is to be used, give it a step above 0 and MAX above MIN");
                continue;
            }
            if let Some(names) = missing("$AA_ENC_COMP_", &FIELDS, &one.fields) {
                self.report.fault_at(span, format!("the table of {} has no {names}", shown(name)), KEEPS_FIELDS);
                continue;
            }
            if step < 0.0 || max <= min {
                let message = format!("the table of {} has STEP {step}, MIN {min}, MAX {max}", shown(name));
                let help = "give it a step above 0 and MAX above MIN, or STEP 0 if it is not used";
                self.report.fault_at(span, message, help);
                continue;
            }
            if let Some(lookup) = self.lookup(wiring, name, *m, one, span) {
                if tables.lookups.iter().any(|other| other.input == lookup.input && other.output == lookup.output) {
                    let message = format!("{} has a second table, for measuring system {m}", shown(name));
                    let help = "only one measuring system of an axis is active: remove the lines of the other, or set its STEP to 0";
                    self.report.fault_at(span, message, help);
                    continue;
                }
                tables.lookups.push(lookup);
            }
        }
        self.report.findings
    }

    fn lookup(&mut self, wiring: &Wiring, name: &str, m: usize, raw: &Raw, span: Span) -> Option<Lookup> {
        let Some(axis) = wiring.axis(name) else {
            let help = "give the machine, or name the axis with --axis-name X=AX1";
            self.report.fault_at(span, format!("no axis has the name {}", shown(name)), help);
            return None;
        };
        let scale = |value: f64| if axis.is_rotary() { value } else { value * raw.unit_mm };
        let [start, step, end] = ["MIN", "STEP", "MAX"].map(|name| scale(raw.field(name)));
        let nodes = Nodes::Even { start, step, end };
        let count = nodes.count();
        if count > MOST_POINTS {
            let message = format!("the table of {} has {count} points", shown(name));
            self.report.fault_at(span, message, "choose a larger $AA_ENC_COMP_STEP");
            return None;
        }
        let missing = (0..count).filter(|n| !raw.values.contains_key(n)).count();
        if missing > 0 {
            let name = shown(name);
            let message = format!("{missing} of the {count} points of {name}, measuring system {m}, have no value");
            self.report.fault_at(span, message, super::KEEPS);
            return None;
        }
        let surplus = raw.values.range(count..).filter(|(_, value)| **value != 0.0).count();
        if surplus > 0 {
            let message = format!("{surplus} values of {} are beyond MAX and are not used", shown(name));
            self.report.unused_at(span, message, "the control ignores them too");
        }
        let value = |n: usize| 0.0 - scale(raw.values.get(&n).copied().unwrap_or(0.0));
        let modulo = raw.field("IS_MODULO") != 0.0;
        if modulo && !axis.is_rotary() {
            let message = format!("the table of {axis} repeats, which is a linear axis");
            self.report.fault_at(span, message, "write $AA_ENC_COMP_IS_MODULO 0: only rotary axes can repeat");
        }
        let values = (0..count).map(value).collect();
        Some(Lookup { modulo, sense: Sense::Both, ..Lookup::added(axis, axis, nodes, values) })
    }
}
