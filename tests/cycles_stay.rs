//! Drilling cycles that stay cycles in a corrected program.
//!
//! The judge here shares nothing with the program: a reader of the written lines, an expansion into the tool positions at the bottom of each hole and
//! at its reference plane, and the errors of the test machine by hand. A hole is where the tool really is: the written position plus the error there.

use std::fmt::Write as _;
use std::io::Write as _;

use crate::support::Shop;

/// G54 in machine coordinates, and the length of tool 2, mm.
const ZERO: [f64; 3] = [40.0, 30.0, 100.0];
const LENGTH_MM: f64 = 80.0;
/// Tolerance and half an increment on three axes, mm.
const ALLOWED_MM: f64 = 1.0e-3 + 0.5e-4 * 1.8;

/// PlateErrors of the test machine.
#[derive(Clone, Copy)]
pub(crate) struct PlateErrors {
    /// Inclination of Z towards X, µrad: the place of a hole changes with its depth.
    pub(crate) lean_urad: f64,
}

pub(crate) const UPRIGHT: PlateErrors = PlateErrors { lean_urad: 4.0 };
pub(crate) const LEANING: PlateErrors = PlateErrors { lean_urad: 160.0 };

impl PlateErrors {
    /// The machine file: all axes carry the tool, X first.
    pub(crate) fn machine(self, control: &str) -> String {
        let mut text = format!("[machine]\nname = \"plate\"\ntopology = \"wFXYZSt\"\ncontroller = \"{control}\"\n\n");
        for (axis, high) in [("X", 700), ("Y", 500), ("Z", 500)] {
            let direction = ["X", "Y", "Z"].map(|other| i32::from(other == axis));
            let _ = write!(text, "[axis.{axis}]\ndirection = {direction:?}\ntravel_mm = [0, {high}]\n\n");
        }
        text.push_str("[spindle]\norigin_mm = [0, 0, 0]\naxis = [0, 0, 1]\n\n");
        text.push_str("[control]\nincrement_mm = 0.0001\n");
        if control == "fanuc" {
            text.push_str(
                "increment_system = \"IS-C\"\norient_shift = \"+X\"\nrigid_tapping = false\nword_meaning = \"fanuc\"\n",
            );
        }
        let _ = write!(text, "[location]\nEC0Y = 30.0\nEA0Z = -5.0\nEB0Z = {}\n\n", self.lean_urad);
        text.push_str("[[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 5.0e-5]\n");
        text.push_str("[[motion]]\ncomponent = \"EYX\"\nkind = \"polynomial\"\ncoefficients = [0, 0, 4.0e-8]\n");
        text.push_str("[[motion]]\ncomponent = \"EZY\"\nkind = \"polynomial\"\ncoefficients = [0, 2.0e-5]\n");
        text.push_str("[[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0, 1.0e-5]\n\n");
        let zero = ZERO.map(|value| format!("{value:.1}"));
        let _ = write!(
            text,
            "[zero_offset.G54]\nX_mm = {}\nY_mm = {}\nZ_mm = {}\nset = \"absolute\"\n\n",
            zero[0], zero[1], zero[2]
        );
        let _ = write!(text, "[[tool]]\nnumber = 2\nlength_mm = {LENGTH_MM:.1}\nradius_mm = 4.0\n");
        text
    }

    /// The place of the tool in the coordinates of the program, for a written position.
    pub(crate) fn real(self, written: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = [0, 1, 2].map(|axis| written[axis] + ZERO[axis]);
        // The position of the Z slide, and of the tip below it.
        let slide = z + LENGTH_MM;
        [
            written[0] + 5.0e-5 * x - 30.0e-6 * y + self.lean_urad * 1e-6 * z,
            written[1] + 4.0e-8 * x * x + 5.0e-6 * z,
            written[2] + 2.0e-5 * y + 1.0e-5 * slide,
        ]
    }
}

/// A hole: the position of the tool at the reference plane and at the bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Drilled {
    pub(crate) reference: [f64; 3],
    pub(crate) bottom: [f64; 3],
}

/// The value of a word of a line.
pub(crate) fn word(line: &str, letter: char) -> Option<f64> {
    line.split_whitespace().find_map(|word| word.strip_prefix(letter)?.parse().ok())
}

