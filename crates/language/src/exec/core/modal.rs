//! Modal groups: the active code of each, from block to block.
//!
//! Groups common to all languages are stored by meaning, in [`Modes`]. For all other groups [`CodesInForce`] stores the code itself; a family defines
//! its groups and their codes at the start. Both are plain values: a saved state is a clone, and a restore compares codes.

use ncfix_base::geometry::Plane;
use ncfix_base::units::MM_PER_INCH;
use ncfix_machine::snc::FeedUnit;

/// Reason of a missing feed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FeedLack {
    /// No F word so far.
    Never,
    /// The last F word has the value 0.
    Zero,
    /// The last F word is in another unit.
    OtherUnit,
}

/// State of the groups common to all languages; `M` is the motion mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec) struct Modes<M> {
    /// The active motion mode.
    pub(in crate::exec) motion: M,
    /// The working plane.
    pub(in crate::exec) plane: Plane,
    /// `true` if positions are relative to the previous one.
    pub(in crate::exec) incremental: bool,
    /// `true` if lengths are in inches.
    pub(in crate::exec) inch: bool,
    /// The feed in mm and in units of `feed_unit`; 0 if none yet.
    pub(in crate::exec) feed: f64,
    /// Why there is no feed, if `feed` is 0.
    lack: FeedLack,
    /// Unit of F.
    pub(in crate::exec) feed_unit: FeedUnit,
    /// Last spindle speed.
    pub(in crate::exec) speed: Option<f64>,
}

impl<M> Modes<M> {
    /// Absolute, millimeters, no feed.
    pub(in crate::exec) fn new(motion: M, plane: Plane) -> Self {
        Modes {
            motion,
            plane,
            incremental: false,
            inch: false,
            feed: 0.0,
            lack: FeedLack::Never,
            feed_unit: FeedUnit::default(),
            speed: None,
        }
    }

    /// mm per programmed length unit.
    pub(in crate::exec) fn scale(&self) -> f64 {
        if self.inch { MM_PER_INCH } else { 1.0 }
    }

    /// Selects the unit of F. A feed in another unit is dropped: it must be programmed again.
    pub(in crate::exec) fn select_feed_unit(&mut self, unit: FeedUnit) {
        if unit != self.feed_unit {
            self.feed_unit = unit;
            self.drop_feed();
        }
    }

    /// Drops the feed, because a code for its unit has ended it.
    pub(in crate::exec) fn drop_feed(&mut self) {
        if self.feed > 0.0 {
            self.lack = FeedLack::OtherUnit;
        }
        self.feed = 0.0;
    }

    /// Sets the feed of an F word, in mm.
    pub(in crate::exec) fn set_feed(&mut self, feed: f64) {
        self.feed = feed;
        self.lack = FeedLack::Zero;
    }

    /// `true` if neither the program nor the start of the control has named a feed.
    pub(in crate::exec) fn never_had_feed(&self) -> bool {
        matches!(self.lack, FeedLack::Never)
    }

    /// Why a feed move has no feed, and what to do.
    pub(in crate::exec) fn no_feed(&self) -> (&'static str, &'static str) {
        match self.lack {
            FeedLack::Never => ("feed move before any F word", "program F before it or in it"),
            FeedLack::Zero => ("feed move with F0", "program F with a value above 0 before it or in it"),
            FeedLack::OtherUnit => (
                "feed move without F after a code that changes the unit of F",
                "program F in the new unit before it or in it",
            ),
        }
    }
}

/// The active code of each group `G`.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::exec) struct CodesInForce<G: 'static, C: 'static> {
    /// Codes at the start.
    initial: &'static [(G, C)],
    /// Codes programmed since, in the order in which their groups were first programmed.
    programmed: Vec<(G, C)>,
}

impl<G: Copy + PartialEq, C: Copy + PartialEq> CodesInForce<G, C> {
    /// Creates the state with these initial codes.
    pub(in crate::exec) fn new(initial: &'static [(G, C)]) -> Self {
        CodesInForce { initial, programmed: Vec::new() }
    }

    /// The active code of a group; `None` if neither the program nor the start has one.
    pub(in crate::exec) fn code(&self, group: G) -> Option<C> {
        self.programmed(group).or_else(|| find(self.initial, group))
    }

    /// The last programmed code of a group.
    pub(in crate::exec) fn programmed(&self, group: G) -> Option<C> {
        find(&self.programmed, group)
    }

    /// `true` if this code is active.
    pub(in crate::exec) fn is(&self, group: G, code: C) -> bool {
        self.code(group) == Some(code)
    }

    /// Activates a code.
    pub(in crate::exec) fn set(&mut self, group: G, code: C) {
        match self.programmed.iter_mut().find(|(known, _)| *known == group) {
            Some(entry) => entry.1 = code,
            None => self.programmed.push((group, code)),
        }
    }

    /// Restores the code of a group from a saved state; returns it if another one was active.
    pub(in crate::exec) fn bring_back(&mut self, saved: &Self, group: G) -> Option<C> {
        let code = saved.code(group).filter(|&code| self.code(group) != Some(code))?;
        self.set(group, code);
        Some(code)
    }

    /// The codes that differ in `left`, in the order in which the ending program first programmed their groups.
    pub(in crate::exec) fn other_than(&self, left: &Self) -> Vec<C> {
        let of = |&(group, code): &(G, C)| self.code(group).filter(|&before| before != code);
        left.programmed.iter().filter_map(of).collect()
    }
}

fn find<G: Copy + PartialEq, C: Copy>(codes: &[(G, C)], group: G) -> Option<C> {
    codes.iter().find(|(known, _)| *known == group).map(|&(_, code)| code)
}

#[cfg(test)]
mod tests {
    use super::*;

    const INITIAL: &[(u8, &str)] = &[(10, "G60"), (15, "G94")];

    #[test]
    fn a_group_has_the_code_of_the_start_until_another_is_programmed() {
        let mut codes = CodesInForce::new(INITIAL);
        assert_eq!((codes.code(10), codes.programmed(10), codes.code(7)), (Some("G60"), None, None));
        codes.set(10, "G64");
        codes.set(10, "G642");
        assert!(codes.is(10, "G642") && !codes.is(10, "G60") && codes.is(15, "G94"));
    }

    #[test]
    fn what_a_called_program_changed_comes_back_in_the_order_in_which_it_changed_it() {
        let mut caller = CodesInForce::new(INITIAL);
        caller.set(7, "G40");
        let mut left = caller.clone();
        left.set(15, "G95");
        left.set(7, "G40");
        left.set(10, "G64");
        left.set(24, "FFWON");
        // The previous code of group 24 is unknown.
        assert_eq!(caller.other_than(&left), ["G94", "G60"]);
        assert_eq!((left.bring_back(&caller, 10), left.bring_back(&caller, 10)), (Some("G60"), None));
        assert!(left.is(10, "G60"));
    }

    #[test]
    fn a_feed_ends_where_f_counts_something_else() {
        let mut modes = Modes { feed: 500.0, inch: true, ..Modes::new((), Plane::XY) };
        modes.select_feed_unit(FeedUnit::PerMinute);
        assert_eq!((modes.feed, modes.scale()), (500.0, 25.4));
        modes.select_feed_unit(FeedUnit::PerTurn);
        assert_eq!((modes.feed, modes.feed_unit), (0.0, FeedUnit::PerTurn));
    }
}
