//! The test workpiece: what its plan and program are, and what its measured features tell. The truth is arithmetic of this file: displacements of a
//! machine with few errors, and a reader of programs that knows straight moves and comments only.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::Value;

use crate::support::{Shop, machine};

/// A gantry mill: F carries X, X carries Y, Y carries Z with the spindle.
const START: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\nreference_temperature_C = 20\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 600]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 400]\n[control]\nincrement_mm = 0.0001\n";
/// Scale of X and Z, per mm; Y leans back by `LEAN` and Z to the right by `TILT`, rad.
const SCALE_X: f64 = 100e-6;
const SCALE_Z: f64 = -80e-6;
const LEAN: f64 = 50e-6;
const TILT: f64 = 30e-6;
/// The errors of these constants.
const ERRORS: &str = "[location]\nEC0Y = 50.0\nEB0Z = 30.0\n[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\n\
    coefficients = [0, 1.0e-4]\n[[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0, -8.0e-5]\n";
/// Length of the end mill, mm, and the zero of the workpiece as a position of its tip.
const LENGTH: f64 = 100.0;
const ZERO: [f64; 3] = [300.0, 250.0, 100.0];

/// The plan of these tests, into `part.csv` and `PART.MPF`.
const PLAN: [&str; 10] =
    ["plan", "workpiece", "--tool", "100", "--centre", "300,250,100", "-o", "part.csv", "--program", "PART.MPF"];

/// The set-up file for it.
const JOB: &str = "[zero_offset.G54]\nX_mm = 300\nY_mm = 250\nZ_mm = 100\nset = \"absolute\"\n[[tool]]\nnumber = 1\n\
    length_mm = 100\nradius_mm = 6\n";

/// Displacement of a tip that is commanded to a position, mm: by hand, to first order.
fn displacement(tip: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = tip;
    [SCALE_X * x - LEAN * y + TILT * z, 0.0, SCALE_Z * (z + LENGTH)]
}

/// A table by column.
struct Rows(Vec<BTreeMap<String, String>>);

impl Rows {
    fn read(text: &str) -> Rows {
        let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let names = lines.next().unwrap();
        Rows(lines.map(|cells| names.iter().cloned().zip(cells).collect()).collect())
    }
}

fn number(row: &BTreeMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap_or_else(|_| panic!("{name}: {}", row[name]))
}

fn nominal(row: &BTreeMap<String, String>) -> [f64; 3] {
    ["nominal_x_mm", "nominal_y_mm", "nominal_z_mm"].map(|name| number(row, name))
}

fn near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() <= within, "{found} is not {expected}");
}

/// A move of a program: the feature, `true` at rapid, and where the axes of the program then are.
#[derive(Clone, Debug)]
struct Step {
    feature: String,
    is_rapid: bool,
    at: [Option<f64>; 3],
}

/// Straight moves of a program in any language, with the last comment that names a feature.
fn steps(program: &str) -> Vec<Step> {
    let mut out = Vec::new();
    let (mut feature, mut is_rapid, mut at) = (String::new(), true, [None; 3]);
    for line in program.lines() {
        if let Some((_, comment)) = line.split_once([';', '(']) {
            let name = comment.trim().split(':').next().unwrap_or_default();
            if name.len() < 9 && name.contains('L') && name.starts_with(['H', 'S']) {
                name.clone_into(&mut feature);
            }
            continue;
        }
        let mut has_moved = false;
        for word in line.split_whitespace() {
            match (word, word.chars().next(), word.get(1..).and_then(|rest| rest.parse::<f64>().ok())) {
                ("G0", ..) => is_rapid = true,
                ("G1", ..) => is_rapid = false,
                (_, Some(letter @ 'X'..='Z'), Some(value)) => {
                    at["XYZ".find(letter).unwrap()] = Some(value);
                    has_moved = true;
                }
                _ => {}
            }
        }
        if has_moved {
            out.push(Step { feature: feature.clone(), is_rapid, at });
        }
    }
    out
}

fn full(step: &Step) -> [f64; 3] {
    step.at.map(|value| value.unwrap())
}

