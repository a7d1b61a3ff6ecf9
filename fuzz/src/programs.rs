//! Programs of all dialects: the parsers, the whole tree against pages of it, execution, and the flat stream as text.

use std::sync::OnceLock;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::AXES;
use ncfix_base::source::Source;
use ncfix_dialect::Dialect;
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax::{self, Program, sinumerik, words};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Dwell, Element, Kind};
use ncfix_model::{ErrorModel, file};

use super::{check_findings, snc, source};

/// Sizes of pages: less than a line, some lines, most of a sample.
const PAGES: [usize; 3] = [1, 60, 1000];
/// Blocks after which a run ends.
const MAX_BLOCKS: u64 = 400;
/// Elements after which nobody looks: one block may be many (patterns of holes, splines, turns).
const MAX_ELEMENTS: usize = 20_000;

/// Parses as Sinumerik.
pub fn parse_sinumerik(bytes: &[u8]) {
    parse("sinumerik", bytes);
}

/// Parses as Grundig, Philips.
pub fn parse_grundig(bytes: &[u8]) {
    parse("grundig", bytes);
}

/// Parses as Fanuc.
pub fn parse_fanuc(bytes: &[u8]) {
    parse("fanuc", bytes);
}

/// Parses as RS274/NGC.
pub fn parse_rs274(bytes: &[u8]) {
    parse("rs274", bytes);
}

/// Executes as Sinumerik.
pub fn execute_sinumerik(bytes: &[u8]) {
    execute("sinumerik", bytes);
}

/// Executes as Grundig, Philips.
pub fn execute_grundig(bytes: &[u8]) {
    execute("grundig", bytes);
}

/// Executes as Fanuc.
pub fn execute_fanuc(bytes: &[u8]) {
    execute("fanuc", bytes);
}

/// Executes as RS274/NGC.
pub fn execute_rs274(bytes: &[u8]) {
    execute("rs274", bytes);
}

/// A dialect.
pub(super) fn dialect_of(name: &str) -> &'static Dialect {
    ncfix_dialect::find(name).expect("a dialect of the register")
}

/// The sample machine of a dialect with its errors.
pub(super) fn machine_of(name: &str) -> &'static (Machine, ErrorModel) {
    static MACHINES: OnceLock<[(Machine, ErrorModel); 4]> = OnceLock::new();
    const TEXTS: [&str; 4] = [
        include_str!("../../samples/machines/demo.toml"),
        include_str!("../../samples/machines/universal_mill.toml"),
        include_str!("../../samples/machines/vmc.toml"),
        include_str!("../../samples/machines/knee_mill.toml"),
    ];
    let machines = MACHINES.get_or_init(|| {
        TEXTS.map(|text| file::load(&source("machine", text.as_bytes())).0.expect("a sample without faults"))
    });
    let number = ["sinumerik", "grundig", "fanuc", "rs274"].iter().position(|known| *known == name);
    &machines[number.expect("one of the four")]
}

fn parse(name: &str, bytes: &[u8]) {
    let source = source("program", bytes);
    let (mut program, findings) = syntax::parse(&source, dialect_of(name));
    check_findings(&findings, &[&source]);
    check_tree(&program);
    for page in PAGES {
        if let Some(mut paged) = syntax::parse_by_pages(&source, dialect_of(name), page) {
            if !findings.is_empty() {
                // It is not executed; the findings are those of its pages.
                continue;
            }
            check_pages(&mut paged, &mut program);
        }
    }
}

/// Spans are in the text, and what belongs to a block lies in it, in order.
fn check_tree(program: &Program) {
    let holds = |source: &Source, span: ncfix_base::source::Span| {
        assert!(span.start <= span.end, "{span:?}");
        assert_eq!(source.slice(span).len(), (span.end - span.start) as usize, "{span:?}");
    };
    match program {
        Program::Sinumerik(program) => {
            for block in &program.blocks {
                holds(&program.source, block.span);
                holds(&program.source, block.comment);
                assert!(block.partner().is_none_or(|partner| partner < program.blocks.len()));
                for word in program.words_of(block) {
                    holds(&program.source, word.span);
                    assert!(block.span.start <= word.span.start && word.span.end <= block.span.end, "{word:?}");
                }
            }
            program.exprs.iter().for_each(|expr| holds(&program.source, expr.span));
        }
        Program::Words(program) => {
            for (index, block) in program.blocks.iter().enumerate() {
                holds(&program.source, block.span);
                assert!(block.partner().is_none_or(|partner| partner < program.blocks.len()));
                let inside = |span: ncfix_base::source::Span| {
                    holds(&program.source, span);
                    assert!(block.span.start <= span.start && span.end <= block.span.end, "{span:?} {block:?}");
                };
                program.words_of(block).iter().for_each(|word| inside(word.span));
                program.comments_of(block).iter().for_each(|comment| inside(comment.span));
                let part = program.part_of(index).expect("every block belongs to a part");
                assert!(program.parts[part].blocks.contains(&index));
            }
            program.exprs.iter().for_each(|expr| holds(&program.source, expr.span));
        }
    }
}

