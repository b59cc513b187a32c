//! The verbs of `solver`.

pub mod check;
pub mod compare;
pub mod fit;
pub mod import;
pub mod list;
pub mod optimize;
pub mod plot;
pub mod simulate;
