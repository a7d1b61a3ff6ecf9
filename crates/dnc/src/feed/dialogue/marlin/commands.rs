//! Marlin executes the first command of a line and takes all further words as its parameters, also `G90` and `M5`.
//!
//! So each line of a program becomes commands of one line each, in the order in which RS274/NGC executes the words of a block. Motion codes are written
//! again, because a line that begins with an axis is an unknown command in most builds. Words that have another meaning in Marlin are converted, or
//! refused:
//!
//! | RS274/NGC | Marlin |
//! | --- | --- |
//! | `G4 P1.5`: 1.5 s | P is in milliseconds: `G4 S1.5` |
//! | `G91.1`, centers are relative | `G91` with a parameter: all positions would be relative. Centers are always relative, so nothing is sent |
//! | `G40`, `G49`, `G64`, `G80`, `G94`, `G98`, `G99` | states that Marlin always has: nothing is sent |
//! | `M2`, `M30`: end, spindle and coolant off | `M30` deletes a file: `M5`, `M9` are sent, if they were on |
//! | `S1000` without M3 or M4 | not a command: `M3 S1000` if the spindle turns, else with the next `M3` |
//! | `F300` alone | `G1 F300` |
//! | `T1`, `M6`, `G28`, `G10`, `G61` … | another extruder, homing, retraction, a saved position …: refused |
//!
//! Source: Marlin, `parser.cpp` (`GCodeParser::parse`), `gcode.cpp` (the list of commands), `G4.cpp`.

use crate::feed::rewriter::LineRewriter;

/// Codes of a state that Marlin always has, in tenths.
const ALWAYS: &[u32] = &[400, 490, 640, 800, 911, 940, 980, 990];
/// Codes of a state that are commands of their own with the same meaning, in tenths.
const STATES: &[u32] = &[170, 180, 190, 200, 210, 540, 550, 560, 570, 580, 590, 591, 592, 593, 900, 910];
/// Words that a motion may have.
const MOTION_WORDS: &[u8] = b"XYZABCUVWIJK";
/// Words that only an arc may have.
const ARC_WORDS: &[u8] = b"IJK";

/// The states that decide what a line becomes.
#[derive(Clone, Debug, Default)]
pub(super) struct MarlinCommands {
    /// Motion code in force, 0 to 3.
    motion: Option<u32>,
    /// Code of the turning spindle, 3 or 4.
    spindle: Option<u32>,
    has_coolant: bool,
    /// Last speed of the spindle, as the program writes it.
    speed: Option<String>,
}

/// Words of one line.
#[derive(Debug, Default)]
struct Block<'t> {
    /// G codes in tenths, M codes.
    g: Vec<u32>,
    m: Vec<u32>,
    feed: Option<&'t str>,
    speed: Option<&'t str>,
    /// All other words, in their order.
    words: Vec<&'t str>,
}

impl<'t> Block<'t> {
    fn read(text: &'t str) -> Result<Block<'t>, String> {
        let mut block = Block::default();
        for word in text.split_ascii_whitespace() {
            let (letter, value) = word.split_at_checked(1).unwrap_or((word, ""));
            let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
            let Some(number) = number else { return Err(no_command(word)) };
            let tenths = (number * 10.0).round();
            let is_code = tenths >= 0.0 && (number * 10.0 - tenths).abs() < 1e-6 && tenths < 1e5;
            match letter {
                // Block numbers have no effect.
                "N" => {}
                "G" if is_code => block.g.push(tenths as u32),
                "M" if is_code && tenths % 10.0 == 0.0 => block.m.push(tenths as u32 / 10),
                "F" => block.feed = Some(word),
                "S" => block.speed = Some(word),
                _ if letter.bytes().all(|byte| byte.is_ascii_uppercase()) && !matches!(letter, "G" | "M" | "T") => {
                    block.words.push(word);
                }
                _ => return Err(no_command(word)),
            }
        }
        Ok(block)
    }

    /// Takes a word with this letter out of the others.
    fn take(&mut self, letter: char) -> Option<&'t str> {
        let at = self.words.iter().position(|word| word.starts_with(letter))?;
        Some(self.words.remove(at))
    }
}

