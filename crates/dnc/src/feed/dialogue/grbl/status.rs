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
pub(super) struct GrblReport {
    pub(super) word: GrblState,
    /// Free blocks of the planner and free bytes of the receive buffer, if reported.
    pub(super) free_blocks: Option<usize>,
    pub(super) free_bytes: Option<usize>,
}

impl GrblReport {
    /// Reads an answer; `None` if it is not a valid report.
    pub(super) fn read(text: &str) -> Option<GrblReport> {
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
        let (mut free_blocks, mut free_bytes) = (None, None);
        for field in fields {
            if let Some(free) = field.strip_prefix("Bf:") {
                let (blocks, bytes) = free.split_once(',')?;
                (free_blocks, free_bytes) = (Some(blocks.parse().ok()?), Some(bytes.parse().ok()?));
            }
        }
        Some(GrblReport { word, free_blocks, free_bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_and_what_is_none_is_not() {
        let read = |text| GrblReport::read(text).unwrap();
        let idle = read("<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>");
        assert_eq!(idle, GrblReport { word: GrblState::Idle, free_blocks: Some(15), free_bytes: Some(128) });
        assert_eq!(
            read("<Run:1|MPos:0,0,0>"),
            GrblReport { word: GrblState::Run, free_blocks: None, free_bytes: None }
        );
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
