//! The properties of `fuzz/`, without libFuzzer: samples that a generator of our own damages, and every input that once broke one.
//!
//! `NCFIX_FUZZ_SECONDS` is for how long (10), `NCFIX_FUZZ_SEED` where the generator begins (1). A failure prints the input as a row of [`BROKE`].

#[allow(unreachable_pub, reason = "the targets of libFuzzer, which are crates of their own, call them too")]
#[allow(clippy::expect_used, reason = "a property that cannot be tested fails")]
#[path = "../fuzz/src/lib.rs"]
mod targets;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};

use crate::bench_machine::Random;
use targets::{TARGETS, Target};

/// Inputs that broke a property, by target.
const BROKE: &[(&str, &[u8])] = &[
    // Numbers of blocks are no targets in RS274/NGC, by pages neither.
    ("parse_rs274", b"N3000 M3\nG0 X1\n"),
    // What is read as a header depends on what came before, also where that was on another page.
    ("parse_grundig", b"N7\nN9\nm9"),
    ("parse_grundig", b"N4\nN1\nY1"),
    ("parse_grundig", b"%PM9001\nN9002\nN1 Y1"),
    ("parse_sinumerik", b"%_N_A_LONG_NAME_MPF\n;$PATH=/_N_WKS_DIR/_N_A_WPD\n; A\nG0 X1\n"),
    // A quotation mark within a cell opens no quotation, so that the semicolons behind it are no separators of the header.
    ("csv", b"a,b\"\n1,\"c;d\"\n"),
    // A feed that is nothing in six decimals is none.
    ("snc_text", b"G1 X1 F0.0000001\n"),
    ("snc_text", b"S=\"MILL_A10\" ;@2\n"),
    // A block on the line of a header is no part of the header, or it would be written twice.
    ("correct_fanuc", b"%\nO1 G90 G54 G0 X1. Y1. Z1.\nG91\nO2\nG1 X2. F100.\nM30\n%\n"),
    ("correct_grundig", b"%PM90180 N5\nN1 G90 G0 X1 Y1 Z1\nN2 G1 X2 F100\nN3 M30\n"),
    ("snc_text", b"\"200"),
    // What a block got ready beside other codes gets a block of its own in the output.
    ("correct_grundig", b"%PM9018\nN1 T17 G71 G90\nN2 T2 M6\nN3 G0 X1 Y1 Z1\nN4 G1 X2 F100\nN5 M30\n"),
    // A second mark would end the tape.
    ("correct_fanuc", b"%100\nG90 G54 G0 X1. Y1. Z1.\nG1 X2. F100.\nM30\n%\n"),
    // Names of tools have blanks and semicolons.
    ("execute_sinumerik", b"T=\"MILL 6; HSS\"\nM6\nG0 X1\n"),
    // A rounding that a contour has held back comes behind the feed of the next block, and has another one.
    (
        "correct_sinumerik",
        b"N10 G17 G90 G710 G40 G64\nN20 T5\nN30 M6\nN40 G54 D1 S3200 M3\nN60 G0 X-20 Y-20 Z5\nN80 G41 G450 G1 X0 Y-5 F600\nN90 Y60 RND=8\n\
        N103 F400\nN200 X70 RND=7\nN230 Y10\nN260 G40 X90\nN280 M30\n",
    ),
];

/// Larger samples take long to execute in a build without optimization.
const LARGEST_SEED: usize = 6000;
/// No input of this size takes longer.
const PATIENCE: Duration = Duration::from_secs(20);

/// Pieces that files are made of, to get past the first byte of a parser.
const PIECES: &[&str] = &[
    "\n",
    "\r\n",
    " ",
    "=",
    "(",
    ")",
    "[",
    "]",
    "\"",
    ";",
    ",",
    ".",
    "-",
    "+",
    "/",
    "*",
    "%",
    "#",
    "<",
    ">",
    "0",
    "1",
    "9",
    "1e9",
    "99999999999",
    "0.0000001",
    "-1",
    "nan",
    "1e308",
    "X",
    "Y",
    "Z",
    "A",
    "R",
    "I",
    "J",
    "K",
    "F",
    "G0",
    "G1",
    "G2",
    "G3",
    "G41",
    "G91",
    "G68",
    "G92",
    "G54",
    "M30",
    "M99",
    "N1",
    "o1 ",
    "IF ",
    "GOTO",
    "SIN",
    "ROT ",
    "é",
    "\0",
    "\u{feff}",
    "[[",
    "]]",
    "{",
    "}",
    "true",
    "\n====\n",
    "</",
    "/>",
    "ok\r\n",
    "error:1\r\n",
];

