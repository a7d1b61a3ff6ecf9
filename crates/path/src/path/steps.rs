//! The largest fixed step that keeps a residual (Spaan, ch. 7: 20 mm for 5 µm on his machine).
//!
//! Lines are divided as [`Subdivision::Step`](super::Subdivision::Step) divides them. The ends of the pieces are corrected exactly, and the axes move
//! straight between them. The residual is the distance of the tip from the nominal line at the same parameter, by the usual forward function.
//! Rounding is excluded: it does not depend on the step.

use ncfix_base::geometry::{AxisVector, Vector};
use ncfix_machine::machine::{Kinematics, State, TipPath};
use ncfix_machine::snc::{Origin, Turning};
use ncfix_model::{Model, Solve};

use super::Rotary;
use super::check::Sampler;
use super::cut::next_step;
use super::prediction::sample_place;
use super::route::Route;

/// The smallest step tried, mm: a control executes such pieces without slowing down.
const SMALLEST_MM: f64 = 0.5;
/// Steps of the series per doubling.
const STEPS_PER_OCTAVE: f64 = 2.0;
/// Ratio of the bounds at which the search ends.
const NEAR_ENOUGH: f64 = 1.002;
/// Maximum examined pieces of one line, spread over it.
const MOST_PIECES: u32 = 2048;

/// A straight path of the axes, or of the tip in the workpiece, whose residual is examined.
#[derive(Clone, Debug)]
pub struct StraightLine {
    ends: [AxisVector; 2],
    tip: Option<LineOfTip>,
    tool_mm: Vector,
    leading_mm: f64,
    /// The block of the program that it comes from, if any.
    pub origin: Option<Origin>,
}

/// The line of a tip in the workpiece: turning of the tool, and the vector of the tool that the control follows, mm.
#[derive(Clone, Copy, Debug)]
pub(super) struct LineOfTip {
    pub(super) turning: Turning,
    pub(super) tool_mm: Vector,
}

impl StraightLine {
    /// A line between two axis commands, examined with a tool; `tip` if the tip follows it in the workpiece.
    pub(super) fn new(
        ends: [AxisVector; 2],
        tip: Option<LineOfTip>,
        kinematics: &Kinematics,
        tool_mm: Vector,
        origin: Option<Origin>,
    ) -> StraightLine {
        let mut line = StraightLine { ends, tip, tool_mm, leading_mm: 0.0, origin };
        line.leading_mm = line.route(kinematics).leading_mm();
        line
    }

    /// Its start, mm and rad.
    #[must_use]
    pub fn start(&self) -> &AxisVector {
        &self.ends[0]
    }

    /// Its end, mm and rad.
    #[must_use]
    pub fn end(&self) -> &AxisVector {
        &self.ends[1]
    }

    /// Travel of the axis that moves farthest, mm, rotary axes at an arm of 100 mm.
    #[must_use]
    pub fn leading_mm(&self) -> f64 {
        self.leading_mm
    }

    /// The path between its ends.
    fn route<'k>(&self, kinematics: &'k Kinematics) -> Route<'k> {
        self.way(kinematics, self.ends)
    }

    /// The path that a control takes between two commands instead of a part of it.
    fn way<'k>(&self, kinematics: &'k Kinematics, [start, end]: [AxisVector; 2]) -> Route<'k> {
        match &self.tip {
            Some(LineOfTip { turning, tool_mm }) => {
                let tip = TipPath::new(kinematics, *turning == Turning::Vector, [&start, &end], tool_mm);
                Route::of_tip(start, end, None, tip)
            }
            None => Route::new(start, end, None),
        }
    }
}

/// The largest residual of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepResidual {
    /// Distance of the tip from the line, mm.
    pub max_mm: f64,
    /// Index of the line, from 0.
    pub line: usize,
    /// Position on it, mm and rad.
    pub at: AxisVector,
    /// Ends of pieces that could not be corrected.
    pub failures: u64,
}

/// A step of the series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesRow {
    /// Step, mm.
    pub step_mm: f64,
    /// Residual of this step, mm.
    pub residual_mm: f64,
    /// Largest residual of this and all smaller steps, mm: a periodic error may look small if a step coincides with its period.
    pub largest_mm: f64,
}

/// Steps that keep the residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ResidualSteps {
    /// Every line may stay in one piece.
    Any,
    /// Steps up to this one, mm.
    UpTo(f64),
    /// Not even the smallest step tried.
    None,
}

