//! Strain gauge that weighs workpieces: its reading for a load, along an axis (Spaan 1995, ch. 4).
//!
//! ```text
//! strain(q) = empty(q) + F · force(q) + F pₓ · moment_x(q) + F p_z · moment_z(q) + an offset that drifts with temperature
//! ```
//!
//! F is the weight, p its position from the center of the table along the axes of F. Only changes along the axis count. For a rotary axis the moments are
//! those of the position at 0 degrees, and their signals are the readings as the axis rotates.

use super::file::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::geometry::{Axis, AxisSet};

/// Strain gauge; its signals are linear between the positions.
#[derive(Clone, Debug, PartialEq)]
pub struct StrainGauge {
    /// Axis that is moved.
    pub axis: Axis,
    /// Commands at which the signals are known, strictly increasing, mm or rad.
    pub positions: Vec<f64>,
    /// Signal of a load at the center of the table, µm/m per N.
    pub force: Vec<f64>,
    /// Signals of the moments due to a position along X, Y and Z, µm/m per N mm; at most two, as a weight has no moment about its own line of action.
    pub moments: [Option<Vec<f64>>; 3],
    /// Signal of the empty table, µm/m; `None` if it does not change along the axis.
    pub empty: Option<Vec<f64>>,
    /// Standard uncertainty of a reading, µm/m; `None` if it must be estimated from the readings.
    pub sigma_um_m: Option<f64>,
}

/// Keys of the moments.
const MOMENTS: [&str; 3] = ["x_um_per_m_per_N_mm", "y_um_per_m_per_N_mm", "z_um_per_m_per_N_mm"];

impl StrainGauge {
    /// Returns a signal at a command; `None` outside the positions.
    #[must_use]
    pub fn signal(&self, values: &[f64], command: f64) -> Option<f64> {
        let next = self
            .positions
            .partition_point(|&position| position <= command)
            .min(self.positions.len().saturating_sub(1))
            .max(1);
        let [left, right] = [*self.positions.get(next - 1)?, *self.positions.get(next)?];
        let [low, high] = [*values.get(next - 1)?, *values.get(next)?];
        (left..=right).contains(&command).then(|| low + (high - low) * ((command - left) / (right - left)))
    }
}

/// Reads `[strain]`.
pub(super) fn read(section: Section<'_>, axes: AxisSet, findings: &mut Vec<Diagnostic>) -> Option<StrainGauge> {
    let mut section = section;
    let gauge = read_gauge(&mut section, axes);
    if gauge.is_none() {
        // The unit of the positions follows from the axis. If the axis is unknown, the positions are not checked.
        let keys: Vec<&str> = section.keys().collect();
        keys.into_iter().for_each(|key| section.accept(key));
    }
    section.finish(findings);
    gauge
}

fn read_gauge(section: &mut Section<'_>, axes: AxisSet) -> Option<StrainGauge> {
    let axis = read_axis(section, axes);
    let sigma_um_m = section.number_where("sigma_um_per_m", "a number above 0", |sigma| sigma > 0.0);
    let positions_key = match axis {
        Some(axis) if axis.is_rotary() => "positions_deg",
        _ => "positions_mm",
    };
    let mut positions = axis.and_then(|_| {
        let positions = section.required(positions_key, "[0, 150, 350, 550, 700]", Section::numbers)?;
        let fault = if positions.len() < 2 {
            Some((section.place_of(positions_key), "fewer than two positions".to_owned()))
        } else {
            let index = positions.windows(2).position(|pair| pair[0] >= pair[1]);
            index.map(|index| {
                let message = format!("position {} of {positions_key} is not above the one before it", index + 2);
                (section.place_of_item(positions_key, index + 1), message)
            })
        };
        let Some((place, message)) = fault else { return Some(positions) };
        section.report(Code::BAD_TABLE, place, message, "give at least two positions, sorted, without duplicates");
        None
    });
    let count = positions.as_ref().map(Vec::len);
    let mut values = |key: &str, is_required: bool| {
        let values = if is_required {
            section.required(key, "[0, 0.002, 0.004, 0.002, 0]", Section::numbers)?
        } else {
            section.numbers(key)?
        };
        if let Some(count) = count.filter(|&count| count != values.len()) {
            let message = format!("{} values of {key} for {count} positions", values.len());
            let place = section.place_of(key);
            section.report(Code::BAD_TABLE, place, message, "give one value for every position");
            return None;
        }
        Some(values)
    };
    let force = values("um_per_m_per_N", true);
    let empty = values("empty_um_per_m", false);
    let moments = MOMENTS.map(|key| values(key, false));
    if moments.iter().flatten().count() > 2 {
        let help = "a weight has no moment about its own line of action: remove the key of that direction";
        let place = section.place_of_key(MOMENTS[1]);
        section.report(Code::BAD_VALUE, place, "moments of positions along X, Y and Z", help);
        return None;
    }
    let axis = axis?;
    if axis.is_rotary() {
        positions.iter_mut().flatten().for_each(|position| *position = position.to_radians());
    }
    Some(StrainGauge { axis, positions: positions?, force: force?, moments, empty, sigma_um_m })
}

fn read_axis(section: &mut Section<'_>, axes: AxisSet) -> Option<Axis> {
    let text = section.required("axis", "\"X\"", Section::text)?;
    let axis = match text.as_bytes() {
        [letter @ b'A'..=b'Z'] => Axis::from_letter(*letter).filter(|&axis| axes.contains(axis)),
        _ => None,
    };
    if axis.is_none() {
        let known: String = axes.iter().map(|axis| char::from(axis.letter())).collect();
        let message = format!("axis must be an axis of the machine, found \"{text}\"");
        section.report(Code::BAD_VALUE, section.place_of("axis"), message, format!("write one of {known}"));
    }
    axis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signal_is_linear_between_positions_and_unknown_outside() {
        let gauge = StrainGauge {
            axis: Axis::X,
            positions: vec![0.0, 100.0, 300.0],
            force: vec![1.0, 3.0, -1.0],
            moments: [None, None, None],
            empty: None,
            sigma_um_m: None,
        };
        let cases =
            [(0.0, 1.0), (50.0, 2.0), (100.0, 3.0), (200.0, 1.0), (300.0, -1.0)].map(|(at, value)| (at, Some(value)));
        for (at, value) in cases.into_iter().chain([(-0.1, None), (300.1, None), (f64::NAN, None)]) {
            assert_eq!(gauge.signal(&gauge.force, at), value, "{at}");
        }
    }
}
