//! Implicit models: primitives and smooth blends → closed surface and regions.
//!
//! Design of the mesher, in the order of what it does:
//! 1. The body is where all its sides are negative: its cuts, the solid and minus the cavity (`sides`).
//! 2. Bounds of these functions over balls (`range`) find the cubes that the surface may meet; those are
//!    filled with tetrahedra of a body-centred cubic lattice (`lattice`).
//! 3. Where two sheets lie within an edge, or the surface bends, tetrahedra are halved (`refine`).
//! 4. In each tetrahedron each side is linear. One side after the other is carved out: tetrahedra are
//!    split at the zeros of their edges, and those outside go (`carve`). Corners near a zero are moved onto
//!    it first, along the surfaces and planes that they are on, so that these stay sharp and exact.
//! 5. All this happens in coordinates that 32-bit floats hold, and leaves no tetrahedron without a positive
//!    volume, exactly (`complex`). The boundary of what is left is closed, oriented and never crosses
//!    itself. Where it would touch itself, corners are taken off the surface again, which ends with a
//!    manifold: without a corner on the surface a linear function has no critical value there.
//! 6. What may fail is sharpness (a corner that cannot be moved) and resolution (sheets that no edge tells
//!    apart); either is said with its place (`thin`). Simplification is checked, and left out if need be.

mod carve;
mod complex;
mod field;
mod lattice;
mod model;
mod range;
mod refine;
mod region;
mod resolution;
mod shape;
mod sides;
mod skin;
mod surface;
mod thin;
mod value;

pub use field::Field;
pub use model::{Cuboid, Cut, Model, ModelFile, Op, Primitive, Region};
pub use region::assign;
pub use shape::{Rotation, Shape};
pub use skin::{Kind, Part, Skin, Thin};
pub use surface::surface;

/// The two implicit functions of a model.
pub struct Fields {
    /// The body with its cavities filled.
    pub solid: Field,
    /// What is taken out.
    pub cavity: Field,
}

impl Fields {
    /// The functions of `model`, with its ornaments if `fine`.
    pub fn new(model: &Model, fine: bool) -> Self {
        Self { solid: Field::new(&model.solid, fine), cavity: Field::new(&model.cavity, fine) }
    }
}
