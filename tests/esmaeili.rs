//! The published cases of S. M. Esmaeili, PhD thesis, Polytechnique Montréal 2021: the ten single errors of chapter 6, the 45° machine of
//! chapter 7 and its closed forms, as they are printed and as they are right.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::{ErrorModel, ErrorName, LocationError, Model, Solve};

use crate::bench_machine::{motion, polynomial};
use crate::model::{Random, read, sample};

/// Table 6-2: µm and µrad of location errors, µm/m of positioning errors.
const CASES: [(&str, f64); 10] = [
    ("EB0A", 400.0),
    ("EC0A", 400.0),
    ("EY0C", 10.0),
    ("EA0C", 400.0),
    ("EB0C", 400.0),
    ("EC0X", 400.0),
    ("EA0Z", 400.0),
    ("EB0Z", 400.0),
    ("EYY", 40.0),
    ("EZZ", 40.0),
];

/// wCAYFXZt of chapter 6: A and C cross in the origin of F, every body moves in the positive direction.
fn chapter_6() -> Machine {
    let mut text = "[machine]\nname = \"chapter_6\"\ntopology = \"wCAYFXZSt\"\n".to_owned();
    for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-500, 500]\n");
    }
    for (axis, direction) in [("A", "[1, 0, 0]"), ("C", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_deg = [-360, 360]\n");
    }
    read(&text).0
}

fn single_error(name: &str, value: f64) -> ErrorModel {
    let mut errors = ErrorModel::default();
    if ["EYY", "EZZ"].contains(&name) {
        errors.motion.push(motion(name, polynomial(&[0.0, value * 1e-6])));
    } else {
        let name: ErrorName = name.parse().unwrap();
        let unit = if name.direction.is_rotation() { 1e-6 } else { 1e-3 };
        errors.location.push(LocationError { name, value: value * unit });
    }
    errors
}

/// Each of the ten errors alone: mean and largest error of the tip before and after, over the strokes of chapter 6 (260, 420, 240 mm, A ±55°).
#[test]
fn the_kinematic_correction_removes_each_of_the_ten_errors() {
    let machine = chapter_6();
    let (state, tool) = (State::default(), Vector::new(0.0, 0.0, -120.0));
    for (name, value) in CASES {
        let model = Model::new(&machine, &single_error(name, value));
        let mut random = Random(61);
        let (mut before_mm, mut most_before_mm, mut after_mm, mut tilt_rad) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
        const POSES: usize = 400;
        for _ in 0..POSES {
            let strokes = [130.0, 210.0, 120.0, 0.0, 0.0, 0.0, 55_f64.to_radians(), 0.0, 3.1];
            let mut nominal = AxisVector(strokes.map(|reach| reach * random.symmetric()));
            nominal[Axis::Z] += 120.0;
            let command = model.solve(&nominal, &tool, &state, &nominal, Solve::Full).unwrap();
            let error_mm = model.tip_error_mm(&nominal, &nominal, &tool, &state).norm();
            before_mm += error_mm / POSES as f64;
            most_before_mm = most_before_mm.max(error_mm);
            let (reached, target) = (model.actual(&command, &tool, &state), model.nominal(&nominal, &tool));
            after_mm = after_mm.max((reached.translation - target.translation).norm());
            if !model.is_near_singularity(&nominal, &tool) {
                tilt_rad = tilt_rad.max((reached.rotation.column(2) - target.rotation.column(2)).norm());
            }
        }
        // 0.4 mrad over about 100 mm, or 40 µm/m; 10 µm.
        assert!((0.003..0.1).contains(&before_mm), "{name}: {before_mm} mm before");
        assert!(after_mm < 1e-5, "{name}: {after_mm} mm after");
        assert!(tilt_rad < 5e-8, "{name}: {tilt_rad} rad after");
    }
}

/// Components in F, with their shares, that make up one parameter of the thesis.
type Parts = &'static [(&'static str, f64)];

