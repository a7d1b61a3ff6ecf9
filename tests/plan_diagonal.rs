//! Diagonals and lengths from a station: the plan of ISO 230-6, and calibrations from readings by own arithmetic.

use std::fmt::Write as _;

use crate::support::Shop;

/// A machine of 500 x 400 x 300 mm whose axes carry the tool.
const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 500]\n\
    [axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 400]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [0, 300]\n\
    [spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

/// The rows of a plan with one more cell in each, from the name of the diagonal and the position.
fn filled(csv: &str, reading: impl Fn(&str, [f64; 3]) -> f64) -> String {
    let mut lines = csv.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| head.iter().position(|one| *one == name).unwrap();
    let mut out = head.join(",") + "\n";
    for line in lines {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        let at = ["X", "Y", "Z"].map(|axis| cells[place(axis)].parse().unwrap());
        let value = reading(&cells[place("setup")], at);
        cells[place("dl_um")] = format!("{value:.4}");
        out += &(cells.join(",") + "\n");
    }
    out
}

/// Estimate and standard uncertainty of parameters.
fn fitted(shop: &Shop, table: &str, model: &str) -> Vec<(String, f64, f64)> {
    let words = ["calibrate", table, "--machine", "mill.toml", "--model", model, "-o", "fitted.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap();
    let rows = json["parameters"].as_array().unwrap().iter();
    rows.map(|row| (row["name"].as_str().unwrap().to_owned(), number(row, "value"), number(row, "sigma"))).collect()
}

/// Four body diagonals with the deviations −21.072, 14.284, 42.286 and −35.495 µm at their ends have, by the formulas of the sum and difference of
/// diagonals (D = √(500² + 400² + 300²) = 707.107 mm),
///   XY: −(PPP + PPN − NPP − PNP) D / (4 · 500 · 400) = 100.0 µrad,
///   ZX: +(PPP + PNP − NPP − PPN) D / (4 · 500 · 300) =  50.0 µrad,
///   YZ: −(PPP + NPP − PNP − PPN) D / (4 · 400 · 300) =  20.0 µrad.
#[test]
fn four_body_diagonals_give_three_squarenesses() {
    let shop = Shop::new().file("mill.toml", MILL);
    let plan =
        ["plan", "diagonal", "--machine", "mill.toml", "--margin", "0", "--model", "squareness.txt", "-o", "d.csv"];
    let shop = shop.file("squareness.txt", "EC0Y\nEB0Z\nEA0Z\n");
    let run = shop.run(plan.iter().copied().chain(["--program", "D.MPF"])).exits(0);
    run.says("3 parameters and 4 unknowns of the set-up: the plan determines 7 of 7")
        .says("straightness and angular errors");
    let description = shop.text("d.toml");
    // (1, 4/5, 3/5) over its length √2.
    assert!(description.contains("[setup.PPP]\ndirection = [0.707107, 0.565685, 0.424264]"), "{description}");
    assert!(description.contains("[setup.NPP]\ndirection = [-0.707107, 0.565685, 0.424264]"), "{description}");
    let csv = shop.text("d.csv");
    // Five targets, five runs in both directions, four diagonals.
    assert_eq!(csv.lines().count(), 1 + 5 * 5 * 2 * 4);
    let d = (500.0_f64.powi(2) + 400.0_f64.powi(2) + 300.0_f64.powi(2)).sqrt();
    let ends = [("PPP", -21.072), ("NPP", 14.284), ("PNP", 42.286), ("PPN", -35.495)];
    let sum = |signs: [f64; 4]| ends.iter().zip(signs).map(|((_, end), sign)| end * sign).sum::<f64>();
    let truth = [
        ("EC0Y", -sum([1.0, -1.0, -1.0, 1.0]) * d / (4.0 * 500.0 * 400.0) * 1e3),
        ("EB0Z", sum([1.0, -1.0, 1.0, -1.0]) * d / (4.0 * 500.0 * 300.0) * 1e3),
        ("EA0Z", -sum([1.0, 1.0, -1.0, -1.0]) * d / (4.0 * 400.0 * 300.0) * 1e3),
    ];
    for ((_, found), hand) in truth.iter().zip([100.0, 50.0, 20.0]) {
        assert!((found - hand).abs() < 0.01, "{found} {hand}");
    }
    let readings = filled(&csv, |setup, [x, y, z]| {
        let start = |is_negative: bool, length: f64| if is_negative { length } else { 0.0 };
        let corner = [
            start(setup.as_bytes()[0] == b'N', 500.0),
            start(setup.as_bytes()[1] == b'N', 400.0),
            start(setup.as_bytes()[2] == b'N', 300.0),
        ];
        let along = ((x - corner[0]).powi(2) + (y - corner[1]).powi(2) + (z - corner[2]).powi(2)).sqrt();
        // The zero of the laser is anywhere.
        3.0 + ends.iter().find(|(name, _)| *name == setup).unwrap().1 * along / d
    });
    let shop = shop.file("d.csv", readings);
    for (name, value, sigma) in fitted(&shop, "d.csv", "EC0Y,EB0Z,EA0Z") {
        let (_, expected) = truth.iter().find(|(own, _)| *own == name).unwrap();
        assert!((value - expected).abs() < 0.02 + 2.0 * sigma, "{name}: {value} ± {sigma}, {expected}");
    }
    // A common scale of the three axes is not identifiable on four equal diagonals.
    let shop = shop.file("scales.txt", "EXX1\nEYY1\nEZZ1\n");
    let plan = ["plan", "diagonal", "--machine", "mill.toml", "--margin", "0", "--model", "scales.txt", "-o", "s.csv"];
    shop.run(plan).exits(0).says("cannot determine");
    // Two face diagonals of XY: γ = −(PP − NP) D / (2 Lx Ly) for a machine whose Y leans.
    let faces = ["plan", "diagonal", "--plane", "XY", "--machine", "mill.toml", "--margin", "0", "-o", "f.csv"];
    shop.run(faces).exits(0);
    let d = 500.0_f64.hypot(400.0);
    let face = filled(&shop.text("f.csv"), |setup, [x, y, _]| {
        let corner = if setup == "XY-NP" { 500.0 } else { 0.0 };
        (if setup == "XY-PP" { -15.6 } else { 15.6 }) * (x - corner).hypot(y) / d
    });
    let shop = shop.file("f.csv", face);
    let found = fitted(&shop, "f.csv", "EC0Y");
    let gamma = 31.2 * d / (2.0 * 500.0 * 400.0) * 1e3;
    assert!((found[0].1 - gamma).abs() < 0.02, "{found:?} {gamma}");
}

/// Lengths from a station whose place is known to some tenths of a millimeter only: the fit finds the place and the scale of X. The tip at X is 50 µm/m too
/// far, so the length is that from the true station to the true tip, minus that between their described places.
#[test]
fn lengths_from_a_station_give_scales() {
    let (described, station) = ([-200.0, -150.0, 50.0], [-199.7, -150.2, 50.1]);
    let norm = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    let mut csv = "setup,X,Y,Z,dl_um\n".to_owned();
    for x in [0.0, 125.0, 250.0, 375.0, 500.0] {
        for y in [0.0, 200.0, 400.0] {
            for z in [0.0, 150.0, 300.0] {
                let tip = [x * (1.0 + 50e-6), y, z];
                let change = norm(tip, station) - norm([x, y, z], described) + 0.25;
                let _ = writeln!(csv, "S1,{x},{y},{z},{:.3}", change * 1e3);
            }
        }
    }
    let toml = "[measurement]\nkind = \"length\"\nfree = [\"offset\", \"centre\"]\n[setup.S1]\nstation_mm = [-200, -150, 50]\n";
    let shop = Shop::new().file("mill.toml", MILL).file("t.csv", &csv).file("t.toml", toml);
    let found = fitted(&shop, "t.csv", "EXX1");
    assert!((found[0].1 - 50.0).abs() < 0.1, "{found:?}");
    // What contradicts itself is refused at its place.
    for (text, message) in [
        (toml.replace("station_mm = [-200, -150, 50]", ""), "no line"),
        (toml.replace("station_mm", "direction = [1, 0, 0]\nstation_mm"), "a direction and a station"),
        (toml.replace("station_mm = [-200, -150, 50]", "direction = [1, 0, 0]"), "no station that could be free"),
        (toml.replace("station_mm = [-200, -150, 50]", "direction = [0, 0, 0]"), "without a direction"),
    ] {
        let shop = Shop::new().file("mill.toml", MILL).file("t.csv", &csv).file("t.toml", text);
        let words = ["calibrate", "t.csv", "--machine", "mill.toml", "--model", "EXX1", "-o", "f.toml"];
        let run = shop.run(words);
        assert!(run.code != 0 && run.stderr.contains(message), "{message}: {}", run.stderr);
    }
}
