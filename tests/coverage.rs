//! Coverage: a tool that knows where its measurements end says so, and a release gate refuses what they do not support.

use std::fmt::Write as _;

use ncfix_base::source::{FileId, Source};

use crate::support::{Run, Shop, machine};

/// A five-axis machine with measured errors of X, Y and Z alone. EXX is a cubic: 40 µm at 300 mm, 320 µm at 600 mm.
const FIVE_AXES: &str = "[machine]
name = \"five\"
topology = \"wCAYFXZSt\"
[axis.X]
direction = [1, 0, 0]
travel_mm = [0, 700]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [0, 500]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [0, 700]
[axis.A]
direction = [-1, 0, 0]
travel_deg = [-60, 60]
[axis.C]
direction = [0, 0, -1]
modulo = true
[control]
initial_zero_offset = \"G500\"
[location]
EC0X = 20.0
EA0Z = -15.0
[[motion]]
component = \"EXX\"
kind = \"polynomial\"
coefficients = [0, 0, 0, 1.4815e-9]
[[motion]]
component = \"EYY\"
kind = \"polynomial\"
coefficients = [0, 2e-5]
[[motion]]
component = \"EZZ\"
kind = \"polynomial\"
coefficients = [0, -3e-5]
";

const MEASURED: &str =
    "[measured]\nX_mm = [3, 597]\nY_mm = [0, 500]\nZ_mm = [0, 700]\nA_deg = [-60, 60]\nC_deg = [0, 360]\n";

/// A program that cuts along X from 100 mm to `x`, with A and C in the end position.
fn program(x: f64, a: f64, c: f64) -> String {
    format!("G90 G71 G0 X100 Y50 Z100 A0 C0\nG1 X{x} Y60 A{a} C{c} F500\nG0 Z700\nM30\n")
}

fn shop(own: &str, program: &str) -> Shop {
    Shop::new().file("five.toml", format!("{FIVE_AXES}{own}")).file("part.mpf", program)
}

/// Corrects the part with these further options, separated by blanks.
fn fix(shop: &Shop, further: &str) -> Run {
    let words = "part.mpf -o out.mpf --machine five.toml --max-correction 2mm --rotary hold";
    shop.run(words.split_whitespace().chain(further.split_whitespace()))
}

/// The gaps of a kind.
fn gaps<'j>(json: &'j serde_json::Value, kind: &str) -> Vec<&'j serde_json::Value> {
    json["coverage"]["gaps"].as_array().unwrap().iter().filter(|gap| gap["kind"] == kind).collect()
}

#[test]
fn rotary_axes_that_were_never_measured_are_named_and_nothing_is_green() {
    let shop = shop("", &program(300.0, 20.0, 90.0));
    let run = fix(&shop, "--review page.html --json").exits(0);
    assert!(run.codes().contains(&"W0316".to_owned()), "{}", run.stdout);
    let json = run.json();
    let axes: Vec<&str> = gaps(&json, "no-errors").iter().map(|gap| gap["axis"].as_str().unwrap()).collect();
    assert_eq!(axes, ["A", "C"]);
    // C is programmed with 90 degrees, A with 20.
    assert_eq!(gaps(&json, "no-errors")[1]["used"], serde_json::json!([0.0, 90.0]));
    assert_eq!(json["verdict"]["grade"], "warn");
    assert_eq!(json["verdict"]["is_covered"], false);
    let first = json["verdict"]["reasons"][0]["text"].as_str().unwrap();
    assert!(first.contains("A and C move, but their errors are not in the machine file"), "{first}");
    assert!(shop.text("page.html").contains("A and C move"));
    // For people: the verdict, and its reason in the next row.
    let run = fix(&shop, "--review page.html").exits(0);
    run.says("warning[W0316]").says("verdict      check it before it runs\n             W0316 A and C move");
    let verified = shop.run(["verify", "part.mpf", "out.mpf", "--machine", "five.toml"]).exits(0);
    assert!(verified.stdout.starts_with("verdict      check it before it runs\n             W0316 A and C move"));
}

