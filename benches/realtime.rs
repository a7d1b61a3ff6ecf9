//! Duration of the correction in the cycle of a control: a million set-points along a path on a machine with three
//! axes and on one with five, with a histogram of the durations. It also proves that a cycle allocates nothing while
//! new kernels are handed over. With `--test` there are fewer set-points, and no limits apply.

#![allow(clippy::print_stdout, reason = "figures are what a bench is for")]
#![allow(unsafe_code, reason = "an allocator that counts must be one; it hands everything on to that of the system")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use criterion::Criterion;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::Machine;
use ncfix_model::{Model, Solve, file::load};
use ncfix_tables::realtime::{Cycle, Dosing, Kernel, LatencyHistogram, Updater, handover};

thread_local! {
    /// Number of allocations and deallocations of this thread.
    static TOUCHED: Cell<u64> = const { Cell::new(0) };
}

/// The allocator of the system, which counts the calls of each thread.
struct Counting;

// SAFETY: every call passes its arguments unchanged to the allocator of the system.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = TOUCHED.try_with(|touched| touched.set(touched.get() + 1));
        // SAFETY: the caller keeps the contract of this function, which is that of the allocator of the system.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        let _ = TOUCHED.try_with(|touched| touched.set(touched.get() + 1));
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A machine, its path, and the limit of 99.9 % of its cycles, ns.
struct Case {
    name: &'static str,
    file: &'static str,
    path: fn(f64) -> AxisVector,
    limit_ns: u64,
}

const CASES: [Case; 2] = [
    Case { name: "three axes", file: "demo", path: three_axes, limit_ns: 1000 },
    Case { name: "five axes", file: "esmaeili_xyz5", path: five_axes, limit_ns: 3000 },
];

/// Number of parts of a run whose tails are printed separately: other processes disturb only some of them.
const PARTS: usize = 10;

/// Descending circles that move over the table.
fn three_axes(s: f64) -> AxisVector {
    let mut point = AxisVector::ZERO;
    point[Axis::X] = 350.0 + 200.0 * (s * 0.11).sin() + 100.0 * s.cos();
    point[Axis::Y] = 250.0 + 100.0 * s.sin();
    point[Axis::Z] = 200.0 + 150.0 * (s * 0.07).cos();
    point
}

/// The same circles with a tool that tilts to all sides.
fn five_axes(s: f64) -> AxisVector {
    let mut point = three_axes(s);
    point[Axis::X] -= 350.0;
    point[Axis::B] = 0.6 + 0.5 * (s * 0.31).sin();
    point[Axis::C] = 3.0 * (s * 0.05).sin();
    point
}

fn read(name: &str) -> Option<(Machine, Model)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("samples/machines/{name}.toml"));
    let source = Source::new(FileId(0), name, std::fs::read(path).ok()?).ok()?;
    let (machine, errors) = load(&source).0?;
    let model = Model::new(&machine, &errors);
    Some((machine, model))
}

/// Measures a case; returns whether it meets its limit and whether nothing was allocated.
fn measure(case: &Case, set_points: usize, criterion: &mut Criterion) -> Option<(bool, bool)> {
    let (machine, model) = read(case.file)?;
    let tool_mm = Vector::new(0.0, 0.0, -120.0);
    let make = move || Kernel::new(&machine, &model, &tool_mm, Solve::Full);
    let (publisher, subscriber) = handover(make());
    // Far more often than once per minute, so that handovers have a visible effect.
    let updater = Updater::start(publisher, Duration::from_millis(200), move || Some(make()));
    let mut cycle = Cycle::new(subscriber, Dosing::new(1e-3, 5e-6), 1e-4, 1e-6);
    // 15 ms at 6 m/min.
    let point = |index: usize| (case.path)(index as f64 * 0.015);
    let mut histogram = Box::<LatencyHistogram>::default();
    let mut part = Box::<LatencyHistogram>::default();
    let mut tails = Vec::with_capacity(PARTS);
    let mut renewed = 0;
    for index in 0..set_points / 10 {
        black_box(cycle.step(&point(index)));
    }
    let before = TOUCHED.get();
    for index in 0..set_points {
        let set_point = black_box(point(index));
        let start = Instant::now();
        let answer = black_box(cycle.step(&set_point));
        let time = start.elapsed();
        histogram.note(time);
        part.note(time);
        if part.total() == (set_points / PARTS) as u64 {
            tails.push(part.quantile_ns(0.999));
            *part = LatencyHistogram::default();
        }
        renewed += u64::from(answer.signals.has(ncfix_tables::realtime::Signals::RENEWED));
    }
    let touched = TOUCHED.get() - before;
    let [half, most, tail] = [0.5, 0.99, 0.999].map(|share| histogram.quantile_ns(share));
    tails.sort_unstable();
    let is_met = tail <= case.limit_ns;
    println!(
        "{}: {set_points} set-points, p50 {half} ns, p99 {most} ns, p99.9 {tail} ns, max {} ns; p99.9 of ten parts {tails:?}; {renewed} new kernels, {touched} allocations; p99.9 <= {} ns {}",
        case.name,
        histogram.max_ns(),
        case.limit_ns,
        if is_met { "met" } else { "NOT met" },
    );
    let mut index = 0;
    criterion.bench_function(&format!("realtime/{}", case.name), |bencher| {
        bencher.iter(|| {
            index += 1;
            cycle.step(&black_box(point(index)))
        });
    });
    drop(updater);
    Some((is_met, touched == 0))
}

fn main() -> ExitCode {
    let is_test = std::env::args().any(|argument| argument == "--test");
    let mut criterion = Criterion::default().configure_from_args();
    let mut is_sound = true;
    for case in &CASES {
        let set_points = if is_test { 20_000 } else { 1_000_000 };
        let Some((_, allocates_nothing)) = measure(case, set_points, &mut criterion) else {
            println!("{}: the machine file cannot be read", case.name);
            return ExitCode::FAILURE;
        };
        is_sound &= allocates_nothing;
    }
    criterion.final_summary();
    if is_sound { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
