//! Elements side by side, one in each lane: their energies, forces and Hessians.

#![allow(clippy::needless_range_loop, reason = "components of tensors have indices")]

use std::ops::Range;

use pulp::Simd;

use super::Elastic;
use super::mean::{Mean, add_dyad};
use super::moments::Moments;
use crate::element::FunctionSpace;
use crate::energy::elements::{Batch, Blocks, ElementEnergy, Forces, Nodal, QUADRATIC, points};
use crate::energy::{Hessian, Iterate};
use crate::material::{Kinematics, Material, Points};
use crate::math::lanes::projection::{self, Tangents, smallest_pivots};
use crate::math::lanes::tensor::{Tensor, lane, plus_identity, scaled};
use crate::math::lanes::{Lanes, MOST};
use crate::math::sparse::{pair_count, pair_index};
use crate::math::tensor::{Mat3, Mat9, project_isotropic};
use mesh::Vec3;

/// ψ of each lane [J/m³].
#[inline(always)]
fn energy_densities<S: Simd>(simd: S, law: &dyn Material, grad_u: &Tensor<S>) -> [f64; MOST] {
    if let Some(law) = law.decoupled() {
        return Points::new(simd, grad_u).energy_densities(law);
    }
    if let Some(law) = law.neo_hookean() {
        return law.energy_densities(&Points::new(simd, grad_u));
    }
    let mut values = [0.0; MOST];
    for (l, value) in values.iter_mut().enumerate().take(Lanes::<S>::COUNT) {
        *value = law.energy_density(&Kinematics::new(&lane(grad_u, l)));
    }
    values
}

/// P [Pa].
#[inline(always)]
fn first_piola<S: Simd>(simd: S, law: &dyn Material, grad_u: &Tensor<S>) -> Tensor<S> {
    if let Some(law) = law.decoupled() {
        let points = Points::new(simd, grad_u);
        return points.first_piola(&points.partials(law));
    }
    if let Some(law) = law.neo_hookean() {
        return law.stresses(&Points::new(simd, grad_u));
    }
    let mut values = [[[0.0; MOST]; 3]; 3];
    for l in 0..Lanes::<S>::COUNT {
        let stress = law.first_piola(&Kinematics::new(&lane(grad_u, l)));
        for i in 0..3 {
            for j in 0..3 {
                values[i][j][l] = stress[(i, j)];
            }
        }
    }
    let mut stress = *grad_u;
    for i in 0..3 {
        for j in 0..3 {
            stress[i][j] = Lanes::load(simd, &values[i][j]);
        }
    }
    stress
}

/// ∂P/∂F [Pa], with the pressure that was foreseen at another ∇u if there is one.
#[inline(always)]
fn tangents<S: Simd>(
    simd: S,
    law: &dyn Material,
    grad_u: &Tensor<S>,
    before: Option<&Tensor<S>>,
) -> Tangents<S> {
    if let Some(law) = law.decoupled() {
        let points = Points::new(simd, grad_u);
        let here = points.partials(law);
        return points.tangent(&match before {
            Some(before) => points.foreseen(here, law, before),
            None => here,
        });
    }
    if let Some(law) = law.neo_hookean() {
        return law.tangents(&Points::new(simd, grad_u), before);
    }
    let mut tangents = [[Lanes::splat(simd, 0.0); 9]; 9];
    for l in 0..Lanes::<S>::COUNT {
        let tangent = law.tangent(&Kinematics::new(&lane(grad_u, l)));
        set_lane(simd, &mut tangents, l, &tangent);
    }
    tangents
}

/// Writes the lower triangle of one lane.
#[inline(always)]
fn set_lane<S: Simd>(simd: S, tangents: &mut Tangents<S>, lane: usize, tangent: &Mat9) {
    for i in 0..9 {
        for j in 0..=i {
            let mut values = tangents[i][j].to_array();
            values[lane] = tangent[(i, j)];
            tangents[i][j] = Lanes::load(simd, &values);
        }
    }
}

/// Makes tangents of a law positive semidefinite where they are not.
#[inline(always)]
fn project<S: Simd>(simd: S, law: &dyn Material, tangents: &mut Tangents<S>, grad_u: &Tensor<S>) {
    let pivots = smallest_pivots(tangents);
    let each = pivots.to_array();
    let mut lanes =
        (0..Lanes::<S>::COUNT).filter(|&l| each[l] <= 0.0 || each[l].is_nan()).peekable();
    if lanes.peek().is_none() {
        return;
    }
    if law.decoupled().is_some() || law.neo_hookean().is_some() {
        let f = plus_identity(grad_u, Lanes::splat(simd, 1.0));
        return projection::project_isotropic(tangents, &f, pivots);
    }
    for l in lanes {
        let whole = Mat9::from_fn(|i, j| tangents[i.max(j)][i.min(j)].to_array()[l]);
        let f = Mat3::identity() + lane(grad_u, l);
        set_lane(simd, tangents, l, &project_isotropic(&whole, &f));
    }
}

