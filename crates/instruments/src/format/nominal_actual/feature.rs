//! Features, and the words of their coordinates.

use ncfix_base::geometry::Axis;

use crate::unit::ReadingUnit;
use crate::words;

/// Headings of nominal values.
pub(super) const NOMINAL: &[&str] =
    &["nom", "nominal", "theo", "theoretical", "soll", "sollwert", "target", "cmd", "command", "commanded", "nominale"];
/// Headings of actual values.
pub(super) const ACTUAL: &[&str] =
    &["act", "actual", "actl", "meas", "measured", "ist", "istwert", "messwert", "mesuré", "reale", "medido"];

/// Feature: nominal and actual coordinates in the unit of the file.
#[derive(Clone, Debug, Default)]
pub(super) struct Feature {
    pub(super) nominal: [Option<f64>; 3],
    pub(super) actual: [Option<f64>; 3],
    pub(super) line: usize,
}

impl Feature {
    /// The feature after quarter turns about Z: the x of the part points along Y+ after the first one.
    pub(super) fn turned(mut self, quarters: usize) -> Feature {
        for _ in 0..quarters {
            for [x, y, _] in [&mut self.nominal, &mut self.actual] {
                (*x, *y) = (y.map(|y| -y), *x);
            }
        }
        self
    }
}

/// Features, and the unit with its line if the file states it.
pub(super) type StatedFeatures = (Vec<Feature>, Option<(ReadingUnit, usize)>);

/// Coordinate of a row label: `X`, `X-axis`, `Pos.Y`, `xValue`, `Y-Wert`.
pub(super) fn coordinate(text: &str) -> Option<usize> {
    let text = text.trim().to_lowercase();
    let text = ["value", "wert"].iter().find_map(|word| text.strip_suffix(word)).unwrap_or(&text);
    words::axis(text).and_then(|axis| [Axis::X, Axis::Y, Axis::Z].iter().position(|own| *own == axis))
}
