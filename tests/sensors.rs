//! Selection of sensors for thermal drift, on the machine that warms up: exact, honest on runs it has not seen, and loaded by the model again.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::{Condition, Machine, State};
use ncfix_metrology::calibrate::sensors::data::{SensorRun, over, read};
use ncfix_metrology::calibrate::sensors::{SelectionOptions, SensorSelection, Shrinkage, SubsetSize, select, text};
use ncfix_model::{ErrorModel, Model, file};

use crate::bench_machine::Random;
use crate::support::Shop;
use crate::thermal_plant::{SENSOR_NOISE_K, Sample, Stage, TOOL_MM, din_8602, drift_um, gauss, random_speeds, run};

const MACHINE: &str = "[machine]\nname = \"warm\"\ntopology = \"wXYFZSt\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
const PLAIN: SelectionOptions = SelectionOptions { most: 9, lags: false, shrinkage: Shrinkage::ReadingError(0.0) };

fn source(name: &str, text: &str) -> Source {
    Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap()
}

fn machine(text: &str) -> (Machine, ErrorModel) {
    let (machine, findings) = file::load(&source("warm.toml", text));
    assert!(findings.is_empty(), "{findings:#?}");
    machine.unwrap()
}

/// A table as a person would record it: the sensors of the plant, those in the corners, and `idle` ones that follow slow waves of their own.
fn table(samples: &[Sample], z_mm: &[f64], idle: usize, random: &mut Random) -> String {
    let mut out = "t_s,Z,dx_um,dy_um,dz_um,T_head_C,T_column_C".to_owned();
    (0..16).for_each(|k| write!(out, ",T_c{k}_C").unwrap());
    (0..idle).for_each(|k| write!(out, ",T_idle{k}_C").unwrap());
    let waves: Vec<[f64; 3]> = (0..idle)
        .map(|_| [random.between(0.5, 2.0), random.between(1500.0, 30_000.0), random.between(0.0, 6.0)])
        .collect();
    for sample in samples {
        for &z in z_mm {
            let [x, y, up] = drift_um(sample, &samples[0], z).map(|um| um + gauss(random, 0.5));
            write!(out, "\n{},{z},{x:.3},{y:.3},{up:.3}", sample.time_s).unwrap();
            let corners = sample.column_corners_c.as_flattened().iter().chain(sample.head_corners_c.as_flattened());
            sample.readings_c.iter().chain(corners).for_each(|reading| write!(out, ",{reading:.3}").unwrap());
            for [size, period_s, phase] in &waves {
                let slow = size * (TAU * sample.time_s / period_s + phase).sin();
                write!(out, ",{:.3}", 20.0 + slow + gauss(random, SENSOR_NOISE_K)).unwrap();
            }
        }
    }
    out + "\n"
}

fn recorded(stages: &[Stage], z_mm: &[f64], idle: usize, seed: u64) -> (SensorRun, Vec<Sample>) {
    let random = &mut Random(seed);
    let samples = run(stages, 20.0, SENSOR_NOISE_K, random);
    let text = table(&samples, z_mm, idle, random);
    (read(&source("run.csv", &text), None, &machine(MACHINE).0).unwrap(), samples)
}

fn random_run(idle: usize, seed: u64) -> (SensorRun, Vec<Sample>) {
    recorded(&random_speeds(&mut Random(seed)), &[200.0], idle, seed + 1)
}

/// Efficiency of what ncfix predicts with the entries, on a run, at Z.
fn predicted(entries: &str, run: &SensorRun, samples: &[Sample], z_mm: f64, direction: usize) -> f64 {
    let (machine, errors) = machine(&format!("{MACHINE}{entries}"));
    let mut condition: Condition = run.condition.clone();
    condition.set_zero_at(samples[0].time_s);
    let mut command = AxisVector::ZERO;
    command.set_xyz(Vector::new(350.0, 250.0, z_mm));
    let (mut off, mut whole) = (0.0, 0.0);
    for sample in samples {
        condition.set_time(sample.time_s);
        let model = Model::at(&machine, &errors, &condition);
        let tool = Vector::new(0.0, 0.0, -TOOL_MM);
        let simulated = 1e3 * model.tip_error_mm(&command, &command, &tool, &State::default())[direction];
        let measured = drift_um(sample, &samples[0], z_mm)[direction];
        off += (measured - simulated).abs();
        whole += measured.abs();
    }
    1.0 - off / whole
}

fn model(selection: &SensorSelection) -> &SubsetSize {
    selection.model().unwrap()
}

