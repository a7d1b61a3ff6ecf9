//! The parser of the word languages: what stands in the tree, and which findings a faulty line gives.
use ncfix_base::source::{FileId, Source};
use ncfix_language::syntax::words::{self, Address, Block, Body, ExprId, Label, Node, PartKind, Program, Value, Word};

/// A program and the codes of its findings.
fn parse(dialect: &str, text: impl AsRef<[u8]>) -> (Program, Vec<String>) {
    let source = Source::new(FileId(0), "a", text.as_ref().to_vec()).unwrap();
    let (program, findings) = words::parse(&source, ncfix_dialect::find(dialect).unwrap());
    (program, findings.iter().map(|finding| finding.code.to_string()).collect())
}

/// A program without findings.
#[track_caller]
fn clean(dialect: &str, text: impl AsRef<[u8]>) -> Program {
    let (program, findings) = parse(dialect, &text);
    assert_eq!(findings, [""; 0], "{}", String::from_utf8_lossy(text.as_ref()));
    program
}

/// An expression with all its brackets, so that precedence shows.
fn shown(program: &Program, id: ExprId) -> String {
    match program.expr(id).node {
        Node::Number(value) => format!("{value}"),
        Node::Parameter(number) => format!("#{number}"),
        Node::ParameterAt(inner) => format!("#[{}]", shown(program, inner)),
        Node::Named(name) => format!("#<{}>", program.names.text(name)),
        Node::Call(function, first, second) => {
            let second = second.map_or(String::new(), |second| format!(",{}", shown(program, second)));
            format!("{function:?}({}{second})", shown(program, first))
        }
        Node::Unary(operator, inner) => format!("{operator:?}({})", shown(program, inner)),
        Node::Binary(operator, left, right) => {
            format!("({} {operator:?} {})", shown(program, left), shown(program, right))
        }
    }
}

fn shown_word(program: &Program, word: &Word) -> String {
    let address = match word.address {
        Address::Letter(letter) => char::from(letter).to_string(),
        Address::Indexed(letter, index) => format!("{}{index}=", char::from(letter)),
        Address::Comma(letter) => format!(",{}", char::from(letter)),
        Address::Variable(id) => format!("{}=", shown(program, id)),
        Address::Name(name) => format!("<{}>", program.names.text(name)),
    };
    let value = match word.value {
        Value::None => String::new(),
        Value::Number { value, has_point, .. } => format!("{value}{}", if has_point { "." } else { "" }),
        Value::Expr(id) => shown(program, id),
    };
    address + &value
}

fn shown_words(program: &Program, block: &Block) -> String {
    program.words_of(block).iter().map(|word| shown_word(program, word)).collect::<Vec<_>>().join(" ")
}

/// The words of the first block of a program without findings.
#[track_caller]
fn first(dialect: &str, text: &str) -> String {
    let program = clean(dialect, text);
    shown_words(&program, &program.blocks[0])
}

#[test]
fn plain_words_need_no_blanks_and_blanks_mean_nothing_in_iso() {
    for text in ["N10G01X10.Y-.5F100", "n10 g 0 1 x 1 0 . y - . 5 f1 00", "N10 G01 X+10. Y-0.5F100."] {
        for dialect in ["fanuc", "rs274"] {
            let program = clean(dialect, text);
            let block = &program.blocks[0];
            assert_eq!(block.number, Some(10));
            let shown = shown_words(&program, block).replace("100.", "100");
            assert_eq!(shown, "G1 X10. Y-0.5. F100", "{text}");
        }
    }
    assert_eq!(first("rs274", "g0x +0. 12 34y 7"), "G0 X0.1234. Y7");
}

#[test]
fn digits_and_points_are_kept_for_what_depends_on_them() {
    let program = clean("fanuc", "M98 P00051002 X10. Y5 Q.5");
    let numbers: Vec<_> = program.words.iter().map(|word| word.value).collect();
    assert_eq!(numbers[1], Value::Number { value: 51002.0, has_point: false, digits: 8 });
    assert_eq!(numbers[2], Value::Number { value: 10.0, has_point: true, digits: 2 });
    assert_eq!(numbers[4], Value::Number { value: 0.5, has_point: true, digits: 0 });
}

