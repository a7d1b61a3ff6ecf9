//! Formats of compensation tables: what each writes it reads again, limits, samples with values by hand, hostile files.

use std::fs;

use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::file::DEMO;
use ncfix_machine::machine::{Machine, State};
use ncfix_model::name::{Direction, ErrorName};
use ncfix_tables::tables::format::{self, Holds};
use ncfix_tables::tables::{
    AxisErrors, Control, ErrorTables, FORMATS, Format, Grid, Lookup, Multiplication, Nodes, Sense, Tables, Wiring,
    Written,
};

use super::model::Random;
use super::support::repository;

/// A file.
pub(crate) fn source(name: &str, bytes: impl Into<Vec<u8>>) -> Source {
    Source::new(FileId(0), name, bytes.into()).unwrap()
}

fn demo() -> Machine {
    super::model::read(DEMO).0
}

fn named(name: &str) -> &'static Format {
    format::find(name).unwrap()
}

/// Reads a text; the findings as `code line:column`.
#[track_caller]
fn read_as(format: &Format, name: &str, bytes: impl Into<Vec<u8>>) -> (Tables, Vec<String>) {
    let source = source(name, bytes);
    let mut tables = Tables::default();
    let findings = (format.read)(&source, &Wiring::usual(), &mut tables);
    let place = |one: &Diagnostic| {
        let (line, column) = source.line_column(one.place.unwrap().span.start);
        format!("{} {line}:{column}", one.code.as_str())
    };
    (tables, findings.iter().map(place).collect())
}

#[track_caller]
fn sample(format: &str, name: &str) -> (Tables, Vec<String>) {
    read_as(named(format), name, fs::read(repository(&format!("samples/tables/{name}"))).unwrap())
}

/// The value of a control at a position of one axis, moving in a sense, mm and degrees.
fn at(tables: &Tables, input: Axis, position: f64, sense: i8, output: Axis) -> f64 {
    let mut command = AxisVector::default();
    command[input] = if input.is_rotary() { position.to_radians() } else { position };
    let mut state = State::default();
    state.direction[input.slot()] = sense;
    let added = Control::new(&demo(), tables).correction(&command, &Vector::zeros(), &state)[output];
    if output.is_rotary() { added.to_degrees() } else { added }
}

/// Numbers without a pattern that decimals would hide: multiples of 1/7.
fn irregular(count: usize, size: f64) -> Vec<f64> {
    (0..count).map(|index| size * ((index * 37 % 23) as f64 - 11.0) / 77.0).collect()
}

fn even(start: f64, step: f64, end: f64) -> Nodes {
    Nodes::Even { start, step, end }
}

/// Tables of every kind that a format has.
pub(crate) fn tables_for(format: &Format) -> Tables {
    let mut tables = Tables::default();
    let lookups = &mut tables.lookups;
    let own = even(-100.0, 100.0 / 3.0, 405.0);
    if format.can_hold(Holds::Own) {
        let count = own.count();
        let mut x = Lookup::added(Axis::X, Axis::X, own, irregular(count, 0.03));
        x.weight = 0.75;
        lookups.push(x);
        let turn = Lookup::added(Axis::C, Axis::C, even(0.0, 45.0, 360.0), irregular(9, 0.002));
        lookups.push(Lookup { modulo: format.can_hold(Holds::Repetition), ..turn });
    }
    if format.can_hold(Holds::Senses) {
        for (sense, start) in [(Sense::Positive, -50.0), (Sense::Negative, -60.0)] {
            let table = Lookup::added(Axis::X, Axis::X, even(start, 40.0, start + 200.0), irregular(6, start * 1e-4));
            lookups.push(Lookup { sense, ..table });
        }
    }
    if format.can_hold(Holds::Cross) {
        lookups.push(Lookup::added(Axis::Y, Axis::Z, even(-400.0, 200.0, 400.0), irregular(5, 0.02)));
        lookups.push(Lookup::added(Axis::Y, Axis::X, even(-400.0, 250.0, 300.0), irregular(4, 0.01)));
    }
    if format.can_hold(Holds::Products) {
        let first = lookups.len();
        lookups.push(Lookup::added(Axis::Z, Axis::X, even(0.0, 10.0, 40.0), irregular(5, 0.01)));
        lookups.push(Lookup {
            factor: Some(first),
            ..Lookup::added(Axis::Y, Axis::X, even(0.0, 7.5, 40.0), irregular(7, 2.0))
        });
    }
    if format.can_hold(Holds::Grid) {
        let values = irregular(3 * 2 * 4 * 3, 0.05).chunks(3).map(|one| [one[0], one[1], one[2]]).collect();
        let (start, step) = ([-300.0, 0.1, 5.0 / 3.0], [100.0, 200.0 / 3.0, 50.5]);
        tables.grid = Some(Grid { axes: [Axis::X, Axis::Y, Axis::Z], start, step, count: [3, 2, 4], values });
    }
    if format.can_hold(Holds::Errors) {
        let row = |index: usize| {
            let values = irregular(60, 0.04);
            std::array::from_fn(|i| values[index * 6 + i] * if i < 3 { 1.0 } else { 0.01 })
        };
        let axis = |axis: Axis, count: usize| AxisErrors {
            axis,
            positions: (0..count).map(|index| -200.0 + 100.0 / 3.0 * index as f64).collect(),
            values: (0..count).map(row).collect(),
        };
        let mut errors = ErrorTables { axes: vec![axis(Axis::Y, 4), axis(Axis::X, 10)], location: Vec::new() };
        if format.can_hold(Holds::Locations) {
            errors.axes.push(axis(Axis::C, 3));
            errors.location = vec![
                (ErrorName::location(Direction::A, Axis::Z), 1e-5 / 3.0),
                (ErrorName::location(Direction::X, Axis::C), -0.01 / 3.0),
            ];
        }
        tables.errors = Some(errors);
    }
    if format.can_hold(Holds::Matrix) {
        tables.matrix = Some([[1.0 + 1e-4 / 3.0, -3e-5, 0.0], [0.0, 1.0, 2e-5 / 7.0], [-1e-6, 0.0, 0.9999]]);
    }
    tables
}

