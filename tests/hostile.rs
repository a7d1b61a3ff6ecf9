//! Whatever comes in: no panic, no endless run.

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use proptest::prelude::*;
use std::fs;
use std::path::Path;

use crate::machines::xyz_machine;

/// Parses and executes; gives the number of items of the stream.
fn run(bytes: Vec<u8>) -> usize {
    let source = Source::new(FileId(0), "hostile", bytes).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    for finding in &findings {
        let place = finding.place.unwrap();
        assert!(
            place.span.start <= place.span.end && place.span.end as usize <= source.bytes().len() + 1,
            "{finding:?}"
        );
    }
    let machine = xyz_machine();
    let options = Options { max_blocks: Some(2000), strict: true, ..Options::default() };
    Execution::new(program, &machine, Box::new(NoLibrary), options).count()
}

fn samples() -> Vec<Vec<u8>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("samples/programs/sinumerik");
    let mut files: Vec<_> = [root.clone(), root.join("bad")]
        .iter()
        .flat_map(|folder| fs::read_dir(folder).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files.into_iter().map(|path| fs::read(path).unwrap()).collect()
}

/// Pieces that programs are made of, to get past the first byte of a parser.
const PIECES: &[&str] = &[
    "G0",
    "G2",
    "X",
    "Y=",
    "R1=",
    "R[",
    "]",
    "(",
    ")",
    "IF ",
    "GOTOF ",
    "GOTOB AB",
    "AB:",
    "WHILE ",
    "ENDWHILE",
    "FOR R1=1 TO ",
    "ENDFOR",
    "REPEAT",
    "REPEAT AB ",
    "REPEATB AB P",
    "ENDLABEL:",
    "CASE R1 OF ",
    " DEFAULT GOTOF AB",
    "MCALL A",
    "MCALL",
    "CALL \"A\" BLOCK AB TO AB",
    "CALL BLOCK AB TO AB",
    "PROC A(VAR REAL R1,INT AA=1) SAVE",
    "A(1,,R1)",
    "RET(\"AB\")",
    "GOTOF \"AB\"<<",
    "\nDEFINE AA AS AB: X1 AA BB AA\n",
    "\nDEFINE BB AS G0 AA(\"\n",
    "BB ",
    "UNTIL ",
    "\nDEF REAL AA[3],BB[2,2]=SET(1,,2)\n",
    "\nDEF STRING[9] AA[2]=REP(\"A\")\n",
    "\nDEF FRAME AA=CTRANS(X,1):CROT(Z,",
    "\nDEF AXIS AA\n",
    "AA[1]=",
    "AA[1,1]=REP(",
    "AA[X,TR]=",
    "BB[",
    "SET(1,,",
    "$P_UIFR[1]=",
    "$P_UIFR[1,X,TR]=",
    "$P_PFRAME=",
    "$TC_DP3[1,1]=",
    "$AC_MARKER[",
    "$P_GG[",
    "G[1]=",
    "AX[X]=",
    "CSCALE(X,",
    "INVFRAME($P_ACTFRAME):",
    "SUBSTR(\"ABC\",",
    "SPRINT(\"%9.9G\",",
    "ISAXIS(",
    "<<",
    ",",
    "LOOP",
    "ENDLOOP",
    "ELSE",
    "ENDIF",
    "\n",
    "\n",
    " ",
    "1",
    "-",
    ".5",
    "EX9",
    "9999999999",
    "\"",
    ";",
    "'H",
    "SIN(",
    "==",
    "<<",
    " AND ",
    "NOT ",
    "DEF INT ",
    "AA",
    "TRANS ",
    "M30",
    "L1",
    "P2",
    "%_N_A_MPF\n",
    "/",
    "N1",
    "CR=",
    "I1",
    "AC(",
    "\0",
    "\u{e9}",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        run(bytes);
    }

    #[test]
    fn random_pieces(pieces in proptest::collection::vec(proptest::sample::select(PIECES), 0..80)) {
        prop_assert!(run(pieces.concat().into_bytes()) < 20_000);
    }

    #[test]
    fn damaged_samples(index in 0_usize..1000, at in any::<prop::sample::Index>(), byte in any::<u8>(), cut in any::<bool>()) {
        let samples = samples();
        let mut bytes = samples[index % samples.len()].clone();
        if !bytes.is_empty() {
            let at = at.index(bytes.len());
            if cut { bytes.truncate(at) } else { bytes[at] = byte }
        }
        run(bytes);
    }
}

#[test]
fn deep_nesting_is_refused_not_overflowed() {
    for text in [
        format!("R1={}1{}", "(".repeat(2000), ")".repeat(2000)),
        format!("R1={}1", "-".repeat(3000)),
        format!("R1={}1", "NOT ".repeat(1000)),
        format!("G0 X={}", "SIN(".repeat(1000)),
        format!("R1={}0{}", "R[".repeat(1500), "]".repeat(1500)),
        "IF 1\n".repeat(5000),
        format!("R1=1{}", "+1".repeat(2000)),
        format!("PROC A({})", "INT AA,".repeat(500)),
        format!("A({})\n%_N_A_SPF\nPROC A({}INT ZZ)", "1,".repeat(700), "INT AA,".repeat(300)),
        format!("AA: X1\n{}", "REPEAT AA P9999\n".repeat(500)),
        format!("{}AA: X1\n", "REPEATB AA P9999\n".repeat(500)),
        format!("CASE R1 OF {}", "1 GOTOF AA ".repeat(300)),
        "MCALL A\nG0 X1\n%_N_A_SPF\nX2\nMCALL A\nA\n".into(),
        "CALL \"A\"\n%_N_A_SPF\nRET(\"AA\",,99)".into(),
        "AA: CALL BLOCK AA TO BB P9999\nBB: X1\n".into(),
    ] {
        run(text.into_bytes());
    }
}
