//! Duration of fits on one core: thirteen parameters on 109 probings, 84 on the same, and 60 on tens of thousands of
//! rows of a ball-bar.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has nothing to measure")]

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

use ncfix_base::geometry::{Axis, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_metrology::calibrate::{FitOptions, Parameter, fit, identify, reduce};
use ncfix_metrology::measure::data::{DataSet, Free};
use ncfix_metrology::measure::noise::Noise;
use ncfix_metrology::measure::plan::{self, Wishes};
use ncfix_metrology::measure::simulate::{ReadValue, Simulation};
use ncfix_model::{ErrorModel, file, preset};

/// Noise of a reading, mm.
const NOISE_MM: f64 = 1e-3;

/// Readings of a machine, and the parameters fitted to them.
struct Job {
    name: String,
    machine: Machine,
    parameters: Vec<Parameter>,
    data: Vec<DataSet>,
}

fn machine(name: &str) -> (Machine, ErrorModel) {
    let path = format!("{}/samples/machines/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let source = Source::new(FileId(0), name, std::fs::read(path).unwrap()).unwrap();
    file::load(&source).0.unwrap()
}

/// The readings of a plan on the machine.
fn measured(machine: &Machine, errors: &ErrorModel, plan: &DataSet, reads: [bool; 3]) -> DataSet {
    let mut data = plan.clone();
    data.observations.iter_mut().for_each(|row| row.values = reads.map(|is_read| is_read.then_some(0.0)));
    let known = data.clone();
    let mut simulation = Simulation::new(machine, errors, &known);
    let mut noise = Noise::new(1);
    for row in &mut data.observations {
        match simulation.read(row).unwrap() {
            ReadValue::Values(values) => {
                row.values = values.map(|value| value.map(|mm| mm + NOISE_MM * noise.normal()))
            }
            ReadValue::Position(position) => {
                row.reading.position = position;
                [Axis::X, Axis::Y, Axis::Z]
                    .iter()
                    .for_each(|&axis| row.reading.position[axis] += NOISE_MM * noise.normal());
            }
        }
    }
    data.is_plan = false;
    data.sigma = Some(NOISE_MM);
    data
}

fn preset_of(name: &str, machine: &Machine) -> Vec<Parameter> {
    (preset::find(name).unwrap().parameters)(machine).unwrap().into_iter().map(Parameter::from).collect()
}

/// Table 4-1 with the parameters of a preset that it determines; the stylus is known.
fn probings(preset: &str) -> Job {
    let (machine, errors) = machine("esmaeili_xyz5");
    let wishes =
        Wishes { variant: Some("samba".into()), tools_mm: vec![Vector::new(0.0, 0.0, -200.0)], ..Wishes::default() };
    let plan = (plan::find("probe").unwrap().build)(&machine, &wishes).unwrap();
    let data = vec![measured(&machine, &errors, &plan.data, plan.reads)];
    let parameters = preset_of(preset, &machine);
    let parameters = reduce(&machine, &errors, &parameters, &data).unwrap().parameters;
    let name = format!("{} on {} probings", parameters.len(), data[0].observations.len());
    Job { name, machine, parameters, data }
}

/// Circles in three planes with this number of rows in total, and the first 60 parameters of Spaan's model that they
/// determine.
fn circles(rows: usize) -> Job {
    let (machine, errors) = machine("demo");
    // Two full circles, and four of 220°: 5.78 turns of the plane.
    let every = 1604.0 / rows as f64;
    let wishes = Wishes {
        tools_mm: vec![Vector::new(0.0, 0.0, -100.0)],
        centres_mm: vec![Vector::new(300.0, 200.0, 150.0)],
        radius_mm: Some(150.0),
        every: Some(every.to_radians()),
        ..Wishes::default()
    };
    let plan = (plan::find("ballbar").unwrap().build)(&machine, &wishes).unwrap();
    let mut data = measured(&machine, &errors, &plan.data, plan.reads);
    data.observations.truncate(rows);
    data.free = vec![Free::Centre];
    let data = vec![data];
    let parameters = preset_of("spaan-21", &machine);
    let mut parameters = reduce(&machine, &errors, &parameters, &data).unwrap().parameters;
    parameters.truncate(60);
    let name = format!("{} on {} rows of a ball-bar", parameters.len(), data[0].observations.len());
    Job { name, machine, parameters, data }
}

fn fits(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("calibrate");
    group.sampling_mode(SamplingMode::Flat).sample_size(10).measurement_time(Duration::from_secs(3));
    for job in [probings("mayer-13"), probings("84"), circles(20_000), circles(100_000)] {
        let rows: usize = job.data.iter().map(|set| set.observations.len()).sum();
        group.throughput(Throughput::Elements(rows as u64));
        let none = ErrorModel::default();
        for robust in [false, true] {
            let id = BenchmarkId::new(if robust { "robust" } else { "fit" }, &job.name);
            group.bench_function(id, |bencher| {
                bencher.iter(|| {
                    black_box(fit(&job.machine, &none, &job.parameters, &job.data, FitOptions { robust }).unwrap())
                });
            });
        }
        group.bench_function(BenchmarkId::new("identify", &job.name), |bencher| {
            bencher.iter(|| black_box(identify(&job.machine, &none, &job.parameters, &job.data).unwrap()));
        });
    }
    group.finish();
}

criterion_group!(benches, fits);
criterion_main!(benches);