#[test]
fn an_axis_in_its_zero_position_is_no_gap() {
    let shop = shop("", &program(300.0, 0.0, 0.0));
    let run = fix(&shop, "--review page.html --json").exits(0);
    let json = run.json();
    assert_eq!(json["coverage"], serde_json::json!({ "is_complete": false, "is_stated": false, "gaps": [] }));
    assert_eq!(json["verdict"]["grade"], "ok");
    assert_eq!(json["verdict"]["is_covered"], false);
    let run = fix(&shop, "--review page.html").exits(0);
    run.says("coverage     not known")
        .says("nothing found against running it; measured ranges and uncertainty not stated");
}

#[test]
fn within_the_measured_ranges_and_with_a_known_uncertainty_the_verdict_is_green() {
    let shop = shop(MEASURED, &program(590.0, 20.0, 90.0));
    let json = fix(&shop, "--review page.html --json --require-coverage").exits(0).json();
    assert_eq!(json["coverage"], serde_json::json!({ "is_complete": true, "is_stated": true, "gaps": [] }));
    assert_eq!((&json["verdict"]["grade"], &json["verdict"]["is_covered"]), (&"ok".into(), &true.into()));
    let run = fix(&shop, "--review page.html").exits(0).says("coverage     within the measured ranges");
    run.says("verdict      nothing found against running it; uncertainty not known\n");
    shop.run(["verify", "part.mpf", "out.mpf", "--machine", "five.toml", "--require-coverage"]).exits(0);
    // With a known uncertainty that is small beside the errors, nothing is missing.
    let known = format!("{MEASURED}[uncertainty]\nEC0X = 1\nEA0Z = 1\nEXX = 0.5\nEYY = 0.5\nEZZ = 0.5\n");
    let shop = self::shop(&known, &program(590.0, 20.0, 90.0));
    let run = fix(&shop, "--review page.html").exits(0);
    run.says("verdict      nothing found against running it\n").says("interval     95 %: largest error");
    let json = fix(&shop, "--review page.html --json").exits(0).json();
    assert_eq!((&json["verdict"]["is_certain"], &json["prediction"]["is_known"]), (&true.into(), &true.into()));
}

#[test]
fn a_position_beyond_the_measured_range_is_named_with_its_distance_and_size() {
    let shop = shop(MEASURED, &program(650.0, 20.0, 90.0));
    let run = fix(&shop, "--json").exits(0);
    assert_eq!(run.codes(), ["W0317"]);
    let json = run.json();
    let gap = gaps(&json, "position")[0].clone();
    assert_eq!((&gap["axis"], &gap["unit"], &gap["code"]), (&"X".into(), &"mm".into(), &"W0317".into()));
    assert_eq!(gap["measured"], serde_json::json!([3.0, 597.0]));
    assert!((gap["beyond"].as_f64().unwrap() - 53.0).abs() < 1e-9, "{gap}");
    // The cubic rises by 1.4815e-9 (650³ − 597³) mm; the offsets of squareness change by nothing along X.
    let rise_um = 1.4815e-6 * (650_f64.powi(3) - 597_f64.powi(3));
    assert!((gap["size_um"].as_f64().unwrap() - rise_um).abs() < 0.02 * rise_um, "{gap} {rise_um}");
    fix(&shop, "").exits(0).says("X 650 mm is 53 mm above the measured range, 3 to 597 mm; 91.6 µm of the error");
}

#[test]
fn rapid_moves_that_retract_do_not_count() {
    // Z goes to 700 mm with G0, and the cut stays at 100 mm.
    let own = MEASURED.replace("Z_mm = [0, 700]", "Z_mm = [0, 300]");
    let shop = shop(&own, &program(300.0, 20.0, 90.0));
    let json = fix(&shop, "--json").exits(0).json();
    assert_eq!(json["coverage"]["is_complete"], true, "{json}");
}

#[test]
fn an_arc_counts_with_its_crest() {
    let circle = "G90 G71 G17 G0 X500 Y50 Z100 A0 C0\nG3 X500 Y250 I0 J100 F500\nG1 X400\nM30\n";
    let shop = shop(MEASURED, circle);
    let json = fix(&shop, "--json").exits(0).json();
    // Half a circle of radius 100 mm about X500 Y150, counter-clockwise from its lowest point, reaches X600: 3 mm beyond.
    assert!((gaps(&json, "position")[0]["beyond"].as_f64().unwrap() - 3.0).abs() < 1e-9, "{json}");
}

