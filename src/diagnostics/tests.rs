//! Tests of the presentation of diagnostics.

use super::*;
use ncfix_base::source::FileId;

fn at(code: Code, start: usize) -> Diagnostic {
    Diagnostic::at(code, Place { file: FileId(0), span: Span::new(start, start + 1) }, "m", "h")
}

#[test]
fn a_finding_in_a_loop_counts_once() {
    let source = Source::new(FileId(0), "a", b"N1 X\nN2 X\n".to_vec()).unwrap();
    let mut findings = Diagnostics::default();
    findings.extend([at(Code::OUT_OF_TRAVEL, 3), at(Code::OUT_OF_TRAVEL, 3), at(Code::OUT_OF_TRAVEL, 8)], &[source]);
    assert_eq!(findings.count(), "2 errors");
    assert!(findings.has_errors() && !findings.has_language_errors());
    let lines: Vec<_> = findings.json().iter().map(|finding| finding.line).collect();
    assert_eq!(lines, [Some(1), Some(2)]);
}

#[test]
fn another_machine_is_named_before_the_errors_that_it_makes() {
    let source = Source::new(FileId(0), "a", vec![b'X'; 200]).unwrap();
    let mut findings = Diagnostics::default();
    findings.extend((0..100).map(|start| at(Code::OFF_PROMISE, start)), &[source]);
    findings.add(Diagnostic::nowhere(Code::OTHER_STAMP, "m", "h"), &[]);
    assert!(findings.drawing(terminal::Colors::Plain, true).starts_with("warning[W0306]"));
    assert!(findings.drawing(terminal::Colors::Plain, false).starts_with("error["));
}

#[test]
fn a_text_that_is_repeated_is_drawn_once_with_the_lines() {
    let source = Source::new(FileId(0), "a", b"N1\nN2\nN3\nN4\nN5\n".to_vec()).unwrap();
    let mut findings = Diagnostics::default();
    findings.extend([0, 6, 12].map(|start| at(Code::UNEXPECTED, start)), &[source]);
    let drawing = findings.drawing(terminal::Colors::Plain, true);
    assert_eq!(drawing.matches("error[E0101]").count(), 1, "{drawing}");
    assert!(drawing.ends_with("  = also in lines 3 and 5\n\n"), "{drawing}");
}

#[test]
fn quantities_make_no_other_text_and_names_do() {
    let source = Source::new(FileId(0), "a", b"N1\nN2\nN3\nN4\nN5\n".to_vec()).unwrap();
    let drawn = |messages: [&str; 3]| {
        let mut findings = Diagnostics::default();
        let all = messages.iter().zip([0, 6, 12]);
        let found = all.map(|(text, start)| Diagnostic { message: (*text).into(), ..at(Code::UNEXPECTED, start) });
        findings.extend(found, std::slice::from_ref(&source));
        findings.drawing(terminal::Colors::Plain, true)
    };
    let radii = drawn(["radius 1.5 mm, end 2.5 mm", "radius 3 mm, end 2.25 mm", "radius -4.0 mm, end 1 mm"]);
    assert!(radii.contains("radius 1.5 mm, end 2.5 mm\n") && !radii.contains("2.25"), "{radii}");
    assert!(radii.ends_with("  = also in lines 3 and 5\n\n"), "{radii}");
    let names = drawn(["there is no O9810", "there is no O9811", "X 5 mm"]);
    assert_eq!(names.matches("error[E0101]").count(), 3, "{names}");
}

#[test]
fn the_drawing_is_bounded_and_errors_come_first() {
    let source = Source::new(FileId(0), "a", vec![b'X'; 5000]).unwrap();
    let mut findings = Diagnostics::default();
    findings.add(Diagnostic::nowhere(Code::SKIP_EXECUTED, "demo", "h"), &[]);
    let other = |start| Diagnostic { message: format!("m{start}"), ..at(Code::UNEXPECTED, start) };
    findings.extend((0..2000).map(other), &[source]);
    let drawing = findings.drawing(terminal::Colors::Plain, true);
    assert_eq!(drawing.matches("error[E0101]").count(), MOST_DRAWN);
    assert!(drawing.starts_with("error[E0101]"));
    assert!(drawing.ends_with("… and 1951 more\n\n"), "{drawing}");
    let errors = findings.drawing(terminal::Colors::Plain, false);
    assert!(errors.ends_with("… and 1950 more\n\n") && !errors.contains("warning"), "{errors}");
    assert_eq!(findings.json().len(), MOST_KEPT);
    assert!(findings.is_hopeless());
    assert!(findings.has_language_errors());
}
