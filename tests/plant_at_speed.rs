//! A machine at speed, by arithmetic of its own: a wCAYFXZt machine with a table at 45°, an interpolator, servo loops, link, motion, thermal and dynamic
//! errors, two recorders with clocks of their own. Nothing of the program under test is used but the shape of a trace.

use nalgebra::{DMatrix, DVector, Rotation3, Unit, Vector3};
use ncfix_base::geometry::{Axis, AxisVector};
use ncfix_metrology::measure::noise::Noise;
use ncfix_metrology::measure::trace::{ControlSamples, Deviations, Trace, TraceRun};

/// Positions of X, Y, Z (mm) and A, C (rad).
pub(crate) type Joints = [f64; 5];
type V = Vector3<f64>;

/// The axes in the order of [`Joints`].
pub(crate) const AXES: [Axis; 5] = [Axis::X, Axis::Y, Axis::Z, Axis::A, Axis::C];
/// Six feeds in geometric progression, as in the paper.
pub(crate) const FEEDS: [f64; 6] = [1000.0, 1800.0, 3240.0, 5832.0, 10_498.0, 18_896.0];
/// Where the ball is on the table.
pub(crate) const BALL: [f64; 3] = [150.0, -100.0, 120.0];
/// The tool.
pub(crate) const TOOL: [f64; 3] = [0.0, 0.0, -150.0];
/// The machine file without errors.
pub(crate) const MACHINE: &str = "\
[machine]
name = \"plant\"
topology = \"wCAYFXZSt\"
controller = \"sinumerik\"
reference_temperature_C = 20.0
[axis.X]
direction = [1, 0, 0]
travel_mm = [-600, 600]
max_feed_mm_min = 30000
[axis.Y]
direction = [0, -1, 0]
travel_mm = [-600, 600]
max_feed_mm_min = 30000
[axis.Z]
direction = [0, 0, 1]
travel_mm = [-600, 900]
max_feed_mm_min = 30000
[axis.A]
direction = [-1, 0, -1]
point_mm = [0, 0, 0]
travel_deg = [-180, 180]
max_feed_deg_min = 9000
[axis.C]
direction = [0, 0, -1]
point_mm = [0, 0, 0]
travel_deg = [-7200, 7200]
max_feed_deg_min = 18000
[spindle]
origin_mm = [0, 0, 0]
axis = [0, 0, 1]
";

const CYCLE: f64 = 0.003;
const FINE: f64 = 0.000_25;
/// Length of the kernel with which the interpolator rounds corners, s.
const KERNEL: f64 = 0.024;

/// What is hidden.
#[derive(Clone, Debug)]
pub(crate) struct Hidden {
    /// δγY δαZ δβZ δβA δγA δαC δβC δyC, rad and mm.
    pub(crate) links: [f64; 8],
    /// Velocity gain (1/s) and feed-forward of each axis.
    pub(crate) loops: [[f64; 2]; 5],
    /// Encoders are recorded so much later than set-points, s.
    pub(crate) record_delay: f64,
    /// The clock of the instrument is ahead of that of the set-points, s.
    pub(crate) reading_delay: f64,
    /// Micrometres of smooth motion errors.
    pub(crate) motion_um: f64,
    /// Smooth motion errors in place of these, if there are any.
    pub(crate) waves: Vec<Wave>,
    /// Thermal offsets of the runs, µm.
    pub(crate) thermal_um: [[f64; 3]; 6],
    /// Displacement of the body of an axis, µm by m/s² of it: along X, Y, Z.
    pub(crate) compliance: [[f64; 3]; 5],
    /// Noise of single readings, µm, and of encoders, µm (and µrad/3).
    pub(crate) noise_um: [f64; 2],
}

impl Default for Hidden {
    fn default() -> Hidden {
        Hidden {
            links: [160e-6, -105e-6, 90e-6, 180e-6, -120e-6, 170e-6, -85e-6, 0.038],
            loops: [[60.0, 0.994], [50.0, 0.988], [55.0, 0.994], [45.0, 0.992], [40.0, 0.992]],
            record_delay: 0.018_4,
            reading_delay: 0.007_3,
            motion_um: 6.0,
            waves: Vec::new(),
            thermal_um: [
                [0.0; 3],
                [0.3, -0.2, 0.4],
                [0.6, -0.3, 0.9],
                [0.9, -0.6, 1.0],
                [1.5, -0.9, 1.4],
                [2.0, -1.2, 1.8],
            ],
            compliance: [[0.9, 0.0, 0.0], [0.0, 1.6, 0.0], [0.0, 0.0, 0.0], [0.0; 3], [0.0; 3]],
            noise_um: [0.15, 0.05],
        }
    }
}

