//! Restored state of a control: state by state, and row by row of all code tables.

use super::*;

const WAY: RestartPath = RestartPath { clearance_mm: 30.0, stands_mm: 30.0 };

fn told_in(language: &str, lines: &[&str]) -> SentState {
    let mut told = SentState::new(Grammar::new(ncfix_dialect::find(language).unwrap(), false));
    lines.iter().for_each(|line| told.note(line));
    told
}

fn told(lines: &[&str]) -> SentState {
    told_in("rs274", lines)
}

/// Returns the restart lines after some lines and a place.
fn plan(language: &str, lines: &[&str]) -> Option<Vec<String>> {
    let all = [lines, &["G0 X1. Y2. Z30."]].concat();
    told_in(language, &all).lines(false, WAY)
}

#[test]
fn the_state_is_that_of_the_last_words() {
    let lines = ["G21 G90 G17", "T3 M6", "G54 S2000 M3", "M8", "G0 X1. Y2. Z50.", "G1 Z-1. F300", "X5.", "G0 Z50."];
    let way = RestartPath { clearance_mm: 50.0, stands_mm: 50.0 };
    let found = told(&lines).lines(false, way).unwrap();
    let [codes, rest @ ..] = found.as_slice() else { panic!("{found:?}") };
    assert!(["G17", "G21", "G54", "G90"].iter().all(|code| codes.split(' ').any(|word| word == *code)), "{codes}");
    assert_eq!(rest, ["S2000 M3", "M8", "G0 Z50.", "G0 X5. Y2.", "F300"]);
}

#[test]
fn behind_a_tool_change_or_machine_coordinates_places_must_be_stated_again() {
    for lines in [
        &["G0 X1. Y2. Z3.", "T4 M6", "G0 Z5."][..],
        &["G0 X1. Y2. Z3.", "G53 G0 Z0."],
        &["G0 X1. Y2. Z3.", "G28 Z5."],
        &["G0 X1. Y2. Z3.", "G55", "G0 Z5."],
        &["G0 X1. Y2. Z3.", "G43 H1", "G0 Z5."],
        &["G0 X1. Y2. Z3.", "G20", "G0 Z5."],
        // Neither increments nor expressions state a position.
        &["G0 X1. Y2. Z3.", "G91 G0 X1.", "G90"],
        &["G0 X1. Y2. Z3. A=IC(90)"],
        &["G0 X1. Y2. Z3. A90.", "G55", "G0 X1. Y2. Z3."],
    ] {
        assert_eq!(told(lines).lines(false, WAY), None, "{lines:?}");
    }
    assert!(told(&["T4 M6", "G0 X1. Y2. Z3."]).lines(false, WAY).is_some());
    // A rotary axis keeps its position.
    let found = told(&["G0 A90.", "T4 M6", "G0 X1. Y2. Z30."]).lines(false, WAY).unwrap();
    assert_eq!(found, ["G0 Z30.", "G0 A90.", "G0 X1. Y2."]);
    for (language, lines) in
        [("sinumerik", &["G0 X1 Y2 Z3", "G75 X0", "G0 Y2 Z3"][..]), ("grundig", &["G0 X1 Y2 Z3", "G74 Z0"])]
    {
        assert_eq!(told_in(language, lines).lines(false, WAY), None, "{lines:?}");
    }
    let found = plan("sinumerik", &["G0 C=DC(90.5)"]).unwrap();
    assert_eq!(found, ["G0 Z30.", "G0 C=DC(90.5)", "G0 X1. Y2."]);
}

#[test]
fn words_of_a_dwell_are_no_places_and_no_feeds() {
    for (language, dwell) in [
        ("fanuc", "G4 X7."),
        ("fanuc", "G04 P500"),
        ("sinumerik", "G4 F7"),
        ("sinumerik", "G4 S7"),
        ("grundig", "G4 X7."),
    ] {
        let found = told_in(language, &["S100 M3", "G1 F300", "G0 X1. Y2. Z30.", dwell]).lines(false, WAY).unwrap();
        assert_eq!(found, ["S100 M3", "G0 Z30.", "G0 X1. Y2.", "F300"], "{language}: {dwell}");
    }
}

#[test]
fn what_was_told_later_must_have_been_told_before() {
    let before = told(&["G90 G54 S100 M3", "G0 X1. Y2. Z3."]);
    assert!(before.knows(&before));
    for later in ["G0 A90", "M8", "G18", "G43 H1", "T4 M6", "M64 P1", "G92 X0"] {
        assert!(!before.knows(&told(&["G90 G54 S100 M3", "G0 X1. Y2. Z3.", later])), "{later}");
    }
    // Another code of the same group is known.
    assert!(before.knows(&told(&["G90 G55 S100 M4", "G0 X1. Y2. Z3."])));
}

