//! Effects of load and temperature from readings in many conditions: readings by formulas of their own, with noise and gross errors, give the
//! parameters back inside their uncertainties.
#![allow(clippy::print_stdout, reason = "shares are worth reading where a test fails")]

use std::fmt::Write as _;

use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::effect::{effect_parameters, named};
use ncfix_metrology::calibrate::{FitOptions, Parameter, equations, fit, quality};
use ncfix_metrology::measure::data::{self, DataSet};
use ncfix_model::{ErrorModel, Sources, file, write};

use crate::model::Random;

/// A measurement with the readings that there would be without noise, mm or rad, and what is to be found.
struct Case {
    machine: Machine,
    start: ErrorModel,
    parameters: Vec<Parameter>,
    truth: Vec<f64>,
    data: DataSet,
    exact: Vec<[Option<f64>; 3]>,
    noise: f64,
}

fn source(number: u16, name: &str, text: &str) -> Source {
    Source::new(FileId(number), name, text.as_bytes().to_vec()).unwrap()
}

pub(crate) fn machine(text: &str) -> (Machine, ErrorModel) {
    let (loaded, findings) = file::load(&source(0, "machine.toml", text));
    assert!(findings.is_empty(), "{findings:?}");
    loaded.unwrap()
}

pub(crate) fn plan(table: &str, description: &str, machine: &Machine) -> DataSet {
    let (data, findings) =
        data::load_plan("plan", &source(1, "plan.csv", table), &source(2, "plan.toml", description), machine);
    assert!(findings.is_empty(), "{findings:?}");
    DataSet { is_plan: false, ..data.unwrap() }
}

fn parameters(errors: &ErrorModel, lines: &str) -> Vec<Parameter> {
    let all = effect_parameters(errors);
    lines
        .split_whitespace()
        .flat_map(|line| match line.parse() {
            Ok(name) => vec![Parameter::Geometry(name)],
            Err(_) => named(&all, line).into_iter().map(Parameter::from).collect(),
        })
        .collect()
}

impl Case {
    fn measured(&self, outliers: f64, random: &mut Random) -> (DataSet, Vec<(usize, usize)>) {
        let mut data = self.data.clone();
        let mut off = Vec::new();
        for (row, (observation, exact)) in data.observations.iter_mut().zip(&self.exact).enumerate() {
            let is_off = random.symmetric() / 2.0 + 0.5 < outliers;
            observation.values = exact.map(|value| {
                let noise = random.normal();
                value.map(|value| value + self.noise * if is_off { 50.0 * noise.signum() } else { noise })
            });
            if is_off {
                off.push((0, row));
            }
        }
        (data, off)
    }

    fn check(&self, outliers: f64) {
        let (mut within, mut near, mut count, mut held_out, mut kept, mut missed) = (0.0, 0.0, 0.0, 0.0, 0.0, 0);
        for seed in 0..200_u64 {
            let mut random = Random(1000 * seed + 3);
            let (data, off) = self.measured(outliers, &mut random);
            let data = [data];
            let options = FitOptions { robust: outliers > 0.0 };
            let found = fit(&self.machine, &self.start, &self.parameters, &data, options)
                .unwrap_or_else(|fault| panic!("{seed}: {fault:?}"));
            for (estimate, truth) in found.estimates.iter().zip(&self.truth) {
                let error = (estimate.value - truth).abs() / estimate.sigma;
                if seed == 0 {
                    println!(
                        "{}: {:e} ± {:e}, true {truth:e}",
                        estimate.column.name(&data),
                        estimate.value,
                        estimate.sigma
                    );
                }
                near += f64::from(u8::from(error < 1.0));
                within += f64::from(u8::from(error < 3.0));
                count += 1.0;
            }
            let rejected = found.rejected();
            missed += off.iter().filter(|row| !rejected.contains(row)).count();
            let good = rejected.iter().filter(|row| !off.contains(row)).count() as f64;
            kept += 1.0 - good / data[0].observations.len() as f64;
            if seed % 20 == 0 {
                let (other, _) = self.measured(0.0, &mut random);
                let left = quality(&self.machine, &found.errors, &other).unwrap().left[0];
                held_out += left / self.noise / 10.0;
            }
        }
        let [near, within, kept] = [near / count, within / count, kept / 200.0];
        println!("outliers {outliers}: within 1σ {near:.4}, 3σ {within:.4}, held out {held_out:.3}, kept {kept:.4}");
        assert!(within >= 0.99, "{within} within 3 σ");
        assert!((0.63..0.73).contains(&near), "{near} within 1 σ");
        assert!((0.9..1.15).contains(&held_out), "held out {held_out}");
        assert!(kept > 0.99, "good rows rejected");
        assert_eq!(missed, 0, "gross errors not rejected");
    }
}

