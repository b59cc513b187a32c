//! What one pair adds to the contact potential, with derivatives.
//!
//! e = m(c, ε) β(d²)
//! ∂e/∂x  = m β′ ∇d² + β m_c ∇c
//! ∂²e/∂x² = m (β″ ∇d² ∇d²ᵀ + β′ ∇²d²) + m_c β′ (∇d² ∇cᵀ + ∇c ∇d²ᵀ)
//!           + β (m_cc ∇c ∇cᵀ + m_c ∇²c)
//! ∂²e/∂x∂ε = m_ε β′ ∇d² + β m_cε ∇c
//!
//! d   distance [m];   β   its [`density`](super::density) [m⁴]
//! m   [`mollifier`](super::mollifier) of parallel edges [1], of c and ε [m⁴]
//!
//! m is one unless the pair is one of edges that are nearly parallel. Such a pair
//! keeps both edges; any other is reduced to the corners that its closest points
//! lie between, so that neighbouring features that meet there have the same
//! stencil.

use mesh::Vec3;

use super::barrier::Form;
use super::density::Repulsion;
use super::distance::{Closest, Region, corners};
use super::mollifier::{
    Mollifier, cross, cross_gradient, cross_hessian, threshold, threshold_gradient,
};
use super::pairs::Pair;
use super::rest_offset::{Offset, OffsetRepulsion};
use crate::math::tensor::{Mat12, Vec12, project_positive};

/// Points of two features that interact. Equal stencils are equal: corners are
/// in a fixed order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stencil {
    /// Collision vertices; the first again where fewer than four take part.
    pub corners: [usize; 4],
    /// Which corners the closest points lie between.
    pub region: Region,
    /// Whether these are edges so parallel that they are mollified.
    pub mollified: bool,
    /// The pair whose [rest distance](super::rest_offset) is its activation; none where
    /// that is the full one.
    pub offset: Option<Pair>,
}

impl Stencil {
    /// The corners that take part, those of the smaller part first.
    pub fn reduced(corners: [usize; 4], region: Region) -> Self {
        // unused entries stay last when the parts are sorted
        let (mut parts, mut counts) = ([[usize::MAX; 3]; 2], [0; 2]);
        for i in (0..4).filter(|&i| region.active[i]) {
            let part = usize::from(i >= region.first);
            parts[part][counts[part]] = corners[i];
            counts[part] += 1;
        }
        parts.iter_mut().for_each(|part| part.sort_unstable());
        if (counts[1], parts[1]) < (counts[0], parts[0]) {
            parts.swap(0, 1);
            counts.swap(0, 1);
        }
        let [a, b] = counts;
        let mut ordered = [parts[0][0]; 4];
        ordered[..a].copy_from_slice(&parts[0][..a]);
        ordered[a..a + b].copy_from_slice(&parts[1][..b]);
        let region = Region { first: a, active: std::array::from_fn(|i| i < a + b) };
        Self { corners: ordered, region, mollified: false, offset: None }
    }

    /// Two edges that are nearly parallel; their corners must be ordered by
    /// [`ordered_edges`].
    pub fn mollified(corners: [usize; 4], region: Region) -> Self {
        Self { corners, region, mollified: true, offset: None }
    }

    /// This stencil with the activation of a pair's rest distance.
    pub fn with_offset(self, offset: Option<Offset>) -> Self {
        Self { offset: offset.map(|o| o.pair), ..self }
    }

    /// The corners' entries of a list over all collision vertices.
    pub fn gather(&self, x: &[Vec3]) -> [Vec3; 4] {
        self.corners.map(|v| x[v])
    }
}

/// The corners of two edges in the order of a mollified stencil.
pub fn ordered_edges(mut a: [usize; 2], mut b: [usize; 2]) -> [usize; 4] {
    a.sort_unstable();
    b.sort_unstable();
    let (a, b) = if b < a { (b, a) } else { (a, b) };
    [a[0], a[1], b[0], b[1]]
}

/// A stencil at positions of its corners.
pub struct Local {
    region: Region,
    x: [Vec3; 4],
    rest: Option<[Vec3; 4]>,
    /// Closest points.
    pub closest: Closest,
    mollifier: Mollifier,
    /// β and its first two derivatives by d².
    beta: [f64; 3],
    offset: Option<OffsetRepulsion>,
}

impl Local {
    /// The stencil at positions and rest positions of all collision vertices.
    pub fn new(
        stencil: &Stencil,
        x: &[Vec3],
        rest: &[Vec3],
        repulsion: &Repulsion,
        form: Form,
    ) -> Self {
        let (x, region) = (stencil.gather(x), stencil.region);
        let own = |pair| OffsetRepulsion::new(pair, rest, repulsion, form);
        let offset = stencil.offset.as_ref().map(own);
        let rest = stencil.mollified.then(|| stencil.gather(rest));
        let mollifier = |rest: &_| Mollifier::new(cross(&x), threshold(rest));
        let mollifier = rest.as_ref().map_or(Mollifier::ONE, mollifier);
        let closest = region.closest(&x);
        let beta = offset.as_ref().map_or_else(|| repulsion.at(closest.d2), |o| o.at(closest.d2));
        Self { region, x, rest, closest, mollifier, beta, offset }
    }

    /// e [m⁴].
    pub fn value(&self) -> f64 {
        self.mollifier.value * self.beta[0]
    }

    /// ∂e/∂x [m³].
    pub fn gradient(&self) -> Vec12 {
        let distance = corners(self.closest.d2_gradient()) * (self.mollifier.value * self.beta[1]);
        match self.rest {
            None => distance,
            Some(_) => {
                distance + cross_gradient(&self.x) * (self.beta[0] * self.mollifier.by_cross)
            }
        }
    }

