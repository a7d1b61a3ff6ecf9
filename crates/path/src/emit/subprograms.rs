//! Sections of a flat program as subprograms.
//!
//! The text of the flat program runs through calls in its own order, so nothing changes for the control: a call changes no modal state in any of these
//! languages. Sections with the same text become one subprogram, which is called as often as they ran.

use std::collections::{BTreeSet, HashMap};

use super::growth::lines_with_words;
use super::sections::{MarkedLine, lines};
use super::stamp::is_stamped;

/// Lines with words below which a section stays in the main program: the call needs a line too.
const LEAST_LINES: u64 = 3;
/// Maximum number of subprograms of a program.
const MOST: u32 = 999;

/// Notation of subprograms in a language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SubprogramStyle {
    /// A file for each one beside the main program, called by its name, until RET. Unlike M17, RET does not interrupt a path with G64.
    Sinumerik,
    /// `O7001` after the main program, called with M98, until M99.
    Fanuc,
    /// `N70001` after the main program, called with M97, until M99: its number is of this program alone.
    Haas,
    /// `o<name> sub` before the first call.
    Rs274,
    /// `%MM9501` after the main program, called with G22.
    Grundig,
}

/// Names of the subprograms of one program.
#[derive(Clone, Debug)]
pub struct SubprogramNames {
    style: SubprogramStyle,
    /// The beginning of a name; empty for a number.
    stem: String,
    first: u32,
    /// Names of other programs, in capitals.
    taken: BTreeSet<String>,
    used: u32,
}

/// A main program and its subprograms.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct FoldedProgram {
    /// The main program, with the subprograms that can be in the same file.
    pub main: Vec<u8>,
    /// Names and texts of the subprograms that need files beside it.
    pub beside: Vec<(String, Vec<u8>)>,
    /// Names of all subprograms.
    pub names: Vec<String>,
    /// Calls of subprograms.
    pub calls: u64,
    /// Lines with words in all texts.
    pub blocks: u64,
}

impl SubprogramNames {
    /// Names from the name of the output file, or numbers from `first`; 0 for the usual ones.
    #[must_use]
    pub fn new(style: SubprogramStyle, file_stem: &str, first: u32) -> SubprogramNames {
        /// Names of Sinumerik have at most 24 characters (840D sl), four of them for the number.
        const LONGEST: usize = 20;
        let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let (stem, usual) = match style {
            SubprogramStyle::Sinumerik => {
                let name: String = file_stem.chars().map(|c| if is_plain(c) { c } else { '_' }).collect();
                // A name begins with two letters.
                let is_name = name.len() > 1 && name.bytes().take(2).all(|byte| byte.is_ascii_alphabetic());
                let name = if is_name { name } else { format!("SP_{name}") };
                (name.to_ascii_uppercase().chars().take(LONGEST).chain(['_']).collect(), 1)
            }
            SubprogramStyle::Rs274 => ("NCFIX_".to_owned(), 1),
            SubprogramStyle::Fanuc => (String::new(), 7001),
            SubprogramStyle::Haas => (String::new(), 70001),
            SubprogramStyle::Grundig => (String::new(), 9501),
        };
        let first = if first == 0 { usual } else { first };
        SubprogramNames { style, stem, first, taken: BTreeSet::new(), used: 0 }
    }

    /// Leaves out every name or number that occurs in a text: a program could mean it.
    pub fn avoid(&mut self, text: &[u8]) {
        let is_number = self.stem.is_empty();
        let is_part =
            |byte: &u8| if is_number { byte.is_ascii_digit() } else { byte.is_ascii_alphanumeric() || *byte == b'_' };
        for word in text.split(|byte| !is_part(byte)) {
            let Ok(word) = std::str::from_utf8(word) else { continue };
            let word = if is_number { word.trim_start_matches('0').to_owned() } else { word.to_ascii_uppercase() };
            if self.may_be(&word) {
                self.taken.insert(word);
            }
        }
    }

    /// Leaves out the numbers that are in use.
    pub fn avoid_numbers(&mut self, is_used: impl Fn(u32) -> bool) {
        let used = (self.first..self.first.saturating_add(MOST)).filter(|&number| is_used(number));
        self.taken.extend(used.map(|number| number.to_string()));
    }

    /// `true` if the programs of a folder are known by their O numbers.
    #[must_use]
    pub fn is_of_tape(&self) -> bool {
        self.style == SubprogramStyle::Fanuc
    }

