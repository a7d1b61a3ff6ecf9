//! Pockets, slots, faces and spigots: the moves of a cycle cut a block of material, and what is left is measured.

use ncfix_language::exec::{NoLibrary, Options};
use ncfix_machine::machine::{Machine, Tool, ToolChange};

use crate::exec::run_with;
use crate::machines::xyz_machine;
use crate::stock::{Stock, TOP};
use crate::support::Shop;

fn machine(radius_mm: f64) -> Machine {
    let mut machine = xyz_machine();
    machine.control.tool_change = ToolChange::T;
    machine.tools.push(Tool { number: 1, name: None, edge: 1, length_mm: [0.0; 3], radius_mm });
    machine
}

/// The moves of one cycle with a tool.
fn moves(call: &str, radius_mm: f64) -> Vec<String> {
    let text = format!("N10 G17 G90 G71 T1 D1\nN20 G0 X0 Y0 Z50 F500\n{call}\nN90 M30");
    let (lines, codes) = run_with(&text, &machine(radius_mm), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{call}: {codes:?}");
    lines
}

/// Signed distance from a rectangle with round corners, below 0 inside.
fn from_rectangle(point: [f64; 2], middle: [f64; 2], half: [f64; 2], corner: f64, turn_deg: f64) -> f64 {
    let (s, c) = turn_deg.to_radians().sin_cos();
    let (dx, dy) = (point[0] - middle[0], point[1] - middle[1]);
    let (u, v) = (dx * c + dy * s, dy * c - dx * s);
    let (qu, qv) = (u.abs() - half[0] + corner, v.abs() - half[1] + corner);
    qu.max(0.0).hypot(qv.max(0.0)) + qu.max(qv).min(0.0) - corner
}

/// What a cycle shall do to the block.
struct Wanted<'a> {
    call: &'a str,
    radius: f64,
    low: [f64; 2],
    high: [f64; 2],
    depth: f64,
    /// Deepest cut across.
    cut: f64,
}

/// Cuts and compares: points further than a hair inside the figure have the depth, points outside are untouched.
#[track_caller]
fn check_figure(wanted: &Wanted<'_>, distance: impl Fn([f64; 2]) -> f64) {
    let mut stock = Stock::new(wanted.low, wanted.high, 0.4);
    stock.mill(&moves(wanted.call, wanted.radius), wanted.radius);
    assert!(stock.faults.is_empty(), "{}: {} {}", wanted.call, stock.faults.len(), stock.faults[0]);
    // A disc that moves by half a step leaves a scallop of less than this at a straight wall.
    let hair = 0.02;
    let mut cleared = 0;
    for (point, height) in stock.points() {
        let d = distance(point);
        if d > 1e-4 {
            assert!(height == TOP, "{}: gouge at {point:?}, {d} outside, height {height}", wanted.call);
        } else if d < -hair {
            assert!((height - wanted.depth).abs() < 1e-9, "{}: {height} left at {point:?}, {d}", wanted.call);
            cleared += 1;
        }
    }
    assert!(cleared > 100, "{}: the figure has {cleared} points", wanted.call);
    assert!(stock.cut <= wanted.cut + 1e-5, "{}: a cut of {} mm", wanted.call, stock.cut);
}

