//! Hand edits of corrected programs: each is found and named, and without one nothing is. `tests/edits/README.md` has the form.

use std::fs;

use crate::support::{Shop, machine, repository};

/// At least so many edits are read.
const LEAST_EDITS: usize = 150;
/// Codes that name a difference, or a stamp that is not as it should be.
const NAMING: &[&str] = &["E0311", "E0319", "E0320", "E0321", "W0306", "W0314", "W0315"];

struct Topic {
    name: String,
    machine: String,
    program: String,
    /// Edit, and what is named.
    edits: Vec<(String, String)>,
}

fn topics() -> Vec<Topic> {
    let mut files: Vec<_> =
        fs::read_dir(repository("tests/edits")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "txt"));
    files.sort();
    let topic = |path: &std::path::PathBuf| {
        let text = fs::read_to_string(path).unwrap();
        let (head, rest) = text.split_once("--- program\n").unwrap();
        let (program, edits) = rest.split_once("--- edits\n").unwrap();
        let edits = edits.lines().map(|line| {
            let (edit, named) = line.split_once('|').unwrap_or_else(|| panic!("no bar: {line}"));
            (edit.trim().to_owned(), named.trim().to_owned())
        });
        Topic {
            name: path.file_stem().unwrap().to_str().unwrap().to_owned(),
            machine: head.trim().strip_prefix("machine ").unwrap().to_owned(),
            program: program.to_owned(),
            edits: edits.collect(),
        }
    };
    files.iter().map(topic).collect()
}

/// The line without its comment.
fn code(line: &str) -> &str {
    line.split([';', '(']).next().unwrap()
}

/// Adds to a word of a line, with as many decimals as it has at least.
fn moved(line: &str, axis: char, by: f64) -> Option<String> {
    let words = code(line);
    let at = words.char_indices().position(|(at, letter)| {
        letter == axis
            && !words[..at].ends_with(|before: char| before.is_ascii_alphabetic())
            && words[at + 1..].starts_with(|next: char| next.is_ascii_digit() || next == '-' || next == '.')
    })?;
    let rest = &line[at + 1..];
    let length = rest.find(|sign: char| !(sign.is_ascii_digit() || sign == '-' || sign == '.')).unwrap_or(rest.len());
    let value: f64 = rest[..length].parse().unwrap();
    Some(format!("{}{axis}{:.4}{}", &line[..at], value + by, &rest[length..]))
}

fn edited(text: &str, edit: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let find = |lines: &[String], what: &str| {
        let is_word = |line: &String| line.split_whitespace().any(|word| word == what);
        let whole = lines.iter().position(is_word);
        whole
            .or_else(|| lines.iter().position(|line| line.contains(what)))
            .unwrap_or_else(|| panic!("no '{what}' in\n{text}"))
    };
    let words: Vec<&str> = edit.split_whitespace().collect();
    if let Some((from, to)) = edit.split_once(" => ") {
        let at = find(&lines, from);
        lines[at] = lines[at].replacen(from, &to.replace(" // ", "\n"), 1);
    } else if let Some(what) = edit.strip_prefix("drop line ") {
        lines.remove(find(&lines, what));
    } else if let Some(what) = edit.strip_prefix("drop ") {
        let at = find(&lines, what);
        lines[at] = lines[at].replacen(what, "", 1);
    } else if let Some((new, before)) = edit.strip_prefix("insert ").and_then(|rest| rest.split_once(" before ")) {
        let at = find(&lines, before);
        lines.insert(at, new.to_owned());
    } else if let Some((one, other)) = edit.strip_prefix("swap ").and_then(|rest| rest.split_once(", ")) {
        let (one, other) = (find(&lines, one), find(&lines, other));
        lines.swap(one, other);
    } else if let ["move", axis, by, how @ ..] = &words[..] {
        let (axis, by) = (axis.chars().next().unwrap(), by.parse().unwrap());
        let range =
            if how[0] == "everywhere" { 0..lines.len() } else { find(&lines, how[1])..find(&lines, how[1]) + 1 };
        let mut count = 0;
        for line in &mut lines[range] {
            if let Some(new) = moved(line, axis, by) {
                *line = new;
                count += 1;
            }
        }
        assert!(count > 0, "{edit}: nothing moved in\n{text}");
    } else if let ["last", axis, by, "before", what] = &words[..] {
        let (axis, by) = (axis.chars().next().unwrap(), by.parse().unwrap());
        let end = find(&lines, what);
        let new = lines[..end].iter().enumerate().rev().find_map(|(at, line)| Some((at, moved(line, axis, by)?)));
        let (at, new) = new.unwrap_or_else(|| panic!("{edit}: nothing moved in\n{text}"));
        lines[at] = new;
    } else {
        panic!("what is '{edit}'?");
    }
    let out: String = lines.into_iter().map(|line| line + "\n").collect();
    assert_ne!(out, text, "{edit} changes nothing");
    out
}

