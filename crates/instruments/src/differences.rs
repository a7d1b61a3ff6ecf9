//! Differences of two known words: `actual - target`, `Soll-Ist`. They decide the sign of a positioning.

/// Words of the position that was reached: English, German, French, Italian, Spanish.
const ACTUAL: &[&str] = &[
    "actual",
    "measured",
    "reached",
    "ist",
    "istwert",
    "istposition",
    "istmaß",
    "istmass",
    "messwert",
    "gemessen",
    "mesuré",
    "mesurée",
    "mesure",
    "réel",
    "réelle",
    "reel",
    "reelle",
    "atteinte",
    "reale",
    "misurato",
    "misurata",
    "misura",
    "effettivo",
    "effettiva",
    "raggiunta",
    "real",
    "medido",
    "medida",
    "alcanzada",
];
/// Words of the position that was commanded.
const NOMINAL: &[&str] = &[
    "target",
    "nominal",
    "command",
    "commanded",
    "setpoint",
    "theoretical",
    "soll",
    "sollwert",
    "sollposition",
    "sollmaß",
    "sollmass",
    "nennwert",
    "ziel",
    "zielposition",
    "cible",
    "consigne",
    "nominale",
    "commandée",
    "théorique",
    "teorico",
    "teorica",
    "comandata",
    "quota",
    "teórico",
    "teórica",
    "objetivo",
    "consigna",
    "programada",
    "programado",
];
/// Words between the name of a position and the minus sign.
const QUALIFIERS: &[&str] = &[
    "position",
    "pos",
    "value",
    "length",
    "the",
    "wert",
    "position",
    "valeur",
    "la",
    "le",
    "valore",
    "posizione",
    "il",
    "valor",
    "posición",
    "posicion",
    "el",
    "o",
    "axis",
    "achse",
];
/// Words that say of two values that they are compared, without a sign: `Soll-Ist-Vergleich`.
const COMPARED: &[&str] = &["vergleich", "comparison", "comparaison", "confronto", "comparación", "comparacion"];

/// Sign of a difference in words: 1 for `actual - target`, -1 for `Soll-Ist`; `None` without such a difference.
pub(crate) fn difference(text: &str) -> Option<f64> {
    if !text.chars().any(char::is_alphabetic) || !text.contains(['-', '\u{2212}', '\u{2013}', 'm', 'M']) {
        return None;
    }
    let mut text = text.to_lowercase().replace(['\u{2212}', '\u{2013}'], "-");
    for word in [" minus ", " moins ", " meno ", " menos "] {
        text = text.replace(word, "-");
    }
    let words = |part: &str| -> Vec<String> {
        part.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
    };
    let parts: Vec<Vec<String>> = text.split('-').map(words).collect();
    parts.windows(2).enumerate().find_map(|(at, pair)| {
        let is_compared =
            pair[1].iter().chain(parts.get(at + 2).into_iter().flatten()).any(|word| COMPARED.contains(&word.as_str()));
        let side = |known: &[&str]| [is_of(known, pair[0].iter().rev()), is_of(known, pair[1].iter())];
        match (side(ACTUAL), side(NOMINAL)) {
            _ if is_compared => None,
            ([true, false], [false, true]) => Some(1.0),
            ([false, true], [true, false]) => Some(-1.0),
            _ => None,
        }
    })
}

/// True if the first word that is no qualifier is one of the known ones.
fn is_of<'w>(known: &[&str], mut words: impl Iterator<Item = &'w String>) -> bool {
    let first = words.find(|word| !QUALIFIERS.contains(&word.as_str()));
    first.is_some_and(|word| known.contains(&word.as_str()))
}

/// A heading in lower case without the words of a difference: `deviation target-actual 1+` is `deviation 1+`.
pub(crate) fn without_difference(words: &str) -> String {
    let is_word = |part: &str| {
        let own: Vec<&str> = part.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).collect();
        let is_sign = part.chars().all(|c| "-\u{2212}\u{2013}".contains(c))
            || matches!(part, "minus" | "moins" | "meno" | "menos");
        is_sign || !own.is_empty() && own.iter().all(|word| ACTUAL.contains(word) || NOMINAL.contains(word))
    };
    let (before, after) = match words.rfind(|c: char| c.is_ascii_digit()) {
        // The sign after the number of a run is its direction.
        Some(at) => words.split_at(at),
        None => (words, ""),
    };
    let kept: Vec<&str> = before
        .split([' ', '(', ')', '[', ']', ',', ':', '_'])
        .filter(|part| !part.is_empty() && !is_word(part))
        .collect();
    format!("{} {}", kept.join(" "), after.trim_end_matches([')', ']'])).trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_has_a_sign_in_five_languages() {
        for (text, sign) in [
            ("Sign convention;target - actual", -1.0),
            ("Vorzeichen;Soll-Ist", -1.0),
            ("Vorzeichen: Istwert \u{2013} Sollwert", 1.0),
            ("actual minus nominal", 1.0),
            ("target position - actual position", -1.0),
            ("Signe;position mesurée - consigne", 1.0),
            ("écart = cible moins mesure", -1.0),
            ("Segno;nominale meno reale", -1.0),
            ("Signo;real - objetivo", 1.0),
            ("Deviation target-actual 1+ (um)", -1.0),
        ] {
            assert_eq!(difference(text), Some(sign), "{text}");
        }
        for text in ["Soll-Ist-Vergleich", "x-axis", "-3.5;-2", "set-up", "2026-11-30", "Target;Actual", "actual value"]
        {
            assert_eq!(difference(text), None, "{text}");
        }
    }

    #[test]
    fn a_heading_is_read_without_its_difference() {
        for (heading, expected) in [
            ("deviation target-actual 1+", "deviation 1+"),
            ("deviation (actual - target)", "deviation"),
            ("abweichung soll-ist", "abweichung"),
            ("soll-ist 2-", "2-"),
        ] {
            assert_eq!(without_difference(heading), expected, "{heading}");
        }
    }
}
