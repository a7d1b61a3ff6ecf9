//! Pictures: where things are drawn, that every picture is XML whatever its labels are, and that a million points stay a picture.

use ncfix_report::plot::{Bar, Bars, Chart, Histogram, LevelLine, Picture, PlotSeries, Polar, PolarTrace, Shape};
use roxmltree::Document;

/// What would be markup if it were not escaped.
const HOSTILE: &str = "</svg><script>alert('1')</script> & \"A\" \u{1}";

/// Parses a picture, and looks that texts stay texts.
fn sound(picture: &impl Picture) -> String {
    let text = picture.svg();
    let document = Document::parse(&text).unwrap_or_else(|error| panic!("{error}: {text}"));
    assert_eq!(document.root_element().tag_name().namespace(), Some("http://www.w3.org/2000/svg"));
    assert!(document.descendants().all(|node| node.tag_name().name() != "script"), "{text}");
    assert!(!["NaN", "inf"].iter().any(|bad| text.contains(bad)), "{text}");
    text
}

fn series(label: &str, points: Vec<(f64, f64)>, shape: Shape) -> PlotSeries {
    PlotSeries { label: label.into(), points, errors: Vec::new(), shape, like: None }
}

/// All `d` of paths within a group of series.
fn paths(text: &str) -> Vec<String> {
    let document = Document::parse(text).unwrap();
    let groups =
        document.descendants().filter(|node| node.attribute("class").is_some_and(|class| class.starts_with('s')));
    let own = groups.flat_map(|group| group.descendants()).filter_map(|node| node.attribute("d"));
    own.map(str::to_owned).collect()
}

#[test]
fn points_lie_where_their_values_say() {
    let chart = Chart {
        title: HOSTILE.into(),
        across: "X in mm".into(),
        up: HOSTILE.into(),
        series: vec![
            series("", vec![(0.0, 0.0), (10.0, 10.0), (5.0, 2.5)], Shape::Line),
            PlotSeries { errors: vec![1.0], ..series(HOSTILE, vec![(5.0, 5.0), (f64::NAN, 1.0)], Shape::Markers) },
        ],
        levels: vec![LevelLine { value: 2.0, label: HOSTILE.into() }],
        ..Chart::default()
    };
    let text = sound(&chart);
    // The frame is from 88 to 556 across and from 248 to 56 upwards: 46.8 and 19.2 to a unit.
    let paths = paths(&text);
    assert_eq!(paths[0], "M88.0 248.0L556.0 56.0L322.0 200.0");
    assert!(paths[1].starts_with("M319.8 149.8h4.4"), "{}", paths[1]);
    assert_eq!(paths[2], "M319.0 171.2h6M319.0 132.8h6M322.0 171.2V132.8");
}

#[test]
fn one_wrong_value_does_not_hide_the_others() {
    let mut points: Vec<(f64, f64)> = (0..100).map(|k| (f64::from(k), f64::from(k % 5) / 10.0)).collect();
    points.push((50.0, 1e6));
    let chart =
        |is_clipped| Chart { series: vec![series("", points.clone(), Shape::Markers)], is_clipped, ..Chart::default() };
    let text = sound(&chart(true));
    assert!(text.contains("1 outside the picture"), "{text}");
    // 100 markers and a triangle.
    assert_eq!(paths(&text)[0].matches('M').count(), 101);
    assert!(!sound(&chart(false)).contains("beyond"));
}

#[test]
fn a_million_points_are_a_small_picture() {
    let points = |of: fn(f64) -> f64| (0..1_000_000).map(|k| (f64::from(k), of(f64::from(k)))).collect::<Vec<_>>();
    let mut values = points(|x| (x * 0.01).sin());
    values[700_000].1 = 3.0;
    let chart = Chart { series: vec![series("a", values, Shape::Line)], ..Chart::default() };
    let text = sound(&chart);
    assert!(text.len() < 40_000, "{}", text.len());
    // The one value that is larger than all others is seen: 3 of −1 … 3 is the upper end of the frame.
    assert!(paths(&text)[0].contains(" 56.6V") || paths(&text)[0].contains(" 55.4V"), "{}", paths(&text)[0]);
    let polar = Polar { traces: vec![PolarTrace { label: "t".into(), points: points(f64::sin) }], ..Polar::default() };
    assert!(sound(&polar).len() < 60_000);
    let values = points(f64::cos).into_iter().map(|point| point.1).collect();
    assert!(sound(&Histogram { values, sigma: Some(1.0), ..Histogram::default() }).len() < 40_000);
    let bars = (0..100_000).map(|k| Bar { label: k.to_string(), value: 1.0, error: 0.5 }).collect();
    let text = sound(&Bars { bars, ..Bars::default() });
    assert!(text.len() < 60_000 && text.contains("99880 more"), "{}", text.len());
}

#[test]
fn bars_end_at_their_values() {
    let bar = |value, error| Bar { label: HOSTILE.into(), value, error };
    let bars = vec![bar(10.0, 1.0), bar(-4.0, 0.0), bar(f64::INFINITY, f64::NAN)];
    let text = sound(&Bars { bars: bars.clone(), ..Bars::default() });
    assert!(text.contains("not identifiable"), "{text}");
    // From −5 to 15: 364 units of the picture for 20, so zero at 297, 10 at 479, −4 at 224.2.
    assert!(text.contains("M297.0 37.0H479.0v11H297.0z") && text.contains("M297.0 58.0H224.2v11H297.0z"), "{text}");
    assert!(text.contains("M460.8 42.5H497.2"), "{text}");
    // 1 … 100 in decades: 10 is in the middle.
    let bars = vec![bar(10.0, 0.0), bar(100.0, 0.0)];
    assert!(sound(&Bars { bars, is_logarithmic: true, ..Bars::default() }).contains("H388.0v11"));
}

#[test]
fn traces_are_about_the_nominal_circle() {
    // 4 µm is four divisions, each 15 of the picture, beyond the nominal radius of 130 about 300, 260.
    let points = vec![(0.0, 4.0), (std::f64::consts::FRAC_PI_2, 0.0), (std::f64::consts::PI, -4.0)];
    let polar = Polar {
        title: HOSTILE.into(),
        axes: [HOSTILE.into(), "Y".into()],
        unit: "µm".into(),
        radius_mm: 150.0,
        traces: vec![PolarTrace { label: HOSTILE.into(), points }],
    };
    assert_eq!(polar.division(), 1.0);
    let text = sound(&polar);
    assert!(paths(&text).contains(&"M490.0 260.0L300.0 130.0L230.0 260.0".to_owned()), "{text}");
    // 150 mm are 130 units, a division of 15 units is 17.3 mm, which is 17308 times 1 µm.
    assert!(text.contains("1 division = 1 µm, exaggerated 17308 times"), "{text}");
    sound(&Polar::default());
    sound(&Chart::default());
    sound(&Bars::default());
    sound(&Histogram {
        title: HOSTILE.into(),
        across: HOSTILE.into(),
        counted: HOSTILE,
        values: vec![f64::NAN, 1.0],
        sigma: Some(0.0),
    });
}