const DIRECT: &str = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n";

/// Eq. 4.1 with the numbers of the sample machine, and the tilt of its table: readings of a level on the table, rad.
pub(crate) fn level(x: f64, force_n: f64, z: f64) -> f64 {
    let beyond = f64::max(x - 350.0, 0.0);
    let curve = 8.575e-5 - 4.9e-7 * x + 7.0e-10 * x * x - 1.4e-9 * beyond * beyond;
    force_n / 4800.0 * ((375.0 - z) / 375.0 * curve - 150e-6 * (300.0 - z) / 300.0)
}

pub(crate) const PLACES: [f64; 3] = [-280.0, 0.0, 280.0];

/// At Y 0, where the coupling of Y with X does nothing.
pub(crate) fn levels() -> String {
    let mut table = "X,Y,Z,B,component,load_N,load_x_mm,load_z_mm\n".to_owned();
    for force in [0, 2400, 4800] {
        for z in PLACES {
            for k in 0..15 {
                let _ = writeln!(table, "{},0,100,0,EAX,{force},0,{z}", 50 * k);
            }
        }
    }
    table
}

/// The sample machine with half of what the load does, and a wrong arm.
pub(crate) fn halved() -> String {
    let text = std::fs::read_to_string(crate::support::repository("samples/machines/maho700s.toml")).unwrap();
    let pairs = [
        (
            "coefficients = [8.575e-05, -4.9e-07, 7.0e-10]",
            "coefficients = [4.3e-05, -2.4e-07, 3.5e-10]   # from a sketch",
        ),
        ("coefficients = [0, 0, -1.4e-09]", "coefficients = [0, 0, -7e-10]"),
        ("arm_mm = 375", "arm_mm = 450      # guessed"),
        ("value_urad = -150", "value_urad = -75"),
    ];
    pairs.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    })
}

fn load_case() -> Case {
    let (machine, start) = machine(&halved());
    let data = plan(&levels(), DIRECT, &machine);
    assert_eq!(data.conditions.len(), 9);
    let exact = data.observations.iter().map(|row| {
        let load = data.condition(row).loads().first().copied();
        let [force, z] = load.map_or([0.0, 0.0], |load| [load.force_n, load.position_mm.z]);
        [Some(level(row.reading.position.xyz().x, force, z)), None, None]
    });
    let exact = exact.collect();
    let parameters = parameters(&start, "load.EAX load.EAX.arm_mm load.EA0B");
    assert_eq!(parameters.len(), 6, "{parameters:?}");
    let truth = vec![8.575e-5, -4.9e-7, 7.0e-10, -1.4e-9, 375.0, -150e-6];
    Case { machine, start, parameters, truth, data, exact, noise: 0.5e-6 }
}

#[test]
fn loads_from_levels() {
    let case = load_case();
    case.check(0.0);
    case.check(0.02);
}

/// Three axes, all of the tool side.
pub(crate) fn three_axes(errors: &str) -> String {
    format!(
        "[machine]\nname = \"three\"\ntopology = \"wFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n\
         [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n[axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 600]\n{errors}"
    )
}

fn drift(head: [f64; 2], column: [f64; 2], lags_s: [f64; 2]) -> String {
    [0, 1].iter().fold(String::new(), |text, &k| {
        text + &format!(
            "[[drift]]\ndirection = \"Y\"\nover = \"Z\"\nat_mm = {}\nsensors = [{{ name = \"T_head\", um_per_K = {}, lag_s = {} }}, \
             {{ name = \"T_column\", um_per_K = {} }}]\n",
            400 * k, head[k], lags_s[k], column[k]
        )
    })
}

