//! Printable molds from an optimised body.
//!
//! One room per kind of work, in dependency order: a room uses only rooms before it.
//!
//! Lengths are metres until the files for printing, which are in millimetres.

// mold.toml: its keys with defaults, limits and documentation
pub mod config;
// the body as closed surfaces, its collars, and how it stands
pub mod body;
// how a body is molded, and why: plan.json
pub mod plan;
// the pieces of a mold
pub mod mold;
// what is written: STL, 3MF, mold.json, the sheet for casting, pictures
pub mod files;
// proofs that a written mold is right
pub mod verify;
// the verbs of the program, one per file
pub mod cmd;