/// Closed forms of the corrections of the 45° machine (Esmaeili 2021, chapter 7, derived anew with the roll of the tool left free),
/// per unit of each parameter and with the sign of J⁺E: the correction is the negative. Commands and results in the senses of
/// the thesis; X Y Z are positions of the machine, c and s cosine and sine of A. The thesis turns EC0A about the z of a frame that
/// lies with the A axis, which is (−1, 0, 1)/√2 in F.
fn closed_forms(x: f64, y: f64, a: f64) -> [(Parts, [f64; 5]); 10] {
    let (s, c) = a.sin_cos();
    let cot = c / s;
    [
        (&[("EC0X", 1.0)], [0.0, -x, 0.0, 0.0, 0.0]),
        (&[("EA0Z", 1.0)], [-y, x, y, -SQRT_2, 0.0]),
        (&[("EA0A", -FRAC_1_SQRT_2), ("EC0A", FRAC_1_SQRT_2)], [-SQRT_2 * y, SQRT_2 * x, 0.0, -1.0, 0.0]),
        (&[("EB0Z", 1.0)], [SQRT_2 * y * cot, -SQRT_2 * x * cot, x, (c - 1.0) / s, SQRT_2 / s]),
        (&[("EB0A", 1.0)], [-SQRT_2 * y * cot, SQRT_2 * x * cot, 0.0, -(c - 1.0) / s, -SQRT_2 / s]),
        (&[("EA0C", 1.0)], [0.0, 0.0, 0.0, SQRT_2, -1.0]),
        (&[("EB0C", 1.0)], [-SQRT_2 * y / s, SQRT_2 * x / s, 0.0, (c - 1.0) / s, -SQRT_2 * cot]),
        (&[("EX0S", 1.0)], [1.0, 0.0, 0.0, 0.0, 0.0]),
        (&[("EY0S", 1.0)], [0.0, -1.0, 0.0, 0.0, 0.0]),
        (&[("EY0C", 1.0)], [FRAC_1_SQRT_2 * s, c, -FRAC_1_SQRT_2 * s, 0.0, 0.0]),
    ]
}

#[test]
fn corrections_of_the_45_degree_table_are_the_closed_forms() {
    let (machine, _) = sample("esmaeili_huron");
    let mut random = Random(7);
    for _ in 0..40 {
        // A between 20° and 160°; the thesis counts Y, A and C the other way.
        let (x, y, z) = (200.0 * random.symmetric(), 200.0 * random.symmetric(), 250.0 + 100.0 * random.symmetric());
        let (a, c) = (1.57 + 1.2 * random.symmetric(), 3.0 * random.symmetric());
        let nominal = AxisVector([x, -y, z, 0.0, 0.0, 0.0, -a, 0.0, -c]);
        for (parts, thesis) in closed_forms(x, y, a) {
            let command_with = |value: f64| {
                let location = parts
                    .iter()
                    .map(|(name, share)| LocationError { name: name.parse().unwrap(), value: share * value });
                let model = Model::new(&machine, &ErrorModel { location: location.collect(), ..ErrorModel::default() });
                let tool = Vector::new(0.0, 0.0, -200.0);
                model.solve(&nominal, &tool, &State::default(), &nominal, Solve::Full).unwrap()
            };
            // Half the difference of both signs is free of the second order, which the closed forms leave out.
            let value = 1e-4;
            let correction = command_with(value) - command_with(-value);
            let senses = [1.0, -1.0, 1.0, -1.0, -1.0];
            for ((axis, sense), thesis) in
                [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C].into_iter().zip(senses).zip(thesis)
            {
                let found = correction[axis] * sense / (2.0 * value);
                let limit = if axis.is_rotary() { 1e-4 } else { 5e-3 };
                assert!((found + thesis).abs() < limit, "{parts:?} {axis}: {found} instead of {}", -thesis);
            }
        }
    }
}

