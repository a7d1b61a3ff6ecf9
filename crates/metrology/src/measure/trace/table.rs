//! The table of a trace: NAME.csv.

use std::collections::HashMap;

use ncfix_base::csv::{DecimalSign, Row, Table};
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::Source;
use ncfix_base::units::mm_from_um;
use ncfix_machine::machine::Machine;

use super::xml::TraceSignals;
use super::{ControlSamples, Described, Trace, TraceRun};

const READINGS: [&str; 3] = ["dx_um", "dy_um", "dz_um"];
const TOOL: [&str; 3] = ["tool_x_mm", "tool_y_mm", "tool_z_mm"];
/// Tolerance within which a position counts as on its limit: a servo loop overshoots, mm or rad.
const BEYOND: f64 = 0.1;
/// Largest plausible deviation, mm; a larger one has another unit.
const MOST_MM: f64 = 20.0;
/// Maximum number of diagnostics of one table.
const MOST_FINDINGS: usize = 50;
/// Minimum number of samples of a run.
const LEAST: usize = 16;

/// The columns of a table.
#[derive(Debug)]
struct Columns {
    sign: DecimalSign,
    time: usize,
    /// Axis, its set-point and its encoder.
    axes: Vec<(Axis, [usize; 2])>,
    readings: [Option<usize>; 3],
    tool: [Option<usize>; 3],
    run: Option<usize>,
    feed: Option<usize>,
    block: Option<usize>,
}

/// Reads a trace: its table, and optionally the recording of a control in a separate file. All diagnostics are reported in one run.
#[must_use]
pub fn read(
    described: &Described,
    table: &Source,
    control: Option<&TraceSignals>,
    machine: &Machine,
) -> (Option<Trace>, Vec<Diagnostic>) {
    let (rows, mut findings) = Table::read(table);
    let Some(rows) = rows else { return (None, findings) };
    let mut trace = described.trace.clone();
    if let Some(columns) = columns(&rows, machine, control.is_some(), described, &mut findings) {
        read_rows(&rows, &columns, machine, described, &mut trace, &mut findings);
        if let (Some(signals), true) = (control, findings.is_empty()) {
            join(&rows, signals, machine, &mut trace, &mut findings);
        }
        if findings.is_empty() {
            check(&rows, &trace, &mut findings);
        }
    }
    let sound = !findings.iter().any(Diagnostic::is_error);
    (sound.then_some(trace), findings)
}

fn columns(
    rows: &Table,
    machine: &Machine,
    has_control: bool,
    described: &Described,
    findings: &mut Vec<Diagnostic>,
) -> Option<Columns> {
    let before = findings.len();
    let mut missing = |name: &str, help: String| {
        let message = format!("there is no column {name}");
        findings.push(Diagnostic::at(Code::DATA_COLUMN, rows.header_place(None), message, help));
    };
    let time = rows.column("t_s");
    if time.is_none() {
        missing("t_s", "a trace needs the time of every row, s".into());
    }
    let mut axes = Vec::new();
    if !has_control {
        for axis in machine.axes.iter().flatten().map(|data| data.axis) {
            let names = [axis.to_string(), format!("{axis}_enc")];
            let found = [0, 1].map(|k| rows.column(&names[k]));
            if let [Some(set), Some(encoder)] = found {
                axes.push((axis, [set, encoder]));
            }
            for (name, _) in names.iter().zip(found).filter(|(_, column)| column.is_none()) {
                let what = if name.ends_with("_enc") { "the encoder position" } else { "the set-point" };
                missing(name, format!("a trace needs {what} of every axis of the machine, mm or deg"));
            }
        }
    }
    let names = described.sensors.as_ref().map_or(READINGS, |sensors| sensors.columns.each_ref().map(String::as_str));
    let readings = names.map(|name| rows.column(name));
    if described.sensors.is_some() {
        for (name, _) in names.iter().zip(readings).filter(|(_, column)| column.is_none()) {
            missing(name, "columns in [sensors] of the description names the columns of the three sensors".into());
        }
    } else if has_control && readings.iter().all(Option::is_none) {
        missing("dx_um", "name the columns of the readings dx_um, dy_um, dz_um".into());
    }
    if described.sensors.is_none() && readings.iter().any(Option::is_some) && readings.iter().any(Option::is_none) {
        let name = READINGS.iter().zip(readings).find(|(_, column)| column.is_none()).map_or("dx_um", |(name, _)| name);
        missing(
            name,
            "parts of an error are determined along three directions; give all of dx_um, dy_um, dz_um".into(),
        );
    }
    let tool = TOOL.map(|name| rows.column(name));
    let [run, feed, block] = ["run", "feed_mm_min", "block"].map(|name| rows.column(name));
    let numbers: Vec<usize> = time
        .into_iter()
        .chain(axes.iter().flat_map(|(_, pair)| *pair))
        .chain(readings.into_iter().chain(tool).flatten())
        .chain(feed)
        .collect();
    let sign = rows.decimal_sign(&numbers).unwrap_or_else(|finding| {
        findings.push(finding);
        DecimalSign::Point
    });
    (findings.len() == before).then_some(Columns { sign, time: time?, axes, readings, tool, run, feed, block })
}

