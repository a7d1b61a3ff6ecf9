//! From the machine to the reviewed program with at most five commands and without a file written by hand: five people and their own files. A file that
//! a control or an instrument saves is made here by own arithmetic from a known error.

use std::fmt::Write as _;

use crate::support::Shop;

/// Most commands of a person.
const MOST_COMMANDS: usize = 5;

/// A person's folder, with the number of commands so far.
struct Person {
    shop: Shop,
    commands: usize,
}

impl Person {
    fn with(files: &[(&str, String)]) -> Person {
        let shop = files.iter().fold(Shop::new(), |shop, (name, text)| shop.file(name, text));
        Person { shop, commands: 0 }
    }

    /// Runs the words of a line.
    #[track_caller]
    fn runs(&mut self, line: &str) {
        self.commands += 1;
        assert!(self.commands <= MOST_COMMANDS, "{line}");
        self.shop.run(line.split_whitespace()).exits(0);
    }

    /// Values of the fitted parameters of the calibration that a line makes.
    #[track_caller]
    fn calibrates(&mut self, line: &str) -> Vec<(String, f64)> {
        self.commands += 1;
        assert!(self.commands <= MOST_COMMANDS, "{line}");
        let json = self.shop.run(line.split_whitespace().chain(["--json"])).exits(0).json();
        let rows = json["parameters"].as_array().unwrap().iter();
        rows.map(|row| (row["name"].as_str().unwrap().to_owned(), row["value"].as_f64().unwrap())).collect()
    }

    /// Corrects with a review page, and returns the largest errors before and after, µm.
    #[track_caller]
    fn corrects(&mut self, line: &str, page: &str) -> [f64; 2] {
        self.commands += 1;
        assert!(self.commands <= MOST_COMMANDS, "{line}");
        let json = self.shop.run(line.split_whitespace().chain(["--review", page, "--json"])).exits(0).json();
        assert!(self.shop.text(page).starts_with("<!"), "the review");
        ["before", "after"].map(|key| json[key]["max_um"].as_f64().unwrap_or_else(|| panic!("{json}")))
    }
}

#[track_caller]
fn near(found: &[(String, f64)], name: &str, expected: f64, by: f64) {
    let value = found.iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("{name}: {found:?}")).1;
    assert!((value - expected).abs() <= by, "{name}: {value}, expected {expected}");
}

/// A square of 200 mm in the language of Sinumerik, Fanuc and RS274.
fn square(dialect: &str) -> String {
    let path = "G0 X0. Y0.\nZ5.\nG1 Z-1. F300\nX200. F1000\nY200.\nX0.\nY0.\nG0 Z50.\n";
    match dialect {
        "sinumerik" => format!("T1 M6\nD1\nG54 G90 G17 G71 G94\n{path}M30\n"),
        "fanuc" => format!("%\nO1\nG21 G90 G17 G94 G54\nT1 M6\nG43 H1 Z50.\n{path}M30\n%\n"),
        _ => format!("G21 G90 G17 G94 G54\nT1 M6\nG43 H1\n{path}M2\n"),
    }
}

