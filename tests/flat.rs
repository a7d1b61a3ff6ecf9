//! Flat move lists in the notation of a reference: `G3/18 X27.3205 Y20 Z20 I-10 K-17.3205`, four decimals, words that are 0 may be left
//! out, moves without length do not appear.
use ncfix_base::geometry::{AXES, AxisVector};
use ncfix_base::source::{FileId, Source};
use ncfix_language::exec::{Execution, NoLibrary, Options};
use ncfix_language::syntax;
use ncfix_machine::machine::Machine;
use ncfix_machine::snc::{Element, Kind, Move};

/// Half a unit of the last decimal, and a little.
const SAME: f64 = 5.1e-5;

/// Elements and codes of findings (`E0201:line`) of a program.
pub(crate) fn execute(text: &str, machine: &Machine, options: Options) -> (Vec<Element>, Vec<String>) {
    let source = Source::new(FileId(0), "test.mpf", text.as_bytes().to_vec()).unwrap();
    let (program, findings) = syntax::parse(&source, ncfix_dialect::sinumerik());
    let shown = |found: &ncfix_base::diagnostic::Diagnostic| {
        format!("{}:{}", found.code, source.line_column(found.place.unwrap().span.start).0)
    };
    let mut codes: Vec<String> = findings.iter().map(shown).collect();
    let mut elements = Vec::new();
    for item in Execution::new(program, machine, Box::new(NoLibrary), options) {
        match item {
            Ok(element) => elements.push(element),
            Err(found) => codes.push(shown(&found)),
        }
    }
    (elements, codes)
}

/// The moves of a program with the tool vector added to their targets, each with its start.
pub(crate) fn moves(elements: &[Element], start: AxisVector) -> Vec<(AxisVector, Move)> {
    let (mut position, mut tool) = (start, ncfix_base::geometry::Vector::zeros());
    let mut out = Vec::new();
    for element in elements {
        match &element.kind {
            Kind::Setup(setup) => tool = setup.tool_mm,
            Kind::Move(motion) => {
                let mut motion = *motion;
                motion.target.set_xyz(motion.target.xyz() + tool);
                out.push((position, motion));
                position = motion.target;
            }
            _ => {}
        }
    }
    out
}

/// The code and the words of one expected line.
fn parse(line: &str) -> (String, Vec<(u8, f64)>) {
    let line = line.split(';').next().unwrap();
    let mut words = line.split_whitespace();
    let code = words.next().unwrap().to_owned();
    (code, words.map(|word| (word.as_bytes()[0], word[1..].parse().unwrap())).collect())
}

fn code_of(motion: &Move) -> String {
    match &motion.arc {
        None => format!("G{}", u8::from(!motion.rapid)),
        Some(arc) => format!("G{}/{}", if arc.clockwise { 2 } else { 3 }, arc.plane.number()),
    }
}

/// Checks the moves of a program that runs without findings from a start position (mm).
#[track_caller]
pub(crate) fn check_from(start: [f64; 3], text: &str, machine: &Machine, expected: &str) {
    let mut position = AxisVector::ZERO;
    position.0[..3].copy_from_slice(&start);
    let options = Options { start: Some(position), ..Options::default() };
    let (elements, codes) = execute(text, machine, options);
    assert!(codes.is_empty(), "{codes:?}");
    let moves: Vec<_> = moves(&elements, position)
        .into_iter()
        .filter(|(start, motion)| motion.arc.is_some() || (motion.target - *start).max_abs(&AXES) > 1e-9)
        .collect();
    let shown: Vec<String> =
        moves.iter().map(|(_, motion)| format!("{} {:?}", code_of(motion), motion.target.0)).collect();
    let expected: Vec<_> = expected.lines().map(str::trim).filter(|line| !line.is_empty()).map(parse).collect();
    assert_eq!(moves.len(), expected.len(), "{shown:#?}");
    for ((start, motion), (code, words)) in moves.iter().zip(&expected) {
        assert_eq!(code_of(motion), *code, "{shown:#?}");
        let center = motion.arc.map_or_else(ncfix_base::geometry::Vector::zeros, |arc| arc.center_from_start_mm(start));
        for letter in *b"XYZABCIJKFL" {
            let wanted = words.iter().find(|(known, _)| *known == letter).map(|(_, value)| *value);
            let found = match letter {
                b'I' | b'J' | b'K' => center[usize::from(letter - b'I')],
                b'F' if wanted.is_none() => 0.0,
                b'F' => motion.feed,
                b'L' => motion.arc.map_or(0.0, |arc| f64::from(arc.extra_turns)),
                _ => {
                    let axis = ncfix_base::geometry::Axis::from_letter(letter).unwrap();
                    let value = motion.target[axis];
                    if axis.is_rotary() { value.to_degrees() } else { value }
                }
            };
            let wanted = wanted.unwrap_or(0.0);
            assert!((found - wanted).abs() < SAME, "{code} {}{found} is not {wanted}: {shown:#?}", char::from(letter));
        }
    }
}

/// The same from the axis zero.
#[track_caller]
pub(crate) fn check(text: &str, machine: &Machine, expected: &str) {
    check_from([0.0; 3], text, machine, expected);
}
