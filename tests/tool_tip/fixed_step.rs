//! The largest fixed step along a path of the tip, against what the judge finds at this step and at a larger one.

use super::{judged, rigs};
use crate::support::Shop;

/// Residual of the step, and that of the rounding of three coordinates to 0.1 µm, mm.
const RESIDUAL_MM: f64 = 1e-3;
const ROUNDING_MM: f64 = 0.5e-4 * 1.7321;

#[test]
fn the_largest_step_is_one_of_the_tip() {
    for rig in rigs() {
        let [a, b] = rig.rotary.map(char::from);
        let text = format!(
            "N10 G17 G90 G71 G94 G54\nN20 T1 M6\nN30 D1 S8000 M3\nN35 G0 X-50 Y-30 Z250 {a}0 {b}0\nN40 TRAORI\nN45 ORIAXES\nN50 G0 X-60 Y-50 \
             Z40 {a}5 {b}10\nN60 G1 X60 Y40 Z30 {a}25 {b}120 F2000\nN140 TRAFOOF\nN150 G0 Z400\nN160 M30\n"
        );
        let shop = Shop::new().file("rig.toml", rig.file("sinumerik", true)).file("part.nc", &text);
        let run = shop.run(["max-step", "part.nc", "--machine", "rig.toml", "--residual", "1um", "--json"]).exits(0);
        let step_mm = run.json()["largest_step_mm"].as_f64().unwrap();
        let worst_mm = |step_mm: f64, out: &str| {
            let step = format!("{step_mm:.4}mm");
            let words =
                ["fix", "part.nc", "--machine", "rig.toml", "-o", out, "--max-correction", "0.5mm", "--step", &step];
            shop.run(words).exits(0);
            judged(&rig, &text, &shop.text(out)).1
        };
        let [at, beyond] = [worst_mm(step_mm, "at.nc"), worst_mm(1.5 * step_mm, "beyond.nc")];
        assert!(at < RESIDUAL_MM + ROUNDING_MM, "{} {step_mm}: {at}", rig.name);
        assert!(beyond > RESIDUAL_MM, "{} {step_mm}: {beyond}", rig.name);
    }
}
