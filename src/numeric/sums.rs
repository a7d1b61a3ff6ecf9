//! Sums over long columns.

/// Sums side by side: one alone waits for itself in every step.
const LANES: usize = 8;

/// The sum of products of two columns, as far as both go.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let (a, b) = (a.get(..length).unwrap_or_default(), b.get(..length).unwrap_or_default());
    let mut sums = [0.0; LANES];
    let (left, right) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in left.zip(right) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// The same of three.
#[must_use]
pub fn dot_of_three(a: &[f64], b: &[f64], c: &[f64]) -> f64 {
    let length = a.len().min(b.len()).min(c.len());
    let [a, b, c] = [a, b, c].map(|one| one.get(..length).unwrap_or_default());
    let mut sums = [0.0; LANES];
    let (first, second, third) = (a.chunks_exact(LANES), b.chunks_exact(LANES), c.chunks_exact(LANES));
    let rest = first.remainder().iter().zip(second.remainder()).zip(third.remainder());
    let rest: f64 = rest.map(|((a, b), c)| a * b * c).sum();
    for ((a, b), c) in first.zip(second).zip(third) {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += a[k] * b[k] * c[k];
        }
    }
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
