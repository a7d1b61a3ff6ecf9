//! The text that leaves: everything of the source in its place, and the marks of what was added.

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::{Machine, Tool};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{Arcs, CorrectionOptions, Corrector, Increments, OutputFrame};
use std::io;

use crate::bench_machine::{backlash, motion, polynomial};
use crate::machines::xyz_machine;

fn shop_machine() -> Machine {
    let mut machine = xyz_machine();
    let tool = |number, name: &str, length| Tool {
        number,
        name: Some(name.into()),
        edge: 1,
        length_mm: [length, 0.0, 0.0],
        radius_mm: 5.0,
    };
    machine.tools = vec![tool(5, "MILL_10", 100.0), tool(6, "DRILL_8", 120.0)];
    machine
}

fn writer_options(machine: &Machine, frame: OutputFrame, crlf: bool) -> WriterOptions {
    let stamp = Stamp { machine: "shop".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() };
    WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame,
        crlf,
        stamp,
        last_block_number: None,
        has_centers_reversed: false,
    }
}

/// The corrected text of a Sinumerik program, its stamp line cut short.
fn corrected(text: &str, errors: &ErrorModel, options: &CorrectionOptions, crlf: bool) -> String {
    corrected_on(&shop_machine(), text, errors, options, crlf)
}

fn corrected_on(machine: &Machine, text: &str, errors: &ErrorModel, options: &CorrectionOptions, crlf: bool) -> String {
    let model = Model::new(machine, errors);
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    assert!(findings.is_empty(), "{findings:?}");
    let strict = ExecOptions { strict: true, ..ExecOptions::default() };
    let execution = Execution::new(program, machine, Box::new(NoLibrary), strict);
    let mut corrector = Corrector::new(execution, machine, &model, options.clone());
    let mut writer = emit::writer("Sinumerik", &writer_options(machine, options.frame, crlf)).unwrap();
    let mut out = Vec::new();
    let blocks = emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| panic!("{finding:?}")).unwrap();
    assert!(emit::is_stamped(&out));
    let out = String::from_utf8(out).unwrap();
    let has_words = |line: &&str| line.contains(' ') || !line.starts_with('N');
    let is_block = |line: &&str| has_words(line) && !line.starts_with([';', '%']);
    assert_eq!(out.lines().filter(is_block).count() as u64, blocks);
    let stamp = writer_options(machine, options.frame, crlf).stamp.text();
    out.replace(&stamp, "ncfix …")
}

const PROGRAM: &str = "%_N_PLATE_MPF
;$PATH=/_N_WKS_DIR/_N_A_WPD
; PLATE 20
N10 G17 G90 G71 G64
N15
N20 T=\"MILL_10\" ; MILL
N30 M6
N40 G54 D1 S2000 M3 S2=500
N50 MSG(\"ROUGHING\")
N60 G0 X0 Y0 Z5
N70 G1 Z-2.5 F250.5 M8
N80 TRANS X10 Y-2.25
; SIDE
N90 G1 X50 F800 ; ALONG
N100 X30 Y30
N110 G2 X40 Y40 I10 J0 M9
N120 G9 G1 X45
N130 G4 F1.5
N140 G4 S3
N150 G53 G0 Z300
N160 G0 X0
N170 F900
N180 MSG()
N190 M2=3
N200 M30
";

#[test]
fn without_errors_the_program_comes_out_as_it_was() {
    let out = corrected(PROGRAM, &ErrorModel::default(), &CorrectionOptions::default(), false);
    insta::assert_snapshot!(out, @r#"
    %_N_PLATE_MPF
    ;$PATH=/_N_WKS_DIR/_N_A_WPD
    ; ncfix …
    ; PLATE 20
    N10 G17 G90 G71 G64
    N15
    N20 T="MILL_10" ; MILL
    N30 M6
    N40 G54 D1 S2000 M3 S2=500
    N50 MSG("ROUGHING")
    N60 G0 X0 Y0 Z5
    N70 G1 Z-2.5 F250.5 M8
    N80 TRANS X10 Y-2.25
    ; SIDE
    N90 G1 X50 F800 ; ALONG
    N100 G1 X30 Y30
    N110 G2 X40 Y40 I10 J0 M9
    N120 G9 G1 X45
    N130 G4 F1.5
    N140 G4 S3
    N150 G53 G0 Z300
    N160 G0 X0
    N170 F900
    N180 MSG()
    N190 M2=3
    N200 M30
    "#);
}

#[test]
fn pieces_are_marked_and_words_of_the_end_stand_at_the_end() {
    let errors = ErrorModel {
        motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6])), motion("EXX", backlash(-4.0))],
        ..ErrorModel::default()
    };
    let program = "N10 T5\nN20 M6\nN30 D1 G54\nN40 G0 X0 Y0 Z0\nN50 G9 G1 X150 F500 S100 M5 ; LONG\nN60 X40 M9\n\
                   N70 G53 X250\nN80 G3 X150 Y30 I0 J15\nN90 M30\n";
    let options = CorrectionOptions { tolerance_mm: 2e-3, arcs: Arcs::Chords, ..CorrectionOptions::default() };
    let out = corrected(program, &errors, &options, false);
    let lines: Vec<&str> = out.lines().take(18).collect();
    insta::assert_snapshot!(lines.join("\n"), @r#"
    ; ncfix …
    N10 T5
    N20 M6
    N30 G54 D1
    G90
    N40 G0 X0 Y-0.01 Z0
    ; LONG
    N50 G1 X-0.002 F500 S100 ;~
    X0.002 ;+~
    X85.8724 Y-0.0345 ;+
    G9 X150.002 Y-0.0625 M5 ;+
    N60 G1 X149.998 ;~
    X94.998 Y-0.038 ;+
    X39.998 Y-0.0196 M9 ;+
    N70 G53 G1 X140.002 ;~
    G53 X195.002 Y49.962 ;+
    G53 X250.002 Y49.9375 ;+
    N80 G1 X150.4734 Y-0.0553
    "#);
}