/// The reason why a word cannot be sent.
fn no_command(word: &str) -> String {
    let why = match word {
        "M6" => "Marlin has no tool change: feed a program for each tool".to_owned(),
        word if word.starts_with('T') => {
            "Marlin would select an extruder: feed a program for each tool, without T".to_owned()
        }
        _ => "Marlin does not execute it, or executes something else".to_owned(),
    };
    format!("{word}: {why}")
}

/// A code as it is written: `G59.1`.
fn code(letter: char, tenths: u32) -> String {
    match tenths % 10 {
        0 => format!("{letter}{}", tenths / 10),
        tenth => format!("{letter}{}.{tenth}", tenths / 10),
    }
}

impl MarlinCommands {
    fn commands(&mut self, text: &str) -> Result<Vec<String>, String> {
        let mut block = Block::read(text)?;
        let mut out = Vec::new();
        // A code of the firmware alone, such as M106: all words are its own.
        if let ([], &[own]) = (block.g.as_slice(), block.m.as_slice())
            && own >= 100
        {
            let words = block.words.iter().copied().chain(block.speed).chain(block.feed);
            out.push(
                std::iter::once(code('M', own * 10)).chain(words.map(str::to_owned)).collect::<Vec<_>>().join(" "),
            );
            return Ok(out);
        }
        self.spindle(&block, &mut out)?;
        self.coolant(&block, &mut out);
        let mut motion = None;
        for one in block.g.clone() {
            match one {
                0 | 10 | 20 | 30 => motion = Some(one / 10),
                40 | 920 => {}
                _ if STATES.contains(&one) => out.push(code('G', one)),
                640 => drop((block.take('P'), block.take('Q'))),
                _ if ALWAYS.contains(&one) => {}
                _ => return Err(no_command(&code('G', one))),
            }
        }
        if block.g.contains(&40) {
            let seconds = block.take('P').ok_or("G4 has no time P")?;
            out.push(format!("G4 S{}", &seconds[1..]));
        }
        if block.g.contains(&920) {
            let words = std::mem::take(&mut block.words);
            out.push(std::iter::once("G92").chain(words).collect::<Vec<_>>().join(" "));
        }
        self.motion(motion, &block.words, block.feed, &mut out)?;
        for one in &block.m {
            match one {
                0 | 1 => out.push(code('M', one * 10)),
                2 | 30 => self.end(&mut out),
                _ => {}
            }
        }
        Ok(out)
    }

    fn spindle(&mut self, block: &Block<'_>, out: &mut Vec<String>) -> Result<(), String> {
        if let Some(speed) = block.speed {
            self.speed = Some(speed.to_owned());
        }
        let mut is_new = block.speed.is_some();
        for &one in &block.m {
            match one {
                3 | 4 => (self.spindle, is_new) = (Some(one), true),
                5 => {
                    (self.spindle, is_new) = (None, false);
                    out.push("M5".to_owned());
                }
                0 | 1 | 2 | 7 | 8 | 9 | 30 => {}
                _ => return Err(no_command(&code('M', one * 10))),
            }
        }
        if let (Some(turns), true) = (self.spindle, is_new) {
            let speed = self.speed.as_deref().map_or(String::new(), |speed| format!(" {speed}"));
            out.push(format!("M{turns}{speed}"));
        }
        Ok(())
    }

    fn coolant(&mut self, block: &Block<'_>, out: &mut Vec<String>) {
        for &one in block.m.iter().filter(|one| matches!(one, 7..=9)) {
            self.has_coolant = one != 9;
            out.push(code('M', one * 10));
        }
    }

