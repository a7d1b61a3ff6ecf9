//! Statements about zero offsets on the command line: `--zero G54=touched@X325+,Y200,Z215,R5,L100`.

use std::str::FromStr;

use crate::error::Error;
use crate::machine::Machine;
use ncfix_base::geometry::{AXIS_COUNT, Axis, AxisSet, AxisVector};
use ncfix_base::units::shown_position;
use ncfix_machine::machine::zero_offset::common_name;
use ncfix_machine::machine::{self, AxisData, TouchedAt, ZeroSetting};

/// Axes whose sides are touched.
const SIDES: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

/// Place of a touch as it was stated.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct StatedTouch {
    /// Axes whose position is stated.
    stated: AxisSet,
    /// Their positions in machine coordinates, mm and rad.
    command: AxisVector,
    /// Direction of the last motion of each axis: −1, 0 (not stated) or 1.
    direction: [i8; AXIS_COUNT],
    /// Length of the tool or probe, mm.
    tool_length_mm: Option<f64>,
    /// Radius of the tool or probe, mm.
    radius_mm: Option<f64>,
}

impl StatedTouch {
    /// Reads `X325+,Y200,L100,R5`; `None` for other words.
    fn read(text: &str) -> Option<StatedTouch> {
        let mut out = StatedTouch::default();
        for word in text.split(',').map(str::trim) {
            let letter = word.chars().next()?.to_ascii_uppercase();
            let rest = word.get(1..)?.trim();
            let number = |text: &str| text.parse::<f64>().ok().filter(|value| value.is_finite());
            match letter {
                'L' => out.tool_length_mm = Some(number(rest)?),
                'R' => out.radius_mm = Some(number(rest).filter(|radius_mm| *radius_mm >= 0.0)?),
                _ => {
                    let axis = Axis::from_letter(u8::try_from(letter).ok()?)?;
                    let (place, direction) = match rest.strip_suffix('+') {
                        Some(place) => (place, 1),
                        None => rest.strip_suffix('-').map_or((rest, 0), |place| (place, -1)),
                    };
                    out.direction[axis.slot()] = direction;
                    if place.is_empty() && direction != 0 {
                        continue;
                    }
                    let command = format!("{letter}{place}").parse::<AxisVector>().ok()?;
                    out.command[axis] = command[axis];
                    out.stated.insert(axis);
                }
            }
        }
        Some(out)
    }

    /// True if it states more than a length.
    fn has_place(&self) -> bool {
        !self.stated.is_empty() || self.radius_mm.is_some() || self.direction.iter().any(|sign| *sign != 0)
    }

    /// Lays this place over another one.
    fn lay_over(&self, at: &mut TouchedAt) {
        for axis in self.stated.iter() {
            at.command[axis] = self.command[axis];
            at.stated.insert(axis);
        }
        for (own, sign) in at.direction.iter_mut().zip(self.direction) {
            if sign != 0 {
                *own = sign;
            }
        }
        at.tool_length_mm = self.tool_length_mm.or(at.tool_length_mm);
    }
}

/// A statement about a zero offset on the command line: `G54=touched@X330,Y240,Z120`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StatedZero {
    /// Name of the zero offset.
    name: String,
    setting: ZeroSetting,
    /// Place of all touches.
    common: Option<StatedTouch>,
    /// Places of the touches along X, Y and Z.
    sides: [Option<StatedTouch>; 3],
    /// As written.
    text: String,
}

impl StatedZero {
    /// The statement as it was written.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// The radius for a side, mm.
    fn radius_mm(&self, side: usize) -> Option<f64> {
        let of = |touch: &Option<StatedTouch>| touch.and_then(|touch| touch.radius_mm);
        self.sides.get(side).and_then(of).or(of(&self.common))
    }
}

impl FromStr for StatedZero {
    type Err = String;

