//! Number of blocks that a control may have answered but not executed, as it reports itself, and whether it is idle.
//!
//! An answer says that the planner has taken a line, not that anything has moved. Planner depth differs between controls and is often a setting, so a
//! constant is of no use. The depth that the control states at the beginning of the job counts; if it states several, the largest.

use super::Event;

/// Planner depth that a control has stated.
#[derive(Debug, Default)]
pub(super) struct Depth {
    /// Maximum number of blocks, and the words of the control; `None` if it states nothing.
    stated: Option<(u64, String)>,
    is_told: bool,
}

impl Depth {
    /// Notes a stated number of blocks. `beyond` more have left the planner and still move. A planner without places is ignored.
    pub(super) fn hear(&mut self, blocks: Option<&str>, beyond: u64, said: &str) {
        let Some(blocks) = blocks.and_then(|blocks| blocks.trim().parse::<u64>().ok()) else { return };
        let most = blocks.saturating_add(beyond);
        let is_size = said.starts_with('[');
        if blocks > 0 && self.stated.as_ref().is_none_or(|(known, _)| *known < most || *known == most && is_size) {
            self.stated = Some((most, said.chars().take(80).collect()));
        }
    }

    /// Reports the depth once, before the first line.
    pub(super) fn tell(&mut self, events: &mut Vec<Event>) {
        if let Some((most, said)) = self.stated.clone().filter(|_| !self.is_told) {
            self.is_told = true;
            events.push(Event::Holds(most, said));
        }
    }

    /// Describes the depth for people.
    pub(super) fn words(&self) -> String {
        match &self.stated {
            Some((most, _)) => format!("up to {most} blocks of its planner"),
            None => "the contents of its planner, which it does not report".into(),
        }
    }
}

/// Returns why nothing may be sent to a control of the Grbl family that reports this state; `None` if it is idle.
///
/// The states are those of Grbl 1.1 and grblHAL; text after a colon gives details.
pub(super) fn not_idle(state: &str) -> Option<String> {
    let what = match state.split(':').next().unwrap_or_default() {
        "Idle" => return None,
        "Run" => "it is executing something else: let it end, or stop it there",
        "Hold" => "its axes are in hold within another job: end that job with cycle start, or reset it there",
        "Door" => "its door is open, or was while it moved: close it, and let the job end or reset it there",
        "Alarm" => "it is in alarm: find the cause, then home it or clear it there",
        "Home" => "it is homing: wait until it has finished",
        "Check" => "its check mode is on, in which nothing moves: switch it off ($C)",
        "Jog" => "it is being jogged: wait until that is done",
        "Sleep" => "it sleeps: reset it there, and home it",
        "Tool" => "it waits for a tool: change it and let it continue, or reset it there",
        _ => "this state is unknown to ncfix: bring the control to idle there",
    };
    let shown: String = state.chars().take(40).collect();
    Some(format!("the control is not idle ({shown}): {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_that_is_stated_counts_and_is_told_once() {
        let (mut depth, mut events) = (Depth::default(), Vec::new());
        depth.tell(&mut events);
        assert!(events.is_empty() && depth.words().contains("does not report"));
        depth.hear(Some("0"), 16, "Bf:0,128");
        depth.tell(&mut events);
        assert!(events.is_empty(), "a planner needs at least one block: {events:?}");
        depth.hear(Some("100"), 16, "[OPT:VNM,100,1024,3,0]");
        depth.hear(Some("x"), 16, "Bf:x,1023");
        depth.hear(None, 16, "Bf");
        depth.hear(Some("35"), 16, "Bf:35,1023");
        depth.tell(&mut events);
        depth.tell(&mut events);
        assert_eq!(events, [Event::Holds(116, "[OPT:VNM,100,1024,3,0]".into())]);
    }

    #[test]
    fn only_idle_is_idle() {
        assert_eq!(not_idle("Idle"), None);
        for (state, word) in [
            ("Run", "let it end"),
            ("Run:1", "let it end"),
            ("Hold:0", "in hold"),
            ("Door:3", "door"),
            ("Alarm:1", "alarm"),
            ("Home", "homing"),
            ("Check", "$C"),
            ("Jog", "jogged"),
            ("Sleep", "sleeps"),
            ("Tool", "tool"),
            ("", "unknown"),
            ("Idler", "unknown"),
        ] {
            assert!(not_idle(state).is_some_and(|why| why.contains(word)), "{state}");
        }
    }
}
