//! The whole way of a correction: what comes out is a program of the same language, which runs without a finding and ends where the original ends.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_language::exec::{Execution, NoLibrary, Options, RapidOrder};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{self, Arcs, Corrector, Increments, Subdivision};

use super::programs::{dialect_of, machine_of, options_for};
use super::source;

/// Corrects a program of the Sinumerik.
pub fn sinumerik(bytes: &[u8]) {
    correct("sinumerik", bytes);
}

/// Corrects a program of Grundig, Philips.
pub fn grundig(bytes: &[u8]) {
    correct("grundig", bytes);
}

/// Corrects a program of a Fanuc.
pub fn fanuc(bytes: &[u8]) {
    correct("fanuc", bytes);
}

/// Corrects a program of LinuxCNC.
pub fn rs274(bytes: &[u8]) {
    correct("rs274", bytes);
}

/// Moves after which nobody looks.
const MOST_MOVES: usize = 300;
/// The longest path that is corrected, mm: pieces go with it.
const LONGEST_MM: f64 = 20_000.0;
/// How far ends may be apart: the increments of the output, some of which add up in incremental words, mm or rad.
const SAME_END: f64 = 1e-3;

fn correct(name: &str, bytes: &[u8]) {
    let source = source("program", bytes);
    if emit::is_stamped(bytes) {
        return;
    }
    let (machine, errors) = machine_of(name);
    let (program, findings) = syntax::parse(&source, dialect_of(name));
    if !findings.is_empty() {
        return;
    }
    let strict = Options { strict: true, ..options_for(bytes) };
    let Some(original) = elements(Execution::new(program, machine, Box::new(NoLibrary), strict.clone())) else {
        return;
    };
    let wanted = original.iter().rev().find_map(|element| match &element.kind {
        Kind::Move(step) => Some(step.target),
        _ => None,
    });
    // Of a program that does nothing nothing is left.
    let Some(wanted) = wanted.filter(|_| is_short(&original)) else { return };
    let has_errors = bytes.len() % 2 == 1;
    let none = ErrorModel::default();
    let model = Model::new(machine, if has_errors { errors } else { &none });
    let Some(out) = written(name, &original, machine, &model, bytes.len().is_multiple_of(3)) else { return };
    let show = || String::from_utf8_lossy(&out).into_owned();
    let again = super::source("output", &out);
    let (program, findings) = syntax::parse(&again, dialect_of(name));
    assert!(findings.is_empty(), "{findings:?}\n{}", show());
    let options = Options { rapid_order: RapidOrder::None, max_blocks: Some(1_000_000), ..strict };
    let mut end = AxisVector::ZERO;
    for item in Execution::new(program, machine, Box::new(NoLibrary), options) {
        match item {
            Ok(Element { kind: Kind::Move(step), .. }) => end = step.target,
            Ok(_) => {}
            Err(finding) => assert!(!finding.is_error(), "{finding:?}\n{}", show()),
        }
    }
    if !has_errors {
        let off = |axis| (wanted[axis] - end[axis]).abs();
        assert!(AXES.into_iter().all(|axis| off(axis) <= SAME_END), "{wanted:?} became {end:?}\n{}", show());
    }
}

/// The elements of a run without an error that is not too long.
fn elements(execution: Execution<'_>) -> Option<Vec<Element>> {
    let mut elements = Vec::new();
    let mut moves = 0;
    for item in execution {
        let element = item.ok()?;
        moves += usize::from(matches!(element.kind, Kind::Move(_)));
        if moves > MOST_MOVES {
            return None;
        }
        elements.push(element);
    }
    Some(elements)
}

/// Whether the path has a length that is corrected in no time.
fn is_short(elements: &[Element]) -> bool {
    let mut length_mm = 0.0;
    let mut last: Option<AxisVector> = None;
    for element in elements {
        let Kind::Move(step) = &element.kind else { continue };
        let from = last.replace(step.target).unwrap_or(step.target);
        // A turn of a rotary axis counts as one with an arm of 1 m.
        length_mm += AXES
            .into_iter()
            .map(|axis| (step.target[axis] - from[axis]).abs() * if axis.is_rotary() { 1000.0 } else { 1.0 })
            .sum::<f64>();
        if let Some(arc) = &step.arc {
            let radius_mm = arc.center_from_start_mm(&from).norm();
            length_mm += radius_mm * 6.3 * f64::from(arc.extra_turns + 1);
        }
    }
    length_mm < LONGEST_MM
}

/// The corrected text; `None` where the correction is refused.
fn written(name: &str, elements: &[Element], machine: &Machine, model: &Model, has_steps: bool) -> Option<Vec<u8>> {
    let entry = emit::entry(name).expect("the dialect has a writer");
    let options = path::CorrectionOptions {
        tolerance_mm: 0.005,
        turns: entry.turns,
        subdivision: if has_steps { Subdivision::Step(20.0) } else { Subdivision::Adaptive },
        arcs: if has_steps { Arcs::Chords } else { Arcs::Keep },
        ..path::CorrectionOptions::default()
    };
    let stamp = Stamp { machine: "m".into(), model: "0".into(), source: "1".into(), ..Stamp::default() };
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame: options.frame,
        crlf: false,
        last_block_number: machine.control.last_block_number,
        has_centers_reversed: false,
        stamp,
    };
    let mut writer = (entry.create)(&writer_options).expect("the sample has increments that can be written");
    let stream = elements.iter().cloned().map(Ok::<Element, Diagnostic>);
    let mut corrector = Corrector::new(stream, machine, model, options);
    let mut out = Vec::new();
    let mut is_refused = false;
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| is_refused |= finding.is_error())
        .expect("memory takes all");
    (!is_refused).then_some(out)
}
