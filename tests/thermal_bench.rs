//! Thermal drift on a machine that warms up, through a machine file, a log and the model (Spaan 1995, ch. 5): the statistical model, whose
//! coefficients are obtained from speeds at random, and the analytical one, which knows the structure, tried on the spectrum of DIN 8602.

use std::fmt::Write as _;

use nalgebra::{DMatrix, DVector};
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::condition::log;
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_model::{ErrorModel, Model, file};

use crate::bench_machine::Random;
use crate::thermal_plant::{SENSOR_NOISE_K, SENSORS, Sample, TOOL_MM, din_8602, drift_um, gauss, random_speeds, run};

/// Where the drift was measured along Z, mm.
const POSITIONS_MM: [f64; 3] = [0.0, 200.0, 400.0];
/// Noise of the displacement sensors, 1σ, µm.
const TRANSDUCER_UM: f64 = 0.5;

const MACHINE: &str = "[machine]\nname = \"warm\"\ntopology = \"wXYFZSt\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";

/// Efficiency (Spaan 1995, eq. 5.2), %.
pub(crate) fn efficiency(measured: &[f64], simulated: &[f64]) -> f64 {
    let off: f64 = measured.iter().zip(simulated).map(|(measured, simulated)| (measured - simulated).abs()).sum();
    100.0 * (1.0 - off / measured.iter().map(|measured| measured.abs()).sum::<f64>())
}

/// Readings of a sensor as a body follows them with a time constant: the exact solution for straight lines between readings.
fn followed(samples: &[Sample], sensor: usize, lag_s: f64) -> Vec<f64> {
    let mut follower = samples[0].readings_c[sensor];
    let mut followed = vec![follower];
    for pair in samples.windows(2) {
        let (from, to) = (pair[0].readings_c[sensor], pair[1].readings_c[sensor]);
        let step_s = pair[1].time_s - pair[0].time_s;
        let behind = lag_s * (to - from) / step_s;
        let kept = if lag_s > 0.0 { (-step_s / lag_s).exp() } else { 0.0 };
        follower = to - behind + (follower - from + behind) * kept;
        followed.push(follower);
    }
    followed
}

/// A sensor by its index and the lag with which it is followed, s.
type Term = (usize, f64);

/// Coefficients of terms.
struct Fit {
    terms: Vec<Term>,
    um_per_k: Vec<f64>,
    squares: f64,
}

/// The best coefficients for given terms; a constant takes what the first readings were off.
fn fit(samples: &[Sample], drift_um: &[f64], terms: &[Term]) -> Fit {
    let columns: Vec<Vec<f64>> = terms.iter().map(|&(sensor, lag_s)| followed(samples, sensor, lag_s)).collect();
    let design = DMatrix::from_fn(drift_um.len(), terms.len() + 1, |row, column| {
        columns.get(column).map_or(1.0, |readings| readings[row] - readings[0])
    });
    let measured = DVector::from_column_slice(drift_um);
    let normal = design.tr_mul(&design).cholesky().unwrap();
    let solution = normal.solve(&design.tr_mul(&measured));
    let squares = (design * &solution - measured).norm_squared();
    Fit { terms: terms.to_vec(), um_per_k: solution.as_slice()[..terms.len()].to_vec(), squares }
}

/// A machine file with the drifts in Y and Z as speeds at random show them, each with the best of some choices of terms.
fn learned(choices: &[Vec<Term>]) -> String {
    let random = &mut Random(5);
    let samples = run(&random_speeds(random), 20.0, SENSOR_NOISE_K, random);
    let mut text = MACHINE.to_owned();
    for (index, direction) in [(1, 'Y'), (2, 'Z')] {
        for z_mm in POSITIONS_MM {
            let drift_um: Vec<f64> = samples
                .iter()
                .map(|sample| drift_um(sample, &samples[0], z_mm)[index] + gauss(random, TRANSDUCER_UM))
                .collect();
            let fits = choices.iter().map(|terms| fit(&samples, &drift_um, terms));
            let best = fits.min_by(|one, other| one.squares.total_cmp(&other.squares)).unwrap();
            write!(text, "[[drift]]\ndirection = \"{direction}\"\nover = \"Z\"\nat_mm = {z_mm}\nsensors = [").unwrap();
            for ((sensor, lag_s), um_per_k) in best.terms.iter().zip(best.um_per_k) {
                write!(text, "{{ name = \"{}\", um_per_K = {um_per_k}, lag_s = {lag_s} }}, ", SENSORS[*sensor])
                    .unwrap();
            }
            text += "]\n";
        }
    }
    text
}

