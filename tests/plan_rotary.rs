//! Plans that turn a table while the tip follows a point of it: R-test, and ball-bar with rotary axes (ISO 10791-6), by own arithmetic.

use crate::support::Shop;

/// A table C about X300 Y200 that turns by the right-hand rule, under axes that carry the tool.
const TABLE: &str = "[machine]\nname = \"table\"\ntopology = \"wCFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-100, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\nmodulo = true\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

/// Columns of a plan, by name.
fn column(csv: &str, name: &str) -> Vec<f64> {
    let mut lines = csv.lines();
    let place = lines.next().unwrap().split(',').position(|one| one == name).unwrap_or_else(|| panic!("{name}"));
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

/// The plan with readings in its last columns, from the set-up and the angle in rad.
fn read(csv: &str, reading: impl Fn(&str, f64) -> Vec<f64>) -> String {
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| head.iter().position(|one| *one == name).unwrap();
    let mut out = head.join(",") + "\n";
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let angle = cells[place("C")].parse::<f64>().unwrap().to_radians();
        let values = reading(&cells[place("setup")], angle);
        let first = cells.len() - values.len();
        for (cell, value) in cells[first..].iter_mut().zip(values) {
            *cell = format!("{value:.4}");
        }
        out += &(cells.join(",") + "\n");
    }
    out
}

#[track_caller]
fn fits(shop: &Shop, table: &str, expected: [f64; 2]) {
    let words = ["calibrate", table, "--machine", "m.toml", "--model", "EX0C,EY0C", "-o", "fitted.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    for (row, expected) in json["parameters"].as_array().unwrap().iter().zip(expected) {
        assert!((row["value"].as_f64().unwrap() - expected).abs() < 0.05, "{row}");
    }
}

/// The axis of C is displaced by e = (20, −15) µm. A point p of the table is then at o + e + R(p − o − e), while the tool is at o + R(p − o): the tool is
/// displaced by R e − e from the table.
#[test]
fn an_r_test_gives_the_place_of_a_rotary_axis() {
    let shop = Shop::new().file("m.toml", TABLE);
    let plan = ["plan", "rtest", "--machine", "m.toml", "--ball", "420,200,60", "--tool", "100", "-o", "r.csv"];
    let run = shop.run(plan.iter().copied().chain(["--program", "R.MPF", "--model", "places.txt"]));
    assert_eq!(run.code, 2, "{}", run.stderr);
    let shop = shop.file("places.txt", "EX0C\nEY0C\n");
    let run = shop.run(plan.iter().copied().chain(["--program", "R.MPF", "--model", "places.txt"])).exits(0);
    run.says("2 parameters and 3 unknowns of the set-up: the plan determines 5 of 5");
    let csv = shop.text("r.csv");
    // 0 to 350 degrees in steps of 10, forward and back.
    let [x, y, z, c] = ["X", "Y", "Z", "C"].map(|name| column(&csv, name));
    assert_eq!(c.len(), 72);
    assert_eq!((c[0], c[35], c[36], c[71]), (0.0, 350.0, 350.0, 0.0));
    for k in 0..c.len() {
        let (sin, cos) = c[k].to_radians().sin_cos();
        // The ball is 120 mm from the axis, the gauge point 100 mm above it.
        let place = [300.0 + 120.0 * cos, 200.0 + 120.0 * sin, 60.0 + 100.0];
        let off = [x[k] - place[0], y[k] - place[1], z[k] - place[2]];
        assert!(off.iter().all(|off| off.abs() < 1.1e-3), "C{}: {off:?}", c[k]);
    }
    // Between two blocks the tip stays at the ball within a few micrometers: the nest is small.
    let moves: Vec<[f64; 3]> = shop.text("R.MPF").lines().filter_map(position).collect();
    let mut most = 0.0_f64;
    for pair in
        moves.windows(2).filter(|pair| (pair[1][2] - pair[0][2]).abs() > 0.0 && (pair[1][2] - pair[0][2]).abs() < 5.0)
    {
        let middle = [0, 1, 2].map(|k| f64::midpoint(pair[0][k], pair[1][k]));
        let (sin, cos) = middle[2].to_radians().sin_cos();
        most = most.max((middle[0] - 300.0 - 120.0 * cos).hypot(middle[1] - 200.0 - 120.0 * sin));
    }
    assert!(most > 0.0 && most < 0.005, "{most}");
    let (ex, ey) = (20.0, -15.0);
    let readings = read(&csv, |_, angle| {
        let (sin, cos) = angle.sin_cos();
        vec![cos * ex - sin * ey - ex, sin * ex + cos * ey - ey, 0.0]
    });
    let shop = shop.file("r.csv", readings);
    fits(&shop, "r.csv", [ex, ey]);
}