/// The offsets and tools that a Sinumerik saves.
fn sinumerik_data(zero: [f64; 3], length: f64) -> [(&'static str, String); 2] {
    let [x, y, z] = zero;
    [
        ("UFR.INI", format!("%_N_CH_UFR_INI\n$P_UIFR[1,X,TR]={x}\n$P_UIFR[1,Y,TR]={y}\n$P_UIFR[1,Z,TR]={z}\nM17\n")),
        ("TOA.INI", format!("%_N_TO_TOA_INI\n$TC_DP1[1,1]=120\n$TC_DP3[1,1]={length}\n$TC_DP6[1,1]=5\nM17\n")),
    ]
}

/// A trunnion machine and a ball-bar: X and Y lean by 80 µrad towards each other, so dr = −R γ/2 sin 2θ with γ = +80 µrad, 6 µm at R 150.
#[test]
fn a_process_engineer_with_five_axes_and_a_ball_bar() {
    let mut bar = "plane;XY\nradius_mm;150\nfeed_mm_min;1000\nrun;angle_deg;dev_um\n".to_owned();
    for run in 1..=2 {
        for k in 0..72 {
            let deg = 5.0 * f64::from(k);
            let _ = writeln!(bar, "{run};{deg};{:.3}", -150.0 * 80e-6 / 2.0 * (2.0 * deg).to_radians().sin() * 1e3);
        }
    }
    let mut files = vec![("bar.csv", bar), ("part.mpf", square("sinumerik"))];
    files.extend(sinumerik_data([50.0, 60.0, 20.0], 100.0));
    let mut person = Person::with(&files);
    person.runs(
        "machine new five.toml --like trunnion-ac --control 840d --travel X=-300..600 --travel Y=-300..600 --travel Z=-200..500 \
         --sense A=- --sense C=- --pivot A=300,-210,-480 --pivot C=310,-198,-440 --setup UFR.INI --setup TOA.INI",
    );
    person
        .runs("import bar.csv --machine five.toml --unit um --turn ccw --at X150,Y150,Z100,A0,C0 --tool 100 -o circle");
    let found = person.calibrates("calibrate circle.csv --machine five.toml -o mill.toml");
    // The squareness is the angle between both axes: EC0Y − EC0X, whichever of them is stated.
    let of = |name: &str| found.iter().find(|(own, _)| own == name).map_or(0.0, |(_, value)| *value);
    assert!((of("EC0Y") - of("EC0X") - 80.0).abs() < 0.5, "{found:?}");
    // Nothing else is wrong, and a bar of unknown length shows no scale of Y beside that of X.
    near(&found, "EXX1", 0.0, 0.5);
    assert!(!found.iter().any(|(name, _)| name == "EYY1"), "{found:?}");
    let [before, after] =
        person.corrects("fix part.mpf -o out.mpf --machine mill.toml --zero G54=absolute", "page.html");
    // At least γ · 200 mm = 16 µm of the square, and nothing of it is left.
    assert!(before > 15.0 && after < 1.1, "{before} {after}");
    person.runs("verify part.mpf out.mpf --machine mill.toml --zero G54=absolute");
}

/// A table of a laser over 11 targets: `slope` µm/m, a reversal value of `play` µm, and runs that scatter by tenths of a micrometer, each in its own way.
fn laser_table(axis: char, [first, step]: [f64; 2], slope: f64, play: f64) -> String {
    let mut text = format!(
        "Achse;{axis}\nZielposition [mm];1 hin [µm];1 rück [µm];2 hin [µm];2 rück [µm];3 hin [µm];3 rück [µm]\n"
    );
    let cell = |value: f64| format!("{value:.2}").replace('.', ",");
    for k in 0..11 {
        let at = first + step * f64::from(k);
        text += &cell(at);
        for run in 0..3 {
            let value = slope * 1e-3 * at + 0.1 * f64::from((7 * k + 3 * run) % 5 - 2);
            text += &format!(";{};{}", cell(value + play / 2.0), cell(value - play / 2.0));
        }
        text.push('\n');
    }
    text
}

/// A cross table, and a folder with the tables of a laser on X, Y and Z, a certificate and a picture.
#[test]
fn a_metrologist_with_a_folder_of_laser_tables() {
    let mut person = Person::with(&[
        ("exports/laser_X.csv", laser_table('X', [0.0, 50.0], 40.0, 6.0)),
        ("exports/laser_Y.csv", laser_table('Y', [0.0, 40.0], -25.0, 4.0)),
        ("exports/laser_Z.csv", laser_table('Z', [-400.0, 40.0], 15.0, 2.0)),
        ("exports/certificate.pdf", "%PDF-1.7 certificate\n".into()),
        ("exports/setup.png", "\u{89}PNG picture\n".into()),
        ("part.nc", square("fanuc")),
        ("OFFSETS.NC", "%\nG21\nG10 L2 P1 X100. Y80. Z-300.\nG10 L10 P1 R100.\nM30\n%\n".into()),
    ]);
    person.runs(
        "machine new mill.toml --like vmc --control fanuc --travel X=0..600 --travel Y=0..400 --travel Z=-500..0 --setup OFFSETS.NC",
    );
    person.runs(
        "import exports --machine mill.toml --sign + --tool 0 --material 20C --at laser_X=Y100,Z-200 --at laser_Y=X300,Z-200 \
         --at laser_Z=X300,Y200 -o measured",
    );
    let found = person.calibrates("calibrate measured --machine mill.toml -o fitted.toml");
    // X and Y are under the table: the body goes the other way than the tool on the workpiece.
    for (name, expected) in [("EXX1", -40.0), ("EYY1", 25.0), ("EZZ1", 15.0)] {
        near(&found, name, expected, 1.5);
    }
    for (name, half) in [("EXXb", -3.0), ("EYYb", -2.0), ("EZZb", 1.0)] {
        near(&found, name, half, 0.2);
    }
    let [before, after] =
        person.corrects("fix part.nc -o out.nc --machine fitted.toml --zero G54=absolute", "page.html");
    // Until an axis has moved once, its position within the backlash is unknown: at most half of each reversal value, √(3² + 2² + 1²) µm.
    assert!(before > 10.0 && after < 3.8, "{before} {after}");
    person.runs("verify part.nc out.nc --machine fitted.toml --zero G54=absolute");
}

/// A router with Grbl and a square with a dial gauge: over the leg of 300 mm the gauge is pressed in by 0.15 mm, so the axes lean by 0.5 mrad.
#[test]
fn a_hobbyist_with_a_square_and_a_dial_gauge() {
    let mut person = Person::with(&[
        (
            "settings.txt",
            "$3=0\n$13=0\n$22=0\n$110=5000.000\n$111=5000.000\n$112=600.000\n$130=600.000\n$131=900.000\n$132=80.000\n"
                .into(),
        ),
        (
            "offsets.txt",
            "[G54:100.000,100.000,-60.000]\n[G28:0.000,0.000,0.000]\n[G92:0.000,0.000,0.000]\n[TLO:0.000]\nok\n".into(),
        ),
        ("part.ngc", "G21 G90 G17 G94 G54\nG0 X0 Y0\nZ5\nG1 Z-1 F300\nX200 F1000\nY200\nX0\nY0\nG0 Z10\nM2\n".into()),
    ]);
    person.runs(
        "machine new router.toml --like router --control grbl --from settings.txt --travel X=0..600 --travel Y=0..900 --travel Z=-80..0 --setup offsets.txt",
    );
    person.runs("square --machine router.toml --square 300 --dial 0.15 -o fitted.toml");
    let [before, after] =
        person.corrects("fix part.ngc -o out.ngc --machine fitted.toml --max-correction 1mm", "page.html");
    // 0.5 mrad over 200 mm.
    assert!((before - 100.0).abs() < 5.0 && after < 1.5, "{before} {after}");
}

/// A rotary table and a probe: five touches of a ball at eight angles; the axis is 20 µm too far in +X and 15 µm in −Y.
#[test]
fn a_researcher_with_a_probe() {
    let mut balls = "ball;X;Y;Z;C\n".to_owned();
    let mut seed = 37_u64;
    for k in 0..8 {
        let c = 45.0 * f64::from(k);
        // The table turns against the right-hand rule.
        let (sin, cos) = (-c).to_radians().sin_cos();
        let center = [300.020 + 100.0 * cos, 199.985 + 100.0 * sin, 150.0];
        for direction in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]] {
            // A probe scatters by half a micrometer: uniform, of a known sequence.
            let mut scatter = || {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                ((seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 0.0005 * 12_f64.sqrt()
            };
            let touch: Vec<f64> = (0..3).map(|i| center[i] + 12.5 * direction[i] + scatter()).collect();
            let _ = writeln!(balls, "b1;{:.4};{:.4};{:.4};{c}", touch[0], touch[1], touch[2]);
        }
    }
    let program = "T1 M6\nD1\nG54 G90 G17 G71 G94\nG0 C0\nG0 X0 Y0 Z50\nG1 Z0 F300\nX50 F1000\nC90\nX0\nG0 Z50\nM30\n";
    let mut files = vec![("balls.csv", balls), ("part.mpf", program.to_owned())];
    files.extend(sinumerik_data([300.0, 200.0, 150.0], 100.0));
    let mut person = Person::with(&files);
    person.runs(
        "machine new table.toml --like trunnion-ac --control sinumerik --travel X=0..600 --travel Y=-100..500 --travel Z=-100..400 \
         --sense A=- --sense C=- --pivot A=300,200,40 --pivot C=300,200,40 --setup UFR.INI --setup TOA.INI",
    );
    person.runs("import balls.csv --machine table.toml --unit mm --tool 0 --at A0 --as ball-touches -o place");
    let found = person.calibrates("calibrate place.csv --machine table.toml -o fitted.toml");
    // A stood still: its offsets are not separable from those of C, which comes first. The tilts of C are fitted too, so the offsets are less certain.
    near(&found, "EX0C", 20.0, 3.0);
    near(&found, "EY0C", -15.0, 3.0);
    assert!(!found.iter().any(|(name, _)| name == "EY0A"), "{found:?}");
    let [before, after] =
        person.corrects("fix part.mpf -o out.mpf --machine fitted.toml --zero G54=absolute", "page.html");
    assert!(before > 15.0 && after < 1.5, "{before} {after}");
    person.runs("verify part.mpf out.mpf --machine fitted.toml --zero G54=absolute");
}

/// Nearly normal noise of a standard deviation: the sum of twelve uniform numbers has a variance of 1.
fn noise(seed: &mut u64, sigma: f64) -> f64 {
    let mut sum = -6.0;
    for _ in 0..12 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (*seed >> 11) as f64 / (1_u64 << 53) as f64;
    }
    sigma * sum
}

