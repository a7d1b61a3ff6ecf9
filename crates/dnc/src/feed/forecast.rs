//! Forecasts before the start whether a link delivers lines as fast as the control carries them out.
//!
//! The link sends a line when the window has room for it. It takes the time of its characters, or of an answer if every line waits for one. The control
//! carries out the lines one after the other. If a line arrives only after the line before it is done, the axes stand still: the control is starved.
//! Corrected programs have longer numbers and more lines, so a correction can starve a control that kept up before.

use std::collections::VecDeque;

/// Performance of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkRate {
    /// Characters per second; infinite if the line is not the limit.
    pub characters_per_s: f64,
    /// Time from the last character of a line to its answer, s; 0 on a link without answers.
    pub answer_s: f64,
    /// Maximum number of lines under way or waiting in the control.
    pub lines: usize,
    /// Maximum number of their bytes.
    pub bytes: usize,
}

/// A stretch of lines in which the control waits for the link.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stretch {
    /// First and last line, by number.
    pub lines: [u64; 2],
    /// First and last line of the source.
    pub source_lines: [u32; 2],
    /// Total time in which the axes stand still, s.
    pub starved_s: f64,
    /// Lines per second that the motion needs in this stretch.
    pub needed_per_s: f64,
    /// Lines per second that the link delivers in this stretch.
    pub given_per_s: f64,
}

/// Forecast of a transfer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Forecast {
    /// Number of lines.
    pub lines: u64,
    /// Bytes including line ends.
    pub bytes: u64,
    /// Duration of the motion if no line is late, s.
    pub motion_s: f64,
    /// Duration over this link, s.
    pub total_s: f64,
    /// Time in which the axes stand still because lines are missing, s.
    pub starved_s: f64,
    /// Minimum number of lines that wait in the busy control after the window was first full.
    pub lowest: Option<usize>,
    /// Worst stretches, worst first.
    pub stretches: Vec<Stretch>,
}

/// Maximum number of stretches that are kept.
const MOST_STRETCHES: usize = 20;
/// Number of lines between two late ones from which they belong to different stretches.
const APART: u64 = 20;
/// Delay that a control does not notice, s.
const UNNOTICED_S: f64 = 1e-3;

/// Makes a forecast line by line, in bounded memory.
#[derive(Clone, Debug)]
pub struct Forecaster {
    link: LinkRate,
    forecast: Forecast,
    /// Completion time of each line that has not been executed, s, and its bytes.
    waiting: VecDeque<(f64, usize)>,
    waiting_bytes: usize,
    /// Times when the link and the control become free, s.
    link_s: f64,
    control_s: f64,
    was_full: bool,
    current: Option<Open>,
}

#[derive(Clone, Copy, Debug)]
struct Open {
    stretch: Stretch,
    motion_s: f64,
}

impl Forecaster {
    /// Begins a forecast.
    #[must_use]
    pub fn new(link: LinkRate) -> Forecaster {
        Forecaster {
            link,
            forecast: Forecast::default(),
            waiting: VecDeque::new(),
            waiting_bytes: 0,
            link_s: 0.0,
            control_s: 0.0,
            was_full: false,
            current: None,
        }
    }

    /// Takes the next line: bytes with its end, its source line, and the time for which it keeps the control busy, s.
    pub fn line(&mut self, bytes: usize, source_line: u32, busy_s: f64) {
        let busy_s = if busy_s.is_finite() { busy_s.max(0.0) } else { 0.0 };
        // The link waits until the window has room.
        let mut from_s = self.link_s;
        while let Some(&(done_s, length)) = self.waiting.front() {
            let is_full = self.waiting.len() >= self.link.lines.max(1) || self.waiting_bytes + bytes > self.link.bytes;
            if !is_full && done_s > from_s {
                break;
            }
            if is_full {
                self.was_full = true;
                from_s = from_s.max(done_s);
            }
            self.waiting.pop_front();
            self.waiting_bytes -= length;
        }
        let takes_s = bytes as f64 / self.link.characters_per_s + self.link.answer_s;
        let there_s = from_s + takes_s;
        let number = self.forecast.lines + 1;
        // A line without duration does not interrupt any motion.
        let is_wanted = number > 1 && busy_s > 0.0;
        let starved_s = if is_wanted { (there_s - self.control_s).max(0.0) } else { 0.0 };
        let done_s = self.control_s.max(there_s) + busy_s;
        if self.was_full && busy_s > 0.0 {
            let at_work = self.waiting.iter().filter(|(done, _)| *done > there_s).count();
            let lowest = self.forecast.lowest.get_or_insert(usize::MAX);
            *lowest = (*lowest).min(at_work);
        }
        self.note(number, source_line, (starved_s, busy_s));
        self.waiting.push_back((done_s, bytes));
        self.waiting_bytes += bytes;
        (self.link_s, self.control_s) = (there_s, done_s);
        let forecast = &mut self.forecast;
        forecast.lines = number;
        forecast.bytes += bytes as u64;
        forecast.motion_s += busy_s;
        forecast.total_s = done_s;
        forecast.starved_s += starved_s;
    }

