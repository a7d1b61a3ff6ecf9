//! Description of a machine: statements, data of the control and assumed values for the axes of a template.

use std::collections::BTreeMap;

use super::data::{ControlFacts, DataNote, DataNoteKind};
use super::known::{Known, KnownOrigin, signed};
use super::stated::{StatedPivot, StatedSense, StatedTravel, TravelRange};
use super::template::{Template, TemplateRotary};
use crate::machine::controller::{ControllerMeaning, controller};
use crate::machine::{Branch, Topology};
use ncfix_base::geometry::{Axis, Vector};

/// Question to a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Question {
    /// The question, with the default in brackets if there is one.
    pub text: String,
    /// The option that answers it on the command line.
    pub option: String,
}

/// Reads the answer to a question; `None` if nobody answers or the answer is empty.
pub type Ask<'a> = &'a mut dyn FnMut(&Question) -> Option<String>;

/// Statements from which a description is made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DescriptionRequest {
    /// Name of the machine.
    pub name: String,
    /// Name of the control; `None`: that of the files, otherwise `sinumerik`.
    pub control: Option<String>,
    /// Stated travels.
    pub travels: Vec<StatedTravel>,
    /// Stated senses.
    pub senses: Vec<StatedSense>,
    /// Stated points on rotary axes.
    pub pivots: Vec<StatedPivot>,
    /// Stated unit of the files in which the control saves offsets and tools: `mm` or `inch`.
    pub saved_unit: Option<String>,
    /// Data of the control.
    pub facts: ControlFacts,
}

/// Description of a new machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Name of the machine.
    pub name: String,
    /// Template of its chain.
    pub template: &'static Template,
    /// Its chain.
    pub topology: Topology,
    /// Name of its control, as stated.
    pub control: Known<String>,
    /// Axes, from the workpiece to the tool.
    pub axes: Vec<AxisDescription>,
    /// Axes in the order of their numbers at the control, if the data state them; `None` is an axis that the machine does not have.
    pub axis_order: Option<Known<Vec<Option<Axis>>>>,
    /// Unit of the files in which the control saves offsets and tools.
    pub saved_unit: Option<Known<&'static str>>,
    /// Increments into which the control divides a millimeter.
    pub increments_per_mm: Option<Known<u32>>,
    /// True if a tool change moves axes.
    pub tool_change_moves: Option<Known<bool>>,
    /// Words in force before the first block.
    pub startup_code: Option<Known<String>>,
    /// Lines of `[control]`: words that are in force before the first block.
    pub control_lines: Vec<Known<String>>,
    /// Data of the files that the machine file does not carry, each with its line.
    pub notes: Vec<DataNote>,
}

/// Axis of a description.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisDescription {
    /// Axis.
    pub axis: Axis,
    /// Side of F.
    pub branch: Branch,
    /// Motion of the carried part in F for a positive command, or the axis of rotation; of any length.
    pub direction: Known<[f64; 3]>,
    /// Travel, mm or degrees, or a modulo axis.
    pub travel: Known<TravelRange>,
    /// Point on a rotary axis in F at the zero pose, mm.
    pub point_mm: Option<Known<[f64; 3]>>,
    /// Maximum feed, mm/min or degrees/min.
    pub max_feed: Option<Known<f64>>,
}

impl DescriptionRequest {
    /// Makes the description for a template, and asks for the values that nobody stated.
    ///
    /// # Errors
    /// Returns a sentence with all dangerous values that are missing, or the first statement that does not fit.
    pub fn describe(&self, template: &'static Template, ask: Ask<'_>) -> Result<Description, String> {
        let topology: Topology =
            template.topology.parse().map_err(|fault| format!("template {}: {fault}", template.name))?;
        self.check_axes(&topology)?;
        if let Some(contradiction) = self.facts.contradiction(&topology) {
            return Err(contradiction);
        }
        let control = self.control()?;
        // Grbl counts from the corner to which it homes, usually the positive one.
        let is_negative = GRBL.contains(&control.value.to_ascii_lowercase().as_str());
        let mut missing = Vec::new();
        let mut axes = Vec::new();
        let tool = topology.tool.iter().map(|axis| (*axis, Branch::Tool));
        let chain = topology.workpiece.iter().rev().map(|axis| (*axis, Branch::Workpiece)).chain(tool);
        for (axis, branch) in chain {
            axes.push(match template.rotary.iter().find(|rotary| rotary.axis == axis) {
                Some(rotary) => self.rotary(rotary, branch, ask, &mut missing)?,
                None => self.linear(axis, branch, (template, is_negative), ask)?,
            });
        }
        if !missing.is_empty() {
            // Data that were not used may be the reason.
            let unused = self.facts.notes.iter().filter(|note| note.kind == DataNoteKind::Unused);
            missing.extend(unused.map(ToString::to_string));
            return Err(missing.join("; "));
        }
        let notes = self.facts.notes.clone();
        let unit = |text: &String| if text.as_str() == "inch" { "inch" } else { "mm" };
        let stated = self.saved_unit.as_ref().map(|text| Known { value: unit(text), origin: KnownOrigin::Stated });
        let saved_unit = stated.or_else(|| self.facts.saved_unit.clone());
        let axis_order = self.facts.axis_numbers.as_ref().and_then(|numbers| axis_order(numbers, &axes));
        let increments_per_mm = self.facts.increments_per_mm.clone();
        let tool_change_moves = self.facts.tool_change_moves.clone();
        let startup_code = self.facts.startup_code.clone();
        Ok(Description {
            name: self.name.clone(),
            template,
            topology,
            control,
            axes,
            axis_order,
            saved_unit,
            increments_per_mm,
            tool_change_moves,
            startup_code,
            control_lines: self.facts.control_lines.clone(),
            notes,
        })
    }