/// Temperatures of a day: two hours on, two hours off.
fn warm(t_s: f64) -> [f64; 2] {
    let rise = |size: f64, tau: f64| {
        let on = size * (1.0 - f64::exp(-t_s.min(7200.0) / tau));
        22.0 + on * f64::exp(-(t_s - 7200.0).max(0.0) / tau)
    };
    [rise(9.0, 900.0), rise(4.0, 4000.0)]
}

fn drift_case() -> Case {
    let (machine, start) = machine(&three_axes(&drift([2.0, 2.0], [0.5, 0.5], [400.0, 400.0])));
    const STEP_S: f64 = 240.0;
    let mut table = "t_s,setup,X,Y,Z,dy_um,T_head_C,T_column_C\n".to_owned();
    let mut read: Vec<(f64, usize, [f64; 2])> = Vec::new();
    for k in 0..60 {
        let (t_s, pose) = (f64::from(k) * STEP_S, (k % 2) as usize);
        let [head, column] = warm(t_s).map(|value| (value * 100.0).round() / 100.0);
        let _ = writeln!(table, "{t_s},Z{pose},350,200,{},,{head},{column}", 400 * pose);
        read.push((t_s, pose, [head, column]));
    }
    let data = plan(&table, "[measurement]\nkind = \"displacement\"\n", &machine);
    assert_eq!(data.conditions.len(), 60);
    // What follows the head with each lag: midpoint rule between the readings.
    let lags_s = [600.0, 900.0];
    let (mut follower, mut rows) = ([read[0].2[0]; 2], Vec::new());
    for (k, &(t_s, pose, [head, column])) in read.iter().enumerate() {
        rows.push((pose, follower, column));
        let Some(&(_, _, [next, _])) = read.get(k + 1) else { break };
        for step in 0..400 {
            let at = head + (next - head) * (f64::from(step) + 0.5) / 400.0;
            for (own, lag_s) in follower.iter_mut().zip(lags_s) {
                let middle = *own + 0.5 * STEP_S / 400.0 * (at - *own) / lag_s;
                *own += STEP_S / 400.0 * (at - middle) / lag_s;
            }
        }
        assert!(t_s >= 0.0);
    }
    let (head_um, column_um) = ([3.1, 3.6], [1.2, -0.7]);
    // The first row at each Z is that at which the indicator was set to zero.
    let value = |pose: usize, (_, follower, column): (usize, [f64; 2], f64)| {
        head_um[pose] * follower[pose] + column_um[pose] * column
    };
    let exact = rows.iter().map(|&row| {
        let um = value(row.0, row) - value(row.0, rows[row.0]);
        [None, Some(um * 1e-3), None]
    });
    let exact = exact.collect();
    let parameters = parameters(&start, "drift.Y drift.Y@Z0.T_head.lag_s drift.Y@Z400.T_head.lag_s");
    let truth = vec![3.1e-3, 1.2e-3, 3.6e-3, -0.7e-3, 600.0, 900.0];
    assert_eq!(parameters.len(), 6);
    Case { machine, start, parameters, truth, data, exact, noise: 0.3e-3 }
}

#[test]
fn drift_from_warming_up_and_cooling_down() {
    let case = drift_case();
    case.check(0.0);
    case.check(0.02);
}

#[test]
fn expansion_from_a_laser_at_two_temperatures() {
    let expansion =
        "[[expansion]]\naxis = \"X\"\nfixed_mm = 300\nscale = { sensors = [\"T_scale\"], um_per_m_K = 11.0 }\n";
    let (machine, start) = machine(&three_axes(expansion));
    let mut table = "X,Y,Z,component,T_scale_C\n".to_owned();
    let mut exact = Vec::new();
    for temperature in [20.5, 28.0] {
        for k in 0..29 {
            let x = 25.0 * f64::from(k);
            let _ = writeln!(table, "{x},200,100,EXX,{temperature}");
            // A zero of the laser, a scale of 12 µm/m, and glass.
            exact.push([Some(0.007 + 12e-6 * x + 8e-6 * (temperature - 20.0) * (x - 300.0)), None, None]);
        }
    }
    let data = plan(&table, DIRECT, &machine);
    assert_eq!(data.conditions.len(), 2);
    let parameters = parameters(&start, "expansion EXX1");
    let case = Case { machine, start, parameters, truth: vec![8e-6, 12e-6, 0.007], data, exact, noise: 0.3e-3 };
    case.check(0.0);
    case.check(0.02);
}

