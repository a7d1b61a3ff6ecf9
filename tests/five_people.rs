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
         --sense A=- --sense C=- --pivot A=300,-210,-480 --pivot C=310,-198,-440",
    );
    person
        .runs("import bar.csv --machine five.toml --unit um --turn ccw --at X150,Y150,Z100,A0,C0 --tool 100 -o circle");
    let found = person.calibrates("calibrate circle.csv --machine five.toml --model EC0Y -o mill.toml");
    near(&found, "EC0Y", 80.0, 0.5);
    let [before, after] = person.corrects(
        "fix part.mpf -o out.mpf --machine mill.toml --setup UFR.INI --setup TOA.INI --zero G54=absolute",
        "page.html",
    );
    // At least γ · 200 mm = 16 µm of the square, and nothing of it is left.
    assert!(before > 15.0 && after < 1.1, "{before} {after}");
    person.runs("verify part.mpf out.mpf --machine mill.toml --setup UFR.INI --setup TOA.INI --zero G54=absolute");
}

/// A cross table and a laser on X: 40 µm/m, and a reversal value of −6 µm.
#[test]
fn a_metrologist_with_a_laser() {
    let mut laser = "Achse;X\nZielposition [mm];1 hin [µm];1 rück [µm];2 hin [µm];2 rück [µm]\n".to_owned();
    for k in 0..11 {
        let x = 50.0 * f64::from(k);
        let cell = |value: f64| format!("{value:.1}").replace('.', ",");
        let (up, down) = (cell(0.040 * x + 3.0), cell(0.040 * x - 3.0));
        let _ = writeln!(laser, "{};{up};{down};{up};{down}", cell(x));
    }
    let mut person = Person::with(&[
        ("laser.csv", laser),
        ("part.nc", square("fanuc")),
        ("OFFSETS.NC", "%\nG21\nG10 L2 P1 X100. Y80. Z-300.\nG10 L10 P1 R100.\nM30\n%\n".into()),
    ]);
    person.runs(
        "machine new mill.toml --like vmc --control fanuc --travel X=0..600 --travel Y=0..400 --travel Z=-500..0",
    );
    person.runs("import laser.csv --machine mill.toml --sign + --at Y100,Z-200 --tool 0 --material 20C -o x");
    let found = person.calibrates("calibrate x.csv --machine mill.toml --model EXX1,EXXb -o fitted.toml");
    // X is under the table: the body goes the other way than the tool on the workpiece.
    near(&found, "EXX1", -40.0, 0.5);
    near(&found, "EXXb", -3.0, 0.2);
    let [before, after] = person
        .corrects("fix part.nc -o out.nc --machine fitted.toml --setup OFFSETS.NC --zero G54=absolute", "page.html");
    // Until X has moved once, its position within the backlash is unknown: half of the reversal value is left there.
    assert!(before > 10.0 && after < 3.1, "{before} {after}");
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
        "machine new router.toml --like router --control grbl --from settings.txt --travel X=0..600 --travel Y=0..900 --travel Z=-80..0",
    );
    person.runs("square --machine router.toml --square 300 --dial 0.15 -o fitted.toml");
    let [before, after] = person.corrects(
        "fix part.ngc -o out.ngc --machine fitted.toml --setup offsets.txt --max-correction 1mm",
        "page.html",
    );
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
         --sense A=- --sense C=- --pivot A=300,200,40 --pivot C=300,200,40",
    );
    person.runs("import balls.csv --machine table.toml --unit mm --tool 0 --at A0 --as ball-touches -o place");
    let found = person.calibrates("calibrate place.csv --machine table.toml --model EX0C,EY0C -o fitted.toml");
    assert_eq!(found.len(), 2);
    near(&found, "EX0C", 20.0, 0.8);
    near(&found, "EY0C", -15.0, 0.8);
    let [before, after] = person.corrects(
        "fix part.mpf -o out.mpf --machine fitted.toml --setup UFR.INI --setup TOA.INI --zero G54=absolute",
        "page.html",
    );
    assert!(before > 15.0 && after < 1.5, "{before} {after}");
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
    person.runs("machine new mill.toml --like vmc --from mill.ini");
    person.runs("import edge.csv --machine mill.toml --axis Y --component EXY --reference square --sign + --unit mm --at X300,Z-100 --tool 0 -o edge_y");
    let found = person.calibrates("calibrate edge_y.csv --machine mill.toml --model EXY1 -o fitted.toml");
    // The instrument reads the tool relative to the workpiece; the body of Y carries the workpiece.
    near(&found, "EXY1", -250.0, 1.0);
    let [before, after] = person.corrects(
        "fix part.ngc -o out.ngc --machine fitted.toml --setup mill.var --setup tool.tbl --zero G54=absolute --max-correction 1mm",
        "page.html",
    );
    assert!(before > 60.0 && after < 1.5, "{before} {after}");
    person.runs("verify part.ngc out.ngc --machine fitted.toml --setup mill.var --setup tool.tbl --zero G54=absolute");
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
