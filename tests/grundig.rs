//! Grundig, Philips, MillPlus: programs with the flat stream that a control produces, worked out by hand.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, Library, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::{CompensationCorner, Machine, Tool};
use ncfix_machine::snc::TextWriter;
use std::collections::BTreeMap;

use crate::machines::xyz_machine;

/// The machine of the examples: a zero offset G54 at X100 Y50.
pub(crate) fn mill() -> Machine {
    let mut machine = xyz_machine();
    machine.controller = "grundig".into();
    let mut g54 = AxisVector::ZERO;
    g54.set_xyz(Vector::new(100.0, 50.0, 0.0));
    machine.zero_offsets.insert("G54".to_owned(), g54.into());
    machine
}

/// A tool with a radius.
pub(crate) fn tool(number: u32, length_mm: f64, radius_mm: f64) -> Tool {
    Tool { number, name: None, edge: 1, length_mm: [length_mm, 0.0, 0.0], radius_mm }
}

/// SNC lines without origins, and the codes of all findings with their lines.
pub(crate) fn run_on(
    text: &str,
    machine: &Machine,
    library: Box<dyn Library>,
    options: Options,
) -> (Vec<String>, Vec<String>) {
    let dialect = ncfix_dialect::find("grundig").unwrap();
    let source = Source::new(FileId(0), "9001.pm", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, dialect);
    let mut codes: Vec<String> =
        findings.iter().map(|f| format!("{}:{}", f.code, source.line_column(f.place.unwrap().span.start).0)).collect();
    let start = options.start;
    let mut execution = Execution::new(program, machine, library, options);
    let mut out = TextWriter::new(Vec::new(), "test", machine.axis_set(), |_, tool| *tool).unwrap();
    if let Some(start) = start {
        out.start_at(start);
    }
    while let Some(item) = execution.next() {
        match item {
            Ok(element) => out.write(&element, &[]).unwrap(),
            Err(finding) => {
                let place = finding.place.unwrap();
                let (line, _) = execution.sources()[usize::from(place.file.0)].line_column(place.span.start);
                codes.push(format!("{}:{line}", finding.code));
            }
        }
    }
    let text = String::from_utf8(out.finish().unwrap()).unwrap();
    (text.lines().skip(1).map(|line| line.split(" ;").next().unwrap().to_owned()).collect(), codes)
}

pub(crate) fn run(text: &str) -> (Vec<String>, Vec<String>) {
    run_on(text, &mill(), Box::new(NoLibrary), Options::default())
}

/// Code and words of a line; `G3/17 …` names the plane as the word P.
pub(crate) fn words(line: &str) -> (String, BTreeMap<char, f64>) {
    let mut parts = line.split_whitespace();
    let head = parts.next().unwrap();
    let (code, plane) = head.split_once('/').map_or((head, None), |(code, plane)| (code, Some(plane)));
    let mut words: BTreeMap<char, f64> =
        parts.map(|word| (word.chars().next().unwrap(), word[1..].parse().unwrap())).collect();
    if let Some(plane) = plane {
        words.insert('P', plane.parse().unwrap());
    }
    (code.to_owned(), words)
}

/// The motions among lines; straight ones that move nothing are left out, as the lists of the examples do.
pub(crate) fn motions(lines: &[String], start: [f64; 3]) -> Vec<String> {
    let mut here = start;
    let mut out = Vec::new();
    for line in lines.iter().filter(|line| line.starts_with('G') && !line.starts_with("G4")) {
        let (code, words) = words(line);
        let to = ['X', 'Y', 'Z'].map(|letter| words[&letter]);
        let still = to.iter().zip(here).all(|(a, b)| (a - b).abs() < 1e-6);
        here = to;
        if !still || code == "G2" || code == "G3" {
            out.push(line.clone());
        }
    }
    out
}

