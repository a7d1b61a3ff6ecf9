//! Times ncfix and two parsers of crates.io on one file, in turns, and prints a line for each: name, best and median time in seconds.
//!
//! Usage: peers FILE.ngc ROUNDS

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_machine::machine::file::DEMO;
use std::hint::black_box;
use std::time::Instant;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().expect("a file");
    let rounds: usize = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(5);
    let bytes = std::fs::read(&path).expect("the file can be read");
    let text = String::from_utf8(bytes.clone()).expect("plain text");
    let source = Source::new(FileId(0), &path, bytes).expect("less than 4 GB");
    let demo = Source::new(FileId(0), "demo.toml", DEMO.as_bytes().to_vec()).expect("small");
    let (machine, _) = ncfix_model::file::load(&demo).0.expect("the embedded machine is sound");
    let rs274 = ncfix_dialect::find("rs274").expect("a known dialect");

    let parse = || ncfix_language::syntax::parse(&source, rs274).0;
    let ncfix_tree = || parse().block_count();
    let ncfix_run = || {
        let execution = Execution::new(parse(), &machine, Box::new(NoLibrary), Options::default());
        execution.filter(|element| element.is_ok()).count()
    };
    let gcode_tree = || gcode::parse(&text).map_or(0, |program| program.blocks.len());
    let g_code_tree = || g_code::parse::file_parser(&text).map_or(0, |file| file.iter().count());
    let cases: [(&str, &dyn Fn() -> usize); 4] = [
        ("ncfix parse", &ncfix_tree),
        ("ncfix parse and execute", &ncfix_run),
        ("gcode 0.7.0 parse", &gcode_tree),
        ("g-code 0.6.0 parse", &g_code_tree),
    ];
    let mut times = vec![Vec::new(); cases.len()];
    for _ in 0..rounds {
        // In turns, so that whatever else the machine does is shared.
        for (times, (name, run)) in times.iter_mut().zip(cases) {
            let start = Instant::now();
            let count = black_box(run());
            times.push(start.elapsed().as_secs_f64());
            assert!(count > 0, "{name} reads nothing");
        }
    }
    for (times, (name, _)) in times.iter_mut().zip(cases) {
        times.sort_by(f64::total_cmp);
        println!("{name}\t{:.4}\t{:.4}", times[0], times[times.len() / 2]);
    }
}
