//! Height map of `RepRapFirmware` (Duet), `heightmap.csv`: a line with the version, a line of names, their values, then a row of heights in mm for each Y.
//!
//! Layout: `HeightMap::SaveToFile` of `RepRapFirmware`. Versions 1 and 2 have `xmin … xnum`, later files of version 2 also `axis0,axis1,min0 … num1`. A point
//! that was not probed is a `0` without decimals.

use std::collections::HashMap;

use ncfix_base::csv::DecimalSign;

use super::InstrumentFormat;
use super::height_map::{Probed, flat};
use crate::grid;
use crate::text::DecodedText;
use crate::unit::ReadingUnit;

/// Beginning of the file.
const MARK: &str = "RepRapFirmware height map file";
/// Largest number of points on a side: the firmware permits 41.
const MOST: f64 = 1000.0;

pub(super) const FORMAT: InstrumentFormat = InstrumentFormat {
    name: "reprap-map",
    title: "height map of RepRapFirmware (Duet): heightmap.csv",
    needs: "flat-reference at tool",
    recognize: |text| u8::from(first(text).is_some_and(|line| line.starts_with(MARK))) * 3,
    read: |inquiry| {
        let help = "give the file as the firmware saved it";
        let found = points(inquiry.text).map_err(|(message, line)| inquiry.refused(message, help, line))?;
        if found.is_empty() {
            return Err(inquiry.refused("the map has no probed point", help, 0));
        }
        // The firmware saves millimeters only.
        flat(inquiry, found, Some((ReadingUnit::Length("mm", 1.0), 0)))
    },
};

fn first(text: &DecodedText) -> Option<&str> {
    text.lines().map(|(_, line, _)| line.trim()).find(|line| !line.is_empty())
}

/// The probed points, or what is wrong with its line.
fn points(text: &DecodedText) -> Result<Vec<Probed>, (String, usize)> {
    let mut lines = text.lines().filter(|(_, line, _)| !line.trim().is_empty()).skip(1);
    let cells = |line: &str| line.split(',').map(|cell| cell.trim().to_lowercase()).collect::<Vec<String>>();
    let cut = || ("the map ends before its values".to_owned(), 0);
    let (_, names, _) = lines.next().ok_or_else(cut)?;
    let (at, values, _) = lines.next().ok_or_else(cut)?;
    let known: HashMap<String, String> = cells(names).into_iter().zip(cells(values)).collect();
    for (key, axis) in [("axis0", "x"), ("axis1", "y")] {
        if let Some(other) = known.get(key).filter(|name| *name != axis) {
            return Err((
                format!("the map is over the axis {}, not {}", other.to_uppercase(), axis.to_uppercase()),
                at,
            ));
        }
    }
    let value = |keys: [&str; 3]| {
        let text = keys.iter().find_map(|key| known.get(*key));
        let number = text.and_then(|text| grid::number(text, DecimalSign::Point));
        number.ok_or_else(|| (format!("the map has no {}", keys[0]), at))
    };
    let [low_x, low_y] = [value(["xmin", "min0", ""])?, value(["ymin", "min1", ""])?];
    let [step_x, step_y] = [value(["xspacing", "spacing0", "spacing"])?, value(["yspacing", "spacing1", "spacing"])?];
    let [count_x, count_y] = [value(["xnum", "num0", ""])?, value(["ynum", "num1", ""])?];
    if !(1.0..=MOST).contains(&count_x) || !(1.0..=MOST).contains(&count_y) || step_x <= 0.0 || step_y <= 0.0 {
        return Err(("the map has no grid".to_owned(), at));
    }
    let [high_x, high_y] = [value(["xmax", "max0", ""])?, value(["ymax", "max1", ""])?];
    for (name, low, high, step, count) in [("X", low_x, high_x, step_x, count_x), ("Y", low_y, high_y, step_y, count_y)]
    {
        // The firmware fits as many points of this spacing as it can between the ends, and prints two decimals.
        let slack = 0.01 * count;
        if high < low || (count - 1.0) * step > high - low + slack || count * step < high - low - slack {
            let message = format!("{count} points with the spacing {step} do not fit {name} from {low} to {high}");
            return Err((message, at));
        }
    }
    let (mut out, mut rows) = (Vec::new(), 0.0);
    for (number, line, _) in lines {
        let own = cells(line);
        if own.len() as f64 != count_x {
            return Err((format!("the row has {} heights instead of {count_x}", own.len()), number));
        }
        for (cell, column) in own.iter().zip(0_u32..) {
            let height = grid::number(cell, DecimalSign::Point);
            let height = height.ok_or_else(|| (format!("'{cell}' is not a height"), number))?;
            if cell != "0" {
                out.push(([low_x + step_x * f64::from(column), low_y + step_y * rows, height], number));
            }
        }
        rows += 1.0;
    }
    if rows != count_y {
        return Err((format!("the map has {rows} rows of heights instead of {count_y}"), at));
    }
    Ok(out)
}
