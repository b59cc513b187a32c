//! Tests that run in seconds.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "fast/energies.rs"]
mod energies;
#[path = "fast/reference.rs"]
mod reference;
