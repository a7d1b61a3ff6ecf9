//! Least squares with many unknowns that belong to few equations each, such as those of set-ups, and some that all equations share.
//!
//! Unknowns that occur in a common equation form a block. The equations of a block are triangulated with its unknowns first. The other rows of the triangle
//! contain only the shared unknowns, the border. So the time grows linearly with the number of blocks (Björck 1996, Numerical Methods for Least Squares Problems,
//! section 6.3). With few unknowns the dense [`System`] is used.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use super::least_squares::{LOST, MAX_SWEEPS, RANK_LIMIT, Solution, System, unit_scale};

/// Number of unknowns besides the shared ones from which blocks are eliminated. The dense decomposition of 100 takes some milliseconds.
const MANY: usize = 100;
/// Rows of a block are triangulated when they are this many times its columns.
const TALL: usize = 4;

/// Equations of shared unknowns, the first columns, and of others.
#[derive(Clone, Debug)]
pub struct BorderedSystem {
    form: Form,
}

#[derive(Clone, Debug)]
enum Form {
    Dense(System),
    Blocks(Blocks),
}

/// Equations by blocks.
#[derive(Clone, Debug)]
struct Blocks {
    columns: usize,
    shared: usize,
    /// Block of each column after the shared ones.
    block_of: Vec<Option<usize>>,
    blocks: Vec<Block>,
    /// Equations of the shared unknowns alone.
    border: System,
    /// Sum of the squares of each column.
    squares: Vec<f64>,
    rows: usize,
}

#[derive(Clone, Debug, Default)]
struct Block {
    /// Its columns, as numbers among all.
    columns: Vec<usize>,
    rows: Vec<Row>,
}

/// An equation, multiplied by its weight.
#[derive(Clone, Debug)]
struct Row {
    shared: Vec<f64>,
    /// Factors of the other unknowns that are not 0.
    own: Vec<(usize, f64)>,
    value: f64,
}

/// A triangulated block: unknowns of the block by directions.
struct Eliminated {
    columns: Vec<usize>,
    /// For each direction that the equations of the block determine: its singular value, its components along the columns of unit length, the shared factors
    /// and the value of its equation.
    kept: Vec<(f64, DVector<f64>, DVector<f64>, f64)>,
    /// Other directions.
    lost: Vec<DVector<f64>>,
}

impl BorderedSystem {
    /// Creates a system without rows; the first `shared` columns may occur in all equations.
    #[must_use]
    pub fn new(columns: usize, shared: usize) -> BorderedSystem {
        let form = if BorderedSystem::has_blocks(columns, shared) {
            Form::Blocks(Blocks::new(columns, shared))
        } else {
            Form::Dense(System::new(columns))
        };
        BorderedSystem { form }
    }

    /// True if a system of this size is solved by blocks.
    #[must_use]
    pub fn has_blocks(columns: usize, shared: usize) -> bool {
        columns > shared + MANY
    }

    /// Adds a row: factors, value and weight (1/σ).
    pub fn add(&mut self, factors: &[f64], value: f64, weight: f64) {
        match &mut self.form {
            Form::Dense(system) => system.add(factors, value, weight),
            Form::Blocks(blocks) => blocks.add(factors, value, weight),
        }
    }

    /// Returns the number of rows so far.
    #[must_use]
    pub fn rows(&self) -> usize {
        match &self.form {
            Form::Dense(system) => system.rows(),
            Form::Blocks(blocks) => blocks.rows,
        }
    }

    /// Removes an unknown: its factors are set to zero in all rows so far.
    pub fn clear(&mut self, column: usize) {
        match &mut self.form {
            Form::Dense(system) => system.clear(column),
            Form::Blocks(blocks) => blocks.clear(column),
        }
    }

