//! What is unknown of instruments beside their place: drift, rods, temperatures. Recovered in simulation, and refused where it cannot be told.

use std::fmt::Write as _;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Vector;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::State;
use ncfix_metrology::measure::data::cycles::RepeatCycle;
use ncfix_metrology::measure::data::{DataSet, Free};
use ncfix_metrology::measure::kind::Unknown;

use crate::calibrate::{Bench, at, circles, lines, measurement, named, observation, plates, reading, setup};
use crate::calibrate_recover::check;
use crate::model::{Random, machine};
use crate::support::{Shop, repository};
use serde_json::Value;

/// Lines along each axis, each twice there and back, with a drift of its own in each cycle.
fn drifting() -> Bench {
    let whole = lines();
    let mut set = whole.data[0].clone();
    set.free = vec![Free::Offset, Free::Drift];
    let rows = std::mem::take(&mut set.observations);
    for (group, own) in rows.chunks(22).enumerate() {
        for number in [1, 2] {
            let level = (number == 2).then_some(group);
            let (first, cycle) = (own[0], set.cycles.len());
            set.cycles.push(RepeatCycle { setup: first.setup, target: first.target.unwrap(), number, level });
            for (k, row) in own.iter().enumerate() {
                set.observations.push(ncfix_metrology::measure::data::Observation {
                    cycle: Some((cycle, k as f64 / 21.0 - 0.5)),
                    ..*row
                });
            }
        }
    }
    let parameters = named("EXX1 EXX2 EXX3 EYX2 EZX3 EAX1 EBX1 EBX2 ECX1 EYY1 EYY2 EXY2 EAY1 EBY2 ECY1 EZZ1 EBZ1 EAZ2");
    let is_angle = |target: usize, set: &DataSet| {
        set.targets[target].starts_with("EA")
            || set.targets[target].starts_with("EB")
            || set.targets[target].starts_with("EC")
    };
    let mut bench = Bench::new(machine("wXFYZSt"), parameters, vec![set], 23);
    let mut random = Random(6);
    let set = &bench.data[0];
    let values: Vec<f64> = (set.kind.unknowns)(set)
        .iter()
        .map(|unknown| {
            let target = match *unknown {
                Unknown::Offset(which, _) => which % set.targets.len(),
                Unknown::Drift(cycle) | Unknown::Level(cycle) => set.cycles[cycle].target,
                other => panic!("{other:?}"),
            };
            random.symmetric() * if is_angle(target, set) { 1e-5 } else { 0.02 }
        })
        .collect();
    bench.unknowns[0] = values;
    bench
}

/// Circles with two rods, in a warm shop.
fn rods() -> Bench {
    let mut bench = circles(24, &[1.0, -1.0]);
    let set = &mut bench.data[0];
    set.free = vec![Free::Centre, Free::Rod];
    set.rods = vec!["one".into(), "two".into()];
    for (number, setup) in set.setups.iter_mut().enumerate() {
        (setup.rod, setup.expansion_per_k, setup.temperature_c) = (number % 2, 11.5e-6, Some(26.0));
    }
    bench.unknowns[0].truncate(18);
    bench.unknowns[0].extend([0.031, -0.017]);
    bench
}

#[test]
fn drifts_with_noise() {
    let bench = drifting();
    assert_eq!(bench.lost(), [""; 0]);
    check(&bench, 0.0);
}

#[test]
fn rods_with_noise() {
    let bench = rods();
    assert_eq!(bench.lost(), [""; 0]);
    check(&bench, 0.0);
}

