//! Diagnostics about gaps of the coverage.

use ncfix_base::diagnostic::{Code, Diagnostic};
use ncfix_base::number::micrometers;
use ncfix_base::units::{rad_from_urad, um_from_mm};

use super::{Coverage, CoverageGap, GapKind};

/// Sizes below this are not worth a number, µm.
const LEAST_UM: f64 = 0.01;
/// Angle whose effect a message states, µrad: that of a good axis over its travel.
const EXAMPLE_URAD: f64 = 10.0;

impl Coverage {
    /// Returns a diagnostic for each gap: a warning, or an error if coverage is required, which unknown ranges do not fulfill either.
    #[must_use]
    pub fn diagnostics(&self, is_required: bool) -> Vec<Diagnostic> {
        let mut found = Vec::new();
        let mut say = |code: Code, message: String, help: String| {
            let code = if is_required { Code::NOT_COVERED } else { code };
            found.push(Diagnostic::nowhere(code, message, help));
        };
        if is_required && !self.is_stated {
            let message = "the machine file does not state in which ranges its errors were measured";
            let help = "add [measured] to the machine file: ncfix calibrate -o writes it from the data";
            say(Code::NOT_COVERED, message.into(), help.into());
        }
        if let Some((axes, verb, errors, _)) = self.subjects(GapKind::NoErrors) {
            let message = format!("{axes} {verb}, but {errors} are not in the machine file");
            let help = format!("measure {axes} and calibrate; until then {errors} remain on the workpiece");
            say(GapKind::NoErrors.code(), message, help);
        }
        if let Some((axes, verb, _, they)) = self.subjects(GapKind::RangeNotStated) {
            let message = format!("{axes} {verb}, and [measured] does not state in which range {they} measured");
            let help = format!("add the range of {axes} to [measured] of the machine file");
            say(GapKind::RangeNotStated.code(), message, help);
        }
        for gap in &self.gaps {
            if let Some((message, help)) = squareness(gap) {
                say(gap.kind.code(), message, help);
            }
            if let Some((message, help)) = sentence(gap) {
                say(gap.kind.code(), message, help);
            }
        }
        if let Some((message, help)) = self.components() {
            say(GapKind::Component.code(), message, help);
        }
        if let Some((message, help)) = self.angles() {
            say(GapKind::Angle.code(), message, help);
        }
        found
    }

    /// Returns message and help of positioning and straightness errors, and places of rotary axes, that no measurement shows.
    fn components(&self) -> Option<(String, String)> {
        let (axes, verb, ..) = self.subjects(GapKind::Component)?;
        let gaps = || self.gaps.iter().filter(|gap| gap.kind == GapKind::Component);
        let all = || gaps().flat_map(|gap| &gap.components);
        let names: Vec<String> = all().map(|name| format!("{name} ({})", name.spelled_out())).collect();
        // The other axes of a machine show no bound: a place or a scale that nobody measured is as it was adjusted.
        let size = if names.len() == 1 { "its size is unknown" } else { "their sizes are unknown" };
        let message = format!("{axes} {verb}, and no measurement shows {}; {size}", names.join(", "));
        let of_spindle = all().all(|name| name.axis().is_none());
        let example = match (all().any(|name| name.is_location()), all().any(|name| !name.is_location())) {
            (true, false) if of_spindle => {
                "with two tool lengths at one ball that stays in its place, or with an R-test"
            }
            (true, false) => "with an R-test or probed balls while the rotary axes turn",
            (true, true) => "with probed balls while all these axes move",
            _ => "with a ball-bar, a straightness optic or probed balls",
        };
        let help = format!(
            "measure them, for example {example}, and calibrate; or remove those that are known from not_shown in [measured]"
        );
        Some((message, help))
    }

    /// Returns message and help of angles that no measurement shows, with the displacement by an angle of [`EXAMPLE_URAD`].
    fn angles(&self) -> Option<(String, String)> {
        let (axes, verb, ..) = self.subjects(GapKind::Angle)?;
        let gaps = || self.gaps.iter().filter(|gap| gap.kind == GapKind::Angle);
        let names: Vec<String> =
            gaps().flat_map(|gap| &gap.components).map(|name| format!("{name} ({})", name.spelled_out())).collect();
        let arm_mm = gaps().filter_map(|gap| gap.arm_mm).fold(0.0, f64::max);
        let size = micrometers(um_from_mm(rad_from_urad(EXAMPLE_URAD) * arm_mm));
        let (what, of) = if names.len() == 1 { ("the angle", "it") } else { ("the angles", "one of them") };
        let message = format!(
            "{axes} {verb}, and no measurement shows {what} {}; a change of {of} by {EXAMPLE_URAD} µrad shifts the tool by up to {size}",
            names.join(", ")
        );
        let help = "measure them, for example with a level, an autocollimator, a laser on a second line beside the first, or with circles, plates or balls at \
                    several heights and with two tool lengths, and calibrate; or remove those that are known from not_shown in [measured]";
        Some((message, help.to_owned()))
    }