/// A wave along a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wave {
    /// Number of the joint, and direction of the displacement: 0 to 2 for X, Y, Z.
    pub(crate) of: [usize; 2],
    /// Amplitude, mm.
    pub(crate) mm: f64,
    /// Radians of the wave for each mm or rad of the joint, and its phase.
    pub(crate) per: f64,
    pub(crate) phase: f64,
}

/// A machine drawn at random: links of the sizes that ISO 10791-1 and -2 allow (50 µrad of squareness, 100 µrad and 100 µm of rotary axes, as standard deviations),
/// and two waves in each direction along each joint, 60 to 400 mm or 20 to 180 degrees long, 8 µm together.
pub(crate) fn drawn(seed: u64) -> Hidden {
    let mut noise = Noise::new(seed);
    let sizes = [50e-6, 50e-6, 50e-6, 100e-6, 100e-6, 100e-6, 100e-6, 0.1];
    let links = sizes.map(|size| size * noise.normal());
    let mut waves = Vec::new();
    for joint in 0..5 {
        for along in 0..3 {
            for _ in 0..2 {
                // A number between 0 and 1 that a normal one makes.
                let share = 1.0 / (1.0 + (-1.7 * noise.normal()).exp());
                let length = if joint < 3 {
                    60.0 * (400.0_f64 / 60.0).powf(share)
                } else {
                    f64::to_radians(20.0 * 9.0_f64.powf(share))
                };
                // Two waves with amplitudes of this size have an RMS of 8 µm.
                let mm = 8e-3 * noise.normal();
                waves.push(Wave {
                    of: [joint, along],
                    mm,
                    per: std::f64::consts::TAU / length,
                    phase: 3.0 * noise.normal(),
                });
            }
        }
    }
    Hidden { links, waves, ..Hidden::default() }
}

/// What each source did, by sample of the recorded encoders, along X, Y, Z of F, mm.
#[derive(Clone, Debug, Default)]
pub(crate) struct Truth {
    /// Contouring, link, motion, thermal, dynamic.
    pub(crate) parts: Vec<[V; 5]>,
}

fn about(axis: V, angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Unit::new_normalize(axis), angle)
}

/// The tool from the ball with link errors.
fn tool_from_ball(q: &Joints, links: &[f64; 8]) -> V {
    let [gamma_y, alpha_z, beta_z, beta_a, gamma_a, alpha_c, beta_c, y_c] = *links;
    let [x, y, z, a, c] = *q;
    let tilt = |a: f64, b: f64, c: f64| Rotation3::from_scaled_axis(V::new(a, b, c));
    let tip = V::new(x, 0.0, 0.0) + tilt(alpha_z, beta_z, 0.0) * (V::new(0.0, 0.0, z) + V::from(TOOL));
    let on_c = V::new(0.0, y_c, 0.0) + tilt(alpha_c, beta_c, 0.0) * (about(V::new(0.0, 0.0, -1.0), c) * V::from(BALL));
    let on_a = tilt(0.0, beta_a, gamma_a) * (about(V::new(-1.0, 0.0, -1.0), a) * on_c);
    let ball = tilt(0.0, 0.0, gamma_y) * (V::new(0.0, -y, 0.0) + on_a);
    tip - ball
}

/// Smooth errors of motion by pose, mm: straightness and yaw of X, Y, Z, wobble of A and C.
fn raw_motion(q: &Joints, hidden: &Hidden) -> V {
    if !hidden.waves.is_empty() {
        let mut sum = V::zeros();
        for wave in &hidden.waves {
            let [joint, along] = wave.of;
            sum[along] += wave.mm * (wave.per * q[joint] + wave.phase).sin();
        }
        return sum;
    }
    let [x, y, z, a, c] = *q;
    let mm = hidden.motion_um * 1e-3;
    V::new(
        (0.06 * x).sin() * 0.8 + 0.4 * (3.0 * c).cos(),
        0.9 * (7.0 * a).sin() + 0.4 * (0.05 * y).cos(),
        0.7 * (0.07 * z + 0.4).sin() + 0.5 * (7.0 * c + 1.0).sin(),
    ) * mm
}