    fn check_axes(&self, topology: &Topology) -> Result<(), String> {
        let stated = self.travels.iter().map(|one| one.axis).chain(self.senses.iter().map(|one| one.axis));
        for axis in stated.chain(self.pivots.iter().map(|one| one.axis)) {
            if topology.branch(axis).is_none() {
                return Err(format!("the chain {topology} has no axis {axis}"));
            }
        }
        match self.pivots.iter().find(|one| !one.axis.is_rotary()) {
            Some(one) => Err(format!("--pivot is for rotary axes, and {} is linear", one.axis)),
            None => Ok(()),
        }
    }

    fn control(&self) -> Result<Known<String>, String> {
        let stated = self.control.clone().map(|value| Known { value, origin: KnownOrigin::Stated });
        let found = stated.or_else(|| self.facts.control.clone());
        let known = found.unwrap_or_else(|| Known { value: "sinumerik".to_owned(), origin: KnownOrigin::Assumed });
        match controller(&known.value).map(|row| row.meaning) {
            Some(ControllerMeaning::Language(_) | ControllerMeaning::Haas) => Ok(known),
            Some(ControllerMeaning::Differs(advice) | ControllerMeaning::Unread(advice)) => {
                Err(format!("control {}: {advice}", known.value))
            }
            None => Err(format!(
                "'{}' is not a control that ncfix knows; write sinumerik, fanuc, haas, linuxcnc, grbl or grundig",
                known.value
            )),
        }
    }

