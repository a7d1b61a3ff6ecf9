//! Explanations on a plant of its own: a machine with three axes in closed form, ball-bar circles in three planes.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::cli_calibrate::bare;
use crate::plant::Random;
use ncfix_base::source::{FileId, Source};
use ncfix_metrology::diagnose::Scene;
use ncfix_metrology::diagnose::explain::{Explained, explain};
use ncfix_metrology::measure::data::load;

/// Errors of a machine whose table moves in X and Y and whose spindle moves in Z: the displacement of the tool from the workpiece, mm.
#[derive(Clone, Copy, Default)]
pub(crate) struct Plant {
    /// Squareness X–Y, Z–X, Z–Y, rad: EC0X, EB0Z, EA0Z.
    pub(crate) squareness: [f64; 3],
    /// Slopes of the positioning errors.
    pub(crate) scale: [f64; 3],
    /// Reversal values, mm.
    pub(crate) backlash: [f64; 3],
}

/// Description of its measurement.
pub(crate) const DESCRIPTION: &str = "[measurement]\nkind = \"ballbar\"\nfree = [\"centre\"]\nsigma_um = 0.5\n\
                                      [setup.A]\ncentre_mm = [350, 250, 150]\nlength_mm = 100\n";

impl Plant {
    /// The table turned by c about Z carries the direction of X with it: X is longer by c·Y. Z tilted by b about Y leads the tool by b·Z along X, by a about X by −a·Z along Y.
    fn error(&self, at: [f64; 3], senses: [f64; 3]) -> [f64; 3] {
        let [c, b, a] = self.squareness;
        let mut out = [c * at[1] + b * at[2], -a * at[2], 0.0];
        for k in 0..3 {
            out[k] += self.scale[k] * at[k] + 0.5 * self.backlash[k] * senses[k];
        }
        out
    }

    /// Circles of 100 mm about a ball on the table in both senses: a whole one in XY, 220° in ZX and YZ. Noise of 0.5 µm.
    pub(crate) fn measured(&self, seed: u64) -> String {
        let mut random = Random::new(seed, "explain");
        let mut table = "run,setup,X,Y,Z,X_dir,Y_dir,Z_dir,tool_z_mm,dr_um\n".to_owned();
        // First and second axis of the plane, from where, how far.
        for (plane, [first, second], from, sweep) in
            [("XY", [0, 1], 0.0, 360.0), ("ZX", [2, 0], -20.0, 220.0), ("YZ", [1, 2], -20.0, 220.0)]
        {
            for (name, sense) in [("ccw", 1.0), ("cw", -1.0)] {
                let count = (sweep / 2.0) as usize;
                for k in 0..count {
                    let swept = 2.0 * k as f64;
                    // The part of a circle that is driven is on the side of the tool.
                    let start = if plane == "ZX" { from - 90.0 } else { from };
                    let angle: f64 = (if sense > 0.0 { start + swept } else { start + sweep - swept }) * TAU / 360.0;
                    let [cos, sin] = [angle.cos(), angle.sin()];
                    let (mut along, mut senses) = ([0.0; 3], [1.0; 3]);
                    (along[first], along[second]) = (cos, sin);
                    senses[first] = if sense * sin > 0.0 { -1.0 } else { 1.0 };
                    senses[second] = if sense * cos < 0.0 { -1.0 } else { 1.0 };
                    let at = [350.0 + 100.0 * along[0], 250.0 + 100.0 * along[1], 300.0 + 100.0 * along[2]];
                    let error = self.error(at, senses);
                    let dr: f64 = (0..3).map(|k| error[k] * along[k]).sum();
                    let dr_um = 1e3 * dr + 0.5 * random.normal();
                    let ([x, y, z], [sx, sy, sz]) = (at, senses);
                    let _ = writeln!(table, "{plane}-{name},A,{x:.6},{y:.6},{z:.6},{sx},{sy},{sz},-150,{dr_um:.5}");
                }
            }
        }
        table
    }

    fn explained(&self, seed: u64) -> Explained {
        let source = |id, name, text: &str| Source::new(FileId(id), name, text.as_bytes().to_vec()).unwrap();
        let (read, _) = ncfix_model::file::load(&source(0, "m.toml", &bare("demo")));
        let (machine, errors) = read.unwrap();
        let table = self.measured(seed);
        let (data, findings) = load("d", &source(1, "d.csv", &table), &source(2, "d.toml", DESCRIPTION), &machine);
        let sets = [data.unwrap_or_else(|| panic!("{findings:?}"))];
        explain(&Scene::new(&machine, &errors, &sets).unwrap())
    }
}

