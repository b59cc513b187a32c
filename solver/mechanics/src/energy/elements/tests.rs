//! What energies of elements are tested with.

use super::*;
use crate::math::lanes::Scalar;

/// An energy, its gradients and its Hessians have the same bits for any number of lanes, in elements of degree 2. Returns
/// the blocks of the exact and of the projected Hessian.
pub fn check_lanes<E: ElementEnergy>(energy: &E, iterate: &Iterate) -> [Vec<[f64; 9]>; 2] {
    let elements = energy.range(iterate.space);
    let of = || Part { energy, iterate, elements: elements.clone() };
    let alone = Value::<E, 10>(of()).with_simd(Scalar);
    assert_eq!(alone.to_bits(), widest(Value::<E, 10>(of())).to_bits());
    let gradients = |run: fn(Gradients<E, 10>)| {
        let mut out = vec![Vec3::zeros(); 10 * elements.len()];
        run(Gradients { of: of(), out: &mut out });
        out
    };
    assert_eq!(gradients(|work| work.with_simd(Scalar)), gradients(|work| widest(work)));
    [Hessian::Exact, Hessian::Projected].map(|kind| {
        let hessians = |run: fn(Hessians<E, 10>)| {
            let mut blocks = vec![[0.0; 9]; pair_count(10) * elements.len()];
            run(Hessians { of: of(), kind, blocks: &mut blocks });
            blocks
        };
        let alone = hessians(|work| work.with_simd(Scalar));
        assert_eq!(alone, hessians(|work| widest(work)));
        alone
    })
}
