//! Columns that state what the reading of each row is: plane, axis, direction, bar, feed. A reader that passes over one of them would take the rows of two
//! planes for those of one.

use crate::grid::{GridTable, number};
use crate::words;

/// Fact that a column states for each row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RowFact {
    /// Unit of the reading.
    Unit,
    /// Quantity that was read.
    Quantity,
    /// Axis that moved.
    Axis,
    /// Plane of a circle.
    Plane,
    /// Direction of the motion or of the approach.
    Direction,
    /// Repetition.
    Run,
    /// Nominal length of the bar.
    Bar,
    /// Feed.
    Feed,
    /// Side, place or set-up.
    Place,
    /// Sign of the reading.
    Sign,
}

impl RowFact {
    /// True if the fact counts even if it is the same in all rows: without it, an option or a default would decide.
    pub(crate) fn counts_alone(self) -> bool {
        matches!(self, RowFact::Unit | RowFact::Quantity | RowFact::Axis | RowFact::Plane | RowFact::Sign)
    }
}

/// Words of headings: English, German, French, Italian, Spanish. A German compound ends with its noun.
const FACTS: &[(RowFact, &[&str])] = &[
    (RowFact::Unit, &["unit", "units", "einheit", "unité", "unite", "unità", "unita", "unidad"]),
    (RowFact::Quantity, &["type", "typ", "kind", "quantity", "messgröße", "messgroesse", "characteristic"]),
    (RowFact::Plane, &["plane", "ebene", "plan", "piano", "plano", "planes", "ebenen"]),
    (RowFact::Axis, &["axis", "achse", "axe", "asse", "eje", "axes", "achsen"]),
    (
        RowFact::Direction,
        &[
            "dir",
            "direction",
            "sense",
            "approach",
            "turn",
            "rotation",
            "richtung",
            "drehsinn",
            "umlaufsinn",
            "sens",
            "direzione",
            "senso",
            "verso",
            "dirección",
            "direccion",
            "sentido",
            "reversal",
        ],
    ),
    (RowFact::Sign, &["sign", "polarity", "vorzeichen", "signe", "segno", "signo"]),
    (
        RowFact::Bar,
        &[
            "rod",
            "bar",
            "ballbar",
            "stab",
            "stablänge",
            "stablaenge",
            "barre",
            "barra",
            "nennradius",
            "nennlänge",
            "radius",
            "rayon",
            "raggio",
        ],
    ),
    (RowFact::Feed, &["feed", "feedrate", "vorschub", "avance", "avanzamento"]),
    (
        RowFact::Run,
        &["run", "cycle", "pass", "repetition", "lauf", "zyklus", "passage", "essai", "ciclo", "corsa", "pasada"],
    ),
    (
        RowFact::Place,
        &[
            "side",
            "seite",
            "côté",
            "cote",
            "lato",
            "lado",
            "setup",
            "aufspannung",
            "montage",
            "station",
            "component",
            "komponente",
            "composante",
            "componente",
        ],
    ),
];

/// Words of a measured quantity: `axis position` and `direction error` state no fact of the row.
const QUANTITIES: &[&str] = &[
    "position",
    "pos",
    "posizione",
    "posición",
    "posicion",
    "coordinate",
    "koordinate",
    "temp",
    "temperature",
    "temperatur",
    "température",
    "temperatura",
    "load",
    "last",
    "error",
    "err",
    "fehler",
    "erreur",
    "errore",
    "dev",
    "deviation",
    "abweichung",
    "écart",
    "pressure",
    "druck",
    "luftdruck",
    "pression",
    "pressione",
    "presión",
    "air",
    "luft",
    "humidity",
    "time",
    "zeit",
    "speed",
    "rpm",
    "current",
    "strom",
    "diameter",
    "number",
    "nummer",
    "id",
    "name",
    "file",
];

/// Shortest noun that ends a compound.
const NOUN: usize = 4;

/// Fact that a column with this heading states, given in lower case without its unit; `None` for all other columns.
pub(crate) fn row_fact(heading: &str) -> Option<RowFact> {
    if words::axis(heading).is_some() {
        return None;
    }
    let joined = heading.replace("set-up", "setup").replace("set up", "setup").replace("ball-bar", "ballbar");
    let tokens: Vec<&str> = joined.split(|c: char| !c.is_alphanumeric()).filter(|token| !token.is_empty()).collect();
    if tokens.iter().any(|token| QUANTITIES.contains(token)) {
        return None;
    }
    let has = |own: &str| {
        let ends = |token: &&str| own.len() >= NOUN && token.len() > own.len() && token.ends_with(own);
        tokens.iter().any(|token| *token == own || is_compound(own) && ends(token))
    };
    FACTS.iter().find(|(_, own)| own.iter().any(|word| has(word))).map(|(fact, _)| *fact)
}

/// True for the German nouns that end compounds, such as `Kreisebene`, `Linearachse` and `Verfahrrichtung`.
fn is_compound(noun: &str) -> bool {
    ["ebene", "achse", "richtung", "seite", "einheit", "lauf", "vorschub"].contains(&noun)
}

/// Most distinct values of a column that are compared: more are those of a quantity or of a remark.
const MOST_VALUES: usize = 64;