    /// Returns the rank of all rows with only the unknowns that are not shared; `None` if they contain numbers that are not finite.
    #[must_use]
    pub fn rank_besides(&self, shared: usize) -> Option<usize> {
        match &self.form {
            Form::Dense(system) => Some(system.behind(shared).solve()?.rank),
            Form::Blocks(blocks) => {
                let found = blocks.clone().eliminated(RANK_LIMIT)?.0;
                Some(found.iter().map(|block| block.kept.len()).sum())
            }
        }
    }

    /// Solves it with [`RANK_LIMIT`]; `None` if it contains numbers that are not finite.
    #[must_use]
    pub fn solve(self) -> Option<Solution> {
        self.solve_to(RANK_LIMIT)
    }

    /// Solves it with a given limit for singular values. Those of blocks are decided in each block, as a share of the largest one of all blocks.
    #[must_use]
    pub fn solve_to(self, limit: f64) -> Option<Solution> {
        match self.form {
            Form::Dense(system) => system.solve_to(limit),
            Form::Blocks(blocks) => blocks.solve_to(limit),
        }
    }
}

impl Blocks {
    fn new(columns: usize, shared: usize) -> Blocks {
        Blocks {
            columns,
            shared,
            block_of: vec![None; columns - shared],
            blocks: Vec::new(),
            border: System::new(shared),
            squares: vec![0.0; columns],
            rows: 0,
        }
    }

    fn add(&mut self, factors: &[f64], value: f64, weight: f64) {
        self.rows += 1;
        let factors = factors.get(..self.columns).unwrap_or(factors);
        let (shared, own) = factors.split_at(self.shared.min(factors.len()));
        let row = Row {
            shared: shared.iter().map(|factor| factor * weight).collect(),
            own: (self.shared..)
                .zip(own)
                .filter(|(_, factor)| **factor != 0.0)
                .map(|(column, factor)| (column, factor * weight))
                .collect(),
            value: value * weight,
        };
        for (square, factor) in self.squares.iter_mut().zip(&row.shared) {
            *square += factor * factor;
        }
        row.own.iter().for_each(|&(column, factor)| self.squares[column] += factor * factor);
        if row.own.is_empty() {
            return self.border.add(&row.shared, row.value, 1.0);
        }
        let number = self.joined(&row);
        let block = &mut self.blocks[number];
        block.rows.push(row);
        if block.rows.len() > TALL * (block.columns.len() + self.shared + 1) {
            self.triangulate(number);
        }
    }

    /// Returns the block of an equation, after it has joined those that it connects.
    fn joined(&mut self, row: &Row) -> usize {
        let known: BTreeSet<usize> =
            row.own.iter().filter_map(|(column, _)| self.block_of[column - self.shared]).collect();
        let mut known = known.into_iter();
        let number = known.next().unwrap_or_else(|| {
            self.blocks.push(Block::default());
            self.blocks.len() - 1
        });
        for other in known {
            let Block { columns, rows } = std::mem::take(&mut self.blocks[other]);
            columns.iter().for_each(|column| self.block_of[column - self.shared] = Some(number));
            self.blocks[number].columns.extend(columns);
            self.blocks[number].rows.extend(rows);
        }
        for (column, _) in &row.own {
            let own = &mut self.block_of[column - self.shared];
            if own.is_none() {
                *own = Some(number);
                self.blocks[number].columns.push(*column);
            }
        }
        number
    }

    /// Triangulates the rows of a block. Those without its unknowns go to the border.
    fn triangulate(&mut self, number: usize) {
        let block = &mut self.blocks[number];
        let (own, width) = (block.columns.len(), block.columns.len() + self.shared + 1);
        let mut matrix = DMatrix::zeros(block.rows.len(), width);
        for (place, row) in block.rows.iter().enumerate() {
            for (column, factor) in &row.own {
                if let Some(at) = block.columns.iter().position(|other| other == column) {
                    matrix[(place, at)] = *factor;
                }
            }
            row.shared.iter().enumerate().for_each(|(at, factor)| matrix[(place, own + at)] = *factor);
            matrix[(place, width - 1)] = row.value;
        }
        let triangle = matrix.qr().unpack_r();
        block.rows.clear();
        for (place, row) in triangle.row_iter().enumerate() {
            let shared: Vec<f64> = row.iter().copied().skip(own).take(self.shared).collect();
            let value = row[width - 1];
            if place < own {
                let own = block.columns.iter().copied().zip(row.iter().copied()).collect();
                block.rows.push(Row { shared, own, value });
            } else {
                self.border.add(&shared, value, 1.0);
            }
        }
    }

