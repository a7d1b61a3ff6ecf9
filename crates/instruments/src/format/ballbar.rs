//! Circles of a telescoping ball-bar: angle and deviation, or angle and radius.
//!
//! The lines before the table may state plane, radius, feed, center, and the angles between which the circle counts: `plane;XY`, `radius_mm;150`. Angles
//! count from the first axis of the plane to the second. A table may have a column for each circle. Instead of angles, the readings may have times.
//! Readings of the overshoot, outside of start and end angle, are not used.

mod clock;
mod columns;
mod facts;
mod runs;

use ncfix_base::geometry::Axis;

use super::InstrumentFormat;
use crate::answers::{self, ReadingMaterial};
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::rows;
use crate::signs::SignMeaning;
use crate::text::DecodedText;
use crate::words::{self, ColumnRole};
use clock::CircleClock;
use columns::CircleColumns;
use facts::facts;
use runs::CircleRun;

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "ball-bar",
    title: "circles of a ball-bar: angle or time, and deviation or radius, for each run",
    needs: "plane radius length feed at unit tool material",
    recognize,
    read,
};

fn recognize(text: &DecodedText) -> u8 {
    let Ok(table) = grid::table(text) else { return 0 };
    let roles: Vec<ColumnRole> = table.headings.iter().map(|heading| words::role(&heading.words)).collect();
    let has_angle = roles.contains(&ColumnRole::Angle);
    let is_reading = |role: &ColumnRole| matches!(role, ColumnRole::Deviation | ColumnRole::Radius);
    let is_circle = |(heading, role): (&grid::GridHeading, &ColumnRole)| {
        words::circle(&heading.words).is_some() && !matches!(role, ColumnRole::Series(..))
    };
    let has_reading = roles.iter().any(is_reading) || table.headings.iter().zip(&roles).any(is_circle);
    // Times, and runs without the word for a circle, may be those of any instrument: then the lines before the table must be those of a circle.
    let has_words = || facts(text, &table).is_circle();
    let has_runs = || roles.iter().any(|role| matches!(role, ColumnRole::Series(..))) && has_words();
    let is_timed = || roles.contains(&ColumnRole::Time) && has_words();
    let is_known = !roles.contains(&ColumnRole::Target) && (has_reading || has_runs()) && (has_angle || is_timed());
    if is_known { 3 } else { 0 }
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let table = grid::table(inquiry.text)?;
    let mut facts = facts(inquiry.text, &table);
    let line = table.heading_line;
    let columns = columns::find(inquiry, &table)?;
    facts.add(inquiry, table.decimal, &columns.constants)?;
    facts.check(inquiry)?;
    let plane = facts.plane(inquiry)?;
    let radius_mm = match (inquiry.answers().radius_mm, facts.radius_mm) {
        (Some(said), _) => said,
        (None, Some((stated, line))) => {
            inquiry.note("nominal length of the ball-bar", line);
            stated
        }
        (None, None) => {
            inquiry.ask(
                "radius",
                "the file does not state the nominal length of the ball-bar",
                "the length in mm, such as 150",
            );
            150.0
        }
    };
    if !(1.0..=100_000.0).contains(&radius_mm) {
        return Err(inquiry.refused(
            format!("a ball-bar of {} mm does not exist", shown(radius_mm)),
            "give --radius in mm",
            facts.radius_mm.map_or(0, |(_, line)| line),
        ));
    }
    if let Some((_, line)) = facts.turn {
        inquiry.note("direction of all circles", line);
    }
    let feed = inquiry.answers().feed.or(facts.feed.map(|(feed, line)| {
        inquiry.note("feed", line);
        feed
    }));
    let bounds_deg = facts.start_deg.zip(facts.end_deg).map(|((start, _), (end, _))| [start, end]);
    let mut clock = match (columns.angle, columns.time) {
        (None, Some(time)) => {
            let mut turns = stated_turns(inquiry, &table, &columns)?;
            turns.extend(facts.turn.map(|(turn, _)| turn));
            Some(CircleClock::ask(inquiry, &table, (time, turns), (feed, radius_mm), bounds_deg)?)
        }
        _ => None,
    };
    let mut runs: Vec<CircleRun> = Vec::new();
    let mut cut = 0;
    let is_outside = |deg: f64| {
        let bound = |limit: Option<(f64, usize)>, other: f64| limit.map_or(other, |(deg, _)| deg);
        let (start, end) = (bound(facts.start_deg, f64::MIN), bound(facts.end_deg, f64::MAX));
        deg < start.min(end) - 1e-6 || deg > start.max(end) + 1e-6
    };
    for row in &table.rows {
        let name = columns.run.and_then(|column| row.cells.get(column)).map_or("", |cell| cell.text.as_str());
        let sense = columns.sense.and_then(|column| row.cells.get(column)).map(|cell| cell.text.as_str());
        let turn = match sense.filter(|text| !text.is_empty()) {
            Some(text) => Some(answers::turn(text).map_err(|message| {
                inquiry.refused(message, "write ccw or cw in the column of the direction", row.number)
            })?),
            None => None,
        };
        for (column, heading) in &columns.readings {
            let name = heading.run.map_or_else(|| name.to_owned(), |run| run.to_string());
            let own = turn.or(heading.turn.map(f64::from));
            if let (Some(own), Some((stated, at))) = (own, facts.turn)
                && own != stated
            {
                let message = format!("the direction of this circle contradicts line {at}");
                return Err(inquiry.refused(message, "remove the line, or correct it", row.number));
            }
            let turn = own.or(facts.turn.map(|(turn, _)| turn));
            let index = runs.iter().position(|run| run.name == name && run.turn == turn).unwrap_or_else(|| {
                runs.push(CircleRun { name, turn, readings: Vec::new() });
                runs.len() - 1
            });
            let deg = match (&mut clock, columns.angle) {
                (Some(clock), _) => {
                    clock.deg(inquiry, &table, row, index, turn.or(runs::by_option(inquiry, index)).unwrap_or(1.0))?
                }
                (None, Some(angle)) => table.needed(row, angle)? * columns.deg,
                (None, None) => continue,
            };
            if deg.abs() > 36_000.0 {
                return Err(inquiry.refused(
                    format!("{} is not an angle in degrees", shown(deg)),
                    "export angles in degrees",
                    row.number,
                ));
            }
            if is_outside(deg) {
                cut += 1;
                continue;
            }
            let Some(value) = table.value(row, *column)? else { continue };
            if let Some(run) = runs.get_mut(index) {
                run.readings.push((deg, value, row.number));
            }
        }
    }
    runs.retain(|run| !run.readings.is_empty());
    runs::sort(inquiry, &mut runs, clock.is_some(), line)?;
    if let Some(clock) = &clock {
        clock.check(inquiry, facts.end_deg.map(|(deg, _)| deg))?;
    }
    if cut > 0 {
        inquiry.note(
            format!("{cut} readings of the overshoot are not used"),
            facts.start_deg.or(facts.end_deg).map_or(0, |(_, line)| line),
        );
    }
    let raw = || runs.iter().flat_map(|run| &run.readings);
    let largest = raw().map(|(_, value, _)| value.abs()).fold(0.0, f64::max);
    let unit = inquiry.unit(columns.unit.map(|unit| (unit, line)), false, largest)?;
    let nominal = if columns.is_radius { radius_mm } else { 0.0 };
    let first = raw().next().map_or(0.0, |(_, value, _)| unit.inner(*value));
    if columns.is_radius && inquiry.questions().is_empty() && (first - radius_mm).abs() > 5.0 {
        let message = format!("the radius {} mm is not near the nominal length {} mm", shown(first), shown(radius_mm));
        return Err(inquiry.refused(message, "check --radius and --unit", raw().next().map_or(0, |row| row.2)));
    }
    // A longer bar reads positive in every layout unless a line says otherwise; a radius has no sign at all.
    let is_usual = columns.is_radius || inquiry.sign_statements().is_empty();
    let question = "is the distance of the balls longer than nominal where a reading is positive?";
    let sign = inquiry.sign(is_usual.then_some((1.0, line)), question, SignMeaning::Difference)?;
    let mut center = [0.0; 3];
    let mut missing = Vec::new();
    for (k, axis) in [Axis::X, Axis::Y, Axis::Z].into_iter().enumerate() {
        let stated = facts.center.iter().find(|(own, ..)| *own == axis);
        match inquiry.given(axis).or(stated.map(|(_, value, _)| *value)) {
            Some(value) => center[k] = value,
            None => missing.push(format!("{}0", char::from(axis.letter()))),
        }
        if let (None, Some((_, _, line))) = (inquiry.given(axis), stated) {
            inquiry.note(format!("center in {}, taken as machine coordinates", char::from(axis.letter())), *line);
        }
    }
    if !missing.is_empty() {
        inquiry.ask(
            "at",
            "the file does not state the axis positions at the center of the circle",
            format!("machine coordinates, such as {}", missing.join(",")),
        );
    }
    let tool = inquiry.tool();
    let axes = vec![Axis::X, Axis::Y, Axis::Z];
    let mut out = ImportedReadings::new(ImportedKind::BallBar, axes.clone(), vec!["dr_um"]);
    out.fixed = inquiry.other_positions(&axes);
    out.tool_mm = [tool[0], tool[1], tool[2]];
    let is_calibrated = facts.is_calibrated(inquiry)?;
    out.free = if is_calibrated { vec!["centre"] } else { vec!["centre", "length"] };
    out.sigma = inquiry.answer("sigma", |own| own.sigma);
    out.feed = feed;
    let rod = bar(inquiry, is_calibrated)?;
    let length_sigma = if is_calibrated { facts.length_sigma_um(inquiry)? } else { None };
    let certificate = length_sigma.map_or(String::new(), |sigma| format!("length_sigma_um = {}\n", shown(sigma)));
    out.lacks_certificate = is_calibrated && length_sigma.is_none();
    let tip: Vec<String> = (0..3).map(|k| shown(center[k] + tool[k])).collect();
    out.sections =
        format!("[setup.A]\ncentre_mm = [{}]\nlength_mm = {}\n{certificate}{rod}", tip.join(", "), shown(radius_mm));
    if !is_calibrated {
        let note = "the length of the bar is an unknown, so a common scale of the axes is not identifiable (--length calibrated for a calibrated bar)";
        inquiry.note(note, 0);
    }
    if feed.is_none() {
        inquiry.note("the feed is not known; backlash does not need it, errors at speed do", 0);
    }
    let mut worst = (0.0_f64, 0.0_f64);
    if !facts::is_standard(plane) && runs.iter().any(|run| run.turn.is_some()) {
        let [first, second] = plane;
        inquiry.note(
            format!("ccw from {first} to {second} is cw in the plane {second}{first} of ISO 230-4, whose words name the runs"),
            0,
        );
    }
    for run in &runs {
        let label = runs::standard_label(run, plane);
        let angles: Vec<f64> = run.readings.iter().map(|(deg, ..)| *deg).collect();
        out.gaps.extend(rows::missing_arcs(&label, &angles, bounds_deg));
        for &(deg, value, line) in &run.readings {
            let mut position = center.to_vec();
            let angle = deg.to_radians();
            for (axis, share) in plane.iter().zip([angle.cos(), angle.sin()]) {
                if let Some(place) = axes.iter().position(|own| own == axis).and_then(|k| position.get_mut(k)) {
                    *place += radius_mm * share;
                }
            }
            let fine = sign * (unit.inner(value) - nominal) * 1000.0;
            if fine.abs() > worst.0.abs() {
                worst = (fine, deg);
            }
            let run = label.clone();
            out.rows.push(ImportedRow { run, position, values: vec![Some(fine)], line, ..ImportedRow::default() });
        }
    }
    let how = if worst.0 < 0.0 { "shorter" } else { "longer" };
    out.sign_sentence = format!(
        "at {}° (from {} to {}) the distance of the balls is {:.1} µm {how} than nominal",
        shown(worst.1),
        char::from(plane[0].letter()),
        char::from(plane[1].letter()),
        worst.0.abs()
    );
    Ok(out)
}

