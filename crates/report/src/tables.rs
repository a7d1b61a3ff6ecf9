//! Output of `ncfix tables`: the tables, their residual, pictures and the JSON object.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::DiagnosticReport;
use super::markup::Markup;
use super::number::{counted, significant};
use super::plot::{Chart, Picture, PlotSeries, STYLE, Shape, WIDTH};
use ncfix_base::geometry::Axis;
use ncfix_tables::results::result::TablesResult;
use ncfix_tables::tables::format::Holds;
use ncfix_tables::tables::{FORMATS, SCHEMES, Sense, Tables};

/// Maximum number of tables that are listed individually.
const MOST_ROWS: usize = 80;
/// Tilt that does not count for a single error, µrad: it moves the tip of a tool of 500 mm by 0.05 µm.
const LEAST_TILT_URAD: f64 = 0.1;
/// Maximum number of rows of the residuals with fewer tables, and the width of their longest bar.
const MOST_FEWER: usize = 24;
const FEWER_WIDTH: usize = 40;

/// Output of `ncfix tables`: the result, with its output files.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TablesReport {
    /// Result.
    #[serde(flatten)]
    pub found: TablesResult,
    /// Files that were written.
    pub written: Vec<String>,
    /// Diagnostics.
    pub diagnostics: Vec<DiagnosticReport>,
}

impl TablesReport {
    /// Returns the page for people.
    #[must_use]
    pub fn page(&self) -> String {
        let mut page = String::new();
        let how = if self.found.scheme.is_empty() { String::new() } else { format!(", scheme {}", self.found.scheme) };
        let _ = writeln!(
            page,
            "{} with {} ({}{how})",
            counted(self.found.tables as u64, "table"),
            counted(self.found.entries as u64, "value"),
            self.found.format
        );
        if let Some([x, y, z]) = self.found.grid {
            let _ = writeln!(page, "a grid of {x} x {y} x {z} nodes");
        }
        let has_times = self.found.rows.iter().any(|row| row.times.is_some());
        let is_rotary =
            |wanted: bool| self.found.rows.iter().any(|row| row.output.starts_with(['A', 'B', 'C']) == wanted);
        if !self.found.rows.is_empty() {
            let times = if has_times { "  times" } else { "" };
            let unit = match (is_rotary(true), is_rotary(false)) {
                (true, true) => "mm, °",
                (true, false) => "°",
                _ => "mm",
            };
            let _ = writeln!(
                page,
                "   no  corrects  over  points           range  {:>14}{times}",
                format!("largest {unit}")
            );
        }
        for row in self.found.rows.iter().take(MOST_ROWS) {
            let times = row.times.map_or(String::new(), |times| times.to_string());
            let times = if has_times { format!("  {times:>5}") } else { String::new() };
            let notes = match (row.sense, row.modulo, row.enabled) {
                (_, _, false) => " off",
                (Sense::Both, false, _) => "",
                (Sense::Both, true, _) => " modulo",
                (Sense::Positive, ..) => " +",
                (Sense::Negative, ..) => " -",
            };
            // Steps of whole decimals end a little beside the travel: 699.999984 for 700. Adding 0 turns -0 into 0.
            let [low, high] = row.range.map(|end| (end * 1e4).round() / 1e4 + 0.0);
            let _ = writeln!(
                page,
                "  {:>3}  {:>8}  {:>4}  {:>6}  {low:>7} .. {high:<7}  {:>10.6}{times}{notes}",
                row.number, row.output, row.input, row.points, row.largest
            );
        }
        if self.found.rows.len() > MOST_ROWS {
            let _ = writeln!(page, "  and {} more", self.found.rows.len() - MOST_ROWS);
        }
        if !self.found.ranges.is_empty() {
            let _ = writeln!(page, "for a part of the travel: {}", self.found.ranges.join(", "));
        }
        self.tried_page(&mut page);
        if let Some(check) = &self.found.check {
            let [x, y, z] = check.tool_mm;
            let senses = check.senses.join(" ");
            let senses = if senses.is_empty() { senses } else { format!(", {senses} moving in both directions") };
            let _ = writeln!(page, "residual over the volume ({} poses{senses}; tool {x} {y} {z} mm)", check.poses);
            page.push_str("                 tip: mean     rms     max µm    tool axis: rms     max µrad\n");
            for (name, one) in [("without", check.before), ("with tables", check.tables), ("exact", check.exact)] {
                let _ = writeln!(
                    page,
                    "  {name:<12}  {:>10.3} {:>7.3} {:>7.3}       {:>12.2} {:>7.2}",
                    one.mean_um, one.rms_um, one.max_um, one.tilt_rms_urad, one.tilt_max_urad
                );
            }
            let _ = writeln!(page, "  largest error with tables at {}", check.worst);
            if check.tables.rms_um > check.before.rms_um {
                page.push_str("  the tables increase the error: a constant part, which belongs in a zero offset, or tables that are not for this machine\n");
            }
            if let Some([x, y, z]) = self.found.made_for_tool_mm {
                let _ = writeln!(
                    page,
                    "  the file states that its tables are for another tool: check them with --tool {x},{y},{z}"
                );
            }
        }
        self.limits_page(&mut page);
        self.single_errors_page(&mut page);
        self.reversals_page(&mut page);
        if let Some(count) = self.found.errors_found {
            let _ = writeln!(page, "{} found from the tables", counted(count as u64, "error"));
            page.push_str("  while the control uses these tables, name them in active_tables of the machine file\n");
        }
        if !self.found.difference.is_empty() {
            page.push_str("difference of the two sets of values\n");
        }
        for one in &self.found.difference {
            let _ = writeln!(
                page,
                "  {}: rms {:.4} {unit}, largest {:.4} {unit}",
                one.axis,
                one.rms,
                one.max,
                unit = one.unit.unit()
            );
        }
        for file in &self.written {
            let _ = writeln!(page, "{file} was written");
        }
        page
    }

