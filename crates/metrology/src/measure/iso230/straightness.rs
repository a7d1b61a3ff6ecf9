//! Straightness of a linear motion (ISO 230-1:2012, 8.2.2): the band of the mean deviations about a reference line.
//!
//! The slope of the readings belongs to the alignment of the instrument or to the squareness of the axis. The mean of both directions of approach counts.

use super::positioning::PositioningTarget;

/// Deviation from the least-squares line and from the line through the end points: the largest minus the smallest distance, mm. `None` for fewer than three targets.
pub(super) fn of(targets: &[PositioningTarget]) -> Option<[f64; 2]> {
    let means: Vec<[f64; 2]> = targets.iter().filter_map(|one| Some([one.position, mean(one)?])).collect();
    let ([first, .., last], true) = (means.as_slice(), means.len() > 2) else { return None };
    let count = means.len() as f64;
    let [x, y] = [0, 1].map(|k| means.iter().map(|point| point[k]).sum::<f64>() / count);
    let squares: f64 = means.iter().map(|point| (point[0] - x).powi(2)).sum();
    let products: f64 = means.iter().map(|point| (point[0] - x) * (point[1] - y)).sum();
    let slopes = [products / squares, (last[1] - first[1]) / (last[0] - first[0])];
    let band = |slope: f64| {
        let ends = means.iter().map(|point| point[1] - slope * point[0]);
        let [low, high] = ends.fold([f64::MAX, f64::MIN], |[low, high], at| [low.min(at), high.max(at)]);
        high - low
    };
    let bands = slopes.map(band);
    bands.iter().all(|band| band.is_finite()).then_some(bands)
}

/// The mean deviation at a target.
fn mean(target: &PositioningTarget) -> Option<f64> {
    match (target.up, target.down) {
        (Some([up, _]), Some([down, _])) => Some((up + down) / 2.0),
        (Some([mean, _]), None) | (None, Some([mean, _])) => Some(mean),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bow_has_its_height_about_either_line() {
        let target = |position: f64, mean: f64| PositioningTarget {
            position,
            up: Some([mean + 0.5, 0.0]),
            down: Some([mean - 0.5, 0.0]),
            runs: 2,
        };
        // 0, 3, 0 with a slope of 0.1: the least-squares line is 1 above the ends, and 2 below the middle.
        let bow = [target(0.0, 0.0), target(10.0, 4.0), target(20.0, 2.0)];
        let found = of(&bow).unwrap();
        assert!((found[0] - 3.0).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12, "{found:?}");
        // 0, 0, 0, 6: without the end line 0, −2, −4, 0 remain. The least-squares line has the slope 90 / 500 = 0.18: 0, −1.8, −3.6, 0.6 remain.
        let kink = [target(0.0, 0.0), target(10.0, 0.0), target(20.0, 0.0), target(30.0, 6.0)];
        let found = of(&kink).unwrap();
        assert!((found[0] - 4.2).abs() < 1e-12 && (found[1] - 4.0).abs() < 1e-12, "{found:?}");
        assert_eq!(of(&bow[..2]), None);
    }
}