#[test]
fn rectangular_pockets_are_cleared_to_the_wall() {
    let (low, high) = ([-10.0, -10.0], [110.0, 90.0]);
    let figure = |fal: f64| {
        move |point| from_rectangle(point, [60.0, 40.0], [30.0 - fal, 20.0 - fal], (8.0 - fal).max(5.0), 20.0)
    };
    // Rough with insertion by feed, on a helix, to and fro; clockwise and counterclockwise; from either side longer.
    for (vari, rad, dp1, cdir) in [(11, 0.0, 0.0, 0), (21, 3.0, 1.0, 1), (31, 5.0, 0.0, 2), (11, 0.0, 0.0, 3)] {
        let call = format!("POCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,{cdir},{vari},,,,,{rad},{dp1})");
        // 9.8 mm in three levels.
        let wanted = Wanted { call: &call, radius: 5.0, low, high, depth: -9.8, cut: 9.8 / 3.0 };
        check_figure(&wanted, figure(0.5));
    }
    let call = "POCKET3(20,0,2,-10,40,60,8,60,40,110,4,0.5,0.2,500,200,0,11)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -9.8, cut: 9.8 / 3.0 }, figure(0.5));
    // Rough, then finish: the wall and the ground are there.
    let call = "POCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,0,11)\nPOCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,0,12)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -10.0, cut: 9.8 / 3.0 + 0.2 }, figure(0.0));
    // Narrow rings, a relative depth, a tool as wide as the pocket.
    let call = "POCKET3(20,0,2,6,60,40,8,60,40,20,0,0,0,500,200,0,11,25,,,,,,0,0,0,0,1,11)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -6.0, cut: 6.0 }, figure(0.0));
    let call = "POCKET3(20,0,2,-6,60,10,5,60,40,0,2,0,0,500,200,0,11)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -6.0, cut: 2.0 }, |point| {
        from_rectangle(point, [60.0, 40.0], [30.0, 5.0], 5.0, 0.0)
    });
    // Inner corners get the radius of the tool where none is given.
    let call = "POCKET3(20,0,2,-6,60,40,0,60,40,0,2,0,0,500,200,0,11)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -6.0, cut: 2.0 }, |point| {
        from_rectangle(point, [60.0, 40.0], [30.0, 20.0], 5.0, 0.0)
    });
    let call = "POCKET1(20,0,2,-6,,60,40,8,60,40,20,100,500,3,2,0.3,0,6,400,2000)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -6.0, cut: 6.0 }, figure(0.0));
}

#[test]
fn circular_pockets_are_cleared_to_the_wall() {
    let (low, high) = ([-10.0, -10.0], [70.0, 70.0]);
    let round = |radius: f64| move |point: [f64; 2]| (point[0] - 30.0).hypot(point[1] - 30.0) - radius;
    for (vari, rad, dp1, tool) in
        [(11, 0.0, 0.0, 5.0), (21, 3.0, 1.5, 4.0), (1021, 9.0, 2.0, 6.0), (11, 0.0, 0.0, 12.0)]
    {
        let call = format!("POCKET4(20,0,2,-7,25,30,30,3,0.4,0.1,500,200,0,{vari},0,,,{rad},{dp1})");
        check_figure(&Wanted { call: &call, radius: tool, low, high, depth: -6.9, cut: 2.3 }, round(24.6));
    }
    let call = "POCKET4(20,0,2,7,25,30,30,3,0.4,0.1,2000,2000,0,11,80,9,15,6,1,0,1,2,10100,111,111)\nPOCKET4(20,0,2,7,25,30,30,3,0.4,0.1,2000,2000,0,12,80,9,15,6,1,0,1,2,10100,111,111)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -7.0, cut: 2.4 }, round(25.0));
    let call = "POCKET2(20,0,2,-7,,25,30,30,100,500,3,3,0.4,0,7,400)";
    check_figure(&Wanted { call, radius: 5.0, low, high, depth: -7.0, cut: 7.0 }, round(25.0));
    // As wide as the tool: a hole.
    let call = "POCKET4(20,0,2,-7,5,30,30,3,0,0,500,200,0,11)";
    let mut stock = Stock::new(low, high, 0.4);
    stock.mill(&moves(call, 5.0), 5.0);
    assert!(stock.faults.is_empty());
    assert!(
        stock
            .points()
            .all(|(point, height)| (round(5.0)(point) < 1e-4) == (height < TOP) || round(5.0)(point).abs() < 1e-4)
    );
}

