//! Grundig: contour calculation (G64, G11), approach and retraction, compensation beside G73.

use crate::grundig::{check, check_codes, check_from, mill, tool};

#[test]
fn lines_by_their_angles_meet() {
    // From the origin at 45° to the horizontal through Y10.
    check("N1 G17 G90 G64 F100\nN2 G1 B1=45\nN3 X30 Y10 B1=0", "G1 X10 Y10 Z0\nG1 X30 Y10 Z0");
    // The same in G18: angles lead from X towards -Z.
    check("N1 G18 G90 G64 F100\nN2 G1 B1=45\nN3 X30 Z-10 B1=0", "G1 X10 Y0 Z-10\nG1 X30 Y0 Z-10");
}

#[test]
fn a_line_meets_a_circle_first_or_second() {
    // Circle of radius 5 about (10, 3): the abscissa cuts it at 6 and 14.
    let text = |choice: &str| format!("N1 G17 G90 G64 F100\nN2 G1 B1=0{choice}\nN3 G2 X10 Y8 I10 J3");
    check(&text(""), "G1 X6 Y0 Z0\nG2/17 X10 Y8 Z0 I4 J3");
    check(&text(" J1=2"), "G1 X14 Y0 Z0\nG2/17 X10 Y8 Z0 I-4 J3");
}

#[test]
fn a_tangent_touches_the_circle() {
    // From (-13, 0) to the circle of radius 5 about the origin: touching at (-25/13, 60/13).
    check_from(
        "N1 G17 G90 G64 F100\nN2 G1 K1=1\nN3 G2 X5 Y0 I0 J0",
        [-13.0, 0.0, 0.0],
        &mill(),
        "G1 X-1.923077 Y4.615385 Z0\nG2/17 X5 Y0 Z0 I1.923077 J-4.615385",
    );
}

#[test]
fn an_arc_without_end_is_a_full_circle_outside_of_g64_only() {
    check("N1 G17 G90 F100\nN2 G3 I5 J0", "G3/17 X0 Y0 Z0 I5 J0");
    // Circle of radius 5 about (5, 0), met from the far end of a line at 90°: x = 9, y = -3 or 3; counter-clockwise from the
    // origin (9, -3) comes first.
    check("N1 G17 G90 G64 F100\nN2 G3 I5 J0\nN3 G1 B1=90 X9 Y20", "G3/17 X9 Y-3 Z0 I5 J0\nG1 X9 Y20 Z0");
}

#[test]
fn roundings_and_chamfers_between_elements() {
    check(
        "N1 G17 G90 G64 F100\nN2 G1 X20 R1=4\nN3 Y20 I1=3\nN4 X0",
        "G1 X16 Y0 Z0
G3/17 X20 Y4 Z0 I0 J4
G1 X20 Y17 Z0
G1 X17 Y20 Z0
G1 X0 Y20 Z0",
    );
    // A factor of G73 scales what is between them too.
    check("N1 G17 G90 G64 F100 G73 A4=2\nN2 G1 X20 R1=4\nN3 Y20", "G1 X32 Y0 Z0\nG3/17 X40 Y8 Z0 I0 J8\nG1 X40 Y40 Z0");
}

#[test]
fn an_element_without_end_needs_one_that_meets_it() {
    check_codes("N1 G17 G90 G64 F100 G0 X0 Y0\nN2 G1 B1=45\nN3 G1 X5 Y9", &["E0210:2"]);
    check_codes("N1 G17 G90 G64 F100 G0 X0 Y0\nN2 G1 B1=45\nN3 M30", &["E0210:2"]);
    check_codes("N1 G17 G90 G64 F100 G0 X0 Y0\nN2 G1 B1=45\nN3 G1 B1=45 X5 Y9", &["E0210:3"]);
}

#[test]
fn two_lines_in_one_block() {
    // First to X20, rounded by 4, then up to Y20.
    check(
        "N1 G17 G90 F100\nN2 G11 X20 Y0 X1=20 Y1=20 R4\nN3 G1 X0",
        "G1 X16 Y0 Z0\nG3/17 X20 Y4 Z0 I0 J4\nG1 X20 Y20 Z0\nG1 X0 Y20 Z0",
    );
    // By angle and length, then by one coordinate and angle.
    check("N1 G17 G90 F100\nN2 G11 B90 L10 X1=10 B1=45", "G1 X0 Y10 Z0\nG1 X10 Y20 Z0");
    // The first by its angle alone.
    check("N1 G17 G90 F100\nN2 G11 B45 X1=30 Y1=10 B1=0", "G1 X10 Y10 Z0\nG1 X30 Y10 Z0");
}

#[test]
fn compensation_changes_its_side_in_a_mirror() {
    let mut machine = mill();
    machine.tools.push(tool(1, 0.0, 5.0));
    // Left of a way along X at Y10: 5 above; mirrored in X it runs to the left, and above stays above.
    let text = |mirror: &str| {
        format!("N1 G17 G90 T1 M67 F100{mirror}\nN2 G0 X-20 Y10\nN3 G41\nN4 G1 X0\nN5 X30\nN6 G40\nN7 X50 Y30")
    };
    check_from(&text(""), [0.0; 3], &machine, "G0 X-20 Y10 Z0\nG1 X0 Y15 Z0\nG1 X30 Y15 Z0\nG1 X50 Y30 Z0");
    check_from(&text(" G73 X-1"), [0.0; 3], &machine, "G0 X20 Y10 Z0\nG1 X0 Y15 Z0\nG1 X-30 Y15 Z0\nG1 X-50 Y30 Z0");
}

#[test]
fn tangential_approach_and_retraction() {
    let mut machine = mill();
    machine.tools.push(tool(1, 0.0, 5.0));
    // The contour runs along X at Y0, the tool left of it at Y5; a quarter of radius 8 arrives at X0 from above.
    check_from(
        "N1 G17 G90 T1 M67 F100\nN2 G1 X-20 Y30\nN3 G41 G61 X0 Y0 I2=1 R8\nN4 G1 X40\nN5 G40 G62 X60 Y40 I2=1 R8",
        [0.0; 3],
        &machine,
        "G1 X-20 Y30 Z0
G1 X-8 Y13 Z0
G3/17 X0 Y5 Z0 I8 J0
G1 X40 Y5 Z0
G3/17 X48 Y13 Z0 I0 J8
G1 X60 Y40 Z0",
    );
}

#[test]
fn an_approach_or_retraction_without_a_motion_is_a_finding() {
    let text = |lines: &str| format!("N1 G17 G90 F100\nN2 G1 X10 Y0\n{lines}");
    check_codes(&text("N3 G62 I2=1 R8\nN4 M30"), &["E0210:3"]);
    check_codes(&text("N3 G62 I2=1 R8\nN4 G40\nN5 G0\nN6 M30"), &["E0210:3"]);
    check_codes(&text("N3 G41 G61 R8\nN4 G40"), &["E0210:3"]);
    // The second takes the place of the first.
    check_codes(&text("N3 G62 R8\nN4 G62 R8\nN5 M30"), &["E0210:3", "E0210:4"]);
}
