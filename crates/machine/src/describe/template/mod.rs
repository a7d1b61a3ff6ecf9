//! Templates of machines: one file for each usual chain, as data.

mod bridge;
mod gantry;
mod head_ac;
mod head_bc;
mod horizontal;
mod knee;
mod lathe;
mod mill_turn;
mod mixed_bc;
mod moving_bed_router;
mod nutating_head;
mod nutating_table;
mod router;
mod swivel_head;
mod trunnion_ac;
mod trunnion_bc;
mod vmc;
mod vmc_a;

use ncfix_base::geometry::Axis;

/// Chain of a usual machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Template {
    /// Name on the command line.
    pub name: &'static str,
    /// Chain of bodies; empty if the machine file cannot describe the machine.
    pub topology: &'static str,
    /// Description in one line.
    pub line: &'static str,
    /// Travels of X, Y and Z that are assumed if nobody states them, mm.
    pub travels_mm: [[f64; 2]; 3],
    /// Rotary axes.
    pub rotary: &'static [TemplateRotary],
    /// True for a router, whose owner usually has a ruler and no laser.
    pub is_router: bool,
    /// Parts of such a machine that the machine file lacks; empty if it describes the machine.
    pub lacks: &'static str,
}

/// Rotary axis of a template.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TemplateRotary {
    /// Axis.
    pub axis: Axis,
    /// Vector along the axis in F. For the sense `+` the part that it carries turns about it by the right-hand rule. Its length has no meaning.
    pub line: [f64; 3],
    /// Travel that is assumed if nobody states it, degrees; `None` for a modulo axis.
    pub travel_deg: Option<[f64; 2]>,
}

/// Templates in the order of the list.
pub const TEMPLATES: &[Template] = &[
    vmc::VMC,
    bridge::BRIDGE,
    gantry::GANTRY,
    router::ROUTER,
    moving_bed_router::MOVING_BED_ROUTER,
    knee::KNEE,
    vmc_a::VMC_A,
    horizontal::HORIZONTAL,
    trunnion_ac::TRUNNION_AC,
    trunnion_bc::TRUNNION_BC,
    head_ac::HEAD_AC,
    head_bc::HEAD_BC,
    mixed_bc::MIXED_BC,
    nutating_table::NUTATING_TABLE,
    nutating_head::NUTATING_HEAD,
    swivel_head::SWIVEL_HEAD,
    lathe::LATHE,
    mill_turn::MILL_TURN,
];

/// Returns the template of a name.
///
/// # Errors
/// Returns a sentence that names the templates if the name is unknown, or the parts that the machine file lacks for it.
pub fn template(name: &str) -> Result<&'static Template, String> {
    let Some(found) = TEMPLATES.iter().find(|template| template.name.eq_ignore_ascii_case(name)) else {
        let names: Vec<&str> = TEMPLATES.iter().map(|template| template.name).collect();
        return Err(format!("'{name}' is not a template; write one of {}", names.join(", ")));
    };
    if found.lacks.is_empty() {
        return Ok(found);
    }
    Err(format!("there is no machine file for a {name} yet: ncfix lacks {}", found.lacks))
}
