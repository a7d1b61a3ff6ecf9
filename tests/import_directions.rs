//! Directions that files of instruments state, or that the order of their rows tells: circles counterclockwise and clockwise, and repeated end targets.

use std::fmt::Write as _;

use ncfix_base::geometry::Axis;
use ncfix_base::source::{FileId, Source};
use ncfix_machine::machine::State;
use ncfix_metrology::measure::data;
use serde_json::Value;

use crate::import::{Noise, calibrated, import, shop};
use crate::support::Shop;

/// Half the reversal value of X, µm: the coordinate is too large by it after a positive motion.
const HALF: f64 = 2.0;
/// Where the ball-bar stood.
const PLACE: [&str; 4] = ["--at", "X300,Y250,Z100", "--tool", "50"];

/// The length of the bar at an angle of a circle about Z in one direction, µm. Counterclockwise X moves against its positive direction where sin θ > 0; the
/// bar sees cos θ of the error.
fn length(deg: f64, turn: f64) -> f64 {
    let (sin, cos) = deg.to_radians().sin_cos();
    let direction = -turn * if sin.abs() < 1e-9 { 0.0 } else { sin.signum() };
    HALF * direction * cos
}

/// Angles of a circle, between the reversals.
fn angles() -> impl Iterator<Item = f64> {
    (0..72).map(|k| 2.5 + 5.0 * f64::from(k))
}

const HEAD: &str = "plane;XY\nradius_mm;100\nfeed_mm_min;1000\n";

/// Both circles as rows at ascending angles, with a column of directions.
fn sorted_by_angle() -> String {
    let mut text = format!("{HEAD}run;direction;angle_deg;dev_um\n");
    for (run, turn, word) in [(1, 1.0, "ccw"), (2, -1.0, "cw")] {
        for deg in angles() {
            writeln!(text, "{run};{word};{deg};{:.3}", length(deg, turn)).unwrap();
        }
    }
    text
}

/// A table with a column for each circle.
fn wide(headings: &str, turns: &[f64]) -> String {
    let mut text = format!("{HEAD}{headings}\n");
    for deg in angles() {
        write!(text, "{deg}").unwrap();
        turns.iter().for_each(|turn| write!(text, ";{:.3}", length(deg, *turn)).unwrap());
        text.push('\n');
    }
    text
}

/// Writes a file, in place of an earlier one.
fn put(shop: &Shop, name: &str, text: &str) {
    std::fs::write(shop.path(name), text).unwrap();
}

/// The figures of the first group of `out.csv`.
fn figures(shop: &Shop) -> Value {
    let report = shop.run(["iso230", "out.csv", "--machine", "tool.toml", "--json"]).exits(0).json();
    report["measurements"][0]["figures"][0].clone()
}

fn value(group: &Value, name: &str) -> f64 {
    let found = group["values"].as_array().unwrap().iter().find(|one| one["name"] == name);
    found.unwrap_or_else(|| panic!("{name}: {group}"))["value"].as_f64().unwrap()
}

/// `out.csv` has both circles: EXXb is the true one, and the two paths differ by twice it where the bar is along X.
#[track_caller]
fn demand_both(shop: &Shop) {
    let found = calibrated(shop, "tool.toml", "EXXb");
    assert!((found[0].1 - HALF).abs() < 0.01, "{found:?}");
    let group = figures(shop);
    // At 2.5°, between the readings before and after the reversal, the paths differ by less.
    let most = 2.0 * HALF * 2.5_f64.to_radians().cos();
    assert!((value(&group, "H") - most).abs() < 0.01, "{group}");
    for name in ["G(ccw)", "G(cw)"] {
        assert!((value(&group, name) - most).abs() < 0.05, "{name}: {group}");
    }
}

