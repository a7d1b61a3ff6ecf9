//! What is too much: every limit of `docs/reference/limits.md` is met through the command itself. Whatever a program, a machine file, a table or a link in a
//! folder asks for, the run ends soon, in little memory, with a finding at its place, and leaves the old output as it was.
#![cfg(target_os = "linux")]

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::support::{Run, Shop, machine, repository};

const OLD: &[u8] = b"the file of yesterday";
/// Address space of a run unless a test says another, KiB: what is met here takes little, and threads reserve more than they use.
const SPACE_KIB: u64 = 4 << 20;
/// Nothing here may take longer, on whatever machine it runs.
const PATIENCE: Duration = Duration::from_secs(60);
/// Memory beside the text, KiB.
const LITTLE_KIB: u64 = 64 << 10;

/// A dialect: its name, the machine, the name of the program, what stands before the lines of a case, and behind them.
struct Language {
    name: &'static str,
    machine: &'static str,
    file: &'static str,
    head: &'static str,
    end: &'static str,
}

const SINUMERIK: Language = Language {
    name: "sinumerik",
    machine: "demo",
    file: "in.mpf",
    head: "G90 G54 G0 X0 Y0 Z0\nG1 X1 F1000\n",
    end: "M30\n",
};
const FANUC: Language = Language {
    name: "fanuc",
    machine: "vmc",
    file: "in.nc",
    head: "O1\nG90 G54 G0 X0. Y0. Z0.\nG1 X1. F1000.\n",
    end: "M30\n",
};
const RS274: Language = Language {
    name: "rs274",
    machine: "knee_mill",
    file: "in.ngc",
    head: "G21 G90 G54 G0 X0 Y0 Z0\nG1 X1 F1000\n",
    end: "M2\n",
};
const GRUNDIG: Language = Language {
    name: "grundig",
    machine: "universal_mill",
    file: "in.pm",
    head: "%PM9001\nN9001\nN1 G54\nN2 G0 X0 Y0 Z0\nN3 G1 X1 F1000\n",
    end: "N999 M30\n",
};

impl Language {
    /// The program with lines between head and end; those of a Grundig have numbers from 10 on.
    fn program(&self, lines: &str) -> String {
        let number = |(index, line): (usize, &str)| match self.name {
            "grundig" if !line.starts_with(['%', 'N']) => format!("N{} {line}\n", 10 + index),
            _ => format!("{line}\n"),
        };
        self.head.to_owned() + &lines.lines().enumerate().map(number).collect::<String>() + self.end
    }

    /// The line in the file of the first line of a case.
    fn first(&self) -> usize {
        self.head.lines().count() + 1
    }

    /// A folder with the program and an output of yesterday.
    fn shop(&self, lines: &str) -> Shop {
        Shop::new().file(self.file, self.program(lines)).file("out.nc", OLD)
    }

    fn arguments(&self, more: &[&str]) -> Vec<String> {
        let machine = machine(self.machine);
        let own = [self.file, "-o", "out.nc", "--machine", &machine];
        own.iter().chain(more).map(|text| (*text).to_owned()).collect()
    }

    /// Corrects the program.
    fn fix(&self, lines: &str, more: &[&str]) -> (Shop, Seen) {
        let shop = self.shop(lines);
        let seen = watch(&shop, &self.arguments(more));
        (shop, seen)
    }

    /// The program is refused with this code in the line of the case, and the old output stays.
    #[track_caller]
    fn refuses(&self, lines: &str, code: &str, line: usize) -> Seen {
        let (shop, seen) = self.fix(lines, &[]);
        let place = format!("{}:{}:", self.file, self.first() + line - 1);
        seen.demand(&shop, code, &place);
        assert!(shop.names().len() == 2, "{:?}", shop.names());
        seen
    }
}

/// A run, how long it took and how much memory it had.
struct Seen {
    run: Run,
    time: Duration,
    peak_kib: u64,
}

impl Seen {
    /// An error with this code at this place, little memory, and the old output.
    #[track_caller]
    fn demand(&self, shop: &Shop, code: &str, place: &str) {
        let said = &self.run.stderr;
        let cut: String = said.chars().take(3000).collect();
        assert!(self.run.code == 3 || self.run.code == 4, "{} {cut}", self.run.code);
        assert!(said.contains(&format!("error[{code}]")) && said.contains(place), "{code} {place}: {cut}");
        assert!(shop.bytes("out.nc") == OLD, "{code} {place}");
        assert!(self.peak_kib < LITTLE_KIB, "{code} {place}: {} KiB", self.peak_kib);
        // Nobody reads a number of 309 digits.
        assert!(!said.lines().filter(|line| line.starts_with("error")).any(has_long_number), "{cut}");
    }

    /// Wrong usage with this sentence, nothing read to speak of, and the old output.
    #[track_caller]
    fn demand_usage(&self, shop: &Shop, sentence: &str) {
        assert!(self.run.code == 2 && self.run.stderr.contains(sentence), "{} {}", self.run.code, self.run.stderr);
        assert!(shop.bytes("out.nc") == OLD, "{sentence}");
    }
}

fn has_long_number(line: &str) -> bool {
    line.split(|letter: char| !letter.is_ascii_digit()).any(|digits| digits.len() > 24)
}

fn watch<S: AsRef<str>>(shop: &Shop, arguments: &[S]) -> Seen {
    watch_within(shop, arguments, SPACE_KIB)
}