#[test]
fn what_is_written_loads_and_predicts_a_run_that_it_has_not_seen() {
    let positions = [0.0, 200.0, 400.0];
    let (learned, _) = recorded(&random_speeds(&mut Random(5)), &positions, 4, 6);
    let (other, samples) = recorded(&din_8602(), &positions, 4, 8);
    let (runs, others) = (vec![learned], vec![other]);
    let (axis, found) = over(&runs).unwrap().unwrap();
    assert_eq!((axis, found.as_slice()), (Axis::Z, &positions[..]));
    for (lags, least) in [(false, 0.88), (true, 0.93)] {
        let options = SelectionOptions { most: 4, lags, ..PLAIN };
        let selections: Vec<SensorSelection> =
            positions.iter().filter_map(|&z| select(&runs, &others, 1, Some((Axis::Z, z)), &options)).collect();
        let entries = text::entries(&selections);
        assert_eq!(entries.matches("[[drift]]").count(), 3, "{entries}");
        assert_eq!(entries.contains("lag_s"), lags, "{entries}");
        for z_mm in [0.0, 100.0, 400.0] {
            let efficiency = predicted(&entries, &others[0], &samples, z_mm, 1);
            assert!(efficiency > least, "Z {z_mm}, lags {lags}: {efficiency} of {entries}");
        }
    }
}

#[test]
fn too_many_sensors_tell_the_data_better_and_another_run_worse() {
    // A short run, and many sensors that have nothing to do with it (fig. 5.6 of the thesis).
    let stages: Vec<Stage> = random_speeds(&mut Random(21)).into_iter().take(9).collect();
    let (short, _) = recorded(&stages, &[200.0], 22, 22);
    let (other, _) = random_run(22, 31);
    let options = SelectionOptions { most: 12, ..PLAIN };
    let found = select(&[short], &[other], 2, Some((Axis::Z, 200.0)), &options).unwrap();
    assert_eq!(found.sizes.len(), 12);
    assert!(found.sizes.iter().all(|size| size.is_exact));
    let best = found.sizes.iter().map(|size| size.independent).fold(f64::MIN, f64::max);
    let last = &found.sizes[11];
    let chosen = model(&found);
    let seen: Vec<[f64; 2]> = found.sizes.iter().map(|size| [size.efficiency, size.independent]).collect();
    assert!(last.efficiency > chosen.efficiency && last.independent < best - 0.05, "{seen:?}");
    assert!(chosen.independent > best - 0.05 && chosen.terms.len() <= 6, "{seen:?}");
    assert!(chosen.terms.iter().all(|term| !term.sensor.contains("idle")), "{chosen:?}");
}

#[test]
fn cp_of_all_sensors_is_their_number() {
    // Three sensors and the offset of the one run: Cp = SSE/MSE + 2 · 4 − n with MSE = SSE/(n − 4).
    let random = &mut Random(3);
    let samples = run(&din_8602(), 20.0, SENSOR_NOISE_K, random);
    let mut text = "t_s,dy_um,A_C,B_C,C_C".to_owned();
    for sample in &samples {
        let um = drift_um(sample, &samples[0], 0.0)[1];
        let [a, b] = sample.readings_c;
        write!(text, "\n{},{um:.3},{a:.3},{b:.3},{:.3}", sample.time_s, 20.0 + gauss(random, 0.3)).unwrap();
    }
    let runs = [read(&source("run.csv", &text), None, &machine(MACHINE).0).unwrap()];
    assert_eq!(over(&runs).unwrap(), None);
    let found = select(&runs, &runs, 1, None, &PLAIN).unwrap();
    assert_eq!(found.sizes.len(), 3);
    assert!((found.sizes[2].cp.unwrap() - 4.0).abs() < 1e-6, "{:?}", found.sizes[2].cp);
    assert!(found.sizes[0].cp.unwrap() > 10.0);
    assert_eq!(found.sizes[1].terms.iter().map(|term| term.sensor.as_str()).collect::<Vec<_>>(), ["A", "B"]);
}

