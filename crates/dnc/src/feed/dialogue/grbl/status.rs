//! Grbl: the report that answers `?`, such as `<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>`.

/// What the control does, as it says (Grbl 1.1, interface; grblHAL adds `Tool`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Idle,
    Run,
    /// It stands until somebody lets it go on: a hold, an open door, a tool to be changed by hand.
    Held,
    /// Somebody moves it by hand, or homes it.
    ByHand,
    /// It takes lines and moves nothing.
    Check,
    Sleep,
    Alarm,
    /// No state that is known.
    Odd,
}

/// One report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Status {
    pub(super) word: Word,
    /// Free blocks of the planner and free bytes of the receive buffer, where it says so.
    pub(super) free_blocks: Option<usize>,
    pub(super) free_bytes: Option<usize>,
}

impl Status {
    /// Reads an answer; `None` where it is no report that a control gives.
    pub(super) fn read(text: &str) -> Option<Status> {
        let mut fields = text.strip_prefix('<')?.strip_suffix('>')?.split('|');
        let word = match fields.next()?.split(':').next()? {
            "Idle" => Word::Idle,
            "Run" => Word::Run,
            "Hold" | "Door" | "Tool" => Word::Held,
            "Home" | "Jog" => Word::ByHand,
            "Check" => Word::Check,
            "Sleep" => Word::Sleep,
            "Alarm" => Word::Alarm,
            "" => return None,
            _ => Word::Odd,
        };
        let (mut free_blocks, mut free_bytes) = (None, None);
        for field in fields {
            if let Some(free) = field.strip_prefix("Bf:") {
                let (blocks, bytes) = free.split_once(',')?;
                (free_blocks, free_bytes) = (Some(blocks.parse().ok()?), Some(bytes.parse().ok()?));
            }
        }
        Some(Status { word, free_blocks, free_bytes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_read_and_what_is_none_is_not() {
        let read = |text| Status::read(text).unwrap();
        let idle = read("<Idle|MPos:0.000,0.000,0.000|Bf:15,128|FS:0,0>");
        assert_eq!(idle, Status { word: Word::Idle, free_blocks: Some(15), free_bytes: Some(128) });
        assert_eq!(read("<Run:1|MPos:0,0,0>"), Status { word: Word::Run, free_blocks: None, free_bytes: None });
        for (text, word) in
            [("<Hold:0|a>", Word::Held), ("<Door:3>", Word::Held), ("<Tool>", Word::Held), ("<Alarm:1>", Word::Alarm)]
        {
            assert_eq!(read(text).word, word);
        }
        assert_eq!(read("<Idlf|MPos:0>").word, Word::Odd);
        for text in ["<Idle|Bf:1x,128>", "<Idle|Bf:15>", "Idle", "<Idle", "<>", "<Run|Bf:,>"] {
            assert_eq!(Status::read(text), None, "{text}");
        }
    }
}
