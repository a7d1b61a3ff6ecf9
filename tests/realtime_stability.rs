//! Scale compensation against set-point compensation: what Spaan measured on the Maho 700S (1995, ch. 6, Figs. 6.4–6.7).

use ncfix_tables::realtime::stability::{Compensation, approach_um, run, there_and_back_um, unrest_um};

use crate::support::Shop;

/// The largest unrest at rest anywhere around the grid point.
fn worst_um(compensation: Compensation, step_um: f64) -> f64 {
    let places = (-24..=24).map(|quarter| 0.25 * f64::from(quarter));
    places.map(|place| unrest_um(&run(compensation, step_um, &approach_um(place)))).fold(0.0, f64::max)
}

#[test]
fn a_step_of_two_increments_makes_a_limit_cycle_and_one_of_an_increment_none() {
    // Measured: a cycle of 5 µm at a step of 2 µm, and none at 1 µm, the resolution.
    let cycle = worst_um(Compensation::Scale, -2.0);
    assert!((2.0..=6.0).contains(&cycle), "{cycle}");
    assert_eq!(worst_um(Compensation::Scale, -1.0), 0.0);
    // The other sign has none.
    assert_eq!(worst_um(Compensation::Scale, 2.0), 0.0);
}

#[test]
fn set_point_compensation_has_no_limit_cycle_at_any_step() {
    for step_um in [-10.0, -5.0, -2.0, -1.0, 1.0, 2.0, 5.0, 10.0] {
        assert_eq!(worst_um(Compensation::SetPoint, step_um), 0.0, "{step_um}");
    }
}

/// How far apart the rests of both ways are at most, µm.
fn hysteresis_um(compensation: Compensation, step_um: f64) -> f64 {
    let [up, mut down] = there_and_back_um(compensation, step_um, 12.0);
    down.reverse();
    assert_eq!(up.len(), 97);
    let apart = up.iter().zip(&down).map(|(up, down)| {
        assert_eq!(up.0, down.0);
        (up.1 - down.1).abs()
    });
    apart.fold(0.0, f64::max)
}

#[test]
fn a_step_up_makes_a_virtual_hysteresis_under_scale_compensation_only() {
    // Friction alone leaves an increment on each side of the set-point, whatever the table: two increments between both ways.
    let friction = hysteresis_um(Compensation::SetPoint, 0.0);
    assert!(friction <= 2.5, "{friction}");
    for step_um in [2.0, 5.0] {
        assert!(hysteresis_um(Compensation::Scale, step_um) > friction + 0.75 * step_um);
        assert!(hysteresis_um(Compensation::SetPoint, step_um) <= friction + 0.5, "{step_um}");
    }
}

#[test]
fn set_point_compensation_leaves_an_ambiguity_or_a_forbidden_zone() {
    // Rests of one way, so that friction pulls all to the same side.
    let [up, _] = there_and_back_um(Compensation::SetPoint, 8.0, 20.0);
    // Set-points below 0 lead below 0, those from 0 on to 8 and more; friction leaves up to an increment and a half.
    assert!(up.iter().all(|&(_, position)| !(1.5..=6.5).contains(&position)));
    let [up, _] = there_and_back_um(Compensation::SetPoint, -8.0, 20.0);
    let near = up.iter().filter(|(_, position)| (position + 4.0).abs() < 0.6);
    let at: Vec<f64> = near.map(|(at, _)| *at).collect();
    assert!(at.iter().any(|&at| at < 0.0) && at.iter().any(|&at| at >= 0.0), "{at:?}");
}

#[test]
fn the_page_has_a_picture_of_each() {
    let shop = Shop::new();
    shop.run(["realtime", "--stability", "s.html"]).exits(0);
    let text = shop.text("s.html");
    let page = roxmltree::Document::parse(text.trim_start_matches("<!DOCTYPE html>\n")).unwrap();
    let titles: Vec<&str> =
        page.descendants().filter(|node| node.tag_name().name() == "title").filter_map(|node| node.text()).collect();
    for word in ["limit cycle", "virtual hysteresis", "at rest", "ambiguity", "forbidden zone"] {
        assert!(titles.iter().any(|title| title.contains(word)), "{word}: {titles:?}");
    }
}