fn read_rows(
    rows: &Table,
    columns: &Columns,
    machine: &Machine,
    described: &Described,
    trace: &mut Trace,
    findings: &mut Vec<Diagnostic>,
) {
    let mut numbers: HashMap<Vec<u8>, usize> = HashMap::new();
    let mut blocks: Vec<Option<Vec<u8>>> = Vec::new();
    for row in rows.rows() {
        if findings.len() >= MOST_FINDINGS {
            return;
        }
        let label = columns.run.map_or(&[][..], |column| row.text(column));
        let number = match numbers.get(label) {
            Some(&number) => number,
            None => {
                let label_text = String::from_utf8_lossy(label).trim().to_owned();
                trace.runs.push(TraceRun {
                    label: label_text,
                    feed_mm_min: described.feed_mm_min,
                    place: Some(row.place(0)),
                    ..TraceRun::default()
                });
                numbers.insert(label.to_vec(), trace.runs.len() - 1);
                blocks.push(None);
                trace.runs.len() - 1
            }
        };
        if let Some(run) = trace.runs.get_mut(number)
            && let Err(found) = read_row(&row, columns, described, machine, run)
        {
            findings.push(found);
        }
        if let (Some(run), Some(block)) = (trace.runs.get_mut(number), blocks.get_mut(number)) {
            note_block(&row, columns, block, run);
        }
    }
}

/// Notes the time of a block that differs from the one of the row before.
fn note_block(row: &Row<'_>, columns: &Columns, known: &mut Option<Vec<u8>>, run: &mut TraceRun) {
    let Some(text) = columns.block.map(|column| row.text(column)).filter(|text| !text.is_empty()) else { return };
    if known.as_deref() == Some(text) {
        return;
    }
    if known.is_some() {
        run.transitions_s.extend(run.control.t_s.last());
    }
    *known = Some(text.to_vec());
}

fn read_row(
    row: &Row<'_>,
    columns: &Columns,
    described: &Described,
    machine: &Machine,
    run: &mut TraceRun,
) -> Result<(), Diagnostic> {
    let number = |column: usize| row.number(column, columns.sign);
    let is_empty = |column: usize| row.text(column).is_empty();
    let t_s = number(columns.time)?;
    if let Some(column) = columns.feed.filter(|&column| !is_empty(column)) {
        let feed = number(column)?;
        let is_another = run.feed_mm_min.is_some_and(|known| known != feed);
        if feed <= 0.0 || is_another && !run.control.t_s.is_empty() {
            let known = run.feed_mm_min.unwrap_or(0.0);
            let message = format!("the feed is {feed} mm/min in a run with {known} mm/min");
            let help = "a run is one pass at one programmed feed: give each pass its own label in the column run";
            return Err(Diagnostic::at(Code::DATA_CELL, row.place(column), message, help));
        }
        run.feed_mm_min = Some(feed);
    }
    for (value, column) in run.tool_mm.iter_mut().zip(columns.tool) {
        if let Some(column) = column.filter(|&column| !is_empty(column)) {
            *value = number(column)?;
        }
    }
    let later = |known: Option<&f64>| match known {
        Some(&last) if t_s <= last => {
            let message = format!("the time {t_s} s does not come after {last} s");
            let help = "the rows of a run must be in the order of time; give each pass a label in the column run";
            Err(Diagnostic::at(Code::DATA_CELL, row.place(columns.time), message, help))
        }
        _ => Ok(()),
    };
    let cells = || columns.axes.iter().flat_map(|(_, pair)| *pair);
    if cells().any(|column| !is_empty(column)) {
        later(run.control.t_s.last())?;
        let mut both = [AxisVector::ZERO; 2];
        for &(axis, pair) in &columns.axes {
            for (whole, column) in both.iter_mut().zip(pair) {
                let value = number(column)?;
                whole[axis] = if axis.is_rotary() { value.to_radians() } else { value };
                within(machine, axis, whole[axis], row, column)?;
            }
        }
        let [set, encoder] = both;
        run.control.t_s.push(t_s);
        run.control.set.push(set);
        run.control.encoder.push(encoder);
    }
    let [Some(x), Some(y), Some(z)] = columns.readings else { return Ok(()) };
    if [x, y, z].iter().any(|&column| !is_empty(column)) {
        later(run.readings.t_s.last())?;
        let mut along = [0.0; 3];
        for (value, column) in along.iter_mut().zip([x, y, z]) {
            *value = number(column)?;
        }
        match &described.sensors {
            Some(sensors) => {
                if let Some((message, help)) = sensors.beyond_text(&along) {
                    return Err(Diagnostic::at(Code::DATA_SIZE, row.place(x), message, help));
                }
                along = sensors.displacement_mm(&along).into();
            }
            None => along = along.map(mm_from_um),
        }
        for (value, column) in along.iter().zip([x, y, z]) {
            if value.abs() > MOST_MM {
                let message = "a deviation of centimeters".to_owned();
                let help = "dx_um, dy_um, dz_um are the position of the tool relative to the ball in micrometers";
                return Err(Diagnostic::at(Code::DATA_SIZE, row.place(column), message, help));
            }
        }
        run.readings.t_s.push(t_s);
        run.readings.along.push(along);
        run.readings.places.push(row.place(columns.time));
    }
    Ok(())
}

