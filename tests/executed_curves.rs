//! "error after" of curves that are executed as arcs and chords, beside a judge of its own: the corrected text, read here, a machine of two errors written down here, and the
//! exact curve, sampled densely.

use crate::cli_diff::MILL;
use crate::support::Shop;

type Point = [f64; 2];

/// Where the tip of the machine of [`MILL`] is when X and Y are commanded: squareness of Y 100 µrad, scale of X 40 µm/m.
fn tip([x, y]: Point) -> Point {
    [x + 4e-5 * x - 1e-4 * y, y]
}

/// A word of a line, where it has one.
fn word(line: &str, letter: char) -> Option<f64> {
    let line = line.split(';').next().unwrap();
    line.split_whitespace().find_map(|word| word.strip_prefix(letter)?.trim_start_matches('=').parse().ok())
}

/// Places of X and Y along the lines and arcs of a corrected program, after the line with a text, scaled as there; and the number of its moves.
fn way(text: &str, after: &str, scale: f64) -> (Vec<Point>, usize) {
    let (mut at, mut motion) = ([f64::NAN; 2], 1);
    let (mut out, mut moves) = (Vec::new(), 0);
    let mut is_wanted = false;
    for line in text.lines() {
        let is_move = !line.contains("SCALE") && !line.contains("G4");
        let before = at;
        if let Some(word) = ["G0", "G1", "G2", "G3"].iter().position(|word| line.split(' ').any(|own| own == *word)) {
            motion = word;
        }
        if is_move {
            at = [word(line, 'X').map_or(at[0], |x| x * scale), word(line, 'Y').unwrap_or(at[1])];
        }
        if is_wanted && at != before {
            moves += 1;
            let center = [word(line, 'I'), word(line, 'J')].map(Option::unwrap_or_default);
            out.extend((0..=60).map(|k| on_piece(motion, [before, at], center, f64::from(k) / 60.0)));
        }
        is_wanted |= line.contains(after);
    }
    (out, moves)
}

/// A place on a line or an arc; the center is given from the start.
fn on_piece(motion: usize, [from, to]: [Point; 2], center: Point, share: f64) -> Point {
    if motion < 2 {
        return [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * share);
    }
    let middle = [from[0] + center[0], from[1] + center[1]];
    let [first, last] = [from, to].map(|end| (end[1] - middle[1]).atan2(end[0] - middle[0]));
    let [begin, end] = [from, to].map(|end| (end[1] - middle[1]).hypot(end[0] - middle[0]));
    let sense = if motion == 3 { 1.0 } else { -1.0 };
    let angle = first + sense * (sense * (last - first)).rem_euclid(std::f64::consts::TAU) * share;
    let radius = begin + (end - begin) * share;
    [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin()]
}

/// The largest distance of the tip from a dense curve at places in order, µm.
fn farthest_um(places: &[Point], curve: &[Point]) -> f64 {
    let mut worst = 0.0_f64;
    let mut near = 0;
    for place in places {
        let at = tip(*place);
        // The nearest piece of the curve is near the last one.
        let from = near;
        let mut least = f64::INFINITY;
        for place in from..(from + 8000).min(curve.len() - 1) {
            let distance = of_piece(at, curve[place], curve[place + 1]);
            if distance < least {
                (least, near) = (distance, place.saturating_sub(200));
            }
        }
        worst = worst.max(least);
    }
    1e3 * worst
}

fn of_piece(at: Point, from: Point, to: Point) -> f64 {
    let way = [to[0] - from[0], to[1] - from[1]];
    let off = [at[0] - from[0], at[1] - from[1]];
    let share = ((off[0] * way[0] + off[1] * way[1]) / (way[0] * way[0] + way[1] * way[1])).clamp(0.0, 1.0);
    (off[0] - share * way[0]).hypot(off[1] - share * way[1])
}

/// Corrects, and compares what three commands say with the judge.
#[track_caller]
fn judged(
    name: &str,
    machine: &str,
    program: &str,
    (after, scale, most): (&str, f64, usize),
    curve: impl Fn(f64) -> Point,
) {
    let shop = Shop::new().file("mill.toml", machine).file(name, program);
    let out = format!("out{}", &name[name.find('.').unwrap()..]);
    let max = |json: &serde_json::Value| json["after"]["max_um"].as_f64().unwrap();
    let told = max(&shop.run(["fix", name, "-o", &out, "--machine", "mill.toml", "--json"]).exits(0).json());
    let verified = max(&shop.run(["verify", name, &out, "--machine", "mill.toml", "--json"]).exits(0).json());
    let reviewed = max(&shop.run(["diff", name, &out, "--machine", "mill.toml", "--json"]).exits(1).json());
    assert!((verified - told).abs() < 0.02 && (reviewed - told).abs() < 0.02, "{told} {verified} {reviewed}");
    let dense: Vec<Point> = (0..=200_000).map(|k| curve(f64::from(k) / 200_000.0)).collect();
    let (places, moves) = way(&shop.text(&out), after, scale);
    assert!(moves > 2 && moves <= most, "{moves} moves\n{}", shop.text(&out));
    let true_um = farthest_um(&places, &dense);
    // Along the path and across it are added, not squared: some more is told, nothing less.
    assert!(told >= true_um - 0.01 && told <= true_um + 0.15, "{name}: {told} told, {true_um} true");
    // Rounding to 0.1 µm alone leaves less: the arcs or chords of the curve are in it.
    assert!(true_um > 0.1, "{true_um}");
}

