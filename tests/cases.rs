//! Cases in plain text: a program, what the control does with it, and where that is written. `tests/cases/README.md` has the form.
//!
//! Every file of `tests/cases/` is a topic. `NCFIX_CASE=WORDS` runs only the cases whose names hold the words.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::support::{Run, Shop, repository};

/// At least so many cases stand in the folder: a file that is not read any more does not go unnoticed.
const LEAST_CASES: usize = 150;
/// Places agree to this, mm or degrees: the flat stream has six decimals, and the values of the cases are written to as many.
const PLACE: f64 = 2e-6;

/// One case as its file says it.
#[derive(Debug, Default)]
struct Case {
    /// Topic and line, for messages.
    place: String,
    name: String,
    /// Names of machines in `tests/cases/machines/`; the case holds on each of them.
    machines: Vec<String>,
    source: String,
    /// Arguments behind the command.
    options: Vec<String>,
    /// Title of a section and its lines.
    sections: Vec<(String, Vec<String>)>,
}

impl Case {
    fn section(&self, title: &str) -> Option<String> {
        let (_, lines) = self.sections.iter().find(|(name, _)| name == title)?;
        Some(lines.iter().map(|line| format!("{line}\n")).collect())
    }
}

/// Sections that say what must come out.
const EXPECTATIONS: &[&str] = &["moves", "end", "refused", "fix refused", "warned", "fix warned", "written", "output"];
/// Sections that say what goes in.
const INPUTS: &[&str] = &["program", "machine"];

/// Reads one topic.
fn read(topic: &str, text: &str) -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let place = format!("tests/cases/{topic}.txt:{}", number + 1);
        if let Some(name) = line.strip_prefix("=== ") {
            cases.push(Case { place, name: name.trim().to_owned(), ..Case::default() });
            continue;
        }
        let Some(case) = cases.last_mut() else {
            assert!(line.is_empty() || line.starts_with('#'), "{place}: text before the first case");
            continue;
        };
        if let Some(title) = line.strip_prefix("--- ") {
            let title = title.trim();
            let known = INPUTS.contains(&title) || EXPECTATIONS.contains(&title) || title.starts_with("file ");
            assert!(known, "{place}: no section is called '{title}'");
            case.sections.push((title.to_owned(), Vec::new()));
        } else if let Some((title, lines)) = case.sections.last_mut() {
            // A remark between cases belongs to no section; in a program a line that begins with # is the program's own.
            let is_remark = line.starts_with('#') && EXPECTATIONS.contains(&title.as_str());
            let is_gap = line.is_empty() && EXPECTATIONS.contains(&title.as_str());
            if !is_remark && !is_gap {
                lines.push(line.to_owned());
            }
        } else if !line.is_empty() && !line.starts_with('#') {
            let (key, value) = line.split_once(' ').unwrap_or((line, ""));
            let value = value.trim();
            match key {
                "machine" => case.machines = value.split_whitespace().map(str::to_owned).collect(),
                "source" if case.source.is_empty() => value.clone_into(&mut case.source),
                "source" => case.source = format!("{}; {value}", case.source),
                "options" => case.options = value.split_whitespace().map(str::to_owned).collect(),
                _ => panic!("{place}: a case has machine, source, options, not '{key}'"),
            }
        }
    }
    for case in &cases {
        assert!(!case.source.is_empty(), "{}: a case says where its values come from", case.place);
        assert!(!case.machines.is_empty(), "{}: a case names its machine", case.place);
        assert!(case.section("program").is_some(), "{}: a case has a program", case.place);
        let expects = case.sections.iter().any(|(title, _)| EXPECTATIONS.contains(&title.as_str()));
        assert!(expects, "{}: a case says what comes out", case.place);
    }
    cases
}

/// What `extra` sets, over what `base` has, table by table.
fn merge(base: &mut toml::Table, extra: toml::Table) {
    for (key, value) in extra {
        match (base.get_mut(&key), value) {
            (Some(toml::Value::Table(old)), toml::Value::Table(new)) => merge(old, new),
            (_, value) => {
                base.insert(key, value);
            }
        }
    }
}

/// The machine file of a case: the one of its name, with the lines of its section over it.
fn machine_text(case: &Case, name: &str) -> String {
    let path = repository(&format!("tests/cases/machines/{name}.toml"));
    let base = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: machine '{name}': {error}", case.place));
    let Some(extra) = case.section("machine") else { return base };
    let mut table: toml::Table = base.parse().unwrap();
    merge(&mut table, extra.parse().unwrap_or_else(|error| panic!("{}: machine: {error}", case.place)));
    table.to_string()
}