#[test]
fn a_table_states_its_own_range() {
    let table =
        "[[motion]]\ncomponent = \"EZX\"\nkind = \"table\"\npositions_mm = [0, 200, 400]\nvalues_um = [0, 4, 10]\n";
    let shop = shop(table, &program(500.0, 0.0, 0.0));
    let json = fix(&shop, "--json").exits(0).json();
    let gap = gaps(&json, "position")[0].clone();
    assert_eq!((&gap["table"], &gap["measured"]), (&"EZX".into(), &serde_json::json!([0.0, 400.0])));
    assert!((gap["beyond"].as_f64().unwrap() - 100.0).abs() < 1e-9);
    fix(&shop, "").exits(0).says("X 500 mm is 100 mm above the table of EZX, 0 to 400 mm");
}

#[test]
fn an_axis_without_a_stated_range_is_named() {
    let own = "[measured]\nX_mm = [0, 700]\nA_deg = [-60, 60]\nC_deg = [0, 360]\n";
    let shop = shop(own, &program(300.0, 20.0, 90.0));
    let run = fix(&shop, "").exits(0);
    run.says("warning[W0319]").says("Y moves, and [measured] does not state in which range it was measured");
    // A table of another component of Y says nothing of the polynomial EYY.
    let table = "[[motion]]\ncomponent = \"EXY\"\nkind = \"table\"\npositions_mm = [0, 500]\nvalues_um = [0, 4]\n";
    let shop = self::shop(&format!("{table}{own}"), &program(300.0, 20.0, 90.0));
    fix(&shop, "").exits(0).says("Y moves, and [measured] does not state in which range it was measured");
}

#[test]
fn a_modulo_axis_counts_within_its_turn() {
    let own = MEASURED.replace("C_deg = [0, 360]", "C_deg = [0, 90]");
    let turned = |c: f64| {
        let json = fix(&shop(&own, &program(300.0, 20.0, c)), "--json").exits(0).json();
        gaps(&json, "position").iter().map(|gap| gap["beyond"].as_f64().unwrap()).sum::<f64>()
    };
    assert_eq!(turned(45.0), 0.0);
    assert!((turned(120.0) - 30.0).abs() < 1e-6);
}

#[test]
fn a_longer_tool_is_named_where_angles_matter() {
    let tool = "tool_length_mm = [100, 150]\n[[tool]]\nnumber = 5\nlength_mm = 220.0\n";
    let cut = "G90 G71 G17\nT5 M6\nG0 X100 Y50 Z300 D1\nG1 X200 F500\nM30\n";
    let run = fix(&shop(&format!("{MEASURED}{tool}"), cut), "").exits(0);
    run.says("warning[W0318]")
        .says("a tool of 220 mm is 70 mm longer than the tools of the measurement, 100 to 150 mm");
    let json = fix(&shop(&format!("{MEASURED}{tool}"), cut), "--json").exits(0).json();
    // EA0Z = -15 µrad at 70 mm more.
    let size_um = gaps(&json, "tool-length")[0]["size_um"].as_f64().unwrap();
    assert!((size_um - 1.05).abs() < 0.02, "{json}");
    // Three linear axes without angular errors: the length of the tool does not matter.
    let straight = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n[control]\ninitial_zero_offset = \"G500\"\n\
        [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 700]\n\
        [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 700]\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 2e-5]\n\
        [measured]\nX_mm = [0, 700]\nY_mm = [0, 700]\nZ_mm = [0, 700]\n";
    let shop = Shop::new().file("five.toml", format!("{straight}{tool}")).file("part.mpf", cut);
    assert_eq!(fix(&shop, "--json").exits(0).json()["coverage"]["is_complete"], true);
}

