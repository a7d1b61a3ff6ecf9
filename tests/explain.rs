//! A plant for explanations: a machine with three axes in closed form, ball-bar circles in three planes.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::plant::Random;

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
}
