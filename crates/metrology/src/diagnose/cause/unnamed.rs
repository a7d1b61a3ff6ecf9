//! An effect without a known cause: only its drivers and its shape are known.

use super::{Cause, Correctable, EffectKind};

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "unknown cause",
    effect: EffectKind::Unknown,
    made_by: "unknown: the error depends on the listed drivers, with the attached shape",
    shown_by: "a structure that no known cause explains equally well",
    separate_by: "vary the listed drivers one at a time",
    correctable: Correctable::No,
    // Shapes are searched in [`crate::diagnose::empirical`].
    propose: |_, _| {},
};
