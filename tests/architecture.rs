//! The house rules that a compiler does not check: which modules of a crate may use which, how every file begins, and that every
//! register is complete.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// A room, and those that it may name.
type Room = (&'static str, &'static [&'static str]);

/// The rooms of each crate, and which of the others in it each may name. Between crates, `Cargo.toml` and the compiler enforce what is permitted.
const CRATES: &[(&str, &[Room])] = &[
    (
        "base",
        &[
            ("source", &[]),
            ("diagnostic", &["source", "units", "csv"]),
            ("units", &[]),
            ("number", &[]),
            ("csv", &["source", "diagnostic"]),
            ("geometry", &["source", "diagnostic", "units", "csv"]),
            ("numeric", &["source", "diagnostic", "units", "csv"]),
            ("pattern", &[]),
            ("register", &[]),
        ],
    ),
    ("dialect", &[]),
    ("machine", &[("machine", &[]), ("snc", &[]), ("describe", &["machine"]), ("saved", &["machine"])]),
    ("language", &[("syntax", &[]), ("exec", &["syntax"])]),
    ("model", &[]),
    ("path", &[("path", &[]), ("servo", &["path"]), ("emit", &["path"]), ("review", &["path"])]),
    (
        "metrology",
        &[
            ("measure", &[]),
            ("calibrate", &["measure"]),
            ("diagnose", &["calibrate", "measure"]),
            ("decompose", &["diagnose", "measure"]),
            ("results", &["calibrate", "decompose", "diagnose", "measure"]),
        ],
    ),
    ("instruments", &[]),
    ("tables", &[("tables", &[]), ("realtime", &[]), ("results", &["realtime", "tables"])]),
    ("dnc", &[("feed", &[]), ("drip", &["feed"]), ("sense", &[])]),
    ("report", &[]),
];

fn sources() -> Vec<(PathBuf, String)> {
    let mut out = below("src");
    for (name, _) in CRATES {
        let of_crate = below(&format!("crates/{name}/src"));
        assert!(!of_crate.is_empty(), "the walk finds the sources of {name}");
        out.extend(of_crate);
    }
    out
}

/// All files of Rust below a folder of the project.
fn below(folder: &str) -> Vec<(PathBuf, String)> {
    fn walk(folder: &Path, out: &mut Vec<(PathBuf, String)>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, out);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                out.push((path.clone(), fs::read_to_string(&path).unwrap()));
            }
        }
    }
    let mut out = Vec::new();
    walk(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut out);
    out.sort();
    out
}

/// The rooms that a text names with `crate::room` or `crate::{room, …}`.
fn named_rooms(text: &str) -> Vec<String> {
    let mut rooms = Vec::new();
    for (at, _) in text.match_indices("crate::") {
        let rest = &text[at + "crate::".len()..];
        let names: Vec<&str> = match rest.strip_prefix('{') {
            Some(list) => list.split('}').next().unwrap().split(',').map(str::trim).collect(),
            None => vec![rest],
        };
        for name in names {
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
            rooms.push(name[..end].to_owned());
        }
    }
    rooms
}