fn within(machine: &Machine, axis: Axis, at: f64, row: &Row<'_>, column: usize) -> Result<(), Diagnostic> {
    let Some([low, high]) = machine.axis(axis).and_then(|data| data.travel) else { return Ok(()) };
    if (low - BEYOND..=high + BEYOND).contains(&at) {
        return Ok(());
    }
    let unit = if axis.is_rotary() { "deg" } else { "mm" };
    let show = |value: f64| ncfix_base::units::shown_position(axis.is_rotary(), value);
    let message = format!("{axis} {} {unit} is outside the travel of {} … {} {unit}", show(at), show(low), show(high));
    let help = format!("check the unit of the column, --machine, and axis.{axis}.travel_{unit} in the machine file");
    Err(Diagnostic::at(Code::OUT_OF_TRAVEL, row.place(column), message, help))
}

/// Combines the signals of a control with the readings of an instrument.
fn join(rows: &Table, signals: &TraceSignals, machine: &Machine, trace: &mut Trace, findings: &mut Vec<Diagnostic>) {
    match trace.runs.as_mut_slice() {
        [run] => {
            run.control = signals.control.clone();
            findings.extend(outside(rows, machine, &run.control));
        }
        _ => {
            let help = "the file of a control is one run: give each run its own table";
            let place = rows.header_place(rows.column("run"));
            findings.push(Diagnostic::at(
                Code::DATA_COLUMN,
                place,
                "a table of several runs with one file of a control",
                help,
            ));
        }
    }
}

/// The first position of a control outside the travel.
fn outside(rows: &Table, machine: &Machine, control: &ControlSamples) -> Option<Diagnostic> {
    let far = |at: &AxisVector, axis: Axis| {
        let [low, high] = machine.axis(axis).and_then(|data| data.travel)?;
        (!(low - BEYOND..=high + BEYOND).contains(&at[axis])).then_some(axis)
    };
    let axes: Vec<Axis> = machine.axes.iter().flatten().map(|data| data.axis).collect();
    let mut all = control.set.iter().chain(&control.encoder);
    let axis = all.find_map(|at| axes.iter().find_map(|&axis| far(at, axis)))?;
    let message = format!("the recorded positions of {axis} are outside its travel");
    let help = format!("check the signal of {axis}, its unit (mm, degrees), and --machine");
    Some(Diagnostic::at(Code::OUT_OF_TRAVEL, rows.header_place(None), message, help))
}

/// Checks that need the whole table.
fn check(rows: &Table, trace: &Trace, findings: &mut Vec<Diagnostic>) {
    if trace.runs.is_empty() {
        let help = "write at least one run";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, rows.header_place(None), "the table has no rows", help));
    }
    for run in &trace.runs {
        let place = run.place.unwrap_or_else(|| rows.header_place(None));
        for (what, times) in [("control", &run.control.t_s), ("instrument", &run.readings.t_s)] {
            if let Some((from_s, gap_s)) = gap(times) {
                let message = format!("the record of the {what} has a gap of {gap_s:.3} s after t_s {from_s}");
                let help = "a run is one record without a gap: give each part its own label in the column run";
                findings.push(Diagnostic::at(Code::DATA_CELL, place, message, help));
            }
        }
        let name = if run.label.is_empty() { "the run".to_owned() } else { format!("the run {}", run.label) };
        let samples = run.control.t_s.len();
        if samples < LEAST {
            let message = format!("{name} has {samples} samples of the control");
            let help = format!("a run needs at least {LEAST} rows with set-points and encoders");
            findings.push(Diagnostic::at(Code::DATA_COLUMN, place, message, help));
        }
        if trace.runs.len() > 1 && run.feed_mm_min.is_none() {
            let message = format!("the programmed feed of {name} is not given");
            let help = "fill the column feed_mm_min";
            findings.push(Diagnostic::at(Code::DATA_COLUMN, place, message, help));
        }
        if run.tool_mm != trace.runs.first().map_or(Vector::zeros(), |first| first.tool_mm) {
            let help = "a trace is one set-up: put runs with another tool in a separate table";
            findings.push(Diagnostic::at(Code::DATA_CELL, place, format!("{name} has another tool"), help));
        }
    }
}

/// The longest gap of a recording, if it is many times its usual step: its start and length, s.
fn gap(times: &[f64]) -> Option<(f64, f64)> {
    /// Number of samples that a control may drop.
    const DROPPED: f64 = 20.0;
    let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let (usual, longest) = (steps.get(steps.len() / 2)?, steps.last()?);
    let (usual, longest) = (*usual, *longest);
    let from = times.windows(2).find(|pair| pair[1] - pair[0] >= longest)?;
    (longest > DROPPED * usual).then_some((from[0], longest))
}
