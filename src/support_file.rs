//! Files of a control other than part programs: machine data, tools, zero offsets, definitions, screens, logs.

use std::sync::LazyLock;

use ncfix_base::pattern::{RegexSet, patterns};
use ncfix_base::source::Source;
use ncfix_language::syntax::sinumerik::{Address, Body, Definition, ExprId, Node, Program, Value, Word};

/// Words of data files that assign nothing.
const FRAMING: [&str; 9] =
    ["CHANDATA", "METRIC", "INCH", "NEWCONF", "RET", "STOPRE", "MSG", "COMPLETE_CEC", "COMPLETE_QEC"];
/// The smallest number of lines of a log.
const FEWEST_LINES: usize = 3;
/// Beginnings of the variables of each kind of file.
const KINDS: [(&[&str], &str); 6] = [
    (&["$TC_"], "tool data"),
    (&["$P_UIFR", "$P_CHB", "$P_NCB", "$P_UBFR", "$P_BFR"], "zero offsets"),
    (&["$AN_CEC", "$AA_ENC_COMP", "$AA_QEC", "$AA_CEC", "$SN_CEC"], "compensation tables"),
    (&["$SN_PA", "$MN_PA", "$SC_PA"], "protection zones"),
    (&["$M", "$S", "$O"], "machine data"),
    (&["$"], "values of system variables"),
];

