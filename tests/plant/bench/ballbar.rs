//! Ball-bar: circles in three planes, both senses, several feeds and radii (ISO 230-4).

use super::{add_setup, to_point};
use crate::plant::random::Random;
use crate::plant::row::{Circle, Column, Kind, Row, Sheet};

/// The circles of one afternoon; every plane and radius is a mounting of its own. `step` is the angle between rows in degrees; every other
/// seed samples in time instead, every fourth has arcs of 220° in the planes of the spindle.
pub(super) fn sheet(random: &mut Random, stem: &str, feeds: &[f64], radii: &[f64], step: f64, seed: u64) -> Sheet {
    let columns = [Column::Time, Column::Feed];
    let mut sheet = Sheet::new(stem, Kind::Ballbar, 0.3e-3, &["centre", "length"], &columns);
    sheet.wander = [0.4, 150.0];
    let mut clock = 0.0;
    for plane in [[0, 1], [1, 2], [2, 0]] {
        let name = ["XY", "YZ", "ZX"][plane[0]];
        for &radius in radii {
            let setup = add_setup(&mut sheet, &format!("{name}{radius}"));
            let round = |x: f64| (x * 10.0).round() / 10.0;
            let centre = [350.0, 250.0, 180.0].map(|x| round(x + random.between(-20.0, 20.0)));
            sheet.setups[setup].centre = centre;
            sheet.setups[setup].length = radius;
            for &feed in feeds {
                let speed = feed / 60.0;
                // In time the slowest feed has the given step.
                let coarser = if seed % 2 == 1 { feed / feeds[0] } else { 1.0 };
                let by = (step * coarser).to_radians();
                let is_part = seed % 4 == 3 && plane != [0, 1];
                let (begin, sweep) = if is_part { (160.0_f64, 220.0) } else { (0.0, 360.0) };
                // The arc of the YZ plane lies above, as that of ZX does.
                let begin = if is_part && plane[0] == 1 { begin + 180.0 } else { begin };
                let begin = if is_part && plane[0] == 2 { begin + 90.0 } else { begin };
                let overlap = 15.0_f64;
                for sense in [1.0, -1.0] {
                    let from = if sense > 0.0 { begin - overlap } else { begin + sweep + overlap };
                    let count = ((sweep + 2.0 * overlap).to_radians() / by).floor() as usize;
                    for k in 0..=count {
                        let angle = from.to_radians() + sense * by * k as f64;
                        let (s, c) = angle.sin_cos();
                        let mut row = Row { setup, feed, tool: [0.0, 0.0, -120.0], ..Row::default() };
                        row.t = clock + by * k as f64 * radius / speed;
                        let mut point = centre;
                        point[plane[0]] += radius * c;
                        point[plane[1]] += radius * s;
                        to_point(&mut row, point);
                        let (a, b) = (plane[0], plane[1]);
                        (row.v[a], row.v[b]) = (-sense * speed * s, sense * speed * c);
                        (row.a[a], row.a[b]) = (-speed * speed / radius * c, -speed * speed / radius * s);
                        for axis in plane {
                            row.dir[axis] = sense_of(row.v[axis], row.a[axis]);
                        }
                        row.circle = Some(Circle { plane, angle, sense, radius });
                        row.run = format!("{name}-{radius}-{feed}-{}", if sense > 0.0 { "ccw" } else { "cw" });
                        sheet.rows.push(row);
                    }
                    clock = sheet.rows.last().unwrap().t + 25.0;
                }
            }
            clock += 300.0;
        }
    }
    sheet
}

/// The sense of the motion that led to a point; on a reversal it is the one before it.
fn sense_of(v: f64, a: f64) -> f64 {
    if v.abs() > 1e-9 { v.signum() } else { -a.signum() }
}
