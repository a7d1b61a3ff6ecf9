//! Dangers of measured data: statements about a sign, a sign that is no better than errors of the machine, several lines in one file, a term beside other
//! causes. Readings follow from arithmetic that is written beside them.

use std::fmt::Write as _;

use crate::import::{Noise, import, shop};
use crate::support::{Run, Shop};

/// A table under the spindle: F carries Y, Y carries X, X carries the workpiece.
const MILL: &str = "[machine]\nname = \"mill\"\ntopology = \"wXYFZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-50, 450]\n";
/// All axes carry the tool.
const BRIDGE: &str = "[machine]\nname = \"bridge\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-50, 450]\n";

fn calibrate(shop: &Shop, file: &str, model: &str) -> Run {
    shop.run(["calibrate", file, "--machine", "mill.toml", "--model", model, "-o", "out.toml", "--json"])
}

fn value(json: &serde_json::Value, list: &str, place: usize) -> [f64; 2] {
    ["value", "sigma"].map(|key| json[list][place][key].as_f64().unwrap_or_else(|| panic!("{json}")))
}

/// Both scales are short by 36 µm/m on a bar of 150 mm, X and Y are 27 µrad out of square: 5.4 µm everywhere, and 27e-3 · 150/2 · sin 2θ = 2.025 sin 2θ µm.
/// The bar is 2 K warmer than 20 °C, 3.45 µm. Four runs with up to 0.35 µm of noise, no stated uncertainty. The opposite sign mends the common part by
/// chance, but needs the same errors.
#[test]
fn equal_scales_beside_a_bar_of_known_length_are_no_wrong_sign() {
    let mut noise = Noise(7);
    for common_um in [5.4, -5.4] {
        let mut rows = "run,setup,X,Y,Z,dr_um\n".to_owned();
        for run in 1..=4 {
            for k in 0..90 {
                let angle = f64::from(4 * k).to_radians();
                let [x, y] = [350.0 + 150.0 * angle.cos(), 250.0 + 150.0 * angle.sin()];
                let dr = common_um + 2.025 * (2.0 * angle).sin() + noise.next(0.2);
                let _ = writeln!(rows, "r{run}-ccw,A,{x:.6},{y:.6},200,{dr:.3}");
            }
        }
        let bar = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\n[setup.A]\ncentre_mm = [350, 250, 200]\nlength_mm = 150\n\
            rod_expansion_per_K = 11.5e-6\nrod_temperature_C = 22\n";
        let shop = Shop::new().file("mill.toml", MILL).file("bar.csv", rows).file("bar.toml", bar);
        let run = shop.run(["diagnose", "bar.csv", "--machine", "mill.toml"]).exits(0);
        assert!(!run.stderr.contains("E0614") && run.stdout.contains("location EC0X"), "{}{}", run.stdout, run.stderr);
    }
}

/// EXX = 20 µm/m · X − 60 µm/m² · Y², five lines of eleven targets, three runs, 0.2 µm of noise; `order` sorts the rows.
fn plane(order: impl Fn(&mut Vec<(u32, u32, u32)>)) -> String {
    let mut all: Vec<(u32, u32, u32)> =
        (1..=3).flat_map(|run| (0..5).flat_map(move |y| (0..11).map(move |x| (run, y, x)))).collect();
    let mut draw = Noise(11);
    let noise: Vec<f64> = (0..all.len()).map(|_| draw.next(0.2)).collect();
    let of = |(run, y, x): (u32, u32, u32)| noise[((run - 1) * 55 + y * 11 + x) as usize];
    order(&mut all);
    let mut rows = "run,setup,component,X,Y,X_dir,value_um\n".to_owned();
    for (run, y, x) in all {
        let (at_x, at_y) = (f64::from(70 * x), f64::from(50 + 100 * y));
        let um = 20e-3 * at_x - 60e-6 * at_y * at_y + of((run, y, x));
        let _ = writeln!(rows, "{run},A,EXX,{at_x},{at_y},1,{um:.3}");
    }
    rows
}

