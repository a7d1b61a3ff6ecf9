//! Reads `$AN_CEC` tables. A missing field is an error: the control keeps its previous value.

use std::collections::{BTreeMap, BTreeSet};

use crate::tables::format::ini::{IniAssignment, IniPosition, KEEPS_FIELDS, missing};
use crate::tables::format::scan::{MOST_POINTS, Report, ScannedLine, lines, shown};
use crate::tables::format::{KEEPS, TWICE, marks};
use crate::tables::{Lookup, Multiplication, Nodes, Sense, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::source::{Source, Span};

/// Maximum table number plus one: two for each of 31 axes, and some spare.
const MOST_TABLES: usize = 128;
/// Required fields of a table in use.
const FIELDS: [&str; 6] = ["STEP", "MIN", "MAX", "DIRECTION", "MULT_BY_TABLE", "IS_MODULO"];

/// The numbers of the tables for which a file has points.
pub(super) fn numbers(source: &Source) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut place = IniPosition::new("CEC", "CEC");
    let mut report = Report::new(source);
    for line in lines(source) {
        place.line(&line, &mut report, |_, one| {
            found.extend(one.index(0, MOST_TABLES).filter(|_| one.name == "$AN_CEC"));
        });
    }
    found
}

/// A table as far as read.
#[derive(Clone, Debug, Default)]
struct Raw {
    /// Millimeters of its unit of length.
    unit_mm: f64,
    values: BTreeMap<usize, f64>,
    /// The names of its axes.
    axes: BTreeMap<String, String>,
    /// Its other fields, without the prefixes `$AN_CEC_` or `$SN_CEC_TABLE_`.
    fields: BTreeMap<String, f64>,
    /// `true` if it has more than settings.
    is_own: bool,
    /// Span of its beginning.
    span: Option<Span>,
}

impl Raw {
    /// A field; 0 if not written.
    fn field(&self, name: &str) -> f64 {
        self.fields.get(name).copied().unwrap_or(0.0)
    }

    fn axis(&self, name: &str) -> &str {
        self.axes.get(name).map_or("", String::as_str)
    }

    /// The index of the table by which it is multiplied.
    fn factor(&self) -> Option<usize> {
        (self.field("MULT_BY_TABLE") as usize).checked_sub(1)
    }
}

pub(super) fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut reader = Reader { report: Report::new(source), wiring, raw: BTreeMap::new() };
    let mut place = IniPosition::new("CEC", "CEC");
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
    if marks::multiplication_of(source) == Some(Multiplication::Beside) {
        tables.multiplication = Multiplication::Beside;
    }
    reader.finish(tables)
}

struct Reader<'a> {
    report: Report<'a>,
    wiring: &'a Wiring,
    raw: BTreeMap<usize, Raw>,
}