#[test]
fn a_column_of_directions_decides_over_the_order_of_the_rows() {
    let shop = shop().file("bar.csv", sorted_by_angle());
    let run = import(&shop, "bar.csv", "tool.toml", &PLACE).exits(0);
    assert!(run.stderr.contains("run 2-cw: the stated direction is cw, and the angles ascend"), "{}", run.stderr);
    assert!(shop.text("out.toml").contains("written in reverse order"), "{}", shop.text("out.toml"));
    demand_both(&shop);
    // The same with the rows in the order of the motion: nothing is reversed.
    let text = sorted_by_angle();
    let (head, rows): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| !line.starts_with("2;"));
    let ordered: Vec<&str> = head.into_iter().chain(rows.into_iter().rev()).collect();
    let shop = shop.file("ordered.csv", ordered.join("\n") + "\n");
    let run = import(&shop, "ordered.csv", "tool.toml", &PLACE).exits(0);
    assert!(!run.stderr.contains("reverse order"), "{}", run.stderr);
    demand_both(&shop);
    // An option that contradicts the column.
    let more: Vec<&str> = PLACE.into_iter().chain(["--turn", "cw"]).collect();
    import(&shop, "bar.csv", "tool.toml", &more).exits(4).says("E0618").says("--turn cw contradicts the file");
}

#[test]
fn columns_of_circles_are_runs_with_their_directions() {
    for (headings, turns) in [
        ("angle_deg;CCW [um];CW [um]", &[1.0, -1.0][..]),
        ("Angle [deg];Run 1 CCW [um];Run 1 CW [um]", &[1.0, -1.0]),
        ("angle_deg;dev_ccw_um;dev_cw_um", &[1.0, -1.0]),
        ("Winkel [°];G3 [µm];G2 [µm]", &[1.0, -1.0]),
        ("angle_deg;CCW1 [um];CW1 [um];CCW2 [um];CW2 [um]", &[1.0, -1.0, 1.0, -1.0]),
        ("angle_deg;1+ [um];1- [um]", &[1.0, -1.0]),
    ] {
        let shop = shop().file("bar.csv", wide(headings, turns));
        import(&shop, "bar.csv", "tool.toml", &PLACE).exits(0);
        demand_both(&shop);
    }
    // Without words, the directions are asked, and one answer for each column is enough.
    let shop = shop().file("bar.csv", wide("angle_deg;run 1 [um];run 2 [um]", &[1.0, -1.0]));
    import(&shop, "bar.csv", "tool.toml", &PLACE).exits(4).says("E0616").says("give --turn").says("ccw,cw");
    let with = |turn: &'static str| PLACE.into_iter().chain(["--turn", turn]).collect::<Vec<_>>();
    import(&shop, "bar.csv", "tool.toml", &with("ccw,cw")).exits(0);
    demand_both(&shop);
    import(&shop, "bar.csv", "tool.toml", &with("ccw,cw,ccw")).exits(4).says("E0618").says("3 directions");
    // Unknown headings: the format and the meaning of each column by options.
    let shop = shop.file("mute.csv", wide("p [deg];q [um];r2 [um]", &[1.0, -1.0]));
    import(&shop, "mute.csv", "tool.toml", &PLACE).exits(4);
    let named: Vec<&str> = PLACE.into_iter().chain(["--as", "ball-bar", "--columns", "angle,ccw,cw"]).collect();
    import(&shop, "mute.csv", "tool.toml", &named).exits(0);
    demand_both(&shop);
}

/// A table that is sorted by angle leaves the direction open; `--turn` states it, also for one circle.
#[test]
fn ascending_angles_alone_are_no_direction() {
    let mut text = format!("{HEAD}run;angle_deg;dev_um\n");
    angles().for_each(|deg| writeln!(text, "1;{deg};{:.3}", length(deg, -1.0)).unwrap());
    let shop = shop().file("bar.csv", text);
    import(&shop, "bar.csv", "tool.toml", &PLACE).exits(4).says("E0616").says("its angles only ascend");
    for (turn, sign) in [("cw", 1.0), ("ccw", -1.0)] {
        let more: Vec<&str> = PLACE.into_iter().chain(["--turn", turn]).collect();
        import(&shop, "bar.csv", "tool.toml", &more).exits(0);
        let found = calibrated(&shop, "tool.toml", "EXXb");
        assert!((found[0].1 - sign * HALF).abs() < 0.01, "{turn}: {found:?}");
    }
}