#[test]
fn a_stated_term_does_not_depend_on_the_order_of_the_rows() {
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.4\n[position]\nZ_mm = 200\n";
    let orders: [(&str, String); 3] = [
        ("lines", plane(|_| {})),
        ("across", plane(|all| all.sort_by_key(|&(run, y, x)| (run, x, y)))),
        ("mixed", plane(|all| all.sort_by_key(|&(run, y, x)| (run * 55 + y * 11 + x) * 31 % 163))),
    ];
    let mut amounts = Vec::new();
    for (name, rows) in &orders {
        let shop = Shop::new()
            .file("mill.toml", MILL)
            .file(&format!("{name}.csv"), rows)
            .file(&format!("{name}.toml"), description);
        let run = calibrate(&shop, &format!("{name}.csv"), "EXX ~ Y^2").exits(0);
        let json = run.json();
        let [amount, sigma] = value(&json, "terms", 0);
        // The slope over X is missing: the interval contains the truth, and the warning names the command that finds it.
        assert!((amount + 60.0).abs() < 2.0 * sigma, "{name}: {amount} ± {sigma}");
        assert!(json.to_string().contains("another error beside this model"), "{json}");
        amounts.push(amount);
        let whole = calibrate(&shop, &format!("{name}.csv"), "EXX1,EXX ~ Y^2").exits(0).json();
        let [with_slope, its_sigma] = value(&whole, "terms", 0);
        assert!((with_slope + 60.0).abs() < 1.0 && its_sigma < 1.0, "{name}: {with_slope} ± {its_sigma}");
    }
    assert!(amounts.iter().all(|amount| (amount - amounts[0]).abs() < 1e-3), "{amounts:?}");
    let shop = Shop::new().file("mill.toml", MILL).file("a.csv", &orders[0].1).file("a.toml", description);
    let words = ["diagnose", "a.csv", "--machine", "mill.toml", "--hypothesis", "EXX ~ Y^2"];
    let run = shop.run(words).exits(0);
    assert!(run.stdout.contains("--model \"EXX1,EXX ~ Y^2\" -o NEW.toml"), "{}", run.stdout);
}

/// Y is rotated relative to X by +40 µrad: then X is rotated relative to Y by −40 µrad, and X is the axis further from F. On the bridge, Z is further from
/// F than Y, and Y further than X.
#[test]
fn a_squareness_under_the_letter_of_the_other_axis_is_turned() {
    let direct = "[measurement]\nkind = \"direct\"\nsigma_urad = 2\n[position]\nX_mm = 0\nY_mm = 0\nZ_mm = 0\n";
    for (machine, table, model, expected) in [
        (MILL, "EC0Y,40\n", "EC0X", vec![-40.0]),
        (BRIDGE, "EC0X,40\nEB0X,-25\nEA0Y,12\n", "EC0Y,EB0Z,EA0Z", vec![-40.0, 25.0, -12.0]),
        (BRIDGE, "EC0Y,40\nEB0Z,-25\nEA0Z,12\n", "EC0Y,EB0Z,EA0Z", vec![40.0, -25.0, 12.0]),
    ] {
        let shop = Shop::new()
            .file("mill.toml", machine)
            .file("s.csv", format!("component,value_urad\n{table}"))
            .file("s.toml", direct);
        let json = calibrate(&shop, "s.csv", model).exits(0).json();
        for (place, truth) in expected.iter().enumerate() {
            let [found, sigma] = value(&json, "parameters", place);
            assert!((found - truth).abs() < 2e-3 && (sigma - 2.0).abs() < 0.1, "{table}: {found} ± {sigma}");
        }
        assert_eq!(json.to_string().contains("W0622"), expected[0] < 0.0, "{json}");
    }
    // The tool on the table: Y is rotated by +40 µrad, so 300 mm of Y+ lead it 12 µm in X−.
    let shop = Shop::new()
        .file("mill.toml", MILL)
        .file(
            "d.csv",
            "run,X,Y,Z,dx_um\n1,300,100,100,0\n1,300,400,100,-12\n2,300,100,100,0.001\n2,300,400,100,-12.001\n",
        )
        .file("d.toml", "[measurement]\nkind = \"displacement\"\nfree = [\"offset\"]\n");
    let json = calibrate(&shop, "d.csv", "EC0X").exits(0).json();
    let [found, _] = value(&json, "parameters", 0);
    assert!((found + 40.0).abs() < 0.1, "{found}");
}

/// Options of a laser without its sign.
const LASER: &[&str] = &["--axis", "X", "--at", "Y200,Z100", "--unit", "um", "--tool", "120", "--material", "20C"];

fn laser(line: &str, headings: &str) -> String {
    format!("{line}{headings}\n0;0,5;0,6\n100;1,5;1,6\n200;3,5;3,4\n")
}

/// The reading of 3.5 µm at 200 mm after the import: of the deviation of the tool, on a machine whose X carries the tool.
fn first_um(shop: &Shop) -> f64 {
    let table = shop.text("out.csv");
    let heads: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let [x, value] = ["X", "value_um"].map(|name| heads.iter().position(|head| *head == name).unwrap());
    let row = table.lines().skip(1).map(|line| line.split(',').collect::<Vec<_>>()).find(|row| row[x] == "200");
    row.unwrap()[value].parse().unwrap()
}

