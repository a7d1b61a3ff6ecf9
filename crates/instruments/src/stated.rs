//! Facts that lines of a file state in any layout: unit, temperature and expansion of a scale or a workpiece, and whether readings refer to 20 °C.

use ncfix_base::csv::DecimalSign;

use crate::grid;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Words of the body whose temperature an instrument states.
const BODIES: &[&str] = &[
    "material",
    "scale",
    "workpiece",
    "werkst",
    "maßstab",
    "massstab",
    "matière",
    "pièce",
    "pezzo",
    "ball-bar",
    "ballbar",
    "ball bar",
    "kugelstab",
];
/// Words of its expansion.
const EXPANSIONS: &[&str] = &["expansion", "ausdehnung", "dilatation", "dilatazione", "dilatación"];

/// Keys of lines with the unit of the readings.
const UNITS: &[&str] = &[
    "unit",
    "units",
    "einheit",
    "einheiten",
    "unité",
    "unités",
    "unità",
    "unidad",
    "unidades",
    "deviation unit",
    "error unit",
    "length unit",
    "measurement unit",
    "unit of measure",
    "messeinheit",
    "maßeinheit",
    "längeneinheit",
];
/// Values of such lines that name no unit.
const SYSTEMS: &[&str] = &["metric", "metrisch", "métrique", "si"];

/// Units of lines such as `Unit;inch` or `# units: mm`, with their lines.
///
/// # Errors
/// The word and its line if a line states a unit that is not known.
pub(crate) fn units(text: &DecodedText) -> Result<Vec<(ReadingUnit, usize)>, (String, usize)> {
    let mut found = Vec::new();
    for (number, line, _) in text.lines() {
        let line = line.trim_start_matches(['#', '/', '!', '(', ';', ' ', '"']).to_lowercase();
        let Some((key, value)) = line.split_once([';', ':', '=', '\t', ',']) else { continue };
        if !UNITS.contains(&key.trim().trim_matches('"')) {
            continue;
        }
        let value = value.trim_matches([';', ',', '\t', '"', ' ', '[', ']', '(', ')']);
        // A line of headings may begin with the same word.
        let is_word =
            !value.is_empty() && value.len() <= 16 && value.chars().all(|c| c.is_alphabetic() || "°/'\"″".contains(c));
        match ReadingUnit::find(value) {
            Some(unit) => found.push((unit, number)),
            None if is_word && !SYSTEMS.contains(&value) => return Err((value.to_owned(), number)),
            None => {}
        }
    }
    Ok(found)
}

/// Temperatures of a material, °C, with their lines.
pub(crate) fn temperatures(text: &DecodedText) -> Vec<(f64, usize)> {
    let is_key = |key: &str| key.contains("temp") && BODIES.iter().any(|word| key.contains(word));
    let celsius = |key: &str, value: f64| if key.contains("°f") { (value - 32.0) / 1.8 } else { value };
    pairs(text).filter(|(key, ..)| is_key(key)).map(|(key, value, line)| (celsius(&key, value), line)).collect()
}

/// Coefficients of expansion, µm/m per K, with their lines.
pub(crate) fn expansions(text: &DecodedText) -> Vec<(f64, usize)> {
    let is_key = |key: &str| EXPANSIONS.iter().any(|word| key.contains(word)) && !key.contains("°f");
    pairs(text).filter(|(key, ..)| is_key(key)).map(|(_, value, line)| (value, line)).collect()
}

/// Words of a conversion of readings to 20 °C.
const CONVERSIONS: &[&str] =
    &["compens", "kompens", "normali", "refer", "corrected", "korrigiert", "bezogen", "corrig", "corregid"];
/// Words of what is converted, beside the temperature 20; the air of a laser beam has a compensation too.
const CONVERTED: &[&str] =
    &["material", "expansion", "ausdehnung", "dilat", "scale", "workpiece", "werkst", "thermal", "thermi", "termic"];