/// Sixteen readings and three waves of ±1 that are orthogonal and have mean zero. The drift is 3a + 2b + e µm; A rises by a, B by b/2 K.
/// The sum of squares of each wave is 16, so that MSE of both sensors is 16/(16 − 3).
#[test]
fn cp_counts_what_shrunk_coefficients_leave_and_cost() {
    let mut text = "t_s,dx_um,A_C,B_C".to_owned();
    for k in 0..16_u32 {
        let [a, b, e] = [1, 2, 4].map(|bit| if k & bit == 0 { -1.0 } else { 1.0 });
        write!(text, "\n{},{},{},{}", 60 * k, 3.0 * a + 2.0 * b + e, 20.0 + a, 20.0 + b / 2.0).unwrap();
    }
    let runs = [read(&source("run.csv", &text), None, &machine(MACHINE).0).unwrap()];
    let cp = |shrinkage| {
        let found = select(&runs, &runs, 0, None, &SelectionOptions { most: 2, shrinkage, ..PLAIN }).unwrap();
        found.sizes.iter().map(|size| size.cp.unwrap()).collect::<Vec<f64>>()
    };
    // Of least squares: 16 · (4 + 1) · 13/16 + 2 · 2 − 16, and the number of coefficients.
    // A reading error of 1 K doubles the square of A, and adds four times its own to that of B: 3 becomes 3/2, and 2 becomes 2/5.
    // Left of one: 16 · (9/4 + 4 + 1) = 116, it costs 1/2. Left of both: 16 · (9/4 + 64/25 + 1) = 92.96, they cost 1/2 + 1/5.
    // One component of both sensors is A alone: B, whose rises are smaller, is left out.
    for (shrinkage, expected) in [
        (Shrinkage::ReadingError(0.0), [53.0, 3.0]),
        (Shrinkage::ReadingError(1.0), [116.0 * 13.0 / 16.0 + 3.0 - 16.0, 92.96 * 13.0 / 16.0 + 3.4 - 16.0]),
        (Shrinkage::Components(1), [53.0, 53.0]),
    ] {
        for (found, expected) in cp(shrinkage).into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-6, "{shrinkage:?}: {found} instead of {expected}");
        }
    }
}

#[test]
fn shrinkage_makes_a_sensor_that_reads_wrong_less_harmful() {
    let (learned, _) = random_run(0, 41);
    let (mut other, samples) = random_run(0, 51);
    let (runs, at) = ([learned], Some((Axis::Z, 200.0)));
    let kinds = [Shrinkage::ReadingError(0.0), Shrinkage::ReadingError(2.0), Shrinkage::Components(2)];
    let [plain, shrunk, components] = kinds.map(|shrinkage| {
        let options = SelectionOptions { most: 6, shrinkage, ..PLAIN };
        // The same six sensors, so that the coefficients can be held against each other.
        let mut found = select(&runs, &[], 2, at, &options).unwrap();
        found.chosen = Some(5);
        found
    });
    let largest = |found: &SensorSelection| {
        let terms = &model(found).terms;
        let worst = terms.iter().max_by(|a, b| a.um_per_k.abs().total_cmp(&b.um_per_k.abs())).unwrap();
        (worst.sensor.clone(), worst.um_per_k.abs())
    };
    let (sensor, steep) = largest(&plain);
    assert!(largest(&shrunk).1 < 0.8 * steep, "{plain:?} {shrunk:?}");
    // That sensor reads 5 K too much after the first quarter.
    let points = other.condition.trace(&sensor).unwrap().points().to_vec();
    let mut condition = Condition::default();
    for name in other.condition.sensors().filter(|name| *name != sensor) {
        condition.set_trace(name, other.condition.trace(name).unwrap().clone());
    }
    for (k, (time_s, value)) in points.iter().enumerate() {
        condition.add_reading(&sensor, *time_s, value + if k > points.len() / 4 { 5.0 } else { 0.0 });
    }
    let sound = [&plain, &shrunk, &components]
        .map(|found| predicted(&text::entries(std::slice::from_ref(found)), &other, &samples, 200.0, 2));
    other.condition = condition;
    let wrong = [&plain, &shrunk, &components]
        .map(|found| predicted(&text::entries(std::slice::from_ref(found)), &other, &samples, 200.0, 2));
    assert!(wrong[1] > wrong[0] + 0.1 && wrong[2] > wrong[0] + 0.05, "{sound:?} {wrong:?}");
    // The price where all readings are right: components cost less than a ridge, and protect less.
    assert!(sound[1] > 0.5 && sound[2] > 0.9 && sound[0] > 0.9, "{sound:?} {wrong:?}");
}

#[test]
fn two_sensors_that_read_nearly_the_same_share_a_component() {
    // Both rise by u; 4 µm/K of the first component are 2 µm/K of each, whatever their small difference correlates with.
    let mut text = "t_s,dx_um,A_C,B_C".to_owned();
    for k in 0..200 {
        let u = 0.05 * f64::from(k);
        let difference = 0.01 * f64::from(k % 2);
        write!(
            text,
            "\n{},{:.3},{:.3},{:.3}",
            60 * k,
            4.0 * u + 0.3 * f64::from(k % 2),
            20.0 + u + difference,
            20.0 + u
        )
        .unwrap();
    }
    let runs = [read(&source("run.csv", &text), None, &machine(MACHINE).0).unwrap()];
    let um_per_k = |shrinkage| {
        let found = select(&runs, &runs, 0, None, &SelectionOptions { most: 2, shrinkage, ..PLAIN }).unwrap();
        found.sizes[1].terms.iter().map(|term| term.um_per_k).collect::<Vec<f64>>()
    };
    // Least squares follows the difference: 0.3 µm of 0.01 K.
    assert!(um_per_k(Shrinkage::ReadingError(0.0))[0] > 20.0);
    for value in um_per_k(Shrinkage::Components(1)) {
        assert!((value - 2.0).abs() < 0.02, "{value}");
    }
}

