//! Functions of custom kinds: the content of [`EntryFunction::Own`](super::EntryFunction::Own).

use std::any::Any;
use std::fmt::Debug;

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;

/// Assumed number of bends over the travel of a function without its own [`MotionFunction::sampling`].
const BENDS: f64 = 8.0;

/// Function that gives one error component of an axis: of a kind ([`MotionKind`](super::MotionKind)) that is not built in, or made by an effect of a custom
/// source. It must implement `Clone` and `PartialEq`.
pub trait MotionFunction: BoxedFunction + Debug + Send + Sync {
    /// Returns the name of its kind, for tables.
    fn kind(&self) -> &'static str;

    /// Returns the value as deviation of the body that `axis` moves: mm, or rad in an angular component. `command` contains the positions of all axes, mm and
    /// rad, within one turn for a modulo axis; `state` the directions of their last motion. The value must be finite and depend only on the arguments. The
    /// function is called for every point of a path and must not allocate.
    fn value(&self, axis: Axis, command: &AxisVector, state: &State) -> f64;

    /// Visits every number to which the value is jointly proportional: doubling all of them doubles the value, and setting all to zero makes it zero. There
    /// is at least one. The name of a number is its key in the file without the unit, `depth` for `depth_um` and `depth_urad`. For coefficients, in mm and
    /// rad, it is the key itself, `coefficients[2]`.
    fn visit_values(&mut self, visit: &mut dyn FnMut(&str, &mut f64));

    /// Returns the other axis on whose position it depends, if any.
    fn with(&self) -> Option<Axis> {
        None
    }

    /// Returns the required sampling along `axis`, its own or that of [`Self::with`], whose travel is this long, mm or rad.
    fn sampling(&self, _axis: Axis, travel: f64) -> Sampling {
        Sampling { length: travel / BENDS, ..Sampling::default() }
    }
}

/// Copies and compares a function. It is implemented for every [`MotionFunction`] that is `Clone` and `PartialEq`.
pub trait BoxedFunction: Any {
    /// Returns a boxed copy.
    fn boxed(&self) -> Box<dyn MotionFunction>;

    /// True if the other function has the same type and is equal.
    fn equals(&self, other: &dyn MotionFunction) -> bool;
}

impl<F: MotionFunction + Clone + PartialEq + 'static> BoxedFunction for F {
    fn boxed(&self) -> Box<dyn MotionFunction> {
        Box::new(self.clone())
    }

    fn equals(&self, other: &dyn MotionFunction) -> bool {
        let other: &dyn Any = other;
        other.downcast_ref::<F>() == Some(self)
    }
}

/// Required sampling of a function along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// Length over which it may be taken as smooth, mm or rad: half a wavelength. Infinite if it is straight.
    pub length: f64,
    /// Commands, mm or rad and increasing, at which its slope jumps.
    pub knots: Vec<f64>,
    /// True if it depends on the direction of the last motion of the axis.
    pub has_senses: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Sampling { length: f64::INFINITY, knots: Vec::new(), has_senses: false }
    }
}

/// Custom function. Two are equal if their kinds are, and the functions themselves.
#[derive(Debug)]
pub struct Own(Box<dyn MotionFunction>);

impl Own {
    /// Returns the function.
    #[must_use]
    pub fn function(&self) -> &dyn MotionFunction {
        &*self.0
    }

    /// Returns the function for modification.
    pub fn function_mut(&mut self) -> &mut dyn MotionFunction {
        &mut *self.0
    }

    /// True if all of its values are zero.
    pub(super) fn is_zero(&self) -> bool {
        let mut is_zero = true;
        self.0.boxed().visit_values(&mut |_, value| is_zero &= *value == 0.0);
        is_zero
    }
}

impl<F: MotionFunction + 'static> From<F> for Own {
    fn from(function: F) -> Own {
        Own(Box::new(function))
    }
}

impl Clone for Own {
    fn clone(&self) -> Self {
        Own(self.0.boxed())
    }
}

impl PartialEq for Own {
    fn eq(&self, other: &Self) -> bool {
        self.0.kind() == other.0.kind() && self.0.equals(&*other.0)
    }
}
