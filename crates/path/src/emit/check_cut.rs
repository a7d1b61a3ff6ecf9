//! Program of a test square for the squareness of X and Y, in the language of a control.

use ncfix_dialect::Language;
use ncfix_machine::machine::Machine;

/// Depth of the groove, height above the workpiece, mm; feeds, mm/min; speed, rpm: careful values for wood, plastics and a marking tool in metal.
const DEPTH_MM: f64 = 0.5;
const HEIGHT_MM: f64 = 10.0;
const PLUNGE_MM_MIN: f64 = 100.0;
const FEED_MM_MIN: f64 = 500.0;
const SPEED_RPM: f64 = 3000.0;

/// Writes a program that engraves a rectangle from the workpiece zero G54 in X+ and Y+, mm.
///
/// # Errors
/// Returns a message if the control has no dialect.
pub fn check_cut(machine: &Machine, [a, b]: [f64; 2]) -> Result<Vec<u8>, String> {
    let language = ncfix_dialect::find(&machine.controller).map(|dialect| dialect.language);
    let language = language.ok_or_else(|| format!("the controller '{}' is not a dialect", machine.controller))?;
    let notes = [
        format!("TEST SQUARE {a} X {b}, ZERO G54 AT ITS CORNER"),
        "CUT IT WITHOUT CORRECTION, MEASURE D1 FROM X0 Y0, AND D2".to_owned(),
    ];
    let number = |value: f64| {
        let text = format!("{value:.3}");
        let text = text.trim_end_matches('0');
        // A number without a point counts increments on some controls.
        if language == Language::Fanuc { text.to_owned() } else { text.trim_end_matches('.').to_owned() }
    };
    let mut lines: Vec<String> = Vec::new();
    let comment = |text: &String| match language {
        Language::Sinumerik => format!("; {text}"),
        _ => format!("({text})"),
    };
    match language {
        Language::Fanuc => lines.extend(["%".to_owned(), "O9002".to_owned()]),
        Language::Grundig => lines.extend(["%PM9002".to_owned(), format!("N9002 {}", comment(&notes[0]))]),
        Language::Sinumerik | Language::Rs274 => {}
    }
    if language != Language::Grundig {
        lines.extend(notes.iter().map(comment));
    }
    let unit = match language {
        Language::Sinumerik | Language::Grundig => "G71",
        Language::Fanuc | Language::Rs274 => "G21",
    };
    let [a, b, zero] = [a, b, 0.0].map(number);
    let [height, depth] = [HEIGHT_MM, -DEPTH_MM].map(number);
    let [plunge, feed, speed] = [PLUNGE_MM_MIN, FEED_MM_MIN, SPEED_RPM].map(|value| format!("{value}"));
    let blocks = [
        format!("G17 {unit} G90 G94 G40"),
        "G54".to_owned(),
        format!("S{speed} M3"),
        format!("G0 Z{height}"),
        format!("G0 X{zero} Y{zero}"),
        format!("G1 Z{depth} F{plunge}"),
        format!("G1 X{a} F{feed}"),
        format!("G1 Y{b}"),
        format!("G1 X{zero}"),
        format!("G1 Y{zero}"),
        format!("G0 Z{height}"),
        "M5".to_owned(),
        "M30".to_owned(),
    ];
    let numbered = |(at, block): (usize, &String)| match language {
        Language::Grundig => format!("N{} {block}", at + 1),
        _ => block.clone(),
    };
    lines.extend(blocks.iter().enumerate().map(numbered));
    if language == Language::Fanuc {
        lines.push("%".to_owned());
    }
    Ok((lines.join("\n") + "\n").into_bytes())
}