#[test]
fn machine_coordinates_need_no_zero_offset() {
    let options = CorrectionOptions { frame: OutputFrame::Machine, ..CorrectionOptions::default() };
    let program = "N10 T5\nN20 M6\nN30 D1 G54\nN40 G0 X0 Y0 Z0\nN50 TRANS X5\nN60 G1 X10 F100\nN70 G53 X20\n\
                   N80 G1 X30 Y0\nN85 G2 X40 I5 J0\nN90 M30\n";
    insta::assert_snapshot!(corrected(program, &ErrorModel::default(), &options, false), @r#"
    ; ncfix …
    N10 T5
    N20 M6
    N30 G54 D1
    G90
    N40 G153 G0 X100 Y50 Z10
    N50 TRANS X5
    N60 G153 G1 X115 F100
    N70 G153 G1 X20
    N80 G153 G1 X135 Y50
    N85 G153 G2 X145 I5 J0
    N90 M30
    "#);
}

#[test]
fn lines_end_as_in_the_source_and_inches_become_millimeters() {
    let out = corrected(
        "N10 G70 G0 X1 Y0 Z0\r\nN20 G1 X1.5 F20\r\nM30\r\n",
        &ErrorModel::default(),
        &CorrectionOptions::default(),
        true,
    );
    assert_eq!(out, "; ncfix …\r\nG90\r\nN10 G71 G0 X25.4 Y0 Z0\r\nN20 G1 X38.1 F20\r\nM30\r\n");
}

#[test]
fn feeds_are_written_without_the_noise_of_their_conversion() {
    let text = "N10 G700 G0 X0 Y0 Z0\nN20 G1 X1 F0.3\nN30 F12\nN40 X2\nM30\n";
    let out = corrected(text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    assert!(out.contains("X25.4 F7.62\n") && out.contains("N30 F304.8\n"), "{out}");
}

#[test]
fn nothing_is_written_behind_an_error_and_the_sink_is_heard() {
    struct Broken;
    impl io::Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::Error::other("full"))
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut machine = xyz_machine();
    machine.axes[0].as_mut().unwrap().travel = Some([0.0, 10.0]);
    let model = Model::new(&machine, &ErrorModel::default());
    let limited = machine.clone();
    let run = |text: &str, sink: &mut dyn io::Write| {
        let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
        let (program, _) = syntax::parse(&source, ncfix_dialect::sinumerik());
        let execution = Execution::new(program, &limited, Box::new(NoLibrary), ExecOptions::default());
        let mut corrector = Corrector::new(execution, &limited, &model, CorrectionOptions::default());
        let mut writer = emit::writer("sinumerik", &writer_options(&limited, OutputFrame::Work, false)).unwrap();
        let mut codes = Vec::new();
        let result = emit::emit(&mut corrector, writer.as_mut(), sink, |finding| codes.push(finding.code.as_str()));
        (result, codes)
    };
    let mut out = Vec::new();
    let (result, codes) = run("G0 X0 Y0 Z0\nG0 X11\nG0 X5\nG0 X-1\n", &mut out);
    assert!(result.is_ok());
    assert_eq!(codes, ["E0302", "E0302"], "the program is followed to its end");
    assert!(out.is_empty());
    assert!(run("G0 X0 Y0 Z0\n", &mut Broken).0.is_err());
    machine.control.increment_mm = 1.0 / 3.0;
    assert!(emit::writer("sinumerik", &writer_options(&machine, OutputFrame::Work, false)).is_none());
    assert!(emit::writer("fanuc", &writer_options(&machine, OutputFrame::Work, false)).is_none());
}

#[test]
fn increments_of_the_control_decide_the_decimals() {
    let mut machine = shop_machine();
    machine.control.increment_mm = 0.0005;
    let model = Model::new(&machine, &ErrorModel::default());
    let source = Source::new(FileId(0), "t", b"G0 X1.00074 Y-0.0002 Z100\n".to_vec()).unwrap();
    let (program, _) = syntax::parse(&source, ncfix_dialect::sinumerik());
    let execution = Execution::new(program, &machine, Box::new(NoLibrary), ExecOptions::default());
    let mut corrector = Corrector::new(execution, &machine, &model, CorrectionOptions::default());
    let mut writer = emit::writer("sinumerik", &writer_options(&machine, OutputFrame::Work, false)).unwrap();
    let mut out = Vec::new();
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |_| {}).unwrap();
    assert!(String::from_utf8(out).unwrap().ends_with("G0 X1.0005 Y0 Z100\n"));
}