#[test]
fn a_line_about_the_sign_is_used_or_asked_about() {
    let head = "Target;1+;1-";
    for line in [
        "Sign convention;target - actual\n",
        "Vorzeichen;Soll-Ist\n",
        "Error definition;commanded minus measured\n",
        "Signe;consigne - position mesurée\n",
        "Segno;nominale meno reale\n",
        "Signo;objetivo menos real\n",
        "# deviation = target - actual\n",
    ] {
        let shop = shop().file("l.csv", laser(line, head));
        import(&shop, "l.csv", "tool.toml", LASER).exits(0).says("nominal minus actual: the sign is reversed");
        assert!((first_um(&shop) + 3.5).abs() < 1e-9, "{line}{}", shop.text("out.csv"));
        import(&shop, "l.csv", "tool.toml", &[LASER, &["--sign", "+"]].concat()).exits(4).says("E0618");
    }
    let shop = shop().file("l.csv", laser("Vorzeichen;Ist-Soll\n", head));
    import(&shop, "l.csv", "tool.toml", LASER).exits(0).says("sign: actual minus nominal");
    assert!((first_um(&shop) - 3.5).abs() < 1e-9);
    for line in
        ["Sign;reversed\n", "Polarity = inverted\n", "Vorzeichen;umgekehrt\n", "Definizione errore;vedi manuale\n"]
    {
        let shop = crate::import::shop().file("o.csv", laser(line, head));
        import(&shop, "o.csv", "tool.toml", LASER).exits(4).says("E0616").says("cannot evaluate it").says("--sign");
        import(&shop, "o.csv", "tool.toml", &[LASER, &["--sign", "-"]].concat()).exits(0).says("--sign decides");
        assert!((first_um(&shop) + 3.5).abs() < 1e-9, "{line}");
    }
}

#[test]
fn a_sign_in_the_headings_is_used_for_all_readings_or_refused() {
    let shop = shop()
        .file("all.csv", laser("", "Target;Deviation target-actual 1+ (um);Deviation target-actual 1- (um)"))
        .file("some.csv", laser("", "Target;Deviation target-actual 1+ (um);1- (um)"))
        .file("both.csv", laser("", "Target;Deviation target-actual 1+ (um);Deviation actual-target 1- (um)"))
        .file("one.csv", "Target;Error (target - actual) [um]\n0;0,5\n100;1,5\n200;3,5\n");
    for file in ["all.csv", "one.csv"] {
        import(&shop, file, "tool.toml", LASER).exits(0).says("the sign is reversed");
        assert!((first_um(&shop) + 3.5).abs() < 1e-9, "{file}");
    }
    import(&shop, "some.csv", "tool.toml", LASER).exits(4).says("E0618").says("states its sign");
    import(&shop, "both.csv", "tool.toml", LASER).exits(4).says("E0618");
}

/// A circle of a bar with a line in its head.
fn circle(line: &str) -> String {
    let mut text = format!("Plane;XY\nRadius;150\n{line}Angle (deg);Run 1 CCW (um)\n");
    for deg in 0..=360 {
        let _ = writeln!(text, "{deg};{:.2}", 4.0 + f64::from(deg) / 100.0);
    }
    text
}

const CENTER: &[&str] = &["--at", "X300,Y250,Z100", "--tool", "0", "--material", "20C"];

#[test]
fn a_line_about_the_sign_of_a_ball_bar_is_used() {
    let shop = shop().file("b.csv", circle("Sign;nominal - measured\n")).file("o.csv", circle("Sign;reversed\n"));
    let length = ["--length", "calibrated", "--length-sigma", "0.2"];
    import(&shop, "b.csv", "tool.toml", &[CENTER, &length].concat()).exits(0).says("the sign is reversed");
    assert!(shop.text("out.csv").lines().nth(1).unwrap().ends_with(",-4"), "{}", shop.text("out.csv"));
    import(&shop, "o.csv", "tool.toml", &[CENTER, &length].concat()).exits(4).says("E0616").says("longer than nominal");
}

/// U = 0.5 µm for k = 2 is a standard uncertainty of 0.25 µm.
#[test]
fn a_calibrated_length_needs_its_uncertainty() {
    let shop = shop()
        .file("plain.csv", circle(""))
        .file("cert.csv", circle("Calibrated length;150,0012\nUncertainty of calibrator (k=2);0.5 um\n"))
        .file("open.csv", circle("Uncertainty of calibrator;0.5 um\n"));
    let calibrated: &[&str] = &["--length", "calibrated"];
    import(&shop, "plain.csv", "tool.toml", &[CENTER, calibrated].concat())
        .exits(0)
        .says("W0623")
        .says("--length-sigma");
    let with = [CENTER, calibrated, &["--length-sigma", "0.5um"]].concat();
    let run = import(&shop, "plain.csv", "tool.toml", &with).exits(0);
    assert!(!run.stderr.contains("W0623") && shop.text("out.toml").contains("length_sigma_um = 0.5"), "{}", run.stderr);
    import(&shop, "cert.csv", "tool.toml", CENTER).exits(4).says("give --length:").says("calibrated if they do");
    import(&shop, "cert.csv", "tool.toml", &[CENTER, calibrated].concat()).exits(0);
    assert!(shop.text("out.toml").contains("length_sigma_um = 0.25"), "{}", shop.text("out.toml"));
    import(&shop, "open.csv", "tool.toml", &[CENTER, calibrated].concat()).exits(4).says("give --length-sigma");
}

