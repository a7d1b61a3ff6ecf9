//! Temperature and expansion of a scale or a workpiece, as the lines before a table state them.

use ncfix_base::csv::DecimalSign;

use crate::grid;
use crate::text::DecodedText;

/// Words of the body whose temperature an instrument states.
const BODIES: &[&str] =
    &["material", "scale", "workpiece", "werkst", "maßstab", "massstab", "matière", "pièce", "pezzo"];
/// Words of its expansion.
const EXPANSIONS: &[&str] = &["expansion", "ausdehnung", "dilatation", "dilatazione", "dilatación"];

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
    fn temperature_and_expansion_are_read_in_either_notation() {
        let text = "Materialtemperatur (°C);21,4\nLufttemperatur (°C);25\nExpansion coefficient: 11.7 ppm/K\n";
        let text = DecodedText::of_text("a.csv", text, "UTF-8").unwrap();
        assert_eq!(temperatures(&text), [(21.4, 1)]);
        assert_eq!(expansions(&text), [(11.7, 3)]);
    }
}
