//! Two castings: the chamber, open to a plane, and the sheet that closes it.

use super::pull_out::pulled;
use super::{Bodies, Castings, Core, JudgedBy, Row};

pub static ROW: Row = Row {
    name: "open-top",
    bodies: Bodies::WithChambers,
    judged_by: JudgedBy::FlatWall,
    castings: Castings::ChamberAndSheet,
    core: Core { filament: None, stands_on_stub: false, leaves: pulled },
    steps: |_| STEPS,
};

const STEPS: &[&str] = &[
    "Cast the chamber over the plate that carries the core, and pour the sheet into its open tray up to the brim.",
    "Clean the cut faces with alcohol, wet that of the chamber with a thin film of the same uncured silicone, and lay it on the sheet until it has cured: within a day of casting, as cured silicone bonds badly.",
    "Cut the film of silicone away that closes the inlet, if there is one.",
];
