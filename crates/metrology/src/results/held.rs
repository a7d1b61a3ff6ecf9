//! Comparison data of a measurement: statistics by direction and component, readings and circles for pictures.

use super::calibrated::{Data, KeptReadings, RepeatedReadings};
use super::compared::{Circle, MeasurementPart, ReadingPoint, ReadingSeries};
use super::repeats;
use crate::calibrate::{ComparedReading, Fit, Quality};
use crate::measure::circles::{self, circles};
use crate::measure::data::{DataSet, Observation};
use crate::measure::kind::Measurand;
use ncfix_base::geometry::Axis;
use ncfix_base::units::Unit;
use ncfix_machine::machine::Machine;

/// Comparison data of a measurement.
pub(super) struct ComparedMeasurement<'a> {
    /// The measurement.
    pub(super) data: &'a DataSet,
    /// Comparison of its readings with the model.
    pub(super) quality: Quality,
    /// Standard uncertainty of a length, mm, and of an angle, rad.
    pub(super) sigmas: [Option<f64>; 2],
    /// Residual of the fit, mm or rad, and weight of each reading; empty if it was held out.
    pub(super) fitted: Vec<[f64; 2]>,
    /// `true` if it was held out.
    pub(super) is_held_out: bool,
}

/// Residuals and weights of the readings of a measurement.
pub(super) fn fitted(fit: &Fit, set: usize) -> Vec<[f64; 2]> {
    fit.residuals.iter().filter(|(of, ..)| *of == set).map(|&(.., left, weight)| [left, weight]).collect()
}

/// The direction or component of a reading, by its row and its number in it.
pub(super) fn value_name(data: &DataSet, row: usize, index: usize) -> String {
    let Some(row) = data.observations.get(row) else { return String::new() };
    if let Some(component) = row.component {
        return component.to_string();
    }
    // Each value has an equation, in order; a probed ball has three without a column.
    let column = row.values.iter().enumerate().filter(|(_, value)| value.is_some()).nth(index);
    match column.and_then(|(k, _)| data.kind.columns.get(k)) {
        Some(name) => name.trim_end_matches("_um").to_owned(),
        None => ["X", "Y", "Z"].get(index).map_or_else(String::new, |name| (*name).to_owned()),
    }
}