#[test]
fn slots_are_cleared_to_the_wall() {
    let (low, high) = ([-60.0, -60.0], [60.0, 60.0]);
    let radial = |length: f64, width: f64, count: u32| {
        move |point: [f64; 2]| {
            let slots = (0..count).map(|k| {
                let a = 30.0 + 360.0 / f64::from(count) * f64::from(k);
                let (s, c) = a.to_radians().sin_cos();
                let middle = 15.0 + length / 2.0;
                from_rectangle(point, [middle * c, middle * s], [length / 2.0, width / 2.0], width / 2.0, a)
            });
            slots.fold(f64::INFINITY, f64::min)
        }
    };
    let call = "LONGHOLE(20,0,2,-6,,3,30,0,0,15,30,0,100,500,2.5)";
    check_figure(&Wanted { call, radius: 4.0, low, high, depth: -6.0, cut: 2.0 }, radial(30.0, 8.0, 3));
    for (vari, cdir) in [(0, 2), (0, 3), (30, 0)] {
        let call = format!("SLOT1(20,0,2,,6,3,30,12,0,0,15,30,0,100,500,2.5,{cdir},0.3,{vari},0,400,0,0,4)");
        let wanted = Wanted { call: &call, radius: 4.0, low, high, depth: -6.0, cut: 6.0 };
        check_figure(&wanted, radial(30.0, 12.0, 3));
    }
    // An arc of 70° of radius 40 from 10°, width 12, and again 180° further.
    let bow = |point: [f64; 2]| {
        let one = |from: f64| {
            let a = (point[1].atan2(point[0]).to_degrees() - from).rem_euclid(360.0);
            let end = |at: f64| {
                let (s, c) = (from + at).to_radians().sin_cos();
                (point[0] - 40.0 * c).hypot(point[1] - 40.0 * s)
            };
            let to_arc = if a <= 70.0 { (point[0].hypot(point[1]) - 40.0).abs() } else { end(0.0).min(end(70.0)) };
            to_arc - 6.0
        };
        one(10.0).min(one(190.0))
    };
    for cdir in [2, 3] {
        let call = format!("SLOT2(20,0,2,-6,,2,70,12,0,0,40,10,180,100,500,2.5,{cdir},0.3,0,0,400)");
        check_figure(&Wanted { call: &call, radius: 4.0, low, high, depth: -6.0, cut: 2.0 }, bow);
    }
    let call = "SLOT2(20,0,2,-6,,2,70,8,0,0,40,10,180,100,500,2.5,3,0,1)";
    check_figure(&Wanted { call, radius: 4.0, low, high, depth: -6.0, cut: 2.0 }, |point| bow(point) + 2.0);
}

#[test]
fn faces_are_cleared_and_the_way_there_is_free() {
    // The block is the face: the tool may come down beside it.
    let (low, high) = ([0.0, 0.0], [80.0, 50.0]);
    let everywhere = |point| from_rectangle(point, [40.0, 25.0], [40.0, 25.0], 0.0, 0.0);
    for kind in [11, 21, 31, 41] {
        let call = format!("CYCLE71(20,0,2,-5,0,0,80,50,0,2,12,3,0.5,800,{kind},2)");
        check_figure(&Wanted { call: &call, radius: 8.0, low, high, depth: -4.5, cut: 1.5 }, everywhere);
        let call = format!("CYCLE71(20,0,2,-5,80,50,-80,-50,0,2,12,3,0.5,800,{kind},2)");
        check_figure(&Wanted { call: &call, radius: 8.0, low, high, depth: -4.5, cut: 1.5 }, everywhere);
        let call = format!("CYCLE61(20,0,2,-5,0,0,80,50,2,75,0.5,800,{kind},0,1,11010)");
        check_figure(&Wanted { call: &call, radius: 8.0, low, high, depth: -4.5, cut: 1.5 }, everywhere);
    }
    let call = "CYCLE71(20,0,2,-5,0,0,80,50,0,2,12,3,0.5,800,32,2)";
    check_figure(&Wanted { call, radius: 8.0, low, high, depth: -5.0, cut: 5.0 }, everywhere);
    // Turned by 90° about its corner it is the same face.
    let call = "CYCLE71(20,0,2,-5,80,0,50,80,90,2,12,3,0,800,31,2)";
    check_figure(&Wanted { call, radius: 8.0, low, high, depth: -5.0, cut: 5.0 / 3.0 }, everywhere);
    // Kept inside on all four sides: a pocket whose corners are as round as the tool.
    for kind in [11, 21, 31, 41] {
        let call = format!("CYCLE61(20,0,2,-4,10,10,70,40,2,12,0,800,{kind},1111,0,0)");
        let mut stock = Stock::new(low, high, 0.4);
        stock.mill(&moves(&call, 8.0), 8.0);
        for (point, height) in stock.points() {
            let d = from_rectangle(point, [40.0, 25.0], [30.0, 15.0], 0.0, 0.0);
            assert!(d < 1e-4 || height == TOP, "{call}: gouge at {point:?}");
            let round = from_rectangle(point, [40.0, 25.0], [30.0, 15.0], 8.0, 0.0);
            // Strokes leave scallops at the ends between them.
            assert!(round > -8.0 || (height + 4.0).abs() < 1e-9, "{call}: {height} left at {point:?}");
        }
    }
}