/// Compares motions with an expected list: all words that it names, to 0.1 µm, or as exactly as it is written.
#[track_caller]
pub(crate) fn same(found: &[String], expected: &str) {
    let expected: Vec<&str> = expected.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    let shown = found.join("\n");
    assert_eq!(found.len(), expected.len(), "\n{shown}");
    for (found, line) in found.iter().zip(expected) {
        let (code, own) = words(found);
        let (wanted, words) = words(line);
        assert_eq!(code, wanted, "{found} is not {line}\n{shown}");
        for (letter, value) in words {
            let near = (own[&letter] - value).abs() < 1.01e-4;
            assert!(near, "{found} is not {line}\n{shown}");
        }
    }
}

/// A program that runs without findings other than that its tools have no data, from X0 Y0 Z0 on.
#[track_caller]
pub(crate) fn check(text: &str, expected: &str) {
    check_from(text, [0.0; 3], &mill(), expected);
}

#[track_caller]
pub(crate) fn check_from(text: &str, start: [f64; 3], machine: &Machine, expected: &str) {
    let mut at = AxisVector::ZERO;
    at.set_xyz(Vector::from(start));
    let options = Options { start: Some(at), ..Options::default() };
    let (lines, codes) = run_on(text, machine, Box::new(NoLibrary), options);
    // Missing data of tools, a missing feed, tables that are not written.
    let is_other = |code: &&String| !["W03", "W0202", "W0204"].iter().any(|known| code.starts_with(known));
    let others: Vec<&String> = codes.iter().filter(is_other).collect();
    assert!(others.is_empty(), "{others:?}");
    same(&motions(&lines, start), expected);
}

#[track_caller]
pub(crate) fn check_codes(text: &str, expected: &[&str]) {
    assert_eq!(run(text).1, expected);
}

#[test]
fn g1_arcs() {
    check(
        "%PM9001
N9001 (ARCS)
N1 G17 G90 G71
N2 T1 M6
N3 G0 X10 Y0 Z5 S1000 M3
N4 G1 Z-2 F200
N5 G3 X0 Y10 I0 J0
N6 G2 X10 Y20 R10
N7 G3 I20 J20 B5=360
N8 G3 I20 J20 B5=90
N9 G91
N10 G2 X10 Y10 I10 J0
N11 G90
N12 G0 X0 Y0 Z50
N13 M30",
        "G0 X0 Y0 Z5
G0 X10 Y0 Z5
G1 X10 Y0 Z-2
G3/17 X0 Y10 Z-2 I-10 J0
G2/17 X10 Y20 Z-2 I10 J0
G3/17 X10 Y20 Z-2 I10 J0
G3/17 X20 Y10 Z-2 I10 J0
G2/17 X30 Y20 Z-2 I10 J0
G0 X30 Y20 Z50
G0 X0 Y0 Z50",
    );
}

#[test]
fn g2_repetitions_within_repetitions() {
    check(
        "%PM9002
N9002
N1 G17 G90
N2 G0 X0 Y0 Z0
N3 G91
N4 G1 X10 F500
N5 Y2
N6 G14 N1=5 J2
N7 X-10
N8 G14 N1=4 N2=7 J1
N9 G90
N10 G0 X0 Y0
N11 M30",
        "G1 X10 Y0 Z0
G1 X10 Y2 Z0
G1 X10 Y4 Z0
G1 X10 Y6 Z0
G1 X0 Y6 Z0
G1 X10 Y6 Z0
G1 X10 Y8 Z0
G1 X10 Y10 Z0
G1 X10 Y12 Z0
G1 X0 Y12 Z0
G0 X0 Y0 Z0",
    );
}

#[test]
fn g3_macros_with_parameters() {
    check(
        "%PM9003
N9003
N1 G17 G90 G0 X0 Y0 Z0
N2 E1=10 E2=3
N3 G22 N=9101
N4 E1=E1:2
N5 G22 N=9101
N6 M30
%MM9101
N9101
N1 G91
N2 G1 X=E1 F=E2*100
N3 G22 N=9102
N4 G90
%MM9102
N9102
N1 Y=E2-1
N2 G14 N1=1 J=E2-2",
        "G1 X10 Y0 Z0 F300
G1 X10 Y2 Z0 F300
G1 X10 Y4 Z0 F300
G1 X15 Y4 Z0 F300
G1 X15 Y6 Z0 F300
G1 X15 Y8 Z0 F300",
    );
}

