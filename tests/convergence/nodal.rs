//! Given forces on nodes.

use mechanics::energy::{Energy, Hessian, Iterate, Nature};
use mechanics::math::sparse::BlockMatrix;

/// Forces [N], three components per node.
pub struct NodalForces(pub Vec<f64>);

impl Energy for NodalForces {
    fn kind(&self) -> (&'static str, Nature) {
        ("nodal forces", Nature::Other)
    }
    fn value(&self, at: &Iterate) -> f64 {
        -self.0.iter().zip(at.u).map(|(f, u)| f * u).sum::<f64>()
    }
    fn add_gradient(&self, _: &Iterate, out: &mut [f64]) {
        out.iter_mut().zip(&self.0).for_each(|(o, f)| *o -= f);
    }
    fn add_hessian(&self, _: &Iterate, _: Hessian, _: &mut BlockMatrix) {}
    fn add_mixed_vjp(&self, _: &Iterate, _: &[f64], _: &mut [f64]) {
        unimplemented!("no shape derivative is asked for")
    }
}