    /// Returns the axes of a kind of gaps as a subject, with its verb, its errors and its passive.
    fn subjects(&self, kind: GapKind) -> Option<(String, &'static str, &'static str, &'static str)> {
        let of_kind = self.gaps.iter().filter(|gap| gap.kind == kind);
        let axes: Vec<String> = of_kind.filter_map(|gap| Some(gap.axis?.to_string())).collect();
        Some(match axes.as_slice() {
            [] => return None,
            [one] => (one.clone(), "moves", "its errors", "it was"),
            [first @ .., last] => (format!("{} and {last}", first.join(", ")), "move", "their errors", "they were"),
        })
    }
}

impl CoverageGap {
    /// Returns the unit in which people read it: `mm`, `deg`, `C`, `N`.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        unit(self.kind, self.is_angle())
    }

    /// Returns a value in that unit.
    #[must_use]
    pub fn shown(&self, value: f64) -> f64 {
        if self.is_angle() { value.to_degrees() } else { value }
    }

    fn is_angle(&self) -> bool {
        self.axis.is_some_and(|axis| axis.is_rotary())
    }
}

fn unit(kind: GapKind, is_angle: bool) -> &'static str {
    match kind {
        GapKind::Temperature => "C",
        GapKind::Load => "N",
        _ if is_angle => "deg",
        _ => "mm",
    }
}

/// Returns message and help of a squareness that no measurement shows.
fn squareness(gap: &CoverageGap) -> Option<(String, String)> {
    let name = gap.squareness?;
    let [one, two] = super::pair_of(name)?;
    let message =
        format!("{one} and {two} move, and no measurement shows their squareness {name}; its size is unknown");
    let help = format!(
        "measure it, for example with a ball-bar in the plane of {one} and {two}, and calibrate; or remove {name} from not_shown in [measured] if it is known"
    );
    Some((message, help))
}

/// Returns message and help of a gap that is not about an axis as a whole.
fn sentence(gap: &CoverageGap) -> Option<(String, String)> {
    let measured = gap.measured?;
    let [low, high] = measured.map(|end| decimal(gap.shown(end)));
    let ends = if measured[0] < measured[1] { format!("{low} to {high}") } else { low };
    let used = decimal(gap.shown(if gap.beyond > 0.0 { gap.used[1] } else { gap.used[0] }));
    let far = decimal(gap.shown(gap.beyond.abs()));
    let size = gap.size_mm.map(um_from_mm).filter(|um| *um >= LEAST_UM);
    let size = size.map_or_else(String::new, |um| format!("; {} of the error is extrapolated", micrometers(um)));
    let unit = gap.unit();
    Some(match gap.kind {
        GapKind::NoErrors | GapKind::RangeNotStated | GapKind::Squareness | GapKind::Component | GapKind::Angle => {
            return None;
        }
        GapKind::Position => {
            let axis = gap.axis?;
            let range = match gap.table {
                Some(name) => format!("the table of {name}, {ends} {unit}"),
                None => format!("the measured range, {ends} {unit}"),
            };
            let side = if gap.beyond > 0.0 { "above" } else { "below" };
            let message = format!("{axis} {used} {unit} is {far} {unit} {side} {range}{size}");
            let measure = format!("measure {axis} to {used} {unit}");
            // Another place of the workpiece does not change the angle of a rotary axis.
            (message, if axis.is_rotary() { measure } else { format!("move the workpiece, or {measure}") })
        }
        GapKind::ToolLength => {
            let than = if gap.beyond > 0.0 { "longer" } else { "shorter" };
            let message =
                format!("a tool of {used} mm is {far} mm {than} than the tools of the measurement, {ends} mm{size}");
            // Then the tilt of an axis that carries the spindle stands for that of the spindle too.
            let help = if ends.contains(" to ") {
                "measure with a tool of this length, or choose another tool"
            } else {
                "measure with a second tool length, and calibrate with EA0S and EB0S: readings with one length do not show a tilt of the spindle against its axis"
            };
            (message, help.to_owned())
        }
        GapKind::Temperature => {
            let sensor = gap.sensor.as_deref().unwrap_or_default();
            let message = format!("{sensor} at {used} °C is {far} K beyond the measured range, {ends} °C{size}");
            (message, "wait for the usual temperature, or measure in this condition".to_owned())
        }
        GapKind::Load => {
            let message = format!("a load of {used} N is {far} N beyond the measured range, {ends} N{size}");
            (message, "measure with a weight of this size".to_owned())
        }
    })
}

/// Formats a number with up to three decimals, without trailing zeros.
fn decimal(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.to_owned() }
}
