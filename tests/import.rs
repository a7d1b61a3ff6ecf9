//! `ncfix import`: files after public layouts, written here by own arithmetic with known errors, become measurements from which `calibrate` finds
//! the errors; files that leave something open end in a question or a refusal.

use std::fmt::Write as _;
use std::io::Write as _;

use crate::support::{Run, Shop, machine, repository};

/// A machine without errors whose axes all carry the tool, and one with a cross table.
const TOOL_SIDE: &str = "[machine]\nname = \"mill\"\ntopology = \"wFXYZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, 1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";
const TABLE_SIDE: &str = "[machine]\nname = \"mill\"\ntopology = \"wXYFZSt\"\ncontroller = \"sinumerik\"\n\
    [axis.X]\ndirection = [-1, 0, 0]\ntravel_mm = [0, 700]\n[axis.Y]\ndirection = [0, -1, 0]\ntravel_mm = [0, 500]\n\
    [axis.Z]\ndirection = [0, 0, 1]\ntravel_mm = [-100, 400]\n[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n";

/// Options that answer all questions of a laser file.
const LASER: &[&str] =
    &["--axis", "X", "--at", "Y200,Z100", "--sign", "+", "--unit", "um", "--tool", "0", "--material", "20C"];

pub(crate) fn shop() -> Shop {
    Shop::new().file("tool.toml", TOOL_SIDE).file("table.toml", TABLE_SIDE)
}

pub(crate) fn import(shop: &Shop, file: &str, machine: &str, more: &[&str]) -> Run {
    let mut words = vec!["import", file, "--machine", machine, "-o", "out", "--force"];
    words.extend(more);
    shop.run(words)
}

/// Calibrates `out.csv`, and gives estimate and standard uncertainty of each parameter.
pub(crate) fn calibrated(shop: &Shop, machine: &str, model: &str) -> Vec<(String, f64, f64)> {
    let words = ["calibrate", "out.csv", "--machine", machine, "--model", model, "-o", "fitted.toml", "--json"];
    let json = shop.run(words).exits(0).json();
    let rows = json["parameters"].as_array().unwrap().iter();
    let number = |row: &serde_json::Value, key: &str| row[key].as_f64().unwrap_or_else(|| panic!("{key}: {row}"));
    rows.map(|row| (row["name"].as_str().unwrap().to_owned(), number(row, "value"), number(row, "sigma"))).collect()
}

/// Every parameter is within two of its standard uncertainties, and a floor for the digits of the file.
#[track_caller]
fn demand(found: &[(String, f64, f64)], expected: &[(&str, f64)], floor: f64) {
    for (name, value) in expected {
        let (_, estimate, sigma) =
            found.iter().find(|(own, ..)| own == name).unwrap_or_else(|| panic!("{name}: {found:?}"));
        let _ = writeln!(std::io::stderr(), "{name}: true {value}, found {estimate:.3} ± {sigma:.3}");
        assert!((estimate - value).abs() <= 2.0 * sigma + floor, "{name}: true {value}, found {estimate} ± {sigma}");
    }
}

/// Noise of a known sequence, uniform with the standard deviation `sigma`.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn next(&mut self, sigma: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1u64 << 53) as f64 - 0.5) * sigma * 12f64.sqrt()
    }
}

/// Deviation of X of a laser, µm: a scale of 40 µm/m, a backlash of 6 µm (half in each direction), noise of 0.2 µm.
fn deviation(x: f64, sense: f64, noise: &mut Noise) -> f64 {
    0.04 * x + 3.0 * sense + noise.next(0.2)
}

/// A wide table: 13 targets, three runs in both directions.
fn wide(head: &str, separator: &str, decimal: &str) -> String {
    let mut noise = Noise(7);
    let mut text = head.to_owned();
    for k in 0..13 {
        let x = 50.0 * f64::from(k);
        let cells: Vec<String> = (0..6)
            .map(|n| {
                format!("{:.2}", deviation(x, if n % 2 == 0 { 1.0 } else { -1.0 }, &mut noise)).replace('.', decimal)
            })
            .collect();
        let _ = writeln!(text, "{}{separator}{}", format!("{x:.1}").replace('.', decimal), cells.join(separator));
    }
    text
}

fn utf16(text: &str) -> Vec<u8> {
    [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes)).collect()
}

fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|letter| u8::try_from(u32::from(letter)).unwrap()).collect()
}

#[test]
fn a_laser_table_gives_scale_and_backlash_in_every_locale() {
    let german = wide("Messung µm\nZielposition [mm];1 hin;1 rück;2 hin;2 rück;3 hin;3 rück\n", ";", ",");
    let files: [(&str, Vec<u8>); 4] = [
        ("english.csv", wide("Target,1+,1-,2+,2-,3+,3-\n", ",", ".").into_bytes()),
        ("latin.txt", latin1(&german)),
        ("unicode.txt", utf16(&wide("Cible\tF1\tR1\tF2\tR2\tF3\tR3\r\n", "\t", ","))),
        ("marked.csv", [b"\xef\xbb\xbf".to_vec(), german.into_bytes()].concat()),
    ];
    for (name, bytes) in files {
        let shop = shop().file(name, bytes);
        for machine in ["tool.toml", "table.toml"] {
            let run = import(&shop, name, machine, LASER).exits(0);
            assert!(run.stderr.contains("check: at X 600 the true position is 27."), "{name}: {}", run.stderr);
        }
        // The table carries X: the deviation of the moving body has the opposite sign, and the calibration knows that.
        let found = calibrated(&shop, "table.toml", "EXX1,EXXb");
        demand(&found, &[("EXX1", -40.0), ("EXXb", -3.0)], 0.05);
        import(&shop, name, "tool.toml", LASER).exits(0);
        demand(&calibrated(&shop, "tool.toml", "EXX1,EXXb"), &[("EXX1", 40.0), ("EXXb", 3.0)], 0.05);
        let description = shop.text("out.toml");
        assert!(
            description.contains("# - sign: --sign +") && description.contains("# - unit of the readings: --unit um"),
            "{description}"
        );
    }
}