#[test]
fn warm_plates_with_noise() {
    let mut bench = plates();
    for setup in &mut bench.data[0].setups {
        (setup.expansion_per_k, setup.temperature_c) = (11.5e-6, Some(23.0));
        setup.origin_mm = Some(Vector::new(-150.0, -150.0, 20.0));
    }
    check(&bench, 0.0);
    // From another point it grows to another place, which the set-up takes up: nothing of the machine changes.
    let (data, _) = bench.measured(1e-3, 0.0, &mut Random(2));
    let one = bench.fit(&data, false);
    let mut moved = data.clone();
    moved[0].setups.iter_mut().for_each(|setup| setup.origin_mm = Some(Vector::new(80.0, 0.0, 0.0)));
    let other = bench.fit(&moved, false);
    for (one, other) in one.estimates.iter().zip(&other.estimates).take(bench.parameters.len()) {
        assert!((one.value - other.value).abs() < 1e-3 * one.sigma, "{one:?} {other:?}");
    }
    // Counted as cold it looks like a scale: 11.5e-6 · 3 K.
    moved[0].setups.iter_mut().for_each(|setup| setup.expansion_per_k = 0.0);
    let cold = bench.fit(&moved, false);
    let gain = cold.estimates[0].value - one.estimates[0].value;
    assert!((gain + 34.5e-6).abs() < 1e-6 || (gain - 34.5e-6).abs() < 1e-6, "{gain:e}");
}

#[test]
fn a_rod_is_told_from_the_scales_by_one_that_is_calibrated() {
    let mut bench = rods();
    bench.parameters = named("EXX1 EYY1 EZZ1");
    let lost = bench.lost();
    assert_eq!(lost.len(), 1, "{lost:?}");
    assert!(lost[0].starts_with("EZZ1 is not separable from EXX1, EYY1"), "{lost:?}");
    assert!(lost[0].contains("length of the rod one") && lost[0].contains("length of the rod two"), "{lost:?}");
    // A second radius helps only where its rod is known: its file has no free length.
    let one = bench.data[0].clone();
    let smaller = |free: &[Free]| {
        let mut set = one.clone();
        set.free = free.to_vec();
        for setup in &mut set.setups {
            setup.length_mm = 100.0;
        }
        for row in &mut set.observations {
            let tip = row.reading.position.xyz() + row.reading.tool_mm;
            let centre = set.setups[row.setup].centre_mm;
            row.reading.position.set_xyz(centre + (tip - centre) / 1.5 - row.reading.tool_mm);
        }
        set
    };
    bench.data = vec![one.clone(), smaller(&[Free::Centre, Free::Rod])];
    assert_eq!(bench.lost().len(), 1);
    bench.data = vec![one.clone(), smaller(&[Free::Centre])];
    assert_eq!(bench.lost(), [""; 0]);
}

#[test]
fn abbe_offsets_are_taken_out_by_the_angles() {
    // Deviation of X at the arm (0, -80, -200) by hand: k x + (b x)(-200) - (c x)(-80).
    let (k, b, c) = (30e-6, 5e-8, -2e-8);
    let mut set = measurement("direct", &[Free::Offset]);
    set.targets = ["EXX", "EBX", "ECX"].map(str::to_owned).to_vec();
    set.setups.push(setup("", [0.0; 3], 0.0));
    for (target, name) in set.targets.clone().iter().enumerate() {
        for step in 0..=10 {
            let x = 50.0 * f64::from(step);
            let mut row = observation(reading(at(&[('X', x)]), Vector::new(0.0, -80.0, -200.0), State::default()), 0);
            let value = [k * x - 200.0 * b * x + 80.0 * c * x, b * x, c * x][target];
            (row.target, row.component, row.values) =
                (Some(target), Some(name.parse().unwrap()), [Some(value), None, None]);
            set.observations.push(row);
        }
    }
    let bench = Bench::new(machine("wFXYZSt"), named("EXX1 EBX1 ECX1"), vec![set.clone()], 1);
    let found = bench.fit(&[set.clone()], false);
    for (estimate, expected) in found.estimates.iter().zip([k, b, c]) {
        assert!((estimate.value / expected - 1.0).abs() < 1e-4, "{estimate:?} is not {expected:e}");
    }
    // Without the angles the slope at the arm would be the machine's.
    let mut alone = bench.clone();
    alone.parameters = named("EXX1");
    set.observations.retain(|row| row.target == Some(0));
    let slope = alone.fit(&[set], false).estimates[0].value;
    assert!((slope - (k - 200.0 * b + 80.0 * c)).abs() < 1e-9, "{slope:e}");
}

const MACHINE: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\n\
    direction = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n";

