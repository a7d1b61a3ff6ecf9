//! Rate limit of the thermal correction: the applied correction approaches that of the model, so that no temperature step marks a workpiece.
//!
//! The remainder is the difference between the correction of the model and the applied one. A new temperature increases it at once, while the applied
//! correction stays; every block removes part of it. A change of the correction due to axis motion is followed at once. It is part of the volumetric
//! correction and as smooth as the path (Spaan 1995, ch. 7). The limits are those of controls with their own temperature compensation: per step, per path
//! length and per time.

use ncfix_base::geometry::AXIS_COUNT;

/// Limits on the rate of change of an applied correction due to temperature, for each axis; infinite means no limit. Linear axes in mm, rotary axes in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DosingLimits {
    /// Maximum change from one block to the next.
    pub per_block: f64,
    /// Maximum change per mm of path. A block without motion changes nothing.
    pub per_mm: f64,
    /// Maximum change per second.
    pub per_s: f64,
}

/// Permitted change of the applied correction in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dose {
    /// Approach the correction of the model, limited by path length and time of the block.
    Step {
        /// Path length of the block, mm.
        way_mm: f64,
        /// Time of the block, s.
        time_s: f64,
    },
    /// Apply the correction of the model at once: a move that does not cut.
    Whole,
    /// Follow the change along the path and approach nothing: the sensors are unreliable.
    Follow,
    /// Keep the correction exactly: arcs.
    Hold,
    /// Remove the correction: a move that is not corrected.
    Release,
}

impl Default for DosingLimits {
    fn default() -> Self {
        DosingLimits { per_block: 1e-3, per_mm: 1e-4, per_s: 5e-4 }
    }
}

/// Applied correction and remainder.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineDosing {
    limits: DosingLimits,
    /// Correction of the model minus applied correction, for each axis; `None` before the first block.
    left: Option<[f64; AXIS_COUNT]>,
    applied: [f64; AXIS_COUNT],
    /// Remainder before moves without correction; `None` if the last move was corrected.
    released: Option<[f64; AXIS_COUNT]>,
}

impl LineDosing {
    /// Starts without a correction.
    #[must_use]
    pub fn new(limits: DosingLimits) -> LineDosing {
        LineDosing { limits, ..LineDosing::default() }
    }

    /// Returns the correction at the end of the next block. The model asks for `now` there, and for `before` at the current position, both at the same
    /// temperatures.
    pub fn step(&mut self, before: &[f64; AXIS_COUNT], now: &[f64; AXIS_COUNT], dose: Dose) -> [f64; AXIS_COUNT] {
        match dose {
            Dose::Hold => {}
            Dose::Whole => self.applied = *now,
            Dose::Release => {
                let lacks = std::array::from_fn(|slot| before[slot] - self.applied[slot]);
                self.released.get_or_insert(lacks);
                self.applied = [0.0; AXIS_COUNT];
            }
            Dose::Follow => {
                // After a move without correction the remainder is again that before the move.
                let applied = self.applied;
                let lacks = self.released.unwrap_or_else(|| std::array::from_fn(|slot| before[slot] - applied[slot]));
                self.applied = std::array::from_fn(|slot| now[slot] - lacks[slot]);
            }
            Dose::Step { way_mm, time_s } => {
                let limits = &self.limits;
                let share = |limit: f64, of: f64| if limit.is_infinite() { limit } else { limit * of.max(0.0) };
                // Without motion nothing is cut along a path; only the time limit counts.
                let of_way = if way_mm > 0.0 { share(limits.per_mm, way_mm) } else { f64::INFINITY };
                let most = limits.per_block.min(of_way).min(share(limits.per_s, time_s));
                for slot in 0..AXIS_COUNT {
                    let left = before[slot] - self.applied[slot];
                    self.applied[slot] = now[slot] - (left - left.clamp(-most, most));
                }
            }
        }
        if !matches!(dose, Dose::Release | Dose::Hold) {
            self.released = None;
        }
        self.left = Some(std::array::from_fn(|slot| now[slot] - self.applied[slot]));
        self.applied
    }