/// Middle of the least and the largest value.
fn middle(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    low.midpoint(values.fold(f64::NEG_INFINITY, f64::max))
}

/// A plan on the machine of this file.
fn planned() -> (Shop, Rows) {
    let shop = Shop::new().file("start.toml", START).file("true.toml", START.to_owned() + ERRORS).file("job.toml", JOB);
    let run = shop.run(PLAN.into_iter().chain(["--machine", "start.toml"])).exits(0);
    assert!(run.stderr.contains("--at X300,Y250,Z200"), "{}", run.stderr);
    let rows = Rows::read(&shop.text("part.csv"));
    (shop, rows)
}

/// Values of the parameters of a calibration.
fn calibrated(shop: &Shop, table: &str) -> BTreeMap<String, f64> {
    let run =
        ["calibrate", table, "--machine", "start.toml", "--model", "EXX1,EZZ1,EC0Y,EB0Z", "-o", "found.toml", "--json"];
    let report = shop.run(run).exits(0).json();
    let all = report["parameters"].as_array().unwrap();
    all.iter().map(|one| (one["name"].as_str().unwrap().to_owned(), one["value"].as_f64().unwrap())).collect()
}

fn is_the_truth(found: &BTreeMap<String, f64>, within: f64) {
    for (name, value) in [("EXX1", 100.0), ("EZZ1", -80.0), ("EC0Y", 50.0), ("EB0Z", 30.0)] {
        near(found[name], value, within);
    }
}

#[test]
fn a_hole_is_where_the_tool_was() {
    let (shop, rows) = planned();
    // Nine holes and six stairs at twelve levels.
    assert_eq!(rows.0.len(), (9 + 6) * 12);
    let note = shop.run(PLAN.into_iter().chain(["--machine", "start.toml", "--model", "EXX1,EZZ1,EC0Y,EB0Z"])).exits(0);
    assert!(note.stderr.contains("the plan determines 10 of 10"), "{}", note.stderr);
    shop.run(["simulate", "part.csv", "--machine", "true.toml", "-o", "measured.csv"]).exits(0);
    let measured = Rows::read(&shop.text("measured.csv"));
    let mut largest: f64 = 0.0;
    for (plan, row) in rows.0.iter().zip(&measured.0) {
        let place = nominal(plan);
        let tip = [0, 1, 2].map(|k| ZERO[k] + place[k]);
        // The point of the tool that makes the feature is at the nominal position.
        for (k, (axis, tool)) in [("X", "tool_x_mm"), ("Y", "tool_y_mm"), ("Z", "tool_z_mm")].into_iter().enumerate() {
            near(number(plan, axis) + number(plan, tool), tip[k], 1e-6);
        }
        let is_hole = plan["feature"].starts_with('H');
        let [dx, _, _] = displacement(tip);
        if is_hole {
            assert_eq!((row["dz_um"].as_str(), plan["X_dir"].as_str(), plan["Y_dir"].as_str()), ("-", "0", "0"));
            // The scale acts on the axis, the tilt on the tip; too far in +X is positive.
            near(number(row, "dx_um"), dx * 1e3, 0.02);
            near(number(row, "dy_um"), 0.0, 0.02);
            largest = largest.max(dx.abs());
        } else {
            assert_eq!((row["dx_um"].as_str(), row["dy_um"].as_str()), ("-", "-"));
            // The axis is a tool length above the tread. A scale that is too small leaves the tread too high or too low by its size.
            near(number(row, "dz_um"), SCALE_Z * number(plan, "Z") * 1e3, 0.02);
        }
    }
    assert!(largest > 0.02, "{largest}");
    is_the_truth(&calibrated(&shop, "measured.csv"), 0.05);
}

