//! Blocks per second of every stage on a program of 200,000 blocks: a surface milled in lines of short G1 blocks on the embedded
//! three-axis machine, whose 21 errors are cubic polynomials and tables.
#![allow(clippy::unwrap_used, reason = "a bench that cannot be set up has nothing to measure")]

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main};

use ncfix_base::source::{FileId, Source};
use ncfix_dialect::Dialect;
use ncfix_language::exec::{Execution, NoLibrary};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::machine::file::DEMO;
use ncfix_machine::snc::{Element, Kind};
use ncfix_model::{ErrorModel, Model};
use ncfix_path::emit::{self, Stamp, WriterOptions};
use ncfix_path::path::{CorrectionOptions, Corrector, Increments, Output, OutputFrame};

const BLOCKS: u32 = 200_000;
const BLOCKS_PER_LINE: u32 = 400;

/// Lines before the surface in each dialect.
const HEADS: &[(&str, &str)] = &[
    ("sinumerik", "N1 G17 G90 G71 G64\nN2 T7\nN3 M6\nN4 G54 D1 S9000 M3\nN5 G0 X0 Y0 Z20\nN6 G1 Z1 F2500\n"),
    ("fanuc", "%\nO0001\nN1 G17 G90 G21 G54\nN2 T7 M6\nN3 G43 H7 S9000 M3\nN5 G0 X0. Y0. Z20.\nN6 G1 Z1. F2500.\n"),
    ("rs274", "N1 G17 G90 G21 G54\nN2 T7 M6\nN3 G43 H7 S9000 M3\nN5 G0 X0 Y0 Z20\nN6 G1 Z1 F2500\n"),
    ("grundig", "%PM9001\nN9001\nN1 G17 G90 G71 G54\nN2 T7 M6\nN4 S9000 M3\nN5 G0 X0 Y0 Z20\nN6 G1 Z1 F2500\n"),
];

/// The text of the program.
fn program(head: &str) -> String {
    let mut text = String::from(head);
    for block in 0..BLOCKS {
        let (line, place) = (block / BLOCKS_PER_LINE, block % BLOCKS_PER_LINE);
        let along = if line % 2 == 0 { place } else { BLOCKS_PER_LINE - 1 - place };
        let (x, y) = (f64::from(along) * 0.37, f64::from(line) * 0.3);
        let z = -5.0 * (x * 0.05).sin() * (y * 0.03).cos();
        writeln!(text, "N{} X{x:.4} Y{y:.4} Z{z:.4}", block + 10).unwrap();
    }
    text.push_str("M30\n");
    text
}

struct Shop {
    dialect: &'static Dialect,
    source: Source,
    machine: Machine,
    model: Model,
    writer_options: WriterOptions,
}

impl Shop {
    fn new((dialect, head): (&str, &str)) -> Shop {
        let read = |name: &str, bytes: &str| Source::new(FileId(0), name, bytes.as_bytes().to_vec()).unwrap();
        let loaded: (Machine, ErrorModel) = ncfix_model::file::load(&read("demo.toml", DEMO)).0.unwrap();
        let (machine, errors) = loaded;
        let increments = Increments::new(&machine.control);
        let writer_options = WriterOptions {
            names: machine.written_names(),
            increments,
            last_block_number: None,
            has_centers_reversed: false,
            frame: OutputFrame::Work,
            crlf: false,
            stamp: Stamp::default(),
        };
        Shop {
            dialect: ncfix_dialect::find(dialect).unwrap(),
            source: read("surface", &program(head)),
            model: Model::new(&machine, &errors),
            machine,
            writer_options,
        }
    }

    fn parse(&self) -> syntax::Program {
        syntax::parse(&self.source, self.dialect).0
    }