#[test]
fn the_folder_of_the_output_is_made() {
    let shop = shop().file("laser.csv", wide("Target,1+,1-,2+,2-,3+,3-\n", ",", "."));
    let mut words = vec!["import", "laser.csv", "--machine", "tool.toml", "-o", "days/one/x"];
    words.extend(LASER);
    shop.run(words).exits(0);
    assert!(shop.path("days/one/x.csv").is_file() && shop.path("days/one/x.toml").is_file());
    // A file in the place of the folder is an error that names it.
    let mut words = vec!["import", "laser.csv", "--machine", "tool.toml", "-o", "laser.csv/x"];
    words.extend(LASER);
    shop.run(words).exits(2).says("laser.csv");
}

#[test]
fn targets_may_be_in_the_first_row() {
    let mut noise = Noise(47);
    let targets: Vec<f64> = (0..13).map(|k| 50.0 * f64::from(k)).collect();
    let row = |head: &str, values: &mut dyn Iterator<Item = f64>| {
        format!(
            "{head};{}\n",
            values.map(|value| format!("{value:.2}").replace('.', ",")).collect::<Vec<_>>().join(";")
        )
    };
    let mut text = row("Position [mm]", &mut targets.iter().copied());
    for run in 1..=3 {
        for (mark, sense) in [('+', 1.0), ('-', -1.0)] {
            text.push_str(&row(&format!("{run}{mark}"), &mut targets.iter().map(|x| deviation(*x, sense, &mut noise))));
        }
    }
    text.push_str(&row("Mittel", &mut targets.iter().copied()));
    let shop = shop().file("rows.csv", text);
    import(&shop, "rows.csv", "tool.toml", LASER).exits(0).says("rows that are not read: Mittel");
    demand(&calibrated(&shop, "tool.toml", "EXX1,EXXb"), &[("EXX1", 40.0), ("EXXb", 3.0)], 0.05);
}

/// A column with the axis of each row is no remark: with one axis for all rows, readings of Y would become errors of X.
#[test]
fn a_table_of_several_axes_is_refused() {
    let mut text = "Axis;Run;Direction;Target [mm];Deviation [um]\n".to_owned();
    for axis in ["X", "Y"] {
        for k in 0..6 {
            let _ = writeln!(text, "{axis};1;+;{};{}", 100 * k, 4 * k);
        }
    }
    let shop = shop().file("several.csv", text);
    let more = ["--axis", "X", "--sign", "+", "--at", "Y200,Z100", "--tool", "0", "--material", "20C"];
    import(&shop, "several.csv", "tool.toml", &more).exits(4).says("E0618").says("the column 'Axis' is not read");
    assert!(!shop.path("out.csv").exists());
}

#[test]
fn a_long_table_of_positions_proves_its_sign() {
    let mut noise = Noise(3);
    let mut text = "Machine;A 1\nAxis;X\nRun;Target (mm);Actual (mm);Direction;Humidity\n".to_owned();
    for run in 1..=3 {
        let there = (0..=10).map(|k| (60.0 * f64::from(k), 1.0));
        let back = (0..=10).rev().map(|k| (60.0 * f64::from(k), -1.0));
        for (x, sense) in there.chain(back) {
            let actual = x + deviation(x, sense, &mut noise) / 1000.0;
            let _ = writeln!(text, "{run};{x:.1};{actual:.5};{};41", if sense > 0.0 { '+' } else { '-' });
        }
    }
    let shop = shop().file("long.csv", text);
    let run =
        import(&shop, "long.csv", "tool.toml", &["--at", "Y200,Z100", "--tool", "0", "--material", "20C"]).exits(0);
    assert!(run.stderr.contains("columns that are not read: Humidity"), "{}", run.stderr);
    assert!(run.stderr.contains("sign: actual minus nominal (line 3"), "{}", run.stderr);
    demand(&calibrated(&shop, "tool.toml", "EXX1,EXXb"), &[("EXX1", 40.0), ("EXXb", 3.0)], 0.05);
}

#[test]
fn a_level_in_arc_seconds_gives_an_angle() {
    let mut noise = Noise(5);
    let mut text = "Neigung\nX [mm]\tAbweichung [″]\n".to_owned();
    for k in 0..=12 {
        let x = 50.0 * f64::from(k);
        // 25 µrad per m; an arc second is 4.8481 µrad.
        let _ = writeln!(text, "{x}\t{:.3}", (0.025 * x + noise.next(0.3)) / 4.848_137);
    }
    let shop = shop().file("level.txt", text);
    import(&shop, "level.txt", "tool.toml", &["--at", "Y0,Z0", "--sign", "+"]).exits(4).says("give --component");
    import(&shop, "level.txt", "tool.toml", &["--component", "EBX", "--at", "Y0,Z0", "--sign", "+"]).exits(0);
    demand(&calibrated(&shop, "tool.toml", "EBX1"), &[("EBX1", 25.0)], 0.01);
}

/// A straightness is across its axis: EYY is the positioning of Y, and no straightness.
#[test]
fn the_components_that_a_question_names_belong_to_the_axis() {
    for (axis, named) in [
        ("X", "EXX for positioning or EYX for a straightness"),
        ("Y", "EYY for positioning or EXY for a straightness"),
        ("Z", "EZZ for positioning or EYZ for a straightness"),
    ] {
        let text = format!(
            "Axis;{axis}\nUnit;um\nMeasurement type;Straightness\nTarget [mm];1+;1-\n0;0;1\n100;1;2\n200;3;3\n300;4;5\n400;2;2\n"
        );
        let shop = shop().file("line.csv", text);
        import(&shop, "line.csv", "tool.toml", &["--at", "X0,Y0,Z0", "--sign", "+"]).exits(4).says(named);
    }
}

