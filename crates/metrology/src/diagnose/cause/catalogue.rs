//! Catalog of physical causes by number: the regressor of each, its evidence, the causes it is confused with, the measurement that separates it, and
//! the [`super::Causes`] that search for it. Causes with one regressor share a file.

use super::{
    Cause, backlash, circle, cross, drift, load, location, motion, periodic, servo, setup, spike, thermal, vibration,
};

/// Search for a catalog entry.
#[derive(Clone, Copy, Debug)]
pub enum Sought {
    /// Causes, the most usual one first.
    By(&'static [&'static Cause]),
    /// A fault of the data, searched before the causes.
    AsFault,
    /// Not searched, for this reason.
    Not(&'static str),
}

/// An entry of the catalog.
#[derive(Clone, Copy, Debug)]
pub struct CatalogueEntry {
    /// Its number.
    pub number: u8,
    /// Its name.
    pub title: &'static str,
    /// The dependence of the readings.
    pub regressor: &'static str,
    /// Its evidence.
    pub shown_by: &'static str,
    /// Causes with which it is confused.
    pub confused_with: &'static str,
    /// The measurement that separates it.
    pub separate_by: &'static str,
    /// The search for it.
    pub sought: Sought,
}

#[rustfmt::skip]
const fn entry(
    number: u8, title: &'static str, regressor: &'static str, shown_by: &'static str, confused_with: &'static str, separate_by: &'static str, sought: Sought,
) -> CatalogueEntry {
    CatalogueEntry { number, title, regressor, shown_by, confused_with, separate_by, sought }
}

