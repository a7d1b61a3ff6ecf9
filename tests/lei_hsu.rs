//! The printed equations of a table-tilting machine against the chain: W. T. Lei and Y. Y. Hsu, Accuracy enhancement of five-axis CNC
//! machines through real-time error compensation, Int. J. Machine Tools & Manufacture 43 (2003) 871–877.
//!
//! The equations are written here as they are printed, with the corrections that they need: in eq. 19 the orientation terms must not be
//! multiplied by sin² θa, and the cases θa = 0 (eq. 23–26) and 90° (eq. 27–31) lack terms.

use std::f64::consts::FRAC_PI_2;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_model::name::DIRECTIONS;
use ncfix_model::{ErrorModel, ErrorName, LocationError, Model, Solve};

use crate::bench_machine::{Random, motion, polynomial};
use crate::model::read;

/// X'Y'ZA'C' (their Fig. 1): the workpiece on C, in A, on X, on Y; Z carries the spindle. Positive commands move the tables in the
/// positive direction. Z is the height of the tip over the point where A and C cross.
pub(crate) fn machine() -> Machine {
    let mut text = "[machine]\nname = \"lei_hsu\"\ntopology = \"wCAXYFZSt\"\n".to_owned();
    for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-500, 500]\n");
    }
    for (axis, direction) in [("A", "[1, 0, 0]"), ("C", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_deg = [-7200, 7200]\n");
    }
    read(&text).0
}

/// Setting positions x_m, y_m, z_m, θa, θc.
#[derive(Clone, Copy, Debug)]
struct Setting {
    x: f64,
    y: f64,
    z: f64,
    a: f64,
    c: f64,
}

impl Setting {
    fn random(random: &mut Random, a: f64) -> Setting {
        let [x, y, z] = [0; 3].map(|_| random.between(-300.0, 300.0));
        Setting { x, y, z, a, c: random.between(-3.0, 3.0) }
    }

    fn command(&self) -> AxisVector {
        AxisVector([self.x, self.y, self.z, 0.0, 0.0, 0.0, self.a, 0.0, self.c])
    }

    /// Sine and cosine of θa and θc.
    fn sines(&self) -> [f64; 4] {
        let ((sa, ca), (sc, cc)) = (self.a.sin_cos(), self.c.sin_cos());
        [sa, ca, sc, cc]
    }

    /// Eq. 10–15 with the offsets of the workpiece zero left out: tip and direction of the tool in the workpiece.
    fn forward(&self) -> [Vector; 2] {
        let Setting { x, y, z, .. } = *self;
        let [sa, ca, sc, cc] = self.sines();
        let tip = Vector::new(z * sc * sa - y * sc * ca - x * cc, z * cc * sa - y * cc * ca + x * sc, z * ca + y * sa);
        [tip, Vector::new(sa * sc, sa * cc, ca)]
    }

    /// Eq. 18–22, eq. 19 corrected: dx_m, dy_m, dz_m, dθa, dθc.
    fn corrections(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let Setting { x, y, z, .. } = *self;
        let [sa, ca, sc, cc] = self.sines();
        let (di, dj) = (dq.x, dq.y);
        [
            (-dp.x * cc * sa + dp.y * sc * sa + di * cc * sa * z - di * cc * ca * y - dj * sc * sa * z
                + dj * sc * ca * y)
                / sa,
            -dp.x * sc * ca - dp.y * cc * ca
                + dp.z * sa
                + di * (sc * z / ca + cc * ca * x / sa)
                + dj * (cc * z / ca - sc * ca * x / sa),
            (dp.x * sa * sc * ca + dp.y * cc * sa * ca + dp.z * ca * ca - di * sc * y - di * cc * ca * x
                + dj * sc * ca * x
                - dj * cc * y)
                / ca,
            (di * sc + dj * cc) / ca,
            (di * cc - dj * sc) / sa,
        ]
    }

    /// Eq. 19 as it is printed.
    fn printed_y(&self, dp: Vector, dq: Vector) -> f64 {
        let Setting { x, z, .. } = *self;
        let [sa, ca, sc, cc] = self.sines();
        (-dp.x * sc * ca * ca - dp.y * cc * ca * ca
            + dp.z * ca * sa
            + dq.x * sa * sa * sc * z
            + dq.x * cc * sa * ca * ca * x
            - dq.y * sc * sa * ca * ca * x
            + dq.y * cc * sa * sa * z)
            / ca
    }

