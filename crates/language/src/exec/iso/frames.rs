//! Programmable mirror, scaling, rotation and tilted plane of Fanuc: the transformations between programmed and local coordinates.
//!
//! A point is mirrored first (G51.1), then scaled (G51), then rotated (G68), each about its own center (operator's manual, "programmable mirror
//! image": the order is mirror, scaling, rotation). Data commanded within a mirror or scaling are mirrored and scaled too: the center of a rotation,
//! and its direction if the plane is mirrored. A mirror must therefore not change within a scaling, nor either of them within a rotation.

use ncfix_base::geometry::{AXES, Axis, AxisSet, AxisVector, Frame, Matrix, Plane, Vector, about};

/// The active transformations.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Transforms {
    /// X, Y, Z of the mirrors.
    mirror: [Option<f64>; 3],
    scale: Option<Scale>,
    rotation: Option<Frame>,
    /// Number of rotations about lines in space; 0 for a rotation in the plane.
    in_space: u8,
    /// G68.2: the feature coordinate system.
    tilt: Option<Frame>,
    /// Alignment of the tool after G53.1.
    stand: Option<Box<Stand>>,
}

/// Alignment of the tool normal to a tilted plane.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stand {
    /// Frame from the plane to the coordinates below it.
    pub(super) frame: Frame,
    /// The zero offset and tool for which it is valid.
    pub(super) below: Frame,
    pub(super) tool_mm: Vector,
    /// `true` if the control tilts the plane in the output too.
    pub(super) is_kept: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Scale {
    center: Vector,
    factors: Vector,
}

/// Name of an active transformation in which a change is not allowed.
pub(super) type Within = &'static str;

impl Transforms {
    /// `true` if nothing is active.
    pub(super) fn is_empty(&self) -> bool {
        self.mirror == [None; 3] && self.scale.is_none() && self.rotation.is_none() && self.tilt.is_none()
    }

    /// The product: programmed to local coordinates; `None` if nothing is active.
    pub(super) fn frame(&self) -> Option<Frame> {
        if self.is_empty() {
            return None;
        }
        let stand = self.stand.as_ref().map(|stand| &stand.frame);
        let turned = stand.or(self.tilt.as_ref()).or(self.rotation.as_ref());
        Some(turned.map_or_else(|| self.inner(), |turned| turned.compose(&self.inner())))
    }

    /// `true` if a rotation is active.
    pub(super) fn is_turned(&self) -> bool {
        self.rotation.is_some()
    }

    /// `true` if a rotation about a line in space is active.
    pub(super) fn is_in_space(&self) -> bool {
        self.in_space > 0
    }

    /// `true` if a scaling is active.
    pub(super) fn is_scaled(&self) -> bool {
        self.scale.is_some()
    }

    /// `true` if a mirror is active.
    pub(super) fn is_mirrored(&self) -> bool {
        self.mirror != [None; 3]
    }

    /// The active tilted plane.
    pub(super) fn tilt(&self) -> Option<&Frame> {
        self.tilt.as_ref()
    }

    /// The alignment of the tool with it.
    pub(super) fn stand(&self) -> Option<&Stand> {
        self.stand.as_deref()
    }

    /// G53.1: aligns the tool normal to the tilted plane.
    pub(super) fn stand_on_tilt(&mut self, stand: Stand) {
        self.stand = Some(Box::new(stand));
    }

    /// The alignment of the tool, if the control tilts the plane in the output too.
    pub(super) fn kept_stand(&self) -> Option<&Stand> {
        self.stand.as_deref().filter(|stand| stand.is_kept)
    }

    /// Ends the alignment of the tool.
    pub(super) fn leave_stand(&mut self) {
        self.stand = None;
    }

    /// Scale factor of lengths along an axis, without sign.
    pub(super) fn growth(&self, axis: Axis) -> f64 {
        self.scale.and_then(|scale| scale.factors.get(axis.slot()).copied()).map_or(1.0, f64::abs)
    }

