//! Contact potential: the sum over all pairs of features that are close, with every
//! derivative. What makes it a barrier or a substitute for it is its density.
//!
//! B(x; X) = s Σ_k w_k m_k β(d_k²)        e_k = m_k β(d_k²)
//!
//! x, X   positions and rest positions of the collision vertices [m]
//! d      distance of a pair: vertex and triangle, or two edges [m]
//! β      [`density`](super::density), e.g. a log barrier [m⁴]
//! m      [`mollifier`](super::mollifier) of parallel edges, whose threshold ε is of
//!        the rest shape [1]
//! w      [weights](super::terms) of pairs, of areas A of the rest shape [m²]; a number
//!        in the plain form
//! s      scale: κ σ of the barrier [J/m⁶]
//!
//! ∂B/∂x        = s Σ_k w ∂e/∂x
//! ∂²B/∂x²      = s Σ_k w ∂²e/∂x²
//! λᵀ ∂²B/∂x∂X  = s Σ_k w (λ · ∂²e/∂x∂ε) ∂ε/∂X + (λ · ∂e/∂x) ∂w/∂X
//!
//! and, where x = X + W u, what X moves along with it: + λᵀ ∂²B/∂x². What one pair adds
//! is in [`stencil`](super::stencil).
//!
//! A potential is evaluated in three steps, each in a fixed order, so that no bit
//! depends on the number of threads:
//!
//! 1. candidate pairs, which may be close ([broad phase](super::candidates));
//! 2. close pairs, those within the range of β;
//! 3. [`Contacts`]: weighted stencils, of which values and derivatives are sums.
//!
//! Sources: Li et al. 2020, "Incremental Potential Contact",
//! doi:10.1145/3386569.3392425; convergent form: Li et al. 2023, arXiv:2307.15908;
//! other densities: Gjoka et al. 2024, equations (13) to (15).

use std::ops::Range;
use std::sync::Arc;

use mesh::Vec3;

use super::barrier::Form;
use super::candidates::{self, TooMany};
use super::density::Repulsion;
use super::distance::corners;
use super::pairs::Pair;
use super::rest_offset::{Close, Offset};
use super::stencil::Local;
use super::surface::Surface;
use super::terms::{Term, Terms};
use super::weights::Adjacency;
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat12, Vec12};
use crate::parallel::{map_each, map_merge};

/// Which features repel each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partners {
    /// All of which one can move, those of one body included, through its solid or not.
    All,
    /// Features of [`Self::All`] that are apart at rest: not through the [solid](super::solid) of
    /// one body, and with a [rest offset](super::rest_offset) within one body.
    ThroughAir,
    /// Features of different bodies.
    OtherBodies,
}

/// The potential of a collision surface.
pub struct Potential {
    surface: Arc<Surface>,
    adjacency: Adjacency,
    /// How pairs are weighted, w.
    form: Form,
    /// β.
    repulsion: Repulsion,
    /// s.
    scale: f64,
    partners: Partners,
}

impl Potential {
    /// The potential s Σ w m β of a surface, with weights of a form and s = `scale`.
    pub fn new(
        surface: Arc<Surface>,
        partners: Partners,
        form: Form,
        repulsion: Repulsion,
        scale: f64,
    ) -> Self {
        let adjacency = Adjacency::new(&surface);
        Self { surface, adjacency, form, repulsion, scale, partners }
    }

    /// The collision surface.
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// Which features repel each other.
    pub fn partners(&self) -> Partners {
        self.partners
    }

    /// β.
    pub fn repulsion(&self) -> &Repulsion {
        &self.repulsion
    }

    /// Candidate pairs: all that come closer than `radius` [m] while collision vertices
    /// move from `x0` to `x1` [m], and some that do not.
    pub fn candidates(&self, x0: &[Vec3], x1: &[Vec3], radius: f64) -> Result<Vec<Pair>, TooMany> {
        let indifferent = |corners: [usize; 4]| match self.partners {
            Partners::All | Partners::ThroughAir => self.surface.immovable(&corners),
            Partners::OtherBodies => {
                let body = self.surface.body(corners[0]);
                corners.iter().all(|&v| self.surface.body(v) == body)
            }
        };
        candidates::between(self.surface.features(), x0, x1, radius, &indifferent)
    }