/// Every block, looked up forward and backward, is that of the whole tree.
fn check_pages(paged: &mut Program, whole: &mut Program) {
    match (paged, whole) {
        (Program::Sinumerik(paged), Program::Sinumerik(whole)) => check_sinumerik_pages(paged, whole),
        (Program::Words(paged), Program::Words(whole)) => check_word_pages(paged, whole),
        _ => panic!("one file, two families of trees"),
    }
}

fn check_sinumerik_pages(paged: &mut sinumerik::Program, whole: &sinumerik::Program) {
    assert_eq!(paged.blocks.len(), whole.blocks.len());
    assert_eq!(paged.sections, whole.sections);
    assert!(paged.names.iter().eq(whole.names.iter()));
    for index in there_and_back(whole.blocks.len()) {
        paged.ensure(index);
        let (one, other) = (paged.blocks[index], whole.blocks[index]);
        assert_eq!(one, other);
        assert_eq!(paged.words_of(&one), whole.words_of(&other));
    }
}

fn check_word_pages(paged: &mut words::Program, whole: &words::Program) {
    assert_eq!(paged.blocks.len(), whole.blocks.len());
    assert_eq!(paged.parts.len(), whole.parts.len());
    for (one, other) in paged.parts.iter().zip(&whole.parts) {
        assert_eq!((&one.headers, &one.blocks, one.number), (&other.headers, &other.blocks, other.number));
        assert_eq!((one.kind, one.name, one.title), (other.kind, other.name, other.title));
    }
    assert_eq!(paged.has_tape_marks, whole.has_tape_marks);
    assert!(paged.names.iter().eq(whole.names.iter()));
    for index in there_and_back(whole.blocks.len()) {
        paged.ensure(index);
        let (one, other) = (paged.blocks[index], whole.blocks[index]);
        assert_eq!(one, other);
        assert_eq!(paged.words_of(&one), whole.words_of(&other));
        assert_eq!(paged.comments_of(&one), whole.comments_of(&other));
    }
    let numbers = whole.blocks.iter().filter_map(|block| block.number).take(5);
    for number in numbers.chain([0, 10]) {
        for from in [0, 3] {
            assert_eq!(paged.find_block(0, number, from), whole.find_block(0, number, from), "N{number} from {from}");
        }
    }
}

fn there_and_back(count: usize) -> impl Iterator<Item = usize> {
    (0..count).chain((0..count).rev().step_by(7))
}

/// What a run gave.
pub(super) struct Ran {
    pub(super) elements: Vec<Element>,
    pub(super) findings: Vec<Diagnostic>,
}

/// How a file is run. The bytes decide, so that samples stay what they are.
pub(super) fn options_for(bytes: &[u8]) -> Options {
    let sum = bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte));
    Options { max_blocks: Some(MAX_BLOCKS), strict: sum % 2 == 1, ..Options::default() }
}

/// Executes a program to its end or to a bound; checks what it says and gives.
pub(super) fn run(program: Program, machine: &Machine, options: Options) -> Ran {
    let mut execution = Execution::new(program, machine, Box::new(NoLibrary), options);
    let mut ran = Ran { elements: Vec::new(), findings: Vec::new() };
    while ran.elements.len() + ran.findings.len() < MAX_ELEMENTS {
        match execution.next() {
            None => break,
            Some(Ok(element)) => {
                let source = execution.sources().get(usize::from(element.origin.file.0)).expect("a file of the run");
                assert!(element.origin.span.end as usize <= source.bytes().len() + 1, "{element:?}");
                check_numbers(&element);
                ran.elements.push(element);
            }
            Some(Err(finding)) => ran.findings.push(finding),
        }
    }
    assert!(execution.executed_blocks() <= MAX_BLOCKS + 1, "{}", execution.executed_blocks());
    let sources: Vec<&Source> = execution.sources().iter().collect();
    check_findings(&ran.findings, &sources);
    ran
}

/// No number that is none leaves an execution.
fn check_numbers(element: &Element) {
    match &element.kind {
        Kind::Move(step) => {
            assert!(AXES.into_iter().all(|axis| step.target[axis].is_finite()), "{element:?}");
            assert!(step.feed.is_finite() && step.feed >= 0.0, "{element:?}");
            assert!(step.arc.iter().flat_map(|arc| arc.center_mm).all(f64::is_finite), "{element:?}");
        }
        Kind::Dwell(Dwell::Seconds(value) | Dwell::Turns(value)) | Kind::Feed(value) => {
            assert!(value.is_finite() && *value >= 0.0, "{element:?}");
        }
        _ => {}
    }
}

fn execute(name: &str, bytes: &[u8]) {
    let source = source("program", bytes);
    let (machine, _) = machine_of(name);
    let options = options_for(bytes);
    let (program, findings) = syntax::parse(&source, dialect_of(name));
    let whole = run(program, machine, options.clone());
    if findings.is_empty() {
        for page in PAGES {
            if let Some(program) = syntax::parse_by_pages(&source, dialect_of(name), page) {
                let paged = run(program, machine, options.clone());
                let first = paged.elements.iter().zip(&whole.elements).find(|(one, other)| one != other);
                assert!(first.is_none(), "pages of {page} bytes: {first:?}");
                assert_eq!(paged.elements.len(), whole.elements.len(), "pages of {page} bytes");
                assert_eq!(paged.findings, whole.findings, "pages of {page} bytes");
            }
        }
    }
    snc::check(&whole.elements, machine.axis_set());
}