    /// Reads `G54=touched`, `G54=absolute`, `G54=probed@X330,Y240,Z120,L100` or `G54=touched@X:X325+,Y200,Z215,L100@Z:X360,Y260,Z270,L150`: with the length of
    /// the tool after L, its radius after R, and the direction of the last motion of an axis as the sign after its position.
    fn from_str(text: &str) -> Result<StatedZero, String> {
        let wrong = || {
            format!(
                "'{text}' states no zero: the methods are touched, probed and absolute; write for example G54=touched or G54=touched@X330,Y240,Z120,L100, with the side X:, Y: or Z: before the place of one touch"
            )
        };
        let no_method = || match ZeroSetting::of_name(text.trim()) {
            Some(setting) => format!("'{text}' names no zero offset; write for example G54={}", setting.name()),
            None => format!(
                "'{text}' does not state how the zero was set; write for example {text}=touched or {text}=absolute"
            ),
        };
        let (name, rest) = text.split_once('=').ok_or_else(no_method)?;
        let mut places = rest.split('@');
        let setting = ZeroSetting::of_name(places.next().unwrap_or_default().trim()).ok_or_else(wrong)?;
        let name = common_name(&name.trim().to_ascii_uppercase());
        let mut out = StatedZero { name, setting, common: None, sides: [None; 3], text: text.to_owned() };
        for place in places {
            let (side, words) = match place.split_once(':') {
                Some((side, words)) => {
                    let of = |axis: &Axis| axis.to_string().eq_ignore_ascii_case(side.trim());
                    (Some(SIDES.iter().position(of).ok_or_else(wrong)?), words)
                }
                None => (None, place),
            };
            if words.split(',').any(|word| word.trim_start().to_ascii_uppercase().starts_with("L-")) {
                return Err(format!(
                    "'{text}' states a negative length L: it is the distance from the spindle nose to the tip of the tool or probe"
                ));
            }
            let touch = StatedTouch::read(words).ok_or_else(wrong)?;
            let slot = side.map_or(Some(&mut out.common), |side| out.sides.get_mut(side)).ok_or_else(wrong)?;
            if slot.replace(touch).is_some() {
                return Err(wrong());
            }
        }
        // A radius of all touches needs a side somewhere: Z is touched from above.
        let has_side = |touch: &StatedTouch| touch.direction.iter().any(|sign| *sign != 0);
        let has_any = out.common.iter().chain(out.sides.iter().flatten()).any(has_side);
        let own = out.sides.iter().flatten().map(|touch| (touch, out.common.iter().chain([touch]).any(has_side)));
        let mut radii = out.common.iter().map(|touch| (touch, has_any)).chain(own);
        if radii.any(|(touch, has_side)| touch.radius_mm.is_some() && !has_side) {
            return Err(format!(
                "'{text}' gives the radius R without the side: write the direction of the motion, such as X+ or Y-"
            ));
        }
        Ok(out)
    }
}

