//! None: the body has no chamber.

use super::pull_out::pulled;
use super::{Bodies, Castings, Core, JudgedBy, Row};

pub static ROW: Row = Row {
    name: "solid",
    bodies: Bodies::Solid,
    judged_by: JudgedBy::NoChamber,
    castings: Castings::Body,
    core: Core { filament: None, stands_on_stub: false, leaves: pulled },
    steps: |_| &["Close the mold and cast the body.", "Take the shells off."],
};
