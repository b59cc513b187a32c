//! Implicit models: primitives and smooth blends → closed surface and regions.
//!
//! The surface is the zero level of max(d_solid, −d_cavity), laid by marching
//! tetrahedra and simplified; planar faces are cut afterwards, so that they are
//! planar to the last bit.

mod field;
mod model;
mod region;
mod shape;

use anyhow::{Result, ensure};
use mesh::solid::Solid;
use mesh::{SurfaceMesh, Vec3};

pub use field::Field;
pub use model::{Cuboid, Cut, Model, ModelFile, Op, Primitive, Region};
pub use region::assign;
pub use shape::{Rotation, Shape};

/// The two implicit functions of a model.
pub struct Fields {
    /// The body with its cavities filled.
    pub solid: Field,
    /// What is taken out.
    pub cavity: Field,
}

impl Fields {
    /// The functions of `model`, with its ornaments if `fine`.
    #[must_use]
    pub fn new(model: &Model, fine: bool) -> Self {
        Self { solid: Field::new(&model.solid, fine), cavity: Field::new(&model.cavity, fine) }
    }
}

/// The closed surface of a model [unit of the file].
///
/// # Errors
/// If nothing is left of the body or if it falls into pieces.
pub fn surface(model: &Model, fields: &Fields) -> Result<SurfaceMesh> {
    let distance = |p: Vec3| fields.solid.at(&p).max(-fields.cavity.at(&p));
    let mut solid = Solid::level_set(distance, model.bounds(), model.grid);
    if model.simplify > 0.0 {
        solid = solid.simplify(model.simplify);
    }
    for cut in &model.cut {
        solid = solid.trim_by_plane(&-Vec3::from(cut.normal), -cut.offset);
    }
    ensure!(!solid.is_empty(), "nothing is left of the body: do its primitives lie behind a cut?");
    let pieces = solid.decompose().len();
    ensure!(
        pieces == 1,
        "the body falls into {pieces} pieces; it must be one: join its primitives"
    );
    let mut surface = solid.to_surface();
    for cut in &model.cut {
        snap(&mut surface, cut, model.grid * 1e-6);
    }
    Ok(surface)
}

/// Moves vertices that rounding has put beside the plane of a cut onto it.
fn snap(surface: &mut SurfaceMesh, cut: &Cut, tolerance: f64) {
    let normal = Vec3::from(cut.normal).normalize();
    for v in &mut surface.vertices {
        let beside = normal.dot(v) - cut.offset;
        if beside.abs() <= tolerance {
            *v -= normal * beside;
        }
    }
}
