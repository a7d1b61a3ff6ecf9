//! The register of words that change no position and are passed on: modes, limits, spindles, messages, coordination of channels.
//!
//! A row says how the values of a word become metric, or that it needs more than passing on. To add a word, add a row.

/// What becomes of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Treatment {
    /// Passed on, values evaluated; those that are lengths or feeds become metric where the program is in inch.
    Keep(Unit),
    /// Replaces the feed in its block.
    BlockFeed,
    /// Reads or writes files of the control: left out, a result variable is 0 (no error).
    File,
    /// Lets an interrupt start a program.
    Interrupt,
    /// Passed on; where the axes are behind it is unknown.
    Lost,
    /// Refused, and why.
    Refuse(&'static str),
}

/// What the values of a word are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// Neither length nor feed.
    None,
    /// A length; of a call the first argument.
    Length,
    /// A feed.
    Feed,
}

/// A row of the register.
#[derive(Debug)]
pub(super) struct Row {
    /// Upper case.
    pub(super) name: &'static str,
    pub(super) treatment: Treatment,
}

const fn plain(name: &'static str) -> Row {
    Row { name, treatment: Treatment::Keep(Unit::None) }
}

const fn length(name: &'static str) -> Row {
    Row { name, treatment: Treatment::Keep(Unit::Length) }
}

const fn feed(name: &'static str) -> Row {
    Row { name, treatment: Treatment::Keep(Unit::Feed) }
}

const fn file(name: &'static str) -> Row {
    Row { name, treatment: Treatment::File }
}

const fn lost(name: &'static str) -> Row {
    Row { name, treatment: Treatment::Lost }
}

const fn refuse(name: &'static str, why: &'static str) -> Row {
    Row { name, treatment: Treatment::Refuse(why) }
}

const PREPARED: &str = "a contour is prepared as a table, and its blocks move nothing";
const COUPLED: &str = "a coupled axis moves without being programmed";
const PROBED: &str = "a probe ends the motion at a place that only the machine finds";
const FILE_READ: &str = "what the file says is known on the control only";
const TOOL_KNOWN: &str = "the answer of the tool management is known on the control only";
const OVERLAID: &str = "a motion is overlaid that is not in the program";

