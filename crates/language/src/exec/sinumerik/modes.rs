//! Modal codes: plane, units, dimensions.

use super::channel::Channel;
use super::gathered::Gathered;
use super::modal::unit_behind;
use super::setup;
use crate::exec::core::fault::{Fault, fault};
use ncfix_base::diagnostic::Code;
use ncfix_base::geometry::Plane;

pub(super) fn modal_codes(channel: &mut Channel<'_>, gathered: &Gathered) -> Result<(), Fault> {
    if let Some((inch, with_feed)) = gathered.inch {
        if let Some(first) = channel.unitless.filter(|_| inch && !channel.unit_stated) {
            return Err(fault(
                Code::UNITS_DOUBT,
                channel.outlet.origin.span,
                format!("the program switches to inch here, but lengths or feeds from line {first} on have no unit"),
                "state the unit (G71 or G710, G70 or G700) in the first block",
            ));
        }
        channel.unit_stated = true;
        channel.modal.modes.inch = inch;
        channel.modal.inch_feed = inch && with_feed;
        channel.modal.technological = with_feed;
    }
    let has_length =
        gathered.named.iter().any(|axis| !axis.is_rotary()) || gathered.feed.is_some() && gathered.dwell.is_none();
    if !channel.unit_stated && channel.unitless.is_none() && has_length {
        channel.unitless = Some(channel.outlet.origin.line);
    }
    if let Some((kind, _)) = gathered.motion {
        channel.modal.modes.motion = kind;
    }
    for &(is_end, end) in &gathered.curve.ends {
        channel.modal.spline_ends[usize::from(is_end)] = end;
    }
    let unit = gathered
        .feed_mode
        .map_or(channel.modal.modes.feed_unit, |word| unit_behind(channel.modal.modes.feed_unit, word));
    channel.modal.modes.select_feed_unit(unit);
    if let Some(incremental) = gathered.incremental {
        channel.modal.modes.incremental = incremental;
    }
    if let Some(plane) = gathered.plane.and_then(Plane::from_number)
        && plane != channel.modal.modes.plane
    {
        channel.modal.modes.plane = plane;
        let stated = channel.modal.position.known.union(channel.modal.moved_by_plane);
        setup::refresh_setup(&mut channel.modal, &mut channel.standing, &mut channel.outlet);
        channel.modal.moved_by_plane = stated.difference(channel.modal.position.known);
    }
    Ok(())
}
