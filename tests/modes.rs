//! Words that change no position: they come out in their places with the values that they have, and change nothing else.
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options as ExecOptions};
use ncfix_language::syntax;
use ncfix_machine::machine::{Machine, Opaque, file};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, OutputFrame};

use crate::bench_machine::{motion, polynomial};
use crate::machines::xyz_machine;

/// The lines that a program becomes on a machine, without stamp, and the codes of all findings.
pub(crate) fn written(
    text: &str,
    machine: &Machine,
    errors: &ErrorModel,
    options: CorrectionOptions,
) -> (Vec<String>, Vec<String>) {
    let model = Model::new(machine, errors);
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    let mut codes: Vec<String> = findings.iter().map(|found| found.code.to_string()).collect();
    let execution = Execution::new(program, machine, Box::new(NoLibrary), ExecOptions::default());
    let stamp = Stamp { machine: "m".into(), model: "0".into(), source: "0".into(), ..Stamp::default() };
    let increments = Increments::new(&machine.control);
    let writer = WriterOptions {
        names: machine.written_names(),
        increments,
        frame: OutputFrame::Work,
        crlf: false,
        stamp,
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut corrector = Corrector::new(execution, machine, &model, options);
    let mut writer = emit::writer("sinumerik", &writer).unwrap();
    let mut out = Vec::new();
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |found| codes.push(found.code.to_string())).unwrap();
    let out = String::from_utf8(out).unwrap();
    (out.lines().filter(|line| !line.starts_with("; ncfix")).map(str::to_owned).collect(), codes)
}

/// Checks the lines behind the line `G90` that the writer begins with, for a program without findings on an ideal machine.
#[track_caller]
fn check_on(machine: &Machine, text: &str, expected: &[&str]) {
    let (lines, codes) = written(text, machine, &ErrorModel::default(), CorrectionOptions::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines, expected);
}

#[track_caller]
pub(crate) fn check(text: &str, expected: &[&str]) {
    check_on(&xyz_machine(), text, expected);
}

#[track_caller]
pub(crate) fn codes(text: &str) -> Vec<String> {
    written(text, &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default()).1
}

#[test]
fn modes_keep_their_places_and_their_values() {
    check(
        "N10 G90 G641 ADIS=R1+0.5 ADISPOS=2 SOFT\nN20 FGROUP(X,Y) FGREF[A]=10 G0 X1\nN30 ACC[X]=80 LIMS=3000 G96 S200 M4\n\
         N40 CYCLE832(0.05,_FINISH+_ORI_FINISH,1)\nN50 CTOL=0.02 OTOL=0.1 G1 X2 F100\nN60 SETMS(1+1)\nN70 COMPCAD FFWON\nN80 M30",
        &[
            "N10 G90 G641 SOFT ADIS=0.5 ADISPOS=2",
            "N20 FGROUP(X,Y) FGREF[A]=10 G0 X1",
            "N30 G96 ACC[X]=80 LIMS=3000 S200 M4",
            "N40 CYCLE832(0.05,_FINISH+_ORI_FINISH,1)",
            "N50 CTOL=0.02 OTOL=0.1 G1 X2 F100",
            "N60 SETMS(2)",
            "N70 COMPCAD FFWON",
            "N80 M30",
        ],
    );
}

#[test]
fn spindles_axes_and_channels_are_passed_on() {
    check(
        "G90\nDEF INT K=2\nS[K]=500 M[K]=4\nM=QU(7)\nSPOS=R1+90\nSPOS[2]=DC(45)\nSPCON(K)\nH1=5\nWAITM(1,1,2)\nINIT(2,\"SUB\",\"S\")\n\
         START(2)\nSETAL(65000)\nCANCEL(K,3)\nCOUPON(S2,S1,30)\nENABLE(1)\nNEWCONF\nM30",
        &[
            "G90",
            "S[2]=500 M[2]=4",
            "M=QU(7)",
            "SPOS=90",
            "SPOS[2]=DC(45)",
            "SPCON(2)",
            "H1=5",
            "WAITM(1,1,2)",
            "INIT(2,\"SUB\",\"S\")",
            "START(2)",
            "SETAL(65000)",
            "CANCEL(2,3)",
            "COUPON(S2,S1,30)",
            "ENABLE(1)",
            "NEWCONF",
            "M30",
        ],
    );
}

