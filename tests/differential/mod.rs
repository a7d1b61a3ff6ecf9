//! Random programs with expressions, jumps, loops, repetitions and calls, in three languages, beside arithmetic that shares no code with the
//! executors: a tree is drawn, evaluated as a tree ([`evaluate`]), written as a program, read and executed.
//!
//! Each language gets 300 programs, or as many as `NCFIX_DIFFERENTIAL` says, from the seed `NCFIX_DIFFERENTIAL_SEED` (1) on. A failure prints
//! the seed and the program.

mod evaluate;
mod fanuc;
mod grundig;
mod sinumerik;
mod text;
mod tree;

use ncfix_base::geometry::Axis;
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::{DecimalPoint, Machine};
use ncfix_machine::snc::Kind;
use ncfix_model::file;

use crate::bench_machine::Random;
use crate::support::repository;
use evaluate::Rules;
use tree::Tree;

/// Positions agree to this part of a millimeter: values are sums and products of a few numbers below 10⁷ in double precision.
const AGREE_MM: f64 = 1e-6;

struct Language {
    name: &'static str,
    rules: Rules,
    write: fn(&Tree, &mut Random) -> String,
}

const LANGUAGES: &[Language] = &[
    // Comparisons of REAL: Programming Manual Job Planning, "Comparison and logic operations".
    Language {
        name: "sinumerik",
        rules: Rules { relative_equality: 1e-12, increment_mm: None, rounds_to_increment: false },
        write: sinumerik::write,
    },
    // Values of addresses: B-63944EN, custom macro, "rounded to the least input increment", IS-B.
    Language {
        name: "fanuc",
        rules: Rules { relative_equality: 0.0, increment_mm: Some(1e-3), rounds_to_increment: true },
        write: fanuc::write,
    },
    // Values of words: M700 manual, "floating to fixed conversion", three decimals.
    Language {
        name: "grundig",
        rules: Rules { relative_equality: 0.0, increment_mm: Some(1e-3), rounds_to_increment: false },
        write: grundig::write,
    },
];

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| text.parse().unwrap())
}

/// The machine of the cases, without ends of travel and offsets.
fn machine(language: &str) -> Machine {
    let path = repository(&format!("tests/cases/machines/{language}.toml"));
    let source = Source::new(FileId(0), "machine", std::fs::read(path).unwrap()).unwrap();
    let (loaded, findings) = file::load(&source);
    let mut machine = loaded.unwrap_or_else(|| panic!("{findings:?}")).0;
    machine.axes.iter_mut().flatten().for_each(|axis| axis.travel = None);
    machine.zero_offsets.values_mut().for_each(|offset| *offset = Default::default());
    machine.control.iso.decimal_point = Some(DecimalPoint::Calculator);
    machine
}

/// Positions of all moves of a program, or why there are none.
fn executed(language: &str, machine: &Machine, text: &str) -> Result<Vec<[f64; 3]>, String> {
    let dialect = ncfix_dialect::find(language).unwrap();
    let source = Source::new(FileId(0), "program", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, dialect);
    if let Some(finding) = findings.first() {
        return Err(format!("{finding:?}"));
    }
    let mut found = Vec::new();
    for item in Execution::new(program, machine, Box::new(NoLibrary), Options::default()) {
        match item {
            Ok(element) => {
                if let Kind::Move(step) = element.kind {
                    found.push([step.target[Axis::X], step.target[Axis::Y], step.target[Axis::Z]]);
                }
            }
            Err(finding) if finding.is_error() => return Err(format!("{finding:?}")),
            Err(_) => {}
        }
    }
    Ok(found)
}

/// Positions without those that repeat the one before: whether a move on the spot is an element is not the question here.
fn changes(positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    for position in positions {
        if !kept.last().is_some_and(|last| are_one(last, position)) {
            kept.push(*position);
        }
    }
    kept
}

fn are_one(left: &[f64; 3], right: &[f64; 3]) -> bool {
    left.iter().zip(right).all(|(left, right)| (left - right).abs() <= AGREE_MM)
}

/// Compares programs of one language until enough had an answer.
fn compare(language: &Language) {
    let wanted = setting("NCFIX_DIFFERENTIAL", 300);
    let first = setting("NCFIX_DIFFERENTIAL_SEED", 1);
    let machine = machine(language.name);
    let (mut compared, mut moves, mut seed) = (0, 0, first);
    while compared < wanted {
        assert!(seed - first < 20 * wanted, "{}: {compared} of {} trees have an answer", language.name, seed - first);
        let mut random = Random(seed);
        seed += 1;
        let tree = tree::draw(&mut random);
        let Ok(expected) = evaluate::positions(&tree, language.rules) else { continue };
        let text = (language.write)(&tree, &mut random);
        let shown = || format!("{} seed {}\n{text}", language.name, seed - 1);
        let found = executed(language.name, &machine, &text).unwrap_or_else(|why| panic!("{why}\n{}", shown()));
        let (expected, found) = (changes(&expected), changes(&found));
        let is_same = expected.len() == found.len() && expected.iter().zip(&found).all(|(e, f)| are_one(e, f));
        if !is_same {
            let at = expected.iter().zip(&found).take_while(|(e, f)| are_one(e, f)).count();
            panic!("move {at}: {:?} expected, {:?} found\n{}", expected.get(at), found.get(at), shown());
        }
        compared += 1;
        moves += found.len();
    }
    // Programs that do nothing would agree, too.
    assert!(moves as u64 > 4 * wanted, "{}: {moves} moves in {wanted} programs", language.name);
}

#[test]
fn sinumerik_programs_do_what_their_trees_say() {
    compare(&LANGUAGES[0]);
}

#[test]
fn fanuc_programs_do_what_their_trees_say() {
    compare(&LANGUAGES[1]);
}

#[test]
fn grundig_programs_do_what_their_trees_say() {
    compare(&LANGUAGES[2]);
}