/// Holes of the lines with G81 to G89, G73 and G76: X Y Z R stay in force until G80, G0 or G1.
pub(crate) fn iso_holes(text: &str) -> Vec<Drilled> {
    let (mut holes, mut at, mut depth, mut r, mut is_on) = (Vec::new(), [0.0; 3], 0.0, 0.0, false);
    for line in text.lines() {
        let line = line.split(['(', ';']).next().unwrap();
        let codes: Vec<f64> = line.split_whitespace().filter_map(|word| word.strip_prefix('G')?.parse().ok()).collect();
        if codes.iter().any(|code| [0.0, 1.0, 80.0].contains(code)) {
            is_on = false;
        }
        is_on |= codes.iter().any(|&code| (81.0..90.0).contains(&code) || code == 73.0 || code == 76.0);
        let names_plane = word(line, 'X').is_some() || word(line, 'Y').is_some();
        at[0] = word(line, 'X').unwrap_or(at[0]);
        at[1] = word(line, 'Y').unwrap_or(at[1]);
        if is_on {
            depth = word(line, 'Z').unwrap_or(depth);
            r = word(line, 'R').unwrap_or(r);
            if names_plane {
                holes.push(Drilled { reference: [at[0], at[1], r], bottom: [at[0], at[1], depth] });
            }
        }
    }
    holes
}

/// Holes of the modal calls and the calls at a position.
pub(crate) fn sinumerik_holes(text: &str) -> Vec<Drilled> {
    let (mut holes, mut at, mut call) = (Vec::new(), [0.0; 2], None);
    for line in text.lines() {
        let line = line.split(';').next().unwrap().trim();
        let line =
            line.strip_prefix('N').map_or(line, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim());
        let heights = |text: &str| -> [f64; 2] {
            let inside = text.split_once('(').unwrap().1.trim_end_matches(')');
            let values: Vec<f64> = inside.split(',').map(|value| value.parse().unwrap_or(0.0)).collect();
            [values[1] + values[2], values[3]]
        };
        let hole = |at: [f64; 2], [reference, bottom]: [f64; 2]| Drilled {
            reference: [at[0], at[1], reference],
            bottom: [at[0], at[1], bottom],
        };
        if let Some(rest) = line.strip_prefix("MCALL") {
            call = rest.contains('(').then(|| heights(rest));
            continue;
        }
        if line.starts_with("CYCLE8") {
            holes.push(hole(at, heights(line)));
            continue;
        }
        let names_plane = word(line, 'X').is_some() || word(line, 'Y').is_some();
        at = [word(line, 'X').unwrap_or(at[0]), word(line, 'Y').unwrap_or(at[1])];
        if let Some(heights) = call.filter(|_| names_plane) {
            holes.push(hole(at, heights));
        }
    }
    holes
}

/// Corrects a program; returns the written text.
pub(crate) fn corrected(control: &str, name: &str, program: &str, errors: PlateErrors) -> String {
    corrected_within(control, name, program, errors, "1um")
}