    /// Returns the applied correction.
    #[must_use]
    pub fn applied(&self) -> &[f64; AXIS_COUNT] {
        &self.applied
    }

    /// Returns the remainder at the end of the last block; `None` before the first.
    #[must_use]
    pub fn left(&self) -> Option<&[f64; AXIS_COUNT]> {
        self.left.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn along_x(value: f64) -> [f64; AXIS_COUNT] {
        let mut out = [0.0; AXIS_COUNT];
        out[0] = value;
        out
    }

    fn step(way_mm: f64, time_s: f64) -> Dose {
        Dose::Step { way_mm, time_s }
    }

    #[test]
    fn on_the_spot_time_alone_counts() {
        for per_mm in [f64::INFINITY, 1e-4] {
            let mut dosing = LineDosing::new(DosingLimits { per_block: 1.0, per_mm, per_s: 1e-3 });
            assert_eq!(dosing.step(&along_x(0.05), &along_x(0.05), step(0.0, 0.0))[0], 0.0);
            assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(0.0, 1.0))[0] - 1e-3).abs() < 1e-12);
        }
        let mut dosing = LineDosing::new(DosingLimits { per_block: 1.0, per_mm: 1e-4, per_s: f64::INFINITY });
        assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(2.0, 0.0))[0] - 2e-4).abs() < 1e-12);
    }

    #[test]
    fn a_jump_of_ten_micrometers_takes_as_many_blocks_as_the_limit_says() {
        let mut dosing = LineDosing::new(DosingLimits { per_block: 1e-3, per_mm: 1.0, per_s: 1.0 });
        let asked = along_x(0.0105);
        let applied: Vec<f64> = (0..12).map(|_| dosing.step(&asked, &asked, step(10.0, 1.0))[0]).collect();
        for (k, value) in applied.iter().enumerate() {
            assert!((value - (0.001 * (k + 1) as f64).min(0.0105)).abs() < 1e-12, "{k}: {value}");
        }
    }

    #[test]
    fn way_and_time_limit_too_and_what_the_way_asks_for_is_followed() {
        let mut dosing = LineDosing::new(DosingLimits { per_block: 1.0, per_mm: 1e-4, per_s: 1e-3 });
        // 10 mm: 1 µm; 0.1 s: 0.1 µm; the smaller limit counts.
        assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(10.0, 0.1))[0] - 1e-4).abs() < 1e-12);
        // The path itself asks for another 0.02.
        let applied = dosing.step(&along_x(0.05), &along_x(0.07), step(10.0, 0.0))[0];
        assert!((applied - 0.0201).abs() < 1e-12, "{applied}");
    }

    #[test]
    fn a_move_without_correction_does_not_end_what_is_followed() {
        let mut dosing = LineDosing::new(DosingLimits { per_block: 1.0, per_mm: 1.0, per_s: 1.0 });
        assert_eq!(dosing.step(&along_x(0.0), &along_x(0.012), Dose::Whole)[0], 0.012);
        for _ in 0..2 {
            assert_eq!(dosing.step(&along_x(0.012), &along_x(0.012), Dose::Release)[0], 0.0);
        }
        let back = dosing.step(&along_x(0.012), &along_x(0.013), Dose::Follow)[0];
        assert!((back - 0.013).abs() < 1e-12, "{back}");
    }

    #[test]
    fn what_is_held_stays_and_is_dosed_afterwards() {
        let mut dosing = LineDosing::new(DosingLimits { per_block: 1e-3, per_mm: 1.0, per_s: 1.0 });
        let held = dosing.step(&along_x(0.0), &along_x(0.004), Dose::Hold)[0];
        assert_eq!((held, dosing.left().unwrap()[0]), (0.0, 0.004));
        let next = dosing.step(&along_x(0.004), &along_x(0.004), step(10.0, 1.0))[0];
        assert!((next - 0.001).abs() < 1e-12, "{next}");
    }
}
