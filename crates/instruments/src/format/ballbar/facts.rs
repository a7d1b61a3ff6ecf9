//! Values that the lines before the table of a ball-bar state.

use ncfix_base::csv::DecimalSign;
use ncfix_base::geometry::Axis;

use super::columns::ColumnFact;
use crate::answers;
use crate::grid::{self, GridTable};
use crate::inquiry::{ImportStop, Inquiry};
use crate::readings::shown;
use crate::row_fact::RowFact;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Share by which a length or a feed may differ between a line and a column.
const SAME: f64 = 1e-3;

/// Values with their lines.
#[derive(Default)]
pub(super) struct CircleFacts {
    /// First and second axis of the plane.
    plane: Option<([Axis; 2], usize)>,
    /// Nominal length of the bar, mm.
    pub(super) radius_mm: Option<(f64, usize)>,
    /// True if the deviations refer to the calibrated length of the bar.
    calibrated: Option<(bool, usize)>,
    /// Line with the calibrated length itself, or a text in its place: it does not say to which length the deviations refer.
    certified: Option<(String, usize)>,
    /// Uncertainty of the calibrated length, µm, with its coverage factor; `None` if its unit or the factor is not stated.
    length_sigma: Option<(Option<f64>, usize)>,
    /// Feed, mm/min.
    pub(super) feed: Option<(f64, usize)>,
    /// Angle at which the circle begins to count.
    pub(super) start_deg: Option<(f64, usize)>,
    /// Angle at which it ends.
    pub(super) end_deg: Option<(f64, usize)>,
    /// Direction of all circles: 1 counterclockwise, -1 clockwise.
    pub(super) turn: Option<(f64, usize)>,
    /// Axis positions at the center.
    pub(super) center: Vec<(Axis, f64, usize)>,
    /// Two lines that state the same key with different values.
    conflict: Option<[usize; 2]>,
}

impl CircleFacts {
    /// True if they are those of a circle.
    pub(super) fn is_circle(&self) -> bool {
        self.plane.is_some() || self.radius_mm.is_some()
    }

    /// Checks the lines against each other and against the options.
    ///
    /// # Errors
    /// The first contradiction.
    pub(super) fn check(&self, inquiry: &Inquiry<'_>) -> Result<(), ImportStop> {
        /// Half a digit of a length in mm, of a feed in mm/min, and of a position in mm.
        const SLACK: [f64; 3] = [0.05, 0.5, 0.005];
        if let Some([first, second]) = self.conflict {
            let message = format!("lines {first} and {second} state the same fact with different values");
            return Err(inquiry.refused(message, "remove the wrong line", second));
        }
        inquiry.agreed("radius", inquiry.answer("radius", |own| own.radius_mm), self.radius_mm, SLACK[0])?;
        inquiry.agreed("feed", inquiry.answer("feed", |own| own.feed), self.feed, SLACK[1])?;
        for &(axis, value, line) in &self.center {
            if let Some(said) = inquiry.given(axis).filter(|said| (said - value).abs() > SLACK[2]) {
                let (said, value) = (shown(said), shown(value));
                let message = format!("--at {axis}{said} contradicts the file, whose line {line} says {value}");
                let help = format!("remove {axis} from --at; if line {line} is no machine coordinate, remove the line");
                return Err(inquiry.refused(message, help, line));
            }
        }
        Ok(())
    }

