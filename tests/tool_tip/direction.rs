//! The direction of the tool along corrected pieces, near the pole too, by the judge of the tip.

use super::{Rig, TipBlock, blocks, fixed, minus, rigs, size};

/// The tolerance at the arm of a cutting edge, 1 µm / 50 mm, and two increments of 0.0001 degrees, µrad.
const ROOM_URAD: f64 = 20.0 + 2.0 * 1.745;
/// Places of a block at which directions are compared, and of a piece.
const STEPS: u32 = 2000;
const PLACES: u32 = 12;

/// The smallest angle between a direction and those of a block, µrad.
fn off_urad(rig: &Rig, block: &TipBlock, direction: &[f64; 3]) -> f64 {
    let off = |share: f64| size(&minus(&rig.direction(&block.at(share), 0.0), direction));
    let all = (0..=STEPS).map(|k| f64::from(k) / f64::from(STEPS));
    let best = all.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
    let half = 1.0 / f64::from(STEPS);
    let (mut low, mut high) = ((best - half).max(0.0), (best + half).min(1.0));
    for _ in 0..60 {
        let third = (high - low) / 3.0;
        if off(low + third) < off(high - third) { high -= third } else { low += third }
    }
    off(low.midpoint(high)) * 1e6
}

/// The tool turns about its tip to nearly vertical while C turns far, and back.
#[test]
fn the_direction_near_the_pole_is_the_one_that_is_claimed() {
    for rig in rigs().into_iter().filter(|rig| ["tables", "mixed"].contains(&rig.name)) {
        let [a, b] = rig.rotary.map(char::from);
        let text = format!(
            "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S8000 M3\nN35 G0 X-50 Y-30 Z250 {a}0 {b}0\nN40 TRAORI\nN45 ORIAXES\nN50 G0 X-10 Y70 \
             Z25 {a}-60\nN60 G1 X-15 Y75 Z20 {a}-65 {b}2 F2000\nN70 G1 {a}0.01 {b}165\nN80 G1 X20 Y60 {a}-40 {b}160\nN140 TRAFOOF\nN150 G0 Z400\nN160 M30\n"
        );
        let (shop, out) = fixed(&rig, "sinumerik", &text, true);
        let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
        assert_eq!(run.code, 0, "{}: {}{}\n{out}", rig.name, run.stdout, run.stderr);
        let run = shop.run(["fix", "part.nc", "--machine", "rig.toml", "-o", "again.nc", "--max-correction", "0.5mm"]);
        let claim = run.stdout.lines().chain(run.stderr.lines()).find_map(|line| line.strip_prefix("tool tilt"));
        let claim: f64 = claim.and_then(|line| line.split_whitespace().nth(2)).unwrap_or("0").parse().unwrap();
        let pieces = blocks(&out);
        for block in blocks(&text).iter().filter(|block| block.motion == 1) {
            for piece in pieces.iter().filter(|piece| piece.number == block.number) {
                for place in 0..=PLACES {
                    let words = piece.at(f64::from(place) / f64::from(PLACES));
                    let off = off_urad(&rig, block, &rig.direction(&rig.commands(&words), 1.0));
                    assert!(off < claim + ROOM_URAD, "{} N{}: {off} {claim} urad\n{out}", rig.name, block.number);
                }
            }
        }
    }
}

/// The plane of both directions holds the pole: only the tilting axis turns, and the corrected tool passes the pole aside by its tilt.
#[test]
fn a_great_circle_through_the_pole_reads_back() {
    for rig in rigs().into_iter().filter(|rig| ["tables", "mixed"].contains(&rig.name)) {
        let [a, b] = rig.rotary.map(char::from);
        let text = format!(
            "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S8000 M3\nN35 G0 X-50 Y-30 Z250 {a}0 {b}0\nN40 TRAORI\nN45 ORIVECT\nN50 G0 X-10 Y70 \
             Z25 {a}30 {b}50\nN60 G1 X-60 Y40 Z20 {a}-25 F2000\nN70 G0 X20 {a}28\nN140 TRAFOOF\nN150 G0 Z400\nN160 M30\n"
        );
        let (shop, out) = fixed(&rig, "sinumerik", &text, true);
        let run = shop.run(["verify", "part.nc", "out.nc", "--machine", "rig.toml"]);
        assert_eq!(run.code, 0, "{}: {}{}\n{out}", rig.name, run.stdout, run.stderr);
    }
}
