//! Error functions in the exchange format of Etalon, which controls of Beckhoff and ISG read for the volumetric compensation: a section for each error.
//!
//! `[C0B]` with `VALUE = 2.2e-05` is a location error, `[EXY]` with `Gridpoints = {`, pairs of position and value, and `}` a function of the axis of its
//! last letter. `//` begins a remark. Names, units (mm, rad, degrees) and signs are those of the format `isg`. The variant is "Vendor"; the variant
//! "Kinematic" has other meanings. (Beckhoff Information System, TF5280, "Etalon Exchange Format".)

use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::scan::{MOST_POINTS, Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, isg};
use crate::tables::{AxisErrors, ErrorTables, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Source;
use ncfix_model::ErrorName;
use ncfix_model::name::{DIRECTIONS, ErrorKind};

/// Maximum number of sections: six errors and six location errors of six axes.
const MOST_SECTIONS: usize = 200;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "etalon",
    title: "Etalon exchange format, variant Vendor",
    sign: "values are errors of the moving body as in ISO 230-1, mm and rad; the control's list can turn their sign (negate): try one large value",
    holds: &[Holds::Errors, Holds::Locations],
    // As for isg, whose control reads both.
    limits: FormatLimits { tables: 6, points: 0, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
    round: isg::round,
    faults: isg::faults,
    write,
    read,
    numbers: super::without_numbers,
    beside: &[],
    sum_limit: None,
    has_axis_numbers: false,
    is_mine,
};

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "// {note}");
    }
    let Some(errors) = &tables.errors else { return vec![Written { suffix: String::new(), text }] };
    for (name, value) in &errors.location {
        let _ = writeln!(text, "[{}]\nVALUE = {value}", isg::short_name(*name));
    }
    for one in &errors.axes {
        for direction in DIRECTIONS {
            let name = ErrorName::motion(direction, one.axis);
            let _ = writeln!(text, "[{name}]\nGridpoints = {{");
            for (position, row) in one.positions.iter().zip(&one.values) {
                let _ = writeln!(text, "{position} {}", row[direction.index()]);
            }
            let _ = writeln!(text, "}}");
        }
    }
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> =
        LazyLock::new(|| patterns([r"(?m)^\s*\[(E[XYZABC][XYZABC]|[XYZABC]0[XYZABC])\]"]));
    MARK.is_match(bytes)
}

/// Value or points of a section.
enum SectionContent {
    /// Nothing yet.
    Empty,
    Value(f64),
    /// Pairs of position and value; `true` until the closing brace.
    Points(Vec<[f64; 2]>, bool),
}

/// A section.
struct EtalonSection<'a> {
    name: ErrorName,
    line: ScannedLine<'a>,
    content: SectionContent,
}

fn read(source: &Source, _: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut report = Report::new(source);
    let mut sections: Vec<EtalonSection<'_>> = Vec::new();
    for line in lines(source) {
        if report.is_hopeless() {
            break;
        }
        let text = line.text.split("//").next().unwrap_or_default().trim();
        if text.is_empty() {
            continue;
        }
        if let Some(name) = text.strip_prefix('[') {
            let Some(section) = section(&line, name.trim_end_matches(']').trim(), &sections, &mut report) else {
                break;
            };
            sections.push(section);
        } else if let Some(section) = sections.last_mut() {
            statement(&line, text, section, &mut report);
        } else {
            report.fault(&line, text, "a value before the first section", "begin with the name of an error: [EXX]");
            break;
        }
    }
    if sections.is_empty() && !report.has_fault() {
        report.empty("the file has no error", "a section begins with the name of an error in brackets: [EXX]");
    }
    let mut errors = tables.errors.clone().unwrap_or_default();
    take(&sections, &mut errors, &mut report);
    if !report.has_fault() {
        tables.errors = Some(errors);
    }
    report.findings
}

fn section<'a>(
    line: &ScannedLine<'a>,
    name: &str,
    sections: &[EtalonSection<'_>],
    report: &mut Report<'_>,
) -> Option<EtalonSection<'a>> {
    let Some(error) = isg::error_of(&name.to_ascii_uppercase()) else {
        let help = "the variant Vendor has names of ISO 230-1: [EXX], [C0Y]";
        report.fault(line, line.text, format!("'{}' is not the name of an error", shown(name)), help);
        return None;
    };
    if sections.iter().any(|one| one.name == error) || sections.len() >= MOST_SECTIONS {
        report.fault(line, line.text, format!("{error} is given twice"), "write each error once");
        return None;
    }
    Some(EtalonSection { name: error, line: *line, content: SectionContent::Empty })
}

