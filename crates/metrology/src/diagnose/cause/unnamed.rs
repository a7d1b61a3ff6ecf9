//! What has no name: only on what it depends is known, and its shape.

use super::{Cause, Correctable, EffectKind};

pub(in crate::diagnose) const CAUSE: Cause = Cause {
    name: "unknown cause",
    effect: EffectKind::Unknown,
    made_by: "not known: it depends on the listed drivers, with the attached shape",
    shown_by: "a structure that no known cause explains as well",
    separate_by: "vary the listed drivers one at a time",
    correctable: Correctable::No,
    // Shapes are searched ([`crate::diagnose::empirical`]).
    propose: |_, _| {},
};
