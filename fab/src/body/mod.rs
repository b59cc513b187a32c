//! The body that is to be molded: its boundary and chambers as closed surfaces, on the mesh or on its model, collars
//! around its inlets, sheets laid into it, grooves for thread, which way it stands in a mold, what it weighs, and from
//! which files it came.

pub mod boundary;
pub mod collar;
pub mod course;
pub mod files;
pub mod groove;
mod joined;
mod labels;
pub mod layer;
pub mod layout;
pub mod orientation;
pub mod source;
pub mod thread;
pub mod walls;
pub mod weight;
