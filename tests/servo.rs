//! What a program does at feed, against closed forms: lag, circles, corners, times.

use std::f64::consts::{PI, TAU};

use ncfix_base::geometry::{Arc, Axis, AxisSet, AxisVector, Plane, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, FeedUnit, Kind, MotionMode, Move, Origin, RotaryDirection};
use ncfix_model::{ErrorModel, Model, file};
use ncfix_path::path::CorrectionOptions;
use ncfix_path::servo::{CycleState, Drive, MoveSpeed, Run, ServoMove, SpaceCircle};

/// A mill with three axes; `servo` are the lines of `[servo]` and of its axes.
fn machine_with(servo: &str, rest: &str) -> (Machine, ErrorModel) {
    let mut text = "[machine]\nname = \"t\"\ntopology = \"wFXYZSt\"\n".to_owned();
    for (axis, direction) in [("X", "[1, 0, 0]"), ("Y", "[0, 1, 0]"), ("Z", "[0, 0, 1]")] {
        text += &format!("[axis.{axis}]\ndirection = {direction}\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n");
    }
    text += &format!("{servo}\n{rest}\n");
    let (loaded, findings) = file::load(&Source::new(FileId(0), "t.toml", text.into_bytes()).unwrap());
    loaded.unwrap_or_else(|| panic!("{findings:?}"))
}

/// `[servo]` with the same loops on all axes but Y.
fn servo(head: &str, all: &str, of_y: &str) -> String {
    format!("[servo]\n{head}\n[servo.X]\n{all}\n[servo.Y]\n{of_y}\n[servo.Z]\n{all}\n")
}

fn at(x: f64, y: f64) -> AxisVector {
    let mut out = AxisVector::ZERO;
    out.set_xyz(Vector::new(x, y, 0.0));
    out
}

fn line(x: f64, y: f64, mm_min: f64) -> ServoMove {
    ServoMove { target: at(x, y), circle: None, pace: MoveSpeed::Feed(mm_min / 60.0), is_tip_feed: false, block: 0 }
}

/// All moments of a program that starts at the first target, and its time.
fn moments((machine, errors): &(Machine, ErrorModel), program: &[ServoMove]) -> (Vec<CycleState>, f64) {
    let model = Model::new(machine, errors);
    let mut drive = Drive::new(machine, machine.servo.as_ref().unwrap(), &model);
    let mut out = Vec::new();
    for motion in program {
        drive.go(motion, &mut |moment| out.push(*moment));
    }
    drive.finish(&mut |moment| out.push(*moment));
    (out, drive.time_s())
}

/// Several turns about the origin from (radius, 0).
fn circle(radius: f64, mm_min: f64) -> [ServoMove; 2] {
    let start = at(radius, 0.0);
    let arc = Arc { plane: Plane::XY, clockwise: false, center_mm: [0.0, 0.0], extra_turns: 3 };
    let turn = ServoMove { circle: Some(SpaceCircle::of_arc(&arc, None, &start)), ..line(radius, 0.0, mm_min) };
    [line(radius, 0.0, mm_min), turn]
}

/// Largest and least radius of the encoders in the second and third turn.
fn radii(moments: &[CycleState], time_s: f64) -> [f64; 2] {
    let inner = moments.iter().filter(|moment| (0.3..0.7).contains(&(moment.time_s / time_s)));
    let radii: Vec<f64> = inner.map(|moment| moment.encoder.0[0].hypot(moment.encoder.0[1])).collect();
    [radii.iter().copied().fold(f64::MIN, f64::max), radii.iter().copied().fold(f64::MAX, f64::min)]
}

const FINE: &str = "cycle_ms = 1.0\ncorner_tolerance_um = 10";
const STIFF: &str = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration_m_s2 = 5";

#[test]
fn a_circle_shrinks_by_the_gain_of_the_loops() {
    // A first-order lag 1/(1 + i w/K) has the gain 1/√(1 + (w/K)²): 50 mm at 6000 mm/min and 50 1/s lose 39.95 µm.
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 0\nmax_acceleration_m_s2 = 5";
    let (seen, time_s) = moments(&machine_with(&servo(FINE, loops, loops), ""), &circle(50.0, 6000.0));
    let lost = 50.0 * (1.0 - 1.0 / (1.0 + (2.0_f64 / 50.0).powi(2)).sqrt());
    let [largest, least] = radii(&seen, time_s);
    assert!((lost - 0.03995).abs() < 1e-5);
    assert!((50.0 - least - lost).abs() < 1e-4 && (50.0 - largest - lost).abs() < 1e-4, "{largest} {least} {lost}");
    // The contouring error is that, not the lag of 2 mm along the path.
    let worst = seen.iter().filter(|moment| (0.3..0.7).contains(&(moment.time_s / time_s)));
    let worst = worst.filter_map(|moment| moment.on_path).map(|on_path| on_path.off_mm.norm()).fold(0.0, f64::max);
    assert!((worst - lost).abs() < 1e-4, "{worst}");
}