fn write(format: &Format, tables: &Tables) -> Vec<Written> {
    let notes = ["a remark (of two".to_owned(), "lines)".to_owned(), format.sign.to_owned()];
    (format.write)(tables, &Wiring::usual(), &notes)
}

#[track_caller]
fn read_all(format: &Format, files: &[Written]) -> Tables {
    let mut tables = Tables::default();
    for file in files {
        let source = source(&format!("mill{}", file.suffix), file.text.as_bytes());
        let findings = (format.read)(&source, &Wiring::usual(), &mut tables);
        assert_eq!(findings, [], "{}{}\n{}", format.name, file.suffix, file.text);
    }
    tables
}

#[test]
fn what_a_format_writes_it_reads_bit_by_bit() {
    for format in FORMATS {
        let mut tables = tables_for(format);
        (format.round)(&mut tables);
        assert_eq!(format.faults_of(&tables, &Wiring::usual()), [""; 0], "{}", format.name);
        let files = write(format, &tables);
        let read = read_all(format, &files);
        assert_eq!(read, tables, "{}: {files:?}", format.name);
        assert_eq!(write(format, &read), files, "{}", format.name);
        let mut again = tables.clone();
        (format.round)(&mut again);
        assert_eq!(again, tables, "{}: rounded twice", format.name);
    }
}

#[test]
fn every_format_is_explained() {
    let docs = fs::read_to_string(repository("docs/reference/table-formats.md")).unwrap();
    for format in FORMATS {
        let rows = docs.lines().filter(|line| line.starts_with(&format!("| `{}` |", format.name))).count();
        assert_eq!(
            (rows, format.sign.is_empty()),
            (2, false),
            "{}: a row for what it holds, one for its sign",
            format.name
        );
    }
}

#[test]
fn a_file_tells_its_format() {
    for format in FORMATS {
        let mut tables = tables_for(format);
        (format.round)(&mut tables);
        for file in write(format, &tables).iter().filter(|file| !file.suffix.ends_with(".txt")) {
            for name in [format!("mill{}", file.suffix), "tables.txt".to_owned()] {
                let guess = format::guess(&name, file.text.as_bytes());
                assert_eq!(guess.map(|one| one.name), Some(format.name), "{name}");
            }
        }
    }
    assert!(format::guess("part.mpf", b"N10 G0 X5 S100 T1\nN20 M30\n").is_none());
    assert!(format::guess("", b"").is_none());
    for name in fs::read_dir(repository("samples/tables")).unwrap().map(|entry| entry.unwrap().file_name()) {
        let name = name.into_string().unwrap();
        let guess = format::guess(&name, &fs::read(repository(&format!("samples/tables/{name}"))).unwrap());
        assert_eq!(guess.is_none(), name == "README.md", "{name}");
    }
}

/// Sums of tables, weights and sides of the sense are brought into the form of each control without a change of what it adds.
#[test]
fn rounding_changes_no_more_than_the_last_digit() {
    let machine = demo();
    for format in FORMATS {
        let before = tables_for(format);
        let mut after = before.clone();
        (format.round)(&mut after);
        let (before, after) = (Control::new(&machine, &before), Control::new(&machine, &after));
        let mut random = Random(7);
        // Errors of rotations act over the machine: half an arc second over 0.6 m is 1.5 µm.
        let lever = if format.name == "grundig" { 6.0 } else { 1.0 };
        // It has other points, and no correction at the reference position: a test of its own has the arithmetic.
        if format.name == "pitch" {
            continue;
        }
        for sense in [-1, 0, 1] {
            let state = State { direction: [sense; 9], ..State::default() };
            for _ in 0..200 {
                let command = random.command(7.0);
                let tool = Vector::new(0.0, 0.0, 100.0);
                let [first, second] = [&before, &after].map(|one| one.correction(&command, &tool, &state));
                for slot in 0..9 {
                    let off = (first.0[slot] - second.0[slot]).abs();
                    assert!(
                        off <= lever * 2.5 * format.limits.resolution_mm,
                        "{} {slot} {command:?}: {off}",
                        format.name
                    );
                }
            }
        }
    }
}

#[test]
fn what_a_control_cannot_take_is_named() {
    for format in FORMATS {
        let faults = |tables: &Tables| format.faults_of(tables, &Wiring::usual()).join("\n");
        // More points than it has.
        let limit = format.limits.points;
        if limit > 0 {
            let mut tables = Tables::default();
            if format.can_hold(Holds::Grid) {
                let count = [limit + 1, 2, 2];
                let values = vec![[0.0; 3]; count[0] * 4];
                let axes = [Axis::X, Axis::Y, Axis::Z];
                tables.grid = Some(Grid { axes, start: [0.0; 3], step: [1.0; 3], count, values });
            } else {
                tables.lookups.push(Lookup::added(
                    Axis::X,
                    Axis::X,
                    even(0.0, 1.0, limit as f64),
                    vec![0.0; limit + 1],
                ));
            }
            (format.round)(&mut tables);
            let message = format!("{} points, but the control allows {limit}", limit + 1);
            assert!(faults(&tables).contains(&message), "{}: {}", format.name, faults(&tables));
        }
        // More tables.
        let mut tables = Tables::default();
        for _ in 0..=format.limits.tables {
            tables.lookups.push(Lookup::added(Axis::X, Axis::X, even(0.0, 1.0, 1.0), vec![0.0; 2]));
        }
        let message =
            format!("{} tables are needed, but the control has {}", format.limits.tables + 1, format.limits.tables);
        assert!(
            format.limits.tables == 0 || faults(&tables).contains(&message),
            "{}: {}",
            format.name,
            faults(&tables)
        );
        // Larger values.
        let limit = format.limits.value_mm;
        let large = Lookup::added(Axis::X, Axis::X, even(0.0, 1.0, 1.0), vec![0.0, -1.01 * limit]);
        let tables = Tables { lookups: vec![large], ..Tables::default() };
        let message = format!("; the control allows {limit} mm");
        assert!(limit == 0.0 || faults(&tables).contains(&message), "{}: {}", format.name, faults(&tables));
        // Kinds that it does not have: what any other format has.
        for other in FORMATS {
            let refused = other.holds.iter().any(|&kind| !format.can_hold(kind));
            assert!(!refused || faults(&tables_for(other)).contains("cannot hold"), "{} {}", format.name, other.name);
        }
        let beside = Tables { multiplication: Multiplication::Beside, ..Tables::default() };
        assert_eq!(faults(&beside).contains("does not multiply"), !format.can_hold(Holds::Products), "{}", format.name);
    }
}

