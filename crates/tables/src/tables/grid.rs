//! A grid of corrections of three axes with trilinear interpolation (Esmaeili 2021, eq. 13 and 14; Fanuc 3-D error compensation).

use ncfix_base::geometry::{Axis, AxisVector};

/// Corrections at the nodes of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// The linear axes that are looked up and corrected.
    pub axes: [Axis; 3],
    /// First node of each axis, mm.
    pub start: [f64; 3],
    /// Node spacing of each axis, mm.
    pub step: [f64; 3],
    /// Number of nodes of each axis, at least 2.
    pub count: [usize; 3],
    /// Corrections added to the three commands at each node, mm; the first axis varies fastest.
    pub values: Vec<[f64; 3]>,
}

impl Grid {
    /// The index of a node.
    #[must_use]
    pub fn index(&self, node: [usize; 3]) -> usize {
        (node[2] * self.count[1] + node[1]) * self.count[0] + node[0]
    }

    /// The node of an index.
    #[must_use]
    pub fn node(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.count;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    /// The position of a node, mm.
    #[must_use]
    pub fn position(&self, node: [usize; 3]) -> [f64; 3] {
        std::array::from_fn(|i| self.start[i] + self.step[i] * node[i] as f64)
    }

    /// The correction at a position, mm; outside the grid, that of the border.
    #[must_use]
    pub fn at(&self, command: &AxisVector) -> [f64; 3] {
        let mut lower = [0; 3];
        let mut share = [0.0; 3];
        for i in 0..3 {
            let steps = (command[self.axes[i]] - self.start[i]) / self.step[i];
            let last = self.count[i].saturating_sub(2);
            lower[i] = (steps.max(0.0).floor() as usize).min(last);
            share[i] = (steps - lower[i] as f64).clamp(0.0, 1.0);
        }
        let mut sum = [0.0; 3];
        for corner in 0..8_usize {
            let bit = |i: usize| corner >> i & 1;
            let weight: f64 = (0..3).map(|i| if bit(i) == 1 { share[i] } else { 1.0 - share[i] }).product();
            let node = std::array::from_fn(|i| (lower[i] + bit(i)).min(self.count[i].saturating_sub(1)));
            let Some(value) = self.values.get(self.index(node)).filter(|_| weight != 0.0) else { continue };
            sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += weight * value);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x·y·z and sums of it are trilinear functions: the interpolation is exact.
    #[test]
    fn products_of_positions_are_exact() {
        let mut grid = Grid {
            axes: [Axis::X, Axis::Y, Axis::Z],
            start: [-100.0, 0.0, 50.0],
            step: [100.0, 40.0, 25.0],
            count: [4, 3, 5],
            values: Vec::new(),
        };
        let law = |p: [f64; 3]| [p[0] * p[1] * p[2] * 1e-9, p[0] * 1e-5 + 1.0, p[1] * p[2] * 1e-7];
        grid.values = (0..60).map(|index| law(grid.position(grid.node(index)))).collect();
        for p in [[-37.0, 11.0, 77.0], [200.0, 80.0, 150.0], [0.0, 0.0, 50.0], [133.3, 63.1, 149.0]] {
            let mut command = AxisVector::default();
            grid.axes.iter().zip(p).for_each(|(&axis, at)| command[axis] = at);
            for (found, truth) in grid.at(&command).into_iter().zip(law(p)) {
                assert!((found - truth).abs() < 1e-14, "{p:?}: {found} {truth}");
            }
        }
        let mut outside = AxisVector::default();
        outside[Axis::X] = -500.0;
        outside[Axis::Z] = 50.0;
        assert_eq!(grid.at(&outside)[1], -100.0 * 1e-5 + 1.0);
    }
}
