//! Barrier between surfaces that must not touch.
//!
//! E(u; X) = κ σ Σ_k w_k m_k b(d_k²)      x_c = W (ΠX + u)
//!
//! w   weights of [`terms`](crate::contact::terms), of the rest shape
//! m   mollifier of parallel edges, whose threshold ε is of the rest shape
//! b   log barrier of the distance d of a pair; σ as in
//!     [`Barrier::scale`]
//!
//! E is +∞ where a pair is not farther apart than d₀, or where more pairs are in
//! range than memory is meant for. With e = m b and λ on the
//! collision vertices, the mixed derivative acts on X_c as
//!
//! λᵀ ∂²E/∂x∂X_c = κ σ Σ_k w λᵀ ∂²e/∂x² + w (λ · ∂²e/∂x∂ε) ∂ε/∂X_c
//!                          + (λ · ∂e/∂x) ∂w/∂X_c
//!
//! and from there through Wᵀ and Πᵀ.
//!
//! Sources: Li et al. 2020, doi:10.1145/3386569.3392425; Li et al. 2023,
//! arXiv:2307.15908.

use std::ops::Range;
use std::sync::{Arc, Mutex, PoisonError};

use mesh::Vec3;

use super::{Energy, Hessian, Iterate};
use crate::contact::barrier::Barrier;
use crate::contact::candidates::{self, TooMany};
use crate::contact::ccd;
use crate::contact::certificate::{Intersection, certify};
use crate::contact::distance::Closest;
use crate::contact::friction::{LaggedContact, LaggedContactCotangent};
use crate::contact::pairs::Pair;
use crate::contact::stencil::Local;
use crate::contact::surface::{BodyForce, Surface};
use crate::contact::terms::{Term, Terms};
use crate::contact::weights::Adjacency;
use crate::math::sparse::BlockMatrix;
use crate::math::tensor::{Mat12, Vec12};
use crate::parallel::map_merge;

/// How far vertices may move before the list of close pairs is made anew, in
/// mean edge lengths. A longer way makes lists longer and rarer; results are the
/// same.
const SLACK: f64 = 0.1;

/// Share of a step below which it is given up.
const SHORTEST: f64 = 1e-10;

/// The barrier between all parts of a collision surface.
pub struct Contact {
    surface: Arc<Surface>,
    adjacency: Adjacency,
    barrier: Barrier,
    list: Mutex<Option<Arc<List>>>,
    /// Whether to prove of accepted states that they have no intersection.
    certify: bool,
}

/// Pairs that may be close as long as no vertex is farther than `slack` from
/// where it was.
struct List {
    x: Vec<Vec3>,
    slack: f64,
    pairs: Vec<Pair>,
}

impl List {
    fn holds(&self, x: &[Vec3]) -> bool {
        let near = |(a, b): (&Vec3, &Vec3)| (a - b).norm_squared() <= self.slack * self.slack;
        self.x.iter().zip(x).all(near)
    }
}

/// How close the surfaces are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closeness {
    /// Number of pairs within the barrier's range.
    pub pairs: usize,
    /// Smallest (d − d₀) / d̂; infinite without pairs.
    pub smallest: f64,
}

/// Positions of the collision vertices and what interacts there.
struct State {
    x: Vec<Vec3>,
    rest: Vec<Vec3>,
    terms: Terms,
}

impl State {
    /// The terms that rub in a step that begins here. Pairs of nearly parallel
    /// edges do not: their closest points jump.
    fn rubbing(&self) -> impl Iterator<Item = &Term> {
        self.terms.terms.iter().filter(|t| !t.stencil.faded && t.weight != 0.0)
    }
}

impl Contact {
    /// The barrier between all features of a surface.
    #[must_use]
    pub fn new(surface: Arc<Surface>, barrier: Barrier) -> Self {
        let adjacency = Adjacency::new(&surface);
        Self { surface, adjacency, barrier, list: Mutex::new(None), certify: false }
    }

    /// The same, and of accepted states it is proved that they have no
    /// intersection.
    #[must_use]
    pub fn certified(self) -> Self {
        Self { certify: true, ..self }
    }

    /// What intersects at positions of the collision vertices [m], if anything.
    #[must_use]
    pub fn intersection(&self, x: &[Vec3]) -> Option<Intersection> {
        let movable = |vertex: usize| !self.surface.immovable(&[vertex]);
        certify(&self.surface.features().triangles, x, movable).err()
    }

