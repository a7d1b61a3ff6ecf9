//! Axes that programs call by names of the machine file: `X1=10`, `C1=DC(90)`.

use ncfix_base::geometry::Axis;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Machine, file};
use ncfix_model::ErrorModel;
use ncfix_path::path::CorrectionOptions;

use crate::modes::written;

const FILE: &str = "[machine]\nname = \"m\"\ntopology = \"wCFXYZSt\"\n[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\
    [control]\ninitial_zero_offset = \"G500\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-9999, 9999]\nname = \"x1\"\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-9999, 9999]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-9999, 9999]\n\
    [axis.C]\ndirection = [0, 0, 1]\nmodulo = true\nname = \"TABLE\"\n";

/// The machine of a file and the codes of its findings.
fn read(text: &str) -> (Option<Machine>, Vec<String>) {
    let source = Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
    let (machine, findings) = file::read_machine(&file::MachineFile::parse(&source).unwrap());
    (machine, findings.iter().map(|found| found.code.to_string()).collect())
}

#[track_caller]
fn check(text: &str, expected: &[&str], expected_codes: &[&str]) {
    let machine = read(FILE).0.unwrap();
    let (lines, codes) = written(text, &machine, &ErrorModel::default(), CorrectionOptions::default());
    assert_eq!(codes, expected_codes);
    if expected_codes.is_empty() {
        assert_eq!(lines, expected);
    }
}

#[test]
fn axes_have_their_names_in_blocks_and_brackets() {
    check(
        "N10 G90 G1 X1=1 Y2 Z3 TABLE=10 F100\nN20 X1=IC(2) TABLE=DC(350)\nN30 AX[X1]=5 AX[TABLE]=20\nN40 POS[TABLE]=30\nN50 X6 C40\n\
         N60 TRANS X1=1 TABLE=5\nN70 X1=1 TABLE=1\nN80 G74 X1=0\nM30",
        &[
            "N10 G90 G1 X1 Y2 Z3 TABLE=10 F100",
            "N20 G1 X3 TABLE=DC(350)",
            "N30 G1 X5 TABLE=20",
            "N40 POS[TABLE]=30",
            "N50 G1 X6 TABLE=40",
            "N60 TRANS X1 TABLE=5",
            "N70 G1 X1 TABLE=1",
            "N80 G74 X1=0",
            "M30",
        ],
        &[],
    );
}

#[test]
fn a_name_that_no_axis_has_is_an_error() {
    check("G90 G1 Y1=1 F100\nM30", &[], &["E0201"]);
    check("G90 G1 SLIDE=1 F100\nM30", &[], &["E0206"]);
    check("G90 G1 X1=1 X2 F100\nM30", &[], &["E0111"]);
}

#[test]
fn names_are_checked() {
    let (machine, codes) = read(FILE);
    assert_eq!(codes, [""; 0]);
    let machine = machine.unwrap();
    assert_eq!(machine.axis_named("X1"), Some(Axis::X));
    assert_eq!(machine.axis_named("TABLE"), Some(Axis::C));
    assert_eq!(machine.axis_named("X"), None);
    for bad in ["C3", "R5", "1C", "C", "C 1", "X1"] {
        assert_eq!(read(&FILE.replace("TABLE", bad)).1, ["E0404"], "{bad}");
    }
}