#[test]
fn every_file_names_only_rooms_that_it_may_know() {
    let mut faults = Vec::new();
    for (name, rooms) in CRATES {
        let rows: BTreeMap<&str, &[&str]> = rooms.iter().copied().collect();
        let inside = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("crates/{name}/src"));
        for (path, text) in below(&format!("crates/{name}/src")) {
            let first = path.strip_prefix(&inside).unwrap().components().next().unwrap();
            let room = first.as_os_str().to_string_lossy().trim_end_matches(".rs").to_owned();
            if rows.is_empty() || room == "lib" {
                continue;
            }
            let Some(allowed) = rows.get(room.as_str()) else {
                faults.push(format!("{}: room {room} has no row in CRATES", path.display()));
                continue;
            };
            // A link in a comment is no use of a room.
            let code: String =
                text.lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
            for named in named_rooms(&code) {
                if rows.contains_key(named.as_str()) && named != room && !allowed.contains(&named.as_str()) {
                    faults.push(format!("{}: {room} must not know {named}", path.display()));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Rooms in which files import one another in a circle, and how many may do so in the largest one; in the others none does.
const CIRCLES: &[(&str, &str, usize)] = &[
    ("base", "geometry", 9),
    ("base", "diagnostic", 2),
    ("base", "csv", 2),
    ("base", "numeric", 2),
    ("dialect", "", 6),
    ("dnc", "feed", 8),
    ("dnc", "sense", 6),
    ("dnc", "drip", 4),
    ("language", "syntax", 12),
    ("machine", "machine", 16),
    ("machine", "snc", 4),
    ("metrology", "measure", 12),
    ("metrology", "calibrate", 12),
    ("metrology", "diagnose", 47),
    ("metrology", "decompose", 4),
    ("model", "", 20),
    ("path", "path", 30),
    ("path", "review", 6),
    ("report", "", 10),
    ("tables", "tables", 10),
];

/// What the `use` lines of a file name, each path written out: `crate::a::{b, c::d}` is `crate::a::b` and `crate::a::c::d`.
fn used_paths(text: &str) -> Vec<String> {
    fn written_out(path: &str, out: &mut Vec<String>) {
        let Some((before, list)) = path.split_once('{') else {
            out.push(path.split(" as ").next().unwrap().trim().to_owned());
            return;
        };
        let (mut depth, mut start) = (0, 0);
        let list = &list[..list.rfind('}').unwrap()];
        for (at, letter) in list.char_indices().chain([(list.len(), ',')]) {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    let part = list[start..at].trim();
                    if !part.is_empty() {
                        written_out(&format!("{}{part}", before.trim()), out);
                    }
                    start = at + 1;
                }
                _ => {}
            }
        }
    }
    let mut out = Vec::new();
    // Tests may look wherever they want.
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(path) = line.strip_prefix("use ").or_else(|| {
            let rest = line.strip_prefix("pub")?;
            let rest = if rest.starts_with('(') { rest.split_once(')')?.1 } else { rest };
            rest.strip_prefix(" use ")
        }) else {
            continue;
        };
        let mut path = path.to_owned();
        while !path.contains(';') {
            path.push_str(lines.next().unwrap().trim());
        }
        written_out(path.split(';').next().unwrap(), &mut out);
    }
    out
}

/// The files of a crate as modules, and the files that each one imports.
fn imports(name: &str) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let inside = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("crates/{name}/src"));
    let files: BTreeMap<Vec<String>, String> = below(&format!("crates/{name}/src"))
        .into_iter()
        .map(|(path, text)| {
            let path = path.strip_prefix(&inside).unwrap().with_extension("");
            let mut module: Vec<String> = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            if module.last().is_some_and(|last| last == "mod" || last == "lib") {
                module.pop();
            }
            (module, text)
        })
        .collect();
    let resolve = |module: &[String], path: &str| {
        let mut parts = path.split("::").peekable();
        let mut at = module.to_vec();
        match parts.peek().copied() {
            Some("crate") => at.clear(),
            Some("self") => {}
            Some("super") => {
                while parts.next_if_eq(&"super").is_some() {
                    at.pop();
                }
            }
            Some(first) => {
                at.push(first.to_owned());
                // A path that begins with neither is one of a crate, unless it is that of a module within this one.
                if !files.contains_key(&at) {
                    return None;
                }
                at.pop();
            }
            None => return None,
        }
        parts.next_if(|part| matches!(*part, "crate" | "self"));
        for part in parts {
            at.push(part.to_owned());
            if !files.contains_key(&at) {
                at.pop();
                break;
            }
        }
        Some(at)
    };
    let imported = |module: &Vec<String>, text: &str| {
        used_paths(text).iter().filter_map(|path| resolve(module, path)).filter(|other| other != module).collect()
    };
    files.iter().map(|(module, text)| (module.clone(), imported(module, text))).collect()
}

