//! A block of material that moves cut, and what is left of it.

/// Heights of a block of material on a grid; its top is at 0.
pub(crate) struct Stock {
    corner: [f64; 2],
    step: f64,
    columns: usize,
    heights: Vec<f64>,
    /// Deepest cut of a move across, mm.
    pub(crate) cut: f64,
    /// Rapid moves through material.
    pub(crate) faults: Vec<String>,
}

/// Top of a grid point where nothing was cut.
pub(crate) const TOP: f64 = 0.0;

impl Stock {
    /// A block that fills a rectangle.
    pub(crate) fn new(low: [f64; 2], high: [f64; 2], step: f64) -> Stock {
        let count = |k: usize| ((high[k] - low[k]) / step).round() as usize + 1;
        Stock {
            corner: low,
            step,
            columns: count(0),
            heights: vec![TOP; count(0) * count(1)],
            cut: 0.0,
            faults: Vec::new(),
        }
    }

    /// Grid points with their heights.
    pub(crate) fn points(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        self.heights.iter().enumerate().map(|(index, &height)| {
            let (row, column) = (index / self.columns, index % self.columns);
            ([self.corner[0] + column as f64 * self.step, self.corner[1] + row as f64 * self.step], height)
        })
    }

    /// The tool, a flat disc, at one place.
    fn touch(&mut self, at: [f64; 3], radius: f64, line: &str, is_rapid: bool, is_across: bool) {
        let rows = self.heights.len() / self.columns;
        let range = |k: usize, count: usize| {
            let low = ((at[k] - radius - self.corner[k]) / self.step).ceil().max(0.0) as usize;
            let high = ((at[k] + radius - self.corner[k]) / self.step).floor();
            low..if high < 0.0 { 0 } else { (high as usize + 1).min(count) }
        };
        for row in range(1, rows) {
            for column in range(0, self.columns) {
                let (x, y) = (self.corner[0] + column as f64 * self.step, self.corner[1] + row as f64 * self.step);
                // A hair inside, so that a wall is not cut by rounding.
                if (x - at[0]).hypot(y - at[1]) > radius - 1e-6 {
                    continue;
                }
                let height = &mut self.heights[row * self.columns + column];
                if at[2] >= *height - 1e-9 {
                    continue;
                }
                if is_rapid {
                    self.faults.push(format!("rapid through material at {x} {y}: {line}"));
                }
                if is_across {
                    self.cut = self.cut.max(*height - at[2]);
                }
                *height = at[2];
            }
        }
    }

    /// Cuts along the moves of a program.
    pub(crate) fn mill(&mut self, lines: &[String], radius: f64) {
        let mut here = [0.0, 0.0, 100.0];
        for line in lines {
            let word = |letter: &str| -> Option<f64> {
                line.split(' ').skip(1).find_map(|word| word.strip_prefix(letter)).map(|value| value.parse().unwrap())
            };
            let code = line.split(' ').next().unwrap();
            if !["G0", "G1", "G2", "G3"].contains(&code) {
                continue;
            }
            let there = [word("X").unwrap(), word("Y").unwrap(), word("Z").unwrap()];
            let is_across = (there[0] - here[0]).hypot(there[1] - here[1]) > 1e-9 && (there[2] - here[2]).abs() < 1e-9;
            let center = [here[0] + word("I").unwrap_or(0.0), here[1] + word("J").unwrap_or(0.0)];
            let angle = |p: [f64; 3]| (p[1] - center[1]).atan2(p[0] - center[0]);
            let r = (here[0] - center[0]).hypot(here[1] - center[1]);
            let mut sweep = angle(there) - angle(here);
            if code == "G3" && sweep <= 1e-9 {
                sweep += std::f64::consts::TAU;
            } else if code == "G2" && sweep >= -1e-9 {
                sweep -= std::f64::consts::TAU;
            }
            let is_arc = code == "G2" || code == "G3";
            if is_arc {
                let end = (there[0] - center[0]).hypot(there[1] - center[1]);
                assert!((end - r).abs() < 1e-5, "{line}");
            }
            let flat = if is_arc { r * sweep.abs() } else { (there[0] - here[0]).hypot(there[1] - here[1]) };
            let length = flat.hypot(there[2] - here[2]);
            let count = (length / (self.step * 0.5)).ceil().max(1.0) as usize;
            for k in 1..=count {
                let share = k as f64 / count as f64;
                let z = here[2] + share * (there[2] - here[2]);
                let at = if is_arc {
                    let a = angle(here) + share * sweep;
                    [center[0] + r * a.cos(), center[1] + r * a.sin(), z]
                } else {
                    [here[0] + share * (there[0] - here[0]), here[1] + share * (there[1] - here[1]), z]
                };
                self.touch(at, radius, line, code == "G0", is_across);
            }
            here = there;
        }
    }
}
