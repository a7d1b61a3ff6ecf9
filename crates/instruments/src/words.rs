//! Words of headings in the languages of exports: English, German, French, Italian, Spanish.

use ncfix_base::geometry::Axis;

/// Meaning of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColumnRole {
    /// Nominal position of an axis.
    Target,
    /// Position that was reached.
    Actual,
    /// Actual minus nominal.
    Deviation,
    /// Nominal minus actual.
    Correction,
    /// Number of a repetition.
    Run,
    /// Direction of approach.
    Sense,
    /// Readings of one repetition in one direction: number, and 1 or -1; 0 if the heading has no direction.
    Series(u32, i8),
    /// Angle of a circle.
    Angle,
    /// Time, s.
    Time,
    /// Distance of two balls.
    Radius,
    /// Name of a feature, a ball or a point.
    Name,
    /// Not read.
    Skip,
    /// Unknown words.
    Unknown,
}

const ROLES: &[(ColumnRole, &[&str])] = &[
    (
        ColumnRole::Target,
        &[
            "target",
            "targets",
            "position",
            "pos",
            "target position",
            "nominal",
            "nominal position",
            "command",
            "soll",
            "sollposition",
            "sollwert",
            "zielposition",
            "ziel",
            "cible",
            "position cible",
            "consigne",
            "quota",
            "posizione",
            "objetivo",
            "posición",
            "posicion",
        ],
    ),
    (
        ColumnRole::Actual,
        &[
            "actual",
            "actual position",
            "measured",
            "measured position",
            "reached",
            "reached position",
            "erreicht",
            "erreichte position",
            "position atteinte",
            "raggiunta",
            "alcanzada",
            "ist",
            "istposition",
            "istwert",
            "messwert",
            "mesure",
            "mesuré",
            "position réelle",
            "reale",
            "misura",
            "real",
            "medido",
        ],
    ),
    (
        ColumnRole::Deviation,
        &[
            "dev",
            "deviation",
            "error",
            "err",
            "positioning error",
            "reading",
            "value",
            "abw",
            "abweichung",
            "fehler",
            "messabweichung",
            "positionsabweichung",
            "lageabweichung",
            "position deviation",
            "positioning deviation",
            "écart",
            "ecart",
            "erreur",
            "déviation",
            "scostamento",
            "errore",
            "deviazione",
            "desviación",
            "desviacion",
            "dr",
            "radial deviation",
            "radiusabweichung",
        ],
    ),
    (
        ColumnRole::Correction,
        &["correction", "compensation", "korrektur", "kompensation", "correzione", "corrección", "correccion"],
    ),
    (
        ColumnRole::Run,
        &[
            "run",
            "cycle",
            "pass",
            "repetition",
            "lauf",
            "messlauf",
            "durchlauf",
            "zyklus",
            "passage",
            "essai",
            "ciclo",
            "corsa",
            "pasada",
            "no",
            "nr",
        ],
    ),
    (
        ColumnRole::Sense,
        &[
            "dir",
            "direction",
            "sense",
            "approach",
            "richtung",
            "anfahrrichtung",
            "sens",
            "direzione",
            "senso",
            "verso",
            "dirección",
            "direccion",
            "sentido",
        ],
    ),
    (ColumnRole::Angle, &["angle", "theta", "winkel", "angolo", "ángulo", "angulo", "phi", "polar angle"]),
    (
        ColumnRole::Time,
        &[
            "time", "t", "zeit", "temps", "tempo", "tiempo", "time s", "time_s", "t s", "t_s", "time ms", "time_ms",
            "t_ms", "zeit s", "zeit ms",
        ],
    ),
    (ColumnRole::Radius, &["radius", "r", "distance", "rayon", "raggio", "radio", "ball distance"]),
    (
        ColumnRole::Name,
        &[
            "name",
            "feature",
            "id",
            "label",
            "point",
            "ball",
            "hole",
            "merkmal",
            "bezeichnung",
            "punkt",
            "kugel",
            "nom",
            "nome",
            "nombre",
            "kennung",
            "featureid",
            "feature id",
            "feature name",
            "merkmalsname",
        ],
    ),
    (ColumnRole::Skip, &["-", "skip"]),
];