/// What is used again from batch to batch.
pub(in crate::energy) struct Memory<S: Simd, const N: usize> {
    /// Blocks of elements that are not of degree 2.
    local: Vec<[Lanes<S>; 9]>,
    /// Moments of elements that are of degree 2.
    moments: Moments<S>,
    /// Sums over quadrature points of the derivatives of the mean dilatations.
    by_volume: Vec<Forces<S, N>>,
    /// Derivatives of the mean dilatations by the nodes.
    changes: Vec<Nodal<S, N>>,
}

impl<S: Simd, const N: usize> Default for Memory<S, N> {
    fn default() -> Self {
        Self {
            local: Vec::new(),
            moments: Moments::default(),
            by_volume: Vec::new(),
            changes: Vec::new(),
        }
    }
}

impl ElementEnergy for Elastic {
    const NAME: &'static str = "elastic";

    type Memory<S: Simd, const N: usize> = Memory<S, N>;

    fn range(&self, space: &FunctionSpace) -> Range<usize> {
        self.elements(space)
    }

    #[inline(always)]
    fn energies<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> [f64; MOST] {
        let (law, split) = self.parts(batch.iterate.space);
        let volume = batch.volume.to_array();
        let mut values = [0.0; MOST];
        for (q, weight) in points::<N>(batch.iterate) {
            let grad_u = batch.grad_u(q, &batch.gradients(q));
            let densities = energy_densities(batch.simd, law, &grad_u);
            for l in 0..Lanes::<S>::COUNT {
                values[l] += weight * volume[l] * densities[l];
            }
        }
        if let Some(split) = split {
            let of_volume = Mean::new(batch, split).values;
            for l in 0..Lanes::<S>::COUNT {
                values[l] += volume[l] * of_volume[l];
            }
        }
        values
    }

    #[inline(always)]
    fn forces<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> Nodal<S, N> {
        let (law, split) = self.parts(batch.iterate.space);
        let mean = split.map(|split| Mean::new(batch, split));
        let mut forces = Forces::none(batch);
        for (q, weight) in points::<N>(batch.iterate) {
            let g = batch.gradients(q);
            let grad_u = batch.grad_u(q, &g);
            let mut stress = first_piola(batch.simd, law, &grad_u);
            if let Some(mean) = &mean {
                mean.add_stress(q, &grad_u, &mut stress);
            }
            forces.add(batch, q, &g, &scaled(&stress, batch.volume * weight));
        }
        forces.of_nodes(batch)
    }

    #[inline(always)]
    fn write_blocks<S: Simd, const N: usize>(
        &self,
        batch: &Batch<S, N>,
        kind: Hessian,
        memory: &mut Memory<S, N>,
        out: &mut Blocks,
    ) {
        let (simd, zero) = (batch.simd, batch.splat(0.0));
        let (law, split) = self.parts(batch.iterate.space);
        let Memory { local, moments, by_volume, changes } = memory;
        if N == QUADRATIC {
            moments.reserve(batch.iterate.space.volume_table(), zero);
        } else {
            local.resize(pair_count(N), [zero; 9]);
            local.fill([zero; 9]);
        }
        let before = batch.iterate.foreseen_from();
        let before = before.as_ref().map(|at| Batch::<S, N>::new(simd, at, batch.elements.clone()));
        let mean = split.map(|split| match &before {
            Some(before) => Mean::new(batch, split).foreseen(batch, before, split),
            None => Mean::new(batch, split),
        });
        let means = mean.as_ref().map_or(0, Mean::count);
        by_volume.clear();
        by_volume.resize(means, Forces::none(batch));
        for (q, weight) in points::<N>(batch.iterate) {
            let g = batch.gradients(q);
            let grad_u = batch.grad_u(q, &g);
            let from = before.as_ref().map(|before| before.grad_u(q, &g));
            let mut tangents = tangents(simd, law, &grad_u, from.as_ref());
            if let Some(mean) = &mean {
                mean.add_tangent(q, &grad_u, &mut tangents);
                for (c, sum) in by_volume.iter_mut().enumerate() {
                    sum.add(batch, q, &g, &mean.volume_change(c, q, &grad_u, weight));
                }
            }
            if kind == Hessian::Projected {
                project(simd, law, &mut tangents, &grad_u);
            }
            if N == QUADRATIC {
                moments.set(q, &tangents, &batch.to_rest);
            } else {
                add_point::<S, N>(&tangents, &g, batch.volume * weight, local);
            }
        }
        if N == QUADRATIC {
            moments.integrate(batch);
        }
        changes.clear();
        for sum in by_volume.iter() {
            changes.push(sum.of_nodes(batch));
        }
        for a in 0..N {
            for b in 0..=a {
                let pair = pair_index(a, b);
                let mut block = if N == QUADRATIC { moments.block(a, b) } else { local[pair] };
                if let Some(mean) = &mean {
                    for (c, change) in changes.iter().enumerate() {
                        let stiffness = mean.stiffness(c, kind) * batch.volume;
                        add_dyad(&change[a], &change[b], stiffness, &mut block);
                    }
                }
                out.write(pair, &block);
            }
        }
    }