/// All rows.
pub(super) const ROWS: &[Row] = &[
    // Continuous path, tolerances, dynamics.
    length("ADIS"),
    length("ADISPOS"),
    length("CTOL"),
    plain("OTOL"),
    plain("STOLF"),
    length("CPREC"),
    plain("ACC"),
    plain("ACCLIMA"),
    plain("VELOLIM"),
    plain("VELOLIMA"),
    plain("JERKLIM"),
    plain("JERKLIMA"),
    plain("BLSYNC"),
    plain("IPOBRKA"),
    plain("ADISPOSA"),
    plain("FINEA"),
    plain("COARSEA"),
    plain("IPOENDA"),
    plain("SOFTA"),
    plain("BRISKA"),
    plain("DRIVEA"),
    plain("JERKA"),
    length("CYCLE832"),
    plain("CYCLE_HSC"),
    // Threads.
    plain("SF"),
    length("DITS"),
    length("DITE"),
    // Feed.
    Row { name: "FB", treatment: Treatment::BlockFeed },
    feed("FA"),
    feed("FL"),
    plain("FGROUP"),
    length("FGREF"),
    plain("FPR"),
    plain("FPRAON"),
    plain("FPRAOF"),
    plain("OVR"),
    plain("OVRRAP"),
    plain("OVRA"),
    // Spindles.
    plain("LIMS"),
    plain("SPOS"),
    plain("SPOSA"),
    plain("SPCON"),
    plain("SPCOF"),
    plain("SETMS"),
    plain("SCC"),
    plain("WAITS"),
    plain("COUPDEF"),
    plain("COUPDEL"),
    plain("COUPON"),
    plain("COUPONC"),
    plain("COUPOF"),
    plain("COUPOFS"),
    plain("COUPRES"),
    plain("WAITC"),
    // Couplings of axes: only what ends them.
    plain("CTABDEL"),
    plain("TRAILOF"),
    plain("LEADOF"),
    plain("EGOFS"),
    plain("EGOFC"),
    plain("EGDEL"),
    plain("MASLOF"),
    plain("MASLOFS"),
    plain("MASLDEL"),
    plain("TOFFOF"),
    plain("CORROF"),
    plain("DRFOF"),
    plain("TANGOF"),
    plain("TANGDEL"),
    plain("OSE"),
    refuse("CTABDEF", "the blocks up to CTABEND fill a table and move nothing"),
    refuse("CTABEND", "the blocks before it fill a table and move nothing"),
    refuse("CONTPRON", PREPARED),
    refuse("CONTDCON", PREPARED),
    refuse("EXECTAB", PREPARED),
    refuse("EXECUTE", PREPARED),
    refuse("TRAILON", COUPLED),
    refuse("LEADON", COUPLED),
    refuse("EGON", COUPLED),
    refuse("EGONSYN", COUPLED),
    refuse("EGONSYNE", COUPLED),
    refuse("TANGON", COUPLED),
    refuse("MASLON", COUPLED),
    refuse("TOFFON", OVERLAID),
    refuse("OS", OVERLAID),
    refuse("PUTFTOC", OVERLAID),
    refuse("PUTFTOCF", OVERLAID),
    // Fixed stop, exchange of axes: the machine is where something else has put it.
    lost("FXS"),
    plain("FXST"),
    plain("FXSW"),
    lost("GET"),
    lost("GETD"),
    plain("RELEASE"),
    refuse("GEOAX", "other axes would be X, Y and Z from here on"),
    refuse("PRESETON", "the machine zero would be moved, and with it the correction"),
    refuse("PRESETONS", "the machine zero would be moved, and with it the correction"),
    refuse("AXCTSWE", "other axes would be moved from here on"),
    refuse("MEAS", PROBED),
    refuse("MEAW", PROBED),
    refuse("MEASA", PROBED),
    refuse("MEAWA", PROBED),
    refuse("MEAC", PROBED),
    // Coordination of channels, messages, preprocessing.
    plain("MMC"),
    plain("WAITM"),
    plain("WAITMC"),
    plain("WAITE"),
    plain("WAITP"),
    plain("SETM"),
    plain("CLEARM"),
    plain("INIT"),
    plain("START"),
    plain("SETAL"),
    plain("NEWCONF"),
    plain("STOPREOF"),
    plain("IPTRLOCK"),
    plain("IPTRUNLOCK"),
    plain("DELAYFSTON"),
    plain("DELAYFSTOF"),
    plain("PROTA"),
    plain("PROTS"),
    plain("PROTD"),
    plain("CANCEL"),
    plain("CANCELSUB"),
    plain("LOCK"),
    plain("UNLOCK"),
    plain("FCTDEF"),
    plain("TLIFT"),
    Row { name: "SETINT", treatment: Treatment::Interrupt },
    plain("CLRINT"),
    plain("ENABLE"),
    plain("DISABLE"),
    // Files of the control, tool management.
    file("WRITE"),
    file("DELETE"),
    refuse("READ", FILE_READ),
    refuse("GETT", TOOL_KNOWN),
    refuse("GETSELT", TOOL_KNOWN),
    refuse("GETEXET", TOOL_KNOWN),
    plain("DELT"),
    plain("SETPIECE"),
    plain("POSM"),
    plain("DELMT"),
];

/// Address letters with an index in brackets, `S[2]=500`.
pub(super) const INDEXED_LETTERS: &[&str] = &["S", "M", "H"];

/// The row of a name, upper case.
pub(super) fn row(name: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_word_stands_once() {
        let mut names: Vec<&str> = ROWS.iter().map(|row| row.name).collect();
        names.sort_unstable();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count);
        assert!(ROWS.iter().all(|row| ncfix_dialect::sinumerik().codes().word(row.name).is_none()));
    }
}