/// Words for a motion in the positive and in the negative direction.
const SENSES: &[(i8, &[&str])] = &[
    (
        1,
        &[
            "+",
            "↑",
            "up",
            "fwd",
            "forward",
            "f",
            "pos",
            "positive",
            "hin",
            "vor",
            "vorwärts",
            "auf",
            "aller",
            "p",
            "v",
            "1",
            "+1",
            "andata",
            "ida",
        ],
    ),
    (
        -1,
        &[
            "-",
            "\u{2212}",
            "↓",
            "down",
            "rev",
            "reverse",
            "bwd",
            "backward",
            "r",
            "neg",
            "negative",
            "rück",
            "rueck",
            "zurück",
            "rückwärts",
            "ab",
            "retour",
            "n",
            "-1",
            "ritorno",
            "vuelta",
        ],
    ),
];

/// Returns the direction of a cell or of a part of a heading; `None` if it has none.
#[must_use]
pub fn sense(text: &str) -> Option<i8> {
    let text = text.trim().to_lowercase();
    SENSES.iter().find(|(_, words)| words.contains(&text.as_str())).map(|(sense, _)| *sense)
}

/// Words for a circle counterclockwise and clockwise.
const TURNS: &[(i8, &[&str])] = &[
    (
        1,
        &[
            "ccw",
            "g3",
            "g03",
            "counterclockwise",
            "anticlockwise",
            "gegenuhrzeigersinn",
            "antihoraire",
            "antiorario",
            "antihorario",
        ],
    ),
    (-1, &["cw", "g2", "g02", "clockwise", "uhrzeigersinn", "horaire", "orario", "horario"]),
];

/// Parts of the headings of circles that say neither a run nor a direction: `Run 1 CCW`, `dev_cw`.
const CIRCLE_ROLES: [ColumnRole; 3] = [ColumnRole::Run, ColumnRole::Deviation, ColumnRole::Radius];

/// Returns the direction of a circle: 1 counterclockwise, -1 clockwise; `None` for other words.
#[must_use]
pub fn turn(text: &str) -> Option<i8> {
    let text = text.trim().to_lowercase().replace(['-', ' '], "");
    TURNS.iter().find(|(_, words)| words.contains(&text.as_str())).map(|(turn, _)| *turn)
}

/// Heading of a column with the readings of one circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CircleHeading {
    /// Number of the repetition.
    pub run: Option<u32>,
    /// 1 counterclockwise, -1 clockwise; `None` if the heading does not say it.
    pub turn: Option<i8>,
    /// True if the readings are radii.
    pub is_radius: bool,
}

/// Reads the heading of the readings of one circle, given in lower case without its unit: `ccw`, `cw2`, `run 1 ccw`, `dev_cw`, `1+`, `2`.
#[must_use]
pub fn circle(words: &str) -> Option<CircleHeading> {
    let text = words.replace("counter-clock", "counterclock").replace("anti-clock", "anticlock");
    let text = text.replace("counter clock", "counterclock").replace("anti clock", "anticlock");
    let mut found = CircleHeading { run: None, turn: None, is_radius: false };
    if let Some(ColumnRole::Series(run, sense)) = series(words)
        && (sense == 0 || words.contains(['+', '-', '\u{2212}']))
    {
        return Some(CircleHeading { run: Some(run), turn: (sense != 0).then_some(sense), ..found });
    }
    for part in text.split([' ', '_', '-', '.', '#', '(', ')', ':', '/']).filter(|part| !part.is_empty()) {
        // `g2` and `g3` are words, the digits of `cw2` are the number of the run.
        let letters = if turn(part).is_some() { part } else { part.trim_matches(|c: char| c.is_ascii_digit()) };
        let number: String = part.replacen(letters, "", 1);
        if let Ok(number) = number.parse::<u32>() {
            if found.run.replace(number).is_some() {
                return None;
            }
        } else if !number.is_empty() {
            return None;
        }
        let own = ROLES.iter().find(|(_, words)| words.contains(&letters)).map(|(role, _)| *role);
        match (turn(letters), own) {
            _ if letters.is_empty() => {}
            (Some(turn), _) if found.turn.is_none() => found.turn = Some(turn),
            (None, Some(role)) if CIRCLE_ROLES.contains(&role) => found.is_radius |= role == ColumnRole::Radius,
            _ => return None,
        }
    }
    found.turn.is_some().then_some(found)
}

