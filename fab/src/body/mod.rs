//! The body that is to be molded: its boundary and chambers as closed surfaces, on the mesh or on its model, which is
//! carried with a design, collars around its inlets, sheets laid into it, grooves for thread, which way it stands in a mold,
//! what it weighs, and from which files it came.

pub mod air;
pub mod boundary;
mod carried;
pub mod collar;
pub mod course;
mod displacement;
pub mod files;
pub mod groove;
mod joined;
mod labels;
pub mod layer;
pub mod layout;
pub mod orientation;
mod slivers;
pub mod source;
pub mod thread;
pub mod weight;
