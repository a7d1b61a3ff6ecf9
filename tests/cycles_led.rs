//! The way to a hole that stays a drilling cycle, and the cut after it.
//!
//! The judge is the one of [`crate::cycles_stay`]: the written positions, and the errors of the test machine by hand.

use std::fmt::Write as _;

use crate::cycles_stay::{
    Drilled, PlateErrors, UPRIGHT, corrected, grundig_holes, iso_holes, judge, sinumerik_holes, word,
};
use crate::support::Shop;

/// Tolerance and half an increment on three axes, mm.
const ALLOWED_MM: f64 = 1.0e-3 + 0.5e-4 * 1.8;

/// Backlash of one axis.
fn play(axis: char, um: i32) -> String {
    format!("[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {um}\n")
}

/// The text without comments and block number.
fn bare(line: &str) -> &str {
    let line = line.split([';', '(']).next().unwrap().trim();
    let rest = line.strip_prefix('N').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim());
    rest.unwrap_or(line)
}

/// Positions that lines state, in their order; `level` is the height to which the cycles return.
fn positions(text: &str, level: f64) -> Vec<[f64; 3]> {
    let mut at = [0.0, 0.0, level];
    let mut found = Vec::new();
    for line in text.lines() {
        let is_cycle = line.contains("CYCLE") || ["G81", "G79"].iter().any(|code| line.contains(code));
        let own = bare(line);
        let stated = ['X', 'Y', 'Z'].map(|letter| word(own, letter));
        if stated == [None; 3] {
            continue;
        }
        at[0] = stated[0].unwrap_or(at[0]);
        at[1] = stated[1].unwrap_or(at[1]);
        if !is_cycle {
            at[2] = stated[2].unwrap_or(at[2]);
        }
        found.push(at);
    }
    found
}

/// 110 mm above the bottom of the hole, the place of the tool differs by 4 µm from that of the hole. The cut after the hole begins up there.
#[test]
fn the_first_cut_after_a_hole_begins_at_its_place() {
    let errors = PlateErrors { lean_urad: 40.0 };
    for (control, name, program) in [
        (
            "rs274",
            "cut.ngc",
            "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20 Y20 S2000 M3\nG43 H2 Z100\nG98 G81 X20 Y20 Z-10 R2 F100\nG80\nG1 X60 F300\nG0 Z150\nM2\n",
        ),
        (
            "fanuc",
            "cut.nc",
            "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S2000 M3\nG43 H2 Z100.\nG98 G81 X20. Y20. Z-10. R2. F100.\nG80\nG1 X60. F300.\nG0 Z150.\nM30\n%\n",
        ),
        (
            "grundig",
            "cut.pm",
            "%PM1\nN1 G17 G71 G90\nN2 G54\nN3 T2 M6\nN4 G0 X20 Y20 Z100 S1100 M3\nN5 G81 Y2 Z-10 F140\nN6 G79 X20 Y20 Z0\nN7 G0 Z100\nN8 G1 X60 F300\nN9 G0 Z150\nN10 M30\n",
        ),
        (
            "sinumerik",
            "cut.mpf",
            "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3\nG0 X20 Y20 Z100\nF150\nMCALL CYCLE81(100,0,2,-10)\nX20 Y20\nMCALL\nG1 X60 F300\nG0 Z150\nM30\n",
        ),
        (
            "sinumerik",
            "single.mpf",
            "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3\nG0 X20 Y20 Z100\nF150\nCYCLE81(100,0,2,-10)\nG1 X60 F300\nG0 Z150\nM30\n",
        ),
    ] {
        let text = corrected(control, name, program, errors);
        let holes = match control {
            "sinumerik" => sinumerik_holes(&text),
            "grundig" => grundig_holes(&text),
            _ => iso_holes(&text),
        };
        let at = |z: f64| [20.0, 20.0, z];
        judge(errors, &holes, &[Drilled { reference: at(2.0), bottom: at(-10.0) }], &text);
        // The level of the tool above the hole is the one before it.
        let way = positions(&text, 100.0);
        let end = way.iter().position(|place| (place[0] - 60.0).abs() < 0.5).unwrap_or_else(|| panic!("{text}"));
        let start = errors.real(way[end - 1]);
        for (axis, wanted) in [20.0, 20.0].into_iter().enumerate() {
            assert!((start[axis] - wanted).abs() <= ALLOWED_MM, "{start:?}\n{text}");
        }
    }
}

