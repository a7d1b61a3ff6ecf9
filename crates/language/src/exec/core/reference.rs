//! The way to reference points, and back.
//!
//! Where a reference point is, is a matter of the family: RS274/NGC lets the program set it, for a Fanuc the machine file says it, and of Sinumerik and
//! Grundig only the control knows: there a block is passed on, and its axes are unknown behind it.

use ncfix_base::geometry::{AxisSet, AxisVector};

/// The point by way of which axes went to a reference point: the way back leads through it again.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::exec) struct Via(Option<AxisVector>);

impl Via {
    /// Axes went by way of this point, axis commands.
    pub(in crate::exec) fn note(&mut self, command: AxisVector) {
        self.0 = Some(command);
    }

    /// Where axes come back to by way of it, the others staying where they are; `None` where none has gone.
    pub(in crate::exec) fn back(&self, axes: AxisSet, here: AxisVector) -> Option<AxisVector> {
        let through = self.0?;
        let mut target = here;
        axes.iter().for_each(|axis| target[axis] = through[axis]);
        Some(target)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ncfix_base::geometry::Axis;

    #[test]
    fn the_way_back_leads_by_way_of_the_point_of_the_way_there() {
        let place = |x: f64, z: f64| {
            let mut place = AxisVector::ZERO;
            (place[Axis::X], place[Axis::Z]) = (x, z);
            place
        };
        let mut via = Via::default();
        let only_z = [Axis::Z].into_iter().collect();
        assert_eq!(via.back(only_z, place(1.0, 0.0)), None);
        via.note(place(30.0, 100.0));
        assert_eq!(via.back(only_z, place(1.0, 0.0)), Some(place(1.0, 100.0)));
    }
}
