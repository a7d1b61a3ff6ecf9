//! Grbl: status report that answers `?`, such as `<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>`.
//!
//! The report is a record of fields and is split at its separators: a pattern would not say which field is wrong.

/// State that the control reports (Grbl 1.1, interface; grblHAL adds `Tool`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum GrblState {
    Idle,
    Run,
    /// Stopped until a person resumes it: a hold, an open door, a manual tool change.
    Held,
    /// Jogged or homed by a person.
    ByHand,
    /// Takes lines and moves nothing.
    Check,
    Sleep,
    Alarm,
    /// Unknown state.
    Odd,
}

/// Status report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct GrblReport<'t> {
    pub(super) word: GrblState,
    /// Free blocks of the planner and free bytes of the receive buffer, if reported.
    pub(super) free_blocks: Option<usize>,
    pub(super) free_bytes: Option<usize>,
    /// Axis positions as reported, with commas: those of the machine, those of the program, and the difference between the two.
    pub(super) machine: Option<&'t str>,
    pub(super) work: Option<&'t str>,
    pub(super) offset: Option<&'t str>,
}

impl<'t> GrblReport<'t> {
    /// Reads an answer; `None` if it is not a valid report.
    pub(super) fn read(text: &'t str) -> Option<GrblReport<'t>> {
        let mut fields = text.strip_prefix('<')?.strip_suffix('>')?.split('|');
        let word = match fields.next()?.split(':').next()? {
            "Idle" => GrblState::Idle,
            "Run" => GrblState::Run,
            "Hold" | "Door" | "Tool" => GrblState::Held,
            "Home" | "Jog" => GrblState::ByHand,
            "Check" => GrblState::Check,
            "Sleep" => GrblState::Sleep,
            "Alarm" => GrblState::Alarm,
            "" => return None,
            _ => GrblState::Odd,
        };
        let mut report =
            GrblReport { word, free_blocks: None, free_bytes: None, machine: None, work: None, offset: None };
        for field in fields {
            match field.split_once(':') {
                Some(("Bf", free)) => {
                    let (blocks, bytes) = free.split_once(',')?;
                    (report.free_blocks, report.free_bytes) = (Some(blocks.parse().ok()?), Some(bytes.parse().ok()?));
                }
                Some(("MPos", axes)) => report.machine = Some(axes),
                Some(("WPos", axes)) => report.work = Some(axes),
                Some(("WCO", axes)) => report.offset = Some(axes),
                _ => {}
            }
        }
        Some(report)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_and_what_is_none_is_not() {
        let read = |text| GrblReport::read(text).unwrap();
        let idle = read("<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0|WCO:-1.000,0.000,2.500>");
        assert_eq!((idle.word, idle.free_blocks, idle.free_bytes), (GrblState::Idle, Some(15), Some(128)));
        assert_eq!(
            (idle.machine, idle.work, idle.offset),
            (Some("0.000,0.000,0.000"), None, Some("-1.000,0.000,2.500"))
        );
        let run = read("<Run:1|WPos:0,0,0>");
        assert_eq!((run.word, run.free_blocks, run.free_bytes), (GrblState::Run, None, None));
        assert_eq!((run.machine, run.work, run.offset), (None, Some("0,0,0"), None));
        for (text, word) in [
            ("<Hold:0|a>", GrblState::Held),
            ("<Door:3>", GrblState::Held),
            ("<Tool>", GrblState::Held),
            ("<Alarm:1>", GrblState::Alarm),
        ] {
            assert_eq!(read(text).word, word);
        }
        assert_eq!(read("<Idlf|MPos:0>").word, GrblState::Odd);
        for text in ["<Idle|Bf:1x,128>", "<Idle|Bf:15>", "Idle", "<Idle", "<>", "<Run|Bf:,>"] {
            assert_eq!(GrblReport::read(text), None, "{text}");
        }
    }
}