    fn mixed_vjp(&self, at: &Iterate, lambda: &[f64], element: usize) -> [Vec3; 4] {
        self.element_mixed(at, lambda, element)
    }

    fn parameter_count(&self) -> usize {
        self.material.parameter_count()
    }

    fn parameters_vjp(&self, at: &Iterate, lambda: &[f64], elements: Range<usize>) -> Vec<f64> {
        self.element_parameters(at, lambda, elements)
    }
}

/// Adds w ∇φ_a · A · ∇φ_b for all pairs b ≤ a; entry (i, j) of a block at 3 i + j.
#[inline(always)]
fn add_point<S: Simd, const N: usize>(
    tangents: &Tangents<S>,
    g: &Nodal<S, N>,
    weight: Lanes<S>,
    local: &mut [[Lanes<S>; 9]],
) {
    for i in 0..3 {
        // c[b][k][j] is the stress (i, k) that component j of node b causes
        let mut c = [[[weight; 3]; 3]; N];
        for k in 0..3 {
            for j in 0..3 {
                let mut t = [weight; 3];
                for (l, t) in t.iter_mut().enumerate() {
                    let (row, column) = (3 * l + j, 3 * k + i);
                    *t = weight * tangents[row.max(column)][row.min(column)];
                }
                for b in 0..N {
                    let sum = t[1].mul_add(g[b][1], t[2] * g[b][2]);
                    c[b][k][j] = t[0].mul_add(g[b][0], sum);
                }
            }
        }
        for a in 0..N {
            for b in 0..=a {
                let local = &mut local[pair_index(a, b)];
                for j in 0..3 {
                    let sum = g[a][1].mul_add(c[b][1][j], local[3 * i + j]);
                    let sum = g[a][2].mul_add(c[b][2][j], sum);
                    local[3 * i + j] = g[a][0].mul_add(c[b][0][j], sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::Energy;
    use crate::energy::elements::tests::check_lanes;
    use crate::material::{MooneyRivlin, Ogden};
    use crate::math::random::Random;

    /// Elements that share no vertex, so strained that some tangents are indefinite, and that the
    /// series of logarithms are left in some.
    fn bodies(count: usize) -> (FunctionSpace, Vec<Vec3>, Vec<f64>) {
        let mut random = Random::new(5);
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let all = corners.iter().cycle().take(4 * count);
        let rest: Vec<Vec3> = all.map(|c| c + 0.1 * random.vector()).collect();
        let tets = (0..count).map(|e| [4 * e, 4 * e + 1, 4 * e + 2, 4 * e + 3]).collect();
        let space = FunctionSpace::new(2, rest.len(), tets);
        let scale = |i: usize| 0.01 + 0.05 * ((i / 30) % 8) as f64 / 7.0;
        let numbers = random.numbers(3 * space.node_count());
        let u = numbers.iter().enumerate().map(|(i, x)| scale(i) * x).collect();
        (space, rest, u)
    }

    #[test]
    fn bits_are_the_same_for_any_number_of_lanes() {
        let (space, rest, u) = bodies(21);
        let iterate = Iterate::new(&space, &rest, &u, 1.0);
        let mooney = MooneyRivlin { c1: 55e3, c2: 5e3, c3: 1.7e3, d1: 1e6 };
        let ogden = Ogden { terms: vec![(34e3, 2.9)], bulk: 1e6 };
        let laws: [Box<dyn Material>; 2] = [Box::new(mooney), Box::new(ogden)];
        let standard = laws.map(Elastic::whole);
        let mean = standard.clone().map(|elastic| elastic.with_mean_dilatation().expect("a part"));
        for elastic in standard.into_iter().chain(mean) {
            assert!(elastic.value(&iterate) > 0.0 && elastic.value(&iterate).is_finite());
            let [exact, projected] = check_lanes(&elastic, &iterate);
            assert!(projected != exact, "no tangent is indefinite");
        }
    }
}
