//! Drilling cycles and patterns of positions: moves worked out by hand from what each cycle is known to do.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::Machine;

use crate::exec::{check, check_codes, run, run_with};
use crate::machines::xyz_machine;

/// Moves at one place: `G0 Z2` stands for `G0 X100 Y0 Z2`.
fn at(place: &str, moves: &[&str]) -> Vec<String> {
    moves
        .iter()
        .map(|entry| {
            let (code, rest) = entry.split_once(' ').unwrap();
            format!("{code} {place} {rest}")
        })
        .collect()
}

/// Motion lines, dwells and auxiliary words, without words for the end and for modes.
fn all(text: &str) -> Vec<String> {
    let (lines, codes) = run(text);
    assert!(codes.is_empty(), "{codes:?}");
    let is_wanted =
        |line: &&String| ["G0 ", "G1 ", "G2 ", "G3 ", "G4", "S", "M"].iter().any(|start| line.starts_with(start));
    lines.iter().filter(is_wanted).filter(|line| *line != "M30").cloned().collect()
}

#[track_caller]
fn check_hole(call: &str, moves: &[&str]) {
    let text = format!("G17 G90 G0 X100 Y0 Z10\nF100\n{call}\nM30");
    let mut expected = vec!["G0 X100 Y0 Z10".to_owned()];
    expected.extend(at("X100 Y0", moves));
    let found: Vec<String> =
        all(&text).into_iter().filter(|line| line.starts_with("G0") || line.starts_with("G1")).collect();
    assert_eq!(found, expected, "{call}");
}

#[test]
fn drilling_goes_to_the_depth_and_back() {
    let down = ["G0 Z2", "G1 Z-15 F100", "G0 Z10"];
    check_hole("CYCLE81(10,0,2,-15)", &down);
    check_hole("CYCLE81(10,0,2,,15)", &down);
    // A relative depth goes first; the newer versions may say which one counts.
    check_hole("CYCLE81(10,0,2,-7,15)", &down);
    check_hole("CYCLE81(10,0,2,-15,7,0,0,1,12)", &down);
    check_hole("CYCLE81(10,0,-2,,-15,0,0,1,11)", &down);
    check_hole("CYCLE82(10,0,2,-15,0,0.5)", &down);
    // From below: retraction plane, reference plane, depth in the other order.
    check_hole("CYCLE81(-30,-20,2,-5)", &["G0 Z-22", "G1 Z-5 F100", "G0 Z-30"]);
    check_hole("CYCLE81(-30,-20,2,,15)", &["G0 Z-22", "G1 Z-5 F100", "G0 Z-30"]);
    check_hole("CYCLE89(10,0,2,-15,0,1)", &["G0 Z2", "G1 Z-15 F100", "G1 Z2 F100", "G0 Z10"]);
    check_hole("CYCLE85(10,0,2,-15,0,0,80,120)", &["G0 Z2", "G1 Z-15 F80", "G1 Z2 F120", "G0 Z10"]);
    check_hole("CYCLE87(10,0,2,-15,0,3)", &down);
    check_hole("CYCLE88(10,0,2,-15,0,1,4)", &down);
}

#[test]
fn dwells_stops_and_spindle_words_have_their_places() {
    let found = |call: &str| all(&format!("G17 G90 G0 X1 Y0 Z10\nF100\n{call}\nM30"))[1..].to_vec();
    assert_eq!(found("CYCLE82(10,0,2,-15,0,0.5)"), ["G0 X1 Y0 Z2", "G1 X1 Y0 Z-15 F100", "G4 S0.5", "G0 X1 Y0 Z10"]);
    assert_eq!(found("CYCLE82(10,0,2,-15,0,-3)")[2], "G4 R3");
    assert_eq!(found("CYCLE82(10,0,2,-15,0,3,0,1,22)")[2], "G4 R3");
    assert_eq!(
        found("CYCLE88(10,0,2,-15,0,1,4)"),
        ["G0 X1 Y0 Z2", "M4", "G1 X1 Y0 Z-15 F100", "G4 S1", "M5 M0", "G0 X1 Y0 Z10"]
    );
    assert_eq!(
        found("CYCLE86(10,0,2,-15,0,0,3,-1,0.5,0.2,45)"),
        ["G0 X1 Y0 Z2", "M3", "G1 X1 Y0 Z-15 F100", "G0 X0 Y0.5 Z-14.8", "G0 X0 Y0.5 Z2", "G0 X1 Y0 Z10", "M3"]
    );
}

