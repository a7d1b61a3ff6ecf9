//! Programmable frames: flat moves of the reference examples, chains, arcs behind frames, what is refused.

use ncfix_base::geometry::{Axis, AxisSet, AxisVector, Frame, Matrix, Plane, RotationOrder, Vector, by_solid_angles};
use ncfix_language::exec::Options;
use ncfix_machine::machine::Machine;
use proptest::prelude::*;

use crate::flat::{check, execute, moves};
use crate::machines::xyz_machine;

fn with(change: impl FnOnce(&mut ncfix_machine::machine::Control)) -> Machine {
    let mut machine = xyz_machine();
    change(&mut machine.control);
    machine
}

/// S4: shift, rotation in G18, scale, an arc in the plane Z X.
#[test]
fn shift_rotation_and_scale_chain_and_a_bare_word_clears_all() {
    check(
        "N10 G18 G90 G500
N20 TRANS X10 Y20 Z30
N30 AROT RPL=30            ; G18 active: rotation about Y, Z towards X
N40 ASCALE X2 Y2 Z2
N50 G0 X0 Y0 Z10
N60 G3 Z0 X10 I0 K-10 F300
N70 G1 Z-5
N80 TRANS                  ; clears TRANS, ROT and SCALE together
N90 G0 X0 Y0 Z0
N100 M30",
        &xyz_machine(),
        "G0 X20 Y20 Z47.3205
G3/18 X27.3205 Y20 Z20 I-10 K-17.3205
G1 X22.3205 Y20 Z11.3397
G0 X0 Y0 Z0",
    );
}

/// S5: one mirrored axis swaps the sense of an arc, two do not.
#[test]
fn mirrors_swap_the_sense_of_arcs() {
    check(
        "N10 G17 G90 G0 X0 Y0
N20 TRANS X50
N30 AMIRROR X0
N40 G1 X10 Y0 F300
N50 G3 X20 Y10 I0 J10
N60 AMIRROR Y0
N70 G1 X10 Y0
N80 G3 X20 Y10 I0 J10
N90 MIRROR                 ; without axes: whole programmable frame cleared
N100 G1 X0 Y0
N110 M30",
        &xyz_machine(),
        "G1 X40 Y0 Z0
G2/17 X30 Y10 Z0 I0 J10
G1 X40 Y0 Z0
G3/17 X30 Y-10 Z0 I0 J-10
G1 X0 Y0 Z0",
    );
}

/// S17: the order of the words does not matter, that of the statements does.
#[test]
fn rotations_by_several_angles() {
    let machine = xyz_machine();
    for words in ["X30 Z90", "Z90 X30"] {
        check(&format!("ROT {words}\nG0 X0 Y10 Z0"), &machine, "G0 X-8.6603 Y0 Z5");
    }
    check("ROT X30\nAROT Z90\nG0 X0 Y10 Z0", &machine, "G0 X-10 Y0 Z0");
    // Euler: Rz(90) Rx(30), and Y turns about the new Z.
    let euler = with(|control| control.rotation_order = RotationOrder::Euler);
    check("ROT X30 Z90\nG0 X0 Y10 Z0", &euler, "G0 X-8.6603 Y0 Z5");
    check("ROT X30 Y90\nG0 X10 Y0 Z0", &euler, "G0 X0 Y8.6603 Z5");
    check("ROT X30 Y90\nG0 X10 Y0 Z0", &machine, "G0 X0 Y0 Z-10");
}

/// S18: what an incremental word does behind a shift.
#[test]
fn incremental_words_behind_a_shift() {
    let program = "N10 G90 G0 X10\nN20 TRANS X5\nN30 G91 X10\nN40 G90 X0";
    check(program, &xyz_machine(), "G0 X10\nG0 X25\nG0 X5");
    let pure = with(|control| control.incremental_traverses_frame_change = false);
    check(program, &pure, "G0 X10\nG0 X20\nG0 X5");
}

#[test]
fn incremental_words_behind_a_rotation_are_refused_where_the_control_adds_the_change() {
    let program = "G90 G0 X10 Y0 Z0\nROT Z30\nG91 Z1\nX10\nG90";
    let strict = || Options { strict: true, ..Options::default() };
    assert_eq!(execute(program, &xyz_machine(), strict()).1, ["E0304:4"]);
    let pure = with(|control| control.incremental_traverses_frame_change = false);
    assert!(execute(program, &pure, strict()).1.is_empty());
    check(program, &pure, "G0 X10\nG0 X10 Z1\nG0 X18.6603 Y5 Z1");
}