/// Codes and messages of the findings that name something.
fn named(json: &serde_json::Value) -> Vec<String> {
    let all = json["diagnostics"].as_array().unwrap();
    let text =
        |one: &serde_json::Value| format!("{} {}", one["code"].as_str().unwrap(), one["message"].as_str().unwrap());
    all.iter().map(text).filter(|text| NAMING.iter().any(|code| text.starts_with(code))).collect()
}

#[test]
fn every_edit_is_found_and_named() {
    let topics = topics();
    let count: usize = topics.iter().map(|topic| topic.edits.len()).sum();
    assert!(count >= LEAST_EDITS, "{count} edits are read");
    let mut problems = Vec::new();
    for topic in &topics {
        let ending = match topic.machine.as_str() {
            "vmc" => "nc",
            "knee_mill" => "ngc",
            "universal_mill" => "pm",
            _ => "mpf",
        };
        let (part, out, bad) = (format!("part.{ending}"), format!("out.{ending}"), format!("bad.{ending}"));
        let machine = machine(&topic.machine);
        let mut shop = Shop::new().file(&part, &topic.program);
        shop.run(["fix", &part, "-o", &out, "--machine", &machine]).exits(0);
        let clean = shop.run(["verify", &part, &out, "--machine", &machine, "--json"]).exits(0).json();
        assert_eq!(named(&clean), [""; 0], "{}", topic.name);
        let corrected = shop.text(&out);
        for (edit, expected) in &topic.edits {
            shop = shop.file(&bad, edited(&corrected, edit));
            let is_error = expected.starts_with('E');
            for command in ["verify", "diff"] {
                let run = shop.run([command, &part, &bad, "--machine", &machine, "--json"]);
                if serde_json::from_str::<serde_json::Value>(&run.stdout).is_err() {
                    problems.push(format!("{} {edit}: {command}: {} {}", topic.name, run.stdout, run.stderr));
                    continue;
                }
                let found = named(&run.json());
                let is_named = found.iter().any(|one| expected.split_whitespace().all(|word| one.contains(word)));
                // Where moves do not follow each other any more, the comparison ends there.
                let is_lost = found.iter().any(|one| one.starts_with("E0311"));
                let status = match command {
                    "diff" if !is_lost => 1,
                    _ if is_error => 4,
                    _ => 0,
                };
                if !is_named || run.code != status {
                    let found = found.join("\n      ");
                    problems.push(format!(
                        "{} {edit}: {command} ends with {}, {expected} expected\n      {found}",
                        topic.name, run.code
                    ));
                }
            }
        }
    }
    assert!(problems.is_empty(), "{} problems:\n{}", problems.len(), problems.join("\n"));
}

/// An edited program, and what is named where the stamp is taken off as well.
fn unstamped(machine_name: &str, ending: &str, program: &str, [from, to]: [&str; 2]) -> Vec<String> {
    let machine = machine(machine_name);
    let (part, out, bad) = (format!("part.{ending}"), format!("out.{ending}"), format!("bad.{ending}"));
    let mut shop = Shop::new().file(&part, program);
    shop.run(["fix", &part, "-o", &out, "--machine", &machine]).exits(0);
    let text = shop.text(&out);
    assert!(text.contains(from), "no {from} in\n{text}");
    let is_stamp = |line: &&str| line.to_ascii_lowercase().contains("ncfix");
    let lines: Vec<&str> = text.lines().filter(|line| !is_stamp(line)).collect();
    shop = shop.file(&bad, lines.join("\n").replacen(from, to, 1) + "\n");
    named(&shop.run(["verify", &part, &bad, "--machine", &machine, "--json"]).exits(4).json())
}