#[test]
fn lengths_and_feeds_of_inch_programs_become_metric() {
    // 0.1 in = 2.54 mm, 10 in/min = 254 mm/min.
    check(
        "G90 G700\nG641 ADIS=0.1 FA[X]=10 OTOL=0.1\nG26 X4 S3000\nG1 X1 F10\nCYCLE832(0.001,1,1)\nM30",
        &[
            "G90 G710",
            "G641 ADIS=2.54 FA[X]=254 OTOL=0.1",
            "G26 X101.6 S3000",
            "G1 X25.4 F254",
            "CYCLE832(0.0254,1,1)",
            "M30",
        ],
    );
}

#[test]
fn limits_of_the_working_area_move_nothing() {
    let (lines, codes) = written(
        "G90 G0 X1\nG25 X-10 Y=R1-5 S2=20\nG26 S3000\nG91 Y1\nM30",
        &xyz_machine(),
        &ErrorModel::default(),
        CorrectionOptions::default(),
    );
    assert!(codes.is_empty(), "{codes:?}");
    assert_eq!(lines[1..3], ["G25 X-10 Y=-5 S2=20", "G26 S3000"]);
    assert_eq!(self::codes("G25 X1 M3"), ["E0108"]);
    // Its words would be those of the motion too.
    assert_eq!(self::codes("G90 G26 G0 X0 Y0 Z0"), ["E0108"]);
}

#[test]
fn a_block_feed_holds_for_its_block() {
    check(
        "G90 G1 X1 F100\nX2 FB=250\nX3\nG0 X4 FB=7\nG1 X5\nM30",
        &["G90 G1 X1 F100", "G1 X2 F250", "G1 X3 F100", "G0 X4", "G1 X5", "M30"],
    );
    assert_eq!(codes("G90 G1 X1 FB=0 F100"), ["E0210"]);
}

#[test]
fn a_block_feed_holds_for_all_pieces_of_its_block() {
    let errors = ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6]))], ..ErrorModel::default() };
    let (lines, codes) = written(
        "G90 G0 X0 Y0 Z0\nG1 X10 F100\nX300 FB=250\nX310\nM30",
        &xyz_machine(),
        &errors,
        CorrectionOptions::default(),
    );
    assert!(codes.is_empty(), "{codes:?}");
    let feeds: Vec<&String> = lines.iter().filter(|line| line.contains('F')).collect();
    assert_eq!(feeds.len(), 3, "{lines:?}");
    assert!(feeds[1].contains("F250") && feeds[2].contains("X310") && feeds[2].contains("F100"), "{lines:?}");
    assert!(lines.len() > 6, "the long move is cut: {lines:?}");
}

#[test]
fn diameters_are_refused_where_they_matter() {
    check("G90 DIAMON\nG0 Y1 Z2\nDIAMOF G0 X1\nM30", &["G90 DIAMOF", "G0 Y1 Z2", "DIAMOF G0 X1", "M30"]);
    assert_eq!(codes("G90 DIAMON\nG0 X1"), ["E0201"]);
    assert_eq!(codes("G90 DIAM90\nG2 Y1 I1 F1"), ["E0201"]);
    let mut machine = xyz_machine();
    machine.control.transverse_axis = ncfix_base::geometry::Axis::Y;
    check_on(&machine, "G90 DIAMON\nG0 X1 Z2\nM30", &["G90 DIAMOF", "G0 X1 Z2", "M30"]);
}

#[test]
fn file_access_is_left_out_and_its_result_is_no_error() {
    let program = "DEF INT ERR=7\nG90\nWRITE(ERR,\"LOG\",\"A\"<<R1)\nDELETE(R5,\"LOG\")\nIF ERR==0 GOTOF FINE\nG0 X99\nFINE: G0 X1\nM30";
    let (lines, codes) = written(program, &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default());
    assert_eq!(codes, ["W0204", "W0204"]);
    assert_eq!(lines, ["G90", "FINE: G0 X1", "M30"]);
}