#[test]
fn g4_points_and_polar_coordinates() {
    check(
        "N1 G17 G90
N2 G78 P1 X20 Y10 Z0
N3 G78 P2 X20 Y30 Z0
N4 G0 P1
N5 G1 B1=0 L1=10 F300
N6 B1=90 L1=5
N7 B1=225 L1=14.1421
N8 B2=45 L2=28.2843
N9 P2
N10 G9 X20 Y20
N11 G1 B2=180 L2=20
N12 M30",
        "G0 X20 Y10 Z0
G1 X30 Y10 Z0
G1 X30 Y15 Z0
G1 X20 Y5 Z0
G1 X20 Y20 Z0
G1 X20 Y30 Z0
G1 X0 Y20 Z0",
    );
}

#[test]
fn g5_drilling_on_a_bolt_circle_and_at_points() {
    check(
        "N1 G17 G90
N2 G0 X0 Y0 Z10
N3 G81 Y2 B8 Z-10 F100
N4 G77 X50 Y50 Z0 R20 I30 J4
N5 G78 P1 X0 Y0 Z-5
N6 G79 P1
N7 G79 X10 Y0 Z0
N8 M30",
        "G0 X0 Y0 Z10
G0 X67.3205 Y60 Z10
G0 X67.3205 Y60 Z2
G1 X67.3205 Y60 Z-10
G0 X67.3205 Y60 Z10
G0 X40 Y67.3205 Z10
G0 X40 Y67.3205 Z2
G1 X40 Y67.3205 Z-10
G0 X40 Y67.3205 Z10
G0 X32.6795 Y40 Z10
G0 X32.6795 Y40 Z2
G1 X32.6795 Y40 Z-10
G0 X32.6795 Y40 Z10
G0 X60 Y32.6795 Z10
G0 X60 Y32.6795 Z2
G1 X60 Y32.6795 Z-10
G0 X60 Y32.6795 Z10
G0 X0 Y0 Z10
G0 X0 Y0 Z-3
G1 X0 Y0 Z-15
G0 X0 Y0 Z5
G0 X10 Y0 Z5
G0 X10 Y0 Z2
G1 X10 Y0 Z-10
G0 X10 Y0 Z10",
    );
}

#[test]
fn g6_shifts_and_rotations_add_up() {
    check(
        "N1 G17 G90
N2 G54
N3 G93 X20 Y10
N4 G0 X0 Y0
N5 G92 X5 Y5
N6 X0 Y0
N7 G92 B4=30
N8 G92 B4=60
N9 G1 X10 Y0 F200
N10 G3 X0 Y10 I0 J0
N11 G93 X0 Y0 B4=0
N12 G0 X0 Y0
N13 M30",
        "G0 X120 Y60 Z0
G0 X125 Y65 Z0
G1 X125 Y75 Z0
G3/17 X115 Y65 Z0 I0 J-10
G0 X100 Y50 Z0",
    );
}

#[test]
fn g7_mirror_and_scale() {
    check(
        "N1 G17 G90
N2 G73 X-1
N3 G0 X10 Y0
N4 G1 X20 F200
N5 G3 X30 Y10 I20 J10
N6 G73 A4=2
N7 G1 X20 Y0
N8 G3 X30 Y10 I20 J10
N9 G72
N10 G0 X0 Y0
N11 M30",
        "G0 X-10 Y0 Z0
G1 X-20 Y0 Z0
G2/17 X-30 Y10 Z0 I0 J10
G1 X-40 Y0 Z0
G2/17 X-60 Y20 Z0 I0 J20
G0 X0 Y0 Z0",
    );
}

#[test]
fn g8_deep_hole_with_shorter_pecks() {
    check_from(
        "N1 G17 G90
N2 G83 Y2 Z-25 K10 I2 J1 F100
N3 G79 X0 Y0 Z0
N4 M30",
        [0.0, 0.0, 10.0],
        &mill(),
        "G0 X0 Y0 Z2
G1 X0 Y0 Z-10
G0 X0 Y0 Z-9
G1 X0 Y0 Z-18
G0 X0 Y0 Z-17
G1 X0 Y0 Z-24
G0 X0 Y0 Z-23
G1 X0 Y0 Z-25
G0 X0 Y0 Z2",
    );
}

