//! `--compensation wear`: a control that has the wear alone goes where it would go with the whole radius and the original program.
//!
//! What is written is executed at the radius w that stands in the register then, and held against the original at the radius r + w: the
//! curve beside a curve is the curve beside the contour. Programs are made from one description for each language.

use std::fs;

use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Kind, Move};

use crate::support::{Run, Shop, repository};

/// Radius of the tool in the machine files of the cases, mm.
const RADIUS_MM: f64 = 5.0;
/// Wear that is tried, mm.
const WEARS_MM: [f64; 2] = [0.05, -0.03];
/// Rounding to micrometers at both ends of elements, and what it turns them by.
const ROUNDING_MM: f64 = 2.5e-3;
/// So near to the first and last place of the contour the way onto it counts, mm.
const ENDS_MM: f64 = 0.3;
const LANGUAGES: [&str; 4] = ["sinumerik", "fanuc", "rs274", "grundig"];

/// A block.
#[derive(Clone, Copy)]
enum Go {
    /// Straight to X and Y.
    To(f64, f64),
    /// Straight to X, Y and Z.
    Ramp(f64, f64, f64),
    /// Clockwise to X and Y about a center.
    Cw([f64; 2], [f64; 2]),
    /// The other way.
    Ccw([f64; 2], [f64; 2]),
}

use Go::{Ccw, Cw, Ramp, To};

/// A contour: 41 or 42, where it comes from, its blocks, where it goes. The first block leads to it.
struct Contour {
    name: &'static str,
    code: u32,
    from: [f64; 2],
    blocks: &'static [Go],
    off: [f64; 2],
}

const CONTOURS: &[Contour] = &[
    Contour {
        name: "outside, with an arc, inner and outer corners",
        code: 41,
        from: [-30.0, -20.0],
        blocks: &[
            To(0.0, -12.0),
            To(0.0, 40.0),
            Cw([10.0, 50.0], [10.0, 40.0]),
            To(60.0, 50.0),
            To(60.0, 20.0),
            To(40.0, 20.0),
            To(40.0, 0.0),
            To(-12.0, 0.0),
        ],
        off: [-40.0, -15.0],
    },
    Contour {
        name: "outside, the other way round",
        code: 42,
        from: [-40.0, -15.0],
        blocks: &[
            To(-12.0, 0.0),
            To(40.0, 0.0),
            To(40.0, 20.0),
            To(60.0, 20.0),
            To(60.0, 50.0),
            To(10.0, 50.0),
            Ccw([0.0, 40.0], [10.0, 40.0]),
            To(0.0, -12.0),
        ],
        off: [-30.0, -30.0],
    },
    Contour {
        name: "a pocket with rounded corners, on and off by arcs",
        code: 41,
        from: [30.0, 20.0],
        blocks: &[
            To(22.0, 8.0),
            Ccw([30.0, 0.0], [30.0, 8.0]),
            To(52.0, 0.0),
            Ccw([60.0, 8.0], [52.0, 8.0]),
            To(60.0, 32.0),
            Ccw([52.0, 40.0], [52.0, 32.0]),
            To(8.0, 40.0),
            Ccw([0.0, 32.0], [8.0, 32.0]),
            To(0.0, 8.0),
            Ccw([8.0, 0.0], [8.0, 8.0]),
            To(30.0, 0.0),
            Ccw([38.0, 8.0], [30.0, 8.0]),
        ],
        off: [30.0, 16.0],
    },
    Contour {
        name: "a hole as a full circle",
        code: 41,
        from: [0.0, 1.0],
        blocks: &[
            To(12.0, -8.0),
            Ccw([20.0, 0.0], [12.0, 0.0]),
            Ccw([20.0, 0.0], [0.0, 0.0]),
            Ccw([12.0, 8.0], [12.0, 0.0]),
        ],
        off: [0.0, 1.0],
    },
    Contour {
        name: "from the far side, heights along the contour",
        code: 42,
        from: [10.0, 40.0],
        blocks: &[
            To(10.0, 0.0),
            Ramp(60.0, 0.0, -6.0),
            Ramp(60.0, 30.0, -7.0),
            Cw([70.0, 40.0], [70.0, 30.0]),
            To(90.0, 40.0),
        ],
        off: [100.0, 0.0],
    },
    Contour {
        name: "slanted lines and two arcs that bend either way",
        code: 41,
        from: [-30.0, -10.0],
        blocks: &[
            To(0.0, 0.0),
            To(20.0, 20.0),
            To(45.0, 25.0),
            Cw([55.0, 15.0], [45.0, 15.0]),
            To(55.0, -5.0),
            Ccw([75.0, -25.0], [75.0, -5.0]),
            To(95.0, -25.0),
        ],
        off: [120.0, -20.0],
    },
];

