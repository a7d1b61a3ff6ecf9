//! Files that a control keeps beside part programs: machine data, tools, zero offsets, definitions, screens, logs.

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

/// The kind of a file that is not a program, by its name and its first lines.
pub(crate) fn kind_of_text(source: &Source) -> Option<&'static str> {
    let name = source.name().to_ascii_lowercase();
    let first =
        source.bytes().split(|&byte| byte == source.line_end()).map(<[u8]>::trim_ascii).find(|line| !line.is_empty());
    let begins = |start: &[u8]| {
        first.is_some_and(|line| line.len() >= start.len() && line[..start.len()].eq_ignore_ascii_case(start))
    };
    if name.ends_with(".com") || begins(b"//S(") || begins(b"//M(") || begins(b"//M{") || begins(b"//S{") {
        return Some("screens");
    }
    if name.ends_with(".log") || name.ends_with(".trc") || is_prose(source) {
        return Some("log");
    }
    begins(b"[SINUMERIK_HEADER]").then_some("drive data")
}

/// True if a file is a text that a program wrote with WRITE, whatever its name: lines of words and numbers, none of them a block.
fn is_prose(source: &Source) -> bool {
    let lines = source.bytes().split(|&byte| byte == source.line_end()).map(<[u8]>::trim_ascii);
    let (mut prose, mut other) = (0_usize, 0_usize);
    for line in lines.filter(|line| !line.is_empty()) {
        if is_block(line) {
            return false;
        }
        if is_sentence(line) { prose += 1 } else { other += 1 }
    }
    prose >= FEWEST_LINES && prose >= 9 * other
}

/// True if a line has a character that only blocks have, or begins with a block number, a G code or a program end.
fn is_block(line: &[u8]) -> bool {
    let word: Vec<u8> =
        line.iter().take_while(|byte| byte.is_ascii_alphanumeric()).map(u8::to_ascii_uppercase).collect();
    let numbered = matches!(word.as_slice(), [b'N' | b'G' | b'M' | b'T' | b'S' | b'F' | b'D' | b'R', rest @ ..] if rest.first().is_some_and(u8::is_ascii_digit));
    numbered || word == b"RET" || line.iter().any(|byte| b"=;(\"$%".contains(byte))
}

/// True if a line has several words, one of them in lower case.
fn is_sentence(line: &[u8]) -> bool {
    let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let is_small = |word: &[u8]| {
        let letters = word.strip_suffix(b":").or(word.strip_suffix(b",")).unwrap_or(word);
        letters.len() >= 3 && letters[1..].iter().all(|byte| byte.is_ascii_lowercase() || !byte.is_ascii())
    };
    words.clone().count() >= 2 && words.any(is_small)
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
