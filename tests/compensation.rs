//! Radius compensation: the way of the tool center worked out by hand.

use ncfix_language::exec::Options;
use ncfix_machine::machine::{Machine, Tool, ToolChange};

use crate::flat::{check_from, execute};
use crate::machines::xyz_machine;

/// A machine whose tool 1 has a radius, without length; edge 2 has another.
pub(crate) fn with_radius(radius_mm: f64) -> Machine {
    let mut machine = xyz_machine();
    machine.control.tool_change = ToolChange::T;
    let tool = |edge, radius_mm| Tool { number: 1, name: None, edge, length_mm: [0.0; 3], radius_mm };
    machine.tools = vec![tool(1, radius_mm), tool(2, radius_mm - 1.0)];
    machine
}

#[track_caller]
fn check(text: &str, expected: &str) {
    check_from([0.0; 3], text, &with_radius(5.0), expected);
}

#[track_caller]
fn check_codes(text: &str, expected: &[&str]) {
    assert_eq!(execute(text, &with_radius(5.0), Options::default()).1, expected);
}

const STEP: &str = "N20 G41 G1 X20 Y20 F500
N30 Y60
N40 X60
N50 Y40
N60 X80
N70 G40 X100 Y40
N80 M30";

#[test]
fn outer_corners_by_arcs() {
    check(
        &format!("N10 G17 G90 T1 D1 G40 G450 NORM\n{STEP}"),
        "G1 X15 Y20 F500
        G1 X15 Y60 F500
        G2/17 X20 Y65 I5 F500
        G1 X60 Y65 F500
        G2/17 X65 Y60 J-5 F500
        G1 X65 Y45 F500
        G1 X80 Y45 F500
        G1 X100 Y40 F500",
    );
}

#[test]
fn the_arc_of_a_corner_belongs_to_the_block_behind_it() {
    check(
        "N10 G17 G90 T1 D1 G450 NORM
        N20 G41 G1 X20 Y20 F500
        N30 Y60 F400
        N40 X60 F100
        N50 G40 X100 Y65",
        "G1 X15 Y20 F500
        G1 X15 Y60 F400
        G2/17 X20 Y65 I5 F100
        G1 X60 Y65 F100
        G1 X100 Y65 F100",
    );
}

#[test]
fn a_corner_behind_a_rapid_is_cut_with_feed() {
    let text = "N10 G17 G90 F500 T1 D1 G450 NORM
        N20 G41 G0 X20 Y20
        N30 Y60
        N35 G1 Z-3 F100
        N40 X60 F400
        N50 G40 X100 Y65";
    check(
        text,
        "G0 X15 Y20
        G0 X15 Y60
        G1 X15 Y60 Z-3 F100
        G2/17 X20 Y65 Z-3 I5 F400
        G1 X60 Y65 Z-3 F400
        G1 X100 Y65 Z-3 F400",
    );
}

#[test]
fn outer_corners_by_intersections() {
    check(
        &format!("N10 G17 G90 T1 D1 G40 G451 NORM\n{STEP}"),
        "G1 X15 Y20 F500
        G1 X15 Y65 F500
        G1 X65 Y65 F500
        G1 X65 Y45 F500
        G1 X80 Y45 F500
        G1 X100 Y40 F500",
    );
}

const CIRCLE: &str = "N10 G17 G90 T1 D1
N20 G41 G1 X70 Y50 F200
N30 G3 I-20 J0
N40 G40 G1 X50 Y50
N50 M30";

#[test]
fn a_full_circle_inside() {
    // On the arc F holds at the contour: 200 · 15/20.
    let expected = "G1 X65 Y50 F200\nG3/17 X65 Y50 I-15 F150\nG1 X50 Y50 F200";
    check_from([50.0, 50.0, 0.0], CIRCLE, &with_radius(5.0), expected);
    let mirrored = format!("N5 TRANS X100\nN6 AMIRROR X0\n{CIRCLE}");
    let expected = "G1 X35 Y50 F200\nG2/17 X35 Y50 I15 F150\nG1 X50 Y50 F200";
    check_from([50.0, 50.0, 0.0], &mirrored, &with_radius(5.0), expected);
}

