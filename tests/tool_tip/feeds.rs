//! The time of short ways beside a large turn: that of the source, by the words of the output alone.

use super::{TipBlock, blocks, fixed, framed, minus, rigs, size};

/// Largest relative difference of a time: that of the feed that is written, and of rounded ways.
const SAME_TIME: f64 = 0.01;

/// Minutes of a block: G93 states their reciprocal, and F is that of the tip.
fn minutes(block: &TipBlock) -> f64 {
    if block.is_by_time {
        return 1.0 / block.feed;
    }
    let way: f64 =
        (0..200).map(|k| size(&minus(&block.tip(f64::from(k) / 200.0), &block.tip(f64::from(k + 1) / 200.0)))).sum();
    way / block.feed
}

/// The tip moves by 5 µm to 2 mm along lines and a small arc while axes turn by tens of degrees.
#[test]
fn a_short_way_beside_a_large_turn_takes_its_time() {
    for rig in rigs() {
        let [a, b] = rig.rotary.map(char::from);
        let cuts = format!(
            "N50 G0 X-50 Y-30 Z40 {a}4 {b}12\nN60 G1 Z3 F500\nN70 X-50.02 {a}18 {b}40 F20\nN80 Y-29 {a}9 {b}100\nN90 Y-29.005 {a}14\nN100 X-48 \
             Y-28 {b}60\nN110 G3 X-48 Y-26 I0 J1 {a}24\nN120 G1 X-47.9 {a}10 {b}200 F3\nN130 G0 Z60\n"
        );
        for control in ["sinumerik", "fanuc"] {
            let text = framed(&rig, control, &cuts);
            let (shop, out) = fixed(&rig, control, &text, true);
            let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
            assert_eq!(run.code, 0, "{} {control}: {}{}\n{out}", rig.name, run.stdout, run.stderr);
            let pieces = blocks(&out);
            for block in blocks(&text).iter().filter(|block| (70..130).contains(&block.number)) {
                let own: Vec<&TipBlock> = pieces.iter().filter(|piece| piece.number == block.number).collect();
                let taken: f64 = own.iter().map(|piece| minutes(piece)).sum();
                let share = taken / minutes(block);
                assert!((share - 1.0).abs() < SAME_TIME, "{} {control} N{}: {share}\n{out}", rig.name, block.number);
                // Each piece has the share of the time that it has of the turn.
                let letter = *b"ABC".iter().max_by(|x, y| turn(block, **x).total_cmp(&turn(block, **y))).unwrap();
                for piece in own {
                    let share = minutes(piece) / taken * turn(block, letter) / turn(piece, letter);
                    assert!((share - 1.0).abs() < 1.5 * SAME_TIME, "{} {control} {piece:?}: {share}\n{out}", rig.name);
                }
            }
        }
    }
}

fn turn(block: &TipBlock, letter: u8) -> f64 {
    (block.to[&letter] - block.from[&letter]).abs()
}