/// The depths at which the strokes of a deep hole end.
fn strokes(arguments: &str) -> Vec<f64> {
    let lines = all(&format!("G17 G90 G0 X0 Y0 Z10\nF100\nCYCLE83({arguments})\nM30"));
    let ends = lines.iter().filter(|line| line.starts_with("G1"));
    ends.map(|line| line.split(" Z").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn strokes_of_a_deep_hole_grow_shorter() {
    assert_eq!(strokes("10,0,2,-50,0,-20,0,8"), [-20.0, -32.0, -40.0, -45.0, -50.0]);
    assert_eq!(strokes("10,0,2,-50,0,-20,0,0"), [-20.0, -35.0, -50.0]);
    assert_eq!(strokes("10,0,2,-50,0,,20,-0.5,0,0,1,0,3,4"), [-20.0, -30.0, -35.0, -39.0, -43.0, -46.5, -50.0]);
    assert_eq!(strokes("10,0,2,,30,,10,3"), [-10.0, -17.0, -21.0, -24.0, -27.0, -30.0]);
    assert_eq!(strokes("10,0,2,-26,0,-20,0,8"), [-20.0, -26.0]);
    // Further than the depth; percent of the newer versions; upwards.
    assert_eq!(strokes("10,0,2,-26,0,-40,0,8"), [-26.0]);
    assert_eq!(strokes("10,0,2,,20,,4,100,0,0,100,1,0,1.2,1.4,0,1.6,0,1,11211111"), [-4.0, -8.0, -12.0, -16.0, -20.0]);
    assert_eq!(strokes("-10,0,2,50,0,20,0,8"), [20.0, 32.0, 40.0, 45.0, 50.0]);
}

#[test]
fn a_deep_hole_with_withdrawal_or_chip_breaking() {
    check_hole(
        "CYCLE83(10,0,2,-50,0,-20,0,8,0,0,1,1)",
        &[
            "G0 Z2",
            "G1 Z-20 F100",
            "G0 Z2",
            "G0 Z-19.4",
            "G1 Z-32 F100",
            "G0 Z2",
            "G0 Z-31.36",
            "G1 Z-40 F100",
            "G0 Z2",
            "G0 Z-39.2",
            "G1 Z-45 F100",
            "G0 Z2",
            "G0 Z-44.1",
            "G1 Z-50 F100",
            "G0 Z10",
        ],
    );
    check_hole(
        "CYCLE83(10,0,2,-50,0,-20,0,8,0,0,1,0)",
        &[
            "G0 Z2",
            "G1 Z-20 F100",
            "G0 Z-19",
            "G1 Z-32 F100",
            "G0 Z-31",
            "G1 Z-40 F100",
            "G0 Z-39",
            "G1 Z-45 F100",
            "G0 Z-44",
            "G1 Z-50 F100",
            "G0 Z10",
        ],
    );
    // Given distances, and the feed of the first stroke.
    check_hole(
        "CYCLE83(10,0,2,-30,0,-20,0,10,0,0,0.5,1,3,0,0,0,1.5)",
        &["G0 Z2", "G1 Z-20 F50", "G0 Z2", "G0 Z-18.5", "G1 Z-30 F100", "G0 Z10"],
    );
    // Each has its dwell.
    let lines = all("G17 G90 G0 X0 Y0 Z10\nF100\nCYCLE83(10,0,2,-30,0,-20,0,10,1,2,1,1,3,0,0,3)\nM30");
    let dwells: Vec<&String> = lines.iter().filter(|line| line.starts_with("G4")).collect();
    assert_eq!(dwells, ["G4 S1", "G4 S2", "G4 S3"]);
}

/// The positions of a pattern, from a start.
fn positions(start: &str, call: &str) -> Vec<[f64; 2]> {
    let lines = all(&format!("G17 G90 G0 {start} Z0\n{call}\nM30"));
    let number = |line: &str, letter: &str| -> f64 {
        line.split(' ').find_map(|word| word.strip_prefix(letter)).unwrap().parse().unwrap()
    };
    lines[1..].iter().map(|line| [number(line, "X"), number(line, "Y")]).collect()
}

#[track_caller]
fn check_positions(start: &str, call: &str, expected: &[[f64; 2]]) {
    let found = positions(start, call);
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (one, other) in found.iter().zip(expected) {
        assert!((one[0] - other[0]).hypot(one[1] - other[1]) < 1e-6, "{found:?}");
    }
}

#[test]
fn rows_and_grids_begin_near_the_tool() {
    let row = [[20.0, 10.0], [30.0, 10.0], [40.0, 10.0]];
    let back = [[40.0, 10.0], [30.0, 10.0], [20.0, 10.0]];
    check_positions("X0 Y0", "HOLES1(10,10,0,10,10,3)", &row);
    check_positions("X100 Y0", "HOLES1(10,10,0,10,10,3)", &back);
    check_positions("X0 Y0", "HOLES1(0,0,30,10,0,1)", &[[75.0_f64.sqrt(), 5.0]]);
    let grid = [[0.0, 0.0], [10.0, 0.0], [20.0, 0.0], [20.0, 15.0], [10.0, 15.0], [0.0, 15.0]];
    check_positions("X-5 Y-5", "CYCLE801(0,0,0,10,15,3,2)", &grid);
    // The meander runs along the smaller spacing, also where that is the ordinate; it starts at the near corner.
    let turned = [[5.0, 20.0], [5.0, 10.0], [5.0, 0.0], [20.0, 0.0], [20.0, 10.0], [20.0, 20.0]];
    check_positions("X0 Y50", "CYCLE801(5,0,0,15,10,2,3)", &turned);
    let frame = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0], [0.0, 2.0], [1.0, 2.0], [2.0, 2.0]];
    check_positions("X0 Y0", "CYCLE801(0,0,0,1,1,3,3,1)", &frame);
    check_positions("X0 Y0", "CYCLE801(1,2,90,10,10,2,1)", &[[1.0, 2.0], [1.0, 12.0]]);
    check_positions(
        "X0 Y0",
        "HOLES2(1,2,10,0,120,3)",
        &[[11.0, 2.0], [-4.0, 2.0 + 75.0_f64.sqrt()], [-4.0, 2.0 - 75.0_f64.sqrt()]],
    );
    check_positions("X0 Y0", "CYCLE802(111111111,111111111,1,2,0,0,,3)", &[[1.0, 2.0], [0.0, 0.0], [0.0, 3.0]]);
}