/// What the workpiece weight does to a plate: displacements at several loads give the same coefficients.
#[test]
fn loads_from_displacements() {
    let load = |c1: f64, arm: f64| {
        format!(
            "[[load]]\ncomponent = \"EAX\"\nreference_N = 4800\nalong = \"Y\"\narm_mm = {arm}\nkind = \"polynomial\"\ncoefficients = [0, {c1:e}]\n"
        )
    };
    let (machine, start) = machine(&three_axes(&load(-1e-8, 500.0)));
    let mut table = "setup,X,Y,Z,dx_um,dy_um,dz_um,tool_z_mm,load_N,load_y_mm\n".to_owned();
    let mut exact = Vec::new();
    for (force, place) in [(0.0, 0.0), (4000.0, 0.0), (4000.0, 250.0), (4000.0, -250.0)] {
        for x in [0.0, 350.0, 700.0] {
            for y in [0.0, 250.0, 500.0] {
                let _ = writeln!(table, "P,{x},{y},100,,,,-120,{force},{place}");
                // Roll φ of X, which carries Y and Z: the tip at (y, 100 − 120) from its line moves by φ × r.
                let roll = -3e-8 * x * force / 4800.0 * (400.0 - place) / 400.0;
                exact.push([Some(0.0), Some(-roll * -20.0), Some(roll * y)]);
            }
        }
    }
    let data = plan(&table, "[measurement]\nkind = \"displacement\"\n", &machine);
    assert_eq!(data.conditions.len(), 4);
    let parameters = parameters(&start, "load load.EAX.arm_mm");
    let case = Case { machine, start, parameters, truth: vec![0.0, -3e-8, 400.0], data, exact, noise: 0.3e-3 };
    case.check(0.0);
    case.check(0.02);
}

#[test]
fn names_are_unambiguous() {
    let twice = "[[load]]\ncomponent = \"EXX\"\nreference_N = 1000\nkind = \"polynomial\"\ncoefficients = [0, 1e-6]\n"
        .repeat(2);
    let drift = "[[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_a\", um_per_K = 1 }, { name = \"T_a\", um_per_K = 2, lag_s = 60 }]\n";
    let (_, errors) = machine(&three_axes(&(twice + drift)));
    let all = effect_parameters(&errors);
    let names: Vec<&str> = all.iter().map(ncfix_metrology::calibrate::EffectParameter::name).collect();
    let expected = [
        "load.EXX.coefficients[0]",
        "load.EXX.coefficients[1]",
        "load.EXX~2.coefficients[0]",
        "load.EXX~2.coefficients[1]",
        "drift.Z.T_a",
        "drift.Z.T_a~2",
        "drift.Z.T_a~2.lag_s",
    ];
    assert_eq!(names, expected);
    for (text, count) in [
        ("load", 4),
        ("load.EXX", 4),
        ("load.EXX~2", 2),
        ("load.EXX.coefficients", 2),
        ("load.EXX~2.coefficients[1]", 1),
        ("drift", 2),
        ("drift.Z", 2),
        ("drift.Z.T_a", 1),
        ("drift.Z.T_a~2.lag_s", 1),
        ("drift.", 0),
        ("loa", 0),
        ("load.EX", 0),
        ("drift.Y", 0),
    ] {
        assert_eq!(named(&all, text).len(), count, "{text}");
    }
}