#[test]
fn a_clearance_comes_first_in_the_unit_that_is_in_force_and_nothing_rapid_goes_below_it() {
    let lines = ["G21 G90 G17 G54", "S2000 M3", "G0 X1. Y2. Z5.", "G1 Z-1. F300", "G0 Z5."];
    let way = |clearance_mm: f64, stands_mm: f64| RestartPath { clearance_mm, stands_mm };
    let found = told(&lines).lines(false, way(30.0, 5.0)).unwrap();
    assert_eq!(found[2..], ["G0 Z30.", "G0 X1. Y2.", "G1 Z5. F200.", "G0 X1. Y2.", "F300"]);
    // 50.8 mm are 2 inches, 200 mm/min are 7.874 inches per minute.
    let found = told(&["G20 G90", "G0 X1. Y2. Z1."]).lines(true, way(50.8, 25.4)).unwrap();
    assert_eq!(found[1..], ["N2 G0 Z2.", "N3 G0 X1. Y2.", "N4 G1 Z1. F7.874", "N5 G0 X1. Y2."]);
    // Up to the place if the program is higher there.
    let found = told(&lines).lines(false, way(3.0, 5.0)).unwrap();
    assert_eq!(found[2..], ["G0 Z3.", "G0 X1. Y2.", "G0 Z5.", "F300"]);
    // No descent if the feed has another unit, or after an arc or a straight line.
    for mode in ["G93", "G95"] {
        let lines = [mode, "G0 X1. Y2. Z5."];
        assert_eq!(told(&lines).lines(false, way(30.0, 5.0)), None, "{mode}");
        assert!(told(&lines).lines(false, way(5.0, 5.0)).is_some(), "{mode}");
    }
    for motion in ["G1 Z5. F300", "G2 X1. Y2. I5. F600", "G33 Z5. K1.", "G81 X1. Y2. Z-5. R5."] {
        assert_eq!(told(&[&lines[..], &[motion]].concat()).lines(false, way(30.0, 5.0)), None, "{motion}");
    }
    assert_eq!(told(&["G21 G90"]).beginning(false, 12.5).unwrap(), ["G90 G21", "G0 Z12.5"]);
    assert_eq!(
        told_in("fanuc", &["G21 G90", "G54.1 P2"]).beginning(false, 12.5).unwrap(),
        ["G90 G21", "G54.1 P2", "G0 Z12.5"]
    );
    // A switched output does not affect a height.
    assert!(told(&["G21 G90", "M64 P1"]).beginning(false, 12.5).is_some());
    for tool in ["T3 M6", "G43 H1", "M6", "T3", "G92 Z5", "M60", "M150"] {
        assert_eq!(told(&["G21 G90", tool]).beginning(false, 12.5), None, "{tool}");
    }
}

#[test]
fn codes_are_told_with_the_words_of_their_blocks() {
    for (language, lines, expected) in [
        ("rs274", &["G43.1 Z100."][..], &["G43.1 Z100."][..]),
        // The base and its additions, in their order.
        ("rs274", &["G43 H1", "G43.2 H9", "G43.2 Z0.5"], &["G43 H1", "G43.2 H9", "G43.2 Z0.5"]),
        ("rs274", &["G43 H1", "G43.2 H9", "G43 H2"], &["G43 H2"]),
        ("rs274", &["G43 H1", "G43.2 H9", "G49"], &["G49"]),
        ("rs274", &["G64 P0.05 Q0.01"], &["G64 P0.05 Q0.01"]),
        ("rs274", &["G64 P0.05", "G61"], &["G61"]),
        ("rs274", &["M50 P0", "M48"], &["M50 P0", "M48"]),
        ("fanuc", &["G54.1 P2"], &["G54.1 P2"]),
        ("fanuc", &["G54.1 P2", "G55"], &["G55"]),
        ("fanuc", &["G43 G0 Z50. H7"], &["G43 H7"]),
        ("fanuc", &["G05.1 Q1", "G08 P1", "G08 P0"], &["G05.1 Q1", "G08 P0"]),
        ("grundig", &["G54 I3"], &["G54 I3"]),
        ("grundig", &["G52 I2", "M41"], &["G52 I2", "M41"]),
        ("sinumerik", &["G641 ADIS=0.05"], &["G641 ADIS=0.05"]),
        ("sinumerik", &["SOFT", "G507", "FFWON"], &["G507", "SOFT", "FFWON"]),
        ("sinumerik", &["D2"], &["D2"]),
    ] {
        let found = plan(language, lines).unwrap_or_else(|| panic!("{language}: {lines:?}"));
        let found: Vec<&str> = found.iter().map(String::as_str).filter(|line| !line.starts_with("G0 ")).collect();
        assert_eq!(found, expected, "{language}: {lines:?}");
    }
}

