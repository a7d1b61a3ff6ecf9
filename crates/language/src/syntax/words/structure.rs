//! Connects both ends of control structures, lists jump targets and subroutines, and reports structures with only one end.

use super::tree::{Address, Block, Body, Label, Part, PartKind, Program, Value, Word};
use ncfix_base::diagnostic::{Code, Diagnostic, Place};
use ncfix_base::source::Span;
use ncfix_dialect::Language;

/// Maximum number of open structures searched for the loop of BREAK or CONTINUE.
const MAX_SEARCH: usize = 256;

/// M codes that end a program or call one.
const LEADING_AWAY: [f64; 5] = [2.0, 30.0, 98.0, 99.0, 198.0];

impl Program {
    /// The part with which the execution begins, and the main program: the first program with blocks. Comments or codes of a Fanuc file before its
    /// first program number come first, but are not a separate program.
    #[must_use]
    pub fn main_parts(&self) -> (usize, usize) {
        let is_program = |part: &Part| part.kind == PartKind::Program && !part.blocks.is_empty();
        let Some(first) = self.parts.iter().position(is_program) else { return (0, 0) };
        let next = self.parts.iter().skip(first + 1).position(is_program).map(|place| first + 1 + place);
        match next {
            Some(main) if self.dialect.language == Language::Fanuc && self.is_preamble(first) => (first, main),
            _ => (first, first),
        }
    }

    /// Fanuc blocks with motion before the first program number that neither end nor call: the first of them, and that number.
    #[must_use]
    pub fn outside(&self) -> Option<(Span, Span)> {
        let (first, main) = self.main_parts();
        let part = self
            .parts
            .get(first)
            .filter(|part| self.dialect.language == Language::Fanuc && first == main && part.headers.is_empty())?;
        let is_program = |part: &&Part| part.kind == PartKind::Program && !part.blocks.is_empty();
        let next = self.parts.iter().skip(first + 1).find(is_program)?;
        let ends = |word: &Word| matches!((word.address, word.value), (Address::Letter(b'M'), Value::Number { value, .. }) if LEADING_AWAY.contains(&value));
        let blocks = self.blocks.range(part.blocks.clone());
        if blocks.iter().any(|block| self.words_of(block).iter().any(ends)) {
            return None;
        }
        let block = blocks.iter().find(|block| matches!(block.body, Body::Words))?;
        Some((block.span, *next.headers.first()?))
    }

    /// `true` if a fully loaded part contains only comments.
    #[must_use]
    pub fn is_idle(&self, part: &Part) -> bool {
        self.blocks.range(part.blocks.clone()).iter().all(|block| block.body == Body::Empty)
    }

    /// `true` if a part has no number and contains no motion, call or end.
    fn is_preamble(&self, part: usize) -> bool {
        let Some(part) = self.parts.get(part).filter(|part| part.headers.is_empty()) else { return false };
        let is_still = |word: &Word| match (word.address, word.value) {
            (Address::Variable(_), _) => true,
            (Address::Letter(b'M'), Value::Number { value, .. }) => !LEADING_AWAY.contains(&value),
            (Address::Letter(b'G' | b'S' | b'T' | b'F' | b'D' | b'H' | b'O'), Value::Number { .. }) => true,
            _ => false,
        };
        self.blocks.range(part.blocks.clone()).iter().all(|block| match block.body {
            Body::Empty | Body::Printing(_) => true,
            Body::Words => self.words_of(block).iter().all(is_still),
            _ => false,
        })
    }
}

/// Sorts the block numbers of each part for the search of jump targets.
pub(super) fn list_targets(program: &mut Program) {
    if program.dialect.language == Language::Rs274 {
        return;
    }
    for part in &mut program.parts {
        let first = program.targets.len();
        let blocks = program.blocks.range(part.blocks.clone());
        let numbered = blocks
            .iter()
            .zip(part.blocks.start..)
            .filter_map(|(block, index)| block.number.map(|number| (number, u32::try_from(index).unwrap_or(u32::MAX))));
        program.targets.extend(numbered);
        // Numbers are mostly ascending, and sorting an ascending run is cheap.
        program.targets[first..].sort_unstable();
        part.targets = first..program.targets.len();
    }
}

/// An open control structure: its blocks that still need a partner.
struct Open {
    block: usize,
    /// The last IF, ELSEIF or ELSE, from which the structure continues.
    last: usize,
    label: Option<Label>,
}

/// `true` if the program ends here unconditionally: M2 or M30.
fn ends_program(program: &Program, block: &Block) -> bool {
    let is_end = |value| matches!(value, Value::Number { value, .. } if value == 2.0 || value == 30.0);
    let mut words = program.words_of(block).iter();
    block.skip.is_none() && words.any(|word| word.address == Address::Letter(b'M') && is_end(word.value))
}

