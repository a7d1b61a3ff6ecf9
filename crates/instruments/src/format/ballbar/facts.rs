//! Values that the lines before the table of a ball-bar state.

use ncfix_base::geometry::Axis;

use crate::answers;
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Values with their lines.
#[derive(Default)]
pub(super) struct CircleFacts {
    /// First and second axis of the plane.
    plane: Option<([Axis; 2], usize)>,
    /// Nominal length of the bar, mm.
    pub(super) radius_mm: Option<(f64, usize)>,
    /// Feed, mm/min.
    pub(super) feed: Option<(f64, usize)>,
    /// Angle at which the circle begins to count.
    pub(super) start_deg: Option<(f64, usize)>,
    /// Angle at which it ends.
    pub(super) end_deg: Option<(f64, usize)>,
    /// Axis positions at the center.
    pub(super) center: Vec<(Axis, f64, usize)>,
    /// Unit of the readings.
    pub(super) unit: Option<(ReadingUnit, usize)>,
}

impl CircleFacts {
    /// True if they are those of a circle.
    pub(super) fn is_circle(&self) -> bool {
        self.plane.is_some() || self.radius_mm.is_some()
    }

    /// First and second axis of the plane; angles count from the first to the second.
    ///
    /// # Errors
    /// A contradiction between the file and the option.
    pub(super) fn plane(&self, inquiry: &mut Inquiry<'_>) -> Result<[Axis; 2], ImportStop> {
        let name = |[first, second]: [Axis; 2]| format!("{first}{second}");
        match (inquiry.answers.plane, self.plane) {
            (Some(said), Some((stated, line)))
                if said != stated && (is_standard(stated) || said != [stated[1], stated[0]]) =>
            {
                Err(inquiry.refused("--plane contradicts the file", "correct one of them", line))
            }
            (Some(said), _) => {
                inquiry.note(format!("plane of the circle: --plane {}", name(said)), 0);
                Ok(said)
            }
            (None, Some((stated, line))) if is_standard(stated) => {
                inquiry.note("plane of the circle", line);
                Ok(stated)
            }
            (None, Some((stated, line))) => {
                // Some instruments name the plane ZX of ISO 230-4 XZ and count from Z, others count from X.
                let (own, other) = (name(stated), name([stated[1], stated[0]]));
                let sentence = format!("line {line} names the plane {own}, which ISO 230-4 names {other}");
                let [first, second] = stated;
                let advice = format!(
                    "{other} if angles count from {second} to {first}, {own} if they count from {first} to {second}"
                );
                inquiry.ask("plane", sentence, advice);
                Ok(stated)
            }
            (None, None) => {
                inquiry.ask("plane", "the file does not state the plane of the circle", "XY, YZ or ZX");
                Ok([Axis::X, Axis::Y])
            }
        }
    }
}

/// True for the planes XY, YZ and ZX of ISO 230-4, in which angles count counterclockwise.
pub(super) fn is_standard([first, second]: [Axis; 2]) -> bool {
    (first.slot() + 1) % 3 == second.slot()
}

/// Factor from the unit of a feed to mm/min: that of its key or of its value.
fn feed_factor(key: &str, value: &str) -> f64 {
    let text = format!("{key} {value}").replace(['_', '[', ']', '(', ')'], " ");
    let has = |words: &[&str]| words.iter().any(|word| text.contains(word));
    if has(&["in/min", "inch", "ipm", "zoll"]) {
        25.4
    } else if has(&["mm/s"]) {
        60.0
    } else if has(&[" m/min"]) {
        1000.0
    } else {
        1.0
    }
}

/// Reads the lines before the table.
pub(super) fn facts(text: &DecodedText, table: &GridTable) -> CircleFacts {
    let mut found = CircleFacts::default();
    for &line in &table.before {
        let Some((key, value)) = text.line(line).split_once([';', ':', '=', '\t', ',']) else { continue };
        let key = key.trim().to_lowercase();
        let value = value.trim().trim_matches([';', ',', '"', ' ']).to_lowercase();
        let number = grid::number(value.split_whitespace().next().unwrap_or_default(), table.decimal);
        // The unit of a length is in its key, as in `Radius [inch]`, or behind its value.
        let unit = grid::heading_of(&key)
            .unit
            .or(value.split_once(char::is_whitespace).and_then(|(_, u)| ReadingUnit::find(u)));
        let length_mm = number.map(|value| match unit {
            Some(unit @ ReadingUnit::Length(..)) => unit.inner(value),
            _ => value,
        });
        let has = |words: &[&str]| words.iter().any(|word| key.starts_with(word));
        if has(&["plane", "ebene", "plan", "piano", "plano"]) {
            found.plane = answers::plane(&value).ok().map(|plane| (plane, line));
        } else if has(&["radius", "nominal radius", "nennradius", "rayon", "raggio", "radio"]) {
            found.radius_mm = length_mm.map(|value| (value, line));
        } else if has(&["feed", "vorschub", "avance", "avanzamento"]) {
            found.feed = number.map(|number| (number * feed_factor(&key, &value), line));
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
            found.unit = ReadingUnit::find(&value).map(|unit| (unit, line));
        }
    }
    found
}
