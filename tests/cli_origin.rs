//! Which machine file is taken, and `ncfix machine show --origin`: where every value comes from.

use crate::support::{Run, Shop, machine};

/// A machine of one axis, so that lines can be counted by hand.
const SMALL: &str = "\
[machine]
name = \"small\"
topology = \"wFXt\"

[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 100]

[control]
arc_tolerance_mm = 0.02

[zero_offset.G54]
X_mm = 10

[[tool]]
number = 5
length_mm = 120

[[tool]]
number = 5
edge = 2
length_mm = 80
";

/// Value and origin of a path in a page.
fn row<'a>(run: &'a Run, path: &str) -> (&'a str, &'a str) {
    let start = format!("{path} ");
    let line =
        run.stdout.lines().find(|line| line.starts_with(&start)).unwrap_or_else(|| panic!("{path}:\n{}", run.stdout));
    let (value, origin) = line[path.len()..].trim().rsplit_once("  ").unwrap();
    (value.trim(), origin.trim())
}

#[test]
fn every_value_says_where_it_was_written() {
    let shop = Shop::new().file("m.toml", SMALL);
    let run = shop.run(["machine", "show", "m.toml", "--origin"]).exits(0);
    assert!(run.stdout.starts_with("machine file m.toml (named on the command line)\n"), "{}", run.stdout);
    for (path, value, origin) in [
        ("machine.name", "\"small\"", "m.toml:2"),
        ("machine.controller", "\"sinumerik\"", "default"),
        ("axis.X.travel_mm", "[0, 100]", "m.toml:7"),
        ("axis.X.point_mm", "[0, 0, 0]", "default"),
        ("spindle.axis", "[0, 0, 1]", "default"),
        ("control.arc_tolerance_mm", "0.02", "m.toml:10"),
        ("control.arc_tolerance_ratio", "0.001", "default"),
        ("control.increment_mm", "0.0001", "default"),
        ("zero_offset.G54.X_mm", "10", "m.toml:13"),
        ("tool[5,1].length_mm", "120", "m.toml:17"),
        ("tool[5,1].edge", "1", "default"),
        ("tool[5,2].length_mm", "80", "m.toml:22"),
    ] {
        assert_eq!(row(&run, path), (value, origin), "{path}");
    }
}

#[test]
fn set_up_files_go_over_the_machine_file_and_the_last_one_wins() {
    let shop = Shop::new()
        .file("m.toml", SMALL)
        .file("job.toml", "[zero_offset.G54]\nX_mm = 25\n\n[zero_offset.G55]\nX_mm = 1\n")
        .file(
            "tools.toml",
            "[[tool]]\nnumber = 5\nlength_mm = 90\nradius_mm = 4\n[zero_offset.G55]\nX_mm = 2\n[gud]\ndepth = 3\n",
        );
    let words = ["machine", "show", "m.toml", "--setup", "job.toml", "--setup", "tools.toml", "--origin"];
    let run = shop.run(words).exits(0);
    assert!(
        run.stdout.contains("\nset-up file  job.toml (--setup)\nset-up file  tools.toml (--setup)\n"),
        "{}",
        run.stdout
    );
    for (path, value, origin) in [
        ("zero_offset.G54.X_mm", "25", "job.toml:2"),
        ("zero_offset.G55.X_mm", "2", "tools.toml:6"),
        ("tool[5,1].length_mm", "90", "tools.toml:3"),
        ("tool[5,1].radius_mm", "4", "tools.toml:4"),
        ("tool[5,2].length_mm", "80", "m.toml:22"),
        ("gud.DEPTH", "3", "tools.toml:8"),
    ] {
        assert_eq!(row(&run, path), (value, origin), "{path}");
    }
    assert_eq!(run.stdout.matches("zero_offset.G55.X_mm").count(), 1);
    // The same as data.
    let json = shop.run(words.into_iter().chain(["--json"])).exits(0).json();
    let rows = json["values"].as_array().unwrap();
    let found = rows.iter().find(|row| row["path"] == "zero_offset.G54.X_mm").unwrap();
    assert_eq!((found["value"].as_str(), found["origin"].as_str()), (Some("25"), Some("job.toml:2")));
    assert_eq!(json["files"][1]["found"], "--setup");
}