#[test]
fn the_modal_state_is_as_before() {
    check(
        "G17 G90 G0 X0 Y0 Z10\nG91 G1 F100 X5\nCYCLE81(10,0,2,-15)\nX5\nM30",
        &[
            "G0 X0 Y0 Z10",
            "G1 X5 Y0 Z10 F100",
            "G0 X5 Y0 Z2",
            "G1 X5 Y0 Z-15 F100",
            "G0 X5 Y0 Z10",
            "G1 X10 Y0 Z10 F100",
        ],
    );
    let lines = run("G17 G90 G0 X0 Y0 Z10\nF100\nCYCLE85(10,0,2,-15,0,0,50,70)\nG1 X1\nM30").0;
    assert!(lines.iter().any(|line| line == "G1 X1 Y0 Z10 F100"), "{lines:?}");
}

#[test]
fn what_is_wrong_is_said_at_the_call() {
    let start = "G17 G90 G0 X0 Y0 Z10 F100\n";
    let wrong = |call: &str, expected: &[&str]| check_codes(&format!("{start}{call}\nG0 X1\nM30"), expected);
    wrong("CYCLE81(0,10,2,-15)", &["E0218:2"]);
    wrong("CYCLE81(10,10,2,0,15)", &["E0218:2"]);
    wrong("CYCLE86(10,0,2,-15,0,0,5)", &["E0218:2"]);
    wrong("CYCLE83(10,0,2,-50,0,20,0,8)", &["E0218:2"]);
    wrong("HOLES2(0,0,10,0,180,3)", &["E0218:2"]);
    wrong("HOLES1(0,0,0,0,0,0)", &["E0218:2"]);
    wrong("CYCLE81(10,0,2,-15,0,0,1)", &["E0201:2"]);
    wrong("CYCLE81(10,0,2,-15,0,0,0,2)", &["E0201:2"]);
    wrong("CYCLE81(1,2,3,4,5,6,7,8,9,10)", &["E0221:2"]);
    wrong("CYCLE899(1)", &["E0201:2"]);
    // With MCALL at the MCALL, once.
    wrong("MCALL CYCLE81(0,10,2,-15)\nX1\nX2\nHOLES2(0,0,9,0,0,3)\nMCALL", &["E0218:2"]);
}

