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
    with(&["--variant", "radial", "--axis", "C", "--range", "10,400"]).says("is a modulo axis");
}

/// A mill whose table carries A about X through Y200 Z0, and C on it about X300 Y200.
const TWO: &str = "[machine]\nname = \"two\"\ntopology = \"wCAFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\nmax_feed_mm_min = 12000\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [-200, 600]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-300, 500]\n[axis.A]\ndirection = [1, 0, 0]\npoint_mm = [300, 200, 0]\ntravel_deg = [-100, 100]\n\
    [axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\ntravel_deg = [-180, 180]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

/// The ball of (420, 200, 60): C turns it about X300 Y200, then A about Y200 Z0. Angles in degrees.
fn ball_at(a: f64, c: f64) -> [f64; 3] {
    let [(sa, ca), (sc, cc)] = [a, c].map(|angle| angle.to_radians().sin_cos());
    let (x, y, z) = (120.0 * cc, 120.0 * sc, 60.0);
    [300.0 + x, 200.0 + ca * y - sa * z, sa * y + ca * z]
}

/// Positions of the blocks of a program: X, Y, Z, A, C; words that do not change are left out of a block. The seconds of feed moves and dwells, and the stops.
fn blocks(program: &str) -> (Vec<[f64; 5]>, f64, usize) {
    let word = |line: &str, letter: &str| -> Option<f64> {
        let word = line.split_whitespace().find_map(|word| word.strip_prefix(letter))?;
        word.trim_start_matches('=').parse().ok()
    };
    let (mut here, mut feed, mut seconds) = ([f64::NAN; 5], f64::NAN, 0.0);
    let mut all = Vec::new();
    for line in program.lines() {
        if line.starts_with("G4 ") {
            seconds += word(line, "F").unwrap();
        }
        if !line.starts_with("SUPA") {
            continue;
        }
        let before = here;
        for (value, letter) in here.iter_mut().zip(["X", "Y", "Z", "A", "C"]) {
            *value = word(line, letter).unwrap_or(*value);
        }
        feed = word(line, "F").unwrap_or(feed);
        if line.contains(" G1 ") {
            let length = (0..3).map(|k| (here[k] - before[k]).powi(2)).sum::<f64>().sqrt();
            seconds += length / feed * 60.0;
        }
        all.push(here);
    }
    (all, seconds, program.lines().filter(|line| *line == "M0").count())
}

/// The tip is 100 mm below the gauge point: the largest difference of the ball from the tip along X, Y or Z, over the blocks that turn, in mm.
fn farthest(blocks: &[[f64; 5]]) -> f64 {
    let mut most = 0.0_f64;
    for pair in blocks.windows(2).filter(|pair| pair[0][3] != pair[1][3]) {
        for part in 0..=20 {
            let at = [0, 1, 2, 3, 4].map(|k| pair[0][k] + (pair[1][k] - pair[0][k]) * f64::from(part) / 20.0);
            let ball = ball_at(at[3], at[4]);
            most = (0..3).map(|k| (ball[k] - at[k] + [0.0, 0.0, 100.0][k]).abs()).fold(most, f64::max);
        }
    }
    most
}

/// Both axes turn together (Lei and Hsu 2003). C is displaced by e = (20, −15) µm in the table of A, which is exact: seen along X, Y, Z, the point of the
/// table is at Ra (e + Rc (p − e)), so the tool is displaced from it by −Ra (e − Rc e).
#[test]
fn a_path_on_which_both_axes_turn_gives_the_place_of_one() {
    let shop = Shop::new().file("m.toml", TWO);
    let plan =
        ["plan", "rtest", "--variant", "together", "--machine", "m.toml", "--ball", "420,200,60", "--tool", "100"];
    shop.run(plan.into_iter().chain(["-o", "r.csv", "--program", "R.MPF"])).exits(0);
    let csv = shop.text("r.csv");
    let [x, y, z, a, c] = ["X", "Y", "Z", "A", "C"].map(|name| column(&csv, name));
    // A by ±60° and C from 0 to 180° less 0.02°, in 18 steps forward and back.
    assert_eq!(a.len(), 38);
    for k in 0..a.len() {
        assert!((c[k] - 90.0 - 1.5 * a[k]).abs() < 0.1, "{} {}", a[k], c[k]);
        let ball = ball_at(a[k], c[k]);
        let off = [x[k] - ball[0], y[k] - ball[1], z[k] - 100.0 - ball[2]];
        assert!(off.iter().all(|off| off.abs() < 1.1e-3), "A{} C{}: {off:?}", a[k], c[k]);
    }
    let most = farthest(&blocks(&shop.text("R.MPF")).0);
    assert!(most > 0.0 && most < 0.03, "{most}");
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut filled = head.join(",") + "\n";
    for (line, (a, c)) in lines.zip(a.iter().zip(&c)) {
        let [(sa, ca), (sc, cc)] = [*a, *c].map(|angle| angle.to_radians().sin_cos());
        let (ex, ey) = (20.0, -15.0);
        let d = [cc * ex - sc * ey - ex, sc * ex + cc * ey - ey];
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let first = cells.len() - 3;
        for (cell, value) in cells[first..].iter_mut().zip([d[0], ca * d[1], sa * d[1]]) {
            *cell = format!("{value:.4}");
        }
        filled += &(cells.join(",") + "\n");
    }
    fits(&shop.file("r.csv", filled), "r.csv", [20.0, -15.0]);
}

