//! The number of tables that each single error of a machine needs (Esmaeili 2021, ch. 9.2), with the sizes of Table 6-2.

use super::made::{Filling, MadeTables, make};
use super::request::TablesRequest;
use super::result::{SingleErrorRow, TablesResult};
use crate::tables::Orientation;
use ncfix_base::diagnostic::Diagnostic;
use ncfix_base::geometry::Axis;
use ncfix_base::number::significant;
use ncfix_base::units::um_from_mm;
use ncfix_model::name::{DIRECTIONS, ErrorName};
use ncfix_model::parameter::ParameterName;
use ncfix_model::{ErrorModel, preset};

/// Sizes of errors without one in the machine file: an offset, mm; an angle, rad; a scale.
const SIZES: [f64; 3] = [0.010, 400e-6, 40e-6];

/// Makes the tables of each location error, and of the scale of each linear axis, as if it were the only error of the machine.
#[must_use]
pub fn single_errors(request: &TablesRequest<'_>, filling: &Filling<'_>) -> Vec<SingleErrorRow> {
    let machine = request.machine;
    let linear = machine.axes.iter().flatten().map(|data| data.axis).filter(|axis| !axis.is_rotary());
    let scales = linear.filter_map(scale);
    preset::location_errors(machine).into_iter().chain(scales).map(|name| single(&name, request, filling)).collect()
}

/// The scale of a linear axis.
fn scale(axis: Axis) -> Option<ParameterName> {
    let direction = DIRECTIONS.into_iter().nth(axis.dimension())?;
    Some(ParameterName::coefficient(ErrorName::motion(direction, axis), 1))
}

fn single(name: &ParameterName, request: &TablesRequest<'_>, filling: &Filling<'_>) -> SingleErrorRow {
    let is_scale = name.degree() == 1;
    let is_angle = name.component.direction.is_rotation();
    let [offset, angle, scale] = SIZES;
    let assumed = if is_scale {
        scale
    } else if is_angle {
        angle
    } else {
        offset
    };
    let own = name.get(request.errors);
    let value = if own == 0.0 { assumed } else { own };
    let mut errors = ErrorModel::default();
    name.set(&mut errors, value);
    let made = fewest(&TablesRequest { errors: &errors, ..request.clone() }, filling);
    let unit = if is_scale {
        "µm/m"
    } else if is_angle {
        "µrad"
    } else {
        "µm"
    };
    let shown = if is_scale || is_angle { value * 1e6 } else { um_from_mm(value) };
    let mut row = SingleErrorRow {
        error: name.to_string(),
        size: format!("{} {unit}", significant(shown)),
        ..SingleErrorRow::default()
    };
    match made {
        Ok(made) => {
            row.tables = Some(made.tables.count());
            made.scheme.clone_into(&mut row.scheme);
            row.before_rms_um = Some(made.checked.before.rms_um);
            row.rms_um = Some(made.checked.tables.rms_um);
            row.tilt_rms_urad = Some(made.checked.tables.tilt_rms_urad);
        }
        Err(why) => row.reason = Some(why.message.clone()),
    }
    row
}

/// The fewest tables within the tolerance, which is one of the tip: unless the orientation is stated, also without corrections by the rotary axes, which
/// other tables would have to follow.
fn fewest(request: &TablesRequest<'_>, filling: &Filling<'_>) -> Result<MadeTables, Box<Diagnostic>> {
    let filling = Filling { tries_fewer: false, most: None, is_fewest: true, ..*filling };
    let made = |request: &TablesRequest<'_>| make(request, &filling, &mut TablesResult::default());
    let has_rotary = request.machine.axes.iter().flatten().any(|data| data.axis.is_rotary());
    let own = made(request);
    if request.orientation.is_some() || !has_rotary {
        return own;
    }
    let size = |made: &MadeTables| (made.tables.count(), made.tables.entries());
    match (own, made(&TablesRequest { orientation: Some(Orientation::Off), ..request.clone() })) {
        (Ok(own), Ok(off)) if size(&own) <= size(&off) => Ok(own),
        (_, Ok(off)) => Ok(off),
        (own, Err(_)) => own,
    }
}
