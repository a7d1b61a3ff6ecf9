//! Data of telegrams: states of the control, positions, block length, refusals.

use super::super::answers::shown;
use super::telegram::Telegram;

/// Numbers of `R_RI` for the questions that are asked here.
pub(super) const POSITION: u16 = 22;
pub(super) const MODE: u16 = 23;
pub(super) const SELECTED: u16 = 24;
pub(super) const STATUS: u16 = 26;

/// Maximum number of axes in a position.
const MOST_AXES: usize = 32;
/// Place of the block length in the system parameters (`S_PR`), and their possible lengths, bytes.
const BLOCK_LENGTH_AT: usize = 98;
const PARAMETERS: [usize; 2] = [120, 124];

/// State of the selected program (`R_RI` 26).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ProgramState {
    Started,
    Stopped,
    Finished,
    Cancelled,
    Interrupted,
    Error,
    ErrorCleared,
    Idle,
    Undefined,
}

impl ProgramState {
    pub(super) fn read(data: &[u8]) -> Option<ProgramState> {
        use ProgramState::{Cancelled, Error, ErrorCleared, Finished, Idle, Interrupted, Started, Stopped, Undefined};
        let all = [Started, Stopped, Finished, Cancelled, Interrupted, Error, ErrorCleared, Idle, Undefined];
        all.get(usize::from(word(data)?)).copied()
    }

    /// True if no program is under way.
    pub(super) fn is_at_rest(self) -> bool {
        matches!(self, Self::Finished | Self::Cancelled | Self::ErrorCleared | Self::Idle)
    }

    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Started => "a program runs",
            Self::Stopped => "a program is stopped",
            Self::Finished => "the program has finished",
            Self::Cancelled => "the program was cancelled",
            Self::Interrupted => "a program is interrupted",
            Self::Error => "a program has an error",
            Self::ErrorCleared => "the error of the program was cleared",
            Self::Idle => "idle",
            Self::Undefined => "undefined",
        }
    }
}

/// Operating mode (`R_RI` 23): its words, and the reason why nothing is sent in it.
pub(super) fn mode(data: &[u8]) -> Option<(&'static str, Option<&'static str>)> {
    Some(match word(data)? {
        0 => ("manual", None),
        1 => ("MDI", None),
        2 => ("reference points", Some("its axes have not passed their reference points: finish that there")),
        3 => ("single block", None),
        4 => ("automatic", None),
        5 => ("undefined", Some("it reports no operating mode: choose one there")),
        _ => return None,
    })
}

/// Program under way (`R_RI` 24).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct SelectedProgram {
    pub(super) line: u32,
    pub(super) main: String,
    pub(super) current: String,
}

impl SelectedProgram {
    pub(super) fn read(data: &[u8]) -> Option<SelectedProgram> {
        let (line, names) = data.split_at_checked(4)?;
        let line = u32::from_be_bytes(line.try_into().ok()?);
        let mut names = names.split(|byte| *byte == 0).map(latin);
        let (main, current) = (names.next()?, names.next()?);
        Some(SelectedProgram { line, main, current })
    }

    /// True if the main program is the file at this path; `/` and `\`, capitals and small letters are the same.
    pub(super) fn is(&self, path: &str) -> bool {
        let plain = |text: &str| text.trim().replace('/', "\\").to_ascii_uppercase();
        plain(&self.main) == plain(path)
    }
}

/// Positions by axis (`R_RI` 22), as text: a byte of unknown meaning, the number of axes, their values, their names, each text with a zero at its end.
pub(super) fn position(data: &[u8]) -> Option<Vec<(String, String)>> {
    let count = usize::from(*data.get(1)?);
    let texts = data.get(2..)?;
    let texts = texts.strip_suffix(&[0])?;
    let all: Vec<String> = texts.split(|byte| *byte == 0).map(latin).collect();
    if count == 0 || count > MOST_AXES || all.len() != 2 * count {
        return None;
    }
    let (values, names) = all.split_at(count);
    let is_number = |text: &String| text.trim().parse::<f64>().is_ok_and(f64::is_finite);
    let is_name = |text: &String| !text.trim().is_empty() && text.trim().len() <= 8;
    if !values.iter().all(is_number) || !names.iter().all(is_name) {
        return None;
    }
    let pair = |(name, value): (&String, &String)| (name.trim().to_owned(), value.trim().to_owned());
    Some(names.iter().zip(values).map(pair).collect())
}

/// Difference of two positions that counts as motion, mm or degrees: more than the noise of an axis at rest.
const MOTION: f64 = 0.005;

/// True if an axis has moved between two positions, or the axes are others.
pub(super) fn has_moved(before: &[(String, String)], after: &[(String, String)]) -> bool {
    let value = |text: &str| text.parse::<f64>().unwrap_or(f64::NAN);
    let is_equal = |((axis, from), (other, to)): (&(String, String), &(String, String))| {
        axis == other && (value(from) - value(to)).abs() <= MOTION
    };
    before.len() != after.len() || !before.iter().zip(after).all(is_equal)
}