/// The path of Andolfatto et al. (2011, 4.3): a right angle in the middle, the ball within 100 µm of the sensors along each direction, at most 15 s at
/// 1000 mm/min, and feeds from 1000 mm/min by a factor of 1.8. The fifth of them, 10,498 mm/min, is the last that 12,000 mm/min permits.
#[test]
fn a_path_with_a_corner_keeps_the_ball_at_the_sensors() {
    let shop = Shop::new().file("m.toml", TWO);
    let plan = [
        "plan",
        "rtest",
        "--variant",
        "corner",
        "--machine",
        "m.toml",
        "--ball",
        "420,200,60",
        "--tool",
        "100",
        "-o",
        "r.csv",
        "--program",
        "R.MPF",
    ];
    let run = shop.run(plan).exits(0).says("5 of 6 feeds");
    let csv = shop.text("r.csv");
    let labels: Vec<String> = {
        let place = csv.lines().next().unwrap().split(',').position(|name| name == "run").unwrap();
        csv.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().to_owned()).collect()
    };
    let mut feeds = labels.clone();
    feeds.dedup();
    assert_eq!(feeds, ["1000", "1800", "3240", "5832", "10498"]);
    let program = shop.text("R.MPF");
    let (path, seconds, stops) = blocks(&program);
    // The time that is printed is that of the blocks.
    let printed = format!("{}{}", run.stdout, run.stderr);
    let time =
        printed.lines().find_map(|line| line.strip_prefix("measuring time: ")).unwrap_or_else(|| panic!("{printed}"));
    let minutes: f64 = time.split(' ').next().unwrap().parse().unwrap();
    assert!((minutes - seconds / 60.0).abs() <= 0.5 && stops == 3, "{time} {seconds}");
    assert!(time.ends_with("min of motion and dwells and 3 stops"), "{time}");
    let most = farthest(&path);
    assert!(most > 0.03 && most <= 0.1015, "{most}");
    let [x, y, z, a, c] = ["X", "Y", "Z", "A", "C"].map(|name| column(&csv, name));
    let rows = labels.iter().filter(|label| *label == "1000").count();
    let length: f64 = (1..rows)
        .map(|k| ((x[k] - x[k - 1]).powi(2) + (y[k] - y[k - 1]).powi(2) + (z[k] - z[k - 1]).powi(2)).sqrt())
        .sum();
    assert!(length > 200.0 && length <= 250.0, "{length}");
    // A turns on through the corner, C turns back: there the ball turns by a right angle.
    let corner = (1..rows - 1).find(|&k| (c[k] - c[k - 1]) * (c[k + 1] - c[k]) < 0.0).unwrap();
    assert!(a[corner - 1] < a[corner] && a[corner] < a[corner + 1]);
    let step = 1e-4;
    let (ka, kc) = ((a[corner + 1] - a[corner]).abs(), (c[corner + 1] - c[corner]).abs());
    let at = |sa: f64, sc: f64| ball_at(a[corner] + sa * ka * step, c[corner] + sc * kc * step);
    let here = at(0.0, 0.0);
    let way = |there: [f64; 3], sign: f64| [0, 1, 2].map(|k| sign * (there[k] - here[k]));
    let [one, other] = [way(at(-1.0, -1.0), -1.0), way(at(1.0, -1.0), 1.0)];
    let dot = |u: [f64; 3], v: [f64; 3]| -> f64 { (0..3).map(|k| u[k] * v[k]).sum() };
    let cosine = dot(one, other) / (dot(one, one) * dot(other, other)).sqrt();
    assert!(cosine.abs() < 0.01, "{cosine}");
    // Fewer blocks leave the sensors.
    let few = shop.run(plan.into_iter().chain(["--points", "2"]));
    assert!(few.code != 0 && few.stderr.contains("more than 100 µm"), "{}", few.stderr);
    // On the axis of C the ball does not move with it.
    let on_axis = plan.map(|word| if word == "420,200,60" { "300,200,60" } else { word });
    let refused = shop.run(on_axis);
    assert!(refused.code != 0 && refused.stderr.contains("on the axis of C"), "{}", refused.stderr);
}