/// A line before the table names the component, with no word for a straightness.
#[test]
fn a_stated_component_is_used_or_refused() {
    let table = "Target [mm];1+ [µm];1- [µm];2+ [µm];2- [µm]\n0;0;1;0;1\n100;1;2;1;2\n200;3;3;3;4\n300;4;5;4;5\n";
    let file = |line: &str| shop().file("line.csv", format!("Axis;X\n{line}\n{table}"));
    let options = ["--at", "Y0,Z0", "--sign", "+", "--tool", "0", "--material", "20C"];
    for (line, component) in
        [("Component;EYX", "EYX"), ("Error: EZX", "EZX"), ("Measured error;EYX", "EYX"), ("Component;EXX", "EXX")]
    {
        // A straightness does not depend on the temperature of the scale.
        let used = if component == "EXX" { &options[..] } else { &options[..6] };
        let shop = file(line);
        import(&shop, "line.csv", "tool.toml", used).exits(0);
        assert!(shop.text("out.csv").contains(&format!(",{component},")), "{line}: {}", shop.text("out.csv"));
        assert!(shop.text("out.toml").contains(&format!("(line 2: {line})")), "{}", shop.text("out.toml"));
    }
    // An angle has another unit than the table.
    import(&file("Component;EBX"), "line.csv", "tool.toml", &options).exits(4);
    let other = [&options[..6], &["--component", "EZX"]].concat();
    import(&file("Component;EYX"), "line.csv", "tool.toml", &other).exits(4).says("E0618").says("which names EYX");
    import(&file("Component;EXY"), "line.csv", "tool.toml", &options[..6]).exits(4).says("names another axis");
    let both = file("Component;EXX\nMeasurement;Straightness");
    import(&both, "line.csv", "tool.toml", &options).exits(4).says("E0618").says("the file names EXX");
    // A component that is only mentioned is asked for, before anything that depends on it.
    let run =
        import(&file("Optics for EYX"), "line.csv", "tool.toml", &["--at", "Y0,Z0"]).exits(4).says("give --component");
    assert!(!run.stderr.contains("--sign") && !run.stderr.contains("--material"), "{}", run.stderr);
}

/// A line with the temperature of the bar does not say whether the software used it. The option --at is given once.
#[test]
fn the_questions_of_a_ball_bar_quote_the_file_and_give_the_whole_option() {
    let mut text =
        "Ball-bar temperature (C),21.5\nplane,XY\nradius_mm,150\nrun,direction,angle_deg,dev_um\n".to_owned();
    for k in 0..72 {
        let _ = writeln!(text, "1,ccw,{},{:.2}", 5 * k, 3.0 * f64::from(10 * k).to_radians().sin());
    }
    let shop = shop().file("bar.csv", text);
    let ask = |more: &[&str]| import(&shop, "bar.csv", "tool.toml", more).exits(4);
    let said = ask(&["--tool", "0", "--at", "X300,Y200,Z100", "--length", "calibrated"]);
    let said = said.says("line 1 of the file states 21.5 °C").says("Ball-bar temperature (C),21.5");
    assert!(said.stderr.contains("such as 11.5@21.5"), "{}", said.stderr);
    // The centre in Z is missing: the example has X and Y too.
    ask(&["--tool", "0", "--at", "X300,Y200"]).says("such as Z0,X300,Y200");
}

#[test]
fn a_rotary_calibrator_is_read_in_degrees_and_arc_seconds() {
    let machine = TOOL_SIDE
        .replace("wFXYZSt", "wCFXYZSt")
        .replace("[spindle]", "[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\nmodulo = true\n[spindle]");
    let mut noise = Noise(9);
    let mut text = "Target [deg],Deviation [arcsec]\n".to_owned();
    for k in 0..12 {
        let c = 30.0 * f64::from(k);
        let _ = writeln!(text, "{c},{:.3}", (20.0 * c.to_radians().sin() + noise.next(0.3)) / 4.848_137);
    }
    let shop = shop().file("rotary.toml", machine).file("xr.csv", text);
    let run =
        import(&shop, "xr.csv", "rotary.toml", &["--axis", "C", "--at", "X0,Y0,Z0", "--sign", "+", "--tool", "0"])
            .exits(0);
    assert!(
        run.stderr.contains("at C 90 the true position is") || run.stderr.contains("at C 270 the true position is"),
        "{}",
        run.stderr
    );
    assert!(shop.text("out.csv").contains("ECC,90,"), "{}", shop.text("out.csv"));
}

/// The plate of a workshop: nine holes of 300 mm × 200 mm, drilled in aluminum at 26 °C on a machine with EXX1 = 40, EYY1 = −15 µm/m and EC0Y = 80 µrad, and
/// measured at 20 °C. The alignment of the report turns it by 24.6 µrad and shifts it.
fn plate(noise: &mut Noise) -> Vec<([f64; 2], [f64; 2])> {
    let mut holes = Vec::new();
    for j in 0..3 {
        for i in 0..3 {
            let (x, y) = (150.0 * f64::from(i), 100.0 * f64::from(j));
            let shrink = -23.8e-6 * 6.0;
            let dx = (40e-6 + shrink) * x - 80e-6 * y - 24.6e-6 * y + 0.021;
            let dy = (-15e-6 + shrink) * y + 24.6e-6 * x + 0.0195;
            holes.push(([x, y], [x + dx + noise.next(0.0005), y + dy + noise.next(0.0005)]));
        }
    }
    holes
}

const PLATE: &[&str] = &["--at", "X100,Y100,Z-20", "--sign", "+", "--tool", "0", "--material", "23.8@26"];

