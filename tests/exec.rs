//! Execution of the Sinumerik core: programs with the flat stream that a control produces, worked out by hand.
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, Library, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::{Machine, Tool, ToolChange};
use ncfix_machine::snc::TextWriter;

use crate::machines::xyz_machine;

pub(crate) struct Programs(pub(crate) Vec<(&'static str, &'static str)>);

impl Library for Programs {
    fn load(&mut self, name: &str) -> Option<(String, Vec<u8>)> {
        self.0
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, text)| (format!("{name}.SPF"), text.as_bytes().to_vec()))
    }
}

/// The SNC lines of a program without origins, and the codes of all findings with their lines.
pub(crate) fn run_with(
    text: &str,
    machine: &Machine,
    library: Box<dyn Library>,
    options: Options,
) -> (Vec<String>, Vec<String>) {
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    let mut codes: Vec<String> =
        findings.iter().map(|f| format!("{}:{}", f.code, source.line_column(f.place.unwrap().span.start).0)).collect();
    let mut execution = Execution::new(program, machine, library, options);
    let mut out = TextWriter::new(Vec::new(), "test", machine.axis_set(), |_, tool| *tool).unwrap();
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
    let lines = text.lines().skip(1).map(|line| line.split(" ;").next().unwrap().to_owned()).collect();
    (lines, codes)
}

pub(crate) fn run(text: &str) -> (Vec<String>, Vec<String>) {
    run_with(text, &xyz_machine(), Box::new(NoLibrary), Options::default())
}

/// Checks the motion lines (G0 … G3) of a program that runs without findings.
#[track_caller]
pub(crate) fn check(text: &str, expected: &[&str]) {
    let (lines, codes) = run(text);
    assert!(codes.is_empty(), "{codes:?}");
    let moves: Vec<&str> =
        lines.iter().map(String::as_str).filter(|line| line.starts_with('G') && !line.starts_with("G4")).collect();
    assert_eq!(moves, expected);
}

#[track_caller]
pub(crate) fn check_codes(text: &str, expected: &[&str]) {
    assert_eq!(run(text).1, expected);
}

#[test]
fn an_incremental_word_behind_a_frame_change_traverses_it_or_not() {
    let text = "N10 G90 G0 X10\nN20 TRANS X5\nN30 G91 X10\nN40 G90 X0";
    check(text, &["G0 X10 Y0 Z0", "G0 X25 Y0 Z0", "G0 X5 Y0 Z0"]);
    let mut machine = xyz_machine();
    machine.control.incremental_traverses_frame_change = false;
    let (lines, _) = run_with(text, &machine, Box::new(NoLibrary), Options::default());
    assert_eq!(lines, ["G0 X10 Y0 Z0", "G0 X20 Y0 Z0", "G0 X5 Y0 Z0"]);
}