/// The letter and number words of a line of the flat stream; the code stands under `' '`.
fn words(line: &str) -> (String, BTreeMap<String, f64>) {
    let line = line.split(';').next().unwrap_or_default();
    let mut parts = line.split_whitespace();
    let code = parts.next().unwrap_or_default().to_owned();
    let words = parts.map(|word| {
        let letters: String = word.chars().take_while(char::is_ascii_alphabetic).collect();
        let value = word[letters.len()..].parse().unwrap_or_else(|error| panic!("'{word}' in '{line}': {error}"));
        (letters, value)
    });
    (code, words.collect())
}

/// Moves and dwells of the flat stream.
fn moves(stdout: &str) -> Vec<&str> {
    stdout.lines().filter(|line| line.starts_with('G')).collect()
}

/// Compares the words that a case names. A code such as `G1` also stands for `G1.W` unless the case writes it out.
fn agrees(expected: &str, found: &str) -> bool {
    let (code, named) = words(expected);
    let (found_code, has) = words(found);
    let same_code = code == found_code || found_code.split('.').next() == Some(code.as_str());
    same_code && named.iter().all(|(word, value)| has.get(word).is_some_and(|found| (found - value).abs() <= PLACE))
}

fn check_moves(case: &Case, run: &Run, problems: &mut Vec<String>) {
    let found = moves(&run.stdout);
    if let Some(text) = case.section("moves") {
        let expected: Vec<&str> = text.lines().collect();
        let same = expected.len() == found.len() && expected.iter().zip(&found).all(|(e, f)| agrees(e, f));
        if !same {
            problems.push(format!("moves expected:\n{text}found:\n{}\n", found.join("\n")));
        }
    }
    if let Some(text) = case.section("end") {
        let last = found.iter().rev().find(|line| !line.starts_with("G4")).copied().unwrap_or("G no move at all");
        let code = last.split_whitespace().next().unwrap_or_default();
        if !agrees(&format!("{code} {}", text.trim()), last) {
            problems.push(format!("the last move is expected to end at {text}found: {last}"));
        }
    }
}

/// Lines `E0231 line 4 words of the message`: every one is there, and no other error is.
fn check_codes(text: &str, run: &Run, is_refusal: bool, problems: &mut Vec<String>) {
    let json: serde_json::Value = match serde_json::from_str(&run.stdout) {
        Ok(json) => json,
        Err(error) => return problems.push(format!("no JSON ({error}): {}{}", run.stdout, run.stderr)),
    };
    let none = Vec::new();
    let found = json["diagnostics"].as_array().unwrap_or(&none);
    let shown: Vec<String> = found
        .iter()
        .map(|d| format!("{} line {} {} {}", d["code"], d["line"], d["message"], d["help"]).replace('"', ""))
        .collect();
    let mut codes = Vec::new();
    for expected in text.lines() {
        let mut parts = expected.splitn(2, ' ');
        let code = parts.next().unwrap_or_default();
        let rest = parts.next().unwrap_or_default();
        codes.push(code);
        let matches = |one: &&String| {
            let (line, message) =
                match rest.strip_prefix("line ").map(|rest| rest.split_once(' ').unwrap_or((rest, ""))) {
                    Some((line, message)) => (format!("{code} line {line} "), message),
                    None => (format!("{code} "), rest),
                };
            one.starts_with(&line) && message.split(" … ").all(|part| one.contains(part))
        };
        if !shown.iter().any(|one| matches(&one)) {
            problems.push(format!("expected {expected}\nfound:\n{}", shown.join("\n")));
        }
    }
    if is_refusal {
        for one in shown.iter().filter(|one| one.starts_with('E')) {
            if !codes.iter().any(|code| one.starts_with(code)) {
                problems.push(format!("not expected: {one}"));
            }
        }
        if run.code != 3 && run.code != 4 {
            problems.push(format!("exit status {}, a refusal has 3 or 4", run.code));
        }
    } else if run.code != 0 {
        problems.push(format!("exit status {}\n{}\n{}", run.code, shown.join("\n"), run.stderr));
    }
}

