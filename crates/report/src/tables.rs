//! Output of `ncfix tables`: the tables, their residual, pictures and the JSON object.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::Finding;
use super::markup::Markup;
use super::plot::{Chart, Picture, STYLE, Series, Shape, WIDTH};
use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_tables::tables::check::{Check, Errors};
use ncfix_tables::tables::{Lookup, Sense, Tables};

/// Maximum number of tables that are listed individually.
const MOST_ROWS: usize = 80;

/// Output of `ncfix tables`.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesReport {
    /// Name of the machine; empty if none was needed.
    pub machine: String,
    /// Format that was written or read.
    pub format: String,
    /// Scheme that filled the tables; empty for tables that were read.
    pub scheme: String,
    /// Number of tables.
    pub tables: usize,
    /// Number of values.
    pub entries: usize,
    /// Number of grid nodes along X, Y, Z.
    pub grid: Option<[usize; 3]>,
    /// List of the tables.
    pub rows: Vec<Row>,
    /// Residual of the tables.
    pub check: Option<CheckReport>,
    /// Tool vector for which the file says its tables are made, mm from the gauge point, if another one was checked.
    pub made_for_tool_mm: Option<[f64; 3]>,
    /// Difference of two sets of tables, µm or µrad: root mean square and largest for each axis.
    pub difference: Vec<Difference>,
    /// Target of `auto`: below the tolerance, as a margin for poses that were not checked.
    pub aim: Option<String>,
    /// Ranges that were requested in place of the travel.
    pub ranges: Vec<String>,
    /// Schemes that `auto` tried.
    pub tried: Vec<TriedReport>,
    /// Files that were written.
    pub written: Vec<String>,
    /// Diagnostics.
    pub diagnostics: Vec<Finding>,
}

/// A compensation table.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Row {
    /// Number, from 1.
    pub number: usize,
    /// Corrected axis.
    pub output: String,
    /// Axis whose position is looked up.
    pub input: String,
    /// Number of points.
    pub points: usize,
    /// First and last position, mm or deg.
    pub range: [f64; 2],
    /// Largest absolute value, mm or deg.
    pub largest: f64,
    /// Number of the table by which it is multiplied.
    pub times: Option<usize>,
    /// Direction of motion: `both`, `+` or `-`.
    pub sense: &'static str,
    /// True if it repeats.
    pub modulo: bool,
    /// True if the control evaluates it.
    pub enabled: bool,
}

/// Errors over the volume.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CheckReport {
    /// Number of poses.
    pub poses: usize,
    /// Errors without correction.
    pub before: ErrorsReport,
    /// Errors with the tables.
    pub tables: ErrorsReport,
    /// Errors with the exact correction of the kinematics.
    pub exact: ErrorsReport,
    /// Place of the largest residual with the tables.
    pub worst: String,
    /// Tool vector from the gauge point to the tip, mm.
    pub tool_mm: [f64; 3],
    /// Axes whose direction of motion matters: every pose was reached in both directions.
    pub senses: Vec<String>,
    /// Tip errors of all poses without correction and with the tables, µm, for pictures.
    #[serde(skip)]
    pub tips_um: [Vec<f64>; 2],
}

/// Errors of tip and tool axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "mean, root mean square and largest, with their units")]
pub struct ErrorsReport {
    pub mean_um: f64,
    pub rms_um: f64,
    pub max_um: f64,
    pub tilt_rms_urad: f64,
    pub tilt_max_urad: f64,
}

/// Difference of two sets of tables.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct Difference {
    pub axis: String,
    pub unit: &'static str,
    pub rms: f64,
    pub max: f64,
}

/// Scheme that `auto` tried.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[expect(missing_docs, reason = "the names say it")]
pub struct TriedReport {
    pub scheme: String,
    pub points: usize,
    pub tables: Option<usize>,
    pub entries: Option<usize>,
    pub rms_um: Option<f64>,
    pub tilt_rms_urad: Option<f64>,
    pub reason: Option<String>,
}

impl From<&Errors> for ErrorsReport {
    fn from(errors: &Errors) -> Self {
        ErrorsReport {
            mean_um: um_from_mm(errors.mean_mm()),
            rms_um: um_from_mm(errors.rms_mm()),
            max_um: um_from_mm(errors.max_mm()),
            tilt_rms_urad: urad_from_rad(errors.rms_rad()),
            tilt_max_urad: urad_from_rad(errors.max_rad()),
        }
    }
}

/// Rounds a tool vector to one nanometre, mm: without the digits due to the direction of the spindle, and without a minus sign before zero.
#[must_use]
pub fn rounded_mm(tool_mm: &Vector) -> [f64; 3] {
    [0, 1, 2].map(|index| (tool_mm[index] * 1e6).round() / 1e6 + 0.0)
}

