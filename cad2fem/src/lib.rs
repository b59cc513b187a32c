//! From geometry to finite element meshes: implicit models and CAD files become
//! closed surfaces in named regions, these become tetrahedra.
//!
//! In the order in which a body passes through them:
//!
//! - [`template`]: bodies to begin with
//! - [`implicit`]: signed-distance primitives, smooth blends, regions
//! - [`mesher`]: the external programs, what they are run with, and what surfaces inside they keep
//! - [`model`]: a surface in regions and its files; CAD files, which become one
//! - [`tetmesh`]: closed surface → tetrahedra: settings, checks around a mesher, repairs, kept meshes
//! - [`import`]: bodies that others made, in any unit, sound or not
//! - [`selection`]: open patch → closed selection volume
//! - [`cmd`]: the verbs; of these alone pictures, films, pages and packages
//!
//! and beside them [`units`], [`report`], what the reports of verbs share, and [`installation`], what came with the
//! program and where it was built.
//!
//! Lengths are metres except inside [`implicit`], which works in the unit of the
//! model file.

pub mod cmd;
pub mod import;
pub mod installation;
pub mod mesher;
pub mod model;
pub mod report;
pub mod selection;
pub mod template;
pub mod tetmesh;

/// Name and version, for reports.
pub const PROGRAM: &str = concat!("cad2fem ", env!("CARGO_PKG_VERSION"));
