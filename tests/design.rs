//! Whole designs of small bodies, and their gradients checked by the programs.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "design/bar.rs"]
mod bar;
#[path = "design/bounds.rs"]
mod bounds;
#[path = "design/constraints.rs"]
mod constraints;
#[path = "design/grip.rs"]
mod grip;
#[path = "design/levels.rs"]
mod levels;
#[path = "design/together.rs"]
mod together;