#[test]
fn spigots_stand_where_they_shall() {
    let (low, high) = ([0.0, 0.0], [90.0, 80.0]);
    // The ring that one round of the tool clears, without the place where it comes and goes.
    let check_spigot = |call: &str, half: [f64; 2], corner: f64, turn: f64, depth: f64, cut: f64| {
        let mut stock = Stock::new(low, high, 0.4);
        stock.mill(&moves(call, 5.0), 5.0);
        // Behind the blank, where the tool comes down, there is nothing to hit.
        let mut ring = 0;
        for (point, height) in stock.points() {
            let d = from_rectangle(point, [45.0, 40.0], half, corner, turn);
            if d < -1e-4 {
                assert!(height == TOP, "{call}: gouge at {point:?}");
            } else if d > 0.02 && d < 9.9 {
                assert!((height - depth).abs() < 1e-9, "{call}: {height} left at {point:?}");
                ring += 1;
            }
        }
        assert!(ring > 1000);
        assert!(stock.faults.is_empty(), "{call}: {:?}", stock.faults.first());
        assert!(stock.cut <= cut + 1e-5, "{call}: {}", stock.cut);
    };
    for cdir in [0, 1, 2, 3] {
        let call = format!("CYCLE76(20,0,2,-9,,40,30,6,45,40,15,3,0.5,0.3,800,200,{cdir},1,60,50)");
        check_spigot(&call, [20.5, 15.5], 6.5, 15.0, -8.7, 2.9);
        let call = format!("CYCLE77(20,0,2,-9,,36,45,40,3,0.5,0.3,800,200,{cdir},1,50)");
        check_spigot(&call, [18.5, 18.5], 18.5, 0.0, -8.7, 2.9);
    }
    check_spigot("CYCLE76(20,0,2,,9,40,30,6,45,40,15,3,0.5,0.3,800,200,0,2,60,50)", [20.0, 15.0], 6.0, 15.0, -9.0, 3.0);
    check_spigot("CYCLE77(20,0,2,-9,,36,45,40,3,0.5,0.3,800,200,0,2,50)", [18.0, 18.0], 18.0, 0.0, -9.0, 3.0);
}

