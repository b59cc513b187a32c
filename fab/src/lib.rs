//! Printable molds from an optimised body.
//!
//! A tagged volume mesh becomes its outer skin and its cavity ([`skin`]), these
//! become a mold ([`mold`]), the mold becomes files ([`export`], [`report`]), and
//! the files are proved to be right by reading them back ([`verify`]).
//!
//! Lengths are metres until the files for printing, which are in millimetres.

pub mod cap;
pub mod cmd;
pub mod columns;
pub mod config;
pub mod export;
pub mod frame;
pub mod layout;
pub mod maxima;
pub mod method;
pub mod mold;
pub mod parting;
pub mod parts;
pub mod plan;
pub mod report;
pub mod skin;
pub mod split;
pub mod stance;
pub mod venting;
pub mod verify;