    /// `true` if a word can be one of the names.
    #[must_use]
    pub fn may_be(&self, word: &str) -> bool {
        let number = word.strip_prefix(&self.stem).and_then(|number| number.parse::<u32>().ok());
        number.is_some_and(|number| (self.first..self.first.saturating_add(MOST)).contains(&number))
    }

    /// The next free name; `None` if there is no further one.
    fn next(&mut self) -> Option<String> {
        while self.used < MOST {
            let name = format!("{}{}", self.stem, self.first.saturating_add(self.used));
            self.used += 1;
            if !self.taken.contains(&name) {
                return Some(name);
            }
        }
        None
    }

    /// The block that calls a subprogram.
    fn call(&self, name: &str) -> String {
        match self.style {
            SubprogramStyle::Sinumerik => name.to_owned(),
            SubprogramStyle::Fanuc => format!("M98 P{name}"),
            SubprogramStyle::Haas => format!("M97 P{name}"),
            SubprogramStyle::Rs274 => format!("o<{name}> call"),
            SubprogramStyle::Grundig => format!("G22 N={name}"),
        }
    }

    /// The name as people read it.
    fn shown(&self, name: &str) -> String {
        match self.style {
            SubprogramStyle::Sinumerik => format!("{name}.SPF"),
            SubprogramStyle::Fanuc => format!("O{name}"),
            SubprogramStyle::Haas => format!("N{name}"),
            SubprogramStyle::Rs274 => format!("o<{name}>"),
            SubprogramStyle::Grundig => format!("MM{name}"),
        }
    }

    /// A comment.
    fn comment(&self, text: &str) -> String {
        match self.style {
            SubprogramStyle::Sinumerik | SubprogramStyle::Rs274 => format!("; {text}"),
            _ => format!("({})", text.to_ascii_uppercase()),
        }
    }
}

/// Replaces the marked sections of a flat program by calls of subprograms. `None` if there are not enough names.
#[must_use]
pub fn fold(marked: &[u8], mut names: SubprogramNames) -> Option<FoldedProgram> {
    let ending: &'static [u8] = if marked.windows(2).any(|pair| pair == b"\r\n") { b"\r\n" } else { b"\n" };
    let mut fold = ProgramFold { ending, ..ProgramFold::default() };
    let mut section: Option<MarkedSection<'_>> = None;
    for line in lines(marked) {
        match (line, &mut section) {
            (MarkedLine::Begin(comment), _) => section = Some(MarkedSection { comment, lines: Vec::new() }),
            (MarkedLine::Text(line), Some(section)) => section.lines.push(line),
            (MarkedLine::Text(line), None) => fold.main.extend_from_slice(line),
            (MarkedLine::End, _) => {
                if let Some(section) = section.take() {
                    fold.section(&section, &mut names)?;
                }
            }
        }
    }
    Some(fold.finish(&names))
}

/// A section of the flat program.
struct MarkedSection<'a> {
    comment: &'a [u8],
    lines: Vec<&'a [u8]>,
}

/// The programs under construction.
#[derive(Default)]
struct ProgramFold {
    ending: &'static [u8],
    main: Vec<u8>,
    /// Names and bodies of the subprograms.
    bodies: Vec<(String, Vec<u8>)>,
    /// Their indices by body.
    known: HashMap<Vec<u8>, usize>,
    calls: u64,
}

impl ProgramFold {
    /// Writes a section as a call, or as it is.
    fn section(&mut self, section: &MarkedSection<'_>, names: &mut SubprogramNames) -> Option<()> {
        let is_numbered = names.style == SubprogramStyle::Grundig;
        let (number, body) =
            if is_numbered { renumbered(&section.lines) } else { (Vec::new(), section.lines.concat()) };
        let comment = section.comment;
        if lines_with_words(&body) < LEAST_LINES || section.lines.iter().any(|line| ends_program(line)) {
            if !comment.is_empty() {
                self.line(comment);
            }
            section.lines.iter().for_each(|line| self.main.extend_from_slice(line));
            return Some(());
        }
        let index = match self.known.get(&body) {
            Some(&index) => index,
            None => {
                let name = names.next()?;
                if names.style == SubprogramStyle::Rs274 {
                    self.line(format!("o<{name}> sub").as_bytes());
                    self.main.extend_from_slice(&body);
                    self.line(format!("o<{name}> endsub").as_bytes());
                }
                self.known.insert(body.clone(), self.bodies.len());
                self.bodies.push((name, body));
                self.bodies.len() - 1
            }
        };
        let mut call = number;
        call.extend_from_slice(names.call(&self.bodies[index].0).as_bytes());
        if !comment.is_empty() {
            call.push(b' ');
            call.extend_from_slice(comment);
        }
        self.line(&call);
        self.calls += 1;
        Some(())
    }

