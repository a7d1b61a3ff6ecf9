//! Programs in rotated, mirrored, scaled and tilted frames, corrected on a machine with errors, written and executed again from their text.

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Grouping, Increments, Output, OutputFrame, Piece, compare};

use crate::bench_machine::{Random, load_machine, tired};
use crate::machines::xyz_machine;

/// Elements of a program without findings.
fn elements(text: &str, machine: &Machine) -> Vec<Element> {
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    assert!(findings.is_empty(), "{findings:?}");
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    Execution::new(program, machine, Box::new(NoLibrary), strict)
        .map(|item| item.unwrap_or_else(|found| panic!("{found:?}\n{text}")))
        .collect()
}

/// A corrected program: its text, its pieces and its findings.
pub(crate) struct Corrected {
    pub(crate) text: String,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) findings: Vec<Diagnostic>,
    pub(crate) max_mm: f64,
}

pub(crate) fn corrected(text: &str, machine: &Machine, errors: &ErrorModel, options: &CorrectionOptions) -> Corrected {
    let model = Model::new(machine, errors);
    let stream = elements(text, machine).into_iter().map(Ok);
    let mut corrector = Corrector::new(stream, machine, &model, options.clone());
    let stamp = Stamp { machine: "shop".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() };
    let increments = Increments::new(&machine.control);
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments,
        frame: options.frame,
        crlf: false,
        stamp,
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut writer = emit::writer("sinumerik", &writer_options).unwrap();
    let (mut out, mut pieces, mut findings) = (Vec::new(), Vec::new(), Vec::new());
    for output in corrector.by_ref() {
        match output {
            Ok(output) => {
                writer.write(&output, &mut out).unwrap();
                if let Output::Piece(piece) = output {
                    pieces.push(piece);
                }
            }
            Err(found) => findings.push(found),
        }
    }
    writer.finish(&mut out);
    let max_mm = corrector.prediction().after().max_mm;
    Corrected { text: String::from_utf8(out).unwrap(), pieces, findings, max_mm }
}

/// Corrects a program and executes the result: the axes go where the corrector said, the error is what it predicted and within the
/// tolerance. Gives the text.
#[track_caller]
pub(crate) fn check(text: &str, machine: &Machine, errors: &ErrorModel, options: &CorrectionOptions) -> Corrected {
    let done = corrected(text, machine, errors, options);
    assert!(done.findings.is_empty(), "{:?}", done.findings);
    let again = elements(&done.text, machine);
    let moves: Vec<_> = again
        .iter()
        .filter_map(|element| match &element.kind {
            Kind::Move(motion) => Some(motion),
            _ => None,
        })
        .collect();
    assert_eq!(moves.len(), done.pieces.len(), "{}", done.text);
    for (motion, piece) in moves.iter().zip(&done.pieces) {
        let off = (motion.target - piece.command).max_abs(&AXES);
        assert!(off < 1e-8, "{off}: {piece:?}\n{}", done.text);
        assert_eq!(motion.arc.is_some(), piece.arc.is_some(), "{}", done.text);
    }
    let model = Model::new(machine, errors);
    let original = elements(text, machine);
    let compared = compare(original.into_iter(), again.into_iter(), Grouping::ByMarks, machine, &model);
    let compared = compared.unwrap_or_else(|found| panic!("{found:?}\n{}", done.text));
    // The tolerance and the rounding of three axes.
    let limit_mm = options.tolerance_mm + 2.0 * machine.control.increment_mm;
    assert!(compared.after.max_mm < limit_mm, "{compared:?}\n{}", done.text);
    assert!(compared.before.max_mm > 5.0 * limit_mm, "{compared:?}");
    assert!((compared.after.max_mm - done.max_mm).abs() < 2e-4, "{} {compared:?}", done.max_mm);
    done
}

const PART: &str = "G1 X60 Y0 F500\nX60 Y40\nG3 X40 Y60 I-20 J0\nG2 X40 Y60 I0 J-15\nG3 X-20 Y20 Z-3 CR=80\nG1 X0 Y0 Z0\n\
                    G91 X10 Y-3 Z2\nG90\nX0\nM30\n";

/// Frames, and if arcs of the plane stay arcs in coordinates of the program and of the machine. In the latter G17 is in force, so that arcs of other
/// planes are chords.
const FRAMES: &[(&str, [bool; 2])] = &[
    ("ROT Z33", [true; 2]),
    ("TRANS X20 Y-10 Z5\nAROT RPL=-120", [true; 2]),
    ("MIRROR X0", [true; 2]),
    ("MIRROR X0\nAMIRROR Y0", [true; 2]),
    ("TRANS X5\nAMIRROR Z0\nAROT Z70", [true; 2]),
    ("SCALE X1.5 Y1.5 Z1.5", [true; 2]),
    ("SCALE X2 Y0.5", [false; 2]),
    ("ROT X20 Y-35 Z15", [true, false]),
    ("ROTS X20 Y10\nATRANS X10\nASCALE X1.3 Y1.3 Z1.3", [true, false]),
    ("ROT X90", [true, false]),
    ("AROT Y-90\nAMIRROR Y0", [true, false]),
];