    fn clear(&mut self, column: usize) {
        if let Some(square) = self.squares.get_mut(column) {
            *square = 0.0;
        }
        if column < self.shared {
            self.border.clear(column);
        }
        for row in self.blocks.iter_mut().flat_map(|block| &mut block.rows) {
            row.shared.get_mut(column).into_iter().for_each(|factor| *factor = 0.0);
            row.own.retain(|(own, _)| *own != column);
        }
    }

    /// Eliminates the unknowns of all blocks. Also returns the equations of the border, the factors that make all columns unit vectors, and the smallest
    /// singular value that counts.
    fn eliminated(mut self, limit: f64) -> Option<(Vec<Eliminated>, System, Vec<f64>, f64)> {
        (0..self.blocks.len()).for_each(|number| self.triangulate(number));
        let scale: Vec<f64> = self.squares.iter().map(|square| unit_scale(square.sqrt())).collect();
        let mut parts = Vec::new();
        for block in self.blocks.iter().filter(|block| !block.columns.is_empty()) {
            let own = block.columns.len();
            // Square, so that all right singular vectors exist.
            let (mut matrix, mut rest) = (DMatrix::zeros(own, own), DMatrix::zeros(own, self.shared + 1));
            for (place, row) in block.rows.iter().enumerate() {
                for (column, factor) in &row.own {
                    if let Some(at) = block.columns.iter().position(|other| other == column) {
                        matrix[(place, at)] = factor * scale[*column];
                    }
                }
                row.shared.iter().enumerate().for_each(|(at, factor)| rest[(place, at)] = *factor);
                rest[(place, self.shared)] = row.value;
            }
            if matrix.iter().chain(&rest).any(|factor| !factor.is_finite()) {
                return None;
            }
            let found = matrix.try_svd(true, true, f64::EPSILON, MAX_SWEEPS)?;
            parts.push((&block.columns, found.u?.transpose() * rest, found.singular_values, found.v_t?));
        }
        let largest = parts.iter().flat_map(|(_, _, values, _)| values.iter().copied()).fold(1.0, f64::max);
        let least = limit * largest;
        let mut border = self.border;
        let mut out = Vec::new();
        for (columns, rest, values, right) in parts {
            let mut one = Eliminated { columns: columns.clone(), kept: Vec::new(), lost: Vec::new() };
            for (k, &singular) in values.iter().enumerate() {
                let direction = right.row(k).transpose();
                let shared: Vec<f64> = rest.row(k).iter().copied().take(self.shared).collect();
                let value = rest[(k, self.shared)];
                if singular > least {
                    one.kept.push((singular, direction, DVector::from_vec(shared), value));
                } else {
                    border.add(&shared, value, 1.0);
                    one.lost.push(direction);
                }
            }
            out.push(one);
        }
        Some((out, border, scale, least))
    }