#[test]
fn a_circle_shrinks_by_the_smoothing_as_a_triangle_does() {
    // The spectrum of a triangle of the length T is sinc²(w T/4): 48 ms at 2 rad/s take 9.6 µm of 50 mm.
    let head = "cycle_ms = 1.0\nsmoothing_ms = 48\ncorner_tolerance_um = 100";
    let (seen, time_s) = moments(&machine_with(&servo(head, STIFF, STIFF), ""), &circle(50.0, 6000.0));
    let angle = 2.0_f64 * 0.048 / 4.0;
    let lost = 50.0 * (1.0 - (angle.sin() / angle).powi(2));
    let [largest, least] = radii(&seen, time_s);
    assert!((lost - 0.0096).abs() < 1e-5);
    assert!((50.0 - least - lost).abs() < 1e-4 && (50.0 - largest - lost).abs() < 1e-4, "{largest} {least} {lost}");
}

#[test]
fn axes_of_different_lag_make_an_oval() {
    // Radially v dτ/2 at 45°, with both signs: 0.4 ms at 100 mm/s are ±20 µm.
    let late = format!("{STIFF}\ndelay_ms = 0.4");
    let (seen, time_s) = moments(&machine_with(&servo(FINE, STIFF, &late), ""), &circle(50.0, 6000.0));
    let [largest, least] = radii(&seen, time_s);
    assert!((largest - 50.02).abs() < 2e-4 && (least - 49.98).abs() < 2e-4, "{largest} {least}");
}

#[test]
fn on_a_slanting_line_only_the_difference_of_the_lags_leaves_the_path() {
    // Lags (1 − f)/K of 1 ms and 2 ms at 100 mm/s: 100 · 1 ms · sin 45° cos 45° = 50 µm.
    let of_x = "velocity_gain_per_s = 50\nfeed_forward = 0.95\nmax_acceleration_m_s2 = 5";
    let of_y = "velocity_gain_per_s = 50\nfeed_forward = 0.9\nmax_acceleration_m_s2 = 5";
    let program = [line(0.0, 0.0, 6000.0), line(200.0, 200.0, 6000.0)];
    let (seen, time_s) = moments(&machine_with(&servo(FINE, of_x, of_y), ""), &program);
    let middle = seen.iter().min_by(|a, b| (a.time_s - time_s / 2.0).abs().total_cmp(&(b.time_s - time_s / 2.0).abs()));
    let middle = middle.unwrap();
    assert!((middle.on_path.unwrap().off_mm.norm() - 0.05).abs() < 1e-6);
    let speed = 100.0 / 2_f64.sqrt();
    assert!((middle.set_point.0[0] - middle.encoder.0[0] - speed * 1e-3).abs() < 1e-9);
    assert!((middle.set_point.0[1] - middle.encoder.0[1] - speed * 2e-3).abs() < 1e-9);
    assert!((middle.feed_mm_min - 6000.0).abs() < 1e-9);
}

#[test]
fn a_corner_is_rounded_by_its_tolerance() {
    // dv T/12 + a T²/96 = 10 µm with T = 12 ms: with 3 m/s² the ramps take 4.5 µm, and the corner is passed at 5.5 mm/s. Where half of the kernel
    // is behind the corner, the acceleration of Y is 2 dv/T + a/2 = 2.417 m/s².
    let head = "cycle_ms = 0.1\nsmoothing_ms = 12\ncorner_tolerance_um = 10";
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration_m_s2 = 3";
    let program = [line(0.0, 0.0, 6000.0), line(30.0, 0.0, 6000.0), line(30.0, 30.0, 6000.0)];
    let (seen, time_s) = moments(&machine_with(&servo(head, loops, loops), ""), &program);
    let corner: Vec<&CycleState> = seen.iter().filter(|moment| (moment.time_s - time_s / 2.0).abs() < 0.02).collect();
    let off = corner.iter().map(|moment| moment.on_path.unwrap().off_mm.norm()).fold(0.0, f64::max);
    // Between two cycles the tool is nearer still to the corner.
    assert!((off - 0.010).abs() < 4e-4, "{off}");
    let slowest = corner.iter().min_by(|a, b| a.feed_mm_min.total_cmp(&b.feed_mm_min)).unwrap();
    assert!((slowest.feed_mm_min - 330.0).abs() < 20.0, "{}", slowest.feed_mm_min);
    assert!((slowest.state.acceleration.0[1] - 2417.0).abs() < 50.0, "{}", slowest.state.acceleration.0[1]);
}

