//! Energy densities at quadrature points, one point after the other: stress and tangent of each become
//! forces and blocks of elements. For terms that have more to remember than lanes would gain, and for the adjoint
//! derivatives of all.
//!
//! Where strain is constant in an element, one point stands for all.

use std::ops::Range;

use mesh::Vec3;
use nalgebra::SVector;

use super::{Hessian, Iterate};
use crate::element::{FunctionSpace, add_at, at};
use crate::material::Kinematics;
use crate::math::sparse::{BlockMatrix, pair_count, pair_index};
use crate::math::tensor::{Mat3, Mat9, cofactor, project_positive, vec9};
use crate::parallel::{fill, map_merge, map_merge_waves};

/// Nodes of an element, at most.
const MOST_NODES: usize = 20;

/// Geometry of one straight-sided element.
pub(super) struct Element<'a> {
    pub(super) nodes: &'a [usize],
    /// G⁻ᵀ: maps reference gradients to rest gradients [1/m].
    to_rest: Mat3,
    /// Rest volume [m³].
    pub(super) volume: f64,
}

impl<'a> Element<'a> {
    pub(super) fn new(space: &'a FunctionSpace, rest: &[Vec3], e: usize) -> Self {
        let [a, b, c, d] = space.tets()[e].map(|v| rest[v]);
        let g = Mat3::from_columns(&[b - a, c - a, d - a]);
        let det = g.determinant();
        // cof G / det G = G⁻ᵀ; a flat element gives infinities, which the
        // caller sees as an infinite energy
        let to_rest = cofactor(&g) / det;
        let n = space.nodes_per_element();
        let nodes = &space.element_nodes()[e * n..(e + 1) * n];
        Self { nodes, to_rest, volume: det / 6.0 }
    }

    /// Rest gradients of the four barycentric coordinates.
    pub(super) fn corner_gradients(&self) -> [Vec3; 4] {
        let c = |k: usize| self.to_rest.column(k).into_owned();
        [-(c(0) + c(1) + c(2)), c(0), c(1), c(2)]
    }
}

/// A quadrature point of an element.
pub(super) struct Point {
    /// The place among all of the term, or of the element.
    pub(super) place: usize,
    /// Part of the volume of the element that it stands for [1].
    pub(super) share: f64,
    /// Volume that it stands for [m³].
    pub(super) weight: f64,
    /// ∇φ_a [1/m].
    gradients: [Vec3; MOST_NODES],
    /// The deformation.
    pub(super) k: Kinematics,
}

impl Point {
    /// ∇w of nodal values of the element.
    pub(super) fn gradient(&self, element: &Element, w: &[f64]) -> Mat3 {
        let terms = element.nodes.iter().zip(&self.gradients);
        terms.map(|(&node, g)| at(w, node) * g.transpose()).sum()
    }

    /// F⁻¹.
    pub(super) fn inverse(&self) -> Mat3 {
        self.k.cofactor.transpose() / self.k.j()
    }

    /// M of the derivative M : ∇V of P : ∇λ dX along a velocity V of the rest vertices, by P, ∂P/∂F : ∇λ and ∇λ.
    pub(super) fn by_rest(&self, stress: &Mat3, pushed: &Mat3, grad_l: &Mat3) -> Mat3 {
        Mat3::identity() * stress.dot(grad_l)
            - self.k.grad_u.transpose() * pushed
            - grad_l.transpose() * stress
    }
}

/// An element with its quadrature points: all of the rule, or one where strain is constant in it.
pub(super) fn points<'a>(
    iterate: &Iterate<'a>,
    e: usize,
    all: bool,
) -> (Element<'a>, impl Iterator<Item = Point> + use<'a>) {
    let (space, u) = (iterate.space, iterate.u);
    let element = Element::new(space, iterate.rest, e);
    let (nodes, volume, to_rest) = (element.nodes, element.volume, element.to_rest);
    let table = space.volume_table();
    let one = !all && nodes.len() == 4;
    let point = move |place: usize| {
        let mut gradients = [Vec3::zeros(); MOST_NODES];
        let mut grad_u = Mat3::zeros();
        for ((g, t), &node) in gradients.iter_mut().zip(&table.gradients[place]).zip(nodes) {
            *g = to_rest * Vec3::from(*t);
            grad_u += at(u, node) * g.transpose();
        }
        let share = if one { 1.0 } else { table.weights[place] };
        let k = Kinematics::new(&grad_u);
        Point { place, share, weight: share * volume, gradients, k }
    };
    (element, (0..if one { 1 } else { table.weights.len() }).map(point))
}

/// The points of a term that has consecutive elements.
#[derive(Clone)]
pub(super) struct QuadraturePoints {
    /// The elements.
    pub(super) elements: Range<usize>,
}

impl QuadraturePoints {
    /// Number of points of an element.
    pub(super) fn each(space: &FunctionSpace) -> usize {
        if space.nodes_per_element() == 4 { 1 } else { space.volume_table().weights.len() }
    }

    /// Number of points.
    pub(super) fn count(&self, space: &FunctionSpace) -> usize {
        self.elements.len() * Self::each(space)
    }