    /// Takes the facts of columns with one value in all rows.
    ///
    /// # Errors
    /// If a value is not of its kind, or if a line before the table states another one.
    pub(super) fn add(
        &mut self,
        inquiry: &Inquiry<'_>,
        decimal: DecimalSign,
        columns: &[ColumnFact],
    ) -> Result<(), ImportStop> {
        for column in columns {
            let (line, help) = (column.line, "correct the column, or the line before the table");
            let wrong = |message: String| inquiry.refused(message, help, line);
            let other = |stated: usize| {
                wrong(format!("the column '{}' says {}, and line {stated} another value", column.written, column.text))
            };
            if column.fact == RowFact::Plane {
                let own = answers::plane(&column.text).map_err(&wrong)?;
                match self.plane {
                    Some((stated, at)) if stated != own => return Err(other(at)),
                    Some(_) => {}
                    None => self.plane = Some((own, line)),
                }
                continue;
            }
            let value = grid::number(&column.text, decimal)
                .ok_or_else(|| wrong(format!("'{}' in the column '{}' is no number", column.text, column.written)))?;
            let (slot, value) = match (column.fact, column.unit) {
                (RowFact::Bar, Some(unit @ ReadingUnit::Length(..))) => (&mut self.radius_mm, unit.inner(value)),
                (RowFact::Bar, _) => (&mut self.radius_mm, value),
                _ => (&mut self.feed, value * feed_factor(&column.written.to_lowercase(), "")),
            };
            match *slot {
                Some((stated, at)) if (stated - value).abs() > SAME * stated.abs() => return Err(other(at)),
                Some(_) => {}
                None => *slot = Some((value, line)),
            }
        }
        Ok(())
    }

    /// True if the length of the bar is calibrated, by the option or the file.
    ///
    /// # Errors
    /// If the option says so, and the file says that the calibrated length was not used.
    pub(super) fn is_calibrated(&self, inquiry: &mut Inquiry<'_>) -> Result<bool, ImportStop> {
        match (inquiry.answer("length", |own| own.is_calibrated), self.calibrated) {
            (Some(true), Some((false, line))) => {
                let message =
                    "--length calibrated contradicts the file, whose deviations do not refer to a calibrated length";
                Err(inquiry.refused(message, "remove --length, or correct the line", line))
            }
            (Some(said), _) => {
                let word = if said { "calibrated" } else { "unknown" };
                inquiry.note(format!("length of the bar: --length {word}"), 0);
                Ok(said)
            }
            (None, None) if self.certified.is_some() => {
                let line = self.certified.as_ref().map_or(0, |(_, line)| *line);
                let sentence = format!(
                    "line {line} states the calibrated length of the bar, and not whether the deviations refer to it"
                );
                inquiry.ask("length", sentence, "calibrated if they do, else unknown");
                Ok(true)
            }
            (None, Some((true, line))) => {
                inquiry.note("the length of the bar is calibrated, so it is not fitted", line);
                Ok(true)
            }
            (None, _) => Ok(false),
        }
    }

    /// Standard uncertainty of the calibrated length, µm, by the option or the file; `None` if neither states it.
    ///
    /// # Errors
    /// If they contradict each other.
    pub(super) fn length_sigma_um(&self, inquiry: &mut Inquiry<'_>) -> Result<Option<f64>, ImportStop> {
        /// Half a digit of a certificate, µm.
        const SLACK: f64 = 0.005;
        let said = inquiry.answer("length-sigma", |own| own.length_sigma_um);
        let known = self.length_sigma.and_then(|(value, line)| Some((value?, line)));
        inquiry.agreed("length-sigma", said, known, SLACK)?;
        match (said, self.length_sigma) {
            (Some(said), _) => {
                inquiry.note(format!("standard uncertainty of the length: --length-sigma {} µm", shown(said)), 0);
                Ok(Some(said))
            }
            (None, Some((Some(value), line))) => {
                inquiry.note(format!("standard uncertainty of the length: {} µm", shown(value)), line);
                Ok(Some(value))
            }
            (None, Some((None, line))) => {
                let sentence = format!(
                    "line {line} states an uncertainty of the length without its unit or its coverage factor k"
                );
                inquiry.ask("length-sigma", sentence, "the standard uncertainty in µm: U divided by k");
                Ok(None)
            }
            (None, None) => Ok(None),
        }
    }