impl Go {
    fn end(self) -> [f64; 2] {
        match self {
            To(x, y) | Ramp(x, y, _) | Cw([x, y], _) | Ccw([x, y], _) => [x, y],
        }
    }

    fn words(self, language: &str, from: [f64; 2]) -> String {
        let word = |letter: &str, value: f64| format!("{letter}{value:?}");
        let arc = |code: &str, [x, y]: [f64; 2], center: [f64; 2]| {
            let [i, j] = if language == "grundig" { center } else { [center[0] - from[0], center[1] - from[1]] };
            let full = language == "grundig" && from == [x, y];
            let end = if full { String::new() } else { format!("{} {} ", word("X", x), word("Y", y)) };
            let turn = if full { " B5=360" } else { "" };
            format!("{code} {end}{} {}{turn}", word("I", i), word("J", j))
        };
        match self {
            To(x, y) => format!("G1 {} {}", word("X", x), word("Y", y)),
            Ramp(x, y, z) => format!("G1 {} {} {}", word("X", x), word("Y", y), word("Z", z)),
            Cw(end, center) => arc("G2", end, center),
            Ccw(end, center) => arc("G3", end, center),
        }
    }
}

/// The program of a contour; `before` stands before its first move.
fn program(contour: &Contour, language: &str, before: &str) -> String {
    let mut out = String::new();
    let (head, tool, on, end) = match language {
        "sinumerik" => ("", "T1 M6\nD1", format!("G{}", contour.code), "M30"),
        "fanuc" => ("%\nO1\n", "T1 M6", format!("G{} D1", contour.code), "M30\n%"),
        "rs274" => ("", "T1 M6", format!("G{} D1", contour.code), "M2"),
        _ => ("%PM9001\nN9001\n", "N1 T1 M6", format!("G{}", contour.code), "N99 M30"),
    };
    let mut number = 10;
    let mut line = |text: &str| {
        let line = if language == "grundig" { format!("N{number} {text}\n") } else { format!("{text}\n") };
        number += 1;
        line
    };
    let unit = if ["sinumerik", "grundig"].contains(&language) { "G71" } else { "G21" };
    out += head;
    out += &line(&format!("{unit} G90 G17 G54"));
    out += tool;
    out += "\n";
    let [x, y] = contour.from;
    if !before.is_empty() {
        out += &line(before);
    }
    out += &line(&format!("G0 X{x:?} Y{y:?} Z5.0"));
    out += &line("G1 Z-5.0 F500.");
    let mut from = contour.from;
    for (index, block) in contour.blocks.iter().enumerate() {
        let words = block.words(language, from);
        if index > 0 {
            out += &line(&words);
        } else if language == "grundig" {
            out += &line(&on);
            out += &line(&format!("{words} F300."));
        } else {
            out += &line(&format!("{on} {words} F300."));
        }
        from = block.end();
    }
    let [x, y] = contour.off;
    if language == "grundig" {
        out += &line("G40");
        out += &line(&format!("G1 X{x:?} Y{y:?}"));
    } else {
        out += &line(&format!("G40 G1 X{x:?} Y{y:?}"));
    }
    out += &line("G0 Z50.0");
    out += end;
    out += "\n";
    out
}

fn file(language: &str) -> &'static str {
    match language {
        "sinumerik" => "part.mpf",
        "fanuc" => "part.nc",
        "rs274" => "part.ngc",
        _ => "part.pm",
    }
}

/// The machine file of a language, with errors that stretch X and tilt Y where they are wanted.
fn machine_text(language: &str, has_errors: bool) -> String {
    let text = fs::read_to_string(repository(&format!("tests/cases/machines/{language}.toml"))).unwrap();
    // Without an entry of Z, each motion of Z is a warning.
    let text = text + "[[motion]]\ncomponent = \"EZZ\"\nkind = \"polynomial\"\ncoefficients = [0, 0]\n";
    let errors = "
[[motion]]
component = \"EXX\"
kind = \"polynomial\"
coefficients = [0, 1.0e-04, -2.0e-07]
[[motion]]
component = \"EYX\"
kind = \"polynomial\"
coefficients = [0, -8.0e-05, 3.0e-07]
[[motion]]
component = \"EZY\"
kind = \"polynomial\"
coefficients = [0, 5.0e-05]
";
    if has_errors { text + errors } else { text }
}

