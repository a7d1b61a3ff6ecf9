//! Sources of the error at speed: contouring, link errors, motion errors, thermal drift, dynamics.
//!
//! After Andolfatto, Lavernhe and Mayer, "Evaluation of servo, geometric and dynamic error sources on five-axis high-speed machine tool",
//! International Journal of Machine Tools and Manufacture 51 (2011) 787–796. The tool is measured relative to a ball on the table while the machine
//! runs over one path at several feeds; set-points and encoders are recorded in parallel. χ is the measured displacement; χnom and χenc are those of
//! an error-free machine at the set-points and at the encoder positions (all along F's directions, by sample). Then
//!
//! ```text
//! χ − χnom = δc + δl + δm + δtd + δd
//! δc  = χenc − χnom                               contouring: the servo loops           eq. 10
//! δl  = J δq from the slowest run                 link errors                            eq. 14
//! δm  = smooth function of the pose, from it      motion errors                          eq. 16, 17
//! δtd = mean of the residual of each run          thermal drift, 0 in the slowest run    eq. 18
//! δd  = the residual                              dynamics                               eq. 20
//! ```
//!
//! The link errors of this division include the effects of motion errors on this path. The values of the links, with their intervals, come from a joint
//! fit of both ([`LinkError`]).
//!
//! Beyond the paper, the delays of the recordings are estimated together with the lags of the loops ([`servo`]) and with smooth errors ([`clock`]).
//! The true contouring error is given in addition to the difference of the axes ([`contour`]). The dynamic part is explained by compliances under the
//! acceleration of axes ([`compliance`]), and their part in the slowest run does not count as a motion error.
//!
//! ```text
//! Trace ─▶ grid (equal steps) ─▶ servo (delay, loops) ─▶ poses ─▶ clock (delay) ─▶ links, motion ─▶ compliance ─▶ shares
//! ```

pub mod basis;
pub mod clock;
pub mod compliance;
pub mod contour;
mod grid;
mod joint;
mod link_names;
mod measurement;
mod parts;
mod poses;
mod power;
mod quasi_static;
pub mod servo;
mod shares;
pub mod signal;
mod spread;
mod together;

pub use basis::Smooth;
pub use clock::Clock;
pub use compliance::Compliance;
pub use joint::{DETERMINED_SHARE, LinkError};
pub use link_names::{NoLinks, links};
pub use measurement::{Of, measurement};
pub use parts::{Decomposition, DecompositionError, DecompositionOptions, RunParts, decompose};
pub use power::{DETERMINED_EXPONENT, PowerLaw, power_law};
pub use servo::{AxisServoErrors, LoopLimits, ServoErrors};
pub use shares::{SOURCES, SourceShares};
