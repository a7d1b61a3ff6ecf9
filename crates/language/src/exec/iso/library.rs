//! Finds programs: in the calling file, in the main file, in files next to it by their name, then by the O number in them.

use super::call::{Call, Callee};
use super::level::{Interpreter, Loaded};
use super::loaded::Loops;
use crate::exec::core::fault::{Fault, fault};
use crate::syntax::words::{Label, PartKind, Program};
use ncfix_base::diagnostic::Code;
use ncfix_dialect::Language;

/// Extensions of program files, in search order.
const ENDINGS: &[&str] = &["", ".NC", ".CNC", ".TAP", ".TXT", ".PRG", ".EIA", ".MIN"];
/// Extensions for RS274/NGC.
const RS274_ENDINGS: &[&str] = &[".NGC", ".NC", ""];
/// From this number on, M98 writes a program together with its count.
const SPLIT: u32 = 10_000;

/// Start of a program: file, part, block.
pub(super) type Entry = (usize, usize, usize);

impl Interpreter<'_> {
    /// The program of a call. This resolves the ambiguity of P: a count and a number, or one long number.
    pub(super) fn find(&mut self, call: &mut Call) -> Result<Entry, Fault> {
        let (shown, found) = match &call.callee {
            Callee::Number(number) => (format!("O{number:04}"), self.find_number(*number)),
            Callee::Name(name) => (format!("<{name}>"), self.find_name(name)),
            Callee::Own => {
                let own = self.levels.last().map_or((0, 0), |level| (level.program, level.part));
                ("this program".to_owned(), self.entry(own.0, own.1))
            }
            Callee::Sub(name) => (format!("o<{name}> sub"), self.find_sub(name)),
            &Callee::Counted(number) => {
                let (count, short) = (number / SPLIT, number % SPLIT);
                let mut found = self.find_number(short);
                let other = self.find_number(number);
                if !self.machine.control.iso.reads_as_fanuc() && found.is_some() && other.is_some() {
                    let message = format!(
                        "M98 P{number}: program {short} {count} times on a Fanuc, program {number} once on a Haas, and both exist"
                    );
                    let help = format!(
                        "write M98 P{short} L{count}, or give program {number} a four-digit number; or set \
                         control.word_meaning = \"fanuc\" or controller = \"haas\""
                    );
                    return Err(fault(Code::TWO_MEANINGS, call.span, message, help));
                }
                if found.is_some() {
                    (call.repeats, call.callee) = (count, Callee::Number(short));
                } else {
                    found = other;
                    call.callee = Callee::Number(number);
                }
                (format!("O{short:04} ({count} times)"), found)
            }
        };
        found.ok_or_else(|| self.not_found(&shown, call))
    }

    fn not_found(&mut self, shown: &str, call: &Call) -> Fault {
        let message =
            self.library.refusal().unwrap_or_else(|| format!("{shown} is neither in this file nor in its folder"));
        // `O7777 (2 times)` is in the file O7777.
        let name = shown.split(' ').next().unwrap_or(shown);
        let files = match (self.channel.language, name.strip_prefix('O')) {
            (Language::Rs274, _) => match &call.callee {
                Callee::Name(name) | Callee::Sub(name) => format!("the file {name}.ngc"),
                Callee::Number(number) | Callee::Counted(number) => format!("the file {number}.ngc"),
                Callee::Own => "its file".to_owned(),
            },
            (_, Some(number)) => format!("the file {name}, {name}.NC or {number}.NC"),
            (_, None) => "its file".to_owned(),
        };
        let own = match &call.callee {
            _ if call.is_of_code => {
                "if the control runs it itself, remove its code from control.macro_codes and name the code in control.opaque"
                    .to_owned()
            }
            Callee::Number(number) | Callee::Counted(number) => {
                format!("if the control runs it itself, write opaque = [\"O{number:04}\"] in [control]")
            }
            Callee::Name(name) | Callee::Sub(name) => {
                let name = name.to_ascii_uppercase();
                format!("if the control runs it itself, write opaque = [\"{name}\"] in [control]")
            }
            Callee::Own => "name a program that the control runs itself under [[opaque]]".to_owned(),
        };
        let help = format!("put {files} next to the program, or add its folder to control.search_path; {own}");
        fault(Code::NO_SUBPROGRAM, call.span, message, help)
    }

    /// The files that may contain a program, the calling file first.
    fn near(&self) -> impl Iterator<Item = usize> + use<> {
        let own = self.levels.last().map_or(0, |level| level.program);
        std::iter::once(own).chain((own != 0).then_some(0))
    }

    fn entry(&self, program: usize, part: usize) -> Option<Entry> {
        let start = self.programs.get(program)?.program.parts.get(part)?.blocks.start;
        Some((program, part, start))
    }

    fn find_number(&mut self, number: u32) -> Option<Entry> {
        let in_file = |program: &Program| program.find_part(PartKind::Program, number);
        for program in self.near() {
            if let Some(part) = in_file(&self.programs[program].program) {
                return self.entry(program, part);
            }
        }
        let names = if self.channel.language == Language::Rs274 {
            RS274_ENDINGS.iter().map(|ending| format!("{number}{ending}")).collect()
        } else {
            let stems = [format!("O{number:04}"), format!("O{number}"), format!("{number:04}"), format!("{number}")];
            file_names(&stems, ENDINGS)
        };
        let is_rs274 = self.channel.language == Language::Rs274;
        let program = self.load(&format!("O{number}"), &names, (!is_rs274).then_some(number))?;
        let part = in_file(&self.programs[program].program).unwrap_or(0);
        self.entry(program, part)
    }

    fn find_name(&mut self, name: &str) -> Option<Entry> {
        let in_file = |program: &Program| program.find_named_part(program.names.find(name)?);
        for program in self.near() {
            if let Some(part) = in_file(&self.programs[program].program) {
                return self.entry(program, part);
            }
        }
        let program = self.load(name, &file_names(&[name.to_owned()], ENDINGS), None)?;
        let part = in_file(&self.programs[program].program).unwrap_or(0);
        self.entry(program, part)
    }

    /// An O-word subroutine: one that was passed or loaded already, then a file, then one further ahead.
    fn find_sub(&mut self, name: &str) -> Option<Entry> {
        let (own, here) = self.levels.last().map_or((0, 0), |level| (level.program, level.next));
        let others = (0..self.programs.len()).filter(|&program| program != own);
        let passed = self.sub_in(own, name).filter(|entry| entry.2 <= here);
        let known =
            passed.or_else(|| others.rev().filter(|&other| other != 0).find_map(|other| self.sub_in(other, name)));
        if known.is_some() {
            return known;
        }
        let stem = name.rsplit('/').next().unwrap_or(name);
        let names = file_names(&[stem.to_owned()], RS274_ENDINGS);
        if let Some(program) = self.load(name, &names, None) {
            return self.sub_in(program, stem);
        }
        self.sub_in(own, name).or_else(|| self.sub_in(0, name))
    }

    /// The first block of a subroutine in a file.
    fn sub_in(&self, program: usize, name: &str) -> Option<Entry> {
        let loaded = &self.programs.get(program)?.program;
        let fits = |label: Label| match label {
            Label::Number(number) => name.parse() == Ok(number),
            Label::Name(known) => loaded.names.text(known).eq_ignore_ascii_case(name),
            Label::Computed(_) => false,
        };
        let &(_, block) = loaded.subs().iter().find(|(label, _)| fits(*label))?;
        let block = block as usize;
        Some((program, loaded.part_of(block)?, block + 1))
    }

    /// Loads a file from the library, once: by its name, else by the O number in it. Returns its index.
    fn load(&mut self, key: &str, names: &[String], number: Option<u32>) -> Option<usize> {
        self.find_once(key, |run| {
            let by_name = run.library.load_file(names);
            let (shown, bytes) = by_name.or_else(|| run.library.load_number(number?))?;
            let program = run.read(&shown, bytes)?;
            run.channel.variables.add_program(&program);
            let loops = Loops::of(&program, &run.ledger);
            Some(run.keep(Loaded::with(program, loops)))
        })
    }
}

/// All combinations of names and extensions.
fn file_names(stems: &[String], endings: &[&str]) -> Vec<String> {
    stems.iter().flat_map(|stem| endings.iter().map(move |ending| format!("{stem}{ending}"))).collect()
}
