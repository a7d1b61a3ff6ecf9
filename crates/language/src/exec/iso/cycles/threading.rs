//! G76 of RS274/NGC: a thread in passes, turned on a lathe (LinuxCNC's user manual, "G76 Threading Cycle").
//!
//! X is the cross direction, Z is along the thread. A pass goes to its depth at rapid, along Z synchronized with the spindle, and back. Depths grow
//! with the R-th root of the pass; with Q each pass starts shifted along the flank.

/// Maximum number of passes of one thread.
const MOST_PASSES: u32 = 10_000;

/// The words of the block; lengths mm, the angle rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec::iso) struct Thread {
    /// X and Z at the start: the drive line.
    pub(in crate::exec::iso) start: [f64; 2],
    /// X and Z at the end.
    pub(in crate::exec::iso) end: [f64; 2],
    /// P: pitch.
    pub(in crate::exec::iso) pitch: f64,
    /// I: from the drive line to the peak, negative outside.
    pub(in crate::exec::iso) peak: f64,
    /// J: depth of the first pass beyond the peak.
    pub(in crate::exec::iso) first: f64,
    /// K: depth of the thread.
    pub(in crate::exec::iso) depth: f64,
    /// R: degression of the depths, 1 for none.
    pub(in crate::exec::iso) degression: f64,
    /// Q: angle of the compound slide.
    pub(in crate::exec::iso) slide_rad: f64,
    /// H: additional passes at full depth.
    pub(in crate::exec::iso) springs: u32,
    /// E: length of a taper along Z.
    pub(in crate::exec::iso) taper: f64,
    /// L: taper at the start and at the end.
    pub(in crate::exec::iso) tapers: [bool; 2],
}

/// One motion: X and Z, and the pitch if synchronized with the spindle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::exec::iso) struct ThreadMove {
    /// X and Z.
    pub(in crate::exec::iso) to: [f64; 2],
    /// mm per turn; `None` for rapid.
    pub(in crate::exec::iso) pitch: Option<f64>,
}

/// All motions of the thread.
///
/// # Errors
/// A message if the words do not define a thread.
pub(in crate::exec::iso) fn moves(thread: &Thread) -> Result<Vec<ThreadMove>, String> {
    let all = [thread.peak, thread.first, thread.depth, thread.pitch, thread.slide_rad, thread.taper];
    if !all.iter().all(|value| value.is_finite()) {
        return Err("G76 has a value that is not a number".into());
    }
    if thread.peak == 0.0 {
        return Err("G76 needs I other than 0".into());
    }
    if thread.first <= 0.0 || thread.depth <= thread.first {
        return Err("G76 needs J above 0 and K above J".into());
    }
    if thread.springs > MOST_PASSES {
        return Err(format!("G76 with {} passes at full depth", thread.springs));
    }
    let full = thread.peak.abs() + thread.depth;
    let depth_of =
        |pass: u32| thread.peak.abs() + thread.first * f64::from(pass).powf(1.0 / thread.degression.max(1.0));
    let mut out = Vec::new();
    let mut pass = 1;
    while depth_of(pass) < full {
        thread.pass(depth_of(pass), &mut out);
        pass += 1;
        if pass > MOST_PASSES {
            return Err(format!("G76 needs more than {MOST_PASSES} passes"));
        }
    }
    for _ in 0..=thread.springs {
        thread.pass(full, &mut out);
    }
    out.push(ThreadMove { to: thread.end, pitch: None });
    Ok(out)
}