/// Runs the command with so much address space and sees how much memory it takes. One that goes on for too long is ended.
fn watch_within<S: AsRef<str>>(shop: &Shop, arguments: &[S], space_kib: u64) -> Seen {
    let line = format!("ulimit -v {space_kib}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &line, env!("CARGO_BIN_EXE_ncfix")]).args(arguments.iter().map(AsRef::as_ref));
    command.current_dir(shop.path("")).env_remove("NCFIX_MACHINE").stdin(std::process::Stdio::null());
    command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let start = Instant::now();
    let child = command.spawn().unwrap();
    let id = child.id();
    let ending = std::thread::spawn(move || child.wait_with_output().unwrap());
    let mut peak_kib = 0;
    while !ending.is_finished() {
        let status = fs::read_to_string(format!("/proc/{id}/status")).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        peak_kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(peak_kib);
        if start.elapsed() > PATIENCE {
            Command::new("kill").args(["-KILL", &id.to_string()]).status().unwrap();
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let (output, time) = (ending.join().unwrap(), start.elapsed());
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let arguments: Vec<&str> = arguments.iter().map(AsRef::as_ref).collect();
    let code = output.status.code().unwrap_or_else(|| panic!("{} after {time:?}: {arguments:?}", output.status));
    Seen {
        run: Run { code, stdout: text(output.stdout), stderr: text(output.stderr), command: String::new() },
        time,
        peak_kib,
    }
}

/// A file of zeros that takes no room on the disk.
fn sparse(shop: &Shop, name: &str, bytes: u64) {
    fs::File::create(shop.path(name)).unwrap().set_len(bytes).unwrap();
}

/// The demo machine with one text replaced.
fn demo(old: &str, new: &str) -> String {
    let text = fs::read_to_string(repository("samples/machines/demo.toml")).unwrap();
    assert!(text.contains(old), "{old}");
    text.replacen(old, new, 1)
}

const ALL: [&Language; 4] = [&SINUMERIK, &FANUC, &RS274, &GRUNDIG];

/// What meets the limits of the table, by the names of its rows: the language, lines, code, and the line of the finding among them.
fn met(row: &str) -> Vec<(&'static Language, String, &'static str, usize)> {
    let assigned = |language: &Language, value: &str| match language.name {
        "sinumerik" => format!("R1={value}"),
        "grundig" => format!("E1={value}"),
        _ => format!("#1=[{value}]"),
    };
    let nested = |language: &Language, depth: usize| {
        let [open, close] = if matches!(language.name, "fanuc" | "rs274") { ["[", "]"] } else { ["(", ")"] };
        assigned(language, &(open.repeat(depth) + "1" + &close.repeat(depth)))
    };
    let all = |line: &dyn Fn(&Language) -> String, code: &'static str| {
        ALL.map(|language| (language, line(language), code, 1)).to_vec()
    };
    match row {
        "length of a block" => all(&|_| "X".to_owned() + &"0".repeat(5000), "E0109"),
        "nested brackets and signs" => all(&|language| nested(language, 66), "E0107"),
        "operators of an expression, Fanuc, RS274/NGC and Grundig" => [&FANUC, &RS274, &GRUNDIG]
            .map(|language| (language, assigned(language, &["1"; 600].join("+")), "E0107", 1))
            .to_vec(),
        "operators of an expression, Sinumerik" => {
            vec![(&SINUMERIK, assigned(&SINUMERIK, &["1"; 600].join("+")), "E0107", 1)]
        }
        "nested control structures, Sinumerik" => {
            vec![(&SINUMERIK, "IF TRUE\n".repeat(40) + &"ENDIF\n".repeat(40), "E0107", 33)]
        }
        // The place is that of the whole file, or of the part behind the last one that is read.
        "lines that cannot be read" => all(&|_| "X2.2.2\n".repeat(1001), "E0110"),
        "programs in one file" => vec![(&FANUC, "M30\n".to_owned() + &"O7 M99\n".repeat(10_001), "E0110", 10_001)],
        "blocks of a run" => vec![
            (&SINUMERIK, "WHILE TRUE\nENDWHILE".into(), "E0214", 1),
            (&FANUC, "WHILE[1EQ1]DO1\nEND1".into(), "E0214", 1),
            (&RS274, "o1 while [1]\no1 endwhile".into(), "E0214", 1),
            (&GRUNDIG, "E1=1\nG29 E1 E1=1 N=11".into(), "E0214", 2),
        ],
        "levels of programs" => vec![(&SINUMERIK, "IN".into(), "E0213", 1), (&FANUC, "M98 P1".into(), "E0213", 1)],
        "levels of programs, RS274/NGC" => {
            vec![(&RS274, "o<a> sub\no<a> call\no<a> endsub\no<a> call".into(), "E0213", 2)]
        }
        "levels of macros, Grundig" => {
            vec![(&GRUNDIG, "G22 N=9002\nN900 M30\n%MM9002\nN9002\nN1 G22 N=9002".into(), "E0213", 5)]
        }
        "repetitions of a call, Fanuc and RS274/NGC" => vec![
            (&FANUC, "M98 P9 L999999999\nM30\nO9\nM99".into(), "E0210", 1),
            (&RS274, "M98 P100 L999999999".into(), "E0210", 1),
        ],
        "repetitions, Sinumerik" => vec![
            (&SINUMERIK, "HERE:\nX2\nREPEAT HERE P=2147483648".into(), "E0210", 3),
            (&SINUMERIK, "CALL \"L7\" P2147483648".into(), "E0210", 1),
        ],
        "passes of G14, Grundig" => vec![(&GRUNDIG, "X2\nX1\nG14 N1=10 N2=11 J2000000000".into(), "E0210", 3)],
        "value of a word, Fanuc and RS274/NGC" => {
            [&FANUC, &RS274].map(|language| (language, "X2. F9999999999.".to_owned(), "E0210", 1)).to_vec()
        }
        "value of a word, Grundig" => vec![(&GRUNDIG, "X2 F9999999999".into(), "E0210", 1)],
        "feed and speed, Sinumerik" => {
            vec![(&SINUMERIK, "X2 F=1EX308".into(), "E0210", 1), (&SINUMERIK, "S=-1EX308 M3".into(), "E0210", 1)]
        }
        "turns of a helix, RS274/NGC" => vec![(&RS274, "G2 X3 I1 J0 P1000".into(), "E0210", 1)],
        // 300 000 holes of at least four steps.
        "steps of a block with a drilling cycle, Fanuc and RS274/NGC" => vec![
            (&FANUC, "G91 G81 X0.001 Z-1. R0. K300000".into(), "E0210", 1),
            (&RS274, "G91 G81 X0.001 Z-1 R0 L300000".into(), "E0210", 1),
        ],
        "turns of a helix, Sinumerik" => vec![(&SINUMERIK, "G2 X2 I1 J0 TURN=1000".into(), "E0210", 1)],
        "elements of local arrays, Sinumerik" => vec![(&SINUMERIK, "DEF REAL AR[999999999]".into(), "E0207", 1)],
        "blocks made of texts (EXECSTRING)" => {
            vec![(&SINUMERIK, "DEF INT II\nFOR II=1 TO 10001\nEXECSTRING(\"R1=\"<<II)\nENDFOR".into(), "E0201", 3)]
        }
        _ => Vec::new(),
    }
}

/// A number of the table: `4 294 967 294`, `1e9`.
fn number(text: &str) -> f64 {
    text.replace(' ', "").parse().unwrap_or_else(|_| panic!("'{text}' is no number"))
}

/// The value of a constant as the sources write it: numbers, shifts, the largest of a type.
fn value(text: &str) -> f64 {
    let text = text.replace('_', "");
    if text == "u32::MAX as usize - 1" {
        return f64::from(u32::MAX) - 1.0;
    }
    match text.split_once(" << ") {
        Some((mantissa, places)) => number(mantissa) * number(places).exp2(),
        None => number(&text),
    }
}

/// A row of the table.
struct Row {
    what: String,
    limit: f64,
    /// Files that have the constant.
    files: Vec<String>,
    constant: String,
    code: String,
}

fn rows() -> Vec<Row> {
    let text = fs::read_to_string(repository("docs/reference/limits.md")).unwrap();
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let table =
        text.lines().skip_while(|line| !line.starts_with("| what |")).skip(2).take_while(|line| line.starts_with('|'));
    let quoted = |cell: &str| cell.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    table
        .map(|line| {
            let cells = cells(line);
            let [what, limit, code, _, place] = cells.as_slice() else { panic!("five cells: {line}") };
            let place = quoted(place);
            let (name, files) = place.split_last().unwrap_or_else(|| panic!("no constant: {line}"));
            let limit = limit.split(|letter: char| letter.is_alphabetic() && letter != 'e').next().unwrap();
            Row {
                what: what.clone(),
                limit: number(limit),
                files: files.to_vec(),
                constant: name.clone(),
                code: code.trim_matches('`').to_owned(),
            }
        })
        .collect()
}

#[test]
fn the_table_of_limits_has_the_numbers_of_the_program() {
    let rows = rows();
    assert!(rows.len() > 15);
    for Row { what, limit, files, constant: name, .. } in &rows {
        assert!(!files.is_empty(), "{what}");
        for file in files {
            let source = fs::read_to_string(repository(file)).unwrap_or_else(|_| panic!("{what}: there is no {file}"));
            // A constant, or the default of a setting.
            let constant = format!("const {name}: ");
            let setting = format!("{name}: ");
            let written = source.lines().find_map(|line| match line.contains(&constant) {
                true => line.rsplit(" = ").next().map(|written| written.trim_end_matches(';')),
                false => line
                    .trim()
                    .strip_prefix(&setting)?
                    .strip_suffix(',')
                    .filter(|written| written.as_bytes()[0].is_ascii_digit()),
            });
            let written = written.unwrap_or_else(|| panic!("{what}: {file} has no {name}"));
            assert!(value(written) == *limit, "{what}: {limit} in the table, {written} in {file}");
        }
    }
}

#[test]
fn every_limit_of_programs_is_met_with_its_finding() {
    let mut told = BTreeMap::new();
    for Row { what, code, .. } in rows() {
        let cases = met(&what);
        for (language, lines, expected, line) in &cases {
            assert_eq!(*expected, code, "{what}");
            let seen = language.refuses(lines, expected, *line);
            assert!(seen.time < PATIENCE);
        }
        told.insert(what, cases.len());
    }
    // What no program meets has a test of its own below.
    let others: Vec<&str> = told.iter().filter(|(_, cases)| **cases == 0).map(|(what, _)| what.as_str()).collect();
    assert_eq!(
        others,
        [
            "coefficient of an error function",
            "ends of a travel",
            "shortest travel",
            "size of a file of an instrument, bytes",
            // The test is that of the crate: feed::dialogue::lsv2.
            "size of a file that a link sends, bytes",
            "size of a hand-written file, bytes",
            "size of a program, a table, an archive, bytes",
            "size of a stream, bytes",
            "size of a temperature log that is replayed, bytes",
            "smallest sampling distance for the curvature of an error, linear",
        ]
    );
}

#[test]
fn repetitions_without_end_end() {
    let repeated = [
        (&SINUMERIK, "AA:\nREPEATB AA P=1000000000", "E0214"),
        (&SINUMERIK, "AA: X2\nX1\nBB:\nREPEAT AA BB P=1000000000", "E0214"),
        (&SINUMERIK, "LOOP\nX2\nX1\nENDLOOP", "E0214"),
        (&SINUMERIK, "DEF INT II\nFOR II=1 TO 1000000000\nENDFOR", "E0214"),
        (&SINUMERIK, "DEF REAL AR\nFOR AR=1 TO 1EX308\nENDFOR", "E0214"),
        (&SINUMERIK, "REPEAT\nUNTIL FALSE", "E0214"),
        (&SINUMERIK, "AA: GOTOB AA", "E0214"),
        (&SINUMERIK, "DEF STRING[400] TT=\"a\"\nWHILE TRUE\nTT=TT<<TT\nENDWHILE", "E0214"),
        (&FANUC, "M98 P9 L99999999\nM30\nO9\nM99", "E0214"),
        (&FANUC, "G65 P9 L99999999\nM30\nO9\nM99", "E0214"),
        (&FANUC, "N10 GOTO 10", "E0214"),
        (&RS274, "o1 repeat [1000000000]\no1 endrepeat", "E0214"),
        (&RS274, "o1 repeat [1000000000]\nX2\nX1\no1 endrepeat", "E0214"),
        (&RS274, "o1 do\no1 while [1]", "E0214"),
        (&GRUNDIG, "N20 X2\nN21 X1\nN22 G14 N1=20 N2=21 J1000000000", "E0214"),
        (&GRUNDIG, "N20 (a)\nN21 (b)\nN22 G14 N1=20 N2=21 J1000000000", "E0214"),
    ];
    for (language, lines, code) in repeated {
        let (shop, seen) = language.fix(lines, &["--max-blocks", "200000"]);
        seen.demand(&shop, code, language.file);
        assert!(seen.run.stderr.contains("200000 blocks were executed"), "{}", seen.run.stderr);
    }
    // An error is not followed by ten millions of blocks.
    let (shop, seen) = SINUMERIK.fix("R1=1/0\nWHILE TRUE\nENDWHILE", &[]);
    seen.demand(&shop, "E0209", "in.mpf:3:");
    assert!(!seen.run.stderr.contains("E0214"));
}

#[test]
fn programs_that_call_each_other_and_texts_that_execute_themselves_end() {
    let (shop, seen) = SINUMERIK.fix("DEF STRING[50] TX\nTX=\"EXECSTRING(TX)\"\nEXECSTRING(TX)", &[]);
    seen.demand(&shop, "E0213", "text of EXECSTRING:1:");
    FANUC.refuses("M98 P2\nM30\nO2\nM98 P3\nM99\nO3\nM98 P2\nM99", "E0213", 4);
    GRUNDIG.refuses("G23 N=9001", "E0213", 1);
    GRUNDIG.refuses("N20 X2\nN22 G14 N1=20 N2=22 J1000000000", "E0210", 2);
    let shop = SINUMERIK.shop("AAA").file("AAA.SPF", "BBB\nM17\n").file("BBB.SPF", "AAA\nM17\n");
    watch(&shop, &SINUMERIK.arguments(&[])).demand(&shop, "E0213", "AAA.SPF:1:");
    // Nested counts multiply; a program that follows each motion and moves itself does not follow itself.
    let shop = SINUMERIK.shop("AAA P9999").file("AAA.SPF", "BBB P9999\nM17\n").file("BBB.SPF", "M17\n");
    watch(&shop, &SINUMERIK.arguments(&["--max-blocks", "200000"])).demand(&shop, "E0214", "BBB.SPF:1:");
    let shop = SINUMERIK.shop("MCALL AAA\nX1\nX2\nMCALL").file("AAA.SPF", "MCALL AAA\nG1 X2\nM17\n");
    watch(&shop, &SINUMERIK.arguments(&[])).run.exits(0);
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    let digits = "9".repeat(400);
    for language in ALL {
        for word in ["X", "F", "S", "G", "M", "T", "N"] {
            language.refuses(&format!("{word}{digits}"), "E0102", 1);
        }
        language.refuses(&format!("G2 X2. Y0. I{digits}. J0."), "E0102", 1);
        let (variable, root, over) = match language.name {
            "sinumerik" => ("R1", "SQRT(0-1)", "0/0"),
            "grundig" => ("E1", "sqrt(-1)", "0:0"),
            _ => ("#1", "[SQRT[0-1]]", "[0/0]"),
        };
        let is_bracketed = matches!(language.name, "fanuc" | "rs274");
        let product = if is_bracketed { format!("[{variable}*{variable}]") } else { format!("{variable}*{variable}") };
        let use_as = |letter: &str| format!("{letter}{}{variable}", if is_bracketed { "" } else { "=" });
        language.refuses(&format!("{variable}={root}"), "E0209", 1);
        language.refuses(&format!("{variable}={over}"), "E0209", 1);
        // 10 squared nine times is more than a double holds; squared eight times it is 1e256.
        let start = format!("{variable}=10.\n");
        let squared = |times: usize| start.clone() + &format!("{variable}={product}\n").repeat(times);
        language.refuses(&squared(9), "E0209", 10);
        language.refuses(&(squared(8) + "X2. " + &use_as("F")), "E0210", 10);
        language.refuses(&(squared(8) + &use_as("X")), "E0210", 10);
        let code = if language.name == "sinumerik" { "E0203" } else { "E0210" };
        language.refuses(&(squared(8) + "G2 X2. Y0. J0. " + &use_as("I")), code, 10);
        let index = match language.name {
            "sinumerik" => "R2=R[R1]",
            "grundig" => "E2=E(E1)",
            _ => "#2=#[#1]",
        };
        let code = if language.name == "sinumerik" { "E0208" } else { "E0207" };
        language.refuses(&(squared(8) + index), code, 10);
        // What is next to nothing is nothing: 0.1 to the power of 4096, a number that a double rounds to zero, minus zero.
        let tiny = format!("{variable}=0.1\n") + &format!("{variable}={product}\n").repeat(12) + &use_as("X");
        for lines in [tiny, format!("X0.{}1", "0".repeat(3000)), "X-0.".to_owned()] {
            let (shop, seen) = language.fix(&lines, &[]);
            seen.run.exits(0);
            let text = shop.text("out.nc");
            assert!(!text.contains("-0 ") && !text.contains("-0.\n") && !text.contains("-0\n"), "{text}");
            assert!(text.lines().all(|line| !has_long_number(line)), "{text}");
        }
    }
    // The numbers that only a Sinumerik can write, wherever a number may stand.
    for (lines, code, line) in [
        ("R1=1EX309", "E0102", 1),
        ("R1=1EX999999999999999999", "E0102", 1),
        ("X=1EX308", "E0210", 1),
        ("X=-1.7976931348623157EX308", "E0210", 1),
        ("G2 X2 Y0 J0 I=1EX308", "E0203", 1),
        ("G2 X2 Y0 J0 I=1EX-320", "E0205", 1),
        ("AA:\nREPEATB AA P=1EX308", "E0210", 2),
        ("DEF REAL AR[1EX308]", "E0208", 1),
        ("DEF INT II=1EX308", "E0209", 1),
        ("X2 F=1EX-400", "E0215", 1),
    ] {
        if lines.contains("F=") {
            // Only where no feed was programmed before is 0 none.
            let shop =
                Shop::new().file("in.mpf", format!("G90 G54 G0 X0 Y0 Z0\nG1 {lines}\nM30\n")).file("out.nc", OLD);
            watch(&shop, &SINUMERIK.arguments(&[])).demand(&shop, code, "in.mpf:2:");
        } else {
            SINUMERIK.refuses(lines, code, line);
        }
    }
}

#[test]
fn structures_and_lines_of_any_size_take_memory_by_their_text() {
    for language in ALL {
        let [open, close] = if matches!(language.name, "fanuc" | "rs274") { ["[", "]"] } else { ["(", ")"] };
        let deep = format!("X={}1{}", open.repeat(100_000), close.repeat(100_000));
        language.refuses(&deep, "E0109", 1);
    }
    // A hundred thousand structures in each other are a list, not a stack.
    let ifs = (1..=100_000).map(|k| format!("o{k} if [1]\n")).collect::<String>();
    let ends = (1..=100_000).rev().map(|k| format!("o{k} endif\n")).collect::<String>();
    let (_, seen) = RS274.fix(&(ifs + "X2\n" + &ends), &[]);
    assert!(seen.run.code == 0 && seen.peak_kib < 2 * LITTLE_KIB, "{} KiB {}", seen.peak_kib, seen.run.stderr);
    // One line of 100 MB, of letters and of nothing.
    const LONG: usize = 100_000_000;
    let text_kib = LONG as u64 / 1024;
    for (language, letter) in [(&SINUMERIK, "A"), (&FANUC, "("), (&RS274, "X1"), (&GRUNDIG, "1")] {
        let shop = language.shop(&letter.repeat(LONG / letter.len()));
        let seen = watch(&shop, &language.arguments(&[]));
        assert!(seen.run.code == 3 && seen.run.stderr.contains("E0109"), "{}", seen.run.stderr);
        assert!(seen.peak_kib < text_kib + LITTLE_KIB, "{} KiB", seen.peak_kib);
        assert!(shop.bytes("out.nc") == OLD);
    }
    for language in [&SINUMERIK, &GRUNDIG] {
        let shop = Shop::new().file("out.nc", OLD);
        sparse(&shop, language.file, LONG as u64);
        let seen = watch(&shop, &language.arguments(&[]));
        assert!(seen.run.code == 3 && seen.run.stderr.contains("E0110"), "{}", seen.run.stderr);
        assert!(seen.peak_kib < text_kib + LITTLE_KIB, "{} KiB", seen.peak_kib);
    }
}

#[test]
fn files_that_are_too_large_are_not_read() {
    // So little memory that reading any of these would be noticed.
    const SPACE: u64 = 512 << 10;
    let shop = SINUMERIK.shop("X2");
    for (name, bytes) in [("big.mpf", 5 << 30), ("big.toml", 1 << 30), ("SUB.SPF", 5 << 30)] {
        sparse(&shop, name, bytes);
    }
    let too_large = "it has more than 4294967294 bytes";
    let program = watch_within(&shop, &["big.mpf", "-o", "out.nc"], SPACE);
    program.demand_usage(&shop, &format!("cannot read big.mpf: {too_large}"));
    for file in ["big.toml", "/dev/zero"] {
        let seen = watch_within(&shop, &["in.mpf", "-o", "out.nc", "--machine", file], SPACE);
        seen.demand_usage(
            &shop,
            &format!("cannot read {file}: it has more than 8388608 bytes (machine file, --machine)"),
        );
        assert!(seen.peak_kib < LITTLE_KIB, "{file}: {} KiB", seen.peak_kib);
    }
    let setup =
        watch_within(&shop, &["in.mpf", "-o", "out.nc", "--machine", &machine("demo"), "--setup", "big.toml"], SPACE);
    setup.demand_usage(&shop, "cannot read big.toml: it has more than 8388608 bytes");
    // A device has no end; what is read of it has one. With less memory than that it is said as well.
    let endless = watch(&shop, &["/dev/zero", "-o", "out.nc", "--dialect", "sinumerik"]);
    endless.demand_usage(&shop, "cannot read /dev/zero: it has more than 1073741824 bytes");
    let endless = watch_within(&shop, &["correct-readings", "/dev/zero", "-o", "out.nc"], SPACE);
    endless.demand_usage(&shop, "cannot read /dev/zero: out of memory");
    // A subprogram is not said to be missing.
    fs::write(shop.path("in.mpf"), SINUMERIK.program("SUB")).unwrap();
    let seen = watch_within(&shop, &SINUMERIK.arguments(&[]), SPACE);
    seen.demand(&shop, "E0212", "in.mpf:3:");
    assert!(seen.run.stderr.contains(&format!("SUB.SPF cannot be read: {too_large}")), "{}", seen.run.stderr);
}

/// One byte more than the limits of the page: 64 MiB and 256 MiB.
#[test]
fn an_instrument_file_and_a_replayed_log_have_a_largest_size() {
    let shop = Shop::new();
    sparse(&shop, "big.csv", 67_108_865);
    shop.run(["import", "big.csv", "-o", "bar"]).exits(4).says("error[E0617]: big.csv has 64 MB, which is too large");
    sparse(&shop, "big.csv", 67_108_864);
    let fits = shop.run(["import", "big.csv", "-o", "bar"]).exits(4);
    assert!(!fits.stderr.contains("too large"), "{}", fits.stderr);
    sparse(&shop, "log.csv", 268_435_457);
    let sensors = "[source.warm]\nkind = \"replay\"\npath = \"log.csv\"\n\n[channel.T_head]\nsource = \"warm\"\nrange_C = [10, 60]\n";
    fs::write(shop.path("sensors.toml"), sensors).unwrap();
    shop.run(["sensors", "sensors.toml", "--watch", "--for", "1"])
        .exits(4)
        .says("error[E0404]: cannot replay log.csv: it has more than 268435456 bytes");
}

#[test]
fn no_name_of_a_subprogram_leads_out_of_its_folders() {
    let secret =
        Shop::new().file("SECRET.SPF", "SECRET=1\n").file("secret.ngc", "(secret)\n").file("O9000.NC", "SECRET\n");
    let away = secret.path("SECRET").display().to_string();
    let long = "A".repeat(300);
    for name in ["../../etc/passwd", "/etc/passwd", "/_N_../_N_ETC/PASSWD", "..", ".", "/", "", "A\0B", &away, &long] {
        for call in ["CALL \"NAME\"", "EXTCALL(\"NAME\")"] {
            SINUMERIK.refuses(&call.replace("NAME", name), "E0212", 1);
        }
    }
    // Two levels above a program may lie the root of a control, and that of the whole disk.
    let deep = Shop::new()
        .file("jobs/part/in.mpf", SINUMERIK.program("CALL \"/etc/SECRET\""))
        .file("etc/SECRET.SPF", "SECRET=1\n");
    let deep = deep.file("out.nc", OLD).file("MPF.DIR/L5.SPF", "G1 X3\nM17\n");
    let run = || watch(&deep, &["jobs/part/in.mpf", "-o", "out.nc", "--machine", &machine("demo")]);
    run().demand(&deep, "E0212", "in.mpf:3:");
    fs::write(deep.path("jobs/part/in.mpf"), SINUMERIK.program("CALL \"/_N_MPF_DIR/_N_L5_SPF\"")).unwrap();
    run().run.exits(0);
    SINUMERIK.refuses("CALLPATH(\"/../../etc\")\nCALL \"PASSWD\"", "E0212", 2);
    for call in ["o<../../etc/passwd> call", "o</etc/passwd> call", "o<a\0b> call", "M98 P9000"] {
        RS274.refuses(call, "E0212", 1);
    }
    for call in ["M98 <../../etc/passwd>", "M98 </etc/passwd>", "M198 P9000", "G65 <../../x> A1."] {
        FANUC.refuses(call, "E0212", 1);
    }
    // A link out of the folders is said, and nothing of what it leads to; nor is a device, a pipe or a folder a program.
    for (language, call, name, target) in [
        (&SINUMERIK, "SUB", "SUB.SPF", "SECRET.SPF"),
        (&RS274, "o<sub> call", "sub.ngc", "secret.ngc"),
        (&FANUC, "M98 P9000", "O9000.NC", "O9000.NC"),
        (&GRUNDIG, "G22 N=9100", "9100.MM", "SECRET.SPF"),
    ] {
        let refused = |prepare: &dyn Fn(&Shop), expected: &str| {
            let shop = language.shop(call);
            prepare(&shop);
            let seen = watch(&shop, &language.arguments(&[]));
            seen.demand(&shop, "E0212", language.file);
            assert!(seen.run.stderr.contains(expected), "{}", seen.run.stderr);
            assert!(!seen.run.stderr.to_lowercase().contains("secret"), "{}", seen.run.stderr);
        };
        let to = |target: String| move |shop: &Shop| symlink(&target, shop.path(name)).unwrap();
        let out = format!("{name} is a symbolic link that leads out of the folders that belong to the program");
        refused(&to(secret.path(target).display().to_string()), &out);
        refused(&to("/etc/passwd".to_owned()), &out);
        refused(&to(name.to_owned()), "");
        refused(&to("/dev/zero".to_owned()), "");
        refused(&|shop| fs::create_dir(shop.path(name)).unwrap(), "");
        let pipe = |shop: &Shop| assert!(Command::new("mkfifo").arg(shop.path(name)).status().unwrap().success());
        refused(&pipe, "");
        // Within the folder a link is a name like another.
        let shop = language
            .shop("X2.")
            .file("parts/real", if language.name == "grundig" { "%MM9100\nN9100\nN1 X3\n" } else { "G1 X3.\nM99\n" });
        if matches!(language.name, "fanuc" | "grundig") {
            fs::write(shop.path(language.file), language.program(call)).unwrap();
            symlink("parts/real", shop.path(name)).unwrap();
            watch(&shop, &language.arguments(&[])).run.exits(0);
            assert!(
                shop.text("out.nc").contains("X3.0") || shop.text("out.nc").contains("X2.9"),
                "{}",
                shop.text("out.nc")
            );
        }
    }
    // The folders of `search_path` are named by the machine file, and so allowed, links into them too.
    let shop = SINUMERIK
        .shop("SUB")
        .file("m.toml", demo("[control]", &format!("[control]\nsearch_path = [\"{}\"]", secret.path("").display())));
    fs::write(secret.path("SUB.SPF"), "G1 X3\nM17\n").unwrap();
    watch(&shop, &["in.mpf", "-o", "out.nc", "--machine", "m.toml"]).run.exits(0);
}

#[test]
fn links_folders_and_other_names_of_the_input_are_no_outputs() {
    let shop = SINUMERIK.shop("X2").file("new.nc", "");
    let to = |output: &str| watch(&shop, &["in.mpf", "-o", output, "--machine", &machine("demo")]);
    symlink("around", shop.path("around")).unwrap();
    to("around").demand_usage(&shop, "too many links");
    to(".").demand_usage(&shop, "it is a folder");
    watch(&shop, &["around", "-o", "out.nc"]).demand_usage(&shop, "cannot read around: ");
    watch(&shop, &["in.mpf", "-o", "out.nc", "--machine", "around"]).demand_usage(&shop, "cannot read around: ");
    watch(&shop, &["in.mpf", "-o", "out.nc", "--machine", "."])
        .demand_usage(&shop, "it is a folder (machine file, --machine)");
    // A subprogram that is a link to the output would be overwritten under the hands of the run.
    fs::write(shop.path("in.mpf"), SINUMERIK.program("SUB")).unwrap();
    fs::write(shop.path("new.nc"), "G1 X3\nM17\n").unwrap();
    symlink("new.nc", shop.path("SUB.SPF")).unwrap();
    let seen = to("new.nc");
    assert!(seen.run.code == 4 && seen.run.stderr.contains("E0310"), "{}", seen.run.stderr);
    assert_eq!(shop.text("new.nc"), "G1 X3\nM17\n");
}

#[test]
fn machine_files_of_any_size_and_with_any_number_are_understood_or_refused() {
    let refused = |content: &[u8], code: &str, expected: &str, most_kib: u64| {
        let shop = SINUMERIK.shop("X2").file("m.toml", content);
        let seen = watch(&shop, &["in.mpf", "-o", "out.nc", "--machine", "m.toml"]);
        let cut: String = seen.run.stderr.chars().take(2000).collect();
        assert!(seen.run.code == 4 && cut.contains(&format!("error[{code}]")), "{code}: {cut}");
        assert!(cut.contains("m.toml:") && cut.contains(expected), "{expected}: {cut}");
        assert!(shop.bytes("out.nc") == OLD && seen.peak_kib < most_kib, "{expected}: {} KiB", seen.peak_kib);
    };
    let many = |piece: &str, bytes: usize| piece.repeat(bytes / piece.len()).into_bytes();
    const MOST: usize = 8_000_000;
    refused(&vec![0; MOST], "E0401", "a zero byte", LITTLE_KIB);
    refused(&many("\n", 1_000_000), "E0403", "the file has no machine", 2 * LITTLE_KIB);
    refused(&[b"a=".as_slice(), &many("[", MOST)].concat(), "E0401", "recursion", 16 * LITTLE_KIB);
    refused(&[b"a=".as_slice(), &many("{a=", 300_000)].concat(), "E0401", "recursion", 2 * LITTLE_KIB);
    refused(&[many("a.", 400_000).as_slice(), b"a=1"].concat(), "E0401", "recursion", 4 * LITTLE_KIB);
    let keys: String = (0..80_000).map(|k| format!("k{k}=1\n")).collect();
    refused(keys.as_bytes(), "E0402", "unknown key k0", 4 * LITTLE_KIB);
    let motion = |kind: &str| demo("[location]", &format!("[[motion]]\ncomponent = \"EXX\"\n{kind}\n[location]"));
    for number in ["1e309", "nan", "inf", "-inf", "1e999999999"] {
        for text in [
            motion(&format!("kind = \"polynomial\"\ncoefficients = [{number}]")),
            demo("travel_mm = [0, 700]", &format!("travel_mm = [0, {number}]")),
            motion(&format!("kind = \"table\"\npositions_mm = [0, 1]\nvalues_um = [0, {number}]")),
            motion(&format!("kind = \"periodic\"\nperiod_mm = {number}\namplitude_um = 1")),
        ] {
            refused(text.as_bytes(), "E0404", "finite", LITTLE_KIB);
        }
    }
    for number in ["1e308", "-1e308", "1001", "0x7fffffffffffffff"] {
        let text = motion(&format!("kind = \"polynomial\"\ncoefficients = [{number}]"));
        let (code, expected) = match number {
            "1001" => ("E0404", "a coefficient that makes errors of meters"),
            _ => ("E0410", "coefficients must be from"),
        };
        refused(text.as_bytes(), code, expected, LITTLE_KIB);
    }
    for travel in ["[0, 1e-320]", "[0, 0.0001]", "[0, 1e10]", "[-1e308, 1e308]"] {
        let text = demo("travel_mm = [0, 700]", &format!("travel_mm = {travel}"));
        let (code, expected) = match travel {
            "[0, 1e10]" | "[-1e308, 1e308]" => ("E0410", "travel_mm must be from"),
            _ => ("E0404", "travel_mm of axis X is not a plausible travel"),
        };
        refused(text.as_bytes(), code, expected, LITTLE_KIB);
    }
    // Bends closer than anything that can be measured are read, and cost no more samples than fine ones do.
    for kind in [
        "kind = \"periodic\"\nperiod_mm = 1e-300\namplitude_um = 1",
        "kind = \"table\"\npositions_mm = [0, 1e-300, 700]\nvalues_um = [0, 0, 1]",
        "kind = \"polynomial\"\ncoefficients = [1e-320, -0.0]",
    ] {
        let shop = SINUMERIK.shop("X2").file("m.toml", motion(kind));
        let seen = watch(&shop, &["in.mpf", "-o", "out.nc", "--machine", "m.toml"]);
        assert!(seen.run.code == 0 || seen.run.code == 4, "{kind}: {}", seen.run.stderr);
        assert!(seen.time < PATIENCE && seen.peak_kib < LITTLE_KIB, "{kind}: {:?}", seen.time);
    }
}

#[test]
fn tables_of_any_width_and_with_any_number_are_read_or_refused() {
    let measured = |content: &[u8]| {
        let shop = Shop::new().file("in.csv", content).file("out.nc", OLD);
        let seen = watch(&shop, &["correct-readings", "in.csv", "-o", "out.nc", "--machine", &machine("demo")]);
        (shop, seen)
    };
    for number in ["1e308", "-1e308", "1e309", "nan", "inf", "0x10", &"9".repeat(400), "1e999999999"] {
        let (shop, seen) = measured(format!("X,Y,Z\n1,2,{number}\n").as_bytes());
        seen.demand(&shop, "E0603", "in.csv:2:5");
    }
    for number in ["-0", "1e-320", &format!("0.{}1", "0".repeat(10_000))] {
        let (_, seen) = measured(format!("X,Y,Z\n1,2,{number}\n").as_bytes());
        assert_eq!(seen.run.code, 0, "{}", seen.run.stderr);
    }
    // A row and a header of millions of cells, a line of digits.
    const CELLS: usize = 5_000_000;
    for (content, line) in [
        (["X,Y,Z".to_owned(), ",".repeat(CELLS), "\n1,2,3\n".to_owned()].concat(), 2),
        (["X,Y,Z\n".to_owned(), "1".repeat(CELLS), "\n".to_owned()].concat(), 2),
    ] {
        let (shop, seen) = measured(content.as_bytes());
        assert!(seen.run.code == 4 && seen.run.stderr.contains(&format!("in.csv:{line}:")), "{}", seen.run.stderr);
        assert!(shop.bytes("out.nc") == OLD && seen.peak_kib < 8 * LITTLE_KIB, "{} KiB", seen.peak_kib);
    }
}

#[test]
fn options_that_would_never_end_are_wrong_usage() {
    for (option, number) in [
        ("--step", "1e-9mm"),
        ("--step", "0.5um"),
        ("--step", "-1mm"),
        ("--tolerance", "0"),
        ("--tolerance", "nan"),
        ("--increment", "1e-300mm"),
        ("--max-blocks", "99999999999999999999999"),
        ("--threads", "1000000"),
        ("--load", "1e308@0,0,0"),
    ] {
        let (shop, seen) = SINUMERIK.fix("X2", &[&format!("{option}={number}")]);
        seen.demand_usage(&shop, option);
    }
    // A tolerance that no control can keep is said, and costs no more pieces than the increment has.
    let (shop, seen) = SINUMERIK.fix("X20", &["--tolerance", "1e-300mm"]);
    assert!(seen.run.code == 0 && shop.bytes("out.nc").len() < 1_000_000, "{}", seen.run.stderr);
}
