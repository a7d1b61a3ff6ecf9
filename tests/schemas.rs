//! Schemas of `--json`, `docs/schemas/`: they are those of the types, every command has one, and what commands print keeps to it.
//! `NCFIX_WRITE_DOCS=1 cargo test schemas` writes them.

use std::fmt::Write as _;
use std::fs;

use ncfix_report::schema;
use serde_json::Value;

use crate::cli_at_feed::MILL;
use crate::cli_resume::cut_off;
use crate::support::{Run, Shop, machine, repository};

/// Keywords that demand nothing.
const WORDS: [&str; 6] = ["$schema", "$defs", "title", "description", "format", "default"];

/// What a value has that its schema does not allow, or lacks: a line for each. A key that the schema does not name is such a fault too.
///
/// Of JSON Schema only what the schemas of this project use; any other keyword is a fault, so that nothing is passed over. A library for all of it would
/// bring more than forty crates.
fn faults(root: &Value, schema: &Value, value: &Value, at: &str) -> Vec<String> {
    let Some(keywords) = schema.as_object() else {
        return if schema == &Value::Bool(true) { Vec::new() } else { vec![format!("{at}: no value is allowed")] };
    };
    let mut found = Vec::new();
    for (keyword, wanted) in keywords {
        match (keyword.as_str(), value) {
            ("$ref", _) => {
                let name = wanted.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                found.extend(faults(root, &root["$defs"][name], value, at));
            }
            ("type", _) => {
                let is_one = |kind: &Value| is_of(value, kind.as_str().unwrap());
                if !wanted.as_array().map_or_else(|| is_one(wanted), |kinds| kinds.iter().any(is_one)) {
                    found.push(format!("{at}: {value} is no {wanted}"));
                }
            }
            ("anyOf" | "oneOf", _) => {
                let all = wanted.as_array().unwrap().iter().map(|one| faults(root, one, value, at));
                // Of several that do not fit the nearest says most.
                found.extend(all.min_by_key(Vec::len).unwrap());
            }
            ("enum", _) if wanted.as_array().unwrap().contains(value) => {}
            ("const", _) if wanted == value => {}
            ("enum" | "const", _) => found.push(format!("{at}: {value} is not of {wanted}")),
            ("properties", Value::Object(object)) => {
                for (key, value) in object {
                    match (wanted.get(key), keywords.get("additionalProperties")) {
                        (Some(schema), _) => found.extend(faults(root, schema, value, &format!("{at}.{key}"))),
                        (None, None | Some(Value::Bool(false))) => found.push(format!("{at}: has {key}")),
                        (None, Some(_)) => {}
                    }
                }
            }
            ("required", Value::Object(object)) => {
                let lacks = |key: &&Value| !object.contains_key(key.as_str().unwrap());
                found.extend(wanted.as_array().unwrap().iter().filter(lacks).map(|key| format!("{at}: lacks {key}")));
            }
            ("additionalProperties", Value::Object(object)) => {
                let named = |key: &String| keywords.get("properties").is_some_and(|known| known.get(key).is_some());
                let others = object.iter().filter(|(key, _)| !named(key));
                others.for_each(|(key, value)| found.extend(faults(root, wanted, value, &format!("{at}.{key}"))));
            }
            ("items", Value::Array(list)) => {
                let skipped = keywords.get("prefixItems").and_then(Value::as_array).map_or(0, Vec::len);
                for (k, value) in list.iter().enumerate().skip(skipped) {
                    found.extend(faults(root, wanted, value, &format!("{at}[{k}]")));
                }
            }
            ("prefixItems", Value::Array(list)) => {
                for (k, (schema, value)) in wanted.as_array().unwrap().iter().zip(list).enumerate() {
                    found.extend(faults(root, schema, value, &format!("{at}[{k}]")));
                }
            }
            ("minItems", Value::Array(list)) if list.len() < wanted.as_u64().unwrap() as usize => {
                found.push(format!("{at}: has {} elements", list.len()));
            }
            ("maxItems", Value::Array(list)) if list.len() > wanted.as_u64().unwrap() as usize => {
                found.push(format!("{at}: has {} elements", list.len()));
            }
            ("minimum", Value::Number(number)) if number.as_f64() < wanted.as_f64() => {
                found.push(format!("{at}: {number} is less than {wanted}"));
            }
            ("maximum", Value::Number(number)) if number.as_f64() > wanted.as_f64() => {
                found.push(format!("{at}: {number} is more than {wanted}"));
            }
            (
                "properties"
                | "required"
                | "additionalProperties"
                | "items"
                | "prefixItems"
                | "minItems"
                | "maxItems"
                | "minimum"
                | "maximum",
                _,
            ) => {}
            (other, _) if WORDS.contains(&other) => {}
            (other, _) => found.push(format!("{at}: the keyword {other} is not known here")),
        }
    }
    found
}

