//! A milling machine that warms up: two masses, sensors that are not where the heat is, and where the tool goes. It knows nothing of the
//! models that are tried on it.
//!
//! Head and column, C dT/dt = P(n) − h (T − T_amb) − k (T − T_other), explicit steps of 10 s. The bearing is warmer than the head by a part
//! of its own that follows the power quickly. The tool drifts by the expansion of head (α L ΔT, towards −Y), spindle (down) and column (up),
//! and because the front of the column is warmer than its rear, and its right side warmer than its left: it leans by θ = α G/b · h at height
//! h, is off by θ h/2 there, and the tool swings about this point.

use std::f64::consts::TAU;

use crate::bench_machine::Random;

/// Highest speed of the spindle, rpm.
pub(crate) const MAX_RPM: f64 = 6300.0;
/// Sampling of readings and drift, s.
pub(crate) const SAMPLING_S: f64 = 60.0;
/// Noise of the temperature sensors, 1σ, K.
pub(crate) const SENSOR_NOISE_K: f64 = 0.1;
/// Names of the sensors: at the bearing, and on the column below the head.
pub(crate) const SENSORS: [&str; 2] = ["T_head", "T_column"];

const STEP_S: f64 = 10.0;
/// J/K
const CAPACITY_HEAD: f64 = 27_600.0;
const CAPACITY_COLUMN: f64 = 276_000.0;
/// W/K
const LOSS_HEAD: f64 = 9.0;
const LOSS_COLUMN: f64 = 15.0;
const CONDUCTION: f64 = 6.0;
/// W at the highest speed.
const POWER_HEAD: f64 = 350.0;
const POWER_COLUMN: f64 = 60.0;
/// Rise of the bearing above the head, K/W, and its time constant, s.
const BEARING_K_PER_W: f64 = 1.0 / 30.0;
const BEARING_LAG_S: f64 = 180.0;
/// Share of head − column in the differences front − rear, right − left (at the mean height), upper − lower.
const FRONT_SHARE: f64 = 0.1;
const RIGHT_SHARE: f64 = 0.02;
const UPPER_SHARE: f64 = 0.06;

/// 1/K
pub(crate) const ALPHA: f64 = 11.5e-6;
/// From the column to the spindle, length of the spindle, length of the tool, mm.
pub(crate) const HEAD_MM: f64 = 450.0;
pub(crate) const SPINDLE_MM: f64 = 250.0;
pub(crate) const TOOL_MM: f64 = 120.0;
/// Height of the head above the foot of the column where Z is 0, mm.
pub(crate) const FOOT_MM: f64 = 700.0;
/// Depth and width of the column and its height, at whose ends the sensors are, mm.
pub(crate) const COLUMN_MM: f64 = 400.0;
pub(crate) const COLUMN_HEIGHT_MM: f64 = 1200.0;

/// A speed for a time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stage {
    pub(crate) duration_s: f64,
    pub(crate) rpm: f64,
}

/// The machine at one instant.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub(crate) time_s: f64,
    /// Mean temperatures of the masses, °C.
    pub(crate) head_c: f64,
    pub(crate) column_c: f64,
    /// What the sensors read, °C, in the order of [`SENSORS`].
    pub(crate) readings_c: [f64; 2],
    /// What sensors in the corners of the column read, °C: the lower ones, the upper ones, each front left, front right, rear left, rear right.
    pub(crate) column_corners_c: [[f64; 4]; 2],
    /// The same for the head: at the column, at the spindle; each upper left, upper right, lower left, lower right.
    pub(crate) head_corners_c: [[f64; 4]; 2],
}

/// From a standstill through speeds in steps of 25 % of the highest, 15 min each, and 30 min at 25 % from 135 min on: as far as Spaan 1995
/// (p. 5.2 ff.) describes DIN 8602. The order of the other levels is our choice.
pub(crate) fn din_8602() -> Vec<Stage> {
    let percent = [25, 50, 75, 100, 75, 50, 25, 0, 100, 25, 25, 50, 100, 75, 50, 0, 0];
    let stages = percent.map(|percent| Stage { duration_s: 900.0, rpm: MAX_RPM * 0.01 * f64::from(percent) });
    [standstill()].into_iter().chain(stages).collect()
}

/// Speeds at random from 800 rpm on or none, for 5 to 45 min each, 24 h long (Spaan 1995, fig. 5.4).
pub(crate) fn random_speeds(random: &mut Random) -> Vec<Stage> {
    let mut stages = vec![standstill()];
    let mut left_s = 24.0 * 3600.0;
    while left_s > 0.0 {
        let rpm = if random.between(0.0, 1.0) < 0.2 { 0.0 } else { random.between(800.0, MAX_RPM) };
        let duration_s = random.between(5.0 * 60.0, 45.0 * 60.0).min(left_s);
        stages.push(Stage { duration_s, rpm });
        left_s -= duration_s;
    }
    stages
}

/// Measurements begin before the spindle does.
fn standstill() -> Stage {
    Stage { duration_s: 900.0, rpm: 0.0 }
}

/// Normally distributed noise: the sum of twelve even ones.
pub(crate) fn gauss(random: &mut Random, sigma: f64) -> f64 {
    sigma * ((0..12).map(|_| random.between(0.0, 1.0)).sum::<f64>() - 6.0)
}