fn load(columns: &str, rows: &str, description: &str) -> (Option<DataSet>, Vec<Diagnostic>) {
    let source = |name: &str, text: &str| Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap();
    let machine = ncfix_model::file::load(&source("m.toml", MACHINE)).0.unwrap().0;
    ncfix_metrology::measure::data::load(
        "a",
        &source("a.csv", &format!("{columns}\n{rows}")),
        &source("a.toml", description),
        &machine,
    )
}

/// The only finding: code and message.
fn refusal(columns: &str, rows: &str, description: &str) -> String {
    let (data, findings) = load(columns, rows, description);
    assert!(data.is_none());
    assert_eq!(findings.len(), 1, "{findings:?}");
    format!("{}: {}", findings[0].code, findings[0].message)
}

/// Readings of EXX there and back, three cycles: a parabola, a drift for each reading, a reversal, and a ripple for noise.
fn cycles_csv(reversal_um: f64, drift_um: f64) -> String {
    let mut text = String::new();
    for cycle in 0..3 {
        for step in 0..22_i32 {
            let (k, sense) = if step < 11 { (step, 1) } else { (21 - step, -1) };
            let ripple = 0.2 * f64::from((step * 7 + cycle * 3) % 5 - 2);
            let value =
                0.1 * f64::from(k * k) + drift_um * f64::from(step) + 0.5 * f64::from(sense) * reversal_um + ripple;
            writeln!(text, "r,{},0,0,{sense},EXX,{value:.4}", 50 * k).unwrap();
        }
    }
    text
}

const DRIFT: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\", \"drift\"]\n";
const COLUMNS: &str = "run,X,Y,Z,X_dir,component,value_um";

#[test]
fn cycles_are_found_by_the_order_of_the_rows() {
    let (data, findings) = load(COLUMNS, &cycles_csv(0.0, 1.0), DRIFT);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    let numbers: Vec<(usize, Option<usize>)> = data.cycles.iter().map(|cycle| (cycle.number, cycle.level)).collect();
    assert_eq!(numbers, [(1, None), (2, Some(0)), (3, Some(1))]);
    assert_eq!(data.observations[0].cycle, Some((0, -0.5)));
    assert_eq!(data.observations[21].cycle, Some((0, 0.5)));
    assert_eq!(data.observations[22].cycle, Some((1, -0.5)));
    // Zero, three drifts, zeros of two further cycles.
    assert_eq!((data.kind.unknowns)(&data).len(), 6);
    // The times of the readings, where the table has them: the turn takes as long as all the rest.
    let timed: String = cycles_csv(0.0, 0.0)
        .lines()
        .enumerate()
        .map(|(k, line)| format!("{line},{}\n", k + if k % 22 < 11 { 0 } else { 21 } + 100 * (k / 22)))
        .collect();
    let (data, findings) = load(&format!("{COLUMNS},t_s"), &timed, DRIFT);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    assert_eq!(data.observations[11].cycle, Some((0, 32.0 / 42.0 - 0.5)));
}