    /// The collision surface.
    #[must_use]
    pub fn surface(&self) -> &Arc<Surface> {
        &self.surface
    }

    /// Force on each collision vertex [N].
    #[must_use]
    pub fn forces(&self, at: &Iterate) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); self.surface.vertex_count()];
        self.for_each_force(at, |corners, force| {
            corners.iter().zip(force).for_each(|(&v, f)| forces[v] += f);
        });
        forces
    }

    /// Force between each two bodies that touch.
    #[must_use]
    pub fn body_forces(&self, at: &Iterate) -> Vec<BodyForce> {
        let mut forces = Vec::new();
        self.for_each_force(at, |corners, force| forces.push((corners, force)));
        self.surface.body_forces(&forces)
    }

    /// How close the surfaces are.
    #[must_use]
    pub fn closeness(&self, at: &Iterate) -> Closeness {
        let active = self.active(&self.positions(at)).unwrap_or_default();
        let gap = |d2: f64| (d2.sqrt() - self.barrier.thickness) / self.barrier.activation;
        let gaps = active.iter().map(|(_, closest)| gap(closest.d2));
        Closeness { pairs: active.len(), smallest: gaps.fold(f64::INFINITY, f64::min) }
    }

    /// The closest of the pairs within range at positions of the collision
    /// vertices, and its distance [m].
    #[must_use]
    pub fn closest(&self, x: &[Vec3]) -> Option<(Pair, f64)> {
        let active = self.active(x)?.into_iter();
        let closest = active.min_by(|a, b| a.1.d2.total_cmp(&b.1.d2))?;
        Some((closest.0, closest.1.d2.sqrt()))
    }

    fn positions(&self, at: &Iterate) -> Vec<Vec3> {
        self.surface.positions(at.space, at.rest, at.u, at.load)
    }

    /// All pairs within range, in a fixed order; none if there are more than
    /// memory is meant for.
    fn active(&self, x: &[Vec3]) -> Option<Vec<(Pair, Closest)>> {
        let list = self.list(x)?;
        let range2 = self.barrier.range().powi(2);
        let near = |range: Range<usize>| -> Vec<(Pair, Closest)> {
            let closest = list.pairs[range].iter().map(|p| (*p, p.closest(&p.gather(x))));
            closest.filter(|(_, closest)| closest.d2 < range2).collect()
        };
        let mut active = Vec::new();
        map_merge(list.pairs.len(), near, |_, mut part| active.append(&mut part));
        Some(active)
    }

    /// The list of pairs that is there, if it holds at all these positions.
    fn kept_for(&self, positions: &[&[Vec3]]) -> Option<Arc<List>> {
        let kept = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        kept.as_ref().filter(|list| positions.iter().all(|x| list.holds(x))).map(Arc::clone)
    }

    /// Pairs that may be within range at positions `x`.
    fn list(&self, x: &[Vec3]) -> Option<Arc<List>> {
        if let Some(list) = self.kept_for(&[x]) {
            return Some(list);
        }
        let slack = SLACK * mesh::measure::mean_edge(x, &self.surface.features().triangles);
        let make = |slack: f64| {
            let pairs = self.pairs(x, self.barrier.range() + 2.0 * slack).ok()?;
            Some(Arc::new(List { x: x.to_vec(), slack, pairs }))
        };
        let mut kept = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        *kept = make(slack).or_else(|| make(0.0));
        kept.clone()
    }

    /// All pairs closer than a radius of which something can move.
    fn pairs(&self, x: &[Vec3], radius: f64) -> Result<Vec<Pair>, TooMany> {
        let skip = |corners: [usize; 4]| self.surface.immovable(&corners);
        candidates::between(self.surface.features(), x, x, radius, skip)
    }

    fn state(&self, at: &Iterate) -> State {
        let (x, rest) = (self.positions(at), self.surface.rest(at.space, at.rest));
        let terms = self.terms(&self.active(&x).unwrap_or_default(), (&x, &rest));
        State { x, rest, terms }
    }

    fn terms(&self, active: &[(Pair, Closest)], positions: (&[Vec3], &[Vec3])) -> Terms {
        let on = (&*self.surface, &self.adjacency);
        Terms::new(on, self.barrier.form, active, positions, self.barrier.range())
    }

    fn local(&self, state: &State, term: &Term) -> Local {
        Local::new(&term.stencil, &state.x, &state.rest, &self.barrier)
    }

    /// Calls `map` on all terms in parallel, and `merge` on their results in
    /// order.
    fn for_each_term<T: Send>(
        &self,
        state: &State,
        map: impl Fn(&Local, f64) -> T + Sync,
        mut merge: impl FnMut(&Term, T),
    ) {
        let (terms, scale) = (&state.terms.terms, self.barrier.scale());
        let part = |range: Range<usize>| -> Vec<T> {
            let local = |t: &Term| map(&self.local(state, t), scale * t.weight);
            terms[range].iter().map(local).collect()
        };
        map_merge(terms.len(), part, |range, part| {
            terms[range].iter().zip(part).for_each(|(term, value)| merge(term, value));
        });
    }

    /// Normal force per weight at a squared distance, and its slope.
    fn normal_force(&self, d2: f64) -> [f64; 2] {
        let [_, slope, curvature] = self.barrier.at(d2);
        let (scale, d) = (self.barrier.scale(), d2.sqrt());
        [-2.0 * scale * slope * d, -scale * (2.0 * curvature * d + slope / d)]
    }

    /// Cotangents of nodes and rest vertices from those of the collision vertices'
    /// positions, rest positions (which W and Π make of rest vertices) and areas.
    fn add_to_rest(
        &self,
        at: &Iterate,
        (state, mut by_rest, by_area): (&State, Vec<Vec3>, &[f64]),
        out: &mut [f64],
    ) {
        self.adjacency.add_gradient(&state.rest, by_area, &mut by_rest);
        let mut nodal = vec![0.0; at.u.len()];
        self.surface.add_to_nodes(&by_rest, &mut nodal);
        at.space.add_to_vertices(&nodal, out);
    }

    fn for_each_force(&self, at: &Iterate, mut f: impl FnMut([usize; 4], [Vec3; 4])) {
        let gradient = |local: &Local, weight: f64| local.gradient() * weight;
        self.for_each_term(&self.state(at), gradient, |term, gradient| {
            f(term.stencil.corners, [0, 1, 2, 3].map(|i| -corner(&gradient, i)));
        });
    }
}