/// First lines of a screen and of drive data.
static FIRST_LINES: LazyLock<RegexSet> = LazyLock::new(|| patterns([r"^//[SM][({]", r"^\[SINUMERIK_HEADER\]"]));
/// A block number, a G code, an address with a number or the end of a program at the start of a line, or a character that only blocks have.
static BLOCK: LazyLock<RegexSet> = LazyLock::new(|| patterns([r#"^(?:[NGMTSFDR][0-9]|RET(?:[^A-Z0-9]|$))|[=;("$%]"#]));
/// Two words; a word of three letters or more that continues in lower case.
static SENTENCE: LazyLock<RegexSet> = LazyLock::new(|| {
    patterns([
        r"[^ \t\n\r\x0c][ \t\n\r\x0c]+[^ \t\n\r\x0c]",
        r"(?-i)(?:^|[ \t\n\r\x0c])[^ \t\n\r\x0c][a-z\x80-\xff]{2,}[:,]?(?:[ \t\n\r\x0c]|$)",
    ])
});

/// The kind of a file that is not a program, by its name and its first lines.
pub(crate) fn kind_of_text(source: &Source) -> Option<&'static str> {
    let name = source.name().to_ascii_lowercase();
    let first =
        source.bytes().split(|&byte| byte == source.line_end()).map(<[u8]>::trim_ascii).find(|line| !line.is_empty());
    let begins = FIRST_LINES.matches(first.unwrap_or_default());
    let is_of = |mark: usize| begins.iter().any(|one| one == mark);
    if name.ends_with(".com") || is_of(0) {
        return Some("screens");
    }
    if name.ends_with(".log") || name.ends_with(".trc") || is_prose(source) {
        return Some("log");
    }
    is_of(1).then_some("drive data")
}

/// True if a file is a text that a program wrote with WRITE, whatever its name: lines of words and numbers, none of them a block.
fn is_prose(source: &Source) -> bool {
    let lines = source.bytes().split(|&byte| byte == source.line_end()).map(<[u8]>::trim_ascii);
    let (mut prose, mut other) = (0_usize, 0_usize);
    for line in lines.filter(|line| !line.is_empty()) {
        if BLOCK.is_match(line) {
            return false;
        }
        // Both of its patterns.
        if SENTENCE.matches(line).iter().count() == 2 { prose += 1 } else { other += 1 }
    }
    prose >= FEWEST_LINES && prose >= 9 * other
}

/// The kind of a parsed file that is not a program: one that has only definitions or data assignments. A large file is taken as a program.
pub(crate) fn kind(program: &Program) -> Option<&'static str> {
    if program.has_pages() {
        return None;
    }
    let mut counts = [0_usize; KINDS.len()];
    let (mut definitions, mut parameters) = (0, 0);
    for block in &program.blocks {
        match block.body {
            Body::Empty => {}
            Body::Define { start, count } => {
                let globals = program.definitions_of(start, count).iter().filter(|one| is_global(one)).count();
                if globals < usize::from(count) {
                    return None;
                }
                definitions += 1;
            }
            Body::Declaration => definitions += 1,
            Body::Words => {
                for word in program.words_of(block) {
                    match meaning(program, word)? {
                        Data::Framing => {}
                        Data::Parameter => parameters += 1,
                        Data::Variable(kind) => counts[kind] += 1,
                    }
                }
            }
            _ => return None,
        }
    }
    let most = (0..KINDS.len()).max_by_key(|&kind| counts[kind]).filter(|&kind| counts[kind] > 0);
    match (most, definitions, parameters) {
        (Some(kind), definitions, _) if counts[kind] >= definitions => Some(KINDS[kind].1),
        (_, 1.., _) => Some("definitions"),
        (_, _, 2..) => Some("R parameters"),
        _ => None,
    }
}

fn is_global(definition: &Definition) -> bool {
    definition.is_global
}

/// The kind of a word in a data file.
enum Data {
    Framing,
    Parameter,
    /// Place in [`KINDS`].
    Variable(usize),
}

fn meaning(program: &Program, word: &Word) -> Option<Data> {
    let named = |name: &str| {
        if FRAMING.contains(&name) {
            return Some(Data::Framing);
        }
        let is_of = |(starts, _): &(&[&str], &str)| starts.iter().any(|start| name.starts_with(start));
        KINDS.iter().position(is_of).map(Data::Variable)
    };
    match (word.address, word.value) {
        (Address::Letter(b'M'), Value::Number(0.0 | 1.0 | 2.0 | 17.0 | 30.0, _)) => Some(Data::Framing),
        (Address::Extended(b'R', _), _) => Some(Data::Parameter),
        (Address::Name(name), _) => named(program.names.text(name)),
        (Address::Indexed(left), _) => left_name(program, left).map_or(Some(Data::Parameter), named),
        _ => None,
    }
}

/// The name left of an assignment to an element; `None` for `R[…]`.
fn left_name(program: &Program, left: ExprId) -> Option<&str> {
    match program.expr(left).node {
        Node::Indexed(name, _) => Some(program.names.text(name)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_sentences_are_distinguished() {
        for line in ["N10 X1", "g1", "R5", "RET", "RET X", "abc def; remark", "a=1", "%MPF", "f(1)"] {
            assert!(BLOCK.is_match(line.as_bytes()), "{line}");
        }
        for line in ["RETURN to the start", "Number 5", "N axis", "the tool 12 is worn", "d"] {
            assert!(!BLOCK.is_match(line.as_bytes()), "{line}");
        }
        let is_sentence = |line: &str| SENTENCE.matches(line.as_bytes()).iter().count() == 2;
        for line in ["Tool broken", "12.5 Länge", "X axis: ready", "is Ready, done"] {
            assert!(is_sentence(line), "{line}");
        }
        for line in ["ready", "X 12 Y 5", "AN ID 12", "CamelCase X", "ab cd", "ready:: X"] {
            assert!(!is_sentence(line), "{line}");
        }
    }

    #[test]
    fn first_lines_name_screens_and_drive_data() {
        let kind = |text: &str| {
            let source = Source::new(ncfix_base::source::FileId(0), "a.txt", text.as_bytes().to_vec()).unwrap();
            kind_of_text(&source)
        };
        for (text, expected) in [
            ("\n//s(Start)\n", Some("screens")),
            ("//M{Mask}", Some("screens")),
            ("//X(Mask)", None),
            ("  [Sinumerik_Header]\n", Some("drive data")),
            ("[HEADER]", None),
            ("", None),
        ] {
            assert_eq!(kind(text), expected, "{text}");
        }
    }
}