/// A pair of files by hand whose run has the name of the other direction.
#[test]
fn rows_against_the_name_of_their_run_are_named() {
    let table = |label: &str, columns: &str, cells: &dyn Fn(f64) -> String| {
        let mut text = format!("run,X,Y,Z{columns},dr_um\n");
        for deg in angles() {
            let (sin, cos) = deg.to_radians().sin_cos();
            writeln!(text, "{label},{:.4},{:.4},100{},0.1", 300.0 + 100.0 * cos, 250.0 + 100.0 * sin, cells(deg))
                .unwrap();
        }
        text
    };
    let toml = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\n[setup.A]\ncentre_mm = [300, 250, 100]\nlength_mm = 100\n";
    let none = |_: f64| String::new();
    let shop = shop()
        .file("good.csv", table("2-ccw", "", &none))
        .file("bad.csv", table("2-cw", "", &none))
        // The direction of X of a clockwise circle beside the rows of a counterclockwise one.
        .file("against.csv", table("2", ",X_dir", &|deg: f64| format!(",{}", if deg < 180.0 { 1 } else { -1 })));
    for name in ["good", "bad", "against"] {
        put(&shop, &format!("{name}.toml"), toml);
        let table = format!("{name}.csv");
        for command in ["iso230", "calibrate", "diagnose"] {
            let mut words = vec![command, &table, "--machine", "tool.toml"];
            if command == "calibrate" {
                words.extend(["--model", "EXXb", "-o", "fitted.toml"]);
            }
            let run = shop.run(words);
            match name {
                "good" => assert!(!run.stderr.contains("W0607"), "{command}: {}", run.stderr),
                "bad" => _ = run.says("W0607").says("against the name of the run"),
                _ => _ = run.says("W0607").says("against the columns with the directions"),
            }
        }
    }
}

/// The file names the plane XZ: angles may count from X to Z, or from Z to X as in ISO 230-4. A bar along X at angle 0 or at 90°.
#[test]
fn the_plane_xz_is_asked() {
    let mut text = "plane;XZ\nradius_mm;100\nfeed_mm_min;1000\nrun;direction;angle_deg;dev_um\n".to_owned();
    // 10 µm longer along one axis: (1 + cos 2θ) · 5 µm is 10 at 0°.
    angles().for_each(|deg| {
        writeln!(text, "1;ccw;{deg};{:.3}", 5.0 + 5.0 * (2.0 * deg).to_radians().cos()).unwrap();
    });
    let shop = shop().file("bar.csv", &text);
    let run = import(&shop, "bar.csv", "tool.toml", &PLACE).exits(4).says("E0616").says("give --plane");
    assert!(run.stderr.contains("ZX if angles count from Z to X, XZ if they count from X to Z"), "{}", run.stderr);
    // 10 µm at 100 mm are 100 µm/m of the axis at angle 0.
    for (plane, expected, word) in [("XZ", [100.0, 0.0], "1-cw"), ("ZX", [0.0, 100.0], "1-ccw")] {
        let more: Vec<&str> = PLACE.into_iter().chain(["--plane", plane]).collect();
        import(&shop, "bar.csv", "tool.toml", &more).exits(0);
        // In the plane ZX of ISO 230-4, from X to Z is clockwise.
        assert!(shop.text("out.csv").contains(&format!("\n{word},")), "{plane}: {}", shop.text("out.csv"));
        let description = shop.text("out.toml").replace("free = [\"centre\", \"length\"]", "free = [\"centre\"]");
        put(&shop, "out.toml", &description);
        let found = calibrated(&shop, "tool.toml", "EXX1,EZZ1");
        let close = |name: &str, value: f64| {
            found.iter().any(|(own, estimate, _)| own == name && (estimate - value).abs() < 0.5)
        };
        assert!(close("EXX1", expected[0]) && close("EZZ1", expected[1]), "{plane}: {found:?}");
    }
    let shop = shop.file("iso.csv", text.replace("plane;XZ", "plane;ZX"));
    let more: Vec<&str> = PLACE.into_iter().chain(["--plane", "XZ"]).collect();
    import(&shop, "iso.csv", "tool.toml", &more).exits(4).says("E0618").says("--plane contradicts the file");
    // Angles in another unit, and a nominal length in inches.
    let radians = text.replace("plane;XZ", "plane;ZX").replace("angle_deg", "angle [mm]");
    import(&shop.file("length.csv", radians), "length.csv", "tool.toml", &PLACE).exits(4).says("no unit of an angle");
}