#[test]
fn runs_that_begin_again_have_clocks_of_their_own_and_steady_rows_share_a_condition() {
    let (machine, _) = machine(&three_axes(""));
    let rows =
        "t_s,run,X,Y,Z,T_a_C\n0,1,0,0,0,20\n10,1,1,0,0,20\n20,1,2,0,0,22\n0,2,3,0,0,30\n10,2,4,0,0,32\n30,3,5,0,0,31\n";
    let data = plan(rows, "[measurement]\nkind = \"displacement\"\n", &machine);
    let numbers: Vec<usize> = data.observations.iter().map(|row| row.condition).collect();
    assert_eq!(numbers, [0, 0, 1, 2, 3, 4]);
    let warmth = |row: usize| data.condition(&data.observations[row]).temperature_c("T_a", 0.0).unwrap();
    assert_eq!([0, 1, 2, 3, 4, 5].map(warmth), [20.0, 20.0, 22.0, 30.0, 32.0, 31.0]);
    // Run 3 goes on from run 2: half way from 32 to 31 in between, and zero in its own first row.
    let zero = |row: usize| {
        let condition = data.condition(&data.observations[row]).zero().unwrap();
        condition.temperature_c("T_a", 0.0).unwrap()
    };
    assert_eq!([2, 4, 5].map(zero), [20.0, 30.0, 31.0]);
    assert_eq!(data.condition(&data.observations[5]).trace("T_a").unwrap().points().len(), 3);
}

/// Every source with parameters: its factors are the derivatives of what the whole model says, and a changed machine file reads back as changed.
#[test]
fn factors_are_derivatives_and_what_is_written_reads_back() {
    let sources = Sources::default();
    let all = sources.iter().map(|source| source.info());
    let own = all.filter(|source| ["load", "structure", "drift", "expansion"].contains(&source.name));
    let text = three_axes(&own.map(|source| source.example).collect::<String>());
    let (loaded, findings) = file::load(&source(0, "machine.toml", &text));
    assert!(findings.iter().all(|finding| !finding.is_error()), "{findings:?}");
    let (machine, errors) = loaded.unwrap();
    let sensors = errors.sensors();
    let mut random = Random(9);
    let mut table = format!("t_s,X,Y,Z,dx_um,dy_um,dz_um,tool_z_mm,load_N,load_z_mm,{}_C\n", sensors.join("_C,"));
    for k in 0..8 {
        let warm =
            sensors.iter().map(|_| format!("{:.3}", 24.0 + 4.0 * random.symmetric())).collect::<Vec<_>>().join(",");
        let [x, y, z] = [700.0, 500.0, 600.0].map(|travel| travel * (0.5 + 0.5 * random.symmetric()));
        let _ = writeln!(table, "{},{x},{y},{z},,,,-90,{},{},{warm}", 300 * k, 1000 * k, 40 * k - 100);
    }
    let data = [plan(&table, "[measurement]\nkind = \"displacement\"\n", &machine)];
    let all: Vec<Parameter> = effect_parameters(&errors).into_iter().map(Parameter::from).collect();
    assert!(all.len() > 20);
    let seen = |errors: &ErrorModel| equations(&machine, errors, &all, &data, None).1;
    let factored = seen(&errors);
    for (k, parameter) in all.iter().enumerate() {
        let value = parameter.get(&errors);
        if !parameter.is_linear() && value == 0.0 {
            continue;
        }
        let largest = factored.iter().fold(0.0, |most, (_, factors)| f64::max(most, factors[k].abs()));
        // Two sensors at an end tell no torsion.
        assert_eq!(largest > 0.0, parameter.to_string() != "segment.bed.torsion_share", "{parameter}");
        if largest == 0.0 {
            continue;
        }
        let step = if parameter.is_linear() { 1e-4 / largest } else { 1e-3 * value.abs() };
        let [above, below] = [step, -step].map(|side| {
            let mut moved = errors.clone();
            parameter.set(&mut moved, value + side);
            seen(&moved)
        });
        for (((_, factors), (above, _)), (below, _)) in factored.iter().zip(&above).zip(&below) {
            let slope = (below.residual - above.residual) / (2.0 * step);
            assert!((slope - factors[k]).abs() < 2e-3 * largest, "{parameter}: {slope:e} is not {:e}", factors[k]);
        }
    }
    let mut changed = errors.clone();
    for (k, parameter) in all.iter().enumerate() {
        parameter.set(&mut changed, parameter.get(&errors) * (1.1 + 0.01 * k as f64));
    }
    let written = write::write(&text, &errors, &changed).unwrap();
    let (_, again) = file::load(&source(0, "machine.toml", &written)).0.unwrap();
    for parameter in &all {
        let [one, other] = [&changed, &again].map(|errors| parameter.get(errors));
        assert!((one - other).abs() <= 1e-10 * one.abs(), "{parameter}: {one:e} is written as {other:e}");
    }
}