#[test]
fn subprograms_repeat_nest_and_leave_modal_state_behind() {
    let text = "%_N_MAIN_MPF
;$PATH=/_N_MPF_DIR
N10 G17 G90 G0 X0 Y0 Z5
N20 STAIR
N30 L20 P2
N35 L020
N40 G1 X0 Y0 F1
N50 M30
%_N_STAIR_SPF
PROC STAIR DISPLOF
DEF INT K
G91 G1 F300
FOR K=1 TO 2
X=10
Y=10
ENDFOR
G90
RET
%_N_L20_SPF
;$PATH=/_N_SPF_DIR
N10 Y=IC(7)
N20 M17
";
    let library = Programs(vec![("L020", "Z=IC(1)\nINNER\n"), ("INNER", "X7\nM2\nX8")]);
    let (lines, codes) = run_with(text, &xyz_machine(), Box::new(library), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(
        lines,
        [
            "G0 X0 Y0 Z5",
            "G1 X10 Y0 Z5 F300",
            "G1 X10 Y10 Z5 F300",
            "G1 X20 Y10 Z5 F300",
            "G1 X20 Y20 Z5 F300",
            "G1 X20 Y27 Z5 F300",
            "G1 X20 Y34 Z5 F300",
            "G1 X20 Y34 Z6 F300",
            "G1 X7 Y34 Z6 F300",
            "G1 X0 Y0 Z6 F1",
            "M30",
        ]
    );
}

#[test]
fn values_of_the_reference() {
    // Each value goes through X with full precision; comparisons bind weakest.
    for (expression, value) in [
        ("7/2", "3.5"),
        ("7 DIV 2", "3"),
        ("-7 MOD 3", "-1"),
        ("2+3*4", "14"),
        ("ROUND(2.5)", "3"),
        ("TRUNC(-2.7)", "-2"),
        ("ATAN2(1,-1)", "135"),
        ("POT(3)", "9"),
        ("5 B_AND 3", "1"),
        ("5 B_OR 3", "7"),
        ("5 B_XOR 3", "6"),
        ("'H1F'", "31"),
        ("'B101'", "5"),
        ("1.5EX2", "150"),
        ("(10*0.1==1)*5", "5"),
        ("SIN(30)", "0.5"),
        ("COS(90)", "0"),
        ("-R1*2", "-8"),
        ("2--3", "5"),
        ("SQRT(16)+ABS(-2)", "6"),
        ("(1==1 AND 0)+2", "2"),
        ("NOT 0+4", "5"),
        ("R[2+1]", "0"),
        ("BOUND(1,5,9)", "5"),
    ] {
        let (lines, codes) = run(&format!("R1=4\nG0 X={expression}"));
        assert!(codes.is_empty(), "{expression}: {codes:?}");
        assert_eq!(lines, [format!("G0 X{value} Y0 Z0")], "{expression}");
    }
}

#[test]
fn words_without_blanks_and_lower_case() {
    let (lines, codes) = run("n10g0g54x-10y.20z30.4ex-1b0\nN10G0G54X-10Y.20Z30.4EX-1T100S400.0M3H12 ; all of it");
    // The test machine has no B axis.
    assert_eq!(codes, ["E0309:1"]);
    assert_eq!(lines, ["T100", "S400 M3 H12", "G0 X90 Y50.2 Z13.04"]);
}

#[test]
fn tools_act_with_m6_or_with_t_and_their_length_does_not_move_the_tip() {
    let mut machine = xyz_machine();
    machine.tools.push(Tool {
        number: 5,
        name: Some("MILL_10".into()),
        edge: 1,
        length_mm: [100.0, 0.0, 0.0],
        radius_mm: 5.0,
    });
    let text = "T=\"mill_10\"\nM6\nG0 X1 Y1 Z50\nD0\nZ50";
    let (lines, codes) = run_with(text, &machine, Box::new(NoLibrary), Options { strict: true, ..Options::default() });
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, ["T=\"mill_10\"", "M6", "G0 X1 Y1 Z50", "D0", "G0 X1 Y1 Z50"]);
    machine.control.tool_change = ToolChange::T;
    let strict = Options { strict: true, ..Options::default() };
    assert_eq!(run_with("T6 D1\nG0 X0", &machine, Box::new(NoLibrary), strict.clone()).1, ["E0307:1"]);
    // The length acts along Z.
    assert_eq!(run_with("D1\nG0 X0\nZ0", &machine, Box::new(NoLibrary), strict.clone()).1, ["E0307:3"]);
    assert!(run_with("T0 D1\nG0 X0", &machine, Box::new(NoLibrary), strict.clone()).1.is_empty());
    assert!(run_with("T5 D1\nG0 X0", &machine, Box::new(NoLibrary), strict).1.is_empty());
}

#[test]
fn a_strict_run_refuses_unknown_starts_and_offsets() {
    let strict = || Options { strict: true, ..Options::default() };
    let codes = |text: &str| run_with(text, &xyz_machine(), Box::new(NoLibrary), strict()).1;
    assert_eq!(codes("G91 G0 X10"), ["E0304:1"]);
    assert_eq!(codes("G0 X0 Y0 Z0\nG91 X10\nT1 M6\nX10"), ["E0307:3", "E0304:4"]);
    assert_eq!(codes("G0 X0\nG2 X10 Y0 I5 J0 F100"), ["E0304:2"]);
    assert_eq!(codes("G505 G0 X0"), ["E0306:1"]);
    let started = Options { start: Some(Default::default()), ..strict() };
    assert!(run_with("G91 G0 X10", &xyz_machine(), Box::new(NoLibrary), started).1.is_empty());
}

#[test]
fn a_program_without_end_stops_at_the_limit() {
    let options = Options { max_blocks: Some(1000), ..Options::default() };
    for text in ["WHILE TRUE\nENDWHILE", "AB: G0 X1\nGOTOB AB", "LOOP\nX=IC(1)\nENDLOOP"] {
        let (_, codes) = run_with(&format!("G0 X0\n{text}\n"), &xyz_machine(), Box::new(NoLibrary), options.clone());
        assert!(codes.len() == 1 && codes[0].starts_with("E0214"), "{text}: {codes:?}");
    }
    let (_, codes) = run_with("%_N_A_MPF\nSUB\n%_N_SUB_SPF\nSUB\n", &xyz_machine(), Box::new(NoLibrary), options);
    assert_eq!(codes, ["E0213:4"]);
}