#[test]
fn programs_take_the_time_of_their_trapezoids() {
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration_m_s2 = 1";
    let machine = machine_with(&servo(FINE, loops, loops), "");
    // 100 mm at 100 mm/s: 1.1 s; back, with a stop: the same again. 1 mm never gets there: 2 √(s/a).
    let (_, time_s) = moments(&machine, &[line(0.0, 0.0, 6000.0), line(100.0, 0.0, 6000.0), line(0.0, 0.0, 6000.0)]);
    assert!((time_s - 2.2).abs() < 2e-3, "{time_s}");
    let (_, time_s) = moments(&machine, &[line(0.0, 0.0, 6000.0), line(1.0, 0.0, 6000.0)]);
    assert!((time_s - 2.0 * 0.001_f64.sqrt()).abs() < 1e-9, "{time_s}");
    // In pieces without a bend it takes no longer; rapid moves go as fast as the axes: 500 mm/s, 0.5 s up and down, 125 mm each.
    let pieces: Vec<ServoMove> = (0..=1000).map(|k| line(f64::from(k) * 0.1, 0.0, 6000.0)).collect();
    let (_, time_s) = moments(&machine, &pieces);
    assert!((time_s - 1.1).abs() < 1e-6, "{time_s}");
    let rapid = ServoMove { pace: MoveSpeed::Rapid, ..line(500.0, 0.0, 0.0) };
    let (_, time_s) = moments(&machine, &[line(0.0, 0.0, 6000.0), rapid]);
    assert!((time_s - 1.5).abs() < 1e-9, "{time_s}");
    // A given time: of the cruise, to which what the ramps lose is added: v/a.
    let timed = ServoMove { pace: MoveSpeed::Time(2.0), ..line(100.0, 0.0, 0.0) };
    let (_, time_s) = moments(&machine, &[line(0.0, 0.0, 6000.0), timed]);
    assert!((time_s - 2.05).abs() < 1e-9, "{time_s}");
}