#[test]
fn a_contour_is_followed_at_the_distance_of_the_tool() {
    let (low, high) = ([0.0, 0.0], [90.0, 80.0]);
    // Once round a plate 50 by 30 with corners of 8, clockwise, so that the tool outside is on the left.
    let contour = "%_N_RIM_SPF\nN10 G0 X20 Y40\nN20 G1 Y47\nN30 G2 X28 Y55 CR=8\nN40 G1 X62\nN50 G2 X70 Y47 CR=8\nN60 G1 Y33\n\
                   N70 G2 X62 Y25 CR=8\nN80 G1 X28\nN90 G2 X20 Y33 CR=8\nN100 G1 Y40\nN110 M17";
    let check_rim = |cycles: &str, fal: f64, depth: f64, cut: f64| {
        let text = format!("%_N_MAIN_MPF\nN10 G17 G90 G71 T1 D1\nN20 G0 X0 Y0 Z50 F500\n{cycles}\nN90 M30\n{contour}");
        let (lines, codes) = run_with(&text, &machine(5.0), Box::new(NoLibrary), Options::default());
        assert!(codes.is_empty(), "{cycles}: {codes:?}");
        let mut stock = Stock::new(low, high, 0.4);
        stock.mill(&lines, 5.0);
        assert!(stock.faults.is_empty(), "{cycles}: {:?}", stock.faults.first());
        for (point, height) in stock.points() {
            let d = from_rectangle(point, [45.0, 40.0], [25.0, 15.0], 8.0, 0.0) - fal;
            if d < -1e-4 {
                assert!(height == TOP, "{cycles}: gouge at {point:?}");
            } else if d > 0.02 && d < 9.9 {
                assert!((height - depth).abs() < 1e-9, "{cycles}: {height} left at {point:?}");
            }
        }
        assert!(stock.cut <= cut + 1e-5, "{cycles}: {}", stock.cut);
    };
    for way in [1, 2, 3] {
        let call = format!("CYCLE72(\"RIM\",20,0,2,-6,2.5,0.4,0.3,800,200,1,41,{way},6,900,{way},6)");
        check_rim(&call, 0.4, -5.7, 5.7 / 3.0);
    }
    let call = "CYCLE72(\"RIM\",20,0,2,-6,0,0.4,0.3,800,200,2,41,2,6,900,3,4)";
    check_rim(call, 0.0, -6.0, 6.0);
    // Without compensation the tool centre follows the contour; a relative depth.
    let call = "CYCLE72(\"RIM\",20,0,2,6,3,0,0,800,200,111,40,1,6,900,1,6,0,0,0,0,1,1)";
    let text = format!("%_N_MAIN_MPF\nN10 G17 G90 G71 T1 D1\nN20 G0 X0 Y0 Z50 F500\n{call}\nN90 M30\n{contour}");
    let (lines, codes) = run_with(&text, &machine(5.0), Box::new(NoLibrary), Options::default());
    assert!(codes.is_empty(), "{codes:?}");
    let mut stock = Stock::new(low, high, 0.4);
    stock.mill(&lines, 5.0);
    assert!(stock.faults.is_empty());
    for (point, height) in stock.points() {
        let d = from_rectangle(point, [45.0, 40.0], [25.0, 15.0], 8.0, 0.0).abs() - 5.0;
        assert!(d.abs() < 0.02 || (d < 0.0) == (height < TOP), "{height} at {point:?}");
        assert!(height == TOP || (height + 6.0).abs() < 1e-9);
    }
}

/// Whether the wall lies on the left of the last arc that is as large as this.
fn sense(call: &str, radius: f64) -> Vec<String> {
    let lines = moves(call, 5.0);
    let large = lines.iter().filter(|line| {
        let word = |letter: &str| -> f64 {
            line.split(' ')
                .skip(1)
                .find_map(|word| word.strip_prefix(letter))
                .map_or(0.0, |value| value.parse().unwrap())
        };
        (line.starts_with("G2") || line.starts_with("G3")) && (word("I").hypot(word("J")) - radius).abs() < 1e-6
    });
    let mut codes: Vec<String> = large.map(|line| line[..2].to_owned()).collect();
    codes.dedup();
    codes
}

#[test]
fn the_direction_is_climb_conventional_or_as_written() {
    for (cdir, inside, outside) in [(0, "G3", "G2"), (1, "G2", "G3"), (2, "G2", "G2"), (3, "G3", "G3")] {
        assert_eq!(sense(&format!("POCKET4(20,0,2,-3,25,30,30,3,0,0,500,200,{cdir},11)"), 20.0), [inside]);
        assert_eq!(sense(&format!("CYCLE77(20,0,2,-3,,36,45,40,3,0,0,800,200,{cdir},1,50)"), 23.0), [outside]);
    }
}