/// A program that goes to R itself: the written R and the written level differ by less than a micrometer.
#[test]
fn a_hole_that_begins_at_the_level_of_the_tool_is_accepted() {
    let head = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nS2000 M3\nG0 X20. Y20.\nG43 H2 Z50.\nG0 Z2.\n";
    let tail = "X40.\nX60. Y35.\nG80\nG0 Z50.\n";
    for cycle in ["G81", "G82", "G83", "G85", "G89"] {
        let words = match cycle {
            "G82" | "G89" => " P1",
            "G83" => " Q3.",
            _ => "",
        };
        for ending in ["G98", "G99"] {
            for at in ["X20. Y20.", "X30. Y20."] {
                let call = format!("{ending} {cycle} {at} Z-7. R2.{words} F100.\n");
                corrected("rs274", "level.ngc", &format!("{head}{call}{tail}M2\n"), UPRIGHT);
                corrected("fanuc", "level.nc", &format!("%\nO1\n{head}{call}{tail}M30\n%\n"), UPRIGHT);
            }
        }
    }
    for call in ["CYCLE81(2,0,2,-7)", "CYCLE82(2,0,2,-7,,1)", "CYCLE85(2,0,2,-7,,1,100,200)", "CYCLE89(2,0,2,-7,,1)"] {
        let head = "G17 G90 G71 G94 G54\nT2 M6\nD1 S2000 M3 F150\nG0 X20 Y20 Z50\nG0 Z2\n";
        let modal = format!("{head}MCALL {call}\nX20 Y20\nX40\nMCALL\nG1 Z-1\nX80\nG0 Z50\nM30\n");
        corrected("sinumerik", "level.mpf", &modal, UPRIGHT);
        let single = format!("{head}{call}\nG0 X40\n{call}\nG1 Z-1\nX80\nG0 Z50\nM30\n");
        corrected("sinumerik", "single.mpf", &single, UPRIGHT);
    }
}

/// X, Y and Z of a move of the flat stream, in the coordinates of the program.
fn place(line: &str) -> Option<[f64; 3]> {
    let stated = ['X', 'Y', 'Z'].map(|letter| word(line, letter));
    let [Some(x), Some(y), Some(z)] = stated else { return None };
    Some([x - 40.0, y - 30.0, z - 100.0])
}

/// Under G98, R is the level of the tool. The rises of Y and Z lower the far holes by 5.5 µm. The tool crosses at its own level all the same, and the cut
/// after the last hole begins at its place, not 5.5 µm above it.
#[test]
fn under_g98_the_tool_crosses_at_its_level_and_cuts_at_its_place() {
    let program = "G21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nS2000 M3\nG0 X20. Y20.\nG43 H2 Z50.\nG0 Z2.\n\
                   G98 G81 X20. Y20. Z-7. R2. F100.\nX400. Y300.\nX60. Y35.\nX420. Y300.\nG80\nG1 X380. F300.\nG0 Z50.\n";
    for (control, name, program) in
        [("rs274", "r.ngc", format!("{program}M2\n")), ("fanuc", "r.nc", format!("%\nO1\n{program}M30\n%\n"))]
    {
        let text = corrected(control, name, &program, UPRIGHT);
        let holes = [[20.0, 20.0], [400.0, 300.0], [60.0, 35.0], [420.0, 300.0]];
        let holes = holes.map(|[x, y]| Drilled { reference: [x, y, 2.0], bottom: [x, y, -7.0] });
        judge(UPRIGHT, &iso_holes(&text), &holes, &text);
        let shop = Shop::new().file(name, &text).file("m.toml", UPRIGHT.machine(control));
        let stream = shop.run(["snc", name, "--machine", "m.toml"]).exits(0).stdout;
        let moves: Vec<(bool, [f64; 3])> =
            stream.lines().filter_map(|line| Some((line.starts_with("G0 "), place(line)?))).collect();
        let before = text.lines().take_while(|line| !line.contains("G81"));
        let level_mm = before.filter_map(|line| word(bare(line), 'Z')).last().unwrap();
        let crossings = moves.windows(2).filter(|pair| pair[1].0 && (pair[1].1[0] - pair[0].1[0]).abs() > 100.0);
        let heights: Vec<f64> = crossings.map(|pair| pair[1].1[2]).collect();
        assert_eq!(heights.len(), 3, "{stream}");
        assert!(heights.iter().all(|z| (z - level_mm).abs() < 1e-6), "{level_mm} {heights:?}\n{text}");
        let cut = moves.iter().position(|(rapid, at)| !rapid && (at[0] - 380.0).abs() < 0.5).unwrap();
        for (at, wanted) in [(moves[cut - 1].1, [420.0, 300.0, 2.0]), (moves[cut].1, [380.0, 300.0, 2.0])] {
            let real = UPRIGHT.real(at);
            let off = (0..3).map(|axis| (real[axis] - wanted[axis]).powi(2)).sum::<f64>().sqrt();
            assert!(off <= ALLOWED_MM, "{off} {at:?} {wanted:?}\n{text}");
        }
    }
}

