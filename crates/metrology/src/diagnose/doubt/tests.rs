//! Tests of the selection of position-dependent errors and of simpler ones.

use super::*;
use crate::diagnose::bench;
use crate::diagnose::scene::Through;

#[test]
fn an_error_of_a_place_acts_through_the_machine_and_depends_on_axes_alone() {
    let of = |effect: EffectKind, through: Through, driver: &str| {
        bench::candidate(effect, through, |_| 1.0).driven_by(&[&driver])
    };
    let component = Through::Component("EXX".parse().unwrap());
    assert!(
        is_of_place(&of(EffectKind::Motion, component, "X"))
            && is_of_place(&of(EffectKind::Unknown, Through::Tip(2), "Y"))
    );
    // The instrument is not a position of the machine, nor is a clock; a wave has a constant as well.
    assert!(!is_of_place(&of(EffectKind::Unknown, Through::Reading(false), "X")));
    assert!(!is_of_place(&of(EffectKind::Unknown, Through::Value(1), "X")));
    assert!(
        !is_of_place(&of(EffectKind::Unknown, component, "t_s")) && !is_of_place(&of(EffectKind::Load, component, "X"))
    );
    let wave = Candidate { constant: Some((10.0, "mm")), ..of(EffectKind::Motion, component, "X") };
    assert!(!is_of_place(&wave));
}

#[test]
fn slopes_are_simpler_than_what_has_no_name_and_curvatures_are_not() {
    let machine = bench::machine();
    let sets = [bench::along_x(&machine, "", &[(-100.0, ""), (0.0, ""), (200.0, "")])];
    let scene = bench::scene(&machine, &sets);
    let of = |name: &str, effect: EffectKind, term: &str| {
        let parameter: ncfix_model::ParameterName = term.parse().unwrap();
        bench::candidate(effect, Through::Component(name.parse().unwrap()), |_| 1.0).extends(&[parameter])
    };
    let all = vec![
        of("EYX", EffectKind::Motion, "EYX1"),
        of("EYX", EffectKind::Motion, "EYX2"),
        of("EC0Y", EffectKind::Location, "EC0Y"),
        of("EYX", EffectKind::Backlash, "EYXb"),
    ];
    let field = Field::new(&scene, all);
    let than = bench::candidate(EffectKind::Unknown, Through::Tip(1), |_| 1.0);
    let found: Vec<usize> = field.simpler(&than).into_iter().filter(|&number| number < 4).collect();
    assert_eq!(found, [0, 2]);
    // Bows with one column are included.
    assert!(field.simpler(&than).iter().any(|number| field.bows.contains(number)));
}