fn corner(vector: &Vec12, i: usize) -> Vec3 {
    vector.fixed_rows::<3>(3 * i).into_owned()
}

/// Adds a second derivative by four collision vertices to the nodes they depend
/// on.
pub(super) fn add_block(
    surface: &Surface,
    corners: &[usize; 4],
    block: &Mat12,
    out: &mut BlockMatrix,
) {
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate() {
            let block = block.fixed_view::<3, 3>(3 * i, 3 * j);
            if block.iter().all(|v| *v == 0.0) {
                continue;
            }
            for &(row, by_row) in surface.row(a) {
                for &(column, by_column) in surface.row(b) {
                    out.add_lower(row, column, &(block * (by_row * by_column)));
                }
            }
        }
    }
}

impl Energy for Contact {
    fn name(&self) -> &'static str {
        "contact"
    }

    fn value(&self, at: &Iterate) -> f64 {
        let x = self.positions(at);
        let Some(active) = self.active(&x) else { return f64::INFINITY };
        let touching = self.barrier.thickness.powi(2);
        if active.iter().any(|(_, closest)| closest.d2 <= touching) {
            return f64::INFINITY;
        }
        let rest = self.surface.rest(at.space, at.rest);
        let terms = self.terms(&active, (&x, &rest));
        let mut sum = 0.0;
        let value = |local: &Local, weight: f64| weight * local.value();
        self.for_each_term(&State { x, rest, terms }, value, |_, value| sum += value);
        sum
    }

    fn add_gradient(&self, at: &Iterate, out: &mut [f64]) {
        let pull: Vec<Vec3> = self.forces(at).iter().map(|f| -f).collect();
        self.surface.add_to_nodes(&pull, out);
    }

    fn add_hessian(&self, at: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
        let hessian = |local: &Local, weight: f64| {
            if weight == 0.0 {
                return None;
            }
            Some(match kind {
                Hessian::Exact => local.hessian() * weight,
                Hessian::Projected => local.projected_hessian(weight),
            })
        };
        self.for_each_term(&self.state(at), hessian, |term, hessian| {
            if let Some(hessian) = hessian {
                add_block(&self.surface, &term.stencil.corners, &hessian, out);
            }
        });
    }

    fn couplings(&self, at: &Iterate, reach: f64) -> Vec<[usize; 2]> {
        let x = self.positions(at);
        let pairs: Vec<Pair> = if reach <= 1.0 {
            self.active(&x).unwrap_or_default().into_iter().map(|(pair, _)| pair).collect()
        } else {
            self.pairs(&x, reach * self.barrier.range()).unwrap_or_default()
        };
        let corners: Vec<_> = pairs.iter().map(Pair::corners).collect();
        self.surface.couplings(&corners)
    }

    fn max_step(&self, from: &Iterate, to: &Iterate) -> f64 {
        let (start, whole) = (self.positions(from), self.positions(to));
        let (thickness, features) = (self.barrier.thickness, self.surface.features());
        if let Some(list) = self.kept_for(&[&start, &whole]) {
            return ccd::max_step(&list.pairs, &start, &whole, thickness);
        }
        let skip = |corners: [usize; 4]| self.surface.immovable(&corners);
        let mut share = 1.0;
        // a step that sweeps through too much is looked at in part
        while share > SHORTEST {
            let along = |(a, b): (&Vec3, &Vec3)| a + share * (b - a);
            let end: Vec<Vec3> = start.iter().zip(&whole).map(along).collect();
            if let Ok(pairs) = candidates::between(features, &start, &end, thickness, skip) {
                return share * ccd::max_step(&pairs, &start, &end, thickness);
            }
            share *= 0.5;
        }
        0.0
    }

    fn objection(&self, at: &Iterate) -> Option<String> {
        let found = self.certify.then(|| self.intersection(&self.positions(at))).flatten();
        found.map(|intersection| intersection.to_string())
    }

    fn lagged_contacts(&self, at: &Iterate) -> Vec<LaggedContact> {
        let state = self.state(at);
        let one = |term: &Term| {
            let closest = self.local(&state, term).closest;
            let force = term.weight * self.normal_force(closest.d2)[0];
            let corners = term.stencil.corners;
            LaggedContact::new(corners, closest.coefficients, closest.offset, force)
        };
        state.rubbing().map(one).collect()
    }

    fn add_mixed_vjp(&self, at: &Iterate, lambda: &[f64], out: &mut [f64]) {
        let state = self.state(at);
        let lambda = self.surface.trace(lambda);
        let scale = self.barrier.scale();
        let mut by_rest = vec![Vec3::zeros(); state.x.len()];
        let mut by_area = self.adjacency.areas(&state.rest);
        by_area.fill(0.0);
        for term in &state.terms.terms {
            let local = self.local(&state, term);
            let l = crate::contact::distance::corners(term.stencil.gather(&lambda));
            let mut by_corners = local.hessian() * l * (scale * term.weight);
            if let Some((by_threshold, threshold)) = local.by_threshold() {
                by_corners += threshold * (scale * term.weight * by_threshold.dot(&l));
            }
            for (i, &v) in term.stencil.corners.iter().enumerate() {
                by_rest[v] += corner(&by_corners, i);
            }
            let by_weight = scale * local.gradient().dot(&l);
            state.terms.add_by_area(term, by_weight, &mut by_area);
        }
        self.add_to_rest(at, (&state, by_rest, &by_area), out);
    }

    fn add_lagged_contacts_vjp(
        &self,
        at: &Iterate,
        cotangents: &[LaggedContactCotangent],
        by_u: &mut [f64],
        by_rest: &mut [f64],
    ) {
        let state = self.state(at);
        let mut by_x = vec![Vec3::zeros(); state.x.len()];
        let mut by_area = vec![0.0; self.adjacency.areas(&state.rest).len()];
        for (term, by) in state.rubbing().zip(cotangents) {
            let closest = self.local(&state, term).closest;
            let [force, force_slope] = self.normal_force(closest.d2);
            let normal = closest.offset.normalize();
            let turned = (by.normal - normal * normal.dot(&by.normal)) / closest.d2.sqrt();
            let by_offset = turned + closest.offset * (2.0 * by.force * term.weight * force_slope);
            let corners = term.stencil.gather(&state.x);
            let by_closest = (&by.coefficients, &by_offset);
            let pull = term.stencil.region.closest_vjp(&corners, &closest, by_closest);
            for (&v, p) in term.stencil.corners.iter().zip(pull) {
                by_x[v] += p;
            }
            state.terms.add_by_area(term, by.force * force, &mut by_area);
        }
        self.surface.add_to_nodes(&by_x, by_u);
        self.add_to_rest(at, (&state, by_x, &by_area), by_rest);
    }
}

#[cfg(test)]
mod tests;