/// Notes statements about zero offsets in the machine; they override its file.
///
/// # Errors
/// If a zero offset has no value there, or if a touch is outside the travel.
pub(crate) fn state(zeros: &[StatedZero], chosen: &mut Machine) -> Result<(), Error> {
    for zero in zeros {
        let name = &zero.name;
        let Some(shift) = chosen.machine.zero_offsets.get(name).map(|parts| parts.shift()) else {
            let shown = chosen.machine.shown_offset(name);
            return Err(Error::usage(format!("--zero {shown}: this zero offset has no value in the machine file")));
        };
        if !chosen.stated_zeros.contains(name) {
            chosen.stated_zeros.push(name.clone());
        }
        let mut datum = chosen.machine.datums.get(name).copied().unwrap_or_default();
        datum.setting = Some(zero.setting);
        datum.is_of_other_value = false;
        for (side, axis) in SIDES.into_iter().enumerate() {
            let touches = || [zero.common, zero.sides[side]].into_iter().flatten();
            let at = &mut datum.at[side];
            // A place replaces that of the file.
            if touches().any(|touch| touch.has_place()) {
                *at = TouchedAt { tool_length_mm: at.tool_length_mm, ..TouchedAt::default() };
            }
            touches().for_each(|touch| touch.lay_over(at));
            let sign = f64::from(at.direction[axis.slot()]);
            // The tip touches along the spindle, the radius across it.
            let is_across = chosen.machine.spindle.axis[side].abs() < 0.5;
            let has_both = |touch: StatedTouch| {
                touch.radius_mm.is_some() && touch.stated.contains(axis) && touch.direction[axis.slot()] != 0
            };
            if is_across && touches().any(has_both) {
                return Err(Error::usage(format!(
                    "--zero {} gives the radius R and a position of {axis}: give one of them, because R takes the place of the position",
                    zero.text()
                )));
            }
            if let Some(radius_mm) = zero.radius_mm(side).filter(|_| is_across && sign != 0.0)
                && !at.stated.contains(axis)
            {
                at.command[axis] = shift[axis] - sign * radius_mm;
                at.stated.insert(axis);
            }
            check(name, axis, at, &chosen.machine)?;
        }
        chosen.machine.datums.insert(name.clone(), datum);
    }
    Ok(())
}

/// Checks that the axes can stand at a touch.
///
/// # Errors
/// If the machine lacks an axis, or if a position is outside the travel.
fn check(name: &str, side: Axis, at: &TouchedAt, machine: &machine::Machine) -> Result<(), Error> {
    for axis in at.stated.iter() {
        let value = at.command[axis];
        let Some(data) = machine.axis(axis) else {
            return Err(Error::usage(format!("--zero {name}: the machine has no axis {axis}")));
        };
        if let Some([low, high]) = outside(data, value) {
            let [value, low, high] = [value, low, high].map(|one| shown_position(axis.is_rotary(), one));
            let unit = if axis.is_rotary() { "deg" } else { "mm" };
            return Err(Error::usage(format!(
                "--zero {name}: {axis} cannot stand at {value} {unit} when it touches the side {side}, because its travel is {low} to {high} {unit}; give the position of the axis in machine coordinates"
            )));
        }
    }
    Ok(())
}

/// The travel of an axis that does not reach a position.
fn outside(data: &AxisData, value: f64) -> Option<[f64; 2]> {
    /// Rounding of a display, mm or rad.
    const ROOM: f64 = 1e-3;
    data.travel.filter(|[low, high]| !(low - ROOM..=high + ROOM).contains(&value))
}

/// Refuses stated zeros where they have no effect.
///
/// # Errors
/// If there is one.
pub(crate) fn refuse(zeros: &[StatedZero], why: &str) -> Result<(), Error> {
    let Some(zero) = zeros.first() else { return Ok(()) };
    Err(Error::usage(format!("--zero {} has no effect on this command: {why}; omit it", zero.text())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_side_has_a_place_of_its_own() {
        let zero: StatedZero = "G54=touched@Y200,L100,R5@X:X325+@Y:Y-@Z:Z270,L150".parse().unwrap();
        let [x, y, z] = zero.sides.map(Option::unwrap);
        assert_eq!((x.command[Axis::X], x.direction[Axis::X.slot()]), (325.0, 1));
        assert!(y.stated.is_empty() && y.direction[Axis::Y.slot()] == -1);
        assert_eq!((z.tool_length_mm, z.command[Axis::Z]), (Some(150.0), 270.0));
        assert_eq!(zero.common.unwrap().radius_mm, Some(5.0));
        for wrong in [
            "G54=touched@R5",
            "G54=touched@",
            "G54=touched@Q:X1",
            "G54=touched@X1@X2",
            "G54=touched@X1,L-150",
            "G54=touched@X:Xa",
        ] {
            assert!(wrong.parse::<StatedZero>().is_err(), "{wrong}");
        }
    }
}