#[test]
fn machine_coordinates_of_other_axes_decide_nothing() {
    let start = "G90 G71 F100\nG0 X0 Y0 Z0\nROT Z30\nG1 X10 Y5\nROT\n";
    let strict = || Options { strict: true, ..Options::default() };
    let codes = |between: &str| execute(&format!("{start}{between}G91 G1 Y1\nM30"), &xyz_machine(), strict()).1;
    assert_eq!(codes(""), ["E0304:6"]);
    for word in ["G53", "G153", "SUPA"] {
        assert_eq!(codes(&format!("{word} G0 X30\n")), ["E0304:7"], "{word}");
        assert!(codes(&format!("{word} G0 Y30\n")).is_empty(), "{word}");
    }
}

#[test]
fn replacing_statements_replace_everything() {
    let machine = xyz_machine();
    check("TRANS X10\nROT Z90\nG0 X1 Y0", &machine, "G0 X0 Y1");
    check("ROT Z90\nTRANS X10\nG0 X1 Y2", &machine, "G0 X11 Y2");
    check("SCALE X2\nATRANS X10\nG0 X1 Y2", &machine, "G0 X22 Y2");
    check("ATRANS X10\nASCALE X2 Y3\nAROT Z90\nG0 X1 Y2", &machine, "G0 X6 Y3");
    check("MIRROR X0\nATRANS X10\nG0 X1 Y2", &machine, "G0 X-11 Y2");
    check("MIRROR X0\nAMIRROR X0\nG0 X1 Y2", &machine, "G0 X1 Y2");
    check("TRANS X10\nROTS\nG0 X1", &machine, "G0 X1");
}

#[test]
fn mirroring_by_value_is_a_setting() {
    let by_value = with(|control| control.mirror_toggles = false);
    check("MIRROR X0 Y1\nG0 X1 Y2", &by_value, "G0 X1 Y-2");
    check("MIRROR X0 Y1\nG0 X1 Y2", &xyz_machine(), "G0 X-1 Y-2");
}

/// ROTS X a Y b: the normal is perpendicular to the lines at a in Y Z and at b in Z X.
#[test]
fn solid_angles_tilt_the_plane() {
    // a = 30, b = 45: x' = (cos 45, 0, -sin 45); normal ~ (sin b cos a, -cos b sin a, cos b cos a) = (0.61237, -0.35355, 0.61237),
    // its length 0.935414.
    check("ROTS X30 Y45\nG0 X10 Y0 Z0\nX0 Z10", &xyz_machine(), "G0 X7.0711 Y0 Z-7.0711\nG0 X6.5465 Y-3.7796 Z6.5465");
    check("ROTS Z90\nG0 X10 Y0 Z0", &xyz_machine(), "G0 X0 Y10 Z0");
    let (_, codes) = execute("ROTS X1 Y1 Z1\nROTS X90 Y10\nG0 X1", &xyz_machine(), Options::default());
    assert_eq!(codes, ["E0210:1", "E0210:2"]);
}

#[test]
fn coarse_and_fine_shift_need_a_control_that_has_them() {
    let program = "TRANS X10 Y20\nG59 X1\nG58 X5\nG0 X0 Y0\nATRANS X2\nG0 X0\nG59 X0.5\nG0 X0";
    assert_eq!(execute(program, &xyz_machine(), Options::default()).1, ["E0201:2", "E0201:3", "E0201:7"]);
    check(program, &with(|control| control.fine_shift = true), "G0 X6 Y20\nG0 X8 Y20\nG0 X5.5 Y20");
}

#[test]
fn frames_that_make_no_sense_are_refused() {
    for (program, code) in [
        ("SCALE X0", "E0210:1"),
        ("SCALE X-1", "E0210:1"),
        ("ROT X30 RPL=10", "E0210:1"),
        ("TRANS RPL=10", "E0210:1"),
        ("ROT Z30 G1", "E0108:1"),
        ("AROT X=IC(5)", "E0108:1"),
        ("G0 X1 RPL=3", "E0210:1"),
    ] {
        assert_eq!(execute(program, &xyz_machine(), Options::default()).1, [code], "{program}");
    }
}