/// Names of the most probable explanation, sorted.
fn named(found: &Explained) -> Vec<String> {
    let mut names: Vec<String> = found.explanations[0].set.iter().map(|&k| found.terms[k].name()).collect();
    names.sort();
    names
}

#[test]
fn squareness_scales_and_backlashes_are_explained_together_with_their_sizes() {
    let (mut right, mut stated, mut inside, mut all) = (0.0, 0.0, 0, 0);
    let plant =
        Plant { squareness: [60e-6, -80e-6, 50e-6], scale: [20e-6, -30e-6, 25e-6], backlash: [4e-3, 7e-3, 0.0] };
    let truth = [
        ("EC0X", 60e-6),
        ("EB0Z", -80e-6),
        ("EA0Z", 50e-6),
        // At the ends of travels of 700, 500 and 500 mm. The errors of X and Y are those of the table, opposite to the displacement of the tool.
        ("EXX X order 1", -20e-6 * 350.0),
        ("EYY Y order 1", 30e-6 * 250.0),
        ("EZZ Z order 1", 25e-6 * 250.0),
        ("EXX X_dir", 4e-3),
        ("EYY Y_dir", 7e-3),
    ];
    let mut wanted: Vec<String> = truth.iter().map(|(name, _)| (*name).to_owned()).collect();
    wanted.sort();
    for seed in 1..=10 {
        let found = plant.explained(seed);
        right += if named(&found) == wanted { 1.0 } else { 0.0 };
        stated += found.explanations[0].probability;
        for one in found.findings() {
            let name = found.terms[one.term].name();
            if let Some((_, size)) = truth.iter().find(|(known, _)| *known == name) {
                // The sign of backlash is that of the body that lags.
                let (size, mean) = if name.ends_with("dir") { (*size, one.mean.abs()) } else { (*size, one.mean) };
                all += 1;
                inside += u32::from((mean - size).abs() < 1.96 * one.sigma);
            }
        }
        let total: f64 = found.explanations.iter().map(|one| one.probability).sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        assert!((found.scale - 1.0).abs() < 0.1, "the noise is as stated: {}", found.scale);
    }
    // Of 80 intervals of 95 %, fewer than 70 with a chance of one in ten thousand.
    assert!(all == 80 && inside >= 70, "{inside} of {all} inside");
    // The first explanation is right as often as its probability says, within two standard deviations of ten draws.
    assert!(right >= 7.0 && right > stated - 3.0, "{right} of 10 right, {stated:.1} expected");
}

#[test]
fn three_equal_backlashes_are_three_backlashes() {
    for seed in 1..=4 {
        let found = Plant { backlash: [4e-3; 3], ..Plant::default() }.explained(seed);
        assert_eq!(named(&found), ["EXX X_dir", "EYY Y_dir", "EZZ Z_dir"], "seed {seed}");
    }
}

#[test]
fn noise_alone_is_explained_by_nothing() {
    let (mut claims, mut most) = (0, 0.0_f64);
    for seed in 1..=20 {
        let found = Plant::default().explained(100 + seed);
        assert_eq!(found.explanations[0].set, [0; 0], "seed {seed}: {:?}", named(&found));
        for one in found.findings() {
            most = most.max(one.probability);
            claims += u32::from(one.probability > 0.5);
        }
    }
    assert!(claims == 0 && most < 0.5, "{claims} claims, {most}");
}

#[test]
fn no_term_cancels_another_one() {
    // Straightness and squareness, angle and offset: no term of any explanation is larger than twice the hidden displacement (28 µrad over 200 mm) or three times the
    // hidden angle, which terms that cancel each other would be.
    let plant = Plant { squareness: [28e-6, 0.0, 0.0], ..Plant::default() };
    for seed in 1..=4 {
        let found = plant.explained(200 + seed);
        for explanation in &found.explanations {
            for (&term, amount) in explanation.set.iter().zip(&explanation.posterior.mean) {
                let term = &found.terms[term];
                let most = if term.component.direction.is_rotation() { 3.0 * 28e-6 } else { 2.0 * 28e-6 * 200.0 };
                // The amount of a product is that at the ends of both travels, 250 mm from the middle of each or more: the circles reach 100 mm.
                let reached = if term.name().contains(" and ") { 0.4 * 0.4 } else { 1.0 };
                assert!(reached * amount.abs() < most, "seed {seed}: {} {amount}", term.name());
            }
        }
    }
}
