//! Lines for the firmware of hobby machines in the files of their senders: commands of Grbl and TinyG, which are no blocks, and the reference motion of Marlin.

/// The message for a line that is a command of firmware.
pub(crate) const COMMAND: &str = "this is a command for the firmware of the machine, not a block of a program";

const REMOVE: &str =
    "remove the line: ncfix does not know what it sets or moves; send such commands before the program";
const REFERENCE: &str = "only the firmware Marlin takes letters without numbers after G28; here the axes are named by G91 G28 X0 Y0, with G90 after it";

/// True for a line such as `$H`, `$$`, `$110=500` or `{"sr":""}`. A spindle of LinuxCNC, `$1`, is no command.
pub(crate) fn is_command(line: &[u8]) -> bool {
    let behind = match line {
        [b'{', rest @ ..] => return rest.trim_ascii_start().starts_with(b"\"") || rest.contains(&b':'),
        [b'$', rest @ ..] => rest,
        _ => return false,
    };
    let word = behind.split(|&byte| matches!(byte, b'(' | b';')).next().unwrap_or_default().trim_ascii();
    let digits = word.iter().take_while(|byte| byte.is_ascii_digit()).count();
    match word.get(digits..).unwrap_or_default() {
        [] => digits == 0,
        [b'=', ..] => digits > 0,
        [b'$' | b'#'] => digits == 0,
        // `$ABS[…]` is an expression.
        [first, ..] => digits == 0 && first.is_ascii_alphabetic() && !word.contains(&b'['),
    }
}

/// The help for an error at `at` in a text whose line ends at `end`, if the line is for firmware.
pub(crate) fn help_in(text: &[u8], at: usize, end: usize) -> Option<&'static str> {
    let first = text.get(..at)?.iter().rposition(|&byte| matches!(byte, b'\n' | b'\r')).map_or(0, |place| place + 1);
    let line = text.get(first..end)?;
    if is_command(text.get(at..end)?) {
        return Some(REMOVE);
    }
    let (before, behind) = line.split_at_checked(at - first)?;
    let is_reference = before.trim_ascii().to_ascii_uppercase().split(|&byte| byte == b' ').any(|word| word == b"G28");
    let is_bare = matches!(behind, [b'X' | b'Y' | b'Z' | b'x' | b'y' | b'z', rest @ ..]
        if rest.first().is_none_or(|byte| matches!(byte, b' ' | b'\t' | b';' | b'(')));
    (is_reference && is_bare).then_some(REFERENCE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_of_firmware_are_no_blocks() {
        for line in
            ["$", "$$", "$# ; offsets", "$H", "$x", "$J=G91X1F100", "$110=500.0", "$RST=$", "{\"sr\":\"\"}", "{sr:n}"]
        {
            assert!(is_command(line.as_bytes()), "{line}");
        }
        for line in ["$1", "$0 S100", "$ABS[1]", "$[#1]", "G0 X1", "", "{BEGIN}", "X$H"] {
            assert!(!is_command(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn a_letter_without_a_number_after_g28_is_of_marlin() {
        let help = |line: &str, at: usize| help_in(line.as_bytes(), at, line.len());
        assert_eq!(help("G28 X", 4), Some(REFERENCE));
        assert_eq!(help("G0 Z5\nn5 g28 x y ; home", 13), Some(REFERENCE));
        assert_eq!(help("G28 X1 Y", 7), Some(REFERENCE));
        assert_eq!(help("G0 X", 3), None);
        assert_eq!(help("G28 XA", 4), None);
        assert_eq!(help("$H", 0), Some(REMOVE));
        assert_eq!(help("", 9), None);
    }
}
