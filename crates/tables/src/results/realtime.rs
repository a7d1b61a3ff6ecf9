//! What was answered in the cycle of a control, and how good the kernel was that did it.

use serde::Serialize;

use crate::realtime::{Agreement, CycleCounts, INTERVALS, Kernel, Signals};
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// A kernel that is in force.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KernelResult {
    /// Intervals of every axis.
    pub intervals: usize,
    /// Functions of an axis that are evaluated beside them, of axes that have any.
    pub direct_functions: Vec<(String, usize)>,
    /// Largest distance between the tips to which it and its model lead, µm.
    pub position_um: f64,
    /// Largest angle between the directions of the tool, µrad.
    pub direction_urad: f64,
    /// Poses at which both were compared.
    pub poses: usize,
}

impl KernelResult {
    /// That of a kernel and how it agrees with its model.
    #[must_use]
    pub fn new(kernel: &Kernel, agreement: &Agreement) -> KernelResult {
        let direct = kernel.axes().iter().map(|axis| (axis.to_string(), kernel.direct_functions(axis)));
        KernelResult {
            intervals: INTERVALS,
            direct_functions: direct.filter(|&(_, count)| count > 0).collect(),
            position_um: um_from_mm(agreement.position_mm),
            direction_urad: urad_from_rad(agreement.direction_rad),
            poses: agreement.poses,
        }
    }
}

/// Set-points that were answered.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RealtimeResult {
    /// How many.
    pub set_points: u64,
    /// Of them with a signal, for each that there was.
    pub signals: Vec<(&'static str, u64)>,
    /// How long they took, in classes.
    pub times: Vec<LatencyClass>,
    /// The time that a half, 99 % and 99.9 % of them did not exceed, ns.
    pub quantiles_ns: [u64; 3],
    /// The longest, ns.
    pub max_ns: u64,
}

/// Set-points that took about as long.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LatencyClass {
    /// From, ns.
    pub from_ns: u64,
    /// To, ns.
    pub to_ns: u64,
    /// How many.
    pub count: u64,
}

impl From<&CycleCounts> for RealtimeResult {
    fn from(counts: &CycleCounts) -> RealtimeResult {
        let counted = counts.by_signal.iter().zip(Signals::NAMED).filter(|(count, _)| **count > 0);
        RealtimeResult {
            set_points: counts.set_points,
            signals: counted.map(|(&count, (_, word))| (word, count)).collect(),
            times: counts
                .times
                .classes()
                .map(|(from_ns, to_ns, count)| LatencyClass { from_ns, to_ns, count })
                .collect(),
            quantiles_ns: [0.5, 0.99, 0.999].map(|share| counts.times.quantile_ns(share)),
            max_ns: counts.times.max_ns(),
        }
    }
}