/// The machine with another radius of its tool.
fn machine(language: &str, radius_mm: f64) -> Machine {
    let source = Source::new(FileId(0), "machine.toml", machine_text(language, false).into_bytes()).unwrap();
    let mut machine = ncfix_model::file::load(&source).0.unwrap().0;
    machine.tools[0].radius_mm = radius_mm;
    machine
}

/// A motion: line, from where, and itself.
type Leg = (u32, Move, [f64; 3]);

/// What a control does with a program whose register holds a radius; no finding is an error.
fn executed(language: &str, text: &str, radius_mm: f64) -> Vec<Leg> {
    let machine = machine(language, radius_mm);
    let source = Source::new(FileId(0), file(language), text.as_bytes().to_vec()).unwrap();
    let (program, found) = syntax::parse(&source, ncfix_dialect::find(language).unwrap());
    assert!(found.iter().all(|one| !one.is_error()), "{found:?}\n{text}");
    let mut legs = Vec::new();
    let mut place = [0.0; 3];
    for item in Execution::new(program, &machine, Box::new(NoLibrary), Options::default()) {
        let element = item.unwrap_or_else(|found| {
            assert!(!found.is_error(), "radius {radius_mm}: {} {:?}\n{text}", found.message, found.place);
            ncfix_machine::snc::Element {
                origin: ncfix_machine::snc::Origin::default(),
                starts_block: false,
                number: None,
                kind: Kind::Empty,
            }
        });
        if let Kind::Move(motion) = element.kind {
            legs.push((element.origin.line, motion, place));
            let target = motion.target.xyz();
            place = [target[0], target[1], target[2]];
        }
    }
    legs
}

/// Points along a motion, so far apart at most, and at its ends.
fn points((_, motion, from): &Leg, apart_mm: f64) -> Vec<[f64; 3]> {
    let to = motion.target.xyz();
    let Some(arc) = motion.arc else {
        let length = (0..3).map(|k| (to[k] - from[k]).powi(2)).sum::<f64>().sqrt();
        let count = (length / apart_mm).ceil().max(1.0);
        let share = |k: f64| [0, 1, 2].map(|axis| from[axis] + (to[axis] - from[axis]) * k / count);
        return (0..=count as usize).map(|k| share(k as f64)).collect();
    };
    let center = arc.center_mm;
    let angle = |p: [f64; 2]| (p[1] - center[1]).atan2(p[0] - center[0]);
    let (start, end) = (angle([from[0], from[1]]), angle([to[0], to[1]]));
    let turn = std::f64::consts::TAU;
    let mut sweep = if arc.clockwise { (start - end).rem_euclid(turn) } else { (end - start).rem_euclid(turn) };
    if sweep < 1e-6 || turn - sweep < 1e-6 {
        sweep = turn;
    }
    let radii = [from, &[to[0], to[1], to[2]]].map(|p| (p[0] - center[0]).hypot(p[1] - center[1]));
    let count = (sweep * radii[0] / apart_mm.min(0.5)).max(sweep * 20.0).ceil();
    let at = |k: f64| {
        let share = k / count;
        let angle = if arc.clockwise { start - sweep * share } else { start + sweep * share };
        let radius = radii[0] + (radii[1] - radii[0]) * share;
        [center[0] + radius * angle.cos(), center[1] + radius * angle.sin(), from[2] + (to[2] - from[2]) * share]
    };
    (0..=count as usize).map(|k| at(k as f64)).collect()
}