impl CheckReport {
    /// Creates the figures of a check; `worst` is the place, the tool runs from the gauge point to the tip.
    #[must_use]
    pub fn new(check: &Check, worst: String, tool_mm: &Vector) -> CheckReport {
        CheckReport {
            poses: check.before.tip_mm.len(),
            before: (&check.before).into(),
            tables: (&check.tables).into(),
            exact: (&check.exact).into(),
            worst,
            tool_mm: rounded_mm(tool_mm),
            senses: check.senses.iter().map(ToString::to_string).collect(),
            tips_um: [&check.before, &check.tables].map(|one| one.tip_mm.iter().map(|mm| um_from_mm(*mm)).collect()),
        }
    }
}

impl TablesReport {
    /// Adds the tables to the report.
    pub fn note(&mut self, tables: &Tables) {
        self.tables = tables.count();
        self.entries = tables.entries();
        self.grid = tables.grid.as_ref().map(|grid| grid.count);
        self.rows = tables.lookups.iter().enumerate().map(|(index, one)| row(index, one)).collect();
    }

    /// Returns the page for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut page = String::new();
        let how = if self.scheme.is_empty() { String::new() } else { format!(", scheme {}", self.scheme) };
        let _ = writeln!(page, "{} tables with {} values ({}{how})", self.tables, self.entries, self.format);
        if let Some([x, y, z]) = self.grid {
            let _ = writeln!(page, "a grid of {x} x {y} x {z} nodes");
        }
        if !self.rows.is_empty() {
            page.push_str("   no  corrects  over  points           range        largest  times\n");
        }
        for row in self.rows.iter().take(MOST_ROWS) {
            let times = row.times.map_or(String::new(), |times| times.to_string());
            let notes = match (row.sense, row.modulo, row.enabled) {
                (_, _, false) => " off",
                ("both", false, _) => "",
                ("both", true, _) => " modulo",
                ("+", ..) => " +",
                _ => " -",
            };
            let [low, high] = row.range;
            let _ = writeln!(
                page,
                "  {:>3}  {:>8}  {:>4}  {:>6}  {low:>7} .. {high:<7}  {:>10.6}  {times:>5}{notes}",
                row.number, row.output, row.input, row.points, row.largest
            );
        }
        if self.rows.len() > MOST_ROWS {
            let _ = writeln!(page, "  and {} more", self.rows.len() - MOST_ROWS);
        }
        if !self.ranges.is_empty() {
            let _ = writeln!(page, "for a part of the travel: {}", self.ranges.join(", "));
        }
        self.tried_page(&mut page);
        if let Some(check) = &self.check {
            let [x, y, z] = check.tool_mm;
            let senses = check.senses.join(" ");
            let senses = if senses.is_empty() { senses } else { format!(", {senses} moving in both senses") };
            let _ = writeln!(page, "left over the volume ({} poses{senses}; tool {x} {y} {z} mm)", check.poses);
            page.push_str("                 tip: mean     rms     max um    tool axis: rms     max urad\n");
            for (name, one) in [("without", check.before), ("with tables", check.tables), ("exact", check.exact)] {
                let _ = writeln!(
                    page,
                    "  {name:<12}  {:>10.3} {:>7.3} {:>7.3}       {:>12.2} {:>7.2}",
                    one.mean_um, one.rms_um, one.max_um, one.tilt_rms_urad, one.tilt_max_urad
                );
            }
            let _ = writeln!(page, "  most with tables at {}", check.worst);
            if check.tables.rms_um > check.before.rms_um {
                page.push_str("  more is left than there was: a constant part, which a zero offset takes, or tables that are not for this machine\n");
            }
            if let Some([x, y, z]) = self.made_for_tool_mm {
                let _ = writeln!(
                    page,
                    "  the file says its tables are for another tool: check them with --tool {x},{y},{z}"
                );
            }
        }
        if !self.difference.is_empty() {
            page.push_str("what the two add differs by\n");
        }
        for one in &self.difference {
            let _ = writeln!(
                page,
                "  {}: rms {:.4} {unit}, largest {:.4} {unit}",
                one.axis,
                one.rms,
                one.max,
                unit = one.unit
            );
        }
        for file in &self.written {
            let _ = writeln!(page, "{file} was written");
        }
        page
    }

    fn tried_page(&self, page: &mut String) {
        if let Some(aim) = &self.aim {
            let _ = writeln!(page, "  auto aims at {aim}: poses that it does not try have a little more");
        }
        for one in &self.tried {
            let _ = match (&one.reason, one.tables, one.rms_um) {
                (Some(reason), ..) => writeln!(page, "  tried {} with {} points: {reason}", one.scheme, one.points),
                (None, Some(tables), Some(rms)) => {
                    let tilt = one.tilt_rms_urad.filter(|tilt| *tilt > 0.0);
                    let tilt = tilt.map_or(String::new(), |tilt| format!(", a tilt of {tilt:.2} urad"));
                    let points = one.points;
                    writeln!(
                        page,
                        "  tried {} with {points} points: {tables} tables leave {rms:.3} um{tilt}",
                        one.scheme
                    )
                }
                _ => Ok(()),
            };
        }
    }
}

