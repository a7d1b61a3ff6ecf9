//! The settings of a program before its first move: how its numbers are interpreted.

use ncfix_base::source::Source;
use ncfix_machine::snc::{Element, Kind};

/// Groups of words that exclude each other. Without a word of a group, the setting of the previous program remains in
/// force.
const GROUPS: [&[&str]; 6] = [
    &["G20", "G21", "G70", "G71", "G700", "G710"],
    &["G90", "G91"],
    &["G90.1", "G91.1"],
    &["G40", "G41", "G42", "G41.1", "G42.1"],
    &["G17", "G18", "G19"],
    &["G93", "G94", "G95"],
];

/// The words of a program up to its first move.
#[derive(Debug, Default)]
pub(crate) struct Header {
    words: Vec<&'static str>,
    /// The line of its first move.
    moves_in: Option<u32>,
}

impl Header {
    pub(crate) fn see(&mut self, element: &Element) {
        match element.kind {
            _ if self.moves_in.is_some() => {}
            Kind::Move(_) => self.moves_in = Some(element.origin.line),
            Kind::Keep(word) => self.words.push(word),
            _ => {}
        }
    }

    /// Words that this header, of the corrected program, lacks: for each group without a word here, the one that the
    /// writer assumes or that the original states.
    pub(crate) fn lacks(&self, original: &Header, assumed: &'static str, corrected: &Source) -> Vec<&'static str> {
        let Some(last) = self.moves_in else { return Vec::new() };
        let lines = corrected.bytes().split(|&byte| byte == corrected.line_end()).take(last as usize);
        let written: Vec<String> = lines.flat_map(codes).collect();
        let assumed: Vec<&'static str> = assumed.split(' ').collect();
        let lacks = |group: &&[&'static str]| {
            let stated = |words: &[&'static str]| words.iter().copied().find(|word| group.contains(word));
            let wanted = stated(&assumed).or_else(|| stated(&original.words))?;
            let is_there = written.iter().any(|word| group.contains(&word.as_str())) || stated(&self.words).is_some();
            (!is_there).then_some(wanted)
        };
        GROUPS.iter().filter_map(lacks).collect()
    }
}

/// The G words of a line outside of its comments.
fn codes(line: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(line).to_ascii_uppercase();
    let mut out = Vec::new();
    let mut rest = text.as_str();
    while let Some(at) = rest.find(['G', '(', ';']) {
        let (sign, behind) = (rest.as_bytes()[at], &rest[at + 1..]);
        match sign {
            b';' => break,
            b'(' => rest = behind.split_once(')').map_or("", |(_, behind)| behind),
            _ => {
                let length = behind.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
                let number = behind[..length].trim_start_matches('0');
                out.push(format!("G{number}"));
                rest = &behind[length..];
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::codes;

    #[test]
    fn codes_are_found_however_they_are_written() {
        assert_eq!(codes(b"N10 G17G090 g71 (G20) X1 G91.1;G40"), ["G17", "G90", "G71", "G91.1"]);
        assert!(codes(b"(G20").is_empty());
    }
}
