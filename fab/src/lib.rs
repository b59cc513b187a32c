//! Printable molds from an optimised body.
//!
//! A tagged volume mesh becomes its outer skin and its cavity ([`skin`]), these
//! become a mold ([`mold`]), the mold becomes files ([`export`], [`report`], [`output`]), and
//! the files are proved to be right by reading them back ([`verify`]).
//!
//! Lengths are metres until the files for printing, which are in millimetres.

pub mod assembly;
pub mod cap;
pub mod cast;
pub mod cmd;
pub mod collar;
pub mod columns;
pub mod config;
pub mod export;
pub mod frame;
pub mod layout;
pub mod maxima;
pub mod method;
pub mod mold;
pub mod output;
pub mod parting;
pub mod parts;
pub mod picture;
pub mod plan;
pub mod report;
pub mod skin;
pub mod slicer;
pub mod split;
pub mod stance;
pub mod threemf;
pub mod tolerance;
pub mod underside;
pub mod venting;
pub mod verify;
