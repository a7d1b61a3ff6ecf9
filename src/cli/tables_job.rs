//! What `ncfix tables` is asked for: the machine, the part of its volume, the names of the axes and the tool.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::arguments::TablesArguments;
use super::findings::Findings;
use super::machine_choice::{self, Chosen};
use super::state;
use super::stop::Stop;
use super::value::ToolVector;
use ncfix_base::geometry::{Axis, AxisVector, Vector};
use ncfix_machine::machine::{ActiveTables, Machine};
use ncfix_report::tables::CheckReport;
use ncfix_tables::tables::check::check;
use ncfix_tables::tables::region::Region;
use ncfix_tables::tables::{Control, Multiplication, Orientation, Tables, Wiring};

/// Start of the generator of the poses of a check: none of those of a scheme.
pub(super) const SEED: u64 = 0x43_4845_434b;

/// What is asked, with the machine that it is asked of.
pub(super) struct Job<'a> {
    pub(super) arguments: &'a TablesArguments,
    pub(super) chosen: Chosen,
    pub(super) region: Region,
    pub(super) wiring: Wiring,
    pub(super) tool_mm: Vector,
}

/// The machine, the region and the names; `None` where findings forbid to use them.
pub(super) fn job<'a>(arguments: &'a TablesArguments, findings: &mut Findings) -> Result<Option<Job<'a>>, Stop> {
    once("--range", arguments.range.iter().map(|(axis, _)| axis.to_string()))?;
    let beside = arguments.output.as_deref().or(arguments.read.first().map(PathBuf::as_path)).unwrap_or(Path::new("."));
    let Some(mut chosen) = machine_choice::choose(&arguments.machine, beside, findings)? else { return Ok(None) };
    // New tables are for the machine itself, and those that are checked stand for themselves.
    let multiplication = chosen.machine.active_tables.multiplication;
    chosen.machine.active_tables = ActiveTables { multiplication, ..ActiveTables::default() };
    if !state::apply(&arguments.state, &mut chosen, findings)? || findings.has_errors() {
        return Ok(None);
    }
    let mut region = Region::travel(&chosen.machine).map_err(|axis| {
        Stop::Usage(format!("axis {axis} has no travel; write travel_mm of it into the machine file"))
    })?;
    for &(axis, [low, high]) in &arguments.range {
        let Some(data) = chosen.machine.axis(axis) else {
            return Err(Stop::Usage(format!("--range: the machine has no axis {axis}")));
        };
        let unit = |value: f64| if axis.is_rotary() { value.to_radians() } else { value };
        let range = [unit(low), unit(high)];
        if let Some([lowest, highest]) =
            data.travel.filter(|[lowest, highest]| range[0] < lowest - 1e-9 || range[1] > highest + 1e-9)
        {
            let shown = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
            return Err(Stop::Usage(format!(
                "--range: {axis} travels from {} to {}",
                short(shown(lowest)),
                short(shown(highest))
            )));
        }
        region.set(axis, range);
    }
    let mut wiring = Wiring::of(&chosen.machine);
    arguments.axis_name.iter().for_each(|(axis, name)| wiring.rename(*axis, name));
    let tool_mm = match arguments.tool {
        Some(ToolVector::Tip(tip_mm)) => tip_mm,
        Some(ToolVector::Length(length_mm)) => chosen.machine.spindle.axis * -length_mm,
        None => chosen.machine.spindle.axis * -longest_tool_mm(&chosen.machine),
    };
    Ok(Some(Job { arguments, chosen, region, wiring, tool_mm }))
}

fn longest_tool_mm(machine: &Machine) -> f64 {
    machine.tools.iter().map(|tool| tool.length_mm[0].abs()).fold(0.0, f64::max)
}

/// Refuses an option that says something of the same thing twice.
pub(super) fn once(option: &str, all: impl Iterator<Item = String>) -> Result<(), Stop> {
    let mut known: Vec<String> = Vec::new();
    for one in all.map(|one| one.to_ascii_uppercase()) {
        if known.contains(&one) {
            return Err(Stop::Usage(format!("{option} is given twice for {one}; give it once")));
        }
        known.push(one);
    }
    Ok(())
}

/// A number with the digits that people write, without those that conversions make.
fn short(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

impl Job<'_> {
    /// `X -130 .. 130 mm, A -55 .. 55 deg`: all of the volume.
    pub(super) fn volume(&self) -> String {
        let text = |&(axis, [low, high]): &(Axis, [f64; 2])| {
            let shown = |value: f64| if axis.is_rotary() { value.to_degrees() } else { value };
            format!("{axis} {} .. {}", short(shown(low)), short(shown(high)))
        };
        self.region.ranges.iter().map(text).collect::<Vec<_>>().join(", ")
    }

    /// `A -55 .. 55 deg` for each range that was asked for.
    pub(super) fn ranges(&self) -> Vec<String> {
        let text = |&(axis, [low, high]): &(Axis, [f64; 2])| {
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            format!("{axis} {} .. {} {unit}", short(low), short(high))
        };
        self.arguments.range.iter().map(text).collect()
    }

    /// What the control does with products, where it is said.
    pub(super) fn multiplication(&self) -> Option<Multiplication> {
        let asked = self.arguments.multiplication.map(|choice| choice.multiplication());
        asked.or(self.chosen.machine.active_tables.multiplication.map(Multiplication::from))
    }

    pub(super) fn target<'t>(&'t self, model: &'t ncfix_model::Model) -> ncfix_tables::tables::Target<'t> {
        ncfix_tables::tables::Target {
            machine: &self.chosen.machine,
            model,
            tool_mm: self.tool_mm,
            orientation: self.arguments.orientation.map_or(Orientation::Smooth, |choice| choice.orientation()),
        }
    }

    /// What tables leave over the volume; a grid knows no rotary axes.
    pub(super) fn check(&self, tables: &Tables) -> CheckReport {
        let mut region = self.region.reached(&self.chosen.machine);
        if tables.grid.is_some() || tables.matrix.is_some() {
            for (axis, [low, high]) in self.region.ranges.iter().filter(|(axis, _)| axis.is_rotary()) {
                let at = 0_f64.clamp(*low, *high);
                region.set(*axis, [at, at]);
            }
        }
        self.check_in(&region, tables)
    }
}

impl Job<'_> {
    /// What tables leave where the machine is used: the range of every axis, the rotary ones too, for which a grid has no tables but which turn all
    /// the same.
    pub(super) fn everywhere(&self, tables: &Tables, checked: &CheckReport) -> CheckReport {
        if tables.grid.is_none() && tables.matrix.is_none() {
            return checked.clone();
        }
        self.check_in(&self.region.reached(&self.chosen.machine), tables)
    }

    fn check_in(&self, region: &Region, tables: &Tables) -> CheckReport {
        let model = self.chosen.model();
        let target = self.target(&model);
        let poses = region.poses(self.arguments.poses as usize, SEED);
        let found = check(&target, &Control::new(&self.chosen.machine, tables), &poses);
        CheckReport::new(&found, place(region, &found.worst), &self.tool_mm)
    }
}

/// `X120.5 Y-3 A30`
fn place(region: &Region, pose: &AxisVector) -> String {
    let mut text = String::new();
    for &(axis, _) in &region.ranges {
        let value = if axis.is_rotary() { pose[axis].to_degrees() } else { pose[axis] };
        let _ = write!(text, "{}{axis}{value:.1}", if text.is_empty() { "" } else { " " });
    }
    text
}