/// A grid plate of 11 by 11 points, read back and forth: X is too long by 10 µm/m and by 40 µm/m² of Y², Y is too short by 6 µm/m, and readings scatter by
/// 0.4 µm.
fn grid_plate(seed: u64) -> String {
    let mut grid = "X [mm],Y [mm],Z [mm],dx [um],dy [um]\n".to_owned();
    let mut seed = seed;
    for row in 0..11 {
        for column in 0..11 {
            let x = 50.0 + 70.0 * f64::from(if row % 2 == 0 { column } else { 10 - column });
            let y = 20.0 + 46.0 * f64::from(row);
            let dx = 0.010 * x + 40.0 * (y / 1e3).powi(2) + noise(&mut seed, 0.4);
            let dy = -0.006 * y + noise(&mut seed, 0.4);
            let _ = writeln!(grid, "{x},{y},-200,{dx:.3},{dy:.3}");
        }
    }
    grid
}

/// A grid plate, and a term that no preset has: the guideway of X turns with Y².
#[test]
fn a_researcher_with_a_new_error_term() {
    let mut files = vec![("grid.csv", grid_plate(11)), ("part.mpf", square("sinumerik"))];
    files.extend(sinumerik_data([100.0, 100.0, -300.0], 100.0));
    let mut person = Person::with(&files);
    person.runs(
        "machine new lab.toml --like vmc --control 840d --travel X=0..800 --travel Y=0..500 --travel Z=-500..0 --setup UFR.INI --setup TOA.INI",
    );
    person.runs("import grid.csv --machine lab.toml --sign + --tool 0 -o plate");
    person.commands += 1;
    let line = ["calibrate", "plate.csv", "--machine", "lab.toml", "--model", "auto,EXX ~ Y^2", "-o", "fitted.toml"];
    let json = person.shop.run(line.into_iter().chain(["--json"])).exits(0).json();
    // X moves the workpiece: the body goes the other way.
    let [value, sigma] = ["value", "sigma"].map(|key| json["terms"][0][key].as_f64().unwrap());
    assert!((value + 40.0).abs() < 4.0 * sigma, "{value} ± {sigma}");
    let [before, after] =
        person.corrects("fix part.mpf -o out.mpf --machine fitted.toml --zero G54=absolute", "page.html");
    assert!(before > 2.0 && after < 1.5, "{before} {after}");
    person.runs("verify part.mpf out.mpf --machine fitted.toml --zero G54=absolute");
}