#[test]
fn what_cannot_be_told_again_is_no_place() {
    for (language, lines) in [
        ("rs274", &["G91"][..]),
        ("rs274", &["G41 D1"]),
        // 4 inches are not 4 mm.
        ("rs274", &["G20", "G43.1 Z4", "G21"]),
        ("sinumerik", &["G70", "G641 ADIS=0.002", "G71"]),
        ("rs274", &["M19 R90"]),
        ("rs274", &["M3 $1 S500"]),
        ("rs274", &["M64 P1"]),
        ("rs274", &["M67 E0 Q50"]),
        ("rs274", &["M60"]),
        ("rs274", &["M105"]),
        ("rs274", &["G92 X0"]),
        ("rs274", &["G10 L2 P1 X5"]),
        ("fanuc", &["G51 X0 Y0 P2000"]),
        ("fanuc", &["G68 X0 Y0 R30."]),
        ("fanuc", &["G66 P9010 A1."]),
        ("fanuc", &["G43.4 H1"]),
        ("fanuc", &["G52 X5."]),
        ("fanuc", &["M88"]),
        ("fanuc", &["M29 S500"]),
        ("grundig", &["G54 I3 X5 Y6"]),
        ("grundig", &["G92 X5"]),
        ("grundig", &["M10"]),
        ("grundig", &["M53"]),
        ("sinumerik", &["TRANS X5"]),
        ("sinumerik", &["TRAORI"]),
        ("sinumerik", &["G41"]),
        ("sinumerik", &["SPOS=90"]),
        ("sinumerik", &["SETMS(2)"]),
        ("sinumerik", &["M70"]),
        ("sinumerik", &["S2=500 M2=3"]),
        ("sinumerik", &["G25 X5"]),
    ] {
        assert_eq!(plan(language, lines), None, "{language}: {lines:?}");
    }
    // Codes that end such a state.
    for (language, lines) in [
        ("rs274", &["G41 D1", "G40"][..]),
        ("rs274", &["M19 R90", "M5"]),
        ("fanuc", &["G68 X0 Y0 R30.", "G69"]),
        ("fanuc", &["M29 S500", "G84 X0 Z-5. R5. F500", "G80"]),
        ("sinumerik", &["TRAORI", "TRAFOOF"]),
    ] {
        assert!(plan(language, lines).is_some(), "{language}: {lines:?}");
    }
}

#[test]
fn every_row_with_words_and_a_group_is_told_with_them_or_not_at_all() {
    let mut count = [0, 0];
    for language in ["rs274", "fanuc", "grundig", "sinumerik"] {
        for row in ncfix_dialect::find(language).unwrap().codes().rows() {
            if row.group == 0 || row.words == "-" {
                continue;
            }
            let first = row.name.split_once("..").map_or(row.name, |(first, _)| first);
            let words = row.words.split(' ').filter(|word| !word.starts_with(',') && *word != "F");
            let words: Vec<String> = words
                .flat_map(|word| if word == "axes" { vec!["X", "Y", "Z"] } else { vec![word] })
                .enumerate()
                .map(
                    |(at, word)| {
                        if word.len() > 1 { format!("{word}={}", at + 3) } else { format!("{word}{}", at + 3) }
                    },
                )
                .collect();
            if words.is_empty() {
                // Only F, which is restored separately.
                continue;
            }
            let block = format!("{first} {}", words.join(" "));
            let found = told_in(language, &["G90", "G0 X1. Y2. Z30.", &block, "G0 X1. Y2. Z30."]).lines(false, WAY);
            count[usize::from(found.is_some())] += 1;
            let Some(found) = found else { continue };
            if row.group == 1 && !row.name.starts_with('M') {
                // The next rapid move has ended it.
                continue;
            }
            if ["G4", "G53", "G74", "G75", "G63"].contains(&first) && language == "sinumerik" {
                // Effective only in its block.
                continue;
            }
            if first == "M61" {
                // The plan names the tool; a person loads it.
                assert_eq!(told_in(language, &[&block]).tool.as_deref(), Some("T3"));
                continue;
            }
            let told = found.iter().find(|line| line.split(' ').any(|word| word == first));
            let told = told.unwrap_or_else(|| panic!("{language}: {block} is not told again: {found:?}"));
            // A spindle speed is restored with the spindle.
            let is_told = |word: &String| {
                let is_in = |line: &str| line.split(' ').any(|other| other == word);
                is_in(told) || word.starts_with('S') && found.iter().any(|line| is_in(line))
            };
            // Length compensation of a Fanuc: the axis word is the target position.
            let is_position =
                |word: &String| language == "fanuc" && ["G43", "G44"].contains(&first) && word.starts_with('Z');
            assert!(
                words.iter().all(|word| is_told(word) || is_position(word)),
                "{language}: {block} is told as {told}"
            );
        }
    }
    assert!(count[0] > 60 && count[1] > 60, "{count:?}");
}

