//! Radius compensation of Fanuc and RS274/NGC programs.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{CompensationCorner, CompensationStart, Machine, Tool};

use crate::iso::{check_on, iso_machine, run_with};

/// A machine whose offset 1 has a radius of 5 mm and offset 2 one of 3 mm.
fn machine() -> Machine {
    let mut machine = iso_machine();
    let tool = |number, radius_mm| Tool { number, name: None, edge: 1, length_mm: [0.0; 3], radius_mm };
    machine.tools = vec![tool(1, 5.0), tool(2, 3.0)];
    machine
}

#[track_caller]
fn check_codes(name: &str, text: &str, expected: &[&str]) {
    let (_, codes) = run_with(name, text, &machine(), Box::new(NoLibrary), Options::default());
    assert_eq!(codes, expected, "{text}");
}

#[test]
fn i4_right_angles_of_a_fanuc() {
    let text = "N5 G90 G0 X0 Y0 Z0
N10 G17 G90 G40
N20 G41 D1 G1 X20. Y20. F500.
N30 Y60.
N40 X60.
N50 Y40.
N60 X80.
N70 G40 X100. Y40.
N80 M30";
    check_on(
        "fanuc",
        text,
        &machine(),
        &[
            "G0 X0 Y0 Z0",
            "G1 X15 Y20 Z0 F500",
            "G1 X15 Y65 Z0 F500",
            "G1 X65 Y65 Z0 F500",
            "G1 X65 Y45 Z0 F500",
            "G1 X80 Y45 Z0 F500",
            "G1 X100 Y40 Z0 F500",
        ],
    );
}

/// Compensation begins at X0 Y0 and ends straight on.
const I5: &str = "N10 G17 G90 G0 X-20. Y0 Z0
N20 G41 D1 G1 X0 Y0 F500.
N50 G1 Y50.
N60 X30. Y0
N70 G40 X50.
N80 M30";

#[test]
fn i5_an_acute_corner_by_lines_and_by_an_arc() {
    check_on(
        "fanuc",
        I5,
        &machine(),
        &[
            "G0 X-20 Y0 Z0",
            "G1 X-5 Y0 Z0 F500",
            "G1 X-5 Y55 Z0 F500",
            "G1 X1.714986 Y56.859943 Z0 F500",
            "G1 X34.287465 Y2.572479 Z0 F500",
            "G1 X50 Y0 Z0 F500",
        ],
    );
    let mut circular = machine();
    circular.control.compensation_corner = Some(CompensationCorner::Circular);
    check_on(
        "fanuc",
        I5,
        &circular,
        &[
            "G0 X-20 Y0 Z0",
            "G1 X-5 Y0 Z0 F500",
            "G1 X-5 Y50 Z0 F500",
            "G2 X4.287465 Y52.572479 Z0 I5 J0 K0 P17 F500",
            "G1 X34.287465 Y2.572479 Z0 F500",
            "G1 X50 Y0 Z0 F500",
        ],
    );
}

#[test]
fn the_end_of_a_fanuc_along_i_and_j() {
    // As if the contour went down behind X80: the intersection lies 5 mm beside both.
    let end =
        |words: &str| format!("G17 G90 G0 X0 Y40. Z0\nG41 D1 G1 X20. F500.\nX80.\nG40 X100. Y20. {words}\nX120. M30");
    let expected = |x: &str| {
        ["G0 X0 Y40 Z0".to_owned(), "G1 X20 Y45 Z0 F500".to_owned()]
            .into_iter()
            .chain([format!("G1 X{x} Y45 Z0 F500"), "G1 X100 Y20 Z0 F500".into(), "G1 X120 Y20 Z0 F500".into()])
            .collect::<Vec<_>>()
    };
    for (words, x) in [("", "80"), ("I0 J-1.", "85"), ("J1.", "75"), ("I7.", "80")] {
        let expected = expected(x);
        let lines: Vec<&str> = expected.iter().map(String::as_str).collect();
        check_on("fanuc", &end(words), &machine(), &lines);
    }
}

