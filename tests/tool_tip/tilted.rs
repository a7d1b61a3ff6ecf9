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