/// Headings of columns that have a unit in each row.
const UNITS: &[&str] = &["unit", "units", "einheit", "unité", "unità", "unidad"];
/// Headings of columns that have the quantity of each row.
const KINDS: &[&str] = &["type", "typ", "kind", "quantity", "messgröße", "messgroesse", "characteristic"];

/// True for the heading of a column that has a unit in each row.
#[must_use]
pub fn is_unit(words: &str) -> bool {
    UNITS.contains(&words.trim())
}

/// True for the heading of a column that has the quantity of each row.
#[must_use]
pub fn is_kind(words: &str) -> bool {
    KINDS.contains(&words.trim())
}

/// Names of columns that a measurement may have besides positions and readings.
const DRIVERS: &[&str] = &["t_s", "feed_mm_min", "load_N", "load_x_mm", "load_y_mm", "load_z_mm"];
/// Ends of the names of drivers: their units.
const DRIVER_UNITS: &[&str] = &["_C", "_pct", "_hPa", "_bar", "_rpm", "_W", "_A", "_V", "_N"];

/// True for the name of a column that a measurement may have besides positions and readings.
#[must_use]
pub(crate) fn is_driver(name: &str) -> bool {
    let is_word = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= 40;
    // A name is more than its unit: in `dx_A`, A is a letter of the file.
    let has_unit = DRIVER_UNITS.iter().any(|unit| name.strip_suffix(unit).is_some_and(|rest| rest.len() > 1));
    DRIVERS.contains(&name) || (is_word && has_unit)
}

/// Returns the meaning of a heading, given in lower case without its unit.
#[must_use]
pub fn role(words: &str) -> ColumnRole {
    let words = words.trim();
    let known = ROLES.iter().find(|(_, own)| own.contains(&words)).map(|(role, _)| *role);
    known.or_else(|| series(words)).or_else(|| named_series(words)).unwrap_or(ColumnRole::Unknown)
}

/// Reads the heading of a series: `1+`, `Run 2 -`, `3 ↓`, `F1`, `rev 2`, `Lauf 1 hin`.
fn series(words: &str) -> Option<ColumnRole> {
    let digits: String = words.chars().filter(char::is_ascii_digit).collect();
    let start = words.find(|c: char| c.is_ascii_digit())?;
    let before = words[..start].trim().trim_end_matches(['#', '_', '.']).trim();
    let after =
        words[start..].trim_start_matches(|c: char| c.is_ascii_digit()).trim().trim_matches(['(', ')', '_', ' ']);
    if after.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    let number: u32 = digits.parse().ok().filter(|number| (1..=999).contains(number))?;
    let is_run =
        |text: &str| text.is_empty() || ROLES.iter().any(|(role, own)| *role == ColumnRole::Run && own.contains(&text));
    match (is_run(before), after.is_empty()) {
        (true, true) => Some(ColumnRole::Series(number, 0)),
        (true, false) => sense(after).map(|sense| ColumnRole::Series(number, sense)),
        (false, true) => sense(before).map(|sense| ColumnRole::Series(number, sense)),
        (false, false) => None,
    }
}