    fn note(&mut self, number: u64, source_line: u32, (starved_s, busy_s): (f64, f64)) {
        let is_late = starved_s > UNNOTICED_S;
        if let Some(open) = &mut self.current {
            if number - open.stretch.lines[1] <= APART {
                open.motion_s += busy_s;
                if is_late {
                    open.stretch.lines[1] = number;
                    // Loops and subprograms jump back.
                    let [first, last] = &mut open.stretch.source_lines;
                    (*first, *last) = ((*first).min(source_line), (*last).max(source_line));
                    open.stretch.starved_s += starved_s;
                }
                return;
            }
            self.close();
        }
        if is_late {
            let stretch =
                Stretch { lines: [number; 2], source_lines: [source_line; 2], starved_s, ..Stretch::default() };
            self.current = Some(Open { stretch, motion_s: busy_s });
        }
    }

    fn close(&mut self) {
        let Some(open) = self.current.take() else { return };
        let mut stretch = open.stretch;
        let count = (stretch.lines[1] - stretch.lines[0] + 1) as f64;
        let per_s = |seconds: f64| if seconds > 0.0 { count / seconds } else { f64::INFINITY };
        (stretch.needed_per_s, stretch.given_per_s) =
            (per_s(open.motion_s), per_s(open.motion_s + open.stretch.starved_s));
        let stretches = &mut self.forecast.stretches;
        let place = stretches.partition_point(|other| other.starved_s >= stretch.starved_s);
        stretches.insert(place, stretch);
        stretches.truncate(MOST_STRETCHES);
    }

    /// Returns the forecast of all lines so far.
    #[must_use]
    pub fn finish(mut self) -> Forecast {
        self.close();
        self.forecast
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 9600 Bd, 7E2: 873 characters per second.
    const SLOW: LinkRate = LinkRate { characters_per_s: 9600.0 / 11.0, answer_s: 0.0, lines: 5, bytes: 512 };

    fn forecast(link: LinkRate, count: u64, bytes: usize, busy_s: f64) -> Forecast {
        let mut forecaster = Forecaster::new(link);
        (0..count).for_each(|k| forecaster.line(bytes, k as u32 + 1, busy_s));
        forecaster.finish()
    }

    #[test]
    fn twenty_seven_lines_a_second_are_too_few_for_sixty() {
        // 32 characters per line: 27.3 lines/s; 1/60 s per block.
        let found = forecast(SLOW, 600, 32, 1.0 / 60.0);
        let late_s = 32.0 * 11.0 / 9600.0 - 1.0 / 60.0;
        assert!((found.starved_s - 599.0 * late_s).abs() < 1e-6, "{found:?}");
        assert!((found.total_s - (600.0 * 32.0 * 11.0 / 9600.0 + 1.0 / 60.0)).abs() < 1e-6);
        let [stretch] = found.stretches.as_slice() else { panic!("{found:?}") };
        assert_eq!((stretch.lines, stretch.source_lines), ([2, 600], [2, 600]));
        assert!((stretch.needed_per_s - 60.0).abs() < 0.2 && (stretch.given_per_s - 27.27).abs() < 0.1, "{stretch:?}");
    }

    #[test]
    fn a_window_carries_over_short_blocks_between_long_ones() {
        // 0.5 s, then four blocks of 10 ms: 37 ms each on the link, and the long block gives time for five.
        let mut forecaster = Forecaster::new(SLOW);
        for k in 0..200_u32 {
            forecaster.line(32, k, if k % 5 == 0 { 0.5 } else { 0.01 });
        }
        let found = forecaster.finish();
        assert!(found.starved_s < 1e-9, "{found:?}");
        assert!((found.motion_s - 40.0 * 0.54).abs() < 1e-9);
    }

    #[test]
    fn send_and_wait_stands_still_for_every_answer() {
        // One line under way, 20 ms until its answer, 25 ms per block: the link waits for the block, the block for the link.
        let link = LinkRate { characters_per_s: f64::INFINITY, answer_s: 0.02, lines: 1, bytes: 512 };
        let found = forecast(link, 200, 20, 0.025);
        assert!((found.total_s - 200.0 * 0.045).abs() < 1e-6, "{found:?}");
        let [stretch] = found.stretches.as_slice() else { panic!("{found:?}") };
        assert!((stretch.needed_per_s - 40.0).abs() < 0.1 && (stretch.given_per_s - 22.2).abs() < 0.1, "{stretch:?}");
    }
}