#[test]
fn a_drift_is_only_taken_out_where_there_is_no_reversal() {
    let found = refusal(COLUMNS, &cycles_csv(4.0, 1.0), DRIFT);
    assert!(found.starts_with("E0613: the two directions of EXX differ by a reversal value of"), "{found}");
    let one_way: String = cycles_csv(0.0, 1.0).lines().take(11).map(|line| format!("{line}\n")).collect();
    assert!(refusal(COLUMNS, &one_way, DRIFT).contains("are in one direction only"));
    assert!(refusal(COLUMNS, &cycles_csv(0.0, 1.0), &DRIFT.replace("\"offset\", ", "")).contains("moves the zero"));
    // What the model has is no drift either.
    let shop = Shop::new()
        .file("start.toml", MACHINE)
        .file("line.csv", format!("{COLUMNS}\n{}", cycles_csv(0.0, 1.0)))
        .file("line.toml", DRIFT)
        .file("with.txt", "EXX1\nEXX2\nEXXb\n")
        .file("without.txt", "EXX1\nEXX2\n");
    let with =
        |model: &'static str| ["calibrate", "line.csv", "--machine", "start.toml", "--model", model, "-o", "m.toml"];
    shop.run(with("with.txt")).exits(4).says("E0613").says("EXXb");
    let report = shop.run(with("without.txt").into_iter().chain(["--json"])).exits(0).json();
    let value = |name: &str| {
        let all = report["parameters"].as_array().unwrap().iter().chain(report["unknowns"].as_array().unwrap());
        all.clone().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{report}"))["value"].as_f64().unwrap()
    };
    // 0.1 µm (x / 50 mm)² is 40 µm/m², and 21 µm within a cycle.
    assert!((value("EXX2") - 40.0).abs() < 2.0, "{report}");
    assert!((value("drift of EXX in cycle 2") - 21.0).abs() < 0.5, "{report}");
    let backlash = format!("{MACHINE}[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = 6.0\n");
    let shop = shop.file("start.toml", backlash);
    shop.run(with("without.txt")).exits(4).says("E0613").says("EXX");
    // A diagnosis cannot separate them either.
    shop.run(["diagnose", "line.csv", "--machine", "start.toml"]).exits(4).says("E0613").says("backlash in EXX");
}

#[test]
fn contradictions_of_a_description_are_found() {
    let rows = "A,0,0,0,1\nA,100,0,0,2\n";
    let bar = |free: &str, setup: &str| {
        format!("[measurement]\nkind = \"ballbar\"\nfree = [{free}]\n[setup.A]\nlength_mm = 100\n{setup}\n")
    };
    let of = |free: &str, setup: &str| refusal("setup,X,Y,Z,dr_um", rows, &bar(free, setup));
    assert!(of("\"rod\", \"length\"", "").contains("E0404: a length for every set-up and one for every rod"));
    assert!(of("\"rod_temperature\", \"rod\"", "rod_expansion_per_K = 1e-5").contains("cannot be separated"));
    assert!(of("\"rod_temperature\"", "").contains("needs its expansion"));
    assert!(of("", "rod = \"150\"\n[setup.B]\nlength_mm = 150\nrod = \"150\"").contains("differ in length_mm"));
    assert!(of("", "rod_temperature_C = 22").contains("has no effect without an expansion"));
    assert!(of("", "rod_expansion_per_K = 1e-5").contains("no temperature"));
    let warm = refusal("X,Y,Z,dr_um,T_rod_C", "0,0,0,1,22\n", &bar("", ""));
    assert!(warm.contains("E0602: T_rod_C has no effect without an expansion"), "{warm}");
    let hot = refusal("X,Y,Z,dr_um,T_rod_C", "0,0,0,1,2200\n", &bar("", "rod_expansion_per_K = 1e-5"));
    assert!(hot.contains("E0603: 2200 °C"), "{hot}");
}

#[test]
fn temperatures_of_rows_make_rods_and_artefacts_longer() {
    let description = "[measurement]\nkind = \"ballbar\"\n[setup.A]\nlength_mm = 150\nrod_expansion_per_K = 12e-6\nrod_temperature_C = 21\n";
    let (data, findings) = load("X,Y,Z,dr_um,T_rod_C", "150,0,0,0,30\n0,150,0,0,\n", description);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    // 12e-6 · 10 K in the row that says so, 12e-6 · 1 K in the other.
    assert!((data.stretch(&data.observations[0]) - 1.000_12).abs() < 1e-15);
    assert!((data.stretch(&data.observations[1]) - 1.000_012).abs() < 1e-15);
    let description =
        "[measurement]\nkind = \"displacement\"\n[artefact]\nexpansion_per_K = 10e-6\ntemperature_C = 25\n";
    let (data, findings) = load("X,Y,Z,dx_um", "100,7,0,0\n300,0,0,0\n", description);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    assert!((data.stretch(&data.observations[0]) - 1.000_05).abs() < 1e-15);
    assert_eq!(data.setups[0].origin_mm, Some(Vector::new(100.0, 7.0, 0.0)));
}