/// Runs the machine from a shop temperature that it has all through, which rises and falls by 1.5 K over a day; 1σ of what sensors read.
pub(crate) fn run(stages: &[Stage], shop_c: f64, noise_k: f64, random: &mut Random) -> Vec<Sample> {
    let mut samples = Vec::new();
    let [mut head_c, mut column_c, mut bearing_w] = [shop_c, shop_c, 0.0];
    let [mut time_s, mut next_s, mut end_s] = [0.0; 3];
    for stage in stages {
        end_s += stage.duration_s;
        let share = stage.rpm / MAX_RPM;
        let (head_w, column_w) = (POWER_HEAD * share.powf(1.5), POWER_COLUMN * share);
        while time_s < end_s {
            if time_s >= next_s {
                let read = |value: f64| value + gauss(random, noise_k);
                samples.push(sample(time_s, head_c, column_c, bearing_w * BEARING_K_PER_W, read));
                next_s += SAMPLING_S;
            }
            let ambient_c = shop_c + 1.5 * (TAU * time_s / 86_400.0).sin();
            let across_w = CONDUCTION * (head_c - column_c);
            head_c += STEP_S * (head_w - LOSS_HEAD * (head_c - ambient_c) - across_w) / CAPACITY_HEAD;
            column_c += STEP_S * (column_w - LOSS_COLUMN * (column_c - ambient_c) + across_w) / CAPACITY_COLUMN;
            bearing_w += STEP_S * (head_w - bearing_w) / BEARING_LAG_S;
            time_s += STEP_S;
        }
    }
    samples
}

fn sample(time_s: f64, head_c: f64, column_c: f64, bearing_k: f64, mut read: impl FnMut(f64) -> f64) -> Sample {
    let across_k = head_c - column_c;
    let readings_c = [read(head_c + bearing_k), read(column_c + 0.15 * across_k)];
    let corner = |end: f64, front: f64, right: f64| {
        let shares = UPPER_SHARE * end + FRONT_SHARE * front + RIGHT_SHARE * right;
        column_c + 0.5 * across_k * shares
    };
    let mut four = |end: f64| {
        [(1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)].map(|(front, right)| read(corner(end, front, right)))
    };
    let column_corners_c = [four(-1.0), four(1.0)];
    let head_corners_c = [-0.2, 0.2].map(|share| [head_c + share * bearing_k; 4].map(&mut read));
    Sample { time_s, head_c, column_c, readings_c, column_corners_c, head_corners_c }
}

/// Where the tool went in relation to the workpiece since another sample, along X, Y and Z, µm.
pub(crate) fn drift_um(sample: &Sample, since: &Sample, z_mm: f64) -> [f64; 3] {
    let (head_k, column_k) = (sample.head_c - since.head_c, sample.column_c - since.column_c);
    let (height_mm, across_k) = (FOOT_MM + z_mm, head_k - column_k);
    // Mean of the column below the head: its temperature rises evenly from end to end.
    let below_k = column_k + 0.5 * UPPER_SHARE * across_k * (height_mm / COLUMN_HEIGHT_MM - 1.0);
    // A column that is warmer in front leans back, which lifts the head and swings the tool forward; one that is warmer on its right leans to
    // the left.
    let [back, left] = [FRONT_SHARE, RIGHT_SHARE].map(|share| ALPHA * share * across_k / COLUMN_MM * height_mm);
    let hanging_mm = SPINDLE_MM + TOOL_MM;
    let along_mm = [
        left * (hanging_mm - height_mm / 2.0),
        back * (height_mm / 2.0 - hanging_mm) - ALPHA * HEAD_MM * head_k,
        back * HEAD_MM + ALPHA * (height_mm * below_k - SPINDLE_MM * head_k),
    ];
    along_mm.map(|mm| 1e3 * mm)
}

#[test]
fn masses_end_where_losses_take_all_the_power() {
    let share: f64 = 0.64;
    let samples =
        run(&[Stage { duration_s: 5.0 * 86_400.0, rpm: share * MAX_RPM }], 20.0, SENSOR_NOISE_K, &mut Random(1));
    // A whole day, so that the shop has its mean temperature.
    let day = &samples[samples.len() - 1440..];
    let mean = |value: fn(&Sample) -> f64| day.iter().map(value).sum::<f64>() / 1440.0;
    let (head_c, column_c) = (mean(|sample| sample.head_c), mean(|sample| sample.column_c));
    let across_w = 6.0 * (head_c - column_c);
    assert!((9.0 * (head_c - 20.0) + across_w - 350.0 * share.powf(1.5)).abs() < 0.1);
    assert!((15.0 * (column_c - 20.0) - across_w - 60.0 * share).abs() < 0.1);
    assert!(head_c > column_c + 5.0 && column_c > 22.0);
}

#[test]
fn corners_tell_mean_and_gradient_of_the_column() {
    let samples = run(&din_8602(), 20.0, SENSOR_NOISE_K, &mut Random(2));
    let warm = &samples[samples.len() / 2..];
    let mean = |value: &dyn Fn(&Sample) -> f64| warm.iter().map(value).sum::<f64>() / warm.len() as f64;
    let off_k = mean(&|sample| sample.column_corners_c.as_flattened().iter().sum::<f64>() / 8.0 - sample.column_c);
    assert!(off_k.abs() < 0.02, "{off_k}");
    let front_k = mean(&|sample| {
        let difference = |[left, right, rear_left, rear_right]: [f64; 4]| (left + right - rear_left - rear_right) / 2.0;
        sample.column_corners_c.map(difference).iter().sum::<f64>() / 2.0
    });
    let across_k = mean(&|sample| sample.head_c - sample.column_c);
    assert!((front_k - 0.1 * across_k).abs() < 0.03, "{front_k}");
    let head_k = mean(&|sample| sample.head_corners_c.as_flattened().iter().sum::<f64>() / 8.0 - sample.head_c);
    assert!(head_k.abs() < 0.02, "{head_k}");
}
