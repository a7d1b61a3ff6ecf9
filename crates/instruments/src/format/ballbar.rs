//! Circles of a telescoping ball-bar: angle and deviation, or angle and radius.
//!
//! The lines before the table may state plane, radius, feed, center, and the angles between which the circle counts: `plane;XY`, `radius_mm;150`. Angles count from
//! the first axis of the plane to the second. Instead of angles, the readings may have times. Readings of the overshoot, outside of start and end angle, are cut.

mod clock;

use ncfix_base::geometry::Axis;

use super::InstrumentFormat;
use crate::answers;
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::{ImportedKind, ImportedReadings, ImportedRow, shown};
use crate::text::DecodedText;
use crate::unit::ReadingUnit;
use crate::words::{self, ColumnRole};
use clock::CircleClock;

/// The format.
pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "ball-bar",
    title: "circles of a ball-bar: angle or time, and deviation or radius, for each run",
    needs: "plane radius feed at unit tool",
    recognize,
    read,
};

fn roles(table: &GridTable) -> Vec<ColumnRole> {
    table.headings.iter().map(|heading| words::role(&heading.words)).collect()
}

fn recognize(text: &DecodedText) -> u8 {
    let Ok(table) = grid::table(text) else { return 0 };
    let roles = roles(&table);
    let has_angle = roles.contains(&ColumnRole::Angle);
    let has_reading = roles.iter().any(|role| matches!(role, ColumnRole::Deviation | ColumnRole::Radius));
    // Times alone may be those of any instrument: the lines before the table must be those of a circle.
    let is_timed = || roles.contains(&ColumnRole::Time) && facts(text, &table).is_circle();
    if has_reading && !roles.contains(&ColumnRole::Target) && (has_angle || is_timed()) { 3 } else { 0 }
}

/// Values that the lines before the table state, with their lines.
#[derive(Default)]
struct CircleFacts {
    plane: Option<([Axis; 2], usize)>,
    radius_mm: Option<(f64, usize)>,
    feed: Option<(f64, usize)>,
    start_deg: Option<(f64, usize)>,
    end_deg: Option<(f64, usize)>,
    center: Vec<(Axis, f64, usize)>,
    unit: Option<(ReadingUnit, usize)>,
}

impl CircleFacts {
    /// True if they are those of a circle.
    fn is_circle(&self) -> bool {
        self.plane.is_some() || self.radius_mm.is_some()
    }
}

fn facts(text: &DecodedText, table: &GridTable) -> CircleFacts {
    let mut found = CircleFacts::default();
    for &line in &table.before {
        let Some((key, value)) = text.line(line).split_once([';', ':', '=', '\t', ',']) else { continue };
        let key = key.trim().to_lowercase();
        let value = value.trim().trim_matches([';', ',', '"', ' ']);
        let number = grid::number(value.split_whitespace().next().unwrap_or_default(), table.decimal);
        let has = |words: &[&str]| words.iter().any(|word| key.starts_with(word));
        if has(&["plane", "ebene", "plan", "piano", "plano"]) {
            found.plane = answers::plane(value).ok().map(|plane| (plane, line));
        } else if has(&["radius", "nominal radius", "nennradius", "rayon", "raggio", "radio"]) {
            found.radius_mm = number.map(|value| (value, line));
        } else if has(&["feed", "vorschub", "avance", "avanzamento"]) {
            found.feed = number.map(|value| (value, line));
        } else if has(&["start angle", "start_angle", "startwinkel", "start"]) {
            found.start_deg = number.map(|value| (value, line));
        } else if has(&["end angle", "end_angle", "endwinkel", "end"]) {
            found.end_deg = number.map(|value| (value, line));
        } else if has(&["center", "centre", "mittelpunkt", "zentrum"]) {
            let letter = key.bytes().last().map(|byte| byte.to_ascii_uppercase());
            if let (Some(axis), Some(value)) = (letter.and_then(Axis::from_letter), number) {
                found.center.push((axis, value, line));
            }
        } else if has(&["unit", "einheit"]) {
            found.unit = ReadingUnit::find(value).map(|unit| (unit, line));
        }
    }
    found
}