#[test]
fn a_copied_row_is_found_wherever_it_stands() {
    let description = "[measurement]\nkind = \"displacement\"\n";
    let of = |columns: &str, rows: &str| refusal(&format!("X,Y,Z,{columns}"), rows, description);
    let good = |columns: &str, rows: &str| load(&format!("X,Y,Z,{columns}"), rows, description).0.is_some();
    let timed = "0,0,0,1.5,1\n5,0,0,2.5,2\n9,0,0,0,3\n0,0,0,1.5,";
    let found = of("dx_um,t_s", &format!("{timed}1\n"));
    assert!(found.starts_with("E0605") && found.contains("line 2"), "{found}");
    // At another time it is a repetition.
    assert!(good("dx_um,t_s", &format!("{timed}4\n")));
    // Three values that are the same are a copy without a time too; one may be read again on the way back, but not on the same way.
    let three = of("dx_um,dy_um,dz_um", "0,0,0,1.5,2,3\n5,0,0,2.5,2,3\n9,0,0,0,1,1\n0,0,0,1.5,2,3\n");
    assert!(three.starts_with("E0605") && three.contains("line 2"), "{three}");
    let one = "5,0,0,2.5,1\n9,0,0,0,1\n5,0,0,2.5,";
    assert!(good("dx_um,X_dir", &format!("{one}-1\n")) && good("dx_um", "1,0,0,0\n5,0,0,2.5\n9,0,0,0\n5,0,0,2.5\n"));
    assert!(of("dx_um,X_dir", &format!("{one}1\n")).starts_with("E0605"));
}

/// Without a run and without senses: two set-ups, in each twice there and back, the first position of a cycle where the last one ended.
#[test]
fn cycles_begin_with_each_set_up() {
    let mut rows = String::new();
    for setup in ["A", "B"] {
        for (row, x) in
            [0, 100, 200, 300, 400, 500, 500, 400, 300, 200, 100, 0].into_iter().cycle().take(24).enumerate()
        {
            writeln!(rows, "{x},0,0,EXX,{},{setup}", 0.01 * f64::from(x) + 0.1 * row as f64).unwrap();
        }
    }
    let (data, findings) = load("X,Y,Z,component,value_um,setup", &rows, DRIFT);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    assert_eq!(
        data.cycles.iter().map(|cycle| (cycle.setup, cycle.number)).collect::<Vec<_>>(),
        [(0, 1), (0, 2), (1, 1), (1, 2)]
    );
    let of_row: Vec<usize> = data.observations.iter().map(|row| row.cycle.unwrap().0).collect();
    assert_eq!(of_row, (0..48).map(|row| row / 12).collect::<Vec<_>>());
}

#[test]
fn a_ball_has_no_distance_from_itself() {
    let description = "[measurement]\nkind = \"probe\"\n[[length]]\nfrom = \"a\"\nto = \"a\"\nvalue_mm = 50\n";
    let found = refusal("X,Y,Z,target", "0,0,0,a\n0,0,1,a\n", description);
    assert!(found.starts_with("E0404") && found.contains("distance of a ball from itself"), "{found}");
}

/// Stylus and spindle are both unknown: turning the spindle tells them.
#[test]
fn a_spindle_that_turns_tells_the_stylus_from_the_spindle() {
    let bench = crate::calibrate::samba(named("EX0S EY0S EX0C EXX1"), true);
    assert_eq!(bench.lost(), [""; 0]);
    let mut still = bench.clone();
    still.data[0].observations.iter_mut().for_each(|row| row.spindle_rad = 0.0);
    let lost = still.lost();
    assert_eq!(lost.len(), 1, "{lost:?}");
    assert!(["EX0S", "EY0S", "the tool"].iter().all(|name| lost[0].contains(name)), "{lost:?}");
    let (data, _) = bench.measured(0.0, 0.0, &mut Random(1));
    let found = bench.fit(&data, false);
    for (estimate, truth) in found.estimates.iter().zip(bench.truth()) {
        assert!((estimate.value - truth).abs() < 1e-9, "{}", estimate.column.name(&data));
    }
}

