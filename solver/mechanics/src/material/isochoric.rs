//! The isochoric part of a law: ψ̄(F) = ψ(J^{−1/3} F), which is what the law does with change of
//! shape alone.

use std::sync::Arc;

use super::Kinematics;
use super::decoupled::{Decoupled, Invariants, Partials, alone};

/// ψ̄(Ī₁, Ī₂) = ψ(Ī₁, Ī₂, J) − ψ(3, 3, J) of a law in which J does not couple to the others. It has
/// all parameters of the law; those of the bulk do nothing.
#[derive(Clone)]
pub struct Isochoric(Arc<dyn Decoupled>);

impl Isochoric {
    /// The isochoric part of a law.
    pub fn new(law: impl Decoupled + 'static) -> Self {
        Self(Arc::new(law))
    }

    /// Adds bar ∂ψ̄/∂parameters.
    pub fn add_energy_vjp(&self, k: &Kinematics, bar: f64, out: &mut [f64]) {
        self.add_value_vjp(&alone(k).invariants()[0], bar, out);
    }
}

impl Decoupled for Isochoric {
    fn partials(&self, at: &Invariants) -> Partials {
        let whole = self.0.partials(at);
        let bulk = self.0.partials(&Invariants { a: 0.0, b: 0.0, ..*at }).value;
        let ([by_1, by_2, _], [a, b, c, _]) = (whole.first, whole.second);
        Partials { value: whole.value - bulk, first: [by_1, by_2, 0.0], second: [a, b, c, 0.0] }
    }

    fn parameter_count(&self) -> usize {
        self.0.parameter_count()
    }

    fn add_value_vjp(&self, at: &Invariants, bar: f64, out: &mut [f64]) {
        self.0.add_value_vjp(at, bar, out);
        self.0.add_value_vjp(&Invariants { a: 0.0, b: 0.0, ..*at }, -bar, out);
    }

    fn add_partials_vjp(&self, at: &Invariants, [by_1, by_2, _]: [f64; 3], out: &mut [f64]) {
        self.0.add_partials_vjp(at, [by_1, by_2, 0.0], out);
    }
}