/// The ends of 17 straight segments, with a nearly square corner in the middle; the tool is at the ball at each.
fn nodes() -> Vec<Joints> {
    let (mut a, mut c) = (0.1_f64, -0.2_f64);
    let mut nodes = Vec::new();
    for k in 0..18 {
        let at = tool_from_ball(&[0.0, 0.0, 0.0, a, c], &[0.0; 8]);
        // X and Z move the tool, Y the table the other way: tool − ball grows with all three.
        nodes.push([-at.x, -at.y, -at.z, a, c]);
        let [da, dc] = if k < 8 { [3.0, 0.9] } else { [-0.7, 3.1] };
        a += f64::to_radians(da);
        c += f64::to_radians(dc);
    }
    nodes
}

fn metric(from: &Joints, to: &Joints) -> f64 {
    (0..5).map(|k| (to[k] - from[k]) * if k < 3 { 1.0 } else { 100.0 }).map(|d| d * d).sum::<f64>().sqrt()
}

/// Set-points every [`FINE`] seconds: a trapezoid of the speed in each segment, slowed down where the corner would cost more than 4 m/s² on an axis, then
/// rounded by a triangle of [`KERNEL`].
fn set_points(feed: f64) -> Vec<Joints> {
    let nodes = nodes();
    let lengths: Vec<f64> = nodes.windows(2).map(|pair| metric(&pair[0], &pair[1])).collect();
    let most = 2500.0;
    let speed = feed / 60.0;
    let mut limits: Vec<f64> = vec![0.0; nodes.len()];
    for (k, limit) in limits.iter_mut().enumerate().take(nodes.len() - 1).skip(1) {
        let turn = (0..5)
            .map(|j| {
                let slope = |from: usize| (nodes[from + 1][j] - nodes[from][j]) / lengths[from];
                ((slope(k) - slope(k - 1)) * if j < 3 { 1.0 } else { 100.0 }).abs()
            })
            .fold(0.0, f64::max);
        *limit = speed.min(4000.0 * KERNEL / 2.0 / turn);
    }
    for k in 1..nodes.len() {
        limits[k] = limits[k].min((limits[k - 1] * limits[k - 1] + 2.0 * most * lengths[k - 1]).sqrt());
    }
    for k in (0..nodes.len() - 1).rev() {
        limits[k] = limits[k].min((limits[k + 1] * limits[k + 1] + 2.0 * most * lengths[k]).sqrt());
    }
    let mut sharp = vec![nodes[0]; (0.3 / FINE) as usize];
    let mut rest = 0.0;
    for (k, &length) in lengths.iter().enumerate() {
        let (from, to) = (limits[k], limits[k + 1]);
        let top = speed.min(((from * from + to * to) / 2.0 + most * length).sqrt());
        let [up, down] = [(top - from) / most, (top - to) / most];
        let [way_up, way_down] = [(from + top) / 2.0 * up, (to + top) / 2.0 * down];
        let flat = (length - way_up - way_down).max(0.0) / top;
        let whole = up + flat + down;
        let mut t = rest;
        while t < whole {
            let way = if t < up {
                from * t + most * t * t / 2.0
            } else if t < up + flat {
                way_up + top * (t - up)
            } else {
                let left = whole - t;
                length - to * left - most * left * left / 2.0
            };
            let share = (way / length).clamp(0.0, 1.0);
            sharp.push(std::array::from_fn(|j| nodes[k][j] + share * (nodes[k + 1][j] - nodes[k][j])));
            t += FINE;
        }
        rest = t - whole;
    }
    sharp.extend(std::iter::repeat_n(*nodes.last().unwrap(), (0.3 / FINE) as usize));
    // Two means over half of the kernel are a triangle.
    let half = (KERNEL / 2.0 / FINE) as usize;
    [half, half].into_iter().fold(sharp, |values, width| box_mean(&values, width))
}