/// Reads the heading of a series that also names its readings: `1+ dev`, `Abweichung 2 -`. Without a direction, the number may be that of anything.
fn named_series(words: &str) -> Option<ColumnRole> {
    let is_reading = |part: &str| {
        ROLES
            .iter()
            .any(|(role, own)| matches!(role, ColumnRole::Deviation | ColumnRole::Actual) && own.contains(&part))
    };
    let parts: Vec<&str> = words.split_whitespace().collect();
    let rest: Vec<&str> = parts.iter().copied().filter(|part| !is_reading(part)).collect();
    if rest.len() == parts.len() {
        return None;
    }
    series(&rest.join(" ")).filter(|role| matches!(role, ColumnRole::Series(_, sense) if *sense != 0))
}

/// Returns the axis that a heading names: `x`, `x-axis`, `axis x`, `x position`.
#[must_use]
pub fn axis(words: &str) -> Option<Axis> {
    let mut parts = words.split([' ', '-', '_', '.', ':']).filter(|part| !part.is_empty());
    let rest = [
        "axis",
        "achse",
        "axe",
        "asse",
        "eje",
        "position",
        "pos",
        "target",
        "soll",
        "nominal",
        "command",
        "linear",
        "linearachse",
    ];
    let mut found = None;
    for part in parts.by_ref() {
        match part.as_bytes() {
            [letter] if found.is_none() => found = Some(Axis::from_letter(letter.to_ascii_uppercase())?),
            _ if rest.contains(&part) => {}
            _ => return None,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_of_many_languages_are_known() {
        for (words, expected) in [
            ("sollposition", ColumnRole::Target),
            ("écart", ColumnRole::Deviation),
            ("messlauf", ColumnRole::Run),
            ("1+", ColumnRole::Series(1, 1)),
            ("run 2 -", ColumnRole::Series(2, -1)),
            ("3 ↓", ColumnRole::Series(3, -1)),
            ("f1", ColumnRole::Series(1, 1)),
            ("lauf 2 rück", ColumnRole::Series(2, -1)),
            ("4", ColumnRole::Series(4, 0)),
            ("1+ dev", ColumnRole::Series(1, 1)),
            ("abweichung 2 -", ColumnRole::Series(2, -1)),
            ("run 3 - deviation", ColumnRole::Series(3, -1)),
            ("dev 4", ColumnRole::Unknown),
            ("humidity", ColumnRole::Unknown),
        ] {
            assert_eq!(role(words), expected, "{words}");
        }
        for (words, run, turn) in [
            ("ccw", None, Some(1)),
            ("cw", None, Some(-1)),
            ("ccw1", Some(1), Some(1)),
            ("cw 12", Some(12), Some(-1)),
            ("run 1 ccw", Some(1), Some(1)),
            ("dev_cw", None, Some(-1)),
            ("g2", None, Some(-1)),
            ("counter-clockwise 3", Some(3), Some(1)),
            ("lauf 2 cw", Some(2), Some(-1)),
            ("run 2", Some(2), None),
            ("1+", Some(1), Some(1)),
        ] {
            assert_eq!(circle(words), Some(CircleHeading { run, turn, is_radius: false }), "{words}");
        }
        assert_eq!(circle("radius cw").map(|found| found.is_radius), Some(true));
        for words in ["humidity", "dev", "angle", "ccw cw", "1 ccw 2", "temperature ccw"] {
            assert_eq!(circle(words), None, "{words}");
        }
        assert_eq!(axis("x-axis"), Some(Axis::X));
        assert_eq!(axis("pos y"), Some(Axis::Y));
        assert_eq!(axis("x error"), None);
        assert!(is_unit("einheit") && is_kind("type") && !is_unit("target") && !is_kind("deviation"));
    }

    #[test]
    fn drivers_have_the_names_of_a_measurement() {
        for name in ["t_s", "T_bed_C", "T_nose_2_C", "load_N", "feed_mm_min", "humidity_pct", "spindle_rpm"] {
            assert!(is_driver(name), "{name}");
        }
        for name in ["T bed", "Humidity", "X", "_C", "dx_um", "T_C_", "°C", "No", "a,b_C"] {
            assert!(!is_driver(name), "{name}");
        }
    }
}