/// The printed uncertainty of a stated term is the scatter of its amount in repeated measurements, as that of a parameter is. Least squares by hand: beside the
/// offset of dx, a slope in X and one in Y, 121 readings of 0.4 µm leave 2.0 µm/m² for Y².
#[test]
fn the_uncertainty_of_a_stated_term_is_its_scatter() {
    let machine = "machine new lab.toml --like vmc --travel X=0..800 --travel Y=0..500 --travel Z=-500..0";
    let shop = Person::with(&[]).shop;
    shop.run(machine.split_whitespace()).exits(0);
    let (mut values, mut sigmas) = (Vec::new(), Vec::new());
    for seed in 1..=12 {
        std::fs::write(shop.path("grid.csv"), grid_plate(1000 * seed)).unwrap();
        shop.run("import grid.csv --machine lab.toml --sign + --tool 0 -o plate --force".split_whitespace()).exits(0);
        let line = ["calibrate", "plate.csv", "--machine", "lab.toml", "--model", "EXX1,EYY1,EC0X,EXX ~ Y^2"];
        let json = shop.run(line.into_iter().chain(["-o", "fitted.toml", "--json"])).exits(0).json();
        values.push(json["terms"][0]["value"].as_f64().unwrap());
        sigmas.push(json["terms"][0]["sigma"].as_f64().unwrap());
    }
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    assert!((mean(&values) + 40.0).abs() < 2.5, "{values:?}");
    assert!((1.6..2.5).contains(&mean(&sigmas)), "{sigmas:?}");
}

