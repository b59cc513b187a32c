//! Potential of one shape alone: the sum of a density over its close pairs.
//!
//! E(x) = Σ_k m_k β(d_k²)
//! ∂E/∂x = Σ_k m β′ ∂d²/∂x + β (∂m/∂c ∂c/∂x + ∂m/∂ε ∂ε/∂x)
//!
//! d_k   distance of pair k [m]
//! m_k   [`mollifier`](super::mollifier) of parallel edges, one for vertex–triangle
//!       pairs [1]; c and ε are of the same shape, so that both change
//! β     [`density`](super::density) [m⁴]
//!
//! Every pair has the same weight whatever the size of its features, so E grows
//! with the number of facets. The potential of a body in contact, with weights and a
//! rest shape beside the deformed one, is [`potential`](super::potential).
//!
//! Source: Gjoka et al. 2024, equations (14) and (15).

use std::ops::Range;

use mesh::Vec3;

use super::density::Repulsion;
use super::mollifier::{Mollifier, cross, cross_gradient, threshold, threshold_gradient};
use super::pairs::Pair;

/// E [unit of β].
pub fn value(pairs: &[Pair], x: &[Vec3], repulsion: &Repulsion) -> f64 {
    let part = |range: Range<usize>| pairs[range].iter().map(|p| pair_value(p, x, repulsion)).sum();
    let mut total = 0.0;
    crate::parallel::map_merge(pairs.len(), part, |_, part: f64| total += part);
    total
}

/// Adds `weight` ∂E/∂x, three components per vertex. E must be finite.
pub fn add_gradient(
    pairs: &[Pair],
    x: &[Vec3],
    repulsion: &Repulsion,
    weight: f64,
    out: &mut [f64],
) {
    let gradient = |pair: &Pair| pair_gradient(pair, x, repulsion);
    crate::parallel::map_each(pairs, gradient, |pair, gradient| {
        for (v, g) in pair.corners().into_iter().zip(gradient) {
            for k in 0..3 {
                out[3 * v + k] += weight * g[k];
            }
        }
    });
}

fn pair_value(pair: &Pair, x: &[Vec3], repulsion: &Repulsion) -> f64 {
    let corners = pair.gather(x);
    let [beta, ..] = repulsion.at(pair.closest(&corners).d2);
    match pair {
        // also where the edges are parallel: touching is not admissible
        _ if beta.is_infinite() => beta,
        Pair::PointTriangle(_) => beta,
        Pair::EdgeEdge(_) => Mollifier::new(cross(&corners), threshold(&corners)).value * beta,
    }
}

fn pair_gradient(pair: &Pair, x: &[Vec3], repulsion: &Repulsion) -> [Vec3; 4] {
    let corners = pair.gather(x);
    let closest = pair.closest(&corners);
    let [beta, slope, _] = repulsion.at(closest.d2);
    let d2 = closest.d2_gradient();
    match pair {
        Pair::PointTriangle(_) => d2.map(|g| slope * g),
        Pair::EdgeEdge(_) => {
            let m = Mollifier::new(cross(&corners), threshold(&corners));
            // the rest shape is this shape, so that both c and ε change
            let dm = m.by_cross * cross_gradient(&corners)
                + m.by_threshold * threshold_gradient(&corners);
            let dm = |i: usize| dm.fixed_rows::<3>(3 * i).into_owned();
            std::array::from_fn(|i| m.value * slope * d2[i] + beta * dm(i))
        }
    }
}