fn box_mean(values: &[Joints], width: usize) -> Vec<Joints> {
    let mut sum = [0.0; 5];
    (0..5).for_each(|j| sum[j] = values[0][j] * width as f64);
    let mut out = Vec::with_capacity(values.len());
    for (k, value) in values.iter().enumerate() {
        let old = values[k.saturating_sub(width)];
        for j in 0..5 {
            sum[j] += value[j] - old[j];
        }
        out.push(sum.map(|sum| sum / width as f64));
    }
    out
}

/// Where the axes are: e' = (1 − f) s' − K e, exactly for straight set-points between steps.
fn follow(set: &[Joints], loops: &[[f64; 2]; 5]) -> Vec<Joints> {
    let mut lag = [0.0; 5];
    let mut out = vec![set[0]];
    for pair in set.windows(2) {
        for j in 0..5 {
            let [gain, forward] = loops[j];
            let fade = (-gain * FINE).exp();
            let rate = (1.0 - forward) * (pair[1][j] - pair[0][j]) / FINE;
            lag[j] = lag[j] * fade + rate / gain * (1.0 - fade);
        }
        out.push(std::array::from_fn(|j| pair[1][j] - lag[j]));
    }
    out
}

/// A series at [`FINE`] steps between its values.
fn between(values: &[Joints], t: f64) -> Joints {
    let place = (t / FINE).clamp(0.0, (values.len() - 1) as f64);
    let low = (place as usize).min(values.len() - 2);
    let share = place - low as f64;
    std::array::from_fn(|j| values[low][j] + share * (values[low + 1][j] - values[low][j]))
}

fn vector(q: &Joints) -> AxisVector {
    let mut out = AxisVector::ZERO;
    AXES.into_iter().zip(q).for_each(|(axis, value)| out[axis] = *value);
    out
}

/// What compliances do to the tool, mm.
fn deflection(actual: &[Joints], t: f64, q: &Joints, compliance: &[[f64; 3]; 5]) -> V {
    let h = 2.0 * FINE;
    let [before, now, after] = [t - h, t, t + h].map(|t| between(actual, t));
    // mm/s² and rad/s², to m/s².
    let rate: Joints = std::array::from_fn(|j| (before[j] - 2.0 * now[j] + after[j]) / (h * h) * 1e-3);
    let body = |j: usize| V::from(compliance[j]) * (1e-3 * rate[j]);
    // Bodies of the table carry the ball; those of A and C turn with it.
    let turn = about(V::new(-1.0, 0.0, -1.0), q[3]);
    let table = body(1) + turn * (body(3) + about(V::new(0.0, 0.0, -1.0), q[4]) * body(4));
    body(0) + body(2) - table
}

/// Runs the machine at some of [`FEEDS`].
pub(crate) fn trace(hidden: &Hidden, feeds: &[usize], seed: u64) -> (Trace, Vec<Truth>) {
    let mut noise = Noise::new(seed);
    let mut trace = Trace { name: "plant".into(), ball_mm: Some(V::from(BALL)), ..Trace::default() };
    let mut truths = Vec::new();
    let slow = follow(&set_points(FEEDS[feeds[0]]), &hidden.loops);
    let projection = projection(&slow, hidden);
    for &number in feeds {
        let set = set_points(FEEDS[number]);
        let actual = follow(&set, &hidden.loops);
        let thermal = V::from(hidden.thermal_um[number]) * 1e-3;
        let end = (set.len() - 1) as f64 * FINE;
        let links = |q: &Joints| tool_from_ball(q, &hidden.links) - tool_from_ball(q, &[0.0; 8]);
        let mut run = TraceRun {
            label: format!("F{}", FEEDS[number]),
            feed_mm_min: Some(FEEDS[number]),
            tool_mm: V::from(TOOL),
            control: ControlSamples::default(),
            readings: Deviations::default(),
            transitions_s: Vec::new(),
            place: None,
        };
        let mut truth = Truth::default();
        for k in 0..(end / CYCLE) as usize {
            let t = k as f64 * CYCLE;
            run.control.t_s.push(t);
            run.control.set.push(vector(&between(&set, t)));
            let then = t - hidden.record_delay;
            let at = between(&actual, then);
            let mut encoder = at;
            for (j, value) in encoder.iter_mut().enumerate() {
                *value += noise.normal() * hidden.noise_um[1] * if j < 3 { 1e-3 } else { 0.33e-6 };
            }
            run.control.encoder.push(vector(&encoder));
            let nominal = tool_from_ball(&between(&set, then), &[0.0; 8]);
            let projected = projected(&at, &projection);
            truth.parts.push([
                tool_from_ball(&at, &[0.0; 8]) - nominal,
                links(&at) + projected,
                raw_motion(&at, hidden) - projected,
                thermal,
                deflection(&actual, then, &at, &hidden.compliance),
            ]);
        }
        let step = 1e-4;
        for k in 0..(end / step) as usize {
            let t = k as f64 * step;
            let at = between(&actual, t);
            let whole = tool_from_ball(&at, &hidden.links)
                + raw_motion(&at, hidden)
                + thermal
                + deflection(&actual, t, &at, &hidden.compliance);
            run.readings.t_s.push(t + hidden.reading_delay);
            run.readings.along.push(std::array::from_fn(|k| whole[k] + noise.normal() * hidden.noise_um[0] * 1e-3));
        }
        trace.runs.push(run);
        truths.push(truth);
    }
    (trace, truths)
}