/// A mill with LinuxCNC: its INI, variables and tools, and a square read along Y: X leans by 0.1 mm over 400 mm.
#[test]
fn a_dnc_operator_with_linuxcnc() {
    let ini = "[EMC]\nMACHINE = mill\n[TRAJ]\nLINEAR_UNITS = mm\nCOORDINATES = X Y Z\n[KINS]\nKINEMATICS = trivkins\nJOINTS = 3\n\
        [JOINT_0]\nTYPE = LINEAR\nMIN_LIMIT = 0\nMAX_LIMIT = 600\n[JOINT_1]\nTYPE = LINEAR\nMIN_LIMIT = 0\nMAX_LIMIT = 450\n\
        [JOINT_2]\nTYPE = LINEAR\nMIN_LIMIT = -300\nMAX_LIMIT = 0\n";
    let mut edge = "straightness of Y\nY [mm];dev [mm]\n".to_owned();
    for k in 0..9 {
        let y = 50.0 * f64::from(k);
        let _ = writeln!(edge, "{y};{:.4}", 0.00025 * y);
    }
    let mut variables = "5161\t0.000000\n5210\t0.000000\n5211\t0.000000\n5220\t1.000000\n".to_owned();
    variables += "5221\t100.000000\n5222\t80.000000\n5223\t-200.000000\n5230\t0.000000\n";
    let mut person = Person::with(&[
        ("mill.ini", ini.into()),
        ("edge.csv", edge),
        ("mill.var", variables),
        ("tool.tbl", "T1 P1 Z100 D10 ;mill\n".into()),
        ("part.ngc", square("rs274")),
    ]);
    person.runs("machine new mill.toml --like vmc --from mill.ini --setup mill.var --setup tool.tbl");
    person.runs("import edge.csv --machine mill.toml --axis Y --component EXY --reference square --sign + --unit mm --at X300,Z-100 --tool 0 -o edge_y");
    let found = person.calibrates("calibrate edge_y.csv --machine mill.toml -o fitted.toml");
    // A square is exact, so the slope is the squareness of X and Y: the tool is too far in +X at large Y.
    near(&found, "EC0X", 250.0, 1.0);
    let [before, after] = person.corrects(
        "fix part.ngc -o out.ngc --machine fitted.toml --zero G54=absolute --max-correction 1mm",
        "page.html",
    );
    assert!(before > 60.0 && after < 1.5, "{before} {after}");
    person.runs("verify part.ngc out.ngc --machine fitted.toml --zero G54=absolute");
}