    /// Product of mirror and scaling.
    fn inner(&self) -> Frame {
        let mirror = self.mirroring();
        self.scale.as_ref().and_then(Scale::frame).map_or(mirror, |scale| scale.compose(&mirror))
    }

    fn mirroring(&self) -> Frame {
        let mirrored = |axis: &Axis| self.mirror.get(axis.slot()).is_some_and(Option::is_some);
        let axes: AxisSet = AXES.into_iter().take(3).filter(mirrored).collect();
        if axes.is_empty() {
            return Frame::identity();
        }
        let mut shift = AxisVector::ZERO;
        for axis in axes.iter() {
            shift[axis] = 2.0 * self.mirror.get(axis.slot()).copied().flatten().unwrap_or(0.0);
        }
        Frame::mirror(axes).with_offset(shift)
    }

    /// G51.1: mirrors about the given positions.
    pub(super) fn set_mirror(&mut self, words: [Option<f64>; 3]) -> Result<(), Within> {
        self.within(true)?;
        for (place, word) in self.mirror.iter_mut().zip(words) {
            *place = word.or(*place);
        }
        Ok(())
    }

    /// G50.1: ends the mirrors of the named axes, or all if none is named.
    pub(super) fn end_mirror(&mut self, named: [bool; 3]) -> Result<(), Within> {
        let all = named == [false; 3];
        let ends = |place: &Option<f64>, is_named: bool| place.is_some() && (all || is_named);
        if self.mirror.iter().zip(named).any(|(place, is_named)| ends(place, is_named)) {
            self.within(true)?;
        }
        for (place, is_named) in self.mirror.iter_mut().zip(named) {
            if all || is_named {
                *place = None;
            }
        }
        Ok(())
    }

    /// G51 about a center; missing coordinates are those of `here`. `Ok(false)` for an invalid factor.
    pub(super) fn set_scale(
        &mut self,
        center: [Option<f64>; 3],
        factors: [f64; 3],
        here: &AxisVector,
    ) -> Result<bool, Within> {
        self.within(false)?;
        let factors = Vector::from(factors);
        if Frame::scale(factors).is_none() {
            return Ok(false);
        }
        // The tool position is the center, independent of the previous scaling.
        let mirror = self.mirroring();
        let here = mirror.unapply(&self.inner().apply(here));
        let center = mirror.apply(&filled(center, &here)).xyz();
        self.scale = Some(Scale { center, factors });
        Ok(true)
    }

    /// G50
    pub(super) fn end_scale(&mut self) -> Result<(), Within> {
        if self.scale.is_some() {
            self.within(false)?;
        }
        self.scale = None;
        Ok(())
    }

    /// G68: rotates the plane about a center; missing coordinates are those of the tool position `here`.
    pub(super) fn set_rotation(
        &mut self,
        plane: Plane,
        center: [Option<f64>; 2],
        angle_rad: f64,
        here: &AxisVector,
    ) -> Result<(), Within> {
        let [abscissa, ordinate, across] = plane.axes();
        let mut words = [None; 3];
        for (axis, word) in [abscissa, ordinate].into_iter().zip(center) {
            if let Some(place) = words.get_mut(axis.slot()) {
                *place = word;
            }
        }
        if self.in_space > 0 {
            return Err("a rotation in space (G68 I J K)");
        }
        let inner = self.inner();
        let directions = [abscissa, ordinate].map(|axis| inner.linear()[(axis.slot(), axis.slot())]);
        let sense = directions.iter().product::<f64>().signum();
        self.set_turn(words, &unit(across), sense * angle_rad, here)
    }