/// Corrects a program with a tolerance.
fn corrected_within(control: &str, name: &str, program: &str, errors: PlateErrors, tolerance: &str) -> String {
    let shop = Shop::new().file(name, program).file("m.toml", errors.machine(control));
    let out = format!("out_{name}");
    let run = shop.run(["fix", name, "-o", &out, "--machine", "m.toml", "--tolerance", tolerance]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let text = shop.text(&out);
    let verify = shop.run(["verify", name, &out, "--machine", "m.toml"]);
    assert_eq!(verify.code, 0, "{}\n{}\n{text}", verify.stderr, verify.stdout);
    text
}

/// The largest distance between drilled and wanted holes, mm.
#[track_caller]
pub(crate) fn judge(errors: PlateErrors, found: &[Drilled], wanted: &[Drilled], text: &str) -> f64 {
    assert_eq!(found.len(), wanted.len(), "{text}");
    let mut worst = 0.0_f64;
    for (found, wanted) in found.iter().zip(wanted) {
        for (found, wanted) in [(found.reference, wanted.reference), (found.bottom, wanted.bottom)] {
            let real = errors.real(found);
            let off = (0..3).map(|axis| (real[axis] - wanted[axis]).powi(2)).sum::<f64>().sqrt();
            assert!(off <= ALLOWED_MM, "{off} {found:?} {wanted:?}\n{text}");
            worst = worst.max(off);
        }
    }
    worst
}

/// A grid of holes, row by row.
fn grid(reference: f64, bottom: f64) -> Vec<Drilled> {
    let mut holes = Vec::new();
    for row in 0..5 {
        for column in 0..8 {
            let [x, y] = [20.0 + 60.0 * f64::from(column), 20.0 + 70.0 * f64::from(row)];
            holes.push(Drilled { reference: [x, y, reference], bottom: [x, y, bottom] });
        }
    }
    holes
}

/// 40 pecked holes: on a Fanuc in a few lines, with increments and K.
fn iso_grid(is_fanuc: bool) -> String {
    let mut text = String::from(if is_fanuc { "%\nO3000 (PLATE)\n" } else { "" });
    text.push_str("N10 G21 G17 G90 G40 G49 G80 G94 G54\nN20 T2 M6\nN30 G0 X0. Y0. S2000 M3\nN40 G43 H2 Z50.\n");
    for row in 0..5 {
        let y = 20 + 70 * row;
        let words = if row == 0 { "G99 G83 Z-30. R2. Q5. F150." } else { "G90" };
        let _ = writeln!(text, "{words} X20. Y{y}.");
        if is_fanuc {
            let _ = writeln!(text, "G91 X60. K7");
        } else {
            (1..8).for_each(|column| text.push_str(&format!("X{}.\n", 20 + 60 * column)));
        }
    }
    text.push_str("N90 G90 G80\nN100 G0 Z50.\nN110 M30\n");
    text.push_str(if is_fanuc { "%\n" } else { "" });
    text
}

#[test]
fn forty_pecked_holes_of_linuxcnc_stay_forty_lines() {
    let text = corrected("rs274", "plate.ngc", &iso_grid(false), UPRIGHT);
    let worst_mm = judge(UPRIGHT, &iso_holes(&text), &grid(2.0, -30.0), &text);
    assert!(text.lines().count() <= 60, "{text}");
    assert!(text.contains("G83") && text.contains(" Q5") && text.contains("G80") && !text.contains("G1 "), "{text}");
    let _ = writeln!(std::io::stderr(), "worst {:.2} µm, {} lines", worst_mm * 1e3, text.lines().count());
}

#[test]
fn forty_pecked_holes_of_a_fanuc_stay_forty_lines() {
    let text = corrected("fanuc", "plate.nc", &iso_grid(true), UPRIGHT);
    judge(UPRIGHT, &iso_holes(&text), &grid(2.0, -30.0), &text);
    assert!(text.lines().count() <= 60, "{text}");
}

#[test]
fn forty_pecked_holes_of_a_sinumerik_stay_positions() {
    let mut program = String::from(
        "; plate\nN10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X0 Y0 Z50\nN50 F150\nN60 MCALL CYCLE83(20,0,2,-30,,-5,,2,0.5,0,1,0)\n",
    );
    for row in 0..5 {
        let _ = writeln!(program, "N{} HOLES1(20,{},0,0,60,8)", 70 + 10 * row, 20 + 70 * row);
    }
    program.push_str("N120 MCALL\nN130 G0 Z50\nN140 M30\n");
    let text = corrected("sinumerik", "plate.mpf", &program, UPRIGHT);
    let found = sinumerik_holes(&text);
    let mut wanted = grid(2.0, -30.0);
    // A row begins at the end that is nearer to the tool.
    for row in [1, 3] {
        wanted[8 * row..8 * row + 8].reverse();
    }
    judge(UPRIGHT, &found, &wanted, &text);
    assert!(text.lines().count() <= 75, "{text}");
}

/// Over 100 mm above the hole the tool is 4 µm beside it: the call must name the place, although the program is already there.
#[test]
fn a_hole_below_the_tool_is_positioned_by_its_call() {
    let errors = PlateErrors { lean_urad: 40.0 };
    for (control, name, program) in [
        (
            "rs274",
            "below.ngc",
            "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z100.\nG98 G81 X20. Y20. Z-10. R2. F100.\nG80\nM2\n",
        ),
        (
            "fanuc",
            "below.nc",
            "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z100.\nG98 G81 Z-10. R2. F100.\nG80\nM30\n%\n",
        ),
        (
            "grundig",
            "below.pm",
            "%PM1\nN1 G17 G71 G90\nN2 G54\nN3 T2 M6\nN4 G0 X20 Y20 Z100 S1100 M3\nN5 G81 Y2 Z-10 F140\nN6 G79 X20 Y20 Z0\nN7 G0 Z100\nN8 M30\n",
        ),
        (
            "sinumerik",
            "below.mpf",
            "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3\nG0 X20 Y20 Z100\nF150\nMCALL CYCLE81(100,0,2,-10)\nX20 Y20\nMCALL\nM30\n",
        ),
    ] {
        let text = corrected(control, name, program, errors);
        let found = match control {
            "sinumerik" => sinumerik_holes(&text),
            "grundig" => grundig_holes(&text),
            _ => iso_holes(&text),
        };
        let at = |z: f64| [20.0, 20.0, z];
        judge(errors, &found, &[Drilled { reference: at(2.0), bottom: at(-10.0) }], &text);
    }
}

/// Statements between the call and its first position: a search for a number must find the blocks in their order.
#[test]
fn block_numbers_stay_in_their_order() {
    let program = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X20 Y20 Z50\nN50 F150\nN60 MCALL CYCLE81(50,0,2,-10)\nN62 G64\n\
        N64 G60\nN66 R1=3\nN70 X30 Y20\nN80 X40\nN90 MCALL\nN95 R2=1\nN96 G64\nN97 G60\nN100 G0 Z60\nN110 MCALL CYCLE81(60,0,2,-10)\nN112 M8\n\
        N120 X50\nN130 MCALL\nN135 G64\nN140 MCALL CYCLE81(60,0,2,-10)\nN150 G1 X60 F500\nN160 X70\nN170 MCALL\nN180 M30\n";
    let text = corrected("sinumerik", "order.mpf", program, UPRIGHT);
    let numbers: Vec<u32> = text
        .lines()
        .filter_map(|line| line.strip_prefix('N')?.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok())
        .collect();
    assert!(numbers.is_sorted(), "{numbers:?}\n{text}");
    for number in [60, 62, 64, 70, 80, 90, 96, 97, 100, 112, 120, 130, 140, 150, 160, 170, 180] {
        assert!(numbers.contains(&number), "N{number}\n{text}");
    }
    assert!(text.contains("MCALL CYCLE81(") && text.contains("N112 M8"), "{text}");
}

/// Number of feed moves down to −10 at a position in X: in the flat stream of a written program, which is in machine coordinates of the tip.
fn feeds_to_the_bottom(text: &str, x_mm: f64) -> usize {
    let shop = Shop::new().file("out.ngc", text).file("m.toml", UPRIGHT.machine("rs274"));
    let stream = shop.run(["snc", "out.ngc", "--machine", "m.toml"]).exits(0).stdout;
    let is_at = |line: &str, letter: char, mm: f64| word(line, letter).is_some_and(|value| (value - mm).abs() < 0.1);
    let is_down =
        |line: &&str| line.starts_with("G1 ") && is_at(line, 'X', ZERO[0] + x_mm) && is_at(line, 'Z', ZERO[2] - 10.0);
    stream.lines().filter(is_down).count()
}

/// LinuxCNC returns from G85 and G89 with the feed, under G98 up to the initial level: that is not the bottom of the hole.
#[test]
fn a_hole_that_is_left_with_the_feed_keeps_its_depth() {
    let head = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z15.\n";
    for cycle in ["G98 G85 X40. Y20. Z-10. R2. F100.", "G98 G89 X40. Y20. Z-10. R2. P0.3 F100."] {
        for tolerance in ["1um", "5um"] {
            let text = corrected_within("rs274", "up.ngc", &format!("{head}{cycle}\nG80\nM2\n"), UPRIGHT, tolerance);
            assert_eq!(feeds_to_the_bottom(&text, 40.0), 1, "{text}");
            assert!(text.contains(&cycle[..7]) || tolerance == "1um", "{text}");
        }
    }
}

/// A coarse increment rounds the depth of each peck, and what it is rounded by adds up over the pecks.
#[test]
fn pecks_on_a_coarse_increment_are_where_the_report_says() {
    let head = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z50.\n";
    let mut calls = String::new();
    for k in 0..8 {
        let _ = writeln!(calls, "G99 G83 X{}. Y{}. Z-18.0{k} R2. Q2.50{k} F100.", 30 + 20 * k, 40 + 9 * k);
    }
    let program = format!("{head}{calls}G80\nM2\n");
    let shop = Shop::new().file("m.toml", UPRIGHT.machine("rs274")).file("in.ngc", program);
    for increment in ["0.1um", "1um", "10um"] {
        let words = ["in.ngc", "-o", "out.ngc", "--machine", "m.toml", "--increment", increment, "--json"];
        let fixed = shop.run(words).exits(0).json();
        let verified = shop.run(["verify", "in.ngc", "out.ngc", "--machine", "m.toml", "--json"]).exits(0).json();
        let [fixed, verified] = [fixed, verified].map(|json| json["after"]["max_um"].as_f64().unwrap());
        assert!((fixed - verified).abs() < 0.01, "{increment}: {fixed} {verified} µm");
    }
}

/// L2 under G90 drills twice at one place.
#[test]
fn a_hole_that_is_repeated_at_one_place_is_drilled_as_often() {
    let head = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z50.\n";
    for from in ["", "G0 X40. Y20.\n"] {
        let program = format!("{head}{from}G99 G81 X40. Y20. Z-10. R2. F100. L2\nX60.\nG80\nM2\n");
        let text = corrected("rs274", "twice.ngc", &program, UPRIGHT);
        assert_eq!([40.0, 60.0].map(|x_mm| feeds_to_the_bottom(&text, x_mm)), [2, 1], "{text}");
    }
}

#[test]
fn the_summary_names_the_tolerance_that_keeps_cycles() {
    // 160 µrad over 32 mm are 5.1 µm: 2.6 µm to each side of the middle, and at most 0.1 µm of rounding.
    let shop = Shop::new().file("plate.ngc", iso_grid(false)).file("m.toml", LEANING.machine("rs274"));
    let fix = |more: &[&str]| {
        let arguments = ["fix", "plate.ngc", "-o", "out.ngc", "--machine", "m.toml", "--json"];
        shop.run(arguments.into_iter().chain(more.iter().copied())).exits(0).json()
    };
    let report = fix(&[]);
    assert_eq!((&report["drilling_cycles"], &report["drilled_by_moves"]), (&0.into(), &40.into()), "{report}");
    assert_eq!(report["cycles_need_um"].as_f64(), Some(3.0), "{report}");
    let report = fix(&["--hole-tolerance", "3um"]);
    assert_eq!((&report["drilling_cycles"], &report["drilled_by_moves"]), (&40.into(), &0.into()), "{report}");
    // Half of 5.12 µm, and up to half an increment of 0.1 µm in each of three directions.
    let off_um = report["cycles_off_um"].as_f64().unwrap();
    assert!((2.5..2.65).contains(&off_um), "{report}");
    shop.run(["verify", "plate.ngc", "out.ngc", "--machine", "m.toml"]).exits(0);
    let report = fix(&["--tolerance", "3um"]);
    assert_eq!((&report["drilling_cycles"], &report["drilled_by_moves"]), (&40.into(), &0.into()), "{report}");
    let report = fix(&["--tolerance", "3um", "--expand-cycles"]);
    assert_eq!(report["drilling_cycles"], 0, "{report}");
}

#[test]
fn a_hole_that_changes_its_place_with_the_depth_is_written_as_moves() {
    // 160 µrad over 32 mm are 5 µm.
    let text = corrected("rs274", "plate.ngc", &iso_grid(false), LEANING);
    assert_eq!(iso_holes(&text), []);
    assert!(text.contains("G1 "), "{text}");
}

#[test]
fn the_other_cycles_keep_their_words() {
    let head = "%\nO1\nN10 G21 G17 G90 G40 G49 G80 G94 G54\nN20 T2 M6\nN30 G0 X0. Y0. S2000 M3\nN40 G43 H2 Z50.\n";
    let tail = "N90 G80\nN100 G0 Z50.\nN110 M30\n%\n";
    for (words, wanted) in [
        ("G98 G81 X20. Y20. Z-10. R2. F100.", "G98 G81"),
        ("G98 G82 X20. Y20. Z-10. R2. P500 F100.", "P500"),
        ("G99 G73 X20. Y20. Z-10. R2. Q3. F100.", "Q3."),
        ("G98 G85 X20. Y20. Z-10. R2. F100.", "G85"),
        ("G98 G86 X20. Y20. Z-10. R2. F100.", "G86"),
        ("G98 G89 X20. Y20. Z-10. R2. P300 F100.", "P300"),
        ("G98 G76 X20. Y20. Z-10. R2. Q0.5 P300 F100.", "Q0.5"),
    ] {
        let text = corrected("fanuc", "one.nc", &format!("{head}{words}\n{tail}"), UPRIGHT);
        let at = |z: f64| [20.0, 20.0, z];
        judge(UPRIGHT, &iso_holes(&text), &[Drilled { reference: at(2.0), bottom: at(-10.0) }], &text);
        assert!(text.contains(wanted), "{wanted}\n{text}");
        assert!(text.contains("G80"), "{text}");
    }
}

#[test]
fn the_other_cycles_of_a_sinumerik_keep_their_arguments() {
    let head = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X20 Y20 Z50\nN50 F150\n";
    for (call, wanted) in [
        ("CYCLE81(20,0,2,-10)", "CYCLE81("),
        ("CYCLE82(20,0,2,-10,,0.5)", ",0.5)"),
        ("CYCLE83(20,0,2,-10,,-4,,1,0,0,1,1)", ",1,0,0,1,1)"),
        ("CYCLE85(20,0,2,-10,,0.5,100,200)", ",100,200)"),
        ("CYCLE86(20,0,2,-10,,0.5,3,0.2,0,0.1,45)", ",45)"),
        ("CYCLE89(20,0,2,-10,,0.5)", "CYCLE89("),
        ("CYCLE84(20,0,2,-10,,0,3,,1.25,0,300,300)", "CYCLE84("),
    ] {
        let text = corrected("sinumerik", "one.mpf", &format!("{head}N60 {call}\nN70 M30\n"), UPRIGHT);
        let at = |z: f64| [20.0, 20.0, z];
        judge(UPRIGHT, &sinumerik_holes(&text), &[Drilled { reference: at(2.0), bottom: at(-10.0) }], &text);
        assert!(text.contains(wanted), "{wanted}\n{text}");
    }
}

#[test]
fn a_longer_output_than_allowed_is_refused() {
    let machine = LEANING.machine("rs274");
    let shop = Shop::new().file("plate.ngc", iso_grid(false)).file("m.toml", machine);
    let fix = |growth: &str| {
        shop.run(["fix", "plate.ngc", "-o", "out.ngc", "--machine", "m.toml", "--json", "--max-growth", growth])
    };
    let run = fix("10x").exits(4);
    assert!(run.stdout.contains("E0324"), "{}", run.stdout);
    assert!(!shop.names().contains(&"out.ngc".to_owned()));
    let report = fix("500x").exits(0).json();
    // 40 holes of 7 pecks: each is at least 3 moves, except the first of a hole.
    let growth = report["growth"].as_f64().unwrap();
    assert!((10.0..500.0).contains(&growth), "{growth}");
    let lines = iso_grid(false).lines().count() as f64;
    assert!((growth - report["blocks_out"].as_f64().unwrap() / lines).abs() < 1e-9, "{growth}");
}

/// Holes of the executions G79 of the last definition: heights count from the surface, the Z of G79.
pub(crate) fn grundig_holes(text: &str) -> Vec<Drilled> {
    let (mut holes, mut heights) = (Vec::new(), [0.0; 2]);
    for line in text.lines() {
        let line = line.split('(').next().unwrap();
        let has = |code: &str| line.split_whitespace().any(|word| word == code);
        if has("G81") || has("G83") || has("G85") || has("G86") {
            heights = [word(line, 'Y').unwrap(), word(line, 'Z').unwrap()];
        }
        if has("G79") {
            let [x, y, surface] = ['X', 'Y', 'Z'].map(|letter| word(line, letter).unwrap());
            let [reference, bottom] = heights.map(|height| surface + height);
            holes.push(Drilled { reference: [x, y, reference], bottom: [x, y, bottom] });
        }
    }
    holes
}

#[test]
fn pecked_holes_of_a_grundig_stay_executions() {
    let mut program = String::from(
        "%PM1\nN1 G17 G71 G90\nN2 G54\nN3 T2 M6\nN4 G0 X0 Y0 Z50 S1100 M3\nN5 G83 Y2 Z-30 K5 I1 J1 F140\n",
    );
    let mut number = 5;
    let mut wanted = Vec::new();
    for hole in grid(2.0, -30.0).into_iter().take(16) {
        number += 1;
        let [x, y, _] = hole.bottom;
        let _ = writeln!(program, "N{number} G79 X{x} Y{y} Z0");
        wanted.push(hole);
    }
    let _ = write!(program, "N{} G0 Z100\nN{} M30\n", number + 1, number + 2);
    let text = corrected("grundig", "plate.pm", &program, UPRIGHT);
    judge(UPRIGHT, &grundig_holes(&text), &wanted, &text);
    assert!(text.contains("K5") && text.contains("J1"), "{text}");
    assert!(text.lines().count() <= 50, "{text}");
}

#[test]
fn rigid_tapping_stays_at_the_corrected_place_and_depth() {
    let head = "%\nO1\nN10 G21 G17 G90 G40 G49 G80 G94 G54\nN20 T2 M6\nN30 G0 X0. Y0. S500 M3\nN40 G43 H2 Z50.\n";
    let tail = "N90 G80\nN100 G0 Z50.\nN110 M30\n%\n";
    let text = corrected(
        "fanuc",
        "tap.nc",
        &format!("{head}M29 S500\nG98 G84 X20. Y20. Z-10. R5. F500.\nX80.\n{tail}"),
        UPRIGHT,
    );
    let hole = |x: f64| Drilled { reference: [x, 20.0, 5.0], bottom: [x, 20.0, -10.0] };
    judge(UPRIGHT, &iso_holes(&text), &[hole(20.0), hole(80.0)], &text);
    assert!(text.contains("M29 S500\n"), "{text}");
    assert_eq!(text.matches("G84").count(), 1, "{text}");
}

#[test]
fn a_comment_of_a_program_is_no_mark() {
    let program =
        "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1\nN40 G0 X20 Y20 Z50\nN50 G1 X120 F500 ;+\nN60 X300 ;~\nN70 M30\n";
    let text = corrected("sinumerik", "marks.mpf", program, UPRIGHT);
    assert!(text.contains(";+ .") && text.contains(";~ ."), "{text}");
}

/// The first hole is where the tool already stands: the move to it is one of the program, and one of the output that has moves instead of the cycle.
#[test]
fn a_hole_where_the_tool_stands_is_written_as_moves_too() {
    let program = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3 F150\nN40 G0 X20 Y15 Z50\nN50 MCALL CYCLE82(50,0,2,-2.5,0,0.3)\n\
        N60 HOLES1(0,15,0,20,40,4)\nN70 MCALL\nN80 M30\n";
    let shop = Shop::new().file("row.mpf", program).file("m.toml", UPRIGHT.machine("sinumerik"));
    for more in [&[][..], &["--expand-cycles"], &["--hole-tolerance", "0.1um", "--tolerance", "0.1um"]] {
        let words = ["fix", "row.mpf", "-o", "out.mpf", "--machine", "m.toml"];
        shop.run(words.iter().chain(more).copied()).exits(0);
        shop.run(["verify", "row.mpf", "out.mpf", "--machine", "m.toml"]).exits(0);
    }
}

#[test]
fn rigid_tapping_of_a_sinumerik_stays_where_the_sides_of_axes_are_unknown() {
    // Lost motion of 10 and 7 um; the hole is at the place where the tool stands, with Y from nobody knows where. Moves of the thread would differ in X.
    let play = |axis: char, um: i32| {
        format!("[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {um}\n")
    };
    let machine = UPRIGHT.machine("sinumerik") + &play('X', -10) + &play('Y', -7);
    let program = "G17 G90 G71 G94 G40 G54\nT2 M6\nD1\nS1000 M3\nG0 X-10 Y0\nX20\nZ50\nF100\nCYCLE84(50,0,2,-10,,0,5,,1.25,0,300,300)\n\
                   CYCLE840(50,0,2,-10,,0,0,3,0,,1.25)\nG0 Z50\nM30\n";
    let shop = Shop::new().file("m.toml", machine).file("tap.mpf", program);
    shop.run(["tap.mpf", "-o", "out.mpf", "--machine", "m.toml"]).exits(0);
    let text = shop.text("out.mpf");
    assert!(
        text.contains("CYCLE84(") && text.contains("CYCLE840(") && !text.contains("G331") && !text.contains("G63"),
        "{text}"
    );
    // The arguments other than heights stay.
    assert!(text.contains(",2,-1") && text.contains(",,0,5,,1.25,0,300,300)"), "{text}");
    // Where Z leans, the tool stands beside the hole: a move in front of the call leads to its place.
    let leaning = shop.file("leaning.toml", LEANING.machine("sinumerik") + &play('X', -10) + &play('Y', -7));
    leaning.run(["tap.mpf", "-o", "out3.mpf", "--machine", "leaning.toml"]).exits(0);
    let led = leaning.text("out3.mpf");
    assert!(led.contains("CYCLE84(") && !led.contains("G331") && led.contains(";~"), "{led}");
    leaning.run(["verify", "tap.mpf", "out3.mpf", "--machine", "leaning.toml"]).exits(0);
    let shop = leaning;
    // In a rotated plane the dead bands do not lie along the words of the call: the moves of the thread replace it.
    let rotated = program.replace("F100\n", "F100\nROT RPL=30\n");
    let shop = shop.file("rotated.mpf", rotated);
    shop.run(["rotated.mpf", "-o", "out2.mpf", "--machine", "m.toml"]).exits(0);
    assert!(shop.text("out2.mpf").contains("G331"), "{}", shop.text("out2.mpf"));
}

/// Z leans, so the tool of the first hole moves by a few micrometers in the air before it goes down. With lost motion this may reverse X.
#[test]
fn the_first_hole_counts_the_reversal_by_its_own_correction() {
    let play = |um: i32| format!("[[motion]]\ncomponent = \"EXX\"\nkind = \"backlash\"\nvalue_um = {um}\n");
    let before = "X20. Y15.\n";
    for lean_urad in [-160.0, -60.0, 60.0, 160.0] {
        for um in [-6, 6, -3] {
            for (control, name, start, cycle) in [
                (
                    "sinumerik",
                    "row.mpf",
                    "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3 F150\nG0 ",
                    "MCALL CYCLE82(50,0,2,-12,0,0.3)\nX20 Y15\nX40 Y15\nMCALL\nG0 Z100\nM30\n",
                ),
                (
                    "rs274",
                    "row.ngc",
                    "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nS2000 M3\nG43 H2\nG0 ",
                    "G98 G82 X20. Y15. Z-12. R2. P0.3 F100.\nX40.\nG80\nG0 Z100.\nM2\n",
                ),
                (
                    "fanuc",
                    "row.nc",
                    "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nS2000 M3\nG43 H2 Z100.\nG0 ",
                    "G98 G82 X20. Y15. Z-12. R2. P300 F100.\nX40.\nG80\nG0 Z100.\nM30\n%\n",
                ),
            ] {
                let machine = PlateErrors { lean_urad }.machine(control) + &play(um);
                let shop = Shop::new().file(name, format!("{start}{before}G0 Z100.\n{cycle}")).file("m.toml", machine);
                let json = shop.run([name, "-o", "out.nc", "--machine", "m.toml", "--json"]).exits(0).json();
                let verified = shop.run(["verify", name, "out.nc", "--machine", "m.toml", "--json"]);
                let [said, found] =
                    [json, verified.exits(0).json()].map(|json| json["after"]["max_um"].as_f64().unwrap());
                assert!(
                    // The tolerance of holes, 2 µm, and the rounding of their heights.
                    found < 2.2 && (found - said).abs() < 0.2,
                    "{lean_urad} {um} {control}: {said} {found}\n{}",
                    shop.text("out.nc")
                );
            }
        }
    }
}

/// Three holes in a frame that turns by 30 degrees, or mirrors X: the call and the positions stay, in the coordinates of the frame.
#[test]
fn holes_in_a_rotated_or_mirrored_frame_stay_positions() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    for (frame, [x, y]) in
        [("AROT RPL=30", [[cosine, -sine], [sine, cosine]]), ("AMIRROR X0", [[-1.0, 0.0], [0.0, 1.0]])]
    {
        let program = format!(
            "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X0 Y0 Z50 F150\nN50 TRANS X200 Y80\nN60 {frame}\nN70 MCALL \
             CYCLE83(20,0,2,-30,,-5,,2,0.5,0,1,0)\nN80 X10 Y10\nN90 X60 Y10\nN100 X60 Y90\nN110 MCALL\nN120 TRANS\nN130 G0 Z50\nN140 M30\n"
        );
        let text = corrected("sinumerik", "frame.mpf", &program, UPRIGHT);
        assert!(text.contains("MCALL CYCLE83(") && !text.contains("G1 "), "{text}");
        // To the coordinates of G54.
        let base = |[u, v, height]: [f64; 3]| [200.0 + x[0] * u + x[1] * v, 80.0 + y[0] * u + y[1] * v, height];
        let based = |hole: &Drilled| Drilled { reference: base(hole.reference), bottom: base(hole.bottom) };
        let found: Vec<Drilled> = sinumerik_holes(&text).iter().map(based).collect();
        let wanted = [[10.0, 10.0], [60.0, 10.0], [60.0, 90.0]]
            .map(|[u, v]| based(&Drilled { reference: [u, v, 2.0], bottom: [u, v, -30.0] }));
        judge(UPRIGHT, &found, &wanted, &text);
    }
}

