//! A core cast of wax in a mold of its own, and molten out. It is as good as a soluble one but takes one more casting,
//! so it is used only if it is asked for.

use super::{Bodies, Castings, Core, JudgedBy, Leaving, Made, Row};

pub static ROW: Row = Row {
    name: "wax",
    bodies: Bodies::WithChambers,
    judged_by: JudgedBy::Inlets,
    is_automatic: false,
    castings: Castings::Body,
    core: Core {
        made: Made::Cast,
        stands_on_stub: false,
        is_bored: false,
        vanishes: true,
        leaves: molten,
    },
    steps: |_| STEPS,
};

const STEPS: &[&str] = &[
    "Cast the core of wax in its own mold, and put it into the mold of the body.",
    "Close the mold around the core and cast it.",
    "Take the shells off, let the wax melt out through the inlet below the softening point of the printed parts, and rinse with hot water.",
];

fn molten(Leaving { cores, inlets, .. }: &Leaving) -> String {
    format!(
        "Let {cores} melt out through {inlets}, and rinse with hot water; stay below what softens the printed parts."
    )
}