    /// Adds the kinds of compensation, the largest sums, the parts that are left out, and the residuals with fewer tables.
    fn limits_page(&self, page: &mut String) {
        if !self.found.kinds.is_empty() {
            let _ = writeln!(page, "types of compensation (ISO/TR 16907): {}", self.found.kinds.join(" "));
        }
        if !self.found.sums.is_empty() {
            let unit = |axis: &str| if axis.starts_with(['A', 'B', 'C']) { "°" } else { " mm" };
            let sums = self.found.sums.iter().map(|one| format!("{} {:.4}{}", one.axis, one.largest, unit(&one.axis)));
            let _ =
                writeln!(page, "largest sum of the corrections of an axis: {}", sums.collect::<Vec<_>>().join(", "));
            if !self.found.rows.is_empty() {
                page.push_str("  the limit of the control must not be smaller (840D: MD32720, 1 mm as delivered)\n");
            }
        }
        for one in &self.found.left_out {
            let _ = writeln!(
                page,
                "not in these tables: {} also depends on {}; they have its mean over {}, from which it is up to {} {} away",
                one.error,
                one.second,
                one.second,
                significant(one.largest),
                one.unit.unit().sign()
            );
        }
        if let Some(all) = self.found.chosen_of {
            let _ = writeln!(page, "the best set of the {} of the scheme", counted(all as u64, "table"));
        }
        if self.found.fewer.len() > 1 {
            let what = if self.found.grid.is_some() { "nodes along each axis" } else { "tables (best set of each)" };
            let _ = writeln!(page, "residual over the number of {what}, rms µm");
            let most = self.found.fewer.iter().map(|one| one.rms_um).fold(f64::MIN_POSITIVE, f64::max);
            let every = self.found.fewer.len().div_ceil(MOST_FEWER);
            for one in self.found.fewer.iter().step_by(every) {
                let bar = "█".repeat((one.rms_um / most * FEWER_WIDTH as f64).round() as usize);
                let line = format!("  {:>4} {:>9.3}  {bar}", one.count, one.rms_um);
                let _ = writeln!(page, "{}", line.trim_end());
            }
        }
    }

    /// Adds the number of tables that each single error needs.
    fn single_errors_page(&self, page: &mut String) {
        if self.found.single_errors.is_empty() {
            return;
        }
        page.push_str("tables for a machine with one error\n");
        for one in &self.found.single_errors {
            let tilt = one.tilt_rms_urad.filter(|tilt| *tilt > LEAST_TILT_URAD);
            let tilt = tilt.map_or(String::new(), |tilt| format!(", a tilt of {} µrad", significant(tilt)));
            let _ = match (one.tables, one.before_rms_um, one.rms_um) {
                (Some(tables), Some(before), Some(left)) => writeln!(
                    page,
                    "  {:<6} {:>12}  {tables:>3} by {}, rms {} → {} µm{tilt}",
                    one.error,
                    one.size,
                    one.scheme,
                    significant(before),
                    significant(left)
                ),
                _ => writeln!(page, "  {:<6} {:>12}  {}", one.error, one.size, one.reason.as_deref().unwrap_or("–")),
            };
        }
    }