/// Positions of an arc in a tilted plane against the circle by its definition.
#[test]
fn arcs_in_tilted_planes_are_arcs_and_in_stretched_ones_chords_on_the_curve() {
    let machine = xyz_machine();
    let rpy = RotationOrder::Rpy.matrix([25_f64.to_radians(), -40_f64.to_radians(), 10_f64.to_radians()]);
    for (statement, linear) in [
        ("ROT X25 Y-40 Z10", rpy),
        ("SCALE X2 Y0.5", Matrix::from_diagonal(&Vector::new(2.0, 0.5, 1.0))),
        ("ROT X25 Y-40 Z10\nASCALE X3\nAMIRROR Y0", rpy * Matrix::from_diagonal(&Vector::new(3.0, -1.0, 1.0))),
    ] {
        let program = format!("{statement}\nG0 X20 Y0 Z0\nG3 X-20 Y0 Z8 I-20 J0 F500");
        let (elements, codes) = execute(&program, &machine, Options::default());
        assert!(codes.is_empty());
        let moves = moves(&elements, AxisVector::ZERO);
        let is_circle = !statement.contains("SCALE");
        assert_eq!(moves.len() == 2, is_circle, "{statement}");
        let mut points = Vec::new();
        for (start, motion) in &moves[1..] {
            match (&motion.arc, &motion.arc_basis) {
                (Some(arc), Some(basis)) => {
                    let [from, to] = [start, &motion.target].map(|end| {
                        let mut flat = *end;
                        flat.set_xyz(basis.transpose() * end.xyz());
                        flat
                    });
                    // So near to each other that their chords are as fine as those of the others.
                    points.extend((1..=1000).map(|k| basis * arc.at(&from, &to, f64::from(k) / 1000.0).xyz()));
                }
                _ => points.push(motion.target.xyz()),
            }
        }
        let back = linear.try_inverse().unwrap();
        let (mut last_angle, mut widest) = (0.0_f64, 0.0_f64);
        let mut start = moves[1].0.xyz();
        for point in points {
            let on_curve = |angle: f64| {
                linear * Vector::new(20.0 * angle.cos(), 20.0 * angle.sin(), 8.0 * angle / std::f64::consts::PI)
            };
            let programmed = back * point;
            let angle = programmed[1].atan2(programmed[0]).rem_euclid(std::f64::consts::TAU);
            assert!((point - on_curve(angle)).norm() < 1e-9, "{statement}");
            assert!(angle > last_angle);
            // Largest distance of the chord from the curve between its ends, sampled.
            for k in 1..8 {
                let at = last_angle + (angle - last_angle) * f64::from(k) / 8.0;
                let way = point - start;
                let from = on_curve(at) - start;
                widest = widest.max((from - way * (from.dot(&way) / way.norm_squared())).norm());
            }
            last_angle = angle;
            start = point;
        }
        assert!((last_angle - std::f64::consts::PI).abs() < 1e-9);
        assert!(widest <= machine.control.chord_tolerance_mm, "{statement}: {widest}");
    }
}

#[test]
fn a_quarter_turn_of_the_frame_swaps_the_plane_of_an_arc() {
    // ROT X90: the programmed X Y plane is the machine's X Z plane; its normal is -Y... of the programmed Z: Rx(90) z = -y.
    check("ROT X90\nG0 X10 Y0 Z0\nG3 X0 Y10 I-10 J0 F100", &xyz_machine(), "G0 X10 Y0 Z0\nG2/18 X0 Y0 Z10 I-10 K0");
    check(
        "ROT Y90\nG0 X10 Y0 Z0\nG3 X0 Y10 I=AC(0) J=AC(0) F100",
        &xyz_machine(),
        "G0 X0 Y0 Z-10\nG3/19 X0 Y10 Z0 J0 K10",
    );
}