#[test]
fn soft_approach_and_retraction() {
    // Quadrant of radius 10 onto (40, -10) beside X: the tool center arrives at (40, -5) from (30, 5). In space: from 3 mm above.
    let program = |approach: &str, retract: &str| {
        format!(
            "N10 G17 G90 G0 T1 D1 X0 Y0 Z20
N20 G41 {approach} F500
N30 G1 X60
N40 G40 {retract} F900
N50 M30"
        )
    };
    check(
        &program("G247 DISR=10 DISCL=3 X40 Y-10 Z0", "G348 DISR=10 DISCL=3 X100 Y50 Z20"),
        "G0 Z20
        G0 X30 Y5 Z20
        G0 X30 Y5 Z3
        G3/17 X40 Y-5 I10 F500
        G1 X60 Y-5 F500
        G3/17 X60 Y15 Z3 J10 F500
        G1 X60 Y15 Z20 F900
        G1 X100 Y50 Z20 F900",
    );
    // In the plane: down first, with the infeed; the end of the approach by the next block; a line of 7 mm and the radius.
    check(
        &program("G341 G147 DISR=7 DISCL=AC(4) FAD=100 Z0\nN25 X40 Y-10", "G148 DISR=1 DISCL=2 X100 Y50 Z20"),
        "G0 Z20
        G0 X28 Y-5 Z20
        G0 X28 Y-5 Z4
        G1 X28 Y-5 F100
        G1 X40 Y-5 F500
        G1 X60 Y-5 F500
        G1 X66 Y-5 F500
        G1 X66 Y-5 Z2 F500
        G1 X66 Y-5 Z20 F900
        G1 X100 Y50 Z20 F900",
    );
    check_codes("G17 G90 G0 X0 Y0 Z0\nG247 DISR=10 X40 Y-10 F500\nG1 X60", &["E0201:2"]);
}

#[test]
fn elements_by_their_angle() {
    // tan 30 degrees · 30; then the intersection of a line under 45 degrees from there with one under 90 degrees through (60, 80).
    check(
        "N10 G17 G90 G1 X10 Y0 F500
N20 X40 ANG=30
N30 ANG=45 RND=0
N40 X60 Y80 ANG=90
N50 G91 ANG=180 X-20
N60 M30",
        "G1 X10 F500
        G1 X40 Y17.3205 F500
        G1 X60 Y37.3205 F500
        G1 X60 Y80 F500
        G1 X40 Y80 F500",
    );
    check(
        "N10 G18 G90 G1 X0 Z0 F500
N20 ANG=90 CHR=2
N30 M8
N40 X10 Z30 ANG=0 RND=5
N50 X40 Z30",
        "G1 X8 F500
        G1 X10 Z2 F500
        G1 X10 Z25 F500
        G3/18 X15 Z30 I5 F500
        G1 X40 Z30 F500",
    );
    check_codes("G17 G90 G1 X0 Y0 F500\nANG=45\nZ5\nX5 Y5", &["E0210:2"]);
    check_codes("G17 G90 G1 X0 Y0 F500\nANG=45\nM30", &["E0210:2"]);
    check_codes("G17 G90 G1 X0 Y0 F500\nX10 ANG=90", &["E0210:2"]);
    check_codes("G17 G90 G1 X0 Y0 F500\nANG=30\nX10 Y5 ANG=30", &["E0210:3"]);
}

#[test]
fn roundings_and_chamfers() {
    check(
        "N10 G17 G90 G1 X0 Y0 F500
N20 X50 RND=10
N30 Y40 CHR=5
N40 X0 CHF=10
N50 Y0
N60 M30",
        "G1 X40 Y0 F500
        G3/17 X50 Y10 J10 F500
        G1 X50 Y35 F500
        G1 X45 Y40 F500
        G1 X7.0711 Y40 F500
        G1 X0 Y32.9289 F500
        G1 X0 Y0 F500",
    );
}

#[test]
fn around_the_corner_where_the_tool_stands_behind_the_contour() {
    // 13 mm from the corner and a radius of 5: the tangent has 12 mm.
    let program = "N10 G17 G90 T1 D1 KONT
N20 G41 G1 X20 Y20 F500
N30 Y60
N40 G40 X33
N50 M30";
    check_from(
        [33.0, 20.0, 0.0],
        program,
        &with_radius(5.0),
        "G1 X21.9231 Y15.3846 F500
        G2/17 X15 Y20 I-1.9231 J4.6154 F500
        G1 X15 Y60 F500
        G2/17 X21.9231 Y64.6154 I5 F500
        G1 X33 Y60 F500",
    );
    // In front of the contour as with NORM.
    check_from(
        [0.0; 3],
        &program.replace("X33", "X0"),
        &with_radius(5.0),
        "G1 X15 Y20 F500\nG1 X15 Y60 F500\nG1 X0 Y60 F500",
    );
}

