//! Words of a line that matter to MDI of LinuxCNC: O-words, stops, ends, the spindle.

/// G codes of other controls that programs for LinuxCNC may have by mistake.
const FOREIGN: [u32; 6] = [50, 51, 68, 69, 70, 71];

/// Relevant words of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Words {
    pub(super) is_empty: bool,
    pub(super) has_o: bool,
    /// M0, M1 or M60.
    pub(super) stops: bool,
    /// M2 or M30.
    pub(super) ends: bool,
    /// M3 or M4.
    pub(super) starts_spindle: bool,
    /// Any M code other than those and the coolant: it may stop the spindle.
    pub(super) has_other_m: bool,
    /// G code of another control that LinuxCNC 2.9 does not have: the unit by G70 or G71, scaling, rotation.
    pub(super) foreign: Option<u32>,
}

/// Reads letters and the numbers after them, outside comments.
pub(super) fn words(text: &[u8]) -> Words {
    let mut words = Words { is_empty: true, ..Words::default() };
    let (mut letter, mut number, mut is_comment, mut is_first) = (0, String::new(), false, true);
    let mut take = |letter: u8, number: &str, words: &mut Words| match (letter, number.parse::<f64>().ok()) {
        // Before any other word; later it would be part of a name.
        (b'N' | b'/' | 0, _) => {}
        _ if std::mem::take(&mut is_first) && letter == b'O' => words.has_o = true,
        (b'M', Some(value)) if [0.0, 1.0, 60.0].contains(&value) => words.stops = true,
        (b'M', Some(value)) if [2.0, 30.0].contains(&value) => words.ends = true,
        (b'M', Some(value)) if [3.0, 4.0].contains(&value) => words.starts_spindle = true,
        // The coolant does not affect the spindle.
        (b'M', Some(value)) if [7.0, 8.0, 9.0].contains(&value) => {}
        (b'M', _) => words.has_other_m = true,
        (b'G', Some(value)) => {
            words.foreign = words.foreign.or(FOREIGN.into_iter().find(|code| f64::from(*code) == value));
        }
        _ => {}
    };
    for byte in text.iter().map(u8::to_ascii_uppercase) {
        match byte {
            _ if is_comment => is_comment = byte != b')',
            b'(' => is_comment = true,
            b';' => break,
            b' ' | b'\t' => {}
            b'0'..=b'9' | b'.' | b'+' | b'-' => number.push(char::from(byte)),
            _ => {
                take(letter, &number, &mut words);
                (letter, number) = (byte, String::new());
            }
        }
        words.is_empty = words.is_empty && byte == b' ';
    }
    take(letter, &number, &mut words);
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_read_outside_of_comments() {
        let of = |text: &str| words(text.as_bytes());
        assert_eq!(of("G1 X1 (M30 O1) Y2 ; M0"), Words::default());
        assert!(of("  ").is_empty && of("").is_empty && !of("(a)").is_empty);
        assert!(of("N10 O100 CALL").has_o && of("o<sub> call").has_o && !of("G1 X[10*COS[30]]").has_o);
        assert!(of("M 00").stops && of("G0 X1 m1").stops && of("M60").stops && !of("M6").stops && !of("G1 X60").stops);
        assert!(of("M02").ends && of("m30").ends && !of("M3").ends);
        assert!(of("S500 M3").starts_spindle && of("M4S1").starts_spindle && of("M5").has_other_m);
        assert_eq!(["G71", "g 70 X1", "G17", "G1 X71"].map(|text| of(text).foreign), [Some(71), Some(70), None, None]);
        assert!(!of("M8").has_other_m && of("M8 M5").has_other_m && of("M19").has_other_m);
    }
}