#[test]
fn grundig_addresses_have_indices_and_expressions_behind_an_equals_sign() {
    assert_eq!(
        first("grundig", "N5 G1 X=E1+3 Y1=5 B1=-45.5 F=E1 N1=54.01 L1=E2*(E3-1) X10"),
        "G1 X(#1 Add 3) Y1=5 B1=-45.5. F#1 N1=54.01. L1=(#2 Multiply (#3 Subtract 1)) X10"
    );
    assert_eq!(first("grundig", "N1=8001 N2=8011 G13"), "N1=8001 N2=8011 G13");
    assert_eq!(first("grundig", "N7 G29 E3=E1>E2 E3 N=100"), "G29 E3=(#1 Greater #2) E3 N100");
    assert_eq!(first("grundig", "N7 E0=E1=5"), "E0=(#1 Equal 5)");
    assert_eq!(first("grundig", "N7 G79 P1 P2 P3 P4 I+1"), "G79 P1 P2 P3 P4 I1");
    assert_eq!(first("grundig", "N7 G22 N=9101 E1=10 E2=3"), "G22 N9101 E1=10 E2=3");
    assert_eq!(first("grundig", "N7 X1 X1=1"), "X1 X1=1");
}

#[test]
fn precedence_is_the_one_of_the_language() {
    for (text, expected) in [
        ("X=1+2*3", "(1 Add (2 Multiply 3))"),
        ("X=E90-((E90-E93):2)", "(#90 Subtract ((#90 Subtract #93) Divide 2))"),
        ("X=E2^2:10", "((#2 Power 2) Divide 10)"),
        ("X=-E1^2", "Minus((#1 Power 2))"),
        ("X=E1+1>E2*2", "((#1 Add 1) Greater (#2 Multiply 2))"),
        ("X=sin(30)+COS(E1)*pi", "(Sin(30) Add (Cos(#1) Multiply 3.141592653589793))"),
        ("X=atan(E1:E2)", "Atan((#1 Divide #2))"),
        ("X=E1>0 and E2>0", "((#1 Greater 0) And (#2 Greater 0))"),
        ("X=not(E1)", "Not(#1)"),
        ("X=exp(1)-E(E5)", "(Exp(1) Subtract #[#5])"),
    ] {
        assert_eq!(first("grundig", text), format!("X{expected}"), "{text}");
    }
    for (text, expected) in [
        ("X[1+2*3]", "(1 Add (2 Multiply 3))"),
        ("X[#1 OR #2 AND #3]", "(#1 Or (#2 And #3))"),
        ("X[#1+1 EQ #2*2]", "((#1 Add 1) Equal (#2 Multiply 2))"),
        ("X[[#1 EQ 10] AND [#2 EQ #0]]", "((#1 Equal 10) And (#2 Equal #0))"),
        ("X[#100*COS[#2]]", "(#100 Multiply Cos(#2))"),
        ("X[ATAN[#1]/[#2]*2]", "(Atan(#1,#2) Multiply 2)"),
        ("X[ATAN[1,-1]]", "Atan(1,Minus(1))"),
        ("X[FI[#1]+RO[2]]", "(Fix(#1) Add Round(2))"),
        ("X[POW[2,3]]", "Pow(2,3)"),
        ("X-#1", "Minus(#1)"),
        ("X-[#1]", "Minus(#1)"),
        ("X#[#1+2]", "#[(#1 Add 2)]"),
        ("X##1", "#[#1]"),
        ("X[7MOD3]", "(7 Mod 3)"),
    ] {
        assert_eq!(first("fanuc", text), format!("X{expected}"), "{text}");
    }
    for (text, expected) in [
        ("x[2**3*4]", "((2 Power 3) Multiply 4)"),
        ("x[2 * 3 ** 2]", "(2 Multiply (3 Power 2))"),
        ("x[#1 gt 1 and #2 lt 2]", "((#1 Greater 1) And (#2 Less 2))"),
        ("x[-#1 ** 2]", "(Minus(#1) Power 2)"),
        ("xsin[30]", "Sin(30)"),
        ("x-sin[30]", "Minus(Sin(30))"),
        ("x#<My Name>", "#<MYNAME>"),
        ("x#<_global>", "#<_GLOBAL>"),
        ("x[exists[#<a>]+exists[##2]]", "(Exists(#<A>) Add Exists(#[#2]))"),
        ("x#atan[1]/[1]", "#[Atan(1,1)]"),
        ("x--5", "Minus(Minus(5))"),
    ] {
        assert_eq!(first("rs274", text), format!("X{expected}"), "{text}");
    }
}

#[test]
fn assignments_are_words_in_their_order() {
    assert_eq!(first("rs274", "#1=2 #<a>=[#1+1] g1 x#1"), "#1=2 #<A>=(#1 Add 1) G1 X#1");
    assert_eq!(first("fanuc", "N1 #100=#101+1 #[#1]=5"), "#100=(#101 Add 1) #[#1]=5");
}