#[test]
fn motions_across_the_plane_take_place_before_the_corner() {
    let expected = "G1 X15 Y20 F500
        G1 X15 Y20 Z-2 F500
        G1 X15 Y60 Z-2 F500
        G2/17 X20 Y65 Z-2 I5 F500
        G1 X60 Y65 Z-2 F500
        G1 X60 Y65 Z-3 F500
        G2/17 X65 Y60 Z-3 J-5 F500
        G1 X65 Y45 Z-3 F500
        G1 X65 Y45 Z-4 F500
        G1 X80 Y45 Z-4 F500
        G1 X100 Y40 Z-4 F500";
    let text = STEP.replace("N30", "N25 Z-2\nN30").replace("N50", "N45 Z-3\nN50").replace("N60", "N55 Z-4\nN60");
    check(&format!("N10 G17 G90 T1 D1\n{text}"), expected);
    let many = STEP.replace("N50", "M8\nM9\nM8\nM9\nN50");
    check_codes(&format!("N10 G17 G90 T1 D1\n{many}"), &["E0232:4"]);
}

#[test]
fn side_and_radius_change_on_the_way() {
    check(
        "N10 G17 G90 T1 D1
N20 G41 G1 X20 Y20 F500
N30 Y60
N40 G42 X60
N50 G40 X80
N60 M30",
        "G1 X15 Y20 F500\nG1 X15 Y60 F500\nG1 X20 Y55 F500\nG1 X60 Y55 F500\nG1 X80 Y60 F500",
    );
    check(
        "N10 G17 G90 T1 D1
N20 G41 G1 X20 Y20 F500
N30 Y40
N40 D2 Y60
N50 Y80
N60 OFFN=2 Y90
N70 G40 X0
N80 M30",
        "G1 X15 Y20 F500\nG1 X15 Y40 F500\nG1 X16 Y60 F500\nG1 X16 Y80 F500\nG1 X14 Y90 F500\nG1 X0 Y90 F500",
    );
    check_codes("G17 G90 T1 D1\nG41 G1 X20 Y20 F500\nY40\nD2 X40\nG40 X50", &["E0232:4"]);
}

#[test]
fn what_the_tool_cannot_reach_is_left_out_or_refused() {
    // A step of 1 mm, and a line under 45 degrees behind it: offsets y = 25 and x − y = 39 − 5 √2 meet at x = 56.9289.
    let program = "N10 G17 G90 T1 D1
N20 G41 G1 X20 Y20 F500
N30 X60
N40 Y21
N50 X80 Y41
N60 G40 Y80
N70 M30";
    let (elements, codes) = execute(program, &with_radius(5.0), Options::default());
    assert_eq!(codes, ["W0233:4"]);
    let ends: Vec<_> = crate::flat::moves(&elements, ncfix_base::geometry::AxisVector::ZERO)
        .iter()
        .map(|(_, motion)| format!("{:.4} {:.4}", motion.target.0[0], motion.target.0[1]))
        .collect();
    assert_eq!(ends, ["20.0000 25.0000", "56.9289 25.0000", "76.4645 44.5355", "80.0000 80.0000"]);
    // A slot of 8 mm and a tool of 10 mm; an inner arc that is too narrow.
    check_codes(
        "G17 G90 T1 D1\nG41 G1 X20 Y20 F500\nX60\nY10\nX68\nY20\nX90\nG40 Y50",
        &["W0233:4", "W0233:5", "W0233:6"],
    );
    check_codes("G17 G90 T1 D1\nG41 G1 X20 Y20 F500\nX60\nG3 X64 Y24 CR=4\nG1 Y60\nG40 X0", &["E0233:4"]);
}

#[test]
fn the_feed_of_one_corner_goes_before_the_modal_one() {
    check(
        "N10 G17 G90 F300 G0 X0 Y0
        N20 RNDM=2 FRCM=77
        N30 G1 X20
        N40 Y20 FRC=99
        N50 X0
        N60 Y0",
        "G1 X18 F300
        G3/17 X20 Y2 J2 F77
        G1 X20 Y18 F300
        G3/17 X18 Y20 I-2 F99
        G1 X2 Y20 F300
        G3/17 X0 Y18 J-2 F77
        G1 X0 Y0 F300",
    );
}