#[test]
fn saved_data_of_a_control_is_named_too() {
    let data = "%_N_TO1_TOA\n;data\n$TC_DP1[7,1]=120\n$TC_DP3[7,1]=95.5\n$TC_DP6[7,1]=3\nM17\n";
    let shop = Shop::new().file("m.toml", SMALL).file("TO.TOA", data).file("r.RPA", "%_N_RPA\nR5=1.5\nR15=2\nM17\n");
    let run = shop.run(["machine", "show", "m.toml", "--setup", "TO.TOA", "--setup", "r.RPA", "--origin"]).exits(0);
    assert_eq!(row(&run, "tool[7,1].length_mm"), ("[95.5, 0, 0]", "TO.TOA:3"));
    assert_eq!(row(&run, "parameter.R5"), ("1.5", "r.RPA:2"));
    assert_eq!(row(&run, "tool[5,1].length_mm"), ("120", "m.toml:17"));
}

/// The method holds for a zero that was set again; the pose of the old touch does not.
#[test]
fn the_method_of_a_zero_stays_until_another_is_stated() {
    let machine = SMALL.replace("X_mm = 10\n", "X_mm = 10\nset = \"absolute\"\nset_at = { X_mm = 3 }\n");
    let shop = Shop::new()
        .file("m.toml", machine)
        .file("value.toml", "[zero_offset.G54]\nX_mm = 25\n")
        .file("method.toml", "[zero_offset.G54]\nset = \"probed\"\n")
        .file("UFR.INI", "%_N_CH_UFR_INI\n$P_UIFR[1,X,TR]=10\nM17\n");
    let show = |setup: &str| shop.run(["machine", "show", "m.toml", "--setup", setup, "--origin"]).exits(0);
    for (setup, value, set) in [
        ("value.toml", ("25", "value.toml:2"), ("\"absolute\"", "m.toml:14")),
        ("method.toml", ("10", "m.toml:13"), ("\"probed\"", "method.toml:2")),
        ("UFR.INI", ("10", "UFR.INI:2"), ("\"absolute\"", "m.toml:14")),
    ] {
        let run = show(setup);
        assert_eq!(row(&run, "zero_offset.G54.X_mm"), value, "{setup}");
        assert_eq!(row(&run, "zero_offset.G54.set"), set, "{setup}");
        assert!(!run.stdout.contains("set_at"), "{setup}: {}", run.stdout);
    }
}

/// Data of the control that are equal to the machine file are those of the control nevertheless.
#[test]
fn equal_data_of_the_control_are_named() {
    let data = "%_N_TO1_TOA\n$TC_DP1[5,1]=120\n$TC_DP3[5,1]=120\n$TC_DP6[5,1]=0\nM17\n";
    let shop = Shop::new().file("m.toml", SMALL).file("TO.TOA", data);
    let run = shop.run(["machine", "show", "m.toml", "--setup", "TO.TOA", "--origin"]).exits(0);
    assert_eq!(row(&run, "tool[5,1].length_mm"), ("[120, 0, 0]", "TO.TOA:2"));
    assert_eq!(row(&run, "tool[5,2].length_mm"), ("80", "m.toml:22"));
}

/// A set-up that states only the method must not move the zero to the machine zero.
#[test]
fn a_method_alone_keeps_the_zero() {
    let shop = Shop::new()
        .file("m.toml", SMALL)
        .file("part.mpf", "N10 G90 G71 G54\nN20 G0 X5\nN30 M30\n")
        .file("method.toml", "[zero_offset.G54]\nset = \"probed\"\n");
    let run = shop.run(["snc", "part.mpf", "--machine", "m.toml", "--setup", "method.toml"]).exits(0);
    assert!(run.stdout.contains("G0 X15 "), "{}", run.stdout);
}

