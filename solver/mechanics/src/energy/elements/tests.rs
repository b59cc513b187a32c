//! What energies of elements are tested with.

use mesh::TetMesh;
use nalgebra::{DMatrix, DVector};

use super::*;
use crate::math::lanes::Scalar;
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::sparse::Pattern;
use crate::testing::{check_gradient, flat, points};

/// A body of a degree with random displacements.
pub struct Case {
    pub space: FunctionSpace,
    pub rest: Vec<Vec3>,
    pub u: Vec<f64>,
}

impl Case {
    pub fn new(mesh: TetMesh, degree: usize, random: &mut Random, size: f64) -> Self {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let u = random.numbers(3 * space.node_count()).iter().map(|x| size * x).collect();
        Self { space, rest: mesh.vertices, u }
    }

    pub fn at<'a>(&'a self, u: &'a [f64], rest: &'a [Vec3]) -> Iterate<'a> {
        Iterate::new(&self.space, rest, u, 1.0)
    }

    pub fn gradient(&self, energy: &dyn Energy, u: &[f64], rest: &[Vec3]) -> Vec<f64> {
        let mut gradient = vec![0.0; u.len()];
        energy.add_gradient(&self.at(u, rest), &mut gradient);
        gradient
    }

    /// The Hessian times vectors.
    fn products<'a>(
        &self,
        energy: &dyn Energy,
        kind: Hessian,
        by: impl Iterator<Item = &'a [f64]>,
    ) -> Vec<Vec<f64>> {
        let n = self.space.nodes_per_element();
        let pattern = Pattern::new(self.space.node_count(), self.space.element_nodes(), n, &[]);
        let mut hessian = BlockMatrix::zeros(&pattern);
        energy.add_hessian(&self.at(&self.u, &self.rest), kind, &mut hessian);
        by.map(|by| hessian.multiply(by)).collect()
    }

    pub fn weights(&self) -> Vec<f64> {
        Random::new(33).numbers(self.u.len())
    }

    /// Forces, exact Hessian and shape derivative pass the Taylor test with a first step.
    pub fn check_derivatives(&self, energy: &dyn Energy, step: f64) {
        let (u, rest, weights) = (&self.u, &self.rest, self.weights());
        let gradient = self.gradient(energy, u, rest);
        check_gradient(u, &gradient, step, |u| energy.value(&self.at(u, rest)));
        let by = [&weights[..]].into_iter();
        let product = self.products(energy, Hessian::Exact, by).remove(0);
        let weighed = |u: &[f64], rest: &[Vec3]| dot(&weights, &self.gradient(energy, u, rest));
        check_gradient(u, &product, step, |u| weighed(u, rest));
        let mut mixed = vec![0.0; 3 * rest.len()];
        energy.add_mixed_vjp(&self.at(u, rest), &weights, &mut mixed);
        check_gradient(&flat(rest), &mixed, step, |x| weighed(u, &points(x)));
    }

    /// The smallest eigenvalue of the Hessian, as a part of the largest.
    pub fn smallest(&self, energy: &dyn Energy, kind: Hessian) -> f64 {
        self.smallest_of(energy, kind, &(0..self.u.len()).collect::<Vec<_>>())
    }

    /// The smallest eigenvalue of the rows and columns `free` of the Hessian, as a part of the largest.
    pub fn smallest_of(&self, energy: &dyn Energy, kind: Hessian, free: &[usize]) -> f64 {
        let unit = DMatrix::<f64>::identity(self.u.len(), self.u.len());
        let units = unit.as_slice().chunks_exact(self.u.len());
        let columns = self.products(energy, kind, units).into_iter().map(DVector::from_vec);
        let dense = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let eigenvalues = dense.select_rows(free).select_columns(free).symmetric_eigenvalues();
        eigenvalues.min() / eigenvalues.amax()
    }
}

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
