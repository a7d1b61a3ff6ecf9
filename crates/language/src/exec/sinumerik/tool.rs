//! Tool and cutting edge.

use super::channel::Channel;
use super::gathered::Gathered;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::LINEAR_AXES;
use ncfix_base::source::Span;
use ncfix_machine::machine::ToolChange;
use ncfix_machine::snc::{Kind, Word, WordValue};

impl Channel<'_> {
    pub(super) fn tool(&mut self, gathered: &mut Gathered) -> Result<(), Fault> {
        let mut changed = None;
        if let Some((tool, span)) = gathered.tool.take() {
            if self.machine.control.tool_change == ToolChange::T {
                self.modal.active = Some(tool.clone());
                changed = Some(span);
            } else {
                self.modal.selected = Some(tool.clone());
            }
            self.push(Kind::Tool(tool));
        }
        if gathered.tool_change && self.machine.control.tool_change == ToolChange::M6 {
            if let Some(selected) = &self.modal.selected {
                self.modal.active = Some(selected.clone());
            }
            changed = Some(self.outlet.origin.span);
        }
        if changed.is_some() || gathered.tool_change {
            self.modal.edge = self.machine.control.edge_after_tool_change;
            self.modal.edge_stated = true;
            self.modal.forget_position();
        }
        if let Some((edge, span)) = gathered.edge {
            self.modal.edge = edge;
            self.modal.edge_stated = true;
            changed = Some(span);
            let value = WordValue::Number(f64::from(edge));
            gathered.before.insert(0, Word { letter: b'D', extension: None, value });
        }
        match changed {
            Some(span) => self.activate_edge(span),
            None => Ok(()),
        }
    }

    /// Puts the length of the active tool's edge in force, and says where it is not known.
    fn activate_edge(&mut self, span: Span) -> Result<(), Fault> {
        let is_off = self.modal.edge == 0 || self.modal.active == Some(WordValue::Number(0.0));
        let wear_mm = || self.active_wear_mm();
        let size = self.active_tool().map(|tool| (tool.length_mm, self.radius.of(tool.radius_mm, wear_mm())));
        (self.modal.length_mm, self.modal.radius_mm) = size.filter(|_| !is_off).unwrap_or_default();
        self.modal.tool_assumed = !is_off && size.is_none();
        self.refresh_setup();
        let tool_mm = self.setup.tool_mm;
        let lacking = LINEAR_AXES
            .into_iter()
            .take(3)
            .find(|&axis| tool_mm[axis.slot()] != 0.0 && self.machine.axis(axis).is_none());
        if let Some(axis) = lacking {
            let message = format!("the tool length lies along {axis}, which the machine lacks");
            return Err(fault(Code::NO_AXIS, span, message, "select another plane, or set control.tool_length_plane"));
        }
        if !self.modal.tool_assumed {
            return Ok(());
        }
        let (message, help) = match (&self.modal.active, &self.modal.selected) {
            (Some(active), _) => {
                let shown = match active {
                    WordValue::Number(number) => format!("T{number}"),
                    WordValue::Name(name) => format!("T=\"{}\"", String::from_utf8_lossy(name)),
                };
                let message = format!("{shown} D{} has no value in the machine file", self.modal.edge);
                (message, "add a [[tool]] entry there or in a file given with --setup")
            }
            (None, Some(_)) => (
                "a cutting edge is activated, but the selected tool was never changed to with M6".to_owned(),
                "program M6, or set control.tool_change = \"T\" where T changes the tool",
            ),
            (None, None) => (
                "a cutting edge is activated, and the program has not said which tool is in the spindle".to_owned(),
                "program T and M6 first",
            ),
        };
        if self.strict {
            return Err(fault(Code::NO_TOOL, span, message, help));
        }
        self.outlet.warnings.push(fault(Code::TOOL_ASSUMED, span, format!("{message}; length 0 is used"), help));
        Ok(())
    }
}