    /// G68 with a direction: rotates about a line in space, a second time in the coordinates of the first rotation. `Ok(false)` for an invalid
    /// direction.
    pub(super) fn set_rotation_about(
        &mut self,
        center: [Option<f64>; 3],
        direction: [f64; 3],
        angle_rad: f64,
        here: &AxisVector,
    ) -> Result<bool, Within> {
        let Some(direction) = Vector::from(direction).try_normalize(1e-12) else { return Ok(false) };
        if self.scale.is_some() || self.mirror != [None; 3] {
            return Err("a scaling or mirror (G51, G51.1)");
        }
        let first = match (self.in_space, self.rotation) {
            (0, None) => Frame::identity(),
            (1, Some(first)) => first,
            _ => return Err("a rotation (G68)"),
        };
        // The current coordinates of `here` replace missing center coordinates.
        self.rotation = None;
        self.set_turn(center, &direction, angle_rad, here)?;
        self.rotation = self.rotation.map(|second| first.compose(&second));
        self.in_space += 1;
        Ok(true)
    }

    fn set_turn(
        &mut self,
        center: [Option<f64>; 3],
        direction: &Vector,
        angle_rad: f64,
        here: &AxisVector,
    ) -> Result<(), Within> {
        if self.tilt.is_some() {
            return Err("a tilted plane (G68.2)");
        }
        // The tool position is the center, independent of the previous rotation.
        let inner = self.inner();
        let before = self.rotation.as_ref().map_or(inner, |rotation| rotation.compose(&inner));
        let here = inner.unapply(&before.apply(here));
        let center = inner.apply(&filled(center, &here)).xyz();
        self.rotation = Some(turned_about(&center, about(direction, angle_rad)));
        Ok(())
    }

    /// `true` if a rotation in space changes the direction of a vector.
    pub(super) fn turns(&self, vector: &Vector) -> bool {
        let turned = self.rotation.filter(|_| self.in_space > 0).map(|rotation| rotation.linear() * vector);
        turned.is_some_and(|turned| (turned - vector).norm() > 1e-9)
    }

    /// G69
    pub(super) fn end_rotation(&mut self) {
        self.in_space = 0;
        self.rotation = None;
        self.tilt = None;
        self.stand = None;
    }

    /// G68.2: a plane in local coordinates.
    pub(super) fn set_tilt(&mut self, origin: Vector, rotation: Matrix) -> Result<(), Within> {
        if self.rotation.is_some() || self.scale.is_some() || self.mirror != [None; 3] {
            return Err("a rotation, scaling or mirror (G68, G51, G51.1)");
        }
        let mut shift = AxisVector::ZERO;
        shift.set_xyz(origin);
        self.tilt = Some(Frame::rotation(rotation).with_offset(shift));
        self.stand = None;
        Ok(())
    }

    fn within(&self, is_mirror: bool) -> Result<(), Within> {
        match self {
            Transforms { tilt: Some(_), .. } => Err("a tilted plane (G68.2)"),
            Transforms { rotation: Some(_), .. } => Err("a rotation (G68)"),
            Transforms { scale: Some(_), .. } if is_mirror => Err("a scaling (G51)"),
            _ => Ok(()),
        }
    }
}

impl Scale {
    fn frame(&self) -> Option<Frame> {
        let scale = Frame::scale(self.factors)?;
        let mut shift = AxisVector::ZERO;
        shift.set_xyz(self.center - self.center.component_mul(&self.factors));
        Some(scale.with_offset(shift))
    }
}

fn turned_about(center: &Vector, rotation: Matrix) -> Frame {
    let mut shift = AxisVector::ZERO;
    shift.set_xyz(center - rotation * center);
    Frame::rotation(rotation).with_offset(shift)
}

fn unit(axis: Axis) -> Vector {
    Vector::ith(axis.dimension(), 1.0)
}

