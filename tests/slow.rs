//! Tests that take minutes: the beam from model to molds, and the molds of all scenes.
//!
//! `make test-all` makes the beam and then runs these; they are not for
//! `make test`, which says so for each.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "slow/beam.rs"]
mod beam;

#[path = "slow/molds.rs"]
mod molds;
