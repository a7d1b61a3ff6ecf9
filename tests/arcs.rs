//! Arcs however they are programmed, and polar coordinates: flat moves of the reference examples and of hand arithmetic.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_language::exec::Options;

use crate::flat::{check, check_from, execute, moves};
use crate::machines::xyz_machine;

/// S3, but for TURN: extra turns stay in one element, `L2` beside the rest of 90 degrees.
#[test]
fn every_way_to_program_an_arc() {
    check_from(
        [10.0, 0.0, 0.0],
        "N10 G17 G90 G64
N20 G3 X0 Y10 I-10 J0 F500
N30 G2 X10 Y20 CR=10
N40 G2 X20 Y20 CR=-7.0711
N50 G3 X40 AR=90
N60 G3 I0 J10 AR=90
N70 G2 I=AC(60) J=AC(30)
N80 CIP X70 Y30 Z0 I1=60 J1=40 K1=0
N90 G1 X90
N100 CT X110 Y50
N110 G3 X100 Y60 Z-9 I-10 J0 TURN=2
N120 M30",
        &xyz_machine(),
        "G3/17 X0 Y10 Z0 I-10 J0
G2/17 X10 Y20 Z0 I10 J0
G2/17 X20 Y20 Z0 I5 J5
G3/17 X40 Y20 Z0 I10 J10
G3/17 X50 Y30 Z0 I0 J10
G2/17 X50 Y30 Z0 I10 J0
G2/17 X70 Y30 Z0 I10 J0
G1 X90 Y30 Z0
G3/17 X110 Y50 Z0 I0 J20
G3/17 X100 Y60 Z-9 I-10 J0 L2",
    );
}

/// The turns of a helix one by one: 4 mm down per turn of 9 mm in two and a quarter.
#[test]
fn extra_turns_sink_in_proportion_to_the_angle() {
    let (elements, _) = execute("G0 X10 Y0 Z0\nG3 X0 Y10 Z-9 I-10 J0 TURN=2 F1", &xyz_machine(), Options::default());
    let (start, motion) = moves(&elements, AxisVector::ZERO)[1];
    let arc = motion.arc.unwrap();
    for (turns, z) in [(1.0, -4.0), (2.0, -8.0)] {
        let place = arc.at(&start, &motion.target, turns / 2.25);
        assert!((place.xyz() - Vector::new(10.0, 0.0, z)).norm() < 1e-9, "{place:?}");
    }
}

#[test]
fn opening_angles_on_both_sides_of_a_half_turn() {
    let machine = xyz_machine();
    let start = "G0 X10 Y0 Z0\n";
    // From (10, 0) to (-10, 0): 180 degrees about the origin; to (0, 10) by 270 degrees about (10, 10).
    check(&format!("{start}G3 X-10 AR=180 F1"), &machine, "G0 X10\nG3/17 X-10 I-10");
    check(&format!("{start}G3 X0 Y10 AR=270 F1"), &machine, "G0 X10\nG3/17 X0 Y10 I0 J10");
    check(&format!("{start}G2 X0 Y10 AR=270 F1"), &machine, "G0 X10\nG2/17 X0 Y10 I-10 J0");
    check(&format!("{start}G2 I-10 Z5 AR=90 F1"), &machine, "G0 X10\nG2/17 X0 Y-10 Z5 I-10 J0");
    // In G18 the abscissa is Z.
    check("G18 G0 Z10 X0\nG3 K-10 AR=90 F1", &machine, "G0 Z10\nG3/18 X10 Z0 K-10");
    check("TRANS X5 Y1\nAROT Z90\nG0 X10 Y0\nG3 I=AC(0) J=AC(0) AR=90 F1", &machine, "G0 X5 Y11\nG3/17 X-5 Y1 J-10");
}

#[test]
fn arcs_through_a_point_in_every_plane() {
    let machine = xyz_machine();
    check("G0 X10\nCIP X-10 Y0 I1=0 J1=10 F1", &machine, "G0 X10\nG3/17 X-10 I-10");
    check("G0 X10\nCIP X-10 Z0 I1=0 K1=10 F1", &machine, "G0 X10\nG2/18 X-10 I-10");
    check("G0 Y10\nCIP Y-10 Z0 J1=0 K1=10 F1", &machine, "G0 Y10\nG3/19 Y-10 J-10");
    // G91: end and intermediate point from the start; IC and AC as written.
    check("G0 X10\nG91 CIP X-20 Y0 I1=-10 J1=10 F1", &machine, "G0 X10\nG3/17 X-10 I-10");
    check("G0 X10\nCIP X-10 Y0 I1=IC(-10) J1=AC(10) F1", &machine, "G0 X10\nG3/17 X-10 I-10");
    // On one line it is straight; the code is modal.
    check("G0 X10\nCIP X30 Y0 I1=20 J1=0 F1\nX30 Y20 I1=40 J1=10", &machine, "G0 X10\nG1 X30\nG3/17 X30 Y20 J10");
    check("MIRROR X0\nG0 X10\nCIP X-10 Y0 I1=0 J1=10 F1", &machine, "G0 X-10\nG2/17 X10 I10");
}

