//! Grundig: what the control must be told, because the output leaves it to the control, and feeds where they are used.
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::Kind;
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions as PathOptions, Corrector, Increments, OutputFrame};

use crate::grundig::{check, check_codes, mill, run, run_on, tool};
use crate::machines::xyz_machine;
use crate::support::{Shop, machine};

const HEAD: &str = "%PM9001\nN9001\nN1 G17 G90 G54 T5 M6\nN2 G0 X0 Y0 Z50 S500 M3\n";

fn execution<'a>(text: &str, machine: &'a Machine, options: Options) -> Execution<'a> {
    let source = Source::new(FileId(0), "9001.pm", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::find("grundig").unwrap());
    assert!(findings.is_empty(), "{findings:?}");
    Execution::new(program, machine, Box::new(NoLibrary), options)
}

/// A tool of 100 mm.
fn shop() -> Machine {
    let mut machine = mill();
    machine.tools.push(tool(5, 100.0, 6.0));
    machine
}

/// The program without errors of the machine, written back.
fn written(text: &str, start: Option<AxisVector>) -> String {
    let machine = shop();
    let errors = ErrorModel::default();
    let model = Model::new(&machine, &errors);
    let execution = execution(text, &machine, Options { strict: true, start, ..Options::default() });
    let options = PathOptions::default();
    let writer_options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        frame: OutputFrame::Work,
        crlf: false,
        stamp: Stamp { machine: "shop".into(), model: "0a".into(), source: "0b".into(), ..Stamp::default() },
        last_block_number: None,
        has_centers_reversed: false,
    };
    let mut corrector = Corrector::new(execution, &machine, &model, options);
    let mut writer = emit::writer("grundig", &writer_options).unwrap();
    let mut out = Vec::new();
    let allowed = |code: &str| code.starts_with('W');
    emit::emit(&mut corrector, writer.as_mut(), &mut out, |finding| {
        assert!(allowed(&finding.code.to_string()), "{finding:?}");
    })
    .unwrap();
    String::from_utf8(out).unwrap()
}

/// Places of the Z axis itself, move by move, where they change.
fn heights(text: &str) -> Vec<f64> {
    let machine = shop();
    let mut out: Vec<f64> = Vec::new();
    for element in execution(text, &machine, Options::default()).flatten() {
        if let Kind::Move(motion) = &element.kind {
            let z = (motion.target[Axis::Z] * 1e6).round() / 1e6;
            if out.last() != Some(&z) {
                out.push(z);
            }
        }
    }
    out
}

/// The axis goes to these heights, by the program and by what is written.
#[track_caller]
fn same_heights(body: &str, expected: &[f64], kept: &[&str]) {
    let text = format!("{HEAD}{body}\n");
    assert_eq!(heights(&text), expected);
    let out = written(&text, None);
    assert_eq!(heights(&out), expected, "{out}");
    let mut at = 0;
    for word in kept {
        let found = out[at..].find(word).unwrap_or_else(|| panic!("{word} is not in its place in\n{out}"));
        at += found + word.len();
    }
}

#[test]
fn the_direction_of_the_tool_is_written() {
    // Tip and axis are 100 mm from one another, in G66 the other way round.
    same_heights(
        "N3 G66\nN4 G0 X0 Y0 Z50\nN5 G1 Z10 F100\nN6 G67\nN7 G1 Z20",
        &[150.0, -50.0, -90.0, 120.0],
        &["G66", "Z50", "Z10", "G67", "Z20"],
    );
}

#[test]
fn behind_a_change_of_direction_the_tool_axis_is_not_known() {
    for code in ["G66", "G39 L1"] {
        let text = format!("{HEAD}N3 {code}\nN4 G91 G1 Z-1 F100\n");
        let machine = shop();
        let options = Options { strict: true, ..Options::default() };
        let (_, codes) = run_on(&text, &machine, Box::new(NoLibrary), options);
        assert!(codes.iter().any(|code| code.starts_with('E') && code.ends_with(":6")), "{code}: {codes:?}");
    }
}