/// Lines in order; `! TEXT` stands nowhere.
fn check_text(text: &str, written: &str, problems: &mut Vec<String>) {
    let mut rest = written.lines();
    for expected in text.lines() {
        if let Some(never) = expected.strip_prefix("! ") {
            if written.lines().any(|line| line.contains(never)) {
                problems.push(format!("'{never}' is written:\n{written}"));
            }
        } else if !rest.any(|line| line.trim_end() == expected.trim_end()) {
            problems.push(format!("'{expected}' is not written, or not in this order:\n{written}"));
            return;
        }
    }
}

fn check(case: &Case, machine: &str) -> Vec<String> {
    let text = machine_text(case, machine);
    let table: toml::Table = text.parse().unwrap();
    let ending = match table["machine"]["controller"].as_str().unwrap_or_default() {
        "sinumerik" => "mpf",
        "fanuc" => "nc",
        "grundig" => "pm",
        _ => "ngc",
    };
    let program = format!("part.{ending}");
    let mut shop = Shop::new().file("machine.toml", &text).file(&program, case.section("program").unwrap_or_default());
    for (title, lines) in &case.sections {
        if let Some(name) = title.strip_prefix("file ") {
            shop = shop.file(name.trim(), lines.iter().map(|line| format!("{line}\n")).collect::<String>());
        }
    }
    let run = |command: &[&str]| {
        let arguments =
            command.iter().map(|word| (*word).to_owned()).chain(["--machine".to_owned(), "machine.toml".to_owned()]);
        let options = if command[0] == "fix" { case.options.clone() } else { Vec::new() };
        shop.run(arguments.chain(options))
    };
    let mut problems = Vec::new();
    if case.section("moves").is_some() || case.section("end").is_some() {
        let ran = run(&["snc", &program]);
        if ran.code == 0 {
            check_moves(case, &ran, &mut problems);
        } else {
            problems.push(format!("snc: exit status {}\n{}", ran.code, ran.stderr));
        }
    }
    for (title, command, is_refusal) in [
        ("refused", "check", true),
        ("fix refused", "fix", true),
        ("warned", "check", false),
        ("fix warned", "fix", false),
    ] {
        if let Some(text) = case.section(title) {
            let ran = match command {
                "fix" => run(&["fix", &program, "-o", "out", "--json"]),
                _ => run(&["check", &program, "--json"]),
            };
            check_codes(&text, &ran, is_refusal, &mut problems);
            if is_refusal && command == "fix" && shop.names().iter().any(|name| name == "out") {
                problems.push("a refused program was written".to_owned());
            }
        }
    }
    if case.section("written").is_some() || case.section("output").is_some() {
        let ran = run(&["fix", &program, "-o", "out"]);
        if ran.code == 0 {
            check_text(&case.section("written").unwrap_or_default(), &shop.text("out"), &mut problems);
            check_text(
                &case.section("output").unwrap_or_default(),
                &format!("{}{}", ran.stdout, ran.stderr),
                &mut problems,
            );
        } else {
            problems.push(format!("fix: exit status {}\n{}", ran.code, ran.stderr));
        }
    }
    problems
}

fn all() -> Vec<Case> {
    let mut files: Vec<_> =
        fs::read_dir(repository("tests/cases")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "txt"));
    files.sort();
    let topic = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    files.iter().flat_map(|path| read(&topic(path), &fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn every_case_comes_out_as_its_source_says() {
    let wanted = std::env::var("NCFIX_CASE").unwrap_or_default();
    let cases: Vec<Case> = all().into_iter().filter(|case| case.name.contains(&wanted)).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let failed = std::sync::Mutex::new(Vec::new());
    // Each case is a process or two; two threads keep two cores at work.
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, std::sync::atomic::Ordering::Relaxed)) {
                    for machine in &case.machines {
                        let problems = check(case, machine);
                        if !problems.is_empty() {
                            let text =
                                format!("{} {} [{machine}]\n  {}\n", case.place, case.name, problems.join("\n  "));
                            failed.lock().unwrap().push(text);
                        }
                    }
                }
            });
        }
    });
    let mut failed = failed.into_inner().unwrap();
    failed.sort();
    assert!(failed.is_empty(), "{} of {} cases:\n{}", failed.len(), cases.len(), failed.join("\n"));
}

#[test]
fn the_cases_are_many_and_no_name_stands_twice() {
    let mut names: Vec<String> = all().into_iter().map(|case| case.name).collect();
    assert!(names.len() >= LEAST_CASES, "{} cases are read, {LEAST_CASES} were written", names.len());
    names.sort();
    let twice: Vec<_> = names.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| &pair[0]).collect();
    assert!(twice.is_empty(), "names that stand twice: {twice:?}");
}