/// The keys of the temperature of the bar; empty if its length is that at 20 °C. A calibrated length counts only with its temperature, so that is then asked.
///
/// # Errors
/// If the option contradicts the file.
fn bar(inquiry: &mut Inquiry<'_>, is_calibrated: bool) -> Result<String, ImportStop> {
    if !is_calibrated && inquiry.answers().material.is_none() {
        return Ok(String::new());
    }
    Ok(match inquiry.material("the bar")? {
        ReadingMaterial::Reference => String::new(),
        ReadingMaterial::Expanded { per_k, celsius } => {
            format!("rod_expansion_per_K = {per_k:e}\nrod_temperature_C = {}\n", shown(celsius))
        }
    })
}

/// The directions that the file or the option states, for circles whose angles follow from them.
///
/// # Errors
/// If a cell is no direction.
fn stated_turns(inquiry: &Inquiry<'_>, table: &GridTable, columns: &CircleColumns) -> Result<Vec<f64>, ImportStop> {
    let mut found: Vec<f64> = columns.readings.iter().filter_map(|(_, heading)| heading.turn).map(f64::from).collect();
    for row in &table.rows {
        let cell = columns.sense.and_then(|column| row.cells.get(column)).filter(|cell| !cell.text.is_empty());
        if let Some(cell) = cell {
            let wrong =
                |message| inquiry.refused(message, "write ccw or cw in the column of the direction", row.number);
            found.push(answers::turn(&cell.text).map_err(wrong)?);
        }
    }
    found.extend(&inquiry.answers().turns);
    Ok(found)
}