#[test]
fn elements_of_a_cycle_come_from_the_line_that_calls_it() {
    let text = "G17 G90 G0 X0 Y0 Z10\nF100\nCYCLE83(10,0,2,-50,0,-20,0,8)\nMCALL CYCLE81(10,0,2,-15)\nX5\nHOLES2(0,0,9,0,0,2)\nMCALL\nM30";
    let lines = origins(text, &xyz_machine());
    let expected = [vec![1], vec![3; 11], vec![5; 4], vec![6; 8]].concat();
    assert_eq!(lines, expected);
}

/// The source lines of the motions.
fn origins(text: &str, machine: &Machine) -> Vec<u32> {
    use ncfix_base::source::{FileId, Source};
    use ncfix_machine::snc::Kind;
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, _) = ncfix_language::syntax::parse(&source, ncfix_dialect::sinumerik());
    let run = ncfix_language::exec::Execution::new(program, machine, Box::new(NoLibrary), Options::default());
    run.filter_map(Result::ok)
        .filter(|element| matches!(element.kind, Kind::Move(_)))
        .map(|element| {
            assert_eq!(element.origin.file, FileId(0));
            element.origin.line
        })
        .collect()
}

#[test]
fn a_file_of_the_user_goes_before_the_cycle() {
    let own = crate::exec::Programs(vec![("CYCLE81", "PROC CYCLE81(REAL A)\nG0 X=A\nRET")]);
    let (lines, codes) = run_with("G0 X0 Y0 Z0\nCYCLE81(7)\nM30", &xyz_machine(), Box::new(own), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    assert!(lines.iter().any(|line| line == "G0 X7 Y0 Z0"), "{lines:?}");
}

#[test]
fn a_cycle_needs_a_known_position_and_a_tool() {
    let strict = |text: &str| {
        let options = Options { strict: true, ..Options::default() };
        run_with(text, &xyz_machine(), Box::new(NoLibrary), options).1
    };
    assert_eq!(strict("G17 G90\nHOLES1(0,0,0,0,5,2)\nM30"), ["E0304:2"]);
    assert_eq!(strict("G17 G90 G0 X0 Y0\nHOLES1(0,0,0,0,5,2)\nM30"), [""; 0]);
    check_codes("G17 G0 X0 Y0 Z9 F100\nPOCKET4(9,0,2,-7,25,30,30,3,0,0,500,200,0,11)\nM30", &["E0307:2"]);
}

#[test]
fn no_argument_makes_a_cycle_endless_or_fall_over() {
    let odd = ["0", "", "-1", "1EX8", "-1EX8", "1EX-9", "1000000000", "11111"];
    let cycles = [
        ("CYCLE83", 17),
        ("CYCLE801", 8),
        ("CYCLE802", 20),
        ("HOLES1", 6),
        ("HOLES2", 6),
        ("LONGHOLE", 15),
        ("POCKET3", 23),
        ("POCKET4", 19),
        ("SLOT1", 25),
        ("SLOT2", 23),
        ("CYCLE71", 16),
        ("CYCLE61", 16),
        ("CYCLE76", 20),
        ("CYCLE77", 16),
    ];
    let mut machine = xyz_machine();
    machine.control.tool_change = ncfix_machine::machine::ToolChange::T;
    machine.tools.push(ncfix_machine::machine::Tool {
        number: 1,
        name: None,
        edge: 1,
        length_mm: [0.0; 3],
        radius_mm: 5.0,
    });
    // A fixed pseudo-random walk through the arguments: each run ends by itself or at the limit of blocks.
    let mut state = 12345_u32;
    for (name, count) in cycles {
        for _ in 0..12 {
            let arguments: Vec<&str> = (0..count)
                .map(|k| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    let sane = ["10", "0", "2", "-5", "3"];
                    if state >> 16 & 3 == 0 || k > 4 { odd[(state >> 24) as usize % odd.len()] } else { sane[k % 5] }
                })
                .collect();
            let text = format!("T1 D1\nG17 G0 X0 Y0 Z9 F100\n{name}({})\nM30", arguments.join(","));
            let options = Options { max_blocks: Some(20_000), ..Options::default() };
            run_with(&text, &machine, Box::new(NoLibrary), options);
        }
    }
}