#[test]
fn a_report_of_a_measuring_machine_tells_the_errors() {
    let (shop, rows) = planned();
    // The measuring machine has another zero and another direction of X; a hole has no height, a tread nothing else.
    let (sin, cos) = 0.4e-3_f64.sin_cos();
    let mut report = "Feature;Nominal X;Nominal Y;Nominal Z;Actual X;Actual Y;Actual Z\n".to_owned();
    for row in &rows.0 {
        let place = nominal(row);
        let axis = number(row, "Z") - (ZERO[2] + place[2] + LENGTH);
        let [dx, dy, dz] = displacement([0, 1, 2].map(|k| ZERO[k] + place[k]));
        let [x, y, z] = [place[0] + dx, place[1] + dy, place[2] + dz + SCALE_Z * axis];
        let (x, y, z) = (cos * x - sin * y + 0.02, sin * x + cos * y - 0.03, z + 0.005);
        let [nx, ny, nz] = place;
        let actual = match row["feature"].starts_with('H') {
            true => format!("{x:.5};{y:.5};"),
            false => format!(";;{z:.5}"),
        };
        writeln!(report, "{};{nx};{ny};{nz};{actual}", row["feature"]).unwrap();
    }
    let shop = shop.file("report.csv", report);
    let import =
        ["import", "report.csv", "--machine", "start.toml", "--at", "X300,Y250,Z200", "--sign", "+", "--unit", "mm"];
    let more = ["--tool", "100", "--material", "20C", "--sigma", "0.5", "-o", "cmm.csv"];
    let run = shop.run(import.into_iter().chain(more)).exits(0);
    assert!(
        run.stdout.contains("180 readings") || run.stderr.contains("180 readings"),
        "{} {}",
        run.stdout,
        run.stderr
    );
    is_the_truth(&calibrated(&shop, "cmm.csv"), 1.0);
}

#[test]
fn the_program_makes_the_planned_features() {
    let mut languages = 0;
    for name in ["demo", "vmc", "knee_mill", "universal_mill"] {
        let shop = Shop::new();
        let plan = ["plan", "workpiece", "--machine", &machine(name), "-o", "p.csv", "--program", "p.nc"];
        let run = shop.run(plan).exits(0);
        let text = shop.text("p.nc");
        let steps = steps(&text);
        let rows = Rows::read(&shop.text("p.csv"));
        // The first motion leads up, and no rapid motion goes sideways below the clearance.
        assert!(steps[0].at[0].is_none() && steps[0].at[2] == Some(20.0), "{name}: {:?}", steps[0]);
        for pair in steps.windows(2).filter(|pair| pair[0].at[0].is_some()) {
            let (from, to) = (full(&pair[0]), full(&pair[1]));
            let aside = (from[0] - to[0]).hypot(from[1] - to[1]) > 1e-9;
            assert!(!aside || !pair[1].is_rapid || from[2] >= 20.0 && to[2] >= 20.0, "{name}: {:?}", pair[1]);
            // A cut goes down or sideways, never both.
            assert!(pair[1].is_rapid || !aside || (from[2] - to[2]).abs() < 1e-9, "{name}: {:?}", pair[1]);
            // A rapid move down ends above the blank.
            assert!(!pair[1].is_rapid || to[2] >= 1.0, "{name}: {:?}", pair[1]);
        }
        assert_eq!(full(steps.last().unwrap())[2], 20.0);
        assert_eq!(rows.0.len(), 180);
        for row in &rows.0 {
            let own: Vec<[f64; 3]> =
                steps.iter().filter(|step| step.feature == row["feature"] && !step.is_rapid).map(full).collect();
            let floor = own.iter().map(|at| at[2]).fold(f64::INFINITY, f64::min);
            let cut: Vec<[f64; 3]> = own.into_iter().filter(|at| (at[2] - floor).abs() < 1e-9).collect();
            let [x, y, z] = nominal(row);
            near(floor, -3.0 * number(row, "level"), 1e-9);
            if row["feature"].starts_with('H') {
                near(middle(cut.iter().map(|at| at[0])), x, 1e-6);
                near(middle(cut.iter().map(|at| at[1])), y, 1e-6);
                near(z, floor + 1.5, 1e-9);
                // The walls recede by 0.7 mm from level to level.
                let wide = cut.iter().map(|at| at[0] - x).fold(0.0, f64::max);
                near(wide, 2.0 + 0.7 * (12.0 - number(row, "level")), 1e-6);
            } else {
                // The tread begins at the edge of the end mill, and is 3 mm long.
                near(cut[0][1] - 6.0 + 1.5, y, 1e-6);
                assert!(cut.iter().all(|at| (at[0] - x).abs() < 1e-6), "{name}");
                near(z, floor, 1e-9);
            }
        }
        let start = text.find("M3").unwrap();
        assert!(start < text.find("G1 ").unwrap() && text.contains("S4000"), "{name}");
        assert!(run.stderr.contains("note: zero offset G"), "{}", run.stderr);
        languages += 1;
    }
    assert_eq!(languages, 4);
}

