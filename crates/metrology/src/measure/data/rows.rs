//! The rows of a measurement: NAME.csv.

use std::collections::HashMap;

use ncfix_base::csv::Table;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::geometry::AxisVector;
use ncfix_machine::machine::condition::columns::OfDead;

use super::super::reading::Readings;
use super::{DataSet, Observation, Setup, bodies, condition, text};

/// Reads all rows into `data`.
pub(super) fn read(
    rows: &Table,
    mut readings: Readings<'_>,
    of_dead: OfDead,
    data: &mut DataSet,
    findings: &mut Vec<Diagnostic>,
) {
    let [setup_column, run_column, time_column] = ["setup", "run", "t_s"].map(|name| rows.column(name));
    let mut conditions = condition::begin(rows, data.kind.temperature, of_dead, findings);
    let [temperature_column, feed_column] = [data.kind.temperature, Some("feed_mm_min")].map(|name| rows.column(name?));
    let mut seen: HashMap<(Vec<u64>, usize, usize), Place> = HashMap::new();
    let mut copies: Vec<(Place, Place)> = Vec::new();
    // A wrongly used column may have as many labels as rows.
    let mut runs: HashMap<String, usize> = HashMap::new();
    data.has_senses = readings.has_senses();
    let is_described = !data.setups.is_empty();
    for row in rows.rows() {
        let reading = match readings.read(&row) {
            Ok(reading) => reading,
            Err(found) => {
                findings.extend(found);
                continue;
            }
        };
        let label = setup_column.map_or(String::new(), |column| text(&row, column));
        let known = data.setups.iter().position(|setup| setup.label == label);
        let setup = match known {
            Some(setup) => setup,
            None if is_described && setup_column.is_none() && data.setups.len() == 1 => 0,
            None if is_described => {
                let place = setup_column.map_or(row.place(0), |column| row.place(column));
                let message = format!("the set-up '{label}' is not described");
                findings.push(Diagnostic::at(
                    Code::DATA_CELL,
                    place,
                    message,
                    format!("add [setup.{label}] to the description"),
                ));
                continue;
            }
            None => {
                data.setups.push(Setup { label, ..data.artefact.clone() });
                data.setups.len() - 1
            }
        };
        let mut number = |column: Option<usize>| match column.filter(|&column| !row.text(column).is_empty()) {
            Some(column) => {
                row.number(column, readings.sign()).map_err(|finding| findings.push(finding)).ok().map(Some)
            }
            None => Some(None),
        };
        let (Some(t_s), Some(temperature_c), Some(feed)) =
            (number(time_column), number(temperature_column), number(feed_column))
        else {
            continue;
        };
        if let (Some(column), Some(found)) = (temperature_column, bodies::implausible(temperature_c)) {
            findings.push(Diagnostic::at(Code::DATA_CELL, row.place(column), found, bodies::PLAUSIBLE));
            continue;
        }
        let run =
            *runs.entry(run_column.map_or(String::new(), |column| text(&row, column))).or_insert_with_key(|label| {
                data.runs.push(label.clone());
                data.runs.len() - 1
            });
        let number = conditions.as_mut().map(|all| all.read(&row, readings.sign(), run, setup, t_s));
        let number = match number.transpose() {
            Ok(number) => number.unwrap_or(0),
            Err(found) => {
                findings.extend(found);
                continue;
            }
        };
        let mut observation = Observation {
            reading,
            setup,
            run,
            t_s,
            condition: number,
            temperature_c,
            feed,
            cycle: None,
            values: [None; 3],
            target: None,
            component: None,
            spindle_rad: 0.0,
            place: row.place(0),
        };
        match (data.kind.read)(data, &row, readings.sign(), &mut observation) {
            Ok(()) => {}
            Err(finding) => {
                findings.push(finding);
                continue;
            }
        }
        let key = (bits(&observation, readings.has_senses()), setup, observation.target.unwrap_or(usize::MAX));
        // A plan may repeat a pose.
        if let Some(first) = (!data.is_plan).then(|| seen.insert(key, observation.place)).flatten() {
            copies.push((observation.place, first));
        }
        data.observations.push(observation);
    }
    findings.extend(copied(rows, &copies));
    data.conditions = conditions.map_or_else(Vec::new, condition::Conditions::finish);
    if data.observations.is_empty() && findings.is_empty() {
        let help = "write at least one reading";
        findings.push(Diagnostic::at(Code::DATA_COLUMN, rows.header_place(None), "the table has no rows", help));
    }
}

/// The warning for repeated rows: the first of them, and their number.
fn copied(rows: &Table, copies: &[(Place, Place)]) -> Option<Diagnostic> {
    /// Maximum number of reported lines.
    const LINES: usize = 5;
    let &(place, first) = copies.first()?;
    let mut message = format!("the row is the same as that in line {}", row_line(rows, first));
    let more = copies.len() - 1;
    if more > 0 {
        let lines: Vec<String> =
            copies.iter().skip(1).take(LINES).map(|(place, _)| row_line(rows, *place).to_string()).collect();
        let dots = if more > LINES { ", …" } else { "" };
        message.push_str(&format!("; {more} more rows are copies too (line {}{dots})", lines.join(", ")));
    }
    let help = "remove one of them: a repetition would differ by the noise of the instrument; if it is a repetition, give t_s or run";
    Some(Diagnostic::at(Code::DATA_REPEATED, place, message, help))
}

/// The content of a row as bits, for detecting copies.
///
/// A direction that follows from the order of the rows is excluded: a copy elsewhere in the table would have another. A single value without a time
/// may be repeated on the way back.
fn bits(observation: &Observation, has_senses: bool) -> Vec<u64> {
    let count = observation.values.iter().flatten().count();
    let is_single = observation.t_s.is_none() && (1..3).contains(&count);
    let AxisVector(position) = observation.reading.position;
    let values = observation.values.map(|value| value.unwrap_or(f64::NAN));
    let senses =
        observation.reading.state.direction.map(|sense| if has_senses || is_single { f64::from(sense) } else { 0.0 });
    let tool = observation.reading.tool_mm;
    let spindle = [observation.spindle_rad];
    position
        .iter()
        .chain(&values)
        .chain(&senses)
        .chain(tool.iter())
        .chain(&spindle)
        .chain(&[observation.run as f64, observation.condition as f64])
        .chain(&[observation.t_s, observation.temperature_c].map(|value| value.unwrap_or(f64::NAN)))
        .map(|value| value.to_bits())
        .collect()
}

fn row_line(rows: &Table, place: Place) -> usize {
    rows.line_of(place)
}