/// A way as straight pieces, arcs to a tenth of a micrometer.
fn way(legs: &[Leg]) -> Vec<[f64; 3]> {
    let pieces = legs.iter().skip(1).map(|leg| points(leg, if leg.1.arc.is_some() { 0.1 } else { 1e9 }));
    pieces.flatten().collect()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// From a point to a way of points.
fn off(point: [f64; 3], way: &[[f64; 3]]) -> f64 {
    let to_piece = |pair: &[[f64; 3]]| {
        let along: [f64; 3] = [0, 1, 2].map(|k| pair[1][k] - pair[0][k]);
        let square: f64 = along.iter().map(|value| value * value).sum();
        let dot: f64 = (0..3).map(|k| (point[k] - pair[0][k]) * along[k]).sum();
        let share = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
        distance(point, [0, 1, 2].map(|k| pair[0][k] + along[k] * share))
    };
    way.windows(2).map(to_piece).fold(f64::INFINITY, f64::min)
}

/// Lines between the one that begins compensation and the one that ends it.
fn between(text: &str) -> std::ops::Range<u32> {
    let at = |from: usize, words: &[&str]| {
        let is_it =
            |line: &str| !line.contains("G90 G40") && words.iter().any(|word| line.split(' ').any(|w| w == *word));
        let found = text.lines().enumerate().skip(from).find(|(_, line)| is_it(line));
        found.unwrap_or_else(|| panic!("no {words:?}\n{text}")).0
    };
    let on = at(0, &["G41", "G42"]);
    let off = at(on, &["G40"]);
    // A line of its own begins it for the next one.
    let alone = usize::from(!text.lines().nth(on).unwrap().contains('X'));
    (on + alone + 2) as u32..(off + 1) as u32
}

fn contour(legs: &[Leg], lines: std::ops::Range<u32>) -> Vec<[f64; 3]> {
    legs.iter().filter(|leg| lines.contains(&leg.0)).flat_map(|leg| points(leg, 0.5)).collect()
}

/// How far two ways of the tool are apart along the contour at most, mm.
fn apart(original: (&[Leg], &str), written: (&[Leg], &str)) -> f64 {
    let own = [contour(original.0, between(original.1)), contour(written.0, between(written.1))];
    let whole = [original.0, written.0].map(way);
    let mut most = 0.0_f64;
    for (points, way) in [(&own[0], &whole[1]), (&own[1], &whole[0])] {
        assert!(points.len() > 50, "a contour is longer");
        let [first, last] = [points[0], points[points.len() - 1]];
        let inner = points.iter().filter(|point| distance(**point, first).min(distance(**point, last)) > ENDS_MM);
        most = inner.map(|point| off(*point, way)).fold(most, f64::max);
    }
    most
}

/// How far the ways may be apart: where controls go around corners by arcs, they do so at the inner ones of a wear below 0.
fn allowed(language: &str, wear_mm: f64) -> f64 {
    let has_arcs = ["rs274", "grundig"].contains(&language) && wear_mm < 0.0;
    ROUNDING_MM + if has_arcs { wear_mm.abs() * (2.0_f64.sqrt() - 1.0) } else { 0.0 }
}

fn fixed(language: &str, text: &str, machine: &str, options: &[&str]) -> (Shop, Run) {
    let shop = Shop::new().file("machine.toml", machine).file(file(language), text);
    let arguments = ["fix", file(language), "-o", "out", "--machine", "machine.toml", "--json"];
    let run = shop.run(arguments.iter().chain(options));
    (shop, run)
}

fn written(language: &str, text: &str, machine: &str) -> (Shop, String) {
    let (shop, run) = fixed(language, text, machine, &["--compensation", "wear"]);
    assert_eq!(run.code, 0, "{language}\n{}{}\n{text}", run.stdout, run.stderr);
    // A machine with errors does not say how its zero was set. Over the long travel of the bench its errors are large.
    let is_asked = |code: &String| !["W0321", "W0408"].contains(&code.as_str());
    let codes: Vec<String> = run.codes().iter().map(ToString::to_string).filter(is_asked).collect();
    assert_eq!(codes, ["W0237"], "{language}\n{}", run.stdout);
    let out = shop.text("out");
    (shop, out)
}

#[test]
fn a_register_with_wear_alone_does_what_the_whole_radius_does() {
    for language in LANGUAGES {
        for one in CONTOURS {
            let text = program(one, language, "");
            let (_, out) = written(language, &text, &machine_text(language, false));
            for wear_mm in WEARS_MM {
                let original = executed(language, &text, RADIUS_MM + wear_mm);
                let corrected = executed(language, &out, wear_mm);
                let apart = apart((&original, &text), (&corrected, &out));
                assert!(
                    apart < allowed(language, wear_mm),
                    "{language}, {}: {apart} mm apart with a wear of {wear_mm}\n{out}",
                    one.name
                );
            }
        }
    }
}

#[test]
fn the_wear_is_not_there_without_it() {
    // The same comparison without wear on the one side is off by it: it can fail.
    for language in LANGUAGES {
        let one = &CONTOURS[0];
        let text = program(one, language, "");
        let (_, out) = written(language, &text, &machine_text(language, false));
        let apart =
            apart((&executed(language, &text, RADIUS_MM + 0.05), &text), (&executed(language, &out, 0.0), &out));
        assert!((apart - 0.05).abs() < 0.022, "{language}: {apart}");
        let wrong = executed(language, &text, RADIUS_MM - 0.05);
        let other = executed(language, &out, 0.05);
        assert!(self::apart((&wrong, &text), (&other, &out)) > 0.09, "{language}");
    }
}

#[test]
fn with_the_errors_of_a_machine_the_contour_moves_by_the_wear_too() {
    for language in LANGUAGES {
        for one in CONTOURS {
            let text = program(one, language, "");
            let machine = machine_text(language, true);
            let (shop, out) = written(language, &text, &machine);
            // At the radius of the register, which is 0, it is the correction that was promised.
            let verified = shop.run(["verify", file(language), "out", "--machine", "machine.toml"]);
            assert_eq!(verified.code, 0, "{language}, {}\n{}{}\n{out}", one.name, verified.stdout, verified.stderr);
            let still = executed(language, &out, 0.0);
            for wear_mm in WEARS_MM {
                let moved = contour(&executed(language, &out, wear_mm), between(&out));
                let way = way(&still);
                let [first, last] = [moved[0], moved[moved.len() - 1]];
                let worst = moved
                    .iter()
                    .filter(|point| distance(**point, first).min(distance(**point, last)) > ENDS_MM)
                    .map(|point| off(*point, &way) - wear_mm.abs())
                    .fold(0.0_f64, |worst, off| worst.max(off));
                // Around an outer corner of straight lines it is further off by the root of 2 at most.
                let corner = wear_mm.abs() * (2.0_f64.sqrt() - 1.0);
                assert!(worst < corner + ROUNDING_MM, "{language}, {}: {worst}\n{out}", one.name);
            }
        }
    }
}

#[test]
fn in_turned_and_mirrored_frames_the_side_is_that_of_the_program() {
    for (language, before) in [
        ("sinumerik", "MIRROR X0"),
        ("sinumerik", "ROT RPL=30"),
        ("sinumerik", "SCALE X2 Y2"),
        ("fanuc", "G51.1 X0."),
        ("fanuc", "G68 X0. Y0. R30."),
        ("grundig", "G73 X-1"),
        ("grundig", "G92 B4=30"),
        ("grundig", "G93 X20 Y10"),
    ] {
        for one in CONTOURS.iter().take(3) {
            let text = program(one, language, before);
            let (_, out) = written(language, &text, &machine_text(language, false));
            for wear_mm in WEARS_MM {
                let original = executed(language, &text, RADIUS_MM + wear_mm);
                let corrected = executed(language, &out, wear_mm);
                let apart = apart((&original, &text), (&corrected, &out));
                // A scaled frame scales the rounding.
                assert!(
                    apart < ROUNDING_MM + allowed(language, wear_mm),
                    "{before}, {}: {apart} mm apart\n{out}",
                    one.name
                );
            }
        }
    }
}

#[test]
fn wear_that_the_control_has_told_is_not_in_the_path() {
    // Radius 5 and wear 0.02 in the tool table: the way is that of radius 5, as the control adds the wear.
    let text = program(&CONTOURS[0], "sinumerik", "");
    let shop = Shop::new()
        .file("machine.toml", machine_text("sinumerik", false))
        .file("part.mpf", &text)
        .file("tools.toa", "%_N_TO_TOA\n$TC_DP1[1,1]=120\n$TC_DP3[1,1]=100\n$TC_DP6[1,1]=5\n$TC_DP15[1,1]=0.02\nM17\n");
    let arguments = ["--machine", "machine.toml", "--setup", "tools.toa"];
    let fix = |out: &str, more: &[&str]| {
        let run = shop.run(["fix", "part.mpf", "-o", out].iter().chain(&arguments).chain(more));
        assert_eq!(run.code, 0, "{}", run.stderr);
        shop.text(out)
    };
    let center = fix("center", &[]);
    let wear = fix("wear", &["--compensation", "wear"]);
    assert!(center.contains("X-5.02 Y40") && !center.contains("G41"), "{center}");
    assert!(wear.contains("X-5 Y40") && wear.contains("G41"), "{wear}");
    let verified = shop.run(["verify", "part.mpf", "wear"].iter().chain(&arguments));
    assert_eq!(verified.code, 0, "{}{}", verified.stdout, verified.stderr);
    // The text of the program does not show what is in the register: a person must look.
    verified.says("W0237");
    shop.run(["diff", "part.mpf", "wear"].iter().chain(&arguments)).says("W0237");
    assert!(!shop.run(["verify", "part.mpf", "center"].iter().chain(&arguments)).stderr.contains("W0237"));
    let guarded =
        shop.run(["fix", "part.mpf", "-o", "guarded", "--compensation", "wear", "--guard"].iter().chain(&arguments));
    guarded.exits(0).says("not that tool radii are 0");
    // The whole radius in the path and the register of the control is what verify sees where the stamp is gone.
    let bare: String = wear.lines().filter(|line| !line.contains("ncfix")).map(|line| format!("{line}\n")).collect();
    let shop = shop.file("bare", bare);
    let verified = shop.run(["verify", "part.mpf", "bare"].iter().chain(&arguments));
    assert_ne!(verified.code, 0, "{}{}", verified.stdout, verified.stderr);
    // Nobody corrects it again.
    let again = shop.run(["fix", "wear", "-o", "again", "--json"].iter().chain(&arguments));
    assert_eq!(again.codes(), ["E0301"], "{}", again.stdout);
}

#[test]
fn what_the_control_could_not_follow_is_not_written() {
    // An inner arc of 5.1 beside which the way of the tool center has a radius of 0.1.
    const NARROW: Contour = Contour {
        name: "narrow",
        code: 41,
        from: [-30.0, 10.0],
        blocks: &[To(0.0, 0.0), To(30.0, 0.0), Ccw([35.1, 5.1], [30.0, 5.1]), To(35.1, 40.0)],
        off: [20.0, 60.0],
    };
    for language in LANGUAGES {
        let text = program(&NARROW, language, "");
        let machine = machine_text(language, false);
        let run = |options: &[&str]| fixed(language, &text, &machine, options);
        let (shop, refused) = run(&["--compensation", "wear"]);
        assert_eq!(refused.codes(), ["E0234", "W0237"], "{language}: {}", refused.stdout);
        assert!(!shop.path("out").exists());
        let (_, small) = run(&["--compensation", "wear", "--largest-wear", "0.08mm"]);
        assert_eq!((small.code, small.codes()), (0, vec!["W0237".to_owned()]), "{language}: {}", small.stdout);
        let (_, center) = run(&[]);
        assert_eq!(center.codes(), ["W0236"], "{language}");
    }
}

#[test]
fn a_program_that_sets_the_radius_itself_would_have_it_twice() {
    // The output keeps such a block, and the operator's 0 would be overwritten in front of G41.
    let setting = |language: &str| -> &'static [&'static str] {
        match language {
            "fanuc" => &["G10 L12 P1 R5.02", "#13001=5.02"],
            "rs274" => &["G10 L1 P1 R5.02"],
            "sinumerik" => &["$TC_DP6[1,1]=5.02"],
            _ => &[],
        }
    };
    let of_wear = |language: &str| match language {
        "fanuc" => "G10 L13 P1 R0.02",
        "sinumerik" => "$TC_DP15[1,1]=0.02",
        _ => "",
    };
    for language in LANGUAGES {
        let machine = machine_text(language, false);
        for before in setting(language) {
            let text = program(&CONTOURS[0], language, before);
            let (shop, refused) = fixed(language, &text, &machine, &["--compensation", "wear"]);
            assert!(refused.codes().contains(&"E0234".to_owned()), "{before}: {}{}", refused.stdout, refused.stderr);
            assert!(refused.stdout.contains("twice") && !shop.path("out").exists(), "{before}: {}", refused.stdout);
            let (_, center) = fixed(language, &text, &machine, &[]);
            assert_eq!((center.code, center.codes()), (0, vec!["W0236".to_owned()]), "{before}: {}", center.stdout);
        }
        // Wear that the program sets is for the control alone.
        let text = program(&CONTOURS[0], language, of_wear(language));
        let (_, kept) = written(language, &text, &machine);
        assert!(kept.contains(of_wear(language).trim_end_matches("R0.02")), "{language}: {kept}");
    }
}