/// X, Y and C of a block.
fn position(line: &str) -> Option<[f64; 3]> {
    let word = |letter: &str| {
        line.split_whitespace()
            .find_map(|word| word.strip_prefix(letter))
            .and_then(|text| text.trim_start_matches('=').parse().ok())
    };
    Some([word("X")?, word("Y")?, word("C")?])
}

/// Seen from the table, the tool is displaced by e − Rᵀe. The bar reads that along its direction, which turns with the table: radial
/// ex (1 − cos c) − ey sin c, tangential ex sin c + ey (1 − cos c), axial nothing.
#[test]
fn a_ball_bar_on_a_turning_table_gives_the_place_of_its_axis() {
    let shop = Shop::new().file("m.toml", TABLE);
    let plan = [
        "plan",
        "ballbar",
        "--variant",
        "rotary",
        "--axis",
        "C",
        "--machine",
        "m.toml",
        "--ball",
        "350,200,50",
        "--radius",
        "100",
        "--tool",
        "80",
        "-o",
        "b.csv",
        "--program",
        "B.MPF",
    ];
    shop.run(plan).exits(0);
    let csv = shop.text("b.csv");
    assert_eq!(csv.lines().count(), 1 + 3 * 72);
    for name in ["C-radial", "C-tangential", "C-axial"] {
        assert!(shop.text("b.toml").contains(&format!("[setup.{name}]\ncentre_mm = [350, 200, 50]\nlength_mm = 100")));
    }
    // The first row of each: 100 mm farther out, 100 mm along +Y, 100 mm higher.
    let [x, y, z] = ["X", "Y", "Z"].map(|name| column(&csv, name));
    for (row, place) in [(0, [450.0, 200.0, 130.0]), (72, [350.0, 300.0, 130.0]), (144, [350.0, 200.0, 230.0])] {
        let off = [x[row] - place[0], y[row] - place[1], z[row] - place[2]];
        assert!(off.iter().all(|off| off.abs() < 1.1e-3), "{row}: {off:?}");
    }
    let (ex, ey) = (20.0, -15.0);
    let readings = read(&csv, |setup, angle| {
        let (sin, cos) = angle.sin_cos();
        vec![match setup {
            "C-radial" => ex * (1.0 - cos) - ey * sin,
            "C-tangential" => ex * sin + ey * (1.0 - cos),
            _ => 0.0,
        }]
    });
    let shop = shop.file("b.csv", readings);
    fits(&shop, "b.csv", [ex, ey]);
    // What is not for a turning table, or only for one, is refused.
    let on = ["plan", "ballbar", "--machine", "m.toml", "-o", "x.csv"];
    let with = |more: &[&'static str]| shop.run(on.iter().copied().chain(more.iter().copied())).exits(2);
    with(&["--variant", "radial", "--plane", "XY"]).says("is for circles");
    with(&["--axis", "C"]).says("is for a turning table");
    with(&["--variant", "oval"]).says("radial, tangential, axial");
    with(&["--variant", "radial", "--axis", "X"]).says("no rotary axis");
    with(&["--variant", "radial", "--axis", "C", "--range", "10,400"]).says("turns without end");
}