#[test]
fn a_tool_that_does_not_fit_is_refused() {
    let codes = |call: &str, radius: f64| {
        let text = format!("N10 G17 G90 G71 T1 D1\nN20 G0 X0 Y0 Z50 F500\n{call}\nN90 M30");
        run_with(&text, &machine(radius), Box::new(NoLibrary), Options::default()).1
    };
    let pocket = "POCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,0,11)";
    assert_eq!(codes(pocket, 0.0), ["E0218:3"]);
    assert_eq!(codes(pocket, 9.0), ["E0218:3"]);
    assert_eq!(codes("POCKET4(20,0,2,-7,5,30,30,3,0.5,0,500,200,0,11)", 5.0), ["E0218:3"]);
    assert_eq!(codes("SLOT1(20,0,2,-6,,3,30,12,0,0,15,30,0,100,500,2.5,2,0.3,0)", 7.0), ["E0218:3"]);
    assert_eq!(codes("LONGHOLE(20,0,2,-6,,3,7,0,0,15,30,0,100,500,2.5)", 4.0), ["E0218:3"]);
    assert_eq!(codes("POCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,0,15)", 5.0), ["E0201:3"]);
    assert_eq!(codes("CYCLE72(\"A:B\",20,0,2,-6,0,0,0,800,200,1,41,2,6,900,3,4)", 5.0), ["E0211:3"]);
    assert_eq!(codes("CYCLE72(\"NOWHERE\",20,0,2,-6,0,0,0,800,200,1,41,2,6,900,3,4)", 5.0), ["E0212:3"]);
    assert_eq!(
        codes("CYCLE72(\"RIM\",20,0,2,-6,0,0,0,800,200,1,41,2,6,900,3,4)\nM30\n%_N_RIM_SPF\nG1\nM17", 5.0),
        ["E0218:3"]
    );
    assert_eq!(codes("POCKET3(20,0,2,-10,-60,40,8,60,40,20,4,0.5,0.2,500,200,0,11)", 5.0), ["E0201:3"]);
    assert_eq!(codes("POCKET3(20,0,2,-10,60,40,8,60,40,20,4,0.5,0.2,500,200,0,21)", 5.0), ["E0201:3"]);
}

#[test]
fn a_correction_says_that_the_strokes_of_a_milling_cycle_are_its_own() {
    let axes = "[machine]\nname = \"m\"\ntopology = \"wFXYZSt\"\ncontroller = \"CONTROL\"\n[axis.X]\ndirection = [1, 0, 0]\n[axis.Y]\n\
        direction = [0, 1, 0]\n[axis.Z]\ndirection = [0, 0, 1]\n[[tool]]\nnumber = 1\nlength_mm = 50\nradius_mm = 5\n\
        [[motion]]\ncomponent = \"EXX\"\nkind = \"polynomial\"\ncoefficients = [0, 3e-5]\n";
    let pocket = "POCKET3(50,0,2,-5,40,30,8,XX,15,0,2,0,0,300,100,0,11,2)";
    let [first, second] = ["60", "160"].map(|x| pocket.replace("XX", x));
    for (control, program, names, comments) in [
        (
            "sinumerik",
            format!("G17 G90\nT1 M6\nD1\nS1000 M3 F500\nG0 X0 Y0 Z50\n{first}\nCYCLE81(50,0,2,-5)\n{second}\nG0 Z50\nM30\n"),
            "POCKET3 (lines 6, 8)",
            [";POCKET3 of line 6: passes by ncfix", ";POCKET3 of line 8: passes by ncfix"],
        ),
        (
            "grundig",
            "%PM9001\nN9001\nN1 G17 T1 M6\nN2 G51\nN3 S1000 F500 M3\nN4 G0 X0 Y0 Z50\nN5 G87 X40 Y30 Z-8 B2 K3 I60 R6 F300\n\
             N6 G79 X50 Y50 Z0\nN7 G79 X150 Y50 Z0\nN8 G0 Z50\nN9 M30\n"
                .to_owned(),
            "G87 (lines 8, 9)",
            ["(G87 OF LINE 8: PASSES BY NCFIX)", "(G87 OF LINE 9: PASSES BY NCFIX)"],
        ),
    ] {
        let shop = Shop::new().file("m.toml", axes.replace("CONTROL", control)).file("p.nc", &program);
        let run = shop.run(["p.nc", "-o", "o.nc", "--machine", "m.toml"]);
        assert!(run.code == 0 && run.stderr.contains("W0239") && run.stderr.contains(names), "{run:?}");
        assert!(!run.stderr.contains("CYCLE81"), "a drilling cycle is that of the control: {run:?}");
        let text = shop.text("o.nc");
        let places = comments.map(|comment| text.find(comment).unwrap_or_else(|| panic!("{comment}\n{text}")));
        assert!(places[0] < places[1], "{text}");
        // The comments are no difference.
        let verified = shop.run(["verify", "p.nc", "o.nc", "--machine", "m.toml"]);
        assert!(verified.code == 0 && !verified.stderr.contains("error["), "{verified:?}");
        // `check` says what a correction would say.
        assert!(shop.run(["check", "p.nc", "--machine", "m.toml"]).stderr.contains("W0239"));
    }
}
