//! Results of the cycle of a control, and the agreement of its kernel.

use serde::Serialize;

use crate::realtime::{Agreement, CycleCounts, INTERVALS, Kernel, Signals};
use ncfix_base::units::{um_from_mm, urad_from_rad};

/// The active kernel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct KernelResult {
    /// Intervals of every axis.
    pub intervals: usize,
    /// Number of directly evaluated functions, for each axis that has any.
    pub direct_functions: Vec<(String, usize)>,
    /// Largest distance between the tips according to kernel and model, µm.
    pub position_um: f64,
    /// Largest angle between the tool directions, µrad.
    pub direction_urad: f64,
    /// Number of compared poses.
    pub poses: usize,
    /// Numbers and names of the heads of the machine, if it has several, for orders of a control.
    pub heads: Vec<(u64, String)>,
}

impl KernelResult {
    /// Creates the result from a kernel and its agreement with its model.
    #[must_use]
    pub fn new(kernel: &Kernel, agreement: &Agreement) -> KernelResult {
        let direct = kernel.axes().iter().map(|axis| (axis.to_string(), kernel.direct_functions(axis)));
        KernelResult {
            intervals: INTERVALS,
            direct_functions: direct.filter(|&(_, count)| count > 0).collect(),
            position_um: um_from_mm(agreement.position_mm),
            direction_urad: urad_from_rad(agreement.direction_rad),
            poses: agreement.poses,
            heads: Vec::new(),
        }
    }
}

/// Answered set-points.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RealtimeResult {
    /// Number of set-points.
    pub set_points: u64,
    /// Number of set-points with each status bit that occurred.
    pub signals: Vec<(&'static str, u64)>,
    /// Their durations, in bins.
    pub times: Vec<LatencyClass>,
    /// Median, 99 % and 99.9 % quantile of the durations, ns.
    pub quantiles_ns: [u64; 3],
    /// The longest duration, ns.
    pub max_ns: u64,
}

/// Set-points with similar durations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LatencyClass {
    /// Lower limit, ns.
    pub from_ns: u64,
    /// Upper limit, ns.
    pub to_ns: u64,
    /// Number of set-points.
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