    fn line(&mut self, text: &[u8]) {
        self.main.extend_from_slice(text);
        self.main.extend_from_slice(self.ending);
    }

    /// Puts the programs together.
    fn finish(mut self, names: &SubprogramNames) -> FoldedProgram {
        let shown: Vec<String> = self.bodies.iter().map(|(name, _)| names.shown(name)).collect();
        let (stamp, head) = self.list(&shown, names);
        let bodies = std::mem::take(&mut self.bodies);
        let mut beside = Vec::new();
        let ends_with_tape = self.main.trim_ascii_end().ends_with(b"\n%");
        if ends_with_tape && names.style != SubprogramStyle::Rs274 {
            let end = self.main.trim_ascii_end().len() - 1;
            self.main.truncate(end);
        }
        for (name, body) in bodies {
            match names.style {
                SubprogramStyle::Rs274 => {}
                SubprogramStyle::Sinumerik => beside.push((name.clone(), self.file(&name, &head, &stamp, &body))),
                style => self.append(style, &name, &body),
            }
        }
        if ends_with_tape && names.style != SubprogramStyle::Rs274 {
            self.line(b"%");
        }
        let blocks = beside.iter().map(|(_, text)| lines_with_words(text)).sum::<u64>() + lines_with_words(&self.main);
        FoldedProgram { main: self.main, beside, names: shown, calls: self.calls, blocks }
    }

    /// Appends a subprogram to the file of the main program.
    fn append(&mut self, style: SubprogramStyle, name: &str, body: &[u8]) {
        match style {
            SubprogramStyle::Grundig => {
                self.line(format!("%MM{name}").as_bytes());
                self.line(format!("N{name} (NCFIX)").as_bytes());
                self.main.extend_from_slice(body);
            }
            SubprogramStyle::Haas => {
                self.line(format!("N{name}").as_bytes());
                self.main.extend_from_slice(body);
                self.line(b"M99");
            }
            _ => {
                self.line(format!("O{name} (NCFIX)").as_bytes());
                self.main.extend_from_slice(body);
                self.line(b"M99");
            }
        }
    }

    /// The text of a subprogram in its own file.
    fn file(&self, name: &str, head: &[u8], stamp: &[u8], body: &[u8]) -> Vec<u8> {
        let mut text = Vec::with_capacity(body.len() + 400);
        let mut line = |bytes: &[u8]| {
            text.extend_from_slice(bytes);
            text.extend_from_slice(self.ending);
        };
        if head.starts_with(b"%_N_") {
            line(format!("%_N_{name}_SPF").as_bytes());
            // The folder of the main program.
            if let Some(path) = head.split(|&byte| byte == b'\n').find(|line| line.starts_with(b";$PATH=")) {
                line(path.trim_ascii_end());
            }
        }
        line(stamp);
        line(format!("PROC {name}").as_bytes());
        text.extend_from_slice(body);
        text.extend_from_slice(b"RET");
        text.extend_from_slice(self.ending);
        text
    }

    /// Lists the subprograms after the stamp of the main program. Returns the stamp and what precedes it.
    fn list(&mut self, shown: &[String], names: &SubprogramNames) -> (Vec<u8>, Vec<u8>) {
        let mut start = 0;
        let found = self.main.split_inclusive(|&byte| byte == b'\n').find_map(|line| {
            start += line.len();
            is_stamped(line).then(|| (start - line.len(), start))
        });
        let (from, to) = found.unwrap_or_default();
        let head = self.main[..from].to_vec();
        let stamp = self.main[from..to].trim_ascii_end().to_vec();
        let text = match shown {
            [] => return (stamp, head),
            [one] => format!("subprogram: {one}"),
            [first, .., last] => format!("{} subprograms: {first} to {last}", shown.len()),
        };
        let line = [names.comment(&text).as_bytes(), self.ending].concat();
        self.main.splice(to..to, line);
        (stamp, head)
    }
}

