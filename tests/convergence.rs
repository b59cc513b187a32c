//! Against closed forms and independent numbers, with tables on standard error:
//! `cargo test --release -p tests --test convergence -- --nocapture`.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "convergence/arch.rs"]
mod arch;
#[path = "convergence/balloon.rs"]
mod balloon;
#[path = "convergence/cantilever.rs"]
mod cantilever;
#[path = "convergence/column.rs"]
mod column;
#[path = "convergence/contact.rs"]
mod contact;
#[path = "convergence/fibre.rs"]
mod fibre;
#[path = "convergence/hertz.rs"]
mod hertz;
#[path = "convergence/land.rs"]
mod land;
#[path = "convergence/layers.rs"]
mod layers;
#[path = "convergence/manufactured.rs"]
mod manufactured;
#[path = "convergence/membrane.rs"]
mod membrane;
#[path = "convergence/node_order.rs"]
mod node_order;
#[path = "convergence/patch.rs"]
mod patch;
#[path = "convergence/pile.rs"]
mod pile;
#[path = "convergence/pressed_cube.rs"]
mod pressed_cube;
#[path = "convergence/radial.rs"]
mod radial;
#[path = "convergence/ring.rs"]
mod ring;
#[path = "convergence/schedules.rs"]
mod schedules;
#[path = "convergence/shell.rs"]
mod shell;
#[path = "convergence/sphere_volume.rs"]
mod sphere_volume;
#[path = "convergence/supports.rs"]
mod supports;
#[path = "convergence/symmetric_gas.rs"]
mod symmetric_gas;
#[path = "convergence/volumes.rs"]
mod volumes;
