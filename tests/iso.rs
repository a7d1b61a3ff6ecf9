//! Execution of Fanuc and RS274/NGC programs: the flat stream that a control produces, worked out by hand.
use ncfix_base::geometry::{Axis, FrameParts};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, Library, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::{DecimalPoint, Machine, Tool};
use ncfix_machine::snc::{Element, Kind, TextWriter};

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
    let (program, findings) = syntax::parse(&source, ncfix_dialect::find(name).unwrap());
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
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG0 G1 X1. F1.\nM30", &["E0111:2"]);
    check_codes("rs274", "G0 X0 Y0 Z0\nG1 X1 Q5 F1\nM2", &["E0210:2"]);
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG1 X1. Q5. F1.\nM30", &["E0210:2"]);
    check_codes("rs274", "X1\nM2", &["E0210:1"]);
}

#[test]
fn behind_a_cycle_the_kind_of_motion_before_it_holds_on_a_fanuc() {
    check(
        "fanuc",
        "G90 G1 X0 Y0 Z0 F100.\nG80 X5.\nG80\nY5.\nM30",
        &["G1 X0 Y0 Z0 F100", "G1 X5 Y0 Z0 F100", "G1 X5 Y5 Z0 F100"],
    );
    check_codes("rs274", "G90 G1 X0 Y0 Z0 F100\nG80\nY5\nM2", &["E0210:3"]);
    // Beside another kind of motion G80 says nothing.
    check("rs274", "G90 G80 G1 G80 X1 F10\nM2", &["G1 X1 Y0 Z0 F10"]);
}

#[test]
fn dwells_of_both_flavours() {
    let (lines, codes) = run("fanuc", "G4 P1500\nG4 X1.5\nG4 U2.\nM30");
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, ["G4 S1.5", "G4 S1.5", "G4 S2", "M30"]);
    let (lines, codes) = run("rs274", "G4 P1.5\nM2");
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, ["G4 S1.5", "M2"]);
}

/// The axis commands of all motions, X Y Z.
fn commands(text: &str, machine: &Machine) -> Vec<[f64; 3]> {
    let (elements, codes) = elements("rs274", text, machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let target = |element: &Element| match &element.kind {
        Kind::Move(motion) => Some([motion.target.0[0], motion.target.0[1], motion.target.0[2]]),
        _ => None,
    };
    elements.iter().filter_map(target).collect()
}

#[track_caller]
fn assert_near(found: &[[f64; 3]], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    }
}

#[test]
fn a_zero_offset_may_be_turned_and_shifted_to_where_the_tool_is() {
    // 30 degrees: cos = √3/2, sin = 1/2.
    let (c, s) = (3_f64.sqrt() / 2.0, 0.5);
    let found = commands(
        "G21 G90 G0 X0 Y0 Z0\nG10 L2 P2 X10 Y20 Z0 R30\nG55 G0 X4 Y2\nG92 X0 Y0\nG0 X1\nG92.1\nG0 X4 Y2\nG10 L20 P2 X0 Y0\nG0 X1 Y0\nM2",
        &iso_machine(),
    );
    let at = |x: f64, y: f64| [10.0 + c * x - s * y, 20.0 + s * x + c * y, 0.0];
    // G92 shifts within the turned system; L20 makes the place of X4 Y2 the zero.
    assert_near(&found, &[[0.0; 3], at(4.0, 2.0), at(5.0, 2.0), at(4.0, 2.0), at(5.0, 2.0)]);
}

#[test]
fn reference_points_are_saved_and_reached_by_way_of_a_point() {
    let found =
        commands("G21 G90 G10 L2 P1 X100 Y0 Z0\nG0 X1 Y2 Z3\nG28.1\nG0 X50 Y50 Z50\nG28 X20\nG28\nM2", &iso_machine());
    assert_near(
        &found,
        &[[101.0, 2.0, 3.0], [150.0, 50.0, 50.0], [120.0, 50.0, 50.0], [101.0, 50.0, 50.0], [101.0, 2.0, 3.0]],
    );
}

#[test]
fn inch_programs_and_changes_of_the_unit() {
    check(
        "rs274",
        "G20\nG90 F10 G1 X1 Y0 Z0\nG21 X1\nG20\nX2 F20\nM2",
        &["G1 X25.4 Y0 Z0 F254", "G1 X1 Y0 Z0 F254", "G1 X50.8 Y0 Z0 F508"],
    );
}

#[test]
fn the_feed_of_a_block_of_rs274_is_read_before_its_unit() {
    check("rs274", "G21 G90 F10 G1 X1 Y0 Z0\nG20 F20 X1\nM2", &["G1 X1 Y0 Z0 F10", "G1 X25.4 Y0 Z0 F20"]);
    check("fanuc", "G21 G90 F10. G1 X1. Y0 Z0\nG20 F20. X1.\nM30", &["G1 X1 Y0 Z0 F10", "G1 X25.4 Y0 Z0 F508"]);
}