/// What 1 of each link does, by differences.
fn jacobian(q: &Joints) -> [V; 8] {
    std::array::from_fn(|j| {
        let mut links = [[0.0; 8]; 2];
        let step = if j < 7 { 1e-5 } else { 1e-3 };
        (links[0][j], links[1][j]) = (step, -step);
        (tool_from_ball(q, &links[0]) - tool_from_ball(q, &links[1])) / (2.0 * step)
    })
}

/// The part of the motion errors that on this path cannot be told from links: their projection on the link errors, as the slowest run samples it.
fn projection(slow: &[Joints], hidden: &Hidden) -> [f64; 8] {
    let poses: Vec<&Joints> = slow.iter().step_by(24).collect();
    let mut matrix = DMatrix::zeros(3 * poses.len(), 8);
    let mut values = DVector::zeros(3 * poses.len());
    for (place, q) in poses.iter().enumerate() {
        let columns = jacobian(q);
        let motion = raw_motion(q, hidden);
        for k in 0..3 {
            values[3 * place + k] = motion[k];
            for (j, column) in columns.iter().enumerate() {
                matrix[(3 * place + k, j)] = column[k];
            }
        }
    }
    let found = matrix.svd(true, true).solve(&values, 1e-12).unwrap();
    std::array::from_fn(|j| found[j])
}

fn projected(q: &Joints, projection: &[f64; 8]) -> V {
    jacobian(q).iter().zip(projection).map(|(column, amount)| column * *amount).sum()
}

/// The table of some runs as a user would have it: rows of the control and rows of the instrument, each with the cells of the other left empty.
pub(crate) fn table(trace: &Trace) -> String {
    use std::fmt::Write as _;
    let mut out = String::from(
        "run,feed_mm_min,t_s,X,Y,Z,A,C,X_enc,Y_enc,Z_enc,A_enc,C_enc,dx_um,dy_um,dz_um,tool_x_mm,tool_y_mm,tool_z_mm\n",
    );
    for run in &trace.runs {
        let feed = run.feed_mm_min.unwrap();
        let [x, y, z] = TOOL;
        for ((t, set), encoder) in run.control.t_s.iter().zip(&run.control.set).zip(&run.control.encoder) {
            write!(out, "{},{feed},{t:.6}", run.label).unwrap();
            for position in [set, encoder] {
                for axis in AXES {
                    let value = position[axis];
                    write!(out, ",{:.7}", if axis.is_rotary() { value.to_degrees() } else { value }).unwrap();
                }
            }
            writeln!(out, ",,,,{x},{y},{z}").unwrap();
        }
        for (t, [dx, dy, dz]) in run.readings.t_s.iter().zip(&run.readings.along) {
            let [dx, dy, dz] = [dx, dy, dz].map(|mm| mm * 1e3);
            writeln!(out, "{},{feed},{t:.6},,,,,,,,,,,{dx:.3},{dy:.3},{dz:.3},{x},{y},{z}", run.label).unwrap();
        }
    }
    out
}

/// The description beside it.
pub(crate) fn description() -> String {
    let [x, y, z] = BALL;
    format!("[measurement]\nkind = \"trace\"\nsigma_um = 0.15\n[ball.b1]\nplace_mm = [{x}, {y}, {z}]\n")
}
