//! Tool and cutting edge.

use super::channel::Channel;
use super::gathered::Gathered;
use super::setup;
use crate::exec::core::fault::{Fault, fault};
use crate::exec::core::tool::{ToolSize, without_value};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::LINEAR_AXES;
use ncfix_base::source::Span;
use ncfix_machine::machine::ToolChange;
use ncfix_machine::snc::{Kind, Word, WordValue};

pub(super) fn tool(channel: &mut Channel<'_>, gathered: &mut Gathered) -> Result<(), Fault> {
    let mut changed = None;
    if let Some((tool, span)) = gathered.tool.take() {
        if channel.settings.machine.control.tool_change == ToolChange::T {
            channel.modal.tool.active = Some(tool.clone());
            changed = Some(span);
        } else {
            channel.modal.tool.selected = Some(tool.clone());
        }
        channel.push(Kind::Tool(tool));
    }
    if gathered.tool_change && channel.settings.machine.control.tool_change == ToolChange::M6 {
        channel.modal.tool.change();
        changed = Some(channel.outlet.origin.span);
    }
    if changed.is_some() || gathered.tool_change {
        channel.modal.edge = channel.settings.machine.control.edge_after_tool_change;
        channel.modal.edge_stated = true;
        if channel.settings.machine.control.tool_change_moves() {
            channel.modal.forget_by_change();
        }
    }
    if let Some((edge, span)) = gathered.edge {
        channel.modal.edge = edge;
        channel.modal.edge_stated = true;
        changed = Some(span);
        let value = WordValue::Number(f64::from(edge));
        gathered.before.insert(0, Word { letter: b'D', extension: None, value });
    }
    match changed {
        Some(span) => activate_edge(channel, span),
        None => Ok(()),
    }
}

/// Activates the length of the active tool's edge, and reports an unknown one.
fn activate_edge(channel: &mut Channel<'_>, span: Span) -> Result<(), Fault> {
    let is_off = channel.modal.edge == 0 || channel.modal.tool.active == Some(WordValue::Number(0.0));
    let of_edge = |size: ToolSize| (size.length_mm, size.compensated_mm(channel.settings.radius));
    let size = channel.modal.size_in(&channel.system.tools, channel.settings.machine).map(of_edge);
    channel.modal.tool.put_size(if is_off { Some(Default::default()) } else { size });
    setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
    let tool_mm = channel.standing.setup.tool_mm;
    let lacking = LINEAR_AXES
        .into_iter()
        .take(3)
        .find(|&axis| tool_mm[axis.slot()] != 0.0 && channel.settings.machine.axis(axis).is_none());
    if let Some(axis) = lacking {
        let message = format!("the tool length acts along {axis}, which the machine does not have");
        return Err(fault(Code::NO_AXIS, span, message, "select another plane, or set control.tool_length_plane"));
    }
    channel.modal.unknown_edge = None;
    if !channel.modal.tool.assumed {
        return Ok(());
    }
    if channel.settings.requires_values && channel.modal.tool.active.is_none() {
        // T and M6 may follow; until then only motions that the length does not change are possible.
        channel.modal.unknown_edge = Some(span);
        return Ok(());
    }
    let (message, help) = match (&channel.modal.tool.active, &channel.modal.tool.selected) {
        (Some(active), _) => {
            let shown = match active {
                WordValue::Number(number) => format!("T{number}"),
                WordValue::Name(name) => format!("T=\"{}\"", String::from_utf8_lossy(name)),
            };
            let message = format!("{shown} D{} has no value in the machine file", channel.modal.edge);
            let help = match active {
                WordValue::Number(_) => "add a [[tool]] entry there or in a file given with --setup",
                WordValue::Name(_) => {
                    "add a [[tool]] entry there with this text as its name, and a number; or give the saved tool data with --setup"
                }
            };
            (message, help)
        }
        (None, Some(_)) => (
            "a cutting edge is activated, but the selected tool was never loaded with M6".to_owned(),
            "program M6, or set control.tool_change = \"T\" if T changes the tool",
        ),
        (None, None) => (
            "a cutting edge is activated, but the tool in the spindle is not known".to_owned(),
            "program T and M6 first",
        ),
    };
    without_value(channel.settings.requires_values, &mut channel.outlet.warnings, span, &message, "length 0", help)
}
