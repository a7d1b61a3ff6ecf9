//! Why the tool is where it is: what each source of error does at one pose.

use std::fmt::Write as _;

use serde::Serialize;

use super::json::Finding;
use ncfix_base::geometry::{AXES, AxisKey, AxisVector, Vector};
use ncfix_base::units::{um_from_mm, urad_from_rad};
use ncfix_machine::machine::{ActiveTables, Condition, Machine, State};
use ncfix_model::{Accumulator, Effect, ErrorModel, Model};

/// Smaller shares of single components are not listed, µm at the tip and µrad.
const LISTED: f64 = 0.05;

/// Errors at a pose: of the tool relative to the workpiece, along F's directions.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Shares {
    /// The pose: `X_mm`, `C_deg`.
    pub at: Vec<(AxisKey, f64)>,
    /// From the spindle gauge point to the tip, in F at the zero pose.
    pub tool_mm: [f64; 3],
    /// Sources in their order, each with its components by size.
    pub sources: Vec<Share>,
    /// All of them together.
    pub sum: Deviation,
    /// What the correction would add to the commands: `X_um`, `C_urad`; empty where none was found.
    pub correction: Vec<(AxisKey, f64)>,
    /// Findings about the files.
    pub diagnostics: Vec<Finding>,
}

/// What one source does.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// The source.
    pub source: &'static str,
    /// What it is.
    pub title: &'static str,
    /// Its deviation alone.
    pub deviation: Deviation,
    /// Its components, the largest first.
    pub components: Vec<(String, Deviation)>,
}

/// A deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Deviation {
    /// Of the tip along X, Y, Z.
    pub position_um: [f64; 3],
    /// Of the tool about X, Y, Z.
    pub rotation_urad: [f64; 3],
}

impl Deviation {
    /// Distance of the tip.
    #[must_use]
    pub fn distance_um(&self) -> f64 {
        Vector::from(self.position_um).norm()
    }

    /// What this is more than another.
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
    /// The shares of all sources that the model has.
    #[must_use]
    pub fn new(
        machine: &Machine,
        errors: &ErrorModel,
        condition: &Condition,
        at: &AxisVector,
        tool_mm: &Vector,
        state: &State,
    ) -> Shares {
        // Tables that are active in the control have a row of their own: without this every row would have them in it.
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
        let shown = |key: AxisKey, value: f64| (key, key.shown(value));
        let solved = model.solve(at, tool_mm, state, at, ncfix_model::Solve::Full).ok();
        let correction = solved.map(|command| command - *at);
        Shares {
            at: own().map(|axis| shown(AxisKey::of_position(axis), at[axis])).collect(),
            tool_mm: (*tool_mm).into(),
            sources,
            sum,
            correction: correction.map_or(Vec::new(), |correction| {
                own().map(|axis| shown(AxisKey::of_deviation(axis), correction[axis])).collect()
            }),
            diagnostics: Vec::new(),
        }
    }

    /// The table for people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut out = String::new();
        // Writing into a String cannot fail.
        let mut line = |text: String| {
            let _ = writeln!(out, "{}", text.trim_end());
        };
        let listed = |values: &[(AxisKey, f64)], digits: usize| -> String {
            let parts =
                values.iter().map(|(key, value)| format!("{} {}{}", key.letter(), plain(*value, digits), key.suffix()));
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

/// Two decimals, without a minus before nothing.
fn fixed(value: f64) -> String {
    let text = format!("{value:.2}");
    if text == "-0.00" { "0.00".into() } else { text }
}

/// Up to so many decimals, trailing zeros dropped.
fn plain(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.to_owned() }
}