/// Result of the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Steps {
    /// The series, steps increasing.
    pub rows: Vec<SeriesRow>,
    /// Admissible steps.
    pub answer: ResidualSteps,
    /// The largest residual at the answer: at the largest step for [`ResidualSteps::Any`], at the smallest for [`ResidualSteps::None`].
    pub worst: StepResidual,
}

/// Tries steps on lines.
pub struct StepTrial<'a> {
    model: &'a Model,
    sampler: Sampler,
    solve: Solve,
    scratch: Vec<f64>,
}

impl<'a> StepTrial<'a> {
    /// A trial on a model.
    #[must_use]
    pub fn new(model: &'a Model, rotary: Rotary) -> StepTrial<'a> {
        let solve = if rotary == Rotary::Hold { Solve::PositionOnly } else { Solve::Full };
        StepTrial { model, sampler: Sampler::new(model), solve, scratch: Vec::new() }
    }

    /// Finds the largest step whose residual stays within `limit_mm`. `note` receives the completed share (0 … 1) of the series.
    pub fn search(&mut self, lines: &[StraightLine], limit_mm: f64, mut note: impl FnMut(f64)) -> Steps {
        let longest_mm = lines.iter().map(StraightLine::leading_mm).fold(0.0, f64::max);
        let series = series(longest_mm);
        // The effort of a step is proportional to its pieces.
        let total: f64 = series.iter().map(|step_mm| 1.0 / step_mm).sum();
        let mut done = 0.0;
        let mut rows: Vec<SeriesRow> = Vec::with_capacity(series.len());
        let mut found = Vec::with_capacity(series.len());
        for step_mm in series {
            let residual = self.residual(lines, step_mm, |share| note((done + share / step_mm) / total));
            done += 1.0 / step_mm;
            let before = rows.last().map_or(0.0, |row| row.largest_mm);
            let (residual_mm, largest_mm) = (residual.max_mm, residual.max_mm.max(before));
            rows.push(SeriesRow { step_mm, residual_mm, largest_mm });
            found.push(residual);
        }
        let is_good = |row: &SeriesRow| row.largest_mm <= limit_mm;
        let good = rows.iter().take_while(|row| is_good(row)).count();
        let found_at = |index: usize| found.get(index).copied().unwrap_or_default();
        let bounds = good.checked_sub(1).and_then(|last| Some((rows.get(last)?.step_mm, rows.get(good)?.step_mm)));
        let (answer, worst) = match bounds {
            Some((mut low, mut high)) => {
                let mut worst = found_at(good - 1);
                while high / low > NEAR_ENOUGH {
                    let middle = (low * high).sqrt();
                    let residual = self.residual(lines, middle, |_| note(1.0));
                    if residual.max_mm <= limit_mm {
                        (low, worst) = (middle, residual);
                    } else {
                        high = middle;
                    }
                }
                (ResidualSteps::UpTo(low), worst)
            }
            None if good == 0 && !rows.is_empty() => (ResidualSteps::None, found_at(0)),
            None => (ResidualSteps::Any, found_at(good.saturating_sub(1))),
        };
        Steps { rows, answer, worst }
    }

    /// The largest residual of a step on lines. `note` receives the completed share of the lines.
    pub fn residual(&mut self, lines: &[StraightLine], step_mm: f64, mut note: impl FnMut(f64)) -> StepResidual {
        let mut worst = StepResidual::default();
        for (number, line) in lines.iter().enumerate() {
            self.cut(line, number, step_mm, &mut worst);
            note((number + 1) as f64 / lines.len() as f64);
        }
        worst
    }

    /// The residual of a line in one piece, mm.
    pub(super) fn bend_mm(&mut self, line: &StraightLine) -> f64 {
        let mut worst = StepResidual::default();
        self.cut(line, 0, f64::INFINITY, &mut worst);
        worst.max_mm
    }

    /// Cuts a line and records the largest residual of its pieces.
    fn cut(&mut self, line: &StraightLine, number: usize, step_mm: f64, worst: &mut StepResidual) {
        let leading = line.leading_mm;
        if leading.is_nan() || leading <= 0.0 || self.model.is_empty() {
            return;
        }
        let route = line.route(self.model.kinematics());
        let mut state = State::default();
        state.note_motion(&route.start, &route.end);
        let mut piece = Piece { line, route, number, state, whole: self.sampler.whole(&route), end: None };
        let pieces = (leading / step_mm).ceil();
        if pieces > f64::from(MOST_PIECES) {
            for k in 0..MOST_PIECES {
                let from = (sample_place(k, MOST_PIECES) * pieces).floor() * step_mm / leading;
                piece.end = None;
                self.measure(&mut piece, [from, (from + step_mm / leading).min(1.0)], worst);
            }
            return;
        }
        let mut from = 0.0;
        while from < 1.0 {
            let to = if step_mm < leading { next_step(leading, from, step_mm) } else { 1.0 };
            self.measure(&mut piece, [from, to], worst);
            from = to;
        }
    }

    /// Measures one piece.
    fn measure(&mut self, piece: &mut Piece<'_>, between: [f64; 2], worst: &mut StepResidual) {
        let route = piece.route;
        let [from, to] = between;
        let start = piece.end.or_else(|| self.correct(piece, from, &AxisVector::ZERO));
        let guess = start.map_or(AxisVector::ZERO, |command| command - route.at(from));
        piece.end = self.correct(piece, to, &guess);
        let (Some(start), Some(end)) = (start, piece.end) else {
            worst.failures += 1;
            return;
        };
        let way = piece.line.way(self.model.kinematics(), [start, end]);
        self.sampler.fractions((&route, piece.whole), between, &way, &mut self.scratch);
        for &fraction in &self.scratch {
            let nominal = route.at(from + (to - from) * fraction);
            let command = way.at(fraction);
            let error = self.model.tip_error_mm(&nominal, &command, &piece.line.tool_mm, &piece.state);
            let size_mm = error.norm();
            if size_mm > worst.max_mm {
                (worst.max_mm, worst.line, worst.at) = (size_mm, piece.number, nominal);
            }
        }
    }

    /// The corrected command at a place of a line.
    fn correct(&self, piece: &Piece<'_>, parameter: f64, guess: &AxisVector) -> Option<AxisVector> {
        let nominal = piece.route.at(parameter);
        let mut start = nominal + *guess;
        if self.solve == Solve::PositionOnly {
            for axis in ncfix_base::geometry::ROTARY_AXES {
                start[axis] = nominal[axis];
            }
        }
        self.model.solve(&nominal, &piece.line.tool_mm, &piece.state, &start, self.solve).ok()
    }
}

/// Progress on a line.
struct Piece<'l> {
    line: &'l StraightLine,
    route: Route<'l>,
    number: usize,
    /// Direction of motion along the line.
    state: State,
    /// Number of samples of the whole line.
    whole: f64,
    /// The corrected end of the last piece.
    end: Option<AxisVector>,
}