/// Maximum length of a telegram, from the system parameters.
pub(super) fn block_length(data: &[u8]) -> Option<usize> {
    let bytes = data.get(BLOCK_LENGTH_AT..BLOCK_LENGTH_AT + 2)?;
    PARAMETERS.contains(&data.len()).then(|| word(bytes).map(usize::from))?
}

/// Type and software of the control, from its version (`S_VR`).
pub(super) fn version(data: &[u8]) -> String {
    let parts: Vec<String> = data.split(|byte| *byte == 0).map(latin).filter(|part| !part.trim().is_empty()).collect();
    parts.join(", ")
}

/// TelegramRefusal of a control (`T_ER`, `T_BD`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TelegramRefusal {
    class: u8,
    pub(super) number: u8,
}

/// Error of `R_FI` for a file that does not exist.
pub(super) const NO_FILE: u8 = 32;

impl TelegramRefusal {
    /// Reads a refusal; `None` if the telegram is another one, or its data are neither two bytes nor empty.
    pub(super) fn read(telegram: &Telegram) -> Option<TelegramRefusal> {
        if ![b"T_ER", b"T_BD"].contains(&&telegram.name) {
            return None;
        }
        match telegram.data[..] {
            [class, number] => Some(TelegramRefusal { class, number }),
            [] => Some(TelegramRefusal { class: 0, number: 0 }),
            _ => None,
        }
    }

    /// Describes it for people.
    pub(super) fn words(self) -> String {
        let what = match self.number {
            20 => "bad format of the telegram",
            21 => "telegram not expected now",
            22 => "unknown telegram",
            23 => "no right to do this, or an option is missing",
            24 | 50 => "wrong parameter",
            25 => "cancelled at the control",
            31 => "bad file name",
            32 => "no such file",
            33 | 45 => "the file cannot be opened",
            34 => "the file exists",
            35 => "this type of file is not allowed",
            36 => "the file cannot be deleted; it may be in use",
            37 => "the file cannot be created",
            46 => "wrong DNC status",
            49 => "login refused",
            53 | 101 => "no free space",
            55 => "no such folder",
            56 => "not possible in this operating mode",
            59 => "write protected",
            60 => "a program runs",
            61 => "reference points are missing",
            80 => "too many connections",
            90 | 91 => "busy",
            100 => "the file cannot be created",
            102 => "the file is not allowed",
            103 => "bad format of the file",
            104 => "bad block",
            105 => "end of the program in the middle of the file",
            111 => "transfer cancelled",
            _ => "an error without a published meaning",
        };
        format!("{what} (error {} of class {})", self.number, self.class)
    }
}

/// Reads a word, the most significant byte first.
fn word(data: &[u8]) -> Option<u16> {
    Some(u16::from_be_bytes(data.try_into().ok()?))
}

/// Text of ISO 8859-1 for display.
fn latin(bytes: &[u8]) -> String {
    let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    shown(&text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_those_of_the_published_list() {
        for (number, state) in [(0, ProgramState::Started), (2, ProgramState::Finished), (7, ProgramState::Idle)] {
            assert_eq!(ProgramState::read(&[0, number]), Some(state));
        }
        for data in [&[0, 9][..], &[1, 0], &[0], &[0, 0, 0]] {
            assert_eq!(ProgramState::read(data), None);
        }
        assert!(mode(&[0, 4]).is_some_and(|(_, why)| why.is_none()) && mode(&[0, 6]).is_none());
        assert!(mode(&[0, 2]).is_some_and(|(_, why)| why.is_some()));
    }

    #[test]
    fn a_position_has_as_many_names_as_values() {
        let found = position(b"\0\x02+1.5\0-20\0X\0Z\0").unwrap();
        assert_eq!(found, [("X".into(), "+1.5".into()), ("Z".into(), "-20".into())]);
        let at = |x: &str| [("X".to_owned(), x.to_owned())];
        assert!(!has_moved(&at("1.000"), &at("+1.004")) && has_moved(&at("1.000"), &at("1.006")));
        assert!(has_moved(&at("1.000"), &[]));
        for data in [
            &b""[..],
            b"\0",
            b"\0\x00",
            b"\0\x02+1.5\0-20\0X\0",
            b"\0\x01X\0+1\0",
            b"\0\x01nan\0X\0",
            b"\0\x01+1\0X",
            b"\0\xff+1\0X\0",
        ] {
            assert_eq!(position(data), None, "{data:?}");
        }
    }

    #[test]
    fn a_selected_program_has_a_line_and_two_names() {
        let found = SelectedProgram::read(b"\0\0\x01\x02TNC:\\A.PM\0TNC:\\B.PM\0").unwrap();
        assert_eq!((found.line, found.current.as_str()), (258, "TNC:\\B.PM"));
        assert!(found.is("tnc:/a.pm") && !found.is("TNC:\\B.PM"));
        assert!(SelectedProgram::read(b"\0\0\0").is_none() && SelectedProgram::read(b"\0\0\0\0A").is_none());
    }

    #[test]
    fn the_block_length_is_a_word_within_the_parameters() {
        let mut data = vec![0; 120];
        data[98] = 0x10;
        assert_eq!(block_length(&data), Some(4096));
        assert_eq!(block_length(&data[..119]), None);
    }
}