#[test]
fn corners_and_names_of_fanuc() {
    assert_eq!(first("fanuc", "G01 X50. ,R10. F200"), "G1 X50. ,R10. F200");
    assert_eq!(first("fanuc", "X1,C5 , A45."), "X1 ,C5 ,A45.");
    assert_eq!(first("fanuc", "M98 <SUB1> L2"), "M98 <SUB1> L2");
}

#[test]
fn skips_at_the_start_and_within() {
    let program = clean("fanuc", "/N10 G1\n/2 N20 X1\nN30 /3 X2\nN40 X3 /4 Y5 Z6");
    let skips: Vec<_> = program.blocks.iter().map(|block| block.skip).collect();
    assert_eq!(skips, [Some(0), Some(2), Some(3), None]);
    let last = &program.blocks[3];
    let inner = last.inner_skip.unwrap();
    assert_eq!((inner.level, inner.words_before), (4, 1));
    assert_eq!(program.words_before_skip(last).len(), 1);
    assert_eq!(program.words_of(last).len(), 3);
}

#[test]
fn programs_of_a_tape() {
    let text =
        "LEADER\n%\nO0001 (MAIN)\nN10 G65 P9100\nM30\nO9100\nM99\n:0200\nX1\n<NAME>(TEXT)\nM99\n%\ntrailer ???\n";
    let program = clean("fanuc", text);
    let numbers: Vec<_> = program.parts.iter().map(|part| part.number).collect();
    assert_eq!(numbers, [Some(1), Some(9100), Some(200), None]);
    assert_eq!(program.source.slice(program.parts[0].title.unwrap()), b"MAIN");
    assert_eq!(program.parts[3].name, program.names.find("NAME"));
    assert_eq!(program.blocks.len(), 5);
    assert_eq!(program.blocks[0].line, 4);
    assert!(program.has_tape_marks);
    assert_eq!(program.find_part(PartKind::Program, 9100), Some(1));
    assert_eq!(program.part_of(4), Some(3));
    for text in ["%O1\nX1\n%", "O1\nX1\n%", "%\nO1\nX1", "%1\nX1\n%\n", ":1\nX1", "%\n%\nO1 X1\n%"] {
        let program = clean("fanuc", text);
        assert_eq!(program.parts.len(), 1, "{text}");
        assert_eq!((program.parts[0].number, program.blocks.len()), (Some(1), 1), "{text}");
    }
    let program = clean("rs274", "%\ng0 x1\n%\n???\n");
    assert_eq!(program.blocks.len(), 1);
    let program = clean("rs274", "o<a> sub\n(debug, a)\no<a> endsub\nm2\n%\n%\n");
    assert_eq!(program.blocks.len(), 4);
    let program = clean("rs274", "%\nO<My Program>\ng0 x1\nn20 %");
    assert_eq!(program.parts[0].name, program.names.find("MYPROGRAM"));
    let program = clean("rs274", "g0 x1\nm2\nThis is no block\nnor ? this");
    assert_eq!(program.blocks.len(), 4);
    let program = clean("rs274", "g0 x1\no100 (fanuc style)\nx2\nm99\n");
    assert_eq!(program.parts.len(), 2);
    assert_eq!(program.parts[1].number, Some(100));
}

#[test]
fn memories_of_the_grundig() {
    for text in [
        "%PM\nN9001\nN1 G0 X1\n",
        "%PM9001\nN9001 (ARCS)\nN1 G0 X1\n",
        "%PM N9001\nN1 G0 X1",
        "N9001 (ARCS)\nN1 G0 X1",
        "%PM\r\n\r\nN9001 (PHILIPS)\r\n\r\nN1 G0 X1\r\n\x04",
        "\0\0%PM9001\nN1 G0 X1\n\x03",
        "% pm 9001\nN1 G0 X1\n%\n",
        "%PM9001 (ARCS)\nN1 G0 X1\x1a",
    ] {
        let program = clean("grundig", text);
        assert_eq!(program.parts.len(), 1, "{text}");
        let part = &program.parts[0];
        assert_eq!((part.kind, part.number, part.blocks.clone()), (PartKind::Program, Some(9001), 0..1), "{text}");
        assert_eq!(program.blocks[0].number, Some(1), "{text}");
    }
    let program =
        clean("grundig", "%PM9001\nN9001\nN1 G22 N=9101\nN2\n%MM9101\nN9101\nN1 X1\n%TM\nT1 L100 R5 L4=0.1\n");
    let parts: Vec<_> = program.parts.iter().map(|part| (part.kind, part.number, part.blocks.clone())).collect();
    assert_eq!(
        parts,
        [(PartKind::Program, Some(9001), 0..2), (PartKind::Macro, Some(9101), 2..3), (PartKind::Tools, None, 3..4)]
    );
    assert_eq!(program.blocks[1].body, Body::Empty);
    assert_eq!(program.find_block(1, 1, 0), Some(2));
}

