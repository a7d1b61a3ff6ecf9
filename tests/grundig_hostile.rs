//! Grundig: whatever comes in, no panic, no endless run, no unbounded memory.

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use proptest::prelude::*;
use std::fs;

use crate::grundig::{mill, tool};
use crate::support::repository;

/// Parses and executes; gives the number of items of the stream.
fn run(bytes: Vec<u8>) -> usize {
    let source = Source::new(FileId(0), "hostile.pm", bytes).unwrap();
    let (program, _) = syntax::parse(&source, ncfix_dialect::find("grundig").unwrap());
    let mut machine = mill();
    machine.tools.push(tool(1, 50.0, 5.0));
    let options = Options { max_blocks: Some(2000), strict: true, ..Options::default() };
    Execution::new(program, &machine, Box::new(NoLibrary), options).count()
}

/// Pieces that programs are made of.
const PIECES: &[&str] = &[
    "\nN1 ",
    "\nN2 ",
    "\n%MM1\n",
    "\n%PM2\nN2\n",
    "\n%TM\n",
    "\n%ZO\n",
    "G0 ",
    "G1 ",
    "G2 ",
    "G3 ",
    "G14 N1=1 N2=2 J",
    "G22 N=1 ",
    "G23 N=2 ",
    "G29 E1 N=1 ",
    "G41 ",
    "G42 ",
    "G43 ",
    "G44 ",
    "G40 ",
    "G61 I2=1 R",
    "G62 I2=2 R",
    "G64 ",
    "G63 ",
    "G11 ",
    "G17 ",
    "G18 ",
    "G19 ",
    "G70 ",
    "G71 ",
    "G72 ",
    "G73 X-1 A4=",
    "G77 R5 J",
    "G78 P1 ",
    "G79 ",
    "G81 Y2 Z-",
    "G83 Y2 Z-9 K",
    "G84 Y2 Z-9 J",
    "G87 X30 Y20 Z-9 B2 K",
    "G88 X30 Y20 Z-9 B2 I",
    "G89 Z-9 B2 R",
    "G90 ",
    "G91 ",
    "G92 X",
    "G93 B4=",
    "G53 ",
    "G54 ",
    "G54 I",
    "G51 ",
    "G52 ",
    "G9 X",
    "G28 I5=1 ",
    "G27 ",
    "G39 R",
    "G149 N1=54 X7=",
    "G150 N1=54.01 X7=",
    "T1 M6 ",
    "M3 S100 ",
    "M30 ",
    "F100 ",
    "X",
    "Y",
    "Z",
    "I",
    "J",
    "K",
    "R",
    "B1=",
    "L1=",
    "B2=",
    "L2=",
    "B3=",
    "L3=",
    "B5=",
    "X90=",
    "Y91=",
    "P1 ",
    "X1=",
    "R1=",
    "I1=",
    "K1=",
    "J1=2 ",
    "E1=",
    "E2=E1",
    "=E1",
    "(",
    ")",
    "+",
    "-",
    "*",
    ":",
    "^",
    "sqrt(",
    "sin(",
    "=",
    ">",
    "1",
    "0",
    "7.5",
    "-3",
    "1000000",
    "99999999999",
    "0.0001",
    " ",
    "/",
    ".",
];

fn samples() -> Vec<Vec<u8>> {
    let mut files: Vec<_> = fs::read_dir(repository("samples/programs/grundig"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files.into_iter().map(|path| fs::read(path).unwrap()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn pieces_in_any_order(picked in proptest::collection::vec(0..PIECES.len(), 0..60)) {
        let text: String = picked.into_iter().map(|index| PIECES[index]).collect();
        run(text.into_bytes());
    }

    #[test]
    fn damaged_programs(which in 0..100_usize, at in 0.0..1.0_f64, length in 0..12_usize, with in 0..PIECES.len()) {
        let samples = samples();
        let mut bytes = samples[which % samples.len()].clone();
        let start = (at * bytes.len() as f64) as usize;
        let end = (start + length).min(bytes.len());
        bytes.splice(start..end, PIECES[with].bytes());
        run(bytes);
    }
}

#[test]
fn cycles_do_not_fill_the_memory() {
    let head = "N1 G17 G90 T1 M67 F100\nN2 G0 X0 Y0 Z9 M3\n";
    for cycle in [
        "G87 X9000 Y9000 Z-9000 B1 K1",
        "G89 Z-9000 B1 R9000 K1 I1",
        "G83 Y1 Z-9000 K1",
        "G88 X9000 Y9000 Z-9000 B1 K1",
    ] {
        assert!(run(format!("{head}N3 {cycle}\nN4 G77 X0 Y0 Z0 R5 J99999\nN5 M30").into_bytes()) < 300_000, "{cycle}");
    }
    assert!(run(format!("{head}N3 G3 I5 J0 K0.00001 Z-9000\nN5 M30").into_bytes()) < 10_000);
}