impl Reader<'_> {
    fn assignment(&mut self, line: &ScannedLine<'_>, unit_mm: f64, one: &IniAssignment<'_>) {
        let name = one.name.as_str();
        let Some(field) = name.strip_prefix("$AN_CEC").or_else(|| name.strip_prefix("$SN_CEC_TABLE")) else {
            // Leadscrew tables belong to another format, with its own reader.
            let is_known = ["$MA_CEC", "$MN_MM_CEC", "$AA_ENC_COMP"].iter().any(|head| name.starts_with(head));
            if !is_known {
                let message = format!("{} is not part of the sag compensation and is ignored", shown(name));
                self.report.unused(line, one.text, message, "check that no part of the tables is missing");
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
        raw.is_own |= name.starts_with("$AN_");
        if raw.unit_mm != unit_mm {
            let help = "write METRIC or INCH once, before the first table";
            self.report.fault(line, one.text, format!("the units of table {t} change in the middle of it"), help);
        }
        match field.strip_prefix('_') {
            None if field.is_empty() => self.point(line, t, one),
            Some(field @ ("INPUT_AXIS" | "OUTPUT_AXIS")) => {
                let before = raw.axes.insert(field.to_owned(), one.value.to_owned());
                if before.is_some_and(|before| before != one.value) {
                    self.twice(line, t, one.name.as_str(), one.text);
                }
            }
            Some("INPUT_NCU" | "OUTPUT_NCU") => {}
            Some(field) => self.parameter(line, t, field, one),
            None => self.unknown(line, one),
        }
    }

    fn unknown(&mut self, line: &ScannedLine<'_>, one: &IniAssignment<'_>) {
        let message = format!("{} is not known and is ignored", shown(&one.name));
        self.report.unused(line, one.text, message, "look up its effect before the table is used");
    }

    fn twice(&mut self, line: &ScannedLine<'_>, t: usize, what: &str, text: &str) {
        self.report.fault(line, text, format!("{} of table {t} is given twice, with different values", what), TWICE);
    }

    /// Reads the value of a point.
    fn point(&mut self, line: &ScannedLine<'_>, t: usize, one: &IniAssignment<'_>) {
        let Some(number) = self.report.number(line, one.value) else { return };
        let Some(n) = one.index(1, MOST_POINTS) else {
            let help = format!("write $AN_CEC[table,point]=value, with a point below {MOST_POINTS}");
            self.report.fault(line, one.text, format!("'{}' has no number of a point", shown(one.text)), &help);
            return;
        };
        let Some(raw) = self.raw.get_mut(&t) else { return };
        if raw.values.insert(n, number).is_some_and(|before| before != number) {
            self.twice(line, t, &format!("point {n}"), one.text);
        }
    }

    /// Reads one of the parameters of a table.
    fn parameter(&mut self, line: &ScannedLine<'_>, t: usize, field: &str, one: &IniAssignment<'_>) {
        let value = one.value;
        let Some(number) = self.report.number(line, value) else { return };
        let is_sense = [-1.0, 0.0, 1.0].contains(&number);
        let is_switch = [0.0, 1.0].contains(&number);
        let fault = match field {
            "STEP" | "MIN" | "MAX" | "WEIGHT" => None,
            "DIRECTION" => (!is_sense).then(|| {
                let help = "write 0 for both directions, 1 for the positive or -1 for the negative one";
                (format!("table {t} has the direction {number}, which is not valid"), help)
            }),
            "MULT_BY_TABLE" => {
                let is_number = number.fract() == 0.0 && (0.0..=MOST_TABLES as f64).contains(&number);
                (!is_number).then(|| {
                    let help = "the number of a table is its index plus 1; 0 means no table";
                    (format!("table {t} is multiplied by number {number}, which no table has"), help)
                })
            }
            "IS_MODULO" | "ENABLE" => (!is_switch).then(|| {
                let help = "write 0 or 1: it is not known how the control reads another number";
                (format!("{} is {number}", one.name), help)
            }),
            "TYPE" => (number != 0.0).then(|| {
                let help = "only tables that depend on one axis are known ($AN_CEC_TYPE 0)";
                (format!("table {t} is of another type, {number}"), help)
            }),
            _ => return self.unknown(line, one),
        };
        let Some(raw) = self.raw.get_mut(&t) else { return };
        if let Some((message, help)) = fault {
            // Reported once: consequences of such a value are not reported, nor the field as missing.
            raw.fields.entry(field.to_owned()).or_insert(if field == "ENABLE" { 1.0 } else { 0.0 });
            self.report.fault(line, value, message, help);
        } else if raw.fields.insert(field.to_owned(), number).is_some_and(|before| before != number) {
            self.twice(line, t, &one.name, one.text);
        }
    }

    /// Adds the complete tables.
    fn finish(mut self, tables: &mut Tables) -> Vec<Diagnostic> {
        let raw = std::mem::take(&mut self.raw);
        if raw.is_empty() {
            self.report.empty("the file has no compensation table", "a table has lines such as $AN_CEC[0,0]=0.005");
        }
        let mut places = BTreeMap::new();
        for (&t, one) in &raw {
            let span = one.span.unwrap_or_default();
            let [step, min, max] = ["STEP", "MIN", "MAX"].map(|name| one.field(name));
            if !one.is_own || one.fields.get("STEP") == Some(&0.0) {
                let message = format!("table {t} is not in use: STEP {step}, MIN {min}, MAX {max}");
                self.report.unused_at(span, message, "if it is to be used, give it a step above 0 and MAX above MIN");
                continue;
            }
            if let Some(names) = missing("$AN_CEC_", &FIELDS, &one.fields) {
                self.report.fault_at(span, format!("table {t} has no {names}"), KEEPS_FIELDS);
                continue;
            }
            if step < 0.0 || max <= min {
                let message = format!("table {t} has STEP {step}, MIN {min}, MAX {max}");
                let help = "give it a step above 0 and MAX above MIN, or STEP 0 if it is not used";
                self.report.fault_at(span, message, help);
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

    /// Sets the factors of the tables.
    fn products(&mut self, raw: &BTreeMap<usize, Raw>, places: &BTreeMap<usize, usize>, tables: &mut Tables) {
        for (t, one) in raw {
            let (Some(&at), Some(other)) = (places.get(t), one.factor()) else { continue };
            let span = one.span.unwrap_or_default();
            if one.unit_mm != 1.0 {
                let message = format!("table {t} is multiplied by another one, in inches");
                let help = "save the tables with the basic system METRIC: it is not known in which unit the control multiplies";
                self.report.fault_at(span, message, help);
            }
            match (places.get(&other), tables.lookups.get_mut(at)) {
                (Some(&factor), Some(lookup)) => lookup.factor = Some(factor),
                _ => {
                    let message = format!("table {t} is multiplied by number {}, which does not exist", other + 1);
                    self.report.fault_at(span, message, "the number of a table is its index plus 1");
                }
            }
        }
    }

    /// The axis for a name in a table.
    fn axis(&mut self, t: usize, what: &str, name: &str, span: Span) -> Option<Axis> {
        let axis = self.wiring.axis(name);
        if axis.is_none() && name.is_empty() {
            let help = "write $AN_CEC_INPUT_AXIS and $AN_CEC_OUTPUT_AXIS";
            self.report.fault_at(span, format!("table {t} has no {what} axis"), help);
        } else if axis.is_none() {
            let help = "give the machine, or name the axis with --axis-name X=AX1";
            self.report.fault_at(span, format!("table {t}: no axis has the name {}", shown(name)), help);
        }
        axis
    }

    fn lookup(&mut self, t: usize, raw: &Raw, span: Span) -> Option<Lookup> {
        let input = self.axis(t, "input", raw.axis("INPUT_AXIS"), span);
        let output = self.axis(t, "output", raw.axis("OUTPUT_AXIS"), span);
        let (input, output) = (input?, output?);
        let scale = |value: f64, axis: Axis| if axis.is_rotary() { value } else { value * raw.unit_mm };
        let [start, step, end] = ["MIN", "STEP", "MAX"].map(|name| scale(raw.field(name), input));
        let nodes = Nodes::Even { start, step, end };
        let count = nodes.count();
        if count > MOST_POINTS {
            self.report.fault_at(span, format!("table {t} has {count} points"), "choose a larger $AN_CEC_STEP");
            return None;
        }
        let modulo = raw.field("IS_MODULO") != 0.0;
        if modulo && !input.is_rotary() {
            let message = format!("table {t} repeats over {input}, which is a linear axis");
            self.report.fault_at(span, message, "write $AN_CEC_IS_MODULO 0: only rotary axes can repeat");
        }
        let surplus = raw.values.range(count..).filter(|(_, value)| **value != 0.0).count();
        if surplus > 0 {
            let message = format!("{surplus} values of table {t} are beyond MAX and are not used");
            self.report.unused_at(span, message, "the control ignores them too");
        }
        let missing = (0..count).filter(|n| !raw.values.contains_key(n)).count();
        if missing > 0 {
            let message = format!("{missing} of the {count} points of table {t} have no value");
            self.report.fault_at(span, message, KEEPS);
            return None;
        }
        let is_enabled = raw.fields.get("ENABLE") != Some(&0.0);
        if !is_enabled {
            let message = format!("table {t} is switched off: $SN_CEC_TABLE_ENABLE[{t}]=0");
            self.report.unused_at(span, message, "write 1 if something else switches it on");
        }
        let value = |n: usize| scale(raw.values.get(&n).copied().unwrap_or(0.0), output);
        let sense = match raw.field("DIRECTION") {
            1.0 => Sense::Positive,
            -1.0 => Sense::Negative,
            _ => Sense::Both,
        };
        let weight = raw.fields.get("WEIGHT").copied().unwrap_or(1.0);
        let values = (0..count).map(value).collect();
        Some(Lookup { sense, modulo, weight, is_enabled, ..Lookup::added(input, output, nodes, values) })
    }
}
