//! None: the body has no chamber.

use super::pull_out::pulled;
use super::{Bodies, Castings, Core, JudgedBy, Made, Row};

pub static ROW: Row = Row {
    name: "solid",
    bodies: Bodies::Solid,
    judged_by: JudgedBy::NoChamber,
    is_automatic: true,
    castings: Castings::Body,
    core: Core {
        made: Made::Printed,
        stands_on_stub: false,
        is_bored: false,
        vanishes: false,
        leaves: pulled,
    },
    steps: |_| &["Close the mold and cast the body.", "Take the shells off."],
};
