//! A rigid core, pulled out through the inlet.

use super::{Bodies, Castings, Core, JudgedBy, Leaving, Row};

pub static ROW: Row = Row {
    name: "pull-out",
    bodies: Bodies::WithChambers,
    judged_by: JudgedBy::Girth,
    castings: Castings::Body,
    core: Core { filament: None, stands_on_stub: true, leaves: pulled },
    steps: |_| STEPS,
};

const STEPS: &[&str] = &[
    "Close the mold around the core and cast it.",
    "Take the shells off, then pull the core out through the inlet: it must stretch, so wet it with soapy water.",
];

/// How cores are pulled out.
pub fn pulled(Leaving { cores, them, inlets }: &Leaving) -> String {
    format!(
        "Let soapy water or air in between {cores} and the silicone, and pull {them} out through {inlets}."
    )
}
