//! Connects both ends of control structures, and reports those with only one end.

use super::tree::{Block, Body, Program};
use crate::syntax::paged_store::PagedStore;
use ncfix_base::diagnostic::{Code, Diagnostic, Place};

/// Maximum nesting of control structures; controls allow 16.
const MAX_DEPTH: usize = 32;

/// Sets [`Block::partner`] of every control block, section by section.
pub(super) fn connect(program: &mut Program, findings: &mut Vec<Diagnostic>) {
    let file = program.source.id();
    let mut faults = Vec::new();
    for section in &program.sections {
        let mut open: Vec<usize> = Vec::new();
        for index in section.blocks.clone() {
            match program.blocks[index].body {
                Body::If(_) | Body::Loop | Body::For { .. } | Body::While(_) | Body::Repeat => {
                    if open.len() == MAX_DEPTH {
                        faults.push((
                            index,
                            Code::TOO_DEEP,
                            "control structures are nested more than 32 deep".to_owned(),
                        ));
                    }
                    open.push(index);
                }
                Body::Else => match open.last() {
                    Some(&start)
                        if matches!(program.blocks[start].body, Body::If(_))
                            && start_is_free(&program.blocks[start]) =>
                    {
                        program.blocks[start].partner = place_of(index);
                    }
                    _ => faults.push((index, Code::UNMATCHED_STRUCTURE, "ELSE without an open IF".to_owned())),
                },
                Body::EndIf | Body::EndLoop | Body::EndFor | Body::EndWhile | Body::Until(_) => {
                    close(&mut program.blocks, &mut open, index, &mut faults);
                }
                _ => {}
            }
        }
        for index in open {
            let (word, end) = words_of(&program.blocks[index].body);
            faults.push((index, Code::UNMATCHED_STRUCTURE, format!("{word} without {end}")));
        }
    }
    for (index, code, message) in faults {
        let place = Place { file, span: program.blocks[index].span };
        findings.push(Diagnostic::at(code, place, message, "close the structure in the same program, properly nested"));
    }
    findings.sort_by_key(|finding| finding.place);
}

fn start_is_free(block: &Block) -> bool {
    block.partner == u32::MAX
}

fn place_of(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

fn close(blocks: &mut PagedStore<Block>, open: &mut Vec<usize>, index: usize, faults: &mut Vec<(usize, Code, String)>) {
    let (opening, end) = words_of(&blocks[index].body);
    let fits = open.last().is_some_and(|&start| words_of(&blocks[start].body) == (opening, end));
    let Some(start) = open.pop_if(|_| fits) else {
        faults.push((index, Code::UNMATCHED_STRUCTURE, format!("{end} without {opening}")));
        return;
    };
    // IF … ELSE … ENDIF: the IF keeps its ELSE, the ELSE gets the ENDIF.
    let first = blocks[start].partner;
    if first == u32::MAX {
        blocks[start].partner = place_of(index);
    } else {
        blocks[first as usize].partner = place_of(index);
    }
    blocks[index].partner = place_of(start);
}

/// The opening and the closing word of a structure, from either of its blocks.
fn words_of(body: &Body) -> (&'static str, &'static str) {
    match body {
        Body::If(_) | Body::EndIf => ("IF", "ENDIF"),
        Body::Loop | Body::EndLoop => ("LOOP", "ENDLOOP"),
        Body::For { .. } | Body::EndFor => ("FOR", "ENDFOR"),
        Body::While(_) | Body::EndWhile => ("WHILE", "ENDWHILE"),
        _ => ("REPEAT", "UNTIL"),
    }
}
