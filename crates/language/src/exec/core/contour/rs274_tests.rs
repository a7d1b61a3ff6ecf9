//! Radius compensation of RS274/NGC at the stage: expected values from the arithmetic of the rules.

use super::ContourModal;
use super::fixture::Fixture;
use ncfix_machine::machine::Control;

fn bench() -> Fixture {
    Fixture::new(Control::default(), |_| ContourModal::rs274(), 5.0)
}

#[test]
fn the_first_motion_ends_square_to_itself() {
    // (0.6, 0.8) of 50 mm; to its left (-0.8, 0.6). The next element continues in the same direction.
    bench().check("G41 G1 X30 Y40 F100\nX60 Y80\nG40 X90 Y80", "G1 X26 Y43 F100\nG1 X56 Y83 F100\nG1 X90 Y80 F100");
    bench().check("G42 G1 X30 Y40\nG40 X90", "G1 X34 Y37\nG1 X90 Y40");
    // Not longer than the radius.
    bench().check_codes("G41 G1 X3 Y4\nX60\nG40 Y90", &["E0232:1"]);
    bench().check_codes("G41 G1 Z5\nX60\nG40 Y90", &["E0232:1"]);
}

#[test]
fn the_first_motion_along_an_arc_keeps_its_tangents() {
    // About (0, 25) counter-clockwise to (25, 25): 5 mm inside it is (20, 25). The center is equidistant from there and from the start: 20 - x = √(x²
    // + 25²) gives x = -5.625.
    bench().check("G41 G3 X25 Y25 I0 J25\nG1 Y60\nG40 X0", "G3 X20 Y25 I-5.625 J25\nG1 X20 Y60\nG1 Y60");
    bench().check_codes("G41 G3 X4 Y4 I0 J4\nG1 Y60\nG40 X0", &["E0233:1"]);
}

#[test]
fn inner_corners_cut_both_back() {
    bench().check("G41 G1 X30\nY40\nG40 X0", "G1 X25 Y5\nG1 X25 Y40\nG1 Y40");
    // Tangential lines and arcs are only offset, inside and outside.
    bench().check("G41 G1 X20\nX30\nG3 X50 Y20 I0 J20\nG40 G1 X60", "G1 X20 Y5\nG1 X30 Y5\nG3 X45 Y20 J15\nG1 X60 Y20");
    bench().check(
        "G41 G1 X20\nX30\nG2 X50 Y-20 I0 J-20\nG40 G1 X60",
        "G1 X20 Y5\nG1 X30 Y5\nG2 X55 Y-20 J-25\nG1 X60 Y-20",
    );
    // A bump of radius 15 about X45 on the line, offset to 20: the line 5 above intersects it √(20² - 5²) beside its center.
    bench().check(
        "G41 G1 X10\nX30\nG2 X45 Y15 I15 J0\nG1 X70\nG40 Y40",
        "G1 X10 Y5\nG1 X25.6351 Y5\nG2 X45 Y20 I19.3649 J-5\nG1 X70 Y20\nG1 X70 Y40",
    );
    bench().check(
        "G41 G1 Y15\nX45\nG2 X60 Y0 I0 J-15\nG1 X90\nG40 Y40",
        "G1 X-5 Y15\nG2 Y20 I5\nG1 X45 Y20\nG2 X64.3649 Y5 J-20\nG1 X90 Y5\nG1 X90 Y40",
    );
    // Two adjacent ones meet half-way between their centers, √(20² - 15²) above.
    bench().check(
        "G41 G1 Y15\nX45\nG2 X60 Y0 I0 J-15\n(here)\nG2 X75 Y15 I15 J0\nG1 X90\nG40 Y40",
        "G1 X-5 Y15
        G2 Y20 I5
        G1 X45 Y20
        G2 X60 Y13.2288 J-20
        (here)
        G2 X75 Y20 I15 J-13.2288
        G1 X90 Y20
        G1 X90 Y40",
    );
}

#[test]
fn outer_corners_get_an_arc_in_the_block_behind() {
    bench().check(
        "G41 G1 X30 F100\nX60\n(here)\nY-40 Z-2 F200\nG40 X90",
        "G1 X30 Y5 F100\nG1 X60 Y5 F100\n(here)\nG2 X65 J-5 F200\nG1 X65 Y-40 Z-2 F200\nG1 X90 Y-40 Z-2 F200",
    );
    // At rapid there are no arcs.
    bench().check("G41 G1 X60\nG0 Y-40\nG40 X90", "G1 X60 Y5\nG0 X65\nG0 X65 Y-40\nG0 X90 Y-40");
    // Bends below 0.05 count as none.
    bench().check("G41 G1 X60\nX100 Y-1\nG40 X150", "G1 X60 Y5\nG1 X100.125 Y3.9984\nG1 X150 Y-1");
}

#[test]
fn behind_g40_motions_begin_where_the_tool_is() {
    // Heights too: the tool returns to the contour.
    bench().check("G41 G1 X60\nG40 Z20\nX70", "G1 X60 Y5\nG1 X60 Z20\nG1 X70 Z20");
    bench().check_codes("G41 G1 X60\nG40 G2 X70 Y-10 I0 J-10", &["E0232:2"]);
    // Restarted without a motion between: the direction is the programmed one.
    bench().check("G41 G1 X60\nG40\nG42\nY40\nG40 X0", "G1 X60 Y5\nG1 X65 Y40\nG1 Y40");
    // It ends with the program.
    bench().check("G41 G1 X60\nX80", "G1 X60 Y5\nG1 X80 Y5");
}

#[test]
fn heights_move_at_the_corner() {
    // All motions between two elements end where the first is cut back.
    bench().check(
        "G41 G1 X10\nX30\nZ5\nZ0\nY40\nG40 X0",
        "G1 X10 Y5\nG1 X25 Y5\nG1 X25 Y5 Z5\nG1 X25 Y5\nG1 X25 Y40\nG1 Y40",
    );
}

#[test]
fn a_full_circle_stays_one() {
    bench().check("G41 G1 X30\nG3 X30 Y0 I0 J20\nG1 X40\nG40 Y20", "G1 X30 Y5\nG3 X30 Y5 J15\nG1 X40 Y5\nG1 X40 Y20");
}

#[test]
fn what_does_not_meet_is_refused() {
    // A step of 3 mm at a radius of 5.
    bench().check_codes("G41 G1 X30\nY3\nX0\nY40\nG40 X0 Y60", &["E0233:2"]);
    bench().check_codes("G41 G1 X30\nG3 X34 Y4 I0 J4\nG40 G1 Y60", &["E0233:2"]);
}
