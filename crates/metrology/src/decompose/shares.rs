//! Shares of the sources: percentages, maxima and RMS (Andolfatto, Lavernhe and Mayer 2011, Tables 1 to 4).

use ncfix_base::geometry::Vector;

/// The sources in the order of all lists.
pub const SOURCES: [&str; 5] = ["contouring", "link", "motion", "thermal", "dynamic"];

/// The sources of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SourceShares {
    /// Mean share of the sum of the norms, % (eq. 21); NaN if nothing was measured.
    pub percent: [f64; 5],
    /// Largest magnitude along X, Y, Z, mm (eq. 22).
    pub max_mm: [[f64; 3]; 5],
    /// Root mean square along X, Y, Z, mm.
    pub rms_mm: [[f64; 3]; 5],
}

/// Accumulates the contributions of the sources over all samples.
#[must_use]
pub(super) fn shares(samples: impl Iterator<Item = [Vector; 5]>) -> SourceShares {
    let mut out = SourceShares::default();
    let mut count = 0.0_f64;
    for parts in samples {
        let norms = parts.map(|part| part.norm());
        let whole: f64 = norms.iter().sum();
        for (source, part) in parts.iter().enumerate() {
            // If all are zero, none has a share.
            out.percent[source] += if whole > 0.0 { 100.0 * norms[source] / whole } else { 0.0 };
            for k in 0..3 {
                out.max_mm[source][k] = out.max_mm[source][k].max(part[k].abs());
                out.rms_mm[source][k] += part[k] * part[k];
            }
        }
        count += 1.0;
    }
    for source in 0..5 {
        out.percent[source] /= count;
        out.rms_mm[source].iter_mut().for_each(|sum| *sum = (*sum / count.max(1.0)).sqrt());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_means_of_shares_and_not_shares_of_means() {
        // Two samples: 3-4-0 by contouring and 5 of links; 15 of links alone. (50 + 0)/2 and (50 + 100)/2.
        let x = |value: f64| Vector::new(value, 0.0, 0.0);
        let none = Vector::zeros();
        let samples = [[Vector::new(3.0, -4.0, 0.0), x(5.0), none, none, none], [none, x(-15.0), none, none, none]];
        let found = shares(samples.into_iter());
        assert_eq!(found.percent, [25.0, 75.0, 0.0, 0.0, 0.0]);
        assert_eq!([found.max_mm[0], found.max_mm[1]], [[3.0, 4.0, 0.0], [15.0, 0.0, 0.0]]);
        assert!((found.rms_mm[1][0] - 125.0_f64.sqrt()).abs() < 1e-12);
    }
}