/// All entries in order.
#[rustfmt::skip]
pub const CATALOGUE: &[CatalogueEntry] = &[
    entry(1, "scale of an axis", "k·x", "laser, hole plate; ball-bar with a calibrated bar", "thermal scale, length of the bar", "a measurement at another temperature; two radii", Sought::By(&[&motion::CAUSE])),
    entry(2, "shape of the positioning error", "smooth in x", "laser", "cosine error of the set-up", "a second set-up: only the slope belongs to the set-up", Sought::By(&[&motion::CAUSE])),
    entry(3, "cyclic error of screw or encoder", "sin, cos 2πnx/P", "laser in fine steps, ball-bar", "vibration", "another feed", Sought::By(&[&periodic::CAUSE])),
    entry(4, "lobes of a rotary encoder", "sin, cos nc", "autocollimator; balls on the table", "radial error of the axis", "two balls at different radii", Sought::By(&[&periodic::CAUSE])),
    entry(5, "straightness", "x², x³", "straightedge, plate, ball-bar", "eccentric ball-bar circle", "a longer travel", Sought::By(&[&motion::CAUSE])),
    entry(6, "roll", "x with the lever across", "level; plate with two tools", "straightness at a single lever arm", "two tool vectors", Sought::By(&[&motion::CAUSE])),
    entry(7, "pitch and yaw", "xᵏ with the lever", "angular laser; plates at two heights", "scale at another height", "lines at two heights", Sought::By(&[&motion::CAUSE])),
    entry(8, "squareness", "y across", "plate, ball-bar at 45°, equal in both directions", "servo mismatch; the plate's own rotation", "both directions; turn the plate by 90°", Sought::By(&[&location::CAUSE])),
    entry(9, "offset of a rotary axis", "1 − cos c, sin c", "chase-the-ball", "position of the ball", "at least three indexed positions", Sought::By(&[&location::CAUSE])),
    entry(10, "tilt of a rotary axis", "rotation times lever", "chase-the-ball at two heights", "height of the ball", "two heights", Sought::By(&[&location::CAUSE])),
    entry(11, "location of the second rotary axis", "according to the chain", "chase-the-ball with both axes", "a roll of the tool about its own axis", "not needed: a roll of the tool has no effect on the part", Sought::By(&[&location::CAUSE])),
    entry(12, "gain and first harmonic of a rotary axis", "c, sin c, cos c", "rotary encoder, R-test", "offset and tilt of the axis", "several balls", Sought::By(&[&motion::CAUSE, &periodic::CAUSE])),
    entry(13, "radial and axial error of a rotary axis", "sin, cos nc", "R-test", "offset of the axis for n = 1", "two radii", Sought::By(&[&periodic::CAUSE])),
    entry(14, "wobble of a rotary axis", "sin, cos c times height", "R-test at two heights", "radial error", "two heights", Sought::By(&[&periodic::CAUSE])),
    entry(15, "backlash of a rotary axis", "direction times radius", "indexing from both sides", "shift when it is clamped", "with and without clamping", Sought::By(&[&backlash::BACKLASH])),
    entry(16, "offset of the spindle", "constant in the tool frame", "balls with an indexed spindle", "run-out of the stylus", "index the spindle", Sought::By(&[&location::CAUSE])),
    entry(17, "tilt of the spindle", "tool length times a constant", "two tool lengths", "offset of the spindle", "another tool length", Sought::By(&[&location::CAUSE])),
    entry(18, "tool length", "constant along the tool", "balls on five axes", "height of the ball, scale of Z", "two tools", Sought::By(&[&setup::TOOL])),
    entry(19, "offset of the stylus", "turns with the spindle", "indexed spindle", "offset of the spindle", "index the spindle", Sought::By(&[&setup::TOOL])),
    entry(20, "backlash", "direction / 2", "laser in both directions; ball-bar: steps of opposite sign in the two directions", "delay", "another feed", Sought::By(&[&backlash::BACKLASH])),
    entry(21, "wind-up of the screw", "direction times x", "laser in both directions", "backlash", "both directions at three positions", Sought::By(&[&backlash::WIND_UP])),
    entry(22, "reversal spike", "exp(−path/s₀) after a reversal", "ball-bar, encoders", "false readings", "repeat the run", Sought::By(&[&spike::CAUSE])),
    entry(23, "stick-slip", "sawtooth where an axis is slow", "ball-bar at low feed", "noise", "another feed", Sought::By(&[&servo::STICK_SLIP])),
    entry(24, "lateral play", "direction of x across it", "ball-bar: both directions differ as |sin|", "hysteresis of squareness", "indicator across the axis", Sought::By(&[&backlash::LATERAL_PLAY])),
    entry(25, "yaw that depends on the direction", "direction times lever", "both directions at two heights", "lateral play", "two levers", Sought::By(&[&backlash::LATERAL_PLAY])),
    entry(26, "servo mismatch", "(τx − τy)·v", "ball-bar: oval at 45° that reverses with the direction", "squareness", "both directions", Sought::By(&[&servo::MISMATCH, &servo::MISMATCH_AT_USUAL_FEED])),
    entry(27, "following error", "τ·v", "traces", "delay of a recorder", "an external sensor", Sought::By(&[&servo::FOLLOWING])),
    entry(28, "circle contraction at feed", "(τω)²R/2", "ball-bar at two feeds", "length of the bar", "another feed", Sought::By(&[&servo::FOLLOWING])),
    entry(29, "friction", "direction and speed in currents", "traces", "backlash", "traces of currents", Sought::Not("no kind of measurement reads currents")),
    entry(30, "deflection by acceleration", "acceleration", "difference between R-test and encoders", "lag", "encoders: they show a lag, but not a deflection", Sought::By(&[&servo::DYNAMIC])),
    entry(31, "residual vibration", "damped wave after a corner", "R-test at a corner", "deflection", "traces of corners", Sought::Not("no kind of measurement records corners")),
    entry(32, "forced vibration", "sin 2πft", "spectrum over time at two feeds", "cyclic error", "another feed", Sought::By(&[&vibration::CAUSE])),
    entry(33, "delay between records", "Δt·v on all axes", "correlation of the records", "following error, backlash", "an external clock", Sought::By(&[&servo::DELAY])),
    entry(34, "clocks with different rates", "t·v", "long records", "delay", "a longer record", Sought::By(&[&servo::DELAY])),
    entry(35, "rounded corners", "deviation at joints of blocks", "traces", "deflection", "exact stop", Sought::Not("joints of blocks are in no kind of measurement")),
    entry(36, "chords", "R(1 − cos Δφ/2)", "ball-bar on a circle of straight blocks", "cyclic error", "the circle as one block", Sought::By(&[&circle::CHORDS])),
    entry(37, "change of the leading axis", "steps at 45° + 90°k", "ball-bar", "lateral play", "another plane", Sought::By(&[&circle::OCTANTS])),
    entry(38, "drift with a temperature", "a sensor with a lag", "readings of one pose", "drift by the ambient temperature", "an idle run", Sought::By(&[&thermal::DRIFT])),
    entry(39, "two lags", "two sensors with lags", "warm-up and cooling", "one lag", "a cooling run", Sought::By(&[&thermal::DRIFT])),
    entry(40, "thermal expansion of a scale", "(T − 20)·x", "lines on the hot and the cold machine", "scale", "another temperature", Sought::By(&[&thermal::EXPANSION])),
    entry(41, "thermal expansion of a screw", "(T − T₀)(x − x₀)", "laser during cycling of the axis", "thermal expansion of a scale", "a sensor at the nut", Sought::By(&[&thermal::EXPANSION])),
    entry(42, "squareness with a gradient", "(T₁ − T₂)·y", "plate on the hot and the cold machine", "squareness", "sensors on both sides", Sought::By(&[&thermal::SQUARENESS])),
    entry(43, "daily temperature cycle", "ambient temperature with a lag of hours", "24 hours without motion", "trend, creep of the set-up", "a measurement over two days", Sought::By(&[&thermal::DRIFT])),
    entry(44, "coolant, open door", "a step that decays", "a log of events", "false readings", "a log of events", Sought::By(&[&drift::EVENT])),
    entry(45, "guideway under load", "weight times its position times a polynomial", "level with loads", "roll", "the same line without the weight", Sought::By(&[&load::GUIDE])),
    entry(46, "table under load", "weight times its position", "loads at several positions", "guideway under load", "lines along the axis", Sought::By(&[&load::TABLE])),
    entry(47, "sag by a moving mass", "overhang²", "level", "pitch", "not needed: the correction is the same", Sought::By(&[&motion::CAUSE])),
    entry(48, "error that depends on two axes", "x·y", "a grid of lines", "noise", "three positions of the other axis", Sought::By(&[&cross::CAUSE])),
    entry(49, "racking of a gantry", "direction, acceleration times x", "two lines", "yaw that depends on the direction", "two lines", Sought::By(&[&backlash::LATERAL_PLAY])),
    entry(50, "position of the ball-bar", "a, b, c of each run", "ball-bar", "every other error with the shape of a circle off its center", "mount the bar again", Sought::By(&[&setup::PLACE])),
    entry(51, "length of the bar", "constant for each bar", "several bars", "scale", "a calibrator", Sought::By(&[&setup::PLACE])),
    entry(52, "worn cup", "three lobes that differ from run to run", "repeated runs", "eccentric ball-bar circle", "clean the cup and repeat the run", Sought::By(&[&circle::CUP])),
    entry(53, "temperature of the artifact", "α·ΔT times its lengths", "temperature of the plate", "scale", "another material", Sought::By(&[&setup::SCALE])),
    entry(54, "alignment of the artifact", "six numbers for each placement", "every placement", "a part of a squareness", "turn the artifact by 90°", Sought::By(&[&setup::PLACE])),
    entry(55, "lobes of the probe", "cos 3ψ of the touch", "sphere from nine directions", "form of the ball", "turn the probe", Sought::By(&[&setup::PROBE])),
    entry(56, "pre-travel", "constant along the radius", "radius of a sphere", "size of the ball", "a calibrated ring", Sought::Not("a probing is the center of a ball: its radius is not read")),
    entry(57, "delay of the trigger", "v·Δt", "two feeds of probing", "pre-travel", "another feed", Sought::By(&[&setup::PROBE])),
    entry(58, "air, dead path, cosine of the laser", "ΔT·L; x(1 − cos)", "log of air temperature, pressure and humidity; another mounting", "scale", "mount the laser again", Sought::By(&[&setup::SCALE])),
    entry(59, "misaligned R-test sensors", "a linear combination of readings", "calibration moves", "every other error of an R-test", "calibration moves", Sought::Not("calibration moves ([sensors] star) determine the directions of the sensors")),
    entry(60, "stuck or dead sensor", "no change, or the value at the end of its range", "record of the sensor", "–", "record of the sensor", Sought::AsFault),
    entry(61, "offset, gain or unit of a sensor", "constant, factor", "sensors against each other", "drift with a temperature", "exchange the sensors", Sought::AsFault),
    entry(62, "exchanged or reversed channels", "a permutation", "each permutation in turn", "–", "one known motion", Sought::AsFault),
    entry(63, "lubrication", "isolated pulse of some minutes", "repeated measurements", "spike", "repeat the measurement", Sought::AsFault),
    entry(64, "first cycle", "first of several runs", "cycles against each other", "–", "omit the first cycle", Sought::AsFault),
    entry(65, "step in time", "a permanent change", "record over several days", "daily temperature cycle", "a log of events", Sought::AsFault),
    entry(66, "a table of the control is already active", "the known errors with the opposite sign", "any measurement", "wrong sign of the model", "switch off the table", Sought::AsFault),
    entry(67, "quantization", "equal steps", "record of the readings", "–", "a finer display", Sought::AsFault),
];

