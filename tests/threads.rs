//! Threads: straight moves in one piece, their words passed on.

use ncfix_model::ErrorModel;
use ncfix_path::path::{CorrectionOptions, Subdivision};

use crate::bench_machine::{motion, polynomial};
use crate::exec::{check as check_moves, check_codes, run};
use crate::machines::xyz_machine;
use crate::modes::{check, codes, written};

/// EZZ = 1e-3 z: Z is told z / 1.001. EXZ = 1e-4 z^2 / 100: a bow of Z.
fn bent() -> ErrorModel {
    ErrorModel { motion: vec![motion("EXZ", polynomial(&[0.0, 0.0, 1e-6]))], ..ErrorModel::default() }
}

#[test]
fn threads_are_straight_moves_without_feed() {
    check_moves(
        "N10 G90 G0 X10 Y20 Z5 S100 M3\nN20 G33 Z-10 K2 SF=30\nN30 Z-20 K1.5\nN40 G34 Z-30 K2 F0.1\nN50 G35 Z-40 K3 F0.1\nN60 G1 X0 F200\nM30",
        &[
            "G0 X10 Y20 Z5",
            "G1 X10 Y20 Z-10",
            "G1 X10 Y20 Z-20",
            "G1 X10 Y20 Z-30",
            "G1 X10 Y20 Z-40",
            "G1 X0 Y20 Z-40 F200",
        ],
    );
    check_moves(
        "G90 G1 X0 Y0 Z5 F80\nG331 Z=IC(-15) K-0.8 S300\nG332 Z5 K-0.8\nG63 Z-9 F250\nG63 Z5\nG1 X1\nM30",
        &[
            "G1 X0 Y0 Z5 F80",
            "G1 X0 Y0 Z-10",
            "G1 X0 Y0 Z5",
            "G1 X0 Y0 Z-9 F250",
            "G1 X0 Y0 Z5 F250",
            "G1 X1 Y0 Z5 F250",
        ],
    );
}

#[test]
fn their_words_are_written_as_they_are() {
    check(
        "N10 G90 G0 X10 Y20 Z5 S100 M3\nN20 G33 Z-10 K2 SF=30\nN30 Z-20 K1.5\nN40 G34 Z-30 K=1+1 F0.1\nN50 G1 X0 F200\n\
         N55 G0 Z5\nN60 SPOS=0\nN70 G331 Z-10 K-0.8 S300\nN80 G332 Z5 K-0.8\nN90 G1 F240\nN95 G63 Z-9\nN100 G63 Z5 M4\nN110 X1\nN120 M30",
        &[
            "N10 G90 G0 X10 Y20 Z5 S100 M3",
            "N20 SF=30 G33 Z-10 K2",
            "N30 G33 Z-20 K1.5",
            "N40 G34 Z-30 K2 F0.1",
            "N50 G1 X0 F200",
            "N55 G0 Z5",
            "N60 SPOS=0",
            "N70 G331 Z-10 K-0.8 S300",
            "N80 G332 Z5 K-0.8",
            "N90 F240",
            "N95 G63 Z-9",
            "N100 G63 Z5 M4",
            "N110 G1 X1",
            "N120 M30",
        ],
    );
    // Inch: positions, leads and their change are lengths.
    check(
        "G90 G70 G0 X1 Y0 Z1\nG33 Z0 K0.1\nG35 Z-1 K0.1 F0.01\nM30",
        &["G90 G71 G0 X25.4 Y0 Z25.4", "G33 Z0 K2.54", "G35 Z-25.4 K2.54 F0.254", "M30"],
    );
}

#[test]
fn a_thread_keeps_its_one_piece_and_says_where_that_bends() {
    // The straight line from the end at z = 0 to that at z = -40 is off the parabola 1e-6 z^2 by 1e-6 * 20^2 = 0.0004 mm at the middle; to
    // z = -100 by 1e-6 * 50^2 = 0.0025 mm.
    let program = |end: &str| format!("G90 G0 X10 Y20 Z0 F100\nG331 Z{end} K1\nG332 Z0 K1\nG1 Z{end}\nM30");
    let options = || CorrectionOptions { tolerance_mm: 1e-3, ..CorrectionOptions::default() };
    let (lines, codes) = written(&program("-40"), &xyz_machine(), &bent(), options());
    assert_eq!(codes, [""; 0]);
    // X is told less by 1e-6 * 40^2 = 0.0016 mm.
    assert_eq!(lines[1..3], ["G331 X9.9984 Z-40 K1", "G332 X10 Z0 K1"]);
    let (lines, codes) = written(&program("-100"), &xyz_machine(), &bent(), options());
    assert_eq!(codes, ["W0307", "W0307"]);
    assert_eq!(lines[1..3], ["G331 X9.99 Z-100 K1", "G332 X10 Z0 K1"]);
    assert!(lines[4].ends_with(";+"), "a feed motion is cut: {lines:?}");
    let stepped = CorrectionOptions { subdivision: Subdivision::Step(5.0), ..options() };
    let (lines, _) = written(&program("-40"), &xyz_machine(), &bent(), stepped);
    assert_eq!(lines[1..3], ["G331 X9.9984 Z-40 K1", "G332 X10 Z0 K1"]);
}

