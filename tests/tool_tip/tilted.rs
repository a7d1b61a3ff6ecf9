//! A tilted plane on machines with a head: the output keeps it, and its arcs, by the judge of the tip.

use super::{Square, TipBlock, blocks, fixed, minus, product, rigid, rigs, size};

/// The tolerance, the rounding of three coordinates to 0.1 µm, and that of two angles to 0.0001 degrees at 60 mm, mm.
const LIMIT_MM: f64 = 1e-3 + 0.5e-4 * 1.7321 + 2.0 * 0.5e-4 * 0.017_45 * 60.0;
/// Places of a piece, and of a block of the source.
const PLACES: u32 = 16;
const STEPS: u32 = 4000;

/// The plane of a line with G68.2: its origin, and its rotation Rz(I) Rx(J) Rz(K).
fn plane(text: &str) -> Square {
    let line = text.lines().find(|line| line.contains("G68.2")).unwrap();
    let value = |letter: char| {
        let word = line.split_whitespace().find_map(|word| word.strip_prefix(letter));
        word.map_or(0.0, |word| word.parse::<f64>().unwrap())
    };
    let zero = [0.0; 3];
    let turns = [[0.0, 0.0, value('I')], [value('J'), 0.0, 0.0], [0.0, 0.0, value('K')]];
    let turned = turns.map(|turn| rigid(zero, turn.map(f64::to_radians)));
    let origin = rigid([value('X'), value('Y'), value('Z')], zero);
    turned.iter().fold(origin, |all, next| product(&all, next))
}

/// A point of a plane in the workpiece.
fn placed(plane: &Square, point: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|row| plane[row][3] + (0..3).map(|k| plane[row][k] * point[k]).sum::<f64>())
}

/// Blocks within the plane: G53.1 begins and G69 ends it.
fn blocks_of_plane(text: &str) -> Vec<TipBlock> {
    blocks(&text.replace("G53.1", "G43.4").replace("G69", "G49"))
}

#[test]
fn a_plane_of_a_head_stays_with_its_arcs() {
    for rig in rigs().into_iter().filter(|rig| ["mixed", "heads"].contains(&rig.name)) {
        let [a, b] = rig.rotary.map(char::from);
        let text = format!(
            "%\nO1\nN10 G21 G17 G90 G40 G49 G80 G94\nN20 T1 M6\nN30 G54 G0 X0. Y0. {a}0. {b}0. S8000 M3\nN40 G43 H1 Z250.\nN50 G68.2 X10. Y20. \
             Z5. I30. J25. K-30.\nN60 G53.1\nN100 G0 X0. Y0.\nN105 Z2.\nN110 G1 Z-3. F300.\nN120 X40. F800.\nN130 G3 X40. Y30. I0 J15.\nN140 G1 \
             X0.\nN150 G3 X0. Y0. I0 J-15.\nN160 G1 X20. Y15.\nN170 G3 X20. Y15. I6. J0\nN180 G0 Z50.\nN190 G69\nN200 G49\nN210 M30\n%\n"
        );
        let (shop, out) = fixed(&rig, "fanuc", &text, true);
        let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
        assert_eq!(run.code, 0, "{}: {}{}\n{out}", rig.name, run.stdout, run.stderr);
        let planes = [&text, &out].map(|text| plane(text));
        let pieces: Vec<TipBlock> = blocks_of_plane(&out).into_iter().filter(|piece| piece.motion > 0).collect();
        assert!(pieces.len() <= 14, "{}: {}\n{out}", rig.name, pieces.len());
        assert!(pieces.iter().filter(|piece| piece.motion == 3).count() >= 3, "{}\n{out}", rig.name);
        for block in blocks_of_plane(&text).iter().filter(|block| block.motion > 0) {
            let path: Vec<[f64; 3]> =
                (0..=STEPS).map(|k| placed(&planes[0], &block.tip(f64::from(k) / f64::from(STEPS)))).collect();
            for piece in pieces.iter().filter(|piece| piece.number == block.number) {
                for place in 0..=PLACES {
                    let share = f64::from(place) / f64::from(PLACES);
                    let mut words = piece.at(share);
                    for (letter, value) in b"XYZ".iter().zip(placed(&planes[1], &piece.tip(share))) {
                        words.insert(*letter, value);
                    }
                    let tip = rig.tip(&rig.commands(&words), 1.0);
                    let off = path.windows(2).map(|way| off_mm(&tip, way)).fold(f64::INFINITY, f64::min);
                    assert!(off < LIMIT_MM, "{} N{}: {off}\n{out}", rig.name, block.number);
                }
            }
        }
    }
}

