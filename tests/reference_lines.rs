//! Squareness as the angle between the reference lines of two motions (ISO 230-1): readings of it beside a straightness whose mean slope is not zero at the zero
//! of the axis, and figures of a straightness.

use std::fmt::Write as _;

use nalgebra::{DMatrix, DVector};
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::State;
use ncfix_model::Model;

use crate::import::Noise;
use crate::machine_file::load;
use crate::support::Shop;

const MILL: &str = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 800]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 600]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 500]\n";

/// The true machine: scales of 30, −22 and 15 µm/m, a bow of X in Y of 9 µm over the travel, and an angle of 90° + 45 µrad between the mean lines of X and Y.
/// The least-squares line of the bow is parallel to X. Error of the tool, µm.
fn error_um([x, y, z]: [f64; 3]) -> [f64; 3] {
    let share = x / 800.0;
    [0.030 * x - 0.045 * y, -0.022 * y + 36.0 * share * (1.0 - share), 0.015 * z]
}

/// Lasers along all axes, and the straightness of X against a straightedge with a slope of 60 µrad.
fn lines(noise: &mut Noise) -> String {
    let mut rows = "run,setup,component,X,Y,Z,value_um\n".to_owned();
    let mut line = |run: u32, setup: &str, component: &str, at: [f64; 3], value: f64| {
        let _ =
            writeln!(rows, "{run},{setup},{component},{},{},{},{:.3}", at[0], at[1], at[2], value + noise.next(0.2));
    };
    for k in 0..=16 {
        let k = f64::from(k);
        for run in 1..=3 {
            let [x, y, z] = [[50.0 * k, 300.0, 200.0], [400.0, 37.5 * k, 200.0], [400.0, 300.0, 31.25 * k]];
            line(run, "1", "EXX", x, error_um(x)[0]);
            line(run, "2", "EYY", y, error_um(y)[1]);
            line(run, "3", "EZZ", z, error_um(z)[2]);
            line(run, "4", "EYX", x, error_um(x)[1] + 0.06 * x[0] + 5.0);
        }
    }
    rows
}

/// A circle of 150 mm in XY about (400, 300).
fn circle(noise: &mut Noise) -> String {
    let mut rows = "run,setup,X,Y,Z,dr_um\n".to_owned();
    for k in 0..120 {
        let angle = f64::from(3 * k).to_radians();
        let [x, y] = [400.0 + 150.0 * angle.cos(), 300.0 + 150.0 * angle.sin()];
        let error = error_um([x, y, 200.0]);
        let dr = error[0] * angle.cos() + error[1] * angle.sin() + noise.next(0.2);
        let _ = writeln!(rows, "ccw,A,{x:.6},{y:.6},200,{dr:.3}");
    }
    rows
}

const DIRECT: &str = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\", \"slope\"]\n";
const BAR: &str = "[measurement]\nkind = \"ballbar\"\nsigma_um = 0.2\nfree = [\"centre\", \"length\"]\n[setup.A]\n\
    centre_mm = [400, 300, 200]\nlength_mm = 150\n";
const SQUARE: &str =
    "[measurement]\nkind = \"direct\"\nsigma_urad = 2\n[position]\nX_mm = 400\nY_mm = 300\nZ_mm = 200\n";

/// A true machine file: the bow is 36·(x/800)·(1 − x/800) µm, so its coefficients are 36e-3/800 = 4.5e-5 and −36e-3/640000 = −5.625e-8 per mm.
fn true_file() -> String {
    format!(
        "{MILL}[location]\nEC0Y = 45\n[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 4.5e-5, -5.625e-8]\n"
    )
}

/// Largest error of a calibrated machine, µm, in each direction, after the part is moved as a whole onto that of the true machine.
fn largest_um(text: &str) -> f64 {
    let (machine, errors) = load(text).0.unwrap();
    let model = Model::new(&machine, &errors);
    let tip = |at: [f64; 3]| {
        let mut command = AxisVector::ZERO;
        command.set_xyz(Vector::from(at));
        let [actual, nominal] = [
            model.actual(&command, &Vector::zeros(), &State::default()).translation,
            model.nominal(&command, &Vector::zeros()).translation,
        ];
        (actual - nominal) * 1e3
    };
    let mut rows: Vec<[f64; 6]> = Vec::new();
    let mut left = Vec::new();
    for x in [0.0, 200.0, 400.0, 600.0, 800.0] {
        for y in [0.0, 150.0, 300.0, 450.0, 600.0] {
            for z in [50.0, 450.0] {
                let (found, truth) = (tip([x, y, z]), error_um([x, y, z]));
                rows.extend([[1.0, 0.0, 0.0, 0.0, z, -y], [0.0, 1.0, 0.0, -z, 0.0, x], [0.0, 0.0, 1.0, y, -x, 0.0]]);
                left.extend((0..3).map(|k| found[k] - truth[k]));
            }
        }
    }
    let whole = DMatrix::from_fn(rows.len(), 6, |row, column| rows[row][column]);
    let left = DVector::from_vec(left);
    let moved = whole.clone().svd(true, true).solve(&left, 1e-12).unwrap();
    (left - whole * moved).amax()
}

