//! Cost of a complete correction as a function of the number of blocks, the size of the file and the number of error
//! terms, over three decades each. `NCFIX_WRITE_DOCS=1` draws it into `docs/scale.svg`; `-- --test` only checks that
//! it runs.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has nothing to measure")]
#![allow(clippy::print_stdout, reason = "a bench prints its table")]

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::file::DEMO;
use ncfix_model::motion::{EntryFunction, periodic::Periodic};
use ncfix_model::{ErrorModel, Model, MotionError};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, OutputFrame};
use ncfix_report::plot::{Chart, Picture, PlotSeries, Shape};
use std::fmt::Write as _;
use std::time::Instant;

/// Number of repetitions, of which the best counts.
const ROUNDS: usize = 3;

/// A remark of a hundred bytes, with its end of line.
const REMARK_BYTES: usize = 100;

/// A surface milled in lines of short blocks, each followed by a number of remarks in lines of their own.
fn program(blocks: usize, remarks: usize) -> String {
    let mut text = String::from("G17 G90 G71 G64\nT7\nM6\nG54 D1 S9000 M3\nG0 X0 Y0 Z20\nG1 Z1 F2500\n");
    let remarks = format!(";{}\n", "x".repeat(REMARK_BYTES - 2)).repeat(remarks);
    for block in 0..blocks {
        let (line, place) = (block / 400, block % 400);
        let along = if line % 2 == 0 { place } else { 399 - place };
        let (x, y) = (along as f64 * 0.37, (line % 1000) as f64 * 0.3);
        let z = -5.0 * (x * 0.05).sin() * (y * 0.03).cos();
        write!(text, "X{x:.4} Y{y:.4} Z{z:.4}\n{remarks}").unwrap();
    }
    text + "M30\n"
}

/// A number of waves, distributed over the 18 errors of three axes.
fn waves(terms: usize) -> ErrorModel {
    let names: Vec<String> =
        "XYZ".chars().flat_map(|axis| "XYZABC".chars().map(move |d| format!("E{d}{axis}"))).collect();
    let motion = (0..terms).map(|k| {
        let name = names[k % names.len()].parse().unwrap();
        let size = if k % 6 < 3 { 1e-3 } else { 1e-6 };
        let (period, phase_rad) = (100.0 + k as f64 * 0.7, k as f64);
        let amplitude = size / terms as f64;
        MotionError { name, function: EntryFunction::Periodic(Periodic { period, amplitude, phase_rad }) }
    });
    ErrorModel { motion: motion.collect(), ..ErrorModel::default() }
}

/// Seconds of a complete correction in one thread, the best of some repetitions.
fn seconds(text: &str, machine: &Machine, errors: &ErrorModel) -> f64 {
    let source = Source::new(FileId(0), "surface", text.as_bytes().to_vec()).unwrap();
    let model = Model::new(machine, errors);
    let options = WriterOptions {
        names: machine.written_names(),
        increments: Increments::new(&machine.control),
        last_block_number: None,
        has_centers_reversed: false,
        frame: OutputFrame::Work,
        crlf: false,
        stamp: Stamp::default(),
    };
    let run = || {
        let start = Instant::now();
        let (program, found) = syntax::parse(&source, ncfix_dialect::sinumerik());
        assert!(found.is_empty(), "what is refused costs nothing: {:?}", found[0]);
        let execution = Execution::new(program, machine, Box::new(NoLibrary), ncfix_language::exec::Options::default());
        let outputs = Corrector::new(execution, machine, &model, CorrectionOptions::default());
        let mut writer = emit::writer("sinumerik", &options).unwrap();
        emit::emit(outputs, writer.as_mut(), &mut std::io::sink(), |finding| panic!("{finding:?}")).unwrap();
        start.elapsed().as_secs_f64()
    };
    (0..ROUNDS).map(|_| run()).fold(f64::INFINITY, f64::min)
}

/// A cost over three decades.
struct Row {
    label: &'static str,
    what: &'static str,
    points: Vec<(f64, f64)>,
}

impl Row {
    /// Exponent of the cost as a function of the size over the last decade: 1 if it is proportional.
    fn power(&self) -> f64 {
        let &[.., (from, before), (to, after)] = self.points.as_slice() else { return f64::NAN };
        (after / before).ln() / (to / from).ln()
    }
}

fn main() {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let demo = Source::new(FileId(0), "demo.toml", DEMO.as_bytes().to_vec()).unwrap();
    let (machine, errors) = ncfix_model::file::load(&demo).0.unwrap();
    let decades: &[usize] = if is_test { &[1, 10] } else { &[1, 10, 100, 1000] };
    let rows = [
        Row {
            label: "blocks",
            what: "blocks",
            points: decades
                .iter()
                .map(|scale| ((1000 * scale) as f64, seconds(&program(1000 * scale, 0), &machine, &errors)))
                .collect(),
        },
        Row {
            label: "bytes",
            what: "bytes of remarks beside 1000 blocks",
            points: decades
                .iter()
                .map(|scale| ((1000 * scale * REMARK_BYTES) as f64, seconds(&program(1000, *scale), &machine, &errors)))
                .collect(),
        },
        Row {
            label: "terms",
            what: "error terms, 1000 blocks",
            points: decades
                .iter()
                .map(|&scale| (scale as f64, seconds(&program(1000, 0), &machine, &waves(scale))))
                .collect(),
        },
    ];
    for row in &rows {
        println!("{} (last decade: power {:.2})", row.what, row.power());
        row.points.iter().for_each(|(size, time)| println!("  {size:>12} {:>10.3} ms", time * 1e3));
    }
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() && !is_test {
        let log = |(size, time): &(f64, f64), first: f64| ((size / first).log10(), (time * 1e3).log10());
        let series = rows.iter().map(|row| PlotSeries {
            label: row.label.into(),
            points: row.points.iter().map(|point| log(point, row.points[0].0)).collect(),
            errors: Vec::new(),
            shape: Shape::Line,
            like: None,
        });
        let chart = Chart {
            title: "Cost of the whole way over three decades, one thread".into(),
            across: "size, decades above the smallest".into(),
            up: "time, log10 of ms".into(),
            series: series.collect(),
            ..Chart::default()
        };
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/scale.svg");
        std::fs::write(path, chart.svg()).unwrap();
    }
}