/// A position that repeats a coordinate keeps its line, if nothing changes.
#[test]
fn lines_of_holes_in_which_nothing_changes_keep_their_bytes() {
    let sinumerik = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3\nN40 G0 X0 Y0 Z50 F150\nN50 MCALL \
                     CYCLE81(20,0,2,-30)\nN60 X10 Y10\nN70 X20.0 Y10\nN80 Y10 X30\nN90 MCALL\nN100 G0 Z50\nN110 M30\n";
    let rs274 = "N10 G21 G17 G90 G94 G54\nN20 T2 M6\nN30 G0 X0 Y0 S2000 M3\nN40 G43 H2 Z50\nN50 G98 G83 X10 Y10 Z-20 R2 Q5 F150\n\
                 N60 X20.0 Y10\nN70 Y10 X30 R2 F150\nN80 G80\nN90 G0 Z50\nN100 M2\n";
    for (control, name, program, lines) in [
        ("sinumerik", "same.mpf", sinumerik, ["N60 X10 Y10", "N70 X20.0 Y10", "N80 Y10 X30"]),
        ("rs274", "same.ngc", rs274, ["N50 G98 G83 X10 Y10 Z-20 R2 Q5 F150", "N60 X20.0 Y10", "N70 Y10 X30 R2 F150"]),
    ] {
        let machine = UPRIGHT.machine(control);
        let (head, errors) = machine.split_once("[location]").unwrap();
        let plain = format!("{head}[zero_offset{}", errors.split_once("[zero_offset").unwrap().1);
        let shop = Shop::new().file(name, program).file("m.toml", plain);
        shop.run(["fix", name, "-o", "out.txt", "--machine", "m.toml"]).exits(0);
        let text = shop.text("out.txt");
        for line in lines {
            assert!(text.lines().any(|own| own == line), "{line}\n{text}");
        }
    }
}