/// The words, with missing ones from a position.
fn filled(words: [Option<f64>; 3], here: &AxisVector) -> AxisVector {
    let mut out = *here;
    for (axis, word) in AXES.into_iter().zip(words) {
        out[axis] = word.unwrap_or(here[axis]);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, z: f64) -> AxisVector {
        AxisVector([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    #[track_caller]
    fn check(transforms: &Transforms, from: AxisVector, to: AxisVector) {
        let found = transforms.frame().unwrap_or_else(Frame::identity).apply(&from);
        assert!((found.xyz() - to.xyz()).norm() < 1e-12, "{:?} {:?}", found.xyz(), to.xyz());
    }

    fn some<const N: usize>(values: [f64; N]) -> [Option<f64>; N] {
        values.map(Some)
    }

    #[test]
    fn each_operation_is_about_its_center() {
        let mut transforms = Transforms::default();
        transforms.set_mirror([Some(50.0), None, None]).unwrap();
        check(&transforms, at(20.0, 3.0, 4.0), at(80.0, 3.0, 4.0));
        transforms.end_mirror([true, false, false]).unwrap();
        assert!(transforms.is_empty());
        assert!(transforms.set_scale([Some(1.0), None, None], [2.0, 2.0, 0.5], &at(9.0, 3.0, 4.0)).unwrap());
        check(&transforms, at(2.0, 3.0, 6.0), at(3.0, 3.0, 5.0));
        transforms.end_scale().unwrap();
        let quarter = std::f64::consts::FRAC_PI_2;
        transforms.set_rotation(Plane::XY, some([10.0, 0.0]), quarter, &AxisVector::ZERO).unwrap();
        check(&transforms, at(12.0, 1.0, 5.0), at(9.0, 2.0, 5.0));
        transforms.end_rotation();
        // G18: Z is the abscissa, counter-clockwise from Z to X.
        transforms.set_rotation(Plane::ZX, some([0.0, 0.0]), quarter, &AxisVector::ZERO).unwrap();
        check(&transforms, at(0.0, 7.0, 10.0), at(10.0, 7.0, 0.0));
    }

    #[test]
    fn a_rotation_within_mirror_and_scaling_is_mirrored_and_scaled_with_them() {
        // The outer transformation acts on everything programmed within: outer(turned(p)).
        let (center, angle) = ([3.0, -2.0], 0.7);
        let mut alone = Transforms::default();
        alone.set_rotation(Plane::XY, some(center), angle, &AxisVector::ZERO).unwrap();
        let mut outer = Transforms::default();
        outer.set_mirror([Some(10.0), None, None]).unwrap();
        outer.set_scale(some([1.0, 2.0, 3.0]), [3.0; 3], &AxisVector::ZERO).unwrap();
        let mut both = outer.clone();
        both.set_rotation(Plane::XY, some(center), angle, &AxisVector::ZERO).unwrap();
        for point in [at(0.0, 0.0, 0.0), at(5.0, 7.0, -1.0)] {
            check(&both, point, outer.frame().unwrap().apply(&alone.frame().unwrap().apply(&point)));
        }
    }

    #[test]
    fn a_missing_center_is_where_the_tool_is() {
        let mut transforms = Transforms::default();
        let here = at(4.0, 5.0, 6.0);
        transforms.set_rotation(Plane::XY, [None, None], 0.5, &here).unwrap();
        check(&transforms, here, here);
        let place = transforms.frame().unwrap().apply(&at(1.0, 1.0, 6.0));
        // A second rotation replaces the first; the tool at that place is its center.
        transforms.set_rotation(Plane::XY, [None, None], 1.5, &at(1.0, 1.0, 6.0)).unwrap();
        check(&transforms, place, place);
    }

    #[test]
    fn what_is_outer_does_not_change_within() {
        let mut transforms = Transforms::default();
        transforms.set_scale(some([0.0; 3]), [2.0; 3], &AxisVector::ZERO).unwrap();
        assert!(transforms.set_mirror([Some(0.0), None, None]).is_err());
        assert!(transforms.end_mirror([false; 3]).is_ok(), "there is nothing to end");
        transforms.set_rotation(Plane::XY, some([0.0; 2]), 1.0, &AxisVector::ZERO).unwrap();
        assert!(transforms.end_scale().is_err());
        assert!(transforms.set_tilt(Vector::zeros(), Matrix::identity()).is_err());
        transforms.end_rotation();
        transforms.end_scale().unwrap();
        assert!(transforms.is_empty());
        assert_eq!(transforms.set_scale(some([0.0; 3]), [1.0, 0.0, 1.0], &AxisVector::ZERO), Ok(false));
    }
}