#[test]
fn an_arc_through_a_point_in_space_is_an_arc_in_its_plane() {
    let machine = xyz_machine();
    let program = "G0 X10 Y0 Z0\nCIP X0 Y0 Z10 I1=0 J1=10 K1=0 F100";
    let (elements, codes) = execute(program, &machine, Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let moves = moves(&elements, AxisVector::ZERO);
    let [(_, start), (_, motion)] = moves[..] else { panic!("{moves:?}") };
    assert_eq!(motion.target.xyz(), Vector::new(0.0, 0.0, 10.0));
    let (arc, basis) = (motion.arc.unwrap(), motion.arc_basis.unwrap());
    // The circle about the axis (1, 1, 1) through the unit points: its center is (10/3, 10/3, 10/3), its radius 10 sqrt(2/3).
    let normal: Vector = basis.column(2).into();
    assert!((normal.norm() - 1.0).abs() < 1e-12 && normal.cross(&Vector::repeat(1.0)).norm() < 1e-12, "{normal}");
    let [abscissa, ordinate] = arc.center_mm;
    let center: Vector =
        basis.column(0) * abscissa + basis.column(1) * ordinate + normal * normal.dot(&start.target.xyz());
    assert!((center - Vector::repeat(10.0 / 3.0)).norm() < 1e-9, "{center}");
    assert!(((start.target.xyz() - center).norm() - 10.0 * (2.0_f64 / 3.0).sqrt()).abs() < 1e-9);
    // About (1, 1, 1), the way from X to Z by Y is two thirds of a turn counterclockwise.
    assert_eq!(arc.clockwise, normal.sum() < 0.0);
    assert_eq!(arc.extra_turns, 0);
}

#[test]
fn tangential_arcs_follow_lines_and_arcs() {
    let machine = xyz_machine();
    check("G1 X10 F1\nCT X20 Y10\nX10 Y20", &machine, "G1 X10\nG3/17 X20 Y10 J10\nG3/17 X10 Y20 I-10");
    // Straight on, and to the right behind an arc.
    check("G1 X10 F1\nCT X20\nX30 Y-10", &machine, "G1 X10\nG1 X20\nG2/17 X30 Y-10 J-10");
    check("G0 X10\nG3 X0 Y10 I-10 F1\nCT X-10 Y20", &machine, "G0 X10\nG3/17 X0 Y10 I-10\nG2/17 X-10 Y20 J10");
    // A motion without way between them changes nothing, nor does a frame.
    check("G1 X10 F1\nX10\nTRANS X10\nCT X10 Y10", &machine, "G1 X10\nG3/17 X20 Y10 J10");
    check("ROT Z90\nG1 X10 F1\nCT X20 Y10", &machine, "G1 Y10\nG3/17 X-10 Y20 I-10");
}

#[test]
fn tangential_and_through_arcs_under_unequal_scale_are_on_the_ellipse() {
    let machine = xyz_machine();
    for words in ["CT X20 Y10", "CIP X20 Y10 I1=IC(10*SIN(45)) J1=IC(10-10*COS(45))"] {
        let (elements, codes) = execute(&format!("SCALE X2\nG1 X10 Y0 Z0 F1\n{words}"), &machine, Options::default());
        assert!(codes.is_empty(), "{codes:?}");
        let moves = moves(&elements, AxisVector::ZERO);
        assert!(moves.len() > 20);
        for (_, motion) in &moves[1..] {
            let [x, y] = [motion.target.0[0] / 2.0 - 10.0, motion.target.0[1] - 10.0];
            assert!((x.hypot(y) - 10.0).abs() < 1e-9, "{words}");
        }
    }
}

#[test]
fn arcs_that_are_none_are_refused() {
    let strict = || Options { strict: true, ..Options::default() };
    for (program, code) in [
        ("G3 X10 AR=400", "E0210"),
        ("G3 AR=90", "E0205"),
        ("G3 X10 I5 AR=90", "E0205"),
        ("G3 X10 CR=5 AR=90", "E0205"),
        ("G1 X10 AR=90", "E0205"),
        ("G1 X10 I1=5", "E0205"),
        ("CIP X10", "E0202"),
        ("CIP X10 Z3 I1=5 J1=5", "E0205"),
        ("CIP X0 Y0 I1=5 J1=5", "E0205"),
        ("CIP X10 I1=5 J1=5 TURN=2", "E0205"),
        ("CIP X10 I5", "E0205"),
    ] {
        let text = format!("G71 G0 X0 Y0 Z0\nF1\n{program}");
        assert_eq!(execute(&text, &xyz_machine(), strict()).1, [format!("{code}:3")], "{program}");
    }
    assert_eq!(execute("CT X10 F1", &xyz_machine(), Options::default()).1, ["E0205:1"]);
}

/// S6
#[test]
fn polar_positions_and_poles() {
    check(
        "N10 G17 G90 G0 X0 Y0 Z0
N20 G111 X40 Y20
N30 G1 RP=20 AP=0 F500
N40 AP=90
N50 G3 AP=IC(90) RP=20
N60 G110 X0 Y0             ; pole = present position X20 Y20
N70 G1 AP=-45 RP=10
N80 G112 X10 Y0            ; pole = last pole + (10,0) = X30 Y20
N90 AP=180 RP=30
N100 M30",
        &xyz_machine(),
        "G1 X60 Y20 Z0
G1 X40 Y40 Z0
G3/17 X20 Y20 Z0 I0 J-20
G1 X27.0711 Y12.9289 Z0
G1 X0 Y20 Z0",
    );
}

#[test]
fn polar_positions_in_other_planes_frames_and_units() {
    let machine = xyz_machine();
    // G18: from Z towards X. The axis across may stand beside it; without a pole the workpiece zero is the pole.
    check("G18 G0 RP=10 AP=90 Y5", &machine, "G0 X10 Y5");
    check("G19 G0 RP=10 AP=90 X5", &machine, "G0 X5 Z10");
    check("G70 G111 X1 Y0\nG0 RP=1 AP=90", &machine, "G0 X25.4 Y25.4");
    check("TRANS X100\nAROT Z90\nG111 X10 Y0\nG0 RP=5 AP=0\nG2 AP=-90 F1", &machine, "G0 X100 Y15\nG2/17 X105 Y10 J-5");
    check("G111 RP=10 AP=90\nG0 RP=0 AP=0", &machine, "G0 Y10");
    check("G0 X10\nG3 AP=0 RP=10 Z-3 F1", &machine, "G0 X10\nG3/17 X10 Z-3 I-10");
}

#[test]
fn polar_positions_that_are_not_clear_are_refused() {
    let machine = xyz_machine();
    for (program, codes) in [
        ("G0 AP=30", &["E0230:1"][..]),
        ("G0 X1 RP=3 AP=0", &["E0230:1"]),
        ("G0 RP=-1 AP=0", &["E0210:1"]),
        ("G91 G0 RP=1 AP=0", &["E0230:1"]),
        ("G0 RP=IC(1) AP=0", &["E0230:1"]),
        ("G111 X1 Y1\nG18\nG0 RP=1 AP=0", &["E0230:3"]),
        ("G0 RP=1 AP=0\nG111 X1\nAP=20", &["E0230:3"]),
        ("G110 X1 AP=3 RP=3", &["E0230:1"]),
        ("G111 AP=3", &["E0230:1"]),
        ("G111 X1 F100", &["E0108:1"]),
        ("G0 RP=5 AP=0\nG3 AP=20 RP=6 F1", &["E0203:2"]),
        ("G0 RP=5 AP=0\nG3 AP=20 CR=5 F1", &["E0205:2"]),
    ] {
        assert_eq!(execute(program, &machine, Options::default()).1, codes, "{program}");
    }
}

#[test]
fn a_faulty_arc_is_one_finding() {
    // The second arc has its center 5 mm off; those behind it are quarters of circles from where it ends.
    let text =
        "G17 G90 G0 X10 Y0 Z0\nG3 X0 Y10 I-10 J0 F100\nG3 X-10 Y0 I5 J-10\nG3 X0 Y-10 I10 J0\nG3 X10 Y0 I0 J10\nM30";
    let (_, codes) = execute(text, &xyz_machine(), Options::default());
    assert_eq!(codes, ["E0203:3"]);
}