#[test]
fn a_drilled_plate_gives_squareness_and_scales_from_every_report() {
    let holes = plate(&mut Noise(11));
    let mut table = "Hole;Nom X;Nom Y;Act X;Act Y;Dev X;Dev Y;Roundness\r\n".to_owned();
    let mut columnar = "feature;axis;actual;nominal;upper tol;deviation\n".to_owned();
    let mut dmis = "DMISMN/'PLATE',04.0\nUNITS/MM,ANGDEC\n".to_owned();
    for (k, (nominal, actual)) in holes.iter().enumerate() {
        let d = [actual[0] - nominal[0], actual[1] - nominal[1]];
        let row = format!(
            "H{k};{:.1};{:.1};{:.4};{:.4};{:.4};{:.4};0.004\r\n",
            nominal[0], nominal[1], actual[0], actual[1], d[0], d[1]
        );
        table.push_str(&row.replace('.', ","));
        for (k2, letter) in ["X", "Y"].iter().enumerate() {
            let _ = writeln!(columnar, "H{k};{letter};{:.4};{:.1};0.1;{:.4}", actual[k2], nominal[k2], d[k2]);
        }
        let _ = writeln!(columnar, "H{k};D;8.0021;8.0;0.1;0.0021");
        let _ =
            writeln!(dmis, "F(H{k})=FEAT/CIRCLE,INNER,CART,{:.4},{:.4},0.0000,$\n0,0,1,8.0", nominal[0], nominal[1]);
        let _ =
            writeln!(dmis, "FA(H{k})=FEAT/CIRCLE,INNER,CART,{:.4},{:.4},0.0000,$\n0,0,1,8.0021", actual[0], actual[1]);
    }
    dmis.push_str("ENDFIL\n");
    let shop = shop().file("plate.csv", table).file("columns.txt", columnar).file("plate.dmo", dmis);
    for (file, unit) in [("plate.csv", true), ("columns.txt", true), ("plate.dmo", false)] {
        let more: Vec<&str> =
            PLATE.iter().copied().chain(unit.then_some(["--unit", "mm"]).into_iter().flatten()).collect();
        // Z stands where --at says, although no column has it.
        import(&shop, file, "tool.toml", &more).exits(0).says(" Z -20 the tool is");
        assert!(shop.text("out.toml").contains("expansion_per_K = 2.38e-5"), "{}", shop.text("out.toml"));
        demand(
            &calibrated(&shop, "tool.toml", "EXX1,EYY1,EC0Y"),
            &[("EXX1", 40.0), ("EYY1", -15.0), ("EC0Y", 80.0)],
            0.3,
        );
    }
    // A calibrated plate that was probed shows the opposite.
    let more: Vec<&str> =
        PLATE.iter().map(|&word| if word == "+" { "-" } else { word }).chain(["--unit", "mm"]).collect();
    import(&shop, "plate.csv", "tool.toml", &more).exits(0);
    let found = calibrated(&shop, "tool.toml", "EC0Y");
    assert!(found[0].1 < -40.0, "{found:?}");
}

#[test]
fn ball_bar_circles_give_squareness_and_scales() {
    // dr = EC0Y, scales: mean 2.25, cos 2θ 5.25, sin 2θ −7.5 µm at R 150 for EC0Y 100, EXX1 50, EYY1 −20.
    let mut noise = Noise(13);
    let mut text =
        "plane;XY\nradius_mm;150\nfeed_mm_min;1000\nstart angle;0\nend angle;360\nrun;angle_deg;dev_um\n".to_owned();
    for run in 1..=2 {
        for k in -5..=77 {
            let deg = 5.0 * f64::from(k);
            let twice = (2.0 * deg).to_radians();
            // The overshoot is spoiled by the acceleration.
            let spoiled = if (0.0..=360.0).contains(&deg) { 0.0 } else { 40.0 };
            let value = 2.25 + 5.25 * twice.cos() - 7.5 * twice.sin() + spoiled + noise.next(0.2);
            let _ = writeln!(
                text,
                "{run};{};{}",
                format!("{deg:.1}").replace('.', ","),
                format!("{value:.2}").replace('.', ",")
            );
        }
    }
    let shop = shop().file("bar.csv", text);
    let run =
        import(&shop, "bar.csv", "tool.toml", &["--at", "X300,Y250,Z100", "--tool", "50", "--turn", "ccw"]).exits(0);
    assert!(run.stderr.contains("20 readings of the overshoot are not used"), "{}", run.stderr);
    let description = shop.text("out.toml").replace("free = [\"centre\", \"length\"]", "free = [\"centre\"]");
    let shop = shop.file("out.toml", description);
    let found = calibrated(&shop, "tool.toml", "EXX1,EYY1,EC0Y");
    demand(&found, &[("EXX1", 50.0), ("EYY1", -20.0), ("EC0Y", 100.0)], 0.2);
}