/// The lines of the note for a set-up file.
pub(crate) fn job(notes: &str) -> String {
    let lines = notes.lines().filter(|line| line.starts_with("    "));
    lines.fold(String::new(), |all, line| all + line.trim() + "\n")
}

#[test]
fn the_program_is_checked_fixed_and_verified() {
    let templates = ["vmc", "bridge", "gantry", "router", "moving-bed-router", "knee"];
    let controls = ["sinumerik", "fanuc", "rs274", "grundig"];
    let new = templates.iter().flat_map(|template| controls.iter().map(move |control| (*template, *control)));
    for (template, control) in std::iter::once(("", "")).chain(new) {
        let what = format!("{template} {control}");
        let mut shop = Shop::new();
        if template.is_empty() {
            shop = shop.copy("samples/machines/demo.toml");
            std::fs::rename(shop.path("demo.toml"), shop.path("m.toml")).unwrap();
        } else {
            shop.run(["machine", "new", "m.toml", "--like", template, "--control", control]).exits(0);
        }
        let mut words = vec!["plan", "workpiece", "--machine", "m.toml", "-o", "p.csv", "--program", "p.nc"];
        if template == "moving-bed-router" {
            // It has travels of 180 mm in Y and 45 mm in Z.
            words.extend(["--blank", "160,140,50", "--points", "2", "--levels", "6"]);
        }
        let plan = shop.run(&words);
        assert_eq!(plan.code, 0, "{what}: {}", plan.stderr);
        let shop = shop.file("job.toml", job(&plan.stderr));
        let with = ["--machine", "m.toml", "--setup", "job.toml"];
        for words in [vec!["check", "p.nc"], vec!["fix", "p.nc", "-o", "q.nc"], vec!["verify", "p.nc", "q.nc"]] {
            let run = shop.run(words.iter().copied().chain(with));
            assert_eq!(run.code, 0, "{what} {}: {}", words[0], run.stderr);
        }
    }
}

#[test]
fn the_zero_offset_of_the_machine_is_used_where_it_is_the_zero() {
    let shop = Shop::new();
    // G54 of the sample is at X 150, Y 120, Z 80, and its tool 4 is an end mill of 12 mm.
    let plan = [
        "plan",
        "workpiece",
        "--machine",
        &machine("demo"),
        "--centre",
        "150,120,80",
        "-o",
        "p.csv",
        "--program",
        "p.mpf",
    ];
    let run = shop.run(plan).exits(0);
    assert!(!run.stderr.contains("--setup"), "{}", run.stderr);
    assert!(shop.text("p.mpf").contains("\nT4\nM6\nD1\nG54\n"));
    shop.run(["check", "p.mpf", "--machine", &machine("demo")]).exits(0);
    // Without its own zero offset, the program is refused.
    shop.run(["plan", "workpiece", "--machine", &machine("demo"), "-o", "p.csv", "--program", "p.mpf"]).exits(0);
    shop.run(["check", "p.mpf", "--machine", &machine("demo")]).exits(4).says("E0306");
}