fn load(text: &str) -> (Machine, ErrorModel) {
    let (machine, findings) = file::load(&Source::new(FileId(0), "warm.toml", text.as_bytes().to_vec()).unwrap());
    assert!(findings.is_empty(), "{findings:#?}");
    machine.unwrap()
}

/// A machine with the drift that speeds at random have shown, each sensor with a lag.
pub(crate) fn statistical() -> (Machine, ErrorModel) {
    load(&learned(&[vec![(0, 525.0), (1, 600.0)]]))
}

/// What the machine would write down: the sensors of the statistical model; `T_L1` … lower and `T_U1` … upper end of the column, `T_B1` … and
/// `T_S1` … head at the column and at the spindle, each in the order of the plant.
pub(crate) fn log_of(samples: &[Sample]) -> Condition {
    let mut text = "t_s".to_owned();
    let ends = ["L", "U", "B", "S"].into_iter().flat_map(|end| (1..=4).map(move |corner| format!("T_{end}{corner}")));
    for sensor in SENSORS.map(str::to_owned).into_iter().chain(ends) {
        write!(text, ",{sensor}_C").unwrap();
    }
    for sample in samples {
        write!(text, "\n{}", sample.time_s).unwrap();
        let corners = sample.column_corners_c.as_flattened().iter().chain(sample.head_corners_c.as_flattened());
        for reading in sample.readings_c.iter().chain(corners) {
            write!(text, ",{reading:.2}").unwrap();
        }
    }
    let (condition, findings) = log::load(&Source::new(FileId(1), "log.csv", text.into_bytes()).unwrap());
    assert!(findings.is_empty(), "{findings:#?}");
    condition.unwrap()
}

/// The drift since the first reading as ncfix predicts it at each sample, µm.
pub(crate) fn predicted_um(machine: &(Machine, ErrorModel), samples: &[Sample], z_mm: f64) -> Vec<Vector> {
    let mut condition = log_of(samples);
    condition.set_zero_at(0.0);
    let mut command = AxisVector::ZERO;
    command.set_xyz(Vector::new(350.0, 250.0, 0.0));
    command[Axis::Z] = z_mm;
    let predict = |sample: &Sample| {
        condition.set_time(sample.time_s);
        let model = Model::at(&machine.0, &machine.1, &condition);
        1e3 * model.tip_error_mm(&command, &command, &Vector::new(0.0, 0.0, -TOOL_MM), &State::default())
    };
    samples.iter().map(predict).collect()
}

/// Efficiency, %, largest drift and largest rest, µm, of one direction.
#[derive(Debug)]
struct Score {
    efficiency: f64,
    drift_um: f64,
    rest_um: f64,
}

/// How well a machine file predicts a run that was not learned from, in X, Y and Z.
fn scores(text: &str, z_mm: f64, noise_k: f64) -> [Score; 3] {
    let samples = run(&din_8602(), 22.0, noise_k, &mut Random(77));
    let predicted = predicted_um(&load(text), &samples, z_mm);
    [0, 1, 2].map(|index| {
        let measured: Vec<f64> = samples.iter().map(|sample| drift_um(sample, &samples[0], z_mm)[index]).collect();
        let simulated: Vec<f64> = predicted.iter().map(|drift_um| drift_um[index]).collect();
        let rest = measured.iter().zip(&simulated).map(|(measured, simulated)| measured - simulated);
        let largest =
            |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, |largest: f64, value| largest.max(value.abs()));
        Score {
            efficiency: efficiency(&measured, &simulated),
            drift_um: largest(&mut measured.iter().copied()),
            rest_um: largest(&mut rest.into_iter()),
        }
    })
}

