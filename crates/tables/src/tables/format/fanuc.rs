//! Three-dimensional error compensation of FANUC Series 30i as a table of its nodes.
//!
//! The control adds the values of a grid of at most 25 by 25 by 25 nodes to three linear axes, with trilinear interpolation (FANUC Series 30i-MODEL
//! A, Three-dimensional error compensation A-79351E, "Calculation of compensation"; Esmaeili 2021, 2.4.5.2 and eq. 13, 14). The file format of the
//! control is not public: this is a plain table for the loader of the machine builder, preceded by its parameters (first node, interval, number of
//! nodes).

use std::fmt::Write as _;
use std::sync::LazyLock;

use super::limits::{FormatLimits, Holds};
use super::scan::{Report, ScannedLine, cells, lines, shown};
use super::{Format, Written, rounded};
use crate::tables::{Grid, Tables, Wiring};
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Source;

/// Decimals of values and positions: a nanometer.
const DECIMALS: usize = 6;
/// Maximum number of nodes that are read: more than 25 by 25 by 25.
const MOST_NODES: usize = 64 * 64 * 64;
/// Header of the grid parameters.
const GRID_HEAD: &str = "axis start_mm step_mm count";
/// Header of the nodes.
const NODE_HEAD: &str = "node";

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "fanuc",
    title: "FANUC 3-D error compensation",
    sign: "values are added to the commands in mm; unit, magnification and sign are those of the machine builder's loader: try one large value",
    holds: &[Holds::Grid],
    // 25 nodes along each axis (Esmaeili 2021, 4.5.2); the largest value depends on a magnification that the builder sets.
    limits: FormatLimits { tables: 1, points: 25, value_mm: 0.0, resolution_mm: 1e-6, further: "" },
    round,
    faults,
    write,
    read,
    numbers: super::without_numbers,
    beside: &[],
    sum_limit: None,
    has_axis_numbers: false,
    is_mine,
};

fn round(tables: &mut Tables) {
    if let Some(grid) = &mut tables.grid {
        let values = grid.values.iter_mut().flatten();
        for value in values.chain(&mut grid.start).chain(&mut grid.step) {
            *value = rounded(*value, DECIMALS);
        }
    }
}

fn faults(tables: &Tables, _: &Wiring) -> Vec<String> {
    let Some(grid) = &tables.grid else { return Vec::new() };
    let [a, b, c] = grid.axes;
    if grid.axes.iter().any(|axis| axis.is_rotary()) || a == b || b == c || a == c {
        return vec!["the grid needs three different linear axes".to_owned()];
    }
    Vec::new()
}

fn write(tables: &Tables, _: &Wiring, notes: &[String]) -> Vec<Written> {
    let mut text = String::new();
    for note in notes {
        let _ = writeln!(text, "# {note}");
    }
    if let Some(grid) = &tables.grid {
        let _ = writeln!(text, "{}", GRID_HEAD.replace(' ', ","));
        for i in 0..3 {
            let _ = writeln!(text, "{},{},{},{}", grid.axes[i], grid.start[i], grid.step[i], grid.count[i]);
        }
        let at = grid.axes.map(|axis| format!("at_{axis}_mm")).join(",");
        let add = grid.axes.map(|axis| format!("add_{axis}_mm")).join(",");
        let _ = writeln!(text, "{NODE_HEAD},{at},{add}");
        for (index, value) in grid.values.iter().enumerate() {
            let at = grid.position(grid.node(index)).map(|position| rounded(position, DECIMALS).to_string());
            let _ = writeln!(text, "{},{},{}", index + 1, at.join(","), value.map(|value| value.to_string()).join(","));
        }
    }
    vec![Written { suffix: String::new(), text }]
}

fn is_mine(_: &str, bytes: &[u8]) -> bool {
    static MARK: LazyLock<RegexSet> = LazyLock::new(|| patterns(["(?-i)axis,start_mm,step_mm,count"]));
    MARK.is_match(bytes)
}

fn read(source: &Source, wiring: &Wiring, tables: &mut Tables) -> Vec<Diagnostic> {
    let mut reader =
        Reader { report: Report::new(source), wiring, axes: Vec::new(), values: Vec::new(), in_nodes: false };
    for line in lines(source) {
        let text = line.before('#').trim();
        if text.is_empty() || cells(text).eq(cells(GRID_HEAD)) {
            continue;
        }
        if cells(text).next() == Some(NODE_HEAD) {
            reader.in_nodes = true;
        } else if reader.in_nodes {
            reader.node(&line, text);
        } else {
            reader.axis(&line, text);
        }
        if reader.report.is_hopeless() {
            break;
        }
    }
    reader.finish(tables)
}