impl Thread {
    /// One pass at a depth from the drive line.
    fn pass(&self, depth: f64, out: &mut Vec<ThreadMove>) {
        let inwards = if self.peak > 0.0 { 1.0 } else { -1.0 };
        let along = if self.end[1] > self.start[1] { 1.0 } else { -1.0 };
        let full = self.peak.abs() + self.depth;
        let across = |depth: f64| self.start[0] + inwards * depth;
        // The slide follows the flank, so that a deeper pass is farther along.
        let flank = -along * self.slide_rad.tan();
        let shift = (depth - self.peak.abs()) * flank;
        let (from, until) = (self.start[1] - shift, self.end[1] + self.depth * flank - shift);
        let taper = along * self.taper.max(0.0);
        let slant = self.pitch * taper.hypot(self.depth) / taper.abs();
        let (clear, lifted, cut) = (across(depth - full), across(depth - self.depth), across(depth));
        let [entry, exit] = self.tapers.map(|is_tapered| is_tapered && taper != 0.0);
        let rapid = |x: f64, z: f64| ThreadMove { to: [x, z], pitch: None };
        let feed = |x: f64, z: f64, pitch: f64| ThreadMove { to: [x, z], pitch: Some(pitch) };
        out.push(rapid(clear, from));
        if entry {
            out.extend([feed(lifted, from, slant), feed(cut, from + taper, slant)]);
        } else {
            out.push(rapid(cut, from));
        }
        if exit {
            out.extend([feed(cut, until - taper, self.pitch), feed(lifted, until, slant)]);
        } else {
            out.push(feed(cut, until, self.pitch));
        }
        out.push(rapid(clear, until));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OUTSIDE: Thread = Thread {
        start: [20.0, 5.0],
        end: [20.0, -30.0],
        pitch: 1.5,
        peak: -1.0,
        first: 0.25,
        depth: 1.0,
        degression: 2.0,
        slide_rad: 0.0,
        springs: 1,
        taper: 0.0,
        tapers: [false; 2],
    };

    #[test]
    fn depths_grow_with_the_root_of_the_pass() {
        let moves = moves(&OUTSIDE).unwrap();
        // J √n below K = 1: n up to 15; then once at full depth and once more. For five words: four motions per pass and the last one.
        let cuts: Vec<f64> = moves.iter().filter(|step| step.pitch.is_some()).map(|step| step.to[0]).collect();
        let mut wanted: Vec<f64> = (1..16).map(|pass| 19.0 - 0.25 * f64::from(pass).sqrt()).collect();
        wanted.extend([18.0; 2]);
        assert_eq!(cuts.len(), wanted.len());
        for (found, wanted) in cuts.iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-12, "{found} {wanted}");
        }
        assert_eq!(moves.len(), 4 * 17 + 1);
        // A pass starts and ends outside by its missing depth.
        assert_eq!(moves[0], ThreadMove { to: [20.75, 5.0], pitch: None });
        assert_eq!(moves[2], ThreadMove { to: [18.75, -30.0], pitch: Some(1.5) });
        assert_eq!(moves[3], ThreadMove { to: [20.75, -30.0], pitch: None });
        assert_eq!(moves.last(), Some(&ThreadMove { to: [20.0, -30.0], pitch: None }));
    }

    #[test]
    fn tapers_lead_in_and_out_over_the_depth_of_the_thread() {
        let thread = Thread { first: 0.9, springs: 0, taper: 2.0, tapers: [true; 2], ..OUTSIDE };
        let moves = moves(&thread).unwrap();
        // Full depth is the second pass: J √2 > K.
        let full = &moves[6..12];
        let slant = 1.5 * 5_f64.sqrt() / 2.0;
        let wanted = [
            ([20.0, 5.0], None),
            ([19.0, 5.0], Some(slant)),
            ([18.0, 3.0], Some(slant)),
            ([18.0, -28.0], Some(1.5)),
            ([19.0, -30.0], Some(slant)),
            ([20.0, -30.0], None),
        ];
        for (found, (to, pitch)) in full.iter().zip(wanted) {
            assert!((found.to[0] - to[0]).abs() + (found.to[1] - to[1]).abs() < 1e-12, "{found:?}");
            assert!((found.pitch.unwrap_or(0.0) - pitch.unwrap_or(0.0)).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn no_thread_of_faulty_words() {
        let faulty = [
            Thread { peak: 0.0, ..OUTSIDE },
            Thread { first: 0.0, ..OUTSIDE },
            Thread { depth: 0.2, ..OUTSIDE },
            Thread { first: 1e-9, ..OUTSIDE },
            Thread { springs: u32::MAX, ..OUTSIDE },
            Thread { pitch: f64::NAN, ..OUTSIDE },
        ];
        for thread in faulty {
            assert!(moves(&thread).is_err(), "{thread:?}");
        }
    }
}