    /// θa = 0, eq. 23–26 corrected: C is suppressed, and with it the tilt in its plane.
    fn level_corrections(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let [_, _, sc, cc] = self.sines();
        let turn_a = sc * dq.x + cc * dq.y;
        [-cc * dp.x + sc * dp.y, -sc * dp.x - cc * dp.y + self.z * turn_a, dp.z - self.y * turn_a, turn_a, 0.0]
    }

    /// θa = 90°, eq. 27–31 corrected.
    fn upright_corrections(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let [_, _, sc, cc] = self.sines();
        let (turn_a, turn_c) = (-dq.z, cc * dq.x - sc * dq.y);
        [
            -cc * dp.x + sc * dp.y + self.z * turn_c,
            dp.z + self.z * turn_a,
            sc * dp.x + cc * dp.y - self.x * turn_c - self.y * turn_a,
            turn_a,
            turn_c,
        ]
    }

    /// Eq. 23–26 as they are printed.
    fn printed_level(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let [_, _, sc, cc] = self.sines();
        let [x, y] = [-cc * dp.x + sc * dp.y - self.y * dq.y, -sc * dp.x - cc * dp.y + self.x * dq.y];
        [x, y, dp.z, dq.x, 0.0]
    }

    /// Eq. 27–31 as they are printed.
    fn printed_upright(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let [_, _, sc, cc] = self.sines();
        let [x, z] = [-cc * dp.x + sc * dp.y + self.z * dq.y, sc * dp.x + cc * dp.y - self.x * dq.y];
        [x, dp.z, z, dq.x, dq.y]
    }

    /// What eq. 18–22 are where no cosine of θa divides: dθa from all three components of the direction.
    fn safe_corrections(&self, dp: Vector, dq: Vector) -> [f64; 5] {
        let Setting { x, y, z, .. } = *self;
        let [sa, ca, sc, cc] = self.sines();
        let turn_a = ca * (sc * dq.x + cc * dq.y) - sa * dq.z;
        let turn_c = (cc * dq.x - sc * dq.y) / sa;
        [
            -cc * dp.x + sc * dp.y + (sa * z - ca * y) * turn_c,
            -sc * ca * dp.x - cc * ca * dp.y + sa * dp.z + z * turn_a + ca * x * turn_c,
            sc * sa * dp.x + cc * sa * dp.y + ca * dp.z - y * turn_a - sa * x * turn_c,
            turn_a,
            turn_c,
        ]
    }
}

/// The link errors of the rotary block (bTc, cTa and aTx of eq. 7) and a workpiece that is set up askew on the table, up to
/// `size` rad and as many times 300 mm.
fn errors(random: &mut Random, size: f64) -> ErrorModel {
    let mut errors = ErrorModel::default();
    for direction in DIRECTIONS {
        let mut value = || random.between(-size, size) * if direction.is_rotation() { 1.0 } else { 300.0 };
        for axis in [Axis::A, Axis::C] {
            errors.location.push(LocationError { name: ErrorName::location(direction, axis), value: value() });
        }
        // Constant errors behind the motion of C are those of the set-up.
        let name = ErrorName::motion(direction, Axis::C).to_string();
        errors.motion.push(motion(&name, polynomial(&[value()])));
    }
    errors
}

/// Eq. 16 and 17 from the chain: nominal minus actual.
fn pose_error(model: &Model, setting: &Setting) -> [Vector; 2] {
    let (command, tool) = (setting.command(), Vector::zeros());
    let (nominal, actual) = (model.nominal(&command, &tool), model.actual(&command, &tool, &State::default()));
    [nominal.translation - actual.translation, (nominal.rotation - actual.rotation) * Vector::z()]
}

/// How far commands with these corrections are from those of the model (mm, an arm of 300 mm for rotary axes), and how far the tip
/// is off with them, mm.
fn differences(model: &Model, setting: &Setting, corrections: [f64; 5]) -> [f64; 2] {
    let (nominal, tool, state) = (setting.command(), Vector::zeros(), State::default());
    let found = model.solve(&nominal, &tool, &state, &nominal, Solve::Full).unwrap();
    let mut command = nominal;
    let mut off: f64 = 0.0;
    for (axis, correction) in [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C].into_iter().zip(corrections) {
        command[axis] += correction;
        let arm = if axis.is_rotary() { 300.0 } else { 1.0 };
        off = off.max(arm * (command[axis] - found[axis]).abs());
    }
    [off, model.tip_error_mm(&nominal, &command, &tool, &state).norm()]
}