#[test]
fn what_would_move_the_machine_unseen_is_refused() {
    for word in [
        "GEOAX(1,U)",
        "PRESETON(X,10)",
        "TRAILON(V,X)",
        "LEADON(V,X,1)",
        "TOFFON(Z)",
        "MEAS=1 G1 X1 F1",
        "MEAW=1 G1 X1 F1",
        "READ(R1,\"A\",1,1,R2)",
        "TRANSMIT",
        "TRACYL(40)",
        "TRAANG(30)",
    ] {
        assert_eq!(codes(&format!("G90\n{word}\nM30")), ["E0201"], "{word}");
    }
    check("G90\nTRAILOF(V,X)\nLEADOF(V,X)\nM30", &["G90", "TRAILOF(V,X)", "LEADOF(V,X)", "M30"]);
}

#[test]
fn an_interrupt_is_passed_on_with_a_warning() {
    let program = "G90\nSETINT(3) PRIO=1 LIFT_Z LIFTFAST ; AWAY\nCLRINT(3)\nM30";
    let (lines, codes) = written(program, &xyz_machine(), &ErrorModel::default(), CorrectionOptions::default());
    assert_eq!(codes, ["W0205"]);
    assert_eq!(lines, ["G90", "SETINT(3) PRIO=1 LIFT_Z LIFTFAST ; AWAY", "CLRINT(3)", "M30"]);
}

#[test]
fn a_name_of_the_program_beside_one_of_the_control_is_not_guessed() {
    assert_eq!(codes("G90\nSETMS(R1+UNKNOWN)\nM30"), ["E0206"]);
    assert_eq!(codes("G90\nLIMS=$UNKNOWN\nM30"), ["E0219"]);
}

fn with_opaque(entries: &[(&str, bool)]) -> Machine {
    let mut machine = xyz_machine();
    machine.control.opaque = entries.iter().map(|&(name, moves)| Opaque { name: name.into(), moves }).collect();
    machine
}

#[test]
fn an_opaque_call_is_passed_on_with_its_values() {
    let machine = with_opaque(&[("WASH", false), ("L6", false), ("CYCLE9*", false)]);
    check_on(
        &machine,
        "DEF REAL D=1.5\nG90 G0 X1\nN20 WASH(R1+2,,\"A\",D)\nL6 P2\nCYCLE97(1,2)\nWASH\nG91 X1\nM30",
        &["G90 G0 X1", "N20 WASH(2,,\"A\",1.5)", "L6 P2", "CYCLE97(1,2)", "WASH", "G90 G0 X2", "M30"],
    );
    assert_eq!(codes("G90\nWASH\nM30"), ["E0212"]);
    assert_eq!(codes("G90\nL6\nM30"), ["E0212"]);
}

#[test]
fn an_opaque_program_may_be_called_by_statement() {
    check_on(
        &with_opaque(&[("WASH", false)]),
        "DEF STRING[20] NAME=\"WASH\"\nG90 G0 X1\nCALL NAME\nEXTCALL(\"WASH\")\nPCALL /_N_SPF_DIR/WASH(R1,2)\nM30",
        &["G90 G0 X1", "CALL \"WASH\"", "EXTCALL(\"WASH\")", "PCALL /_N_SPF_DIR/WASH(0,2)", "M30"],
    );
}

