//! From geometry to finite element meshes: implicit models and CAD files become
//! closed surfaces in named regions, these become tetrahedra.
//!
//! - [`implicit`]: signed-distance primitives, smooth blends, regions
//! - [`cad`]: gmsh scripts, STEP, BREP and IGES files
//! - [`import`]: bodies that others made, in any unit, sound or not
//! - [`geo`]: what a gmsh script may do
//! - [`labelled`]: a surface in regions and its files
//! - [`solids`]: what several solids of a CAD file are to each other
//! - [`offset`]: open patch → closed selection volume
//! - [`layers`]: surfaces inside a body that its mesh keeps
//! - [`tetrahedralize`]: checks around a mesher, and its report
//! - [`mesher`]: the external programs
//! - [`fragments`]: removes small components that a mesher has cut off, and spikes
//! - [`planar`]: planar faces of the input stay planar, and keep their rims
//! - [`cache`]: meshes kept from earlier runs
//! - [`checkout`]: where the program was built
//! - [`installed`]: what came with the program
//! - [`template`]: bodies to begin with
//!
//! Lengths are metres except inside [`implicit`], which works in the unit of the
//! model file.

pub mod cache;
pub mod cad;
pub mod checkout;
pub mod cmd;
pub mod config;
pub mod fragments;
pub mod geo;
pub mod implicit;
pub mod import;
pub mod installed;
pub mod labelled;
pub mod layers;
pub mod mesher;
pub mod offset;
pub mod planar;
pub mod record;
pub mod report;
pub mod solids;
pub mod template;
pub mod tetrahedralize;
pub mod units;

/// Name and version, for reports.
pub const PROGRAM: &str = concat!("cad2fem ", env!("CARGO_PKG_VERSION"));