/// The circle of the test above with times instead of angles, counterclockwise and clockwise, from −180° with an overshoot of 180° on both ends. At 1,000
/// mm/min on 150 mm a turn lasts 2π·150·60/1000 = 56.55 s.
#[test]
fn ball_bar_circles_by_time_give_the_same_errors() {
    let mut noise = Noise(17);
    let mut text =
        "plane;XY\nradius_mm;150\nfeed_mm_min;1000\nstart angle;0\nend angle;360\nrun;dir;time_s;dev_um\n".to_owned();
    let turn_s = std::f64::consts::TAU * 150.0 * 60.0 / 1000.0;
    let mut circles = |text: &mut String, start: f64, second: &str| {
        for (run, sense) in [("1", 1.0), (second, -1.0)] {
            for k in 0..=144 {
                let swept = 5.0 * f64::from(k);
                // The circle back begins 180° beyond its end, at 540°.
                let deg: f64 = if sense > 0.0 { start + swept } else { 360.0 - start - swept };
                let twice = (2.0 * deg).to_radians();
                let value = 2.25 + 5.25 * twice.cos() - 7.5 * twice.sin() + noise.next(0.2);
                let word = if sense > 0.0 { "ccw" } else { "cw" };
                let _ = writeln!(text, "{run};{word};{:.4};{value:.2}", 3.0 + swept / 360.0 * turn_s);
            }
        }
    };
    circles(&mut text, -180.0, "2");
    let shop = shop().file("bar.csv", &text);
    let place = ["--at", "X300,Y250,Z100", "--tool", "50"];
    let run = import(&shop, "bar.csv", "tool.toml", &place).exits(4);
    assert!(run.stderr.contains("give --start-angle") && !run.stderr.contains("give --turn"), "{}", run.stderr);
    let more: Vec<&str> = place.iter().copied().chain(["--start-angle", "-180"]).collect();
    let run = import(&shop, "bar.csv", "tool.toml", &more).exits(0);
    assert!(
        run.stderr.contains("of the overshoot are not used") && run.stderr.contains("acceleration"),
        "{}",
        run.stderr
    );
    let free = |shop: Shop| {
        let description = shop.text("out.toml").replace("free = [\"centre\", \"length\"]", "free = [\"centre\"]");
        shop.file("out.toml", description)
    };
    let shop = free(shop);
    let found = calibrated(&shop, "tool.toml", "EXX1,EYY1,EC0Y");
    demand(&found, &[("EXX1", 50.0), ("EYY1", -20.0), ("EC0Y", 100.0)], 0.2);
    // Milliseconds taken for seconds, another feed, and a file without the direction.
    let fast = shop.file("fast.csv", text.replace("feed_mm_min;1000", "feed_mm_min;100"));
    import(&fast, "fast.csv", "tool.toml", &more).exits(4).says("E0618").says("before the end");
    let slow = fast.file("slow.csv", text.replace("feed_mm_min;1000", "feed_mm_min;10000"));
    import(&slow, "slow.csv", "tool.toml", &more).exits(4).says("E0618").says("sweep");
    let blind = slow.file("blind.csv", text.replace("run;dir;", "run;-;"));
    import(&blind, "blind.csv", "tool.toml", &more).exits(4).says("give --turn");
}

