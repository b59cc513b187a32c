//! Two halves, each cast on a half core, and glued.

use super::pull_out::pulled;
use super::{Bodies, Castings, Core, JudgedBy, Row};

pub static ROW: Row = Row {
    name: "halves",
    bodies: Bodies::All,
    judged_by: JudgedBy::HalfCores,
    castings: Castings::Halves,
    core: Core { filament: None, stands_on_stub: false, leaves: pulled },
    steps: |chambers| if chambers == 0 { SOLID } else { STEPS },
};

const GLUE: &str = "Clean the cut faces with alcohol, wet both with a thin film of the same uncured silicone, and press them together until it has cured: within a day of casting, as cured silicone bonds badly.";

const SOLID: &[&str] = &["Cast both halves, each over its plate.", GLUE];

const STEPS: &[&str] = &[
    "Cast both halves, each over the plate that carries its half of the core.",
    GLUE,
    "A closed chamber takes its tube through a hole that is pierced afterwards, sealed with the same silicone.",
];