#[test]
fn tables_that_are_none_are_not_written() {
    let ramp = Lookup::added(Axis::X, Axis::X, even(0.0, 1.0, 2.0), vec![0.0, 1.0, 2.0]);
    for (name, table) in [
        ("3 values", Lookup { nodes: even(0.0, 1.0, 5.0), ..ramp.clone() }),
        ("not a number", Lookup { values: vec![0.0, f64::NAN, 0.0], ..ramp.clone() }),
        ("not increase", Lookup { nodes: Nodes::At(vec![0.0, 5.0, 5.0]), ..ramp.clone() }),
        ("does not exist", Lookup { factor: Some(8), ..ramp.clone() }),
        ("one point", Lookup { nodes: even(5.0, 1.0, 5.0), values: vec![1.0], ..ramp.clone() }),
    ] {
        let tables = Tables { lookups: vec![table], ..Tables::default() };
        let faults = named("cec").faults_of(&tables, &Wiring::usual()).join("\n");
        assert!(faults.contains(name), "{name}: {faults}");
    }
    let modulo = Tables { lookups: vec![Lookup { modulo: true, ..ramp.clone() }], ..Tables::default() };
    for name in ["comp", "heidenhain"] {
        let mut tables = modulo.clone();
        (named(name).round)(&mut tables);
        assert!(named(name).faults_of(&tables, &Wiring::usual()).join("\n").contains("repeats"), "{name}");
    }
    let twice = Tables { lookups: vec![ramp.clone(), ramp.clone()], ..Tables::default() };
    assert!(named("enc").faults_of(&twice, &Wiring::usual()).join("\n").contains("second table"));
    let cross = Lookup { output: Axis::Z, sense: Sense::Positive, ..ramp };
    let mut tables = Tables { lookups: vec![cross], ..Tables::default() };
    (named("heidenhain").round)(&mut tables);
    assert!(named("heidenhain").faults_of(&tables, &Wiring::usual()).join("\n").contains("depends on the direction"));
    let singular = Tables { matrix: Some([[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), ..Tables::default() };
    assert!(named("matrixkins").faults_of(&singular, &Wiring::usual()).join("\n").contains("no inverse"));
}

/// Five points 200 mm apart, values by hand.
#[test]
fn sag_of_z_over_y() {
    let (tables, findings) = sample("cec", "sag.ini");
    assert_eq!(findings, [""; 0]);
    for (position, value) in [
        (-500.0, 0.0),
        (-400.0, 0.0),
        (-300.0, 0.005),
        (-250.0, 0.0075),
        (0.0, 0.012),
        (50.0, 0.0105),
        (399.0, -0.00395),
        (450.0, -0.004),
    ] {
        assert!((at(&tables, Axis::Y, position, 1, Axis::Z) - value).abs() < 1e-15, "{position}");
    }
}

#[test]
fn tables_of_esmaeili_are_multiplied() {
    let (tables, findings) = sample("cec", "product.ini");
    // The third table has a value more than it uses.
    assert_eq!(findings, ["W0901 45:1"]);
    assert_eq!(tables.lookups.iter().map(|one| one.factor).collect::<Vec<_>>(), [None, Some(0), None]);
    let mut command = AxisVector::default();
    command[Axis::X] = -625.0;
    command[Axis::Y] = -675.0;
    command[Axis::Z] = -425.0;
    let correction = |tables: &Tables| {
        Control::new(&demo(), tables).correction(&command, &Vector::zeros(), &State::default())[Axis::X]
    };
    // Z: (0.0048 + 0.0037) / 2, Y: (0.0055 + 0.0047) / 2, X: (0.032 + 0.053) / 2.
    let (z, y, x) = (0.00425, 0.0051, 0.0425);
    assert!((correction(&tables) - (z + z * y + x)).abs() < 1e-15);
    let beside = Tables { multiplication: Multiplication::Beside, ..tables };
    assert!((correction(&beside) - (z + y + z * y + x)).abs() < 1e-15);
}

/// A table of an axis with values 1 and 3 at 0 and 100, further lines, and the fields that are not among them.
fn ramp(t: usize, more: &str) -> String {
    let fields = [
        ("INPUT_AXIS", "AX1"),
        ("OUTPUT_AXIS", "AX2"),
        ("STEP", "100"),
        ("MIN", "0"),
        ("MAX", "100"),
        ("DIRECTION", "0"),
        ("MULT_BY_TABLE", "0"),
        ("IS_MODULO", "0"),
    ];
    let rest = fields.into_iter().filter(|(name, _)| !more.contains(&format!("$AN_CEC_{name}")));
    let rest: String = rest.map(|(name, value)| format!("$AN_CEC_{name}[{t}]={value}\n")).collect();
    let more = if more.is_empty() { String::new() } else { format!("{more}\n") };
    format!("$AN_CEC[{t},0]=1\n$AN_CEC[{t},1]=3\n{more}{rest}M17\n")
}

#[test]
fn weights_senses_repetition_and_products() {
    let read = |text: &str| {
        let (tables, findings) = read_as(named("cec"), "x.ini", text);
        assert_eq!(findings, [""; 0], "{text}");
        tables
    };
    let y = |tables: &Tables, x: f64, sense: i8| at(tables, Axis::X, x, sense, Axis::Y);
    let weighted = read(&ramp(0, "$SN_CEC_TABLE_WEIGHT[0]=0.5"));
    assert_eq!(y(&weighted, 50.0, 1), 1.0);
    let one_way = read(&ramp(0, "$AN_CEC_DIRECTION[0]=-1"));
    assert_eq!([1, -1, 0].map(|sense| y(&one_way, 50.0, sense)), [0.0, 2.0, 1.0]);
    let repeated = read(&ramp(0, "$AN_CEC_IS_MODULO[0]=1\n$AN_CEC_INPUT_AXIS[0]=C1"));
    let over_c = |position: f64| at(&repeated, Axis::C, position, 1, Axis::Y);
    for (position, value) in [(150.0, 2.0), (-25.0, 2.5), (225.0, 1.5)] {
        assert!((over_c(position) - value).abs() < 1e-12, "{position}");
    }
    // Alone with itself: the square.
    let square = read(&ramp(0, "$AN_CEC_MULT_BY_TABLE[0]=1"));
    assert_eq!(y(&square, 50.0, 1), 4.0);
    // A chain is pairs: 0 times 1, 1 times 2, 2 added.
    let chain =
        read(&(0..3).map(|t| ramp(t, &format!("$AN_CEC_MULT_BY_TABLE[{t}]={}", (t + 2) % 4))).collect::<String>());
    assert_eq!(y(&chain, 50.0, 1), 4.0 + 4.0 + 2.0);
    let sum = read(&(ramp(0, "") + &ramp(5, "")));
    assert_eq!(y(&sum, 50.0, 1), 4.0);
}

#[test]
fn units_and_spellings_of_sag_tables() {
    let inch = read_as(named("cec"), "x.ini", format!("INCH\n{}", ramp(0, ""))).0;
    assert!((at(&inch, Axis::X, 1270.0, 1, Axis::Y) - 2.0 * 25.4).abs() < 1e-12);
    // The units hold for one member of an archive.
    let archive = format!("%_N_NC_CEC_INI\nINCH\n{}%_N_NC_CEC_INI\n{}", ramp(0, ""), ramp(1, ""));
    let (two, findings) = read_as(named("cec"), "x.arc", archive);
    assert_eq!((two.lookups[0].values[0], two.lookups[1].values[0], findings.len()), (25.4, 1.0, 0));
    for (text, expected) in [
        // In which unit a control multiplies is not known.
        (format!("INCH\n{}", ramp(0, "$AN_CEC_MULT_BY_TABLE[0]=1")), vec!["E0901 2:1"]),
        (ramp(0, "$AN_CEC_MULT_BY_TABLE[0]=7"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_TYPE[0]=1"), vec!["E0901 3:17"]),
        (ramp(0, "$AN_CEC[0,99999999999999999999]=1"), vec!["E0901 3:1"]),
        (ramp(0, "$AN_CEC[0.1]=1"), vec!["E0901 3:1"]),
        (ramp(0, "$AN_CEC[999,1]=1"), vec!["E0901 3:1"]),
        (ramp(0, "$AN_CEC[0,1]=1,5"), vec!["E0901 3:14"]),
        (ramp(0, "AN_CEC[0,1]=5"), vec!["E0901 3:1"]),
        (ramp(0, "$AN_CEC[0,1]"), vec!["E0901 3:1"]),
        (
            ramp(0, "INCH\n$AN_CEC[0,1]=3"),
            vec![
                "E0901 4:1",
                "E0901 5:1",
                "E0901 6:1",
                "E0901 7:1",
                "E0901 8:1",
                "E0901 9:1",
                "E0901 10:1",
                "E0901 11:1",
                "E0901 12:1",
            ],
        ),
        (ramp(0, "$AN_CEC[0,1]=3"), vec![]),
        (ramp(0, "$AN_CEC[0,1]=4"), vec!["E0901 3:1"]),
        (ramp(0, "$AN_CEC_DIRECTION[0]=7"), vec!["E0901 3:22"]),
        (ramp(0, "$AN_CEC_MULT_BY_TABLE[0]=0.5"), vec!["E0901 3:26"]),
        (ramp(0, "MSG(\"loaded\")"), vec!["W0901 3:1"]),
        (ramp(0, "$AN_CEC[0,2]=0"), vec![]),
        (ramp(0, "$AN_CEC[0,2]=7"), vec!["W0901 1:1"]),
        (ramp(0, "$SN_CEC_TABLE_ENABLE[0]=0"), vec!["W0901 1:1"]),
        (ramp(0, "$AN_CEC_MAX[0]=150"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_MAX[0]=-1"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_STEP[0]=-100"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_STEP[0]=1e-300"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_MAX[0]=1e300"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_STEP[0]=0"), vec!["W0901 1:1"]),
        (ramp(0, "$AN_CEC_INPUT_AXIS[0]=AX31"), vec!["E0901 1:1"]),
        (ramp(0, "$AN_CEC_INPUT_AXIS [ 0 ] = \"X1\" ; é"), vec![]),
        ("; nothing\n".to_owned(), vec!["E0901 1:1"]),
    ] {
        assert_eq!(read_as(named("cec"), "x.ini", text.clone()).1, expected, "{text}");
    }
}

/// The control keeps what it had in a field that is not written; a file that is cut off says nothing of what is lost.
#[test]
fn fields_that_are_missing_twice_or_impossible() {
    let whole = ramp(0, "");
    let without = |name: &str| -> String {
        whole.lines().filter(|line| !line.contains(name)).map(|line| format!("{line}\n")).collect()
    };
    for name in ["_STEP", "_MIN", "_MAX", "_DIRECTION", "_MULT_BY_TABLE", "_IS_MODULO", "_INPUT_AXIS", "_OUTPUT_AXIS"] {
        assert_eq!(read_as(named("cec"), "x.ini", without(name)).1, ["E0901 1:1"], "{name}");
        let (_, findings) = read_as(named("cec"), "x.ini", whole.replace(name, &format!("{name}S")));
        assert!(findings.contains(&"E0901 1:1".to_owned()), "{name}: {findings:?}");
        assert!(findings.len() > 1, "the name that is not known is told too: {findings:?}");
    }
    assert_eq!(read_as(named("cec"), "x.ini", without("M17")).1, ["W0901 10:1"]);
    let member = whole.replace("M17", "%_N_PART_MPF");
    assert_eq!(read_as(named("cec"), "x.arc", member).1, ["W0901 10:1"]);
    for (more, expected) in [
        ("$AN_CEC_MAX[0]=90", "E0901 11:1"),
        ("$AN_CEC_INPUT_AXIS[0]=AX3", "E0901 11:1"),
        ("$AN_CEC_MULT_BY_TABLE[0]=1", "E0901 11:1"),
        ("$AN_CEC_IS_MODULO[0]=7", "E0901 11:22"),
        ("$SN_CEC_TABLE_ENABLE[0]=2", "E0901 11:25"),
    ] {
        let text = whole.replace("M17", &format!("{more}\nM17"));
        assert_eq!(read_as(named("cec"), "x.ini", text).1, [expected], "{more}");
    }
    // A linear axis never comes round to where the table begins.
    assert_eq!(read_as(named("cec"), "x.ini", ramp(0, "$AN_CEC_IS_MODULO[0]=1")).1, ["E0901 1:1"]);
}

#[test]
fn an_archive_of_a_control() {
    let (tables, findings) = sample("cec", "archive.arc");
    // A value too many (17), a table that is not in use.
    assert_eq!(findings, ["W0901 12:5", "W0901 23:1"]);
    let [sag] = &tables.lookups[..] else { panic!("{tables:?}") };
    assert_eq!((sag.input, sag.output, sag.nodes.count()), (Axis::Y, Axis::Z, 4));
    // 290 mm in steps of 100: the last point is at MAX.
    assert_eq!(sag.values, [0.0, 0.004, 0.006, 0.002]);
    assert!((at(&tables, Axis::Y, -605.0, 1, Axis::Z) - 0.004).abs() < 1e-15);
    let (tables, findings) = sample("enc", "archive.arc");
    assert_eq!(findings, [""; 0]);
    // A positive value moves the axis in the negative direction.
    for (x, value) in [(-300.0, -0.003), (0.0, -0.0065), (200.0, -0.01)] {
        assert!((at(&tables, Axis::X, x, 1, Axis::X) - value).abs() < 1e-15, "{x}");
    }
    // Old files end their lines with a carriage return alone.
    let text: Vec<u8> = fs::read(repository("samples/tables/archive.arc")).unwrap();
    let old: Vec<u8> = text.into_iter().filter(|&byte| byte != b'\n').collect();
    assert_eq!(read_as(named("enc"), "old.arc", old), (tables, Vec::new()));
}

#[test]
fn leadscrew_tables_of_two_measuring_systems() {
    let table = |m: usize, value: f64| {
        format!(
            "$AA_ENC_COMP[{m},0,Z1]={value}\n$AA_ENC_COMP[{m},1,Z1]=0\n$AA_ENC_COMP_STEP[{m},Z1]=10\n\
             $AA_ENC_COMP_MIN[{m},Z1]=0\n$AA_ENC_COMP_MAX[{m},Z1]=10\n$AA_ENC_COMP_IS_MODULO[{m},Z1]=0\nM17\n"
        )
    };
    // Which of both is at work is not in the file; one that is not in use has no step.
    let (_, findings) = read_as(named("enc"), "x.ini", table(0, 0.5) + &table(1, 0.7));
    assert_eq!(findings, ["E0901 8:1"]);
    let idle = table(1, 0.0).replace("STEP[1,Z1]=10", "STEP[1,Z1]=0");
    let (tables, findings) = read_as(named("enc"), "x.ini", table(0, 0.5) + &idle);
    assert_eq!((at(&tables, Axis::Z, 0.0, 1, Axis::Z), findings), (-0.5, vec!["W0901 8:1".to_owned()]));
    for (from, to, place) in [
        ("STEP[0,Z1]=10", "STEP[0,Z1]=-10", "E0901 1:1"),
        ("MAX[0,Z1]=10", "MAX[0,Z1]=20", "E0901 1:1"),
        ("IS_MODULO[0,Z1]=0", "IS_MODULO[0,Z1]=1", "E0901 1:1"),
        ("IS_MODULO[0,Z1]=0", "IS_MODULO[0,Z1]=7", "E0901 6:30"),
        ("MIN[0,Z1]", "MINN[0,Z1]", "E0901 1:1"),
        ("MAX[0,Z1]=10\n", "", "E0901 3:1"),
        ("M17", "$AA_ENC_COMP[0,0,Z1]=3\nM17", "E0901 7:1"),
        ("M17", "$AA_ENC_COMP_MAX[0,Z1]=11\nM17", "E0901 7:1"),
        ("M17", "", "W0901 6:1"),
    ] {
        let findings = read_as(named("enc"), "x.ini", table(0, 0.5).replace(from, to)).1;
        assert!(findings.contains(&place.to_owned()) || to.is_empty(), "{to}: {findings:?}");
        assert!(!findings.is_empty(), "{from}");
    }
    assert_eq!(read_as(named("enc"), "x.ini", table(2, 0.5)).1[0], "E0901 1:1");
}

/// Spaan, Table 6.1: µm and arc seconds, one arc second is π/648000 rad.
#[test]
fn the_table_of_spaan() {
    let (tables, findings) = sample("grundig", "spaan.txt");
    assert_eq!(findings, [""; 0]);
    let errors = tables.errors.unwrap();
    assert_eq!(
        errors.axes.iter().map(|one| (one.axis, one.positions.len())).collect::<Vec<_>>(),
        [(Axis::X, 3), (Axis::Y, 3), (Axis::Z, 3)]
    );
    let row = errors.axes[0].values[0];
    for (found, expected) in row.into_iter().zip([0.010, 0.006, -0.006, -4.848_136_811e-6, 0.0, 1.454_441_043e-5]) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }
    // As printed, with R2 twice.
    let (_, findings) = read_as(named("grundig"), "x", "S2\tP-480\tT1=3\nS2 P-460 T1=1 T2=7 T3=4 R1=0 R2=1 R2=1\n");
    assert_eq!(findings[5..], ["E0901 2:35"]);
    for (text, expected) in [
        ("S4 P1 T1=1", "E0901 1:1"),
        ("S1 P0 T1=1 T2=0 T3=0 R1=0 R2=0 R3=0\nS1 P0 T1=1 T2=0 T3=0 R1=0 R2=0 R3=0", "E0901 2:1"),
        ("S1 T1=1", "E0901 1:1"),
        ("S1 P1 T1=1x", "E0901 1:7"),
        ("S1 P1 Q1=1", "E0901 1:7"),
        ("..", "E0901 1:1"),
    ] {
        let findings = read_as(named("grundig"), "x", text).1;
        assert!(findings.contains(&expected.to_owned()), "{text}: {findings:?}");
    }
}

#[test]
fn a_screw_of_linuxcnc() {
    let (tables, findings) = sample("comp", "xscrew.comp");
    assert_eq!(findings, [""; 0]);
    // Nominal minus position is added: at -200 up 0.004, down -0.002.
    let x = |position: f64, sense: i8| at(&tables, Axis::X, position, sense, Axis::X);
    for (position, sense, value) in
        [(-200.0, 1, 0.004), (-200.0, -1, -0.002), (-100.0, 1, 0.002), (225.25, 1, -0.0035), (999.0, -1, -0.015)]
    {
        assert!((x(position, sense) - value).abs() < 1e-12, "{position} {sense}");
    }
    for (name, text, expected) in [
        // The control stops at a remark.
        ("x.comp", "0 0.001 0\n90 0.002 0.001\n# half\n95 0 0\n", vec!["W0901 4:1"]),
        ("x.comp", "# first\n0 0 0\n", vec!["E0901 1:1"]),
        ("screw.comp", "0 0.001 0\n500 0.001 0\n", vec!["E0901 1:1"]),
        ("x.comp", "0 0 0\n0.001 0.001 0\n", vec!["E0901 1:1"]),
        ("x.comp", "0 0 0\n0 1 1\n", vec!["E0901 2:1"]),
        ("screw.comp", "0 0.1 0.1\n0.2 0.1 0\n# axis Z\n# COMP_FILE_TYPE = 1\n", vec![]),
    ] {
        assert_eq!(read_as(named("comp"), name, text).1, expected, "{text}");
    }
}

/// A block over Z and X, in either order of columns and of rows, is the block over X alone and the block over Z alone.
#[test]
fn errors_over_two_axes_are_read_in_either_order() {
    let own = read_as(named("isg"), "a.csv", "X EXX EYX\n0 0.001 0\n100 0.003 0.002\n#\nZ EZZ\n5 0\n25 0.004\n");
    assert_eq!(own.1, [""; 0]);
    let value = |x: f64, z: f64| {
        let (exx, eyx) = if x == 0.0 { ("0.001", "0") } else { ("0.003", "0.002") };
        (exx, eyx, if z == 5.0 { "0" } else { "0.004" })
    };
    let places = [(0.0, 5.0), (100.0, 5.0), (0.0, 25.0), (100.0, 25.0)];
    let row = |head: &str, order: [usize; 4], line: fn(f64, f64, (&str, &str, &str)) -> String| {
        order.iter().fold(format!("{head}\n"), |text, &index| {
            let (x, z) = places[index];
            text + &line(x, z, value(x, z))
        })
    };
    for text in [
        row("Z X EXX EYX EZZ", [0, 1, 2, 3], |x, z, (a, b, c)| format!("{z} {x} {a} {b} {c}\n")),
        row("X Z EXX EYX EZZ", [0, 2, 1, 3], |x, z, (a, b, c)| format!("{x} {z} {a} {b} {c}\n")),
        row("EZZ X EYX Z EXX", [3, 1, 0, 2], |x, z, (a, b, c)| format!("{c};{x};{b};{z};{a}\n")),
    ] {
        let (tables, findings) = read_as(named("isg"), "b.csv", text.clone());
        assert_eq!(findings, [""; 0], "{text}");
        let found = |tables: &Tables, axis: Axis| {
            tables.errors.as_ref().unwrap().axes.iter().find(|one| one.axis == axis).cloned().unwrap()
        };
        for axis in [Axis::X, Axis::Z] {
            assert_eq!(found(&tables, axis), found(&own.0, axis), "{text}");
        }
    }
}

/// Between its own points an error is linear: EYX at 200 lies half way from −1.2 to 0.8 µm, EXX at 100 half way from 0 to 4 µm.
#[test]
fn the_exchange_format_of_etalon() {
    let (tables, findings) = sample("etalon", "etalon.txt");
    assert_eq!(findings, [""; 0]);
    let errors = tables.errors.unwrap();
    let named_errors = errors.location.iter().map(|(name, value)| (name.to_string(), *value)).collect::<Vec<_>>();
    assert_eq!(named_errors, [("EA0Z".to_owned(), 2e-5), ("EC0Y".to_owned(), -3.5e-5)]);
    assert_eq!(errors.axes[0].positions, [0.0, 100.0, 200.0, 300.0]);
    let of = |index: usize| errors.axes[0].values.iter().map(|row| row[index]).collect::<Vec<_>>();
    assert_eq!(of(0), [0.0, 0.002, 0.004, 0.010]);
    for (found, truth) in of(1).into_iter().zip([0.0, -0.0012, -0.0002, 0.0008]) {
        assert!((found - truth).abs() < 1e-15, "{found} {truth}");
    }
    for (text, expected) in [
        ("[EXX]\nVALUE = 1\n", "E0901 1:1"),
        ("[C0Y]\nGridpoints = {\n0 0\n}\n", "E0901 1:1"),
        ("[EXX]\nGridpoints = {\n0 0\n", "E0901 1:1"),
        ("[EXX]\nGridpoints = {\n5 0\n0 0\n}\n", "E0901 1:1"),
        ("[EXX]\nGridpoints = {\n0,0 0,5 1\n}\n", "E0901 3:1"),
        ("[C0Y]\nVALUE = 1e-5\n[C0Y]\nVALUE = 2e-5\n", "E0901 3:1"),
        ("[C0Y]\nVALUE = 1,5\n", "E0901 2:8"),
        ("[C0Y]\nPOLY = 1\n", "E0901 2:1"),
        ("[PXA]\nVALUE = 1\n", "E0901 1:1"),
        ("VALUE = 1\n", "E0901 1:1"),
    ] {
        assert!(read_as(named("etalon"), "e.txt", text).1.contains(&expected.to_owned()), "{text}");
    }
}

/// The example of the manual: values of the points 33 to 49, reference 40. Sums on either side of the reference position, by hand.
#[test]
fn the_pitch_errors_of_a_fanuc_manual() {
    let (tables, findings) = sample("pitch", "x-pitch.csv");
    assert_eq!(findings, [""; 0]);
    let x = |position: f64| at(&tables, Axis::X, position, 1, Axis::X) * 1e3;
    // Point 41 (50 mm) has +2; 42 adds 1; 46 is 2 + 1 + 0 − 1 − 1 − 2 = −1. Downwards the value of each section is taken away.
    for (position, um) in [
        (0.0, 0.0),
        (50.0, 2.0),
        (100.0, 3.0),
        (300.0, -1.0),
        (450.0, 2.0),
        (-50.0, 1.0),
        (-150.0, 2.0),
        (-250.0, 4.0),
        (-400.0, 0.0),
        (25.0, 1.0),
    ] {
        assert!((x(position) - um).abs() < 1e-9, "{position}: {}", x(position));
    }
    let text = fs::read_to_string(repository("samples/tables/x-pitch.csv")).unwrap();
    for (what, with) in [
        ("3624,X,50\n", ""),
        ("3623,X,1\n", "3623,X,0\n"),
        ("3621,X,33", "3621,X,41"),
        ("40,X,0,-1\n", ""),
        ("40,X,0,-1", "40,X,5,-1"),
        ("40,X,0,-1", "40,X,0,-1.5"),
        ("3620,X,40", "3620,Q,40"),
        ("40,X,0,-1", "40,X,0,-1\n40,X,0,-1"),
    ] {
        let (tables, findings) = read_as(named("pitch"), "p.csv", text.replace(what, with));
        assert!(findings.iter().any(|one| one.starts_with("E0901")) && tables.is_empty(), "{what}: {findings:?}");
    }
}

/// A change of 40 µm between two points needs the magnification 6 (7 x 6 = 42 µm): the sums are rounded to 6 µm, not each change, so that the error of
/// rounding stays below 3 µm all along the axis.
#[test]
fn large_pitch_errors_take_a_magnification() {
    let exact = [0.0, 0.040, 0.050, 0.060, 0.070, 0.080, 0.090];
    let one = Lookup::added(Axis::X, Axis::X, even(-100.0, 100.0, 500.0), exact.to_vec());
    let mut tables = Tables { lookups: vec![one], ..Tables::default() };
    (named("pitch").round)(&mut tables);
    assert_eq!(named("pitch").faults_of(&tables, &Wiring::usual()), [""; 0]);
    let files = write(named("pitch"), &tables);
    assert!(files[0].text.contains("\n3623,X,6\n"), "{}", files[0].text);
    // At the reference position the control adds nothing: the correction there, 40 µm, is taken from all.
    for (index, value) in exact.into_iter().enumerate() {
        let found = at(&tables, Axis::X, index as f64 * 100.0 - 100.0, 1, Axis::X);
        let sixth = ((value - 0.040) / 0.006_f64).round() * 0.006;
        assert!((found - sixth).abs() < 1e-9 && (found - value + 0.040).abs() <= 0.003, "{index}: {found}");
    }
}

/// The example of the manual: 19866.7 µm programmed, 19856.5 µm reached upwards and 19874.7 µm downwards are -102 and 80.
#[test]
fn a_leadscrew_list_of_twincat() {
    let (tables, findings) = sample("ssfk", "y-screw.lis");
    assert_eq!(findings, [""; 0]);
    let y = |position: f64, sense: i8| at(&tables, Axis::Y, position, sense, Axis::Y);
    assert!((y(19.8667, 1) - 0.0102).abs() < 1e-15 && (y(19.8667, -1) + 0.0080).abs() < 1e-15);
    assert!((y(-0.06665, 1) - 0.0051).abs() < 1e-12, "{}", y(-0.06665, 1));
    let even = "kw.ssfk.interval 10000\nkw.ssfk.kw_startpos -5000\nkw.ssfk.kw_nr_max 2\n\
                kw.ssfk.table[0].pos 10\nkw.ssfk.table[1].pos 30\n";
    let (tables, findings) = read_as(named("ssfk"), "z.lis", even);
    assert_eq!((findings.len(), at(&tables, Axis::Z, 0.0, -1, Axis::Z)), (0, -0.002));
    for (more, expected) in [
        ("kw.ssfk.unit 0\n", "E0901 1:1"),
        ("kw.ssfk.kw_nr_max 3\nkw.ssfk.interval 0", "E0901 1:1"),
        ("kw.ssfk.table[99999].pos 3", "E0901 6:9"),
        ("kw.ssfk.table[1].pos x", "E0901 6:22"),
        ("kw.ssfk.bilateral 1", "E0901 1:1"),
        ("kw.ssfk.manual_activation 1", "W0901 6:9"),
    ] {
        let findings = read_as(named("ssfk"), "z.lis", format!("{even}{more}")).1;
        assert_eq!(findings, [expected], "{more}");
    }
}

#[test]
fn a_matrix_of_linuxcnc() {
    let (tables, findings) = sample("matrixkins", "matrix.hal");
    assert_eq!(findings, [""; 0]);
    assert_eq!(tables.matrix, Some([[1.00012, -0.000031, 0.0], [0.0, 1.0, 2.5e-5], [0.0, 0.0, 1.0]]));
    let mut command = AxisVector::default();
    (command[Axis::X], command[Axis::Y], command[Axis::Z]) = (100.0, 200.0, 400.0);
    let added = Control::new(&demo(), &tables).correction(&command, &Vector::zeros(), &State::default());
    // 100 · 0.00012 - 200 · 0.000031 and 400 · 0.000025.
    assert!((added[Axis::X] - 0.0058).abs() < 1e-12 && (added[Axis::Y] - 0.01).abs() < 1e-12, "{added:?}");
    for (text, expected) in [
        ("setp matrixkins.C_xq 1", "E0901 1:6"),
        ("setp matrixkins.C_xx", "E0901 1:1"),
        ("setp matrixkins.C_xx 1 2", "E0901 1:1"),
        ("setp matrixkins.C_xx one", "E0901 1:22"),
        ("net a => b", "E0901 1:1"),
    ] {
        assert_eq!(read_as(named("matrixkins"), "x.hal", text).1, [expected], "{text}");
    }
}

#[test]
fn columns_of_iso_230_names() {
    let (tables, findings) = sample("isg", "volcomp.csv");
    assert_eq!(findings, [""; 0]);
    let errors = tables.errors.unwrap();
    let squareness = errors.location.iter().map(|(name, value)| (name.to_string(), *value)).collect::<Vec<_>>();
    assert_eq!(squareness, [("EA0Z".to_owned(), 1.2e-5), ("EB0Z".to_owned(), -8e-6), ("EC0Y".to_owned(), 2.1e-5)]);
    assert_eq!(errors.axes[0].values[0], [0.002, 0.001, 0.007, 0.0, 4.2e-6, 3e-6]);
    assert_eq!(errors.axes[1].positions, [0.0, 180.0, 360.0]);
    assert_eq!(errors.axes[1].values[1], [-0.001, 0.0, 0.0, 0.0, 0.0, 2e-5]);
    for (text, expected) in [
        // EXX depends on Z; a place without a row; a place with two rows.
        ("Z X EXX\n0 0 1\n5 0 2\n0 9 1\n5 9 2\n", "E0901 1:1"),
        ("Z X EXX\n0 0 1\n5 0 1\n0 9 1\n", "E0901 1:1"),
        ("Z X EXX\n0 0 1\n5 0 1\n0 9 1\n0 9 1\n", "E0901 1:1"),
        ("Z X Y EXX\n0 0 0 1\n", "E0901 1:1"),
        ("EXX\n1\n", "E0901 1:1"),
        ("X EXY\n0 1\n", "E0901 1:1"),
        ("X EXX\n0 1\n0 1\n", "E0901 1:1"),
        ("X EXX EXX\n0 1 1\n", "E0901 1:7"),
        ("X QQQ\n0 1\n", "E0901 1:3"),
        ("X EXX\n0,0 0,1\n", "E0901 2:1"),
        ("A0Z\n1\n2\n", "E0901 1:1"),
        ("PXA PYA A0Z\n1 1 1\n", "W0901 1:1"),
        ("X EXX\n0 1\n#\nX EYX\n5 1\n", "E0901 4:1"),
    ] {
        assert!(read_as(named("isg"), "x.csv", text).1.contains(&expected.to_owned()), "{text}");
    }
}

#[test]
fn tables_of_heidenhain() {
    let (tables, findings) = sample("heidenhain", "axis-y.com");
    assert_eq!(findings, [""; 0]);
    let y = |position: f64, sense: i8, output: Axis| at(&tables, Axis::Y, position, sense, output);
    assert_eq!(tables.lookups.len(), 3);
    assert_eq!((y(-90.0, 1, Axis::Y), y(-90.0, -1, Axis::Y), y(-90.0, -1, Axis::Z)), (0.0, 0.0012, 0.01));
    // Where BACKLASH is blank its last value holds.
    assert!((y(-70.3392, -1, Axis::Y) - 0.0031).abs() < 1e-15 && (y(-80.1696, 1, Axis::Y) - 0.00135).abs() < 1e-15);
    assert_eq!(sample("heidenhain", "config.cma"), (Tables::default(), Vec::new()));
    for (text, expected) in [
        ("NR AXISPOS X\n0 1 2\n1 1 2\n[END]\n", "E0901 3:1"),
        ("NR AXISPOS X\n0 1 2\n", "E0901 1:1"),
        ("NR POS X\n0 1 2\n[END]\n", "E0901 1:1"),
        ("NR AXISPOS X Y BACKLASH\n0 1 2 3 4\n[END]\n", "E0901 1:1"),
        ("NR AXISPOS X C7\n0 1 2 3\n[END]\n", "W0901 1:1"),
        ("NR AXISPOS X\n0 1 2 3\n[END]\n", "E0901 2:1"),
    ] {
        let findings = read_as(named("heidenhain"), "z.com", text).1;
        assert!(findings.contains(&expected.to_owned()), "{text}: {findings:?}");
    }
    assert_eq!(read_as(named("heidenhain"), "table.com", "NR AXISPOS X\n0 1 2\n[END]\n").1, ["E0901 1:1"]);
    let inch = read_as(named("heidenhain"), "z.com", "BEGIN T .COM INCH\nNR AXISPOS X\n0 1 2\n1 2 4\n[END]\n").0;
    assert!((at(&inch, Axis::Z, 38.1, 1, Axis::X) - 3.0 * 25.4).abs() < 1e-12);
}

#[test]
fn a_grid_of_nodes() {
    let (tables, findings) = sample("fanuc", "grid.csv");
    assert_eq!(findings, [""; 0]);
    let mut command = AxisVector::default();
    (command[Axis::X], command[Axis::Y], command[Axis::Z]) = (40.0, -20.0, 15.0);
    let added = Control::new(&demo(), &tables).correction(&command, &Vector::zeros(), &State::default());
    // (40 - 2·20 - 15) · 1e-5 for X; Y from 0 to 0.002 over 50 mm; Z from 0.001 to 0.003 over 20 mm.
    for (axis, value) in [(Axis::X, -0.00015), (Axis::Y, 0.0012), (Axis::Z, 0.0015)] {
        assert!((added[axis] - value).abs() < 1e-12, "{axis}: {}", added[axis]);
    }
    let text = fs::read_to_string(repository("samples/tables/grid.csv")).unwrap();
    // Formats with equal steps take named points that are as far apart.
    let nodes = Nodes::At(vec![-10.0, -9.9, -9.8, -9.75]);
    let mut named_points =
        Tables { lookups: vec![Lookup::added(Axis::X, Axis::X, nodes, vec![0.0; 4])], ..Tables::default() };
    (self::named("enc").round)(&mut named_points);
    assert_eq!(named_points.lookups[0].nodes, even(-10.0, 0.1, -9.75));
    for (from, to, expected) in [
        ("8,100,0,30", "8,100,0,31", "E0901 14:9"),
        ("8,100", "9,100", "E0901 14:1"),
        ("Z,10,20,2", "Z,10,20,3", "E0901 1:1"),
        ("Z,10,20,2", "Y,10,20,2", "E0901 5:1"),
        ("Z,10,20,2", "C,10,20,2", "E0901 5:1"),
        ("Z,10,20,2", "Z,10,20,1", "E0901 5:1"),
        ("Z,10,20,2", "Z,10,20,9999999999999", "E0901 5:1"),
    ] {
        let findings = read_as(named("fanuc"), "x.csv", text.replace(from, to)).1;
        assert!(findings.contains(&expected.to_owned()), "{to}: {findings:?}");
    }
}