#[test]
fn the_machine_file_is_that_of_the_option_the_variable_the_program_the_working_folder() {
    let named = |name: &str| SMALL.replace("small", name);
    let program = "N10 G90 G71 G54 G0 X10\nN20 M30\n";
    let shop = Shop::new()
        .file("ncfix.toml", named("here"))
        .file("parts/ncfix.toml", named("beside"))
        .file("parts/a/part.mpf", program)
        .file("part.mpf", program)
        .file("option.toml", named("option"))
        .file("variable.toml", named("variable"));
    let check = |words: &[&str], variable: Option<&str>| {
        let mut command = shop.command(["-v", "check"].iter().chain(words));
        if let Some(variable) = variable {
            command.env("NCFIX_MACHINE", variable);
        }
        let output = command.output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        said.lines().find(|line| line.contains("machine file, ")).unwrap_or_else(|| panic!("{said}")).to_owned()
    };
    let of_option = check(&["parts/a/part.mpf", "--machine", "option.toml"], Some("variable.toml"));
    assert_eq!(of_option, "note: read option.toml: machine file, --machine");
    let of_variable = check(&["parts/a/part.mpf"], Some("variable.toml"));
    assert_eq!(of_variable, "note: read variable.toml: machine file, NCFIX_MACHINE");
    let beside = check(&["parts/a/part.mpf"], None);
    assert!(
        beside.contains("parts/ncfix.toml: machine file, the nearest ncfix.toml from the folder of the program"),
        "{beside}"
    );
    // A variable that is empty is none; standard input has no folder.
    let here = check(&["-"], Some(""));
    assert!(here.contains("ncfix.toml: machine file, the nearest ncfix.toml from the working folder"), "{here}");

    let show = |variable: &str| {
        let mut command = shop.command(["machine", "show", "--origin"]);
        command.env("NCFIX_MACHINE", variable);
        String::from_utf8(command.output().unwrap().stdout).unwrap()
    };
    assert!(
        show("variable.toml").starts_with("machine file variable.toml (NCFIX_MACHINE)\n"),
        "{}",
        show("variable.toml")
    );
    assert!(show("").contains("(the nearest ncfix.toml from the working folder upwards)"), "{}", show(""));
    let mut missing = shop.command(["check", "part.mpf"]);
    let output = missing.env("NCFIX_MACHINE", "none.toml").output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("cannot read none.toml: there is no such file or folder (machine file, NCFIX_MACHINE)"),
        "{said}"
    );
}

#[test]
fn without_any_file_the_demo_machine_says_that_it_is_one() {
    let run = Shop::new().run(["machine", "show", "--origin"]).exits(0).says("W0304");
    assert!(
        run.stdout.starts_with("machine file <demo machine> (embedded, as no machine file was found)\n"),
        "{}",
        run.stdout
    );
}

#[test]
fn every_sample_machine_has_its_origins() {
    for name in ["esmaeili_xyz5", "maho700s", "universal_mill", "vmc"] {
        let run = Shop::new().run(["machine", "show", &machine(name), "--origin"]).exits(0);
        let values = run.stdout.lines().filter(|line| line.contains(&format!("{name}.toml:"))).count();
        // Every line of the file with a key at its beginning is a value.
        let text = std::fs::read_to_string(machine(name)).unwrap();
        let keys = text.lines().filter(|line| {
            line.starts_with(|letter: char| letter.is_alphabetic() || letter == '"') && line.contains(" = ")
        });
        assert!(values >= keys.count(), "{name}: {values}\n{}", run.stdout);
    }
}

#[test]
fn the_defaults_are_those_of_the_documents() {
    let run = Shop::new().file("m.toml", SMALL).run(["machine", "show", "m.toml", "--origin"]).exits(0);
    let mut compared = 0;
    for document in ["docs/reference/settings.md", "docs/reference/grundig.md"] {
        let text = std::fs::read_to_string(crate::support::repository(document)).unwrap();
        // The last table holds ranges, not defaults.
        let text = text.split("\n## Ranges of numbers").next().unwrap();
        for line in text.lines().filter(|line| line.starts_with("| `")) {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let keys: Vec<&str> = cells[1].split('`').skip(1).step_by(2).collect();
            let values: Vec<&str> = cells[2].split(", ").map(|value| value.trim_matches('`')).collect();
            for (key, value) in keys.iter().zip(&values).filter(|_| keys.len() == values.len()) {
                let path = format!("control.{key} ");
                let shown = run.stdout.lines().find(|line| line.starts_with(&path) && line.ends_with("  default"));
                // What the documents put in words has no value that could be written.
                let is_value = value.starts_with(|first: char| first.is_ascii_digit() || "\"[{".contains(first))
                    || matches!(*value, "true" | "false");
                if let (Some(line), true) = (shown, is_value && !value.contains([' ', ';'])) {
                    let said = line[path.len()..].trim().trim_end_matches("default").trim();
                    assert_eq!(said, *value, "{document}: {key}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn what_a_kind_of_error_leaves_out_has_a_default_too() {
    let periodic = "\n[[motion]]\ncomponent = \"EXX\"\nkind = \"periodic\"\nperiod_mm = 10\namplitude_um = 1\n";
    let shop = Shop::new().file("m.toml", SMALL.to_owned() + periodic);
    let run = shop.run(["machine", "show", "m.toml", "--origin"]).exits(0);
    assert_eq!(row(&run, "motion[1].phase_deg"), ("0", "default"));
    assert_eq!(row(&run, "motion[1].period_mm"), ("10", "m.toml:27"));
}