#[test]
fn under_exact_stop_a_move_stops_at_its_end_only() {
    let errors = ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6]))], ..ErrorModel::default() };
    let program = "N10 G54\nN20 G60 G0 X0 Y0 Z0\nN30 G1 X200 F500\nN40 G64\nN50 X0\nN60 G60 X200\n";
    let options = CorrectionOptions { tolerance_mm: 2e-3, ..CorrectionOptions::default() };
    let out = corrected(program, &errors, &options, false);
    let lines: Vec<&str> = out.lines().filter(|line| line.contains('X')).collect();
    let is_stop = |line: &&&str| line.contains("G60");
    // N20 is one piece, N30 several: it leaves G60 on its first and takes it up again on its last.
    assert_eq!(lines.iter().filter(is_stop).count(), 3, "{out}");
    let last_of_n30 = lines.iter().position(|line| line.starts_with("N50")).unwrap() - 1;
    assert!(
        lines[0].starts_with("N20 G60 G0")
            && lines[1].starts_with("N30 G64 G1")
            && is_stop(&&lines[last_of_n30])
            && last_of_n30 > 2,
        "{out}"
    );
    let n60 = lines.iter().position(|line| line.starts_with("N60")).unwrap();
    assert!(lines[n60].starts_with("N60 G64 G1 X") && lines.last().unwrap().starts_with("G60 X"), "{out}");
}