#[test]
fn the_allowance_of_length_is_written_and_that_of_the_radius_is_not() {
    same_heights("N3 G39 L1\nN4 G0 X0 Y0 Z50\nN5 G1 Z10 F100", &[150.0, 151.0, 111.0], &["G39 L1", "Z10"]);
    same_heights(
        "N3 G39 L-0.25 R0.5\nN4 G1 Z10 F100\nN5 G39 R0 L0\nN6 Z20",
        &[150.0, 109.75, 120.0],
        &["G39 L-0.25", "Z10", "G39 L0", "Z20"],
    );
    // Inches become millimeters.
    same_heights("N3 G70 G39 L0.1\nN4 G71\nN5 G1 Z10 F100", &[150.0, 112.54], &["G39 L2.54", "Z10"]);
    let text = format!("{HEAD}N3 G39 L1 R0.5\nN4 G39 R0\nN5 G1 X10 Z5 F100\n");
    let out = written(&text, None);
    assert_eq!(out.matches("G39").count(), 1, "{out}");
    assert!(!out.contains("R0"), "{out}");
}

#[test]
fn a_start_is_known_for_the_axes_of_the_machine_only() {
    let mut at = AxisVector::ZERO;
    at.set_xyz(Vector::new(-50.0, -40.0, 80.0));
    let out = written("N1 G17 G90 G53\nN2 G1 X1 F100\nN3 G93 B4=30\nN4 G1 X0 Y5\nN5 G1 Z5", Some(at));
    // Comments are no words.
    let blocks = out.lines().filter(|line| line.starts_with('N') && !line.contains('('));
    let mut letters = blocks.flat_map(|line| line.split(' ').skip(1));
    assert!(letters.all(|word| !word.starts_with(['U', 'V', 'W', 'A', 'B', 'C'])), "{out}");
    let machine = xyz_machine();
    let options = Options { start: Some(at), ..Options::default() };
    for element in execution("N1 G17 G90 G1 X1 F100\n", &machine, options).flatten() {
        if let Kind::Move(motion) = &element.kind {
            assert_eq!(motion.known, machine.axis_set());
        }
    }
}

/// Feeds of the feed moves.
fn feeds(body: &str) -> Vec<f64> {
    let machine = shop();
    let text = format!("{HEAD}{body}\n");
    let moves = execution(&text, &machine, Options::default()).flatten().filter_map(|element| match element.kind {
        Kind::Move(motion) if !motion.rapid => Some(motion.feed),
        _ => None,
    });
    moves.collect()
}

#[test]
fn the_feed_of_tapping_follows_speed_and_feed_mode() {
    // Pitch 1.25: in and out with 1.25 S per minute, or 1.25 per turn.
    assert_eq!(feeds("N3 G84 Y5 Z-10 J1.25\nN4 G79 X0 Y0 Z0"), [625.0; 2]);
    assert_eq!(feeds("N3 G84 Y5 Z-10 J1.25\nN4 G79 X10 Y0 Z0 S800"), [1000.0; 2]);
    assert_eq!(feeds("N3 G84 Y5 Z-10 J1.25\nN4 S200\nN5 G77 X0 Y0 Z0 R5 J2"), [250.0; 4]);
    assert_eq!(feeds("N3 G95 F0.2\nN4 G84 Y5 Z-10 J1.25\nN5 G79 X0 Y0 Z0"), [1.25; 2]);
    assert_eq!(feeds("N3 G84 Y5 Z-10 J1.25\nN4 G95\nN5 G79 X0 Y0 Z0"), [1.25; 2]);
    // S of G96 is no speed in turns.
    check_codes(
        "N1 G17 G90 G53\nN2 G0 X0 Y0 Z5 M3\nN3 G96 S200\nN4 G84 Y5 Z-9 J1\nN5 G79 X0 Y0 Z0\nN6 G97 S100\nN7 G79 X1 Y0 Z0",
        &["W0207:4", "E0218:5"],
    );
}

#[test]
fn the_feed_of_a_cycle_belongs_to_its_feed_mode() {
    let cycle = |first: &str, words: &str, then: &str| {
        run(&format!(
            "N1 G17 G90 {first}\nN2 G0 X0 Y0 Z5\nN3 {words}\nN4 {then}\nN5 G79 X0 Y0 Z0\nN6 G77 X0 Y0 Z0 R5 J2"
        ))
        .1
    };
    let own = "G83 Y2 Z-10 K5 F50";
    assert_eq!(cycle("G94", own, "G95"), ["E0218:5", "E0218:6"]);
    assert_eq!(cycle("G95", own, "G94"), ["E0218:5", "E0218:6"]);
    assert_eq!(cycle("G94 F10", "G85 Y2 Z-10 F2=30", "G95 F0.1"), ["E0218:5", "E0218:6"]);
    assert!(cycle("G95", own, "G95").is_empty());
    // The feed in force is that of the mode in force.
    assert!(cycle("G94", "G83 Y2 Z-10 K5", "G95 F0.1").is_empty());
}

