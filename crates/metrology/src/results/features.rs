//! Features of a workpiece that was machined and then measured: deviations, what the errors of the machine explain of them, and drift.
//!
//! Position and rotation of the workpiece on the measuring machine are unknowns of the set-up. Deviations are those of the best fit without them.

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::figure::{FigureGroup, FigureValue, Standard};
use super::measurement::Measurement;
use crate::calibrate::{ComparedReading, quality};
use crate::measure::data::FEATURE_COLUMNS;
use crate::measure::kind::Measurand;
use ncfix_base::csv::Table;
use ncfix_base::geometry::Vector;
use ncfix_base::units::{Unit, um_from_mm};
use ncfix_machine::machine::Machine;
use ncfix_model::ErrorModel;

/// Names of the figures of all readings, and of those along X, Y and Z: rms and largest value.
const NAMES: [[&str; 2]; 4] = [["rms", "max"], ["rms X", "max X"], ["rms Y", "max Y"], ["rms Z", "max Z"]];
/// Singular value below which the alignment by the first level is not determined: directions have the size 1.
const LEAST_SINGULAR: f64 = 1e-6;
/// Names of the readings along X, Y and Z.
const ALONG: [&str; 3] = ["dx", "dy", "dz"];

/// A feature of a workpiece, such as a hole or a tread.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FeatureDeviation {
    /// Its name.
    pub feature: String,
    /// Its level, if the table states it.
    pub level: Option<u32>,
    /// Displacements along X, Y and Z, measured minus nominal, µm; `null` where it gives no reading.
    pub deviation: [Option<f64>; 3],
    /// The part of them that the errors of the machine file do not explain, µm.
    pub left: [Option<f64>; 3],
}

/// The figures and features of a measurement with the column `feature`; `None` for others.
#[must_use]
pub fn figures(
    one: &Measurement,
    machine: &Machine,
    errors: &ErrorModel,
) -> Option<(Vec<FigureGroup>, Vec<FeatureDeviation>)> {
    let table = Table::read(&one.sources[0]).0?;
    let [name_column, level_column] = [FEATURE_COLUMNS[0], FEATURE_COLUMNS[1]].map(|name| table.column(name));
    let name_column = name_column.filter(|_| one.data.kind.measurand == Measurand::Displacement)?;
    let compared = match quality(machine, errors, &one.data) {
        Ok(compared) => compared,
        Err(_) => {
            let reason = Some("the readings do not determine position and rotation of the part".to_owned());
            return Some((vec![FigureGroup { of: "features".into(), reason, ..FigureGroup::default() }], Vec::new()));
        }
    };
    let cell = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    let of_row = |row: ncfix_base::csv::Row<'_>| FeatureDeviation {
        feature: cell(row.text(name_column)),
        level: level_column.and_then(|column| cell(row.text(column)).parse().ok()),
        ..FeatureDeviation::default()
    };
    let mut features: Vec<FeatureDeviation> = table.rows().map(of_row).collect();
    for line in &compared.lines {
        let Some(k) = direction(one, line) else { continue };
        if let Some(feature) = features.get_mut(line.row) {
            feature.deviation[k] = Some(um_from_mm(line.measured));
            feature.left[k] = Some(um_from_mm(line.left));
        }
    }
    let removed = "position and rotation of the part removed";
    let mut groups = vec![group(
        "features",
        &features,
        |one| one.deviation,
        vec![format!("{} features", features.len()), removed.into()],
    )];
    if features.iter().any(|one| one.deviation != one.left) {
        let explains = format!("the errors of the machine file explain {:.1} %", 100.0 * compared.efficiency);
        groups.push(group(
            "features without the errors of the machine file",
            &features,
            |one| one.left,
            vec![explains],
        ));
    }
    let coordinates = [2, 3, 4].map(|k| table.column(FEATURE_COLUMNS[k]));
    let place = |row: ncfix_base::csv::Row<'_>| {
        let [x, y, z] = coordinates.map(|column| cell(row.text(column?)).replace(',', ".").parse().ok());
        Some(Vector::new(x?, y?, z?))
    };
    let places: Vec<Option<Vector>> = table.rows().map(place).collect();
    groups.extend(levels(&features, &places));
    Some((groups, features))
}

/// The direction of a reading: 0, 1, 2 for X, Y, Z.
fn direction(one: &Measurement, line: &ComparedReading) -> Option<usize> {
    let values = one.data.observations.get(line.row)?.values;
    (0..3).filter(|k| values[*k].is_some()).nth(line.index)
}

/// Root mean square and largest value, of all readings and by direction.
fn group(
    of: &str,
    features: &[FeatureDeviation],
    values: impl Fn(&FeatureDeviation) -> [Option<f64>; 3],
    conditions: Vec<String>,
) -> FigureGroup {
    let mut out = FigureGroup {
        of: of.into(),
        standard: Standard::LeastSquares,
        unit: Unit::Um,
        conditions,
        ..FigureGroup::default()
    };
    for (names, only) in NAMES.into_iter().zip([None, Some(0), Some(1), Some(2)]) {
        let all = features.iter().map(&values);
        let own: Vec<f64> = match only {
            None => all.flatten().flatten().collect(),
            Some(k) => all.filter_map(|values: [Option<f64>; 3]| values[k]).collect(),
        };
        if let Some(sizes) = sizes(&own) {
            out.values.extend(names.into_iter().zip(sizes).map(|(name, value)| FigureValue { name, value }));
        }
    }
    out
}

