//! A core printed of what water dissolves.

use super::{Bodies, Castings, Core, Filament, JudgedBy, Leaving, Row};

pub static ROW: Row = Row {
    name: "soluble",
    bodies: Bodies::WithChambers,
    judged_by: JudgedBy::Inlets,
    castings: Castings::Body,
    core: Core { filament: Some(POLYVINYL_ALCOHOL), stands_on_stub: true, leaves: dissolved },
    steps: |_| STEPS,
};

const POLYVINYL_ALCOHOL: Filament = Filament {
    name: "PVA",
    density: 1.23,
    item: "filament that water dissolves (PVA or BVOH)",
    words: "a filament that water dissolves",
};

const STEPS: &[&str] = &[
    "Print the core of a filament that water dissolves (PVA or BVOH), the rest of any other.",
    "Close the mold around the core and cast it.",
    "Take the shells off and leave the body in warm water, flushed through the bore of the core, until nothing of the core is left.",
];

fn dissolved(Leaving { cores, them, .. }: &Leaving) -> String {
    format!(
        "Leave the body in warm water, flushed through the bore of {cores}, until nothing of {them} is left."
    )
}