#[test]
fn the_forward_equations_are_the_chain() {
    let model = Model::new(&machine(), &ErrorModel::default());
    let mut random = Random(31);
    for k in 0..300 {
        let a = match k {
            0..50 => 0.0,
            50..100 => FRAC_PI_2,
            _ => random.between(-2.0, 2.0),
        };
        let setting = Setting::random(&mut random, a);
        let [tip, direction] = setting.forward();
        let pose = model.nominal(&setting.command(), &Vector::zeros());
        assert!((pose.translation - tip).norm() < 1e-10, "{setting:?}");
        assert!((pose.rotation * Vector::z() - direction).norm() < 1e-13, "{setting:?}");
    }
}

type Form = fn(&Setting, Vector, Vector) -> [f64; 5];

/// The largest differences over random machines and poses with `a` from `angle`.
fn worst(size: f64, form: Form, mut angle: impl FnMut(&mut Random) -> f64) -> [f64; 2] {
    let (machine, mut random) = (machine(), Random(32));
    let mut worst: [f64; 2] = [0.0; 2];
    for _ in 0..300 {
        let model = Model::new(&machine, &errors(&mut random, size));
        let a = angle(&mut random);
        let setting = Setting::random(&mut random, a);
        let [dp, dq] = pose_error(&model, &setting);
        let found = differences(&model, &setting, form(&setting, dp, dq));
        worst = [worst[0].max(found[0]), worst[1].max(found[1])];
    }
    worst
}

/// Errors a tenth as large leave a hundredth: the equations are the first order of the chain, and nothing of that order is missing.
#[track_caller]
fn is_first_order(form: Form, angle: fn(&mut Random) -> f64) {
    let (large, small) = (worst(1e-3, form, angle), worst(1e-4, form, angle));
    for k in 0..2 {
        let ratio = large[k] / small[k];
        assert!((70.0..140.0).contains(&ratio), "{large:?} {small:?}");
        // 300 mm · 1e-4 is 30 µm for each of 18 errors.
        assert!(small[k] < 1e-3, "{small:?}");
    }
}

#[test]
fn the_corrected_inverse_is_the_first_order_of_the_chain() {
    is_first_order(Setting::corrections, |random| random.between(0.4, 1.2));
    is_first_order(Setting::safe_corrections, |random| random.between(0.4, 2.7));
}

#[test]
fn with_the_table_level_c_is_suppressed_and_the_position_exact() {
    is_first_order(Setting::level_corrections, |_| 0.0);
}

#[test]
fn with_the_table_upright_no_cosine_divides() {
    is_first_order(Setting::upright_corrections, |_| FRAC_PI_2);
    is_first_order(Setting::safe_corrections, |_| FRAC_PI_2);
}

/// Errors a tenth as large leave a tenth: terms of the first order are missing.
#[track_caller]
fn is_wrong(form: Form, angle: fn(&mut Random) -> f64) {
    let (large, small) = (worst(1e-3, form, angle), worst(1e-4, form, angle));
    assert!(small[1] > 0.02 && (8.0..12.0).contains(&(large[1] / small[1])), "{large:?} {small:?}");
}

#[test]
fn the_cases_of_both_poles_as_printed_leave_errors_of_the_first_order() {
    is_wrong(Setting::printed_level, |_| 0.0);
    is_wrong(Setting::printed_upright, |_| FRAC_PI_2);
}

/// The orientation terms of eq. 19 are printed sin² θa too small; what that leaves is no second order.
#[test]
fn equation_19_as_printed_leaves_errors_of_the_first_order() {
    let printed: Form = |setting, dp, dq| {
        let mut corrections = setting.corrections(dp, dq);
        corrections[1] = setting.printed_y(dp, dq);
        corrections
    };
    is_wrong(printed, |random| random.between(0.4, 1.2));
    let mut random = Random(33);
    for degrees in [10.0_f64, 30.0, 60.0, 80.0] {
        let setting = Setting::random(&mut random, degrees.to_radians());
        let (none, tilt) = (Vector::zeros(), Vector::new(1e-4, -2e-4, 0.0));
        let right = setting.corrections(none, tilt)[1];
        let sine = setting.a.sin();
        assert!((setting.printed_y(none, tilt) - right * sine * sine).abs() < 1e-15);
    }
}
