//! Questions to linuxcncrsh before the first line, step by step: passwords, readiness, MDI.
//!
//! Answers are complete texts of a protocol and are compared as such; they need no pattern.

/// Meaning of an answer.
pub(super) enum Reply<'a> {
    /// Continue with this step.
    Next(usize),
    /// A message that was left there; more may follow.
    Message(&'a str),
    /// The job ends here, for this reason.
    Refusal(&'static str),
    /// Not an answer to the question.
    Other,
}

/// Answers to the steps before the first line that end the job.
const REFUSALS: &[(usize, &str, &str)] = &[
    (0, "HELLO NAK", "it does not accept the password: see start in the profile"),
    (2, "SET ENABLE NAK", "it does not accept the second password: see start in the profile"),
    (3, "ESTOP ON", "emergency stop: release it at the machine"),
    (4, "MACHINE OFF", "the machine is off: switch it on"),
    (5, "PROGRAM_STATUS RUNNING", "the control is executing something else: wait until it is idle"),
    (5, "PROGRAM_STATUS PAUSED", "the control is paused in another job: finish or abort it there"),
    (7, "SET NAK", "it knows neither set_wait nor wait_mode: check the LinuxCNC version"),
    (7, "SET WAIT_MODE NAK", "it knows neither set_wait nor wait_mode, or another client has taken over the control"),
    (8, "SET MODE NAK", "it does not switch to MDI"),
];

/// Returns the question of a step; `None` after the last step.
pub(super) fn question(step: usize, passwords: &(String, String)) -> Option<String> {
    let text = match step {
        0 => return Some(format!("hello {} ncfix 1.0", passwords.0)),
        1 => "set echo off\r\nset verbose on",
        2 => return Some(format!("set enable {}", passwords.1)),
        3 => "get estop",
        4 => "get machine",
        5 => "get program_status",
        6 => "set set_wait received",
        // Name in later versions.
        7 => "set wait_mode received",
        8 => "set mode mdi",
        // Unit of its positions.
        9 => "get user_linear_units",
        // Messages of other clients do not concern this job.
        10 => "get error",
        _ => return None,
    };
    Some(text.to_owned())
}

/// Returns the meaning of an answer to a step.
pub(super) fn answer(step: usize, answer: &str) -> Reply<'_> {
    if let Some((_, _, why)) = REFUSALS.iter().find(|(at, said, _)| (*at, *said) == (step, answer)) {
        return Reply::Refusal(why);
    }
    match (step, answer) {
        (0, _) if answer.starts_with("HELLO ACK") => Reply::Next(1),
        (1, "SET VERBOSE ACK")
        | (2, "SET ENABLE ACK")
        | (3, "ESTOP OFF")
        | (4, "MACHINE ON")
        | (5, "PROGRAM_STATUS IDLE")
        | (6, "SET NAK" | "SET SET_WAIT NAK")
        | (7, "SET WAIT_MODE ACK")
        | (8, "SET MODE ACK")
        | (10, "ERROR OK") => Reply::Next(step + 1),
        (6, "SET SET_WAIT ACK") => Reply::Next(8),
        (9, _) if answer.starts_with("USER_LINEAR_UNITS ") => Reply::Next(10),
        (10, _) if answer.starts_with("ERROR ") => Reply::Message(answer),
        _ => Reply::Other,
    }
}