#[test]
fn temperatures_and_loads_beyond_the_measured_ones_are_named() {
    let own = "[measured]\nX_mm = [0, 700]\nY_mm = [0, 500]\nZ_mm = [0, 700]\nload_N = [0, 1000]\n\
        temperature_C = { HEAD = [18, 26] }\n\
        [[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"HEAD\", um_per_K = 4.0 }]\n\
        [[load]]\ncomponent = \"EA0C\"\nreference_N = 1000\nvalue_urad = 10\n";
    let shop = shop(own, &program(300.0, 0.0, 0.0)).file("state.toml", "[temperature_C]\nHEAD = 31.0\n");
    let json = fix(&shop, "--json --state state.toml --load 1500").exits(0).json();
    let warm = gaps(&json, "temperature")[0].clone();
    assert_eq!((&warm["sensor"], &warm["unit"], &warm["beyond"]), (&"HEAD".into(), &"C".into(), &5.0.into()));
    // 5 K at 4 µm/K.
    assert!((warm["size_um"].as_f64().unwrap() - 20.0).abs() < 0.1, "{warm}");
    let heavy = gaps(&json, "load")[0].clone();
    assert_eq!((&heavy["unit"], &heavy["beyond"]), (&"N".into(), &500.0.into()));
    let cool = shop.file("state.toml", "[temperature_C]\nHEAD = 20.0\n");
    let json = fix(&cool, "--json --state state.toml --load 800").exits(0).json();
    assert_eq!(json["coverage"]["is_complete"], true, "{json}");
}

#[test]
fn a_release_gate_refuses_gaps_and_writes_nothing() {
    for (own, x, says) in [
        ("", 300.0, "A and C move, but their errors are not in the machine file"),
        ("", 300.0, "the machine file does not state in which ranges its errors were measured"),
        (MEASURED, 650.0, "X 650 mm is 53 mm above the measured range"),
    ] {
        let shop = shop(own, &program(x, 20.0, 90.0));
        fix(&shop, "--require-coverage").exits(4).says("error[E0322]").says(says);
        let check = ["check", "part.mpf", "--machine", "five.toml", "--max-correction", "2mm", "--rotary", "hold"];
        shop.run(check.into_iter().chain(["--require-coverage"])).exits(4).says("error[E0322]").says(says);
        shop.run(check).exits(0);
        assert_eq!(shop.names(), ["five.toml", "part.mpf"]);
        fix(&shop, "").exits(0);
        shop.run(["verify", "part.mpf", "out.mpf", "--machine", "five.toml"]).exits(0);
        let gate = ["verify", "part.mpf", "out.mpf", "--machine", "five.toml", "--require-coverage"];
        let run = shop.run(gate).exits(4).says("error[E0322]").says(says);
        assert!(run.stdout.contains("verdict      should not run"), "{}", run.stdout);
    }
}

#[test]
fn tables_are_not_filled_beyond_the_measured_range_in_silence() {
    let shop = shop(MEASURED, "");
    let words = "tables --machine five.toml --format cec --scheme fik -o CEC.INI --json";
    let run = shop.run(words.split_whitespace()).exits(0);
    assert!(run.codes().contains(&"W0317".to_owned()), "{}", run.stdout);
    let run = shop.run(words.split_whitespace().filter(|word| *word != "--json"));
    run.says("X 700 mm is 103 mm above the measured range, 3 to 597 mm");
    // A part of the travel that was measured.
    let part = words.split_whitespace().chain(["--range", "X=3..597"]);
    assert!(!shop.run(part).exits(0).codes().contains(&"W0317".to_owned()));
}

#[test]
fn a_transfer_names_gaps_before_it_begins() {
    let shop = shop(MEASURED, &program(650.0, 20.0, 90.0));
    let words = "feed part.mpf --machine five.toml --link siemens-v24 --port /dev/null --dry-run --max-correction 2mm";
    let run = shop.run(words.split_whitespace());
    run.says("X 650 mm is 53 mm above the measured range");
}

/// Rows of a laser along X at seven places and along Y at five, with errors of a scale.
fn laser() -> String {
    let mut rows = String::from("run,component,X,Y,Z,T_HEAD_C,value_um\n");
    for (k, x) in [12.5, 100.0, 200.0, 300.0, 400.0, 500.0, 612.25].into_iter().enumerate() {
        writeln!(rows, "1,EXX,{x},250,200,{},{}", 19.0 + 0.25 * k as f64, 0.03 * x).unwrap();
    }
    for (k, y) in [40.0, 120.0, 200.0, 280.0, 360.0].into_iter().enumerate() {
        writeln!(rows, "2,EYY,300,{y},150,{},{}", 22.0 + 0.25 * k as f64, -0.02 * y).unwrap();
    }
    rows
}