/// Deviations of the features of a program on the true machine, µm, in the columns of a plan: walls and treads, by hand.
fn machined(program: &str, rows: &Rows) -> String {
    let steps = steps(program);
    let mut out =
        "feature,level,nominal_x_mm,nominal_y_mm,nominal_z_mm,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm,dx_um,dy_um,dz_um\n"
            .to_owned();
    for row in &rows.0 {
        let own: Vec<[f64; 3]> =
            steps.iter().filter(|step| step.feature == row["feature"] && !step.is_rapid).map(full).collect();
        let floor = own.iter().map(|at| at[2]).fold(f64::INFINITY, f64::min);
        let actual = |at: &[f64; 3], above: f64| {
            let tip = [ZERO[0] + at[0], ZERO[1] + at[1], ZERO[2] + at[2]];
            let [dx, dy, _] = displacement([tip[0], tip[1], tip[2] + above]);
            // The scale of Z acts on the axis, a tool length above the tip.
            [at[0] + dx, at[1] + dy, at[2] + SCALE_Z * (tip[2] + LENGTH)]
        };
        let [x, y, z] = nominal(row);
        let cells = if row["feature"].starts_with('H') {
            let cut: Vec<[f64; 3]> = own.iter().filter(|at| at[2] - floor < 0.1).map(|at| actual(at, 1.5)).collect();
            let [mx, my] = [0, 1].map(|k| middle(cut.iter().map(|at| at[k])));
            format!("{:.4},{:.4},-", (mx - x) * 1e3, (my - y) * 1e3)
        } else {
            let first = own.iter().find(|at| at[2] - floor < 0.1).unwrap();
            format!("-,-,{:.4}", (actual(first, 0.0)[2] - z) * 1e3)
        };
        let name = |name: &str| row[name].clone();
        let columns = "feature,level,nominal_x_mm,nominal_y_mm,nominal_z_mm,X,Y,Z,tool_x_mm,tool_y_mm,tool_z_mm";
        let own: Vec<String> = columns.split(',').map(name).collect();
        writeln!(out, "{},{cells}", own.join(",")).unwrap();
    }
    out
}

fn group<'a>(measurement: &'a Value, of: &str) -> &'a Value {
    let all = measurement["figures"].as_array().unwrap();
    all.iter().find(|one| one["of"] == of).unwrap_or_else(|| panic!("{of}: {all:?}"))
}

fn value(group: &Value, name: &str) -> f64 {
    let all = group["values"].as_array().unwrap();
    all.iter().find(|one| one["name"] == name).unwrap_or_else(|| panic!("{name}: {group}"))["value"].as_f64().unwrap()
}

#[test]
fn a_corrected_part_is_as_good_as_its_increments() {
    let (shop, rows) = planned();
    let with = ["--machine", "true.toml", "--setup", "job.toml"];
    shop.run(["fix", "PART.MPF", "-o", "OUT.MPF"].into_iter().chain(with)).exits(0);
    let [before, after] = ["PART.MPF", "OUT.MPF"].map(|name| machined(&shop.text(name), &rows));
    let toml = shop.text("part.toml");
    let shop =
        shop.file("before.csv", before).file("before.toml", &toml).file("after.csv", after).file("after.toml", &toml);
    let run = ["iso230", "before.csv", "after.csv", "--machine", "true.toml"];
    let report = shop.run(run.into_iter().chain(["--json"])).exits(0).json();
    let [one, other] = [0, 1].map(|k| &report["measurements"][k]);
    // By hand: scale and squareness over 120 mm about the center of the holes, ±6 µm and ±3 µm of which the rotation takes its half.
    let [rms, max] = ["rms", "max"].map(|name| value(group(one, "features"), name));
    assert!(rms > 2.0 && max > 6.0 && max < 15.0, "{rms} {max}");
    // The errors of the machine file are the true ones: they explain the first part.
    let left = value(group(one, "features without the errors of the machine file"), "max");
    assert!(left < 0.1, "{left}");
    // Increments of 0.1 µm, and a tolerance of 1 µm along the path.
    let against = group(other, "features against before");
    near(value(against, "rms before"), rms, 1e-9);
    assert!(value(against, "rms") < 0.2 && value(against, "max") < 1.0, "{against}");
    let efficiency = against["conditions"][1].as_str().unwrap();
    let efficiency: f64 = efficiency.trim_start_matches("efficiency ").trim_end_matches(" %").parse().unwrap();
    assert!(efficiency > 95.0, "{efficiency}");
    // Every feature has its line.
    assert_eq!(one["features"].as_array().unwrap().len(), 180);
    let text = shop.run(run).exits(0);
    let all = text.stdout + &text.stderr;
    assert!(all.contains("H9L12   dx ") && all.contains("S6L12   dz "), "{all}");
}