#[test]
fn the_statistical_model_predicts_a_spectrum_that_it_has_not_seen() {
    let mut lagged = Vec::new();
    for head_lag_s in (1..=20).map(|step| 75.0 * f64::from(step)) {
        for column_lag_s in [0.0, 600.0, 1200.0, 2400.0] {
            lagged.push(vec![(0, head_lag_s), (1, column_lag_s)]);
        }
    }
    let also_direct: Vec<Vec<Term>> = lagged.iter().map(|terms| [&[(0, 0.0)], terms.as_slice()].concat()).collect();
    let [plain, lagged, both] = [&[vec![(0, 0.0), (1, 0.0)]], lagged.as_slice(), &also_direct].map(learned);
    // Between the positions that were measured, too: drift over Z is a parabola there, a chord in the model.
    for z_mm in [0.0, 100.0, 200.0, 300.0, 400.0] {
        let [plain, lagged, both] = [&plain, &lagged, &both].map(|text| scores(text, z_mm, SENSOR_NOISE_K));
        let seen = format!("at Z {z_mm}: as read {plain:?}, with lag {lagged:?}, with both {both:?}");
        for (index, drift_um) in [(1, 50.0), (2, 15.0)] {
            let [plain, lagged, both] = [&plain, &lagged, &both].map(|scores| &scores[index]);
            assert!(plain.drift_um > drift_um, "{seen}");
            // The bearing is warm before the head is, so that without a lag the head seems to have expanded already.
            assert!(lagged.efficiency > plain.efficiency + 3.0 && lagged.rest_um < 0.75 * plain.rest_um, "{seen}");
            // The sensor leads by a bearing that is not heated at once either: part of it without lag.
            assert!(both.efficiency > 80.0 && both.rest_um < 5.0, "{seen}");
        }
        // In Z head and column cancel each other to a good part, so that the same rest weighs more.
        assert!(lagged[1].efficiency > 90.0 && lagged[2].efficiency > 70.0, "{seen}");
        assert!(both[1].efficiency > 95.0, "{seen}");
    }
}

/// The structure of the plant, with the coefficient of expansion that tables have for cast iron instead of its own. F's origin is at the nose
/// of the spindle. Corners behind (+Y) and on the left (−X) are on the positive sides.
const STRUCTURE: &str = "\
[[segment]]
name = \"column\"
before = \"Z\"
along = \"Z\"
at_mm = 700
from_mm = [0, 450, -450]
to_mm = [0, 450, 750]
um_per_m_K = 11
across = [0, 1, 0]
across_mm = 400
wide_mm = 400
sensors_from = [\"T_L2\", \"T_L4\", \"T_L3\", \"T_L1\"]
sensors_to = [\"T_U2\", \"T_U4\", \"T_U3\", \"T_U1\"]
[[segment]]
name = \"head\"
before = \"S\"
from_mm = [0, 450, 250]
to_mm = [0, 0, 250]
um_per_m_K = 11
sensors_from = [\"T_B1\"]
sensors_to = [\"T_S1\"]
[[segment]]
name = \"spindle\"
before = \"S\"
from_mm = [0, 0, 250]
to_mm = [0, 0, 0]
um_per_m_K = 11
sensors_from = [\"T_B2\"]
sensors_to = [\"T_S2\"]
";

#[test]
fn the_analytical_model_predicts_it_from_the_structure_alone() {
    for z_mm in [0.0, 150.0, 400.0] {
        let text = format!("{MACHINE}{STRUCTURE}");
        // With the plant's own coefficient and without noise nothing is left but the digits of the log.
        let exact = scores(&text.replace("um_per_m_K = 11\n", "um_per_m_K = 11.5\n"), z_mm, 0.0);
        assert!(exact.iter().all(|score| score.rest_um < 0.4), "at Z {z_mm}: {exact:?}");
        assert!(exact[1].efficiency > 99.0 && exact[2].efficiency > 99.0, "at Z {z_mm}: {exact:?}");
        let [_, y, z] = scores(&text, z_mm, SENSOR_NOISE_K);
        let seen = format!("at Z {z_mm}: {y:?} {z:?}");
        // 4.3 % are the coefficient. The rest is noise of single readings: 0.1 K across the column lift the head by up to 1.4 µm.
        assert!(y.efficiency > 90.0 && y.rest_um < 0.05 * y.drift_um + 3.0, "{seen}");
        assert!(z.efficiency > 65.0 && z.rest_um < 0.05 * z.drift_um + 5.0, "{seen}");
    }
}

#[test]
fn nothing_of_it_is_left_where_the_zero_point_has_just_been_set() {
    let machine = load(&learned(&[vec![(0, 525.0), (1, 600.0)]]));
    let samples = run(&din_8602(), 24.0, SENSOR_NOISE_K, &mut Random(9));
    let mut condition = log_of(&samples);
    let predict = |condition: &Condition| {
        let model = Model::at(&machine.0, &machine.1, condition);
        let command = AxisVector::ZERO;
        model.tip_error_mm(&command, &command, &Vector::zeros(), &State::default()) * 1e3
    };
    let late_s = 7200.0;
    condition.set_time(late_s);
    // From the reference temperature it would be 4 K of the shop and what the spindle has done.
    assert!(predict(&condition).norm() > 40.0);
    condition.set_zero_at(late_s);
    assert_eq!(predict(&condition).norm(), 0.0);
    condition.set_time(late_s + 60.0);
    let minute_um = predict(&condition).norm();
    assert!(minute_um > 0.0 && minute_um < 10.0, "{minute_um}");
}
