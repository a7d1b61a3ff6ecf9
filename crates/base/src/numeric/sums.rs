//! Sums over long columns.

/// Number of parallel sums: each step of a single sum would wait for the previous one.
const LANES: usize = 8;

/// Returns the sum of products of two columns, up to the shorter length.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let [(a, a_rest), (b, b_rest)] = [a, b].map(|one| one.get(..length).unwrap_or_default().as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// Returns the sum of products of three columns, up to the shortest length.
#[must_use]
pub fn dot_of_three(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let length = a.len().min(b.len()).min(c.len());
    let [(a, a_rest), (b, b_rest), (c, c_rest)] =
        [a, b, c].map(|one| one.get(..length).unwrap_or_default().as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for ((a, b), c) in a.iter().zip(b).zip(c) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane] * c[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).zip(c_rest).map(|((a, b), c)| a * b * c).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_go_to_the_end_of_the_shorter_column() {
        let numbers: Vec<f64> = (1..=21).map(f64::from).collect();
        let ones = vec![1.0; 19];
        // 1 + … + 19 = 19 · 20 / 2, 1² + … + 21² = 21 · 22 · 43 / 6.
        assert_eq!(dot(&numbers, &ones), 190.0);
        assert_eq!(dot_of_three(&numbers, &numbers, &vec![1.0; 30]), 3311.0);
        assert_eq!(dot_of_three(&numbers, &ones, &ones), 190.0);
        assert_eq!(dot(&[], &ones), 0.0);
    }
}