/// Files that import one another, directly or by way of others, are read and changed together or not at all.
#[test]
fn no_files_of_a_room_import_one_another_in_a_circle() {
    let mut faults = Vec::new();
    for (name, rooms) in CRATES {
        let imported = imports(name);
        let reached = |from: &Vec<String>| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![from.clone()]);
            while let Some(module) = open.pop() {
                for next in imported.get(&module).into_iter().flatten() {
                    if seen.insert(next.clone()) {
                        open.push(next.clone());
                    }
                }
            }
            seen
        };
        let reaches: BTreeMap<&Vec<String>, BTreeSet<Vec<String>>> =
            imported.keys().map(|module| (module, reached(module))).collect();
        let mut largest: BTreeMap<&str, Vec<&Vec<String>>> = BTreeMap::new();
        for (module, others) in &reaches {
            let circle: Vec<&Vec<String>> = reaches
                .keys()
                .copied()
                .filter(|other| others.contains(*other) && reaches[*other].contains(*module))
                .collect();
            let room = if rooms.is_empty() { "" } else { module.first().map_or("", String::as_str) };
            let known = largest.entry(room).or_default();
            if circle.len() > known.len() {
                *known = circle;
            }
        }
        for (room, circle) in largest {
            let row = CIRCLES.iter().find(|row| (row.0, row.1) == (*name, room));
            let most = row.map_or(0, |row| row.2);
            if circle.len() > most {
                let shown: Vec<String> = circle.iter().map(|module| module.join("::")).collect();
                faults.push(format!(
                    "{name}, {room}: {} files in a circle, at most {most}: {}",
                    circle.len(),
                    shown.join(", ")
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Lines of the command line at most. It goes from arguments to the library and from there to a view; the number only gets smaller.
const MOST_LINES_OF_CLI: usize = 6000;

#[test]
fn the_command_line_stays_thin() {
    let lines: usize = below("src/cli").iter().map(|(_, text)| text.lines().count()).sum();
    assert!(lines > 0 && lines <= MOST_LINES_OF_CLI, "src/cli has {lines} lines, at most {MOST_LINES_OF_CLI}");
}

#[test]
fn every_crate_has_a_row() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("crates");
    let mut members: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    members.sort();
    let mut rows: Vec<&str> = CRATES.iter().map(|(name, _)| *name).collect();
    rows.sort_unstable();
    assert_eq!(members, rows);
    for name in members {
        let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("crates/{name}/Cargo.toml"));
        let text = fs::read_to_string(manifest).unwrap();
        assert!(text.contains("[lints]\nworkspace = true"), "{name} has lints of its own");
    }
}

#[test]
fn every_file_opens_with_a_sentence_that_says_what_it_is() {
    for (path, text) in sources() {
        assert!(text.starts_with("//! "), "{}: the first line is no //! sentence", path.display());
    }
}

#[test]
fn every_room_is_on_the_map() {
    let map = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).unwrap();
    for (name, rooms) in CRATES {
        assert!(map.contains(&format!("| `ncfix-{name}` |")), "ARCHITECTURE.md does not explain the crate {name}");
        let alone = [(*name, [].as_slice())];
        for (room, _) in if rooms.is_empty() { alone.as_slice() } else { rooms } {
            assert!(map.contains(&format!("`{room}`")), "ARCHITECTURE.md does not explain {room}");
        }
    }
}

#[test]
fn every_executable_dialect_has_codes_samples_and_a_writer() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for dialect in ncfix_dialect::DIALECTS.iter().filter(|dialect| dialect.is_executable) {
        assert!(!dialect.codes().rows().is_empty(), "{} has no code table", dialect.name);
        assert!(root.join(format!("grammars/{}-codes.tsv", dialect.name)).exists(), "{}", dialect.name);
        let samples = root.join(format!("samples/programs/{}", dialect.name));
        let count = fs::read_dir(&samples).unwrap().count();
        assert!(count >= 8, "{} has {count} samples", dialect.name);
        assert!(
            ncfix_path::emit::WRITERS.iter().any(|entry| entry.dialect == dialect.name),
            "{} has no writer in the register",
            dialect.name
        );
    }
}