#[test]
fn a_calibration_writes_the_ranges_of_its_data() {
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\ndate = \"2026-11-20\"\n";
    let table = laser();
    let shop = Shop::new()
        .copy("samples/machines/demo.toml")
        .file("laser.csv", &table)
        .file("laser.toml", description)
        .file("parameters.txt", "EXX1\nEYY1\n");
    let words = "calibrate laser.csv --machine demo.toml --model parameters.txt -o new.toml --max 2mm";
    shop.run(words.split_whitespace()).exits(0);
    let text = shop.text("new.toml");
    // Independent arithmetic on the cells: rows of a component count for its own axis.
    let cells: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let range = |of: &dyn Fn(&[&str]) -> Option<f64>| {
        let values: Vec<f64> = cells.iter().filter_map(|row| of(row)).collect();
        [values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
    };
    let along = |component: &'static str, column: usize| {
        range(&move |row: &[&str]| (row[1] == component).then(|| row[column].parse().unwrap()))
    };
    let measured = read(&text).measured.unwrap();
    let axes: Vec<(String, [f64; 2])> = measured.axes.iter().map(|(axis, ends)| (axis.to_string(), *ends)).collect();
    assert_eq!(axes, [("X".to_owned(), along("EXX", 2)), ("Y".to_owned(), along("EYY", 3))], "{text}");
    assert_eq!(measured.temperatures_c["T_HEAD"], range(&|row: &[&str]| row[5].parse().ok()));
    assert_eq!((measured.date.as_deref(), measured.instruments), (Some("2026-11-20"), vec!["direct".to_owned()]));
    assert_eq!((measured.tool_length_mm, measured.load_n, measured.residual_um), (None, None, None));
    shop.run(["machine", "check", "new.toml"]).exits(0);
    let shown = shop.run(["machine", "show", "new.toml"]).exits(0);
    for row in ["\nmeasured\nX           12.5 … 612.25 mm\n", "T_HEAD      19 … 23 °C", "instruments direct"] {
        assert!(shown.stdout.contains(row), "{row}: {}", shown.stdout);
    }
}

#[test]
fn a_later_calibration_extends_the_ranges_and_states_the_residual_of_holdout_data() {
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.3\ndate = \"2026-11-20\"\n";
    let earlier = "\n[measured]\nX_mm = [-10, 300]\nZ_mm = [0, 100]\ndate = \"2026-01-02\"\nload_N = [0, 500]\n";
    let demo = std::fs::read_to_string(machine("demo")).unwrap() + earlier;
    let later = laser().replace("612.25", "550");
    let shop = Shop::new()
        .file("demo.toml", demo)
        .file("laser.csv", laser())
        .file("laser.toml", description)
        .file("later.csv", later)
        .file("later.toml", description)
        .file("parameters.txt", "EXX1\nEYY1\n");
    let words = "calibrate laser.csv --hold-out later.csv --machine demo.toml --model parameters.txt -o new.toml --max 2mm --json";
    let json = shop.run(words.split_whitespace()).exits(0).json();
    let measured = read(&shop.text("new.toml")).measured.unwrap();
    let axes: Vec<(String, [f64; 2])> = measured.axes.iter().map(|(axis, ends)| (axis.to_string(), *ends)).collect();
    let expected = [("X", [-10.0, 612.25]), ("Y", [40.0, 360.0]), ("Z", [0.0, 100.0])];
    assert_eq!(axes, expected.map(|(axis, ends)| (axis.to_owned(), ends)));
    assert_eq!((measured.date.as_deref(), measured.load_n), (Some("2026-11-20"), Some([0.0, 500.0])));
    let holdout = json["data"].as_array().unwrap().iter().find(|set| set["is_held_out"] == true).unwrap();
    let rms_um = holdout["left_rms"].as_f64().unwrap();
    assert!((measured.residual_um.unwrap() - rms_um).abs() < 1e-3 && rms_um > 0.0, "{holdout}");
}

#[test]
fn wrong_ranges_are_found_at_their_place() {
    let shop = Shop::new().file("five.toml", format!("{FIVE_AXES}[measured]\nX_mm = [600, 3]\nB_deg = [0, 1]\n"));
    let line = FIVE_AXES.lines().count() + 2;
    let run = shop.run(["machine", "check", "five.toml"]).exits(4);
    run.says("error[E0404]").says(&format!("five.toml:{line}:8")).says("error[E0402]");
}

