//! Two programs side by side on the error model.

use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::AXES;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, TextReader};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::path::{
    Arcs, Comparison, CorrectionOptions, Grouping, Increments, Piece, Rapids, Rotary, Subdivision, compare,
};

use crate::bench_machine::{Random, backlash, correct, load_machine, motion, tired};
use crate::machines::xyz_machine;

const PATH: &str = "G0 X0 Y0 Z0\nG0 X-50 Y20 Z5\nG1 X250.5 Y-30 Z-10 F500\nG1 X250.5 Y-30 Z-10 F500\nG1 X250.55 Y-30 Z-10 F500\n\
    G1 X250.6 Y-29.99 Z-10 F500\nG3 X250.6 Y-29.99 Z-10 I-40 J0 P17 F500\nG2 X180 Y-30 Z-12 I-35.3 J-0.005 P17 L1 F500\n\
    G1 X-200 Y-30 Z-12 F500\nG0 X0 Y0 Z50\n";

fn elements(text: &str) -> impl Iterator<Item = Element> + '_ {
    TextReader::new(text).map(Result::unwrap)
}

/// The pieces as SNC text.
fn text_of(pieces: &[Piece], machine: &Machine) -> String {
    let increments = Increments::new(&machine.control);
    let mut text = String::new();
    for piece in pieces {
        let code = match (piece.rapid, &piece.arc) {
            (true, _) => "G0",
            (false, None) => "G1",
            (false, Some(arc)) if arc.clockwise => "G2",
            (false, Some(_)) => "G3",
        };
        text.push_str(code);
        for axis in AXES.into_iter().filter(|&axis| piece.words.contains(axis)) {
            let position = increments.position(axis, piece.counts[axis.slot()]);
            let position = if axis.is_rotary() { position.to_degrees() } else { position };
            text.push_str(&format!(" {axis}{position:.6}"));
        }
        if let Some(arc) = &piece.arc {
            let [i, j, k] = arc.center_counts.map(|count| count as f64 * increments.linear_mm);
            text.push_str(&format!(" I{i:.6} J{j:.6} K{k:.6} P{} L{}", arc.plane.number(), arc.extra_turns));
        }
        text.push_str(" F500\n");
    }
    text
}

fn compared(original: &str, corrected: &str, machine: &Machine, errors: &ErrorModel) -> Comparison {
    compare(elements(original), elements(corrected), Grouping::ByPlace, machine, &Model::new(machine, errors)).unwrap()
}

/// Corrects, compares the text with the original, and demands what the corrector predicted.
#[track_caller]
fn agrees(original: &str, machine: &Machine, errors: &ErrorModel, options: CorrectionOptions) {
    let run = correct(original, machine, errors, options.clone());
    let found = compared(original, &text_of(&run.pieces, machine), machine, errors);
    let predicted = &run.prediction;
    assert!(found.samples > 100);
    // Where on the way a piece ends is found by the nearest place, which hides rounding along the way: some nm.
    let same = |found: f64, predicted: f64| (found - predicted).abs() <= 0.03 * predicted + 1e-5;
    assert!(same(found.before.mean_mm(), predicted.before().mean_mm()), "{options:?} {found:?} {predicted:?}");
    assert!(same(found.after.mean_mm(), predicted.after().mean_mm()), "{options:?} {found:?} {predicted:?}");
    assert!(found.after.max_mm <= 1.15 * predicted.after().max_mm, "{options:?} {found:?} {predicted:?}");
}

#[test]
fn a_comparison_finds_what_was_predicted() {
    let machine = xyz_machine();
    let mut random = Random(31);
    for _ in 0..4 {
        let errors = tired(&mut random);
        for options in [
            CorrectionOptions::default(),
            CorrectionOptions { arcs: Arcs::Chords, tolerance_mm: 4e-3, ..CorrectionOptions::default() },
            CorrectionOptions { rapids: Rapids::None, ..CorrectionOptions::default() },
            CorrectionOptions { rapids: Rapids::All, tolerance_mm: 3e-4, ..CorrectionOptions::default() },
            CorrectionOptions { subdivision: Subdivision::Step(7.0), ..CorrectionOptions::default() },
        ] {
            agrees(PATH, &machine, &errors, options);
        }
    }
}

#[test]
fn reversals_and_their_steps_on_the_spot_are_followed() {
    let errors = ErrorModel {
        motion: vec![motion("EXX", backlash(-6.0)), motion("EYY", backlash(-3.0))],
        ..tired(&mut Random(12))
    };
    agrees(PATH, &xyz_machine(), &errors, CorrectionOptions::default());
}

#[test]
fn rotary_axes_may_be_corrected_or_not() {
    let (machine, errors) = load_machine("esmaeili_xyz5");
    let text = "G0 X0 Y0 Z200 B0 C0\nG1 X50 Y40 Z120 B10 C30 F500\nG1 X-60 Y40 Z80 B-35 C-120 F500\n\
                G3 X-40 Y60 Z80 I20 J0 P17 F500\nG1 B20 C0 F500\nG1 C720 F500\n";
    for rotary in [Rotary::Correct, Rotary::Hold] {
        agrees(text, &machine, &errors, CorrectionOptions { rotary, ..CorrectionOptions::default() });
    }
}

#[test]
fn a_program_beside_itself_has_the_same_errors() {
    let errors = tired(&mut Random(77));
    let found = compared(PATH, PATH, &xyz_machine(), &errors);
    assert_eq!(found.before, found.after);
    assert!(found.before.mean_mm() > 5e-3 && found.samples > 500);
    let best = compared(PATH, PATH, &xyz_machine(), &ErrorModel::default());
    assert_eq!(best.after.max_mm, 0.0);
}

#[test]
fn programs_of_different_paths_cannot_be_compared() {
    let machine = xyz_machine();
    let model = Model::new(&machine, &tired(&mut Random(2)));
    let line = |x: &str| PATH.replace("G1 X-200 Y-30", x);
    for other in [
        line("G1 X-190 Y-30"),
        line("G0 X-200 Y-30"),
        PATH.lines().take(6).collect::<Vec<_>>().join("\n"),
        format!("{PATH}G1 X10 F500\n"),
    ] {
        let finding = compare(elements(PATH), elements(&other), Grouping::ByPlace, &machine, &model).unwrap_err();
        assert_eq!(finding.code, Code::CANNOT_ALIGN, "{other}");
    }
}
