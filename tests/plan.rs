//! Test plans: counts of the printed tables, points on circles and spheres by own arithmetic, spectra, what a plan tells, and programs that
//! every control's own executor takes to the planned positions.

use std::collections::HashMap;

use crate::support::{Run, Shop, machine};

/// A table by column.
struct Rows {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Rows {
    fn read(text: &str) -> Rows {
        let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines();
        Rows { names: split(lines.next().unwrap()), rows: lines.map(split).collect() }
    }

    fn column(&self, name: &str) -> Vec<&str> {
        let place = self.names.iter().position(|known| known == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|row| row[place].as_str()).collect()
    }

    fn numbers(&self, name: &str) -> Vec<f64> {
        self.column(name).iter().map(|cell| cell.parse().unwrap()).collect()
    }

    fn points(&self) -> Vec<[f64; 3]> {
        let [x, y, z] = ["X", "Y", "Z"].map(|name| self.numbers(name));
        (0..x.len()).map(|k| [x[k], y[k], z[k]]).collect()
    }
}

/// Runs a plan into `plan.csv` and `test.nc`.
fn plan(shop: &Shop, on: &str, arguments: &[&str]) -> Run {
    let mut all = vec!["plan"];
    all.extend(arguments);
    all.extend(["--machine", on, "-o", "plan.csv", "--program", "test.nc"]);
    shop.run(all)
}

fn rows(shop: &Shop, on: &str, arguments: &[&str]) -> Rows {
    let run = plan(shop, on, arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    Rows::read(&shop.text("plan.csv"))
}

fn distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    (0..3).map(|k| (one[k] - other[k]).powi(2)).sum::<f64>().sqrt()
}

/// The machine of the table A under C, all along the axes of F.
const KOLIBRI: &str = r#"
[machine]
name = "kolibri"
topology = "wCAYFXZSt"
controller = "sinumerik"
reference_temperature_C = 20.0
[axis.X]
direction = [1, 0, 0]
travel_mm = [-300, 300]
[axis.Y]
direction = [0, -1, 0]
travel_mm = [-300, 300]
[axis.Z]
direction = [0, 0, 1]
travel_mm = [-100, 400]
[axis.A]
direction = [-1, 0, 0]
travel_deg = [-120, 120]
[axis.C]
direction = [0, 0, -1]
travel_deg = [-360, 360]
[spindle]
origin_mm = [0, 0, 0]
axis = [0, 0, 1]
"#;

#[test]
fn table_4_1_has_109_probings_and_carries_84_parameters() {
    let shop = Shop::new();
    let run =
        plan(&shop, &machine("esmaeili_xyz5"), &["probe", "--variant", "samba", "--tool", "200", "--model", "84"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Six balls at three places each; the tool is known.
    assert!(
        run.stderr.contains("84 parameters and 18 unknowns of the set-up: the plan determines 102 of 102"),
        "{}",
        run.stderr
    );
    // The tool is taken as calibrated, and the scale of Z follows from its length: that is said.
    let said = run.stderr.lines().find(|line| line.contains("only the stated tool tells")).unwrap_or_default();
    assert!(said.contains("EZZ1") && said.contains("[[length]]"), "{}", run.stderr);
    let rows = Rows::read(&shop.text("plan.csv"));
    let mut balls = HashMap::new();
    for ball in rows.column("target") {
        *balls.entry(ball).or_insert(0) += 1;
    }
    // Counted in the printed table.
    let counted = [("b1", 7), ("b2", 7), ("b3", 32), ("b4", 27), ("b5", 23), ("b6", 13)];
    assert_eq!(balls, HashMap::from(counted));
    let [b, c] = ["B", "C"].map(|name| rows.numbers(name));
    let mut indexations: Vec<(i64, i64)> =
        b.iter().zip(&c).map(|(b, c)| (b.round() as i64, c.round() as i64)).collect();
    assert_eq!((indexations[0], indexations[12], indexations[108]), ((10, 30), (90, 270), (0, 0)));
    indexations.dedup();
    // 27 indexations; the last of them and five angles of the spindle share theirs.
    assert_eq!(indexations.len(), 27);
    assert_eq!(rows.column("setup").iter().filter(|label| **label == "S300").count(), 1);
}

#[test]
fn table_5_3_carries_81_parameters_and_no_spindle_offsets() {
    let shop = Shop::new().file("kolibri.toml", KOLIBRI);
    let arguments = ["probe", "--variant", "rumba", "--tool", "74", "--model", "81"];
    let run = plan(&shop, "kolibri.toml", &arguments);
    assert_eq!(run.code, 0, "{}", run.stderr);
    // Four balls and the tool at three coordinates each: 96 columns, as printed.
    assert!(
        run.stderr.contains("81 parameters and 15 unknowns of the set-up: the plan determines 96 of 96"),
        "{}",
        run.stderr
    );
    // The tool is an unknown.
    assert!(!run.stderr.contains("only the stated tool"), "{}", run.stderr);
    let rows = Rows::read(&shop.text("plan.csv"));
    assert_eq!(rows.rows.len(), 4 * 42);
    let [a, c] = ["A", "C"].map(|name| rows.numbers(name));
    let pairs: Vec<(i64, i64)> = a.iter().zip(&c).map(|(a, c)| (a.round() as i64, c.round() as i64)).collect();
    assert_eq!((pairs[0], pairs[14], pairs[41], pairs[42]), ((15, 60), (0, 360), (-5, 345), (15, 60)));
    // The spindle offsets of this preset are the tool of unknown place.
    let run = plan(&shop, "kolibri.toml", &["probe", "--variant", "rumba", "--tool", "74", "--model", "mayer-13"]);
    assert!(
        run.stderr.contains("cannot determine: EX0S and EY0S are not separable from the tool\n    turn the spindle"),
        "{}",
        run.stderr
    );
    // Two spindle offsets, and the scale of everything: no length is known.
    assert!(run.stderr.contains("the plan determines 25 of 28"), "{}", run.stderr);
    let wrong = plan(&shop, &machine("esmaeili_xyz5"), &["probe", "--variant", "rumba"]);
    assert_eq!(wrong.code, 2);
    assert!(wrong.stderr.contains("Table 5-3 is for a table C on A"), "{}", wrong.stderr);
}

#[test]
fn probed_balls_are_where_the_chain_has_them() {
    let shop = Shop::new().file("kolibri.toml", KOLIBRI);
    let ball = [60.0, -20.0, 45.0];
    let arguments = ["probe", "--tool", "74", "--ball", "60,-20,45", "--points", "20"];
    let rows = rows(&shop, "kolibri.toml", &arguments);
    let [a, c] = ["A", "C"].map(|name| rows.numbers(name));
    for ((point, a), c) in rows.points().into_iter().zip(a).zip(c) {
        // A positive command turns the table backwards: first C takes the ball about −Z, then A about −X.
        let (sin, cos) = (-c.to_radians()).sin_cos();
        let [x, y, z] = [cos * ball[0] - sin * ball[1], sin * ball[0] + cos * ball[1], ball[2]];
        let (sin, cos) = (-a.to_radians()).sin_cos();
        let place = [x, cos * y - sin * z, sin * y + cos * z];
        // X and Z carry the tool; Y carries the table backwards.
        assert!(distance(point, [place[0], place[1], place[2] + 74.0]) < 2e-4, "{a} {c}: {point:?} {place:?}");
    }
}

#[test]
fn circles_are_round_and_go_both_ways() {
    let shop = Shop::new();
    let rows =
        rows(&shop, &machine("demo"), &["ballbar", "--tool", "100", "--centre", "300,200,150", "--radius", "120"]);
    // Every 2°: 180 on a full circle, 111 on 220°, in both senses.
    assert_eq!(rows.rows.len(), 2 * 180 + 4 * 111);
    let centre = [300.0, 200.0, 250.0];
    for point in rows.points() {
        assert!((distance(point, centre) - 120.0).abs() < 2e-6, "{point:?}");
    }
    let runs = rows.column("run");
    for (run, [first, second]) in [("XY-ccw", [0, 1]), ("YZ-ccw", [1, 2]), ("ZX-ccw", [2, 0]), ("XY-cw", [0, 1])] {
        let points: Vec<[f64; 3]> =
            rows.points().into_iter().zip(&runs).filter(|(_, own)| **own == run).map(|(point, _)| point).collect();
        let sense = if run.ends_with("ccw") { 1.0 } else { -1.0 };
        for pair in points.windows(2) {
            let [one, other] =
                [pair[0], pair[1]].map(|point| [point[first] - centre[first], point[second] - centre[second]]);
            assert!(sense * (one[0] * other[1] - one[1] * other[0]) > 0.0, "{run}");
        }
    }
    // The tool is above: no ball is more than 20° below the centre.
    assert!(rows.numbers("Z").iter().all(|z| *z > 250.0 - 120.0 * 20.1_f64.to_radians().sin()));
    let description = shop.text("plan.toml");
    assert!(description.contains("centre_mm = [300, 200, 150]\nlength_mm = 120"), "{description}");
}

#[test]
fn the_hemisphere_has_five_meridians_and_short_chords() {
    let shop = Shop::new();
    let demo = machine("demo");
    let rows = rows(&shop, &demo, &["sphere", "--tool", "100", "--centre", "300,200,150"]);
    // 180° in steps of 5°, and 36° in steps of 5.14°.
    assert_eq!(rows.rows.len(), 5 * 37 + 4 * 8);
    let centre = [300.0, 200.0, 250.0];
    assert!(rows.points().iter().all(|point| (distance(*point, centre) - 150.0).abs() < 1e-4));
    let runs = rows.column("run");
    let poles = rows.points().iter().zip(&runs).filter(|(point, _)| (point[2] - 400.0).abs() < 1e-3).count();
    assert_eq!(poles, 5);
    // 1800 chords of 0.1° on a meridian: 150 (1 − cos 0.05°) = 0.057 µm, beside the rounding to 0.1 µm. Up, over and down before, up behind.
    let path = positions(&shop, &demo);
    assert_eq!(path.len(), 3 + 5 * 1800 + 4 * 364 + 1);
    for pair in path[2..path.len() - 1].windows(2) {
        let middle = [0, 1, 2].map(|k| pair[0][k].midpoint(pair[1][k]));
        let inside = 150.0 - distance(middle, centre);
        assert!(inside < 0.000_057_2 + 0.000_1 && inside > -0.000_1, "{inside}");
    }
}

#[test]
fn spaans_spheres_are_those_of_table_3_1() {
    let wide = KOLIBRI.replace("wCAYFXZSt", "wYFXZSt").replace("[axis.A]", "#").replace("[-300, 300]", "[-900, 900]");
    let wide: String =
        wide.split("#").next().unwrap().to_owned() + "[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
    let shop = Shop::new().file("wide.toml", wide.replace("[-100, 400]", "[-900, 900]"));
    let rows = rows(&shop, "wide.toml", &["sphere", "--variant", "spaan", "--chord", "5"]);
    let (setups, tools) = (rows.column("setup"), rows.numbers("tool_z_mm"));
    let mut seen: Vec<(&str, f64)> = Vec::new();
    for (setup, tool) in setups.iter().zip(tools) {
        if seen.last().is_none_or(|(last, _)| last != setup) {
            seen.push((setup, -tool));
        }
    }
    let short = ["4", "14", "27", "29", "89"].map(|label| (label, 110.0));
    let long = ["99", "105", "137"].map(|label| (label, 245.0));
    assert_eq!(seen, [short.as_slice(), long.as_slice()].concat());
    let description = shop.text("plan.toml");
    assert!(description.contains("[setup.29]\ncentre_mm = [400, 190, 300]\nlength_mm = 250"), "{description}");
    assert!(description.contains("[setup.137]\ncentre_mm = [350, 210, 0]\nlength_mm = 300"), "{description}");
}

#[test]
fn an_axis_goes_forth_and_back_over_the_same_targets() {
    let shop = Shop::new();
    let demo = machine("demo");
    let arguments = ["laser", "--axis", "Y", "--component", "EYY", "--component", "EAY", "--runs", "3"];
    let rows_of = |more: &[&str]| rows(&shop, &demo, &[arguments.as_slice(), more].concat());
    let rows = rows_of(&[]);
    assert_eq!(rows.rows.len(), 3 * 2 * 11 * 2);
    let y = rows.numbers("Y");
    let forth: Vec<f64> = y[..22].iter().step_by(2).copied().collect();
    let back: Vec<f64> = y[22..44].iter().step_by(2).copied().rev().collect();
    assert_eq!(forth, back);
    assert_eq!(y[..44], y[44..88]);
    // A margin and room to turn, 2 mm each, at both ends.
    let step = (500.0 - 4.0 * 2.0) / 10.0;
    for (number, target) in forth.iter().enumerate() {
        assert!((target - 4.0 - step * number as f64).abs() <= 0.3 * step + 1e-4);
    }
    let steps: Vec<f64> = forth.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().any(|one| (one - step).abs() > 1.0), "unequal");
    let senses: Vec<(&str, f64)> = rows.column("run").into_iter().zip(rows.numbers("Y_dir")).collect();
    assert!(senses.iter().all(|(run, sense)| *sense == if run.ends_with('+') { 1.0 } else { -1.0 }));
    assert!(rows.names.contains(&"value_um".to_owned()) && rows.names.contains(&"value_urad".to_owned()));
    assert_eq!(rows_of(&["--seed", "1"]).rows, rows.rows);
    assert_ne!(rows_of(&["--seed", "2"]).rows, rows.rows);
    let equal = rows_of(&["--variant", "equal"]).numbers("Y");
    assert!((0..11).all(|k| (equal[2 * k] - 4.0 - step * k as f64).abs() < 1e-4));
}

/// Speeds and how many minutes each lasts.
fn stages(rows: &Rows) -> Vec<(f64, usize)> {
    let mut out: Vec<(f64, usize)> = Vec::new();
    for speed in rows.numbers("spindle_rpm").into_iter().skip(1) {
        match out.last_mut() {
            Some((last, count)) if *last == speed => *count += 1,
            _ => out.push((speed, 1)),
        }
    }
    out
}

#[test]
fn spectra_are_those_that_the_literature_describes() {
    let shop = Shop::new();
    let demo = machine("demo");
    let din = rows(&shop, &demo, &["drift", "--speed", "6000"]);
    let at = |minute: usize| din.numbers("spindle_rpm")[minute];
    assert!(din.numbers("t_s").iter().enumerate().all(|(minute, time)| *time == 60.0 * minute as f64));
    // Levels of a quarter of the highest speed for 15 min, a quarter for 30 min from 135 min on, and the highest right behind it or later.
    assert!((1..=15).all(|minute| at(minute) == 1500.0));
    assert!((136..=165).all(|minute| at(minute) == 1500.0) && at(135) != 1500.0 && at(166) != 1500.0);
    for (speed, minutes) in stages(&din) {
        assert!((speed / 1500.0).fract() == 0.0 && speed <= 6000.0);
        assert_eq!(minutes, if speed == 1500.0 && minutes == 30 { 30 } else { 15 });
    }
    let random = rows(&shop, &demo, &["drift", "--variant", "random", "--seed", "7"]);
    assert_eq!(random.rows.len(), 24 * 60 + 1);
    let found = stages(&random);
    assert!(found.iter().all(|(speed, _)| *speed == 0.0 || (800.0..=6300.0).contains(speed)));
    assert!(found.iter().rev().skip(1).all(|(speed, minutes)| *minutes >= 5 && (*minutes <= 45 || *speed == 0.0)));
    assert!(found.iter().any(|(speed, _)| *speed == 0.0));
    let again = rows(&shop, &demo, &["drift", "--variant", "random", "--seed", "7"]);
    assert_eq!(again.rows, random.rows);
    assert_ne!(rows(&shop, &demo, &["drift", "--variant", "random", "--seed", "8"]).rows, random.rows);
    let refused = plan(&shop, &demo, &["drift", "--model", "spaan-21"]);
    assert_eq!(refused.code, 2);
}

/// A move of the flat stream: where it ends, and for an arc its center and sense.
struct Step {
    code: String,
    end: HashMap<char, f64>,
}

fn stream(shop: &Shop, on: &str, dialect: &str) -> Vec<Step> {
    let run = shop.run(["check", "test.nc", "--machine", on, "--dialect", dialect]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    assert!(!run.stderr.contains("[W02"), "{}", run.stderr);
    let run = shop.run(["snc", "test.nc", "--machine", on, "--dialect", dialect]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let mut out = Vec::new();
    for line in run.stdout.lines() {
        let words: Vec<&str> = line.split(' ').take_while(|word| !word.starts_with(';')).collect();
        if let Some(code @ ("G0" | "G1" | "G2" | "G3")) = words.first().copied() {
            let value = |word: &&str| Some((word.chars().next()?, word.get(1..)?.parse().ok()?));
            out.push(Step { code: code.to_owned(), end: words.iter().skip(1).filter_map(value).collect() });
        }
    }
    out
}

fn xyz(step: &Step) -> [f64; 3] {
    ['X', 'Y', 'Z'].map(|axis| step.end[&axis])
}

fn positions(shop: &Shop, on: &str) -> Vec<[f64; 3]> {
    stream(shop, on, "sinumerik").iter().map(xyz).collect()
}

/// Every planned position, with the rotary axis, comes up in the stream in its order.
fn passes(path: &[Step], rows: &Rows, over_mm: f64, what: &str) {
    let a = rows.names.contains(&"A".to_owned()).then(|| rows.numbers("A"));
    let mut steps = path.iter();
    let mut here: Option<&Step> = None;
    for (number, point) in rows.points().into_iter().enumerate() {
        let point = [point[0], point[1], point[2] + over_mm];
        let is_there = |step: &Step| {
            let turned = a.as_ref().is_none_or(|a| (step.end[&'A'] - a[number]).abs() < 1e-6);
            distance(xyz(step), point) < 1.5e-4 && turned
        };
        if !here.is_some_and(is_there) {
            here = steps.find(|step| is_there(step));
        }
        assert!(here.is_some(), "{what}: row {number} at {point:?} is not on the path");
    }
}

/// Every planned position is on an arc of the stream, between its ends.
fn on_arcs(path: &[Step], rows: &Rows, what: &str) {
    for point in rows.points() {
        let found = path.windows(2).any(|pair| {
            let (start, arc) = (xyz(&pair[0]), &pair[1]);
            if arc.code != "G2" && arc.code != "G3" {
                return false;
            }
            let center = [('I', 0), ('J', 1), ('K', 2)].map(|(letter, k)| start[k] + arc.end[&letter]);
            let [first, second] = match arc.end[&'P'] as i64 {
                17 => [0, 1],
                18 => [2, 0],
                _ => [1, 2],
            };
            let across = 3 - first - second;
            let sense = if arc.code == "G3" { 1.0 } else { -1.0 };
            let angle = |at: [f64; 3]| (at[second] - center[second]).atan2(at[first] - center[first]);
            let from_start =
                |at: [f64; 3]| (sense * (angle(at) - angle(start)) + 1e-4).rem_euclid(std::f64::consts::TAU);
            (point[across] - start[across]).abs() < 1e-3
                && (distance(point, center) - distance(start, center)).abs() < 2e-3
                && from_start(point) <= from_start(xyz(arc)) + 2e-4
        });
        assert!(found, "{what}: {point:?} is on no arc");
    }
}

#[test]
fn programs_of_all_dialects_go_where_the_plan_says() {
    for (dialect, name) in
        [("sinumerik", "demo"), ("grundig", "universal_mill"), ("fanuc", "vmc"), ("rs274", "knee_mill")]
    {
        let shop = Shop::new();
        let on = machine(name);
        let circles = rows(&shop, &on, &["ballbar", "--tool", "60", "--radius", "80", "--every", "5"]);
        let path = stream(&shop, &on, dialect);
        assert_eq!(
            path.iter().filter(|step| step.code == "G3").count(),
            path.iter().filter(|step| step.code == "G2").count()
        );
        on_arcs(&path, &circles, dialect);
        for (arguments, over_mm) in [
            (["sphere", "--tool", "60", "--radius", "100", "--chord", "1"].as_slice(), 0.0),
            (&["laser", "--axis", "Z", "--runs", "2"], 0.0),
            (&["plate", "--plane", "ZX", "--every", "30", "--tool", "20", "--tool", "80"], 0.0),
            (&["drift", "--hours", "1"], 0.0),
            (&["probe", "--points", "12", "--tool", "60", "--radius", "30"], 20.0),
        ] {
            if arguments[0] == "probe" && !["fanuc", "rs274"].contains(&dialect) {
                // These machines have no rotary axis.
                assert!(plan(&shop, &on, arguments).stderr.contains("has no rotary axis"));
                continue;
            }
            let planned = rows(&shop, &on, arguments);
            passes(&stream(&shop, &on, dialect), &planned, over_mm, &format!("{dialect} {arguments:?}"));
        }
    }
}

#[test]
fn a_plan_outside_the_travel_names_the_axis_and_writes_nothing() {
    let shop = Shop::new();
    let demo = machine("demo");
    let run = plan(&shop, &demo, &["ballbar", "--tool", "100", "--radius", "260"]);
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("Y would go to") && run.stderr.contains("its travel of 0 to 500 mm"), "{}", run.stderr);
    assert!(shop.names().is_empty());
    let run = plan(&shop, &demo, &["laser", "--radius", "10"]);
    assert_eq!(run.code, 2);
    assert!(run.stderr.contains("ncfix plan laser has no --radius"), "{}", run.stderr);
    for wrong in
        [&["laser", "--axis", "C"][..], &["laser", "--component", "EYY"], &["sphere", "--variant", "x"], &["cube"]]
    {
        assert_eq!(plan(&shop, &demo, wrong).code, 2, "{wrong:?}");
    }
    assert!(shop.names().is_empty());
}

/// Rank before and behind `--improve`.
fn ranks(text: &str) -> Vec<usize> {
    let tells = text.split(" determines ").skip(1);
    tells.map(|rest| rest.split(' ').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn further_poses_tell_more() {
    let shop = Shop::new().file("kolibri.toml", KOLIBRI);
    let few = ["probe", "--tool", "74", "--ball", "60,0,40", "--points", "2", "--model", "10"];
    let before = rows(&shop, "kolibri.toml", &few).rows.len();
    // 10 parameters, a ball and the tool: 16 unknowns, and three equations a pose.
    assert!(before * 3 < 16);
    let run = plan(&shop, "kolibri.toml", &[few.as_slice(), &["--improve", "6"]].concat());
    assert_eq!(run.code, 0, "{}", run.stderr);
    let ranks = ranks(&run.stderr);
    assert!(ranks.len() == 2 && ranks[0] <= before * 3 && ranks[1] == 16, "{}", run.stderr);
    let after = Rows::read(&shop.text("plan.csv"));
    assert_eq!(after.rows.len(), before + 6);
    assert_eq!(after.column("run").iter().filter(|run| **run == "more").count(), 6);
    let path = stream(&shop, "kolibri.toml", "sinumerik");
    // The tool stays along Z, so the approach is 20 mm above.
    passes(&path, &after, 20.0, "improved");
    let run = plan(&shop, "kolibri.toml", &["laser", "--model", "10", "--improve", "2"]);
    assert!(run.code == 2 && run.stderr.contains("no further poses"), "{}", run.stderr);
}

#[test]
fn increments_begin_at_a_known_place_behind_every_stop() {
    let shop = Shop::new();
    let vmc = machine("vmc");
    rows(&shop, &vmc, &["probe", "--points", "12", "--tool", "60", "--radius", "30", "--line", "G65 P9810"]);
    let program = shop.text("test.nc");
    let (mut is_known, mut is_incremental, mut calls) = (true, false, 0);
    for line in program.lines() {
        if line == "M0" || line.starts_with("G65") {
            assert!(line == "M0" || !is_incremental, "a cycle is called in G90");
            is_known = false;
            calls += usize::from(line != "M0");
        } else if line.starts_with("G90") {
            (is_known, is_incremental) = (is_known || line.contains("G53"), false);
        } else if line == "G91" {
            assert!(is_known, "increments from nowhere");
            is_incremental = true;
        }
    }
    assert_eq!(calls, Rows::read(&shop.text("plan.csv")).rows.len());
}

#[test]
fn every_plan_is_documented() {
    let text = std::fs::read_to_string(crate::support::repository("docs/reference/plan.md")).unwrap();
    let help = Shop::new().run(["plan", "--help"]).stdout;
    for kind in ncfix_metrology::measure::plan::PLANS {
        assert!(text.contains(&format!("| `{}` |", kind.name)), "docs/reference/plan.md lacks {}", kind.name);
        let at = help.find(&format!("\n  {} ", kind.name)).unwrap_or_else(|| panic!("help lacks {}", kind.name));
        for wish in kind.wishes {
            assert!(help[at..].contains(&format!("--{wish}")), "{}: {wish}", kind.name);
        }
    }
}

#[test]
fn no_other_pose_would_have_told_more() {
    use ncfix_metrology::calibrate::{identify, improve};
    let source =
        ncfix_base::source::Source::new(ncfix_base::source::FileId(0), "kolibri.toml", KOLIBRI.as_bytes().to_vec())
            .unwrap();
    let (found, _) = ncfix_model::file::load(&source);
    let machine = found.unwrap().0;
    let parameters = (ncfix_model::preset::find("10").unwrap().parameters)(&machine).unwrap();
    let wishes = ncfix_metrology::measure::plan::Wishes {
        balls_mm: vec![ncfix_base::geometry::Vector::new(60.0, 0.0, 40.0)],
        tools_mm: vec![ncfix_base::geometry::Vector::new(0.0, 0.0, -74.0)],
        points: Some(2),
        ..Default::default()
    };
    let plan = (ncfix_metrology::measure::plan::find("probe").unwrap().build)(&machine, &wishes).unwrap();
    let rank_with = |candidate: usize| {
        let mut data = plan.data.clone();
        data.observations.push(plan.candidates[candidate]);
        identify(&machine, &ncfix_model::ErrorModel::default(), &parameters, &[data]).unwrap().rank
    };
    let before = identify(&machine, &ncfix_model::ErrorModel::default(), &parameters, std::slice::from_ref(&plan.data))
        .unwrap()
        .rank;
    let best = (0..plan.candidates.len()).map(rank_with).max().unwrap();
    let chosen = improve(
        &machine,
        &ncfix_model::ErrorModel::default(),
        &parameters,
        std::slice::from_ref(&plan.data),
        &plan.candidates,
        1,
    );
    assert_eq!(chosen.len(), 1);
    assert_eq!(rank_with(chosen[0]), best);
    assert!(best > before);
}

#[test]
fn center_has_two_spellings() {
    let shop = Shop::new();
    let demo = machine("demo");
    let [center, centre] = ["--center", "--centre"].map(|option| {
        plan(&shop, &demo, &["sphere", "--tool", "100", option, "300,200,150"]).exits(0);
        shop.text("plan.csv")
    });
    assert_eq!(center, centre);
    assert!(center.lines().count() > 10, "{center}");
}

#[test]
fn the_automatic_model_needs_readings() {
    let shop = Shop::new();
    let run = plan(&shop, &machine("demo"), &["ballbar", "--tool", "100", "--model", "auto"]);
    assert_eq!(run.code, 2, "{}", run.stderr);
    run.says("--model auto needs readings");
}