#[test]
fn a_rapid_move_that_dives_is_found_without_marks_and_stamp() {
    let mill = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S300 M3\nN40 G0 X10 Y10\nN50 Z50\nN60 Z2\nN70 G1 Z-4 F200\nN80 X60\nN90 G0 Z50\nN100 M30\n";
    let iso = "%\nO1\nN10 G21 G17 G90 G40 G49 G80 G94\nN20 T9 M6\nN30 G54 G0 X0. Y0. S300 M3\nN40 G43 H9 Z50.\nN50 Z2.\nN60 G1 Z-4. F200.\nN70 X60.\nN80 G0 Z50.\nN90 G53 G0 Z0.\nN100 M30\n%\n";
    let ngc =
        "G21 G17 G90 G40 G49 G80 G94\nT3 M6\nG43 H3\nS3500 M3\nG54 G0 X0 Y0 Z20\nG1 Z-0.5 F400\nX60\nG0 Z20\nM2\n";
    let grundig = "%PM9010\nN9010 (PLATE)\nN1 G17 G71 G90 G40\nN2 G54\nN3 T1 M6\nN4 G0 X-40 Y10 Z60 S800 M3\nN5 G0 Z2\nN6 G1 Z-1 F800\nN7 X40\nN8 G0 Z60\nN9 M30\n";
    for (name, ending, program, edit) in [
        ("demo", "mpf", mill, ["N90 G0 Z50", "N90 G0 Z-40\nZ50"]),
        // Where the axis was is not known to the program, and so its way is its end alone.
        ("demo", "mpf", mill, ["N50 Z50", "N50 G0 Z-40\nZ50"]),
        ("vmc", "nc", iso, ["N80 G0 Z50.", "N80 G0 Z-40.\nG0 Z50."]),
        ("vmc", "nc", iso, ["N90 G53 G0 Z0.", "N90 G0 Z-40.\nG53 G0 Z0."]),
        ("knee_mill", "ngc", ngc, ["G0 Z20\n", "G0 Z-20\nG0 Z20\n"]),
        ("universal_mill", "pm", grundig, ["N8 G0 Z60", "N8 G0 Z-40\nN80 G0 Z60"]),
    ] {
        let found = unstamped(name, ending, program, edit);
        let is_named =
            |one: &String| one.starts_with("E0320") && one.contains("off the path") || one.starts_with("E0311");
        assert!(found.iter().any(is_named), "{edit:?}: {found:?}");
    }
}

#[test]
fn behind_an_edit_others_are_found_too() {
    let part = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S300 M3\nN40 G0 X10 Y10\nN50 Z50\nN60 Z2\nN70 G1 Z-4 F200\nN80 X60\nN90 Y60\nN100 X10\nN110 G0 Z50\nN120 M30\n";
    let demo = machine("demo");
    let mut shop = Shop::new().file("part.mpf", part);
    shop.run(["fix", "part.mpf", "-o", "out.mpf", "--machine", &demo]).exits(0);
    let edits = ["drop line N80", "last X 0.05 before N110", "M30 => M17"];
    let text = edits.iter().fold(shop.text("out.mpf"), |text, edit| edited(&text, edit));
    shop = shop.file("bad.mpf", text);
    for command in ["verify", "diff"] {
        let found = named(&shop.run([command, "part.mpf", "bad.mpf", "--machine", &demo, "--json"]).exits(4).json());
        for part in ["E0311 line 9 of bad.mpf", "N90", "may be missing", "E0320 the tool tip is 49.98", "M30", "M17"] {
            assert!(found.iter().any(|one| one.contains(part)), "{command} {part}: {found:?}");
        }
        assert_eq!(found.len(), 3, "{found:?}");
    }
}

