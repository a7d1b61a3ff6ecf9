//! Positioning axes: moves of their own, written as POS again.

use ncfix_model::ErrorModel;
use ncfix_path::path::{CorrectionOptions, Rapids};

use crate::bench_machine::{motion, polynomial};
use crate::exec::{check as check_moves, check_codes};
use crate::machines::xyz_machine;
use crate::modes::{check, codes, written};

#[test]
fn positions_of_axes_are_moves_at_rapid() {
    check_moves(
        "G90 G1 X1 Y2 Z3 F100\nPOS[X]=10 FA[X]=500\nPOS[Y]=IC(5) POS[Z]=AC(7)\nG91 POS[X]=-4\nPOS[X1]=1 G90\nX0\nM30",
        &["G1 X1 Y2 Z3 F100", "G0 X10 Y2 Z3", "G0 X10 Y7 Z7", "G0 X6 Y7 Z7", "G0 X1 Y7 Z7", "G1 X0 Y7 Z7 F100"],
    );
    check(
        "N10 G90 G1 X1 Y2 Z3 F100\nN20 POS[X]=10 FA[X]=500 M8\nN30 POS[Y]=IC(5) POS[Z]=7\nN40 G91 POS[X]=-4\nN50 G90 X0\nM30",
        &[
            "N10 G90 G1 X1 Y2 Z3 F100",
            "N20 FA[X]=500 POS[X]=10 M8",
            "N30 POS[Y]=7 POS[Z]=7",
            "N40 G90 POS[X]=6",
            "N50 G90 G1 X0",
            "M30",
        ],
    );
}

#[test]
fn their_ends_are_corrected_and_the_other_axes_follow() {
    // EYX = 1e-6 x^2: Y is told 0.009998 less at X = 99.990001; EXX = 1e-4 x: X is told 100 / 1.0001 = 99.990001; increment 0.0001.
    let errors = ErrorModel {
        motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6])), motion("EXX", polynomial(&[0.0, 1e-4]))],
        ..ErrorModel::default()
    };
    let text = "G90 G1 X0 Y0 Z0 F100\nPOS[X]=100";
    for rapids in [Rapids::Ends, Rapids::All] {
        let options = CorrectionOptions { rapids, ..CorrectionOptions::default() };
        let (lines, codes) = written(&format!("{text}\nG1 Z1\nM30"), &xyz_machine(), &errors, options.clone());
        assert_eq!(lines[1], "POS[X]=99.99 POS[Y]=-0.01", "{rapids:?}");
        // The bow of 2.5 um is only looked for where rapid moves are to be corrected along their way.
        let expected: &[&str] = if rapids == Rapids::All { &["W0307"] } else { &[] };
        assert_eq!(codes, expected);
        // Without a cut behind it only the axis named moves.
        let (lines, _) = written(&format!("{text}\nM30"), &xyz_machine(), &errors, options);
        assert_eq!(lines[1..], ["POS[X]=99.99", "M30"].map(str::to_owned), "{rapids:?}");
    }
    let options = CorrectionOptions { rapids: Rapids::None, ..CorrectionOptions::default() };
    assert_eq!(written(text, &xyz_machine(), &errors, options).0[1], "POS[X]=100");
}

#[test]
fn axes_that_are_not_modelled_are_passed_on() {
    check(
        "N10 G90 G1 X1 Y2 Z3 F100\nN20 POS[V]=10 FA[V]=500 X5\nN30 POSA[Q1]=R1+3 Y5\nN40 G91 POS[Q1]=3 X2\nN50 POS[C]=DC(90) G90\nN60 WAITP(Q1)\nM30",
        &[
            "N10 G90 G1 X1 Y2 Z3 F100",
            "N20 POS[V]=10 FA[V]=500 G1 X5",
            "N30 POSA[Q1]=3 G1 Y5",
            "N40 G90 POS[Q1]=IC(3) G1 X7",
            "N50 G90 POS[C]=DC(90)",
            "N60 WAITP(Q1)",
            "M30",
        ],
    );
    check("G90 G70 G1 X1 Y0 Z0 F100\nPOS[V]=2\nM30", &["G90 G71 G1 X25.4 Y0 Z0 F100", "POS[V]=50.8", "M30"]);
    assert_eq!(codes("G90 G70 G1 X1 Y0 Z0 F100\nPOS[Q1]=2\nM30"), ["E0201"]);
}

#[test]
fn a_thread_in_force_is_no_matter_of_a_positioning_axis() {
    assert!(codes("G90 G0 X0 Y0 Z50\nG331 Z30 K1 S100\nG332 Z50 K1\nPOS[X]=5\nM30").is_empty());
    assert!(codes("G90 G0 X0 Y0 Z50 S100\nG33 Z30 K1\nPOS[X]=5\nM30").is_empty());
}

#[test]
fn what_runs_beside_the_path_is_refused() {
    let found = |block: &str| codes(&format!("G90 G1 X1 Y2 Z3 F100\n{block}\nM30"));
    assert_eq!(found("POS[X]=10 Y5"), ["E0201"]);
    assert_eq!(found("POSA[X]=10"), ["E0201"]);
    assert_eq!(found("X1 POS[X]=10"), ["E0111"]);
    assert_eq!(found("POS[SPINDLE_AXIS]=10"), ["E0206"]);
    assert_eq!(found("ROT RPL=30\nPOS[X]=10\nTRANS"), ["E0201"]);
    check_codes("G90 G0 X0 Y0 Z5\nOFFN=5 G41 G1 X9 F100\nY9\nPOS[X]=20\nG40 G1 X0\nM30", &["E0201:4"]);
}
