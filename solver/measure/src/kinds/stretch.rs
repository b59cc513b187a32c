//! The stretch of bodies, nearly the largest.
//!
//! q = 1 + (I/V)^(1/p)      I = ∫ Σ_i (λ_i − 1)₊^p dX,  V = ∫ dX        [1]
//!
//! λ_i   principal stretches, the singular values of F = I + ∇u [1]
//! p     the larger, the nearer q is to the largest stretch anywhere, from below
//!
//! ∂q = (q − 1)/p (∂I/I − ∂V/V). Σ is symmetric in the stretches, so that it has a derivative where they coincide.

use std::ops::Range;

use mechanics::math::tensor::Mat3;

use super::strain_limit::over_stretches;
use super::*;

pub(super) const KIND: Kind =
    Kind { key: "stretch", unit: "1", example: "power = 4", ..Kind::of::<Keys>(&[List::Probe]) };

program::table! {
    /// 1 + (∫ Σ (λ_i − 1)₊^p dX / ∫ dX)^(1/p) of the principal stretches: the larger p, the nearer to the largest
    #[derive(Debug)]
    struct Keys {
        /// body; all if not given
        on: Option<String> = None;
        /// p ≥ 2
        power: f64 = 16.0, program::table::Range::at_least(2.0);
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        Ok(Arc::new(Stretch { elements: site.elements(self.on.as_deref())?, power: self.power }))
    }
}

struct Stretch {
    elements: Vec<Range<usize>>,
    power: f64,
}

impl Stretch {
    /// Σ (λ_i − 1)₊^p with its derivative by F.
    fn density(&self, grad_u: &Mat3) -> (f64, Mat3) {
        over_stretches(grad_u, |stretch| {
            let beyond = (stretch - 1.0).max(0.0);
            (beyond.powf(self.power), self.power * beyond.powf(self.power - 1.0))
        })
    }

    /// I and V.
    fn integrals(&self, at: &Equilibrium) -> [f64; 2] {
        let sum = |density: &(dyn Fn(&Mat3) -> (f64, Mat3) + Sync)| {
            self.elements.iter().map(|part| solid_integral::value(at, part, density)).sum()
        };
        [sum(&|h| self.density(h)), sum(&|_| (1.0, Mat3::zeros()))]
    }
}

impl Quantity for Stretch {
    fn value(&self, at: &Equilibrium) -> f64 {
        let [all, volume] = self.integrals(at);
        1.0 + (all / volume).powf(1.0 / self.power)
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let [all, volume] = self.integrals(at);
        if all == 0.0 {
            return;
        }
        let factor = weight * (all / volume).powf(1.0 / self.power) / self.power;
        let density = |h: &Mat3| {
            let (value, by_f) = self.density(h);
            (factor * (value / all - 1.0 / volume), factor / all * by_f)
        };
        for elements in &self.elements {
            solid_integral::add_partials(at, elements, &density, 1.0, out);
        }
    }
}