/// The line of a hole has no Z: a jump over a clamp in the block of a hole must be written as a move, with the tool at that height before it moves away.
#[test]
fn a_hole_to_which_the_program_rises_keeps_its_height() {
    let errors = PlateErrors { lean_urad: 0.0 };
    let program = "N5 G17 G90 G71 G94 G54\nN6 T2 M6\nN7 D1 S2000 M3 F300\nN10 G0 X0 Y0 Z5\nN20 MCALL CYCLE81(50,0,2,-6)\n\
                   N30 X30 Y10 Z50\nN40 X60 Y10\nN45 Z60\nN50 X80 Y10\nN60 MCALL\nN70 G0 Z80\nN80 M30\n";
    let text = corrected("sinumerik", "p.mpf", program, errors);
    // Z of each line, as modal; cycles end at 50.
    let line =
        |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {text}"));
    let near = |line: &str, z_mm: f64| word(line, 'Z').is_some_and(|written| (written - z_mm).abs() < 0.05);
    assert!(near(line("N30 "), 50.0), "{text}");
    // The block that only rises drills at the same place from there.
    let rises = text.lines().position(|line| near(line, 60.0)).unwrap_or_else(|| panic!("{text}"));
    let next = text.lines().position(|line| line.starts_with("N50 ")).unwrap();
    assert!(rises < next, "{text}");
    // A hole without a new height stays a position.
    let at = word(line("N40 "), 'X').unwrap_or_else(|| panic!("{text}"));
    assert!(word(line("N40 "), 'Z').is_none() && (at - 60.0).abs() < 0.05, "{text}");
}
