//! The order of the bodies from the workpiece through the foundation to the tool.

/// (helper writes)
pub struct Topology;
/// x
pub struct Branch;
/// x
pub struct TopologyFault;