const AIR: &[&str] = &["air", "luft", "environment", "umwelt", "wavelength", "refract", "beam"];
/// Answers of such lines.
const YES: &[&str] =
    &["yes", "on", "true", "ja", "ein", "an", "oui", "si", "sì", "sí", "enabled", "active", "aktiv", "applied", "1"];
const NO: &[&str] =
    &["no", "off", "false", "nein", "aus", "non", "disabled", "inactive", "inaktiv", "none", "not applied", "0"];

/// Statements whether the readings were converted to 20 °C with the temperature of the material, with their lines: `Compensated to 20 C: Yes`.
pub(crate) fn conversions(text: &DecodedText) -> Vec<(bool, usize)> {
    let mut found = Vec::new();
    for (number, line, _) in text.lines() {
        let line = line.trim_start_matches(['#', '/', '!', '(', ';', ' ', '"']).to_lowercase();
        let Some((key, value)) = line.split_once([';', ':', '=', '\t', ',']) else { continue };
        let has = |words: &[&str]| words.iter().any(|word| key.contains(word));
        let is_at_20 = key.split(|c: char| !c.is_ascii_digit()).any(|digits| digits == "20");
        if !has(CONVERSIONS) || has(AIR) || !(is_at_20 || has(CONVERTED)) {
            continue;
        }
        // `On (20 °C)`: the temperature is that of the reference.
        let value = value.split('(').next().unwrap_or_default().trim_matches([';', ',', '\t', '"', ' ', '.', ')']);
        if YES.contains(&value) {
            found.push((true, number));
        } else if NO.contains(&value) {
            found.push((false, number));
        }
    }
    found
}

/// Lines with a key and a number, in lower case.
fn pairs(text: &DecodedText) -> impl Iterator<Item = (String, f64, usize)> {
    text.lines().filter_map(|(number, line, _)| {
        let (key, value) = line.split_once([';', ':', '=', '\t', ','])?;
        let value = value.trim().trim_matches([';', ',', '"', ' ']);
        let value = value.split_whitespace().next()?;
        let value = grid::number(value, DecimalSign::Point).or_else(|| grid::number(value, DecimalSign::Comma))?;
        Some((key.to_lowercase(), value, number))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_state_a_unit() {
        let of = |text: &str| units(&DecodedText::of_text("a.csv", text, "UTF-8").unwrap());
        assert_eq!(of("Unit,inch\nX,Y\n").unwrap(), [(ReadingUnit::find("inch").unwrap(), 1)]);
        assert_eq!(of("# units: mm\n").unwrap(), [(ReadingUnit::find("mm").unwrap(), 1)]);
        assert_eq!(of("Unit;target;dev\num;0;1\nUnits;3\nunits: metric\n").unwrap(), []);
        assert_eq!(of("x\nEinheit;Elle\n").unwrap_err(), ("elle".to_owned(), 2));
    }

    #[test]
    fn lines_state_whether_readings_refer_to_20_degrees() {
        let of = |text: &str| conversions(&DecodedText::of_text("a.csv", text, "UTF-8").unwrap());
        assert_eq!(of("Axis;X\nCompensated to 20 C: Yes\n"), [(true, 2)]);
        assert_eq!(
            of("Material compensation;OFF\n# thermal expansion compensation = enabled\n"),
            [(false, 1), (true, 2)]
        );
        assert_eq!(of("Auf 20 °C kompensiert: nein\nReadings referred to 20 °C,no\n"), [(false, 1), (false, 2)]);
        // The beam of the laser, the table of the control, and a number.
        assert_eq!(of("Air temperature compensation: On\nCompensation: On\nCompensated to 20 C: 3.5\n"), []);
    }

    #[test]
    fn temperature_and_expansion_are_read_in_either_notation() {
        let text = "Materialtemperatur (°C);21,4\nLufttemperatur (°C);25\nExpansion coefficient: 11.7 ppm/K\n";
        let text = DecodedText::of_text("a.csv", text, "UTF-8").unwrap();
        assert_eq!(temperatures(&text), [(21.4, 1)]);
        assert_eq!(expansions(&text), [(11.7, 3)]);
    }
}