/// The machine of a text.
fn read(text: &str) -> ncfix_machine::machine::Machine {
    let source = Source::new(FileId(0), "m.toml", text.as_bytes().to_vec()).unwrap();
    let (loaded, findings) = ncfix_model::file::load(&source);
    loaded.unwrap_or_else(|| panic!("{findings:?}\n{text}")).0
}

/// A program that the control runs itself may have moved every axis, and a program may begin to cut before it names all of them.
#[test]
fn a_cut_at_an_unknown_position_is_named() {
    let opaque = format!("{MEASURED}[[opaque]]\nname = \"L6\"\n");
    let calls = "G90 G71 G0 X100 Y50 Z100 A0 C0\nL6\nG1 X120 F500\nY60 Z90\nG0 Z700\nM30\n";
    let begins = "G90 G71\nG1 X100 F500\nG0 Z700\nM30\n";
    for (own, text, line) in [(opaque.as_str(), calls, 3), (MEASURED, begins, 2)] {
        let shop = shop(own, text);
        let place = format!(
            "warning[W0322]: the tool cuts here, and the position of Y and Z is not known, so the correction is incomplete\n --> part.mpf:{line}:1"
        );
        fix(&shop, "--require-coverage").says("error[E0322]").says(&format!("part.mpf:{line}:1"));
        fix(&shop, "--review r.html").exits(0).says(&place).says("verdict      check it before it runs");
        let verified = shop.run(["verify", "part.mpf", "out.mpf", "--machine", "five.toml"]).says(&place);
        assert!(verified.stdout.starts_with("verdict      check it before it runs\n"), "{}", verified.stdout);
    }
    // Without a move of L6, and with a start, all positions are known.
    let still = format!("{MEASURED}[[opaque]]\nname = \"L6\"\nmoves = false\n");
    assert!(!fix(&shop(&still, calls), "").stderr.contains("W0322"));
    assert!(!fix(&shop(MEASURED, begins), "--start X0,Y0,Z0").stderr.contains("W0322"));
}

/// Postprocessors write the way to the first cut after a tool change as feed moves in the plane, and state Z after it.
#[test]
fn an_approach_after_a_tool_change_is_no_cut() {
    let begin = "G90 G71 G0 X100 Y50 Z700 A0 C0\nT1 M6\nG0 A0 C0\nG1 X120 Y60 F650\n";
    for (next, is_cut) in [
        ("G0 Z100\nG1 Z90 F100\n", false),
        ("X130\nG0 Z100\nG1 Z90 F100\n", false),
        // Down with feed, around an arc, and no height at all: perhaps a cut.
        ("G1 Z90 F100\n", true),
        ("G2 X140 Y60 I10 J0\nG0 Z100\n", true),
        ("", true),
    ] {
        let own = format!("{MEASURED}[[tool]]\nnumber = 1\nlength_mm = 100\nradius_mm = 3\n");
        let run = fix(&shop(&own, &format!("{begin}{next}M30\n")), "");
        assert_eq!(run.stderr.contains("warning[W0322]"), is_cut, "{next}\n{}", run.stderr);
        assert!(!is_cut || run.stderr.contains("the position of Z is not known"), "{next}\n{}", run.stderr);
    }
}

/// Programs for three axes on a machine with rotary axes: nothing says that the table is at 0°.
#[test]
fn rotary_axes_that_nothing_positions_are_named() {
    let text = "G90 G71 G0 X100 Y50 Z100\nG1 X120 F500\nG0 Z700\nM30\n";
    let shop = shop(MEASURED, text);
    fix(&shop, "--require-coverage").says("error[E0322]").says("part.mpf:2:1");
    fix(&shop, "--review r.html")
        .exits(0)
        .says("warning[W0324]: the tool cuts here, and the position of A and C is not stated; the correction is for 0°\n --> part.mpf:2:1")
        .says("verdict      check it before it runs");
    // The advice is followed.
    assert!(!fix(&shop, "--start X0,Y0,Z0,A0,C0").stderr.contains("W0324"));
    let stated = text.replacen("Z100", "Z100 A0 C0", 1);
    assert!(!fix(&self::shop(MEASURED, &stated), "").stderr.contains("W0324"));
}