/// A folder is the same as its measurements by name; a table without a description is named.
#[test]
fn a_folder_of_measurements_is_its_files() {
    let sample = |name: &str| crate::support::repository(&format!("samples/measurements/{name}"));
    let shop = Shop::new();
    std::fs::create_dir(shop.path("tests")).unwrap();
    for name in ["ball_bar.csv", "ball_bar.toml", "laser.csv", "laser.toml"] {
        std::fs::copy(sample(name), shop.path("tests").join(name)).unwrap();
    }
    std::fs::write(shop.path("tests/notes.csv"), "day,temperature\n1,20.5\n").unwrap();
    let machine = crate::support::machine("demo");
    let model = ["--machine", &machine, "--model", "EXX1,EXXb,EC0X"];
    let run = shop.run(["calibrate", "tests", "-o", "folder.toml"].into_iter().chain(model)).exits(0);
    assert!(run.stderr.contains("notes.csv"), "{}", run.stderr);
    let files = ["calibrate", "tests/ball_bar.csv", "tests/laser.csv", "-o", "files.toml"];
    let run = shop.run(files.into_iter().chain(model)).exits(0);
    assert!(!run.stderr.contains("notes.csv"), "{}", run.stderr);
    assert_eq!(shop.text("folder.toml"), shop.text("files.toml"));
    std::fs::create_dir(shop.path("empty")).unwrap();
    shop.run(["calibrate", "empty", "-o", "none.toml"].into_iter().chain(model)).exits(2).says("has no measurement");
    assert!(!shop.path("none.toml").exists());
}

/// Each command of the way prints the next one.
#[test]
fn every_command_states_the_next_one() {
    let files = [
        ("exports/laser_X.csv", laser_table('X', [0.0, 50.0], 40.0, 6.0)),
        ("part.nc", square("fanuc")),
        ("OFFSETS.NC", "%\nG21\nG10 L2 P1 X100. Y80. Z-300.\nG10 L10 P1 R100.\nM30\n%\n".into()),
    ];
    let shop = Person::with(&files).shop;
    let next = |line: &str, expected: &str| {
        let run = shop.run(line.split_whitespace()).exits(0);
        let row = run.stderr.lines().last().unwrap_or_default().to_owned();
        assert_eq!(row.trim_end(), format!("next         ncfix {expected}"), "{line}\n{}", run.stderr);
    };
    next(
        "machine new mill.toml --like vmc --control fanuc --travel X=0..600 --travel Y=0..400 --travel Z=-500..0 --setup OFFSETS.NC",
        "import FOLDER --machine mill.toml -o readings",
    );
    next(
        "machine new r.toml --like router --control grbl",
        "square --machine r.toml --d1 D1 --d2 D2 --sides A,B --nominal A,B --read-to 0.5 -o r_square.toml",
    );
    next(
        "import exports --machine mill.toml --sign + --tool 0 --material 20C --at Y100,Z-200 -o readings",
        "calibrate readings --machine mill.toml -o mill_measured.toml",
    );
    let fix = "fix PROGRAM --machine mill_measured.toml -o CORRECTED --review review.html";
    next("calibrate readings --machine mill.toml -o mill_measured.toml", fix);
    next("square --machine mill.toml --square 300 --dial 0.02 -o square.toml", &fix.replace("mill_measured", "square"));
    next(
        "fix part.nc --machine mill_measured.toml -o out.nc --zero G54=absolute",
        "verify part.nc out.nc --machine mill_measured.toml --zero G54=absolute",
    );
}

