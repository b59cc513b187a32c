//! Constitutive laws ψ(F): energy per rest volume [J/m³].

mod isotropic;
mod kinematics;
mod mooney_rivlin;

pub use isotropic::{Isotropic, Partials};
pub use kinematics::Kinematics;
pub use mooney_rivlin::MooneyRivlin;

use crate::math::tensor::{Mat3, Mat9};

/// A hyperelastic law. The energy of an inverted point (J ≤ 0) is infinite.
pub trait Material: Send + Sync {
    /// ψ [J/m³].
    fn energy_density(&self, k: &Kinematics) -> f64;
    /// First Piola–Kirchhoff stress P = ∂ψ/∂F [Pa].
    fn first_piola(&self, k: &Kinematics) -> Mat3;
    /// A = ∂P/∂F [Pa].
    fn tangent(&self, k: &Kinematics) -> Mat9;
}
