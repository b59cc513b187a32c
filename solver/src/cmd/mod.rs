//! The verbs of `solver`.

pub mod check;
pub mod optimize;
pub mod simulate;