#[cfg(test)]
mod tests {
    use super::super::BUILT_IN;
    use super::*;

    #[test]
    fn every_row_is_sought_or_says_why_not() {
        assert_eq!(CATALOGUE.len(), 67);
        for (place, row) in CATALOGUE.iter().enumerate() {
            assert_eq!(usize::from(row.number), place + 1);
            let words = [row.title, row.regressor, row.shown_by, row.confused_with, row.separate_by];
            assert!(words.iter().all(|text| !text.is_empty()), "{}", row.number);
            match row.sought {
                Sought::By(causes) => {
                    let is_known = |cause: &&Cause| BUILT_IN.iter().any(|known| known.name == cause.name);
                    assert!(!causes.is_empty() && causes.iter().all(is_known), "{}", row.number);
                }
                Sought::AsFault => assert!(row.number >= 60, "{}", row.number),
                Sought::Not(why) => assert!(why.len() > 20, "{}", row.number),
            }
        }
    }

    #[test]
    fn no_cause_is_without_words() {
        for cause in BUILT_IN {
            let words = [cause.name, cause.made_by, cause.shown_by, cause.separate_by];
            assert!(words.iter().all(|text| !text.is_empty()), "{}", cause.name);
            let twins = BUILT_IN.iter().filter(|other| other.name == cause.name).count();
            assert_eq!(twins, 1, "{}", cause.name);
        }
    }
}