/// The files that a target begins with.
fn seeds(target: &Target) -> Vec<Vec<u8>> {
    let mut found = Vec::new();
    for folder in target.seeds {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        let entries = fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_file()).collect();
        paths.sort();
        found.extend(paths.into_iter().map(|path| fs::read(path).unwrap()).filter(|bytes| bytes.len() <= LARGEST_SEED));
    }
    if found.is_empty() {
        found.push((0..64).collect());
    }
    found
}

/// A number below a bound, 0 where that is 0.
fn below(random: &mut Random, bound: usize) -> usize {
    random.between(0.0, bound as f64) as usize
}

/// A sample with some damage.
fn damaged(random: &mut Random, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[below(random, seeds.len())].clone();
    for _ in 0..=below(random, 6) {
        let at = below(random, bytes.len());
        let end = (at + 1 + below(random, 30)).min(bytes.len());
        match below(random, 8) {
            0 => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << below(random, 8);
                }
            }
            1 => {
                if let Some(byte) = bytes.get_mut(at) {
                    *byte = below(random, 256) as u8;
                }
            }
            2 => drop(bytes.drain(at..end)),
            3 => {
                let again = bytes[at..end].to_vec();
                bytes.splice(at..at, again);
            }
            4 | 5 => {
                let piece = PIECES[below(random, PIECES.len())];
                bytes.splice(at..at, piece.bytes());
            }
            6 => {
                // A piece of another sample.
                let other = &seeds[below(random, seeds.len())];
                let from = below(random, other.len());
                let piece = &other[from..(from + below(random, 80)).min(other.len())];
                bytes.splice(at..at, piece.iter().copied());
            }
            _ => {
                // Another digit.
                let digits: Vec<usize> = (0..bytes.len()).filter(|&at| bytes[at].is_ascii_digit()).collect();
                if !digits.is_empty() {
                    bytes[digits[below(random, digits.len())]] = b'0' + below(random, 10) as u8;
                }
            }
        }
    }
    bytes
}

/// Runs a target on an input; shows the input where the property does not hold, or takes too long.
#[track_caller]
fn run(target: &Target, bytes: &[u8]) {
    let started = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| (target.run)(bytes)));
    let row = || format!("(\"{}\", b\"{}\"),", target.name, bytes.escape_ascii());
    assert!(result.is_ok(), "{}", row());
    assert!(started.elapsed() < PATIENCE, "{:?} {}", started.elapsed(), row());
}

fn setting(name: &str, otherwise: f64) -> f64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn damaged_samples_break_nothing() {
    let each = Duration::from_secs_f64(setting("NCFIX_FUZZ_SECONDS", 10.0) / TARGETS.len() as f64);
    for target in TARGETS {
        let mut random = Random(setting("NCFIX_FUZZ_SEED", 1.0) as u64);
        let seeds = seeds(target);
        let started = Instant::now();
        while started.elapsed() < each {
            run(target, &damaged(&mut random, &seeds));
        }
    }
}

#[test]
fn samples_break_nothing() {
    for target in TARGETS {
        seeds(target).iter().for_each(|bytes| run(target, bytes));
    }
}

#[test]
fn what_broke_once_does_not_break_again() {
    for (name, bytes) in BROKE {
        run(TARGETS.iter().find(|target| target.name == *name).unwrap(), bytes);
    }
}

#[test]
fn every_target_has_its_file_and_its_binary() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap();
    for target in TARGETS {
        let text = fs::read_to_string(folder.join(format!("fuzz_targets/{}.rs", target.name))).unwrap();
        assert!(text.contains("fuzz_target!") && manifest.contains(&format!("name = \"{}\"", target.name)));
    }
    assert_eq!(fs::read_dir(folder.join("fuzz_targets")).unwrap().count(), TARGETS.len());
}