/// One ball, chased: a preset of five axes on poses of both rotary axes.
#[test]
fn a_ball_that_is_chased_tells_location_errors() {
    let mut bench = crate::calibrate::rumba(named("EX0C EY0C EA0C EB0C EB0A EC0A EY0A"));
    let set = &mut bench.data[0];
    set.observations.retain(|row| row.target == Some(0));
    set.targets.truncate(1);
    set.free.clear();
    bench.unknowns[0].truncate(3);
    let lost = bench.lost();
    // One ball does not tell how high the axes are tilted: whatever is told comes back.
    let is_lost = |name: &str| lost.iter().any(|sentence| sentence.starts_with(name));
    bench.parameters.retain(|name| !is_lost(&name.to_string()));
    assert!(bench.parameters.len() >= 5, "{lost:?}");
    bench.errors = crate::calibrate::errors(&bench.parameters, 0.03, &mut Random(4));
    let (data, _) = bench.measured(0.0, 0.0, &mut Random(1));
    let found = bench.fit(&data, false);
    for (estimate, truth) in found.estimates.iter().zip(bench.truth()) {
        assert!((estimate.value - truth).abs() < 1e-9, "{}", estimate.column.name(&data));
    }
}

#[test]
fn lengths_and_angles_of_a_file_have_figures_of_their_own() {
    let mut rows = String::new();
    for step in 0..11 {
        let x = 50 * step;
        // 30 µm/m and 20 µrad/m, with ripples of 0.5 µm and 0.2 µrad.
        let sign = if step % 2 == 0 { 1.0 } else { -1.0 };
        let (length, angle) = (0.03 * f64::from(x) + 0.5 * sign, 0.02 * f64::from(x) + 0.2 * sign);
        writeln!(rows, "{x},0,0,EXX,{length:.4},\n{x},0,0,EBX,,{angle:.4}").unwrap();
    }
    let shop = Shop::new()
        .file("start.toml", MACHINE)
        .file("line.csv", format!("X,Y,Z,component,value_um,value_urad\n{rows}"))
        .file("line.toml", "[measurement]\nkind = \"direct\"\nsigma_um = 0.5\nsigma_urad = 0.2\nfree = [\"offset\"]\n")
        .file("model.txt", "EXX1\nEBX1\n");
    let run = shop.run([
        "calibrate",
        "line.csv",
        "--machine",
        "start.toml",
        "--model",
        "model.txt",
        "-o",
        "m.toml",
        "--json",
    ]);
    let report = run.exits(0).json();
    let data = report["data"].as_array().unwrap();
    assert_eq!(data.len(), 2, "{report}");
    for (one, (unit, ripple)) in data.iter().zip([("µm", 0.5), ("µrad", 0.2)]) {
        assert_eq!((one["unit"].as_str().unwrap(), one["readings"].as_u64().unwrap()), (unit, 11));
        let left = one["left_rms"].as_f64().unwrap();
        assert!(left < 1.01 * ripple && left > 0.9 * ripple, "{one}");
        assert!((one["sigma"].as_f64().unwrap() - ripple).abs() < 1e-9, "{one}");
    }
    let zero = report["unknowns"].as_array().unwrap().iter().find(|one| one["name"] == "zero of EBX").unwrap();
    assert_eq!(zero["unit"], "µrad");
    assert!(repository("docs/reference/figures.md").exists());
}