#[test]
fn a_stamp_that_was_changed_promises_nothing() {
    let part = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S300 M3\nN40 G0 X10 Y10 Z50\nN50 G1 Z-4 F200\nN60 X60\nN70 G0 Z50\nN80 M30\n";
    let demo = machine("demo");
    let mut shop = Shop::new().file("part.mpf", part);
    shop.run(["fix", "part.mpf", "-o", "out.mpf", "--machine", &demo]).exits(0);
    for edit in ["tolerance=0.001 => tolerance=0.1", "drop check="] {
        let edits = [edit, "last Z -0.05 before N70"];
        let text = edits.iter().fold(shop.text("out.mpf"), |text, edit| edited(&text, edit));
        shop = shop.file("bad.mpf", text);
        let found = named(&shop.run(["verify", "part.mpf", "bad.mpf", "--machine", &demo, "--json"]).exits(4).json());
        assert!(found.iter().any(|one| one.starts_with("E0320") && one.contains("allow 1.07")), "{edit}: {found:?}");
    }
}

/// What ncfix itself writes is no difference, whatever its options.
#[test]
fn what_ncfix_writes_raises_no_alarm() {
    const ALL: &[&str] =
        &["", "--step 5mm", "--arcs chords", "--rapids none", "--rapids all", "--tolerance 5um", "--increment 1um"];
    const FRAMES: &[&str] = &["--frame machine", "--five-axis axes", "--rotary hold"];
    let samples = [
        ("sinumerik", "demo", "seal_groove.mpf spline.mpf slots.mpf clamps.mpf cover.mpf"),
        ("sinumerik", "esmaeili_huron", "swarf.mpf five_axis_index.mpf"),
        ("fanuc", "vmc", "rotary_cam.nc clamp_jaws.nc profile_comp.nc inch_bracket.nc"),
        ("rs274", "knee_mill", "arcs.ngc threaded.ngc rotary.ngc compensation.ngc"),
        ("grundig", "universal_mill", "outline.pm cam_follower.pm two_parts.pm"),
    ];
    let mut problems = Vec::new();
    for (dialect, name, programs) in samples {
        let machine = machine(name);
        let mut shop = Shop::new();
        for entry in fs::read_dir(repository(&format!("samples/programs/{dialect}"))).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() {
                shop = shop.copy(path.to_str().unwrap());
            }
        }
        for program in programs.split(' ') {
            let more = if dialect == "sinumerik" { FRAMES } else { &[] };
            for options in ALL.iter().chain(more) {
                let out = format!("out.{}", program.split_once('.').unwrap().1);
                let fix = ["fix", program, "-o", &out, "--machine", &machine, "--json"];
                let fixed = shop.run(fix.into_iter().chain(options.split_whitespace())).exits(0).json();
                let run = shop.run(["verify", program, &out, "--machine", &machine, "--json"]);
                let found = named(&run.json());
                // Where ncfix fix has said that the tolerance is not reached, so may verify.
                let is_told = fixed["diagnostics"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .any(|one| ["W0305", "W0307"].contains(&one["code"].as_str().unwrap()));
                let found: Vec<_> = found.into_iter().filter(|one| !(is_told && one.starts_with("E0320"))).collect();
                if !found.is_empty() {
                    problems.push(format!("{program} {options}: {} of {}", found[0], found.len()));
                }
                let [told, verified] =
                    [&fixed, &run.json()].map(|json| json["after"]["max_um"].as_f64().unwrap_or(f64::NAN));
                // Where on the way a piece ends is found by the nearest place, which hides rounding along the way; with the increment of 1 µm the
                // center of an arc is off by half of one in each of two directions, which `fix` counts at its ends only.
                let rounding_um: f64 = match () {
                    () if options.contains("1um") => 0.5 * 2.0_f64.sqrt(),
                    () if name == "universal_mill" => 0.25,
                    () => 0.03,
                };
                if (told - verified).abs() > rounding_um.max(0.04 * told) {
                    problems.push(format!("{program} {options}: {told} told by fix, {verified} by verify"));
                }
            }
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}