#[test]
fn g10_conditional_jumps() {
    check(
        "N1 G17 G90 G0 X0 Y0 Z0
N2 E1=3 E2=0
N3 E2=E2+5
N4 G1 X=E2 Y=E2^2:10 F100
N5 E1=E1-1
N6 E3=E1>0
N7 G29 E3 N=3
N8 G29 N=10
N9 X999
N10 G0 X0 Y0
N11 M30",
        "G1 X5 Y2.5 Z0
G1 X10 Y10 Z0
G1 X15 Y22.5 Z0
G0 X0 Y0 Z0",
    );
}

#[test]
fn g11_helices() {
    check_from(
        "N1 G17 G90
N2 G3 I0 J0 K2 B5=1080 Z-6 F200
N3 G2 X0 Y-10 Z-7 I0 J0
N4 M30",
        [10.0, 0.0, 0.0],
        &mill(),
        "G3/17 X10 Y0 Z-2 I-10 J0
G3/17 X10 Y0 Z-4 I-10 J0
G3/17 X10 Y0 Z-6 I-10 J0
G2/17 X0 Y-10 Z-7 I-10 J0",
    );
}

#[test]
fn g12_the_plane_with_the_tool_along_y() {
    check_from(
        "N1 G18 G90
N2 G2 X0 Z20 I0 K0 F200
N3 G3 X0 Z0 I0 K10
N4 M30",
        [20.0, 0.0, 0.0],
        &mill(),
        "G2/18 X0 Y0 Z20 I-20 K0
G3/18 X0 Y0 Z0 I0 K-10",
    );
}

#[test]
fn g13_mirror_within_rotation_within_shift() {
    check(
        "N1 G17 G90
N2 G54
N3 G93 X20 Y10 B4=90
N4 G73 X-1
N5 G0 X10 Y0
N6 G2 X0 Y-10 I0 J0 F100
N7 M30",
        "G0 X120 Y50 Z0
G3/17 X130 Y60 Z0 I0 J10",
    );
}

#[test]
fn g9_compensation_reached_with_g43() {
    let mut machine = mill();
    machine.tools.push(tool(1, 0.0, 5.0));
    let program = "N1 G17 G90 T1 M67
N2 G1 F300
N3 G43 X0
N4 G41
N5 Y60
N6 X40
N7 Y80
N8 G40
N9 G1 X0 Y100
N10 M30";
    let start = [-30.0, 20.0, 0.0];
    check_from(
        program,
        start,
        &machine,
        "G1 X-5 Y20 Z0
G1 X-5 Y60 Z0
G2/17 X0 Y65 Z0 I5 J0
G1 X35 Y65 Z0
G1 X35 Y80 Z0
G1 X0 Y100 Z0",
    );
    machine.control.compensation_corner = Some(CompensationCorner::Linear);
    check_from(
        program,
        start,
        &machine,
        "G1 X-5 Y20 Z0
G1 X-5 Y65 Z0
G1 X35 Y65 Z0
G1 X35 Y80 Z0
G1 X0 Y100 Z0",
    );
}

#[test]
fn what_nothing_uses_is_a_finding() {
    check_codes("N1 G17 G90 G0 X1 Y2 Q5", &["E0210:1"]);
    check_codes("N1 G0 X1\nN2 G123 X5", &["E0201:2"]);
    check_codes("N1 X1 X2", &["E0111:1"]);
    check_codes("N1 G79 X1", &["E0218:1"]);
}

#[test]
fn a_tool_may_be_named_in_a_block_of_its_own() {
    let (lines, findings) = run("%PM9001\nN9001\nN1 T17\nN2 M30\n");
    assert!(findings.is_empty(), "{findings:?}");
    assert!(lines.iter().any(|line| line.starts_with("T17")), "{lines:?}");
}