#[test]
fn tapping_dwells_before_the_spindle_turns_back() {
    let out = written(&format!("{HEAD}N3 G84 X0.5 Y5 Z-10 J1\nN4 G79 X0 Y0 Z0\n"), None);
    let (dwell, back) = (out.find("G4 X0.5").unwrap(), out.find("M4").unwrap());
    assert!(dwell < back, "{out}");
    assert!(out.find("Z-10").unwrap() < dwell, "{out}");
}

#[test]
fn tables_that_are_not_written_are_warned_of() {
    let program = "%PM9001\nN9001\nN1 G17 G90 T4 M67\nN2 G0 X0 Y0 Z0\n";
    check_codes(&format!("%TM\nN1 T4 L80 R5.5\n{program}"), &["W0204:1"]);
    check_codes(&format!("%PA\nE1=2\n%ZO\nG55 X10 Y20\n%TM\nN1 T4 L80\n{program}"), &["W0204:3"]);
    check_codes(&format!("%PA\nE1=2\n%TM\n{}", program.replace("T4 M67", "T0 M67")), &[]);
}

#[test]
fn what_is_not_supported_is_said_before_what_its_words_would_mean() {
    let shop = Shop::new()
        .file("a.pm", format!("{HEAD}N3 G2 X10 I5 Y0 J0 F100\nN4 G33 Z-10 J1.5\n"))
        .file("b.pm", format!("{HEAD}N3 G182 Y1 B1\n"))
        .file("c.pm", format!("{HEAD}N3 G1 F100\nN4 G41 X10 Y10\nN5 X20\nN6 G40\nN7 G62 I2=1 R10\nN8 Z40\n"));
    let on = machine("universal_mill");
    for (file, said) in [("a.pm", "G33 (thread) is not supported"), ("b.pm", "G182 (")] {
        let run = shop.run(["check", file, "--machine", &on]).exits(3);
        let first = run.stderr.lines().chain(run.stdout.lines()).find(|line| line.starts_with("error")).unwrap();
        assert!(first.contains(said), "{first}");
    }
    let run = shop.run(["check", "c.pm", "--machine", &on]).exits(3);
    let all = run.stderr + &run.stdout;
    assert!(all.contains("G62)"), "{all}");
}

#[test]
fn a_limit_of_the_spindle_stands_beside_g96() {
    let out = written(&format!("{HEAD}N3 G96 S120 D3000\nN4 G1 X10 F100\nN5 G97 S500\n"), None);
    assert!(out.contains("G96 D3000"), "{out}");
    assert!(out.contains("G97"), "{out}");
    check("N1 G17 G90 F100\nN2 G96 D3000 S120\nN3 G1 X5", "G1 X5 Y0 Z0");
}

#[test]
fn no_move_is_added_where_the_length_has_changed() {
    let on = machine("universal_mill");
    for change in ["G66", "G39 L1", "T9 M67", "T9 M66"] {
        let shop = Shop::new().file("a.pm", format!("{HEAD}N3 G0 X0 Y0 Z150\nN4 {change}\nN5 G1 Z20 F100\n"));
        shop.run(["fix", "a.pm", "--machine", &on, "-o", "o.pm"]).exits(0);
        let out = shop.text("o.pm");
        // One move behind it, from wherever the axis is.
        let behind = out.lines().skip_while(|line| !line.contains(change)).skip(1);
        assert_eq!(behind.filter(|line| line.contains('Z')).count(), 1, "{out}");
    }
}

#[test]
fn a_feed_of_one_mode_is_none_of_the_other() {
    // Equal numbers of different units.
    let out = written(&format!("{HEAD}N3 G94 G1 X10 F1\nN4 G95 X20 F1\nN5 X30\nN6 G94 X40 F1\n"), None);
    let feeds = |line: &&str| line.contains("G1 X") && line.contains(" F1");
    assert_eq!(out.lines().filter(feeds).count(), 3, "{out}");
    check_codes("N1 G17 G90 G94 F100\nN2 G1 X10 Y0 Z0\nN3 G95 X20\nN4 M30", &["W0202:3"]);
    check_codes("N1 G17 G90 G94 F100\nN2 G1 X10 Y0 Z0\nN3 G94 X20\nN4 M30", &[]);
}