/// A mill of three axes, and a folder with the table of a laser.
fn mill_and_laser() -> Shop {
    let shop = Person::with(&[("exports/laser_X.csv", laser_table('X', [0.0, 50.0], 40.0, 6.0))]).shop;
    let line =
        "machine new mill.toml --like vmc --control fanuc --travel X=0..600 --travel Y=0..400 --travel Z=-500..0";
    shop.run(line.split_whitespace()).exits(0);
    shop
}

/// A folder is imported without the files that have no readings. A text of unknown layout gives exit status 1; a table with an open question stops all.
#[test]
fn a_folder_of_exports_names_each_file_that_it_did_not_read() {
    let shop = mill_and_laser();
    let write = |name: &str, text: &str| std::fs::write(shop.path(name), text).unwrap();
    write("exports/certificate.pdf", "%PDF-1.7 certificate\n");
    write("exports/readme.md", "Measured by the night shift.\n");
    let import = |output: &str| {
        let line =
            format!("import exports --machine mill.toml --sign + --tool 0 --material 20C --at Y100,Z-200 -o {output}");
        shop.run(line.split_whitespace())
    };
    let run = import("one").exits(0);
    for part in ["not read: exports/certificate.pdf", "not read: exports/readme.md", "wrote one/laser_X.csv"] {
        assert!(run.stderr.contains(part), "{part}: {}", run.stderr);
    }
    write("exports/shift.txt", "the laser was warm\n");
    import("two").exits(1).says("not read: exports/shift.txt");
    assert!(shop.path("two/laser_X.csv").exists());
    // Without its axis in the file, a table is a question, and nothing is written.
    write("exports/unknown.csv", &laser_table('X', [0.0, 50.0], 40.0, 6.0).replace("Achse;X\n", ""));
    import("three").exits(4).says("unknown.csv: ");
    assert!(!shop.path("three").exists());
    // An answer for a file that is not there is a mistake, not an answer for all.
    let line = "import exports --machine mill.toml --sign laser_Q=+ -o four";
    shop.run(line.split_whitespace()).exits(2).says("laser_Q");
}

/// The residual of each reading: reading minus model. Their root mean square is that of the result.
#[test]
fn residuals_are_a_table() {
    let shop = mill_and_laser();
    let line = "import exports/laser_X.csv --machine mill.toml --sign + --tool 0 --material 20C --at Y100,Z-200 -o x";
    shop.run(line.split_whitespace()).exits(0);
    let line =
        "calibrate x.csv --machine mill.toml --model EXX1,EXXb -o fitted.toml --residuals left.csv --no-robust --json";
    let json = shop.run(line.split_whitespace()).exits(0).json();
    let text = shop.text("left.csv");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| head.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}: {text}"));
    let numbers = ["line", "X_mm", "reading", "model", "residual", "weight"].map(column);
    let (mut squares, mut count) = (0.0, 0.0);
    for (number, line) in lines.enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let [at, x, reading, model, residual, weight] = numbers.map(|column| cells[column].parse::<f64>().unwrap());
        assert!(cells[column("value")] == "EXX" && cells[column("unit")] == "um", "{line}");
        // The heading is line 1.
        assert!((at - number as f64 - 2.0).abs() < 1e-9 && (0.0..=500.0).contains(&x), "{line}");
        assert!((reading - model - residual).abs() < 2e-4 && (weight - 1.0).abs() < 1e-9, "{line}");
        squares += residual * residual;
        count += 1.0;
    }
    assert!((count - 66.0_f64).abs() < 1e-9, "three runs in both directions at 11 targets: {count}");
    let stated = json["data"][0]["left_rms"].as_f64().unwrap_or_else(|| panic!("{json}"));
    assert!(((squares / count).sqrt() - stated).abs() < 1e-3, "{} {stated}", (squares / count).sqrt());
}