    /// ∂²e/∂x² [m²].
    pub fn hessian(&self) -> Mat12 {
        let [beta, slope, curvature] = self.beta;
        let m = &self.mollifier;
        let by_d2 = corners(self.closest.d2_gradient());
        let mut hessian = self.region.d2_hessian(&self.x, &self.closest) * (m.value * slope);
        hessian += by_d2 * (by_d2 * (m.value * curvature)).transpose();
        if self.rest.is_some() {
            let by_cross = cross_gradient(&self.x);
            let mixed = by_d2 * (by_cross * (m.by_cross * slope)).transpose();
            hessian += mixed + mixed.transpose();
            hessian += by_cross * (by_cross * (beta * m.by_cross_twice)).transpose();
            hessian += cross_hessian(&self.x) * (beta * m.by_cross);
        }
        hessian
    }

    /// `weight` ∂²e/∂x² with its negative eigenvalues set to zero.
    ///
    /// Unless edges are mollified, the Hessian maps into the few directions c ⊗ a and
    /// eₖ ⊗ r of [`distance`](super::distance), a any vector, so that a matrix of
    /// their number is decomposed.
    pub fn projected_hessian(&self, weight: f64) -> Mat12 {
        let hessian = self.hessian() * weight;
        if self.rest.is_some() {
            return project_positive(&hessian);
        }
        let basis = self.region.range(&self.closest);
        let inner = basis.transpose() * hessian * basis;
        basis * project_positive(&inner) * basis.transpose()
    }

    /// Normal force per weight for a scale s of the potential, N = −2 s β′ d, and ∂N/∂d².
    pub fn normal_force(&self, scale: f64) -> [f64; 2] {
        let ([_, slope, curvature], d) = (self.beta, self.closest.d2.sqrt());
        [-2.0 * scale * slope * d, -scale * (2.0 * curvature * d + slope / d)]
    }

    /// ∂N/∂a and how a follows the rest shape, for an activation of its own.
    pub fn normal_force_by_offset(&self, scale: f64) -> Option<(f64, &OffsetRepulsion)> {
        let offset = self.offset.as_ref()?;
        let slope = offset.by_activation(self.closest.d2)[1];
        Some((-2.0 * scale * slope * self.closest.d2.sqrt(), offset))
    }

    /// ∂²e/∂x∂a [m²] and how a follows the rest shape, for an activation of its own.
    pub fn by_offset(&self) -> Option<(Vec12, &OffsetRepulsion)> {
        let offset = self.offset.as_ref()?;
        let [beta, slope] = offset.by_activation(self.closest.d2);
        let mut by = corners(self.closest.d2_gradient()) * (self.mollifier.value * slope);
        if self.rest.is_some() {
            by += cross_gradient(&self.x) * (beta * self.mollifier.by_cross);
        }
        Some((by, offset))
    }

    /// ∂²e/∂x∂ε [1/m] and ∂ε/∂X [m³] of a mollified pair.
    pub fn by_threshold(&self) -> Option<(Vec12, Vec12)> {
        let rest = self.rest.as_ref()?;
        let [beta, slope, _] = self.beta;
        let by_d2 = corners(self.closest.d2_gradient());
        let by = by_d2 * (self.mollifier.by_threshold * slope)
            + cross_gradient(&self.x) * (beta * self.mollifier.by_both);
        Some((by, threshold_gradient(rest)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::density::Density;
    use crate::contact::distance::{edge_edge, point_triangle};
    use crate::math::random::Random;

    #[test]
    fn a_stencil_does_not_depend_on_how_its_features_are_listed() {
        let region = |first, active| Region { first, active };
        let corner = Stencil::reduced([7, 3, 5, 9], region(1, [true, false, true, false]));
        assert_eq!(corner, Stencil::reduced([9, 5, 7, 3], region(2, [false, true, true, false])));
        let edge = Stencil::reduced([7, 9, 3, 5], region(1, [true, true, false, true]));
        assert_eq!(edge, Stencil::reduced([5, 9, 4, 7], region(2, [true, true, false, true])));
        assert_eq!((edge.corners, edge.region.first), ([7, 5, 9, 7], 1));
        assert_eq!(ordered_edges([8, 2], [1, 4]), ordered_edges([4, 1], [2, 8]));
    }

    /// The small decomposition against one of all twelve components, for all
    /// kinds of closest points and both signs of the weight.
    #[test]
    fn the_projected_hessian_is_that_of_all_components() {
        let mut random = Random::new(6);
        let repulsion = Repulsion { density: Density::Log, minimum: 0.1, activation: 1.5 };
        let mut seen = std::collections::BTreeSet::new();
        for k in 0..400 {
            let x: Vec<Vec3> = (0..4).map(|_| random.vector()).collect();
            let corners = [x[0], x[1], x[2], x[3]];
            let (first, closest) =
                if k % 2 == 0 { (1, point_triangle(&corners)) } else { (2, edge_edge(&corners)) };
            if closest.d2 < 0.02 {
                continue;
            }
            let stencil = Stencil::reduced([0, 1, 2, 3], Region::of(first, &closest));
            seen.insert(stencil.region);
            let local = Local::new(&stencil, &x, &x, &repulsion, Form::Plain);
            for weight in [2.0, -3.0] {
                let hessian = local.hessian() * weight;
                let error = local.projected_hessian(weight) - project_positive(&hessian);
                assert!(error.norm() <= 1e-10 * hessian.norm(), "{:e}", error.norm());
            }
        }
        assert_eq!(seen.len(), 4, "{seen:?}");
    }
}