#[test]
fn the_alignment_of_a_straightedge_is_unknown_and_that_of_a_square_is_not() {
    let mut table = "X [mm];dev [um]\n".to_owned();
    for k in 0..8 {
        table += &format!("{};{}\n", 50 * k, k * (7 - k));
    }
    for (component, reference, free) in
        [("EYX", "straightedge", r#"free = ["offset", "slope"]"#), ("EYX", "square", r#"free = ["offset"]"#)]
    {
        let shop = Shop::new().file("line.csv", &table);
        let machine = machine("demo");
        let all = format!(
            "import line.csv --machine {machine} --axis X --component {component} --reference {reference} --sign + --unit um \
             --at Y250,Z200 --tool 60 --material 20C -o line_m"
        );
        shop.run(all.split_whitespace()).exits(0);
        assert!(shop.text("line_m.toml").contains(free), "{component} {reference}: {}", shop.text("line_m.toml"));
        // A positioning has no reference of a straightness.
        let positioning = all.replace("--component EYX", "--component EXX").replace("-o line_m", "-o line_x");
        shop.run(positioning.split_whitespace()).exits(4).says("E0618").says("--reference has no effect");
    }
}

#[test]
fn sections_of_a_laser_file_are_read_in_the_order_of_their_rows() {
    let mut noise = Noise(17);
    let mut text =
        "HEADER::\r\nFile Type: RTL\r\nAxis: X\r\nTARGET DATA::\r\nTarget-count: 13\r\nTargets :\r\n".to_owned();
    for k in 0..13 {
        let _ = write!(text, "  {:.3}", 50.0 * f64::from(k));
    }
    text.push_str("\r\nRUNS::\r\nRun-count: 4\r\nDEVIATIONS::\r\nRun Target Data:\r\n");
    for run in 1..=4 {
        for k in 0..13 {
            let target = if run % 2 == 1 { k } else { 12 - k };
            let sense = if run % 2 == 1 { 1.0 } else { -1.0 };
            let _ = write!(
                text,
                "  {run}  {}  {:.5}\r\n",
                target + 1,
                deviation(50.0 * f64::from(target), sense, &mut noise) / 1000.0
            );
        }
    }
    text.push_str("EOF::\r\n");
    let cut = text.replace("EOF::\r\n", "");
    let shop = shop().file("laser.rtl", text).file("cut.rtl", cut);
    // Neither sign nor unit is in the file.
    import(&shop, "laser.rtl", "tool.toml", &["--at", "Y200,Z100", "--tool", "0", "--material", "20C"])
        .exits(4)
        .says("give --unit")
        .says("give --sign");
    let more = ["--at", "Y200,Z100", "--tool", "0", "--material", "20C", "--sign", "+", "--unit", "mm"];
    import(&shop, "laser.rtl", "tool.toml", &more).exits(0);
    demand(&calibrated(&shop, "tool.toml", "EXX1,EXXb"), &[("EXX1", 40.0), ("EXXb", 3.0)], 0.05);
    import(&shop, "cut.rtl", "tool.toml", &more).exits(4).says("error[E0618]").says("no end mark");
}

#[test]
fn height_maps_of_a_flat_give_straightness() {
    // The tool is too high by 40 µm per (200 mm)² of x: the axis stops lower there.
    let height = |x: f64| -1e-6 * x * x;
    let mut noise = Noise(29);
    let mut linuxcnc = String::new();
    let mut grbl = String::new();
    let mut rows = Vec::new();
    for j in 0..4 {
        let mut row = Vec::new();
        for i in 0..9 {
            let (x, y) = (25.0 * f64::from(i), 50.0 * f64::from(j));
            let z = height(x) + noise.next(0.0005);
            let _ = writeln!(linuxcnc, "{x:.6} {y:.6} {z:.6} 0.000000 0.000000 0.000000 0.000000 0.000000 0.000000");
            let _ = writeln!(grbl, "[PRB:{x:.4},{y:.4},{z:.4}:1]\nok");
            row.push(format!("{z:.6}"));
        }
        rows.push(format!("#*# \t  {}\n", row.join(", ")));
    }
    let klipper = format!(
        "[printer]\nkinematics = cartesian\n#*# <---- SAVE_CONFIG ---->\n#*# [bed_mesh default]\n#*# version = 1\n#*# points =\n{}#*# x_count = 9\n#*# y_count = 4\n#*# min_x = 0.0\n#*# max_x = 200.0\n#*# min_y = 0.0\n#*# max_y = 150.0\n",
        rows.concat()
    );
    let shop = shop().file("probe.txt", linuxcnc).file("console.log", grbl).file("printer.cfg", klipper);
    for (file, has_unit) in [("probe.txt", false), ("console.log", false), ("printer.cfg", true)] {
        let mut more = vec!["--at", "X100,Y100,Z50", "--tool", "0"];
        if !has_unit {
            more.extend(["--unit", "mm"]);
        }
        import(&shop, file, "tool.toml", &more).exits(4).says("error[E0616]").says("calibrated flat");
        more.push("--flat-reference");
        import(&shop, file, "tool.toml", &more).exits(0);
        // x of the map is X − 100: the coefficient of degree 2 does not depend on that. 1e-6 per mm is 1000 µm/m².
        demand(&calibrated(&shop, "tool.toml", "EZX2"), &[("EZX2", 1000.0)], 1.0);
    }
}

#[test]
fn a_list_of_displacements_gives_squareness() {
    let mut noise = Noise(31);
    let mut text = "X;Y;Z;dx [µm];dy [µm];dz [µm];remark\n".to_owned();
    for k in 0..24 {
        let (x, y) = (100.0 * f64::from(k % 6), 100.0 * f64::from(k / 6));
        // EC0Y of 100 µrad opens the angle: dx = −10 µm at Y 100.
        let values = [-0.1 * y + noise.next(0.5), noise.next(0.5), noise.next(0.5)];
        let _ = writeln!(text, "{x};{y};100;{:.2};{:.2};{:.2};ok", values[0], values[1], values[2]);
    }
    let shop = shop().file("rtest.csv", text);
    import(&shop, "rtest.csv", "tool.toml", &["--tool", "100"]).exits(4).says("give --sign");
    import(&shop, "rtest.csv", "tool.toml", &["--tool", "100", "--sign", "+"])
        .exits(0)
        .says("columns that are not read: remark");
    demand(&calibrated(&shop, "tool.toml", "EC0Y"), &[("EC0Y", 100.0)], 0.1);
}

#[test]
fn touches_of_a_ball_give_the_place_of_a_rotary_axis() {
    let machine = TOOL_SIDE
        .replace("wFXYZSt", "wCFXYZSt")
        .replace("[spindle]", "[axis.C]\ndirection = [0, 0, 1]\npoint_mm = [300, 200, 0]\nmodulo = true\n[spindle]");
    let mut noise = Noise(37);
    let mut text = "ball;X;Y;Z;C\n".to_owned();
    for k in 0..8 {
        let c = 45.0 * f64::from(k);
        let (sin, cos) = c.to_radians().sin_cos();
        // The axis is 20 µm too far in +X and 15 µm in −Y; the ball is 100 mm beside it.
        let center = [300.020 + 100.0 * cos, 199.985 + 100.0 * sin, 50.0];
        for direction in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]] {
            let touch: Vec<f64> = (0..3).map(|i| center[i] + (12.5 + noise.next(0.0005)) * direction[i]).collect();
            let _ = writeln!(text, "b1;{:.5};{:.5};{:.5};{c}", touch[0], touch[1], touch[2]);
        }
    }
    let missing = text.lines().take(4).collect::<Vec<_>>().join("\n");
    let shop = shop().file("rotary.toml", machine).file("balls.csv", text).file("few.csv", missing);
    let more = ["--unit", "mm", "--tool", "0", "--as", "ball-touches"];
    import(&shop, "balls.csv", "rotary.toml", &more).exits(0).says("a touch scatters by");
    demand(&calibrated(&shop, "rotary.toml", "EX0C,EY0C"), &[("EX0C", 20.0), ("EY0C", -15.0)], 0.2);
    import(&shop, "few.csv", "rotary.toml", &more).exits(4).says("has 3 touches");
}

#[test]
fn a_report_in_blocks_and_a_printed_mesh_are_read() {
    let mut report = String::new();
    for (k, (nominal, actual)) in plate(&mut Noise(41)).iter().enumerate() {
        let _ = writeln!(
            report,
            "DIM LOC{k}= LOCATION OF CIRCLE CIR{k}  UNITS=MM\nAX    NOMINAL   MEAS   +TOL  -TOL   DEV  OUTTOL"
        );
        for (i, letter) in ["X", "Y"].iter().enumerate() {
            let _ = writeln!(
                report,
                "{letter}  {:.4} {:.4} 0.1 0.1 {:.4} 0.0",
                nominal[i],
                actual[i],
                actual[i] - nominal[i]
            );
        }
        let _ = writeln!(report, "D  8.0 8.0021 0.1 0.1 0.0021 0.0");
    }
    let mut mesh = "Recv: Bilinear Leveling Grid:\nRecv:       0      1      2      3      4\n".to_owned();
    let mut noise = Noise(43);
    for j in 0..4 {
        let row: Vec<String> =
            (0..5).map(|i| format!("{:+.4}", -1e-6 * (50.0 * f64::from(i)).powi(2) + noise.next(0.0005))).collect();
        let _ = writeln!(mesh, "Recv:  {j} {}", row.join(" "));
    }
    mesh.push_str("Recv: \nRecv: Subdivided with CATMULL ROM Leveling Grid:\nRecv:  0 1\nRecv:  0 +0.5 +0.5\n");
    let shop = shop().file("report.txt", report).file("mesh.log", mesh);
    import(&shop, "report.txt", "tool.toml", PLATE).exits(0).says("9 rows that are no coordinate");
    demand(&calibrated(&shop, "tool.toml", "EXX1,EYY1,EC0Y"), &[("EXX1", 40.0), ("EYY1", -15.0), ("EC0Y", 80.0)], 0.3);
    let place = ["--at", "X100,Y100,Z50", "--tool", "0", "--flat-reference"];
    import(&shop, "mesh.log", "tool.toml", &place).exits(4).says("indices, not positions");
    let more: Vec<&str> = place.iter().copied().chain(["--columns", "0,0,50,50"]).collect();
    import(&shop, "mesh.log", "tool.toml", &more).exits(0);
    demand(&calibrated(&shop, "tool.toml", "EZX2"), &[("EZX2", 1000.0)], 1.0);
}