#[test]
fn a_correct_square_does_not_spoil_the_fit() {
    let mut noise = Noise(11);
    let shop = Shop::new()
        .file("start.toml", MILL)
        .file("lines.csv", lines(&mut noise))
        .file("lines.toml", DIRECT)
        .file("circle.csv", circle(&mut noise))
        .file("circle.toml", BAR)
        .file("square.csv", "component,value_urad\nEC0Y,45\n")
        .file("square.toml", SQUARE);
    for files in ["lines.csv circle.csv", "lines.csv circle.csv square.csv"] {
        let words = format!("calibrate {files} --machine start.toml -o out.toml");
        let run = shop.run(words.split_whitespace()).exits(0);
        assert!(!run.stderr.contains("W0604"), "{files}: {}", run.stderr);
        let found = largest_um(&shop.text("out.toml"));
        assert!(found < 0.6, "{files}: {found} µm");
    }
    // Without a circle the square alone gives the angle of the mean lines.
    let words = "calibrate lines.csv square.csv --machine start.toml -o out.toml";
    shop.run(words.split_whitespace()).exits(0);
    let found = largest_um(&shop.text("out.toml"));
    assert!(found < 0.6, "without a circle: {found} µm");
}

#[test]
fn a_square_shows_the_angle_between_mean_lines() {
    let simulated = |machine: &str, table: &str, range: &str| {
        let shop = Shop::new()
            .file("true.toml", machine)
            .file("plan.csv", table)
            .file("plan.toml", format!("{SQUARE}{range}"));
        shop.run("simulate plan.csv -o out.csv --machine true.toml".split_whitespace()).exits(0);
        let text = shop.text("out.csv");
        let value = text.lines().nth(1).and_then(|line| line.split(',').nth(1)).unwrap().parse::<f64>();
        value.unwrap_or_else(|_| panic!("{text}"))
    };
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 0.02, "{found} is not {expected}");
    let table = "component,value_urad\nEC0Y,\n";
    // The mean line of the whole bow is parallel to X. Over half of the travel its slope is that of the chord of a parabola, the derivative in the middle:
    // 36/800 · (1 − 2 · 200/800) = 0.0225 µm/mm. X then leans towards Y+, and the angle closes.
    near(simulated(&true_file(), table, ""), 45.0);
    near(simulated(&true_file(), table, "[range]\nX_mm = [0, 400]\n"), 45.0 - 22.5);
    // With the table on Y, a straightness of Y of 20 µm/m moves the table towards X+, so the tool goes to X− in the part as Y rises: the angle opens by 20 µrad.
    // EC0Y is then the other name of EC0X, and has the opposite sign.
    let table_side = MILL.replace("wFXYZSt", "wYFXZSt").replace("direction = [0, 1, 0]", "direction = [0, -1, 0]")
        + "[[motion]]\ncomponent = \"EXY\"\nkind = \"polynomial\"\ncoefficients = [0.0, 2e-5]\n";
    near(simulated(&table_side, "component,value_urad\nEC0X,\n", ""), -20.0);
    near(simulated(&table_side, table, ""), 20.0);
}

/// The location `EY0A` that a plan of this machine reads, µm.
fn read_place(lever: &str, travel: &str, functions: &str) -> f64 {
    let machine = format!(
        "[machine]\nname = \"swivel\"\ntopology = \"wAFXYZSt\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\ndirection = [0, 1, 0]\n\
         [axis.Z]\ndirection = [0, 0, 1]\n[axis.A]\ndirection = [1, 0, 0]\nlever = \"{lever}\"\n{travel}\n[location]\nEY0A = 4\n{functions}"
    );
    let shop = Shop::new().file("true.toml", machine).file("plan.csv", "component,value_um\nEY0A,\n").file(
        "plan.toml",
        "[measurement]\nkind = \"direct\"\nsigma_um = 1\n[position]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\nA_deg = 0\n",
    );
    shop.run("simulate plan.csv -o out.csv --machine true.toml".split_whitespace()).exits(0);
    let text = shop.text("out.csv");
    let value = text.lines().nth(1).and_then(|line| line.split(',').nth(1)).unwrap().parse::<f64>();
    value.unwrap_or_else(|_| panic!("{text}"))
}