#[test]
fn the_published_parameters_fall_from_tens_of_micrometers_to_nothing() {
    let (machine, errors) = sample("esmaeili_huron");
    let model = Model::new(&machine, &errors);
    let mut random = Random(8);
    let (mut before_mm, mut after_mm, mut first_order_mm, mut tilt_rad) = (0.0, 0.0, 0.0, 0.0_f64);
    const POSES: usize = 400;
    for _ in 0..POSES {
        let mut nominal =
            AxisVector([150.0, 150.0, 100.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.1].map(|reach| reach * random.symmetric()));
        nominal[Axis::Z] += 250.0;
        nominal[Axis::A] = -1.57 + 1.2 * random.symmetric();
        let tool = Vector::new(0.0, 0.0, -200.0);
        let state = State::default();
        before_mm += model.tip_error_mm(&nominal, &nominal, &tool, &state).norm() / POSES as f64;
        let command = model.solve(&nominal, &tool, &state, &nominal, Solve::Full).unwrap();
        after_mm += model.tip_error_mm(&nominal, &command, &tool, &state).norm() / POSES as f64;
        let (reached, target) = (model.actual(&command, &tool, &state), model.nominal(&nominal, &tool));
        tilt_rad = tilt_rad.max((reached.rotation.column(2) - target.rotation.column(2)).norm());
        // One step with the Jacobian by differences of the actual forward function.
        let step = first_order(&model, &nominal, &tool);
        first_order_mm += model.tip_error_mm(&nominal, &(nominal + step), &tool, &state).norm() / POSES as f64;
        assert!((command - nominal - step).max_abs(&[Axis::X, Axis::Y, Axis::Z]) < 1e-3);
        assert!((command - nominal - step).max_abs(&[Axis::A, Axis::C]) < 1e-6);
    }
    assert!((0.03..0.09).contains(&before_mm), "mean before {before_mm} mm");
    assert!(after_mm < 1e-6, "mean after {after_mm} mm");
    assert!(first_order_mm < 2e-4, "mean after one step {first_order_mm} mm");
    assert!(tilt_rad < 1e-8, "tilt {tilt_rad} rad");
}

/// The correction to first order: five rows (tip, two components of the tool axis), solved by elimination.
fn first_order(model: &Model, nominal: &AxisVector, tool: &Vector) -> AxisVector {
    let axes = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C];
    let target = model.nominal(nominal, tool);
    let (u, v) = (target.rotation.column(0), target.rotation.column(1));
    let rows = |command: &AxisVector| {
        let pose = model.actual(command, tool, &State::default());
        let (tip, axis) = (pose.translation - target.translation, pose.rotation.column(2).clone_owned());
        nalgebra::SVector::<f64, 5>::new(tip.x, tip.y, tip.z, u.dot(&axis), v.dot(&axis))
    };
    let columns = axes.map(|axis| {
        let (mut plus, mut minus) = (*nominal, *nominal);
        let step = if axis.is_rotary() { 1e-4 } else { 1e-2 };
        plus[axis] += step;
        minus[axis] -= step;
        (rows(&plus) - rows(&minus)) / (2.0 * step)
    });
    let solution = nalgebra::SMatrix::<f64, 5, 5>::from_columns(&columns).lu().solve(&-rows(nominal)).unwrap();
    let mut step = AxisVector::ZERO;
    axes.into_iter().zip(solution.iter()).for_each(|(axis, value)| step[axis] = *value);
    step
}

/// Table 7-2 before compensation: mm, rad and mm per mm, in the order of eq. 59.
const PARAMETERS: [f64; 13] = [
    -32.0e-6, 106.0e-6, 22.0e-6, 39.1e-6, 5.5e-6, 1.0e-3, 33.8e-6, -14.6e-6, -2.1e-3, 55.6e-3, 25.9e-6, -14.3e-6,
    30.0e-6,
];

/// Commands of the thesis: X, Y, Z, A, and the tool length t_y.
#[derive(Clone, Copy)]
struct Thesis {
    x: f64,
    y: f64,
    z: f64,
    a: f64,
    t_y: f64,
}