#[test]
fn behind_an_opaque_call_that_moves_the_position_is_unknown() {
    let program = "G90 G0 X1 Y2 Z3\nCHANGE\nG91 G1 X1 F100\nM30";
    let source = Source::new(FileId(0), "test.mpf", program.as_bytes().to_vec()).unwrap();
    for (moves, expected) in [(true, vec!["E0304"]), (false, vec![])] {
        let machine = with_opaque(&[("CHANGE", moves)]);
        let (parsed, _) = syntax::parse(&source, ncfix_dialect::sinumerik());
        let options = ExecOptions { strict: true, ..ExecOptions::default() };
        let found: Vec<String> = Execution::new(parsed, &machine, Box::new(NoLibrary), options)
            .filter_map(|item| item.err().map(|found| found.code.to_string()))
            .collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn the_machine_file_names_opaque_programs() {
    let keys = "[control]\nopaque = [\"l6\", \"CYCLE9*\"]\nallow_synchronised = [\"3\"]\ntransverse_axis = \"Y\"\n";
    let text = file::DEMO.replace("[control]\n", keys) + "\n[[opaque]]\nname = \"L6\"\nmoves = false\n";
    let source = Source::new(FileId(0), "machine.toml", text.into_bytes()).unwrap();
    let (machine, findings) = file::read_machine(&file::MachineFile::parse(&source).unwrap());
    let control = machine.unwrap_or_else(|| panic!("{findings:?}")).control;
    assert_eq!(control.opaque_moves("L6"), Some(false));
    assert_eq!(control.opaque_moves("CYCLE97"), Some(true));
    assert_eq!(control.opaque_moves("CYCLE81"), None);
    assert_eq!(control.transverse_axis, ncfix_base::geometry::Axis::Y);
    assert!(control.allows_synchronised(Some(3)));
    assert!(!control.allows_synchronised(Some(4)) && !control.allows_synchronised(None));
}

#[test]
fn the_time_of_a_block_is_shared_by_its_pieces() {
    let errors = ErrorModel { motion: vec![motion("EYX", polynomial(&[0.0, 0.0, 1e-6]))], ..ErrorModel::default() };
    let program = "G90 G94 G0 X0 Y0 Z0\nG93 G1 X300 F2\nX310\nX10 F0.5\nG94 X0 F100\nM30";
    let (lines, codes) = written(program, &xyz_machine(), &errors, CorrectionOptions::default());
    assert!(codes.is_empty(), "{codes:?}");
    let blocks: Vec<(&str, f64, Option<f64>)> = lines
        .iter()
        .filter_map(|line| {
            let word = |letter: char| line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok());
            Some((line.as_str(), word('X')?, word('F')))
        })
        .collect();
    // Minutes of the blocks: 1/2, 1/2 (F stays), 1/0.5; each piece takes what its length takes of that.
    let (mut at, mut feed, mut minutes) = (0.0, 0.0, vec![0.0; 4]);
    let mut block = 0;
    let mut is_on = false;
    for (line, x, word) in &blocks {
        is_on |= line.contains("G93");
        if line.contains("G94") && is_on {
            assert_eq!(*word, Some(100.0));
            break;
        }
        if let Some(word) = word {
            feed = *word;
        }
        block += usize::from(!line.contains(";+"));
        if is_on {
            minutes[block - 2] += 1.0 / feed;
        }
        at = *x;
    }
    assert!((at - 10.0_f64).abs() < 1e-3);
    assert!(blocks.len() > 8, "{lines:?}");
    for (found, expected) in minutes.iter().zip([0.5, 0.5, 2.0]) {
        assert!((found - expected).abs() < 1e-4, "{minutes:?} {lines:?}");
    }
}

#[test]
fn behind_a_change_of_the_feed_mode_the_feed_must_be_programmed_again() {
    assert_eq!(codes("G90 G0 X0\nG93 G1 X1 F2\nG94 X2\nM30"), ["W0202"]);
    // Millimeters per minute are none per turn.
    for (mode, other) in
        [("G94", "G95"), ("G95", "G94"), ("G94", "G96 S100"), ("G961 S100", "G97"), ("G96 S100", "G971")]
    {
        let text = |feed| format!("G90 G0 X0\n{mode}\nG1 X1 F2\n{other}\nX2{feed}\nM30");
        assert_eq!(codes(&text("")), ["W0202"], "{mode} {other}");
        assert!(codes(&text(" F2")).is_empty(), "{mode} {other}");
    }
    for (mode, other) in
        [("G95", "G96 S100"), ("G96 S100", "G97"), ("G94", "G961 S100"), ("G95", "G962 S100"), ("G94", "G972")]
    {
        assert!(codes(&format!("G90 G0 X0\n{mode}\nG1 X1 F2\n{other}\nX2\nM30")).is_empty(), "{mode} {other}");
    }
    check("G90 G700 G0 X0\nG93 G1 X1 F2\nM30", &["G90 G710 G0 X0", "G93 G1 X25.4 F2", "M30"]);
}

#[test]
fn the_chords_of_one_block_share_its_time() {
    // Circles become ellipses under unequal scale, so the arc comes out as chords: their times add up to that of the block.
    let (lines, codes) = written(
        "G90 G0 X0 Y0 Z0\nSCALE X2\nG93 G3 X0 Y20 I0 J10 F4\nSCALE\nG94 G1 X1 F100\nM30",
        &xyz_machine(),
        &ErrorModel::default(),
        CorrectionOptions::default(),
    );
    assert!(codes.is_empty(), "{codes:?}");
    let feeds: Vec<f64> = lines
        .iter()
        .skip_while(|line| !line.contains("G93"))
        .take_while(|line| !line.contains("SCALE"))
        .map(|line| line.split(' ').find_map(|word| word.strip_prefix('F')?.parse().ok()).unwrap_or(f64::NAN))
        .collect();
    assert!(feeds.len() > 20, "{lines:?}");
    let minutes: f64 = feeds.iter().map(|feed| 1.0 / feed).sum();
    assert!((minutes - 0.25).abs() < 1e-5, "{minutes}");
}

#[test]
fn codes_are_programmed_by_group_and_number() {
    // G54 of this machine lies at X100 Y50 Z10; group 8: 1 is G500, 2 is G54, 6 is G505.
    check(
        "G90 G0 X1\nR1=2\nG[8]=R1\nX2\nG[8]=1 G[1]=2 F100\nX3\nG[14]=2\nX1\nM30",
        &["G90 G0 X1", "G54", "G0 X2", "G500 F100", "G1 X3", "G90", "G1 X4", "M30"],
    );
    assert_eq!(codes("G90\nG[1]=77\nM30"), ["E0201"]);
    assert_eq!(codes("G90\nG[8]=101\nM30"), ["E0201"]);
    assert_eq!(codes("G90\nG[6]=2 G17\nM30"), ["E0111"]);
    assert_eq!(codes("G90\nFIELD[1]=2\nM30"), ["E0206"]);
}

#[test]
fn the_first_plane_is_that_of_the_machine() {
    let mut machine = xyz_machine();
    machine.control.initial_plane = ncfix_base::geometry::Plane::ZX;
    check_on(
        &machine,
        "G90 G0 X0 Y0 Z0\nG2 X10 Z10 I10 K0 F100\nM30",
        &["G90 G0 X0 Y0 Z0", "G2 X10 Z10 I10 K0 F100", "M30"],
    );
    assert_eq!(codes("G90 G0 X0 Y0 Z0\nG2 X10 Z10 I10 K0 F100\nM30"), ["E0203"]);
}

#[test]
fn cutting_speeds_in_feet_are_refused() {
    assert_eq!(codes("G90 G70\nG96 S300 M4\nM30"), ["E0201"]);
    assert_eq!(codes("G90 G71\nG96 S300 M4\nG97 S500\nG70 S600\nM30"), [""; 0]);
    assert_eq!(codes("G90 G70\nG97 S300 M4\nM30"), [""; 0]);
}

/// Passed on, it would turn the coordinates, and the correction would count for a table that does not swivel.
#[test]
fn no_entry_passes_on_a_swivelled_plane() {
    let demo = std::fs::read_to_string("samples/machines/demo.toml").unwrap();
    let program = "G90 G17 G71 G500 T1 D1 M6\nG0 X50 Y50 Z100\nCYCLE800(1,\"TABLE\",0,57,0,0,0,-30,0,0,0,0,0,-1)\nG1 X60 F500\nM30\n";
    for entry in ["CYCLE800", "CYCLE8*"] {
        let machine = format!("{demo}\n[[opaque]]\nname = \"{entry}\"\n");
        let shop = crate::support::Shop::new().file("m.toml", machine).file("p.mpf", program);
        let run = shop.run(["p.mpf", "--machine", "m.toml", "-o", "out.mpf"]);
        assert!(run.code == 4 && run.stderr.contains("E0235"), "{}", run.stderr);
        assert!(!shop.path("out.mpf").exists());
    }
}

#[test]
fn no_entry_passes_on_a_word_that_exchanges_axes() {
    // Passed on, the corrections of X would go to the axis that moved as X before.
    for word in ["GEOAX(1,Y,2,X)", "TRAILON(V,X)", "TRANSMIT", "EGON(X)"] {
        let name = word.split('(').next().unwrap();
        let machine = format!(
            "{}\n[[opaque]]\nname = \"{name}\"\nmoves = false\n",
            std::fs::read_to_string("samples/machines/demo.toml").unwrap()
        );
        let program = format!("G90 G17 G71 G500 T1 D1 M6\nG0 X50 Y50 Z100\n{word}\nG1 X60 F500\nM30\n");
        let shop = crate::support::Shop::new().file("m.toml", machine).file("p.mpf", program);
        let run = shop.run(["p.mpf", "--machine", "m.toml", "-o", "out.mpf"]).exits(3);
        assert!(run.stderr.contains("E0201") && run.stderr.contains(name), "{}", run.stderr);
        assert!(!shop.path("out.mpf").exists());
    }
}