/// A reference point, a program of the control or a tool change may have turned the table after its last motion. The correction still is that of the last
/// programmed angles, here C 90.
#[test]
fn rotary_axes_that_something_else_has_moved_are_named_with_their_assumed_place() {
    let own = format!("{MEASURED}[[opaque]]\nname = \"L6\"\n");
    let begin = "G90 G71 G0 X100 Y50 Z100 A0 C90\nG1 X120 F500\nG0 Z700\n";
    let end = "G0 X100 Y50 Z100\nG1 X120 F500\nG0 Z700\nM30\n";
    for (block, names, places) in [("G74 C1=0", "C", "C 90°"), ("L6", "A and C", "A 0° and C 90°")] {
        let text = format!("{begin}{block}\n{end}");
        let shop = shop(&own, &text);
        let message = format!(
            "warning[W0324]: the tool cuts here, and the position of {names} is no longer known; the correction is for {places}\n --> part.mpf:6:1"
        );
        fix(&shop, "--review r.html").exits(0).says(&message).says("verdict      check it before it runs");
        fix(&shop, "--require-coverage").says("error[E0322]").says("part.mpf:6:1");
        // The advice is followed.
        let stated = format!("{begin}{block}\nG0 A0 C90\n{end}");
        let run = fix(&self::shop(&own, &stated), "").exits(0);
        assert!(!run.stderr.contains("W0324"), "{}", run.stderr);
    }
    // start_deg says nothing about a reference point.
    let five = FIVE_AXES.replace("[axis.A]", "[axis.A]\nstart_deg = 0").replace("[axis.C]", "[axis.C]\nstart_deg = 30");
    for (block, is_named) in [("G74 C1=0\n", true), ("", false)] {
        let text = format!("G90 G71 G0 X100 Y50 Z100\nG0 Z700\n{block}{end}");
        let shop = Shop::new().file("five.toml", format!("{five}{MEASURED}")).file("part.mpf", text);
        let run = fix(&shop, "").exits(0);
        assert_eq!(run.stderr.contains("the position of C is no longer known"), is_named, "{}", run.stderr);
    }
}

/// Other languages: a MillPlus loses the axes of G74; G28 of a Fanuc and of LinuxCNC leads to a position that is known.
#[test]
fn only_a_reference_point_that_nothing_states_leaves_rotary_axes_unknown() {
    let cut = "G0 X100. Y50. Z100.\nG1 X120. F500\nG0 Z600.\n";
    for (controller, name, program, is_named) in [
        ("grundig", "part.pm", format!("%PM1\nN1 G17 G71 G90\nN2 G0 A10 C-90\n{cut}G74 A1=1\n{cut}M30\n"), true),
        (
            "fanuc",
            "part.nc",
            format!("%\nO1\nG21 G17 G90 G94\nG0 A10. C-90.\n{cut}G91 G28 A0.\nG90\n{cut}M30\n%\n"),
            false,
        ),
        ("rs274", "part.ngc", format!("G21 G17 G90 G94\nG0 A10 C-90\n{cut}G28 A10\n{cut}M2\n"), false),
    ] {
        let machine = FIVE_AXES.replace("[control]\ninitial_zero_offset = \"G500\"\n", "");
        let machine = machine.replace("modulo = true", "travel_deg = [-360, 360]");
        let machine = machine.replace("name = \"five\"", &format!("name = \"five\"\ncontroller = \"{controller}\""));
        let zero = "[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nset = \"absolute\"\n";
        let mut number = 10;
        let program: String = program
            .lines()
            .map(|line| {
                number += 1;
                let needs_number = controller == "grundig" && !line.starts_with(['N', '%']);
                if needs_number { format!("N{number} {line}\n") } else { format!("{line}\n") }
            })
            .collect();
        let shop = Shop::new().file("five.toml", format!("{machine}{MEASURED}{zero}")).file(name, program);
        let out = format!("out_{name}");
        let words = [name, "-o", &out, "--machine", "five.toml", "--max-correction", "2mm", "--rotary", "hold"];
        let run = shop.run(words).exits(0);
        let message = "the position of A is no longer known; the correction is for A 10°";
        assert_eq!(run.stderr.contains(message), is_named, "{controller}\n{}", run.stderr);
        assert_eq!(run.stderr.contains("W0324"), is_named, "{controller}\n{}", run.stderr);
    }
}

