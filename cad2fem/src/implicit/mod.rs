//! Implicit models: primitives and smooth blends → closed surface and regions.
//!
//! The surface is that of {d_solid < 0} without {d_cavity < 0}, each laid by marching
//! tetrahedra for itself, so that a wall between them may be thinner than the grid;
//! planar faces are cut afterwards, so that they are planar to the last bit.

mod field;
mod model;
mod region;
mod resolution;
mod shape;
mod surface;

pub use field::Field;
pub use model::{Cuboid, Cut, Model, ModelFile, Op, Primitive, Region};
pub use region::assign;
pub use shape::{Rotation, Shape};
pub use surface::{Part, Skin, surface};

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
