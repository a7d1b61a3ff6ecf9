//! Connects the two sides of control structures, lists jump targets and subroutines, and reports what has only one side.

use super::tree::{Block, Body, Label, Program};
use crate::diagnostic::{Code, Diagnostic, Place};
use crate::dialect::Language;
use crate::source::Span;

/// Sorts the block numbers of each part, so that a jump finds its target.
pub(super) fn list_targets(program: &mut Program, findings: &mut Vec<Diagnostic>) {
    if program.dialect.language == Language::Rs274 {
        return;
    }
    for part in &mut program.parts {
        let first = program.targets.len();
        let blocks = program.blocks.get(part.blocks.clone()).unwrap_or_default();
        let numbered = blocks
            .iter()
            .zip(part.blocks.start..)
            .filter_map(|(block, index)| block.number.map(|number| (number, u32::try_from(index).unwrap_or(u32::MAX))));
        program.targets.extend(numbered);
        // Numbers mostly rise, and a sorted run costs the sort nothing.
        program.targets[first..].sort_unstable();
        part.targets = first..program.targets.len();
    }
    let _ = findings;
}

/// An open control structure: its blocks that still want a partner.
struct Open {
    block: usize,
    /// IF or ELSEIF or ELSE that leads on from here.
    last: usize,
    label: Option<Label>,
}

/// Sets the partners.
pub(super) fn connect(program: &mut Program, findings: &mut Vec<Diagnostic>) {
    for part in 0..program.parts.len() {
        let Some(range) = program.parts.get(part).map(|part| part.blocks.clone()) else { continue };
        let mut open: Vec<Open> = Vec::new();
        for index in range {
            step(program, index, &mut open, findings);
        }
        for left in open {
            let message = "this has no end in this program";
            report(program, left.block, message, findings);
        }
    }
}

fn report(program: &Program, index: usize, message: &str, findings: &mut Vec<Diagnostic>) {
    let span = program.blocks.get(index).map_or(Span::default(), |block| block.span);
    let place = Place { file: program.source.id(), span };
    let help = "every structure needs both its sides, in the same program and properly nested";
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
            // `o100 while […]` behind `o100 do` ends it.
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
            _ => report(program, index, "there is no IF that this could belong to", findings),
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
                report(program, index, "there is no open structure of this kind that this could end", findings);
            }
        }
        Body::Break | Body::Continue => {
            let is_loop = |open: &&Open| {
                open.label == label
                    && matches!(body_at(program, open.block), Body::While(_) | Body::Do | Body::Repeat(_))
            };
            match open.iter().rev().find(is_loop).map(|open| open.block) {
                Some(start) => set(program, index, start),
                None => report(program, index, "there is no open loop that this could belong to", findings),
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
