//! G74 and G75: passed on in their places, the named axes are anywhere behind them.

use ncfix_language::exec::{NoLibrary, Options as ExecOptions};
use ncfix_path::path::CorrectionOptions;

use crate::bench_machine::{motion, polynomial};
use crate::exec::run_with;
use crate::machines::xyz_machine;
use crate::modes::{check, codes, written};

#[test]
fn reference_and_fixed_points_are_passed_on_and_move_nothing_in_the_stream() {
    check(
        "N10 G90 G0 X1 Y2 Z3\nN20 G74 X1=0 Y1=0\nN30 G75 FP=1 X1=0 Z=0\nN40 X1=0 G74 M8\nN50 G74 C0\nN60 G0 X4 Y5 Z6\nN70 G75 AX4=R1 Y0\nN80 M30",
        &[
            "N10 G90 G0 X1 Y2 Z3",
            "N20 G74 X1=0 Y1=0",
            "N30 G75 FP=1 X1=0 Z=0",
            "N40 X1=0 G74 M8",
            "N50 G74 C0",
            "N60 G0 X4 Y5 Z6",
            "N70 G75 AX4=0 Y0",
            "N80 M30",
        ],
    );
}

#[test]
fn only_on_these_blocks_a_letter_and_a_number_name_an_axis() {
    assert_eq!(codes("G0 X1 Y1 Z1\nX1=0\nM30"), ["E0201"]);
    assert_eq!(codes("G74 G75 X1=0\nM30"), ["E0111"]);
}

#[test]
fn behind_a_reference_point_only_its_axes_are_unknown() {
    let strict = || ExecOptions { strict: true, ..ExecOptions::default() };
    let found = |block: &str| {
        let text = format!("G90 G1 X1 Y2 Z3 F100\n{block}\nG91 X1\nM30");
        run_with(&text, &xyz_machine(), Box::new(NoLibrary), strict()).1
    };
    assert_eq!(found("G74 X1=0"), ["E0304:3"]);
    assert_eq!(found("G75 FP=2 Y1=0"), [""; 0]);
    assert_eq!(found("G75 FP=2 Y1=0 X1=0"), ["E0304:3"]);
    // Which axis AX2 is, the control knows.
    assert_eq!(found("G75 AX2=0"), ["E0304:3"]);
    // A turned plane mixes X and Y.
    assert_eq!(found("ROT RPL=30\nG74 Y1=0\nTRANS"), ["E0304:5"]);
}

#[test]
fn an_axis_that_is_unknown_is_written_again_when_it_is_known() {
    // EXX = 0.01 mm everywhere: X is told 0.01 mm less.
    let errors = vec![motion("EXX", polynomial(&[0.01]))];
    let errors = ncfix_model::ErrorModel { motion: errors, ..Default::default() };
    let text = "G90 G1 X1 Y2 Z3 F100\nG74 X1=0\nY5\nX1\nM30";
    let (lines, codes) = written(text, &xyz_machine(), &errors, CorrectionOptions::default());
    assert_eq!(codes, [""; 0]);
    assert_eq!(lines, ["G90 G1 X0.99 Y2 Z3 F100", "G74 X1=0", "G1 Y5", "G1 X0.99", "M30"]);
}

#[test]
fn under_a_transformation_no_axis_goes_to_a_place_of_the_machine_and_none_begins_beside_a_contour() {
    let machine = crate::five_axis::with_tool(crate::swivel::machine("wCAYXFZSt"));
    let found = |text: &str| {
        let (_, found) = crate::five_axis::execute(text, &machine);
        found.iter().filter(|d| d.is_error()).map(|d| d.code.as_str()).collect::<Vec<_>>()
    };
    let begin = "G17 G90 G54 T1 M6\nG0 X-20 Y10 Z60 A0 C0\n";
    for block in ["G74 Z1=0", "G75 FP=1 X1=0 Y1=0", "G75 FP=2 Z=0"] {
        assert_eq!(found(&format!("{begin}TRAORI\n{block}\nM30\n")), ["E0227"], "{block}");
        assert_eq!(found(&format!("{begin}TRAORI\nTRAFOOF\n{block}\nM30\n")), [""; 0], "{block}");
    }
    let contour = "G1 G41 X0 Y10 F500\nY20\n";
    assert_eq!(found(&format!("{begin}{contour}TRAORI\nTRAFOOF\nG40 X-20\nM30\n")), ["E0232"; 2]);
}