#[test]
fn arcs_of_linuxcnc_may_widen_like_a_spiral_and_turn_more_than_once() {
    // Radius 10 at the start and 10.005 at the end: less than a thousandth.
    check(
        "rs274",
        "G21 G90 G0 X10 Y0 Z0\nG3 X0 Y10.005 I-10 J0 F100\nG2 X0 Y10.005 Z-3 I0 J-10 P3\nM2",
        &["G0 X10 Y0 Z0", "G3 X0 Y10.005 Z0 I-10 J0 K0 P17 F100", "G2 X0 Y10.005 Z-3 I0 J-10 K0 P17 L2 F100"],
    );
    check_codes("rs274", "G21 G90 G0 X10 Y0 Z0\nG3 X0 Y10.05 I-10 J0 F100\nM2", &["E0203:2"]);
    check_codes("rs274", "G21 G90 G0 X10 Y0 Z0\nG3 X10 Y0 R10 F100\nM2", &["E0204:2"]);
    check(
        "rs274",
        "G21 G90 G0 X10 Y0 Z0\nG90.1 G3 X0 Y10 I0 J0 F100\nM2",
        &["G0 X10 Y0 Z0", "G3 X0 Y10 Z0 I-10 J0 K0 P17 F100"],
    );
}

#[test]
fn states_are_saved_and_come_back() {
    check(
        "rs274",
        "G21 G90 G0 X0 Y0 Z0 F100\nM70\nG91 G20 G93\nG1 X1 F2\nM72\nX1\nM2",
        &["G0 X0 Y0 Z0", "G1 X25.4 Y0 Z0 F2 G93", "G1 X1 Y0 Z0 F100"],
    );
    check_codes("rs274", "G21 M72\nM2", &["E0210:1"]);
}

#[test]
fn what_a_correction_must_not_assume_is_refused_once() {
    let strict = Options { strict: true, ..Options::default() };
    let mut machine = iso_machine();
    machine.zero_offsets.clear();
    let text = "G21 G90 G0 X1 Y2 Z3\nG1 X2 F100\nG43 H5 Z10\nM2";
    let (_, codes) = run_with("rs274", text, &machine, Box::new(NoLibrary), strict);
    assert_eq!(codes, ["E0306:1", "E0307:3"]);
    let (_, codes) = run_with("rs274", text, &machine, Box::new(NoLibrary), Options::default());
    assert_eq!(codes, ["W0302:1", "W0303:3"]);
}

#[test]
fn fanuc_lengths_by_table_and_sign() {
    let mut machine = iso_machine();
    machine.tools = vec![Tool { number: 5, name: None, edge: 1, length_mm: [80.0, 0.0, 0.0], radius_mm: 4.0 }];
    let text = "G90 G0 X0 Y0 Z0\nG43 H5 Z10.\nG44 H5 Z10.\nG43 H0 Z10.\nG10 L10 P6 R20.\nG43 H6 Z10.\nG10 L11 P6 R1.\nG43 H6 Z10.\nG49 Z10.\nM30";
    let (elements, codes) = elements("fanuc", text, &machine, Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let height = |element: &Element| match &element.kind {
        Kind::Move(motion) => Some(motion.target.0[2]),
        _ => None,
    };
    let heights: Vec<f64> = elements.iter().filter_map(height).collect();
    assert_eq!(heights, [0.0, 90.0, -70.0, 10.0, 30.0, 31.0, 10.0]);
}

#[test]
fn reference_points_of_a_fanuc() {
    let mut machine = iso_machine();
    machine.control.iso.reference_points.insert((2, Axis::Z), 250.0);
    check_on(
        "fanuc",
        "G90 G10 L2 P1 X10. Y0 Z0\nG0 X1. Y2. Z3.\nG28 X5. Z20.\nG29 X2. Z4.\nG30 Z30.\nG91 G28 Z0\nM30",
        &machine,
        &[
            "G0 X11 Y2 Z3",
            "G0 X15 Y2 Z20",
            "G0 X0 Y2 Z0",
            "G0 X15 Y2 Z20",
            "G0 X12 Y2 Z4",
            "G0 X12 Y2 Z30",
            "G0 X12 Y2 Z250",
            "G0 X12 Y2 Z0",
        ],
    );
    check_codes("fanuc", "G90 G0 X0 Y0 Z0\nG30 X0\nG29 X0\nM30", &["E0219:2"]);
}

#[test]
fn codes_may_hold_before_the_first_block() {
    let mut machine = iso_machine();
    machine.control.iso.startup_code = "G20 G64 P0.1 G1 F10".to_owned();
    check_on("rs274", "X1 Y0 Z0\nM2", &machine, &["G1 X25.4 Y0 Z0 F10"]);
    machine.control.iso.startup_code = "G0 X1".to_owned();
    let source = Source::new(FileId(0), "test.ngc", b"G0 X1\nM2".to_vec()).unwrap();
    let (program, _) = syntax::parse(&source, ncfix_dialect::find("rs274").unwrap());
    let found = Execution::new(program, &machine, Box::new(NoLibrary), Options::default()).find_map(Result::err);
    assert_eq!(found.unwrap().code.as_str(), "E0404");
}

#[test]
fn the_mark_of_a_tape_is_a_header() {
    let (elements, _) = elements("fanuc", I1, &iso_machine(), Box::new(NoLibrary), Options::default());
    let headers: Vec<&[u8]> = elements
        .iter()
        .filter_map(|element| match &element.kind {
            Kind::Header(text) => Some(&text[..]),
            _ => None,
        })
        .collect();
    assert_eq!(headers, [&b"%"[..], b"O0001"]);
}