/// Time of 100 mm along X at 100 mm/s in two moves, behind these words, on a control.
fn time_of_halves(controller: &str, words: &[&'static str]) -> f64 {
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration_m_s2 = 1";
    let (mut machine, errors) = machine_with(&servo(FINE, loops, loops), "");
    machine.controller = controller.to_owned();
    let model = Model::new(&machine, &errors);
    let options = CorrectionOptions { start: Some(AxisVector::ZERO), ..CorrectionOptions::default() };
    let mut run = Run::new(&machine, machine.servo.as_ref().unwrap(), &model, &options);
    let named: AxisSet = [Axis::X].into_iter().collect();
    let half = |x: f64| {
        Kind::Move(Move {
            rapid: false,
            arc: None,
            target: at(x, 0.0),
            named,
            known: AxisSet::XYZ,
            feed: 6000.0,
            feed_named: true,
            unit: FeedUnit::PerMinute,
            ways: [RotaryDirection::default(); 3],
            in_machine_frame: false,
            motion_mode: MotionMode::Path,
            off_curve_mm: 0.0,
            tip: None,
            arc_basis: None,
        })
    };
    for kind in words.iter().map(|word| Kind::Keep(word)).chain([half(50.0), half(100.0)]) {
        let element = Element { origin: Origin::default(), starts_block: true, number: None, kind };
        run.element(&element, 0, &mut |_| {});
    }
    run.finish(&mut |_| {});
    run.time_s()
}

#[test]
fn axes_stop_between_blocks_where_the_language_says_so() {
    // One trapezoid with ramps of 0.1 s: 1.1 s; two: 1.2 s, and what the axes need to arrive.
    for (controller, words, stops) in [
        ("sinumerik", ["G60", "G62"].as_slice(), true),
        ("sinumerik", &["G9"], true),
        ("sinumerik", &["G60", "G64"], false),
        ("sinumerik", &["G61"], false),
        ("fanuc", &["G61"], true),
        ("fanuc", &["G61", "G62"], false),
        ("fanuc", &["G60"], false),
        ("rs274", &["G61.1"], true),
        ("rs274", &["G61.1", "G61"], false),
        ("rs274", &["G9"], false),
        ("grundig", &["G61"], false),
    ] {
        let time_s = time_of_halves(controller, words);
        let is_right = if stops { (1.2..1.6).contains(&time_s) } else { (time_s - 1.1).abs() < 2e-3 };
        assert!(is_right, "{controller} {words:?}: {time_s}");
    }
}

#[test]
fn curves_are_passed_as_fast_as_the_acceleration_allows() {
    // 5 mm at 1 m/s²: √(a R) = 70.7 mm/s; per axis the acceleration is that of the circle where it is turned to the centre.
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration_m_s2 = 1";
    let (seen, time_s) = moments(&machine_with(&servo(FINE, loops, loops), ""), &circle(5.0, 12000.0));
    let hardest = seen.iter().filter(|moment| (0.3..0.7).contains(&(moment.time_s / time_s)));
    let hardest = hardest.map(|moment| moment.state.acceleration.0[0].abs()).fold(0.0, f64::max);
    assert!((950.0..1050.0).contains(&hardest), "{hardest}");
    let fastest = seen.iter().map(|moment| moment.feed_mm_min).fold(0.0, f64::max);
    assert!(fastest > 0.98 * 60.0 * 5000_f64.sqrt(), "{fastest}");
    assert!(time_s > 4.0 * TAU * 5.0 / 100.0 && time_s < 4.0 * TAU * 5.0 / 55.0, "{time_s}");
}

#[test]
fn what_gives_way_under_acceleration_is_added() {
    // EYX of 2 µm by m/s² of X: while X goes up with 5 m/s², the tool is 10 µm beside its line.
    let rest = "[[dynamic]]\ncomponent = \"EYX\"\num_per_m_s2 = 2";
    let program = [line(0.0, 0.0, 30000.0), line(200.0, 0.0, 30000.0)];
    let (seen, _) = moments(&machine_with(&servo(FINE, STIFF, STIFF), rest), &program);
    let off = |from: f64, to: f64| {
        let part = seen.iter().filter(|moment| (from..to).contains(&moment.time_s));
        part.map(|moment| moment.on_path.unwrap().off_mm.y).fold(f64::NAN, f64::max)
    };
    assert!((off(0.03, 0.07) - 0.010).abs() < 1e-6, "{}", off(0.03, 0.07));
    assert!(off(0.15, 0.35).abs() < 1e-9);
}

#[test]
fn a_rotary_axis_under_the_tool_has_a_path_of_its_own() {
    // A table that turns the workpiece 90° under a tool at 100 mm: the path in the workpiece is an arc, and an exact loop stays on it.
    let text = "[machine]\nname = \"t\"\ntopology = \"wCFXYZSt\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-900, 900]\nmax_feed_mm_min = 30000\n\
        [axis.C]\ndirection = [0, 0, 1]\ntravel_deg = [-900, 900]\nmax_feed_deg_min = 3600\n";
    let loops = "velocity_gain_per_s = 50\nfeed_forward = 1\nmax_acceleration";
    let mut text = format!("{text}[servo]\n{FINE}\n");
    for axis in ["X", "Y", "Z"] {
        text += &format!("[servo.{axis}]\n{loops}_m_s2 = 5\n");
    }
    text += &format!("[servo.C]\n{loops}_rad_s2 = 20\n");
    let (loaded, findings) = file::load(&Source::new(FileId(0), "t.toml", text.into_bytes()).unwrap());
    let machine = loaded.unwrap_or_else(|| panic!("{findings:?}"));
    let mut target = at(100.0, 0.0);
    target.0[8] = PI / 2.0;
    let turn = ServoMove { target, ..line(0.0, 0.0, 1800.0) };
    let (seen, time_s) = moments(&machine, &[line(100.0, 0.0, 100.0), turn]);
    let worst = seen.iter().filter_map(|moment| moment.on_path).map(|on_path| on_path.off_mm.norm());
    assert!(worst.fold(0.0, f64::max) < 2e-4);
    // 90° at 1800°/min, where only the table turns: 3 s and v/a = 0.5236/20 s.
    assert!((time_s - (3.0 + PI / 6.0 / 20.0)).abs() < 1e-3, "{time_s}");
}