/// A table of a report in Markdown, with a direction of approach in each row.
#[test]
fn a_table_in_a_report_states_directions() {
    let shop = mill_and_laser();
    let rows = "# Report\n\nMachine: mill\n\n| X [mm] | Y [mm] | X_dir | dx [um] | dy [um] |\n|---|---:|:-:|---|---|\n\
        | 50 | 20 | + | -1.25 | 1.66 |\n| 120 | 20 | - | -1.01 | 1.98 |\n| 190 | 20 |  | -0.29 | 1.39 |\n";
    std::fs::write(shop.path("report.md"), rows).unwrap();
    let line = "import report.md --machine mill.toml --sign + --tool 0 --at Z-200 -o grid";
    shop.run(line.split_whitespace()).exits(0);
    let text = shop.text("grid.csv");
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}: {text}"));
    let cells: Vec<Vec<&str>> = text.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let of = |name: &str| cells.iter().map(|row| row[at(name)]).collect::<Vec<_>>();
    assert_eq!(of("X_dir"), ["1", "-1", ""]);
    assert_eq!(of("dx_um"), ["-1.25", "-1.01", "-0.29"]);
    std::fs::write(shop.path("wrong.md"), rows.replace("| - |", "| east |")).unwrap();
    shop.run("import wrong.md --machine mill.toml --sign + --tool 0 --at Z-200".split_whitespace())
        .exits(4)
        .says("east");
}

/// A plate that was clamped turned by 90°: X of the report is Y of the machine. The hole at X 200 of the part, which is 40 µm too far in X, was drilled 40 µm too
/// far in Y+ at Y 350.
#[test]
fn a_part_that_was_clamped_turned() {
    let report = "name,nom x,nom y,act x,act y\nH1,0,0,0.001,0\nH2,200,0,200.040,0.002\nH3,0,100,0.003,99.99\nH4,200,100,200.041,99.988\n";
    let shop = mill_and_laser().file("report.csv", report).file("laser.csv", laser_table('X', [0.0, 50.0], 40.0, 6.0));
    let words =
        "--machine mill.toml --sign + --unit mm --tool 0 --material 20C --at X250,Y150,Z-200 -o plate --turned 90";
    shop.run(["import", "report.csv"].into_iter().chain(words.split(' '))).exits(0);
    let text = shop.text("plate.csv");
    let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let at = |name: &str| head.iter().position(|own| *own == name).unwrap_or_else(|| panic!("{name}: {text}"));
    let row: Vec<&str> = text.lines().nth(2).unwrap().split(',').collect();
    let of = |name: &str| row[at(name)].parse::<f64>().unwrap();
    // x = 250 − 0, y = 150 + 200; dx = −2 µm, dy = +40 µm.
    for (name, expected) in [("X", 250.0), ("Y", 350.0), ("dx_um", -2.0), ("dy_um", 40.0)] {
        assert!((of(name) - expected).abs() < 1e-6, "{name}: {text}");
    }
    // Readings of the axes themselves have no turn.
    let words = "--machine mill.toml --sign + --tool 0 --material 20C --at Y150,Z-200 --turned 90";
    shop.run(["import", "laser.csv"].into_iter().chain(words.split(' '))).exits(4).says("E0618");
}
