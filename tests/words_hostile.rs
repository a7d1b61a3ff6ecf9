//! Whatever comes in as a program of a word language: no panic, no endless run, findings with places in the file.

use ncfix_base::source::{FileId, Source};
use ncfix_language::syntax::words::{self, Body, Program};
use proptest::prelude::*;
use std::time::{Duration, Instant};

const DIALECTS: [&str; 3] = ["grundig", "fanuc", "rs274"];

/// Pieces that programs are made of, to get past the first byte of a parser.
const PIECES: &[&str] = &[
    "%PM",
    "%MM9101",
    "%",
    "O1",
    "O0002 (A)",
    ":3",
    "<NAME>",
    "N1",
    "N9001",
    "N1=",
    "G1",
    "G54.1",
    "X1.5",
    "X",
    "X=",
    "Y-.5",
    "E1=",
    "E5",
    "=E1+",
    "X1=",
    "B1=45",
    "#",
    "#1=",
    "#<a>=",
    "#<",
    "##1",
    "[",
    "]",
    "(",
    ")",
    "(MSG,a)",
    ";",
    "/",
    "/2",
    ",C5",
    ",R",
    "@1",
    "^90",
    "$1",
    "+",
    "-",
    "*",
    "**",
    ":",
    "^",
    "MOD",
    "AND ",
    "OR ",
    "EQ ",
    "GT ",
    "<>",
    "sin(",
    "SIN[",
    "ATAN[1]/[",
    "EXISTS[#<a>]",
    "POW[1,",
    "IF [",
    "IF [1] THEN",
    "GOTO 1",
    "] GOTO ",
    "WHILE [1] DO1",
    "DO2",
    "END1",
    "END2",
    "ELSE",
    "ENDIF",
    "DPRNT[",
    "o1 sub",
    "o1 endsub",
    "o<a> sub",
    "o<a> call [1]",
    "o2 if [1]",
    "o2 else",
    "o2 elseif [2]",
    "o2 endif",
    "o3 do",
    "o3 while [1]",
    "o3 endwhile",
    "o4 repeat [2]",
    "o4 endrepeat",
    "o3 break",
    "o4 continue",
    "o#1 call",
    "M2",
    "M30",
    "\n",
    "\n",
    "\n",
    " ",
    "1",
    ".",
    "9",
    "\r\n",
    "\0",
];

fn parse(dialect: &str, bytes: Vec<u8>) -> Program {
    let length = bytes.len();
    let source = Source::new(FileId(0), "hostile", bytes).unwrap();
    let (program, findings) = words::parse(&source, ncfix_dialect::find(dialect).unwrap());
    for finding in &findings {
        let span = finding.place.unwrap().span;
        assert!(span.start <= span.end && span.end as usize <= length + 1, "{finding:?}");
    }
    for (index, block) in program.blocks.iter().enumerate() {
        assert!(block.partner().is_none_or(|partner| partner < program.blocks.len()));
        for word in program.words_of(block) {
            assert!(block.span.start <= word.span.start && word.span.end <= block.span.end, "{word:?}");
        }
        let part = program.part_of(index).expect("every block belongs to a part");
        assert!(program.parts[part].blocks.contains(&index));
    }
    program
}

proptest! {
    #[test]
    fn bytes_of_any_kind(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        for dialect in DIALECTS {
            parse(dialect, bytes.clone());
        }
    }

    #[test]
    fn pieces_in_any_order(picks in proptest::collection::vec(0..PIECES.len(), 0..60)) {
        let text: String = picks.iter().map(|&pick| PIECES[pick]).collect();
        for dialect in DIALECTS {
            parse(dialect, text.clone().into_bytes());
        }
    }
}

/// The code of the only finding.
#[track_caller]
fn code(dialect: &str, text: &str) -> &'static str {
    let source = Source::new(FileId(0), "hostile", text.as_bytes().to_vec()).unwrap();
    let (_, findings) = words::parse(&source, ncfix_dialect::find(dialect).unwrap());
    assert_eq!(findings.len(), 1, "{findings:?}");
    findings[0].code.as_str()
}

#[test]
fn nesting_without_end_is_a_finding() {
    for (dialect, open) in [
        ("fanuc", "X[".to_owned() + &"[".repeat(2000)),
        ("fanuc", "X".to_owned() + &"#".repeat(2000)),
        ("fanuc", "X#[".to_owned() + &"SIN[".repeat(900)),
        ("rs274", "X".to_owned() + &"-".repeat(2000) + "1"),
        ("rs274", "X[1".to_owned() + &"+[1".repeat(1000)),
        ("rs274", "o".to_owned() + &"#".repeat(2000)),
        ("grundig", "X=".to_owned() + &"(".repeat(2000)),
        ("grundig", "X=".to_owned() + &"-".repeat(2000)),
        ("grundig", "X=".to_owned() + &"E(".repeat(1500)),
        ("grundig", "X=".to_owned() + &"not ".repeat(900)),
    ] {
        assert_eq!(code(dialect, &open), "E0107", "{dialect}");
    }
}

#[test]
fn lines_and_files_of_any_length() {
    for dialect in DIALECTS {
        assert_eq!(code(dialect, &"X1".repeat(500_000)), "E0109");
        assert_eq!(code(dialect, &("(".to_owned() + &"a".repeat(1_000_000) + ")")), "E0109");
        parse(dialect, vec![0; 1_000_000]);
        parse(dialect, vec![b'%'; 1_000_000]);
        parse(dialect, b"%\n".repeat(200_000));
        parse(dialect, b"(\n".repeat(200_000));
    }
    let many = "o1 if [1]\n".repeat(100_000);
    let program = parse("rs274", many.into_bytes());
    assert_eq!(program.blocks.len(), 100_000);
    let breaks = "o1 do\n".repeat(2000) + &"o2 break\n".repeat(2000);
    assert!(parse("rs274", breaks.into_bytes()).blocks.iter().all(|block| block.body != Body::Faulty));
}

#[test]
fn names_in_angle_brackets_that_end_nowhere() {
    for (dialect, text, wanted) in [
        ("fanuc", "N1 <A", "E0105"),
        ("fanuc", "N1 <>", "E0101"),
        ("fanuc", "N1 M98 < >", "E0101"),
        ("rs274", "X#<a", "E0105"),
        ("rs274", "#<>=1", "E0101"),
        ("rs274", "o<a sub", "E0105"),
        ("rs274", "o<> sub", "E0101"),
    ] {
        assert_eq!(code(dialect, text), wanted, "{dialect}: {text}");
    }
}

#[test]
fn angle_brackets_without_end_take_time_in_proportion_to_the_file() {
    let started = Instant::now();
    for dialect in DIALECTS {
        for piece in ["<", "#<", "O<", "o<", "X#<", "<a>", "#<a>", "O<a>", "#<a", "(DEBUG,#<"] {
            // One line of any length, and many of the longest that are read.
            parse(dialect, piece.repeat(1_000_000 / piece.len()).into_bytes());
            parse(dialect, (piece.repeat(4000 / piece.len()) + "\n").repeat(250).into_bytes());
            parse(dialect, format!("{piece}\n").repeat(20_000).into_bytes());
            // 60 MB in all: a second where each byte is looked at a few times, hours where it is for each bracket.
            assert!(started.elapsed() < Duration::from_secs(60), "{:?}", started.elapsed());
        }
    }
}