/// A line of a section.
fn statement(line: &ScannedLine<'_>, text: &str, section: &mut EtalonSection<'_>, report: &mut Report<'_>) {
    let is_open = matches!(section.content, SectionContent::Points(_, true));
    if let (true, SectionContent::Points(points, open)) = (is_open, &mut section.content) {
        let row = text.trim_end_matches('}').trim();
        let pair: Vec<f64> = cells(row).take(3).filter_map(|cell| report.number(line, cell)).collect();
        match pair[..] {
            [position, value] if points.len() < MOST_POINTS => points.push([position, value]),
            [] if row.is_empty() => {}
            _ => {
                let help = "write a position and a value on each line between the braces, with decimal points";
                report.fault(line, text, format!("'{}' is not a pair of position and value", shown(text)), help);
            }
        }
        *open = !text.ends_with('}');
        return;
    }
    let (key, value) = text.split_once('=').unwrap_or((text, ""));
    let is_key = |name: &str| key.trim().eq_ignore_ascii_case(name);
    if !matches!(section.content, SectionContent::Empty) {
        report.fault(line, text, format!("{} has a second value", section.name), "write VALUE or Gridpoints once");
    } else if is_key("VALUE") {
        section.content = report.number(line, value).map_or(SectionContent::Empty, SectionContent::Value);
    } else if is_key("Gridpoints") && value.trim() == "{" {
        section.content = SectionContent::Points(Vec::new(), true);
    } else {
        let message = format!("'{}' is not known here", shown(text));
        report.fault(line, text, message, "write VALUE = number, or Gridpoints = { and lines of position and value");
    }
}

/// Adds the errors of all sections. The errors of an axis get the points of all of them: between points they are linear, so this changes nothing.
fn take(sections: &[EtalonSection<'_>], errors: &mut ErrorTables, report: &mut Report<'_>) {
    let mut functions: Vec<(ErrorName, Axis, &[[f64; 2]])> = Vec::new();
    for section in sections {
        let EtalonSection { name, line, content } = section;
        let mut fault = |message: String, help: &str| report.fault(line, line.text, message, help);
        match (content, name.kind, name.axis()) {
            (SectionContent::Value(value), ErrorKind::Location, _) => {
                if errors.location.iter().any(|(other, _)| other == name) {
                    fault(format!("{name} is given twice"), "write each error once");
                } else {
                    errors.location.push((*name, *value));
                }
            }
            (SectionContent::Points(points, false), ErrorKind::Motion, Some(axis)) if !points.is_empty() => {
                if points.windows(2).any(|pair| pair[0][0] >= pair[1][0]) {
                    fault(format!("the positions of {name} do not increase"), "sort the points by position");
                } else if errors.axes.iter().any(|one| one.axis == axis) {
                    fault(
                        format!("errors of {axis} are given in another file"),
                        "name the files that are now in the control",
                    );
                } else {
                    functions.push((*name, axis, points));
                }
            }
            (SectionContent::Points(_, true), ..) => {
                fault(format!("the points of {name} have no end"), "close them with a brace: }");
            }
            _ => {
                let help = "a location error such as C0Y has VALUE, an error of an axis such as EXX has Gridpoints";
                fault(format!("{name} has no value that belongs to it"), help);
            }
        }
    }
    if report.has_fault() {
        return;
    }
    let mut axes: Vec<Axis> = Vec::new();
    for (_, axis, _) in &functions {
        if !axes.contains(axis) {
            axes.push(*axis);
        }
    }
    for axis in axes {
        let own: Vec<_> = functions.iter().filter(|(_, other, _)| *other == axis).collect();
        let mut positions: Vec<f64> = own.iter().flat_map(|(.., points)| points.iter().map(|pair| pair[0])).collect();
        positions.sort_by(f64::total_cmp);
        positions.dedup();
        let mut values = vec![[0.0; 6]; positions.len()];
        for (name, _, points) in own {
            for (row, position) in values.iter_mut().zip(&positions) {
                row[name.direction.index()] = between(points, *position);
            }
        }
        errors.axes.push(AxisErrors { axis, positions, values });
    }
}

/// The value at a position: linear between points, constant beyond them.
fn between(points: &[[f64; 2]], position: f64) -> f64 {
    let after = points.partition_point(|pair| pair[0] <= position);
    match (after.checked_sub(1).and_then(|before| points.get(before)), points.get(after)) {
        (Some(before), Some(next)) if before[0] < position => {
            before[1] + (next[1] - before[1]) * (position - before[0]) / (next[0] - before[0])
        }
        (Some(one), _) | (None, Some(one)) => one[1],
        (None, None) => 0.0,
    }
}
