//! The body that is to be molded: its boundary and chambers as closed surfaces, collars around its
//! inlets, sheets laid into it, which way it stands in a mold, what it weighs, and from which file it
//! came.

pub mod collar;
pub mod layer;
pub mod layout;
pub mod orientation;
pub mod boundary;
pub mod source;
pub mod weight;