/// A laser with five cycles 0 … 400, 400 … 0 and no column of directions: error 10 µm/m, half the reversal value 2 µm.
#[test]
fn an_end_target_that_is_read_twice_is_the_turn() {
    let mut noise = Noise(5);
    let mut text = "run,X,component,value_um\n".to_owned();
    let mut with = "run,X,X_dir,component,value_um\n".to_owned();
    for run in 1..=5 {
        let ways = (0..=4).map(|k| (k, 1)).chain((0..=4).rev().map(|k| (k, -1)));
        for (k, direction) in ways {
            let x = 100.0 * f64::from(k);
            let value = 0.010 * x + HALF * f64::from(direction) + noise.next(0.1);
            writeln!(text, "{run},{x},EXX,{value:.3}").unwrap();
            writeln!(with, "{run},{x},{direction},EXX,{value:.3}").unwrap();
        }
    }
    let toml = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\n[position]\nY_mm = 200\nZ_mm = 100\n";
    let shop = shop();
    let mut all = Vec::new();
    for table in [&with, &text] {
        put(&shop, "out.csv", table);
        put(&shop, "out.toml", toml);
        let found = calibrated(&shop, "tool.toml", "EXX1,EXXb");
        assert!((found[1].1 - HALF).abs() < 0.1, "{found:?}");
        all.push((found, figures(&shop)));
    }
    assert_eq!(all[0], all[1]);
    // The mean reversal value of ISO 230-2 is the whole one.
    assert!((value(&all[1].1, "B mean") - 2.0 * HALF).abs() < 0.2, "{}", all[1].1);
    // The end target only once: what the order leaves open is asked, never left out without a word.
    let single: Vec<&str> = {
        let mut last = "";
        let lines = text.lines().filter(|line| {
            let keep = line.starts_with("run") || line.rsplit_once(",EXX").map_or("", |(place, _)| place) != last;
            last = line.rsplit_once(",EXX").map_or("", |(place, _)| place);
            keep
        });
        lines.collect()
    };
    put(&shop, "out.csv", &(single.join("\n") + "\n"));
    let group = figures(&shop);
    let reason = group["reason"].as_str().unwrap_or_else(|| panic!("{group}"));
    assert!(reason.contains("X 0 mm") && reason.contains("X_dir"), "{reason}");
}

/// A mesh of Klipper with 3 columns and 2 rows, 200 mm and 300 mm apart.
const MESH: &str = "[bed_mesh default]\nversion = 1\npoints =\n  0.0, 0.04, 0.10\n  -0.02, 0.02, 0.08\n\
    x_count = 3\ny_count = 2\nmin_x = 30\nmax_x = 430\nmin_y = 30\nmax_y = 330\n";

/// Directions of X and Y of each row of `out.csv`, as a fit takes them.
fn directions(shop: &Shop) -> Vec<[i8; 2]> {
    let source = |id, name: &str| Source::new(FileId(id), name, shop.text(name).into_bytes()).unwrap();
    let (machine, _) = ncfix_model::file::load(&source(0, "tool.toml")).0.unwrap();
    let (data, findings) = data::load("out", &source(1, "out.csv"), &source(2, "out.toml"), &machine);
    let data = data.unwrap_or_else(|| panic!("{findings:?}"));
    let of = |one: &data::Observation| {
        let State { direction, .. } = one.reading.state;
        [direction[Axis::X.slot()], direction[Axis::Y.slot()]]
    };
    data.observations.iter().map(of).collect()
}