#[test]
fn an_arc_in_a_scaled_frame_is_an_ellipse() {
    let program = "N10 G90 G17 G71 G94 G54\nN15 D0\nN20 SCALE X3\nN30 G0 X20 Y0 Z5\nN40 G1 Z-1 F500\nN50 G3 X-20 Y0 I-20 J0\nN60 M30\n";
    judged("part.mpf", MILL, program, ("N40 ", 3.0, 1000), |share| {
        let (sine, cosine) = (std::f64::consts::PI * share).sin_cos();
        [60.0 * cosine, 20.0 * sine]
    });
}

#[test]
fn a_polynomial_is_arcs() {
    // y = 60 p² - 40 p³ + (30 - 20) p, x = 80 p.
    let program = "N10 G90 G17 G71 G94 G54\nN15 D0\nN30 G0 X0 Y0 Z5\nN40 G1 Z-1 F500\nN50 POLY PO[X]=(80) PO[Y]=(30,60,-40)\nN60 M30\n";
    judged("part.mpf", MILL, program, ("N40 ", 1.0, 40), |p| [80.0 * p, 10.0 * p + 60.0 * p * p - 40.0 * p.powi(3)]);
}

#[test]
fn a_cubic_spline_of_rs274_is_arcs() {
    let machine = MILL.replace("sinumerik", "rs274");
    let program = "G21 G90 G17 G54\nG0 X0 Y0 Z5\nG1 Z-1 F500\nG5 X90 Y60 I50 J0 P-40 Q-10\nG0 Z5\nM2\n";
    let control = [[0.0, 0.0], [50.0, 0.0], [50.0, 50.0], [90.0, 60.0]];
    judged("part.ngc", &machine, program, ("Z-1", 1.0, 40), |share| {
        let rest = 1.0 - share;
        let weights = [rest.powi(3), 3.0 * rest * rest * share, 3.0 * rest * share * share, share.powi(3)];
        [0, 1].map(|axis| (0..4).map(|k| weights[k] * control[k][axis]).sum())
    });
}

/// Reversals within arcs and beside their rounded ends: fix and verify say the same of them.
#[test]
fn backlash_in_arcs_is_one_number() {
    // The first rapid move comes from anywhere; the second one leads X and Y through their play.
    let program = "G21 G90 G54 G17\nS1000 M3\nG0 X90 Y90 Z5\nG0 X100 Y100\nG1 Z-1 F500\nG1 X171.604 Y298.625\nG3 X249.634 Y337.295 I43.532 J10.221\n\
                   G3 X318.873 Y394.174 I21.239 J44.727\nG3 X313.621 Y397.118 I-3.823 J-0.663\nG0 Z5\nM2\n";
    for increment in ["0.001", "0.0001"] {
        for value in ["20", "-20"] {
            let play = |axis: &str| {
                format!("[[motion]]\ncomponent = \"E{axis}{axis}\"\nkind = \"backlash\"\nvalue_um = {value}\n")
            };
            let machine = MILL.replace("sinumerik", "rs274").replace(
                "[location]",
                &format!("[control]\nincrement_mm = {increment}\narc_tolerance_mm = 0.01\n[location]"),
            ) + &play("X")
                + &play("Y");
            let shop = Shop::new().file("mill.toml", &machine).file("part.ngc", program);
            let max = |json: &serde_json::Value| json["after"]["max_um"].as_f64().unwrap();
            let told = max(&shop
                .run(["fix", "part.ngc", "-o", "out.ngc", "--machine", "mill.toml", "--json"])
                .exits(0)
                .json());
            let verified =
                max(&shop.run(["verify", "part.ngc", "out.ngc", "--machine", "mill.toml", "--json"]).exits(0).json());
            // Where on the way a piece ends is found by the nearest place, which hides rounding along the way.
            let rounding_um = 250.0 * increment.parse::<f64>().unwrap();
            assert!((told - verified).abs() < rounding_um && told < 1.1, "{increment} {value}: {told} {verified}");
        }
    }
}