/// EYA of 10 µm everywhere: on a fixed lever it is an offset of 10 µm. On a carried one it turns with A: 10 µm · cos a, whose mean over ±90° is 10 · 2/π.
#[test]
fn a_place_of_a_rotary_axis_is_that_of_its_average_line() {
    let motion = "[[motion]]\ncomponent = \"EYA\"\nkind = \"polynomial\"\ncoefficients = [0.01]\n";
    let swivel = "travel_deg = [-90, 90]";
    let whole = "modulo = true";
    let expected = [
        ("fixed", swivel, 14.0),
        ("carried", swivel, 4.0 + 10.0 * std::f64::consts::FRAC_2_PI),
        // Over a whole turn the mean is zero.
        ("carried", whole, 4.0),
        ("fixed", whole, 14.0),
    ];
    for (lever, travel, um) in expected {
        let found = read_place(lever, travel, motion);
        assert!((found - um).abs() < 0.01, "{lever} {travel}: {found} is not {um}");
        assert!((read_place(lever, travel, "") - 4.0).abs() < 1e-9, "{lever} {travel}");
    }
}

/// A straightness whose value at zero has a slope turns the mean line, so it acts on the square: 45 µrad remain for the location.
#[test]
fn a_diagnosis_refers_a_square_to_the_mean_lines() {
    let mut noise = Noise(14);
    // The bow alone, read against a reference of known direction: its slope at zero is 45 µrad, that of its mean line 0.
    let mut rows = "run,setup,component,X,Y,Z,value_um\n".to_owned();
    for run in 1..=3 {
        for k in 0..=16 {
            let x = 50.0 * f64::from(k);
            let _ = writeln!(rows, "{run},4,EYX,{x},300,200,{:.3}", error_um([x, 0.0, 0.0])[1] + noise.next(0.2));
        }
    }
    let mut square = "component,value_urad\n".to_owned();
    for _ in 0..8 {
        let _ = writeln!(square, "EC0Y,{:.2}", 45.0 + noise.next(2.0));
    }
    let direct = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\"]\nreference = \"square\"\n";
    let shop = Shop::new()
        .file("start.toml", MILL)
        .file("lines.csv", rows)
        .file("lines.toml", direct)
        .file("square.csv", square)
        .file("square.toml", SQUARE);
    let words = "diagnose lines.csv square.csv --machine start.toml --json";
    let report = shop.run(words.split_whitespace()).exits(0).json();
    let findings = report["findings"].as_array().unwrap();
    let angle = findings.iter().find(|one| one["parameter"] == "EC0Y").unwrap_or_else(|| panic!("{report:#}"));
    let [value, u95] = ["value", "u95"].map(|key| angle[key].as_f64().unwrap());
    assert!((value - 45.0).abs() < 3.0 && u95 < 6.0, "{angle}");
}

#[test]
fn the_command_square_counts_the_slope_that_the_file_already_has() {
    // 300 mm with 0.0135 mm: −45 µrad. The straightness of the file turns X by 10 µrad towards Y+, and so closes the angle by 10 µrad of the 45.
    let file = format!("{MILL}[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0.0, 1e-5]\n");
    let shop = Shop::new().file("m.toml", file);
    let words = "square --machine m.toml --square 300 --dial 0.0135 -o out.toml";
    let run = shop.run(words.split_whitespace()).exits(0);
    assert!(run.stdout.contains("explain -10.0 µrad"), "{}", run.stdout);
    assert!(shop.text("out.toml").contains("EC0Y = -35"), "{}", shop.text("out.toml"));
}

#[test]
fn a_straightness_has_figures_about_its_lines() {
    // The bow of 9 µm over 800 mm with a slope of 60 µrad: 0, 9, 0 µm about either line; both directions differ by 1 µm.
    let mut rows = "run,component,X,Y,Z,X_dir,value_um\n".to_owned();
    for run in 1..=2 {
        for (sense, shift) in [(1, 0.5), (-1, -0.5)] {
            for x in [0.0, 400.0, 800.0] {
                let _ = writeln!(
                    rows,
                    "{run},EYX,{x},300,200,{sense},{:.4}",
                    error_um([x, 0.0, 0.0])[1] + 0.06 * x + shift
                );
            }
        }
    }
    let shop = Shop::new().file("m.toml", MILL).file("a.csv", rows).file("a.toml", DIRECT);
    let report = shop.run(["iso230", "a.csv", "--machine", "m.toml", "--json"]).exits(0).json();
    let group = &report["measurements"][0]["figures"][0];
    assert_eq!(group["standard"], "ISO 230-1", "{group}");
    for (name, expected) in [("straightness", 9.0), ("end points", 9.0), ("B mean", 1.0)] {
        let found = group["values"].as_array().unwrap().iter().find(|one| one["name"] == name).unwrap();
        assert!((found["value"].as_f64().unwrap() - expected).abs() < 1e-6, "{name}: {group}");
    }
}

