//! Facts that lines of a file state in any layout: unit, and temperature and expansion of a scale or a workpiece.

use ncfix_base::csv::DecimalSign;

use crate::grid;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Words of the body whose temperature an instrument states.
const BODIES: &[&str] =
    &["material", "scale", "workpiece", "werkst", "maßstab", "massstab", "matière", "pièce", "pezzo"];
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
    fn temperature_and_expansion_are_read_in_either_notation() {
        let text = "Materialtemperatur (°C);21,4\nLufttemperatur (°C);25\nExpansion coefficient: 11.7 ppm/K\n";
        let text = DecodedText::of_text("a.csv", text, "UTF-8").unwrap();
        assert_eq!(temperatures(&text), [(21.4, 1)]);
        assert_eq!(expansions(&text), [(11.7, 3)]);
    }
}