/// A bow of 4 um over 700 mm, read on a straightedge that is 50 urad off the axis.
#[test]
fn the_alignment_of_a_straightness_is_no_error_of_the_machine() {
    let machine = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
        [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n";
    let mut random = Random(3);
    let mut rows = String::from("run,component,X,Y,Z,X_dir,tool_z_mm,value_um\n");
    for run in 0..4 {
        for place in 0..=20 {
            let x = 35.0 * f64::from(place);
            let bow = 4.0 * (1.0 - ((x - 350.0) / 350.0).powi(2));
            let value = bow + 0.05 * x + 1.7 + 0.4 * random.symmetric();
            rows += &format!("{run},EYX,{x},250,200,1,-60,{value:.3}\n");
        }
    }
    let describe = |free: &str| format!("[measurement]\nkind = \"direct\"\nfree = {free}\nsigma_um = 0.3\n");
    let shop = Shop::new().file("m.toml", machine).file("line.csv", rows);
    let shop = shop
        .file("line.toml", describe("[\"offset\", \"slope\"]"))
        .file("slope.txt", "EYX1\nEYX2\n")
        .file("bow.txt", "EYX2\n");
    let run = shop.run(["calibrate", "line.csv", "--machine", "m.toml", "--model", "slope.txt", "-o", "no.toml"]);
    assert!(run.code != 0 && run.stderr.contains("EYX1 is not separable from alignment of EYX"), "{run:?}");
    let run = shop
        .run(["calibrate", "line.csv", "--machine", "m.toml", "--model", "bow.txt", "-o", "bow.toml", "--json"])
        .exits(0);
    // 4 um at half of the travel, 0.35 m: -4 / 0.35^2 um/m^2.
    let json = run.json();
    let found = json["parameters"].as_array().unwrap().iter().find(|one| one["name"] == "EYX2").unwrap();
    let expected = -4.0 / 0.35_f64.powi(2);
    assert!((found["value"].as_f64().unwrap() / expected - 1.0).abs() < 0.1, "{found}");
    let json = shop.run(["diagnose", "line.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let size = |json: &Value| json["findings"][0]["value"].as_f64().unwrap();
    assert!((size(&json) - 4.0).abs() < 0.5, "{}", json["findings"]);
    // Against a square the slope of 35 um is in it.
    let shop = shop.file("line.toml", describe("[\"offset\"]\nreference = \"square\""));
    let json = shop.run(["diagnose", "line.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    assert!(size(&json) > 20.0, "{}", json["findings"]);
    let shop = shop.file("line.toml", describe("[\"slope\"]"));
    let run = shop.run(["diagnose", "line.csv", "--machine", "m.toml"]);
    assert!(run.code != 0 && run.stderr.contains("\"offset\", \"slope\""), "{run:?}");
}

/// A reading of a squareness itself is moved by the squareness alone, by its other name with the opposite sign (X and Y on two sides of F), and by no
/// displacement of the tool.
#[test]
fn a_reading_of_a_location_error_shows_this_error_alone() {
    use ncfix_metrology::diagnose::Scene;
    use ncfix_metrology::diagnose::scene::Through;
    use ncfix_metrology::measure::data::load;

    let text = "[machine]\nname = \"m\"\ntopology = \"wYFXZSt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\ndirection = [0, -1, 0]\n\
        [axis.Z]\ndirection = [0, 0, 1]\n[location]\nEC0X = 5.0\n";
    let source = |name: &str, text: &str| Source::new(FileId(0), name, text.as_bytes().to_vec()).unwrap();
    let (machine, errors) = ncfix_model::file::load(&source("m.toml", text)).0.unwrap();
    let table =
        source("s.csv", "component,X,Y,Z,value_urad,value_um\nEC0X,300,200,0,60,\nEC0Y,0,0,0,-61,\nEXX,500,0,0,,4\n");
    let description = source("s.toml", "[measurement]\nkind = \"direct\"\nsigma_urad = 2\nsigma_um = 1\n");
    let (data, findings) = load("s", &table, &description, &machine);
    assert!(findings.is_empty(), "{findings:#?}");
    let sets = [data.unwrap()];
    let scene = Scene::new(&machine, &errors, &sets).unwrap();
    let left: Vec<f64> = scene.items.iter().map(|item| (item.left * 1e9).round() / 1e3).collect();
    // 60 − 5, and −61 + 5: the machine file has 5 µrad.
    assert_eq!(left[..2], [55.0, -56.0]);
    let factors = |through| scene.factors(through)[..2].to_vec();
    assert_eq!(factors(Through::Component("EC0X".parse().unwrap())), [1.0, -1.0]);
    assert_eq!(factors(Through::Component("EC0Y".parse().unwrap())), [-1.0, 1.0]);
    for other in ["EA0Z", "ECX", "EXX"] {
        assert_eq!(factors(Through::Component(other.parse().unwrap())), [0.0, 0.0], "{other}");
    }
    assert_eq!(factors(Through::Tip(0)), [0.0, 0.0]);
}
