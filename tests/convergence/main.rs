//! Against closed forms and independent numbers, with tables on standard error:
//! `cargo test --release -p tests --test convergence -- --nocapture`.
#![allow(missing_docs, clippy::unwrap_used)]

mod arch;
mod balloon;
mod cantilever;
mod column;
mod contact;
mod fibre;
mod hertz;
mod inflated;
mod land;
mod manufactured;
mod membrane;
mod nodal;
mod node_order;
mod patch;
mod pile;
mod pressed_cube;
mod radial;
mod ring;
mod schedules;
mod shell;
mod sphere_volume;
mod supports;
mod volumes;
