//! Words that are in force when a program of a Sinumerik begins: MD20150 `$MC_GCODE_RESET_VALUES[n]` has the place of the word in group n + 1 of the G codes.
//!
//! Source: SINUMERIK 840D sl, Programming Manual Fundamentals, list of the G functions (the places in their groups).

/// Meaning of a word at the start for the machine file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ResetWord {
    /// The word that ncfix assumes.
    Usual,
    /// A key of `[control]`.
    Key(String),
    /// A word that no key states, with the word that ncfix assumes.
    Unknown(&'static str, &'static str),
}

/// Settable zero offsets from the second place on; later ones are G505, G506 …
const OFFSETS: [&str; 4] = ["G54", "G55", "G56", "G57"];

/// The word at a place, from 1, of element n of MD20150; `None` if its group changes no positions.
pub(super) fn reset_word(element: u32, place: u32) -> Option<ResetWord> {
    let index = usize::try_from(place).ok()?;
    Some(match (element, place) {
        (5 | 7 | 12 | 13 | 14, 0) | (5 | 7, 1) | (12 | 14, 2) | (13, 1) => ResetWord::Usual,
        (5, 2 | 3) => ResetWord::Key(format!("initial_plane = {}", 16 + place)),
        (7, _) => {
            let name =
                OFFSETS.get(index.checked_sub(2)?).map_or_else(|| format!("G{}", 499 + place), ToString::to_string);
            ResetWord::Key(format!("initial_zero_offset = \"{name}\""))
        }
        (12, 1) => ResetWord::Unknown("G70 (inches)", "G71"),
        (12, 3) => ResetWord::Unknown("G700 (inches)", "G71"),
        (12, 4) => ResetWord::Unknown("G710", "G71"),
        (13, 2) => ResetWord::Unknown("G91 (incremental)", "G90"),
        (14, 1) => ResetWord::Unknown("G93", "G94"),
        (14, 3) => ResetWord::Unknown("G95 (feed per turn)", "G94"),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_in_the_groups_become_keys() {
        let key = |element, place| match reset_word(element, place) {
            Some(ResetWord::Key(key)) => key,
            other => format!("{other:?}"),
        };
        assert_eq!(key(5, 2), "initial_plane = 18");
        assert_eq!(
            [key(7, 2), key(7, 5), key(7, 6)],
            ["initial_zero_offset = \"G54\"", "initial_zero_offset = \"G57\"", "initial_zero_offset = \"G505\""]
        );
        for usual in [(5, 1), (7, 1), (12, 2), (13, 1), (14, 2), (7, 0)] {
            assert_eq!(reset_word(usual.0, usual.1), Some(ResetWord::Usual), "{usual:?}");
        }
        assert!(matches!(reset_word(12, 1), Some(ResetWord::Unknown("G70 (inches)", "G71"))));
        assert_eq!(reset_word(9, 2), None);
    }
}