#[test]
fn jump_targets_are_searched_forward_then_from_the_start() {
    let program = clean("fanuc", "O1\nN10 X1\nN0020 X2\nN10 X3\nX4\nN20 X5\nO2\nN10 X6");
    assert_eq!(program.find_block(0, 10, 0), Some(2));
    assert_eq!(program.find_block(0, 10, 2), Some(0));
    assert_eq!(program.find_block(0, 20, 1), Some(4));
    assert_eq!(program.find_block(0, 30, 1), None);
    assert_eq!(program.find_block(1, 10, 5), Some(5));
    assert_eq!(program.find_block(2, 10, 5), None);
}

#[test]
fn macro_statements() {
    let text = "IF [#1 EQ #0] GOTO 50\nIF[#1NE1]THEN#3=30\nGOTO#1\nWHILE[#1LT3]DO1\nDO2\nEND2\nEND1\nDPRNT[X#1[53]]\n\
                IF [#1 GT 2] THEN\nELSE\nENDIF";
    let program = clean("fanuc", text);
    let bodies: Vec<_> = program.blocks.iter().map(|block| (block.body, block.partner())).collect();
    assert!(matches!(bodies[0].0, Body::IfGoto { .. }));
    assert!(matches!(bodies[1].0, Body::IfThen(_)));
    assert_eq!(shown_words(&program, &program.blocks[1]), "#3=30");
    assert!(matches!(bodies[2].0, Body::Goto(_)));
    assert!(matches!(bodies[3], (Body::While(Some(_)), Some(6))));
    assert!(matches!(bodies[4], (Body::While(None), Some(5))));
    assert_eq!(bodies[5], (Body::EndWhile, Some(4)));
    assert_eq!(bodies[6], (Body::EndWhile, Some(3)));
    assert!(matches!(bodies[7].0, Body::Printing(_)));
    assert!(matches!(bodies[8], (Body::If(_), Some(9))));
    assert_eq!(bodies[9], (Body::Else, Some(10)));
    assert_eq!(bodies[10], (Body::EndIf, Some(8)));
}

#[test]
fn o_words() {
    let text = "o<sub one> sub\no1 if [#1 eq 1]\no1 elseif [#1 eq 2]\no1 else\no1 endif\no2 do\no3 while [#2 lt 3]\n\
                o3 continue\no3 endwhile\no2 while [#1 lt 2]\no4 repeat [3]\no4 break (out)\no4 endrepeat\n\
                o<subone> return [#1]\no<SubOne> endsub [1]\no<subone> call [1] (second) [#2+1] ; there\no#7 call\no[7] call";
    let program = clean("rs274", text);
    let partners: Vec<_> = program.blocks.iter().map(Block::partner).collect();
    assert_eq!(partners[..6], [Some(14), Some(2), Some(3), Some(4), Some(1), Some(9)]);
    assert_eq!(partners[6..13], [Some(8), Some(6), Some(6), Some(5), Some(12), Some(10), Some(10)]);
    assert_eq!(partners[13..], [None, Some(0), None, None, None]);
    assert!(matches!(program.blocks[9].body, Body::DoWhile(_)));
    let name = Label::Name(program.names.find("SUBONE").unwrap());
    assert_eq!(program.find_sub(name), Some(0));
    assert_eq!(program.blocks[15].label, Some(name));
    let Body::Call(arguments) = program.blocks[15].body else { panic!("{:?}", program.blocks[15].body) };
    let arguments: Vec<_> = program.arguments_of(arguments).iter().map(|&id| shown(&program, id)).collect();
    assert_eq!(arguments, ["1", "(#2 Add 1)"]);
    assert!(matches!(program.blocks[16].label, Some(Label::Computed(_))));
    assert_eq!(program.blocks[17].label, Some(Label::Number(7)));
}