/// A function after the motion, another level, and a feed move trigger the modal call too.
#[test]
fn holes_of_a_modal_call_between_other_words_stay_calls() {
    let program = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3 F150\nN40 G0 X20 Y20 Z50\nN50 MCALL CYCLE82(20,0,2,-10,,0.2)\n\
                   N60 X20 Y20 M8\nN70 X40 Y20 M9\nN80 X60 Y20 Z70\nN85 G1 X80 Y20 F300\nN90 G0 X80 Y40 S900\nN100 MCALL\nN110 G1 X90\nN120 G0 Z60\nN130 M30\n";
    let text = corrected("sinumerik", "words.mpf", program, UPRIGHT);
    let hole = |x: f64, y: f64| Drilled { reference: [x, y, 2.0], bottom: [x, y, -10.0] };
    let wanted = [hole(20.0, 20.0), hole(40.0, 20.0), hole(60.0, 20.0), hole(80.0, 20.0), hole(80.0, 40.0)];
    judge(UPRIGHT, &sinumerik_holes(&text), &wanted, &text);
    // The other level is a move in front of its hole.
    let rise = text.lines().find(|line| line.starts_with("N80 ")).unwrap();
    assert!(word(rise, 'Z').is_some_and(|z| (z - 70.0).abs() < 0.05), "{text}");
}

/// Lost motion of three axes: a tap that stands at its hole, and one that reaches it from either side.
#[test]
fn taps_on_a_machine_with_lost_motion_stay_and_are_accepted() {
    let backlash = play('X', -6) + &play('Y', -6) + &play('Z', -6);
    let sinumerik = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S300 M3 F150\nN40 G0 X20 Y20 Z50\nN50 MCALL CYCLE84(50,0,3,-18,,0.5,3,,1.25,,300,400)\n\
                     N60 X20 Y20\nN70 X60\nN80 X20 Y40\nN90 MCALL\nN100 G0 X70 Y40\nN110 CYCLE84(50,0,3,-18,,0.5,3,,1.25,,300,400)\nN120 G0 X20\n\
                     N130 CYCLE84(50,0,3,-18,,0.5,3,,1.25,,300,400)\nN140 G0 Z60\nN150 M30\n";
    let fanuc = "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X20. Y20. S500 M3\nG43 H2 Z50.\nM29 S500\nG98 G84 X20. Y20. Z-18. R5. F500.\n\
                 X60.\nX20. Y40.\nG80\nG0 Z60.\nM30\n%\n";
    let mut sides = Vec::new();
    for (control, name, program, call) in
        [("sinumerik", "tap.mpf", sinumerik, "CYCLE84("), ("fanuc", "tap.nc", fanuc, "G84 ")]
    {
        for lean_urad in [4.0, 120.0] {
            let machine = PlateErrors { lean_urad }.machine(control) + &backlash;
            let shop = Shop::new().file(name, program).file("m.toml", machine);
            shop.run([name, "-o", "out.txt", "--machine", "m.toml"]).exits(0);
            let text = shop.text("out.txt");
            assert!(text.contains(call) && !text.contains("G331"), "{text}");
            shop.run(["verify", name, "out.txt", "--machine", "m.toml"]).exits(0);
            sides.push(text);
        }
    }
    // Half of 120 µrad over 23 mm is 1.4 µm: with a shift of the other end, twice that is left, and the program is refused.
    let machine = PlateErrors { lean_urad: 120.0 }.machine("sinumerik") + &backlash;
    let spoiled: String = sides[1].lines().fold(String::new(), |mut out, line| {
        let _ = match (line.starts_with("N80 "), word(bare(line), 'X')) {
            (true, Some(x)) => writeln!(out, "{}", line.replace(&format!("X{x}"), &format!("X{:.4}", x + 0.012))),
            _ => writeln!(out, "{line}"),
        };
        out
    });
    assert_ne!(spoiled, sides[1]);
    let shop = Shop::new().file("tap.mpf", sinumerik).file("m.toml", machine).file("out.mpf", spoiled);
    assert_ne!(shop.run(["verify", "tap.mpf", "out.mpf", "--machine", "m.toml"]).code, 0);
}