#[test]
fn the_tool_is_the_one_that_was_changed_and_not_the_next() {
    let tool = |language: &str, changes_on_t: bool, lines: &[&str]| {
        let mut told = SentState::new(Grammar::new(ncfix_dialect::find(language).unwrap(), changes_on_t));
        lines.iter().for_each(|line| told.note(line));
        told.tool
    };
    for (language, changes_on_t, lines, expected) in [
        ("rs274", false, &["T1 M6", "G43 H1", "T2"][..], Some("T1")),
        ("rs274", false, &["M6 T1", "T2", "M6", "T3"], Some("T2")),
        ("rs274", false, &["T1"], None),
        ("rs274", false, &["T1 M6", "T2", "M61 Q5"], Some("T5")),
        ("fanuc", false, &["T01", "M06", "T02"], Some("T01")),
        ("fanuc", true, &["T01", "T02"], Some("T02")),
        ("sinumerik", false, &["T=\"MILL 10\"", "M6", "T=\"DRILL\""], Some("T=\"MILL 10\"")),
        ("sinumerik", true, &["T5 D1"], Some("T5")),
        ("grundig", false, &["T4 M66", "T5"], Some("T4")),
    ] {
        assert_eq!(tool(language, changes_on_t, lines).as_deref(), expected, "{lines:?}");
    }
    // The next tool is prepared again, as the program changes to it without naming it.
    let found = plan("rs274", &["T1 M6", "G43 H1", "T2"]).unwrap();
    assert_eq!(found[..2], ["G43 H1", "T2"]);
}

#[test]
fn switches_of_the_coolant_add_up_until_all_are_off() {
    let of = |lines: &[&str]| {
        let found = plan("rs274", lines).unwrap();
        found.into_iter().filter(|line| !line.starts_with("G0")).collect::<Vec<_>>()
    };
    assert_eq!(of(&["M7", "M8"]), ["M7", "M8"]);
    assert_eq!(of(&["M8", "M8"]), ["M8"]);
    assert_eq!(of(&["M7", "M8", "M9"]), ["M9"]);
    assert_eq!(of(&["M7", "M9", "M8"]), ["M8"]);
    let grundig = |lines: &[&str]| plan("grundig", lines).unwrap()[0].clone();
    assert_eq!(grundig(&["S500 M13"]), "S500 M13");
    assert_eq!(grundig(&["S500 M13", "M9"]), "S500 M3");
}

/// The dwell between the start of the spindle and the next motion is its run-up; any other dwell belongs to its place.
#[test]
fn the_spindle_has_time_to_run_up_again() {
    for (lines, run_up) in [
        (&["S10000 M3", "M8", "G4 P5", "G0 X1 Y2 Z30", "G4 P1"][..], Some("G4 P5")),
        (&["S10000 M3", "G0 X1 Y2 Z30", "G4 P5"], None),
        (&["S10000 M3", "G4 P5", "M5", "S500 M4", "G0 X1 Y2 Z30"], None),
        (&["G0 X1 Y2 Z30", "M3 S10000", "X3 Y3", "G4 P5"], None),
    ] {
        let found = plan("rs274", lines).unwrap();
        let dwells: Vec<&str> = found.iter().map(String::as_str).filter(|line| line.starts_with("G4")).collect();
        assert_eq!(dwells, run_up.into_iter().collect::<Vec<_>>(), "{found:?}");
        let at = |begin: &str| found.iter().position(|line| line.starts_with(begin));
        assert!(run_up.is_none() || at("S10000 M3") < at("G4") && at("G4") < at("G0 X"), "{found:?}");
    }
}
