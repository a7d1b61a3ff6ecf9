//! Directions of approach that only the order of several rows tells: a cycle of ISO 230-2 reads its end targets twice.
//!
//! In 0, 100, 200, 200, 100, 0 the axis overruns the end target between its two readings and comes back, so the second reading belongs to the way back. The
//! readings of one component in a run are blocks at one position. Every block on the way has n readings. A block at which the motion turns then has n if
//! the target was read on one way only, and 2 n if it was read on both. A block of another size leaves it open: its direction is unknown after the first n.

use ncfix_base::geometry::Axis;

use super::DataSet;

/// Positions closer than this are one target, mm or rad: below the last digit of every file.
const SAME: f64 = 1e-9;

/// Consecutive readings at one position.
#[derive(Clone, Copy)]
struct Block {
    /// Its first reading in the series.
    first: usize,
    /// Number of its readings.
    count: usize,
    /// Position, mm or rad.
    at: f64,
}

/// The readings of one component in a run.
struct ReadSeries {
    /// Indices of set-up and run, and the number of the target.
    key: (usize, usize, usize),
    axis: Axis,
    /// Their rows.
    rows: Vec<usize>,
}

/// Sets the directions of readings of single components at repeated end targets. `is_stated` is `true` for an axis whose directions the table states.
pub(super) fn turn_at_ends(data: &mut DataSet, is_stated: impl Fn(Axis) -> bool) {
    let mut series: Vec<ReadSeries> = Vec::new();
    for (row, observation) in data.observations.iter().enumerate() {
        let Some(axis) = observation.motion_axis() else { continue };
        if is_stated(axis) {
            continue;
        }
        let key = (observation.setup, observation.run, observation.target.unwrap_or(0));
        match series.iter_mut().rev().find(|known| known.key == key) {
            Some(known) => known.rows.push(row),
            None => series.push(ReadSeries { key, axis, rows: vec![row] }),
        }
    }
    for ReadSeries { axis, rows, .. } in series {
        let places: Vec<f64> =
            rows.iter().filter_map(|row| data.observations.get(*row)).map(|own| own.reading.position[axis]).collect();
        for (place, sense) in turned(&places) {
            if let Some(observation) = rows.get(place).and_then(|row| data.observations.get_mut(*row)) {
                observation.reading.state.direction[axis.slot()] = sense;
            }
        }
    }
}

/// The readings of a series whose direction differs from that of the last change of position, with their direction; 0 if it is unknown.
fn turned(places: &[f64]) -> Vec<(usize, i8)> {
    let mut blocks: Vec<Block> = Vec::new();
    for (first, &at) in places.iter().enumerate() {
        match blocks.last_mut().filter(|block| (block.at - at).abs() < SAME) {
            Some(block) => block.count += 1,
            None => blocks.push(Block { first, count: 1, at }),
        }
    }
    let way = |from: &Block, to: &Block| if to.at > from.at { 1 } else { -1 };
    let (mut on_the_way, mut turns): (Vec<Block>, Vec<(Block, i8)>) = Default::default();
    for three in blocks.windows(3) {
        let [before, own, after] = three else { continue };
        let next = way(own, after);
        if way(before, own) == next { on_the_way.push(*own) } else { turns.push((*own, next)) }
    }
    let (Some(start), Some(end)) = (blocks.first(), blocks.last()) else { return Vec::new() };
    let count = on_the_way.first().map_or(start.count, |block| block.count);
    let is_regular = on_the_way.iter().all(|block| block.count == count);
    let mut out = Vec::new();
    let mut set = |from: usize, to: usize, sense: i8| out.extend((from..to).map(|reading| (reading, sense)));
    for (block, next) in &turns {
        let until = block.first + block.count;
        if is_regular && block.count == 2 * count {
            set(block.first + count, until, *next);
        } else if block.count > 1 && !(is_regular && block.count == count) {
            set(block.first + 1, until, 0);
        }
    }
    // A cycle that reads every end target twice and ends where it began was there on both ways: its first readings belong to the way out.
    let is_closed = blocks.len() > 2 && (start.at - end.at).abs() < SAME && start.count == count && end.count == count;
    let is_twice = !turns.is_empty() && turns.iter().all(|(block, _)| block.count == 2 * count);
    if let (true, true, true, Some(second)) = (is_regular, is_closed, is_twice, blocks.get(1)) {
        set(start.first, start.first + start.count, way(start, second));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The directions of readings at these positions: those of the last change of position, as far as no turn changes them.
    fn directions(places: &[f64]) -> Vec<i8> {
        let mut last = 0;
        let mut out = vec![0];
        for pair in places.windows(2) {
            let step = pair[1] - pair[0];
            last = if step > 0.0 { 1 } else { -i8::from(step < 0.0) } + last * i8::from(step == 0.0);
            out.push(last);
        }
        turned(places).into_iter().for_each(|(reading, sense)| out[reading] = sense);
        out
    }

    #[test]
    fn a_repeated_end_target_is_the_turn() {
        assert_eq!(directions(&[0.0, 100.0, 200.0, 200.0, 100.0, 0.0]), [1, 1, 1, -1, -1, -1]);
        // Two cycles without a label.
        let twice = [0.0, 100.0, 200.0, 200.0, 100.0, 0.0, 0.0, 100.0, 200.0, 200.0, 100.0, 0.0];
        assert_eq!(directions(&twice), [1, 1, 1, -1, -1, -1, 1, 1, 1, -1, -1, -1]);
        // Two readings at each target and way.
        let pairs = [0.0, 0.0, 100.0, 100.0, 200.0, 200.0, 200.0, 200.0, 100.0, 100.0, 0.0, 0.0];
        assert_eq!(directions(&pairs), [1, 1, 1, 1, 1, 1, -1, -1, -1, -1, -1, -1]);
    }

    #[test]
    fn what_the_order_does_not_tell_is_unknown() {
        // A turn that is read once, and the start of a way without a way back.
        assert_eq!(directions(&[0.0, 100.0, 200.0, 100.0, 0.0]), [0, 1, 1, -1, -1]);
        assert_eq!(directions(&[0.0, 100.0, 200.0]), [0, 1, 1]);
        // Two readings at rest at each target, and the end target on one way only.
        let rest = [0.0, 0.0, 100.0, 100.0, 200.0, 200.0, 100.0, 100.0];
        assert_eq!(directions(&rest), [0, 0, 1, 1, 1, 1, -1, -1]);
        // Three readings at the end, where one is read on the way.
        assert_eq!(directions(&[0.0, 100.0, 200.0, 200.0, 200.0, 100.0, 0.0]), [0, 1, 1, 0, 0, -1, -1]);
    }
}