/// The machine file states where the rotary axes are at the beginning of every program.
#[test]
fn a_position_at_the_beginning_counts_as_programmed() {
    let begin = |a_deg: f64, c_deg: f64| {
        let five = FIVE_AXES.replace("[axis.A]", &format!("[axis.A]\nstart_deg = {a_deg}"));
        five.replace("[axis.C]", &format!("[axis.C]\nstart_deg = {c_deg}")) + MEASURED
    };
    let text = |rotary: &str| format!("G90 G71 G0 X100 Y50 Z100{rotary}\nG1 X120 F500\nG0 Z700\nM30\n");
    let at = |machine: &str, rotary: &str| {
        let shop = Shop::new().file("five.toml", machine).file("part.mpf", text(rotary));
        fix(&shop, "--json").exits(0)
    };
    let begins = at(&begin(20.0, 90.0), "");
    assert!(!begins.codes().contains(&"W0324".to_owned()), "{}", begins.stderr);
    // The errors are those of a program that names the position.
    let named = at(&format!("{FIVE_AXES}{MEASURED}"), " A20 C90").json();
    let unstated = at(&format!("{FIVE_AXES}{MEASURED}"), "").json();
    let begins = begins.json();
    assert_eq!(begins["before"], named["before"]);
    assert_ne!(begins["before"], unstated["before"]);
    // A tool change before the first motion does not take the statement back.
    let tool = "[[tool]]\nnumber = 1\nlength_mm = 0\n";
    let changed = |machine: &str| {
        let shop = Shop::new().file("five.toml", format!("{machine}{tool}"));
        let shop = shop.file("part.mpf", format!("T1 M6\n{}", text("")));
        fix(&shop, "--json").exits(0)
    };
    let begins = changed(&begin(20.0, 90.0));
    assert!(!begins.codes().contains(&"W0324".to_owned()), "{}", begins.stdout);
    assert_eq!(begins.json()["before"], named["before"]);
    assert!(changed(&format!("{FIVE_AXES}{MEASURED}")).codes().contains(&"W0324".to_owned()));
    // A position beyond the travel is a mistake.
    let far = Shop::new().file("five.toml", begin(500.0, 0.0)).file("part.mpf", text(""));
    fix(&far, "").exits(4).says("error[E0404]: start_deg of axis A is outside its travel");
}

/// A control whose lengths count from the machine zero has negative ones. Their sum with Z of the zero offset is right, but not the arm of an angle.
#[test]
fn a_tool_of_negative_length_is_named() {
    let tool = |length: f64, z: f64| {
        format!(
            "[[tool]]\nnumber = 1\nlength_mm = {length}\nradius_mm = 4.0\n[zero_offset.G54]\nX_mm = 0\nY_mm = 0\nZ_mm = {z}\n"
        )
    };
    let text = "G90 G71 G54\nT1 M6\nD1\nG0 X100 Y50 Z100 A0 C0\nG1 X120 F500\nG0 Z200\nM30\n";
    for (length, z, is_named) in [(-330.0, 450.0, true), (120.0, 0.0, false)] {
        let shop = shop(&tool(length, z), text);
        for arguments in [&["part.mpf", "-o", "out.mpf"][..], &["check", "part.mpf"]] {
            let run = shop.run(arguments.iter().chain(&["--machine", "five.toml", "--max-correction", "2mm"])).exits(0);
            assert_eq!(run.stderr.contains("W0327"), is_named, "{}", run.stderr);
            if is_named {
                run.says("a tool of this program has the length -330 mm");
            }
        }
        assert_eq!(fix(&shop, "--require-coverage").stderr.contains("has the length -330 mm"), is_named);
    }
}

/// After a program that the control itself runs, no position is known until the next programmed one: nothing is known of the error, and it is not 0.
#[test]
fn an_error_that_is_not_known_is_not_zero() {
    let opaque = format!("{MEASURED}[[opaque]]\nname = \"L6\"\n");
    let shop = shop(&opaque, "G90 G71 G0 X100 Y50 Z100 A0 C0\nL6\nG1 Z90 F500\nZ80\nM30\n");
    let run = fix(&shop, "--json").exits(0);
    let json = run.json();
    assert!(json["before"].is_null() && json["after"].is_null(), "{json}");
    let run = fix(&shop, "").exits(0);
    assert!(run.stderr.contains("error        not known") && !run.stderr.contains("0.000 µm"), "{}", run.stderr);
}