#[test]
fn block_wise_suppression_acts_below_rotated_frames() {
    check(
        "N10 G54 G0 X0 Y0 Z0\nN20 ROT Z90\nN30 X10 Y0\nN40 G53 X3 Y4\nN50 X1\nN60 G500 X1 Y2\nN70 SUPA X0",
        &xyz_machine(),
        // Behind N40 the machine stands at X3 Y4: in the frame X-46 Y97; N50 moves X to 1 only.
        "G0 X100 Y50 Z10\nG0 X100 Y60 Z10\nG0 X3 Y4 Z10\nG0 X3 Y51 Z10\nG0 X-2 Y1 Z10\nG0 X0 Y1 Z10",
    );
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let angle = -3.0..3.0_f64;
    (
        angle.clone(),
        angle.clone(),
        angle,
        prop::array::uniform3(0.2..5.0_f64),
        0_u8..8,
        prop::array::uniform3(-500.0..500.0_f64),
    )
        .prop_map(|(a, b, c, factors, mirrored, shift)| {
            let mut offset = AxisVector::ZERO;
            offset.0[..3].copy_from_slice(&shift);
            let axes: AxisSet =
                [Axis::X, Axis::Y, Axis::Z].into_iter().filter(|axis| mirrored & (1 << axis.slot()) != 0).collect();
            Frame::translation(offset)
                .compose(&Frame::rotation(RotationOrder::Rpy.matrix([a, b, c])))
                .compose(&Frame::scale(factors.into()).unwrap())
                .compose(&Frame::mirror(axes))
        })
}

fn homogeneous(frame: &Frame) -> nalgebra::Matrix4<f64> {
    let mut out = frame.linear().to_homogeneous();
    out.fixed_view_mut::<3, 1>(0, 3).copy_from(&frame.offset().xyz());
    out
}

proptest! {
    #[test]
    fn frames_compose_as_matrices(a in any_frame(), b in any_frame(), p in prop::array::uniform3(-500.0..500.0_f64)) {
        let chained = homogeneous(&a.compose(&b));
        prop_assert!((chained - homogeneous(&a) * homogeneous(&b)).norm() < 1e-9 * chained.norm());
        let mut position = AxisVector::ZERO;
        position.0[..3].copy_from_slice(&p);
        let there = a.compose(&b).apply(&position);
        prop_assert!((a.compose(&b).unapply(&there) - position).max_abs(&ncfix_base::geometry::AXES) < 1e-7);
        let nothing = a.compose(&a.inverse());
        prop_assert!((homogeneous(&nothing) - nalgebra::Matrix4::identity()).norm() < 1e-9 * homogeneous(&a).norm());
    }

    #[test]
    fn circles_stay_circles_exactly_where_lengths_stay_in_proportion(a in any_frame()) {
        let linear = a.linear();
        let [x, y, z] = [0, 1, 2].map(|k| linear.column(k).into_owned());
        let is_alike = (x.norm() - y.norm()).abs() < 1e-9;
        prop_assert_eq!(a.keeps_circles(Plane::XY), is_alike && x.dot(&y).abs() < 1e-9 && x.dot(&z).abs() < 1e-9);
    }

    #[test]
    fn a_plane_by_solid_angles_is_a_rotation(a in -1.5..1.5_f64, b in -1.5..1.5_f64) {
        for axis in [Axis::X, Axis::Y, Axis::Z] {
            let rotation = by_solid_angles(axis, a, b).unwrap();
            prop_assert!((rotation * rotation.transpose() - Matrix::identity()).norm() < 1e-12);
            prop_assert!(rotation.determinant() > 0.0);
        }
    }

    /// A frame, and its statements undone in reverse order, give the moves back; mirrors undo themselves.
    #[test]
    fn statements_and_their_opposites_leave_the_moves(angle in -180.0..180.0_f64, factor in 0.1..9.0_f64, shift in -99.0..99.0_f64) {
        let program = format!(
            "ATRANS X={shift} Z=2\nAROT Y={angle}\nASCALE X={factor}\nAMIRROR Z0\nAMIRROR Z0\nASCALE X=1/{factor}\nAROT Y=-{angle}
ATRANS X=-{shift} Z=-2\nG0 X10 Y20 Z30\nG3 X20 Y30 J10 F100"
        ).replace("--", "");
        let (elements, codes) = execute(&program, &xyz_machine(), Options::default());
        prop_assert!(codes.is_empty(), "{:?}", codes);
        let end = moves(&elements, AxisVector::ZERO).last().unwrap().1.target;
        prop_assert!((end.xyz() - Vector::new(20.0, 30.0, 30.0)).norm() < 1e-9, "{:?}", end);
    }
}
