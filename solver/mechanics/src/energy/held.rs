//! A term of the energy whose loads are held as they are at a moment, while others go on.

use std::sync::Arc;

use super::{Energy, Hessian, Iterate, Nature, RankOne};
use crate::math::sparse::BlockMatrix;

/// A term at a time that does not pass.
#[derive(Clone)]
pub struct Held {
    /// The term.
    pub energy: Arc<dyn Energy>,
    /// Time at which it is held [s].
    pub time: f64,
}

impl Held {
    fn at<'a>(&self, iterate: &Iterate<'a>) -> Iterate<'a> {
        Iterate { time: self.time, ..*iterate }
    }
}

impl Energy for Held {
    fn name(&self) -> &'static str {
        self.energy.name()
    }

    fn nature(&self) -> Nature {
        Nature::Other
    }

    fn value(&self, at: &Iterate) -> f64 {
        self.energy.value(&self.at(at))
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        self.energy.add_gradient(&self.at(at), out);
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        self.energy.add_hessian(&self.at(at), kind, out);
    }

    fn rank_one(&self, at: &Iterate) -> Option<RankOne> {
        self.energy.rank_one(&self.at(at))
    }

    fn couplings(&self, at: &Iterate, reach: f64) -> Vec<[usize; 2]> {
        self.energy.couplings(&self.at(at), reach)
    }

    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        self.energy.add_mixed_vjp(&self.at(at), lambda, out);
    }
}