    fn linear(
        &self,
        axis: Axis,
        branch: Branch,
        (template, is_negative): (&Template, bool),
        ask: Ask<'_>,
    ) -> Result<AxisDescription, String> {
        let facts = self.facts.axis(axis);
        let mut usual = template.travels_mm[axis.dimension()];
        if is_negative && usual[1] > 0.0 {
            usual = usual.map(|end| end - usual[1]);
        }
        let usual = TravelRange::Ends(usual);
        let stated = self.travels.iter().find(|one| one.axis == axis).map(|one| one.range);
        let travel = self.travel(axis, (stated, facts.and_then(|facts| facts.travel.clone())), usual, ask)?;
        if travel.value == TravelRange::Modulo {
            return Err(format!("{axis} is a linear axis: write its travel as {axis}=0..500"));
        }
        let own = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]][axis.dimension()];
        let turned = self.senses.iter().find(|one| one.axis == axis).map(|one| !one.is_positive);
        let is_reversed = turned.unwrap_or(branch == Branch::Workpiece);
        let origin = if turned.is_some() { KnownOrigin::Stated } else { KnownOrigin::Convention };
        Ok(AxisDescription {
            axis,
            branch,
            direction: Known { value: signed(own, !is_reversed), origin },
            travel,
            point_mm: None,
            max_feed: facts.and_then(|facts| facts.max_feed.clone()),
        })
    }

    fn rotary(
        &self,
        rotary: &TemplateRotary,
        branch: Branch,
        ask: Ask<'_>,
        missing: &mut Vec<String>,
    ) -> Result<AxisDescription, String> {
        let axis = rotary.axis;
        let facts = self.facts.axis(axis);
        let stated = self.senses.iter().find(|one| one.axis == axis);
        let mut direction =
            stated.map(|one| Known { value: signed(rotary.line, one.is_positive), origin: KnownOrigin::Stated });
        direction = direction.or_else(|| facts.and_then(|facts| facts.direction.clone()));
        if direction.is_none() {
            let [x, y, z] = rotary.line;
            let carried = if branch == Branch::Tool { "the head" } else { "the table" };
            let question = Question {
                text: format!(
                    "Sense of {axis}: jog {axis}+ and watch {carried} against the vector ({x}, {y}, {z}). \
                     Does it turn counter-clockwise (+) or clockwise (-)?"
                ),
                option: format!("--sense {axis}=+ or {axis}=-"),
            };
            direction = match ask(&question) {
                Some(answer) => {
                    let sense: StatedSense = format!("{axis}={}", answer.trim()).parse()?;
                    Some(Known { value: signed(rotary.line, sense.is_positive), origin: KnownOrigin::Stated })
                }
                None => None,
            };
            if direction.is_none() {
                missing.push(format!(
                    "the sense of {axis} is not known, and a wrong one is dangerous: give {} (+: {carried} turns about ({x}, {y}, {z}) by the right-hand rule)",
                    question.option
                ));
            }
        }
        let stated = self.pivots.iter().find(|one| one.axis == axis);
        let mut point_mm = stated.map(|one| Known { value: one.point_mm, origin: KnownOrigin::Stated });
        point_mm = point_mm.or_else(|| facts.and_then(|facts| facts.point_mm.clone()));
        if point_mm.is_none() {
            let question = Question {
                text: format!("Point on the axis of {axis}, in machine coordinates with all axes at zero, mm: X,Y,Z"),
                option: format!("--pivot {axis}=X,Y,Z"),
            };
            match ask(&question) {
                Some(answer) => {
                    let pivot: StatedPivot = format!("{axis}={}", answer.trim()).parse()?;
                    point_mm = Some(Known { value: pivot.point_mm, origin: KnownOrigin::Stated });
                }
                None => missing.push(format!(
                    "a point on the axis of {axis} is not known, and a wrong one is dangerous: give {} (machine coordinates, all axes at zero, mm)",
                    question.option
                )),
            }
        }
        let stated = self.travels.iter().find(|one| one.axis == axis).map(|one| one.range);
        let usual = rotary.travel_deg.map_or(TravelRange::Modulo, TravelRange::Ends);
        let travel = self.travel(axis, (stated, facts.and_then(|facts| facts.travel.clone())), usual, ask)?;
        let unknown = Known { value: rotary.line, origin: KnownOrigin::Assumed };
        Ok(AxisDescription {
            axis,
            branch,
            direction: direction.unwrap_or(unknown),
            travel,
            point_mm,
            max_feed: facts.and_then(|facts| facts.max_feed.clone()),
        })
    }

    fn travel(
        &self,
        axis: Axis,
        (stated, taken): (Option<TravelRange>, Option<Known<TravelRange>>),
        usual: TravelRange,
        ask: Ask<'_>,
    ) -> Result<Known<TravelRange>, String> {
        if let Some(value) = stated {
            return Ok(Known { value, origin: KnownOrigin::Stated });
        }
        if let Some(taken) = taken {
            return Ok(taken);
        }
        let unit = if axis.is_rotary() { "degrees, or modulo" } else { "mm" };
        let question = Question {
            text: format!("Travel of {axis} in machine coordinates, {unit} [{usual}]"),
            option: format!("--travel {axis}={usual}"),
        };
        Ok(match ask(&question) {
            Some(answer) => {
                let travel: StatedTravel = format!("{axis}={}", answer.trim()).parse()?;
                Known { value: travel.range, origin: KnownOrigin::Stated }
            }
            None => Known { value: usual, origin: KnownOrigin::Assumed },
        })
    }
}

/// Controls that count from the positive end of their axes.
const GRBL: [&str; 3] = ["grbl", "grblhal", "fluidnc"];

impl AxisDescription {
    /// Returns the direction as a vector of F.
    #[must_use]
    pub fn vector(&self) -> Vector {
        Vector::from(self.direction.value)
    }
}

/// The axes of a machine in the order of their numbers at the control; `None` if an axis has no number, or the order is the usual one of three axes.
fn axis_order(numbers: &Known<BTreeMap<usize, Axis>>, axes: &[AxisDescription]) -> Option<Known<Vec<Option<Axis>>>> {
    let has = |axis: Axis| axes.iter().any(|described| described.axis == axis);
    let own: BTreeMap<usize, Axis> =
        numbers.value.iter().filter(|(_, axis)| has(**axis)).map(|(number, axis)| (*number, *axis)).collect();
    let last = *own.keys().next_back()?;
    let order: Vec<Option<Axis>> = (1..=last).map(|number| own.get(&number).copied()).collect();
    let is_whole = axes.iter().all(|described| order.contains(&Some(described.axis)));
    let is_usual = order == [Axis::X, Axis::Y, Axis::Z].map(Some);
    (is_whole && !is_usual).then(|| Known { value: order, origin: numbers.origin.clone() })
}