    /// The candidates within the range of β at positions `x`, in their order, for rest
    /// positions.
    pub fn close_pairs(&self, candidates: &[Pair], x: &[Vec3], rest: &[Vec3]) -> Vec<Close> {
        let range2 = self.repulsion.range().powi(2);
        let close = |pair: &Pair| {
            let closest = pair.closest(&pair.gather(x));
            let one = || Close { pair: *pair, closest, offset: self.offset(pair, rest) };
            (closest.d2 < range2).then(one)
        };
        let near = |range: Range<usize>| -> Vec<Close> {
            candidates[range].iter().filter_map(close).collect()
        };
        let mut close = Vec::new();
        map_merge(candidates.len(), near, |_, mut part| close.append(&mut part));
        close
    }

    /// The rest offset of a pair.
    fn offset(&self, pair: &Pair, rest: &[Vec3]) -> Option<Offset> {
        let own = self.partners == Partners::ThroughAir && self.surface.within_one_body(pair);
        own.then(|| Offset::of(pair, rest, &self.repulsion)).flatten()
    }

    /// What interacts at positions and rest positions of the collision vertices [m],
    /// where these pairs are close.
    pub fn contacts(&self, close: &[Close], x: Vec<Vec3>, rest: Vec<Vec3>) -> Contacts<'_> {
        let acting: Vec<Close> =
            close.iter().filter(|pair| pair.acts(&self.repulsion)).copied().collect();
        let (surface, range) = (&self.surface, self.repulsion.range());
        let terms = Terms::new(surface, &self.adjacency, self.form, &acting, &x, &rest, range);
        Contacts { potential: self, x, rest, terms }
    }
}

/// The potential at one state: weighted stencils with their sums.
pub struct Contacts<'a> {
    potential: &'a Potential,
    /// Positions of the collision vertices [m].
    x: Vec<Vec3>,
    /// Their rest positions [m].
    rest: Vec<Vec3>,
    terms: Terms,
}