#[test]
fn a_drift_during_machining_is_the_change_from_level_to_level() {
    let (shop, rows) = planned();
    // A head that warms up by 1 K with each level moves the tool by 2 µm in X and -3 µm in Z.
    let drift = "[[drift]]\ndirection = \"X\"\nsensors = [{ name = \"T_head\", um_per_K = 2.0 }]\n\
        [[drift]]\ndirection = \"Z\"\nsensors = [{ name = \"T_head\", um_per_K = -3.0 }]\n";
    let mut text = String::new();
    for (number, line) in shop.text("part.csv").lines().enumerate() {
        let level = number.checked_sub(1).map(|row| rows.0[row]["level"].parse::<f64>().unwrap());
        let cell = level.map_or("T_head_C".to_owned(), |level| (19.0 + level).to_string());
        writeln!(text, "{line},{cell}").unwrap();
    }
    let toml = shop.text("part.toml");
    let shop = shop.file("warm.toml", START.to_owned() + drift).file("log.csv", text).file("log.toml", &toml);
    shop.run(["simulate", "log.csv", "--machine", "warm.toml", "-o", "drifted.csv"]).exits(0);
    let report = shop.run(["iso230", "drifted.csv", "--machine", "warm.toml", "--json"]).exits(0).json();
    let found = &report["measurements"][0];
    for level in 2..=12 {
        let of = group(found, &format!("level {level}"));
        let warmer = f64::from(level - 1);
        near(value(of, "dx"), 2.0 * warmer, 0.01);
        near(value(of, "dy"), 0.0, 0.01);
        near(value(of, "dz"), -3.0 * warmer, 0.01);
    }
    assert!(value(group(found, "features without the errors of the machine file"), "max") < 0.01);
    // The times of the plan never go back, and a wait between levels adds to them.
    let times: Vec<f64> = rows.0.iter().map(|row| number(row, "t_s")).collect();
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]) && times[0] > 5.0, "{times:?}");
    shop.run(PLAN.into_iter().chain(["--machine", "start.toml", "--dwell", "900"])).exits(0);
    let late = Rows::read(&shop.text("part.csv"));
    near(number(late.0.last().unwrap(), "t_s"), times.last().unwrap() + 11.0 * 900.0, 1.0);
}

#[test]
fn a_part_that_cannot_be_milled_or_measured_is_refused() {
    let shop = Shop::new().file("m.toml", START);
    let names = shop.names();
    let cases: [(&[&str], &str); 11] = [
        (&["--blank", "700,200,50"], "the blank of 700 mm in X is beyond the positions 2 to 598"),
        (&["--centre", "90,250,100"], "the blank of 200 mm in X is beyond"),
        (&["--points", "6"], "the outer holes are 31.4 mm wide, and only -50.0 mm from a side of the blank"),
        (&["--blank", "180,200,50"], "only 30.0 mm from a side of the blank"),
        (&["--every", "50"], "leave no wall of 3 mm beside the stairs; give --every 51.0 or more"),
        (&["--radius", "3"], "would leave a core"),
        (&["--levels", "16", "--radius", "8"], "need a blank at least 53 mm high, but it has 50 mm"),
        (&["--levels", "0"], "1 to 50 levels"),
        (&["--tool", "0,-60,-100"], "must be along the spindle"),
        (&["--tool", "30"], "does not reach the lowest level"),
        (&["--centre", "300,250,380"], "Z would go to"),
    ];
    for (words, sentence) in cases {
        let mut all = vec!["plan", "workpiece", "--machine", "m.toml", "-o", "p.csv", "--program", "p.mpf"];
        all.extend(words);
        shop.run(&all).exits(2).says(sentence);
        assert_eq!(shop.names(), names, "{words:?}");
    }
    // Options of other plans are not silently ignored.
    shop.run(["plan", "workpiece", "--machine", "m.toml", "-o", "p.csv", "--runs", "2"]).exits(2).says("has no --runs");
    shop.run(["plan", "laser", "--machine", "m.toml", "-o", "p.csv", "--levels", "2"]).exits(2).says("has no --levels");
}