#[test]
fn what_is_no_thread_is_refused() {
    assert_eq!(codes("G90 G0 Z5\nG33 Z0\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G0 Z5\nG33 Z0 I1 K1\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G0 Z5\nG33 Z0 K-1\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G0 Z5\nG331 Z0 K0\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G0 Z5\nG34 Z0 K1\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G1 Z5 F10\nG63 Z0 K1\nM30"), ["E0210"]);
    assert_eq!(codes("G90 G0 Z5\nG33 Z0 K1 CR=5\nM30"), ["E0205"]);
    check_codes("G90 G0 X0 Y0 Z5\nOFFN=5 G41 G1 X9 F100\nY9\nG33 Y20 J1\nG40 G1 X0\nM30", &["E0201:4"]);
    // The feed is that of G63, none for the spindle.
    check_codes("G90 G0 X0 Y0 Z5\nG331 Z0 K1\nG332 Z5 K1\nM30", &[]);
    check_codes("G90 G0 X0 Y0 Z5\nG63 Z0\nM30", &["W0202:2"]);
}

#[test]
fn tapping_cycles_go_down_and_back_with_the_spindle() {
    let moves = |call: &str| {
        let (lines, codes) = run(&format!("G17 G90 G0 X1 Y2 Z10 S200 M3\nF100\n{call}\nM30"));
        assert_eq!(codes, [""; 0], "{call}");
        let of_motion = |line: &&String| ["G0", "G1", "G4"].iter().any(|code| line.starts_with(code));
        lines.iter().filter(of_motion).skip(1).map(|line| line.replace("X1 Y2 ", "")).collect::<Vec<_>>()
    };
    let plain = ["G0 Z2", "G1 Z-15", "G1 Z2", "G0 Z10"];
    assert_eq!(moves("CYCLE84(10,0,2,-15,0,0,3,,0.8,90,200,500)"), plain);
    assert_eq!(moves("CYCLE84(10,0,2,,15,0,3,5,,90,200)"), plain);
    // Strokes of 6: out to the safety height, or back by 1.
    assert_eq!(
        moves("CYCLE84(10,0,2,-15,0,0.5,3,,0.8,90,200,0,0,0,0,2,6)"),
        ["G0 Z2", "G1 Z-6", "G1 Z2", "G1 Z-12", "G1 Z2", "G1 Z-15", "G4 S0.5", "G1 Z2", "G0 Z10"]
    );
    assert_eq!(
        moves("CYCLE84(10,0,2,-15,0,0,3,,0.8,90,200,0,0,0,0,1,6)"),
        ["G0 Z2", "G1 Z-6", "G1 Z-5", "G1 Z-12", "G1 Z-11", "G1 Z-15", "G1 Z2", "G0 Z10"]
    );
    assert_eq!(moves("CYCLE840(10,0,2,-15,0,0,4,3,0,,1)"), plain);
    // Without an encoder: F = S times lead.
    assert_eq!(moves("CYCLE840(10,0,2,-15,0,0,4,3,1,,1.5)"), ["G0 Z2", "G1 Z-15 F300", "G1 Z2 F300", "G0 Z10"]);
}

#[test]
fn a_tapping_cycle_is_written_with_its_lead() {
    let text = "G17 G90 G0 X1 Y2 Z10 S200 M3\nCYCLE84(10,0,2,-15,0,0,3,,-0.8,90,200,500)\nM30";
    let (lines, codes) = written(text, &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default());
    assert_eq!(codes, [""; 0]);
    let words = |line: &str| line.split(" ;").next().unwrap().to_owned();
    let lines: Vec<String> = lines.iter().map(|line| words(line)).collect();
    assert_eq!(
        lines,
        [
            "G17 G90 G0 X1 Y2 Z10 S200 M3",
            "G0 Z2",
            "SPOS=90",
            "G331 Z-15 K-0.8 S200",
            "G332 Z2 K-0.8 S500",
            "G0 Z10",
            "M3",
            "M30",
        ]
    );
}