/// A call without a position drills where the tool stands: a move leads to the place of the hole, 5 µm beside.
#[test]
fn a_single_call_stays_a_call_at_the_corrected_place() {
    let errors = PlateErrors { lean_urad: 40.0 };
    let program = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3 F150\nN40 G0 X20 Y20 Z130\nN50 CYCLE82(130,0,2,-10,,0.5)\nN60 G0 X60\n\
                   N70 CYCLE83(130,0,2,-10,,-5,,2,0.5,0,1,0)\nN80 G0 X100\nN90 CYCLE84(130,0,2,-10,,0.5,3,,1.25,,300,400)\nN100 G0 Z150\nN110 M30\n";
    let text = corrected("sinumerik", "single.mpf", program, errors);
    assert!(!text.contains("G1 ") && !text.contains("G331"), "{text}");
    for call in ["CYCLE82(", "CYCLE83(", "CYCLE84("] {
        assert!(text.contains(call), "{call}\n{text}");
    }
    let hole = |x: f64| Drilled { reference: [x, 20.0, 2.0], bottom: [x, 20.0, -10.0] };
    judge(errors, &sinumerik_holes(&text), &[hole(20.0), hole(60.0), hole(100.0)], &text);
    // Where the tool leads to the hole, another place is no correction.
    let led = text.lines().position(|line| line.ends_with(";~")).unwrap_or_else(|| panic!("{text}"));
    for off_mm in [0.01, 0.3] {
        let spoiled: Vec<String> = text
            .lines()
            .enumerate()
            .map(|(k, line)| match word(bare(line), 'X') {
                Some(x) if k == led => line.replace(&format!("X{x}"), &format!("X{:.4}", x + off_mm)),
                _ => line.to_owned(),
            })
            .collect();
        let shop = Shop::new()
            .file("single.mpf", program)
            .file("m.toml", errors.machine("sinumerik"))
            .file("out.mpf", spoiled.join("\n") + "\n");
        assert_ne!(shop.run(["verify", "single.mpf", "out.mpf", "--machine", "m.toml"]).code, 0, "{spoiled:?}");
    }
}

/// Rigid tapping in a plane that G68 turns by 30 degrees, and in a mirrored one: the holes by hand.
#[test]
fn rigid_tapping_stays_in_a_turned_plane_of_a_fanuc() {
    let (sine, cosine) = 30_f64.to_radians().sin_cos();
    let turned = |x: f64, y: f64| {
        [200.0 + cosine * (x - 200.0) - sine * (y - 80.0), 80.0 + sine * (x - 200.0) + cosine * (y - 80.0)]
    };
    let mirrored = |x: f64, y: f64| [-x, y];
    let place: [(&str, &str, [[f64; 2]; 2]); 2] = [
        ("G68 X200. Y80. R30.", "G69", [turned(220.0, 90.0), turned(260.0, 90.0)]),
        ("G51.1 X0.", "G50.1 X0.", [mirrored(-220.0, 90.0), mirrored(-260.0, 90.0)]),
    ];
    for (frame, end, wanted) in place {
        let sign = if frame.starts_with("G51") { "-" } else { "" };
        let program = format!(
            "%\nO1\nG21 G17 G90 G40 G49 G80 G94 G54\nT2 M6\nG0 X0. Y0. S500 M3\nG43 H2 Z50.\n{frame}\nG0 X{sign}210. Y90.\nM29 S500\n\
             G98 G84 X{sign}220. Y90. Z-10. R5. F500.\nX{sign}260.\nG80\n{end}\nG0 Z60.\nM30\n%\n"
        );
        let text = corrected("fanuc", "turned.nc", &program, UPRIGHT);
        assert!(text.contains("M29 S500\n") && text.matches("G84").count() == 1 && !text.contains("G1 "), "{text}");
        let holes = wanted.map(|[x, y]| Drilled { reference: [x, y, 5.0], bottom: [x, y, -10.0] });
        judge(UPRIGHT, &iso_holes(&text), &holes, &text);
    }
}

/// Both factors of the plane are 2: a circle stays a circle, although Z is not scaled.
#[test]
fn arcs_in_a_plane_of_equal_factors_stay_arcs() {
    let program = "N10 G17 G90 G71 G94 G54\nN20 T2 M6\nN30 D1 S2000 M3 F300\nN40 TRANS X200 Y100\nN50 AROT RPL=15\nN60 ASCALE X2 Y2\nN70 G0 X10 Y-10 Z20\n\
                   N80 G1 Z-1\nN90 G2 X20 Y-20 I10 J0\nN100 G3 X20 Y-20 I5 J5 Z-3\nN110 G0 Z20\nN120 TRANS\nN130 M30\n";
    let text = corrected("sinumerik", "scale.mpf", program, UPRIGHT);
    let arcs: Vec<&str> = text.lines().filter(|line| word(bare(line), 'I').is_some()).collect();
    assert!(text.contains("N90 G2 ") && text.contains("N100 G3 ") && arcs.len() >= 2, "{text}");
    assert!(text.lines().count() <= 40, "{text}");
    // 5e-5 of X and 3e-5 of Y distort the circles by less than 0.01 mm.
    let first = arcs.iter().find(|line| line.starts_with("N90 ")).unwrap();
    let radius = word(bare(first), 'I').unwrap().hypot(word(bare(first), 'J').unwrap());
    assert!((radius - 10.0).abs() < 0.01, "{radius}\n{text}");
}
