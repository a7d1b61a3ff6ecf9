//! A plate with holes or balls in a square grid: every hole in alternating rows; one set-up for every tool and every position of the plate.

use super::builder::{Builder, PlanReach, observation};
use super::{PlanKind, PlanRefused, RowSpacing, Wishes, along_spindle, empty, kind};
use crate::measure::data::{Free, Observation, Setup};
use crate::measure::reading::Reading;
use ncfix_base::geometry::{Plane, Vector};
use ncfix_machine::machine::{Machine, State};
use ncfix_machine::snc::{Dwell, Kind};

/// The plan.
pub(super) const PLAN: PlanKind = PlanKind {
    name: "plate",
    title: "grid of holes in a plane; several tools and centers give several set-ups",
    wishes: &["plane", "center", "points", "every", "clearance", "feed", "dwell", "line"],
    spacing: RowSpacing::Length,
    has_setups: true,
    build,
};

fn build(machine: &Machine, wishes: &Wishes) -> Result<Builder, PlanRefused> {
    let mut grid = PlannedPlate::new(machine, wishes)?;
    let tools = if wishes.tools_mm.is_empty() { vec![wishes.tool_mm()] } else { wishes.tools_mm.clone() };
    for (number, tool_mm) in tools.iter().enumerate() {
        let places = if wishes.centres_mm.is_empty() {
            vec![wishes.centre_or_middle(machine, tool_mm)]
        } else {
            wishes.centres_mm.clone()
        };
        for (place, centre_mm) in places.iter().enumerate() {
            let mut label = format!("T{}", number + 1);
            if places.len() > 1 {
                label.push_str(&format!("P{}", place + 1));
            }
            grid.plan.retract()?;
            let setup = grid.mount(&label, centre_mm, tool_mm);
            grid.visit(setup, centre_mm, tool_mm, &label)?;
        }
    }
    Ok(grid.plan)
}

/// A plate plan under construction.
pub(super) struct PlannedPlate {
    pub(super) plan: Builder,
    plane: Plane,
    side: usize,
    pitch_mm: f64,
}

impl PlannedPlate {
    pub(super) fn new(machine: &Machine, wishes: &Wishes) -> Result<PlannedPlate, PlanRefused> {
        let planes = if wishes.planes.is_empty() { vec![Plane::XY] } else { wishes.planes.clone() };
        let &[plane] = planes.as_slice() else {
            return Err(PlanRefused(
                "a plate lies in one plane; make a plan for each, and evaluate them together (--with)".into(),
            ));
        };
        let [abscissa, ordinate, _] = plane.axes();
        let data = empty(kind("displacement")?, &[Free::Offset, Free::Rotation]);
        let mut plan = Builder::new(machine, wishes, data);
        plan.reads = [abscissa, ordinate].iter().fold([false; 3], |mut reads, axis| {
            if let Some(read) = reads.get_mut(axis.dimension()) {
                *read = true;
            }
            reads
        });
        plan.reach = PlanReach::Above {
            clearance_mm: wishes.clearance_mm.unwrap_or(20.0).max(0.0),
            above_mm: 0.0,
            retract: false,
            feed: wishes.feed.unwrap_or(2000.0),
        };
        plan.at_pose = match &wishes.line {
            Some(line) => vec![Kind::Verbatim(line.as_bytes().to_vec())],
            None => vec![Kind::Dwell(Dwell::Seconds(wishes.dwell_s.unwrap_or(3.0)))],
        };
        let side = wishes.points.unwrap_or(5).clamp(2, 200);
        Ok(PlannedPlate { plan, plane, side, pitch_mm: wishes.every.unwrap_or(50.0) })
    }

    fn hole(&self, setup: usize, centre_mm: &Vector, tool_mm: &Vector, [column, row]: [f64; 2]) -> Observation {
        let [abscissa, ordinate, _] = self.plane.axes();
        let half = (self.side - 1) as f64 / 2.0;
        let mut position = self.plan.at_tip(centre_mm, tool_mm);
        position[abscissa] += (column - half) * self.pitch_mm;
        position[ordinate] += (row - half) * self.pitch_mm;
        observation(Reading { position, tool_mm: *tool_mm, state: State::default() }, setup)
    }

    /// A set-up, and positions between the holes as further poses.
    pub(super) fn mount(&mut self, label: &str, centre_mm: &Vector, tool_mm: &Vector) -> usize {
        let setup = self.plan.data.setups.len();
        self.plan.side = self.side(tool_mm);
        if let Some(side) = self.plan.side {
            let letter = ["X", "Y", "Z"].get(side.iamax()).unwrap_or(&"");
            let sign = if side.sum() < 0.0 { "-" } else { "+" };
            self.plan.notes.push(format!("{label}: the plate is probed from its side {sign}{letter}"));
        }
        self.plan.data.setups.push(Setup { label: label.to_owned(), ..Setup::default() });
        self.plan.stop(&format!("set-up {label}: clear the path"));
        let gaps = self.side - 1;
        let between = (0..gaps * gaps).map(|number| [(number % gaps) as f64 + 0.5, (number / gaps) as f64 + 0.5]);
        let between: Vec<Observation> =
            between.map(|at| self.hole(setup, centre_mm, tool_mm, at)).filter(|row| self.is_inside(row)).collect();
        self.plan.candidates.extend(between);
        setup
    }

    /// The approach side of a plate along the spindle: the side of a lateral stylus, otherwise the positive side.
    fn side(&self, tool_mm: &Vector) -> Option<Vector> {
        let [_, _, across] = self.plane.axes();
        let normal = across.dimension();
        (normal != along_spindle(&self.plan.machine).0)
            .then(|| Vector::ith(normal, if tool_mm[normal] > 0.0 { -1.0 } else { 1.0 }))
    }

    fn is_inside(&self, row: &Observation) -> bool {
        self.plan.outside(&row.reading.position).is_none()
    }

    /// All holes, in alternating rows.
    pub(super) fn visit(
        &mut self,
        setup: usize,
        centre_mm: &Vector,
        tool_mm: &Vector,
        run: &str,
    ) -> Result<(), PlanRefused> {
        for row in 0..self.side {
            for column in 0..self.side {
                let column = if row.is_multiple_of(2) { column } else { self.side - 1 - column };
                let hole = self.hole(setup, centre_mm, tool_mm, [column as f64, row as f64]);
                self.plan.visit(&hole, run)?;
            }
        }
        Ok(())
    }
}
