//! Second step of the correction in doses: what is applied approaches what the model asks for, so that no jump of a temperature marks a workpiece.
//!
//! What is left to dose is the difference between the correction that the model asks for and the one that is applied. A new temperature makes it
//! grow at once while the applied correction stays; every block takes some of it away. Where the model asks for another correction because the axes
//! have moved, that is followed at once: it is a part of the volumetric correction, as smooth as the way (Spaan 1995, ch. 7; the limits are those
//! of controls that compensate temperatures themselves: per step, per way and per time).

use ncfix_base::geometry::AXIS_COUNT;

/// How fast an applied correction changes for the sake of temperature, each axis; infinite where that does not matter. Linear axes in mm, rotary
/// ones in rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// From one block to the next.
    pub per_block: f64,
    /// Per mm of way; a block that stays on the spot changes nothing.
    pub per_mm: f64,
    /// Per second.
    pub per_s: f64,
}

/// What a block may do to the applied correction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dose {
    /// Approach what the model asks for, by the way in mm and the time in s of the block.
    Step {
        /// Way of the block, mm.
        way_mm: f64,
        /// Its time, s.
        time_s: f64,
    },
    /// Be there at once: a way on which nothing is cut.
    Whole,
    /// Follow what the way asks for and approach nothing: sensors are in doubt.
    Follow,
    /// Leave it exactly as it is: arcs.
    Hold,
    /// Take it away: a move that is not corrected.
    Release,
}

impl Default for Limits {
    fn default() -> Self {
        Limits { per_block: 1e-3, per_mm: 1e-4, per_s: 5e-4 }
    }
}

/// The correction that is applied, and what is left to dose.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LineDosing {
    limits: Limits,
    /// What the model asks for less what is applied, each axis; `None` before the first block.
    left: Option<[f64; AXIS_COUNT]>,
    applied: [f64; AXIS_COUNT],
    /// What was lacking before moves without correction; `None` where the last move was none.
    released: Option<[f64; AXIS_COUNT]>,
}

impl LineDosing {
    /// Starts without a correction.
    #[must_use]
    pub fn new(limits: Limits) -> LineDosing {
        LineDosing { limits, ..LineDosing::default() }
    }

    /// The correction at the end of the next block, when the model asks for `now` there and asked for `before` where the axes stand, with the same
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
                // Behind a move without correction it is again what it was before that.
                let applied = self.applied;
                let lacks = self.released.unwrap_or_else(|| std::array::from_fn(|slot| before[slot] - applied[slot]));
                self.applied = std::array::from_fn(|slot| now[slot] - lacks[slot]);
            }
            Dose::Step { way_mm, time_s } => {
                let limits = &self.limits;
                let share = |limit: f64, of: f64| if limit.is_infinite() { limit } else { limit * of.max(0.0) };
                // On the spot nothing is cut along a way; time alone counts.
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

    /// What is applied.
    #[must_use]
    pub fn applied(&self) -> &[f64; AXIS_COUNT] {
        &self.applied
    }

    /// What was left to dose at the end of the last block; `None` before the first.
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
            let mut dosing = LineDosing::new(Limits { per_block: 1.0, per_mm, per_s: 1e-3 });
            assert_eq!(dosing.step(&along_x(0.05), &along_x(0.05), step(0.0, 0.0))[0], 0.0);
            assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(0.0, 1.0))[0] - 1e-3).abs() < 1e-12);
        }
        let mut dosing = LineDosing::new(Limits { per_block: 1.0, per_mm: 1e-4, per_s: f64::INFINITY });
        assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(2.0, 0.0))[0] - 2e-4).abs() < 1e-12);
    }

    #[test]
    fn a_jump_of_ten_micrometers_takes_as_many_blocks_as_the_limit_says() {
        let mut dosing = LineDosing::new(Limits { per_block: 1e-3, per_mm: 1.0, per_s: 1.0 });
        let asked = along_x(0.0105);
        let applied: Vec<f64> = (0..12).map(|_| dosing.step(&asked, &asked, step(10.0, 1.0))[0]).collect();
        for (k, value) in applied.iter().enumerate() {
            assert!((value - (0.001 * (k + 1) as f64).min(0.0105)).abs() < 1e-12, "{k}: {value}");
        }
    }

    #[test]
    fn way_and_time_limit_too_and_what_the_way_asks_for_is_followed() {
        let mut dosing = LineDosing::new(Limits { per_block: 1.0, per_mm: 1e-4, per_s: 1e-3 });
        // 10 mm: 1 µm; 0.1 s: 0.1 µm; the smaller counts.
        assert!((dosing.step(&along_x(0.05), &along_x(0.05), step(10.0, 0.1))[0] - 1e-4).abs() < 1e-12);
        // The way itself asks for 0.02 more.
        let applied = dosing.step(&along_x(0.05), &along_x(0.07), step(10.0, 0.0))[0];
        assert!((applied - 0.0201).abs() < 1e-12, "{applied}");
    }

    #[test]
    fn a_move_without_correction_does_not_end_what_is_followed() {
        let mut dosing = LineDosing::new(Limits { per_block: 1.0, per_mm: 1.0, per_s: 1.0 });
        assert_eq!(dosing.step(&along_x(0.0), &along_x(0.012), Dose::Whole)[0], 0.012);
        for _ in 0..2 {
            assert_eq!(dosing.step(&along_x(0.012), &along_x(0.012), Dose::Release)[0], 0.0);
        }
        let back = dosing.step(&along_x(0.012), &along_x(0.013), Dose::Follow)[0];
        assert!((back - 0.013).abs() < 1e-12, "{back}");
    }

    #[test]
    fn what_is_held_stays_and_is_dosed_afterwards() {
        let mut dosing = LineDosing::new(Limits { per_block: 1e-3, per_mm: 1.0, per_s: 1.0 });
        let held = dosing.step(&along_x(0.0), &along_x(0.004), Dose::Hold)[0];
        assert_eq!((held, dosing.left().unwrap()[0]), (0.0, 0.004));
        let next = dosing.step(&along_x(0.004), &along_x(0.004), step(10.0, 1.0))[0];
        assert!((next - 0.001).abs() < 1e-12, "{next}");
    }
}