#[test]
fn the_alignment_does_not_contain_the_slope_of_the_axis() {
    let mut noise = Noise(12);
    let shop = Shop::new().file("m.toml", MILL).file("lines.csv", lines(&mut noise)).file("lines.toml", DIRECT);
    let words = "calibrate lines.csv --machine m.toml --model EXX1,EYY1,EZZ1,EYX2 -o out.toml --json";
    let report = shop.run(words.split_whitespace()).exits(0).json();
    let unknowns = report["unknowns"].as_array().unwrap();
    let alignment = unknowns.iter().find(|one| one["name"] == "alignment of EYX of set-up 4").unwrap();
    let found = alignment["value"].as_f64().unwrap();
    assert!((found - 60.0).abs() < 1.0, "the straightedge has 60 µrad: {alignment}");
    // The slope that makes the bow straight on average has the uncertainty of the bow.
    let text = shop.text("out.toml");
    let uncertainty = text.split("[uncertainty]").nth(1).unwrap();
    assert!(uncertainty.contains("EYX1 = ["), "{text}");
}

#[test]
fn a_laser_with_the_wrong_sign_is_refused_by_name() {
    let mut noise = Noise(13);
    let mut shop = Shop::new()
        .file("m.toml", MILL)
        .file("bar.csv", circle(&mut noise))
        .file("bar.toml", BAR.replace(", \"length\"", ""));
    for (name, axis, sign) in [("laser_x", 0, 1.0), ("laser_y", 1, -1.0)] {
        let mut rows = "component,X,Y,Z,value_um\n".to_owned();
        for k in 0..=20 {
            let mut at = [400.0, 300.0, 200.0];
            at[axis] = 30.0 * f64::from(k);
            let value = sign * error_um(at)[axis] + noise.next(0.2);
            let _ = writeln!(rows, "{},{},{},{},{value:.3}", ["EXX", "EYY"][axis], at[0], at[1], at[2]);
        }
        let description = "[measurement]\nkind = \"direct\"\nsigma_um = 0.2\nfree = [\"offset\"]\n";
        shop = shop.file(&format!("{name}.csv"), rows).file(&format!("{name}.toml"), description);
    }
    let words = "calibrate bar.csv laser_x.csv laser_y.csv --machine m.toml --model EXX1,EYY1,EC0Y,EYX2 -o out.toml";
    let run = shop.run(words.split_whitespace()).exits(4).says("E0607").says("opposite sign");
    assert!(
        run.stderr.contains("contradicts laser_y") && !run.stderr.contains("contradicts laser_x"),
        "{}",
        run.stderr
    );
}

#[test]
fn an_appended_uncertainty_is_named_when_it_is_replaced() {
    let mut noise = Noise(14);
    let shop = Shop::new().file("m.toml", MILL).file("lines.csv", lines(&mut noise)).file("lines.toml", DIRECT);
    let calibrate = |from: &str, to: &str| {
        let words = format!("calibrate lines.csv --machine {from} --model EXX1,EYY1,EZZ1 -o {to}");
        shop.run(words.split_whitespace()).exits(0)
    };
    assert!(!calibrate("m.toml", "first.toml").stderr.contains("W0621"));
    assert!(!calibrate("first.toml", "second.toml").stderr.contains("W0621"));
    // Three lists with at most three entries: the fourth one is the certificate of the laser, 0.5 µm/m.
    let text = shop.text("first.toml");
    let own = text.lines().find(|line| line.starts_with("EXX1 = [")).unwrap();
    let entries = own.matches(',').count() + 1;
    let appended = format!("{}{}, 5e-7]", own.trim_end_matches(']'), ", 0".repeat(3 - entries));
    let shop = shop.file("own.toml", text.replace(own, &appended));
    let words = "calibrate lines.csv --machine own.toml --model EXX1,EYY1,EZZ1 -o third.toml";
    shop.run(words.split_whitespace()).exits(0).says("warning[W0621]").says("EXX1");
}