#[test]
fn unsafe_code_stands_where_memory_is_shared_and_nowhere_else() {
    let word = concat!("unsafe", "_code");
    let files: Vec<_> = sources().into_iter().filter(|(_, text)| text.contains(word)).map(|(path, _)| path).collect();
    assert_eq!(files, [Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/tables/src/realtime/ring.rs")]);
    // Benches are no part of the program; one of them counts allocations.
    let benches = below("benches").into_iter().filter(|(_, text)| text.contains(word)).map(|(path, _)| path);
    assert_eq!(benches.collect::<Vec<_>>(), [Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/realtime.rs")]);
    let manifest = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml")).unwrap();
    assert!(manifest.contains(&format!("{word} = \"deny\"")), "what is not allowed by name is denied");
}

#[test]
fn nothing_is_left_for_later_in_the_sources() {
    for (path, text) in sources() {
        for word in ["TODO", "FIXME"] {
            assert!(!text.contains(word), "{} mentions {word}", path.display());
        }
    }
}

#[test]
fn a_fault_in_a_thread_is_a_fault_of_the_program() {
    // Taken for a result that is empty or for a finding it would be a wrong answer. Where nobody waits for a result `let _` says so.
    for (path, text) in sources() {
        for line in text.lines().filter(|line| line.contains(".join()")) {
            let goes_on = line.contains("resume_unwind") || line.trim_start().starts_with("let _ = ");
            assert!(goes_on, "{}: {}", path.display(), line.trim());
        }
    }
}

/// What a person runs by `just`, what CI runs and what `.ci/run` runs is one thing.
#[test]
fn every_step_of_ci_has_a_recipe() {
    let read = |path: &str| fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap();
    let (run, justfile, hosted) = (read(".ci/run"), read("justfile"), read(".github/workflows/ci.yml"));
    let steps: Vec<&str> =
        run.lines().filter_map(|line| line.strip_prefix("step_")?.split_once("()")).map(|(name, _)| name).collect();
    assert!(steps.contains(&"all"), "the steps are found");
    let (mut recipes, mut name) = (Vec::new(), "");
    for line in justfile.lines().filter(|line| !line.starts_with('_')) {
        match line.strip_prefix("    .ci/run ") {
            Some(step) => {
                assert_eq!(step, name, "a recipe runs the step of its name");
                recipes.push(name);
            }
            None => name = line.strip_suffix(':').unwrap_or(name),
        }
    }
    assert_eq!(recipes, steps);
    for (_, words) in hosted.lines().filter_map(|line| line.split_once(".ci/run ")) {
        // A comment names the script alone.
        for word in words.split_whitespace() {
            assert!(steps.contains(&word), "the hosted CI runs {word}, which is no step");
        }
    }
}

/// A package has nothing of what stands above the folder of its crate.
#[test]
fn every_crate_embeds_only_what_its_package_has() {
    for (name, _) in CRATES {
        let own = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("crates/{name}"));
        for (path, text) in below(&format!("crates/{name}/src")) {
            for (at, macro_name) in text.match_indices("include_str!(").chain(text.match_indices("include_bytes!(")) {
                let argument = text[at + macro_name.len()..].split(')').next().unwrap();
                let up = argument.matches("../").count();
                let depth = path.strip_prefix(&own).unwrap().components().count() - 1;
                assert!(up <= depth, "{}: {argument} stands outside of the crate", path.display());
                assert!(up == 0 || !argument.contains("CARGO_MANIFEST_DIR"), "{}: {argument}", path.display());
            }
        }
    }
}

/// Where words are read: those of programs, of files, of the answers of a control and of a source of readings. Reading compares text.
const READERS: [&str; 9] = [
    "crates/dialect/src/code.rs",
    "crates/dnc/src/drip/block.rs",
    "crates/dnc/src/drip/told.rs",
    "crates/dnc/src/feed/dialogue/",
    "crates/dnc/src/sense/source/",
    "crates/instruments/src/",
    "crates/language/src/",
    "crates/machine/src/machine/zero_offset.rs",
    "crates/tables/src/tables/format/",
];

/// Files that still compare the name of a thing with a text, and how often. No row is added, and no number grows.
const DECIDED_BY_TEXT: &[(&str, usize)] = &[
    ("crates/metrology/src/diagnose/empirical/screen.rs", 1),
    ("crates/metrology/src/diagnose/extend/law.rs", 1),
    ("crates/metrology/src/diagnose/gates.rs", 1),
    ("crates/metrology/src/diagnose/shape.rs", 1),
    ("crates/metrology/src/diagnose/size.rs", 5),
    ("crates/metrology/src/diagnose/slow.rs", 1),
    ("crates/metrology/src/results/diagnosis.rs", 1),
    // The name of a command is what a person writes.
    ("src/cli/exit_code.rs", 3),
];

/// What says of a thing what it is: a field or a variable of this name holds a type, not a text.
const SAYS_WHAT_IT_IS: [&str; 19] = [
    "cause",
    "driver",
    "effect",
    "ended",
    "form",
    "kind",
    "mode",
    "name",
    "parameter",
    "sense",
    "severity",
    "source",
    "state",
    "status",
    "subject",
    "unit",
    "variant",
    "verdict",
    "what",
];

/// How often a line compares something of [`SAYS_WHAT_IT_IS`] with a text; `next` is the line behind it, in which a `match` may name the text.
fn decisions_by_text(line: &str, next: &str) -> usize {
    let last_name = |text: &str| {
        let text =
            ["()", ".as_str()", ".as_deref()"].iter().fold(text.trim_end(), |text, end| text.trim_end_matches(end));
        let start = text.rfind(|c: char| !c.is_ascii_lowercase() && c != '_').map_or(0, |at| at + 1);
        SAYS_WHAT_IT_IS.contains(&&text[start..])
    };
    let compared = [" == \"", " != \"", " == Some(\"", " != Some(\""]
        .iter()
        .flat_map(|sign| line.match_indices(sign))
        .filter(|(at, _)| last_name(&line[..*at]))
        .count();
    let matched = line.split_once("match ").and_then(|(_, rest)| rest.strip_suffix(" {"));
    let is_matched = matched.is_some_and(|of| of.contains('.') && last_name(of)) && next.trim_start().starts_with('"');
    let is_one_of =
        line.split_once("matches!(").and_then(|(_, rest)| rest.split_once(", \"")).is_some_and(|(of, _)| last_name(of));
    compared + usize::from(is_matched) + usize::from(is_one_of)
}

/// Types decide; a text is a view of them, and one that is compared with another is a type that is missing.
#[test]
fn no_further_text_decides() {
    assert_eq!(decisions_by_text("if set.kind.name == \"ballbar\" || one.state != \"good\" {", ""), 2);
    assert_eq!(decisions_by_text("match plan.kind.name {", "    \"ballbar\" => vec![],"), 1);
    assert_eq!(decisions_by_text("if matches!(kind.name, \"plate\" | \"load\") {", ""), 1);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for (path, text) in sources() {
        let shown = path.strip_prefix(root).unwrap().to_string_lossy().replace('\\', "/");
        if READERS.iter().any(|reader| shown.starts_with(reader)) || shown.ends_with("tests.rs") {
            continue;
        }
        let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
        let lines: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        let pairs = lines.iter().zip(lines.iter().skip(1).chain([&""]));
        let count: usize = pairs.map(|(line, next)| decisions_by_text(line, next)).sum();
        let most = DECIDED_BY_TEXT.iter().find(|(name, _)| *name == shown).map_or(0, |(_, most)| *most);
        assert!(count <= most, "{shown}: {count} comparisons of a name with a text, at most {most}: make it a type");
    }
}

/// The names of types that a text gives to the rest of its crate, or to others; those of its tests aside.
fn types_of(text: &str) -> Vec<&str> {
    let code = text.split("#[cfg(test)]\nmod ").next().unwrap();
    let mut names = Vec::new();
    for line in code.lines().map(str::trim_start).filter(|line| line.starts_with("pub")) {
        // Behind `pub` or `pub(…)`.
        let rest =
            line.strip_prefix("pub ").or_else(|| line.strip_prefix("pub(")?.split_once(") ").map(|(_, rest)| rest));
        let Some((keyword, rest)) = rest.and_then(|rest| rest.split_once(' ')) else { continue };
        if ["struct", "enum", "trait", "type", "union"].contains(&keyword) {
            names.push(rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap());
        }
    }
    names
}

/// A type is named for its role, and its name stands once in the workspace. Those that still stand twice are in a list that only gets shorter.
#[test]
fn no_further_name_of_a_type_stands_twice() {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for (_, text) in sources() {
        for name in types_of(&text) {
            *counts.entry(name.to_owned()).or_default() += 1;
        }
    }
    counts.retain(|_, count| *count > 1);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/duplicate_type_names.tsv");
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        let rows: String = counts.iter().map(|(name, count)| format!("{name}\t{count}\n")).collect();
        fs::write(
            &path,
            format!(
                "# Types whose names occur more than once in the workspace, and how often. No row is added.\n{rows}"
            ),
        )
        .unwrap();
    }
    let text = fs::read_to_string(&path).unwrap();
    let rows = text.lines().filter_map(|line| line.split_once('\t'));
    let allowed: BTreeMap<&str, usize> = rows.map(|(name, count)| (name, count.parse().unwrap())).collect();
    for (name, count) in counts {
        let most = allowed.get(name.as_str()).copied().unwrap_or(1);
        assert!(count <= most, "{name} names {count} types, at most {most} had that name: name it for its role");
    }
}
