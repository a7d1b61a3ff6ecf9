//! The first tool with which a program cuts in each zero offset. Nothing states the tool of a touch more often than it does: a machinist touches the
//! workpiece with the tool that is in the spindle.

use std::collections::BTreeMap;

use crate::machine::Machine;
use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine;
use ncfix_machine::snc::Kind;
use ncfix_model::Model;

/// Length of a tool vector along the spindle, mm. A control that measures tools from the machine zero has negative lengths.
pub(crate) fn length_mm(machine: &machine::Machine, tool_mm: &Vector) -> f64 {
    tool_mm.norm().copysign(-machine.spindle.axis.dot(tool_mm))
}

/// First tools by the index of the zero offset.
pub(crate) struct FirstTools<'a> {
    machine: &'a machine::Machine,
    /// Zero offset and tool in force.
    now: Option<(u16, Vector)>,
    found: BTreeMap<u16, f64>,
}

impl<'a> FirstTools<'a> {
    /// Before the first element.
    pub(crate) fn new(machine: &'a machine::Machine) -> FirstTools<'a> {
        FirstTools { machine, now: None, found: BTreeMap::new() }
    }

    /// Takes the next element of the program.
    pub(crate) fn see(&mut self, kind: &Kind) {
        match kind {
            // Another head has another direction of the tool.
            Kind::Setup(setup) => {
                self.now = setup.zero.filter(|_| setup.head == 0 && !setup.assumed).map(|zero| (zero, setup.tool_mm));
            }
            Kind::Move(motion) if !motion.rapid && !motion.in_machine_frame => {
                if let Some((zero, tool_mm)) = self.now {
                    self.found.entry(zero).or_insert_with(|| length_mm(self.machine, &tool_mm));
                }
            }
            _ => {}
        }
    }

    /// True if each of these zero offsets has its tool.
    pub(crate) fn has_all(&self, zeros: &[u16]) -> bool {
        zeros.iter().all(|zero| self.found.contains_key(zero))
    }

    /// Lengths by the index of the zero offset, mm.
    pub(crate) fn lengths_mm(self) -> BTreeMap<u16, f64> {
        self.found
    }
}

/// Lengths of tools between which a touch is compared, mm.
const TRIED_MM: [f64; 3] = [0.0, 100.0, 300.0];
/// Differences below this are rounding noise, mm.
const NOISE_MM: f64 = 1e-6;

/// Indices of the zero offsets that are stated as touched, contain an error that depends on the length of the tool at the touch, and have no stated length.
/// `zeros` are the names and shifts of all zero offsets, by index.
pub(crate) fn asked<'a>(
    chosen: &Machine,
    model: &Model,
    zeros: impl Iterator<Item = (&'a String, AxisVector)>,
) -> Vec<u16> {
    let machine = &chosen.machine;
    let is_asked = |name: &str, shift: &AxisVector| {
        let datum = machine.datums.get(name).copied().unwrap_or_default();
        let is_touched = datum.setting.is_some_and(|setting| setting.is_relative());
        if !is_touched || datum.at.iter().all(|at| at.tool_length_mm.is_some()) {
            return false;
        }
        let [none_mm, short_mm, long_mm] = TRIED_MM.map(|length_mm| {
            let mut tried = datum;
            tried.at.iter_mut().for_each(|at| at.tool_length_mm = at.tool_length_mm.or(Some(length_mm)));
            model.displacement_at(&[0, 1, 2].map(|side| tried.pose(side, shift, machine)))
        });
        [short_mm, long_mm].iter().any(|mm| (mm - none_mm).amax() > NOISE_MM)
    };
    zeros.zip(0_u16..).filter(|((name, shift), _)| is_asked(name, shift)).map(|(_, index)| index).collect()
}