/// Root mean square and largest magnitude; `None` without values.
fn sizes(values: &[f64]) -> Option<[f64; 2]> {
    let count = values.len();
    let squares = values.iter().map(|value| value * value).sum::<f64>();
    (count > 0).then(|| [(squares / count as f64).sqrt(), values.iter().fold(0.0, |most, value| value.abs().max(most))])
}

/// The mean displacement of each level, of a workpiece that is aligned by its first level: what changed while it was machined (Spaan 1995, ch. 5).
///
/// An alignment by all levels would hide a part of a drift: it could turn the workpiece until its levels are above each other.
fn levels(features: &[FeatureDeviation], places_mm: &[Option<Vector>]) -> Vec<FigureGroup> {
    let mut known: Vec<u32> = features.iter().filter_map(|one| one.level).collect();
    known.sort_unstable();
    known.dedup();
    let Some((&first, others)) = known.split_first().filter(|(_, others)| !others.is_empty()) else {
        return Vec::new();
    };
    // A small displacement and rotation about the zero of the workpiece: d = o + ρ × p, µm and µm/mm.
    let effect = |place: &Vector, k: usize| {
        let direction = Vector::ith(k, 1.0);
        let turned = place.cross(&direction);
        [direction.x, direction.y, direction.z, turned.x, turned.y, turned.z]
    };
    let readings = |of: u32| -> Vec<(usize, [f64; 6], f64)> {
        let own = features.iter().zip(places_mm).filter(|(one, _)| one.level == Some(of));
        let all = own.flat_map(|(one, place)| {
            let read = one.deviation.iter().enumerate().filter_map(|(k, value)| Some((k, (*value)?)));
            read.filter_map(|(k, value)| Some((k, effect(&(*place)?, k), value))).collect::<Vec<_>>()
        });
        all.collect()
    };
    let aligned = readings(first);
    let matrix = DMatrix::from_fn(aligned.len(), 6, |row, column| aligned[row].1[column]);
    let values = DVector::from_iterator(aligned.len(), aligned.iter().map(|(_, _, value)| *value));
    // What the first level does not determine stays 0.
    let Ok(moved) = matrix.svd(true, true).solve(&values, LEAST_SINGULAR) else { return Vec::new() };
    let of_level = |&level: &u32| {
        let own = readings(level);
        let mean = |k: usize| {
            let along = own.iter().filter(|(of, ..)| *of == k);
            let left = |effect: &[f64; 6]| effect.iter().zip(moved.iter()).map(|(one, by)| one * by).sum::<f64>();
            let all: Vec<f64> = along.map(|(_, effect, value)| value - left(effect)).collect();
            (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
        };
        let named = ALONG.into_iter().enumerate();
        FigureGroup {
            of: format!("level {level}"),
            standard: Standard::LeastSquares,
            unit: Unit::Um,
            values: named.filter_map(|(k, name)| Some(FigureValue { name, value: mean(k)? })).collect(),
            conditions: vec![format!("mean, the part aligned by level {first}")],
            ..FigureGroup::default()
        }
    };
    others.iter().map(of_level).collect()
}

/// A workpiece compared with an earlier one of this name: the features that both have; `None` without such features.
#[must_use]
pub fn against(name: &str, before: &[FeatureDeviation], after: &[FeatureDeviation]) -> Option<FigureGroup> {
    let known: HashMap<&str, &FeatureDeviation> = before.iter().map(|one| (one.feature.as_str(), one)).collect();
    let mut pairs: Vec<[f64; 2]> = Vec::new();
    for one in after {
        let Some(old) = known.get(one.feature.as_str()) else { continue };
        let both = old.deviation.iter().zip(&one.deviation);
        pairs.extend(both.filter_map(|(old, new)| Some([(*old)?, (*new)?])));
    }
    let of = |which: usize| pairs.iter().map(|pair| pair[which]).collect::<Vec<f64>>();
    let ([old_rms, old_max], [rms, max]) = (sizes(&of(0))?, sizes(&of(1))?);
    let sum = |values: Vec<f64>| values.iter().map(|value| value.abs()).sum::<f64>();
    let (old_sum, new_sum) = (sum(of(0)), sum(of(1)));
    let efficiency = if old_sum > 0.0 { 100.0 * (1.0 - new_sum / old_sum) } else { 0.0 };
    let named = [("rms before", old_rms), ("max before", old_max), ("rms", rms), ("max", max)];
    Some(FigureGroup {
        of: format!("features against {name}"),
        standard: Standard::LeastSquares,
        unit: Unit::Um,
        values: named.into_iter().map(|(name, value)| FigureValue { name, value }).collect(),
        conditions: vec![format!("{} readings", pairs.len()), format!("efficiency {efficiency:.1} %")],
        ..FigureGroup::default()
    })
}
