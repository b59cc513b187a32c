//! The body that is to be molded: its boundary and chambers as closed surfaces, collars around its
//! inlets, which way it stands in a mold, and from which file it came.

pub mod collar;
pub mod layout;
pub mod orientation;
pub mod boundary;
pub mod source;
