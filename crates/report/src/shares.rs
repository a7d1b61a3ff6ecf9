//! Contribution of each error source to the position of the tool at one pose.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::Finding;
use ncfix_base::geometry::{AXES, AxisVector, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{ActiveTables, Condition, Machine, State};
use ncfix_model::{Accumulator, Effect, ErrorModel, Model};

/// Smallest share of a component that is listed, µm at the tip and µrad.
const LISTED: f64 = 0.05;

/// Errors at a pose: of the tool relative to the workpiece, along the directions of F.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shares {
    /// Pose: `X_mm`, `C_deg`.
    pub at: Vec<(String, f64)>,
    /// From the spindle gauge point to the tip, in F at the zero pose.
    pub tool_mm: [f64; 3],
    /// Sources in their order, each with its components by size.
    pub sources: Vec<Share>,
    /// Sum of all sources.
    pub sum: Deviation,
    /// Correction that would be added to the commands: `X_um`, `C_urad`; empty if none was found.
    pub correction: Vec<(String, f64)>,
    /// Diagnostics of the files.
    pub diagnostics: Vec<Finding>,
}

/// Contribution of one source.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// Name of the source.
    pub source: &'static str,
    /// Description of the source.
    pub title: &'static str,
    /// Deviation due to this source alone.
    pub deviation: Deviation,
    /// Its components, the largest first.
    pub components: Vec<(String, Deviation)>,
}

/// Deviation of the tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Deviation {
    /// Displacement of the tip along X, Y, Z.
    pub position_um: [f64; 3],
    /// Rotation of the tool about X, Y, Z.
    pub rotation_urad: [f64; 3],
}

impl Deviation {
    /// Returns the distance of the tip.
    #[must_use]
    pub fn distance_um(&self) -> f64 {
        Vector::from(self.position_um).norm()
    }

    /// Returns the difference from another deviation.
    fn less(&self, other: &Deviation) -> Deviation {
        let apart = |own: [f64; 3], other: [f64; 3]| [0, 1, 2].map(|index| own[index] - other[index]);
        Deviation {
            position_um: apart(self.position_um, other.position_um),
            rotation_urad: apart(self.rotation_urad, other.rotation_urad),
        }
    }

    fn counts(&self) -> bool {
        self.distance_um() >= LISTED || Vector::from(self.rotation_urad).norm() >= LISTED
    }
}

impl Shares {
    /// Returns the shares of all sources in the model.
    #[must_use]
    pub fn new(
        machine: &Machine,
        errors: &ErrorModel,
        condition: &Condition,
        at: &AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> Shares {
        // Active tables of the control have their own row; otherwise every row would include them.
        let bare = Machine { active_tables: ActiveTables::default(), ..machine.clone() };
        let of = |machine: &Machine, wanted: &dyn Fn(&dyn Effect) -> bool| {
            let model = Model::summed(&Accumulator::sum(machine, errors, condition, wanted));
            let found = model.deviation(at, tool_mm, state);
            Deviation {
                position_um: found.translation.map(um_from_mm).into(),
                rotation_urad: found.rotation.map(urad_from_rad).into(),
            }
        };
        let deviation = |wanted: &dyn Fn(&dyn Effect) -> bool| of(&bare, wanted);
        let sum = of(machine, &|_| true);
        let mut sources = Vec::new();
        for source in errors.sources() {
            let is_own = |effect: &dyn Effect| effect.source().name == source.name;
            let mut labels: Vec<String> = errors.effects_of(source.name).map(Effect::label).collect();
            labels.sort_unstable();
            labels.dedup();
            let mut components: Vec<(String, Deviation)> = labels
                .into_iter()
                .map(|label| {
                    let found = deviation(&|effect| is_own(effect) && effect.label() == label);
                    (label, found)
                })
                .filter(|(_, found)| found.counts())
                .collect();
            components.sort_by(|(_, one), (_, other)| other.distance_um().total_cmp(&one.distance_um()));
            sources.push(Share { source: source.name, title: source.title, deviation: deviation(&is_own), components });
        }
        if machine.active_tables.control.is_some() {
            let deviation = sum.less(&deviation(&|_| true));
            let title = "tables in the control";
            sources.push(Share { source: "tables", title, deviation, components: Vec::new() });
        }
        let model = Model::at(machine, errors, condition);
        let own = || AXES.into_iter().filter(|&axis| machine.axis(axis).is_some());
        let shown = |axis: ncfix_base::geometry::Axis, units: [&str; 2], values: [f64; 2]| {
            let which = usize::from(axis.is_rotary());
            (format!("{axis}_{}", units[which]), values[which])
        };
        let solved = model.solve(at, tool_mm, state, at, ncfix_model::Solve::Full).ok();
        let correction = solved.map(|command| command - *at);
        Shares {
            at: own().map(|axis| shown(axis, ["mm", "deg"], [at[axis], at[axis].to_degrees()])).collect(),
            tool_mm: (*tool_mm).into(),
            sources,
            sum,
            correction: correction.map_or(Vec::new(), |correction| {
                let value = |axis| [um_from_mm(correction[axis]), urad_from_rad(correction[axis])];
                own().map(|axis| shown(axis, ["um", "urad"], value(axis))).collect()
            }),
            diagnostics: Vec::new(),
        }
    }

    /// Returns the table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let mut line = |text: String| {
            let _ = writeln!(out, "{}", text.trim_end());
        };
        let listed = |values: &[(String, f64)], digits: usize| -> String {
            let parts = values.iter().map(|(key, value)| {
                let (axis, unit) = key.split_once('_').unwrap_or((key, ""));
                let unit = match unit {
                    "um" => " µm",
                    "urad" => " µrad",
                    "deg" => "°",
                    _ => "",
                };
                format!("{axis} {}{unit}", plain(*value, digits))
            });
            parts.collect::<Vec<_>>().join(", ")
        };
        let [x, y, z] = self.tool_mm.map(|part| plain(part, 4));
        line(format!("at          {}; tool {x} {y} {z} mm", listed(&self.at, 4)));
        line(String::new());
        line(format!(
            "{:<26}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}",
            "", "dX", "dY", "dZ", "distance", "rot. X", "rot. Y", "rot. Z"
        ));
        line(format!(
            "{:<26}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}",
            "source", "µm", "µm", "µm", "µm", "µrad", "µrad", "µrad"
        ));
        let row = |name: &str, deviation: &Deviation| {
            let [x, y, z] = deviation.position_um;
            let [a, b, c] = deviation.rotation_urad;
            let numbers = [x, y, z, deviation.distance_um(), a, b, c].map(|value| format!("{:>9}", fixed(value)));
            format!("{name:<26}{}", numbers.concat())
        };
        for share in &self.sources {
            line(row(share.source, &share.deviation));
            for (label, deviation) in &share.components {
                line(row(&format!("  {label}"), deviation));
            }
        }
        line(row("sum", &self.sum));
        line(String::new());
        if self.correction.is_empty() {
            line("correction  none was found".into());
        } else {
            line(format!("correction  {}", listed(&self.correction, 2)));
        }
        out
    }
}

/// Formats two decimals, without a minus sign before zero.
fn fixed(value: f64) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".into() } else { text }
}

/// Formats a value with up to `digits` decimals, without trailing zeros.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.to_owned() }
}