#[test]
fn what_the_file_leaves_open_is_asked_with_its_option() {
    let text = wide("Target;1+;1-;2+;2-;3+;3-\n", ";", ",");
    let shop = shop().file("laser.csv", &text);
    let run = import(&shop, "laser.csv", "tool.toml", &["--axis", "X"]).exits(4);
    for option in ["--unit", "--sign", "--at", "--tool", "--material"] {
        assert!(run.stderr.contains(&format!("give {option}")), "{option}: {}", run.stderr);
    }
    assert!(run.stderr.contains("error[E0616]") && run.stderr.contains("nothing was written"), "{}", run.stderr);
    assert!(!shop.names().iter().any(|name| name.starts_with("out")), "{:?}", shop.names());
    // Without a machine file nothing is assumed.
    shop.run(["import", "laser.csv", "-o", "out"]).exits(4).says("give --machine M.toml");
    // Runs without a direction.
    let blind = shop.file("blind.csv", text.replace("1+;1-;2+;2-;3+;3-", "1;2;3;4;5;6"));
    import(&blind, "blind.csv", "tool.toml", LASER).exits(4).says("give --columns");
    let columns: Vec<&str> = LASER.iter().copied().chain(["--columns", "target,1+,1-,2+,2-,3+,3-"]).collect();
    import(&blind, "blind.csv", "tool.toml", &columns).exits(0);
}

/// A file that says nothing beyond its numbers: one round of questions, and the answers to them are all that is needed.
#[test]
fn all_questions_come_in_one_round() {
    let asked = |run: &Run| {
        let options =
            ["axis", "columns", "component", "sign", "unit", "at", "tool", "material", "plane", "radius", "machine"];
        let is_asked = |name: &&str| run.stderr.contains(&format!("give --{name}"));
        options.into_iter().filter(is_asked).collect::<Vec<_>>()
    };
    let text = wide("Target;1+;1-;2+;2-;3+;3-\n", ";", ",");
    let shop = shop().file("laser.csv", &text).file("blind.csv", text.replace("1+;1-;2+;2-;3+;3-", "1;2;3;4;5;6"));
    let all = ["axis", "sign", "unit", "at", "tool", "material"];
    assert_eq!(asked(&import(&shop, "laser.csv", "tool.toml", &[]).exits(4)), all);
    let answers =
        ["--axis", "X", "--sign", "+", "--unit", "um", "--at", "Y200,Z100", "--tool", "120", "--material", "20C"];
    import(&shop, "laser.csv", "tool.toml", &answers).exits(0);
    // Also where the directions of the runs are open.
    let columns = ["axis", "columns", "sign", "unit", "at", "tool", "material"];
    assert_eq!(asked(&import(&shop, "blind.csv", "tool.toml", &[]).exits(4)), columns);
    // What is answered is not asked again.
    assert_eq!(asked(&import(&shop, "laser.csv", "tool.toml", &answers[..6]).exits(4)), ["at", "tool", "material"]);
    // Without a machine file, this is one more question, not another round.
    let run = shop.run(["import", "laser.csv", "-o", "out"]).exits(4);
    assert_eq!(asked(&run), [&all[..], &["machine"]].concat(), "{}", run.stderr);
    // A table with headings that say nothing.
    let shop = shop.file("mute.csv", text.replace("Target;1+;1-;2+;2-;3+;3-", "pp;qq;rr;ss;tt;kk;ll"));
    let run = import(&shop, "mute.csv", "tool.toml", &["--as", "targets"]).exits(4);
    assert_eq!(asked(&run), columns, "{}", run.stderr);
}

#[test]
fn files_that_contradict_themselves_are_refused() {
    let text = wide("Target [mm];1+;1-;2+;2-;3+;3-\n", ";", ",");
    let swap =
        |unit: &'static str| LASER.iter().map(|&word| if word == "um" { unit } else { word }).collect::<Vec<_>>();
    let marked = text.replacen("Target [mm];1+", "Deviation unit;µm\nTarget [mm];1+", 1);
    let missing = text.replacen("\n100,0;", "\n100,0", 1);
    let shop = shop()
        .file("laser.csv", &text)
        .file("marked.csv", marked)
        .file("missing.csv", missing)
        .file("unmarked.csv", text.replace("Target [mm]", "Target"))
        .file("outside.csv", text.replace("\n600,0;", "\n6000,0;"))
        .file("plate.csv", "hole;nom x;nom y;act x;act y;dev x\nA;0;0;0,011;0,002;0,011\nB;300;0;300,012;0,003;0,5\nC;0;200;0,01;200,02;0,01\n")
        .file("exact.csv", "target;actual;deviation\n0;0.001;0.001\n100;100.003;0.004\n200;200.1;0.1\n");
    // Micrometers taken for millimeters are meters of error.
    import(&shop, "laser.csv", "tool.toml", &swap("mm")).exits(4).says("error[E0608]").says("check --unit");
    import(&shop, "laser.csv", "tool.toml", &swap("arcsec")).exits(4).says("is an angle");
    import(&shop, "marked.csv", "tool.toml", &swap("mm")).exits(4).says("error[E0618]").says("contradicts the file");
    import(&shop, "missing.csv", "tool.toml", LASER).exits(4).says("error[E0601]").says("cells");
    import(&shop, "outside.csv", "tool.toml", LASER).exits(4).says("error[E0618]").says("outside of the travel");
    let more: Vec<&str> = PLATE.iter().copied().chain(["--unit", "mm"]).collect();
    import(&shop, "plate.csv", "tool.toml", &more).exits(4).says("error[E0618]").says("not actual minus nominal");
    let columns: Vec<&str> = LASER.iter().copied().chain(["--columns", "1+,target,1-,2+,2-,3+,3-"]).collect();
    import(&shop, "laser.csv", "tool.toml", &columns).exits(4);
    import(&shop, "laser.csv", "tool.toml", &["--axis", "A", "--at", "Y200,Z100"]).exits(4).says("no axis A");
    let more = ["--axis", "X", "--at", "Y200,Z100", "--tool", "0", "--material", "20C", "--unit", "mm"];
    import(&shop, "exact.csv", "tool.toml", &more).exits(4).says("error[E0618]").says("actual and target position");
    // Inches of readings say nothing about the unit of the targets.
    import(&shop, "unmarked.csv", "tool.toml", &swap("inch")).exits(4).says("error[E0616]").says("unit of the targets");
    assert!(!shop.names().iter().any(|name| name.starts_with("out.")), "{:?}", shop.names());
}

