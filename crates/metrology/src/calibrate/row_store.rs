//! Rows of derivatives that are stored without the zeros of other set-ups: each set-up has unknowns of its own, so a row has few derivatives besides those of
//! the parameters.

/// Rows of derivatives, the parameters first.
#[derive(Clone, Debug, Default)]
pub(super) struct RowStore {
    columns: usize,
    parameters: usize,
    /// Derivatives with respect to the parameters, one row after the other.
    shared: Vec<f64>,
    /// Other derivatives that are not 0, with their columns.
    own: Vec<(usize, f64)>,
    /// End of each row in `own`.
    ends: Vec<usize>,
}

impl RowStore {
    /// An empty store of rows with this number of columns, of which the first ones are parameters.
    pub(super) fn new(columns: usize, parameters: usize) -> RowStore {
        RowStore { columns, parameters: parameters.min(columns), ..RowStore::default() }
    }

    /// Number of rows.
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Number of stored derivatives.
    pub(super) fn size(&self) -> usize {
        self.shared.len() + self.own.len()
    }

    /// Adds a row with all columns.
    pub(super) fn push(&mut self, factors: &[f64]) {
        let own = (self.parameters..).zip(factors.get(self.parameters..).unwrap_or_default());
        self.own.extend(own.filter(|(_, factor)| **factor != 0.0).map(|(column, factor)| (column, *factor)));
        self.shared.extend(factors.iter().take(self.parameters));
        self.ends.push(self.own.len());
    }

    /// Adds a row: the derivatives with respect to the parameters, and the others with their columns.
    pub(super) fn push_parts(&mut self, shared: &[f64], own: impl Iterator<Item = (usize, f64)>) {
        self.shared.extend(shared.iter().take(self.parameters));
        self.own.extend(own);
        self.ends.push(self.own.len());
    }

    /// Removes all rows.
    pub(super) fn clear(&mut self) {
        self.shared.clear();
        self.own.clear();
        self.ends.clear();
    }

    /// Calls `out` with the number of each row and its derivatives.
    pub(super) fn each(&self, mut out: impl FnMut(usize, &[f64])) {
        let mut row = vec![0.0; self.columns];
        let mut from = 0;
        for (number, &end) in self.ends.iter().enumerate() {
            let shared = self.shared.get(number * self.parameters..(number + 1) * self.parameters);
            row[..self.parameters].copy_from_slice(shared.unwrap_or_default());
            let own = self.own.get(from..end).unwrap_or_default();
            own.iter().for_each(|&(column, factor)| row[column] = factor);
            out(number, &row);
            own.iter().for_each(|&(column, _)| row[column] = 0.0);
            from = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_as_they_were() {
        let rows = [[1.0, 2.0, 0.0, 3.0, 0.0], [0.0, 4.0, 5.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 6.0]];
        let mut store = RowStore::new(5, 2);
        rows[..2].iter().for_each(|row| store.push(row));
        store.push_parts(&rows[2][..2], [(4, 6.0)].into_iter());
        let mut found: Vec<Vec<f64>> = Vec::new();
        store.each(|number, row| {
            assert_eq!(number, found.len());
            found.push(row.to_vec());
        });
        assert_eq!(found, rows);
        assert_eq!((store.len(), store.size()), (3, 9));
    }
}