    fn reversals_page(&self, page: &mut String) {
        for one in &self.found.reversals {
            let unit = if one.axis.starts_with(['A', 'B', 'C']) { "deg" } else { "mm" };
            let spread =
                if one.spread < 5e-5 { String::new() } else { format!(", ± {:.4} along the axis", one.spread) };
            let _ =
                writeln!(page, "reversal value of {}: {:.5} {unit}{spread}, not in these tables", one.axis, one.value);
            for setting in one.settings() {
                let _ = writeln!(page, "  {setting}");
            }
        }
    }

    fn tried_page(&self, page: &mut String) {
        if let Some(aim) = &self.found.aim {
            let _ = writeln!(page, "  auto aims at {aim}: poses that it does not test have slightly more");
        }
        for one in &self.found.tried {
            let _ = match (&one.reason, one.tables, one.rms_um) {
                (Some(reason), ..) => writeln!(page, "  tried {} with {} points: {reason}", one.scheme, one.points),
                (None, Some(tables), Some(rms)) => {
                    let tilt = one.tilt_rms_urad.filter(|tilt| *tilt > 0.0);
                    let tilt = tilt.map_or(String::new(), |tilt| format!(", a tilt of {tilt:.2} µrad"));
                    let points = one.points;
                    writeln!(
                        page,
                        "  tried {} with {points} points: {}, residual {rms:.3} µm{tilt}",
                        one.scheme,
                        counted(tables as u64, "table")
                    )
                }
                _ => Ok(()),
            };
        }
    }
}

/// Lists formats and schemes, one per line.
#[must_use]
pub fn list() -> String {
    let mut text = String::from("formats\n");
    let limit = |value: usize| if value == 0 { "-".to_owned() } else { value.to_string() };
    for one in FORMATS {
        let holds: Vec<&str> = one.holds.iter().map(|what| kind_name(*what)).collect();
        let _ = writeln!(
            text,
            "  {:<11} {}: {}; {}tables {}, points {}, largest value {}",
            one.name,
            one.title,
            holds.join(", "),
            if one.limits.further.is_empty() { String::new() } else { format!("{}; ", one.limits.further) },
            limit(one.limits.tables),
            limit(one.limits.points),
            if one.limits.value_mm > 0.0 { format!("{} mm", one.limits.value_mm) } else { "-".to_owned() }
        );
    }
    text.push_str("schemes\n");
    for one in SCHEMES {
        let _ = writeln!(text, "  {:<14} {}", one.name, one.title);
    }
    let _ = writeln!(text, "  {:<14} the fewest tables that reach the tolerance on this control", "auto");
    text
}

/// Returns the name of a kind of table for people.
fn kind_name(kind: Holds) -> &'static str {
    match kind {
        Holds::Own => "own axis",
        Holds::Cross => "other axis",
        Holds::Products => "products",
        Holds::Senses => "own axis by direction",
        Holds::CrossSenses => "other axis by direction",
        Holds::Repetition => "periodic",
        Holds::Grid => "grid",
        Holds::Errors => "error functions",
        Holds::Locations => "location errors",
        Holds::Matrix => "matrix",
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
    let mut add = |title: String, across: String, up: &str, series: PlotSeries| match charts
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
    let line = |label: String, points: Vec<(f64, f64)>| PlotSeries {
        label,
        points,
        shape: Shape::Line,
        ..PlotSeries::default()
    };
    let unit = |axis: Axis| if axis.is_rotary() { "deg" } else { "mm" };
    for (label, tables) in sets {
        for (index, one) in tables.lookups.iter().enumerate() {
            let times = one.factor.map_or(String::new(), |factor| format!(" × {}", factor + 1));
            let points = (0..one.nodes.count()).map(|node| one.nodes.position(node)).map(|at| (at, one.value(at)));
            let series = line(format!("{label}table {}{times}", index + 1), points.collect());
            let title = format!("{} over {}", one.output, one.input);
            add(
                title,
                format!("{} in {}", one.input, unit(one.input)),
                &format!("added to {}, {}", one.output, unit(one.output)),
                series,
            );
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
                let up = format!("error, {up}");
                add(format!("{kind} of {}", one.axis), format!("{} in {}", one.axis, unit(one.axis)), &up, series);
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
                    let series = line(format!("{label}added to {output}"), points.collect());
                    add(format!("Grid along {}", grid.axes[i]), format!("{} in mm", grid.axes[i]), "added, mm", series);
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
            ("font-size", &"16"),
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