#[test]
fn what_save_brings_back_is_said_again() {
    let text = "%_N_MAIN_MPF
N10 G17 G90 G71 G64 G94
N20 G54 G0 X0 Y0 Z0
N25 TRANS X10
N30 SUB P2
N40 G1 X5 F100
N50 M30
%_N_SUB_SPF
PROC SUB SAVE
N1 G18 G60 SOFT G91
N2 G500
N3 TRANS Y5
N4 AROT Z90
N5 X=AC(7) Y=AC(0) M17
";
    let out = corrected(text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    // Numbers of a subprogram are not those of the program.
    let run = "\nG18 G60 SOFT G90\nG500\nTRANS Y5\nAROT Z90\n";
    let back = "G17 G64 BRISK\nG54\nTRANS X10\n";
    assert_eq!(out.matches(run).count(), 2, "{out}");
    assert_eq!(out.matches(back).count(), 2, "{out}");
    assert!(out.ends_with("TRANS X10\nN40 G1 X5 F100\nN50 M30\n"), "{out}");
    // Positions, feed and tool are no modal state.
    let text = "F100\nG0 X1 Y0 Z0\nSUB\nG1 X2\nM30\n%_N_SUB_SPF\nPROC SUB SAVE\nG1 X5 F300\nM17\n";
    let out = corrected(text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    assert!(out.ends_with("G1 X5 F300\nG1 X2\nM30\n"), "{out}");
}

#[test]
fn save_brings_back_the_feed_of_the_feed_mode() {
    let text = "G94 F200\nG0 X0 Y0 Z0\nSUB\nG1 X2\nM30\n%_N_SUB_SPF\nPROC SUB SAVE\nG95 G1 X1 F0.1\nM17\n";
    let out = corrected(text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    assert!(out.ends_with("G95 G1 X1 F0.1\nG94\nG1 X2 F200\nM30\n"), "{out}");
}

#[test]
fn save_brings_back_what_is_active_at_the_start() {
    let text = "G0 X0 Y0 Z0\nSUB\nX2\nM30\n%_N_SUB_SPF\nPROC SUB SAVE\nG641 SOFT\nM17\n";
    let out = corrected(text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    assert!(out.ends_with("G641 SOFT\nG60 BRISK\nG0 X2\nM30\n"), "{out}");
    let demo = std::fs::read_to_string(crate::support::machine("demo")).unwrap();
    let own = |codes: &str| demo.replace("[control]", &format!("[control]\ninitial_codes = [{codes}]"));
    let shop = crate::support::Shop::new().file("a.mpf", text.replace("G0 X0", "G90 G54 G0 X0"));
    let shop = shop.file("m.toml", own("\"G64\", \"soft\"")).file("bad.toml", own("\"G18\""));
    shop.run(["fix", "a.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    assert!(shop.text("out.mpf").contains("G641 SOFT\nG64\n"), "{}", shop.text("out.mpf"));
    shop.run(["check", "a.mpf", "--machine", "bad.toml"]).exits(4).says("'G18' in control.initial_codes");
}

#[test]
fn an_exact_stop_belongs_to_the_end_of_its_block() {
    // The arc around the corner belongs to the block behind it, which is then two lines.
    let mut machine = xyz_machine();
    machine.control.tool_change = ncfix_machine::machine::ToolChange::T;
    machine.tools =
        vec![ncfix_machine::machine::Tool { number: 1, name: None, edge: 1, length_mm: [0.0; 3], radius_mm: 5.0 }];
    let text = |stop: &str, word: &str| {
        format!(
            "N10 G17 G90 G71 {stop} G0 X0 Y0 Z0 F100 T1 D1\nN15 G0 X-20 Y-20 Z0\nN20 G41 G1 X0 Y0\nN30 Y40\nN40 {word} X50\nN50 G40 Y60\nN60 M30\n"
        )
    };
    let run =
        |text: String| corrected_on(&machine, &text, &ErrorModel::default(), &CorrectionOptions::default(), false);
    let once = run(text("G64", "G9"));
    assert!(once.contains("N40 G2 X0 Y45 I5 J0\nG9 G1 X50 Y45\n"), "{once}");
    let always = run(text("G60", ""));
    assert!(always.contains("N40 G64 G2 X0 Y45 I5 J0\nG60 G1 X50 Y45\nN50"), "{always}");
}

#[test]
fn a_block_on_the_line_of_its_program_number_is_written_once() {
    let machine = crate::iso::iso_machine();
    let model = Model::new(&machine, &ErrorModel::default());
    let text = b"%\nO1234 (PLATE) G91 G0 X1.\nG90 G0 X10. Y5. Z2.\nM30\n%\n".to_vec();
    let (program, findings) =
        syntax::parse(&Source::new(FileId(0), "p.nc", text).unwrap(), ncfix_dialect::find("fanuc").unwrap());
    assert!(findings.is_empty(), "{findings:?}");
    let execution = Execution::new(program, &machine, Box::new(NoLibrary), ExecOptions::default());
    let mut corrector = Corrector::new(execution, &machine, &model, CorrectionOptions::default());
    let mut writer = emit::writer("fanuc", &writer_options(&machine, OutputFrame::Work, false)).unwrap();
    let mut out = Vec::new();
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |_| {}).unwrap();
    let out = String::from_utf8(out).unwrap();
    assert!(out.starts_with("%\nO1234\n(NCFIX"), "{out}");
    assert_eq!(out.matches("X1.").count(), 1, "{out}");
}