fn is_of(value: &Value, kind: &str) -> bool {
    match kind {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => false,
    }
}

/// Demands that what a command printed keeps to its schema, each line by itself; a command without a schema prints what it likes.
#[track_caller]
pub(crate) fn keeps_to_its_schema(command: &str, printed: &str) {
    let Ok(text) = fs::read_to_string(repository(&format!("docs/schemas/{command}.json"))) else { return };
    let schema: Value = serde_json::from_str(&text).unwrap();
    for line in printed.lines() {
        let value: Value = serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
        let found = faults(&schema, &schema, &value, command);
        assert!(found.is_empty(), "{}\n{line}", found.join("\n"));
    }
}

#[test]
fn the_files_are_those_of_the_types() {
    let folder = repository("docs/schemas");
    let text = |schema: &Value| serde_json::to_string_pretty(schema).unwrap() + "\n";
    if std::env::var_os("NCFIX_WRITE_DOCS").is_some() {
        fs::create_dir_all(&folder).unwrap();
        for (name, schema) in schema::all() {
            fs::write(folder.join(format!("{name}.json")), text(&schema)).unwrap();
        }
    }
    for (name, schema) in schema::all() {
        let written = fs::read_to_string(folder.join(format!("{name}.json"))).unwrap_or_default();
        assert!(written == text(&schema), "docs/schemas/{name}.json: run this test with NCFIX_WRITE_DOCS=1");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), schema::all().len(), "schemas of commands that there are not");
}