impl Thesis {
    /// Eq. 59 as it is printed: rows ECOX EAOZ EBOZ EBOA ECOA EYOC EAOC EBOC EXOS EZOS EXX1 EYY1 EZZ1, per unit of each.
    fn printed(self) -> [[f64; 5]; 13] {
        let Thesis { x, y, z, a, t_y } = self;
        let ((s, c), (s2, c2)) = (a.sin_cos(), (2.0 * a).sin_cos());
        let h = x + z - t_y;
        let half = FRAC_1_SQRT_2;
        [
            [
                (y * (c2 - 3.0) + SQRT_2 * s2 * (z - t_y)) / 4.0,
                (c * c - 1.0) * (t_y - z - x) / 2.0,
                (y * (1.0 - c2) - SQRT_2 * x * s2) / 4.0,
                half * (c - 1.0),
                -c,
            ],
            [
                (y * (c2 - 1.0) + SQRT_2 * s2 * (t_y - z)) / 4.0,
                (1.0 - c * c) * h / 2.0,
                (y * (3.0 + c2) + SQRT_2 * x * s2) / 4.0,
                -half * (c + 1.0),
                c,
            ],
            [
                (-2.0 * c * (t_y - z) - SQRT_2 * y * s) / 4.0,
                s2 * (t_y - x - z) / 2.0,
                SQRT_2 * s * (y * c + SQRT_2 * x * s2) / 2.0,
                -s,
                SQRT_2 * s,
            ],
            [
                c * (c * (t_y - z) - SQRT_2 * y * s) / 2.0,
                SQRT_2 * s2 * h / 4.0,
                c * (2.0 * x * c - SQRT_2 * y * s) / 2.0,
                s,
                -SQRT_2 * s,
            ],
            [
                (-SQRT_2 * y * (c2 - 1.0) + 2.0 * s2 * (t_y - z)) / 4.0,
                -SQRT_2 * s * s * h / 2.0,
                (SQRT_2 * y * c * c + x * s2) / 2.0,
                -c,
                SQRT_2 * c,
            ],
            [half * s, c, -half * s, 0.0, 0.0],
            [0.0, 0.0, 0.0, SQRT_2, -1.0],
            [c * (t_y - z) - half * y * s, half * s * h, x * c, 0.0, 0.0],
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, -1.0, 0.0, 0.0, 0.0],
            [x, 0.0, 0.0, 0.0, 0.0],
            [0.0, y, 0.0, 0.0, 0.0],
            [0.0, 0.0, z, 0.0, 0.0],
        ]
    }

    /// Eq. 59 with its ten wrong entries right.
    fn corrected(self) -> [[f64; 5]; 13] {
        let Thesis { x, y, z, a, t_y } = self;
        let ((s, c), (s2, c2)) = (a.sin_cos(), (2.0 * a).sin_cos());
        let h = x + z - t_y;
        let mut rows = self.printed();
        rows[0][0] = -(y * (c2 + 3.0) - SQRT_2 * (z - t_y) * s2) / 4.0;
        rows[0][1] = -h * s * s / 2.0;
        rows[2][0] = c * (SQRT_2 * y * s + 2.0 * c * (z - t_y)) / 2.0;
        rows[2][1] = -SQRT_2 * h * s2 / 4.0;
        rows[2][2] = s * (2.0 * x * s + SQRT_2 * y * c) / 2.0;
        rows[3][0] = c * (2.0 * c * (t_y - z) - SQRT_2 * y * s) / 2.0;
        rows[4][0] = (SQRT_2 * y * (c2 - 1.0) + 2.0 * (t_y - z) * s2) / 4.0;
        rows[4][1] = SQRT_2 * h * s * s / 2.0;
        rows[4][2] = (SQRT_2 * y * (c2 - 1.0) + 2.0 * x * s2) / 4.0;
        rows[7][2] = x * c - FRAC_1_SQRT_2 * y * s;
        rows
    }

    /// The command of the machine file, which counts Y, A and C the other way, with `sign` times the sum of the rows.
    fn command(self, c: f64, rows: &[[f64; 5]; 13], sign: f64) -> AxisVector {
        let Thesis { x, y, z, a, .. } = self;
        let mut thesis = [x, y, z, a, c];
        for (row, parameter) in rows.iter().zip(PARAMETERS) {
            for (value, entry) in thesis.iter_mut().zip(row) {
                *value += sign * parameter * entry;
            }
        }
        let [x, y, z, a, c] = thesis;
        AxisVector([x, -y, z, 0.0, 0.0, 0.0, -a, 0.0, -c])
    }
}

/// Error of the tip, mm, and tilt of the tool axis, rad, over poses.
#[derive(Clone, Copy, Debug, Default)]
struct Left {
    mean_mm: f64,
    max_mm: f64,
    mean_tilt_rad: f64,
    max_tilt_rad: f64,
}

/// What is left of the errors of the 45° machine over 400 random poses by a way to correct.
fn left(correct: impl Fn(&Model, Thesis, f64, &AxisVector) -> AxisVector) -> Left {
    const POSES: usize = 400;
    let (machine, errors) = sample("esmaeili_huron");
    let model = Model::new(&machine, &errors);
    let (state, t_y) = (State::default(), 200.0);
    let tool = Vector::new(0.0, 0.0, -t_y);
    let mut random = Random(71);
    let mut left = Left::default();
    for _ in 0..POSES {
        let [x, y, z] = [250.0, 250.0, 200.0].map(|reach| reach * random.symmetric());
        // A between 11° and 169°; at 0 it is singular.
        let (a, c) = (1.57 + 1.37 * random.symmetric(), 3.1 * random.symmetric());
        let pose = Thesis { x, y, z: 250.0 + z, a, t_y };
        let nominal = pose.command(c, &[[0.0; 5]; 13], 0.0);
        let command = correct(&model, pose, c, &nominal);
        let (reached, target) = (model.actual(&command, &tool, &state), model.nominal(&nominal, &tool));
        let off = (reached.translation - target.translation).norm();
        let tilt = (reached.rotation.column(2) - target.rotation.column(2)).norm();
        left.mean_mm += off / POSES as f64;
        left.mean_tilt_rad += tilt / POSES as f64;
        left.max_mm = left.max_mm.max(off);
        left.max_tilt_rad = left.max_tilt_rad.max(tilt);
    }
    left
}