impl Contacts<'_> {
    /// Positions of the collision vertices [m].
    pub fn positions(&self) -> &[Vec3] {
        &self.x
    }

    /// The weighted stencils, in a fixed order.
    pub fn terms(&self) -> &[Term] {
        &self.terms.terms
    }

    /// e of one stencil, with its derivatives.
    pub fn local(&self, term: &Term) -> Local {
        let Potential { repulsion, form, .. } = self.potential;
        Local::new(&term.stencil, &self.x, &self.rest, repulsion, *form)
    }

    /// B.
    pub fn value(&self) -> f64 {
        let mut sum = 0.0;
        self.for_each_term(|_, local, weight| weight * local.value(), |_, value| sum += value);
        sum
    }

    /// Calls `f` with the corners of each stencil and what it adds to ∂B/∂x there.
    pub fn for_each_gradient(&self, mut f: impl FnMut([usize; 4], [Vec3; 4])) {
        let gradient = |_: &Term, local: &Local, weight: f64| local.gradient() * weight;
        self.for_each_term(gradient, |term, gradient| {
            f(term.stencil.corners, [0, 1, 2, 3].map(|i| corner(&gradient, i)));
        });
    }

    /// ∂B/∂x.
    pub fn gradient(&self) -> Vec<Vec3> {
        let mut sum = self.zeros();
        self.for_each_gradient(|corners, gradient| add(&mut sum, &corners, gradient));
        sum
    }

    /// Adds Wᵀ ∂²B/∂x² W of the nodes.
    pub fn add_hessian(&self, out: &mut BlockMatrix) {
        self.add_blocks(|local, weight| local.hessian() * weight, out);
    }

    /// Adds Wᵀ ∂²B/∂x² W with the second derivative of each stencil made positive semidefinite.
    pub fn add_projected_hessian(&self, out: &mut BlockMatrix) {
        self.add_blocks(Local::projected_hessian, out);
    }

    /// ∂²B/∂x² λ.
    pub fn hessian_times(&self, lambda: &[Vec3]) -> Vec<Vec3> {
        let image = |term: &Term, local: &Local, weight: f64| {
            local.hessian() * corners(term.stencil.gather(lambda)) * weight
        };
        let mut sum = self.zeros();
        self.for_each_term(image, |term, image| {
            add_vector(&mut sum, &term.stencil.corners, &image);
        });
        sum
    }

    /// λᵀ ∂²B/∂x∂X for x that moves along with X, one to one.
    pub fn shape_vjp(&self, lambda: &[Vec3]) -> Vec<Vec3> {
        let by_shape = |term: &Term, local: &Local, weight: f64| {
            let l = corners(term.stencil.gather(lambda));
            let mut by_corners = local.hessian() * l * weight;
            if let Some((by_threshold, threshold)) = local.by_threshold() {
                by_corners += threshold * (weight * by_threshold.dot(&l));
            }
            let by_offset = local.by_offset().map(|(by_activation, own)| {
                (own.corners, own.by_rest * (weight * by_activation.dot(&l)))
            });
            (by_corners, by_offset, self.potential.scale * local.gradient().dot(&l))
        };
        let (mut by_rest, mut by_area) = (self.zeros(), self.zero_areas());
        self.for_each_term(by_shape, |term, (by_corners, by_offset, by_weight)| {
            add_vector(&mut by_rest, &term.stencil.corners, &by_corners);
            if let Some((corners, by_offset)) = by_offset {
                add_vector(&mut by_rest, &corners, &by_offset);
            }
            self.add_by_area(term, by_weight, &mut by_area);
        });
        self.add_area_gradient(&by_area, &mut by_rest);
        by_rest
    }

    /// s.
    pub(super) fn scale(&self) -> f64 {
        self.potential.scale
    }

    /// Zero at each collision vertex.
    pub(super) fn zeros(&self) -> Vec<Vec3> {
        vec![Vec3::zeros(); self.x.len()]
    }

    /// Zero for each area that weights are made of.
    pub(crate) fn zero_areas(&self) -> Vec<f64> {
        vec![0.0; self.potential.adjacency.area_count()]
    }

    /// Adds `by_weight` ∂w/∂A of a term.
    pub(crate) fn add_by_area(&self, term: &Term, by_weight: f64, by_area: &mut [f64]) {
        self.terms.add_by_area(term, by_weight, by_area);
    }

    /// Adds Σ `by_area` ∂A/∂X.
    pub(super) fn add_area_gradient(&self, by_area: &[f64], by_rest: &mut [Vec3]) {
        self.potential.adjacency.add_gradient(&self.rest, by_area, by_rest);
    }

    /// Adds `block` of each stencil and its weight s w, unless that is zero.
    fn add_blocks(&self, block: impl Fn(&Local, f64) -> Mat12 + Sync, out: &mut BlockMatrix) {
        let block =
            |_: &Term, local: &Local, weight: f64| (weight != 0.0).then(|| block(local, weight));
        self.for_each_term(block, |term, block| {
            if let Some(block) = block {
                self.potential.surface.add_block(&term.stencil.corners, &block, out);
            }
        });
    }

    /// Calls `map` on all terms, with their weight s w, in parallel, and `merge` on the
    /// results in order.
    fn for_each_term<T: Send>(
        &self,
        map: impl Fn(&Term, &Local, f64) -> T + Sync,
        merge: impl FnMut(&Term, T),
    ) {
        let (terms, scale) = (self.terms(), self.potential.scale);
        map_each(terms, |t| map(t, &self.local(t), scale * t.weight), merge);
    }
}

fn corner(vector: &Vec12, i: usize) -> Vec3 {
    vector.fixed_rows::<3>(3 * i).into_owned()
}

/// Adds vectors of four collision vertices to a list over all of them.
pub(super) fn add(list: &mut [Vec3], corners: &[usize; 4], vectors: [Vec3; 4]) {
    corners.iter().zip(vectors).for_each(|(&v, vector)| list[v] += vector);
}

pub(super) fn add_vector(list: &mut [Vec3], corners: &[usize; 4], vector: &Vec12) {
    add(list, corners, [0, 1, 2, 3].map(|i| corner(vector, i)));
}
