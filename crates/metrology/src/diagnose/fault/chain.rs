//! A machine file with another order of the bodies than the machine, so that its known errors act at the wrong places.
//!
//! The check tests all orders of the linear axes and the foundation that keep the meaning of positions. It reports an order only if no single cause
//! explains the readings nearly as well: with the right bodies, the known errors predict all readings without any fit.

use super::single::{MOST, ROWS, by_one_cause, left, thinned};
use super::{DataDefect, DefectCheck, DefectKind, Then, View, median};
use crate::measure::data::DataSet;
use ncfix_base::geometry::Axis;
use ncfix_machine::machine::{Machine, Topology};

pub(super) const CHECK: DefectCheck = DefectCheck {
    name: "another machine",
    made_by: "a machine file with another order of the axes than the machine, or the file of a similar machine",
    shown_by: "readings that the known errors predict within the noise with another order of the axes, but not with the order of the file",
    source: "likelihood over permutations",
    look,
};

/// Largest mean squared residual of readings that fit, in squares of the noise.
const FITS: f64 = 1.4;
/// Smallest ratio of the residual with the stated order to the best residual.
const WORSE: f64 = 1.5;
/// Smallest difference of the residuals, in squares of the noise, also with the best single cause.
const SURELY: f64 = 24.0;
/// Orders within this difference are equally good.
const TIE: f64 = 12.0;
/// Maximum number of named orders.
const NAMED: usize = 3;

fn look(view: &View<'_, '_>, out: &mut Vec<DataDefect>) {
    let scene = view.scene;
    let ratios: Vec<f64> =
        view.sets().filter_map(|(set, _)| view.trails.get(set)?.noise_ratio()).map(|ratio| ratio * ratio).collect();
    let noise = if ratios.is_empty() { 1.0 } else { median(ratios).max(1e-6) };
    let sets: Vec<DataSet> = view.sets().map(|(_, data)| thinned(data, ROWS)).collect();
    let Some((first, _)) = view.sets().next() else { return };
    let Some(as_is) = left(scene.machine, scene, &sets, MOST) else { return };
    let count = as_is.values.len() as f64;
    if as_is.squares < WORSE * noise * count {
        return;
    }
    let mut others: Vec<(f64, String)> = Vec::new();
    for machine in machines(scene.machine) {
        if let Some(left) = left(&machine, scene, &sets, MOST).filter(|left| left.values.len() == as_is.values.len()) {
            others.push((left.squares, machine.topology.to_string()));
        }
    }
    others.sort_by(|a, b| a.0.total_cmp(&b.0));
    let Some(&(best, _)) = others.first() else { return };
    if best > FITS * noise * count || as_is.squares < WORSE * best || as_is.squares - best < SURELY * noise {
        return;
    }
    let single = by_one_cause(scene.machine, &sets, &as_is);
    if single - best < SURELY * noise {
        return;
    }
    let names: Vec<&str> = others
        .iter()
        .filter(|(left, _)| left - best < TIE * noise)
        .map(|(_, name)| name.as_str())
        .take(NAMED)
        .collect();
    let times = |squares: f64| (squares / count / noise).sqrt();
    let evidence = format!(
        "with the chain of the machine file ({}) the residual is {:.1} times the noise of the readings, with {} {:.1} times; no single cause explains as much ({:.1} times)",
        scene.machine.topology,
        times(as_is.squares),
        names.join(" or "),
        times(best),
        times(single)
    );
    let rows = view.scene.sets.get(first).map_or(0, |data| data.observations.len().saturating_sub(1));
    out.push(DataDefect {
        kind: DefectKind::Topology,
        set: first,
        name: scene.machine.name.clone(),
        what: format!("another order of the axes: {}", names.join(" or ")),
        rows: [0, rows],
        evidence,
        then: Then::Refuse,
    });
}

/// The machine with every other order of its linear axes and the foundation; rotary axes keep their places.
fn machines(machine: &Machine) -> Vec<Machine> {
    // From the workpiece to the tool; `None` is the foundation.
    let inner = machine.topology.workpiece.iter().rev().copied().map(Some);
    let chain: Vec<Option<Axis>> = inner.chain([None]).chain(machine.topology.tool.iter().copied().map(Some)).collect();
    let moves: Vec<usize> = (0..chain.len()).filter(|&k| chain[k].is_none_or(|axis| !axis.is_rotary())).collect();
    let mut out = Vec::new();
    for order in permutations(moves.len()) {
        let mut other = chain.clone();
        for (&to, &from) in moves.iter().zip(&order) {
            other[to] = chain[moves[from]];
        }
        if other == chain {
            continue;
        }
        let Some(foundation) = other.iter().position(Option::is_none) else { continue };
        let axes = |part: &[Option<Axis>]| part.iter().flatten().copied().collect::<Vec<Axis>>();
        let (mut workpiece, tool) = (axes(&other[..foundation]), axes(&other[foundation + 1..]));
        workpiece.reverse();
        let topology = Topology { workpiece, tool };
        let crosses = |axis: Axis| topology.branch(axis) != machine.topology.branch(axis);
        if chain.iter().flatten().any(|&axis| axis.is_rotary() && crosses(axis)) {
            continue;
        }
        let mut changed = machine.clone();
        // On the other side of the foundation a body moves in the opposite direction for the same command.
        for data in changed.axes.iter_mut().flatten().filter(|data| crosses(data.axis)) {
            data.direction = -data.direction;
        }
        changed.topology = topology;
        out.push(changed);
    }
    out
}

/// All permutations, or an empty list for too many items.
fn permutations(count: usize) -> Vec<Vec<usize>> {
    /// 24 orders.
    const MOST: usize = 4;
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..if count > MOST { 0 } else { count } {
        let longer = |one: &Vec<usize>| -> Vec<Vec<usize>> {
            let next = (0..count).filter(|k| !one.contains(k));
            next.map(|k| one.iter().copied().chain([k]).collect()).collect()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.retain(|one| one.len() == count);
    all
}