#[test]
fn skip_blocks_run_or_not_as_chosen_and_say_so_once() {
    let text = "G0 X1\n/ X2\n/2 N10 X3\nN20 /1 X4";
    assert_eq!(
        run(text),
        (
            vec!["G0 X1 Y0 Z0".into(), "G0 X2 Y0 Z0".into(), "G0 X3 Y0 Z0".into(), "G0 X4 Y0 Z0".into()],
            vec!["W0201:2".into()]
        )
    );
    let mut options = Options::default();
    options.skip_levels[2] = true;
    let (lines, _) = run_with(text, &xyz_machine(), Box::new(NoLibrary), options);
    assert_eq!(lines, ["G0 X1 Y0 Z0", "G0 X2 Y0 Z0", "G0 X4 Y0 Z0"]);
}

#[test]
fn dwell_message_and_auxiliary_words_keep_their_places() {
    let (lines, codes) = run("N10 G4 F1.5\nG4 S3\nMSG(\"A;B\"<<R1)\nN20 S1200 M3 M8\nN30 G0 X1 M9\nM30");
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, ["G4 S1.5", "G4 R3", "S1200 M3 M8", "G0 X1 Y0 Z0", "M9", "M30"]);
}

#[test]
fn any_bytes_are_read() {
    for text in [
        &b"\0\0\0%_N_A_MPF\r\nN10 G0 X1 ;\xb2\xe2\xca\xd4\r\nM30\r\n"[..],
        b"\xef\xbb\xbfN10 G0 X1 ; \xe4\xf6\nM30",
        b"G0 X1\rM30",
    ] {
        let source = Source::new(FileId(0), "a", text.to_vec()).unwrap();
        let machine = xyz_machine();
        let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
        assert!(findings.is_empty(), "{findings:?}");
        let moves = Execution::new(program, &machine, Box::new(NoLibrary), Options::default())
            .filter(|item| matches!(item, Ok(e) if matches!(e.kind, ncfix_machine::snc::Kind::Move(_))))
            .count();
        assert_eq!(moves, 1, "{}", String::from_utf8_lossy(text));
    }
}

#[test]
fn incremental_blocks_do_not_drift() {
    let mut text = String::from("G90 G0 X0 Y0 Z0\nG91 G1 F100\n");
    (0..100_000).for_each(|_| text.push_str("X0.00333 Y-.0001\n"));
    let (lines, codes) = run(&text);
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines.last().map(String::as_str), Some("G1 X333 Y-10 Z0 F100"));
}

#[test]
fn an_empty_spindle_and_another_plane_leave_no_length_behind() {
    let mut machine = xyz_machine();
    let length_mm = [100.0, 0.0, 0.0];
    machine.tools.push(Tool { number: 5, name: None, edge: 1, length_mm, radius_mm: 5.0 });
    let strict = || Options { strict: true, ..Options::default() };
    let codes = |text: &str, machine: &Machine| run_with(text, machine, Box::new(NoLibrary), strict()).1;
    assert!(codes("T5 M6\nG0 X0 Y0 Z50\nT0 M6\nG0 X1 Y1 Z1", &machine).is_empty());
    // In G18 the length lies along Y: where Y and Z are now depends on the control, so both must be stated again.
    assert_eq!(codes("T5 M6\nG0 X0 Y0 Z50\nG18\nG91 Z1", &machine), ["E0304:4"]);
    machine.control.tool_length_plane = Some(ncfix_base::geometry::Plane::XY);
    assert!(codes("T5 M6\nG0 X0 Y0 Z50\nG18\nG91 Z1", &machine).is_empty());
}

#[test]
fn a_doubt_about_units_is_found_where_the_unit_changes() {
    check_codes("G0 X1\nG70 X2", &["E0305:2"]);
    check_codes("TRANS X1\nG700 G0 X2", &["E0305:2"]);
    check_codes("G71 G0 X1\nG70 X2", &[]);
}

#[test]
fn findings_come_with_their_lines_and_all_in_one_run() {
    check_codes(
        "G0 X\nG1 Y5\nG0 X1 X2\nGEOAX(1,X)\nCYCLE63(1,2)\nG0 Q1\n",
        &["E0103:1", "W0202:2", "E0111:3", "E0201:4", "E0201:5", "E0201:6"],
    );
    check_codes("IF R1\nG0 X1\n", &["E0106:1"]);
    check_codes("IF R1\nENDIF G0 X1\n", &["E0108:2"]);
    check_codes("FOR R1=1 TO 3\nENDWHILE\n", &["E0106:1", "E0106:2"]);
    check_codes(
        "G0 X0 Y0\nG2 X10 Y0 I4 J0 F1\nG2 X20 CR=4\nG2 X20\nG2 X30 I5 K2\n",
        &["E0203:2", "E0204:3", "E0202:4", "E0205:5"],
    );
    check_codes(
        "R1=1/0\nR2=FOO\nGOTOF NOWHERE\nNOPROG\nL5\nR[10000]=1\nR3=SQRT(-1)\n",
        &["E0209:1", "E0206:2", "E0211:3", "E0212:4", "E0212:5", "E0207:6", "E0209:7"],
    );
}