/// Steps from the smallest to the length of the longest line, at a constant ratio.
fn series(longest_mm: f64) -> Vec<f64> {
    if longest_mm.is_nan() || longest_mm <= SMALLEST_MM {
        return Vec::from_iter((longest_mm > 0.0).then_some(longest_mm));
    }
    let octaves = (longest_mm / SMALLEST_MM).log2();
    // Small: travels are finite and doubles have a thousand octaves.
    let count = (octaves * STEPS_PER_OCTAVE).ceil().max(1.0) as u32;
    let mut steps: Vec<f64> =
        (0..count).map(|k| SMALLEST_MM * (octaves * f64::from(k) / f64::from(count)).exp2()).collect();
    steps.push(longest_mm);
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_runs_from_half_a_millimeter_to_the_whole_way() {
        let steps = series(700.0);
        assert_eq!((steps.first(), steps.last()), (Some(&0.5), Some(&700.0)));
        assert!(steps.windows(2).all(|pair| pair[1] > pair[0] && pair[1] / pair[0] < 1.4143), "{steps:?}");
        assert_eq!(series(0.2), [0.2]);
        assert!(series(0.0).is_empty() && series(f64::NAN).is_empty());
    }

    #[test]
    fn each_line_is_told_when_it_is_done() {
        let machine = crate::path::tests::demo();
        let lines: Vec<StraightLine> = crate::path::volume(&machine, &Vector::zeros()).into_iter().take(4).collect();
        let model = Model::new(&machine, &ncfix_model::ErrorModel::default());
        let mut shares = Vec::new();
        StepTrial::new(&model, Rotary::Correct).residual(&lines, 100.0, |share| shares.push(share));
        assert_eq!(shares, [0.25, 0.5, 0.75, 1.0]);
    }
}