/// Between commas, a number with a decimal comma is in quotation marks.
#[test]
fn quoted_decimal_commas_between_commas_are_read() {
    let shop = shop()
        .file("q.csv", "Target,1+,1-\n0,\"0,5\",\"0,6\"\n100,\"1,5\",\"1,6\"\n200,\"3,5\",\"3,4\"\n")
        .file("open.csv", "Target,1+,1-\n0,\"1,500\",\"1,600\"\n100,\"2,500\",\"2,600\"\n200,\"3,500\",\"3,400\"\n");
    let sign = [LASER, &["--sign", "+"]].concat();
    import(&shop, "q.csv", "tool.toml", &sign).exits(0);
    assert!((first_um(&shop) - 3.5).abs() < 1e-9, "{}", shop.text("out.csv"));
    import(&shop, "open.csv", "tool.toml", &sign).exits(4).says("'1,500' may be 1.500 or 1500");
}

/// Five targets of X with a slope of 10 µm/m at Y = 100, and of 30 µm/m at Y = 400: E is the range of the means, 4 · 0.1 m · slope. Both directions agree.
#[test]
fn lines_at_two_places_have_figures_of_their_own() {
    let mut rows = "run,setup,component,X,Y,Z,X_dir,value_um\n".to_owned();
    for (y, slope) in [(100, 10.0), (400, 30.0)] {
        for run in 1..=5 {
            for (sense, order) in [(1, [0, 1, 2, 3, 4]), (-1, [4, 3, 2, 1, 0])] {
                for k in order {
                    let um = slope * 0.1 * f64::from(k) + 0.01 * f64::from((run * 7 + k * 3) % 5 - 2);
                    let _ = writeln!(rows, "{y}-{run},A,EXX,{},{y},200,{sense},{um:.4}", 100 * k);
                }
            }
        }
    }
    let description = "[measurement]\nkind = \"direct\"\nfree = [\"offset\"]\nsigma_um = 0.05\n";
    let shop = Shop::new().file("mill.toml", MILL).file("two.csv", rows).file("two.toml", description);
    let json = shop.run(["iso230", "two.csv", "--machine", "mill.toml", "--json"]).exits(0).json();
    let groups = json["measurements"][0]["figures"].as_array().unwrap();
    for (group, (of, e)) in groups.iter().zip([("EXX at Y100", 4.0), ("EXX at Y400", 12.0)]) {
        assert_eq!(group["of"], of, "{group}");
        let found = group["values"].as_array().unwrap().iter().find(|one| one["name"] == "E").unwrap();
        assert!((found["value"].as_f64().unwrap() - e).abs() < 0.1, "{group}");
        assert!(group["conditions"].to_string().contains("5 runs"), "{group}");
    }
    assert_eq!(groups.len(), 2, "{json}");
    // Y only stood at two places, so its scale has no part in these readings.
    let run = calibrate(&shop, "two.csv", "EXX1").exits(0);
    assert!(!run.stdout.contains("W0611"), "{}", run.stdout);
}

/// The nose of the demo machine is at the table surface at Z0; its travel begins at −50 mm, the plan keeps 2 mm away.
#[test]
fn a_plan_states_its_lowest_point() {
    let demo = crate::support::machine("demo");
    for kind in ["diagonal", "laser"] {
        let shop = Shop::new();
        let axis: &[&str] = if kind == "laser" { &["--axis", "Z"] } else { &[] };
        let words = ["plan", kind, "--machine", &demo, "--tool", "100", "-o", "p.csv", "--program", "p.mpf"];
        let run = shop.run(words.into_iter().chain(axis.iter().copied())).exits(0);
        let said = "the spindle nose moves down to Z -48 mm, and the measuring point to Z -148, relative to the zero of the machine";
        assert!(run.stdout.contains(said) || run.stderr.contains(said), "{kind}: {}{}", run.stdout, run.stderr);
        assert!(shop.text("p.mpf").contains("the spindle nose moves down to Z -48 mm"), "{}", shop.text("p.mpf"));
    }
}
