//! The first comment of a corrected program: which machine, model and source it was made for, and that it is good for nothing else.
//!
//! A corrected program is ephemeral: it holds the errors of one machine at one time. The stamp keeps it from being corrected again
//! and from being taken for the part program.

/// What stands in the stamp.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Stamp {
    /// Name of the machine.
    pub machine: String,
    /// First digits of the hash of the machine file, lower-case hexadecimal.
    pub model: String,
    /// First digits of the hash of the state of the machine, where one was given.
    pub state: Option<String>,
    /// First digits of the hash of the part program.
    pub source: String,
    /// Whether the machine is the one built in.
    pub is_demo: bool,
}

/// What every stamp begins with.
const MARK: &str = "ncfix ";
/// What every stamp holds.
const EPHEMERAL: &str = "ephemeral";
const ONLY: &str = "for this machine only";
/// A stamp stands within so many bytes of the start.
const HEAD_BYTES: usize = 4096;

impl Stamp {
    /// The text of the comment, without the sign that makes it one. Plain ASCII without the characters that end a comment in some
    /// dialect.
    #[must_use]
    pub fn text(&self) -> String {
        let machine = with_harmless(&self.machine, |c| c.is_ascii_graphic() && !"\"();".contains(c));
        let version = env!("CARGO_PKG_VERSION");
        let (model, source) = (self.model_and_state(), &self.source);
        let warning = if self.is_demo { " DEMO MACHINE: not for a real machine" } else { "" };
        format!("{MARK}{version} machine=\"{machine}\" model={model} source={source} {EPHEMERAL}: {ONLY}{warning}")
    }

    /// The same for controls that know capital letters, digits and a few signs only.
    #[must_use]
    pub fn capital_text(&self) -> String {
        let machine = with_harmless(&self.machine, |c| c.is_ascii_alphanumeric() || ".,=_-".contains(c));
        let version = env!("CARGO_PKG_VERSION");
        let (model, source) = (self.model_and_state(), &self.source);
        let warning = if self.is_demo { " - DEMO MACHINE NOT FOR A REAL MACHINE" } else { "" };
        format!("{MARK}{version} machine={machine} model={model} source={source} {EPHEMERAL} - {ONLY}{warning}")
            .to_ascii_uppercase()
    }
}

impl Stamp {
    fn model_and_state(&self) -> String {
        match &self.state {
            Some(state) => format!("{} state={state}", self.model),
            None => self.model.clone(),
        }
    }
}

fn with_harmless(text: &str, is_harmless: impl Fn(char) -> bool) -> String {
    text.chars().map(|c| if c == ' ' || is_harmless(c) { c } else { '_' }).collect()
}

/// Whether a program carries a stamp: a comment, `; …` or `( … )`, among its first lines. Line numbers, header lines and
/// line ends do not matter.
#[must_use]
pub fn is_stamped(bytes: &[u8]) -> bool {
    bytes[..bytes.len().min(HEAD_BYTES)].split(|&byte| byte == b'\n' || byte == b'\r').any(|line| {
        let Some(at) = line.iter().position(|&byte| byte == b';' || byte == b'(') else { return false };
        let comment = line[at + 1..].trim_ascii_start();
        // Some links and controls turn everything into capitals.
        let holds = |part: &[u8]| comment.windows(part.len()).any(|window| window.eq_ignore_ascii_case(part));
        comment.get(..MARK.len()).is_some_and(|start| start.eq_ignore_ascii_case(MARK.as_bytes()))
            && holds(b"machine=")
            && holds(EPHEMERAL.as_bytes())
            && holds(ONLY.as_bytes())
    })
}

/// The hash of the model in a program's stamp; `None` without a stamp.
#[must_use]
pub fn stamped_model(bytes: &[u8]) -> Option<String> {
    stamped(bytes, "model=")
}

/// The hash of the state of the machine in a program's stamp; `None` where it has none.
#[must_use]
pub fn stamped_state(bytes: &[u8]) -> Option<String> {
    stamped(bytes, "state=")
}

fn stamped(bytes: &[u8], key: &str) -> Option<String> {
    if !is_stamped(bytes) {
        return None;
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)]).to_ascii_lowercase();
    let line = head.lines().find(|line| line.contains(EPHEMERAL))?;
    let (_, rest) = line.split_once(key)?;
    Some(rest.chars().take_while(char::is_ascii_alphanumeric).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamp() -> Stamp {
        Stamp {
            machine: "mill".into(),
            model: "0123456789ab".into(),
            state: None,
            source: "ba9876543210".into(),
            is_demo: false,
        }
    }

    #[test]
    fn a_stamp_says_all_and_is_found() {
        let text = stamp().text();
        let version = env!("CARGO_PKG_VERSION");
        let expected = format!(
            "ncfix {version} machine=\"mill\" model=0123456789ab source=ba9876543210 ephemeral: for this machine only"
        );
        assert_eq!(text, expected);
        for program in [
            format!("; {text}\nG0 X0\n"),
            format!("%_N_A_MPF\r\n;$PATH=/_N_MPF_DIR\r\n;{text}\r\nG0"),
            format!("%\nO1000\nN10 ({text})\n"),
            format!("; {}", Stamp { is_demo: true, ..stamp() }.text()),
            format!("%\nO1000 (PLATE)\n({})\n", stamp().capital_text()),
            format!("%PM\nN9001 (PLATE)\nN1 ({})\n", Stamp { is_demo: true, ..stamp() }.capital_text()),
        ] {
            assert!(is_stamped(program.as_bytes()), "{program}");
        }
    }

    #[test]
    fn a_state_is_in_the_stamp() {
        let warm = Stamp { state: Some("00ff00ff00ff".into()), ..stamp() };
        for text in [warm.text(), warm.capital_text()] {
            let program = format!("; {text}\nG0 X0\n");
            assert!(is_stamped(program.as_bytes()));
            assert_eq!(stamped_model(program.as_bytes()).as_deref(), Some("0123456789ab"));
            assert_eq!(stamped_state(program.as_bytes()).as_deref(), Some("00ff00ff00ff"));
        }
        assert_eq!(stamped_state(format!("; {}\n", stamp().text()).as_bytes()), None);
    }

    #[test]
    fn other_programs_carry_none() {
        let late = format!("{}; {}\n", "G1 X1\n".repeat(1000), stamp().text());
        for program in ["", "; ncfix is a program\nG0 X0", "G0 X0", "; for ncfix 0.1 machine=", late.as_str()] {
            assert!(!is_stamped(program.as_bytes()), "{program}");
        }
    }

    #[test]
    fn a_strange_name_does_not_end_the_comment() {
        let odd = Stamp { machine: "a\"b(c)\nd;e µ".into(), ..stamp() };
        assert!(odd.text().contains("machine=\"a_b_c__d_e _\""), "{}", odd.text());
        assert!(is_stamped(format!("({})", odd.text()).as_bytes()));
    }
}