/// Sets the partners. Text after the end of an RS274/NGC program is never read, so it contains no errors.
pub(super) fn connect(program: &mut Program, findings: &mut Vec<Diagnostic>) {
    let mut unread: Vec<Span> = Vec::new();
    for part in 0..program.parts.len() {
        let Some(range) = program.parts.get(part).map(|part| part.blocks.clone()) else { continue };
        let mut open: Vec<Open> = Vec::new();
        let mut is_over = false;
        for index in range {
            step(program, index, &mut open, findings);
            match program.blocks.get_mut(index) {
                Some(block) if block.body == Body::Sub => is_over = false,
                Some(block) if block.body == Body::Faulty && is_over => {
                    block.body = Body::Empty;
                    unread.push(block.span);
                }
                Some(block)
                    if block.body == Body::Words && open.is_empty() && program.dialect.language == Language::Rs274 =>
                {
                    let block = *block;
                    is_over |= ends_program(program, &block);
                }
                _ => {}
            }
        }
        for left in open {
            let message = "this structure has no end in this program";
            report(program, left.block, message, findings);
        }
    }
    if !unread.is_empty() {
        let is_unread = |place: Place| {
            let before = unread.partition_point(|span| span.start <= place.span.start);
            before > 0 && unread.get(before - 1).is_some_and(|span| place.span.start <= span.end)
        };
        findings.retain(|finding| !finding.place.is_some_and(is_unread));
    }
}

fn report(program: &Program, index: usize, message: &str, findings: &mut Vec<Diagnostic>) {
    let span = program.blocks.get(index).map_or(Span::default(), |block| block.span);
    let place = Place { file: program.source.id(), span };
    let help = "every structure needs its beginning and its end, in the same program and properly nested";
    findings.push(Diagnostic::at(Code::UNMATCHED_STRUCTURE, place, message, help));
}

fn set(program: &mut Program, index: usize, partner: usize) {
    if let Some(block) = program.blocks.get_mut(index) {
        block.partner = u32::try_from(partner).unwrap_or(u32::MAX);
    }
}

fn step(program: &mut Program, index: usize, open: &mut Vec<Open>, findings: &mut Vec<Diagnostic>) {
    let Some(&Block { body, label, .. }) = program.blocks.get(index) else { return };
    let body_at = |program: &Program, at: usize| program.blocks.get(at).map_or(Body::Empty, |block| block.body);
    let top = open.last().map(|top| (body_at(program, top.block), body_at(program, top.last), top.label));
    match body {
        Body::While(Some(condition)) if matches!(top, Some((Body::Do, _, of)) if of == label) => {
            // `o100 while […]` after `o100 do` ends the loop.
            if let Some(block) = program.blocks.get_mut(index) {
                block.body = Body::DoWhile(condition);
            }
            close(program, index, open);
        }
        Body::While(_) | Body::Do | Body::Repeat(_) | Body::If(_) | Body::Sub => {
            if body == Body::Sub
                && let Some(label) = label
            {
                program.subs.push((label, u32::try_from(index).unwrap_or(u32::MAX)));
            }
            open.push(Open { block: index, last: index, label });
        }
        Body::ElseIf(_) | Body::Else => match (top, open.last_mut()) {
            (Some((Body::If(_), Body::If(_) | Body::ElseIf(_), of)), Some(top)) if of == label => {
                set(program, top.last, index);
                top.last = index;
            }
            _ => report(program, index, "there is no matching IF", findings),
        },
        Body::EndWhile | Body::EndRepeat | Body::EndIf | Body::EndSub(_) => {
            let fits = matches!(
                (body, top),
                (Body::EndWhile, Some((Body::While(_), ..)))
                    | (Body::EndRepeat, Some((Body::Repeat(_), ..)))
                    | (Body::EndIf, Some((Body::If(_), ..)))
                    | (Body::EndSub(_), Some((Body::Sub, ..)))
            );
            if fits && top.is_some_and(|top| top.2 == label) {
                close(program, index, open);
            } else {
                report(program, index, "there is no open structure of this kind to end", findings);
            }
        }
        Body::Break | Body::Continue => {
            let is_loop = |open: &&Open| {
                open.label == label
                    && matches!(body_at(program, open.block), Body::While(_) | Body::Do | Body::Repeat(_))
            };
            match open.iter().rev().take(MAX_SEARCH).find(is_loop).map(|open| open.block) {
                Some(start) => set(program, index, start),
                None => report(program, index, "there is no open loop for this statement", findings),
            }
        }
        _ => {}
    }
}

/// Connects the innermost open structure with its end.
fn close(program: &mut Program, index: usize, open: &mut Vec<Open>) {
    let Some(top) = open.pop() else { return };
    set(program, top.last, index);
    set(program, index, top.block);
}
