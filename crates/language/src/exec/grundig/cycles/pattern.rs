//! G77: positions on a circle.

use super::basis::{CycleFault, fault};
use crate::exec::core::step::Flat;

/// Maximum number of holes; more is an input error.
const MOST_HOLES: f64 = 100_000.0;

/// Positions on a circle: `count` holes from the angle `first`. Without `last` they are spaced over the full circle, counter-clockwise. With it they
/// lie between both angles, inclusive, clockwise if `last` is smaller. Angles are in degrees from the abscissa.
///
/// # Errors
/// A message if the count is invalid or the radius is not above 0.
pub(in crate::exec::grundig) fn bolt_circle(
    center: Flat,
    radius: f64,
    first: f64,
    last: Option<f64>,
    count: f64,
) -> Result<impl Iterator<Item = Flat>, CycleFault> {
    if !(1.0..=MOST_HOLES).contains(&count) || count.fract() != 0.0 {
        return Err(fault(format!("J={count} is not a valid number of holes"), "write a whole number of holes"));
    }
    if radius <= 0.0 || !radius.is_finite() {
        return Err(fault(format!("R={radius} is not a valid bolt circle radius"), "write the radius of the circle"));
    }
    let step = match last {
        None => 360.0 / count,
        Some(_) if count == 1.0 => 0.0,
        Some(last) => (last - first) / (count - 1.0),
    };
    // Within the limit.
    Ok((0..count as u32).map(move |k| {
        let (sin, cos) = (first + step * f64::from(k)).to_radians().sin_cos();
        [center[0] + radius * cos, center[1] + radius * sin]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holes_share_the_circle_or_an_arc_of_it() {
        let near = |a: Flat, b: Flat| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-9;
        let all: Vec<Flat> = bolt_circle([50.0, 50.0], 20.0, 30.0, None, 4.0).unwrap().collect();
        // 20 cos 30° = 17.3205080757.
        assert!(near(all[0], [67.320_508_075_688_78, 60.0]) && near(all[1], [40.0, 67.320_508_075_688_78]));
        let arc: Vec<Flat> = bolt_circle([0.0, 0.0], 10.0, 90.0, Some(0.0), 3.0).unwrap().collect();
        let half = 10.0 * 0.5_f64.sqrt();
        assert!(near(arc[0], [0.0, 10.0]) && near(arc[1], [half, half]) && near(arc[2], [10.0, 0.0]));
        assert!(bolt_circle([0.0, 0.0], 10.0, 0.0, None, 0.0).is_err());
    }
}