/// The correction of this program, the corrected closed forms and the printed ones, on the parameters of Table 7-2. The volume of
/// the poses is not printed; other volumes change the figures by some tens of percent.
#[test]
fn equation_59_is_right_with_ten_entries_and_its_sign_corrected() {
    let before = left(|_, _, _, nominal| *nominal);
    let solved = left(|model, pose, _, nominal| {
        let tool = Vector::new(0.0, 0.0, -pose.t_y);
        model.solve(nominal, &tool, &State::default(), nominal, Solve::Full).unwrap()
    });
    let corrected = left(|_, pose, c, _| pose.command(c, &pose.corrected(), -1.0));
    let printed = left(|_, pose, c, _| pose.command(c, &pose.printed(), -1.0));
    let with_plus = left(|_, pose, c, _| pose.command(c, &pose.corrected(), 1.0));
    // 55.7 µm and 84.6 µrad; 44 µm were measured.
    assert!((0.050..0.062).contains(&before.mean_mm) && (70e-6..100e-6).contains(&before.mean_tilt_rad), "{before:?}");
    assert!(solved.max_mm < 1e-6 && solved.max_tilt_rad < 5e-8, "{solved:?}");
    // First order only: 1e-5 of the distances is left.
    assert!(corrected.mean_mm < 2e-5 && corrected.max_mm < 6e-5, "{corrected:?}");
    // Ten wrong entries: 5.2 µm, at most 18.6 µm.
    assert!((0.003..0.008).contains(&printed.mean_mm) && (0.012..0.03).contains(&printed.max_mm), "{printed:?}");
    // Six rows spend rotary motion on the roll of the tool; the axis stays tilted by 53.8 µrad, right entries or not.
    for tilted in [corrected, printed] {
        assert!((40e-6..70e-6).contains(&tilted.mean_tilt_rad), "{tilted:?}");
    }
    // Without the minus sign the error doubles.
    assert!((with_plus.mean_mm / before.mean_mm - 2.0).abs() < 0.02, "{with_plus:?}");
}

#[test]
fn printed_results_that_their_tables_cannot_give() {
    // Table 4-1: the number of balls of each of the 32 indexations.
    let balls = [3, 3, 3, 3, 4, 3, 3, 3, 3, 3, 3, 3, 4, 3, 3, 3, 6, 3, 3, 6, 6, 6, 6, 3, 3, 6, 6, 1, 1, 1, 1, 1];
    assert_eq!((balls.len(), balls.iter().sum::<i32>()), (32, 109));
    // Table 4-3: scales of X, Y, Z, mm/mm. A distance of 150 mm in the direction (x, y, z) changes by R (sx x² + sy y² + sz z²).
    let (scales, radius_mm) = ([-17e-6, -23e-6, -32e-6], 150.0_f64);
    let mut largest_um = 0.0_f64;
    for polar in 0..=90 {
        for around in 0..360 {
            let (polar, around) = (f64::from(polar).to_radians(), f64::from(around).to_radians());
            let direction = [polar.sin() * around.cos(), polar.sin() * around.sin(), polar.cos()];
            let change: f64 = scales.iter().zip(direction).map(|(scale, part)| scale * part * part).sum();
            largest_um = largest_um.max((radius_mm * change * 1e3).abs());
        }
    }
    assert!((largest_um - 4.8).abs() < 1e-9, "{largest_um}");
    // Table 4-2: ECX0 in rad, a rotation about Z. On a hemisphere the mean square of the arm is 2/3 R².
    let (rotation, rms_um) = (3.62e-3_f64, 24.5);
    let hemisphere_mm = rotation * radius_mm * (2.0_f64 / 3.0).sqrt();
    assert!((hemisphere_mm - 0.44).abs() < 0.005, "{hemisphere_mm}");
    assert!((rms_um * 1e-3 / rotation - 6.8).abs() < 0.05);
}