/// First node, spacing and number of nodes of an axis.
struct Row {
    axis: Axis,
    start: f64,
    step: f64,
    count: usize,
}

struct Reader<'a> {
    report: Report<'a>,
    wiring: &'a Wiring,
    axes: Vec<Row>,
    values: Vec<[f64; 3]>,
    in_nodes: bool,
}

impl Reader<'_> {
    fn axis(&mut self, line: &ScannedLine<'_>, text: &str) {
        let parts: Vec<&str> = cells(text).take(5).collect();
        let [name, start, step, count] = parts[..] else {
            let help = "write a row for each of three axes: X,-100,50,9";
            self.report.fault(line, text, format!("'{}' is not a row of {GRID_HEAD}", shown(text)), help);
            return;
        };
        let axis = self.wiring.axis(name).filter(|axis| !axis.is_rotary());
        let is_new = self.axes.len() < 3 && self.axes.iter().all(|row| Some(row.axis) != axis);
        let (Some(axis), true) = (axis, is_new) else {
            let help = "a grid has three different linear axes";
            self.report.fault(line, name, format!("'{}' is not another linear axis", shown(name)), help);
            return;
        };
        let (Some(start), Some(step)) = (self.report.number(line, start), self.report.number(line, step)) else {
            return;
        };
        match count.parse::<usize>() {
            Ok(count) if (2..=MOST_NODES).contains(&count) && step > 0.0 => {
                self.axes.push(Row { axis, start, step, count })
            }
            _ => {
                let help = "an axis has two nodes or more, a positive distance apart";
                self.report.fault(line, text, format!("'{}' is not a grid", shown(text)), help);
            }
        }
    }

    fn node(&mut self, line: &ScannedLine<'_>, text: &str) {
        let parts: Vec<&str> = cells(text).take(8).collect();
        let [number, at @ .., x, y, z] = &parts[..] else {
            self.report.fault(
                line,
                text,
                format!("'{}' is not a node", shown(text)),
                "write number, positions and values",
            );
            return;
        };
        let index = self.values.len();
        if number.parse::<usize>().ok() != Some(index + 1) {
            let help = "nodes are numbered from 1 without a gap, the first axis fastest";
            self.report.fault(line, number, format!("node {} must come here", index + 1), help);
            return;
        }
        if index >= MOST_NODES {
            self.report.fault(
                line,
                number,
                format!("more than {MOST_NODES} nodes"),
                "the control allows 25 along each axis",
            );
            return;
        }
        self.position(line, index, at);
        if let (Some(x), Some(y), Some(z)) =
            (self.report.number(line, x), self.report.number(line, y), self.report.number(line, z))
        {
            self.values.push([x, y, z]);
        }
    }

    /// Checks that the position of a node is that of the grid.
    fn position(&mut self, line: &ScannedLine<'_>, index: usize, at: &[&str]) {
        let mut rest = index;
        for (place, row) in self.axes.iter().enumerate() {
            let expected = rounded(row.start + row.step * (rest % row.count) as f64, DECIMALS);
            rest /= row.count;
            let Some(text) = at.get(place) else { break };
            let Some(position) = self.report.number(line, text) else { break };
            if (position - expected).abs() > 1e-5 {
                let message = format!("node {} lies at {} {expected}, not {position}", index + 1, row.axis);
                self.report.fault(line, text, message, "the first axis runs fastest");
                break;
            }
        }
    }

    fn finish(mut self, tables: &mut Tables) -> Vec<Diagnostic> {
        let Ok([x, y, z]) = <[Row; 3]>::try_from(self.axes) else {
            self.report
                .empty("the file has no grid", "write a row of axis,start_mm,step_mm,count for each of three axes");
            return self.report.findings;
        };
        let rows = [x, y, z];
        let nodes = rows.iter().try_fold(1_usize, |nodes, row| nodes.checked_mul(row.count));
        if nodes != Some(self.values.len()) {
            let message =
                format!("the file has {} nodes, but the grid has {}", self.values.len(), nodes.unwrap_or(usize::MAX));
            self.report.empty(&message, "write every node");
        } else if tables.grid.is_some() {
            self.report.empty("a grid has already been read", "the control has only one");
        } else if !self.report.has_fault() {
            tables.grid = Some(Grid {
                axes: [rows[0].axis, rows[1].axis, rows[2].axis],
                start: [rows[0].start, rows[1].start, rows[2].start],
                step: [rows[0].step, rows[1].step, rows[2].step],
                count: [rows[0].count, rows[1].count, rows[2].count],
                values: self.values,
            });
        }
        self.report.findings
    }
}
