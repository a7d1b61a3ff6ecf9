//! Sensors that show the weight of a workpiece without moving an axis past it: load cells, hydraulic pressure, the current of a vertical axis. Spaan (1995,
//! ch. 9) wished for one, because a strain gauge needs readings at several positions.
//!
//! ```text
//! reading = empty + F · (per_N + x · x_per_N_mm + y · y_per_N_mm + z · z_per_N_mm)
//! ```
//!
//! F is the weight, (x, y, z) its position from the center of the table along the axes of F.

use super::section::Section;
use ncfix_base::diagnostic::{Code, Diagnostic};

/// A sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadSensor {
    /// The column of its readings.
    pub name: String,
    /// Change of the reading per N of a load at the center of the table.
    pub per_n: f64,
    /// Change per N mm of the moments due to a position along X, Y and Z; 0 without one.
    pub per_n_mm: [f64; 3],
    /// Reading with the empty table.
    pub empty: f64,
    /// Standard uncertainty of a reading; `None` if it must be estimated from the readings.
    pub sigma: Option<f64>,
}

/// Keys of the moments.
const MOMENTS: [&str; 3] = ["x_per_N_mm", "y_per_N_mm", "z_per_N_mm"];

/// Reads the sections `[[load_sensor]]`.
pub(super) fn read(sections: Vec<Section<'_>>, findings: &mut Vec<Diagnostic>) -> Vec<LoadSensor> {
    let mut sensors: Vec<LoadSensor> = Vec::new();
    for mut section in sections {
        let name = section.required("name", "\"current_Z_A\"", Section::text).map(str::to_owned);
        let per_n = section.required("per_N", "0.002", |section, key| {
            section.number_where(key, "a number other than 0", |value| value != 0.0)
        });
        let per_n_mm = MOMENTS.map(|key| section.number(key).unwrap_or(0.0));
        let empty = section.number("empty").unwrap_or(0.0);
        let sigma = section.number_where("sigma", "a number above 0", |sigma| sigma > 0.0);
        if let Some(name) = &name
            && sensors.iter().any(|known| known.name == *name)
        {
            let place = section.place_of("name");
            section.report(
                Code::BAD_VALUE,
                place,
                format!("two load sensors are named \"{name}\""),
                "give each its own name",
            );
        }
        if let (Some(name), Some(per_n)) = (name, per_n) {
            sensors.push(LoadSensor { name, per_n, per_n_mm, empty, sigma });
        }
        section.finish(findings);
    }
    sensors
}