fn row(index: usize, one: &Lookup) -> Row {
    Row {
        number: index + 1,
        output: one.output.to_string(),
        input: one.input.to_string(),
        points: one.nodes.count(),
        range: one.nodes.range(),
        largest: one.values.iter().fold(0.0, |most, value| value.abs().max(most)),
        times: one.factor.map(|factor| factor + 1),
        sense: match one.sense {
            Sense::Both => "both",
            Sense::Positive => "+",
            Sense::Negative => "-",
        },
        modulo: one.modulo,
        enabled: one.is_enabled,
    }
}

/// Returns a picture of all tables: the contribution of each over its axis, mm or degrees; error functions in µm and µrad; a grid along lines through its
/// middle.
#[must_use]
pub fn picture(sets: &[(&str, &Tables)]) -> String {
    stacked(&charts(sets))
}

/// Returns the pictures of all tables one by one.
#[must_use]
pub fn charts(sets: &[(&str, &Tables)]) -> Vec<Chart> {
    let mut charts: Vec<Chart> = Vec::new();
    let mut add = |title: String, across: String, up: &str, series: Series| match charts
        .iter_mut()
        .find(|chart| chart.title == title)
    {
        Some(chart) => chart.series.push(series),
        None => charts.push(Chart {
            title,
            across,
            up: up.to_owned(),
            series: vec![series],
            is_balanced: true,
            is_sparing: true,
            ..Chart::default()
        }),
    };
    let line =
        |label: String, points: Vec<(f64, f64)>| Series { label, points, shape: Shape::Line, ..Series::default() };
    let unit = |axis: Axis| if axis.is_rotary() { "deg" } else { "mm" };
    for (label, tables) in sets {
        for (index, one) in tables.lookups.iter().enumerate() {
            let times = one.factor.map_or(String::new(), |factor| format!(" times {}", factor + 1));
            let points = (0..one.nodes.count()).map(|node| one.nodes.position(node)).map(|at| (at, one.value(at)));
            let series = line(format!("{label}{}{times}", index + 1), points.collect());
            let title = format!("{} over {}", one.output, one.input);
            add(title, format!("{} in {}", one.input, unit(one.input)), unit(one.output), series);
        }
        for one in tables.errors.iter().flat_map(|errors| &errors.axes) {
            for (index, letter) in ["X", "Y", "Z", "A", "B", "C"].into_iter().enumerate() {
                let is_rotation = index > 2;
                let points = one
                    .positions
                    .iter()
                    .zip(&one.values)
                    .map(|(&at, row)| (at, row[index] * 1e6 / if is_rotation { 1.0 } else { 1e3 }));
                let (kind, up) = if is_rotation { ("rotations", "µrad") } else { ("translations", "µm") };
                let series = line(format!("{label}E{letter}{}", one.axis), points.collect());
                add(format!("{kind} of {}", one.axis), format!("{} in {}", one.axis, unit(one.axis)), up, series);
            }
        }
        if let Some(grid) = &tables.grid {
            for i in 0..3 {
                for (k, output) in grid.axes.iter().enumerate() {
                    let mut node = grid.count.map(|count| count / 2);
                    let points = (0..grid.count[i]).filter_map(|at| {
                        node[i] = at;
                        grid.values.get(grid.index(node)).map(|value| (grid.position(node)[i], value[k]))
                    });
                    let series = line(format!("{label}{output}"), points.collect());
                    add(format!("grid along {}", grid.axes[i]), format!("{} in mm", grid.axes[i]), "mm", series);
                }
            }
        }
    }
    charts
}

/// Returns pictures one below the other as a file.
fn stacked(charts: &[Chart]) -> String {
    let height: f64 = charts.iter().map(Picture::height).sum::<f64>().max(1.0);
    let mut out = Markup::new();
    out.element(
        "svg",
        &[
            ("xmlns", &"http://www.w3.org/2000/svg"),
            ("viewBox", &format_args!("0 0 {WIDTH} {height:.0}")),
            ("class", &"plot"),
            ("font-family", &"system-ui, sans-serif"),
            ("font-size", &"13"),
        ],
        |out| {
            out.leaf("style", &[], STYLE);
            out.empty(
                "rect",
                &[("class", &"paper"), ("width", &WIDTH), ("height", &format_args!("{height:.0}")), ("fill", &"#fff")],
            );
            let mut top = 0.0;
            for chart in charts {
                out.element("g", &[("transform", &format_args!("translate(0 {top:.0})"))], |out| chart.inside(out));
                top += chart.height();
            }
        },
    );
    out.to_string()
}
