//! The cycle: one set-point in, one correction out. It does not allocate or wait, and the number of its operations has a fixed limit.

use super::dosing::Dosing;
use super::sense::Senses;
use super::update::Subscriber;
use ncfix_base::geometry::AxisVector;

/// Status bits of an answer, as the ring transmits them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Signals(pub u64);

impl Signals {
    /// A set-point was not finite: the correction is that of the previous cycle.
    pub const HELD: Signals = Signals(1);
    /// An axis was beyond its travel: the correction is that of the limit.
    pub const BEYOND: Signals = Signals(2);
    /// The correction has not reached its target value: it is rate-limited.
    pub const DOSED: Signals = Signals(4);
    /// No command brings the tip to its place: the correction is that of the previous cycle.
    pub const UNSOLVED: Signals = Signals(8);
    /// A new kernel was installed in this cycle.
    pub const RENEWED: Signals = Signals(16);

    /// All status bits with their names.
    pub const NAMED: [(Signals, &str); 5] = [
        (Signals::HELD, "held"),
        (Signals::BEYOND, "beyond"),
        (Signals::DOSED, "dosed"),
        (Signals::UNSOLVED, "unsolved"),
        (Signals::RENEWED, "renewed"),
    ];

    /// `beyond dosed`: the names of the set bits.
    #[must_use]
    pub fn words(self) -> String {
        let set = Signals::NAMED.into_iter().filter(|&(signal, _)| self.has(signal));
        set.map(|(_, word)| word).collect::<Vec<_>>().join(" ")
    }

    /// `true` if all bits of `other` are set.
    #[must_use]
    pub fn has(self, other: Signals) -> bool {
        self.0 & other.0 == other.0
    }

    fn set(&mut self, other: Signals, is_set: bool) {
        if is_set {
            self.0 |= other.0;
        }
    }
}

/// The answer to a set-point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Answer {
    /// Correction to add to the set-point, mm and rad.
    pub correction: AxisVector,
    /// Status bits.
    pub signals: Signals,
}

/// The function that a control calls once per cycle.
#[derive(Debug)]
pub struct Cycle {
    kernels: Subscriber,
    dosing: Dosing,
    senses: Senses,
    /// `true` until the first set-point with other kernels.
    is_replaced: bool,
}

impl Cycle {
    /// Creates a cycle. An axis that returns by more than `band_mm` or `band_rad` has reversed; use the increments of the control.
    #[must_use]
    pub fn new(kernels: Subscriber, dosing: Dosing, band_mm: f64, band_rad: f64) -> Cycle {
        Cycle { kernels, dosing, senses: Senses::new(band_mm, band_rad), is_replaced: false }
    }

    /// The correction for the uncompensated set-point of all axes, mm and rad; axes that the machine lacks are ignored.
    pub fn step(&mut self, set_point: &AxisVector) -> Answer {
        let mut signals = Signals::default();
        let (kernel, is_new) = self.kernels.latest();
        signals.set(Signals::RENEWED, is_new || std::mem::take(&mut self.is_replaced));
        if kernel.axes().iter().any(|axis| !set_point[axis].is_finite()) {
            signals.set(Signals::HELD, true);
            return Answer { correction: *self.dosing.in_force(), signals };
        }
        let mut within = *set_point;
        signals.set(Signals::BEYOND, !kernel.clamp(&mut within).is_empty());
        match kernel.correction(&within, self.senses.note(&within)) {
            Some(wanted) => signals.set(Signals::DOSED, !self.dosing.follow(&wanted).is_empty()),
            None => signals.set(Signals::UNSOLVED, true),
        }
        Answer { correction: *self.dosing.in_force(), signals }
    }

    /// Takes kernels from another handover from now on, as after a tool change. The correction goes to its new target in doses. The kernels that were
    /// in use are freed here: between two cycles, not in one.
    pub fn replace(&mut self, kernels: Subscriber) {
        self.kernels = kernels;
        self.is_replaced = true;
    }

    /// Resets to zero correction and unknown directions, as after a reference run.
    pub fn reset(&mut self) {
        self.dosing.reset();
        self.senses.reset();
    }
}