#[test]
fn starts_of_type_b_go_around_the_corner() {
    let mut machine = machine();
    machine.control.compensation_start = CompensationStart::B;
    check_on(
        "fanuc",
        "G17 G90 G0 X40. Y0 Z0\nG41 D1 G1 X20. Y20. F500.\nY60.\nG40 X0\nM30",
        &machine,
        &[
            "G0 X40 Y0 Z0",
            "G1 X16.464466 Y16.464466 Z0 F500",
            "G1 X15 Y17.928932 Z0 F500",
            "G1 X15 Y60 Z0 F500",
            "G1 X0 Y60 Z0 F500",
        ],
    );
}

#[test]
fn compensation_of_rs274_begins_square_to_the_first_motion() {
    // (0.6, 0.8) of 50 mm: to its left lies (-4, 3) at a radius of 5, and (-2.4, 1.8) at 3.
    for (word, x, y) in
        [("G41 D1", 26.0, 43.0), ("G41 D2", 27.6, 41.8), ("G41.1 D10", 26.0, 43.0), ("G42.1 D-10", 26.0, 43.0)]
    {
        check_on(
            "rs274",
            &format!("G21 G17 G90 G0 X0 Y0 Z0\n{word}\nF500 G1 X30 Y40\nX60 Y80\nG40\nZ5\nX100\nM2"),
            &machine(),
            &[
                "G0 X0 Y0 Z0",
                &format!("G1 X{x} Y{y} Z0 F500"),
                &format!("G1 X{} Y{} Z0 F500", x + 30.0, y + 40.0),
                // Behind G40 every motion leads to where the program is.
                "G1 X60 Y80 Z5 F500",
                "G1 X100 Y80 Z5 F500",
            ],
        );
    }
}

#[test]
fn a_tool_change_behind_g40_leaves_the_program_beside_the_contour() {
    for change in ["T1 M6", "M61 Q1"] {
        check_on(
            "rs274",
            &format!("G21 G17 G90 G0 X0 Y0 Z0\nG41.1 D10\nF500 G1 X30 Y40\nX60 Y80\nG40\n{change}\nZ5\nX100\nM2"),
            &machine(),
            &[
                "G0 X0 Y0 Z0",
                "G1 X26 Y43 Z0 F500",
                "G1 X56 Y83 Z0 F500",
                // Y is not named: it stays 5 mm beside the contour.
                "G1 X56 Y83 Z5 F500",
                "G1 X100 Y83 Z5 F500",
            ],
        );
    }
}

#[test]
fn what_compensation_refuses() {
    let rs274 = |text: &str| format!("G21 G17 G90 G0 X0 Y0 Z0\nF500\n{text}\nM2");
    check_codes("rs274", &rs274("G41.1 D10 G1 X3\nX40\nG40 Y40"), &["E0232:3"]);
    check_codes("rs274", &rs274("G41.1 D10 G1 X40\nG40 G2 X50 Y10 J10"), &["E0232:4"]);
    check_codes("rs274", &rs274("G41.1 D10 G1 X30\nY3\nX0\nY40\nG40 X0 Y60"), &["E0233:4"]);
    let fanuc = |text: &str| format!("G21 G17 G90 G0 X0 Y0 Z0 F500.\n{text}\nM30");
    check_codes("fanuc", &fanuc("G41 D1 G1 X20. Y0\nX40.\nG42 Y40.\nG40 Y60."), &["E0232:4"]);
    check_codes("fanuc", &fanuc("G41 D1 G1 X20. Y0\nX40.\nY3.\nX0\nG40 Y60."), &["E0233:4", "E0233:5"]);
    check_codes("fanuc", &fanuc("G41 D1 G2 X20. Y20. J20.\nG1 X40.\nG40 Y60."), &["E0232:2", "E0232:3"]);
    // Still on at the end: said once.
    check_codes("fanuc", &fanuc("G41 D1 G1 X20. Y0\nX40."), &["W0232:3"]);
    check_codes("rs274", &rs274("G41.1 D10 G1 X20\nX40"), &["W0232:5"]);
}
