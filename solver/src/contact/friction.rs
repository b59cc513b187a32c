//! Contacts that rub.

use mesh::Vec3;

/// A contact with friction, as it was at the start of a time step: its normal
/// force, and how velocities of its corners make a sliding velocity
/// 𝒯ᵀ Σᵢ cᵢ vᵢ.
#[derive(Clone, Debug, PartialEq)]
pub struct Sliding {
    /// Collision vertices of the two features.
    pub corners: [usize; 4],
    /// Barycentric coefficients cᵢ of the closest points, negative on the second
    /// feature [1].
    pub coefficients: [f64; 4],
    /// Two orthonormal directions 𝒯 in which it slides.
    pub tangents: [Vec3; 2],
    /// Normal force [N].
    pub force: f64,
}