    fn execute(&self, program: syntax::Program) -> Execution<'_> {
        Execution::new(program, &self.machine, Box::new(NoLibrary), ncfix_language::exec::Options::default())
    }

    fn correct<I>(&self, elements: I) -> Corrector<'_, I>
    where
        I: Iterator<Item = Result<Element, ncfix_base::diagnostic::Diagnostic>>,
    {
        Corrector::new(elements, &self.machine, &self.model, CorrectionOptions::default())
    }

    /// Writes into a buffer and returns the number of blocks.
    fn emit(&self, outputs: impl Iterator<Item = Result<Output, ncfix_base::diagnostic::Diagnostic>>) -> u64 {
        let mut writer = emit::writer(self.dialect.name, &self.writer_options).unwrap();
        emit::emit(outputs, writer.as_mut(), &mut std::io::sink(), |finding| panic!("{finding:?}")).unwrap()
    }
}

fn stages(criterion: &mut Criterion) {
    let shop = Shop::new(HEADS[0]);
    let elements: Vec<Element> = shop.execute(shop.parse()).map(Result::unwrap).collect();
    let outputs: Vec<Output> = shop.correct(elements.iter().cloned().map(Ok)).map(Result::unwrap).collect();
    assert!(shop.emit(outputs.iter().cloned().map(Ok)) > u64::from(BLOCKS));

    let mut group = criterion.benchmark_group("pipeline");
    group.throughput(Throughput::Elements(u64::from(BLOCKS))).sampling_mode(SamplingMode::Flat);
    group.sample_size(10).measurement_time(Duration::from_secs(5));
    let stage = |name| BenchmarkId::new(name, "200k blocks");
    group.bench_function(stage("parse"), |bencher| bencher.iter(|| black_box(shop.parse())));
    group.bench_function(stage("execute"), |bencher| {
        bencher.iter_batched(
            || shop.parse(),
            |program| shop.execute(program).map(|element| u64::from(black_box(element).is_ok())).sum::<u64>(),
            BatchSize::LargeInput,
        );
    });
    group.bench_function(stage("parse and execute"), |bencher| {
        bencher.iter(|| shop.execute(shop.parse()).map(|element| u64::from(black_box(element).is_ok())).sum::<u64>());
    });
    group.bench_function(stage("correct"), |bencher| {
        bencher.iter_batched(
            || elements.clone(),
            |elements| shop.correct(elements.into_iter().map(Ok)).map(|o| u64::from(black_box(o).is_ok())).sum::<u64>(),
            BatchSize::LargeInput,
        );
    });
    group.bench_function(stage("emit"), |bencher| {
        bencher.iter_batched(
            || outputs.clone(),
            |outputs| shop.emit(outputs.into_iter().map(Ok)),
            BatchSize::LargeInput,
        );
    });
    group.bench_function(stage("correct and emit"), |bencher| {
        bencher.iter_batched(
            || elements.clone(),
            |elements| shop.emit(shop.correct(elements.into_iter().map(Ok))),
            BatchSize::LargeInput,
        );
    });
    group.bench_function(stage("whole"), |bencher| {
        bencher.iter(|| shop.emit(shop.correct(shop.execute(shop.parse()))));
    });
    group.finish();
}

/// The flat stream and the complete correction, for each language.
fn dialects(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("dialects");
    group.throughput(Throughput::Elements(u64::from(BLOCKS))).sampling_mode(SamplingMode::Flat);
    group.sample_size(10).measurement_time(Duration::from_secs(3));
    for &head in HEADS {
        let shop = Shop::new(head);
        let moves = shop.execute(shop.parse()).map(Result::unwrap).filter(|e| matches!(e.kind, Kind::Move(_))).count();
        assert!(moves > BLOCKS as usize, "{} executes {moves} moves", head.0);
        group.bench_function(BenchmarkId::new("parse and execute", head.0), |bencher| {
            bencher
                .iter(|| shop.execute(shop.parse()).map(|element| u64::from(black_box(element).is_ok())).sum::<u64>());
        });
        group.bench_function(BenchmarkId::new("whole", head.0), |bencher| {
            bencher.iter(|| black_box(shop.emit(shop.correct(shop.execute(shop.parse())))));
        });
    }
}

criterion_group!(benches, stages, dialects);
criterion_main!(benches);