#[test]
fn comments_and_what_they_do() {
    use words::CommentKind::{Debug, Log, Message, Plain, Print, Probe};
    let text = "(msg, Hello)\ng0 (a) x1 (b) ; c (d)\n( Debug,#1)\n(PRINT, x)\n(LOGOPEN, f)(LOGCLOSE)\n(PROBEOPEN f)\n(message)";
    let program = clean("rs274", text);
    let kinds: Vec<_> = program.comments.iter().map(|comment| comment.kind).collect();
    assert_eq!(kinds, [Message, Plain, Plain, Plain, Debug, Print, Log, Log, Probe, Plain]);
    assert_eq!(program.source.slice(program.comments[0].text), b" Hello");
    assert_eq!(program.source.slice(program.comments[3].text), b" c (d)");
    assert_eq!(program.source.slice(program.comments[3].span), b"; c (d)");
    assert_eq!(program.comments_of(&program.blocks[1]).len(), 3);
    let program = clean("fanuc", b"(MSG,x)\nX1(\xe4\xb8)");
    assert!(program.comments.iter().all(|comment| comment.kind == Plain));
}

#[test]
fn polar_words_and_spindles_of_rs274() {
    assert_eq!(first("rs274", "g1 @10 ^45.5 $1 s-#2"), "G1 @10 ^45.5. $1 SMinus(#2)");
}

#[test]
fn parity_and_flow_control_of_serial_lines_are_taken_off() {
    let plain = b"\x11%\r\nO1\r\nN10 G1 X12.5\r\n%\r\n\x13";
    let even: Vec<u8> = plain.iter().map(|&b| if b.count_ones() % 2 == 1 { b | 0x80 } else { b }).collect();
    for text in [plain.to_vec(), even] {
        let program = clean("fanuc", &text);
        assert_eq!(program.parts[0].number, Some(1));
        assert_eq!(shown_words(&program, &program.blocks[0]), "G1 X12.5.");
    }
}

#[test]
fn faults_have_their_code_and_their_place() {
    for (dialect, text, code, at) in [
        ("fanuc", "G1 X1.2.3", "E0102", 4),
        ("fanuc", "X", "E0103", 0),
        ("fanuc", "X--5", "E0103", 0),
        ("fanuc", "X[1+]", "E0104", 4),
        ("fanuc", "X[1+2", "E0105", 1),
        ("fanuc", "X1 (open", "E0105", 3),
        ("fanuc", "X1 ?", "E0101", 3),
        ("fanuc", "IF [#1 EQ 1] THE X1", "E0101", 13),
        ("fanuc", "GOTO 1 X1", "E0108", 7),
        ("fanuc", "WHILE [#1 LT 1] DO1", "E0106", 0),
        ("fanuc", "END1", "E0106", 0),
        ("fanuc", "WHILE [#1 LT 1] DO4", "E0106", 18),
        ("fanuc", "IF [#1 EQ 1 AND #2 EQ 2] GOTO 1", "E0104", 19),
        ("fanuc", "#0=1", "E0101", 0),
        ("fanuc", "#1", "E0103", 0),
        ("fanuc", "X1 ,Q5", "E0101", 3),
        ("rs274", "x1 /2 y1", "E0101", 3),
        ("rs274", "o100 foo", "E0101", 5),
        ("rs274", "o100 if [1]", "E0106", 0),
        ("rs274", "o100 endif", "E0106", 0),
        ("rs274", "o100 break", "E0106", 0),
        ("rs274", "x atan[1]", "E0104", 2),
        ("rs274", "x[foo[1]]", "E0104", 2),
        ("rs274", "#<a = 1", "E0105", 1),
        ("rs274", "(a (b) c)", "E0101", 3),
        ("rs274", "", "E0110", 0),
        ("grundig", "N1 X=", "E0103", 5),
        ("grundig", "N1 XE1", "E0103", 3),
        ("grundig", "N1 X=(1", "E0105", 5),
        ("grundig", "N1 X=E", "E0104", 5),
        ("grundig", "N1 X[1]", "E0103", 3),
        ("grundig", "N1.5 X1", "E0102", 0),
        ("rs274", "m2\no1 sub\nx?\no1 endsub", "E0103", 10),
    ] {
        let source = Source::new(FileId(0), "a", text.as_bytes().to_vec()).unwrap();
        let (_, findings) = words::parse(&source, ncfix_dialect::find(dialect).unwrap());
        let found: Vec<_> = findings
            .iter()
            .map(|finding| (finding.code.as_str(), finding.place.map(|place| place.span.start)))
            .collect();
        assert_eq!(found, [(code, Some(at))], "{dialect}: {text}");
    }
}

#[test]
fn a_faulty_line_costs_only_itself() {
    let (program, findings) = parse("fanuc", "X1\nX?\nX3");
    assert_eq!(findings, ["E0103"]);
    assert_eq!(program.blocks.len(), 3);
    assert_eq!(program.blocks[1].body, Body::Faulty);
    assert_eq!(shown_words(&program, &program.blocks[2]), "X3");
}