    /// The points of an element.
    pub(super) fn of<'a>(
        &self,
        iterate: &Iterate<'a>,
        e: usize,
    ) -> (Element<'a>, impl Iterator<Item = Point> + use<'a>) {
        let first = (e - self.elements.start) * Self::each(iterate.space);
        let (element, own) = points(iterate, e, false);
        (element, own.map(move |point| Point { place: first + point.place, ..point }))
    }

    /// Calls `f` with each element, and each point of it.
    pub(super) fn for_each(&self, iterate: &Iterate, mut f: impl FnMut(usize, &Element, &Point)) {
        for e in self.elements.clone() {
            let (element, own) = self.of(iterate, e);
            own.for_each(|point| f(e, &element, &point));
        }
    }

    /// N numbers of each point, by place.
    pub(super) fn numbers<const N: usize>(
        &self,
        iterate: &Iterate,
        of: impl Fn(&Point) -> [f64; N] + Sync,
    ) -> Vec<f64> {
        fill(self.elements.len(), N * Self::each(iterate.space), 0.0, |range, out| {
            let own = range.flat_map(|e| self.of(iterate, self.elements.start + e).1);
            for (point, out) in own.zip(out.chunks_exact_mut(N)) {
                out.copy_from_slice(&of(&point));
            }
        })
    }

    /// The integral of a density.
    pub(super) fn integral(
        &self,
        iterate: &Iterate,
        density: impl Fn(&Point) -> f64 + Sync,
    ) -> f64 {
        let one = |e: usize| -> f64 {
            let of = |point: Point| point.weight * density(&point);
            self.of(iterate, self.elements.start + e).1.map(of).sum()
        };
        let mut sum = 0.0;
        map_merge(self.elements.len(), |r| r.map(one).sum::<f64>(), |_, part| sum += part);
        sum
    }

    /// Adds the forces of a stress P, of points that have any.
    pub(super) fn add_gradient(
        &self,
        iterate: &Iterate,
        stress: impl Fn(&Point) -> Option<Mat3> + Sync,
        out: &mut [f64],
    ) {
        let n = iterate.space.nodes_per_element();
        let forces = fill(self.elements.len(), n, Vec3::zeros(), |range, forces| {
            for (e, forces) in range.zip(forces.chunks_exact_mut(n)) {
                for point in self.of(iterate, self.elements.start + e).1 {
                    let Some(stress) = stress(&point) else { continue };
                    let terms = forces.iter_mut().zip(&point.gradients);
                    terms.for_each(|(f, g)| *f += point.weight * (stress * g));
                }
            }
        });
        let places = n * self.elements.start..n * self.elements.end;
        iterate.space.incidence().add(places, &forces, out);
    }

    /// Adds the blocks of a tangent ∂P/∂F, of points that have any.
    pub(super) fn add_hessian(
        &self,
        iterate: &Iterate,
        kind: Hessian,
        tangent: impl Fn(&Point) -> Option<Mat9> + Sync,
        out: &mut BlockMatrix,
    ) {
        let n = iterate.space.nodes_per_element();
        let first = self.elements.start;
        let blocks = |range: Range<usize>| -> Vec<[f64; 9]> {
            let mut blocks = vec![[0.0; 9]; pair_count(n) * range.len()];
            for (e, local) in range.zip(blocks.chunks_exact_mut(pair_count(n))) {
                for point in self.of(iterate, first + e).1 {
                    let Some(mut tangent) = tangent(&point) else { continue };
                    if kind == Hessian::Projected {
                        tangent = project_positive(&tangent);
                    }
                    add_point(&tangent, &point, n, local);
                }
            }
            blocks
        };
        map_merge_waves(self.elements.len(), blocks, |r, parts| {
            let parts: Vec<&[[f64; 9]]> = parts.iter().map(|part| &part[..]).collect();
            out.add_elements(first + r.start..first + r.end, &parts);
        });
    }

    /// Adds λᵀ ∂²E/∂u∂X of points with a stress and a symmetric tangent.
    pub(super) fn add_mixed_vjp(
        &self,
        iterate: &Iterate,
        lambda: &[f64],
        at_point: impl Fn(&Point) -> Option<(Mat3, Mat9)>,
        out: &mut [f64],
    ) {
        self.for_each(iterate, |e, element, point| {
            let Some((stress, tangent)) = at_point(point) else { return };
            let grad_l = point.gradient(element, lambda);
            let pushed = tangent * vec9(&grad_l);
            let pushed = Mat3::from_column_slice(pushed.as_slice());
            let m = point.by_rest(&stress, &pushed, &grad_l);
            for (&vertex, c) in iterate.space.tets()[e].iter().zip(&element.corner_gradients()) {
                add_at(out, vertex, &(point.weight * (m * c)));
            }
        });
    }

    /// Adds a cotangent of F at a point to those of u and X: ∇u at fixed nodal u changes by −∇u ∇V.
    pub(super) fn add_deformation_vjp(
        iterate: &Iterate,
        (e, element): (usize, &Element),
        point: &Point,
        by_f: &Mat3,
        (by_u, by_rest): (&mut [f64], &mut [f64]),
    ) {
        for (&node, g) in element.nodes.iter().zip(&point.gradients) {
            add_at(by_u, node, &(by_f * g));
        }
        let m = -point.k.grad_u.transpose() * by_f;
        for (&vertex, c) in iterate.space.tets()[e].iter().zip(&element.corner_gradients()) {
            add_at(by_rest, vertex, &(m * c));
        }
    }
}

/// Adds w ∇φ_a · A · ∇φ_b for all pairs b ≤ a; entry (i, j) of a block at 3 i + j.
fn add_point(tangent: &Mat9, point: &Point, nodes: usize, local: &mut [[f64; 9]]) {
    for b in 0..nodes {
        let g = point.weight * point.gradients[b];
        for j in 0..3 {
            // of the strain e_j ⊗ ∇φ_b, which has the entries 3 k + j alone
            let stress: SVector<f64, 9> = (0..3).map(|k| g[k] * tangent.column(3 * k + j)).sum();
            let stress = Mat3::from_column_slice(stress.as_slice());
            for a in b..nodes {
                let force = stress * point.gradients[a];
                let block = &mut local[pair_index(a, b)];
                (0..3).for_each(|i| block[3 * i + j] += force[i]);
            }
        }
    }
}
