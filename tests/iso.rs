//! Execution of Fanuc and RS274/NGC programs: the flat stream that a control produces, worked out by hand.

use ncfix::dialect;
use ncfix::exec::{Execution, Library, NoLibrary, Options};
use ncfix::geometry::FrameParts;
use ncfix::machine::{DecimalPoint, Machine, Tool};
use ncfix::snc::{Element, Kind, TextWriter};
use ncfix::source::{FileId, Source};
use ncfix::syntax;

use crate::machines::xyz_machine;

/// Three linear axes, G54 and G55 at machine zero, numbers without a point in whole units.
pub(crate) fn iso_machine() -> Machine {
    let mut machine = xyz_machine();
    for name in ["G54", "G55"] {
        machine.zero_offsets.insert(name.to_owned(), FrameParts::default());
    }
    machine.control.iso.decimal_point = Some(DecimalPoint::Calculator);
    machine
}

/// The elements of a program, and the codes of all findings with their lines.
pub(crate) fn elements(
    name: &str,
    text: &str,
    machine: &Machine,
    library: Box<dyn Library>,
    options: Options,
) -> (Vec<Element>, Vec<String>) {
    let source = Source::new(FileId(0), "test.nc", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, dialect::find(name).unwrap());
    let mut codes: Vec<String> =
        findings.iter().map(|f| format!("{}:{}", f.code, source.line_column(f.place.unwrap().span.start).0)).collect();
    let mut execution = Execution::new(program, machine, library, options);
    let mut out = Vec::new();
    while let Some(item) = execution.next() {
        match item {
            Ok(element) => out.push(element),
            Err(finding) => {
                let place = finding.place.unwrap();
                let (line, _) = execution.sources()[usize::from(place.file.0)].line_column(place.span.start);
                codes.push(format!("{}:{line}", finding.code));
            }
        }
    }
    (out, codes)
}

/// The SNC lines of a program without origins, and the codes of all findings with their lines.
pub(crate) fn run_with(
    name: &str,
    text: &str,
    machine: &Machine,
    library: Box<dyn Library>,
    options: Options,
) -> (Vec<String>, Vec<String>) {
    let (elements, codes) = elements(name, text, machine, library, options);
    let mut out = TextWriter::new(Vec::new(), "test", machine.axis_set(), |_, tool| *tool).unwrap();
    for element in &elements {
        out.write(element, &[]).unwrap();
    }
    let text = String::from_utf8(out.finish().unwrap()).unwrap();
    let lines = text.lines().skip(1).map(|line| line.split(" ;").next().unwrap().to_owned()).collect();
    (lines, codes)
}

pub(crate) fn run(name: &str, text: &str) -> (Vec<String>, Vec<String>) {
    run_with(name, text, &iso_machine(), Box::new(NoLibrary), Options::default())
}

/// The motion lines (G0 … G3) of a program.
pub(crate) fn moves(lines: &[String]) -> Vec<&str> {
    lines.iter().map(String::as_str).filter(|line| line.starts_with('G') && !line.starts_with("G4")).collect()
}

/// Checks the motion lines of a program that runs without findings.
#[track_caller]
pub(crate) fn check(name: &str, text: &str, expected: &[&str]) {
    check_on(name, text, &iso_machine(), expected);
}

#[track_caller]
pub(crate) fn check_on(name: &str, text: &str, machine: &Machine, expected: &[&str]) {
    let (lines, codes) = run_with(name, text, machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(moves(&lines), expected);
}

#[track_caller]
pub(crate) fn check_codes(name: &str, text: &str, expected: &[&str]) {
    assert_eq!(run(name, text).1, expected);
}

const I1: &str = "%
O0001
N10 G21 G90 G17 G94 G0 X10. Y10 Z5.
N20 G1 X25500 F500
N30 M30
%";

#[test]
fn i1_decimal_point_by_setting() {
    let mut machine = iso_machine();
    check_on("fanuc", I1, &machine, &["G0 X10 Y10 Z5", "G1 X25500 Y10 Z5 F500"]);
    machine.control.iso.decimal_point = Some(DecimalPoint::Increment);
    check_on("fanuc", I1, &machine, &["G0 X10 Y0.01 Z5", "G1 X25.5 Y0.01 Z5 F500"]);
    machine.control.iso.decimal_point = None;
    let (_, codes) = run_with("fanuc", I1, &machine, Box::new(NoLibrary), Options::default());
    assert_eq!(codes, ["E0305:3"]);
}

#[test]
fn i9_offsets_and_shifts() {
    check(
        "fanuc",
        "N10 G90 G17 G10 L2 P1 X100. Y50. Z0
N20 G54 G0 X0 Y0 Z0
N30 G52 X10. Y5.
N40 X0 Y0
N50 G53 X0 Y0
N60 G52 X0 Y0
N70 X1. Y1.
N80 G92 X0 Y0
N90 X5. Y5.
N100 G55 X0 Y0
N110 M30",
        &["G0 X100 Y50 Z0", "G0 X110 Y55 Z0", "G0 X0 Y0 Z0", "G0 X101 Y51 Z0", "G0 X106 Y56 Z0", "G0 X1 Y1 Z0"],
    );
}

#[test]
fn i10_arcs_with_center_and_radius() {
    check(
        "fanuc",
        "N5 G90 G0 X10. Y0 Z0
N10 G17 G91 G3 I-10. F100.
N20 G90 G3 X0 Y10. R-10.
N30 G2 X10. Y20. Z-3. R10.
N40 M30",
        &[
            "G0 X10 Y0 Z0",
            "G3 X10 Y0 Z0 I-10 J0 K0 P17 F100",
            "G3 X0 Y10 Z0 I0 J10 K0 P17 F100",
            "G2 X10 Y20 Z-3 I10 J0 K0 P17 F100",
        ],
    );
}

#[test]
fn rs274_lengths_of_tools_move_the_axis_and_not_the_tip() {
    let mut machine = iso_machine();
    machine.tools = vec![Tool { number: 3, name: None, edge: 1, length_mm: [50.0, 0.0, 0.0], radius_mm: 4.0 }];
    let text = "G21 G90 G0 X0 Y0 Z0\nT3 M6\nZ10\nG43\nZ10\nG49\nZ10\nM2";
    let (elements, codes) = elements("rs274", text, &machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let heights: Vec<f64> = elements
        .iter()
        .filter_map(|element| match &element.kind {
            Kind::Move(motion) => Some(motion.target.0[2]),
            _ => None,
        })
        .collect();
    assert_eq!(heights, [0.0, 10.0, 60.0, 10.0]);
}

#[test]
fn words_and_codes_that_do_not_go_together_are_findings() {
    check_codes("rs274", "G0 X0 Y0 Z0\nG0 G1 X1 F1\nM2", &["E0111:2"]);
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG0 G1 X1. F1.\nM30", &["W0204:2"]);
    check_codes("rs274", "G0 X0 Y0 Z0\nG1 X1 Q5 F1\nM2", &["E0210:2"]);
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG1 X1. Q5. F1.\nM30", &["W0204:2"]);
    check_codes("rs274", "X1\nM2", &["E0210:1"]);
}