/// Numbers the lines of a macro from 1. Returns the number of the first line and the text.
fn renumbered(lines: &[&[u8]]) -> (Vec<u8>, Vec<u8>) {
    let (mut first, mut out, mut count) = (Vec::new(), Vec::new(), 0_u32);
    for line in lines {
        let digits = line.iter().skip(1).take_while(|byte| byte.is_ascii_digit()).count();
        if line.first() == Some(&b'N') && digits > 0 && line.get(digits + 1) == Some(&b' ') {
            if count == 0 {
                first.extend_from_slice(&line[..digits + 2]);
            }
            count += 1;
            out.extend_from_slice(format!("N{count}").as_bytes());
            out.extend_from_slice(&line[digits + 1..]);
        } else {
            out.extend_from_slice(line);
        }
    }
    (first, out)
}

/// `true` if a line ends the program: in a subprogram, the word would mean a return, or nothing. Words of a kept line may stand without blanks.
fn ends_program(line: &[u8]) -> bool {
    let words = line.split(|&byte| matches!(byte, b';' | b'(')).next().unwrap_or_default();
    let mut before = b' ';
    words.iter().enumerate().any(|(at, &byte)| {
        let is_word = byte.eq_ignore_ascii_case(&b'M') && !before.is_ascii_alphabetic() && before != b'_';
        before = byte;
        let digits = words[at + 1..].iter().take_while(|byte| byte.is_ascii_digit()).skip_while(|&&byte| byte == b'0');
        is_word && [&b"2"[..], b"30", b"17", b"99"].iter().any(|end| digits.clone().eq(end.iter()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::emit::Stamp;

    fn stamp(is_capital: bool) -> String {
        let stamp = Stamp { machine: "m".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() };
        if is_capital { format!("({})", stamp.capital_text()) } else { format!("; {}", stamp.text()) }
    }

    /// The programs for a flat text in which `<` and `>` mark sections and `*` the stamp.
    fn folded(style: SubprogramStyle, taken: &str, text: &str) -> FoldedProgram {
        let stamp = stamp(!matches!(style, SubprogramStyle::Sinumerik | SubprogramStyle::Rs274));
        let marked = text.replace('<', "\u{1e}B").replace('>', "\u{1e}E").replace('*', &stamp);
        let mut names = SubprogramNames::new(style, "plate-2", 0);
        names.avoid(taken.as_bytes());
        let mut found = fold(marked.as_bytes(), names).unwrap();
        let plain = |text: &[u8]| String::from_utf8_lossy(text).replace(&stamp, "*").into_bytes();
        found.main = plain(&found.main);
        found.beside.iter_mut().for_each(|(_, text)| *text = plain(text));
        found
    }

    fn text(bytes: &[u8]) -> &str {
        std::str::from_utf8(bytes).unwrap()
    }

    #[test]
    fn a_section_that_runs_twice_is_written_once() {
        let flat =
            "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR\n*\nG90\n<\nG1 X1\nX2\nX3\n>\nG0 Z9\n<; pass 2\nG1 X1\nX2\nX3\n>\nM30\n";
        let found = folded(SubprogramStyle::Sinumerik, "", flat);
        let main = "%_N_PLATE_MPF\n;$PATH=/_N_WKS_DIR\n*\n; subprogram: PLATE_2_1.SPF\nG90\nPLATE_2_1\nG0 Z9\nPLATE_2_1 ; pass 2\nM30\n";
        assert_eq!(text(&found.main), main);
        assert_eq!(found.beside.len(), 1);
        let file = "%_N_PLATE_2_1_SPF\n;$PATH=/_N_WKS_DIR\n*\nPROC PLATE_2_1\nG1 X1\nX2\nX3\nRET\n";
        assert_eq!((found.beside[0].0.as_str(), text(&found.beside[0].1)), ("PLATE_2_1", file));
        // Main: the header line is a comment for the count; G90, two calls, G0 and M30. File: PROC, three moves, RET.
        assert_eq!((found.calls, found.blocks), (2, 10));
    }

    #[test]
    fn each_language_has_its_calls() {
        let flat = "%\nO5\n*\n<\nG1 X1.\nX2.\nX3.\n>\n<\nG1 X1.\nX2.\nX4.\n>\nM30\n%\n";
        let found = folded(SubprogramStyle::Fanuc, "M98 P7001", flat);
        let expected = "%\nO5\n*\n(2 SUBPROGRAMS: O7002 TO O7003)\nM98 P7002\nM98 P7003\nM30\nO7002 (NCFIX)\nG1 X1.\nX2.\nX3.\nM99\nO7003 (NCFIX)\nG1 X1.\nX2.\nX4.\nM99\n%\n";
        assert_eq!(text(&found.main), expected);
        let haas = folded(SubprogramStyle::Haas, "", "*\n<(PASS 2)\nX1.\nX2.\nX3.\n>\nM30\n");
        assert_eq!(text(&haas.main), "*\n(SUBPROGRAM: N70001)\nM97 P70001 (PASS 2)\nM30\nN70001\nX1.\nX2.\nX3.\nM99\n");
        let rs274 = folded(SubprogramStyle::Rs274, "", "*\n<\nX1\nX2\nX3\n>\n<\nX1\nX2\nX3\n>\nM2\n");
        let expected = "*\n; subprogram: o<NCFIX_1>\no<NCFIX_1> sub\nX1\nX2\nX3\no<NCFIX_1> endsub\no<NCFIX_1> call\no<NCFIX_1> call\nM2\n";
        assert_eq!(text(&rs274.main), expected);
        let flat =
            "%PM1\r\nN1 *\r\n<\nN2 X1\r\nN3 X2\r\nN4 X3\r\n>\nN5 Z9\r\n<\nN6 X1\r\nN7 X2\r\nN8 X3\r\n>\nN9 M30\r\n";
        let grundig = folded(SubprogramStyle::Grundig, "", flat);
        let expected = "%PM1\r\nN1 *\r\n(SUBPROGRAM: MM9501)\r\nN2 G22 N=9501\r\nN5 Z9\r\nN6 G22 N=9501\r\nN9 M30\r\n%MM9501\r\nN9501 (NCFIX)\r\nN1 X1\r\nN2 X2\r\nN3 X3\r\n";
        assert_eq!(text(&grundig.main), expected);
    }

    #[test]
    fn short_sections_and_ends_stay() {
        let flat = "*\n<; pass 2\nX1\nX2\n>\n<\nX1\nX2\nX3\nM02 ; end\n>\n";
        let found = folded(SubprogramStyle::Rs274, "", flat);
        assert_eq!(text(&found.main), "*\n; pass 2\nX1\nX2\nX1\nX2\nX3\nM02 ; end\n");
        assert_eq!((found.calls, found.names.len()), (0, 0));
    }

    #[test]
    fn the_end_of_a_program_is_seen_in_any_block() {
        for line in ["M30\n", "G90M30\r\n", "g0 x1 m02 ; end", "N5 M17", "M99 P10"] {
            assert!(ends_program(line.as_bytes()), "{line}");
        }
        for line in ["M3 S30\n", "G1 X2 (M30)", "; M30", "M300", "X30 M8", "MM=30", "M130"] {
            assert!(!ends_program(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn names_are_those_of_no_other_program() {
        let mut names = SubprogramNames::new(SubprogramStyle::Sinumerik, "plate", 0);
        names.avoid(b"PLATE_1 plate_3(5) MY_PLATE_2 PLATE_20X PLATE_002");
        assert_eq!([names.next(), names.next(), names.next()].map(Option::unwrap), ["PLATE_2", "PLATE_4", "PLATE_5"]);
        let mut names = SubprogramNames::new(SubprogramStyle::Fanuc, "plate", 7101);
        names.avoid(b"O7101 M98P07103 X7104.5");
        names.avoid_numbers(|number| number == 7105);
        assert_eq!([names.next(), names.next()].map(Option::unwrap), ["7102", "7106"]);
        // A name begins with two letters and has at most 24 characters.
        let name = |stem: &str| SubprogramNames::new(SubprogramStyle::Sinumerik, stem, 0).next().unwrap();
        assert_eq!(name("10 plate"), "SP_10_PLATE_1");
        assert_eq!(name("x1"), "SP_X1_1");
        assert_eq!(name("some_very_long_name_of_a_program"), "SOME_VERY_LONG_NAME__1");
    }

    #[test]
    fn names_end() {
        let sections: String = (0..1000).map(|x| format!("\u{1e}B\nX{x}\nY1\nY2\n\u{1e}E\n")).collect();
        let names = || SubprogramNames::new(SubprogramStyle::Fanuc, "a", 0);
        assert_eq!(fold(sections.as_bytes(), names()), None);
        let shorter = &sections.as_bytes()[..sections.find("X999").unwrap() - 3];
        assert_eq!(fold(shorter, names()).unwrap().names.len(), 999);
    }
}