#[test]
fn programs_in_every_frame_come_out_corrected_in_this_frame() {
    let machine = xyz_machine();
    let errors = tired(&mut Random(7));
    for &(frame, keeps_arcs) in FRAMES {
        for output in [OutputFrame::Work, OutputFrame::Machine] {
            let program = format!("G17 G90 G71 G54\n{frame}\nG0 X0 Y0 Z0\n{PART}");
            let options = CorrectionOptions { frame: output, max_correction_mm: 1.0, ..CorrectionOptions::default() };
            let done = check(&program, &machine, &errors, &options);
            let can_be_arcs = keeps_arcs[usize::from(output == OutputFrame::Machine)];
            assert_eq!(
                done.pieces.iter().any(|piece| piece.arc.is_some()),
                can_be_arcs,
                "{frame} {output:?}\n{}",
                done.text
            );
            for statement in frame.lines().filter(|_| output == OutputFrame::Work) {
                let word = statement.split_whitespace().next().unwrap();
                assert!(done.text.contains(word), "{}", done.text);
            }
        }
    }
}

/// Under a mirror the written arc keeps the sense of the program: the control swaps it.
#[test]
fn arcs_keep_the_sense_of_the_program_under_a_mirror() {
    let machine = xyz_machine();
    let errors = tired(&mut Random(8));
    let program = "G17 G90 G71 G54\nMIRROR X0\nG0 X0 Y0 Z0\nG3 X20 Y0 I10 J0 F500\nG2 X0 Y0 I-10 J0\nM30\n";
    let options = CorrectionOptions { max_correction_mm: 1.0, ..CorrectionOptions::default() };
    let done = check(program, &machine, &errors, &options);
    let senses: Vec<bool> = done.pieces.iter().filter_map(|piece| piece.arc).map(|arc| arc.clockwise).collect();
    let turned = senses.iter().position(|clockwise| *clockwise).unwrap();
    assert!(turned > 0 && senses[..turned].iter().all(|c| !c) && senses[turned..].iter().all(|c| *c), "{senses:?}");
}

/// The increments are those of the program: under a scale of 10 the axes move in steps ten times as coarse.
#[test]
fn rounding_is_that_of_programmed_values() {
    let machine = xyz_machine();
    let errors = ErrorModel::default();
    let program = "G17 G90 G71 G54\nSCALE X10\nG0 X0 Y0 Z0\nG1 X1.23456789 Y1.23456789 F500\nM30\n";
    let done = corrected(program, &machine, &errors, &CorrectionOptions::default());
    let piece = done.pieces.last().unwrap();
    assert_eq!(piece.counts[..2], [12_346, 12_346]);
    assert!((piece.command.0[0] - (100.0 + 12.346)).abs() < 1e-9 && (piece.command.0[1] - 51.2346).abs() < 1e-9);
    assert!(done.text.contains("SCALE X10\n"), "{}", done.text);
}

/// An axis of the frame that the program has not stated is not written, and does not move.
#[test]
fn an_axis_that_is_not_stated_in_a_tilted_frame_stays() {
    let machine = xyz_machine();
    let errors = tired(&mut Random(9));
    let program = "G17 G90 G71 G54\nROT X20 Y-35 Z15\nG0 X10 Y20\nG0 Z5\nG1 X30 F500\nM30\n";
    let options = CorrectionOptions { max_correction_mm: 1.0, ..CorrectionOptions::default() };
    let done = corrected(program, &machine, &errors, &options);
    assert!(done.findings.is_empty());
    let lines: Vec<&str> = done.text.lines().filter(|line| line.contains("G0") || line.contains("G1 ")).collect();
    assert!(lines[0].contains('X') && lines[0].contains('Y') && !lines[0].contains('Z'), "{}", done.text);
    assert!(lines[1].contains('X') && lines[1].contains('Y') && lines[1].contains('Z'), "{}", done.text);
    // In machine coordinates all three axes would have to be written.
    let refused = corrected(program, &machine, &errors, &CorrectionOptions { frame: OutputFrame::Machine, ..options });
    assert_eq!(refused.findings[0].code.to_string(), "E0304");
}

#[test]
fn a_tilted_frame_on_a_machine_with_rotary_axes() {
    let (machine, errors) = load_machine("esmaeili_huron");
    let start = AxisVector::ZERO;
    let limits = |axis| machine.axis(axis).unwrap().travel.unwrap();
    let middle = AXES[..3].iter().map(|&axis| (limits(axis)[0] + limits(axis)[1]) / 2.0).collect::<Vec<_>>();
    let program = format!(
        "G17 G90 G71\nTRANS X{} Y{} Z{}\nAROT Y20 X-10\nG0 A0 C30 X0 Y0 Z0\nG1 X40 F500\nY20 Z-5\nG3 X20 Y40 I-20 J0\nM30\n",
        middle[0], middle[1], middle[2]
    );
    assert_eq!(start, AxisVector::ZERO);
    check(&program, &machine, &errors, &CorrectionOptions { max_correction_mm: 5.0, ..CorrectionOptions::default() });
}