#[test]
fn files_without_a_layout_are_refused_with_the_export_to_use() {
    let shop = shop()
        .file("letter.txt", "Dear customer,\nthe machine is fine.\n")
        .file("test.b5r", [0u8, 1, 2, 3])
        .file("book.xlsx", b"PK\x03\x04rest".as_slice());
    import(&shop, "letter.txt", "tool.toml", &[]).exits(4).says("error[E0617]").says("import --list");
    import(&shop, "test.b5r", "tool.toml", &[]).exits(4).says("error[E0617]").says("ball-bar software");
    // An archive that is no workbook.
    import(&shop, "book.xlsx", "tool.toml", &[]).exits(4).says("error[E0617]").says("as CSV");
    import(&shop, "letter.txt", "tool.toml", &["--as", "nothing"]).exits(4).says("'nothing' is not a format");
}

#[test]
fn existing_files_stay_without_force() {
    let shop = shop().file("laser.csv", wide("Target;1+;1-;2+;2-;3+;3-\n", ";", ",")).file("mine.toml", "mine");
    let mut words = vec!["import", "laser.csv", "--machine", "tool.toml", "-o", "mine"];
    words.extend(LASER);
    shop.run(words).exits(2).says("mine.toml exists");
    assert_eq!(shop.text("mine.toml"), "mine");
    assert!(!shop.names().contains(&"mine.csv".to_owned()));
}

#[test]
fn every_format_is_listed_and_explained() {
    let list = shop().run(["import", "--list"]).exits(0).stdout;
    let docs = std::fs::read_to_string(repository("docs/reference/instrument-files.md")).unwrap();
    for format in ncfix_instruments::format::FORMATS {
        assert!(list.contains(format.title), "{}", format.name);
        assert_eq!(
            docs.lines().filter(|line| line.starts_with(&format!("| `{}` |", format.name))).count(),
            1,
            "{}",
            format.name
        );
    }
}

#[test]
fn damaged_files_never_end_in_a_panic() {
    use ncfix_instruments::answers::ImportAnswers;
    use ncfix_instruments::format::InstrumentFormats;
    use ncfix_instruments::text::DecodedText;
    let machine = crate::model::read(ncfix_machine::machine::file::DEMO).0;
    let formats = InstrumentFormats::default();
    let mut answers = ImportAnswers { is_flat_reference: true, ..ImportAnswers::default() };
    for (option, text) in [
        ("axis", "X"),
        ("at", "X0,Y0,Z0"),
        ("sign", "+"),
        ("tool", "0"),
        ("material", "20C"),
        ("plane", "XY"),
        ("radius", "150"),
        ("turn", "ccw"),
    ] {
        answers.set(option, text).unwrap();
    }
    let seeds = [
        wide("Target;1+;1-;2+;2-;3+;3-\n", ";", ","),
        "HEADER::\nTargets :\n 0 100\nDEVIATIONS::\n 1 1 0.1\n 1 2 0.2\nEOF::\n".to_owned(),
        "F(A)=FEAT/POINT,CART,1,2,3\nFA(A)=FEAT/POINT,CART,1,2,3\n".to_owned(),
        "#*# [bed_mesh a]\n#*# points =\n#*# 1, 2\n#*# 1, 2\n#*# x_count = 2\n#*# y_count = 2\n".to_owned(),
        "plane;XY\nangle;dev\n0;1\n90;2\n".to_owned(),
        "plane;XY\nangle;ccw1;ccw2\n0;1;2\n90;2;3\n180;2;3\n".to_owned(),
        "0 0 0\n1 1 1\n2 2 2\n".to_owned(),
    ];
    let mut noise = Noise(23);
    let mut pick = |most: usize| (noise.next(1.0).abs() * 1e6) as usize % most.max(1);
    for round in 0..3000 {
        let mut bytes = seeds[round % seeds.len()].clone().into_bytes();
        for _ in 0..pick(6) {
            let at = pick(bytes.len());
            match pick(3) {
                0 => bytes.truncate(at),
                1 => bytes.insert(at, pick(256) as u8),
                _ if at < bytes.len() => bytes[at] = pick(256) as u8,
                _ => {}
            }
        }
        let Ok(text) = DecodedText::decode("a.csv", bytes) else { continue };
        for format in
            [None, Some(ncfix_instruments::format::FORMATS[round % ncfix_instruments::format::FORMATS.len()].name)]
        {
            if let Ok(ncfix_instruments::ImportOutcome::Readings(readings)) =
                ncfix_instruments::import(&text, format, &answers, &machine, &formats)
            {
                let _ = (readings.table(), readings.description("a.csv"));
            }
        }
    }
}