/// Words by which a report says if a reading is within its tolerance, in lower case.
const VERDICTS: [&str; 24] = [
    "ok", "nok", "ng", "pass", "fail", "passed", "failed", "good", "bad", "in", "out", "yes", "no", "true", "false",
    "i.o.", "n.i.o.", "io", "nio", "gut", "schlecht", "ja", "nein", "-",
];

/// Spread of numbers, as a share of the largest one, up to which they are one nominal value.
const ONE_VALUE: f64 = 0.01;

/// Distinct texts of a column without the empty ones, each with the line where it is first.
#[derive(Clone, Debug, Default)]
pub(crate) struct ColumnValues {
    /// Texts and lines in the order of the rows, at most [`MOST_VALUES`].
    pub(crate) distinct: Vec<(String, usize)>,
    /// Number of cells with a text.
    filled: usize,
    /// True if there are more distinct texts.
    is_cut: bool,
    /// True if all of them are numbers or times.
    is_numeric: bool,
    /// True if all of them are numbers that differ by no more than their noise.
    is_one_number: bool,
}

impl ColumnValues {
    /// The values of a column of a table.
    pub(crate) fn of(table: &GridTable, column: usize) -> ColumnValues {
        let mut found = ColumnValues { is_numeric: true, ..ColumnValues::default() };
        let [mut low, mut high] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut are_numbers = true;
        for row in &table.rows {
            let Some(text) = row.cells.get(column).map(|cell| cell.text.trim()).filter(|text| !text.is_empty()) else {
                continue;
            };
            found.filled += 1;
            match number(text, table.decimal) {
                Some(value) => [low, high] = [low.min(value), high.max(value)],
                None => are_numbers = false,
            }
            // Dates and times of day are no words.
            found.is_numeric &= text.starts_with(|c: char| c.is_ascii_digit() || "+-.,\u{2212}".contains(c))
                && text.chars().any(|c| c.is_ascii_digit());
            let text = text.to_lowercase();
            if found.distinct.iter().all(|(own, _)| *own != text) {
                if found.distinct.len() < MOST_VALUES {
                    found.distinct.push((text, row.number));
                } else {
                    found.is_cut = true;
                }
            }
        }
        found.is_one_number = are_numbers && high - low <= ONE_VALUE * high.abs().max(low.abs());
        found
    }

    /// True if the rows differ in this column. A number for each row only counts the rows.
    pub(crate) fn differ(&self) -> bool {
        let is_numbering = self.is_numeric && !self.is_cut && self.distinct.len() == self.filled && self.filled > 2;
        self.distinct.len() > 1 && !self.is_one_number && !is_numbering
    }

    /// True if the cells are a few words that divide the rows into groups. Verdicts of a tolerance do not: they follow from the readings.
    pub(crate) fn are_groups(&self) -> bool {
        let are_verdicts = self.distinct.iter().all(|(text, _)| VERDICTS.contains(&text.as_str()));
        !self.is_numeric
            && !self.is_cut
            && !are_verdicts
            && self.distinct.len() > 1
            && 2 * self.distinct.len() <= self.filled
    }

    /// The one text of all rows with its first line; `None` if the rows differ, or if a cell is empty.
    pub(crate) fn only(&self, table: &GridTable) -> Option<(&str, usize)> {
        let (text, line) = self.distinct.first()?;
        ((self.distinct.len() == 1 || self.is_one_number) && self.filled == table.rows.len())
            .then_some((text.as_str(), *line))
    }

    /// Names the first values: `'xy' (line 5), 'yz' (line 77)`.
    pub(crate) fn named(&self) -> String {
        /// Most values that a sentence names.
        const MOST: usize = 3;
        let first = self.distinct.iter().take(MOST).map(|(text, line)| format!("'{text}' (line {line})"));
        let dots = if self.distinct.len() > MOST { " …" } else { "" };
        format!("{}{dots}", first.collect::<Vec<_>>().join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_state_facts_in_five_languages() {
        for (heading, expected) in [
            ("plane", RowFact::Plane),
            ("plane of the circle", RowFact::Plane),
            ("kreisebene", RowFact::Plane),
            ("piano di prova", RowFact::Plane),
            ("linear axis", RowFact::Axis),
            ("linearachse", RowFact::Axis),
            ("axe mesuré", RowFact::Axis),
            ("asse lineare", RowFact::Axis),
            ("eje lineal", RowFact::Axis),
            ("verfahrrichtung", RowFact::Direction),
            ("direction of approach", RowFact::Direction),
            ("sens de rotation", RowFact::Direction),
            ("bar length", RowFact::Bar),
            ("stablänge", RowFact::Bar),
            ("feed rate", RowFact::Feed),
            ("side of the table", RowFact::Place),
            ("set-up", RowFact::Place),
            ("length unit", RowFact::Unit),
            ("vorzeichen", RowFact::Sign),
        ] {
            assert_eq!(row_fact(heading), Some(expected), "{heading}");
        }
        for heading in
            ["x axis", "axis position", "dia", "humidity", "remark", "air pressure [bar]", "planid", "direction error"]
        {
            assert_eq!(row_fact(heading), None, "{heading}");
        }
    }
}