    fn motion(
        &mut self,
        stated: Option<u32>,
        words: &[&str],
        feed: Option<&str>,
        out: &mut Vec<String>,
    ) -> Result<(), String> {
        let moves = words.iter().any(|word| MOTION_WORDS.contains(&word.as_bytes()[0]));
        self.motion = stated.or(self.motion);
        // The feed of a line without motion: a straight move to nowhere.
        let mode = if moves { self.motion } else { Some(1) };
        if !moves && feed.is_none() && words.is_empty() {
            return Ok(());
        }
        let mode = mode.ok_or("the motion code in force is not known")?;
        let is_arc = mode >= 2;
        for word in words {
            let letter = word.as_bytes()[0];
            // P is the number of turns; Marlin adds that many. One turn is the arc itself.
            let is_one_turn = is_arc && letter == b'P' && word[1..].parse::<f64>() == Ok(1.0);
            let is_own = MOTION_WORDS.contains(&letter) && (is_arc || !ARC_WORDS.contains(&letter));
            if !is_own && !is_one_turn {
                return Err(no_command(word));
            }
        }
        let words = words.iter().copied().filter(|word| !word.starts_with('P')).chain(feed);
        out.push(std::iter::once(format!("G{mode}")).chain(words.map(str::to_owned)).collect::<Vec<_>>().join(" "));
        Ok(())
    }

    /// The end of a program stops spindle and coolant.
    fn end(&mut self, out: &mut Vec<String>) {
        if self.spindle.take().is_some() {
            out.push("M5".to_owned());
        }
        if std::mem::take(&mut self.has_coolant) {
            out.push("M9".to_owned());
        }
    }
}

impl LineRewriter for MarlinCommands {
    fn rewrite(&mut self, text: &[u8]) -> Result<Vec<Vec<u8>>, String> {
        let text = std::str::from_utf8(text).map_err(|_| "it has characters that Marlin does not read".to_owned())?;
        Ok(self.commands(text)?.into_iter().map(String::into_bytes).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(lines: &[&str]) -> Vec<String> {
        let mut state = MarlinCommands::default();
        lines.iter().flat_map(|line| state.commands(line).unwrap_or_else(|why| panic!("{line}: {why}"))).collect()
    }

    #[test]
    fn a_line_becomes_commands_of_one_line_each() {
        assert_eq!(all(&["G21 G90 G91.1 G40"]), ["G21", "G90"]);
        assert_eq!(all(&["N10 G21 G90 G17 G54 G94"]), ["G21", "G90", "G17", "G54"]);
        assert_eq!(
            all(&["G0 X1 Y2", "Z3", "G1 Z-1 F300", "X5", "F200", "Y6"]),
            ["G0 X1 Y2", "G0 Z3", "G1 Z-1 F300", "G1 X5", "G1 F200", "G1 Y6"]
        );
        // The feed of a rapid block does not change the motion code in force.
        assert_eq!(all(&["G0 X1", "F200", "X2"]), ["G0 X1", "G1 F200", "G0 X2"]);
        assert_eq!(all(&["G2 X1 Y2 I3 J4 P1 F9", "X5 Y6 I7 J8"]), ["G2 X1 Y2 I3 J4 F9", "G2 X5 Y6 I7 J8"]);
        assert_eq!(all(&["G64 P0.02", "G4 P1.5", "G92 X0 Y0"]), ["G4 S1.5", "G92 X0 Y0"]);
        assert_eq!(all(&["M106 P1 S255"]), ["M106 P1 S255"]);
    }

    #[test]
    fn spindle_and_coolant_are_off_at_the_end() {
        assert_eq!(
            all(&["S500", "M3", "S600", "M8", "G0 Z9 M5", "S700", "M2"]),
            ["M3 S500", "M3 S600", "M8", "M5", "G0 Z9", "M9"]
        );
        assert_eq!(all(&["S500 M4", "M8", "M30"]), ["M4 S500", "M8", "M5", "M9"]);
        assert_eq!(all(&["M30"]), [""; 0]);
    }

    #[test]
    fn what_marlin_would_do_differently_is_refused() {
        for line in [
            "T1",
            "T1 M6",
            "M6",
            "G28",
            "G28 X0",
            "G10 L2 P1 X0",
            "G61",
            "G53 G0 Z0",
            "G93",
            "G43 H1",
            "G38.2 Z-5",
            "G91.2",
            "G2 X1 Y2 I3 J4 P2",
            "G2 X1 Y2 R5",
            "X5",
            "M62 P1",
            "M98",
            "O100 CALL",
            "G1 X[1+2]",
            "G5 X1 I2",
            "G1 X1 I2",
            "M3.1",
            "G92.1",
            "G4",
            "M106 M107",
        ] {
            assert!(MarlinCommands::default().commands(line).is_err(), "{line}");
        }
    }
}