#[test]
fn every_command_with_json_has_a_schema() {
    let shop = Shop::new();
    let pages = fs::read_dir(repository("docs/commands")).unwrap().map(|entry| entry.unwrap().path());
    // The pages have what `--help` prints, which another test holds.
    let has_json = |page: &std::path::PathBuf| {
        fs::read_to_string(page).unwrap().lines().any(|line| line.trim_start().starts_with("--json"))
    };
    let mut commands: Vec<String> =
        pages.filter(has_json).map(|page| page.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    commands.sort();
    assert_eq!(commands, schema::all().iter().map(|(name, _)| (*name).to_owned()).collect::<Vec<_>>());
    assert!(shop.names().is_empty());
}

#[test]
fn what_a_schema_does_not_allow_is_a_fault() {
    let root = serde_json::json!({
        "type": "object",
        "properties": { "a": { "type": "integer", "minimum": 0 }, "b": { "$ref": "#/$defs/b" } },
        "required": ["a"],
        "$defs": { "b": { "anyOf": [{ "type": "null" }, { "type": "array", "items": { "const": "x" }, "minItems": 1 }] } },
    });
    let found = |value: Value| faults(&root, &root, &value, "$").len();
    for (value, count) in [
        (serde_json::json!({ "a": 1, "b": ["x"] }), 0),
        (serde_json::json!({ "a": 0, "b": null }), 0),
        (serde_json::json!({ "a": -1 }), 1),
        (serde_json::json!({ "a": 1.5 }), 1),
        (serde_json::json!({ "b": null }), 1),
        (serde_json::json!({ "a": 1, "b": ["y"] }), 1),
        (serde_json::json!({ "a": 1, "b": [] }), 1),
        (serde_json::json!({ "a": 1, "c": 1 }), 1),
        (serde_json::json!([]), 1),
    ] {
        assert_eq!(found(value.clone()), count, "{value}");
    }
}

/// A run of every command with a result, and one that is refused where it prints an object for that too.
#[test]
fn every_command_keeps_to_its_schema() {
    let program = "G90 G500 G0 X0 Y0 Z0\nG1 X60 F5000\nX90 Y40\nM30\n";
    let mut bar = "X,Y,Z,dr_um\n".to_owned();
    for k in 0..72 {
        let angle = f64::from(k) * 5.0_f64.to_radians();
        let (x, y) = (300.0 + 100.0 * angle.cos(), 200.0 + 100.0 * angle.sin());
        // A squareness of 20 µrad, and what no model has.
        let dr = 1.0 * (2.0 * angle).sin() + 0.1 * (7.0 * angle).cos();
        writeln!(bar, "{x:.6},{y:.6},300,{dr:.4}").unwrap();
    }
    let about = "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.3\nfree = [\"centre\", \"length\"]\n\
                 [setup.default]\ncentre_mm = [300, 200, 300]\nlength_mm = 100\n";
    let mut strain = "run,X,strain_um_m\n".to_owned();
    for (run, x, um_m) in (0..4)
        .flat_map(|run| [(0, 0.0), (150, 3.3), (350, 6.9), (550, 3.1), (700, 0.1)].map(|(x, um_m)| (run, x, um_m)))
    {
        writeln!(strain, "{run},{x},{um_m}").unwrap();
    }
    let mut warm = "t_s,dx_um,T_head_C,T_bed_C\n".to_owned();
    for k in 0..200 {
        let t = f64::from(k) * 60.0;
        let head = 20.0 + 8.0 * (1.0 - (-t / 3000.0).exp());
        let bed = 20.0 + 0.5 * (t / 2000.0).sin();
        writeln!(warm, "{t},{:.3},{head:.3},{bed:.3}", 3.0 * (head - 20.0) + 0.1 * (k % 3) as f64).unwrap();
    }
    let shop = Shop::new()
        .file("m.toml", MILL)
        .file("known.toml", MILL.split("[servo]").next().unwrap())
        .file("p.mpf", program)
        .file("small.toml", MILL.replace("[-900, 900]", "[0, 20]"))
        .file("laser.csv", "component,X,Y,Z,value_um\nEXX,0,0,0,0\nEXX,100,0,0,9\nEXX,200,0,0,21\nEXX,300,0,0,29\nEXX,400,0,0,41\nEXX,500,0,0,50\n")
        .file("laser.toml", "[measurement]\nkind = \"direct\"\nsigma_um = 0.5\n")
        .file("wrong.mpf", "G1 X1 F1\nFOO(\nM30\n")
        .file("part.ngc", "G21 G90 G54\nG0 X0 Y0 Z50\nG1 Z-1 F100\nX20 F300\nG0 Z50\nM30\n")
        .file("bar.csv", bar)
        .file("bar.toml", about)
        .file("none.csv", "X,Y,Z,dr_um\n400,200,300,1\n")
        .file("none.toml", about)
        .file("strain.csv", strain)
        .file("warm.csv", warm)
        .copy("samples/machines/maho700s.toml")
        .copy("samples/tables/archive.arc");
    let demo = machine("demo");
    let maho = "maho700s.toml";
    shop.run(["fix", "p.mpf", "-o", "o.mpf", "--machine", "m.toml"]).exits(0);
    let trace = ["simulate", "p.mpf", "--machine", "m.toml", "--feed", "15000,25000", "-o", "trace.csv"];
    shop.run(trace).exits(0);
    let calibrate = ["calibrate", "bar.csv", "--machine", &demo, "--model", "quick.txt", "-o", "new.toml", "--json"];
    let shop = shop.file("quick.txt", "EC0X\n");
    let runs: Vec<(i32, Vec<&str>)> = vec![
        (0, vec!["check", "p.mpf", "--machine", "m.toml", "--json"]),
        (3, vec!["check", "wrong.mpf", "--machine", "m.toml", "--json"]),
        (0, vec!["fix", "p.mpf", "-o", "new.mpf", "--machine", "m.toml", "--json"]),
        (0, vec!["fix", "p.mpf", "-o", "slow.mpf", "--machine", "m.toml", "--feed-limit", "50um", "--json"]),
        (3, vec!["fix", "wrong.mpf", "-o", "w.mpf", "--machine", "m.toml", "--json"]),
        (0, vec!["verify", "p.mpf", "o.mpf", "--machine", "m.toml", "--at-feed", "--json"]),
        (3, vec!["verify", "wrong.mpf", "o.mpf", "--machine", "m.toml", "--json"]),
        (1, vec!["diff", "p.mpf", "o.mpf", "--machine", "m.toml", "--json"]),
        (1, vec!["diff", "p.mpf", "o.mpf", "--text", "--json"]),
        (3, vec!["diff", "wrong.mpf", "o.mpf", "--machine", "m.toml", "--json"]),
        (0, vec!["max-step", "--machine", "small.toml", "--residual", "2um", "--json"]),
        (0, vec!["machine", "show", maho, "--at", "X350,Y100,Z100,B0", "--json"]),
        (0, vec!["machine", "show", "m.toml", "--origin", "--json"]),
        (0, calibrate.to_vec()),
        (4, vec!["calibrate", "none.csv", "--machine", &demo, "--model", "quick.txt", "-o", "n.toml", "--json"]),
        (
            0,
            vec![
                "calibrate",
                "bar.csv",
                "--machine",
                &demo,
                "--model",
                "none",
                "--select",
                "EXX,EC0X",
                "-o",
                "s.toml",
                "--json",
            ],
        ),
        (0, vec!["diagnose", "laser.csv", "--machine", "known.toml", "--json"]),
        (4, vec!["diagnose", "none.csv", "--machine", &demo, "--json"]),
        (0, vec!["iso230", "bar.csv", "--machine", &demo, "--json"]),
        (0, vec!["decompose", "trace.csv", "--machine", "known.toml", "--json"]),
        (
            4,
            vec![
                "tables",
                "--machine",
                &demo,
                "--format",
                "cec",
                "--scheme",
                "auto",
                "--tolerance",
                "20um",
                "-o",
                "A.INI",
                "--json",
            ],
        ),
        (
            0,
            vec![
                "tables",
                "--machine",
                maho,
                "--format",
                "cec",
                "--scheme",
                "free",
                "--check",
                "-o",
                "B.INI",
                "--json",
            ],
        ),
        (0, vec!["tables", "--read", "archive.arc", "--json"]),
        (0, vec!["weigh", "strain.csv", "--machine", maho, "--json"]),
        (0, vec!["sensors", "warm.csv", "--machine", &demo, "--json"]),
        (0, vec!["feed", "part.ngc", "--machine", "mill", "--link", "grbl", "--dry-run", "--json"]),
    ];
    let mill = machine("knee_mill");
    let mut commands: Vec<String> = Vec::new();
    let mut check = |run: Run, code: i32, words: &[&str]| {
        assert_eq!(run.code, code, "{words:?}\n{}\n{}", run.stdout, run.stderr);
        keeps_to_its_schema(words[0], &run.stdout);
        assert!(run.stdout.starts_with('{'), "{words:?}");
        commands.push(words[0].to_owned());
    };
    for (code, words) in &runs {
        let words: Vec<&str> = words.iter().map(|word| if *word == "mill" { &mill } else { *word }).collect();
        check(shop.run(&words), *code, &words);
    }
    let live = "poll_s = 0.2\nconfirm = 1\n[source.in]\nkind = \"stdin\"\n[channel.T_head]\nsource = \"in\"\n";
    let watch = ["sensors", "S.toml", "--watch", "--for", "1", "--json"];
    // Whether the last reading came in time is not the question here.
    let run = Shop::new().file("S.toml", live).run_with_input(watch, b"{\"T_head\": 21.5}\n");
    let code = run.code;
    check(run, code, &watch);
    let mut passes = "G21 G90 G54\nG0 X0 Y0 Z50\n".to_owned();
    (0..40).for_each(|k| writeln!(passes, "G0 X{k} Y0\nG1 Z-1 F100\nY10 F300\nG0 Z50").unwrap());
    let resume = ["resume", "part.ngc.journal", "--clearance", "60mm", "--json"];
    check(cut_off(&(passes + "M30\n"), 80).run(resume), 0, &resume);
    commands.sort();
    commands.dedup();
    assert_eq!(commands, schema::all().iter().map(|(name, _)| (*name).to_owned()).collect::<Vec<_>>());
}