/// Distance of a point from a line between two others, mm.
fn off_mm(point: &[f64; 3], way: &[[f64; 3]]) -> f64 {
    let (step, from) = (minus(&way[1], &way[0]), minus(point, &way[0]));
    let square: f64 = step.iter().map(|part| part * part).sum();
    let along: f64 = step.iter().zip(from).map(|(one, other)| one * other).sum();
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    size(&std::array::from_fn(|k| from[k] - share * step[k]))
}

/// Tolerance of holes, and the rounding of three coordinates to 1 µm, mm.
const HOLE_LIMIT_MM: f64 = 2e-3 + 0.5e-3 * 1.7321;

/// The tip at the reference plane and at the bottom of each hole of G83, in the plane, with the rotary axes there.
fn holes(text: &str) -> Vec<[super::Values; 2]> {
    let mut values: super::Values = b"XYZRABC".iter().map(|&letter| (letter, 0.0)).collect();
    let (mut is_on, mut out) = (false, Vec::new());
    for line in text.lines().filter(|line| !line.contains("G68.2")) {
        is_on = (is_on || line.contains("G83")) && !line.contains("G80");
        let mut is_hole = false;
        for word in line.split_whitespace() {
            let (letter, value) = (word.as_bytes()[0], word[1..].parse::<f64>());
            let Ok(value) = value else { continue };
            if values.contains_key(&letter) {
                values.insert(letter, if letter < b'D' { value.to_radians() } else { value });
            }
            is_hole |= is_on && (letter == b'X' || letter == b'Y');
        }
        if is_hole {
            let at = |height: f64| {
                let mut place = values.clone();
                place.insert(b'Z', height);
                place
            };
            out.push([at(values[&b'R']), at(values[&b'Z'])]);
        }
    }
    out
}

/// Three pecked holes in a tilted plane of a head: 13 lines of pecks each, or one.
#[test]
fn holes_in_a_tilted_plane_of_a_head_stay_one_line_each() {
    for rig in rigs().into_iter().filter(|rig| ["mixed", "heads"].contains(&rig.name)) {
        let [a, b] = rig.rotary.map(char::from);
        let text = format!(
            "%\nO1\nN10 G21 G17 G90 G40 G49 G80 G94\nN20 T1 M6\nN30 G54 G0 X0. Y0. {a}0. {b}0. S8000 M3\nN40 G43 H1 Z250.\nN50 G68.2 X10. Y20. \
             Z5. I30. J25. K-30.\nN60 G53.1\nN100 G0 X0. Y0.\nN105 Z5.\nN110 G98 G83 X10. Y10. Z-20. R2. Q5. F300.\nN120 X40. Y10.\nN130 X40. \
             Y60.\nN140 G80\nN180 G0 Z50.\nN190 G69\nN200 G49\nN210 M30\n%\n"
        );
        let (shop, out) = fixed(&rig, "fanuc", &text, true);
        let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
        assert_eq!(run.code, 0, "{}: {}{}\n{out}", rig.name, run.stdout, run.stderr);
        let planes = [&text, &out].map(|text| plane(text));
        let (wanted, found) = (holes(&text), holes(&out));
        assert!(wanted.len() == 3 && found.len() == 3 && !out.contains("G1 "), "{}\n{out}", rig.name);
        for (wanted, found) in wanted.iter().zip(&found).flat_map(|(wanted, found)| wanted.iter().zip(found)) {
            let point = |values: &super::Values| [values[&b'X'], values[&b'Y'], values[&b'Z']];
            let mut words = found.clone();
            for (letter, value) in b"XYZ".iter().zip(placed(&planes[1], &point(found))) {
                words.insert(*letter, value);
            }
            let off = size(&minus(&rig.tip(&rig.commands(&words), 1.0), &placed(&planes[0], &point(wanted))));
            assert!(off < HOLE_LIMIT_MM, "{}: {off} {found:?}\n{out}", rig.name);
        }
    }
}