fn read(inquiry: &mut Inquiry<'_>) -> Result<ImportedReadings, ImportStop> {
    let table = grid::table(inquiry.text)?;
    let facts = facts(inquiry.text, &table);
    let line = table.heading_line;
    let roles = roles(&table);
    let of = |wanted: ColumnRole| roles.iter().position(|role| *role == wanted);
    let (angle, reading) = (of(ColumnRole::Angle), of(ColumnRole::Deviation).or(of(ColumnRole::Radius)));
    let time = of(ColumnRole::Time);
    if angle.or(time).is_none() {
        return Err(inquiry.refused(
            "the table has no column of angles or times",
            "export angle and deviation of each reading",
            line,
        ));
    }
    let Some(reading) = reading else {
        return Err(inquiry.refused(
            "the table has no column of deviations or radii",
            "export angle and deviation of each reading",
            line,
        ));
    };
    let is_radius = of(ColumnRole::Deviation).is_none();
    let unread: Vec<&str> = table
        .headings
        .iter()
        .zip(&roles)
        .filter(|(_, role)| **role == ColumnRole::Unknown)
        .map(|(heading, _)| heading.written.as_str())
        .collect();
    if !unread.is_empty() {
        inquiry.note(format!("columns that are not read: {}", unread.join(", ")), line);
    }
    let plane = match (inquiry.answers.plane, facts.plane) {
        (Some(said), Some((stated, line))) if said != stated => {
            return Err(inquiry.refused("--plane contradicts the file", "correct one of them", line));
        }
        (Some(said), _) => said,
        (None, Some((stated, line))) => {
            inquiry.note("plane of the circle", line);
            stated
        }
        (None, None) => {
            inquiry.ask("plane", "the file does not state the plane of the circle", "XY, YZ or ZX");
            [Axis::X, Axis::Y]
        }
    };
    let radius_mm = match (inquiry.answers.radius_mm, facts.radius_mm) {
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
    let feed = inquiry.answers.feed.or(facts.feed.map(|(feed, line)| {
        inquiry.note("feed", line);
        feed
    }));
    let (run, sense) = (of(ColumnRole::Run), of(ColumnRole::Sense));
    let bounds_deg = facts.start_deg.zip(facts.end_deg).map(|((start, _), (end, _))| [start, end]);
    let mut clock = match (angle, time) {
        (None, Some(time)) => Some(CircleClock::ask(inquiry, &table, time, sense, (feed, radius_mm), bounds_deg)?),
        _ => None,
    };
    let mut raw = Vec::new();
    let mut cut = 0;
    let is_outside = |deg: f64| {
        let bound = |limit: Option<(f64, usize)>, other: f64| limit.map_or(other, |(deg, _)| deg);
        let (start, end) = (bound(facts.start_deg, f64::MIN), bound(facts.end_deg, f64::MAX));
        deg < start.min(end) - 1e-6 || deg > start.max(end) + 1e-6
    };
    for row in &table.rows {
        let text = |column: Option<usize>| {
            column.and_then(|column| row.cells.get(column)).map_or("", |cell| cell.text.as_str())
        };
        let label = [text(run), text(sense)].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("-");
        let deg = match (&mut clock, angle) {
            (Some(clock), _) => clock.deg(inquiry, &table, row, &label)?,
            (None, Some(angle)) => table.needed(row, angle)?,
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
        let Some(value) = table.value(row, reading)? else { continue };
        raw.push((label, deg, value, row.number));
    }
    if let Some(clock) = &clock {
        clock.check(inquiry, facts.end_deg.map(|(deg, _)| deg))?;
    }
    if cut > 0 {
        inquiry.note(
            format!("{cut} readings of the overshoot are cut"),
            facts.start_deg.or(facts.end_deg).map_or(0, |(_, line)| line),
        );
    }
    let largest = raw.iter().map(|(_, _, value, _)| value.abs()).fold(0.0, f64::max);
    let written = table.headings.get(reading).and_then(|heading| heading.unit).map(|unit| (unit, line)).or(facts.unit);
    let unit = inquiry.unit(written, false, largest)?;
    let nominal = if is_radius { radius_mm } else { 0.0 };
    let first = raw.first().map_or(0.0, |(_, _, value, _)| unit.inner(*value));
    if is_radius && inquiry.questions().is_empty() && (first - radius_mm).abs() > 5.0 {
        let message = format!("the radius {} mm is not near the nominal length {} mm", shown(first), shown(radius_mm));
        return Err(inquiry.refused(message, "check --radius and --unit", raw.first().map_or(0, |row| row.3)));
    }
    // A longer bar reads positive in every layout; a radius has no sign at all.
    let sign = inquiry.sign(Some((1.0, line)), "");
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
    out.free = vec!["centre", "length"];
    out.sigma = inquiry.answers.sigma;
    out.feed = feed;
    let tip: Vec<String> = (0..3).map(|k| shown(center[k] + tool[k])).collect();
    out.sections = format!("[setup.A]\ncentre_mm = [{}]\nlength_mm = {}\n", tip.join(", "), shown(radius_mm));
    inquiry.note(
        "the length of the bar is an unknown: without a calibrated rod a common scale of the axes is not identifiable",
        0,
    );
    if feed.is_none() {
        inquiry.note("the feed is not known; backlash does not need it, errors at speed do", 0);
    }
    let mut worst = (0.0_f64, 0.0_f64);
    for (run, deg, value, line) in raw {
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
        out.rows.push(ImportedRow { run, position, values: vec![Some(fine)], line, ..ImportedRow::default() });
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
