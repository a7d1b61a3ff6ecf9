//! Files that are no tables: whatever stands in them, reading ends with findings at their places, in bounded memory, without a panic.

use ncfix_base::geometry::Axis;
use ncfix_base::source::{FileId, Source};
use ncfix_tables::tables::{FORMATS, Format, Lookup, Nodes, Sense, Tables, Wiring};
use proptest::prelude::*;

use super::table_formats::{source, tables_for};

/// Reads anything; what was read without an error can be judged, rounded and written.
#[track_caller]
fn survive(format: &Format, name: &str, bytes: Vec<u8>) -> bool {
    let length = bytes.len();
    let source = source(name, bytes);
    let mut tables = Tables::default();
    let findings = (format.read)(&source, &Wiring::usual(), &mut tables);
    assert!(findings.len() <= 100, "{}: {}", format.name, findings.len());
    for one in &findings {
        let place = one.place.unwrap();
        assert!(place.file == FileId(0) && place.span.start as usize <= length, "{}: {one:?}", format.name);
        assert!(!one.help.is_empty() && one.message.len() < 400, "{}: {one:?}", format.name);
    }
    let has_error = findings.iter().any(|one| one.is_error());
    if !has_error {
        let entries = tables.entries();
        assert!(entries <= 4_000_000, "{}: {entries}", format.name);
        (format.round)(&mut tables);
        if format.faults_of(&tables, &Wiring::usual()).is_empty() {
            (format.write)(&tables, &Wiring::usual(), &[]);
        }
    }
    has_error
}

/// What a format writes of its tables.
fn texts(format: &Format) -> Vec<(String, String)> {
    let mut tables = tables_for(format);
    (format.round)(&mut tables);
    let files = (format.write)(&tables, &Wiring::usual(), &["remark".to_owned()]);
    files.into_iter().map(|file| (format!("mill{}", file.suffix), file.text)).collect()
}

#[test]
fn what_is_no_table_is_refused() {
    for format in FORMATS {
        for garbage in
            ["", "hello world", "G0 X5\nM30\n", "\0\0\0\0", "\u{feff}", "é = ü\n$é\nNé\n%é\n", "=", "$", "[", "N1"]
        {
            assert!(survive(format, "garbage.txt", garbage.as_bytes().to_vec()), "{}: {garbage:?}", format.name);
        }
        assert!(survive(format, "latin.txt", vec![0xfc; 100]), "{}", format.name);
    }
}

#[test]
fn files_that_are_cut_off_or_damaged() {
    for format in FORMATS {
        for (name, text) in texts(format) {
            for end in (0..text.len()).step_by(1 + text.len() / 150) {
                survive(format, &name, text.as_bytes()[..end].to_vec());
            }
            for large in
                ["1e308", "-1e308", "1e999", "NaN", "99999999999999999999", "-1", "0", "1e-300", "", ",,,", "é"]
            {
                for digit in '0'..='9' {
                    survive(format, &name, text.replace(digit, large).into_bytes());
                    survive(format, &name, text.replacen(digit, large, 1).into_bytes());
                }
            }
        }
    }
}

#[test]
fn ten_megabytes_are_read_in_bounded_memory() {
    const SIZE: usize = 10 << 20;
    for format in FORMATS {
        assert!(survive(format, "long.txt", vec![b'A'; SIZE]), "{}", format.name);
        survive(format, "lines.txt", b"\n; $".repeat(SIZE / 40));
        let (name, text) = texts(format).swap_remove(0);
        survive(format, &name, text.repeat(SIZE / text.len()).into_bytes());
    }
}

/// Pieces of all formats.
const PIECES: &[&str] = &[
    "$AN_CEC",
    "$AN_CEC_STEP",
    "$AN_CEC_MIN",
    "$AN_CEC_MAX",
    "$AN_CEC_INPUT_AXIS",
    "$AN_CEC_OUTPUT_AXIS",
    "[0",
    "[1",
    ",0]",
    ",1]",
    "]",
    "=",
    "=(AX1)",
    "=AX2",
    "=100",
    "=-1",
    "1e9",
    "\n",
    "\n",
    "; é",
    " ",
    "INCH",
    "%_N_NC_CEC_INI",
    "$AN_CEC_MULT_BY_TABLE",
    "$AN_CEC_IS_MODULO",
    "$SN_CEC_TABLE_WEIGHT",
    "$AA_ENC_COMP",
    ",AX1]",
    "S1",
    " P5",
    " T1=",
    " R3=1",
    "X EXX\n",
    "A0Z\n",
    "#\n",
    "//",
    "BEGIN X .COM MM\n",
    "NR AXISPOS X BACKLASH\n",
    "0 1 2 3\n",
    "1 2\n",
    "[END]",
    "setp matrixkins.C_",
    "xy ",
    "axis,start_mm,step_mm,count\n",
    "X,0,1,2\n",
    "node\n",
    "1,0,0,0,1,1,1\n",
    "0 0 0\n",
    "5 5 5\n",
    "# axis X\n",
    "# COMP_FILE_TYPE = 1\n",
];

/// A table of a sag compensation with any values, and one that multiplies it.
fn any_lookup() -> impl Strategy<Value = (f64, f64, f64, Vec<f64>, i8, bool, f64, bool)> {
    (
        -1e3..1e3_f64,
        0.01..200.0_f64,
        0.0..1.0_f64,
        proptest::collection::vec(-0.9..0.9_f64, 2..40),
        -1..=1_i8,
        any::<bool>(),
        -2.0..2.0_f64,
        any::<bool>(),
    )
}

proptest! {
    #[test]
    fn pieces_in_any_order(picks in proptest::collection::vec(proptest::sample::select(PIECES), 0..60)) {
        for format in FORMATS {
            survive(format, "x.txt", picks.concat().into_bytes());
        }
    }

    #[test]
    fn bytes_of_any_kind(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        for format in FORMATS {
            survive(format, "x.txt", bytes.clone());
        }
    }

    /// Every table of the sag compensation comes back bit by bit.
    #[test]
    fn sag_tables_come_back(
        lookups in proptest::collection::vec(any_lookup(), 1..6),
        factors in proptest::collection::vec(proptest::option::of(0..6_usize), 6),
    ) {
        let format = ncfix_tables::tables::format::find("cec").unwrap();
        let mut tables = Tables::default();
        for (index, (start, step, rest, values, sense, modulo, weight, has_weight)) in lookups.iter().enumerate() {
            let whole = (values.len() - 2) as f64;
            // The last step may be shorter than the others.
            let end = start + step * (whole + rest.max(0.01));
            let nodes = Nodes::Even { start: *start, step: *step, end };
            let sense = [Sense::Negative, Sense::Both, Sense::Positive][(sense + 1) as usize];
            let factor = factors[index].filter(|&factor| factor < lookups.len());
            let weight = if *has_weight { *weight } else { 1.0 };
            let input = if *modulo { Axis::C } else { Axis::Y };
            let added = Lookup::added(input, Axis::X, nodes, values.clone());
            tables.lookups.push(Lookup { sense, modulo: *modulo, weight, factor, ..added });
        }
        (format.round)(&mut tables);
        prop_assert_eq!(format.faults_of(&tables, &Wiring::usual()), Vec::<String>::new());
        let files = (format.write)(&tables, &Wiring::usual(), &[]);
        let source = Source::new(FileId(0), "x", files[0].text.clone().into_bytes()).unwrap();
        let mut read = Tables::default();
        prop_assert_eq!((format.read)(&source, &Wiring::usual(), &mut read), Vec::new());
        prop_assert_eq!(read, tables);
    }
}