impl ComparedMeasurement<'_> {
    /// The comparison of the measurement with the result, lengths and angles separately; with its readings if pictures are requested.
    pub(super) fn shown(&self, machine: &Machine, with_readings: bool) -> Vec<Data> {
        [false, true].into_iter().filter_map(|angles| self.in_unit(angles, machine, with_readings)).collect()
    }

    fn row(&self, line: &ComparedReading) -> Option<&Observation> {
        self.data.observations.get(line.row)
    }

    fn in_unit(&self, angles: bool, machine: &Machine, with_readings: bool) -> Option<Data> {
        let is_of_unit = |line: &ComparedReading| self.row(line).is_some_and(Observation::is_angle) == angles;
        let whole = self.quality.part(self.quality.name.clone(), is_of_unit);
        if whole.readings == 0 {
            return None;
        }
        let unit = Unit::of(angles);
        let shown = |value: f64| unit.shown(value);
        let names = self.part_names(&whole.lines);
        let part_of = |line: &ComparedReading| {
            let name = self.part_name(line);
            names.iter().position(|known| *known == name)
        };
        let parts = names.iter().enumerate().map(|(number, name)| {
            let part = whole.part(name.clone(), |line| part_of(line) == Some(number));
            MeasurementPart {
                name: part.name,
                readings: part.readings,
                unit,
                measured_rms: shown(part.measured[0]),
                measured_max: shown(part.measured[1]),
                left_rms: shown(part.left[0]),
                left_max: shown(part.left[1]),
                left_sigma: part.left_sigma.map(shown),
                efficiency: part.efficiency,
            }
        });
        let parts: Vec<MeasurementPart> = parts.collect();
        let repeated = names.iter().enumerate().filter_map(|(number, name)| {
            let own = whole.lines.iter().filter(|line| part_of(line) == Some(number));
            let values = own.filter_map(|line| Some((repeats::place(self.row(line)?), line.measured)));
            let values: Vec<_> = values.collect();
            let has_drift =
                self.data.is_in_order && repeats::drifts(values.iter().map(|(place, value)| (place, *value)));
            let (sigma, repetitions) = repeats::pooled(values)?;
            Some(RepeatedReadings { name: name.clone(), sigma: shown(sigma), repetitions, has_drift })
        });
        let repeated: Vec<RepeatedReadings> = repeated.collect();
        let shown_readings = if with_readings {
            let points = self.quality.lines.iter().enumerate().filter(|(_, line)| is_of_unit(line));
            let points = points.map(|(number, line)| ReadingPoint {
                row: line.row + 1,
                part: part_of(line).unwrap_or(0),
                setup: self.row(line).map_or(0, |row| row.setup),
                measured: shown(line.measured),
                left: shown(line.left),
                weight: self.fitted.get(number).map_or(1.0, |[_, weight]| *weight),
            });
            let points: Vec<ReadingPoint> = points.collect();
            ReadingSeries {
                setups: self.data.setups.iter().map(|setup| setup.label.clone()).collect(),
                axes: self.axes(machine, &whole.lines),
                circles: self.circles(machine, &points),
                points,
            }
        } else {
            ReadingSeries::default()
        };
        Some(Data {
            name: whole.name,
            kind: self.data.kind.name,
            is_held_out: self.is_held_out,
            readings: whole.readings,
            unit,
            measured_rms: shown(whole.measured[0]),
            measured_max: shown(whole.measured[1]),
            left_rms: shown(whole.left[0]),
            left_max: shown(whole.left[1]),
            sigma: self.sigmas[usize::from(angles)].map(shown),
            efficiency: whole.efficiency,
            kept: self.kept(is_of_unit).map(|kept| KeptReadings {
                left_rms: shown(kept.left_rms),
                left_max: shown(kept.left_max),
                ..kept
            }),
            parts,
            repeated,
            sums: whole.sums.map(shown),
            shown: shown_readings,
        })
    }

    /// Residuals without the readings of weight 0, mm or rad; `None` if there are no such readings, or no others.
    fn kept(&self, is_of_unit: impl Fn(&ComparedReading) -> bool) -> Option<KeptReadings> {
        let own = self.quality.lines.iter().zip(&self.fitted).filter(|(line, _)| is_of_unit(line));
        let (kept, gone): (Vec<[f64; 2]>, Vec<[f64; 2]>) =
            own.map(|(_, fitted)| *fitted).partition(|[_, weight]| *weight > 0.0);
        if kept.is_empty() || gone.is_empty() {
            return None;
        }
        let squares = kept.iter().map(|[left, _]| left * left).sum::<f64>();
        Some(KeptReadings {
            rejected: gone.len(),
            left_rms: (squares / kept.len() as f64).sqrt(),
            left_max: kept.iter().fold(0.0, |most, [left, _]| most.max(left.abs())),
        })
    }

    /// The direction or component of a reading.
    fn part_name(&self, line: &ComparedReading) -> String {
        value_name(self.data, line.row, line.index)
    }

    /// Directions and components in the order of their first occurrence.
    fn part_names(&self, lines: &[ComparedReading]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for line in lines {
            let name = self.part_name(line);
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Time, if known, and positions of the moving axes.
    fn axes(&self, machine: &Machine, lines: &[ComparedReading]) -> Vec<(String, Vec<f64>)> {
        let of = |axis: Axis| -> Vec<f64> {
            let factor = if axis.is_rotary() { 1.0_f64.to_degrees() } else { 1.0 };
            let place =
                |line: &ComparedReading| self.row(line).map_or(f64::NAN, |row| row.reading.position[axis] * factor);
            lines.iter().map(place).collect()
        };
        let moved = |values: &[f64]| values.iter().any(|value| Some(value) != values.first());
        let times: Vec<f64> =
            lines.iter().map(|line| self.row(line).and_then(|row| row.t_s).unwrap_or(f64::NAN)).collect();
        let axes = machine.axes.iter().flatten().map(|data| data.axis);
        let axes = axes.map(|axis| (format!("{axis} in {}", if axis.is_rotary() { "°" } else { "mm" }), of(axis)));
        let all = timed(times).into_iter().chain(axes);
        all.filter(|(_, values)| moved(values)).collect()
    }

    fn circles(&self, machine: &Machine, points: &[ReadingPoint]) -> Vec<Circle> {
        if self.data.kind.measurand != Measurand::BallDistance {
            return Vec::new();
        }
        // Readings of a ball-bar are one per row, in order.
        let number = |row: usize| points.binary_search_by_key(&(row + 1), |point| point.row).ok();
        circles(machine, self.data).iter().map(|circle| shown_circle(circle, self.data, number)).collect()
    }
}

/// Times in a unit with short numbers; `None` if a reading has none.
pub(super) fn timed(times: Vec<f64>) -> Option<(String, Vec<f64>)> {
    if times.iter().any(|time| !time.is_finite()) {
        return None;
    }
    let first = times.iter().copied().fold(f64::INFINITY, f64::min);
    let range = times.iter().fold(0.0, |range, time| f64::max(range, time - first));
    let (unit, seconds) = match range {
        range if range < 600.0 => ("s", 1.0),
        range if range < 4.0 * 3600.0 => ("min", 60.0),
        _ => ("h", 3600.0),
    };
    Some((format!("time in {unit}"), times.into_iter().map(|time| time / seconds).collect()))
}

/// A circle for pictures; `number` returns the index of the reading of a row.
pub(super) fn shown_circle(found: &circles::Circle, data: &DataSet, number: impl Fn(usize) -> Option<usize>) -> Circle {
    let (plane, axes) = match found.main_plane() {
        Some(0) => ("XY".to_owned(), ["X", "Y"].map(String::from)),
        Some(1) => ("YZ".to_owned(), ["Y", "Z"].map(String::from)),
        Some(_) => ("ZX".to_owned(), ["Z", "X"].map(String::from)),
        None => {
            let azimuth = format!("{:.0}°", found.azimuth().to_degrees()).replace('-', "\u{2212}");
            (format!("in the plane at {azimuth}"), [azimuth, "Z".to_owned()])
        }
    };
    Circle {
        setup: found.setup,
        plane,
        axes,
        radius_mm: data.setups.get(found.setup).map_or(0.0, |setup| setup.length_mm),
        is_counterclockwise: found.is_counterclockwise,
        angles: found.rows.iter().filter_map(|&(row, angle)| Some((number(row)?, angle))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_in_a_unit_of_their_size() {
        let of = |times: &[f64]| timed(times.to_vec()).map(|(name, times)| (name, times[1]));
        assert_eq!(of(&[0.0, 90.0]), Some(("time in s".into(), 90.0)));
        assert_eq!(of(&[100.0, 4000.0 + 200.0]), Some(("time in min".into(), 70.0)));
        assert_eq!(of(&[0.0, 36_000.0]), Some(("time in h".into(), 10.0)));
        assert_eq!(of(&[0.0, f64::NAN]), None);
    }
}
