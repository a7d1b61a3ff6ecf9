//! Functions of kinds that a caller brings: what [`Function::Own`](super::Function::Own) holds.

use std::fmt::Debug;

use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_machine::machine::State;

/// How many times a function without [`MotionFunction::sampling`] of its own may bend over the travel.
const BENDS: f64 = 8.0;

/// A function that gives one component of the errors of an axis: of a kind ([`MotionKind`](super::MotionKind)) that is not built in, or made by the effect of a
/// source of one's own. It is `Clone`, and shows all of itself by `Debug`.
pub trait MotionFunction: BoxedFunction + Debug + Send + Sync {
    /// The name of its kind, for tables.
    fn kind(&self) -> &'static str;

    /// The value: mm, or rad in a component that is an angle, as deviation of the body that `axis` moves. `command` holds the positions of all axes,
    /// mm and rad, within one turn for an axis without end; `state` the sense of their last motion. It must be finite and pure, and it is called for
    /// every point of a path: without allocation.
    fn value(&self, axis: Axis, command: &AxisVector, state: &State) -> f64;

    /// Shows every number that the value is proportional to, all of them together: twice of each is twice the value, and zero of each is zero. There is
    /// at least one. It is called by its key in the file without the unit, `depth` for `depth_um` and `depth_urad`; coefficients, in mm and rad, by the key
    /// itself, `coefficients[2]`.
    fn visit_values(&mut self, visit: &mut dyn FnMut(&str, &mut f64));

    /// Another axis than its own whose position it depends on.
    fn with(&self) -> Option<Axis> {
        None
    }

    /// How finely a path must be cut along `axis`, its own or that of [`Self::with`], whose travel is this long, mm or rad.
    fn sampling(&self, _axis: Axis, travel: f64) -> Sampling {
        Sampling { length: travel / BENDS, ..Sampling::default() }
    }
}

/// Copies a function: what is a [`MotionFunction`] and `Clone` does it by itself.
pub trait BoxedFunction {
    /// A copy.
    fn boxed(&self) -> Box<dyn MotionFunction>;
}

impl<F: MotionFunction + Clone + 'static> BoxedFunction for F {
    fn boxed(&self) -> Box<dyn MotionFunction> {
        Box::new(self.clone())
    }
}

/// How finely the function must be sampled along an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Sampling {
    /// The length, mm or rad, over which it may be taken as smooth: half of that of a wave. Infinite where it is straight.
    pub length: f64,
    /// Commands, mm or rad and increasing, at which its slope jumps.
    pub knots: Vec<f64>,
    /// Whether it depends on the sense of the last motion of the axis.
    pub has_senses: bool,
}

impl Default for Sampling {
    fn default() -> Self {
        Sampling { length: f64::INFINITY, knots: Vec::new(), has_senses: false }
    }
}

/// A function that a caller brought. Two are equal where their kind and all that they show of themselves are.
#[derive(Debug)]
pub struct Own(Box<dyn MotionFunction>);

impl Own {
    /// The function.
    #[must_use]
    pub fn function(&self) -> &dyn MotionFunction {
        &*self.0
    }

    /// The function, to be changed.
    pub fn function_mut(&mut self) -> &mut dyn MotionFunction {
        &mut *self.0
    }

    /// Whether all of its values are zero.
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
        self.0.kind() == other.0.kind() && format!("{:?}", self.0) == format!("{:?}", other.0)
    }
}
