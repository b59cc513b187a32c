//! Constitutive laws ψ(F): energy per rest volume [J/m³].
//!
//! One law per file, or two that differ in one term; one row per law in [`LAWS`]. Laws of thin sheets are in [`sheet`], that of fibres in [`fibre`].

mod arruda_boyce;
pub mod fibre;
mod gent;
mod isochoric;
mod decoupled;
mod kinematics;
mod lame;
mod law;
mod linear_elastic;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod ogden_roxburgh;
mod points;
pub mod response;
mod saint_venant_kirchhoff;
pub mod sheet;
pub mod slack;
mod specification;
mod split;
#[cfg(test)]
mod tests;
mod yeoh;

pub use arruda_boyce::ArrudaBoyce;
pub use decoupled::{Decoupled, Invariants, Partials};
pub use gent::Gent;
pub use isochoric::Isochoric;
pub use kinematics::Kinematics;
pub use lame::Lame;
pub use law::{BULK_RATIO, Law, Moduli, NotPositive, Parameter};
pub use linear_elastic::LinearElastic;
pub use mooney_rivlin::{MooneyRivlin, MooneyRivlinQuadratic};
pub use neo_hookean::NeoHookean;
pub use ogden::Ogden;
pub use ogden_roxburgh::{OgdenRoxburgh, Softened};
pub use points::{Points, add_j_hessian, j_minus_1, volume_change};
pub use saint_venant_kirchhoff::SaintVenantKirchhoff;
pub use specification::{Softening, Specification};
pub use split::Split;
pub use yeoh::Yeoh;

use crate::math::tensor::{Mat3, Mat9};

/// A hyperelastic law. The energy of an inverted point (J ≤ 0) is infinite, and so is that of
/// a strain a law does not admit; stress and tangent have no meaning there.
pub trait Material: Send + Sync {
    /// ψ [J/m³].
    fn energy_density(&self, k: &Kinematics) -> f64;
    /// First Piola–Kirchhoff stress P = ∂ψ/∂F [Pa].
    fn first_piola(&self, k: &Kinematics) -> Mat3;
    /// A = ∂P/∂F [Pa].
    fn tangent(&self, k: &Kinematics) -> Mat9;
    /// Number of parameters.
    fn parameter_count(&self) -> usize;
    /// Adds P̄ : ∂P/∂parameters, in the order of the law's [`Law::parameters`].
    fn add_parameter_vjp(&self, k: &Kinematics, p_bar: &Mat3, out: &mut [f64]);
    /// The law as ψ̄(Ī₁, Ī₂) + U(J), if it is one.
    fn decoupled(&self) -> Option<&dyn Decoupled> {
        None
    }
    /// The law as compressible neo-Hookean, if it is that.
    fn neo_hookean(&self) -> Option<&NeoHookean> {
        None
    }
    /// ψ(J^{−1/3} F), if it is a law in Ī₁ and Ī₂.
    fn isochoric(&self) -> Option<Isochoric> {
        None
    }
    /// The law in two parts, if it has a term of the change of volume alone.
    fn split(&self) -> Option<Split> {
        None
    }
}

/// The laws, in the order in which they are listed.
pub const LAWS: &[Law] = &[
    mooney_rivlin::LAW,
    mooney_rivlin::QUADRATIC,
    neo_hookean::LAW,
    yeoh::LAW,
    gent::LAW,
    arruda_boyce::LAW,
    ogden::LAW,
    saint_venant_kirchhoff::LAW,
    linear_elastic::LAW,
];