    /// First and second axis of the plane; angles count from the first to the second.
    ///
    /// # Errors
    /// A contradiction between the file and the option.
    pub(super) fn plane(&self, inquiry: &mut Inquiry<'_>) -> Result<[Axis; 2], ImportStop> {
        let name = |[first, second]: [Axis; 2]| format!("{first}{second}");
        match (inquiry.answer("plane", |own| own.plane), self.plane) {
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

/// Words before the name of a fact: `Test radius`, `Nennradius`, `Prüfebene`.
const BEFORE: &[&str] = &[
    "test", "nominal", "nenn", "soll", "prüf", "pruef", "mess", "ball-bar", "ballbar", "bar", "circle", "kreis", "of",
    "the",
];

/// A key without the words before its name.
fn name_of(key: &str) -> &str {
    let mut name = key.trim_start_matches(['#', '/', '!', ' ']);
    while let Some(rest) = BEFORE.iter().find_map(|word| name.strip_prefix(word)) {
        name = rest.trim_start_matches([' ', '_', '-', '.']);
    }
    name
}

/// Keys of a line with the direction of the circles: `Direction;CCW`.
const DIRECTIONS: &[&str] = &[
    "direction",
    "dir",
    "run direction",
    "rotation",
    "turn",
    "sense",
    "richtung",
    "drehrichtung",
    "drehsinn",
    "umlaufsinn",
    "sens",
    "sens de rotation",
    "direzione",
    "senso",
    "verso",
    "dirección",
    "direccion",
    "sentido",
];

/// Keys of a line about the calibrated length: yes or no, or the length itself.
const CALIBRATED: &[&str] = &[
    "calibrated length",
    "length calibrated",
    "kalibrierte länge",
    "longueur étalonnée",
    "longueur calibrée",
    "lunghezza calibrata",
    "longitud calibrada",
];
/// Parts of the words for an uncertainty, and for what has it.
const UNCERTAINTY: &[&str] = &["uncertainty", "unsicherheit", "incertitude", "incertezza", "incertidumbre"];
const OF_LENGTH: &[&str] = &[
    "length",
    "calibrat",
    "certificate",
    "länge",
    "kalibr",
    "zertifikat",
    "longueur",
    "étalon",
    "certificat",
    "lunghezza",
    "calibra",
    "taratura",
    "longitud",
];

/// True for the key of a line with the uncertainty of the calibrated length.
fn is_length_sigma(key: &str) -> bool {
    let has = |words: &[&str]| words.iter().any(|word| key.contains(word));
    has(UNCERTAINTY) && has(OF_LENGTH)
}

/// The standard uncertainty of a length, µm; `None` if its unit or its coverage factor is not stated.
fn length_sigma(key: &str, value: &str, number: Option<f64>, unit: Option<ReadingUnit>) -> Option<f64> {
    let text = format!("{key} {value}").replace(' ', "");
    let factor = || -> Option<f64> {
        if text.contains("standard") || text.contains("1sigma") {
            return Some(1.0);
        }
        let after = text.split("k=").nth(1)?;
        let digits = after.split(|c: char| !c.is_ascii_digit() && c != '.' && c != ',').next()?;
        digits
            .trim_end_matches(['.', ','])
            .replace(',', ".")
            .parse::<f64>()
            .ok()
            .filter(|factor| (1.0..=4.0).contains(factor))
    };
    let Some(unit @ ReadingUnit::Length(..)) = unit else { return None };
    Some(unit.fine(number?) / factor()?).filter(|sigma| *sigma > 0.0)
}

/// An answer in a line of a file; `None` for a number or another word.
fn yes(value: &str) -> Option<bool> {
    match value {
        "yes" | "true" | "on" | "ja" | "oui" | "sì" | "si" | "sí" => Some(true),
        "no" | "false" | "off" | "nein" | "non" => Some(false),
        _ => None,
    }
}

/// Takes the value of a line. The first one counts, and a second one that differs is a conflict.
fn take<T: PartialEq>(slot: &mut Option<(T, usize)>, value: Option<T>, line: usize, conflict: &mut Option<[usize; 2]>) {
    match (slot.as_ref(), value) {
        (Some((own, first)), Some(value)) if *own != value => _ = conflict.get_or_insert([*first, line]),
        (None, Some(value)) => *slot = Some((value, line)),
        _ => {}
    }
}

/// Key and value of a line. A separator in brackets belongs to the key: `Uncertainty (k=2);0,5 um`.
fn pair(line: &str) -> Option<(&str, &str)> {
    let mut depth = 0_usize;
    let at = line.char_indices().find(|(_, letter)| {
        match letter {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        depth == 0 && matches!(letter, ';' | ':' | '=' | '\t' | ',')
    });
    let (at, letter) = at?;
    Some((line.get(..at)?, line.get(at + letter.len_utf8()..)?))
}

/// True for the key of a line with the nominal length of the bar: `Ballbar length`, `Nominal length`, `Longueur nominale`.
fn is_bar_length(key: &str) -> bool {
    let has = |words: &[&str]| words.iter().any(|word| key.contains(word));
    let is_length = has(&["length", "länge", "laenge", "longueur", "lunghezza", "longitud"]);
    // The length of a way, of a path, of a measured table, or the calibrated one are other facts.
    let is_bar = has(&["bar", "stab", "nomin", "nenn"]) || name_of(key).trim() == "length";
    is_length
        && is_bar
        && !has(UNCERTAINTY)
        && !has(&["calib", "kalib", "étalon", "taratura", "expan", "unit", "einheit"])
}

/// Coordinates in one value: `X20 Y-10 Z-260`, `x=20; y=-10`.
fn coordinates(value: &str, decimal: DecimalSign) -> impl Iterator<Item = (Axis, f64)> + use<'_> {
    value.split([' ', ';', '/']).filter_map(move |word| {
        let word = word.trim().trim_end_matches(',');
        let mut letters = word.chars();
        let axis = Axis::from_letter(u8::try_from(letters.next()?).ok()?.to_ascii_uppercase())?;
        let number = letters.as_str().trim_start_matches(['=', ':', ' ']);
        Some((axis, grid::number(number, decimal)?))
    })
}

/// Reads the lines before the table.
pub(super) fn facts(text: &DecodedText, table: &GridTable) -> CircleFacts {
    let mut found = CircleFacts::default();
    for &line in &table.before {
        let Some((key, value)) = pair(text.line(line)) else { continue };
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
        let name = name_of(&key);
        let has = |words: &[&str]| words.iter().any(|word| name.starts_with(word));
        let conflict = &mut found.conflict;
        if has(&["plane", "ebene", "plan", "piano", "plano"]) {
            take(&mut found.plane, answers::plane(&value).ok(), line, conflict);
        } else if (has(&["radius", "rayon", "raggio", "radio"]) && !has(&["radius error", "radius dev", "radiusabw"]))
            || is_bar_length(&key)
        {
            take(&mut found.radius_mm, length_mm, line, conflict);
        } else if CALIBRATED.iter().any(|own| name.starts_with(own)) && !is_length_sigma(&key) {
            let said = yes(&value);
            let length = said.is_none().then(|| value.clone()).filter(|value| !value.is_empty());
            take(&mut found.calibrated, said, line, conflict);
            take(&mut found.certified, length, line, conflict);
        } else if is_length_sigma(&key) {
            take(&mut found.length_sigma, Some(length_sigma(&key, &value, number, unit)), line, conflict);
        } else if has(&["feed", "vorschub", "avance", "avanzamento"]) {
            take(&mut found.feed, number.map(|number| number * feed_factor(&key, &value)), line, conflict);
        } else if DIRECTIONS.iter().any(|word| name.trim_end() == *word || name.starts_with(&format!("{word} of"))) {
            // A line that names both directions states none.
            take(&mut found.turn, answers::turn(&value).ok(), line, conflict);
        } else if has(&["start angle", "start_angle", "startwinkel", "start"]) {
            take(&mut found.start_deg, number, line, conflict);
        } else if has(&["end angle", "end_angle", "endwinkel", "end"]) {
            take(&mut found.end_deg, number, line, conflict);
        } else if has(&["center", "centre", "mittelpunkt", "zentrum"]) {
            let letter = key.bytes().last().map(|byte| byte.to_ascii_uppercase());
            if let (Some(axis), Some(value)) = (letter.and_then(Axis::from_letter), number) {
                found.center.push((axis, value, line));
            } else {
                found.center.extend(coordinates(&value, table.decimal).map(|(axis, value)| (axis, value, line)));
            }
        }
    }
    found
}
