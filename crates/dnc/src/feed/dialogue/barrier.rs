//! Decides when the sender waits until the control has stopped, because only then the executed lines are certain.
//!
//! A later line hides an earlier one that was accepted and not executed, if it commands the same axes. And if only the count of answers says which lines were
//! taken, one answer too many shifts all later ones. So the sender waits now and then until all moves are done, and compares the position. It waits only after
//! rapid moves: a stop on a contour leaves a mark.

/// Minimum number of lines between two stops: few enough to repeat little, enough to cost no noticeable time.
const EVERY: u64 = 50;
/// Motion codes other than rapid, whole numbers.
const CUTS: &[u32] = &[1, 2, 3, 5, 33, 38, 73, 76, 81, 82, 83, 84, 85, 86, 87, 88, 89];

/// Counts lines and follows the motion mode in force.
#[derive(Debug, Default)]
pub(super) struct Barrier {
    lines: u64,
    is_rapid: bool,
}

impl Barrier {
    /// Notes a line that is sent. Returns true if a stop is due after it.
    pub(super) fn sent(&mut self, text: &[u8]) -> bool {
        let (mut moves, mut rest) = (false, text);
        while let Some((&letter, behind)) = rest.split_first() {
            let end = behind.iter().position(|byte| byte.is_ascii_alphabetic()).unwrap_or(behind.len());
            let (value, next) = behind.split_at(end);
            rest = next;
            let whole = value.split(|byte| b". \t".contains(byte)).next().unwrap_or_default();
            match letter.to_ascii_uppercase() {
                b'G' => {
                    if let Ok(number) = String::from_utf8_lossy(whole).parse::<u32>() {
                        self.is_rapid = number == 0 || self.is_rapid && !CUTS.contains(&number);
                    }
                }
                b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => moves = true,
                _ => {}
            }
        }
        self.lines += 1;
        moves && self.is_rapid && self.lines >= EVERY
    }

    /// Notes that the control has reported what it has executed.
    pub(super) fn is_over(&mut self) {
        self.lines = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_is_due_behind_rapid_moves_and_nowhere_else() {
        let due = |lines: &[&str]| {
            let mut barrier = Barrier { lines: EVERY, is_rapid: false };
            lines.iter().fold(false, |_, line| barrier.sent(line.as_bytes()))
        };
        for lines in [&["G0 X1"][..], &["G00Z5."], &["G90 G0 X1"], &["G0 X1", "X2 Y3"], &["N10 G0 Z30", "G54 X1"]] {
            assert!(due(lines), "{lines:?}");
        }
        for lines in [
            &["G1 X1"][..],
            &["G0 X1", "G1 X2"],
            &["G0 X1", "G2 X2 I1"],
            &["G0 X1", "M5"],
            &["G0"],
            &["X1"],
            &["G0 X1", "G38.2 Z-5"],
        ] {
            assert!(!due(lines), "{lines:?}");
        }
        let mut barrier = Barrier::default();
        let first = (1..200).find(|_| barrier.sent(b"G0 X1"));
        assert_eq!(first, Some(50));
        barrier.is_over();
        assert!(!barrier.sent(b"G0 X1"));
    }
}