/// A mesh and a report are sorted: their rows give no directions, unless the option says that they are in the order of the motion.
#[test]
fn sorted_rows_give_no_directions() {
    let report = "Feature;Nominal X [mm];Nominal Y [mm];Actual X [mm];Actual Y [mm]\n\
        H1;0;0;0.011;0.003\nH2;100;0;100.013;0.004\nH3;100;50;100.012;50.007\n";
    let log = "0 0 0.01\n100 0 0.03\n100 50 -0.02\n0 50 0.05\n";
    let shop = shop().file("mesh.cfg", MESH).file("cmm.csv", report).file("log.txt", log);
    let mesh = ["--flat-reference", "--at", "X0,Y0,Z100", "--tool", "0"];
    let cmm = ["--at", "X100,Y100,Z100", "--sign", "+", "--tool", "0", "--material", "20C"];
    let unknown = "\norder = \"unknown\"";
    import(&shop, "mesh.cfg", "tool.toml", &mesh).exits(0).says("the order of the rows counts as sorted");
    assert!(shop.text("out.toml").contains(unknown), "{}", shop.text("out.toml"));
    assert_eq!(directions(&shop), [[0, 0]; 6]);
    import(&shop, "mesh.cfg", "tool.toml", &[&mesh[..], &["--order", "motion"]].concat()).exits(0);
    // The first row of each line is reached from the right.
    assert_eq!(directions(&shop), [[0, 0], [1, 0], [1, 0], [-1, 1], [1, 1], [1, 1]]);
    import(&shop, "cmm.csv", "tool.toml", &cmm).exits(0);
    assert_eq!(directions(&shop), [[0, 0]; 3]);
    import(&shop, "cmm.csv", "tool.toml", &[&cmm[..], &["--order", "motion"]].concat()).exits(0);
    assert_eq!(directions(&shop), [[0, 0], [1, 0], [1, 1]]);
    // A probe log is written while the machine moves.
    let more = [&mesh[..], &["--unit", "mm"]].concat();
    import(&shop, "log.txt", "tool.toml", &more).exits(0);
    assert!(!shop.text("out.toml").contains("order ="), "{}", shop.text("out.toml"));
    assert_eq!(directions(&shop), [[0, 0], [1, 0], [1, 1], [-1, 1]]);
    import(&shop, "log.txt", "tool.toml", &[&more[..], &["--order", "unknown"]].concat()).exits(0);
    assert_eq!(directions(&shop), [[0, 0]; 4]);
    // Another word is refused with the two.
    put(&shop, "out.toml", &shop.text("out.toml").replace("order = \"unknown\"", "order = \"sorted\""));
    shop.run(["iso230", "out.csv", "--machine", "tool.toml"]).says("unknown order \"sorted\"").says("motion, unknown");
}

/// The heights of a bed are deviations: where the travel of Z ends at the bed, the mean height of the map is no position.
#[test]
fn a_bed_beyond_the_travel_has_its_nominal_plane() {
    let shop = shop().file("mesh.cfg", MESH);
    let at = |place: &'static str| ["--flat-reference", "--at", place, "--tool", "0"];
    // The mean of the six heights is 0.036667 mm, and Z ends at 400.
    import(&shop, "mesh.cfg", "tool.toml", &at("X0,Y0,Z400")).exits(0).says("that of the nominal plane, 400");
    assert!(shop.text("out.csv").lines().any(|line| line == "A,30,30,400,0,0,0,36.666667"), "{}", shop.text("out.csv"));
    import(&shop, "mesh.cfg", "tool.toml", &at("X0,Y0,Z100")).exits(0).says("is the mean height");
    // A place that is outside by itself is refused as before.
    import(&shop, "mesh.cfg", "tool.toml", &at("X0,Y0,Z401")).exits(4).says("E0618").says("outside of the travel");
}
