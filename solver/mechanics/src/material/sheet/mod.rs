//! Laws of thin sheets in plane stress: energy per rest volume ψ(E) [J/m³] of the strain in
//! the plane of the sheet.
//!
//! E = ½ (C − I)     C = FᵀF of the 3×2 gradient F of the deformed position along the rest sheet
//! S = ∂ψ/∂E         force per rest width and thickness, pulled back to the rest sheet
//! D = ∂S/∂E
//!
//! in an orthonormal basis of the rest sheet, as [E₁₁, E₂₂, 2 E₁₂] and [S₁₁, S₂₂, S₁₂], so that
//! S · δE = δψ. Most laws are isotropic: the basis does not matter. One that has axes takes the components
//! along them. Stress across the sheet is zero; its change of thickness is eliminated. A sheet has no stiffness against bending.
//!
//! One law per file, one row per law in [`LAWS`]. [`TensionField`] takes compression away from
//! any of them.

mod linear;
mod neo_hookean;
mod tension;
#[cfg(test)]
mod tests;
mod woven;

pub use linear::Linear;
pub use neo_hookean::NeoHookean;
pub use tension::{State, Strip, TensionField, principal};
pub use woven::Woven;

use super::{Law, Parameter};
use crate::math::tensor::Mat3;

/// Green–Lagrange strain [E₁₁, E₂₂, 2 E₁₂] in the plane of a sheet.
pub type Strain = nalgebra::Vector3<f64>;

/// Second Piola–Kirchhoff stress [S₁₁, S₂₂, S₁₂] [Pa].
pub type Stress = nalgebra::Vector3<f64>;

/// A hyperelastic law of a sheet; isotropic in its plane, if it has no axes.
pub trait Sheet: Send + Sync {
    /// ψ [J/m³].
    fn energy_density(&self, e: &Strain) -> f64;
    /// S = ∂ψ/∂E [Pa].
    fn stress(&self, e: &Strain) -> Stress;
    /// D = ∂S/∂E [Pa]; where a second derivative jumps, that of one side.
    fn tangent(&self, e: &Strain) -> Mat3;
    /// What its law is made with, one number each.
    fn parameters(&self) -> &'static [Parameter];
    /// Adds S̄ · ∂S/∂parameters for S̄ = [S̄₁₁, S̄₂₂, 2 S̄₁₂], in the order of the law's
    /// [`Law::parameters`].
    fn add_parameter_vjp(&self, e: &Strain, s_bar: &Strain, out: &mut [f64]);
    /// Principal strain E₂ at which S₂ = 0 while the other is E₁ (natural width in tension).
    fn natural_width(&self, stretched: f64) -> f64;
    /// Whether it is another along other directions of the sheet.
    fn has_axes(&self) -> bool {
        false
    }
    /// What a sheet in tension does at a strain.
    fn state(&self, e: &Strain) -> State {
        tension::state(principal(e), |first| self.natural_width(first))
    }
    /// The strips that carry all where it is wrinkled.
    fn strip(&self, e: &Strain) -> Strip {
        let first = principal(e)[0];
        let at = Strain::new(first, self.natural_width(first), 0.0);
        Strip::isotropic(e, at, self.stress(&at)[0], &self.tangent(&at))
    }
}

/// The laws, in the order in which they are listed.
pub const LAWS: &[Law<dyn Sheet>] = &[linear::LAW, neo_hookean::LAW, woven::LAW];

/// A law of a sheet with its parameters.
#[derive(Clone)]
pub struct Specification {
    /// The law.
    pub law: &'static Law<dyn Sheet>,
    /// The parameters.
    pub values: Vec<f64>,
}

impl Specification {
    /// The law, ready for use; without compression if it carries `tension` only.
    pub fn build(&self, tension: bool) -> Box<dyn Sheet> {
        let law = (self.law.build)(&self.values);
        if tension { Box::new(TensionField(law)) } else { law }
    }
}