    fn solve_to(self, limit: f64) -> Option<Solution> {
        let (columns, shared, rows) = (self.columns, self.shared, self.rows);
        let (blocks, border, scale, least) = self.eliminated(limit)?;
        let border = border.solve_scaled(scale.get(..shared), least)?;
        // All of this in columns of unit length.
        let of_shared = DVector::from_fn(shared, |k, _| border.unknowns[k] / scale[k]);
        let cofactors = DMatrix::from_fn(shared, shared, |k, l| border.cofactors[(k, l)] / (scale[k] * scale[l]));
        // Unknowns of blocks per shared unknown.
        let mut by_shared = DMatrix::zeros(columns, shared);
        let mut unknowns = DVector::zeros(columns);
        let mut whole = DMatrix::zeros(columns, columns);
        let mut null_space: Vec<DVector<f64>> = Vec::new();
        let mut singular_values = border.singular_values.clone();
        let mut rank = border.rank;
        for block in &blocks {
            rank += block.kept.len();
            singular_values.extend(block.kept.iter().map(|(singular, ..)| *singular));
            singular_values.extend(block.lost.iter().map(|_| 0.0));
            for (singular, direction, factors, value) in &block.kept {
                let factors = factors.component_mul(&DVector::from_fn(shared, |k, _| scale[k]));
                let amount = (value - factors.dot(&of_shared)) / singular;
                for (k, &column) in block.columns.iter().enumerate() {
                    unknowns[column] += direction[k] * amount;
                    for l in 0..shared {
                        by_shared[(column, l)] -= direction[k] * factors[l] / singular;
                    }
                    for (l, &other) in block.columns.iter().enumerate() {
                        whole[(column, other)] += direction[k] * direction[l] / (singular * singular);
                    }
                }
            }
            for direction in &block.lost {
                let mut vector = DVector::zeros(columns);
                block.columns.iter().zip(direction).for_each(|(&column, value)| vector[column] = *value);
                null_space.push(vector);
            }
        }
        // Columns without any equation.
        let is_idle = |column: &usize| *column >= shared && !blocks.iter().any(|block| block.columns.contains(column));
        for column in (0..columns).filter(is_idle) {
            singular_values.push(0.0);
            null_space.push(DVector::from_fn(columns, |k, _| if k == column { 1.0 } else { 0.0 }));
        }
        (0..shared).for_each(|k| by_shared[(k, k)] = 1.0);
        unknowns.rows_mut(0, shared).copy_from(&of_shared);
        whole += &by_shared * &cofactors * by_shared.transpose();
        for direction in &border.null_space {
            let vector = &by_shared * direction;
            let length = vector.norm();
            null_space.push(vector / length);
        }
        let is_lost = |column: usize| null_space.iter().any(|vector| vector[column].abs() > LOST);
        let inflation =
            (0..columns).map(|column| if is_lost(column) { f64::INFINITY } else { whole[(column, column)] }).collect();
        for (column, &scale) in scale.iter().enumerate() {
            unknowns[column] *= scale;
            whole.column_mut(column).scale_mut(scale);
            whole.row_mut(column).scale_mut(scale);
        }
        singular_values.sort_by(|a, b| b.total_cmp(a));
        Some(Solution {
            unknowns,
            cofactors: whole,
            singular_values,
            rank,
            null_space,
            squares: border.squares,
            freedom: rows.saturating_sub(rank),
            inflation,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 60 set-ups of three unknowns each with four readings, and three shared unknowns.
    fn both(change: impl Fn(usize, &mut [f64])) -> (Solution, Solution) {
        const SHARED: usize = 3;
        const SETUPS: usize = 60;
        let columns = SHARED + 3 * SETUPS;
        let mut seed = 3_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let (mut blocks, mut dense) = (BorderedSystem::new(columns, SHARED), System::new(columns));
        assert!(matches!(blocks.form, Form::Blocks(_)));
        for k in 0..SETUPS * 8 {
            let mut factors = vec![0.0; columns];
            factors.iter_mut().take(SHARED).for_each(|factor| *factor = 100.0 * random());
            let first = SHARED + 3 * (k % SETUPS);
            factors[first..first + 3].iter_mut().for_each(|factor| *factor = random());
            change(k, &mut factors);
            let (value, weight) = (random(), 1.0 + random());
            blocks.add(&factors, value, weight);
            dense.add(&factors, value, weight);
        }
        (blocks.solve().unwrap(), dense.solve().unwrap())
    }

    fn agree(found: &Solution, dense: &Solution) {
        assert_eq!((found.rank, found.freedom), (dense.rank, dense.freedom));
        assert!((found.squares / dense.squares - 1.0).abs() < 1e-9, "{} {}", found.squares, dense.squares);
        for (k, (own, other)) in found.inflation.iter().zip(&dense.inflation).enumerate() {
            assert_eq!(own.is_finite(), other.is_finite(), "{k}: {own} {other}");
            if own.is_finite() {
                assert!((own / other - 1.0).abs() < 1e-6, "{k}: {own} {other}");
                assert!((found.unknowns[k] - dense.unknowns[k]).abs() < 1e-9 * dense.unknowns.amax(), "{k}");
                for l in (0..dense.inflation.len()).filter(|&l| dense.inflation[l].is_finite()) {
                    let size = (dense.cofactors[(k, k)] * dense.cofactors[(l, l)]).sqrt();
                    assert!((found.cofactors[(k, l)] - dense.cofactors[(k, l)]).abs() < 1e-8 * size, "{k} {l}");
                }
            }
        }
    }

    #[test]
    fn blocks_give_what_the_dense_system_gives() {
        let (found, dense) = both(|_, _| ());
        agree(&found, &dense);
        assert_eq!(found.rank, 183);
    }

    #[test]
    fn a_cleared_unknown_is_in_no_equation() {
        let columns = 3 + 120;
        let mut blocks = BorderedSystem::new(columns, 3);
        for k in 0..600_u32 {
            let mut factors = vec![0.0; columns];
            let [one, other] = [f64::from(k), f64::from(k * k % 17)];
            factors[..3].copy_from_slice(&[one, other, 1.0]);
            factors[3 + k as usize % 120] = 1.0;
            blocks.add(&factors, 0.0, 1.0);
        }
        // The constant is the sum of all offsets; the offsets alone are independent.
        assert_eq!((blocks.rank_besides(3), blocks.clone().solve().unwrap().rank), (Some(120), 122));
        // Without one offset the constant is determined; without the constant nothing changes.
        for (column, rank, besides) in [(5, 122, 119), (2, 122, 120), (0, 121, 120)] {
            let mut less = blocks.clone();
            less.clear(column);
            assert_eq!((less.rank_besides(3), less.rows()), (Some(besides), 600), "{column}");
            let solution = less.solve().unwrap();
            assert_eq!((solution.rank, solution.freedom), (rank, 600 - rank), "{column}");
        }
    }

    #[test]
    fn an_equation_may_connect_two_blocks() {
        // A known distance between neighboring set-ups.
        let (found, dense) = both(|k, factors| {
            if k % 7 == 3 {
                factors[3 + 3 * ((k + 1) % 60)] = 0.7;
            }
        });
        agree(&found, &dense);
    }

    #[test]
    fn what_cannot_be_told_in_a_block_or_of_the_border_is_named() {
        // The third unknown of each fifth set-up has no effect, and the second shared unknown is always twice the first.
        let (found, dense) = both(|k, factors| {
            factors[1] = 2.0 * factors[0];
            let setup = k % 60;
            if setup % 5 == 0 {
                factors[3 + 3 * setup + 2] = 0.0;
            }
        });
        agree(&found, &dense);
        assert_eq!((found.rank, found.null_space.len()), (183 - 12 - 1, 13));
    }

    #[test]
    fn a_shared_unknown_that_the_set_ups_absorb_is_lost() {
        // A shared unknown with the effect of the first unknown of every set-up.
        let (found, dense) = both(|k, factors| factors[2] = factors[3 + 3 * (k % 60)]);
        agree(&found, &dense);
        assert_eq!(found.null_space.len(), 1);
        assert!(found.inflation[2].is_infinite() && found.inflation[0].is_finite());
    }
}
