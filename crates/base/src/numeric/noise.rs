//! Normal noise that is identical for the same seed on every platform: SplitMix64 (Steele, Lea & Flood 2014) and the Box–Muller method.

use std::f64::consts::TAU;

/// A random number generator.
#[derive(Clone, Debug)]
pub struct Noise {
    state: u64,
    /// The second number of the last pair.
    kept: Option<f64>,
}

impl Noise {
    /// Creates a generator from a seed.
    #[must_use]
    pub fn new(seed: u64) -> Noise {
        Noise { state: seed, kept: None }
    }

    /// A number of the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        if let Some(kept) = self.kept.take() {
            return kept;
        }
        // 1 − u is never 0.
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        self.kept = Some(radius * sin);
        radius * cos
    }

    /// A uniform number from 0 to 1, exclusive.
    fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_generator_is_the_published_one() {
        // First number for the seed 1234567 in the reference implementation.
        assert_eq!(Noise::new(1_234_567).next(), 6_457_827_717_110_365_317);
    }

    #[test]
    fn mean_variance_and_tails_are_those_of_a_normal_distribution() {
        let mut noise = Noise::new(7);
        let all: Vec<f64> = (0..40_000).map(|_| noise.normal()).collect();
        let count = all.len() as f64;
        let mean = all.iter().sum::<f64>() / count;
        let square = all.iter().map(|value| value * value).sum::<f64>() / count;
        // Five standard deviations of each.
        assert!(mean.abs() < 0.025 && (square - 1.0).abs() < 0.036, "{mean} {square}");
        let beyond = all.iter().filter(|value| value.abs() > 1.959_964).count() as f64 / count;
        assert!((beyond - 0.05).abs() < 0.0055, "{beyond}");
    }
}