#[test]
fn what_has_nothing_to_do_with_temperature_has_no_model() {
    let random = &mut Random(61);
    let mut make = || {
        let mut text = "t_s,dx_um,A_C,B_C,C_C,D_C".to_owned();
        let mut slow = [0.0; 5];
        for k in 0..400 {
            slow.iter_mut().for_each(|value| *value = 0.98 * *value + gauss(random, 0.3));
            let [x, a, b, c, d] = slow;
            write!(text, "\n{},{x:.3},{:.3},{:.3},{:.3},{:.3}", 60 * k, 20.0 + a, 20.0 + b, 20.0 + c, 20.0 + d)
                .unwrap();
        }
        read(&source("run.csv", &text), None, &machine(MACHINE).0).unwrap()
    };
    let wrong = (0..20).filter(|_| {
        let (runs, others) = ([make()], [make()]);
        let found = select(&runs, &others, 0, None, &PLAIN).unwrap();
        // A correction that takes off a tenth or more would be believed.
        found.model().is_some_and(|model| model.independent > 0.1)
    });
    assert!(wrong.count() <= 4);
}

#[test]
fn the_command_writes_entries_and_shows_the_choice() {
    let make = |seed: u64| {
        let random = &mut Random(seed);
        let samples = run(&din_8602(), 20.0, SENSOR_NOISE_K, random);
        table(&samples, &[0.0, 400.0], 2, random)
    };
    let shop = Shop::new().file("m.toml", MACHINE).file("a.csv", make(71)).file("b.csv", make(72));
    let arguments = ["sensors", "a.csv", "--machine", "m.toml", "--verify", "b.csv", "--most", "3", "-o", "drift.toml"];
    let page = shop.run(arguments).exits(0).stdout;
    assert!(page.contains("Y at Z400: ") && page.contains("● independent") && page.contains("b.csv"), "{page}");
    let drift = shop.text("drift.toml");
    assert!(drift.matches("[[drift]]").count() >= 4 && drift.contains("at_mm = 400"), "{drift}");
    machine(&format!("{MACHINE}{drift}"));
    let found =
        shop.run(["sensors", "a.csv", "--machine", "m.toml", "--most", "2", "--ridge=1", "--json"]).exits(0).json();
    assert_eq!(found["selections"].as_array().unwrap().len(), 6);
    assert_eq!(found["selections"][2]["direction"], "Y");
    assert!(found["selections"][2]["sizes"][1]["independent_efficiency"].as_f64().unwrap() > 0.5);
}

#[test]
fn tables_that_cannot_be_read_are_refused_with_the_place() {
    let good = "t_s,dx_um,T_a_C\n0,0,20\n60,1,21\n";
    let shop = Shop::new()
        .file("m.toml", MACHINE)
        .file("good.csv", good)
        .file("text.csv", good.replace("60,1,", "60,one,"))
        .file("back.csv", good.replace("60,", "-60,"))
        .file("none.csv", good.replace("dx_um", "dx"))
        .file("cold.csv", good.replace("T_a_C", "T_a"))
        .file("axis.csv", good.replace("dx_um", "dx_um,W").replace(",0,", ",0,5,").replace(",1,", ",1,5,"));
    let many: String = (0..65).map(|k| format!(",T_{k}_C")).collect();
    let shop = shop.file("many.csv", format!("t_s,dx_um{many}\n0,0{}\n", ",20".repeat(65)));
    for (name, code) in [
        ("many.csv", "E0602"),
        ("text.csv", "E0603"),
        ("back.csv", "E0603"),
        ("none.csv", "E0602"),
        ("cold.csv", "E0602"),
        ("axis.csv", "E0602"),
    ] {
        let run = shop.run(["sensors", name, "--machine", "m.toml", "--json", "-o", "out.toml"]).exits(4);
        assert!(run.codes().contains(&code.to_owned()), "{name}: {:?}", run.codes());
    }
    assert!(!shop.names().contains(&"out.toml".to_owned()));
}
