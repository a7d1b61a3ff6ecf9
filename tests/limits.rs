//! What the corrector refuses or warns of: travel, the size of corrections, tolerances that cannot be kept.

use ncfix_base::diagnostic::Code;
use ncfix_model::ErrorModel;
use ncfix_path::path::CorrectionOptions;

use crate::bench_machine::{Random, correct, motion, polynomial, table, tired};
use crate::machines::xyz_machine;

#[test]
fn positions_outside_the_travel_are_found_once_a_line() {
    let mut machine = xyz_machine();
    machine.axes[0].as_mut().unwrap().travel = Some([0.0, 100.0]);
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[-0.005]))], ..ErrorModel::default() };
    let run = correct("G0 X0 Y0 Z0\nG1 X100 F500\nG1 X50 F500\n", &machine, &errors, CorrectionOptions::default());
    // 5 µm short, so the corrected command is 5 µm beyond the limit; within it nothing is said.
    assert_eq!(run.findings.len(), 1, "{:?}", run.findings);
    assert_eq!(run.findings[0].code, Code::OUT_OF_TRAVEL);
    assert_eq!(run.findings[0].message, "X 100.0050 mm is above the limit of 100 mm");
    // The far side of a circle counts, though both its ends are inside.
    let circle = correct(
        "G0 X60 Y0 Z0\nG3 X60 Y0 Z0 I-40 J0 P17 F500\n",
        &machine,
        &ErrorModel::default(),
        CorrectionOptions::default(),
    );
    assert_eq!(circle.findings.len(), 1);
    assert_eq!(circle.findings[0].message, "during this move X reaches -20.0000 mm, below the limit of 0 mm");
}

#[test]
fn a_move_in_pieces_that_ends_outside_is_said_with_its_end() {
    let mut machine = xyz_machine();
    machine.axes[0].as_mut().unwrap().travel = Some([0.0, 100.0]);
    // 1 µm per mm², so that the moves are cut.
    let errors = ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6]))], ..ErrorModel::default() };
    let message = |text: &str| {
        let run = correct(
            text,
            &machine,
            &errors,
            CorrectionOptions { tolerance_mm: 0.0005, ..CorrectionOptions::default() },
        );
        assert!(run.pieces.len() > 3, "{}", run.pieces.len());
        assert_eq!(run.findings.len(), 1, "{:?}", run.findings);
        run.findings[0].message.clone()
    };
    assert_eq!(message("G0 X0 Y0 Z0\nG1 X180 F500\n"), "X 180.0000 mm is above the limit of 100 mm");
    // Three quarters of a circle of radius 40 about (90, 0): past X130 and X50 to (90, -40).
    let arc = "G0 X90 Y40 Z0\nG2 X50 Y0 I0 J-40 P17 F500\n";
    assert_eq!(message(arc), "during this move X reaches 130.0000 mm, above the limit of 100 mm");
    // About (110, 0) with radius 40, from (70, 0) over the top to (150, 0), and on to (110, -40).
    let over = "G0 X70 Y0 Z0\nG2 X110 Y-40 I40 J0 P17 F500\n";
    assert_eq!(message(over), "X 110.0000 mm is above the limit of 100 mm");
}

#[test]
fn a_rapid_to_the_end_of_an_axis_stays_there() {
    let mut machine = xyz_machine();
    machine.axes[2].as_mut().unwrap().travel = Some([-500.0, 0.0]);
    let errors = ErrorModel {
        motion: vec![motion("EZZ", polynomial(&[-0.005])), motion("EXX", polynomial(&[0.003]))],
        ..ErrorModel::default()
    };
    // Each rapid move is the approach to a cut; others stay as they are anyway.
    let cut = "G1 X0 Y0 Z-12 F500\n";
    let text = format!("G0 X0 Y0 Z-10\n{cut}G0 X0 Y0 Z0\n{cut}G0 X0 Y0 Z-10\n{cut}G0 X0 Y0 Z0.001\n{cut}");
    let run = correct(&text, &machine, &errors, CorrectionOptions::default());
    let rapids = run.pieces.iter().filter(|piece| piece.rapid);
    let counts: Vec<[i64; 3]> = rapids.map(|piece| [0, 1, 2].map(|slot| piece.counts[slot])).collect();
    // Increments of 0.1 µm: X 3 µm too far, Z 5 µm short.
    assert_eq!(counts[..3], [[-30, 0, -99_950], [0, 0, 0], [-30, 0, -99_950]]);
    // What the program itself puts outside is found.
    let messages: Vec<&str> = run.findings.iter().map(|finding| finding.message.as_str()).collect();
    // So is a cut from the very end, which cannot be corrected there.
    let of_cut = "during this move Z reaches 0.0050 mm, above the limit of 0 mm";
    assert_eq!(messages, [of_cut, "Z 0.0060 mm is above the limit of 0 mm"]);
}

#[test]
fn corrections_that_are_too_large_are_found_and_bounded() {
    let errors = ErrorModel { motion: vec![motion("EXX", polynomial(&[0.25]))], ..ErrorModel::default() };
    let mut text = String::from("G0 X0 Y0 Z0\n");
    (0..300).for_each(|k| text.push_str(&format!("G1 X{k} F500\n")));
    let run = correct(&text, &xyz_machine(), &errors, CorrectionOptions::default());
    assert!(run.findings.iter().all(|finding| finding.code == Code::CORRECTION_TOO_LARGE));
    assert_eq!(run.findings.len(), 100);
    let wide = CorrectionOptions { max_correction_mm: 0.3, ..CorrectionOptions::default() };
    assert!(correct(&text, &xyz_machine(), &errors, wide).findings.is_empty());
}

#[test]
fn a_step_in_the_errors_is_met_with_a_warning_and_few_pieces() {
    // 10 µm within 1 µm of travel: steeper than the shortest piece.
    let errors = ErrorModel {
        motion: vec![motion("EYX", table(&[0.0, 50.0, 50.001, 100.0], &[0.0, 0.0, 10.0, 10.0]))],
        ..ErrorModel::default()
    };
    let run = correct("G0 X0 Y0 Z0\nG1 X100 F500\n", &xyz_machine(), &errors, CorrectionOptions::default());
    assert_eq!(run.findings.iter().map(|finding| finding.code).collect::<Vec<_>>(), [Code::TOLERANCE_NOT_REACHED]);
    assert!(run.pieces.len() < 20, "{}", run.pieces.len());
}

#[test]
fn a_coarse_increment_does_not_cut_moves_to_pieces() {
    let mut machine = xyz_machine();
    machine.control.increment_mm = 0.01;
    let errors = tired(&mut Random(11));
    let text = "G0 X0 Y0 Z0\nG1 X300.123 Y200.321 Z-30.7 F500\nG1 X10 Y100 Z5 F500\n";
    let run = correct(text, &machine, &errors, CorrectionOptions::default());
    // 5 µm of rounding per axis, and a tolerance of 1 µm: it cannot be kept, and more blocks would not help.
    assert!(run.pieces.len() < 80, "{}", run.pieces.len());
    assert!(run.findings.iter().any(|finding| finding.code == Code::TOLERANCE_NOT_REACHED));
    assert!(run.prediction.after().max_mm < 0.01);
}
