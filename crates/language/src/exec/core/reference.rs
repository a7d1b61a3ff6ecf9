//! Paths to reference points, and back.
//!
//! The position of a reference point depends on the family: RS274/NGC lets the program set it, for a Fanuc the machine file gives it. For Sinumerik
//! and Grundig only the control knows it: a block is passed through, and its axes are unknown afterwards.

use ncfix_base::geometry::{AxisSet, AxisVector};

/// The intermediate point of a motion to a reference point; the way back passes it again.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::exec) struct Via(Option<AxisVector>);

impl Via {
    /// Stores the intermediate point as axis commands.
    pub(in crate::exec) fn note(&mut self, command: AxisVector) {
        self.0 = Some(command);
    }

    /// The intermediate point for a way back with these axes, the others staying; `None` if there is none.
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
